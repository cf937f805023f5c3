/* control/motor/deadbeat.c with a dq machine integrated in double precision: the current two samples after the step, the
 * voltage limit, wrong models, and every wrong signal. Currents count 10 A, voltages 100 V, speeds 100 rad/s. */
#include "tests/support/numeric.h"

#include "control/motor/deadbeat.h"
#include "tests/control/golden/deadbeat.h"

#define TS_S 1e-4
#define AMP 10.0
#define VOLT 100.0
#define SPEED 100.0
#define RAD_S_PER_RPM (TWO_PI / 60.0)

/* The machine of Tang et al. 2020. */
#define R_OHM 0.5
#define LD_H 0.9e-3
#define LQ_H 1.2e-3
#define PSI_WB 0.0594
#define POLE_PAIRS 5.0

static ctl_deadbeat_t deadbeat;

typedef struct {
    double r, l, psi; /* Of the model over the true ones. */
} wrong_t;
static const wrong_t TRUE_MODEL = {1.0, 1.0, 1.0};

static ctl_deadbeat_params_t params_of(wrong_t x, double correction)
{
    const double                we = POLE_PAIRS * SPEED;
    const ctl_deadbeat_params_t p = {
        .r = num_of(x.r * R_OHM * AMP / VOLT),
        .ld_ts = num_of(x.l * LD_H / TS_S * AMP / VOLT),
        .lq_ts = num_of(x.l * LQ_H / TS_S * AMP / VOLT),
        .ts_ld = num_of(TS_S / (x.l * LD_H) * VOLT / AMP),
        .ts_lq = num_of(TS_S / (x.l * LQ_H) * VOLT / AMP),
        .w_ld = num_of(we * x.l * LD_H * AMP / VOLT),
        .w_lq = num_of(we * x.l * LQ_H * AMP / VOLT),
        .w_psi = num_of(we * x.psi * PSI_WB / VOLT),
        .correction = num_of(correction),
        .c_max = num_of(2.0),
        .v_max = num_of(100.0),
    };
    return p;
}

static void start(wrong_t x, double correction)
{
    const ctl_deadbeat_params_t p = params_of(x, correction);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_deadbeat_init(&deadbeat, &p).status);
}

/* ---- the machine ------------------------------------------------------------------------------------------------------ */

typedef struct {
    double d, q;
} dq_t;

typedef struct {
    dq_t   i_a, v_v;    /* Current; voltage acting until the next sample, as realised. */
    double rad_s;       /* Mechanical, kept. */
    double limit_v;     /* Of the vector; 0: none. */
    bool   tells_limit; /* The controller hears what was realised, not what it asked for. */
    dq_t   asked_v;
} machine_t;

static machine_t m;

/* Tests are compiled at -O0; what takes most of the time of this one is not. */
#pragma GCC push_options
#pragma GCC optimize("O1")
static dq_t slope(dq_t i, dq_t v)
{
    const double w = m.rad_s * POLE_PAIRS;
    const dq_t   s = {(v.d - (R_OHM * i.d) + (w * LQ_H * i.q)) / LD_H,
                      (v.q - (R_OHM * i.q) - (w * ((LD_H * i.d) + PSI_WB))) / LQ_H};
    return s;
}

static dq_t plus(dq_t a, double h, dq_t b)
{
    const dq_t c = {a.d + (h * b.d), a.q + (h * b.q)};
    return c;
}

