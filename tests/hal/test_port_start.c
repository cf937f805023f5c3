/* port_init and port_start: what is called, with which arguments, and in which order. */
#include "hal/hal_limits.h"
#include "hal/hal_reset.h"
#include "tests/hal/support/started.h"

static const uint32_t EPWM[3] = BOARD_EPWM_BASES;
static const uint32_t GATES[6] = BOARD_PWM_PIN_CONFIGS;

void setUp(void) { started(); }
void tearDown(void) {}

#define BEFORE(first, second)                                                                                                    \
    do {                                                                                                                         \
        TEST_ASSERT_TRUE_MESSAGE((first) >= 0, "first is not called: " #first);                                                  \
        TEST_ASSERT_TRUE_MESSAGE((second) > (first), "not before: " #second);                                                    \
    } while (0)

void test_start_arms_the_trip_before_the_pins_leave_their_safe_state(void)
{
    for (int k = 0; k < 3; k++) {
        for (int pin = 0; pin < 6; pin++) {
            const int connected = CALLED("GPIO_setPinConfig", GATES[pin]);
            BEFORE(CALLED("EPWM_setTripZoneAction", EPWM[k], EPWM_TZ_ACTION_EVENT_TZA, EPWM_TZ_ACTION_LOW), connected);
            BEFORE(CALLED("EPWM_setTripZoneAction", EPWM[k], EPWM_TZ_ACTION_EVENT_TZB, EPWM_TZ_ACTION_LOW), connected);
            BEFORE(CALLED("EPWM_setTripZoneAction", EPWM[k], EPWM_TZ_ACTION_EVENT_DCAEVT1, EPWM_TZ_ACTION_LOW), connected);
            BEFORE(CALLED("EPWM_setTripZoneAction", EPWM[k], EPWM_TZ_ACTION_EVENT_DCBEVT1, EPWM_TZ_ACTION_LOW), connected);
            /* nFAULT, clock failure, halt, comparators, guard: bits 8, 12, 13, 14, 15 of TZSEL */
            BEFORE(CALLED("EPWM_enableTripZoneSignals", EPWM[k], 0xF100U), connected);
            BEFORE(CALLED("EPWM_forceTripZoneEvent", EPWM[k], EPWM_TZ_FORCE_EVENT_OST), connected);
        }
    }
    TEST_ASSERT_EQUAL(0, chip.unsafe_connections);
}

void test_start_enables_the_gate_driver_only_with_tripped_and_connected_gates(void)
{
    const int enabled = CALLED("GPIO_writePin", BOARD_PIN_EN_GATE, 1U);
    for (int pin = 0; pin < 6; pin++) {
        BEFORE(CALLED("GPIO_setPinConfig", GATES[pin]), enabled);
    }
}

void test_start_leaves_every_gate_low(void)
{
    period();

    TEST_ASSERT_TRUE(all_gates_low());
    TEST_ASSERT_FALSE(fake_gate_follows(0) || fake_gate_follows(1) || fake_gate_follows(2));
}

void test_start_writes_the_latch_of_an_output_before_its_direction(void)
{
    BEFORE(CALLED("GPIO_writePin", BOARD_PIN_EN_GATE, 0U), CALLED("GPIO_setDirectionMode", BOARD_PIN_EN_GATE, GPIO_DIR_MODE_OUT));
    BEFORE(CALLED("GPIO_writePin", BOARD_PIN_CHIP_SELECT, 1U),
           CALLED("GPIO_setDirectionMode", BOARD_PIN_CHIP_SELECT, GPIO_DIR_MODE_OUT));
}

void test_start_takes_200_mhz_from_the_crystal(void)
{
    /* 10 MHz x 40 / 2: multiplier in bits 0..6, divider / 2 in bits 7..12, crystal bit 16, PLL bit 31 */
    BEFORE(CALLED("SysCtl_setClock", 0x800100A8U), CALLED("SysCtl_setEPWMClockDivider", SYSCTL_EPWMCLK_DIV_2));
    TEST_ASSERT_EQUAL_UINT32(200000000U, hal_clock_hz());
}

/* Loaded by a debugger, the boot ROM has not run, and it is what copies the trims. A module without its clock ignores writes. */
void test_start_in_ram_loads_the_trims_of_the_converters_when_they_are_clocked(void)
{
    const int trims = CALLED_AT_ALL("SysCtl_deviceCal");
    BEFORE(CALLED("SysCtl_enablePeripheral", SYSCTL_PERIPH_CLK_ADCA), trims);
    BEFORE(CALLED("SysCtl_enablePeripheral", SYSCTL_PERIPH_CLK_ADCB), trims);
    BEFORE(CALLED("SysCtl_enablePeripheral", SYSCTL_PERIPH_CLK_ADCC), trims);
    BEFORE(trims, CALLED_AT_ALL("ADC_setMode"));
}

/* The stack is one of the test's own: 300 words, of which 20 were in use when the pattern was written. */
void test_start_the_deepest_that_the_stack_has_been_is_found_within_a_few_passes(void)
{
    static uint16_t area[301];
    area[300] = 0x1234U;
    for (uint16_t i = 0U; i < 20U; i++) {
        area[i] = 0U;
    }
    port_stack_watch(area, 300U, 20U);
    for (uint16_t pass = 0U; pass < 20U; pass++) {
        port_stack_check();
    }
    TEST_ASSERT_EQUAL_UINT16(20U, port_stack_used());
    TEST_ASSERT_EQUAL_HEX16(0U, area[19]);
    TEST_ASSERT_EQUAL_HEX16(0x1234U, area[300]);

    area[150] = 7U; /* what lies below may have been skipped by a frame: the highest counts */
    for (uint16_t pass = 0U; pass < 20U; pass++) {
        port_stack_check();
    }
    TEST_ASSERT_EQUAL_UINT16(151U, port_stack_used());
    area[299] = 7U;
    for (uint16_t pass = 0U; pass < 20U; pass++) {
        port_stack_check();
    }
    TEST_ASSERT_EQUAL_UINT16(300U, port_stack_used());
}

/* The debug build of driverlib calls __error__ when an argument is wrong. */
void test_start_an_assertion_of_driverlib_switches_the_bridge_off_and_keeps_its_place(void)
{
    period();
    (void)hal_inverter_arm();
    period();
    chip.escape_set = true;
    if (setjmp(chip.escape) == 0) {
        __error__("epwm.h", 4711U);
    }
    chip.escape_set = false;

    TEST_ASSERT_TRUE(all_gates_low());
    TEST_ASSERT_TRUE(chip.intm);
    TEST_ASSERT_FALSE(chip.watchdog_on);
    port_assertion_failed("adc.h", 1U);
    TEST_ASSERT_EQUAL_STRING("epwm.h", port_assertion.file);
    TEST_ASSERT_EQUAL_UINT32(4711U, port_assertion.line);
    TEST_ASSERT_EQUAL_UINT16(2U, port_assertion.count);
}

void test_start_without_a_clock_connects_nothing(void)
{
    fake_power_on();
    chip.pll_locks = false;

    TEST_ASSERT_EQUAL(PORT_NO_CLOCK, port_init());
    TEST_ASSERT_EQUAL(-1, CALLED_AT_ALL("GPIO_setPinConfig"));
}

void test_start_counts_10_khz_up_and_down_at_100_mhz(void)
{
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setTimeBasePeriod", EPWM[k], 5000U));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setTimeBaseCounterMode", EPWM[k], EPWM_COUNTER_MODE_UP_DOWN));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setClockPrescaler", EPWM[k], EPWM_CLOCK_DIVIDER_1, EPWM_HSCLOCK_DIVIDER_1));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setEmulationMode", EPWM[k], EPWM_EMULATION_FREE_RUN));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setCounterCompareShadowLoadMode", EPWM[k], EPWM_COUNTER_COMPARE_A,
                                          EPWM_COMP_LOAD_ON_CNTR_ZERO));
    }
}

