/* control/repetitive/repetitive.c: CRC, FORC and fal-FORC against a non-causal two-history recursion; the three kinds of
 * memory; learning freeze; every wrong parameter and every wrong signal. */
#include "tests/support/numeric.h"

#include "control/repetitive/repetitive.h"
#include "tests/control/golden/repetitive.h"

#define CAPACITY 128U
#define GUARD 4U

static num_t    memory[4096U + GUARD];
static ctl_rc_t rc;

/* FORC of the paper with a pure delay for Q, so that what comes out is what went in. */
static ctl_rc_params_t valid_params(void)
{
    const ctl_rc_params_t p = {
        .gain = num_of(0.5),
        .lead = 3U,
        .q = {.side = (num_t)0, .centre = num_of(1.0)},
        .order = 2U,
        .truncate = true,
        .fal_at = CTL_RC_FAL_NONE,
        .fal = {.alpha = num_of(0.6), .delta = num_of(0.4)},
        .memory = CTL_RC_KEEP,
        .limit = num_of(100.0),
        .freeze_above = (num_t)0,
        .freeze_samples = 0U,
    };
    return p;
}

static void start(const ctl_rc_params_t *p) { TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&rc, p, memory, CAPACITY).status); }

static ctl_period_t period_of(double samples)
{
    const ctl_period_t n = {(uint16_t)floor(samples), num_of(samples - floor(samples))};
    return n;
}

static angle_t turns(double t) { return (angle_t)(int64_t)llround((t - floor(t)) * TURN_STEPS); }

/* One sample without an angle. */
static double step(double err, double samples) { return value_of(ctl_rc_step(&rc, num_of(err), period_of(samples), 0U)); }

/* `count` samples without an error. */
static void wait(uint16_t count, double samples)
{
    for (uint16_t k = 0; k < count; k++) {
        (void)step(0.0, samples);
    }
}

void setUp(void)
{
    for (size_t i = 0; i < COUNT_OF(memory); i++) {
        memory[i] = num_of(99.0);
    }
    const ctl_rc_params_t p = valid_params();
    start(&p);
}

void tearDown(void)
{
    for (size_t i = 4096U; i < COUNT_OF(memory); i++) {
        ASSERT_NUM_WITHIN_AT(0.0, 99.0, memory[i], "written behind the memory");
    }
}

/* ---- golden --------------------------------------------------------------------------------------------------------- */

void test_ctl_rc_matches_golden(void)
{
    double closest_call = 0.0; /* error over bound */
    for (size_t i = 0; i < COUNT_OF(GOLDEN_RC); i++) {
        const golden_rc_t *const g = &GOLDEN_RC[i];
        ctl_rc_params_t          p = valid_params();
        p.gain = num_of(g->gain);
        p.lead = g->lead;
        p.q.side = num_of(g->side);
        p.q.centre = num_of(g->centre);
        p.q.side2 = num_of(g->side2);
        p.order = g->order;
        p.truncate = g->truncate;
        p.fal_at = (ctl_rc_fal_at_t)g->fal_at;
        p.fal.alpha = num_of(g->alpha);
        p.fal.delta = num_of(g->delta);
        start(&p);
        double largest = 0.0;
        for (uint16_t k = 0; k < g->samples / g->stride; k++) {
            largest = fmax(largest, fabs(g->u[k]));
        }
        const double bound = per_numeric(1e-6 * largest, 5e-6); /* header of repetitive.h */
        noise_t      noise = {41U};
        uint16_t     part = 0U;
        for (uint16_t k = 0; k < g->samples; k++) {
            part = (uint16_t)(((part < 2U) && (k >= g->period[part + 1U].first)) ? part + 1U : part);
            const ctl_period_t n = {g->period[part].whole, num_of(g->period[part].fraction)};

            const num_t u = ctl_rc_step(&rc, num_of(4.0 * noise_next(&noise)), n, 0U);

            if ((k % g->stride) == 0U) {
                ASSERT_NUM_WITHIN_AT(bound, g->u[k / g->stride], u, at("%s, sample %u", g->name, k));
                closest_call = fmax(closest_call, fabs(value_of(u) - g->u[k / g->stride]) / bound);
            }
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.45, 0.55, closest_call); /* not suddenly ten times better than the header says, either */
}

/* ---- delay and lead --------------------------------------------------------------------------------------------------- */

/* Sample at which the answer to an error of 1 at sample 0 first comes out. */
static int answer_to_an_impulse(double samples, double *answer)
{
    *answer = step(1.0, samples);
    int k = 0;
    while ((*answer == 0.0) && (k < 200)) {
        *answer = step(0.0, samples);
        k++;
    }
    return k;
}

void test_ctl_rc_answers_one_period_less_the_lead_after_the_error(void)
{
    for (uint16_t lead = 0; lead <= CTL_RC_LEAD_MAX; lead++) {
        ctl_rc_params_t p = valid_params();
        double          answer = 0.0;
        p.lead = lead;
        start(&p);

        TEST_ASSERT_EQUAL_INT_MESSAGE(40 - lead, answer_to_an_impulse(40.0, &answer), at("lead %u", lead));
        TEST_ASSERT_EQUAL_DOUBLE(0.5, answer);
    }
}

void test_ctl_rc_without_new_errors_repeats_itself_every_period(void)
{
    double answer = 0.0;
    (void)answer_to_an_impulse(40.0, &answer);
    for (int n = 0; n < 5; n++) {
        for (int k = 1; k < 40; k++) {
            TEST_ASSERT_EQUAL_DOUBLE(0.0, step(0.0, 40.0));
        }
        TEST_ASSERT_EQUAL_DOUBLE(0.5, step(0.0, 40.0));
    }
}

void test_ctl_rc_adds_up_what_it_learns_from_a_constant_error(void)
{
    for (int k = 0; k < 40 - 3; k++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, step(1.0, 40.0));
    }
    for (int n = 1; n < 8; n++) {
        for (int k = 0; k < 40; k++) {
            TEST_ASSERT_EQUAL_DOUBLE(0.5 * n, step(1.0, 40.0));
        }
    }
}

void test_ctl_rc_order_0_cuts_or_rounds_the_period(void)
{
    static const struct {
        double samples;
        int    truncated, nearest;
    } CASES[] = {{48.0, 48, 48},    {48.4, 48, 48},    {48.5, 48, 49}, {48.86, 48, 49},
                 {48.9990, 48, 49}, {48.9996, 49, 49}, {49.1, 49, 49}};
    for (size_t i = 0; i < COUNT_OF(CASES); i++) {
        ctl_rc_params_t p = valid_params();
        double          answer = 0.0;
        p.order = 0U;
        p.lead = 0U;
        p.truncate = true;
        start(&p);
        TEST_ASSERT_EQUAL_INT_MESSAGE(CASES[i].truncated, answer_to_an_impulse(CASES[i].samples, &answer),
                                      at("N = %g", CASES[i].samples));
        p.truncate = false;
        start(&p);
        TEST_ASSERT_EQUAL_INT_MESSAGE(CASES[i].nearest, answer_to_an_impulse(CASES[i].samples, &answer),
                                      at("N = %g", CASES[i].samples));
    }
}

void test_ctl_rc_order_above_0_uses_the_fraction_whatever_truncate_says(void)
{
    for (uint16_t order = 1; order <= 3U; order++) {
        ctl_rc_params_t p = valid_params();
        p.order = order;
        start(&p);
        ctl_rc_t other = rc;
        num_t    other_memory[CAPACITY];
        p.truncate = false;
        TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&other, &p, other_memory, CAPACITY).status);
        noise_t noise = {42U};
        for (int k = 0; k < 200; k++) {
            const num_t e = num_of(noise_next(&noise));
            const num_t u = ctl_rc_step(&rc, e, period_of(20.625), 0U);

            TEST_ASSERT_TRUE(u == ctl_rc_step(&other, e, period_of(20.625), 0U));
        }
    }
}

void test_ctl_rc_period_just_below_a_whole_number_is_that_number(void)
{
    double answer = 0.0;

    TEST_ASSERT_EQUAL_INT(40 - 3, answer_to_an_impulse(39.9997, &answer));
    TEST_ASSERT_EQUAL_DOUBLE(0.5, answer); /* all of it in one sample */
    setUp();
    TEST_ASSERT_EQUAL_INT(39 - 3, answer_to_an_impulse(39.9985, &answer));
}

/* A plant that only delays by the lead, a disturbance with a period of N samples: largest error of the last periods. */
static double error_left(double samples, int periods)
{
    const uint16_t lead = rc.params.lead;
    double         past[CTL_RC_LEAD_MAX + 1U] = {0.0};
    double         worst = 0.0;
    for (int k = 0; k < (int)(periods * samples); k++) {
        const double e = sin(TWO_PI * k / samples) - past[k % lead]; /* the correction of `lead` samples ago */
        past[k % lead] = step(e, samples);
        worst = (k > (periods - 3) * samples) ? fmax(worst, fabs(e)) : worst;
    }
    return worst;
}

