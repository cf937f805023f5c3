/* hal/f28379d/storage.c with the flash API: three sectors, blocks of four words, nothing while the bridge is armed. That the
 * API is called as TI wants it can only be held against declarations here; docs/flashing.md lists what to see on a board. */
#include <string.h>

#include "F021_F2837xD_C28x.h"
#include "tests/hal/support/started.h"

static const uint16_t BLOCK[4] = {1U, 2U, 3U, 0xFFFFU};

void setUp(void)
{
    started();
    (void)memset(&fake_flash, 0, sizeof fake_flash);
    fake_flash.ecc = true;
    fake_flash.busy_cyc = 10000U;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(0U, fake_flash.broken, "a demand of the flash API is not met");
    TEST_ASSERT_TRUE_MESSAGE(fake_flash.ecc && !fake_flash.pump && !fake_flash.eallow, "left open");
}

void test_storage_keeps_what_is_written_in_its_own_sectors(void)
{
    uint16_t back[4];
    TEST_ASSERT_EQUAL_UINT16(3U, hal_storage_pages());
    TEST_ASSERT_EQUAL_UINT16(0x2000U, hal_storage_page_words());
    for (uint16_t page = 0U; page < 3U; page++) {
        TEST_ASSERT_EQUAL(HAL_OK, hal_storage_erase(page));
        TEST_ASSERT_EQUAL(HAL_OK, hal_storage_write(page, 0x1FFCU, BLOCK, 4U));
        TEST_ASSERT_EQUAL(HAL_OK, hal_storage_read(page, 0x1FFCU, back, 4U));
        TEST_ASSERT_EQUAL_HEX16_ARRAY(BLOCK, back, 4U);
        TEST_ASSERT_EQUAL_HEX16_ARRAY(BLOCK, &fake_flash.word[((page + 1U) * 0x2000U) - 4U], 4U);
    }
    TEST_ASSERT_FALSE(chip.intm);
}

void test_storage_refuses_what_is_no_block_or_outside(void)
{
    uint16_t word = 0U;
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_storage_write(0U, 2U, BLOCK, 4U));
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_storage_write(0U, 0U, BLOCK, 3U));
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_storage_write(3U, 0U, BLOCK, 4U));
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_storage_write(0U, 0x1FFEU, BLOCK, 4U));
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_storage_read(0U, 0x2000U, &word, 1U));
    TEST_ASSERT_EQUAL(HAL_UNSUPPORTED, hal_storage_erase(3U));
    TEST_ASSERT_EQUAL(0, TIMES_CALLED("Flash_claimPumpSemaphore", FLASHPUMPSEMAPHORE_BASE, FLASH_CPU1_WRAPPER));
}

void test_storage_changes_nothing_while_the_bridge_is_armed(void)
{
    uint16_t back[4];
    TEST_ASSERT_EQUAL(HAL_OK, hal_storage_erase(0U));
    period();
    TEST_ASSERT_EQUAL(HAL_OK, hal_inverter_arm());
    TEST_ASSERT_EQUAL(HAL_BUSY, hal_storage_write(0U, 0U, BLOCK, 4U));
    TEST_ASSERT_EQUAL(HAL_BUSY, hal_storage_erase(0U));
    TEST_ASSERT_EQUAL(HAL_OK, hal_storage_read(0U, 0U, back, 4U));
    TEST_ASSERT_EQUAL_HEX16(0xFFFFU, back[0]);
    hal_inverter_disarm();
}

void test_storage_says_when_the_state_machine_of_the_flash_has_failed(void)
{
    fake_flash.status = 0x10U;
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_storage_erase(1U));
    TEST_ASSERT_EQUAL(HAL_SENSOR_FAULT, hal_storage_write(1U, 0U, BLOCK, 4U));
}

/* 300 ms, and the watchdog bites after 52: it is served, not more often than every 20 ms, in case it has a window. */
void test_storage_long_erase_serves_the_watchdog(void)
{
    fake_flash.busy_cyc = 60000000U;
    chip.cycles += 1U;
    const uint32_t before = chip.watchdog_served;
    const uint64_t began = chip.cycles;
    TEST_ASSERT_EQUAL(HAL_OK, hal_storage_erase(0U));
    const uint64_t took_ms = (chip.cycles - began) / 200000U;
    const int      served = (int)(chip.watchdog_served - before);
    TEST_ASSERT_TRUE(took_ms >= 300U);
    TEST_ASSERT_INT_WITHIN(2, (int)(took_ms / 20U), served);
}

/* The main loop goes on right after it: what the erase has served it does not serve again within the window. */
void test_storage_and_main_loop_together_serve_the_watchdog_never_within_its_window(void)
{
    for (uint32_t k = 0U; k < 20U; k++) {
        fake_flash.busy_cyc = 8000000U + (k * 500000U); /* ends at every distance from the last service */
        TEST_ASSERT_EQUAL(HAL_OK, hal_storage_erase(0U));
        for (int i = 0; i < 300; i++) {
            period();
            port_background();
        }
    }
    TEST_ASSERT_EQUAL(0, chip.watchdog_too_soon);
}

/* Start-up: nothing is switched on that was off. */
void test_storage_leaves_the_interrupts_off_where_they_were_off(void)
{
    chip.intm = true;
    TEST_ASSERT_EQUAL(HAL_OK, hal_storage_erase(0U));
    TEST_ASSERT_TRUE(chip.intm);
    chip.intm = false;
}

/* Hundreds of periods go by in an erase: for the drive no sample is lost. */
void test_storage_the_drive_sees_no_gap_after_an_erase(void)
{
    period();
    const uint32_t before = sample.seq;
    fake_flash.busy_cyc = 20000000U;
    chip.adc_flag = true;
    chip.adc_overflow = true;
    TEST_ASSERT_EQUAL(HAL_OK, hal_storage_erase(2U));
    period();
    TEST_ASSERT_EQUAL(HAL_OK, sample_status);
    TEST_ASSERT_EQUAL_UINT32(before + 1U, sample.seq);
}
