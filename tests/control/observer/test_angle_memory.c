/* control/observer/angle_memory.c: what a motion leaves in the memory, against a model that looks at the whole motion at
 * once; both directions, standstill, jumps, and everything that must not be learned. */
#include "tests/support/numeric.h"

#include "control/observer/angle_memory.h"
#include "tests/control/golden/angle_memory.h"

#define CELLS 64U /* points are exact angles */
#define CELL UINT32_C(0x04000000)
#define GUARD 2U

static num_t              cells[4096U + GUARD];
static ctl_angle_memory_t memory;

static ctl_angle_memory_params_t valid_params(void)
{
    const ctl_angle_memory_params_t p = {
        .gain = num_of(0.5), .forgetting = num_of(1.0), .write = CTL_WRITE_ONE, .read = CTL_READ_LINEAR, .limit = num_of(100.0)};
    return p;
}

static void start(const ctl_angle_memory_params_t *p, uint16_t count)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_angle_memory_init(&memory, p, cells, count).status);
}

static void start_writing(ctl_write_t write)
{
    ctl_angle_memory_params_t p = valid_params();
    p.write = write;
    start(&p, CELLS);
}

static void see(angle_t angle, double v) { ctl_angle_memory_write(&memory, angle, num_of(v), memory.params.gain); }

/* Where, in cells. */
static angle_t place(double position) { return (angle_t)(int64_t)llround(position * CELL); }

static double cell(int i) { return value_of(cells[(i + (int)CELLS) % (int)CELLS]); }

/* All points but those in [from, to] hold that value. */
static void assert_others_hold(double value, int from, int to)
{
    for (int i = 0; i < (int)CELLS; i++) {
        if (((i - from + (int)CELLS) % (int)CELLS) > (to - from)) {
            TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(value, cell(i), at("point %d", i));
        }
    }
}

/* A content that shows every change. */
static void fill(double (*f)(int))
{
    for (int i = 0; i < (int)CELLS; i++) {
        cells[i] = num_of(f(i));
    }
}
static double marks(int i) { return (0.25 * i) - 3.0; }

void setUp(void)
{
    for (size_t i = 0; i < COUNT_OF(cells); i++) {
        cells[i] = num_of(99.0);
    }
    start_writing(CTL_WRITE_ONE);
}

void tearDown(void)
{
    for (size_t i = 4096U; i < COUNT_OF(cells); i++) {
        ASSERT_NUM_WITHIN_AT(0.0, 99.0, cells[i], "written behind the memory");
    }
}

/* ---- golden ---------------------------------------------------------------------------------------------------------- */

static void assert_golden(uint16_t count, ctl_write_t write, const double *golden, uint32_t writes)
{
    ctl_angle_memory_params_t p = valid_params();
    p.gain = num_of(0.375);
    p.forgetting = num_of(0.9375);
    p.write = write;
    start(&p, count);
    noise_t values = {61U};
    noise_t steps = {62U};
    angle_t angle = 0U;
    for (size_t row = 0; row < COUNT_OF(GOLDEN_AM_PATH); row++) {
        const golden_am_path_t *const part = &GOLDEN_AM_PATH[row];
        for (uint16_t k = 0; (part->cells == count) && (k < part->samples); k++) {
            if (part->jitter != 0U) {
                angle += (noise_bits(&steps) >> (32U - part->jitter)) - ((UINT32_C(1) << part->jitter) >> 1);
            }
            angle += part->step;
            see(angle, 4.0 * noise_next(&values));
        }
    }

    TEST_ASSERT_EQUAL_UINT32(writes, memory.state.written);
    TEST_ASSERT_EQUAL_UINT32(0U, memory.state.rejected);
    for (uint16_t i = 0; i < count; i++) {
        /* values within +-2: a point of a walk is off by 3e-7 for each before it, a short average by 4 half steps; past
         * errors fade with 9/16 a write */
        ASSERT_NUM_WITHIN_AT(per_numeric(1.5e-6, 1.5e-6), golden[i], cells[i],
                             at("way of writing %d, point %u of %u", (int)write, i, count));
    }
}

void test_ctl_angle_memory_writing_one_matches_golden(void)
{
    assert_golden(60U, CTL_WRITE_ONE, GOLDEN_AM_ROUGH_ONE, GOLDEN_AM_ROUGH_ONE_WRITES);
    assert_golden(64U, CTL_WRITE_ONE, GOLDEN_AM_EXACT_ONE, GOLDEN_AM_EXACT_ONE_WRITES);
}

void test_ctl_angle_memory_writing_all_matches_golden(void)
{
    assert_golden(60U, CTL_WRITE_ALL, GOLDEN_AM_ROUGH_ALL, GOLDEN_AM_ROUGH_ALL_WRITES);
    assert_golden(64U, CTL_WRITE_ALL, GOLDEN_AM_EXACT_ALL, GOLDEN_AM_EXACT_ALL_WRITES);
}

void test_ctl_angle_memory_writing_hats_matches_golden(void)
{
    assert_golden(60U, CTL_WRITE_HAT, GOLDEN_AM_ROUGH_HAT, GOLDEN_AM_ROUGH_HAT_WRITES);
    assert_golden(64U, CTL_WRITE_HAT, GOLDEN_AM_EXACT_HAT, GOLDEN_AM_EXACT_HAT_WRITES);
}