/* Runge-Kutta, twenty steps a sample: off by 1e-12. */
static void machine_sample(void)
{
    const double h = TS_S / 20.0;
    for (int n = 0; n < 20; n++) {
        const dq_t k1 = slope(m.i_a, m.v_v);
        const dq_t k2 = slope(plus(m.i_a, h / 2.0, k1), m.v_v);
        const dq_t k3 = slope(plus(m.i_a, h / 2.0, k2), m.v_v);
        const dq_t k4 = slope(plus(m.i_a, h, k3), m.v_v);
        m.i_a = plus(plus(plus(plus(m.i_a, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4);
    }
}

#pragma GCC pop_options

static void machine_start(double rpm)
{
    const machine_t rest = {.rad_s = rpm * RAD_S_PER_RPM, .tells_limit = true};
    m = rest;
}

static ctl_dq_t in_units(dq_t x, double unit)
{
    const ctl_dq_t y = {num_of(x.d / unit), num_of(x.q / unit)};
    return y;
}

/* Measure, compute, and let the sample pass with the voltage computed in the one before. */
static void sample(double id_ref, double iq_ref)
{
    const dq_t     ref_a = {id_ref, iq_ref};
    const ctl_dq_t meas = in_units(m.i_a, AMP);
    const ctl_dq_t ref = in_units(ref_a, AMP);
    const ctl_dq_t v_last = in_units(m.tells_limit ? m.v_v : m.asked_v, VOLT);
    const ctl_dq_t out = ctl_deadbeat_step(&deadbeat, &meas, &ref, num_of(m.rad_s / SPEED), &v_last);
    machine_sample();
    const dq_t   asked = {value_of(out.d) * VOLT, value_of(out.q) * VOLT};
    const double size = hypot(asked.d, asked.q);
    const double part = ((m.limit_v > 0.0) && (size > m.limit_v)) ? (m.limit_v / size) : 1.0;
    m.asked_v = asked;
    m.v_v.d = asked.d * part;
    m.v_v.q = asked.q * part;
}

static void samples(int count, double id_ref, double iq_ref)
{
    for (int k = 0; k < count; k++) {
        sample(id_ref, iq_ref);
    }
}

void setUp(void)
{
    start(TRUE_MODEL, 0.0);
    machine_start(0.0);
}
void tearDown(void) {}

/* ---- the step ---------------------------------------------------------------------------------------------------------- */

void test_ctl_deadbeat_reaches_the_reference_two_samples_after_the_step(void)
{
    /* Resistance and voltages of rotation are taken in the middle of a sample: what is left is of third order in
     * w T_s, 0.16 at 3000 r/min, and in R T_s / L = 0.056. In A, of a step of 6.3 A; measured 0.0010, 0.0036, 0.015. */
    static const struct {
        double rpm, off_a;
    } SPEEDS[] = {{0.0, 0.0012}, {123.0, 0.0015}, {1000.0, 0.0042}, {-1000.0, 0.0042}, {3000.0, 0.018}};
    for (size_t i = 0; i < COUNT_OF(SPEEDS); i++) {
        for (int corrects = 0; corrects < 2; corrects++) {
            const char *const text = at("%g rpm, correction %d", SPEEDS[i].rpm, corrects);
            start(TRUE_MODEL, (corrects != 0) ? 0.1 : 0.0);
            machine_start(SPEEDS[i].rpm);
            samples(400, 0.0, 0.0);

            sample(-2.0, 6.0);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, 0.0, m.i_a.d, text); /* computed, not yet acting */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, 0.0, m.i_a.q, text);
            sample(-2.0, 6.0);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(SPEEDS[i].off_a, -2.0, m.i_a.d, text);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(SPEEDS[i].off_a, 6.0, m.i_a.q, text);
            for (int k = 0; k < 20; k++) { /* and stays */
                sample(-2.0, 6.0);
                TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.2 * SPEEDS[i].off_a, -2.0, m.i_a.d, text);
                TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.2 * SPEEDS[i].off_a, 6.0, m.i_a.q, text);
            }
        }
    }
}

void test_ctl_deadbeat_follows_a_reference_that_changes_every_sample_two_samples_later(void)
{
    noise_t noise = {91U};
    double  last_d = 0.0;
    double  last_q = 0.0;
    machine_start(451.0);
    for (int k = 0; k < 500; k++) {
        const double id = 8.0 * noise_next(&noise);
        const double iq = 8.0 * noise_next(&noise);
        sample(id, iq);
        if (k > 2) {
            /* third order again, of steps of up to 8 A, and what the step before left */
            TEST_ASSERT_DOUBLE_WITHIN(0.01, last_d, m.i_a.d);
            TEST_ASSERT_DOUBLE_WITHIN(0.01, last_q, m.i_a.q);
        }
        last_d = id;
        last_q = iq;
    }
}

void test_ctl_deadbeat_with_a_true_model_needs_no_correction(void)
{
    for (int i = -1; i <= 1; i++) {
        start(TRUE_MODEL, 0.1);
        machine_start(1000.0 * i);
        samples(300, -2.0, 6.0);

        ASSERT_NUM_WITHIN(2e-6, 0.0, deadbeat.state.c.d);
        ASSERT_NUM_WITHIN(2e-6, 0.0, deadbeat.state.c.q);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, -2.0, m.i_a.d);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 6.0, m.i_a.q);
    }
}