/* What (1) leaves of a disturbance with period `whole` + `fraction` in that loop: |1 - D| / |1 - (1 - k_rc) D|. */
static double error_left_in_theory(uint16_t order, double gain, double whole, double fraction)
{
    const double w = TWO_PI / (whole + fraction);
    double       re = 0.0;
    double       im = 0.0;
    const double from = (order == 3U) ? -1.0 : 0.0; /* four points: two on either side */
    for (int k = 0; k <= (int)order; k++) {
        double tap = 1.0;
        for (int i = 0; i <= (int)order; i++) {
            tap *= (i != k) ? ((fraction - from - i) / (k - i)) : 1.0;
        }
        re += tap * cos(w * (whole + from + k));
        im -= tap * sin(w * (whole + from + k));
    }
    return hypot(1.0 - re, im) / hypot(1.0 - ((1.0 - gain) * re), (1.0 - gain) * im);
}

/* Q = 1 and no error to learn from: what is in the memory may only fade, whatever its frequency. With three of four points behind the
 * place, noise grew by 1.05 per turn at a third of the sampling rate. */
void test_ctl_rc_order_3_amplifies_no_frequency(void)
{
    for (int part = 0; part < 8; part++) {
        ctl_rc_params_t p = valid_params();
        p.order = 3U;
        start(&p);
        noise_t noise = {61U};
        double  first = 0.0;
        double  last = 0.0;
        for (int k = 0; k < 24 * 200; k++) {
            const double u = step((k < 20) ? noise_next(&noise) : 0.0, 24.0 + part / 8.0);
            first += ((k >= 24) && (k < 72)) ? u * u : 0.0;
            last += (k >= 24 * 198) ? u * u : 0.0;
        }
        TEST_ASSERT_TRUE_MESSAGE((first > 0.1) && (last < 1.001 * first),
                                 at("fraction %d of 8: %.4g after %.4g", part, last, first));
    }
}

void test_ctl_rc_leaves_of_a_fractional_period_what_the_order_of_interpolation_leaves(void)
{
    double before = 2.0;
    for (uint16_t order = 0; order <= 3U; order++) {
        ctl_rc_params_t p = valid_params();
        p.order = order;
        start(&p);

        const double left = error_left(24.5, 40);

        /* 0.25, 0.016, 0.0021, 0.00034; the sine is met up to 0.2 % beside its peak, and sums of 1 are rounded */
        const double want = error_left_in_theory(order, 0.5, 24.0, 0.5);
        ASSERT_DOUBLE_WITHIN_AT((0.005 * want) + 2e-6, want, left, at("order %u", order));
        TEST_ASSERT_TRUE_MESSAGE(left < 0.2 * before, at("order %u", order));
        before = left;
    }
}

void test_ctl_rc_with_a_whole_period_removes_the_disturbance_in_every_order(void)
{
    for (uint16_t order = 0; order <= 3U; order++) {
        ctl_rc_params_t p = valid_params();
        p.order = order;
        start(&p);

        ASSERT_DOUBLE_WITHIN_AT(2e-6, 0.0, error_left(24.0, 40), at("order %u", order)); /* some roundings of 1 */
    }
}

/* ---- fal -------------------------------------------------------------------------------------------------------------- */

void test_ctl_rc_with_fal_at_the_input_learns_fal_of_the_error(void)
{
    ctl_rc_params_t p = valid_params();
    double          answer = 0.0;
    p.fal_at = CTL_RC_FAL_INPUT;
    start(&p);

    TEST_ASSERT_EQUAL_DOUBLE(0.0, step(32.0, 40.0));
    wait(36U, 40.0);
    answer = step(0.0, 40.0);

    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.5 * pow(32.0, 0.6), answer); /* 2e-6 relative (float), absolute (fixed) of 8 */
}

void test_ctl_rc_with_fal_at_the_output_learns_the_error_and_scales_the_answer(void)
{
    ctl_rc_params_t p = valid_params();
    p.fal_at = CTL_RC_FAL_OUTPUT;
    start(&p);

    (void)step(32.0, 40.0);
    wait(36U, 40.0);
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, 16.0 * pow(0.4, -0.4), step(0.0, 40.0)); /* error 0 now: the steepest slope */
    wait(39U, 40.0);
    TEST_ASSERT_DOUBLE_WITHIN(5e-5, 16.0 * pow(32.0, -0.4), step(32.0, 40.0)); /* the same memory, seen with a large error */
}

void test_ctl_rc_without_fal_does_not_look_at_its_parameters(void)
{
    ctl_rc_params_t p = valid_params();
    p.fal.alpha = NOT_FINITE[0];
    p.fal.delta = num_of(-1.0);

    start(&p);
}

/* ---- change of the period ---------------------------------------------------------------------------------------------- */

/* Learn an impulse with one period, wait until it came out and was remembered again, then run with another period:
 * the number of samples until it comes out next, or 0 when it never does. */
static int impulse_survives(double first, double second)
{
    double answer = 0.0;
    (void)answer_to_an_impulse(first, &answer);
    int k = 0;
    do {
        answer = step(0.0, second);
        k++;
    } while ((fabs(answer) < 0.1) && (k < 100));
    return (k < 100) ? k : 0;
}

void test_ctl_rc_keep_plays_the_old_memory_with_the_new_delay(void)
{
    TEST_ASSERT_EQUAL_INT(30, impulse_survives(40.0, 30.0));
    setUp();
    TEST_ASSERT_EQUAL_INT(10, impulse_survives(40.0, 50.0)); /* what was learned 40 samples ago is only 50 - 40 away */
    for (int k = 11; k < 50; k++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, step(0.0, 50.0));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.5, step(0.0, 50.0));
}

void test_ctl_rc_clear_forgets_when_the_period_changes(void)
{
    ctl_rc_params_t p = valid_params();
    p.memory = CTL_RC_CLEAR;
    start(&p);
    TEST_ASSERT_EQUAL_INT(0, impulse_survives(40.0, 41.0));
    start(&p);
    TEST_ASSERT_EQUAL_INT(0, impulse_survives(40.0, 39.0));
    start(&p);
    TEST_ASSERT_EQUAL_INT(0, impulse_survives(40.25, 40.375));
}

void test_ctl_rc_clear_forgets_nothing_when_the_period_changes_by_a_sixteenth_sample_at_most(void)
{
    static const double PAIRS[][2] = {{40.0, 40.0}, {40.0, 40.0625}, {40.5, 40.4375}, {40.0, 39.96875}, {39.96875, 40.015625}};
    ctl_rc_params_t     p = valid_params();
    p.memory = CTL_RC_CLEAR;
    for (size_t i = 0; i < COUNT_OF(PAIRS); i++) {
        start(&p);

        TEST_ASSERT_GREATER_THAN_INT_MESSAGE(0, impulse_survives(PAIRS[i][0], PAIRS[i][1]), at("pair %u", (unsigned)i));
    }
}

void test_ctl_rc_clear_in_order_0_looks_at_whole_samples_only(void)
{
    ctl_rc_params_t p = valid_params();
    p.memory = CTL_RC_CLEAR;
    p.order = 0U;
    start(&p);
    TEST_ASSERT_EQUAL_INT(40, impulse_survives(40.1, 40.9));
    start(&p);
    TEST_ASSERT_EQUAL_INT(0, impulse_survives(40.9, 41.1));
}

void test_ctl_rc_clear_learns_again_after_a_change(void)
{
    ctl_rc_params_t p = valid_params();
    double          answer = 0.0;
    p.memory = CTL_RC_CLEAR;
    start(&p);
    (void)answer_to_an_impulse(40.0, &answer);

    TEST_ASSERT_EQUAL_INT(27, answer_to_an_impulse(30.0, &answer));
    TEST_ASSERT_EQUAL_DOUBLE(0.5, answer);
}

/* ---- memory over the angle ----------------------------------------------------------------------------------------------- */

static ctl_rc_params_t angle_params(void)
{
    ctl_rc_params_t p = valid_params();
    p.memory = CTL_RC_ANGLE;
    return p;
}

static void start_angle(const ctl_rc_params_t *p, uint16_t cells)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&rc, p, memory, cells).status);
}