/* ---- which points ---------------------------------------------------------------------------------------------------- */

void test_ctl_angle_memory_learns_the_straight_line_at_the_point_passed(void)
{
    see(place(4.75), 1.0);
    see(place(5.75), 3.0);

    TEST_ASSERT_EQUAL_DOUBLE(0.5 * 1.5, cell(5)); /* a quarter of the way from 1 to 3 */
    assert_others_hold(0.0, 5, 5);
}

void test_ctl_angle_memory_first_sample_teaches_nothing(void)
{
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        start_writing((ctl_write_t)w);

        see(place(7.0), 5.0);

        assert_others_hold(0.0, 0, -1);
        TEST_ASSERT_EQUAL_UINT32(0U, memory.state.written);
    }
}

void test_ctl_angle_memory_writing_one_writes_only_the_newest_point_passed(void)
{
    see(place(4.5), 1.0);
    see(place(8.5), 5.0);
    TEST_ASSERT_EQUAL_DOUBLE(0.5 * 4.5, cell(8));
    assert_others_hold(0.0, 8, 8);

    see(place(3.5), 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(per_numeric(3e-7, 4.0 * FIXED_STEP), 0.5 * 0.5, cell(4)); /* 3e-7 a point of the walk */
    TEST_ASSERT_EQUAL_DOUBLE(0.5 * 4.5, cell(8));
    TEST_ASSERT_EQUAL_UINT32(2U, memory.state.written);
}

void test_ctl_angle_memory_writing_all_writes_every_point_passed(void)
{
    start_writing(CTL_WRITE_ALL);
    see(place(62.5), 1.0);

    see(place(66.5), 5.0); /* 63, 0, 1, 2: over the end of the turn */

    for (int i = 0; i < 4; i++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.5 * (1.5 + i), cell(63 + i));
    }
    assert_others_hold(0.0, 63, 66);
    TEST_ASSERT_EQUAL_UINT32(4U, memory.state.written);
}

void test_ctl_angle_memory_landing_on_a_point_writes_it_and_leaving_it_does_not(void)
{
    static const ctl_write_t WAYS[] = {CTL_WRITE_ONE, CTL_WRITE_ALL};
    for (size_t w = 0; w < COUNT_OF(WAYS); w++) {
        for (int up = 0; up < 2; up++) {
            start_writing(WAYS[w]);
            const double away = (up != 0) ? 0.75 : -0.75;
            see(place(20.0 - away), 1.0);
            see(place(20.0), 2.0);
            TEST_ASSERT_EQUAL_DOUBLE(0.5 * 2.0, cell(20));

            see(place(20.0 + away), 3.0);
            see(place(20.0 + (away / 3.0)), 3.0);

            TEST_ASSERT_EQUAL_DOUBLE(0.5 * 2.0, cell(20));
            assert_others_hold(0.0, 20, 20);
        }
    }
}

void test_ctl_angle_memory_reversal_writes_the_point_once_for_each_passing(void)
{
    for (int w = 0; w < 2; w++) {
        start_writing((ctl_write_t)w);
        see(place(9.5), 4.0);
        see(place(10.5), 4.0); /* 2 */
        see(place(10.75), 8.0);
        see(place(10.25), 8.0); /* turned round between the points: nothing */
        TEST_ASSERT_EQUAL_DOUBLE(2.0, cell(10));

        see(place(9.75), 4.0); /* the middle of 8 and 4 */

        TEST_ASSERT_EQUAL_DOUBLE(2.0 + (0.5 * (6.0 - 2.0)), cell(10));
        assert_others_hold(0.0, 10, 10);
        TEST_ASSERT_EQUAL_UINT32(2U, memory.state.written);
    }
}

void test_ctl_angle_memory_at_standstill_learns_nothing(void)
{
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        start_writing((ctl_write_t)w);
        see(place(30.25), 1.0);
        for (int k = 0; k < 1000; k++) {
            see(place(30.25), 1.0 + (k % 5));
        }
        for (int k = 0; k < 1000; k++) {
            see(place(30.5), 7.0);
        }

        assert_others_hold(0.0, 0, -1);
        TEST_ASSERT_EQUAL_UINT32(0U, memory.state.written);
    }
}

void test_ctl_angle_memory_opposite_values_leave_the_opposite(void)
{
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        noise_t noise = {63U};
        num_t   other_cells[CELLS];
        start_writing((ctl_write_t)w);
        ctl_angle_memory_t other = memory;
        TEST_ASSERT_EQUAL(CTL_OK, ctl_angle_memory_init(&other, &memory.params, other_cells, CELLS).status);
        angle_t angle = 0U;
        for (int k = 0; k < 2000; k++) {
            const double v = noise_next(&noise);
            angle += noise_bits(&noise) >> 6;
            see(angle, v);
            ctl_angle_memory_write(&other, angle, num_of(-v), other.params.gain);
        }
        for (uint16_t i = 0; i < CELLS; i++) {
            /* half steps round up, whatever their sign */
            TEST_ASSERT_DOUBLE_WITHIN(per_numeric(0.0, 16.0 * FIXED_STEP), -cell(i), value_of(other_cells[i]));
        }
    }
}

