/* control/position/ilc.c: what went wrong at an angle, added up turn by turn, where its cause was. */
#include "tests/support/numeric.h"

#include "control/position/ilc.h"

#define CELLS 64U
#define STEP (UINT32_C(0x80000000) / (CELLS / 2U)) /* one cell per sample: every sample lands on a point */
#define GAIN 0.25

static num_t     memory[CELLS];
static ctl_ilc_t ilc;

static ctl_ilc_params_t valid_params(void)
{
    const ctl_ilc_params_t p = {.gain = num_of(GAIN), .lead = 0U, .limit = num_of(8.0)};
    return p;
}

static void start(uint16_t lead)
{
    ctl_ilc_params_t p = valid_params();
    p.lead = lead;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_ilc_init(&ilc, &p, memory, CELLS).status);
}

static double step(angle_t theta, double err) { return value_of(ctl_ilc_step(&ilc, theta, num_of(err))); }

/* a periodic error that both numerics hold exactly */
static double wave(uint32_t cell) { return (double)(int)((cell % CELLS) * 7U % 32U) / 16.0 - 1.0; }

static void assert_cell(uint32_t cell, double value, const char *text)
{
    ASSERT_NUM_WITHIN_AT(per_numeric(3e-6, 16.0 * FIXED_STEP), value, memory[cell % CELLS], text);
}

void setUp(void) { start(0U); }
void tearDown(void) {}

/* ---- learning ------------------------------------------------------------------------------------------------------------ */

void test_ctl_ilc_starts_with_nothing(void)
{
    for (uint32_t i = 0U; i < CELLS; i++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, step(i * STEP, 0.0));
    }
}

/* (1): after n passes the cell holds n times gain times error, in either direction */
static void assert_adds_up(angle_t one)
{
    (void)step(0U, wave(0U));
    for (uint32_t turn = 1U; turn <= 5U; turn++) {
        for (uint32_t k = 1U; k <= CELLS; k++) {
            const angle_t  theta = k * one;
            const uint32_t cell = theta / STEP;
            TEST_ASSERT_DOUBLE_WITHIN(per_numeric(3e-6, 16.0 * FIXED_STEP), turn * GAIN * wave(cell), step(theta, wave(cell)));
        }
        for (uint32_t cell = 0U; cell < CELLS; cell++) {
            assert_cell(cell, turn * GAIN * wave(cell), at("turn %u, cell %u", (unsigned)turn, (unsigned)cell));
        }
    }
}

void test_ctl_ilc_adds_gain_times_error_once_per_turn_forwards(void) { assert_adds_up(STEP); }

void test_ctl_ilc_adds_gain_times_error_once_per_turn_backwards(void) { assert_adds_up((angle_t)(0U - STEP)); }

/* an error that the output takes away shrinks by 1 - gain per turn */
void test_ctl_ilc_in_a_loop_the_error_falls_by_one_minus_gain_per_turn(void)
{
    double before[CELLS];
    for (uint32_t turn = 0U; turn < 12U; turn++) {
        for (uint32_t i = 0U; i < CELLS; i++) {
            const uint32_t cell = (i + 1U) % CELLS;
            const double   c = value_of(ctl_grid_read_linear(&ilc.state.grid, cell * STEP));
            const double   e = wave(cell) - c;
            (void)step(cell * STEP, e);
            if (turn > 1U) {
                TEST_ASSERT_DOUBLE_WITHIN(1e-5, (1.0 - GAIN) * before[cell], e);
            }
            before[cell] = e;
        }
    }
}

void test_ctl_ilc_slow_motion_teaches_a_point_once_per_pass(void)
{
    for (uint32_t k = 0U; k <= 16U * CELLS; k++) {
        (void)step(k * (STEP / 16U), 1.0);
    }
    for (uint32_t cell = 0U; cell < CELLS; cell++) {
        assert_cell(cell, GAIN, at("cell %u", (unsigned)cell));
    }
}

void test_ctl_ilc_fast_motion_teaches_every_point_between_by_the_straight_line(void)
{
    (void)step(0U, 0.0);
    (void)step(8U * STEP, 2.0);
    for (uint32_t cell = 1U; cell <= 8U; cell++) {
        assert_cell(cell, GAIN * 0.25 * cell, at("cell %u", (unsigned)cell));
    }
    assert_cell(0U, 0.0, "where it began");
    assert_cell(9U, 0.0, "ahead");
}

void test_ctl_ilc_at_standstill_learns_nothing(void)
{
    for (int k = 0; k < 100; k++) {
        (void)step(3U * STEP, 1.0);
    }
    for (uint32_t cell = 0U; cell < CELLS; cell++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(memory[cell]));
    }
}