void test_ctl_rc_angle_with_a_cell_per_sample_is_a_whole_delay_in_both_directions(void)
{
    static num_t other_memory[CAPACITY];
    for (int direction = -1; direction <= 1; direction += 2) {
        for (uint16_t order = 0; order <= 2U; order += 2U) {
            ctl_rc_params_t p = angle_params();
            ctl_rc_t        time_based;
            noise_t         noise = {43U};
            p.q.side = num_of(0.25);
            p.q.centre = num_of(0.5);
            p.order = order;
            start_angle(&p, 64U);
            p.memory = CTL_RC_KEEP;
            p.order = 0U;
            TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&time_based, &p, other_memory, CAPACITY).status);
            for (int k = 0; k < 600; k++) {
                const num_t   e = num_of((k > 3) ? noise_next(&noise) : 0.0); /* the first samples have no angle to go to yet */
                const angle_t theta = (angle_t)((int64_t)direction * k * 0x4000000);

                const num_t u = ctl_rc_step(&rc, e, period_of(64.0), theta);
                const num_t v = ctl_rc_step(&time_based, e, period_of(64.0), 0U);

                /* order 2 weighs four cells with taps that are off by 3 steps; values up to 2 */
                const double bound = per_numeric(2e-6, (order == 0U) ? FIXED_STEP : 60.0 * FIXED_STEP);
                ASSERT_NUM_WITHIN_AT(bound, value_of(v), u, at("direction %d, order %u, sample %d", direction, order, k));
            }
        }
    }
}

/* The same disturbance over the angle at two speeds; largest error in the first turn after the change. */
static double error_after_a_speed_change(double first, double second)
{
    const uint16_t lead = rc.params.lead;
    double         past[CTL_RC_LEAD_MAX + 1U] = {0.0};
    double         position = 0.0;
    double         worst = 0.0;
    const int      change = (int)(30.0 * first);
    for (int k = 0; k < change + (int)second; k++) {
        const double n = (k < change) ? first : second;
        const double e = sin(TWO_PI * position) - past[k % lead];
        past[k % lead] = value_of(ctl_rc_step(&rc, num_of(e), period_of(n), turns(position)));
        worst = (k > change + (int)lead) ? fmax(worst, fabs(e)) : worst;
        position += 1.0 / n;
    }
    return worst;
}

void test_ctl_rc_angle_knows_at_one_speed_what_it_learned_at_another(void)
{
    ctl_rc_params_t p = angle_params();
    start_angle(&p, 128U);
    const double by_angle = error_after_a_speed_change(60.3, 40.7);
    p.memory = CTL_RC_KEEP;
    start(&p);
    const double by_time = error_after_a_speed_change(60.3, 40.7);

    /* left is the phase of `lead` samples at the other speed: 2 pi 3 (1/40.7 - 1/60.3) = 0.15 */
    TEST_ASSERT_DOUBLE_WITHIN(0.005, 0.1505, by_angle);
    TEST_ASSERT_TRUE(by_time > 1.0);
}

void test_ctl_rc_angle_converges_at_a_fractional_period(void)
{
    for (uint16_t order = 1; order <= 2U; order++) {
        ctl_rc_params_t p = angle_params();
        p.order = order;
        start_angle(&p, 128U);
        const double left = error_after_a_speed_change(48.86, 48.86);

        /* The straight line between two samples leaves (2 pi / 48.86)^2 / 8 of the disturbance, linear read-out of 128
         * cells (2 pi / 128)^2 / 8 over the gain; the scatter is that of the samples against the cells. */
        const double want = (pow(TWO_PI / 48.86, 2.0) / 8.0) + ((order == 1U) ? pow(TWO_PI / 128.0, 2.0) / 8.0 / 0.5 : 0.0);
        ASSERT_DOUBLE_WITHIN_AT(1.5e-4, want, left, at("order %u", order));
    }
}

void test_ctl_rc_angle_filters_with_the_angle_of_one_sample(void)
{
    static const double PERIODS[] = {8.75, 20.25, 48.859375};
    for (size_t i = 0; i < COUNT_OF(PERIODS); i++) {
        ctl_rc_params_t p = angle_params();
        p.q.side = num_of(0.25);
        p.q.centre = num_of(0.5);
        start_angle(&p, 128U);
        for (uint16_t c = 0; c < 128U; c++) {
            memory[c] = num_of(sin(TWO_PI * c / 128.0));
        }

        const num_t y = ctl_rc_step(&rc, (num_t)0, period_of(PERIODS[i]), turns(0.2));

        /* cubic read-out of a sine of 128 points is off by 1.4e-7 */
        const double gain = 0.5 + (0.5 * cos(TWO_PI / PERIODS[i]));
        ASSERT_NUM_WITHIN_AT(1e-6, gain * sin(TWO_PI * 0.2), y, at("N = %g", PERIODS[i]));
    }
}

void test_ctl_rc_angle_filters_with_five_taps_in_angles_of_one_and_two_samples(void)
{
    static const double PERIODS[] = {9.75, 20.25, 48.859375};
    for (size_t i = 0; i < 2U * COUNT_OF(PERIODS); i++) {
        const double    w = TWO_PI / PERIODS[i / 2U];
        ctl_rc_params_t p = angle_params();
        p.q.side = num_of(0.25);
        p.q.centre = num_of(0.625);
        p.q.side2 = num_of(-0.0625);
        p.order = ((i % 2U) == 0U) ? 2U : 1U;
        start_angle(&p, 128U);
        for (uint16_t c = 0; c < 128U; c++) {
            memory[c] = num_of(sin(TWO_PI * c / 128.0));
        }

        const num_t y = ctl_rc_step(&rc, (num_t)0, period_of(PERIODS[i / 2U]), turns(0.2));

        /* cubic read-out of a sine of 128 points is off by 1.4e-7, linear by (w / 128)^2 / 8 = 3e-4 */
        const double gain = 0.625 + (0.5 * cos(w)) - (0.125 * cos(2.0 * w));
        ASSERT_NUM_WITHIN_AT((p.order == 2U) ? 1e-6 : 4e-4, gain * sin(TWO_PI * 0.2), y, at("N = %g", PERIODS[i / 2U]));
    }
}

void test_ctl_rc_angle_orders_0_and_1_read_alike(void)
{
    static num_t    other_memory[CAPACITY];
    ctl_rc_params_t p = angle_params();
    ctl_rc_t        other;
    noise_t         noise = {44U};
    p.q.side = num_of(0.25);
    p.q.centre = num_of(0.5);
    p.truncate = false;
    p.order = 0U;
    start_angle(&p, 64U);
    p.order = 1U;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&other, &p, other_memory, 64U).status);
    for (int k = 0; k < 300; k++) {
        const num_t e = num_of(noise_next(&noise));
        const num_t u = ctl_rc_step(&rc, e, period_of(20.625), turns(k / 20.625));

        TEST_ASSERT_TRUE(u == ctl_rc_step(&other, e, period_of(20.625), turns(k / 20.625)));
    }
}

void test_ctl_rc_angle_at_standstill_learns_nothing(void)
{
    const ctl_rc_params_t p = angle_params();
    start_angle(&p, 64U);
    for (int k = 0; k < 200; k++) {
        (void)ctl_rc_step(&rc, num_of(1.0), period_of(60.0), turns(0.3));
    }

    for (uint16_t i = 0; i < 64U; i++) {
        ASSERT_NUM_WITHIN_AT(0.0, 0.0, memory[i], at("cell %u", i));
    }
}

void test_ctl_rc_angle_after_a_jump_of_more_than_a_quarter_turn_does_not_smear(void)
{
    static const double JUMPS[] = {0.26, -0.26, 0.45, 0.5};
    for (size_t j = 0; j < COUNT_OF(JUMPS); j++) {
        const ctl_rc_params_t p = angle_params();
        start_angle(&p, 64U);
        for (int k = 0; k < 20; k++) {
            (void)ctl_rc_step(&rc, num_of(1.0), period_of(60.0), turns(JUMPS[j] * k));
        }

        for (uint16_t i = 0; i < 64U; i++) {
            ASSERT_NUM_WITHIN_AT(0.0, 0.0, memory[i], at("jump %g, cell %u", JUMPS[j], i));
        }
    }
}

void test_ctl_rc_angle_with_steps_just_below_a_quarter_turn_still_learns(void)
{
    for (int direction = -1; direction <= 1; direction += 2) {
        const ctl_rc_params_t p = angle_params();
        start_angle(&p, 64U);
        for (int k = 0; k < 40; k++) {
            (void)ctl_rc_step(&rc, num_of(1.0), period_of(60.0), turns(0.24 * direction * k));
        }

        for (uint16_t i = 0; i < 64U; i++) {
            TEST_ASSERT_TRUE_MESSAGE(memory[i] > (num_t)0, at("direction %d, cell %u", direction, i));
        }
    }
}