/* ---- hats ------------------------------------------------------------------------------------------------------------ */

void test_ctl_angle_memory_hat_is_the_average_weighted_with_nearness(void)
{
    start_writing(CTL_WRITE_HAT);
    static const struct {
        double at, v;
    } SEEN[] = {{8.75, 9.0}, {9.25, 1.0}, {9.5, 2.0}, {10.25, 3.0}, {10.75, 4.0}};
    for (size_t i = 0; i < COUNT_OF(SEEN); i++) {
        see(place(SEEN[i].at), SEEN[i].v);
    }
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * FIXED_STEP, 0.5 * ((9.0 * 0.75) + (1.0 * 0.75) + (2.0 * 0.5)) / 2.0, cell(9));

    see(place(11.25), 7.0); /* point 10 is complete */

    const double average = ((1.0 * 0.25) + (2.0 * 0.5) + (3.0 * 0.75) + (4.0 * 0.25)) / 1.75;
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * FIXED_STEP, 0.5 * average, cell(10));
    assert_others_hold(0.0, 9, 10);
}

void test_ctl_angle_memory_hat_without_a_sample_near_the_point_is_the_straight_line(void)
{
    start_writing(CTL_WRITE_HAT);
    see(place(2.5), 1.0);
    see(place(7.5), 6.0); /* over 3 to 7; 3 and 7 have a sample half a cell away */

    for (int i = 4; i <= 6; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(per_numeric(6e-7, 6.0 * FIXED_STEP), 0.5 * (1.5 + (i - 3)), cell(i));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.5 * 1.0, cell(3));
    assert_others_hold(0.0, 3, 6);
}

void test_ctl_angle_memory_hat_writes_every_point_passed_at_any_speed(void)
{
    /* cells per sample in eighths, up to 15 7/8 */
    for (int speed = -127; speed <= 127; speed++) {
        for (int from = 0; from < 8; from++) {
            const int samples = 6 + (512 / (((speed < 0) ? -speed : speed) + 1));
            start_writing(CTL_WRITE_HAT);
            ctl_angle_memory_params_t p = memory.params;
            p.gain = num_of(1.0);
            start(&p, CELLS);
            fill(marks);
            for (int k = 0; k <= samples; k++) {
                see(place((from + (speed * k)) / 8.0), 50.0);
            }
            /* points between the first and the last sample, less those that may wait for more samples near them; a
             * landing exactly on a point from above passes it with the next step */
            const double way = fmin(fabs(samples * speed / 8.0), 63.0);
            const int    low = (int)ceil((speed > 0) ? (from / 8.0) : ((from / 8.0) - way)) + ((speed > 0) ? 1 : 2);
            const int    high = (int)floor((speed > 0) ? ((from / 8.0) + way) : (from / 8.0)) - 1;
            for (int i = low; i <= high; i++) {
                ASSERT_DOUBLE_WITHIN_AT(per_numeric(1e-5, 50.0 * 8.0 * FIXED_STEP), 50.0, cell(i),
                                        at("speed %d/8, from %d/8, point %d", speed, from, i));
            }
        }
    }
}

void test_ctl_angle_memory_hat_beside_a_point_that_is_not_passed_leaves_it_alone(void)
{
    /* up to half a cell beyond 20 and back: 21 was near, but never passed */
    start_writing(CTL_WRITE_HAT);
    fill(marks);
    for (int k = 0; k <= 200; k++) {
        see(place(18.5 + (2.0 * sin(TWO_PI * k / 400.0))), 9.0);
    }
    for (int k = 0; k <= 80; k++) {
        see(place(18.5 - (k / 40.0)), 9.0);
    }

    for (int i = 0; i < (int)CELLS; i++) {
        const bool touched = (i >= 18) && (i <= 20);
        if (!touched) {
            TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(marks(i), cell(i), at("point %d", i));
        } else {
            TEST_ASSERT_TRUE_MESSAGE(cell(i) > marks(i), at("point %d", i));
        }
    }
}

void test_ctl_angle_memory_hat_standing_on_a_point_with_rounding_noise_leaves_its_neighbours_alone(void)
{
    /* the motor stands, and once in a while the last bit of the encoder changes */
    start_writing(CTL_WRITE_HAT);
    fill(marks);
    for (int k = 0; k < 5000; k++) {
        see(place(40.0 + (((k / 50) % 2 == 0) ? 0.02 : -0.02)), 9.0);
    }

    for (int i = 0; i < (int)CELLS; i++) {
        if (i != 40) {
            TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(marks(i), cell(i), at("point %d", i));
        }
    }
}