void test_start_starts_all_counters_together_and_last(void)
{
    const int stopped = CALLED("SysCtl_disablePeripheral", SYSCTL_PERIPH_CLK_TBCLKSYNC);
    const int run = CALLED("SysCtl_enablePeripheral", SYSCTL_PERIPH_CLK_TBCLKSYNC);
    for (int k = 0; k < 3; k++) {
        BEFORE(stopped, CALLED("EPWM_setTimeBasePeriod", EPWM[k], 5000U));
        BEFORE(CALLED("EPWM_setFallingEdgeDelayCount", EPWM[k], 50U), run);
    }
}

void test_start_sets_500_ns_of_complementary_dead_band(void)
{
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setRisingEdgeDelayCount", EPWM[k], 50U));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setFallingEdgeDelayCount", EPWM[k], 50U));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setRisingEdgeDeadBandDelayInput", EPWM[k], EPWM_DB_INPUT_EPWMA));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setFallingEdgeDeadBandDelayInput", EPWM[k], EPWM_DB_INPUT_EPWMA));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setDeadBandDelayPolarity", EPWM[k], EPWM_DB_RED, EPWM_DB_POLARITY_ACTIVE_HIGH));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setDeadBandDelayPolarity", EPWM[k], EPWM_DB_FED, EPWM_DB_POLARITY_ACTIVE_LOW));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setDeadBandDelayMode", EPWM[k], EPWM_DB_RED, 1U));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setDeadBandDelayMode", EPWM[k], EPWM_DB_FED, 1U));
    }
}