void test_ctl_rc_angle_after_a_reversal_keeps_what_it_knows(void)
{
    const ctl_rc_params_t p = angle_params();
    start_angle(&p, 128U);
    const uint16_t lead = p.lead;
    double         past[CTL_RC_LEAD_MAX + 1U] = {0.0};
    double         worst = 0.0;
    double         position = 0.0;
    for (int k = 0; k < 3000; k++) {
        const double speed = (k < 2400) ? (1.0 / 60.0) : (-1.0 / 60.0);
        const double e = sin(TWO_PI * position) - past[k % lead];
        past[k % lead] = value_of(ctl_rc_step(&rc, num_of(e), period_of(60.0), turns(position)));
        worst = ((k > 2400 + (int)lead) && (k < 2460)) ? fmax(worst, fabs(e)) : worst;
        position += speed;
    }

    /* the lead of 3 samples has the wrong sign now: 2 pi 6 / 60 = 0.63 at most, instead of up to 2 */
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 0.55, worst);
}

/* ---- learning freeze -------------------------------------------------------------------------------------------------------- */

void test_ctl_rc_freeze_learns_nothing_during_and_after_a_large_error(void)
{
    ctl_rc_params_t p = valid_params();
    p.freeze_above = num_of(2.0);
    p.freeze_samples = 5U;
    start(&p);
    static const double ERRORS[] = {2.0, 2.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -2.5, 1.0};
    static const double LEARNED[] = {1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0};
    for (size_t k = 0; k < COUNT_OF(ERRORS); k++) {
        (void)step(ERRORS[k], 40.0);
    }
    wait((uint16_t)(40U - 3U - COUNT_OF(ERRORS)), 40.0);

    for (size_t k = 0; k < COUNT_OF(LEARNED); k++) {
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(LEARNED[k], step(0.0, 40.0), at("sample %u", (unsigned)k));
    }
}

void test_ctl_rc_freeze_starts_over_with_every_large_error(void)
{
    ctl_rc_params_t p = valid_params();
    p.freeze_above = num_of(2.0);
    p.freeze_samples = 3U;
    start(&p);

    (void)step(5.0, 40.0);
    (void)step(0.0, 40.0);
    (void)step(-5.0, 40.0);
    TEST_ASSERT_EQUAL_UINT16(3U, rc.state.frozen);
    wait(3U, 40.0);
    TEST_ASSERT_EQUAL_UINT16(0U, rc.state.frozen);
}

void test_ctl_rc_freeze_still_plays_back(void)
{
    ctl_rc_params_t p = valid_params();
    p.freeze_above = num_of(2.0);
    p.freeze_samples = 100U;
    start(&p);
    (void)step(1.0, 40.0);
    (void)step(5.0, 40.0);
    wait(35U, 40.0);

    TEST_ASSERT_EQUAL_DOUBLE(0.5, step(0.0, 40.0));
}

void test_ctl_rc_freeze_threshold_of_zero_never_freezes(void)
{
    (void)step(90.0, 40.0);

    TEST_ASSERT_EQUAL_UINT16(0U, rc.state.frozen);
    wait(36U, 40.0);
    TEST_ASSERT_EQUAL_DOUBLE(45.0, step(0.0, 40.0));
}

/* ---- limits ------------------------------------------------------------------------------------------------------------------ */

void test_ctl_rc_memory_stops_at_its_limit_and_leaves_it_at_once(void)
{
    for (uint16_t lead = 0; lead <= 3U; lead += 3U) {
        ctl_rc_params_t p = valid_params();
        p.lead = lead;
        p.limit = num_of(2.0);
        start(&p);
        for (int k = 0; k < 400; k++) {
            TEST_ASSERT_TRUE(step(1.0, 20.0) <= 2.0);
        }
        TEST_ASSERT_EQUAL_DOUBLE(2.0, step(-1.0, 20.0));
        for (int k = 0; k < 19; k++) {
            (void)step(-1.0, 20.0);
        }
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(1.5, step(-1.0, 20.0),
                                         at("lead %u", lead)); /* one learned sample below, not hidden behind windup */
        for (int k = 0; k < 400; k++) {
            TEST_ASSERT_TRUE(step(-1.0, 20.0) >= -2.0);
        }
        TEST_ASSERT_EQUAL_DOUBLE(-2.0, step(0.0, 20.0));
    }
}

void test_ctl_rc_output_stays_within_the_limit_where_interpolation_overshoots(void)
{
    ctl_rc_params_t p = valid_params();
    p.order = 3U;
    p.gain = num_of(10.0);
    p.limit = num_of(1.0);
    start(&p);
    for (int k = 0; k < 400; k++) { /* a square wave: cubic interpolation of its edges goes beyond it */
        TEST_ASSERT_DOUBLE_WITHIN(1.0, 0.0, step((((k / 7) % 2) == 0) ? 1.0 : -1.0, 21.5));
    }
}

void test_ctl_rc_with_taps_that_sum_to_one_stays_bounded_for_ever(void)
{
    static const double TAPS[][2] = {{0.5, 0.0}, {-0.5, 0.0}, {0.45, 0.1}, {0.0, -1.0}, {0.25, 0.500009}};
    for (size_t i = 0; i < COUNT_OF(TAPS); i++) {
        ctl_rc_params_t p = valid_params();
        noise_t         noise = {45U};
        p.q.side = num_of(TAPS[i][0]);
        p.q.centre = num_of(TAPS[i][1]);
        p.limit = num_of(3.0);
        start(&p);
        for (int k = 0; k < 3000; k++) {
            TEST_ASSERT_DOUBLE_WITHIN(3.0, 0.0, step(noise_next(&noise) + 0.3, 17.3));
        }
    }
}

/* ---- wrong signals ------------------------------------------------------------------------------------------------------------ */

void test_ctl_rc_error_that_is_not_finite_teaches_nothing_and_is_counted(void)
{
    for (int mode = CTL_RC_KEEP; mode <= CTL_RC_ANGLE; mode++) {
        static num_t    other_memory[CAPACITY];
        ctl_rc_params_t p = valid_params();
        ctl_rc_t        other;
        noise_t         noise = {46U};
        uint32_t        bad = 0U;
        p.memory = (ctl_rc_memory_t)mode;
        p.fal_at = (mode == CTL_RC_CLEAR) ? CTL_RC_FAL_OUTPUT : CTL_RC_FAL_INPUT;
        start(&p);
        TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&other, &p, other_memory, CAPACITY).status);
        for (uint32_t k = 0; k < 300U; k++) {
            const bool    good = (k % 7U) != 3U;
            const num_t   e = num_of(noise_next(&noise));
            const angle_t theta = turns(k / 20.3);
            const num_t   u = ctl_rc_step(&rc, good ? e : NOT_FINITE[k % COUNT_OF(NOT_FINITE)], period_of(20.3), theta);
            const num_t   v = ctl_rc_step(&other, good ? e : (num_t)0, period_of(20.3), theta);

            bad += good ? 0U : 1U;
            TEST_ASSERT_TRUE_MESSAGE(u == v, at("mode %d, sample %u", mode, k));
            TEST_ASSERT_EQUAL_UINT32(bad, rc.state.rejected);
        }
    }
}

void test_ctl_rc_error_that_is_not_finite_does_not_stop_the_freeze_from_running_out(void)
{
    ctl_rc_params_t p = valid_params();
    p.freeze_above = num_of(2.0);
    p.freeze_samples = 3U;
    start(&p);
    (void)step(5.0, 40.0);

    (void)ctl_rc_step(&rc, NOT_FINITE[0], period_of(40.0), 0U);

    TEST_ASSERT_EQUAL_UINT16(2U, rc.state.frozen);
}

void test_ctl_rc_period_outside_of_the_memory_is_cut_and_counted(void)
{
    double         answer = 0.0;
    const uint16_t longest = ctl_rc_period_max(&rc);
    TEST_ASSERT_EQUAL_UINT16(CAPACITY - 2U - 1U, longest);

    TEST_ASSERT_EQUAL_INT(5 - 3, answer_to_an_impulse(1.5, &answer)); /* shortest: lead + 2, without a fraction */
    TEST_ASSERT_EQUAL_DOUBLE(0.5, answer);
    TEST_ASSERT_EQUAL_UINT32(3U, rc.state.cut_periods);
    setUp();
    TEST_ASSERT_EQUAL_INT(longest - 3, answer_to_an_impulse(60000.0, &answer));
    TEST_ASSERT_EQUAL_UINT32(longest - 3U + 1U, rc.state.cut_periods);
    setUp();
    TEST_ASSERT_EQUAL_INT(longest - 3, answer_to_an_impulse(65535.9997, &answer)); /* does not wrap to 0 when rounded up */
}

