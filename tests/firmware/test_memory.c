/* firmware/app/memory.c: what the angle observer learned, in and out, over a power cycle, and when the power fails. */
#include <stdlib.h>

#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "mock_hal_storage.h"
#include "tests/firmware/support/bench.h"
#include "tests/firmware/support/flash.h"

#define CELLS 200U

static void power_up(uint16_t method)
{
    flash_power_up();
    drive_params_t p = bench_params();
    p.method = method;
    drive_init(&drive, &p);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_READY, drive.state);
}

void setUp(void)
{
    bench_start();
    flash_start();
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

/* wherever the power goes: the older save is there, or, from the commit on, the new one; tests/firmware/storage has the rest */
void test_memory_save_cut_off_anywhere_leaves_the_older_one_or_the_new_one(void)
{
    static flash_cells_t older;
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    older = flash.cells;
    const int32_t steps =
        1 + 1 + 2 + ((int32_t)CELLS / 2) + 1 + 3; /* erase, page, head, which tables and values, trailer, commit, confirm */
    for (int32_t after = 0; after <= steps; after++) {
        flash.cells = older;
        power_up(DRIVE_METHOD_ARO);
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
        flash.until_power_fails = after;
        (void)drive_memory_save(&drive);

        power_up(DRIVE_METHOD_ARO);
        TEST_ASSERT_EQUAL_INT_MESSAGE(HAL_OK, drive_memory_restore(&drive), at("after %d", (int)after));
        assert_table((after >= (steps - 1)) ? 2.0 : 1.0, at("after %d", (int)after));
    }
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
        flash.pages = k; /* what would be erased might be all there is */

        TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
        TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_restore(&drive));
    }
    flash.pages = FLASH_PAGES;
    flash.page_words = 0U;
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_restore(&drive));
    TEST_ASSERT_EQUAL_UINT32(0U, flash.changes);
    assert_table(1.0, "as it was");
}

void test_memory_storage_as_large_as_the_table_will_do_and_a_smaller_one_is_not_touched(void)
{
    flash.pages = 2U;
    flash.page_words = 4U + 8U + (2U * CELLS) + 4U + 12U; /* which tables: two words, padded to a block */
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_TRUE(drive_memory_clear(&drive));

    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    assert_table(2.0, "restored");

    flash.page_words -= 4U;
    const uint32_t before = flash.changes;
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_save(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_UNSUPPORTED, drive_memory_restore(&drive));
    TEST_ASSERT_EQUAL_UINT32(before, flash.changes);
}

/* ---- storage that answers with an error ---------------------------------------------------------------------------------- */

void test_memory_save_ends_at_the_first_error_of_the_storage_and_says_it(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
    for (int32_t good = 0; good < 50; good += 7) {
        flash.changes = 0U;
        flash.until_error = good;
        TEST_ASSERT_EQUAL_INT(HAL_BUSY, drive_memory_save(&drive));
        flash.until_error = -1;
        TEST_ASSERT_EQUAL_UINT32_MESSAGE((uint32_t)good + 1U, flash.changes, "went on after an error");
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
        assert_table(1.0, at("after %d", (int)good));
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.0), CELLS));
    }
}

/* A value that reads differently each time spoils every attempt: nothing of it is taken. */
void test_memory_restore_that_cannot_read_leaves_the_table(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    for (uint16_t word = 0U; word < (2U * CELLS); word += 3U) {
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(3.0), CELLS));
        flash.cells.word[0][4U + 8U + word] ^= 0x10U;
        TEST_ASSERT_EQUAL_INT(HAL_SENSOR_FAULT, drive_memory_restore(&drive));
        flash.cells.word[0][4U + 8U + word] ^= 0x10U;
        assert_table(3.0, at("word %u", (unsigned)word));
    }
}

/* ---- every method that learns over the angle --------------------------------------------------------------------------- */

typedef struct {
    const char *name;
    uint16_t    method, rc_memory, position_method;
    float       learn_gain;
    uint16_t    cells;
    double      limit; /* of its values */
} learner_t;

