/* firmware/app/memory.c: what the angle observer learned, in and out, over a power cycle, and when the power fails. */
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_sample.h"
#include "mock_hal_storage.h"
#include "tests/firmware/support/bench.h"

#define PAGES 4U
#define WORDS 256U
#define CELLS 200U

static uint16_t flash[PAGES][WORDS];
static int32_t  writes_until_power_fails; /* negative: it does not */
static uint16_t pages;

static hal_status_t check(uint16_t page, uint16_t offset, uint16_t count)
{
    TEST_ASSERT_TRUE_MESSAGE((page < PAGES) && ((uint32_t)offset + count <= WORDS), "outside of the storage");
    return HAL_OK;
}

static uint16_t storage_pages(int calls)
{
    (void)calls;
    return pages;
}

static uint16_t storage_page_words(int calls)
{
    (void)calls;
    return WORDS;
}

static hal_status_t storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count, int calls)
{
    (void)calls;
    (void)check(page, offset, count);
    (void)memcpy(words, &flash[page][offset], count * sizeof words[0]);
    return HAL_OK;
}

static bool powered(void)
{
    if (writes_until_power_fails == 0) {
        return false;
    }
    writes_until_power_fails--;
    return true;
}

static hal_status_t storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count, int calls)
{
    (void)calls;
    (void)check(page, offset, count);
    if (powered()) {
        for (uint16_t i = 0U; i < count; i++) {
            TEST_ASSERT_EQUAL_HEX16_MESSAGE(0xFFFFU, flash[page][offset + i], "programmed without being erased");
            flash[page][offset + i] &= words[i];
        }
    }
    return HAL_OK;
}

static hal_status_t storage_erase(uint16_t page, int calls)
{
    (void)calls;
    (void)check(page, 0U, 1U);
    if (powered()) {
        (void)memset(flash[page], 0xFF, sizeof flash[page]);
    }
    return HAL_OK;
}

static void power_up(uint16_t method)
{
    drive_params_t p = bench_params();
    p.method = method;
    p.auto_run = 0U;
    drive_init(&drive, &p);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
}

void setUp(void)
{
    bench_start();
    (void)memset(flash, 0xFF, sizeof flash);
    writes_until_power_fails = -1;
    pages = PAGES;
    hal_storage_pages_Stub(storage_pages);
    hal_storage_page_words_Stub(storage_page_words);
    hal_storage_read_Stub(storage_read);
    hal_storage_write_Stub(storage_write);
    hal_storage_erase_Stub(storage_erase);
    power_up(DRIVE_METHOD_ARO);
}
void tearDown(void) {}

static float table[CELLS];
static float back[CELLS];

static const float *wave(double size)
{
    for (uint16_t i = 0U; i < CELLS; i++) {
        table[i] = (float)(size * cos(TWO_PI * 3.0 * i / CELLS));
    }
    return table;
}

/* ampere: half of 2^-16 of a save, and a step of 6e-8 of 10 A */
static void assert_table(double size, const char *text)
{
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(CELLS, drive_memory_read(&drive, back, CELLS), text);
    for (uint16_t i = 0U; i < CELLS; i++) {
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, size * cos(TWO_PI * 3.0 * i / CELLS), (double)back[i], text);
    }
}

void test_memory_starts_with_nothing(void)
{
    assert_table(0.0, "after power-up");
}

void test_memory_reads_back_what_was_written(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.5), CELLS));

    assert_table(2.5, "written");
}

void test_memory_read_gives_no_more_than_there_is_room_for(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.5), CELLS));
    back[10] = 77.0f;

    TEST_ASSERT_EQUAL_UINT16(10U, drive_memory_read(&drive, back, 10U));
    TEST_ASSERT_EQUAL_FLOAT(77.0f, back[10]);
    TEST_ASSERT_EQUAL_UINT16(0U, drive_memory_read(&drive, back, 0U));
}