void test_ctl_angle_memory_hat_averages_the_noise_that_one_sample_would_keep(void)
{
    double rms[2] = {0.0, 0.0};
    for (int hat = 0; hat < 2; hat++) {
        noise_t noise = {65U};
        start_writing((hat != 0) ? CTL_WRITE_HAT : CTL_WRITE_ONE);
        ctl_angle_memory_params_t p = memory.params;
        p.gain = num_of(1.0);
        start(&p, CELLS);
        for (int k = 0; k < (int)CELLS * 24 * 2; k++) {
            see(place(k / 24.0 + 0.01), noise_next(&noise));
        }
        for (int i = 0; i < (int)CELLS; i++) {
            rms[hat] += cell(i) * cell(i) / CELLS;
        }
    }

    /* 48 samples of white noise under a hat: sum w^2 / (sum w)^2 = 16/24^2 of the variance; one: 2/3 to 1 of it. So a
     * 30th within the scatter of 64 points (25 %) */
    TEST_ASSERT_DOUBLE_WITHIN(0.015, 1.0 / 30.0, rms[1] / rms[0]);
}

void test_ctl_angle_memory_hat_of_a_constant_is_that_constant_however_slow_and_large(void)
{
    static const double VALUES[] = {0.001, -2.0, 20.0, -60.0};
    for (size_t v = 0; v < COUNT_OF(VALUES); v++) {
        start_writing(CTL_WRITE_HAT);
        ctl_angle_memory_params_t p = memory.params;
        p.gain = num_of(1.0);
        start(&p, CELLS);
        for (int k = 0; k < 2000; k++) {
            see(place(50.5 + (k / 500.0)), VALUES[v]);
        }

        for (int i = 51; i <= 53; i++) {
            /* 500 sums, each rounded: float to 2^-24 of the sum, fixed to a step */
            ASSERT_DOUBLE_WITHIN_AT(per_numeric(1.5e-5 * fabs(VALUES[v]), 16.0 * FIXED_STEP), VALUES[v], cell(i),
                                    at("value %g, point %d", VALUES[v], i));
        }
    }
}

/* ---- gain, forgetting, limit ----------------------------------------------------------------------------------------- */

/* `passes` turns forwards or backwards at a third of a cell a sample, where the shape is seen. */
static void turn(int passes, int direction, double (*shape)(double))
{
    for (int k = 0; k <= passes * (int)CELLS * 3; k++) {
        const double position = direction * k / 3.0;
        see(place(position + 0.1), shape(position + 0.1));
        ctl_angle_memory_update_quality(&memory);
    }
}
static double constant(double position)
{
    (void)position;
    return 2.0;
}
static double ripple(double position) { return sin(TWO_PI * 2.0 * position / CELLS); }

void test_ctl_angle_memory_error_falls_by_1_minus_gain_every_pass(void)
{
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        for (int direction = -1; direction <= 1; direction += 2) {
            for (int passes = 1; passes < 8; passes++) {
                ctl_angle_memory_params_t p = valid_params();
                p.write = (ctl_write_t)w;
                p.gain = num_of(0.25);
                start(&p, CELLS);

                turn(passes, direction, constant);

                for (int i = 3; i < (int)CELLS - 3; i++) { /* those near the seam are one pass ahead or behind */
                    ASSERT_DOUBLE_WITHIN_AT(per_numeric(2e-6, 12.0 * FIXED_STEP), 2.0 * (1.0 - pow(0.75, passes)), cell(i),
                                            at("way of writing %d, pass %d, point %d", w, passes, i));
                }
            }
        }
    }
}

void test_ctl_angle_memory_with_forgetting_rests_below_what_it_sees(void)
{
    ctl_angle_memory_params_t p = valid_params();
    p.gain = num_of(0.25);
    p.forgetting = num_of(0.75);
    start(&p, CELLS);

    turn(60, 1, constant);

    /* m = q m + g (v - m)  ->  m = v g / (1 - q + g) */
    assert_others_hold(cell(5), 0, -1);
    TEST_ASSERT_DOUBLE_WITHIN(per_numeric(5e-7, 4.0 * FIXED_STEP), 2.0 * 0.25 / 0.5, cell(5));
}

void test_ctl_angle_memory_in_the_end_reads_the_waveform_it_saw_whatever_the_way(void)
{
    const double h = TWO_PI * 2.0 / CELLS; /* of the ripple, per cell */
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        for (int r = 0; r <= (int)CTL_READ_CUBIC; r++) {
            for (int direction = -1; direction <= 1; direction += 2) {
                ctl_angle_memory_params_t p = valid_params();
                p.write = (ctl_write_t)w;
                p.read = (ctl_read_t)r;
                start(&p, CELLS);

                turn(24, direction, ripple);

                double worst = 0.0;
                for (int k = 0; k < (int)CELLS * 10; k++) {
                    worst = fmax(worst, fabs(value_of(ctl_angle_memory_read(&memory, place(k / 10.0))) - ripple(k / 10.0)));
                }
                /* lines between samples a third of a cell apart lose up to h^2 / 72, a hat of three a side some h^2 / 12;
                 * reading on a line another h^2 / 8 */
                const double theory =
                    (((w == (int)CTL_WRITE_HAT) ? (1.0 / 12.0) : (1.0 / 81.0)) + ((r == 0) ? 0.125 : 0.0)) * h * h;
                ASSERT_DOUBLE_WITHIN_AT(0.2 * theory, theory, worst, at("write %d, read %d, direction %d", w, r, direction));
            }
        }
    }
}

