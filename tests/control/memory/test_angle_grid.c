/* control/memory/angle_grid.c: every grid point that a motion passes is visited once, read-out at any angle. */
#include "tests/support/numeric.h"

#include "control/memory/angle_grid.h"
#include "tests/control/golden/angle_grid.h"

#define CELLS 12U
#define GUARD 2U

static num_t      memory[4096U + GUARD];
static ctl_grid_t grid;

void setUp(void)
{
    for (size_t i = 0; i < COUNT_OF(memory); i++) {
        memory[i] = num_of(99.0);
    }
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, CELLS).status);
}

void tearDown(void)
{
    for (size_t i = 4096U; i < COUNT_OF(memory); i++) {
        ASSERT_NUM_WITHIN_AT(0.0, 99.0, memory[i], "written behind the memory");
    }
}

/* ---- read-out --------------------------------------------------------------------------------------------------- */

static void fill_golden(void)
{
    TEST_ASSERT_EQUAL_UINT32(CELLS, COUNT_OF(GOLDEN_GRID_CELLS));
    for (size_t i = 0; i < COUNT_OF(GOLDEN_GRID_CELLS); i++) {
        grid.cell[i] = num_of(GOLDEN_GRID_CELLS[i]);
    }
}

void test_ctl_grid_read_matches_golden(void)
{
    fill_golden();
    /* cells within +-4: float, rounding of the position and of up to four products; fixed, up to 3 steps a tap */
    const double bound_linear = per_numeric(1.5e-6, 8.0 * FIXED_STEP);
    const double bound_cubic = per_numeric(3.0e-6, 32.0 * FIXED_STEP);
    for (size_t i = 0; i < COUNT_OF(GOLDEN_GRID_READ); i++) {
        const angle_t     angle = GOLDEN_GRID_READ[i].angle;
        const char *const text = at("row %u", (unsigned)i);

        ASSERT_NUM_WITHIN_AT(bound_linear, GOLDEN_GRID_READ[i].linear, ctl_grid_read_linear(&grid, angle), text);
        ASSERT_NUM_WITHIN_AT(bound_cubic, GOLDEN_GRID_READ[i].cubic, ctl_grid_read_cubic(&grid, angle), text);
    }
}

void test_ctl_grid_read_at_a_point_is_its_cell(void)
{
    fill_golden();
    for (uint16_t i = 0; i < CELLS; i++) {
        /* 2^32 / 12 is not whole: the angle lies up to 12 steps below the point, 1e-8 of a cell */
        const angle_t angle = (angle_t)(((UINT64_C(0x100000000) * i) + CELLS - 1U) / CELLS);

        ASSERT_NUM_WITHIN_AT(per_numeric(1e-6, 4.0 * FIXED_STEP), GOLDEN_GRID_CELLS[i], ctl_grid_read_linear(&grid, angle),
                             at("point %u", i));
        ASSERT_NUM_WITHIN_AT(per_numeric(1e-6, 24.0 * FIXED_STEP), GOLDEN_GRID_CELLS[i], ctl_grid_read_cubic(&grid, angle),
                             at("point %u", i));
    }
}

void test_ctl_grid_read_of_a_constant_is_that_constant_everywhere(void)
{
    noise_t noise = {9U};
    for (uint16_t i = 0; i < CELLS; i++) {
        grid.cell[i] = num_of(-3.25);
    }
    for (uint32_t i = 0; i < 300U; i++) {
        const angle_t angle = noise_bits(&noise);

        ASSERT_NUM_WITHIN(0.0, -3.25, ctl_grid_read_linear(&grid, angle));
        ASSERT_NUM_WITHIN(per_numeric(2e-6, 20.0 * FIXED_STEP), -3.25, ctl_grid_read_cubic(&grid, angle));
    }
}

void test_ctl_grid_read_of_a_sine_has_the_error_of_its_interpolation(void)
{
    const uint16_t cells = 64U;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, cells).status);
    for (uint16_t i = 0; i < cells; i++) {
        grid.cell[i] = num_of(sin(TWO_PI * i / cells));
    }
    double worst_linear = 0.0;
    double worst_cubic = 0.0;
    for (uint32_t i = 0; i < 5000U; i++) {
        const angle_t angle = i * UINT32_C(858993);
        const double  want = sin(TWO_PI * (double)angle / TURN_STEPS);
        worst_linear = fmax(worst_linear, fabs(value_of(ctl_grid_read_linear(&grid, angle)) - want));
        worst_cubic = fmax(worst_cubic, fabs(value_of(ctl_grid_read_cubic(&grid, angle)) - want));
    }
    const double h = TWO_PI / cells;

    /* theory: h^2 / 8 and (9/16) h^4 / 24 of the highest derivative */
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * h * h / 8.0, h * h / 8.0, worst_linear);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * h * h * h * h * 3.0 / 128.0, h * h * h * h * 3.0 / 128.0, worst_cubic);
}