void test_memory_write_refuses_what_does_not_fit_and_changes_nothing(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));

    TEST_ASSERT_FALSE(drive_memory_write(&drive, wave(2.0), CELLS - 1U));
    const float bad[] = {NAN, INFINITY, -INFINITY, 10.5f, -10.5f}; /* observer_limit_a is 10 A */
    for (size_t k = 0; k < COUNT_OF(bad); k++) {
        (void)wave(2.0);
        table[CELLS - 1U] = bad[k];
        TEST_ASSERT_FALSE(drive_memory_write(&drive, table, CELLS));
    }
    assert_table(1.0, "as it was");
}

void test_memory_exists_only_for_the_angle_observer(void)
{
    power_up(DRIVE_METHOD_DOB);

    TEST_ASSERT_EQUAL_UINT16(0U, drive_memory_read(&drive, back, CELLS));
    TEST_ASSERT_FALSE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_restore(&drive));
}

void test_memory_cannot_be_replaced_forgotten_or_saved_while_running(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    drive_start(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);

    TEST_ASSERT_FALSE(drive_memory_write(&drive, wave(2.0), CELLS));
    TEST_ASSERT_FALSE(drive_memory_clear(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_BUSY, drive_memory_save(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_BUSY, drive_memory_restore(&drive));
    assert_table(1.0, "as it was");
}

void test_memory_clear_forgets(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_TRUE(drive_memory_clear(&drive));

    assert_table(0.0, "cleared");
}

void test_memory_survives_a_power_cycle_when_saved(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.5), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    power_up(DRIVE_METHOD_ARO);
    assert_table(0.0, "not restored yet");

    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    assert_table(2.5, "restored");
}

void test_memory_restore_without_a_save_leaves_it(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));

    TEST_ASSERT_EQUAL_INT(HAL_STALE, drive_memory_restore(&drive));
    assert_table(1.0, "as it was");
}

void test_memory_newest_of_many_saves_counts(void)
{
    for (int k = 1; k <= 9; k++) {
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(0.5 * k), CELLS));
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
        TEST_ASSERT_TRUE(drive_memory_clear(&drive));
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
        assert_table(0.5 * k, at("save %d", k));
    }
}

/* wherever the power goes: the older save is there, or, after the last word, the new one */
void test_memory_save_cut_off_anywhere_leaves_the_older_one(void)
{
    static uint16_t older[PAGES][WORDS];
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    (void)memcpy(older, flash, sizeof flash);
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
    const int32_t steps = 2 + 4 + 2 * (int32_t)CELLS; /* 2 pages erased, header, values */
    for (int32_t after = 0; after <= steps; after++) {
        (void)memcpy(flash, older, sizeof flash);
        power_up(DRIVE_METHOD_ARO);
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
        writes_until_power_fails = after;
        (void)drive_memory_save(&drive);
        writes_until_power_fails = -1;

        power_up(DRIVE_METHOD_ARO);
        TEST_ASSERT_EQUAL_INT_MESSAGE(HAL_OK, drive_memory_restore(&drive), at("after %d", (int)after));
        assert_table((after == steps) ? 2.0 : 1.0, at("after %d", (int)after));
    }
}

void test_memory_save_with_a_flipped_bit_does_not_exist(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    for (uint16_t i = 0U; i < 4U + 2U * CELLS; i += 3U) {
        uint16_t *const word = &flash[i / WORDS][i % WORDS];
        *word ^= (uint16_t)(1U << (i % 16U));
        TEST_ASSERT_EQUAL_INT_MESSAGE(HAL_STALE, drive_memory_restore(&drive), at("word %u", (unsigned)i));
        *word ^= (uint16_t)(1U << (i % 16U));
    }
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
}

void test_memory_board_without_storage_is_unsupported(void)
{
    pages = 0U;

    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_STALE, drive_memory_restore(&drive));
}

void test_memory_storage_too_small_for_the_table_is_unsupported(void)
{
    pages = 2U; /* one page of 256 words per slot, 404 are needed */

    TEST_ASSERT_NOT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_STALE, drive_memory_restore(&drive));
}