void test_ctl_angle_memory_takes_the_gain_of_the_call_within_0_and_1(void)
{
    static const struct {
        double given, used;
    } GAINS[] = {{0.0, 0.0}, {0.125, 0.125}, {1.0, 1.0}, {1.5, 1.0}, {-0.5, 0.0}};
    for (size_t i = 0; i < COUNT_OF(GAINS); i++) {
        start_writing(CTL_WRITE_ONE);
        ctl_angle_memory_write(&memory, place(1.5), num_of(4.0), num_of(GAINS[i].given));
        ctl_angle_memory_write(&memory, place(2.5), num_of(4.0), num_of(GAINS[i].given));

        TEST_ASSERT_EQUAL_DOUBLE(4.0 * GAINS[i].used, cell(2));
    }
}

void test_ctl_angle_memory_contents_stay_within_the_limit(void)
{
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            ctl_angle_memory_params_t p = valid_params();
            p.write = (ctl_write_t)w;
            p.limit = num_of(1.5);
            start(&p, CELLS);
            for (int k = 0; k < 3 * (int)CELLS; k++) {
                see(place(k + 0.5), sign * 50.0);
            }

            for (int i = 0; i < (int)CELLS; i++) {
                TEST_ASSERT_EQUAL_DOUBLE(sign * 1.5, cell(i));
            }
        }
    }
}

/* ---- reading --------------------------------------------------------------------------------------------------------- */

static double cubic(int i)
{
    const double x = (i - 30) / 8.0;
    return 0.5 - (0.75 * x) + (0.25 * x * x) + (0.125 * x * x * x);
}

void test_ctl_angle_memory_reads_a_straight_line_or_a_cubic_between_points(void)
{
    ctl_angle_memory_params_t p = valid_params();
    p.read = CTL_READ_CUBIC;
    start(&p, CELLS);
    fill(cubic);
    for (int k = 8; k < 8 * (int)(CELLS - 2U); k++) {
        const double position = k / 8.0;
        const double x = (position - 30.0) / 8.0;
        const double whole = 0.5 - (0.75 * x) + (0.25 * x * x) + (0.125 * x * x * x);
        const double part = position - floor(position);
        const double line = ((1.0 - part) * cubic((int)position)) + (part * cubic((int)position + 1));

        memory.params.read = CTL_READ_CUBIC;
        /* contents up to 20: four products, each rounded */
        ASSERT_NUM_WITHIN(per_numeric(2e-5, 80.0 * FIXED_STEP), whole, ctl_angle_memory_read(&memory, place(position)));
        memory.params.read = CTL_READ_LINEAR;
        ASSERT_NUM_WITHIN(per_numeric(4e-6, 4.0 * FIXED_STEP), line, ctl_angle_memory_read(&memory, place(position)));
    }
}

void test_ctl_angle_memory_reading_changes_nothing(void)
{
    noise_t noise = {66U};
    fill(marks);
    const ctl_angle_memory_t before = memory;
    for (int k = 0; k < 100; k++) {
        (void)ctl_angle_memory_read(&memory, noise_bits(&noise));
    }

    ASSERT_SAME_BITS(before, memory);
}

/* ---- cost and quality -------------------------------------------------------------------------------------------------- */

void test_ctl_angle_memory_writing_one_costs_one_write_a_sample_whatever_the_number_of_cells(void)
{
    static const uint16_t COUNTS[] = {4U, 200U, 720U, 4096U};
    for (size_t c = 0; c < COUNT_OF(COUNTS); c++) {
        ctl_angle_memory_params_t p = valid_params();
        start(&p, COUNTS[c]);
        for (uint32_t k = 0; k < 3000U; k++) {
            const uint32_t before = memory.state.written;
            see(k * UINT32_C(71582788), 1.0); /* a 60th of a turn: 68 points of 4096 */

            TEST_ASSERT_TRUE(memory.state.written <= (before + 1U));
        }
    }
}

void test_ctl_angle_memory_writing_all_costs_the_points_passed_and_one_at_most(void)
{
    for (int w = (int)CTL_WRITE_ALL; w <= (int)CTL_WRITE_HAT; w++) {
        ctl_angle_memory_params_t p = valid_params();
        p.write = (ctl_write_t)w;
        start(&p, 4096U);
        for (uint32_t k = 0; k < 3000U; k++) {
            const uint32_t before = memory.state.written;
            see(k * UINT32_C(71582788), 1.0); /* 68.27 points */

            TEST_ASSERT_TRUE(memory.state.written <= (before + 70U));
        }
        TEST_ASSERT_UINT32_WITHIN(70U, (uint32_t)(2999.0 * 4096.0 / 60.0), memory.state.written);
    }
}

void test_ctl_angle_memory_news_falls_as_the_waveform_is_learned(void)
{
    start_writing(CTL_WRITE_ALL);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(memory.state.change));
    turn(2, 1, ripple);
    const double early = value_of(memory.state.change);
    turn(20, 1, ripple);

    TEST_ASSERT_TRUE(early > 0.1);
    TEST_ASSERT_TRUE(value_of(memory.state.change) < (0.01 * early));
    TEST_ASSERT_TRUE(value_of(memory.state.change) >= 0.0);
}