/* ---- walks -------------------------------------------------------------------------------------------------------- */

/* Position of an angle on the grid in cells, exact in double: 32 + 12 bits. */
static double position_of(angle_t angle, uint16_t cells) { return (double)angle * cells / TURN_STEPS; }

/* A walk must visit the points in (from, to], one by one, with the values of the straight line; nothing else. */
static uint16_t assert_walk(angle_t from, double v_from, angle_t to, double v_to, double bound)
{
    const uint16_t  cells = grid.cells;
    const int32_t   turn = (int32_t)(to - from);
    const bool      up = turn >= 0;
    const double    start = position_of(from, cells);
    const double    way = (double)turn * cells / TURN_STEPS;
    const double    end = start + way;
    double          next = up ? (floor(start) + 1.0) : (ceil(start) - 1.0);
    ctl_grid_walk_t walk = ctl_grid_walk(&grid, from, num_of(v_from), to, num_of(v_to));
    uint16_t        index = 0U;
    uint16_t        visited = 0U;
    num_t           value = (num_t)0;
    while (up ? (next <= end) : (next >= end)) {
        TEST_ASSERT_TRUE_MESSAGE(ctl_grid_walk_next(&walk, &index, &value), at("too early, from %u to %u", from, to));
        const int32_t want = ((int32_t)next + (2 * (int32_t)cells)) % (int32_t)cells;
        TEST_ASSERT_EQUAL_INT32_MESSAGE(want, index, at("from %u to %u", from, to));
        ASSERT_NUM_WITHIN_AT(bound, v_from + ((v_to - v_from) * (next - start) / way), value, at("from %u to %u", from, to));
        next += up ? 1.0 : -1.0;
        visited++;
    }
    TEST_ASSERT_FALSE_MESSAGE(ctl_grid_walk_next(&walk, &index, &value), at("too late, from %u to %u", from, to));
    return visited;
}

/* Header: values within +-2 are off by 3e-7 a point. Float rounds the running sum, fixed point cuts the slope. */
static double walk_bound(double points) { return 3e-7 * (points + 1.0); }

void test_ctl_grid_walk_visits_what_lies_between_two_angles_both_ways(void)
{
    noise_t               noise = {10U};
    static const uint16_t SIZES[] = {4U, 5U, 12U, 64U, 257U};
    for (size_t s = 0; s < COUNT_OF(SIZES); s++) {
        TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, SIZES[s]).status);
        for (uint32_t i = 0; i < 400U; i++) {
            const angle_t from = noise_bits(&noise);
            const angle_t step = noise_bits(&noise) >> (1U + noise_pick(&noise, 24U)); /* all sizes below half a turn */
            const double  v_from = 4.0 * noise_next(&noise);
            const double  v_to = 4.0 * noise_next(&noise);

            (void)assert_walk(from, v_from, from + step, v_to, walk_bound(SIZES[s] / 2.0));
            (void)assert_walk(from, v_from, from - step, v_to, walk_bound(SIZES[s] / 2.0));
        }
    }
}

void test_ctl_grid_walk_from_a_point_has_visited_it_and_to_a_point_includes_it(void)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, 8U).status);
    const angle_t cell = UINT32_C(0x20000000); /* 2^32 / 8: points are exact angles */

    TEST_ASSERT_EQUAL_UINT16(1U, assert_walk(cell, 0.0, 2U * cell, 1.0, 0.0));
    TEST_ASSERT_EQUAL_UINT16(1U, assert_walk(2U * cell, 0.0, cell, 1.0, 0.0));
    TEST_ASSERT_EQUAL_UINT16(0U, assert_walk(cell, 0.0, (2U * cell) - 1U, 1.0, 0.0));
    TEST_ASSERT_EQUAL_UINT16(0U, assert_walk(2U * cell, 0.0, cell + 1U, 1.0, 0.0));
    TEST_ASSERT_EQUAL_UINT16(1U, assert_walk((2U * cell) - 1U, 0.0, 2U * cell, 1.0, 0.0));
    TEST_ASSERT_EQUAL_UINT16(1U, assert_walk(cell + 1U, 0.0, cell, 1.0, 0.0));
    TEST_ASSERT_EQUAL_UINT16(1U, assert_walk(cell, 0.0, 0U, 1.0, 0.0)); /* from the first point down to 0 */

    /* 5 cells: steps of 5 parts of 2^32. 1717986918 steps end two parts below point 2, 858993459 from 1 one part below point 1 */
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, 5U).status);
    TEST_ASSERT_EQUAL_UINT16(1U, assert_walk(0U, 0.0, 1717986918U, 1.0, walk_bound(1.0)));
    TEST_ASSERT_EQUAL_UINT16(0U, assert_walk(1U, 0.0, 858993459U, 1.0, 0.0));
}