/* ---- the voltage limit ------------------------------------------------------------------------------------------------- */

void test_ctl_deadbeat_arrives_without_overshoot_when_it_hears_what_the_limit_left(void)
{
    for (int corrects = 0; corrects < 2; corrects++) {
        start(TRUE_MODEL, (corrects != 0) ? 0.1 : 0.0);
        machine_start(1000.0);
        m.limit_v = 45.0; /* 31 V of it against the magnets */
        samples(300, 0.0, 0.0);
        double largest = 0.0;
        int    arrived = 0;
        for (int k = 1; k <= 100; k++) {
            sample(0.0, 15.0);
            largest = fmax(largest, m.i_a.q);
            arrived = ((arrived == 0) && (m.i_a.q > 14.9)) ? k : arrived;
            TEST_ASSERT_TRUE(hypot(m.v_v.d, m.v_v.q) <= 45.000001);
        }

        TEST_ASSERT_INT_WITHIN(3, 19, arrived); /* 14 V on 1.2 mH make 1.1 A a sample at first, less later */
        TEST_ASSERT_TRUE(largest < 15.01);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 15.0, m.i_a.q);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, m.i_a.d);
    }
}

void test_ctl_deadbeat_that_does_not_hear_of_the_limit_does_not_arrive(void)
{
    /* why v_last is what was realised */
    start(TRUE_MODEL, 0.1);
    machine_start(1000.0);
    m.limit_v = 45.0;
    m.tells_limit = false;
    samples(400, 0.0, 15.0);

    TEST_ASSERT_TRUE(m.i_a.q < 14.0);
}

void test_ctl_deadbeat_does_not_take_the_limit_for_an_error_of_its_model(void)
{
    start(TRUE_MODEL, 0.1);
    machine_start(1000.0);
    m.limit_v = 35.0;
    samples(500, 0.0, 30.0); /* cannot be reached */

    ASSERT_NUM_WITHIN(1e-4, 0.0, deadbeat.state.c.d);
    ASSERT_NUM_WITHIN(1e-4, 0.0, deadbeat.state.c.q);
}

/* ---- wrong models ------------------------------------------------------------------------------------------------------ */

static const double RPMS[] = {0.0, 123.0, 1000.0, -1000.0};

/* R, L and psi each too small, right or too large by 30 %: every combination. */
static wrong_t combination(int n)
{
    const wrong_t x = {0.7 + (0.3 * (n % 3)), 0.7 + (0.3 * ((n / 3) % 3)), 0.7 + (0.3 * (n / 9))};
    return x;
}

void test_ctl_deadbeat_with_correction_settles_without_a_steady_error_for_any_model_within_30_percent(void)
{
    for (int n = 0; n < 27; n++) {
        for (size_t i = 0; i < COUNT_OF(RPMS); i++) {
            const wrong_t     x = combination(n);
            const char *const text = at("R %g L %g psi %g, %g rpm", x.r, x.l, x.psi, RPMS[i]);
            double            over = 0.0;
            int               settled = 0;
            start(x, 0.1);
            machine_start(RPMS[i]);
            samples(400, 0.0, 0.0);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-5, 0.0, hypot(m.i_a.d, m.i_a.q), text);
            for (int k = 1; k <= 300; k++) {
                sample(-2.0, 6.0);
                over = fmax(over, fmax(m.i_a.q - 6.0, -2.0 - m.i_a.d));
                settled = (hypot(m.i_a.q - 6.0, m.i_a.d + 2.0) > 0.063) ? k : settled;
            }

            /* the first answer is L of the model over the true one times the step */
            TEST_ASSERT_TRUE_MESSAGE(over < ((x.l > 1.1) ? 1.95 : 0.6), text);
            TEST_ASSERT_TRUE_MESSAGE((x.l < 1.1) || (over > 1.5), text);
            TEST_ASSERT_TRUE_MESSAGE(settled < 40, text); /* to a hundredth of the step, 4 ms */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-5, 0.0, hypot(m.i_a.q - 6.0, m.i_a.d + 2.0), text);
        }
    }
}