void test_ctl_angle_memory_news_is_the_mean_size_of_what_is_new(void)
{
    start_writing(CTL_WRITE_ONE);
    for (int k = 0; k < 1500; k++) {
        ctl_angle_memory_write(&memory, place(k), num_of((k & 1) ? -3.0 : 3.0), (num_t)0); /* learns nothing: all stays new */
        ctl_angle_memory_update_quality(&memory);
    }

    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 3.0, value_of(memory.state.change));
}

void test_ctl_angle_memory_after_a_skipped_sample_goes_on_along_a_line_from_it(void)
{
    start_writing(CTL_WRITE_ONE);
    see(place(0.5), 1.0);
    ctl_angle_memory_skip(&memory, place(2.5), num_of(3.0)); /* points 1 and 2 are passed and not learned */
    see(place(3.5), 5.0);

    TEST_ASSERT_EQUAL_UINT32(1U, memory.state.written);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, cell(2));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 4.0 * value_of(memory.params.gain), cell(3));
}

void test_ctl_angle_memory_after_a_skipped_sample_hats_and_all_points_begin_again(void)
{
    for (int w = (int)CTL_WRITE_ALL; w <= (int)CTL_WRITE_HAT; w++) {
        start_writing((ctl_write_t)w);
        see(place(0.5), 1.0);
        ctl_angle_memory_skip(&memory, place(0.9), num_of(3.0));
        see(place(1.5), 5.0);

        TEST_ASSERT_EQUAL_UINT32(0U, memory.state.written);
    }
}

/* ---- what must not be learned ------------------------------------------------------------------------------------------ */

void test_ctl_angle_memory_jump_of_a_quarter_turn_or_more_teaches_nothing_and_is_counted(void)
{
    static const uint32_t JUMPS[] = {ANGLE_QUARTER, ANGLE_QUARTER + 1U, UINT32_C(0x60000000), UINT32_C(0x7FFFFFFF),
                                     UINT32_C(0x80000000)};
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        for (size_t j = 0; j < COUNT_OF(JUMPS); j++) {
            for (int up = 0; up < 2; up++) {
                start_writing((ctl_write_t)w);
                fill(marks);
                see(place(10.25), 1.0);

                see((up != 0) ? (place(10.25) + JUMPS[j]) : (place(10.25) - JUMPS[j]), 2.0);

                TEST_ASSERT_EQUAL_UINT32_MESSAGE(1U, memory.state.rejected, at("jump %u, up %d", JUMPS[j], up));
                TEST_ASSERT_EQUAL_UINT32(0U, memory.state.written);
                for (int i = 0; i < (int)CELLS; i++) {
                    TEST_ASSERT_EQUAL_DOUBLE(marks(i), cell(i));
                }
            }
        }
    }
}

void test_ctl_angle_memory_step_just_below_a_quarter_turn_is_a_motion(void)
{
    for (int up = 0; up < 2; up++) {
        start_writing(CTL_WRITE_ALL);
        see(place(32.5), 1.0);

        see((up != 0) ? (place(32.5) + (ANGLE_QUARTER - 1U)) : (place(32.5) - (ANGLE_QUARTER - 1U)), 1.0);

        TEST_ASSERT_EQUAL_UINT32(0U, memory.state.rejected);
        TEST_ASSERT_EQUAL_UINT32(16U, memory.state.written);
    }
}

void test_ctl_angle_memory_goes_on_from_where_a_jump_led(void)
{
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        start_writing((ctl_write_t)w);
        see(place(9.9), 50.0);
        see(place(40.5), 2.0);
        for (int k = 1; k < 12; k++) {
            see(place(40.5 + (k / 4.0)), 2.0);
        }

        for (int i = 41; i <= 42; i++) {
            TEST_ASSERT_DOUBLE_WITHIN(per_numeric(1e-6, 4.0 * FIXED_STEP), 0.5 * 2.0, cell(i));
        }
        assert_others_hold(0.0, 41, 43);
    }
}

void test_ctl_angle_memory_value_or_gain_that_is_not_finite_teaches_nothing_and_is_counted(void)
{
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
            start_writing((ctl_write_t)w);
            fill(marks);
            see(place(10.5), 1.0);
            const ctl_angle_memory_t before = memory;

            ctl_angle_memory_write(&memory, place(11.5), NOT_FINITE[i], num_of(0.5));
            ctl_angle_memory_write(&memory, place(11.5), num_of(1.0), NOT_FINITE[i]);

            TEST_ASSERT_EQUAL_UINT32(2U, memory.state.rejected);
            memory.state.rejected = 0U;
            ASSERT_SAME_BITS(before, memory);
            for (int c = 0; c < (int)CELLS; c++) {
                TEST_ASSERT_EQUAL_DOUBLE(marks(c), cell(c));
            }
        }
    }
}

