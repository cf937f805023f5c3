/* firmware/app/memory.c: what the angle observer learned, in and out, over a power cycle, and when the power fails. */
#include <stdlib.h>

#include "firmware/app/storage_map.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "mock_hal_storage.h"
#include "tests/firmware/support/bench.h"

#define PAGES 4U
#define WORDS 256U
#define CELLS 200U

static uint16_t flash[PAGES][WORDS];
static int32_t  writes_until_power_fails; /* negative: it does not */
static uint16_t pages;                    /* before those of the parameters, which nobody here may touch */
static uint16_t page_words;
static bool     tears; /* the power goes in the middle of a word or an erase */
static noise_t  torn;
static uint32_t changes;             /* words written and pages erased... */
static int32_t  changes_until_error; /* ...until the storage is busy; negative: never */
static int32_t  reads, reads_until_error;
static uint16_t stuck_page, stuck_word, stuck_mask;          /* bits of a cell that read 0 whatever was written... */
static uint16_t unsteady_page, unsteady_word, unsteady_mask; /* ...and that read one way or the other */
static noise_t  chance;

static hal_status_t check(uint16_t page, uint16_t offset, uint16_t count)
{
    TEST_ASSERT_TRUE_MESSAGE((page < pages) && ((uint32_t)offset + count <= page_words), "outside of the storage");
    return HAL_OK;
}

/* Pages lie one behind the other, of whatever size. */
static uint16_t *cell_of(uint16_t page, uint16_t offset) { return &flash[0][0] + ((size_t)page * page_words) + offset; }

static uint16_t storage_pages(int calls)
{
    (void)calls;
    return (uint16_t)(pages + STORAGE_PARAMETER_PAGES);
}

static uint16_t storage_page_words(int calls)
{
    (void)calls;
    return page_words;
}

static hal_status_t storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count, int calls)
{
    (void)calls;
    (void)check(page, offset, count);
    if ((reads_until_error >= 0) && (reads >= reads_until_error)) {
        return HAL_SENSOR_FAULT;
    }
    reads++;
    (void)memcpy(words, cell_of(page, offset), count * sizeof words[0]);
    if ((page == stuck_page) && (offset <= stuck_word) && (stuck_word < (offset + count))) {
        words[stuck_word - offset] &= (uint16_t)~stuck_mask;
    }
    if ((page == unsteady_page) && (offset <= unsteady_word) && (unsteady_word < (offset + count))) {
        words[unsteady_word - offset] ^= (uint16_t)(unsteady_mask & (noise_bits(&chance) >> 16));
    }
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

static bool is_busy(void)
{
    changes++;
    return (changes_until_error >= 0) && (changes > (uint32_t)changes_until_error);
}

static hal_status_t storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count, int calls)
{
    (void)calls;
    (void)check(page, offset, count);
    if (is_busy()) {
        return HAL_BUSY;
    }
    uint16_t *const to = cell_of(page, offset);
    if (powered()) {
        for (uint16_t i = 0U; i < count; i++) {
            TEST_ASSERT_EQUAL_HEX16_MESSAGE(0xFFFFU, to[i], "programmed without being erased");
            to[i] &= words[i];
        }
    } else if (tears) {
        to[0] &= (uint16_t)(words[0] | (noise_bits(&torn) >> 16));
        tears = false; /* nothing happens after it */
    } else {
        /* dead */
    }
    return HAL_OK;
}

static hal_status_t storage_erase(uint16_t page, int calls)
{
    (void)calls;
    (void)check(page, 0U, 1U);
    if (is_busy()) {
        return HAL_BUSY;
    }
    uint16_t *const from = cell_of(page, 0U);
    if (powered()) {
        (void)memset(from, 0xFF, page_words * sizeof from[0]);
    } else if (tears) {
        for (uint16_t i = 0U; i < page_words; i++) {
            from[i] |= (uint16_t)(noise_bits(&torn) >> 16);
        }
        tears = false;
    } else {
        /* dead */
    }
    return HAL_OK;
}

static void power_up(uint16_t method)
{
    drive_params_t p = bench_params();
    p.method = method;
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
    page_words = WORDS;
    tears = false;
    changes_until_error = -1;
    reads_until_error = -1;
    stuck_mask = 0U;
    unsteady_mask = 0U;
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

void test_memory_starts_with_nothing(void) { assert_table(0.0, "after power-up"); }

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

    drive.set[0].setup.observer.capacity = CELLS; /* not for want of room */
    TEST_ASSERT_FALSE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
}

