/* control/memory/kept_order.c: one order of a learned waveform and its neighbours stay as they were, the others are not touched. */
#include "tests/support/numeric.h"

#include "control/memory/kept_order.h"

#define CELLS 90U
#define MANY 2048U
#define GUARD 2U
#define ORDER 28U
#define LIMIT 2.0
#define PER_CALL 7U

static num_t            memory[CELLS + GUARD];
static num_t            many[MANY];
static ctl_grid_t       grid;
static ctl_kept_order_t kept;
static uint16_t         at_cell;

void setUp(void)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, CELLS).status);
    memory[CELLS] = num_of(99.0);
    memory[CELLS + 1U] = num_of(99.0);
    ctl_kept_order_clear(&kept);
    at_cell = 0U;
}

void tearDown(void)
{
    ASSERT_NUM_WITHIN_AT(0.0, 99.0, memory[CELLS], "written behind the memory");
    ASSERT_NUM_WITHIN_AT(0.0, 99.0, memory[CELLS + 1U], "written behind the memory");
}

static double wave(uint16_t i, double order, double size, double phase)
{
    return size * cos((order * TWO_PI * i / CELLS) + phase);
}

static void add(double order, double size, double phase)
{
    for (uint16_t i = 0U; i < CELLS; i++) {
        grid.cell[i] = num_of(value_of(grid.cell[i]) + wave(i, order, size, phase));
    }
}

/* Moves on by some turns, and calls on the way. */
static void go(uint16_t order, double turns, int way)
{
    const int calls = (int)((turns * CELLS) / PER_CALL);
    for (int k = 0; k < calls; k++) {
        at_cell = (uint16_t)((at_cell + CELLS + (unsigned)(way * (int)PER_CALL)) % CELLS);
        ctl_kept_order_step(&kept, &grid, order, at_cell, num_of(LIMIT));
    }
}

/* All calls until it is known. */
static void begin(uint16_t order)
{
    for (uint16_t k = 0U; k < CTL_KEPT_ORDERS; k++) {
        ctl_kept_order_step(&kept, &grid, order, at_cell, num_of(LIMIT));
        TEST_ASSERT_EQUAL_UINT16(((k + 1U) == CTL_KEPT_ORDERS) ? order : 0U, kept.known);
    }
}

/* Sums of CELLS products of two values within 1: some 1e-7 each in float, half a step each in fixed point. */
static double bound(void) { return per_numeric(2e-6, CELLS * FIXED_STEP); }

static void assert_wave(const char *text)
{
    for (uint16_t i = 0U; i < CELLS; i++) {
        const double want = 0.1 + wave(i, 12.0, 0.5, 0.7) + wave(i, ORDER, 0.2, 1.1) + wave(i, 27.0, 0.1, 0.3);
        ASSERT_NUM_WITHIN_AT(bound(), want, grid.cell[i], at("%s, cell %u", text, (unsigned)i));
    }
}

static void fill(void)
{
    add(0.0, 0.1, 0.0);
    add(12.0, 0.5, 0.7);
    add(27.0, 0.1, 0.3);
    add(ORDER, 0.2, 1.1);
}

void test_ctl_kept_order_takes_out_what_its_order_and_the_two_beside_it_have_gathered_once_a_turn_and_nothing_else(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        fill();
        begin(ORDER);
        TEST_ASSERT_EQUAL_UINT16(ORDER, kept.known);
        for (int turn = 0; turn < 20; turn++) {
            add(ORDER, 0.3, 0.4 * turn);
            add(ORDER - 1U, 0.2, 0.3 * turn);
            add(ORDER + 1U, 0.1, 0.2 * turn);
            go(ORDER, 1.2, way);
            assert_wave(at("way %d, turn %d", way, turn));
            go(ORDER, 0.85, way);
        }
    }
}

void test_ctl_kept_order_waits_for_a_whole_turn(void)
{
    fill();
    begin(ORDER);
    add(ORDER, 0.3, 0.0);
    const num_t before = grid.cell[0];

    go(ORDER, 0.9, 1);
    go(ORDER, 0.9, -1); /* to and fro is no turn */
    go(ORDER, 0.9, 1);

    ASSERT_NUM_WITHIN(0.0, value_of(before), grid.cell[0]);
    go(ORDER, 0.35, 1);
    assert_wave("after it");
}

void test_ctl_kept_order_of_another_order_begins_anew(void)
{
    fill();
    begin(20U);
    add(ORDER, -0.1, 1.1);
    begin(ORDER); /* from here on 0.1 is what is kept */
    add(ORDER, 0.1, 1.1);
    add(20.0, 0.05, 0.3);

    go(ORDER, 1.2, 1);

    add(20.0, -0.05, 0.3);
    add(ORDER, 0.1, 1.1);
    assert_wave("kept since the second one");
}

void test_ctl_kept_order_that_the_cells_cannot_hold_is_not_known_and_changes_nothing(void)
{
    static const uint16_t NONE[] = {0U, CELLS / 2U, CELLS, 1000U, UINT16_MAX};
    for (size_t k = 0; k < COUNT_OF(NONE); k++) {
        setUp();
        fill();
        begin(ORDER);
        go(NONE[k], 2.2, 1);

        TEST_ASSERT_EQUAL_UINT16(0U, kept.known);
        TEST_ASSERT_EQUAL_UINT16(0U, kept.order);
        assert_wave(at("order %u", (unsigned)NONE[k]));
    }
    TEST_ASSERT_TRUE(ctl_kept_order_fits(&grid, (CELLS / 2U) - 1U));
}