/* bench_params: over_speed 650 rad/s, iq_limit 10 A; rc_limit_unit and the sizes are set below */
static const learner_t LEARNERS[] = {
    {"aro", DRIVE_METHOD_ARO, CTL_RC_KEEP, DRIVE_POSITION_PPI, 0.0f, CELLS, 10.0},
    {"crc, angle", DRIVE_METHOD_CRC, CTL_RC_ANGLE, DRIVE_POSITION_PPI, 0.0f, 128U, 50.0},
    {"forc, angle", DRIVE_METHOD_FORC, CTL_RC_ANGLE, DRIVE_POSITION_PPI, 0.0f, 128U, 50.0},
    {"fal-forc, angle", DRIVE_METHOD_FAL_FORC, CTL_RC_ANGLE, DRIVE_POSITION_PPI, 0.0f, 128U, 50.0},
    {"silc", DRIVE_METHOD_PI, CTL_RC_KEEP, DRIVE_POSITION_SILC, 0.0f, 100U, 600.0},
    {"src", DRIVE_METHOD_PI, CTL_RC_KEEP, DRIVE_POSITION_SRC, 0.0f, 100U, 600.0},
    {"rdc", DRIVE_METHOD_PI, CTL_RC_KEEP, DRIVE_POSITION_RDC, 0.3f, 100U, 10.0},
    {"rdc that does not learn", DRIVE_METHOD_PI, CTL_RC_KEEP, DRIVE_POSITION_RDC, 0.0f, 0U, 10.0},
    {"crc, time", DRIVE_METHOD_CRC, CTL_RC_KEEP, DRIVE_POSITION_PPI, 0.0f, 0U, 50.0},
    {"fal-forc, time, cleared", DRIVE_METHOD_FAL_FORC, CTL_RC_CLEAR, DRIVE_POSITION_PPI, 0.0f, 0U, 50.0},
    {"ro", DRIVE_METHOD_RO, CTL_RC_KEEP, DRIVE_POSITION_PPI, 0.0f, 0U, 10.0},
};

static void start_learner(const learner_t *of)
{
    drive_params_t p = bench_params();
    p.method = of->method;
    p.rc_memory = of->rc_memory;
    p.position_method = of->position_method;
    p.rdc_learn_gain = of->learn_gain;
    p.rc_cells = 128U;
    p.rc_limit_unit = 50.0f;
    p.position_cells = 100U;
    p.over_speed_rad_s = 600.0f;
    drive_init(&drive, &p);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_READY, drive.state, of->name);
}

static const float *scaled(double size, uint16_t cells)
{
    for (uint16_t i = 0U; i < cells; i++) {
        table[i] = (float)(size * cos(TWO_PI * 3.0 * i / cells));
    }
    return table;
}

/* half of 2^-16 of a save, and a step of 6e-8 of at most 150 rad/s or 60 units; float: 24 bits */
static void assert_scaled(double size, uint16_t cells, const char *text)
{
    TEST_ASSERT_EQUAL_UINT16_MESSAGE(cells, drive_memory_read(&drive, back, CELLS), text);
    for (uint16_t i = 0U; i < cells; i++) {
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.5e-5, size * cos(TWO_PI * 3.0 * i / cells), (double)back[i], text);
    }
}