void test_memory_write_leaves_what_is_behind_the_table(void)
{
    drive.observer_memory[CELLS] = num_of(0.5);

    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.5), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));

    TEST_ASSERT_EQUAL_DOUBLE(0.5, value_of(drive.observer_memory[CELLS]));
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

/* CRC-16/CCITT-FALSE (polynomial 0x1021, start 0xFFFF; "123456789" gives 0x29B1), octet by octet */
static uint16_t crc16(uint16_t crc, uint16_t octet)
{
    uint32_t c = crc ^ ((uint32_t)octet << 8);
    for (int bit = 0; bit < 8; bit++) {
        c = ((c << 1) ^ (((c & 0x8000U) != 0U) ? 0x1021U : 0U)) & 0xFFFFU;
    }
    return (uint16_t)c;
}

void test_memory_save_carries_the_published_check_sum_over_number_size_and_values(void)
{
    uint16_t check = 0xFFFFU;
    for (uint16_t c = '1'; c <= '9'; c++) {
        check = crc16(check, c);
    }
    TEST_ASSERT_EQUAL_HEX16(0x29B1U, check);
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));

    const uint16_t *const word = flash[0];
    TEST_ASSERT_EQUAL_UINT16(CELLS, word[2]);
    check = 0xFFFFU;
    for (uint16_t i = 1U; i < 4U + 2U * CELLS; i++) {
        const uint16_t w = flash[i / WORDS][i % WORDS];
        if (i != 3U) { /* that is where it stands */
            check = crc16(crc16(check, (uint16_t)(w >> 8)), (uint16_t)(w & 0xFFU));
        }
    }
    TEST_ASSERT_EQUAL_HEX16(check, word[3]);
    /* a value is ampere times 2^16, high word first */
    TEST_ASSERT_INT_WITHIN(1, 65536, (int)(((uint32_t)word[4] << 16) | word[5]));
}

void test_memory_clear_forgets_the_repetitive_controller_too(void)
{
    drive_params_t p = bench_params();
    p.method = DRIVE_METHOD_FORC;
    p.speed_inline = 1U;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 15.707963, 0.0, 0.0);
    bench_periods(1005U);
    TEST_ASSERT_TRUE(value_of(drive.speed.correction) > 0.0);
    drive.state = DRIVE_READY;
    TEST_ASSERT_TRUE(drive_memory_clear(&drive));
    drive.state = DRIVE_RUN;
    bench_periods(10U);

    TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(drive.speed.correction));
}

void test_memory_board_without_storage_is_unsupported(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    for (uint16_t k = 0U; k < 2U; k++) {
        pages = k; /* one page is no two slots */

        TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
        TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_restore(&drive));
    }
    pages = PAGES;
    page_words = 0U;
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_restore(&drive));
    assert_table(1.0, "as it was");
}

void test_memory_storage_too_small_for_the_table_is_unsupported_and_not_erased(void)
{
    pages = 2U; /* one page of 256 words per slot, 404 are needed */
    (void)memset(flash, 0x55, sizeof flash);

    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_restore(&drive));
    TEST_ASSERT_EACH_EQUAL_HEX16(0x5555U, &flash[0][0], PAGES * WORDS);
}

void test_memory_storage_as_large_as_the_table_will_do(void)
{
    pages = 2U;
    page_words = 4U + (2U * CELLS);
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_TRUE(drive_memory_clear(&drive));

    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    assert_table(2.0, "restored");

    page_words--;
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
}

/* ---- power that goes in the middle of a word ---------------------------------------------------------------------------- */

#define SAVE_STEPS (2U + 4U + (2U * CELLS)) /* 2 pages erased, header, values */