void test_ctl_deadbeat_without_correction_has_the_known_steady_error(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_DEADBEAT); i++) {
        const golden_deadbeat_t *const g = &GOLDEN_DEADBEAT[i];
        const wrong_t                  x = {g->r, g->l, g->psi};
        start(x, 0.0);
        machine_start(g->rpm);

        samples(400, -1.0, 5.0);

        /* parameters of fixed point are known to 3e-8, a part of 1e-6 of the smallest; times 5 A */
        const char *const text = at("R %g L %g psi %g, %g rpm", g->r, g->l, g->psi, g->rpm);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-5, g->id_a, m.i_a.d, text);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-5, g->iq_a, m.i_a.q, text);
    }
}

void test_ctl_deadbeat_correction_removes_the_error_with_a_pole_at_1_minus_g(void)
{
    /* a magnet of 30 % less at a constant speed: an error that the correction alone sees */
    const wrong_t x = {1.0, 1.0, 0.7};
    start(x, 0.1);
    machine_start(1000.0);
    samples(40, 0.0, 0.0);
    const double then = m.i_a.q;
    samples(10, 0.0, 0.0);

    /* resistance, which the model knows, is why it is not exactly 0.9^10 */
    TEST_ASSERT_DOUBLE_WITHIN(0.02, pow(0.9, 10.0), m.i_a.q / then);
}

static bool is_stable(double l, double correction, double rpm)
{
    const wrong_t x = {1.0, l, 1.0};
    start(x, correction);
    machine_start(rpm);
    samples(20, 0.0, 0.0);
    samples(3000, -0.2, 0.6);
    double worst = 0.0;
    for (int k = 0; k < 20; k++) {
        sample(-0.2, 0.6);
        worst = fmax(worst, hypot(m.i_a.d + 0.2, m.i_a.q - 0.6));
    }
    return worst < 1e-3;
}

void test_ctl_deadbeat_is_stable_in_the_range_of_inductance_that_the_header_states(void)
{
    static const struct {
        double correction, low, high, too_high;
    } RANGES[] = {{0.05, 0.2, 1.88, 2.0}, {0.1, 0.2, 1.8, 1.9}, {0.2, 0.31, 1.65, 1.8}, {0.5, 0.58, 1.4, 1.55}};
    static const double SPEEDS[] = {0.0, 1000.0, -1000.0, 3000.0};
    for (size_t i = 0; i < COUNT_OF(RANGES); i++) {
        for (size_t n = 0; n < COUNT_OF(SPEEDS); n++) {
            const char *const text = at("correction %g, %g rpm", RANGES[i].correction, SPEEDS[n]);
            for (double l = RANGES[i].low; l < RANGES[i].high; l += 0.1) {
                TEST_ASSERT_TRUE_MESSAGE(is_stable(l, RANGES[i].correction, SPEEDS[n]), text);
            }
            TEST_ASSERT_TRUE_MESSAGE(is_stable(RANGES[i].high, RANGES[i].correction, SPEEDS[n]), text);
            TEST_ASSERT_FALSE_MESSAGE(is_stable(RANGES[i].too_high, RANGES[i].correction, SPEEDS[n]), text);
        }
    }
}

/* ---- what is not a number ---------------------------------------------------------------------------------------------- */

static const ctl_dq_t NOTHING = {(num_t)0, (num_t)0};

void test_ctl_deadbeat_current_that_is_not_finite_counts_as_predicted(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        for (int lost = 1; lost <= 3; lost++) { /* d, q, both */
            const wrong_t x = {1.3, 0.9, 0.7};
            start(x, 0.1);
            machine_start(1000.0);
            samples(37, -2.0, 6.0);
            ctl_deadbeat_t twin = deadbeat;
            ctl_dq_t       seen = in_units(m.i_a, AMP);
            ctl_dq_t       meant = seen;
            if ((lost & 1) != 0) {
                seen.d = NOT_FINITE[i];
                meant.d = twin.state.predicted.d;
            }
            if ((lost & 2) != 0) {
                seen.q = NOT_FINITE[i];
                meant.q = twin.state.predicted.q;
            }
            const ctl_dq_t ref = {num_of(-0.2), num_of(0.6)};
            const ctl_dq_t v = in_units(m.v_v, VOLT);

            const ctl_dq_t want = ctl_deadbeat_step(&twin, &meant, &ref, num_of(1.0), &v);
            const ctl_dq_t got = ctl_deadbeat_step(&deadbeat, &seen, &ref, num_of(1.0), &v);

            ASSERT_SAME_BITS(want, got);
            TEST_ASSERT_EQUAL_UINT32((lost == 3) ? 2U : 1U, deadbeat.state.rejected);
        }
    }
}