void test_start_samples_at_zero_of_every_period(void)
{
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setADCTriggerSource", EPWM1_BASE, EPWM_SOC_A, EPWM_SOC_TBCTR_ZERO));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_setADCTriggerEventPrescale", EPWM1_BASE, EPWM_SOC_A, 1U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("EPWM_enableADCTrigger", EPWM1_BASE, EPWM_SOC_A));
}

void test_start_converts_three_currents_at_once_and_the_dc_link_after_them(void)
{
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("ADC_setupSOC", ADCA_BASE, ADC_SOC_NUMBER0, ADC_TRIGGER_EPWM1_SOCA, ADC_CH_ADCIN2, 30U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("ADC_setupSOC", ADCB_BASE, ADC_SOC_NUMBER0, ADC_TRIGGER_EPWM1_SOCA, ADC_CH_ADCIN2, 30U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("ADC_setupSOC", ADCC_BASE, ADC_SOC_NUMBER0, ADC_TRIGGER_EPWM1_SOCA, ADC_CH_ADCIN2, 30U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("ADC_setupSOC", ADCA_BASE, ADC_SOC_NUMBER1, ADC_TRIGGER_EPWM1_SOCA, ADC_CH_ADCIN3, 30U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("ADC_setInterruptSource", ADCA_BASE, ADC_INT_NUMBER1, ADC_SOC_NUMBER1));
}

void test_start_sets_the_converters_up_alike_and_waits_a_millisecond(void)
{
    static const uint32_t BASE[3] = BOARD_ADC_BASES;
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("ADC_setPrescaler", BASE[k], ADC_CLK_DIV_4_0));
        TEST_ASSERT_EQUAL(1, TIMES_CALLED("ADC_setMode", BASE[k], ADC_RESOLUTION_12BIT, ADC_MODE_SINGLE_ENDED));
        const int on = CALLED("ADC_enableConverter", BASE[k]);
        BEFORE(on, CALLED_AFTER(on, "SysCtl_delay", 40000U));
    }
}

void test_start_routes_nfault_and_three_comparators_to_the_trip_zone(void)
{
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("XBAR_setInputPin", XBAR_INPUT1, 19U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("XBAR_setEPWMMuxConfig", XBAR_TRIP4, 0x1401U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("XBAR_setEPWMMuxConfig", XBAR_TRIP4, 0x0801U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("XBAR_setEPWMMuxConfig", XBAR_TRIP4, 0x0001U));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("XBAR_enableEPWMMux", XBAR_TRIP4, 0x411U));
}

void test_start_sets_the_comparators_to_18_a_of_their_own_reference(void)
{
    static const uint32_t BASE[3] = BOARD_CMPSS_BASES;
    for (int k = 0; k < 3; k++) { /* (1.65 V +- 18 A x 70 mV/A) / 3.3 V x 4096 */
        TEST_ASSERT_TRUE(CALLED("CMPSS_setDACValueHigh", BASE[k], 3612U) >= 0);
        TEST_ASSERT_TRUE(CALLED("CMPSS_setDACValueLow", BASE[k], 484U) >= 0);
        TEST_ASSERT_EQUAL_UINT16(3612U, chip.cmpss[k].high);
    }
}

/* The board's maximum of the software limit is the level at which the hardware trips, and below where the converter clips. */
/* The DRV8305 warns of its own heat, and has no value to read; its board has no sensor for the motor's. */
void test_board_has_no_temperature_sensor(void)
{
    float celsius = NAN;
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_temperature(HAL_TEMPERATURE_MOTOR, &celsius));
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_temperature(HAL_TEMPERATURE_BRIDGE, &celsius));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, celsius);
}