/* What is there after a failure may be anything between before and after, bit by bit. */
void test_memory_save_cut_off_within_any_word_or_erase_leaves_the_older_or_the_new_one(void)
{
    static uint16_t older[PAGES][WORDS];
    uint32_t        news = 0U;
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(0.5), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive)); /* so that what is erased is a good save, too */
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    (void)memcpy(older, flash, sizeof flash);
    for (uint32_t cut = 0U; cut < SAVE_STEPS; cut++) {
        for (uint32_t seed = 1U; seed <= 3U; seed++) {
            (void)memcpy(flash, older, sizeof flash);
            TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
            writes_until_power_fails = (int32_t)cut;
            torn.seed = (cut * 3U) + seed;
            tears = true;
            (void)drive_memory_save(&drive);
            tears = false;
            writes_until_power_fails = -1;

            power_up(DRIVE_METHOD_ARO);
            TEST_ASSERT_EQUAL_INT_MESSAGE(HAL_OK, drive_memory_restore(&drive), at("cut %u", (unsigned)cut));
            (void)drive_memory_read(&drive, back, CELLS);
            const bool is_new = fabs((double)back[0] - 2.0) < 0.1;
            news += is_new ? 1U : 0U;
            TEST_ASSERT_TRUE_MESSAGE(!is_new || (cut == (SAVE_STEPS - 1U)), at("cut %u", (unsigned)cut));
            assert_table(is_new ? 2.0 : 1.0, at("cut %u", (unsigned)cut));

            /* and the next save is as good as any */
            TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.5), CELLS));
            TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
            TEST_ASSERT_TRUE(drive_memory_clear(&drive));
            TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
            assert_table(1.5, at("the save after cut %u", (unsigned)cut));
        }
    }
    TEST_ASSERT_TRUE(news <= 3U);
}

void test_memory_save_cut_off_on_an_empty_storage_leaves_none_or_the_new_one(void)
{
    for (uint32_t cut = 0U; cut <= SAVE_STEPS; cut++) {
        (void)memset(flash, 0xFF, sizeof flash);
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
        writes_until_power_fails = (int32_t)cut;
        (void)drive_memory_save(&drive);
        writes_until_power_fails = -1;

        power_up(DRIVE_METHOD_ARO);
        const bool complete = cut == SAVE_STEPS;
        TEST_ASSERT_EQUAL_INT_MESSAGE(complete ? HAL_OK : HAL_STALE, drive_memory_restore(&drive), at("cut %u", (unsigned)cut));
        assert_table(complete ? 2.0 : 0.0, at("cut %u", (unsigned)cut));
    }
}

void test_memory_with_a_bit_of_the_newest_save_flipped_the_older_one_counts(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive)); /* slot 0, pages 0 and 1 */
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive)); /* slot 1, pages 2 and 3 */
    for (uint16_t i = 0U; i < (4U + (2U * CELLS)); i++) {
        uint16_t *const word = &flash[2U + (i / WORDS)][i % WORDS];
        *word ^= (uint16_t)(1U << (i % 16U));
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
        assert_table(1.0, at("word %u", (unsigned)i));
        *word ^= (uint16_t)(1U << (i % 16U));
    }
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    assert_table(2.0, "whole again");
}

/* ---- storage that answers with an error ---------------------------------------------------------------------------------- */

void test_memory_save_ends_at_the_first_error_of_the_storage_and_says_it(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
    for (int32_t good = 0; good < (int32_t)SAVE_STEPS; good += 7) {
        changes = 0U;
        changes_until_error = good;
        TEST_ASSERT_EQUAL_INT(HAL_BUSY, drive_memory_save(&drive));
        changes_until_error = -1;
        TEST_ASSERT_EQUAL_UINT32_MESSAGE((uint32_t)good + 1U, changes, "went on after an error");
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
        assert_table(1.0, at("after %d", (int)good));
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
    }
}

void test_memory_restore_that_meets_an_error_leaves_the_table(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    reads = 0;
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    const int32_t all = reads;
    for (int32_t good = 0; good < all; good++) {
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(3.0), CELLS));
        reads = 0;
        reads_until_error = good;
        TEST_ASSERT_NOT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
        reads_until_error = -1;

        (void)drive_memory_read(&drive, back, CELLS);
        assert_table(3.0, at("read %d", (int)good));
    }
    TEST_ASSERT_EQUAL_INT32(4 + 4 + (2 * (int32_t)CELLS), all); /* two headers, and every word of the table once */
}

/* ---- what is stored ---------------------------------------------------------------------------------------------------- */

/* CRC-16/CCITT-FALSE, octet by octet from the most significant bit: its check value for "123456789" is 0x29B1. */
static uint16_t crc_octets(const uint8_t *octets, size_t count)
{
    uint32_t crc = 0xFFFFU;
    for (size_t i = 0; i < count; i++) {
        for (int bit = 7; bit >= 0; bit--) {
            const uint32_t in = (octets[i] >> bit) & 1U;
            const uint32_t out = (crc >> 15) & 1U;
            crc = (crc << 1) & 0xFFFFU;
            crc ^= ((in ^ out) != 0U) ? 0x1021U : 0U;
        }
    }
    return (uint16_t)crc;
}

