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
    const int amplifiers = CALLED("SPI_writeDataNonBlocking", SPIA_BASE, 0x5000U);
    const int control = CALLED("SPI_writeDataNonBlocking", SPIA_BASE, 0x3A16U);
    TEST_ASSERT_TRUE((enabled >= 0) && (waited > enabled) && (amplifiers > waited) && (control > amplifiers));
    TEST_ASSERT_TRUE(port_driver_status()->answers);
}

void test_driver_keeps_its_vds_level_and_gets_latched_shutdown(void)
{
    fake_power_on();
    chip.drv[0xC] = 0x0C9; /* an earlier program left "report only" */

    TEST_ASSERT_EQUAL(PORT_OK, port_init());

    TEST_ASSERT_EQUAL_HEX16(0x0C8, chip.drv[0xC]);
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

    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, hal_inverter_fault());
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_inverter_arm());
}

void test_hanging_spi_ends_and_is_a_fault(void)
{
    fake_power_on();
    chip.spi_hangs = true;

    TEST_ASSERT_EQUAL(PORT_OK, port_init());

    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, hal_inverter_fault());
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

void test_supply_and_gate_bits_mean_a_driver_fault(void)
{
    static const uint16_t IC[] = {0x400, 0x200, 0x040, 0x020, 0x010, 0x004, 0x002, 0x001};
    for (size_t i = 0; i < sizeof IC / sizeof IC[0]; i++) {
        TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, meaning(0U, 0U, IC[i], 0U));
    }
    TEST_ASSERT_EQUAL(HAL_INVERTER_DRIVER_FAULT, meaning(0U, 0U, 0U, 0x400U));
}

void test_temperature_flags_below_the_warning_are_no_fault(void)
{
    TEST_ASSERT_EQUAL(HAL_INVERTER_FINE, meaning(0x10EU & ~0x001U, 0U, 0U, 0U));
}

void test_warning_that_comes_up_is_found_by_the_main_loop(void)
{
    chip.drv[1] = 0x001;
    for (int i = 0; i < 4; i++) { /* one of four status registers every 10 ms */
        chip.cycles += 2000000U;
        port_background();
    }

    TEST_ASSERT_EQUAL(HAL_INVERTER_OVER_TEMPERATURE, hal_inverter_fault());
}

void test_main_loop_asks_the_driver_every_10_ms_only(void)
{
    port_background();
    chip.cycles += 2000000U;
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