void test_ctl_deadbeat_goes_on_through_lost_measurements(void)
{
    start(TRUE_MODEL, 0.1);
    machine_start(1000.0);
    samples(50, -2.0, 6.0);
    for (int k = 0; k < 60; k++) {
        const ctl_dq_t lost = {NOT_FINITE[0], NOT_FINITE[0]};
        const ctl_dq_t ref = {num_of(-0.2), num_of(0.6)};
        const ctl_dq_t v = in_units(m.v_v, VOLT);
        const ctl_dq_t out = ctl_deadbeat_step(&deadbeat, &lost, &ref, num_of(m.rad_s / SPEED), &v);
        machine_sample();
        m.v_v.d = value_of(out.d) * VOLT;
        m.v_v.q = value_of(out.q) * VOLT;
    }

    /* nothing but its model for 6 ms */
    TEST_ASSERT_DOUBLE_WITHIN(0.02, -2.0, m.i_a.d);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 6.0, m.i_a.q);
}

void test_ctl_deadbeat_reference_that_is_not_finite_counts_as_the_last(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        start(TRUE_MODEL, 0.1);
        const ctl_dq_t meas = {num_of(0.1), num_of(0.2)};
        const ctl_dq_t ref = {num_of(-0.3), num_of(0.7)};
        const ctl_dq_t lost = {NOT_FINITE[i], NOT_FINITE[i]};
        (void)ctl_deadbeat_step(&deadbeat, &meas, &ref, num_of(1.0), &NOTHING);
        ctl_deadbeat_t twin = deadbeat;

        const ctl_dq_t want = ctl_deadbeat_step(&twin, &meas, &ref, num_of(1.0), &NOTHING);
        const ctl_dq_t got = ctl_deadbeat_step(&deadbeat, &meas, &lost, num_of(1.0), &NOTHING);

        ASSERT_SAME_BITS(want, got);
        TEST_ASSERT_EQUAL_UINT32(2U, deadbeat.state.rejected);
    }
}

void test_ctl_deadbeat_speed_and_voltage_that_are_not_finite_count_as_zero(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        start(TRUE_MODEL, 0.1);
        ctl_deadbeat_t twin = deadbeat;
        const ctl_dq_t meas = {num_of(0.1), num_of(0.2)};
        const ctl_dq_t lost = {NOT_FINITE[i], NOT_FINITE[i]};

        const ctl_dq_t want = ctl_deadbeat_step(&twin, &meas, &meas, (num_t)0, &NOTHING);
        const ctl_dq_t got = ctl_deadbeat_step(&deadbeat, &meas, &meas, NOT_FINITE[i], &lost);

        ASSERT_SAME_BITS(want, got);
        TEST_ASSERT_EQUAL_UINT32(3U, deadbeat.state.rejected);
    }
}

void test_ctl_deadbeat_counter_stops_at_its_end(void)
{
    const ctl_dq_t lost = {NOT_FINITE[0], NOT_FINITE[0]};
    deadbeat.state.rejected = UINT32_MAX - 1U;

    (void)ctl_deadbeat_step(&deadbeat, &lost, &lost, NOT_FINITE[0], &lost);

    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, deadbeat.state.rejected);
}