void test_memory_is_stored_in_parts_of_an_ampere_whatever_the_numeric(void)
{
    static uint8_t octets[2U * (2U + (2U * CELLS))];
    TEST_ASSERT_EQUAL_HEX16(0x29B1U, crc_octets((const uint8_t *)"123456789", 9U));
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.5), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    const uint16_t *const stored = &flash[0][0]; /* two pages in a row */

    TEST_ASSERT_EQUAL_HEX16(0xA201U, stored[0]);
    TEST_ASSERT_EQUAL_UINT16(1U, stored[1]);
    TEST_ASSERT_EQUAL_UINT16(CELLS, stored[2]);
    size_t n = 0;
    for (uint16_t i = 1U; i < (4U + (2U * CELLS)); i++) {
        if (i != 3U) {
            octets[n++] = (uint8_t)(stored[i] >> 8);
            octets[n++] = (uint8_t)(stored[i] & 0xFFU);
        }
    }
    TEST_ASSERT_EQUAL_HEX16(crc_octets(octets, n), stored[3]);
    for (uint16_t i = 0U; i < CELLS; i++) {
        const uint32_t word = ((uint32_t)stored[4U + (2U * i)] << 16) | stored[5U + (2U * i)];
        /* half of 2^-16 A, and a step of 6e-8 of 10 A */
        TEST_ASSERT_DOUBLE_WITHIN(8.5e-6, 2.5 * cos(TWO_PI * 3.0 * i / CELLS), (double)(int32_t)word / 65536.0);
    }
}

void test_memory_of_another_number_of_cells_is_not_restored(void)
{
    drive_params_t p = bench_params();
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    p.method = DRIVE_METHOD_ARO;
    p.aro_cells = CELLS / 2U;
    drive_init(&drive, &p);
    drive_background(&drive);

    TEST_ASSERT_EQUAL_INT(HAL_STALE, drive_memory_restore(&drive));
    TEST_ASSERT_EQUAL_UINT16(CELLS / 2U, drive_memory_read(&drive, back, CELLS));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, back[0]);
}

void test_memory_newest_save_is_found_when_its_number_wraps(void)
{
    /* after 65535 saves; the numbers are not protected by more than the check sum, so the test writes them itself */
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    for (int k = 0; k < 2; k++) {
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    }
    static uint8_t octets[2U * (2U + (2U * CELLS))];
    for (uint16_t slot = 0U; slot < 2U; slot++) { /* numbers 65534 and 65535 */
        uint16_t *const stored = &flash[2U * slot][0];
        size_t          n = 0;
        stored[1] = (uint16_t)(65534U + slot);
        for (uint16_t i = 1U; i < (4U + (2U * CELLS)); i++) {
            if (i != 3U) {
                octets[n++] = (uint8_t)(stored[i] >> 8);
                octets[n++] = (uint8_t)(stored[i] & 0xFFU);
            }
        }
        stored[3] = crc_octets(octets, n);
    }
    for (int k = 1; k <= 3; k++) { /* 0, 1, 2 */
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0 + k), CELLS));
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
        TEST_ASSERT_TRUE(drive_memory_clear(&drive));
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
        assert_table(1.0 + k, at("save %d", k));
    }
}

void test_memory_restored_is_within_the_limit_of_today(void)
{
    drive_params_t p = bench_params();
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(8.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    p.method = DRIVE_METHOD_ARO;
    p.observer_limit_a = 3.0f;
    drive_init(&drive, &p);
    drive_background(&drive);

    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));

    TEST_ASSERT_EQUAL_UINT16(CELLS, drive_memory_read(&drive, back, CELLS));
    for (uint16_t i = 0U; i < CELLS; i++) {
        const double want = fmin(3.0, fmax(-3.0, 8.0 * cos(TWO_PI * 3.0 * i / CELLS)));
        TEST_ASSERT_DOUBLE_WITHIN(1.2e-5, want, (double)back[i]);
    }
}

