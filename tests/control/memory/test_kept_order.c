/* control/memory/kept_order.c: one order of a learned waveform stays as it was, the others are not touched. */
#include "tests/support/numeric.h"

#include "control/memory/kept_order.h"

#define CELLS 90U
#define GUARD 2U
#define ORDER 28U
#define LIMIT 2.0
#define PER_CALL 7U

static num_t            memory[CELLS + GUARD];
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

void test_ctl_kept_order_takes_out_what_its_order_has_gathered_once_a_turn_and_nothing_else(void)
{
    for (int way = -1; way <= 1; way += 2) {
        setUp();
        fill();
        ctl_kept_order_step(&kept, &grid, ORDER, at_cell, num_of(LIMIT));
        TEST_ASSERT_EQUAL_UINT16(ORDER, kept.known);
        for (int turn = 0; turn < 20; turn++) {
            add(ORDER, 0.3, 0.4 * turn);
            go(ORDER, 1.2, way);
            assert_wave(at("way %d, turn %d", way, turn));
            go(ORDER, 0.85, way);
        }
    }
}

void test_ctl_kept_order_waits_for_a_whole_turn(void)
{
    fill();
    ctl_kept_order_step(&kept, &grid, ORDER, at_cell, num_of(LIMIT));
    add(ORDER, 0.3, 0.0);
    const num_t before = grid.cell[0];

    go(ORDER, 0.9, 1);
    go(ORDER, 0.9, -1); /* to and fro is no turn */
    go(ORDER, 0.9, 1);

    ASSERT_NUM_WITHIN(0.0, value_of(before), grid.cell[0]);
    go(ORDER, 0.2, 1);
    assert_wave("after it");
}

void test_ctl_kept_order_of_another_order_begins_anew(void)
{
    fill();
    ctl_kept_order_step(&kept, &grid, 27U, at_cell, num_of(LIMIT));
    add(ORDER, -0.1, 1.1);
    ctl_kept_order_step(&kept, &grid, ORDER, at_cell, num_of(LIMIT)); /* from here on 0.1 is what is kept */
    add(ORDER, 0.1, 1.1);
    add(27.0, 0.05, 0.3);

    go(ORDER, 1.2, 1);

    add(27.0, -0.05, 0.3);
    add(ORDER, 0.1, 1.1);
    assert_wave("kept since the second one");
}

void test_ctl_kept_order_that_the_cells_cannot_hold_is_not_known_and_changes_nothing(void)
{
    static const uint16_t NONE[] = {0U, CELLS / 2U, CELLS, 1000U, UINT16_MAX};
    for (size_t k = 0; k < COUNT_OF(NONE); k++) {
        setUp();
        fill();
        ctl_kept_order_step(&kept, &grid, ORDER, at_cell, num_of(LIMIT));
        go(NONE[k], 2.2, 1);

        TEST_ASSERT_EQUAL_UINT16(0U, kept.known);
        TEST_ASSERT_EQUAL_UINT16(0U, kept.order);
        assert_wave(at("order %u", (unsigned)NONE[k]));
    }
    TEST_ASSERT_TRUE(ctl_kept_order_fits(&grid, (CELLS / 2U) - 1U));
}

void test_ctl_kept_order_leaves_no_cell_beyond_the_limit(void)
{
    ctl_kept_order_step(&kept, &grid, ORDER, at_cell, num_of(LIMIT));
    add(ORDER, 3.0, 0.0);
    for (uint16_t i = 0U; i < CELLS; i++) { /* cut, as learning leaves it: other orders come with it */
        grid.cell[i] = num_clamp(grid.cell[i], num_of(-LIMIT), num_of(LIMIT));
    }
    go(ORDER, 5.0, 1);
    for (uint16_t i = 0U; i < CELLS; i++) {
        TEST_ASSERT_TRUE(fabs(value_of(grid.cell[i])) <= LIMIT);
    }
}