void test_memory_of_every_method_that_learns_over_the_angle_is_read_written_saved_restored_and_cleared(void)
{
    for (size_t k = 0; k < COUNT_OF(LEARNERS); k++) {
        const learner_t *const of = &LEARNERS[k];
        start_learner(of);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(of->cells, drive_memory_cells(&drive), of->name);
        if (of->cells == 0U) {
            TEST_ASSERT_FALSE_MESSAGE(drive_memory_write(&drive, scaled(1.0, 100U), 100U), of->name);
            TEST_ASSERT_EQUAL_INT_MESSAGE(HAL_UNSUPPORTED, drive_memory_save(&drive), of->name);
            TEST_ASSERT_EQUAL_INT_MESSAGE(HAL_UNSUPPORTED, drive_memory_restore(&drive), of->name);
            continue;
        }
        TEST_ASSERT_TRUE_MESSAGE(drive_memory_write(&drive, scaled(2.0, of->cells), of->cells), of->name);
        assert_scaled(2.0, of->cells, of->name);
        TEST_ASSERT_EQUAL_INT_MESSAGE(HAL_OK, drive_memory_save(&drive), of->name);
        TEST_ASSERT_TRUE(drive_memory_clear(&drive));
        assert_scaled(0.0, of->cells, of->name);
        TEST_ASSERT_EQUAL_INT_MESSAGE(HAL_OK, drive_memory_restore(&drive), of->name);
        assert_scaled(2.0, of->cells, of->name);
    }
}

void test_memory_of_every_method_is_bounded_by_its_limit(void)
{
    for (size_t k = 0; k < COUNT_OF(LEARNERS); k++) {
        const learner_t *const of = &LEARNERS[k];
        if (of->cells > 0U) {
            start_learner(of);
            TEST_ASSERT_TRUE_MESSAGE(drive_memory_write(&drive, scaled(of->limit, of->cells), of->cells), of->name);
            (void)scaled(1.0, of->cells);
            table[of->cells - 1U] = (float)(-1.001 * of->limit);
            TEST_ASSERT_FALSE_MESSAGE(drive_memory_write(&drive, table, of->cells), of->name);
            table[of->cells - 1U] = (float)NAN;
            TEST_ASSERT_FALSE_MESSAGE(drive_memory_write(&drive, table, of->cells), of->name);
            (void)drive_memory_read(&drive, back, CELLS);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5 * of->limit, of->limit, (double)back[0],
                                              of->name); /* nothing of it was taken */
        }
    }
}

void test_memory_over_the_angle_survives_a_stop_and_a_start(void)
{
    for (size_t k = 1; k <= 6; k++) {
        const learner_t *const of = &LEARNERS[k];
        start_learner(of);
        TEST_ASSERT_TRUE(drive_memory_write(&drive, scaled(2.0, of->cells), of->cells));
        for (int run = 0; run < 2; run++) {
            drive_start(&drive);
            drive_background(&drive);
            TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
            drive_stop(&drive);
            drive_background(&drive);
        }
        assert_scaled(2.0, of->cells, of->name);
    }
}

