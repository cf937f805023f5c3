/* DRV8305: set-up, frames, and what its status bits mean. */
#include "tests/hal/support/started.h"

void setUp(void) { started(); }
void tearDown(void) {}

static hal_inverter_fault_t meaning(uint16_t warnings, uint16_t vds, uint16_t ic, uint16_t vgs)
{
    const port_driver_status_t s = {warnings, vds, ic, vgs, true};
    return port_driver_reason(&s);
}

void test_driver_is_set_to_16_bit_frames_that_it_latches_on_the_falling_edge(void)
{
    TEST_ASSERT_EQUAL(1,
                      TIMES_CALLED("SPI_setConfig", SPIA_BASE, 50000000U, SPI_PROT_POL0PHA0, SPI_MODE_CONTROLLER, 1000000U, 16U));
}

void test_driver_gets_its_settings_after_its_wake_up_time(void)
{
    const int enabled = CALLED("GPIO_writePin", BOARD_PIN_EN_GATE, 1U);
    const int waited = CALLED_AFTER(enabled, "SysCtl_delay", 80000U); /* 2 ms */
    const int control = CALLED("SPI_writeDataNonBlocking", SPIA_BASE, 0x3A16U);
    const int amplifiers = CALLED("SPI_writeDataNonBlocking", SPIA_BASE, 0x5000U);
    const int cleared = CALLED("SPI_writeDataNonBlocking", SPIA_BASE, 0x48A2U); /* after the settings */
    TEST_ASSERT_TRUE((enabled >= 0) && (waited > enabled) && (control > waited) && (amplifiers > control) &&
                     (cleared > amplifiers));
    TEST_ASSERT_TRUE(port_driver_status()->answers);
}

/* Register maps of SLVSD12D: what an earlier program or a rubbish answer may have left is gone. */
static const uint16_t SETTING[][2] = {{0x5U, 0x344U}, {0x6U, 0x344U}, {0x7U, 0x216U}, {0x9U, 0x0A0U},
                                      {0xAU, 0x000U}, {0xBU, 0x10AU}, {0xCU, 0x040U}};
#define SETTING_COUNT (sizeof SETTING / sizeof SETTING[0])

void test_driver_gets_every_setting_whatever_it_had_before(void)
{
    for (int stuck = 0; stuck < 2; stuck++) {
        fake_power_on();
        for (int address = 5; address <= 0xC; address++) {
            chip.drv[address] = 0x7FFU;
        }
        chip.drv_stuck = stuck != 0; /* every answer is 0x7FF: nothing of it may be written back */
        TEST_ASSERT_EQUAL(PORT_OK, port_init());
        for (size_t i = 0; (i < SETTING_COUNT) && (stuck == 0); i++) {
            TEST_ASSERT_EQUAL_HEX16(SETTING[i][1], chip.drv[SETTING[i][0]]);
        }
        TEST_ASSERT_EQUAL((stuck == 0) ? HAL_INVERTER_FINE : HAL_INVERTER_DRIVER_LINK, hal_inverter_fault());
        TEST_ASSERT_EQUAL(-1, CALLED("SPI_writeDataNonBlocking", SPIA_BASE, 0x4FFFU)); /* sleep, watchdog, protections off */
        TEST_ASSERT_EQUAL(-1, CALLED("SPI_writeDataNonBlocking", SPIA_BASE, 0x4FFDU));
    }
}

void test_driver_is_waited_for_when_its_supply_comes_80_ms_later(void)
{
    fake_power_on();
    chip.drv_supplied_cycles = 80U * 200000U;

    TEST_ASSERT_EQUAL(PORT_OK, port_init());

    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
}