void test_board_has_no_input_for_safe_torque_off(void) { TEST_ASSERT_EQUAL_UINT16(0U, hal_sto()); }

void test_board_has_no_brake_chopper(void)
{
    hal_limits_t board = {.has_chopper = true};
    hal_limits(&board);
    TEST_ASSERT_FALSE(board.has_chopper);
    hal_brake_duty(1.0f); /* does nothing */
}

void test_start_the_board_states_maxima_that_its_hardware_keeps(void)
{
    hal_limits_t board;
    hal_limits(&board);
    const double trips_a = ((3612.0 / 4096.0 * 3.3) - 1.65) / 0.07;                   /* 70 mV/A */
    TEST_ASSERT_DOUBLE_WITHIN(3.3 / 4096.0 / 0.07, trips_a, (double)board.current_a); /* one step of the comparator's converter */
    TEST_ASSERT_TRUE(board.current_a < (3.0 - 1.65) / 0.07);
    TEST_ASSERT_TRUE(board.dc_link_v < 3.0 * 13.42); /* full scale of the divider */
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 1.5e6 / 4000.0 * 6.283185, (double)board.speed_rad_s);
    TEST_ASSERT_TRUE(1.0 / 1.5e6 > 6.0 * 20.0 / 200.0e6); /* edges that far apart pass six equal samples of 20 cycles */
}

void test_start_proves_that_each_comparator_trips_each_module(void)
{
    static const uint32_t BASE[3] = BOARD_CMPSS_BASES;
    for (int k = 0; k < 3; k++) {
        const int forced = CALLED("CMPSS_setDACValueHigh", BASE[k], 0U);
        BEFORE(CALLED("GPIO_writePin", BOARD_PIN_EN_GATE, 1U), forced); /* the amplifiers must live */
        BEFORE(forced, CALLED_AFTER(forced, "CMPSS_setDACValueHigh", BASE[k], 3612U));
    }
    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
}

void test_start_with_a_dead_trip_path_never_arms(void)
{
    fake_power_on();
    chip.comparators_dead = true;

    TEST_ASSERT_EQUAL(PORT_OK, port_init());

    TEST_ASSERT_EQUAL(HAL_INVERTER_TRIP_PATH, hal_inverter_fault());
    hal_inverter_clear_fault();
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_inverter_arm());
}

void test_start_with_a_dead_trip_zone_connects_no_gate(void)
{
    fake_power_on();
    chip.trip_zone_dead = true;

    TEST_ASSERT_EQUAL(PORT_TRIP_UNARMED, port_init());

    for (int pin = 0; pin < 6; pin++) {
        TEST_ASSERT_EQUAL(-1, CALLED("GPIO_setPinConfig", GATES[pin]));
    }
    TEST_ASSERT_EQUAL(-1, CALLED("GPIO_writePin", BOARD_PIN_EN_GATE, 1U));
    TEST_ASSERT_EQUAL(HAL_INVERTER_TRIP_PATH, hal_inverter_fault());
    hal_inverter_clear_fault(); /* nothing makes it well */
    TEST_ASSERT_EQUAL(HAL_INVERTER_TRIP_PATH, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_inverter_arm());
    TEST_ASSERT_EQUAL(-1, CALLED("GPIO_writePin", BOARD_PIN_EN_GATE, 1U));
}