void test_memory_can_be_written_read_saved_and_restored_in_a_fault(void)
{
    drive.state = DRIVE_FAULT;

    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_TRUE(drive_memory_clear(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    assert_table(1.0, "restored");
}

void test_memory_clear_forgets_what_the_repetitive_controller_learned_too(void)
{
    power_up(DRIVE_METHOD_FORC);
    TEST_ASSERT_TRUE(drive.setup->speed.rc_used);
    const ctl_period_t period = {20U, (num_t)0};
    double             before = 0.0;
    for (int k = 0; k < 200; k++) {
        before = fmax(before, fabs(value_of(ctl_rc_step(&drive.speed.rc, num_of(0.5), period, 0U))));
    }
    TEST_ASSERT_TRUE(before > 0.01);

    TEST_ASSERT_TRUE(drive_memory_clear(&drive));

    for (int k = 0; k < 100; k++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(ctl_rc_step(&drive.speed.rc, (num_t)0, period, 0U)));
    }
}

void test_memory_write_of_every_value_up_to_the_limit_is_taken(void)
{
    for (uint16_t i = 0U; i < CELLS; i++) {
        table[i] = (i % 2U == 0U) ? 10.0f : -10.0f;
    }

    TEST_ASSERT_TRUE(drive_memory_write(&drive, table, CELLS));
    TEST_ASSERT_FALSE(drive_memory_write(&drive, table, CELLS + 1U));
    TEST_ASSERT_FALSE(drive_memory_write(&drive, table, 0U));
}

/* ---- cells that do not keep or do not show what was written ---------------------------------------------------------------- */

static unsigned trials(unsigned usual, unsigned all) { return (getenv("EVENSPIN_CAMPAIGN") != NULL) ? all : usual; }

/* Any bit of any word of the slot that the next save takes. */
void test_memory_save_into_a_cell_that_is_stuck_is_not_called_a_save(void)
{
    noise_t        noise = {11U};
    const uint16_t words = 4U + (2U * CELLS);
    unsigned       saved = 0U;
    unsigned       told = 0U;
    for (unsigned k = 0U; k < trials(200U, 2000U); k++) {
        setUp();
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive)); /* slot 0 */
        const uint16_t word = (uint16_t)noise_pick(&noise, words);
        stuck_page = (uint16_t)(2U + (word / WORDS));
        stuck_word = (uint16_t)(word % WORDS);
        stuck_mask = (uint16_t)(1U << noise_pick(&noise, 16U));
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(3.0), CELLS));
        const bool ok = drive_memory_save(&drive) == HAL_OK;
        power_up(DRIVE_METHOD_ARO);

        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
        assert_table(ok ? 3.0 : 1.0, at("trial %u", k));
        saved += ok ? 1U : 0U;
        told += ok ? 0U : 1U;
    }
    TEST_ASSERT_TRUE((saved > 0U) && (told > 0U));
}

void test_memory_restore_from_a_cell_that_is_unsteady_takes_what_was_saved_or_nothing(void)
{
    noise_t        noise = {13U};
    const uint16_t words = 4U + (2U * CELLS);
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(3.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    for (unsigned k = 0U; k < trials(500U, 20000U); k++) {
        const uint16_t word = (uint16_t)noise_pick(&noise, words);
        unsteady_page = (uint16_t)((2U * noise_pick(&noise, 2U)) + (word / WORDS));
        unsteady_word = (uint16_t)(word % WORDS);
        unsteady_mask = (uint16_t)(1U << noise_pick(&noise, 16U));
        power_up(DRIVE_METHOD_ARO);
        const hal_status_t s = drive_memory_restore(&drive);
        (void)drive_memory_read(&drive, back, CELLS);
        assert_table((s != HAL_OK) ? 0.0 : ((back[0] > 2.0f) ? 3.0 : 1.0), at("trial %u", k));
    }
}

/* 16 words or a page a pass: a watchdog of 50 ms is served in between. */
void test_memory_save_is_done_in_small_steps(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save_begin(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_BUSY, drive_memory_save_begin(&drive));
    TEST_ASSERT_FALSE(drive_memory_write(&drive, wave(2.0), CELLS)); /* the table stays what it was */
    unsigned passes = 0U;
    while (drive.saving.active && (passes < 1000U)) {
        const uint32_t before = changes;
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save_step(&drive));
        TEST_ASSERT_TRUE((changes - before) <= 16U);
        passes++;
    }
    TEST_ASSERT_TRUE(passes < 1000U);
    power_up(DRIVE_METHOD_ARO);
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    assert_table(1.0, "saved in steps");
}

void test_memory_save_that_meets_a_start_fails_and_leaves_the_older_one(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(3.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save_begin(&drive));
    (void)drive_memory_save_step(&drive);
    drive_start(&drive);
    drive_background(&drive);
    TEST_ASSERT_NOT_EQUAL_INT(HAL_OK, drive_memory_save_step(&drive));
    TEST_ASSERT_FALSE(drive.saving.active);
    power_up(DRIVE_METHOD_ARO);
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    assert_table(1.0, "the older one");
}