/* there and back: a point learns when it is reached, once per pass */
void test_ctl_ilc_reversal_teaches_each_pass_once(void)
{
    for (uint32_t k = 0U; k <= 10U; k++) {
        (void)step(k * STEP + STEP / 2U, 1.0);
    }
    for (uint32_t k = 10U; k-- > 0U;) {
        (void)step(k * STEP + STEP / 2U, -0.5);
    }
    for (uint32_t cell = 1U; cell <= 9U; cell++) {
        assert_cell(cell, GAIN * (1.0 - 0.5), at("cell %u", (unsigned)cell));
    }
    assert_cell(10U, GAIN * (1.0 + 0.25), "the last one: on the way back from 1 to -0.5, half of it passed");
    assert_cell(11U, 0.0, "not reached");
}

void test_ctl_ilc_reads_between_the_points_by_the_straight_line(void)
{
    memory[5] = num_of(2.0);
    memory[6] = num_of(4.0);

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.5, step(5U * STEP + STEP / 4U, 0.0));
}

/* ---- lead ------------------------------------------------------------------------------------------------------------------ */

void test_ctl_ilc_error_is_credited_lead_samples_back_in_both_directions(void)
{
    const uint16_t leads[] = {1U, 5U, 12U, CTL_ILC_LEAD_MAX};
    for (size_t n = 0; n < COUNT_OF(leads); n++) {
        for (int direction = 0; direction < 2; direction++) {
            start(leads[n]);
            for (uint32_t k = 0U; k <= 3U * CELLS; k++) {
                const uint32_t now = (direction == 0) ? k : (0U - k);
                const uint32_t cause = (direction == 0) ? (now - leads[n]) : (now + leads[n]);
                (void)step(now * STEP, wave(cause));
            }
            /* after lead + 1 samples the first is known; from there on two passes and a part of a third */
            const uint32_t passed = 3U * CELLS - leads[n];
            for (uint32_t k = 1U; k <= CELLS; k++) {
                const uint32_t cell = (direction == 0) ? k : (0U - k);
                const uint32_t times = (passed - k) / CELLS + 1U;
                assert_cell(cell, times * GAIN * wave(cell), at("lead %u, cell %u", leads[n], (unsigned)(cell % CELLS)));
            }
        }
    }
}

void test_ctl_ilc_errors_before_the_lead_is_known_teach_nothing(void)
{
    start(12U);
    for (uint32_t k = 0U; k <= 12U; k++) {
        (void)step((5U + k) * STEP, 1.0);
    }
    for (uint32_t cell = 0U; cell < CELLS; cell++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(memory[cell]));
    }
    (void)step((5U + 13U) * STEP, 1.0);
    assert_cell(6U, GAIN, "the first one known");
}

/* ---- limits, jumps, resets -------------------------------------------------------------------------------------------------- */

void test_ctl_ilc_contents_stop_at_the_limit_in_both_directions(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        start(0U);
        for (uint32_t k = 0U; k <= 60U * CELLS; k++) {
            ASSERT_BOUNDED_AT(8.0, ctl_ilc_step(&ilc, k * STEP, num_of(sign)), "output");
        }
        assert_cell(7U, 8.0 * sign, "at the limit");
        for (uint32_t k = 0U; k <= CELLS; k++) {
            (void)step(k * STEP, -1.0 * sign);
        }
        assert_cell(7U, (8.0 - GAIN) * sign, "and back");
    }
}

/* an index found, a lost count: no motion passed the points between */
void test_ctl_ilc_jump_of_more_than_a_quarter_turn_teaches_nothing(void)
{
    const uint32_t jumps[] = {17U, 32U, 47U};
    for (size_t n = 0; n < COUNT_OF(jumps); n++) {
        start(0U);
        (void)step(3U * STEP, 1.0);
        (void)step((3U + jumps[n]) * STEP, 1.0);
        for (uint32_t cell = 0U; cell < CELLS; cell++) {
            TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(memory[cell]));
        }
        (void)step((4U + jumps[n]) * STEP, 1.0);
        assert_cell(4U + jumps[n], GAIN, "goes on from where it landed");
    }
}

void test_ctl_ilc_step_just_below_a_quarter_turn_is_a_motion(void)
{
    (void)step(0U, 1.0);
    (void)step(15U * STEP, 1.0);
    assert_cell(1U, GAIN, "forwards");
    start(0U);
    (void)step(0U, 1.0);
    (void)step(0U - 15U * STEP, 1.0);
    assert_cell(63U, GAIN, "backwards");
}