void test_driver_without_supply_is_a_fault_within_150_ms_and_a_clear_sets_it_up_when_it_has_one(void)
{
    started(); /* a program that runs, and loses the supply of its driver */
    const uint64_t before = chip.cycles;
    chip.drv_supplied_cycles = UINT64_MAX;
    TEST_ASSERT_EQUAL(PORT_OK, port_init());
    TEST_ASSERT_TRUE((chip.cycles - before) < (150U * 200000U));
    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_LINK, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_inverter_arm());

    chip.drv_supplied_cycles = 0U;
    for (int address = 5; address <= 0xC; address++) { /* as at reset, but for what matters here: level and clamp */
        chip.drv[address] = (address == 0xC) ? 0x0C8U : ((address == 9) ? 0x020U : chip.drv[address]);
    }
    hal_inverter_clear_fault();

    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        TEST_ASSERT_EQUAL_HEX16(SETTING[i][1], chip.drv[SETTING[i][0]]);
    }
    TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
}

static int polls_until_fault(int most)
{
    int n = 0;
    while ((hal_inverter_fault() == HAL_INVERTER_FINE) && (n < most)) {
        pass_ms(2);
        n++;
    }
    return n;
}

void test_driver_that_loses_a_setting_while_it_runs_is_a_fault_within_22_ms(void)
{
    for (size_t i = 0; i < SETTING_COUNT; i++) {
        started();
        arm();
        chip.drv[SETTING[i][0]] ^= 0x001U; /* no status bit tells */
        const int polls = polls_until_fault(30);
        TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_LINK, hal_inverter_fault());
        TEST_ASSERT_TRUE(polls <= 11);
    }
}

void test_dead_spi_while_it_runs_is_a_fault(void)
{
    for (int way = 0; way < 3; way++) {
        started();
        arm();
        chip.drv_mute = way == 0;
        chip.drv_stuck = way == 1;
        chip.spi_hangs = way == 2;
        TEST_ASSERT_TRUE(polls_until_fault(30) <= ((way == 1) ? 1 : 11));  /* ones where the sheet has zeros show in every word */
        TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_LINK, hal_inverter_fault()); /* all ones are not every fault at once */
    }
}

void test_answer_that_a_disturbance_hits_once_is_read_again(void)
{
    arm();
    for (int i = 0; i < 11; i++) {
        chip.drv_garbled = (i >= 4) ? 1 : 0; /* settings, not the status words: those say what they say */
        pass_ms(2);
        TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
    }
}

void test_warning_on_nfault_is_named_after_the_bridge_went_off(void)
{
    static const struct {
        uint16_t             warning;
        hal_inverter_fault_t name;
    } CASE[] = {{0x040U, HAL_INVERTER_DRIVER_SUPPLY}, /* over-voltage */
                {0x080U, HAL_INVERTER_DRIVER_SUPPLY}, /* under-voltage */
                {0x010U, HAL_INVERTER_DRIVER_SUPPLY}, /* charge pump */
                {0x001U, HAL_INVERTER_OVER_TEMPERATURE},
                {0x100U, HAL_INVERTER_OVER_TEMPERATURE}};
    for (size_t k = 0; k < sizeof CASE / sizeof CASE[0]; k++) {
        started();
        arm();
        chip.drv[1] = CASE[k].warning;
        fake_trips();
        TEST_ASSERT_TRUE(all_gates_low());
        TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, hal_inverter_fault()); /* in an interrupt there is no time to ask */
        port_background();
        TEST_ASSERT_EQUAL(CASE[k].name, hal_inverter_fault());
    }
}

void test_driver_faults_of_an_earlier_program_are_cleared(void)
{
    fake_power_on();
    chip.drv[2] = 0x400;
    chip.drv[1] = 0x400;

    TEST_ASSERT_EQUAL(PORT_OK, port_init());

    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, hal_inverter_fault());
}