void test_ctl_angle_memory_interpolates_over_a_sample_that_was_not_finite(void)
{
    see(place(4.5), 1.0);
    ctl_angle_memory_write(&memory, place(5.0), NOT_FINITE[0], num_of(0.5));
    see(place(5.5), 3.0);

    TEST_ASSERT_EQUAL_DOUBLE(0.5 * 2.0, cell(5));
}

void test_ctl_angle_memory_counter_stops_at_its_end(void)
{
    memory.state.rejected = UINT32_MAX;

    ctl_angle_memory_write(&memory, 0U, NOT_FINITE[0], num_of(0.5));
    see(0U, 1.0);
    see(UINT32_C(0x80000000), 1.0);

    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, memory.state.rejected);
}

void test_ctl_angle_memory_pause_keeps_the_contents_and_forgets_the_last_sample(void)
{
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        start_writing((ctl_write_t)w);
        fill(marks);
        see(place(10.5), 1.0);
        see(place(10.75), 1.0);

        ctl_angle_memory_pause(&memory);
        see(place(11.25), 1.0);

        for (int i = 0; i < (int)CELLS; i++) {
            TEST_ASSERT_EQUAL_DOUBLE(marks(i), cell(i));
        }
        TEST_ASSERT_EQUAL_UINT32(0U, memory.state.written);
        TEST_ASSERT_EQUAL_UINT32(0U, memory.state.rejected);
    }
}

void test_ctl_angle_memory_clear_forgets_everything_but_the_count_of_refusals(void)
{
    start_writing(CTL_WRITE_HAT);
    turn(2, 1, constant);
    ctl_angle_memory_write(&memory, 0U, NOT_FINITE[0], num_of(0.5));

    ctl_angle_memory_clear(&memory);

    assert_others_hold(0.0, 0, -1);
    TEST_ASSERT_EQUAL_UINT32(0U, memory.state.written);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(memory.state.change));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(memory.state.innovation));
    TEST_ASSERT_EQUAL_UINT32(1U, memory.state.rejected);
    see(place(5.5), 1.0); /* no sample before it */
    see(place(5.75), 1.0);
    TEST_ASSERT_EQUAL_UINT32(0U, memory.state.written);
}

void test_ctl_angle_memory_stays_within_its_limit_and_memory_whatever_comes(void)
{
    noise_t noise = {67U};
    for (int w = 0; w <= (int)CTL_WRITE_HAT; w++) {
        for (int r = 0; r <= (int)CTL_READ_CUBIC; r++) {
            ctl_angle_memory_params_t p = valid_params();
            p.write = (ctl_write_t)w;
            p.read = (ctl_read_t)r;
            p.limit = num_of(2.0);
            start(&p, CELLS);
            angle_t angle = 0U;
            for (int k = 0; k < 5000; k++) {
                angle += noise_bits(&noise) >> noise_pick(&noise, 32U);
                angle -= noise_bits(&noise) >> noise_pick(&noise, 32U);
                ctl_angle_memory_write(&memory, angle, noise_nasty(&noise), noise_nasty(&noise));

                /* a cubic between points that alternate reaches 1.25 times them */
                ASSERT_BOUNDED_AT((r == 0) ? 2.000001 : 2.500001, ctl_angle_memory_read(&memory, noise_bits(&noise)),
                                  at("sample %d", k));
            }
            for (int i = 0; i < (int)CELLS; i++) {
                TEST_ASSERT_TRUE(fabs(cell(i)) <= 2.0);
            }
            TEST_ASSERT_TRUE(memory.state.written > 100U);
            ASSERT_NUM_WITHIN(0.0, 99.0, cells[CELLS]);
        }
    }
}

/* ---- configuration ------------------------------------------------------------------------------------------------------ */

static void assert_rejected(const ctl_angle_memory_params_t *p, num_t *room, uint16_t count, ctl_status_t status, uint16_t field)
{
    see(place(5.5), 1.0);
    see(place(6.5), 1.0);
    const ctl_angle_memory_t before = memory;
    const double             learned = cell(6);

    const ctl_diag_t got = ctl_angle_memory_init(&memory, p, room, count);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(before, memory);
    TEST_ASSERT_EQUAL_DOUBLE(learned, cell(6));
}

void test_ctl_angle_memory_init_rejects_a_number_of_cells_of_zero_or_beyond_its_room(void)
{
    static const uint16_t           WRONG[] = {0U, 1U, 3U, 4097U, UINT16_MAX};
    const ctl_angle_memory_params_t p = valid_params();
    for (size_t i = 0; i < COUNT_OF(WRONG); i++) {
        assert_rejected(&p, cells, WRONG[i], CTL_ERR_MEMORY, CTL_AM_CELLS);
    }
    start(&p, 4U);
    start(&p, 4096U);
}

void test_ctl_angle_memory_init_rejects_a_gain_outside_of_its_range(void)
{
    static const double WRONG[] = {0.0, -0.1, 1.0001, 2.0};
    for (size_t i = 0; i < COUNT_OF(WRONG); i++) {
        ctl_angle_memory_params_t p = valid_params();
        p.gain = num_of(WRONG[i]);
        assert_rejected(&p, cells, CELLS, CTL_ERR_RANGE, CTL_AM_GAIN);
    }
    ctl_angle_memory_params_t p = valid_params();
    p.gain = num_of(1.0);
    start(&p, CELLS);
}