/* Five taps reach one sample further on either side. */
void test_ctl_rc_five_taps_cost_a_sample_at_either_end_of_the_memory(void)
{
    for (uint16_t order = 0; order <= 3U; order++) {
        ctl_rc_params_t p = valid_params();
        p.order = order;
        start(&p);
        const uint16_t shortest = rc.shortest;
        const uint16_t longest = rc.longest;
        p.q.side2 = num_of(-0.05);
        p.q.side = num_of(0.2);
        p.q.centre = num_of(0.7);
        start(&p);
        TEST_ASSERT_EQUAL_UINT16(shortest + 1U, rc.shortest);
        TEST_ASSERT_EQUAL_UINT16(longest - 1U, rc.longest);
        TEST_ASSERT_EQUAL(CTL_ERR_MEMORY, ctl_rc_check(&p, (uint16_t)(p.lead + order + 6U)).status);
        TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_check(&p, (uint16_t)(p.lead + order + 7U)).status);
    }
}

/* The memory holds a wave of 40 samples, which a period of 40 reads back with the gain of the taps. */
void test_ctl_rc_reads_back_with_the_gain_of_three_and_of_five_taps(void)
{
    static const double TAPS[][3] = {{0.2, 0.6, 0.0}, {0.2, 0.7, -0.05}, {0.1, 0.6, 0.1}};
    const double        w = TWO_PI / 40.0;
    for (size_t i = 0; i < 4U * COUNT_OF(TAPS); i++) {
        const double *const taps = TAPS[i / 4U];
        ctl_rc_params_t     p = valid_params();
        p.order = (uint16_t)(i % 4U);
        p.gain = (num_t)0;
        p.q.side = num_of(taps[0]);
        p.q.centre = num_of(taps[1]);
        p.q.side2 = num_of(taps[2]);
        start(&p);
        TEST_ASSERT_EQUAL((taps[2] == 0.0) && (p.order == 2U), rc.fast);
        for (uint16_t k = 0; k < CAPACITY; k++) {
            ctl_ring_push(&rc.state.time, num_of(sin(w * k)));
        }
        const double y = value_of(ctl_rc_step(&rc, (num_t)0, period_of(40.0), 0U));

        const double gain = taps[1] + (2.0 * taps[0] * cos(w)) + (2.0 * taps[2] * cos(2.0 * w));
        ASSERT_DOUBLE_WITHIN_AT(2e-6, gain * sin(w * CAPACITY), y, at("case %u", (unsigned)i));
    }
}

void test_ctl_rc_period_at_either_end_of_the_memory_is_used_uncounted(void)
{
    double         answer = 0.0;
    const uint16_t longest = ctl_rc_period_max(&rc);

    TEST_ASSERT_EQUAL_INT(2, answer_to_an_impulse(5.0, &answer));
    setUp();
    TEST_ASSERT_EQUAL_INT(longest - 3, answer_to_an_impulse(longest, &answer));
    TEST_ASSERT_EQUAL_DOUBLE(0.5, answer);
    TEST_ASSERT_EQUAL_UINT32(0U, rc.state.cut_periods);
}

void test_ctl_rc_longest_period_uses_the_whole_memory_in_every_order(void)
{
    for (uint16_t order = 0; order <= 3U; order++) {
        ctl_rc_params_t p = valid_params();
        double          answer = 0.0;
        p.order = order;
        start(&p);
        const double samples = ctl_rc_period_max(&rc) + 0.5;
        TEST_ASSERT_EQUAL_UINT16(CAPACITY - order - 1U, ctl_rc_period_max(&rc));
        (void)step(1.0, samples);
        double sum = 0.0;
        for (int k = 0; k < (int)CAPACITY + 8; k++) {
            answer = step(0.0, samples);
            sum += answer;
        }

        ASSERT_DOUBLE_WITHIN_AT(1e-6, 0.5, sum, at("order %u", order)); /* all of the taps were in the memory */
    }
}

void test_ctl_rc_fraction_out_of_range_counts_as_zero(void)
{
    const num_t wrong[] = {num_of(1.0), num_of(-0.25), num_of(7.5), NUM_MAX, -NUM_MAX, NOT_FINITE[0]};
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        setUp();
        const ctl_period_t n = {40U, wrong[i]};
        double             answer = 0.0;
        (void)ctl_rc_step(&rc, num_of(1.0), n, 0U);
        for (int k = 1; k <= 37; k++) {
            answer = value_of(ctl_rc_step(&rc, (num_t)0, n, 0U));
        }

        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(0.5, answer, at("case %u", (unsigned)i));
    }
}

void test_ctl_rc_fed_with_anything_stays_bounded_in_every_mode(void)
{
    noise_t noise = {47U};
    for (int mode = CTL_RC_KEEP; mode <= CTL_RC_ANGLE; mode++) {
        for (int fal_at = CTL_RC_FAL_NONE; fal_at <= CTL_RC_FAL_OUTPUT; fal_at++) {
            ctl_rc_params_t p = valid_params();
            p.memory = (ctl_rc_memory_t)mode;
            p.fal_at = (ctl_rc_fal_at_t)fal_at;
            p.order = (uint16_t)noise_pick(&noise, 4U);
            p.lead = (uint16_t)(2U + noise_pick(&noise, 14U));
            p.limit = num_of(5.0);
            p.gain = num_of(100.0);
            p.freeze_above = num_of((fal_at == CTL_RC_FAL_INPUT) ? 50.0 : 0.0);
            p.freeze_samples = 2U;
            start(&p);
            for (uint32_t k = 0; k < 2000U; k++) {
                const ctl_period_t n = {(uint16_t)(noise_bits(&noise) >> (16U + noise_pick(&noise, 16U))), noise_nasty(&noise)};

                const num_t u = ctl_rc_step(&rc, noise_nasty(&noise), n, noise_bits(&noise) >> noise_pick(&noise, 32U));

                const double most = 5.0 * ((fal_at == CTL_RC_FAL_OUTPUT) ? 1.4428 : 1.0);
                ASSERT_BOUNDED_AT(most, u, at("mode %d, fal %d, sample %u", mode, fal_at, k));
            }
            if (mode == CTL_RC_ANGLE) {
                for (uint16_t i = 0; i < CAPACITY; i++) {
                    ASSERT_BOUNDED_AT(5.00001, memory[i], at("cell %u", i));
                }
            } else {
                for (uint16_t d = 0; d < CAPACITY; d++) {
                    ASSERT_BOUNDED_AT(5.0, ctl_ring_get(&rc.state.time, d), at("delay %u", d));
                }
            }
        }
    }
}

/* ---- reset -------------------------------------------------------------------------------------------------------------------------- */

void test_ctl_rc_reset_forgets_what_was_learned_but_not_what_was_counted(void)
{
    for (int mode = CTL_RC_KEEP; mode <= CTL_RC_ANGLE; mode++) {
        ctl_rc_params_t p = valid_params();
        p.memory = (ctl_rc_memory_t)mode;
        p.freeze_above = num_of(50.0);
        p.freeze_samples = 9U;
        start(&p);
        for (int k = 0; k < 100; k++) {
            (void)ctl_rc_step(&rc, num_of(1.0), period_of(20.5), turns(k / 20.5));
        }
        (void)ctl_rc_step(&rc, NOT_FINITE[0], period_of(1.0), 0U);
        (void)step(60.0, 20.5);

        ctl_rc_reset(&rc, false);

        TEST_ASSERT_EQUAL_UINT16(0U, rc.state.frozen);
        for (int k = 0; k < 100; k++) {
            ASSERT_NUM_WITHIN_AT(0.0, 0.0, ctl_rc_step(&rc, (num_t)0, period_of(20.5), turns(k / 20.5)),
                                 at("mode %d, %d", mode, k));
        }
        TEST_ASSERT_EQUAL_UINT32(1U, rc.state.rejected);
        TEST_ASSERT_EQUAL_UINT32(1U, rc.state.cut_periods);
    }
}

/* Over time it is forgotten all the same: the samples of before belong to another time. */
void test_ctl_rc_reset_that_keeps_keeps_what_was_learned_over_the_angle_alone(void)
{
    for (int mode = CTL_RC_KEEP; mode <= CTL_RC_ANGLE; mode++) {
        ctl_rc_params_t p = valid_params();
        p.memory = (ctl_rc_memory_t)mode;
        start(&p);
        double before = 0.0;
        for (int k = 0; k < 200; k++) {
            before = value_of(ctl_rc_step(&rc, num_of(1.0), period_of(20.0), turns(k / 20.0)));
        }
        TEST_ASSERT_TRUE(before > 0.1);

        ctl_rc_reset(&rc, true);

        const double after = value_of(ctl_rc_step(&rc, (num_t)0, period_of(20.0), turns(200 / 20.0)));
        TEST_ASSERT_EQUAL_MESSAGE(mode == CTL_RC_ANGLE, after > (0.9 * before), at("mode %d", mode));
        TEST_ASSERT_EQUAL_MESSAGE(mode != CTL_RC_ANGLE, after == 0.0, at("mode %d", mode));
    }
}

