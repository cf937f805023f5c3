/**
 * @file  tests/target/cycles/port.c
 * @brief What the port to the F28379D costs in the current interrupt, run on the fake of driverlib (tests/hal).
 *
 * hal/f28379d is compiled with the counter and with its functions renamed from hal_ to chip_: the driver's own HAL answers the
 * drive, and adds the dearest call that was seen here to each of its calls. A call of driverlib counts as the registers that
 * it reads and writes (tools/src/evenspin/cycles/costs.py).
 */
#include <stdint.h>

#define EVENSPIN_TMU_MARKED /* as the port is compiled: port_min and port_max are functions, which count as instructions */
#include "fake_chip.h"
#include "fake_memory.h"
#include "hal/f28379d/port.h"
#include "hal/hal_encoder.h"
#include "hal/hal_inverter.h"
#include "hal/hal_sample.h"
#include "tests/target/cycles/port.h"

extern uint64_t evenspin_cycles;

hal_status_t         chip_sample_read(hal_sample_t *out);
hal_status_t         chip_encoder_edge(hal_encoder_edge_t *out);
hal_status_t         chip_inverter_set_duty(const hal_duty_t *duty);
hal_inverter_fault_t chip_inverter_fault(void);
hal_status_t         chip_inverter_arm(void);
uint32_t             chip_clock_cyc(void);
void                 chip_clock_request_speed_isr(void);

port_cost_t port_cost;
static void (*note)(const char *name, uint64_t cost);
static uint32_t seed = 7U, periods;
static bool     counted;

float port_min(float a, float b);
float port_max(float a, float b);
float port_min(float a, float b) { return (a < b) ? a : b; }
float port_max(float a, float b) { return (a > b) ? a : b; }

static float share(void) /* 0 to 1 */
{
    seed = (seed * 1664525U) + 1013904223U;
    return (float)(seed >> 8) / 16777216.0f;
}

#define PORT_CASE(row, dearest, call)                                                                                            \
    do {                                                                                                                         \
        const uint64_t before_ = evenspin_cycles;                                                                                \
        call;                                                                                                                    \
        const uint64_t cost_ = evenspin_cycles - before_;                                                                        \
        if (counted) {                                                                                                           \
            note(row, cost_);                                                                                                    \
            *(dearest) = (cost_ > *(dearest)) ? cost_ : *(dearest);                                                              \
        }                                                                                                                        \
    } while (0)

static void current_isr(void)
{
    hal_sample_t       sample;
    hal_encoder_edge_t edge;
    uint64_t           begin = 0U, end = 0U;
    const hal_duty_t   duty = {share(), share(), share()};
    PORT_CASE("port_current_begin", &begin, port_current_begin());
    PORT_CASE("hal_clock_cyc", &port_cost.clock_cyc, (void)chip_clock_cyc());
    PORT_CASE("hal_sample_read", &port_cost.sample_read, (void)chip_sample_read(&sample));
    PORT_CASE("hal_inverter_fault", &port_cost.inverter_fault, (void)chip_inverter_fault());
    PORT_CASE("hal_encoder_edge", &port_cost.encoder_edge, (void)chip_encoder_edge(&edge));
    PORT_CASE("hal_clock_request_speed_isr", &port_cost.request_speed_isr, chip_clock_request_speed_isr());
    PORT_CASE("hal_inverter_set_duty", &port_cost.set_duty, (void)chip_inverter_set_duty(&duty));
    PORT_CASE((periods < 1000U) ? "port_current_end idle link" : "port_current_end busy link", &end, port_current_end());
}

static void speed_isr(void)
{
    uint64_t begin = 0U, end = 0U;
    PORT_CASE("port_speed_begin", &begin, port_speed_begin());
    PORT_CASE("port_speed_end", &end, port_speed_end());
}

/* The dearest of each: a slice of a long region, one inside a section in flash, the processor. */
static void self_test(void)
{
    static const port_region_t ram = {FAKE_MEMORY_FIRST, 64U};
    static CRC_TABLE           sums = {8U, 1U, {{0U, 0U, FAKE_MEMORY_FIRST + 100U, 400U, 0U}}};
    uint64_t                   slice[3] = {0U, 0U, 0U};
    fake_places.ram = &ram;
    fake_places.ram_count = 1U;
    fake_places.sums = &sums; /* of words that are zero */
    for (int round = 0; round < 20; round++) {
        PORT_CASE("port_self_test_slice RAM", &slice[0], port_self_test_slice());
        PORT_CASE("port_self_test_slice program", &slice[1], port_self_test_slice());
        PORT_CASE("port_self_test_slice processor", &slice[2], port_self_test_slice());
    }
    uint64_t masked = 0U;
    PORT_CASE("port_ram_slice, interrupts masked", &masked, (void)port_ram_slice(FAKE_MEMORY_FIRST, 0x5555U));
}

int port_cases(void (*note_case)(const char *name, uint64_t cost))
{
    note = note_case;
    counted = false;
    fake_power_on();
    if (port_init() != PORT_OK) {
        return 1;
    }
    port_start(&current_isr, &speed_isr);
    chip.cycles += 20000U;
    fake_pwm_zero(); /* before anybody can arm; it clears what the guard has noted before the first interrupt, and does not count */
    (void)chip_inverter_arm();
    counted = true;
    for (periods = 0U; periods < 2000U; periods++) { /* edges both ways, the index now and then, all phases over the limit */
        chip.cycles += 20000U;
        chip.qep_direction = ((periods % 200U) < 100U) ? 1 : -1;
        chip.qep_position = (chip.qep_position + ((chip.qep_direction > 0) ? 7U : 3993U)) % 4000U;
        chip.qep_edge_cycles = chip.cycles - 300U;
        if ((periods % 50U) == 49U) {
            chip.qep_flags |= EQEP_INT_INDEX_EVNT_LATCH;
        }
        if (periods >= 1000U) {
            chip.rx_count = 7U;
            chip.tx_room = 16U;
        }
        fake_pwm_zero();
    }
    self_test();
    return 0;
}