/* as many values: of silc, in rad/s, and of rdc, in ampere */
void test_memory_of_another_method_is_not_restored(void)
{
    start_learner(&LEARNERS[4]);
    TEST_ASSERT_TRUE(drive_memory_write(&drive, scaled(2.0, 100U), 100U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    for (size_t k = 5; k <= 6; k++) {
        start_learner(&LEARNERS[k]);
        TEST_ASSERT_TRUE(drive_memory_write(&drive, scaled(1.0, 100U), 100U));

        TEST_ASSERT_EQUAL_INT(HAL_STALE, drive_memory_restore(&drive));
        assert_scaled(1.0, 100U, LEARNERS[k].name);
    }
}

void test_memory_of_two_methods_is_one_table_after_the_other(void)
{
    learner_t both = LEARNERS[2];
    start_learner(&both);
    drive_params_t p = *drive.params;
    p.disturbance_observer = DRIVE_OBSERVER_ARO;
    p.aro_cells = 64U;
    drive_init(&drive, &p);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_UINT16(64U + 128U, drive_memory_cells(&drive));
    for (uint16_t i = 0U; i < (64U + 128U); i++) {
        table[i] = (i < 64U) ? 3.0f : 20.0f; /* ampere within 10, then units within 50 */
    }
    TEST_ASSERT_TRUE(drive_memory_write(&drive, table, 64U + 128U));
    TEST_ASSERT_DOUBLE_WITHIN(
        1e-5, 3.0, (double)num_to_float(drive.observer.observer.state.memory.state.grid.cell[63]) * drive.scale.current_a);
    TEST_ASSERT_DOUBLE_WITHIN(2.5e-5, 20.0, (double)num_to_float(drive.speed.rc.state.turn.cell[0]) * drive.scale.error_unit);
    table[0] = 20.0f;
    TEST_ASSERT_FALSE(drive_memory_write(&drive, table, 64U + 128U));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_TRUE(drive_memory_clear(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 3.0, (double)drive_memory_cell(&drive, 63U));
    TEST_ASSERT_DOUBLE_WITHIN(2.5e-5, 20.0, (double)drive_memory_cell(&drive, 64U));
}

/* ---- what is stored ---------------------------------------------------------------------------------------------------- */

void test_memory_is_stored_in_parts_of_an_ampere_whatever_the_numeric(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(2.5), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    const uint16_t *const stored =
        &flash.cells.word[0][4U + 8U + 2U]; /* behind the block of the page, the head, and which tables */
    for (uint16_t i = 0U; i < CELLS; i++) {
        const uint32_t word = ((uint32_t)stored[2U * i] << 16) | stored[(2U * i) + 1U];
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

static unsigned trials(unsigned few, unsigned all) { return (getenv("EVENSPIN_CAMPAIGN") != NULL) ? all : few; }

/* Any bit of any word of the page that the next save takes. */
void test_memory_save_into_a_cell_that_is_stuck_is_not_called_a_save(void)
{
    unsigned saved = 0U;
    unsigned failed = 0U;
    for (unsigned k = 0U; k < trials(200U, 2000U); k++) {
        setUp();
        flash.chance = k;
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
        power_up(DRIVE_METHOD_ARO);
        flash.odd_page = 1U;
        flash.odd_word = (uint16_t)flash_pick(4U + 8U + (2U * CELLS) + 12U);
        flash.stuck = (uint16_t)(1U << flash_pick(16U));
        TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(3.0), CELLS));
        const bool ok = drive_memory_save(&drive) == HAL_OK;
        power_up(DRIVE_METHOD_ARO);

        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
        assert_table(ok ? 3.0 : 1.0, at("trial %u", k));
        saved += ok ? 1U : 0U;
        failed += ok ? 0U : 1U;
    }
    TEST_ASSERT_TRUE((saved > 0U) && (failed > 0U));
}

void test_memory_restore_from_a_cell_that_is_unsteady_takes_what_was_saved_or_nothing(void)
{
    const uint32_t words = 4U + (2U * (8U + (2U * CELLS) + 12U));
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(3.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save(&drive));
    for (unsigned k = 0U; k < trials(500U, 20000U); k++) {
        flash.odd_word = (uint16_t)flash_pick(words);
        flash.unsteady = (uint16_t)(1U << flash_pick(16U));
        power_up(DRIVE_METHOD_ARO);
        const hal_status_t s = drive_memory_restore(&drive);
        (void)drive_memory_read(&drive, back, CELLS);
        assert_table((s != HAL_OK) ? 0.0 : ((back[0] > 2.0f) ? 3.0 : 1.0), at("trial %u", k));
    }
}

/* 4 blocks or a page a pass: a watchdog of 50 ms is served in between. */
void test_memory_save_is_done_in_small_steps(void)
{
    TEST_ASSERT_TRUE(drive_memory_write(&drive, wave(1.0), CELLS));
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save_begin(&drive));
    TEST_ASSERT_EQUAL_INT(HAL_BUSY, drive_memory_save_begin(&drive));
    TEST_ASSERT_FALSE(drive_memory_write(&drive, wave(2.0), CELLS)); /* the table stays what it was */
    unsigned passes = 0U;
    while (drive.storage.active && (passes < 1000U)) {
        const uint32_t before = flash.changes;
        TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_save_step(&drive));
        TEST_ASSERT_TRUE((flash.changes - before) <= 16U);
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
    TEST_ASSERT_FALSE(drive.storage.active);
    power_up(DRIVE_METHOD_ARO);
    TEST_ASSERT_EQUAL_INT(HAL_OK, drive_memory_restore(&drive));
    assert_table(1.0, "the older one");
}