void test_ctl_rc_over_the_angle_on_hold_writes_nothing_and_goes_on_acting(void)
{
    ctl_rc_params_t p = valid_params();
    p.memory = CTL_RC_ANGLE;
    start(&p);
    for (int k = 0; k < 200; k++) {
        (void)ctl_rc_step(&rc, num_of(sin(TWO_PI * k / 20.0)), period_of(20.0), turns(k / 20.0));
    }
    static num_t kept[CAPACITY];
    for (uint16_t i = 0U; i < rc.state.turn.cells; i++) {
        kept[i] = rc.state.turn.cell[i];
    }
    p.hold = true;
    ctl_rc_tune(&rc, &p);
    double largest = 0.0;
    for (int k = 200; k < 400; k++) {
        largest = fmax(largest, fabs(value_of(ctl_rc_step(&rc, num_of(1.0), period_of(20.0), turns(k / 20.0)))));
    }
    TEST_ASSERT_TRUE(largest > 0.1);
    for (uint16_t i = 0U; i < rc.state.turn.cells; i++) {
        ASSERT_NUM_WITHIN_AT(0.0, value_of(kept[i]), rc.state.turn.cell[i], at("cell %u", (unsigned)i));
    }
}

void test_ctl_rc_after_a_reset_runs_as_after_init(void)
{
    for (int mode = CTL_RC_KEEP; mode <= CTL_RC_ANGLE; mode++) {
        static num_t    other_memory[CAPACITY];
        ctl_rc_params_t p = valid_params();
        ctl_rc_t        fresh;
        noise_t         noise = {48U};
        p.memory = (ctl_rc_memory_t)mode;
        start(&p);
        for (int k = 0; k < 77; k++) {
            (void)ctl_rc_step(&rc, num_of(noise_next(&noise)), period_of(20.5), turns(k / 20.5));
        }
        ctl_rc_reset(&rc, false);
        TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&fresh, &p, other_memory, CAPACITY).status);
        for (int k = 0; k < 200; k++) {
            const num_t e = num_of(noise_next(&noise));
            const num_t u = ctl_rc_step(&rc, e, period_of(20.5), turns(0.77 + k / 20.5));

            TEST_ASSERT_TRUE(u == ctl_rc_step(&fresh, e, period_of(20.5), turns(0.77 + k / 20.5)));
        }
    }
}

/* ---- period from two numbers ------------------------------------------------------------------------------------------------------------ */

void test_ctl_period_ratio_splits_the_quotient(void)
{
    static const double CASES[][2] = {{100.0, 2.0},        {15.0, 0.306640625}, {1.0, 3.0},
                                      {120.0, 0.00390625}, {0.5, 60.0},         {7.0, 7.0}};
    for (size_t i = 0; i < COUNT_OF(CASES); i++) {
        const double       want = CASES[i][0] / CASES[i][1];
        const ctl_period_t n = ctl_period_ratio(num_of(CASES[i][0]), num_of(CASES[i][1]));

        TEST_ASSERT_TRUE((n.fraction >= (num_t)0) && (n.fraction < num_of(1.0)));
        /* relative error of a float; in fixed point that of the divisor's own rounding (none: all are exact) */
        ASSERT_DOUBLE_WITHIN_AT(per_numeric(1.2e-7 * want, FIXED_STEP), want, n.whole + value_of(n.fraction),
                                at("case %u", (unsigned)i));
    }
}

static void assert_longest_period(num_t numerator, num_t denominator, const char *text)
{
    const ctl_period_t n = ctl_period_ratio(numerator, denominator);

    TEST_ASSERT_EQUAL_UINT16_MESSAGE(65534U, n.whole, text);
    ASSERT_NUM_WITHIN_AT(0.0, 0.0, n.fraction, text);
}

void test_ctl_period_ratio_of_what_has_no_period_is_the_longest(void)
{
    assert_longest_period(num_of(1.0), (num_t)0, "standstill");
    assert_longest_period(num_of(1.0), num_of(-1.0), "backwards");
    assert_longest_period(num_of(-1.0), num_of(1.0), "negative");
    assert_longest_period((num_t)0, num_of(1.0), "zero");
    assert_longest_period(num_of(127.0), NUM_EPS, "too long");
    assert_longest_period(num_of(64.0), num_of(64.0 / 65534.0 - per_numeric(0.0, FIXED_STEP)), "just too long");
#ifdef EVENSPIN_FIXED
    assert_longest_period(INT32_MIN, num_of(1.0), "INT32_MIN above");
    assert_longest_period(num_of(1.0), INT32_MIN, "INT32_MIN below");
#else
    assert_longest_period(NAN, 1.0f, "NaN above");
    assert_longest_period(1.0f, NAN, "NaN below");
    assert_longest_period(INFINITY, 1.0f, "infinity above");
    assert_longest_period(INFINITY, INFINITY, "infinity over infinity");
#endif
}

void test_ctl_period_ratio_just_inside_the_longest_is_used(void)
{
    const ctl_period_t n = ctl_period_ratio(num_of(127.0), num_of(0.00194));

    TEST_ASSERT_UINT16_WITHIN(3U, 65463U, n.whole); /* the divisor's own rounding: 3e-5 of it in fixed point */
}

void test_ctl_rc_period_max_in_angle_mode_is_the_longest_there_is(void)
{
    const ctl_rc_params_t p = angle_params();
    start_angle(&p, 64U);

    TEST_ASSERT_EQUAL_UINT16(65534U, ctl_rc_period_max(&rc));
}

/* ---- configuration ---------------------------------------------------------------------------------------------------------------------- */

static void assert_rejected(const ctl_rc_params_t *p, ctl_status_t status, uint16_t field, num_t given)
{
    (void)step(1.0, 20.5);
    const ctl_rc_t before = rc;
    num_t          untouched[CAPACITY];
    memcpy(untouched, memory, sizeof untouched);

    const ctl_diag_t got = ctl_rc_init(&rc, p, memory, CAPACITY);
    const ctl_diag_t foreseen = ctl_rc_check(p, CAPACITY);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(given, got.given);
    TEST_ASSERT_EQUAL(status, foreseen.status);
    TEST_ASSERT_EQUAL_UINT16(field, foreseen.field);
    ASSERT_SAME_BITS(given, foreseen.given);
    ASSERT_SAME_BITS(before, rc);
    TEST_ASSERT_EQUAL_MEMORY(untouched, memory, sizeof untouched);
}

void test_ctl_rc_init_rejects_a_gain_out_of_range(void)
{
    ctl_rc_params_t p = valid_params();
    p.gain = num_of(-0.1);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_GAIN, p.gain);
    p.gain = num_of(100.5);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_GAIN, p.gain);
}

void test_ctl_rc_init_rejects_a_lead_out_of_range(void)
{
    ctl_rc_params_t p = valid_params();
    p.lead = CTL_RC_LEAD_MAX + 1U;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_LEAD, num_of(16.0));
}

void test_ctl_rc_init_rejects_a_lead_below_two_over_the_angle(void)
{
    ctl_rc_params_t p = angle_params();
    p.lead = 1U;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_LEAD, num_of(1.0));

    p.lead = 2U;
    start(&p);
}

void test_ctl_rc_init_rejects_a_filter_whose_memory_would_grow(void)
{
    ctl_rc_params_t p = valid_params();
    p.q.side = num_of(0.3);
    p.q.centre = num_of(0.5);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_Q, p.q.centre);
}

void test_ctl_rc_init_rejects_an_unknown_order_place_or_memory(void)
{
    ctl_rc_params_t p = valid_params();
    p.order = 4U;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_ORDER, num_of(4.0));

    p = valid_params();
    p.fal_at = (ctl_rc_fal_at_t)(CTL_RC_FAL_OUTPUT + 1);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_FAL_AT, num_of(3.0));

    p = valid_params();
    p.memory = (ctl_rc_memory_t)(CTL_RC_ANGLE + 1);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_MEMORY, num_of(3.0));
}

void test_ctl_rc_init_names_the_parameter_of_fal_that_is_wrong(void)
{
    for (int fal_at = CTL_RC_FAL_INPUT; fal_at <= CTL_RC_FAL_OUTPUT; fal_at++) {
        ctl_rc_params_t p = valid_params();
        p.fal_at = (ctl_rc_fal_at_t)fal_at;
        p.fal.alpha = num_of(1.5);
        assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_FAL_ALPHA, p.fal.alpha);
        p.fal.alpha = num_of(0.6);
        p.fal.delta = (num_t)0;
        assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_FAL_DELTA, p.fal.delta);
    }
}