void test_start_with_dead_low_comparators_never_arms(void)
{
    fake_power_on();
    chip.low_comparators_dead = true;

    TEST_ASSERT_EQUAL(PORT_OK, port_init());

    TEST_ASSERT_EQUAL(HAL_INVERTER_TRIP_PATH, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_inverter_arm());
}

void test_start_with_a_dead_guard_never_arms(void)
{
    fake_power_on();
    chip.guard_dead = true;

    TEST_ASSERT_EQUAL(PORT_OK, port_init());

    TEST_ASSERT_EQUAL(HAL_INVERTER_TRIP_PATH, hal_inverter_fault());
    hal_inverter_clear_fault();
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_inverter_arm());
}

void test_start_restores_both_levels_of_every_comparator_after_the_self_test(void)
{
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_EQUAL_UINT16(3612U, chip.cmpss[k].high);
        TEST_ASSERT_EQUAL_UINT16(484U, chip.cmpss[k].low);
    }
}

void test_start_locks_what_routes_the_trips_and_the_gates_and_writes_nothing_of_it_later(void)
{
    TEST_ASSERT_TRUE(chip.xbar_locked && chip.input_locked);
    TEST_ASSERT_EQUAL_HEX32(0x0008003FU, chip.port_a_locked); /* GPIO0..5 and 19 */
    arm();
    hal_inverter_disarm();
    hal_inverter_clear_fault();
    arm();
    TEST_ASSERT_EQUAL(0, chip.locked_writes);
}

void test_start_gives_the_vector_check_a_handler_and_enables_the_nmi(void)
{
    TEST_ASSERT_NOT_EQUAL_UINT32(0U, chip.pie_error_address); /* at reset: a routine of the boot ROM */
    TEST_ASSERT_TRUE(CALLED_AT_ALL("SysCtl_enableNMIGlobalInterrupt") >= 0);
}

/* What made the NMI outlives the reset that its watchdog makes, and only that one. */
void test_start_after_a_reset_by_the_nmi_is_a_fault_that_says_which(void)
{
    static const struct {
        uint32_t             cause;
        uint16_t             nmi;
        hal_inverter_fault_t fault;
    } CASE[] = {{0x8U, 0x002U, HAL_INVERTER_CLOCK},  {0x8U, 0x004U, HAL_INVERTER_MEMORY}, {0x8U, 0x008U, HAL_INVERTER_MEMORY},
                {0xAU, 0x040U, HAL_INVERTER_MEMORY}, {0x8U, 0x000U, HAL_INVERTER_FINE},   {0x4U, 0x004U, HAL_INVERTER_FINE},
                {0x1U, 0x040U, HAL_INVERTER_FINE}};
    for (size_t k = 0; k < sizeof CASE / sizeof CASE[0]; k++) {
        fake_power_on();
        chip.reset_cause = CASE[k].cause;
        chip.nmi_shadow = CASE[k].nmi;
        TEST_ASSERT_EQUAL(PORT_OK, port_init());
        TEST_ASSERT_EQUAL_INT(CASE[k].fault, hal_inverter_fault());
        hal_inverter_clear_fault(); /* it has been seen */
        TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
    }
}

void test_start_shows_corrected_memory_errors(void)
{
    chip.ram_errors = 3U;
    chip.flash_errors = 2U;

    port_background();

    TEST_ASSERT_EQUAL_UINT32(3U, port_health()->ram_corrected);
    TEST_ASSERT_EQUAL_UINT32(2U, port_health()->flash_corrected);
}

static int flashes_in(int passes, uint64_t cycles)
{
    int      n = 0;
    uint32_t before = 1U;
    for (int i = 0; i < passes; i++) {
        chip.cycles += cycles;
        port_background();
        n += ((before == 1U) && (chip.latch[BOARD_PIN_LED_RED] == 0U)) ? 1 : 0;
        before = chip.latch[BOARD_PIN_LED_RED];
    }
    return n;
}