void test_ctl_grid_walk_across_zero_wraps_both_ways(void)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, 8U).status);
    const angle_t cell = UINT32_C(0x20000000);

    TEST_ASSERT_EQUAL_UINT16(1U, assert_walk((7U * cell) - 5U, 0.0, UINT32_MAX, 1.0, walk_bound(1.0))); /* 7 */
    TEST_ASSERT_EQUAL_UINT16(3U, assert_walk((7U * cell) - 5U, 0.0, cell, 1.0, walk_bound(3.0)));       /* 7, 0, 1 */
    TEST_ASSERT_EQUAL_UINT16(3U, assert_walk(cell + 5U, 0.0, 7U * cell, 1.0, walk_bound(3.0)));         /* 1, 0, 7 */
    TEST_ASSERT_EQUAL_UINT16(1U, assert_walk(0U, 0.0, 7U * cell, 1.0, 0.0));                            /* 0 was visited before */
}

void test_ctl_grid_walk_at_standstill_visits_nothing(void)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, 8U).status);

    TEST_ASSERT_EQUAL_UINT16(0U, assert_walk(0U, 1.0, 0U, 2.0, 0.0));
    TEST_ASSERT_EQUAL_UINT16(0U, assert_walk(UINT32_C(0x20000000), 1.0, UINT32_C(0x20000000), 2.0, 0.0));
    TEST_ASSERT_EQUAL_UINT16(0U, assert_walk(12345U, 1.0, 12345U, 2.0, 0.0));
}

void test_ctl_grid_walk_takes_the_shorter_way_round(void)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, 4U).status);

    TEST_ASSERT_TRUE(ctl_grid_walk(&grid, 0U, (num_t)0, UINT32_C(0x7FFFFFFF), (num_t)0).up);
    TEST_ASSERT_FALSE(ctl_grid_walk(&grid, 0U, (num_t)0, UINT32_C(0x80000001), (num_t)0).up);
    TEST_ASSERT_EQUAL_UINT16(1U, assert_walk(0U, 0.0, UINT32_C(0x7FFFFFFF), 1.0, walk_bound(2.0)));
    TEST_ASSERT_EQUAL_UINT16(2U, assert_walk(0U, 0.0, UINT32_C(0x80000000), 1.0, walk_bound(2.0))); /* half a turn: backwards */
}

void test_ctl_grid_walks_in_a_row_visit_every_passing_once(void)
{
    /* A motion forwards, slower, to a stop, back over the same points and across zero. Each passing of a point counts. */
    noise_t noise = {13U};
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, 32U).status);
    angle_t  angle = 123456789U;
    double   position = position_of(angle, 32U); /* not wrapped */
    uint32_t visits = 0U;
    uint32_t wanted = 0U;
    for (int i = 0; i < 600; i++) {
        const double  speed = 1.3 * cos(TWO_PI * i / 300.0) + 0.1 * noise_next(&noise); /* cells per sample */
        const int32_t step = ((i % 7) == 0) ? 0 : (int32_t)(speed / 32.0 * TURN_STEPS);
        visits += assert_walk(angle, 1.0, angle + (angle_t)step, -1.0, walk_bound(2.0));
        const double before = position;
        angle += (angle_t)step;
        position += (double)step * 32.0 / TURN_STEPS;
        wanted += (uint32_t)((step >= 0) ? (floor(position) - floor(before)) : (ceil(before) - ceil(position)));
    }

    TEST_ASSERT_EQUAL_UINT32(wanted, visits);
    TEST_ASSERT_GREATER_THAN_UINT32(300U, visits);
}

void test_ctl_grid_walk_in_the_largest_grid_stays_on_the_line(void)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, 4096U).status);

    /* 2048 points: the error grows with their number as stated in the header */
    TEST_ASSERT_EQUAL_UINT16(2047U, assert_walk(77U, -2.0, UINT32_C(0x7FFFFFFF), 2.0, walk_bound(2048.0)));
    TEST_ASSERT_EQUAL_UINT16(2048U, assert_walk(77U, -2.0, UINT32_C(0x80000077), 2.0, walk_bound(2048.0)));
}