void test_ctl_rc_init_rejects_a_limit_that_is_not_positive(void)
{
    ctl_rc_params_t p = valid_params();
    p.limit = (num_t)0;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_LIMIT, p.limit);
    p.limit = num_of(-1.0);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_LIMIT, p.limit);
}

void test_ctl_rc_init_rejects_a_negative_freeze_threshold(void)
{
    ctl_rc_params_t p = valid_params();
    p.freeze_above = num_of(-1.0);

    assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_FREEZE, p.freeze_above);
}

void test_ctl_rc_init_rejects_what_is_not_finite_in_every_field(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        ctl_rc_params_t p = valid_params();
        p.gain = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_GAIN, NOT_FINITE[i]);
        p = valid_params();
        p.q.centre = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_Q, NOT_FINITE[i]);
        p = valid_params();
        p.q.side = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_Q, p.q.centre);
        p = valid_params();
        p.limit = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_LIMIT, NOT_FINITE[i]);
        p = valid_params();
        p.freeze_above = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_FREEZE, NOT_FINITE[i]);
        p = valid_params();
        p.fal_at = CTL_RC_FAL_INPUT;
        p.fal.alpha = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_FAL_ALPHA, NOT_FINITE[i]);
        p.fal.alpha = num_of(0.5);
        p.fal.delta = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_RC_FAL_DELTA, NOT_FINITE[i]);
    }
}

void test_ctl_rc_init_without_a_pointer_says_so(void)
{
    const ctl_rc_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_rc_init(NULL, &p, memory, CAPACITY));
    assert_rejected(NULL, CTL_ERR_NULL, 0U, (num_t)0);
    const ctl_rc_t before = rc;
    for (int mode = CTL_RC_KEEP; mode <= CTL_RC_ANGLE; mode++) {
        ctl_rc_params_t q = p;
        q.memory = (ctl_rc_memory_t)mode;
        const ctl_diag_t got = ctl_rc_init(&rc, &q, NULL, CAPACITY);

        TEST_ASSERT_EQUAL(CTL_ERR_NULL, got.status);
        TEST_ASSERT_EQUAL_UINT16(CTL_RC_CAPACITY, got.field);
        ASSERT_SAME_BITS(before, rc);
    }
}

void test_ctl_rc_init_rejects_a_memory_too_small_for_lead_and_order(void)
{
    for (uint16_t order = 0; order <= 3U; order++) {
        ctl_rc_params_t p = valid_params();
        p.order = order;
        const uint16_t least = (uint16_t)(p.lead + order + 5U);

        const ctl_diag_t got = ctl_rc_init(&rc, &p, memory, (uint16_t)(least - 1U));

        TEST_ASSERT_EQUAL(CTL_ERR_MEMORY, got.status);
        TEST_ASSERT_EQUAL_UINT16(CTL_RC_CAPACITY, got.field);
        ASSERT_NUM_WITHIN(0.0, least - 1.0, got.given);
        TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&rc, &p, memory, least).status);
    }
}

void test_ctl_rc_init_rejects_a_memory_larger_than_its_kind_can_use(void)
{
    static num_t    large[40000];
    ctl_rc_params_t p = valid_params();

    TEST_ASSERT_EQUAL(CTL_ERR_MEMORY, ctl_rc_init(&rc, &p, large, 32768U).status);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&rc, &p, large, 32767U).status);
    p.memory = CTL_RC_ANGLE;
    const ctl_diag_t got = ctl_rc_init(&rc, &p, large, 4097U);
    TEST_ASSERT_EQUAL(CTL_ERR_MEMORY, got.status);
    TEST_ASSERT_EQUAL_UINT16(CTL_RC_CAPACITY, got.field);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&rc, &p, large, 4096U).status);
}

void test_ctl_rc_init_takes_the_ends_of_every_range(void)
{
    ctl_rc_params_t p = valid_params();
    p.gain = (num_t)0;
    p.lead = CTL_RC_LEAD_MAX;
    p.limit = NUM_EPS;
    start(&p);
    p.gain = num_of(100.0);
    p.lead = 0U;
    p.limit = NUM_MAX;
    p.freeze_above = NUM_MAX;
    p.freeze_samples = UINT16_MAX;
    start(&p);
}

/* ---- the straight way, other parameters, periods in parts -------------------------------------------------------------------- */

void test_ctl_rc_the_straight_way_gives_what_the_general_way_gives(void)
{
    /* a freeze that nothing reaches is all that tells them apart */
    static num_t    other_memory[CAPACITY];
    static ctl_rc_t general;
    ctl_rc_params_t p = valid_params();
    p.q.side = num_of(0.45);
    p.q.centre = num_of(0.1);
    for (int fal = 0; fal < 2; fal++) {
        p.fal_at = (fal != 0) ? CTL_RC_FAL_INPUT : CTL_RC_FAL_NONE;
        p.freeze_above = (num_t)0;
        start(&p);
        p.freeze_above = num_of(120.0);
        TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&general, &p, other_memory, CAPACITY).status);
        TEST_ASSERT_TRUE(rc.fast);
        TEST_ASSERT_FALSE(general.fast);
        noise_t noise = {77U};
        for (int k = 0; k < 2000; k++) {
            const num_t        e = num_of(8.0 * noise_next(&noise));
            const ctl_period_t n = period_of(((k % 900) < 700) ? 40.0 + (0.01 * (k % 37)) : ((k % 2) ? 2.5 : 500.0));
            const num_t        want = ctl_rc_step(&general, e, n, 0U);

            ASSERT_NUM_WITHIN_AT(per_numeric(1e-4, 1e-4), value_of(want), ctl_rc_step(&rc, e, n, 0U),
                                 at("fal %d, sample %d", fal, k));
        }
        TEST_ASSERT_EQUAL_UINT32(general.state.cut_periods, rc.state.cut_periods);
        TEST_ASSERT_TRUE(rc.state.cut_periods > 0U);
    }
}

void test_ctl_rc_raw_takes_a_period_that_is_too_short_or_almost_whole_as_the_other_does(void)
{
    const ctl_rc_params_t p = valid_params();
    static num_t          other_memory[CAPACITY];
    static ctl_rc_t       raw;
    start(&p);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_rc_init(&raw, &p, other_memory, CAPACITY).status);
    for (int k = 0; k < 400; k++) {
        static const double PERIODS[] = {20.0, 20.25, 3.5, 20.9998};
        const ctl_period_t  n = period_of(PERIODS[(k / 10) % 4]);
        const num_t         e = num_of((k % 20) * 0.125);

        TEST_ASSERT_TRUE_MESSAGE(ctl_rc_step(&rc, e, n, 0U) == ctl_rc_step_unchecked(&raw, e, n.whole, n.fraction, 0U),
                                 at("sample %d", k));
    }
    TEST_ASSERT_EQUAL_UINT32(rc.state.cut_periods, raw.state.cut_periods);
}

void test_ctl_rc_raw_of_another_kind_goes_the_general_way(void)
{
    ctl_rc_params_t p = valid_params();
    p.order = 3U;
    start(&p);
    double got = 0.0;
    for (int k = 0; k < 21; k++) {
        got = value_of(ctl_rc_step_unchecked(&rc, num_of((k == 3) ? 2.0 : 0.0), 20U, (num_t)0, 0U));
        if (k == 20) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, got); /* half of it, 20 samples less a lead of 3 later */
        }
    }
}

void test_ctl_rc_tune_keeps_what_was_learned_and_takes_the_new_gain_and_fal(void)
{
    ctl_rc_params_t p = valid_params();
    start(&p);
    (void)step(4.0, 20.0);
    p.gain = num_of(0.25);
    p.fal_at = CTL_RC_FAL_INPUT;
    p.fal.alpha = num_of(0.5);

    ctl_rc_tune(&rc, &p);

    wait(16U, 20.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, step(4.0, 20.0)); /* of before the change: half of 4, 20 - 3 samples later */
    ctl_rc_tune(&rc, &p);                                  /* no change: nothing happens */
    wait(16U, 20.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.25 * 2.0, step(0.0, 20.0)); /* a quarter of the root of 4 */
    p.fal_at = CTL_RC_FAL_NONE;
    ctl_rc_tune(&rc, &p);
    (void)step(4.0, 20.0);
    wait(16U, 20.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, step(0.0, 20.0));
}