void test_ctl_deadbeat_voltage_and_correction_stay_within_their_limits_whatever_comes(void)
{
    ctl_deadbeat_params_t p = params_of(TRUE_MODEL, 0.5);
    noise_t               noise = {92U};
    p.v_max = num_of(3.0);
    p.c_max = num_of(0.25);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_deadbeat_init(&deadbeat, &p).status);
    for (int k = 0; k < 20000; k++) {
        const ctl_dq_t meas = {noise_nasty(&noise), noise_nasty(&noise)};
        const ctl_dq_t ref = {noise_nasty(&noise), noise_nasty(&noise)};
        const ctl_dq_t v = {noise_nasty(&noise), noise_nasty(&noise)};
        const ctl_dq_t out = ctl_deadbeat_step(&deadbeat, &meas, &ref, noise_nasty(&noise), &v);

        ASSERT_BOUNDED_AT(3.0, out.d, at("sample %d", k));
        ASSERT_BOUNDED_AT(3.0, out.q, at("sample %d", k));
        ASSERT_BOUNDED_AT(0.25, deadbeat.state.c.d, at("sample %d", k));
        ASSERT_BOUNDED_AT(0.25, deadbeat.state.c.q, at("sample %d", k));
    }
    /* and it recovers */
    ctl_dq_t last = NOTHING;
    for (int k = 0; k < 200; k++) {
        last = ctl_deadbeat_step(&deadbeat, &NOTHING, &NOTHING, (num_t)0, &NOTHING);
    }
    ASSERT_BOUNDED_AT(1.0, last.d, "afterwards");
    ASSERT_BOUNDED_AT(1.0, last.q, "afterwards");
}

/* ---- reset and configuration ---------------------------------------------------------------------------------------------- */

void test_ctl_deadbeat_reset_forgets_all_but_the_count(void)
{
    const wrong_t x = {1.3, 0.9, 0.7};
    start(x, 0.1);
    ctl_deadbeat_t fresh = deadbeat;
    machine_start(1000.0);
    samples(50, -2.0, 6.0);
    deadbeat.state.rejected = 5U;

    ctl_deadbeat_reset(&deadbeat.state);

    TEST_ASSERT_EQUAL_UINT32(5U, deadbeat.state.rejected);
    const ctl_dq_t lost = {NOT_FINITE[0], NOT_FINITE[0]};
    for (int k = 0; k < 3; k++) {
        const ctl_dq_t want = ctl_deadbeat_step(&fresh, &lost, &lost, num_of(0.5), &NOTHING);
        const ctl_dq_t got = ctl_deadbeat_step(&deadbeat, &lost, &lost, num_of(0.5), &NOTHING);
        ASSERT_SAME_BITS(want, got);
    }
}

void test_ctl_deadbeat_first_sample_after_a_reset_corrects_nothing(void)
{
    const ctl_dq_t meas = {num_of(0.5), num_of(-0.5)};
    start(TRUE_MODEL, 0.5);

    (void)ctl_deadbeat_step(&deadbeat, &meas, &meas, (num_t)0, &NOTHING);

    ASSERT_NUM_WITHIN(0.0, 0.0, deadbeat.state.c.d);
    ASSERT_NUM_WITHIN(0.0, 0.0, deadbeat.state.c.q);
}

static void assert_rejected(const ctl_deadbeat_params_t *p, ctl_status_t status, uint16_t field)
{
    samples(3, 1.0, 1.0);
    const ctl_deadbeat_t before = deadbeat;

    const ctl_diag_t got = ctl_deadbeat_init(&deadbeat, p);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(before, deadbeat);
}

/* Every number, what it may be, and the name it goes by. */
typedef struct {
    size_t   offset;
    double   least, below, above; /* above 0: no end to test */
    uint16_t field;
} number_t;

static const number_t NUMBERS[] = {
    {offsetof(ctl_deadbeat_params_t, r), 0.0, -0.001, 0.0, CTL_DEADBEAT_R},
    {offsetof(ctl_deadbeat_params_t, ld_ts), 0.001, 0.0, 0.0, CTL_DEADBEAT_LD},
    {offsetof(ctl_deadbeat_params_t, ts_ld), 0.001, 0.0, 0.0, CTL_DEADBEAT_LD},
    {offsetof(ctl_deadbeat_params_t, w_ld), 0.0, -0.001, 0.0, CTL_DEADBEAT_LD},
    {offsetof(ctl_deadbeat_params_t, lq_ts), 0.001, 0.0, 0.0, CTL_DEADBEAT_LQ},
    {offsetof(ctl_deadbeat_params_t, ts_lq), 0.001, 0.0, 0.0, CTL_DEADBEAT_LQ},
    {offsetof(ctl_deadbeat_params_t, w_lq), 0.0, -0.001, 0.0, CTL_DEADBEAT_LQ},
    {offsetof(ctl_deadbeat_params_t, w_psi), 0.0, -0.001, 0.0, CTL_DEADBEAT_PSI},
    {offsetof(ctl_deadbeat_params_t, correction), 0.0, -0.001, 0.501, CTL_DEADBEAT_CORRECTION},
    {offsetof(ctl_deadbeat_params_t, c_max), 0.001, 0.0, 0.0, CTL_DEADBEAT_LIMIT},
    {offsetof(ctl_deadbeat_params_t, v_max), 0.001, 0.0, 0.0, CTL_DEADBEAT_LIMIT},
};