/* The whole walk at once leaves in the cells what the walk visits, and the rest as it was: both ways, across the end, of any length. */
static void assert_write(angle_t from, angle_t to)
{
    static num_t before[72];
    for (uint16_t i = 0U; i < grid.cells; i++) {
        before[i] = grid.cell[i] = num_of(3.0 + (i / 128.0));
    }
    /* in cells times 2^32, whole numbers: a double of 32 bits would be off by more than the walk on a way of part of a cell */
    const int64_t one = INT64_C(0x100000000);
    const int64_t start = (int64_t)from * grid.cells;
    const int64_t way = (int64_t)(int32_t)(to - from) * grid.cells;
    const int32_t sign = (way >= 0) ? 1 : -1;
    int32_t       next = (int32_t)((sign > 0) ? ((start / one) + 1) : (((start + one - 1) / one) - 1));
    for (int64_t gone = (next * one) - start; (gone * sign) <= (way * sign); gone += sign * one) {
        before[(next + (2 * (int32_t)grid.cells)) % (int32_t)grid.cells] = num_of(-1.0 + (2.0 * (double)gone / (double)way));
        next += sign;
    }
    ctl_grid_write(&grid, from, num_of(-1.0), to, num_of(1.0));
    for (uint16_t i = 0U; i < grid.cells; i++) {
        ASSERT_NUM_WITHIN_AT(walk_bound(grid.cells / 2.0), value_of(before[i]), grid.cell[i],
                             at("%u cells, from %u to %u, cell %u", (unsigned)grid.cells, from, to, (unsigned)i));
    }
}

void test_ctl_grid_write_leaves_the_line_in_every_cell_that_it_passes_and_no_other(void)
{
    static const uint16_t SIZES[] = {4U, 7U, 12U, 64U};
    noise_t               noise = {15U};
    for (size_t s = 0; s < COUNT_OF(SIZES); s++) {
        TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, SIZES[s]).status);
        for (uint32_t i = 0; i < 200U; i++) {
            const angle_t from = noise_bits(&noise);
            const angle_t step = (noise_bits(&noise) | 1U) >> (1U + noise_pick(&noise, 4U));
            assert_write(from, from + step);
            assert_write(from, from - step);
        }
        memory[SIZES[s]] = num_of(99.0);
        assert_write(UINT32_MAX - 5U, 5U);
        assert_write(5U, UINT32_MAX - 5U);
        ASSERT_NUM_WITHIN_AT(0.0, 99.0, memory[SIZES[s]], "written behind the cells");
    }
}

/* ---- configuration -------------------------------------------------------------------------------------------------- */

void test_ctl_grid_fresh_and_cleared_reads_zero(void)
{
    ASSERT_NUM_WITHIN(0.0, 0.0, ctl_grid_read_cubic(&grid, 98765432U));
    fill_golden();

    ctl_grid_clear(&grid);

    for (uint16_t i = 0; i < CELLS; i++) {
        ASSERT_NUM_WITHIN(0.0, 0.0, memory[i]);
    }
    ASSERT_NUM_WITHIN_AT(0.0, 99.0, memory[CELLS], "cleared too much");
}

void test_ctl_grid_init_without_a_pointer_names_it(void)
{
    const ctl_grid_t before = grid;

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_grid_init(NULL, memory, CELLS));
    ASSERT_DIAG(CTL_ERR_NULL, CTL_GRID_MEMORY, 0.0, ctl_grid_init(&grid, NULL, CELLS));
    ASSERT_SAME_BITS(before, grid);
}

void test_ctl_grid_init_rejects_a_number_of_cells_out_of_range(void)
{
    static const uint16_t WRONG[] = {0U, 3U, 4097U, UINT16_MAX};
    const ctl_grid_t      before = grid;
    for (size_t i = 0; i < COUNT_OF(WRONG); i++) {
        const ctl_diag_t got = ctl_grid_init(&grid, memory, WRONG[i]);

        TEST_ASSERT_EQUAL(CTL_ERR_MEMORY, got.status);
        TEST_ASSERT_EQUAL_UINT16(CTL_GRID_CELLS, got.field);
        ASSERT_NUM_WITHIN(FIXED_STEP, fmin(fmin(WRONG[i], 32767.0), num_max_value()), got.given);
        ASSERT_SAME_BITS(before, grid);
        ASSERT_NUM_WITHIN(0.0, 99.0, memory[CELLS]);
    }
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, 4U).status);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_grid_init(&grid, memory, 4096U).status);
}

void test_ctl_grid_with_any_content_and_angle_reads_a_bounded_value(void)
{
    noise_t noise = {14U};
    for (uint32_t i = 0; i < 2000U; i++) {
        grid.cell[noise_pick(&noise, CELLS)] = (noise_pick(&noise, 2U) != 0U) ? NUM_MAX : -NUM_MAX;
        const angle_t angle = noise_bits(&noise);

        ASSERT_BOUNDED_AT(1.01 * num_max_value(), ctl_grid_read_linear(&grid, angle), at("turn %u", i));
        ASSERT_BOUNDED_AT(2.0 * num_max_value(), ctl_grid_read_cubic(&grid, angle), at("turn %u", i));
    }
}
