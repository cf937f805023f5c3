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
    HIGH_GATES = 0x5,
    LOW_GATES = 0x6,
    GATE_CONTROL = 0x7,
    OPERATION = 0x9,
    AMPLIFIERS = 0xA,
    REGULATOR = 0xB,
    VDS_SENSE = 0xC
};

/* Every register that can be written, as constants: what is read may be rubbish, and an earlier program may have left anything.
 * Most are not zero, so neither a dead bus (all zero) nor one that is stuck high reads like them. [sheet] */
typedef struct {
    uint16_t address, value;
} setting_t;
#define OPERATION_SET (UINT16_C(0x0A0) | BOARD_DRIVER_FLIP_OTSD) /* amplifiers clamped to 3.3 V; watchdog and sleep off */
#define CLEAR_FAULTS UINT16_C(0x002)                             /* in the same register; clears itself */
static const setting_t SETTING[] = {
    {GATE_CONTROL, 0x216}, /* six inputs, 52 ns dead time, 1.75 us blanking (none trips at rest), 3.5 us VDS filter: as at reset */
    {HIGH_GATES, 0x344},   /* 50 mA on, 60 mA off for 1.78 us: as at reset */
    {LOW_GATES, 0x344},         {AMPLIFIERS, 0x000}, /* 10 V/V, no blanking, no calibration short */
    {REGULATOR, 0x10A},                              /* amplifiers' zero at half of VREF: as at reset */
    {VDS_SENSE, 0x040}, /* latched shutdown at 0.155 V: 44 A through a hot switch of 3.5 mohm, 86 A through a cold one */
    {OPERATION, OPERATION_SET},
};
#define SETTINGS ((uint16_t)(sizeof SETTING / sizeof SETTING[0]))
#define STATUS_WORDS 4U

#define WARNING_HOT UINT16_C(0x101)    /* warning, and the highest of the four flags */
#define WARNING_SUPPLY UINT16_C(0x0D0) /* motor supply low, high; charge pump low */
#define IC_SHUTDOWN_HOT UINT16_C(0x100)
#define IC_SUPPLY UINT16_C(0x477) /* motor supply, regulators and charge pump */

static port_driver_status_t status;
static bool                 timed_out;
static uint16_t             poll_next; /* register that the main loop reads next: a status word, then the settings */
static uint32_t             polled_cyc;
static bool                 asked_why; /* since the driver has tripped the bridge */

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
    static const uint16_t RESERVED[STATUS_WORDS] = {0x200U, 0x018U, 0x088U, 0x01FU};
    const uint16_t        word = read_register(address);
    if ((word & RESERVED[address - WARNINGS]) != 0U) { /* always 0 [sheet]: that is no answer */
        status.answers = false;
        return;
    }
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

/* A frame that a disturbance has hit once is read again. */
static bool holds(const setting_t *setting)
{
    for (uint16_t tries = 0U; tries < 2U; tries++) {
        timed_out = false;
        if ((read_register(setting->address) == setting->value) && !timed_out) {
            return true;
        }
    }
    return false;
}

static void check_settings(void)
{
    status.answers = true;
    for (uint16_t k = 0U; k < SETTINGS; k++) {
        status.answers = holds(&SETTING[k]) && status.answers;
    }
}

bool port_driver_set_up(void)
{
    for (uint16_t k = 0U; k < SETTINGS; k++) {
        write_register(SETTING[k].address, SETTING[k].value);
    }
    write_register(OPERATION, OPERATION_SET | CLEAR_FAULTS); /* after the settings: what they cause is cleared, too */
    check_settings();
    asked_why = false;
    return status.answers;
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
    poll_next = 0U;
    bool ready = false;
    for (uint16_t tries = 0U; (tries < BOARD_DRIVER_TRIES) && !ready; tries++) { /* the motor supply may come after this chip's */
        SysCtl_delay(BOARD_US(BOARD_DRIVER_WAKE_US));
        write_register(SETTING[0].address, SETTING[0].value);
        ready = holds(&SETTING[0]);
    }
    polled_cyc = hal_clock_cyc();
    return port_driver_set_up();
}

/* The driver is not reset with this chip, and is when its supply fails: a clear sets it up again. */
hal_inverter_fault_t port_driver_reason(const port_driver_status_t *s)
{
    if (!s->answers) { /* then nothing else that was read means anything */
        return HAL_INVERTER_DRIVER_LINK;
    }
    if (((s->ic & IC_SHUTDOWN_HOT) != 0U) || ((s->warnings & WARNING_HOT) != 0U)) {
        return HAL_INVERTER_OVER_TEMPERATURE;
    }
    if (s->vds != 0U) { /* a switch or a shunt with too much voltage across it */
        return HAL_INVERTER_OVER_CURRENT;
    }
    if (((s->ic & IC_SUPPLY) != 0U) || ((s->warnings & WARNING_SUPPLY) != 0U)) {
        return HAL_INVERTER_DRIVER_SUPPLY;
    }
    if ((s->ic != 0U) || (s->vgs != 0U)) {
        return HAL_INVERTER_DRIVER_FAULT;
    }
    return HAL_INVERTER_FINE;
}

bool port_driver_is_well(hal_inverter_fault_t *reason)
{
    check_settings();
    for (uint16_t address = WARNINGS; address <= (uint16_t)VGS_FAULTS; address++) {
        read_status(address);
    }
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
    if (poll_next < STATUS_WORDS) {
        timed_out = false;
        read_status((uint16_t)(WARNINGS + poll_next));
        status.answers = status.answers && !timed_out;
    } else {
        status.answers = holds(&SETTING[poll_next - STATUS_WORDS]) && status.answers;
    }
    poll_next = (poll_next < (STATUS_WORDS + SETTINGS - 1U)) ? (uint16_t)(poll_next + 1U) : 0U;
    const hal_inverter_fault_t reason = port_driver_reason(&status);
    if (reason != HAL_INVERTER_FINE) {
        port_trip_note(reason);
    }
}

/* The bridge went off in hardware by nFAULT, which also pulses for a warning: ask once which it was, before it is gone. */
void port_driver_ask_why(void)
{
    if ((port_trip_latched != HAL_INVERTER_DRIVER_FAULT) || asked_why) {
        return;
    }
    asked_why = true;
    hal_inverter_fault_t reason = HAL_INVERTER_FINE;
    if (!port_driver_is_well(&reason)) {
        port_trip_latched = reason;
    }
}

const port_driver_status_t *port_driver_status(void) { return &status; }