void test_ctl_angle_memory_init_rejects_a_forgetting_factor_outside_of_its_range(void)
{
    static const double WRONG[] = {-0.001, 1.0001, 2.0};
    for (size_t i = 0; i < COUNT_OF(WRONG); i++) {
        ctl_angle_memory_params_t p = valid_params();
        p.forgetting = num_of(WRONG[i]);
        assert_rejected(&p, cells, CELLS, CTL_ERR_RANGE, CTL_AM_FORGETTING);
    }
    ctl_angle_memory_params_t p = valid_params();
    p.forgetting = (num_t)0;
    start(&p, CELLS);
}

void test_ctl_angle_memory_init_rejects_a_limit_that_leaves_nothing(void)
{
    ctl_angle_memory_params_t p = valid_params();
    p.limit = (num_t)0;
    assert_rejected(&p, cells, CELLS, CTL_ERR_RANGE, CTL_AM_LIMIT);
    p.limit = num_of(-1.0);
    assert_rejected(&p, cells, CELLS, CTL_ERR_RANGE, CTL_AM_LIMIT);
}

void test_ctl_angle_memory_init_rejects_what_is_not_finite_in_every_field(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        ctl_angle_memory_params_t p = valid_params();
        p.gain = NOT_FINITE[i];
        assert_rejected(&p, cells, CELLS, CTL_ERR_RANGE, CTL_AM_GAIN);
        p = valid_params();
        p.forgetting = NOT_FINITE[i];
        assert_rejected(&p, cells, CELLS, CTL_ERR_RANGE, CTL_AM_FORGETTING);
        p = valid_params();
        p.limit = NOT_FINITE[i];
        assert_rejected(&p, cells, CELLS, CTL_ERR_RANGE, CTL_AM_LIMIT);
    }
}

void test_ctl_angle_memory_init_rejects_an_unknown_way_of_writing_or_reading(void)
{
    ctl_angle_memory_params_t p = valid_params();
    p.write = (ctl_write_t)(CTL_WRITE_HAT + 1);
    assert_rejected(&p, cells, CELLS, CTL_ERR_RANGE, CTL_AM_WRITE);
    p = valid_params();
    p.read = (ctl_read_t)(CTL_READ_CUBIC + 1);
    assert_rejected(&p, cells, CELLS, CTL_ERR_RANGE, CTL_AM_READ);
}

void test_ctl_angle_memory_init_without_a_pointer_says_so(void)
{
    const ctl_angle_memory_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_angle_memory_init(NULL, &p, cells, CELLS));
    assert_rejected(NULL, cells, CELLS, CTL_ERR_NULL, 0U);
    assert_rejected(&p, NULL, CELLS, CTL_ERR_NULL, CTL_AM_CELLS);
}

void test_ctl_angle_memory_init_clears_the_cells_and_nothing_behind_them(void)
{
    const ctl_angle_memory_params_t p = valid_params();
    fill(marks);
    cells[8] = num_of(77.0);

    start(&p, 8U);

    for (int i = 0; i < 8; i++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, cell(i));
    }
    TEST_ASSERT_EQUAL_DOUBLE(77.0, cell(8));
}

/* A low-pass over 100 calls: a hundredth of the way to the size of the innovation. */
void test_ctl_angle_memory_mean_size_of_the_innovation_takes_a_hundredth_of_the_new_one_a_call(void)
{
    memory.state.innovation = num_of(-2.0);
    memory.state.change = num_of(1.0);
    ctl_angle_memory_update_quality(&memory);
    ASSERT_NUM_WITHIN(per_numeric(2e-7, 2.0 * FIXED_STEP), 1.01, memory.state.change);
}

void test_ctl_angle_memory_pause_leaves_no_half_gathered_point_on_either_side(void)
{
    start_writing(CTL_WRITE_HAT);
    see(place(5.25), 1.0);
    see(place(5.5), 1.0);
    TEST_ASSERT_TRUE((memory.state.below.weight > (num_t)0) && (memory.state.above.weight > (num_t)0));
    ctl_angle_memory_pause(&memory);
    const ctl_hat_t hat[] = {memory.state.below, memory.state.above};
    for (size_t k = 0; k < COUNT_OF(hat); k++) {
        TEST_ASSERT_TRUE((hat[k].weight == (num_t)0) && (hat[k].sum == (num_t)0) && !hat[k].passed);
    }
    TEST_ASSERT_FALSE(memory.state.primed);
}

/* What is skipped is where the next sample comes from: 9.5 of 64 cells. */
void test_ctl_angle_memory_skip_knows_the_place_of_the_sample_that_was_not_written(void)
{
    see(place(2.5), 1.0);
    ctl_angle_memory_skip(&memory, place(9.5), num_of(0.75));
    TEST_ASSERT_TRUE(memory.state.primed);
    TEST_ASSERT_EQUAL_UINT16(9U, memory.state.position.below);
    TEST_ASSERT_EQUAL_UINT32(0x80000000U, memory.state.position.inside);
    ASSERT_NUM_WITHIN(0.0, 0.75, memory.state.value);
}