void test_start_light_flashes_the_code_of_what_is_wrong_and_is_dark_else(void)
{
    TEST_ASSERT_EQUAL(0, flashes_in(100, 6000000U));
    TEST_ASSERT_TRUE(chip.is_output[BOARD_PIN_LED_RED] && chip.is_output[BOARD_PIN_LED_BLUE]);
    TEST_ASSERT_EQUAL_UINT32(1U, chip.latch[BOARD_PIN_LED_BLUE]); /* off */

    port_trip_note(HAL_INVERTER_OVER_CURRENT);
    TEST_ASSERT_INT_WITHIN(1, 3 * 5, flashes_in(500, 6000000U)); /* 5 times 10 steps of 0.3 s, from anywhere in the first */

    fake_power_on();
    chip.trip_zone_dead = true;
    TEST_ASSERT_EQUAL(PORT_TRIP_UNARMED, port_init());
    TEST_ASSERT_INT_WITHIN(1, 2 * 5, flashes_in(400, 6000000U)); /* 5 times 8 steps */
}

void test_start_that_fails_flashes_its_code_without_a_clock(void)
{
    fake_power_on();
    fake_forget_calls();
    chip.escape_set = true;
    if (setjmp(chip.escape) == 0) {
        port_stop_with_code(PORT_NO_CLOCK);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, chip.latch[BOARD_PIN_LED_RED]); /* low is on */
    TEST_ASSERT_TRUE(CALLED("SysCtl_delay", 600000U) >= 0);      /* 3e6 cycles, 0.3 s at the 10 MHz that are left */
}

void test_start_gives_every_other_interrupt_to_a_handler_that_trips(void)
{
    arm();
    TEST_ASSERT_TRUE(all_gates_follow());

    chip.escape_set = true;
    if (setjmp(chip.escape) == 0) {
        chip.vector[18](); /* NMI */
    }

    TEST_ASSERT_TRUE(all_gates_low());
    for (int v = 13; v < FAKE_VECTORS; v++) {
        TEST_ASSERT_NOT_NULL(chip.vector[v]);
    }
}

void test_start_enables_two_interrupts_and_nothing_else(void)
{
    TEST_ASSERT_EQUAL(2, fake_count("Interrupt_enable", 0, NULL));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("Interrupt_enable", INT_ADCA1));
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("Interrupt_enable", INT_TIMER2));
    TEST_ASSERT_EQUAL_HEX16(0x2001, IER);
}

void test_start_puts_the_watchdog_on_last_with_52_ms(void)
{
    TEST_ASSERT_EQUAL(1, TIMES_CALLED("SysCtl_setWatchdogPrescaler", SYSCTL_WD_PRESCALE_4));
    BEFORE(CALLED("SysCtl_enablePeripheral", SYSCTL_PERIPH_CLK_TBCLKSYNC), CALLED_AT_ALL("SysCtl_enableWatchdog"));
    TEST_ASSERT_TRUE(chip.watchdog_on);
}

/* The watchdog pulls the reset pin as well: the worst that is seen counts. */
void test_start_tells_why_the_processor_was_reset(void)
{
    static const struct {
        uint32_t    bits;
        hal_reset_t cause;
    } CASE[] = {{0x0U, HAL_RESET_UNKNOWN},  {0x1U, HAL_RESET_POWER_UP}, {0x3U, HAL_RESET_POWER_UP}, {0x2U, HAL_RESET_PIN},
                {0x4U, HAL_RESET_WATCHDOG}, {0x6U, HAL_RESET_WATCHDOG}, {0x8U, HAL_RESET_WATCHDOG}, {0x100U, HAL_RESET_OTHER}};
    for (size_t k = 0; k < sizeof CASE / sizeof CASE[0]; k++) {
        chip.reset_cause = CASE[k].bits;
        TEST_ASSERT_EQUAL(PORT_OK, port_init());
        TEST_ASSERT_EQUAL_INT(CASE[k].cause, hal_reset_cause());
        TEST_ASSERT_EQUAL_HEX32(CASE[k].bits, port_reset_cause());
    }
}