void test_ctl_kept_order_leaves_no_cell_beyond_the_limit(void)
{
    begin(ORDER);
    add(ORDER, 3.0, 0.0);
    for (uint16_t i = 0U; i < CELLS; i++) { /* cut, as learning leaves it: other orders come with it */
        grid.cell[i] = num_clamp(grid.cell[i], num_of(-LIMIT), num_of(LIMIT));
    }
    go(ORDER, 5.0, 1);
    for (uint16_t i = 0U; i < CELLS; i++) {
        TEST_ASSERT_TRUE(fabs(value_of(grid.cell[i])) <= LIMIT);
    }
}

/* What fixed point holds ends at 128, and a memory has up to 2048 cells. */
void test_ctl_kept_order_is_kept_with_any_number_of_cells(void)
{
    static const uint16_t CELLS_OF[] = {91U, 127U, 128U, 129U, 200U, 720U, MANY};
    for (size_t k = 0; k < COUNT_OF(CELLS_OF); k++) {
        const uint16_t cells = CELLS_OF[k];
        ctl_kept_order_clear(&kept);
        TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, many, cells).status);
        begin(5U);
        for (uint16_t i = 0U; i < cells; i++) { /* 12th order stays, 5th has been gathered */
            grid.cell[i] = num_of((0.5 * cos(TWO_PI * ((12U * i) % cells) / cells)) +
                                  (0.3 * cos((TWO_PI * ((5U * i) % cells) / cells) + 1.0)));
        }
        for (uint16_t moved = 0U; moved <= (2U * cells); moved = (uint16_t)(moved + (cells / 4U))) {
            ctl_kept_order_step(&kept, &grid, 5U, (uint16_t)((moved + (cells / 4U)) % cells), num_of(LIMIT));
        }
        /* each term of a sum is within half a step of a product and the error of a sine, and 2 / cells is cut to a step: 0.3 of cells / 2 */
        const double within = per_numeric(2e-6, (0.15 * cells * FIXED_STEP) + (cells * FIXED_STEP) + 1e-6);
        for (uint16_t i = 0U; i < cells; i++) {
            ASSERT_NUM_WITHIN_AT(within, 0.5 * cos(TWO_PI * ((12U * i) % cells) / cells), grid.cell[i],
                                 at("cell %u of %u", (unsigned)i, (unsigned)cells));
        }
    }
}

/* (1) of A cos(n theta + phi) = A cos(phi) cos(n theta) - A sin(phi) sin(n theta). */
void test_ctl_kept_order_knows_the_cosine_and_the_sine_of_the_wave_that_it_keeps(void)
{
    fill();
    begin(ORDER);
    ASSERT_NUM_WITHIN(bound(), 0.1 * cos(0.3), kept.a0[0]); /* ORDER - 1 */
    ASSERT_NUM_WITHIN(bound(), -0.1 * sin(0.3), kept.b0[0]);
    ASSERT_NUM_WITHIN(bound(), 0.2 * cos(1.1), kept.a0[1]);
    ASSERT_NUM_WITHIN(bound(), -0.2 * sin(1.1), kept.b0[1]);
    ASSERT_NUM_WITHIN(bound(), 0.0, kept.a0[2]);
    ASSERT_NUM_WITHIN(bound(), 0.0, kept.b0[2]);
}

/* From a cell on by equal steps: the turn is over in the third, and what it went further counts for the next. */
static void assert_third_step_ends_the_turn(uint16_t cells, int step, int further)
{
    const char *const text = at("%u cells by %d", (unsigned)cells, step);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, many, cells).status);
    ctl_kept_order_clear(&kept);
    at_cell = 40U;
    begin(5U);
    TEST_ASSERT_EQUAL_INT16_MESSAGE(0, kept.travel, text);
    for (int k = 1; k <= 3; k++) {
        at_cell = (uint16_t)(((int)at_cell + (int)cells + step) % (int)cells);
        ctl_kept_order_step(&kept, &grid, 5U, at_cell, num_of(LIMIT));
        TEST_ASSERT_EQUAL_INT16_MESSAGE((k < 3) ? (k * step) : further, kept.travel, text);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE((k < 3) ? 0U : (CTL_KEPT_ORDERS - 1U), kept.left, text); /* one of them in this call */
    }
}

/* Just below half a turn a step is still the shorter way round: 45 of 91 cells, 44 of 90. */
void test_ctl_kept_order_counts_cells_the_shorter_way_round_from_where_it_began(void)
{
    assert_third_step_ends_the_turn(91U, 45, 44);
    assert_third_step_ends_the_turn(91U, -45, -44);
    assert_third_step_ends_the_turn(90U, 44, 42);
    assert_third_step_ends_the_turn(90U, -44, -42);
    assert_third_step_ends_the_turn(90U, 30, 0); /* a turn to the cell */
    assert_third_step_ends_the_turn(90U, -30, 0);
}