void test_chip_select_frames_every_word(void)
{
    fake_forget_calls();
    hal_inverter_fault_t reason;

    TEST_ASSERT_TRUE(port_driver_is_well(&reason));

    TEST_ASSERT_EQUAL(fake_count("SPI_writeDataNonBlocking", 0, NULL), TIMES_CALLED("GPIO_writePin", BOARD_PIN_CHIP_SELECT, 0U));
    const int low = CALLED("GPIO_writePin", BOARD_PIN_CHIP_SELECT, 0U);
    const int sent = CALLED_AFTER(low, "SPI_writeDataNonBlocking", SPIA_BASE, 0x8800U);
    const int got = CALLED_AFTER(sent, "SPI_readDataNonBlocking", SPIA_BASE);
    const int high = CALLED_AFTER(got, "GPIO_writePin", BOARD_PIN_CHIP_SELECT, 1U);
    TEST_ASSERT_TRUE((low >= 0) && (sent > low) && (got > sent) && (high > got));
}

void test_mute_driver_is_a_fault_and_prevents_arming(void)
{
    fake_power_on();
    chip.drv_mute = true;

    TEST_ASSERT_EQUAL(PORT_OK, port_init());

    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_LINK, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_inverter_arm());
}

void test_hanging_spi_ends_and_is_a_fault(void)
{
    fake_power_on();
    chip.spi_hangs = true;

    TEST_ASSERT_EQUAL(PORT_OK, port_init());

    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_LINK, hal_inverter_fault());
}

void test_nfault_without_a_reason_in_the_status_is_a_driver_fault(void)
{
    hal_inverter_fault_t reason = HAL_INVERTER_FINE;
    chip.nfault_stuck = true;

    TEST_ASSERT_FALSE(port_driver_is_well(&reason));

    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, reason);
}

void test_quiet_status_means_no_fault(void) { TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, meaning(0U, 0U, 0U, 0U)); }

void test_temperature_warning_and_shutdown_mean_over_temperature(void)
{
    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_TEMPERATURE, meaning(0x001U, 0U, 0U, 0U));
    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_TEMPERATURE, meaning(0U, 0U, 0x100U, 0U));
}

void test_each_vds_and_shunt_bit_means_over_current(void)
{
    static const uint16_t BIT[] = {0x400, 0x200, 0x100, 0x080, 0x040, 0x020, 0x004, 0x002, 0x001};
    for (size_t i = 0; i < sizeof BIT / sizeof BIT[0]; i++) {
        TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_CURRENT, meaning(0U, BIT[i], 0U, 0U));
    }
}

void test_supply_bits_mean_the_supply_of_the_driver(void)
{
    static const uint16_t IC[] = {0x400, 0x040, 0x020, 0x010, 0x004, 0x002, 0x001};
    for (size_t i = 0; i < sizeof IC / sizeof IC[0]; i++) {
        TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_SUPPLY, meaning(0U, 0U, IC[i], 0U));
    }
}

void test_gate_and_watchdog_bits_mean_a_driver_fault(void)
{
    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, meaning(0U, 0U, 0x200U, 0U));
    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, meaning(0U, 0U, 0U, 0x400U));
}

void test_temperature_flags_below_the_warning_are_no_fault(void)
{
    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, meaning(0x00EU, 0U, 0U, 0U));
}

void test_warning_that_comes_up_is_found_by_the_main_loop(void)
{
    chip.drv[1] = 0x001;
    for (int i = 0; i < 11; i++) { /* one of eleven registers every 2 ms */
        chip.cycles += 400000U;
        port_background();
    }

    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_TEMPERATURE, hal_inverter_fault());
}

void test_main_loop_asks_the_driver_every_2_ms_only(void)
{
    port_background();
    chip.cycles += 400000U;
    fake_forget_calls();

    port_background();
    port_background();

    TEST_ASSERT_EQUAL(1, fake_count("SPI_writeDataNonBlocking", 0, NULL));
}

void test_clearing_a_driver_fault_while_it_stands_names_it(void)
{
    arm();
    chip.drv_cause[3] = 0x100; /* too hot */
    chip.drv[3] = 0x100;
    fake_trips();
    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, hal_inverter_fault()); /* in the interrupt there is no time to ask */

    hal_inverter_clear_fault();

    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_TEMPERATURE, hal_inverter_fault());
}