/* Sample by sample the same as a controller that was tuned at once, whenever the preparation came. */
void test_ctl_rc_prepare_shows_only_when_it_is_taken(void)
{
    static num_t          want[120];
    const num_t           step_max = num_of(1.0e-12);
    ctl_rc_params_t       p = valid_params();
    const ctl_rc_memory_t kinds[] = {CTL_RC_KEEP, CTL_RC_CLEAR};
    for (size_t kind = 0; kind < COUNT_OF(kinds); kind++) {
        p = valid_params();
        p.memory = kinds[kind];
        p.fal_at = CTL_RC_FAL_INPUT;
        ctl_rc_params_t other = p;
        other.gain = num_of(0.25);
        other.fal.alpha = num_of(0.3);
        other.fal.delta = num_of(0.1);
        other.freeze_above = num_of(50.0); /* from the fast path to the general one, and back */
        for (int prepared_at = -1; prepared_at < 60; prepared_at += 7) {
            start(&p);
            for (int k = 0; k < 120; k++) {
                if (k == prepared_at) {
                    ctl_rc_prepare(&rc, &other);
                }
                if ((k == 60) && (prepared_at < 0)) {
                    ctl_rc_tune(&rc, &other);
                } else if (k == 60) {
                    ctl_rc_take_prepared(&rc, &other);
                } else if (k == 90) {
                    ctl_rc_tune(&rc, &p);
                } else {
                    /* as it is */
                }
                const num_t y = num_of(step(3.0 * cos(0.3 * k), 20.25));
                if (prepared_at < 0) {
                    want[k] = y;
                } else {
                    TEST_ASSERT_TRUE_MESSAGE(num_abs(num_sub(y, want[k])) <= step_max,
                                             at("prepared at %d, sample %d", prepared_at, k));
                }
            }
        }
    }
}

/* A freeze that no error reaches takes the general path: the same numbers, to the rounding of other sums. */
void test_ctl_rc_tune_from_the_fast_path_to_the_general_one_goes_on_as_if_it_had_always_been_there(void)
{
    static double   want[200];
    ctl_rc_params_t general = valid_params();
    general.freeze_above = num_of(90.0);
    start(&general);
    for (int k = 0; k < 200; k++) {
        want[k] = step(3.0 * cos(0.3 * k), 20.25);
    }
    const ctl_rc_params_t fast = valid_params();
    start(&fast);
    for (int k = 0; k < 200; k++) {
        if (k == 77) {
            ctl_rc_tune(&rc, &general);
        }
        ASSERT_DOUBLE_WITHIN_AT(2e-5, want[k], step(3.0 * cos(0.3 * k), 20.25), at("sample %d", k));
    }
    TEST_ASSERT_TRUE(fabs(want[150]) > 0.5);
}

void test_ctl_rc_tune_is_no_change_of_the_period(void)
{
    ctl_rc_params_t p = valid_params();
    p.memory = CTL_RC_CLEAR; /* would clear at a change by more than a sample */
    start(&p);
    (void)step(4.0, 20.0);

    ctl_rc_tune(&rc, &p);

    TEST_ASSERT_EQUAL_UINT16(20U, rc.state.period.whole);
    wait(16U, 20.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, step(0.0, 20.0));
}

void test_ctl_rc_period_in_parts_is_the_ratio_as_long_as_the_memory_holds_it(void)
{
    const ctl_rc_params_t p = valid_params();
    start(&p);
    for (double speed = 0.125; speed < 8.0; speed *= 1.09) {
        const num_t        d = num_of(speed);
        const ctl_period_t want = ctl_period_ratio(num_of(100.0), d);
        uint16_t           whole = 0U;
        num_t              fraction = (num_t)0;

        const bool fits = ctl_rc_period_unchecked(&rc, num_of(100.0), d, &whole, &fraction);

        TEST_ASSERT_EQUAL_MESSAGE(want.whole <= ctl_rc_period_max(&rc), fits, at("%g", speed));
        if (fits) {
            TEST_ASSERT_EQUAL_UINT16(want.whole, whole);
            TEST_ASSERT_TRUE(want.fraction == fraction);
        }
    }
    uint16_t whole = 0U;
    num_t    fraction = (num_t)0;
    TEST_ASSERT_FALSE(ctl_rc_period_unchecked(&rc, num_of(100.0), (num_t)0, &whole, &fraction));
}

void test_ctl_rc_parameters_that_nobody_prepared_leave_the_table_of_fal_as_it_is(void)
{
    ctl_rc_params_t p = valid_params();
    p.fal_at = CTL_RC_FAL_INPUT;
    memset(&rc, 0, sizeof rc);
    rc.prepared = true;
    start(&p);
    TEST_ASSERT_FALSE(rc.prepared);
    ctl_rc_take_prepared(&rc, &p);
    ASSERT_NUM_WITHIN(0.0, value_of(p.fal.delta), rc.fal->params.delta);

    ctl_rc_params_t other = p;
    other.fal.delta = num_of(0.75);
    ctl_rc_prepare(&rc, &other);
    for (int k = 0; k < 3; k++) {
        ctl_rc_take_prepared(&rc, &other); /* the second time there is nothing to take */
        TEST_ASSERT_FALSE(rc.prepared);
        ASSERT_NUM_WITHIN(0.0, 0.75, rc.fal->params.delta);
    }
}

/* Order 0 looks at every period; those at the ends are as long as the memory and its lead allow. */
void test_ctl_rc_order_0_takes_the_shortest_and_the_longest_period_uncounted(void)
{
    ctl_rc_params_t p = valid_params();
    p.order = 0U;
    start(&p);
    wait(3U, 5.0); /* lead 3 and 2 */
    wait(3U, 127.0);
    TEST_ASSERT_EQUAL_UINT32(0U, rc.state.cut_periods);
    (void)step(0.0, 4.0);
    TEST_ASSERT_EQUAL_UINT32(1U, rc.state.cut_periods);
    (void)step(0.0, 128.0);
    TEST_ASSERT_EQUAL_UINT32(2U, rc.state.cut_periods);
}

void test_ctl_rc_period_of_two_numbers_is_one_up_to_the_longest_and_its_fraction(void)
{
    uint16_t     whole = 0U;
    num_t        fraction = (num_t)0;
    const double most = ctl_rc_period_max(&rc);
    TEST_ASSERT_TRUE(ctl_rc_period_unchecked(&rc, num_of(most + 0.75), num_of(1.0), &whole, &fraction));
    TEST_ASSERT_EQUAL_UINT16((uint16_t)most, whole);
    ASSERT_NUM_WITHIN(1e-4, 0.75, fraction);
    TEST_ASSERT_TRUE(ctl_rc_period_unchecked(&rc, num_of(most - 0.25), num_of(1.0), &whole, &fraction));
    TEST_ASSERT_EQUAL_UINT16((uint16_t)most - 1U, whole);
    TEST_ASSERT_FALSE(ctl_rc_period_unchecked(&rc, num_of(0.5 * (most + 1.0)), num_of(0.5), &whole, &fraction));
    TEST_ASSERT_FALSE(ctl_rc_period_unchecked(&rc, num_of(0.5 * (most + 1.25)), num_of(0.5), &whole, &fraction));
}

/* An error of 1 at sample k comes back as half of it at k + N - m = k + 37. Sample 0 freezes for 5; with the memory kept and no threshold
 * learning goes on at once, and nothing of the pause is left when the threshold comes back. */
void test_ctl_rc_freeze_threshold_that_comes_back_finds_no_pause_of_before(void)
{
    ctl_rc_params_t p = valid_params();
    p.freeze_above = num_of(2.0);
    p.freeze_samples = 5U;
    start(&p);
    (void)step(5.0, 40.0);
    p.freeze_above = (num_t)0;
    ctl_rc_tune(&rc, &p);
    (void)step(1.0, 40.0);
    p.freeze_above = num_of(2.0);
    ctl_rc_tune(&rc, &p);
    (void)step(1.0, 40.0);
    wait(34U, 40.0);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, step(0.0, 40.0));
    TEST_ASSERT_EQUAL_DOUBLE(0.5, step(0.0, 40.0));
    TEST_ASSERT_EQUAL_DOUBLE(0.5, step(0.0, 40.0));
}

/* A threshold below 1 acts as any; taken away, what is frozen runs out. */
void test_ctl_rc_freeze_threshold_below_one_freezes_and_one_that_is_taken_away_does_not(void)
{
    ctl_rc_params_t p = valid_params();
    p.memory = CTL_RC_CLEAR; /* not on the fast path, which knows no freezing */
    p.freeze_above = num_of(0.5);
    p.freeze_samples = 5U;
    start(&p);
    (void)step(0.75, 20.0);
    TEST_ASSERT_EQUAL_UINT32(5U, rc.state.frozen);
    p.freeze_above = (num_t)0;
    ctl_rc_tune(&rc, &p);
    for (unsigned k = 1U; k <= 5U; k++) {
        (void)step(0.75, 20.0);
        TEST_ASSERT_EQUAL_UINT32(5U - k, rc.state.frozen);
    }
}