void test_ctl_ilc_reset_keeps_or_forgets_the_contents(void)
{
    assert_adds_up(STEP);
    ctl_ilc_reset(&ilc, true);
    assert_cell(9U, 5.0 * GAIN * wave(9U), "kept");
    (void)step(20U * STEP, 1.0); /* a first sample passes nothing */
    assert_cell(20U, 5.0 * GAIN * wave(20U), "not learned");

    ctl_ilc_reset(&ilc, false);
    for (uint32_t cell = 0U; cell < CELLS; cell++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(memory[cell]));
    }
}

void test_ctl_ilc_reset_forgets_the_samples_of_the_lead(void)
{
    start(3U);
    for (uint32_t k = 0U; k < 10U; k++) {
        (void)step(k * STEP, 0.0);
    }
    ctl_ilc_reset(&ilc, true);
    for (uint32_t k = 40U; k < 44U; k++) {
        (void)step(k * STEP, 1.0);
    }
    for (uint32_t cell = 0U; cell < CELLS; cell++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(memory[cell]));
    }
}

/* ---- not a number ------------------------------------------------------------------------------------------------------------ */

void test_ctl_ilc_error_that_is_not_a_number_teaches_nothing_and_is_counted(void)
{
    for (size_t n = 0; n < COUNT_OF(NOT_FINITE); n++) {
        start(0U);
        (void)step(0U, 1.0);
        memory[1] = num_of(0.5);
        ASSERT_NUM_WITHIN(1e-6, 0.5, ctl_ilc_step(&ilc, STEP, NOT_FINITE[n]));
        (void)step(2U * STEP, 1.0); /* the way from the bad sample to here says nothing */
        (void)step(3U * STEP, 1.0);

        TEST_ASSERT_EQUAL_UINT32(1U, ilc.state.rejected);
        assert_cell(1U, 0.5, "untouched");
        assert_cell(2U, 0.0, "untouched");
        assert_cell(3U, GAIN, "goes on");
    }
}

void test_ctl_ilc_output_is_bounded_for_any_input(void)
{
    noise_t noise = {137U};
    start(7U);
    for (int k = 0; k < 20000; k++) {
        const angle_t theta = (k % 100 == 0) ? noise_bits(&noise) : (ilc.state.past[ilc.state.head] + (noise_bits(&noise) >> 4));
        ASSERT_BOUNDED_AT(8.0, ctl_ilc_step(&ilc, theta, noise_nasty(&noise)), at("sample %d", k));
    }
    TEST_ASSERT_TRUE(ilc.state.rejected > 100U);
}

/* ---- refused --------------------------------------------------------------------------------------------------------------------- */

static void assert_refused(const ctl_ilc_params_t *p, num_t *cells, uint16_t count, ctl_status_t status, uint16_t field)
{
    const ctl_ilc_t  before = ilc;
    const ctl_diag_t got = ctl_ilc_init(&ilc, p, cells, count);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL(field, got.field);
    TEST_ASSERT_EQUAL_MEMORY(&before, &ilc, sizeof ilc);
}

void test_ctl_ilc_init_without_object_parameters_or_memory_is_null(void)
{
    const ctl_ilc_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_ilc_init(NULL, &p, memory, CELLS));
    assert_refused(NULL, memory, CELLS, CTL_ERR_NULL, 0U);
    assert_refused(&p, NULL, CELLS, CTL_ERR_NULL, CTL_ILC_CELLS);
}

void test_ctl_ilc_init_rejects_too_few_or_too_many_cells(void)
{
    const ctl_ilc_params_t p = valid_params();

    assert_refused(&p, memory, 3U, CTL_ERR_MEMORY, CTL_ILC_CELLS);
    assert_refused(&p, memory, 4097U, CTL_ERR_MEMORY, CTL_ILC_CELLS);
}

void test_ctl_ilc_init_rejects_gain_lead_and_limit_out_of_range(void)
{
    const double gains[] = {-0.01, 100.5};
    for (size_t k = 0; k < COUNT_OF(gains); k++) {
        ctl_ilc_params_t p = valid_params();
        p.gain = num_of(gains[k]);
        assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_ILC_GAIN);
    }
    ctl_ilc_params_t p = valid_params();
    p.lead = CTL_ILC_LEAD_MAX + 1U;
    assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_ILC_LEAD);
    p = valid_params();
    p.limit = (num_t)0;
    assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_ILC_LIMIT);
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        p = valid_params();
        p.gain = NOT_FINITE[k];
        assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_ILC_GAIN);
        p = valid_params();
        p.limit = NOT_FINITE[k];
        assert_refused(&p, memory, CELLS, CTL_ERR_RANGE, CTL_ILC_LIMIT);
    }
}