void test_ctl_deadbeat_init_takes_every_number_within_its_range_and_no_other(void)
{
    for (size_t i = 0; i < COUNT_OF(NUMBERS); i++) {
        ctl_deadbeat_params_t p = params_of(TRUE_MODEL, 0.1);
        num_t *const          number = (num_t *)(void *)((char *)&p + NUMBERS[i].offset);
        *number = num_of(NUMBERS[i].least);
        TEST_ASSERT_EQUAL(CTL_OK, ctl_deadbeat_init(&deadbeat, &p).status);
        *number = num_of(NUMBERS[i].below);
        assert_rejected(&p, CTL_ERR_RANGE, NUMBERS[i].field);
        if (NUMBERS[i].above > 0.0) {
            *number = num_of(NUMBERS[i].above);
            assert_rejected(&p, CTL_ERR_RANGE, NUMBERS[i].field);
        }
        for (size_t n = 0; n < COUNT_OF(NOT_FINITE); n++) {
            *number = NOT_FINITE[n];
            assert_rejected(&p, CTL_ERR_RANGE, NUMBERS[i].field);
        }
    }
}

void test_ctl_deadbeat_init_without_a_pointer_says_so(void)
{
    const ctl_deadbeat_params_t p = params_of(TRUE_MODEL, 0.1);

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_deadbeat_init(NULL, &p));
    assert_rejected(NULL, CTL_ERR_NULL, 0U);
}

void test_ctl_deadbeat_init_clears_the_count(void)
{
    deadbeat.state.rejected = 5U;

    start(TRUE_MODEL, 0.1);

    TEST_ASSERT_EQUAL_UINT32(0U, deadbeat.state.rejected);
}

/* ---- without looking ------------------------------------------------------------------------------------------------------ */

void test_ctl_deadbeat_raw_is_the_same_for_numbers(void)
{
    start(TRUE_MODEL, 0.1);
    ctl_deadbeat_t twin = deadbeat;
    noise_t        noise = {97U};
    for (int k = 0; k < 300; k++) {
        const ctl_dq_t i = {num_of(noise_next(&noise)), num_of(noise_next(&noise))};
        const ctl_dq_t r = {num_of(noise_next(&noise)), num_of(noise_next(&noise))};
        const ctl_dq_t v = {num_of(noise_next(&noise)), num_of(noise_next(&noise))};
        const num_t    w = num_of(4.0 * noise_next(&noise));
        const ctl_dq_t want = ctl_deadbeat_step(&twin, &i, &r, w, &v);

        const ctl_dq_t got = ctl_deadbeat_step_unchecked(&deadbeat.params, &deadbeat.state, i, r, w, v);

        ASSERT_SAME_BITS(want, got);
        ASSERT_SAME_BITS(twin.state.predicted, deadbeat.state.predicted);
    }
}

void test_ctl_deadbeat_raw_is_bounded_and_recovers_whatever_comes(void)
{
    start(TRUE_MODEL, 0.1);
    noise_t noise = {98U};
    for (int k = 0; k < 3000; k++) {
        const bool     nasty = (k % 100) < 50;
        const ctl_dq_t i = {nasty ? noise_nasty(&noise) : num_of(0.1), nasty ? noise_nasty(&noise) : num_of(0.2)};
        const ctl_dq_t r = {num_of(0.1), num_of(0.2)};
        const ctl_dq_t out = ctl_deadbeat_step_unchecked(&deadbeat.params, &deadbeat.state, i, r, num_of(1.0), r);

        ASSERT_BOUNDED_AT(100.0, out.d, at("sample %d", k));
        ASSERT_BOUNDED_AT(100.0, out.q, at("sample %d", k));
        if ((k % 100) > 53) {
            ASSERT_BOUNDED_AT(50.0, deadbeat.state.predicted.q, at("sample %d", k));
        }
    }
}
