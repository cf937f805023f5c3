/* DRV8305 over SPI A: set-up, status, and what a status means. Main loop only; a frame takes 16 us.
 *
 * Frame: 1 = read, address (4), data (11). The answer carries the addressed register. The chip is not reset with the MCU,
 * so old settings and latched faults survive: everything that matters is written and read back. */
#include "hal/f28379d/parts.h"
#include "hal/hal_clock.h"

#define READ UINT16_C(0x8000)
#define DATA UINT16_C(0x07FF)

enum {
    WARNINGS = 0x1,
    VDS_FAULTS = 0x2,
    IC_FAULTS = 0x3,
    VGS_FAULTS = 0x4,
    GATE_CONTROL = 0x7,
    OPERATION = 0x9,
    AMPLIFIERS = 0xA,
    VDS_SENSE = 0xC
};

/* Six inputs, 52 ns dead time, 1.75 us blanking, 3.5 us VDS filter: the reset state. Without blanking the VDS comparators
 * trip at rest. It also is what is read back: not zero, so a dead bus does not look like it. */
#define GATE_CONTROL_SET UINT16_C(0x216)
#define AMPLIFIERS_SET UINT16_C(0x000) /* 10 V/V, no blanking, no calibration short */
#define VDS_MODE_MASK UINT16_C(0x007)  /* 0: latched shutdown */
#define CLEAR_FAULTS UINT16_C(0x002)

#define WARNING_HOT UINT16_C(0x001)
#define IC_SHUTDOWN_HOT UINT16_C(0x100)

static port_driver_status_t status;
static bool                 timed_out;
static uint16_t             poll_next; /* status register that the main loop reads next */
static uint32_t             polled_cyc;

static uint16_t transfer(uint16_t frame)
{
    uint16_t answer = 0U;
    uint16_t polls = 0U;
    SPI_resetRxFIFO(BOARD_SPI_BASE);
    GPIO_writePin(BOARD_PIN_CHIP_SELECT, 0U);
    SPI_writeDataNonBlocking(BOARD_SPI_BASE, frame);
    /* the received word, not SPI_isBusy, says that the frame has left the wire */
    while ((SPI_getRxFIFOStatus(BOARD_SPI_BASE) == SPI_FIFO_RXEMPTY) && (polls < BOARD_SPI_POLLS)) {
        polls++;
    }
    if (polls < BOARD_SPI_POLLS) {
        answer = SPI_readDataNonBlocking(BOARD_SPI_BASE);
    } else {
        timed_out = true;
    }
    GPIO_writePin(BOARD_PIN_CHIP_SELECT, 1U);
    SysCtl_delay(BOARD_US(1U)); /* select stays high for longer than the 400 ns it must */
    return answer & DATA;
}

static uint16_t read_register(uint16_t address) { return transfer(READ | (uint16_t)(address << 11)); }
static void     write_register(uint16_t address, uint16_t data) { (void)transfer((uint16_t)(address << 11) | (data & DATA)); }

static void read_status(uint16_t address)
{
    const uint16_t word = read_register(address);
    switch (address) {
    case WARNINGS:
        status.warnings = word;
        break;
    case VDS_FAULTS:
        status.vds = word;
        break;
    case IC_FAULTS:
        status.ic = word;
        break;
    default:
        status.vgs = word;
        break;
    }
}

static void check_answer(void)
{
    timed_out = false;
    const uint16_t back = read_register(GATE_CONTROL);
    status.answers = (back == GATE_CONTROL_SET) && !timed_out;
}

bool port_driver_init(void)
{
    SPI_disableModule(BOARD_SPI_BASE);
    SPI_setConfig(BOARD_SPI_BASE, BOARD_LSPCLK_HZ, SPI_PROT_POL0PHA0, SPI_MODE_CONTROLLER, BOARD_SPI_HZ, 16U);
    SPI_setEmulationMode(BOARD_SPI_BASE, SPI_EMULATION_FREE_RUN);
    SPI_enableFIFO(BOARD_SPI_BASE);
    SPI_enableModule(BOARD_SPI_BASE);

    GPIO_writePin(BOARD_PIN_WAKE, 1U);
    SysCtl_delay(BOARD_US(BOARD_DRIVER_SLEEP_US));
    GPIO_writePin(BOARD_PIN_EN_GATE, 1U); /* the trip holds the gates; without EN_GATE the amplifiers float */
    SysCtl_delay(BOARD_US(BOARD_DRIVER_WAKE_US));

    write_register(AMPLIFIERS, AMPLIFIERS_SET);
    write_register(VDS_SENSE, read_register(VDS_SENSE) & (uint16_t)~VDS_MODE_MASK);
    write_register(GATE_CONTROL, GATE_CONTROL_SET);
    port_driver_clear();
    check_answer();
    poll_next = WARNINGS;
    polled_cyc = hal_clock_cyc();
    return status.answers;
}

void port_driver_clear(void) { write_register(OPERATION, read_register(OPERATION) | CLEAR_FAULTS); }

hal_inverter_fault_t port_driver_reason(const port_driver_status_t *s)
{
    if (((s->ic & IC_SHUTDOWN_HOT) != 0U) || ((s->warnings & WARNING_HOT) != 0U)) {
        return HAL_INVERTER_OVER_TEMPERATURE;
    }
    if (s->vds != 0U) { /* a switch or a shunt with too much voltage across it */
        return HAL_INVERTER_OVER_CURRENT;
    }
    if ((s->ic != 0U) || (s->vgs != 0U) || !s->answers) {
        return HAL_INVERTER_DRIVER_FAULT;
    }
    return HAL_INVERTER_FINE;
}

bool port_driver_is_well(hal_inverter_fault_t *reason)
{
    for (uint16_t address = WARNINGS; address <= (uint16_t)VGS_FAULTS; address++) {
        read_status(address);
    }
    check_answer();
    *reason = port_driver_reason(&status);
    if ((*reason == HAL_INVERTER_FINE) && (GPIO_readPin(BOARD_PIN_NFAULT) == 0U)) {
        *reason = HAL_INVERTER_DRIVER_FAULT;
    }
    return *reason == HAL_INVERTER_FINE;
}

void port_driver_poll(void)
{
    if ((hal_clock_cyc() - polled_cyc) < BOARD_DRIVER_POLL_CYC) {
        return;
    }
    polled_cyc = hal_clock_cyc();
    read_status(poll_next);
    poll_next = (poll_next < (uint16_t)VGS_FAULTS) ? (uint16_t)(poll_next + 1U) : (uint16_t)WARNINGS;
    const hal_inverter_fault_t reason = port_driver_reason(&status);
    if (reason != HAL_INVERTER_FINE) {
        port_trip_note(reason);
    }
}

const port_driver_status_t *port_driver_status(void) { return &status; }
