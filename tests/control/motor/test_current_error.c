/* control/motor/current_error.c on a balanced winding whose equations are solved here: phase currents through sensors with gains and
 * offsets, corrected by what the block has learned, and the voltages that the true currents take. Current counts 10 A, voltage 20 V. */
#include "tests/support/numeric.h"

#include "control/motor/current_error.h"
#include "tests/control/golden/current_error.h"

#define AMP 10.0
#define VOLT 20.0
#define SPEED 100.0 /* rad/s mechanical */
#define POLE_PAIRS 4.0
#define R_OHM 0.36
#define L_H 0.2e-3
#define PSI_WB 6.4e-3
#define EACH_S 2.0e-4 /* every second sample */
#define LIMIT_V 13.8

typedef struct {
    double re, im;
} c_t;
static c_t c_mul(c_t a, c_t b) { return (c_t){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
static c_t c_add(c_t a, c_t b) { return (c_t){a.re + b.re, a.im + b.im}; }
static c_t c_at(double rad) { return (c_t){cos(rad), sin(rad)}; }
static c_t c_times(double x, c_t a) { return (c_t){x * a.re, x * a.im}; }

static ctl_current_error_t block;
static ctl_turn_log_t      turns;

/* What the machine is like, and what its sensors add. */
typedef struct {
    bool   three;
    double offset_a[3], gain[3];
    c_t    forwards_a, backwards_a, dc_a; /* True currents: with the rotor, against it, standing. */
    double rpm, theta;                    /* Electrical angle. */
    double delay_periods;                 /* From a sample to the middle of its voltage, as it is; the block knows of 0.5. */
} machine_t;
static machine_t m;

static ctl_current_error_params_t valid_params(void)
{
    const ctl_current_error_params_t p = {
        .gain = 0.5f,
        .least_current = (float)(0.2 / AMP),
        .offset_max = (float)(1.0 / AMP),
        .gain_max = 0.2f,
        .r = (float)(R_OHM * AMP / VOLT),
        .w_l = (float)(L_H * POLE_PAIRS * SPEED * AMP / VOLT),
        .turns_per_sample = (float)(POLE_PAIRS * SPEED * EACH_S / TWO_PI),
        .advance_turns = (float)(0.5 * POLE_PAIRS * SPEED * 0.5 * EACH_S / TWO_PI),
        .pole_pairs = 4U,
        .three = m.three,
    };
    return p;
}

static void begin(ctl_current_error_params_t p)
{
    TEST_ASSERT_EQUAL(CTL_OK, ctl_current_error_init(&block, &p).status);
    memset(&turns, 0, sizeof turns);
}

void setUp(void)
{
    m = (machine_t){
        .offset_a = {0.2, 0.05, 0.0}, .gain = {1.1, 0.9, 1.0}, .forwards_a = {0.2, 3.0}, .rpm = 255.0, .delay_periods = 0.5};
    begin(valid_params());
}
void tearDown(void) {}

static double we(void) { return m.rpm * TWO_PI / 60.0 * POLE_PAIRS; }

/* What the drive sees of the true current: sensors, correction, Clarke. */
static c_t seen_a(c_t true_a)
{
    double x[3];
    for (int k = 0; k < 3; k++) {
        const double phase = true_a.re * cos(k * TWO_PI / 3.0) + true_a.im * sin(k * TWO_PI / 3.0);
        x[k] = (phase * m.gain[k] + m.offset_a[k]) / (double)block.state.gain[k] -
               (double)block.state.offset[k] * AMP / (double)block.state.gain[k];
    }
    if (!m.three) {
        x[2] = -x[0] - x[1];
    }
    return (c_t){(2.0 * x[0] - x[1] - x[2]) / 3.0, (x[1] - x[2]) / sqrt(3.0)};
}

/* Currents of the machine at an angle, and the voltage that they take there. */
static c_t true_current_a(double theta)
{
    return c_add(m.dc_a, c_add(c_mul(m.forwards_a, c_at(theta)), c_mul(m.backwards_a, c_at(-theta))));
}
static c_t voltage_v(double theta)
{
    const c_t f = c_mul((c_t){R_OHM, we() * L_H}, m.forwards_a);
    const c_t b = c_mul((c_t){R_OHM, -we() * L_H}, m.backwards_a);
    const c_t e = {0.0, we() * PSI_WB};
    return c_add(c_times(R_OHM, m.dc_a), c_add(c_mul(c_add(f, e), c_at(theta)), c_mul(b, c_at(-theta))));
}

static ctl_dq_t in_frame(c_t x, double theta, double base)
{
    const c_t y = c_mul(x, c_at(-theta));
    return (ctl_dq_t){num_of(y.re / base), num_of(y.im / base)};
}

static angle_t angle_of(double rad) { return (angle_t)(int64_t)llround((rad / TWO_PI - floor(rad / TWO_PI)) * TURN_STEPS); }

static ctl_turn_now_t now_at(double theta)
{
    const ctl_turn_now_t now = {.i = in_frame(seen_a(true_current_a(theta)), theta, AMP),
                                .v = in_frame(voltage_v(theta), theta, VOLT),
                                .i_mean = in_frame(c_mul(m.forwards_a, c_at(theta)), theta, AMP),
                                .speed = num_of(m.rpm * TWO_PI / 60.0 / SPEED),
                                .v_limit = num_of(LIMIT_V / VOLT)};
    return now;
}

/* One sample that counts. The voltage acts over the period that begins here, in which the rotor goes on; the frame that it was
 * commanded in is half a period ahead. @return the verdict on a turn that is complete, or -1 */
static int sample(void)
{
    const double step = we() * 0.5 * EACH_S;
    const c_t    v = voltage_v(m.theta + m.delay_periods * step);
    ctl_turn_note_voltage_unchecked(&turns, in_frame(v, m.theta + 0.5 * step, VOLT), angle_of(m.theta),
                                    angle_of(m.theta / POLE_PAIRS));
    ctl_turn_note_current_unchecked(&turns, in_frame(seen_a(true_current_a(m.theta)), m.theta, AMP));
    int verdict = -1;
    if (turns.ready != 0U) {
        const ctl_turn_now_t now = now_at(m.theta);
        verdict = (int)ctl_current_error_learn(&block, ctl_turn_complete(&turns), &now);
        ctl_turn_clear(&turns);
        turns.ready = 0U;
    }
    m.theta += we() * EACH_S;
    return verdict;
}

static int turn(void)
{
    int verdict = -1;
    for (unsigned k = 0U; (k < 20000U) && (verdict < 0); k++) {
        verdict = sample();
    }
    return verdict;
}

static void live(double seconds)
{
    for (double t = 0.0; t < seconds; t += EACH_S) {
        (void)sample();
    }
}

static void assert_known(double tolerance_a, double tolerance, const char *text)
{
    const int    sensors = m.three ? 3 : 2;
    const double mean = m.three ? (m.gain[0] + m.gain[1] + m.gain[2]) / 3.0 : (m.gain[0] + m.gain[1]) / 2.0;
    double       left[3], common = 0.0; /* what is left of the offsets, as the current that it looks like */
    for (int k = 0; k < sensors; k++) {
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance, m.gain[k] / mean, (double)block.state.gain[k], text); /* their ratios */
        left[k] = (m.offset_a[k] - (double)block.state.offset[k] * AMP) / m.gain[k];
        common += m.three ? left[k] / 3.0 : 0.0; /* the same on three phases acts on no vector */
    }
    for (int k = 0; k < sensors; k++) {
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(tolerance_a, common, left[k], text);
    }
}

/* ---- one turn, and many --------------------------------------------------------------------------------------------------- */

void test_ctl_current_error_takes_half_of_what_it_sees_in_one_turn_as_in_golden(void)
{
    for (size_t i = 0; i < COUNT_OF(GOLDEN_CURRENT_ERROR); i++) {
        const golden_current_error_t g = GOLDEN_CURRENT_ERROR[i];
        setUp();
        m.three = g.three != 0;
        m.offset_a[0] = g.oa;
        m.offset_a[1] = g.ob;
        m.offset_a[2] = g.oc;
        m.gain[0] = g.ga;
        m.gain[1] = g.gb;
        m.gain[2] = g.gc;
        m.forwards_a = c_times(3.0, c_at(0.3));
        m.rpm = 60.0 / (500.0 * EACH_S * POLE_PAIRS); /* 500 samples a turn */
        begin(valid_params());
        int verdict = 0;
        while (verdict != CTL_CURRENT_ERROR_LEARNS) {
            /* I as the drive sees it, which golden has, too */
            verdict = turn();
            TEST_ASSERT_NOT_EQUAL(CTL_CURRENT_ERROR_BOUND, verdict);
        }
        const double o[3] = {g.learned_oa, g.learned_ob, g.learned_oc};
        const double k[3] = {g.learned_ga, g.learned_gb, g.learned_gc};
        for (int x = 0; x < (m.three ? 3 : 2); x++) {
            /* sums of 500 floats; now_at gives the true I, which the gains change by up to a tenth of n */
            ASSERT_DOUBLE_WITHIN_AT(3e-5, o[x], (double)block.state.offset[x] * AMP, at("case %u", (unsigned)i));
            ASSERT_DOUBLE_WITHIN_AT(0.06 * fabs(k[x] - 1.0) + 3e-5, k[x], (double)block.state.gain[x],
                                    at("case %u", (unsigned)i));
        }
    }
}

void test_ctl_current_error_knows_the_errors_after_two_seconds_at_every_speed_in_both_directions(void)
{
    static const double RPM[] = {37.0, 150.0, -255.0, 900.0, -1203.0, 2001.0};
    for (size_t i = 0; i < COUNT_OF(RPM); i++) {
        for (int three = 0; three < 2; three++) {
            setUp();
            m.three = three != 0;
            m.offset_a[2] = m.three ? -0.1 : 0.0;
            m.gain[2] = m.three ? 1.04 : 1.0;
            m.rpm = RPM[i];
            m.forwards_a.im = (m.rpm < 0.0) ? -3.0 : 3.0;
            begin(valid_params());
            live((fabs(m.rpm) < 50.0) ? 6.0 : 2.0);
            /* the turn is not a whole number of samples: 1 % of 3 A at 20 samples a turn is the trapezoidal rule */
            assert_known(0.004, 0.002, at("%d sensors, %d r/min", three + 2, (int)RPM[i]));
        }
    }
}

void test_ctl_current_error_is_not_misled_by_currents_that_are_really_there(void)
{
    m.dc_a = (c_t){0.3, -0.2};
    m.backwards_a = (c_t){-0.1, 0.25};
    live(3.0);
    assert_known(0.002, 0.001, "true dc and negative sequence");
}

/* 30 samples a turn and less: what they cover too much, and the angle by which the voltage is ahead, are no longer small. */
void test_ctl_current_error_is_not_misled_by_them_when_a_turn_has_few_samples_either(void)
{
    static const double RPM[] = {-1203.0, 1203.0, 2001.0};
    for (size_t i = 0; i < COUNT_OF(RPM); i++) {
        setUp();
        m.three = true; /* these show both parts of the negative sequence */
        m.offset_a[2] = -0.1;
        m.gain[2] = 1.04;
        m.dc_a = (c_t){0.6, -0.4};
        m.backwards_a = (c_t){-0.3, 0.4};
        m.rpm = RPM[i];
        m.forwards_a.im = (m.rpm < 0.0) ? -3.0 : 3.0;
        begin(valid_params());
        live(2.0);
        /* A turn ends between two samples, and is corrected there by the fundamental alone: 2 % of what is really there. */
        assert_known(0.012, 0.005, at("%d r/min", (int)RPM[i]));
    }
}

void test_ctl_current_error_ends_at_the_same_place_with_a_wrong_resistance_inductance_and_delay(void)
{
    static const double OFF[][3] = {{0.7, 1.0, 0.5}, {1.3, 1.0, 0.5}, {1.0, 0.5, 0.5}, {1.3, 1.6, 1.5}};
    for (size_t i = 0; i < COUNT_OF(OFF); i++) {
        setUp();
        ctl_current_error_params_t p = valid_params();
        p.r *= (float)OFF[i][0];
        p.w_l *= (float)OFF[i][1];
        begin(p);
        m.delay_periods = OFF[i][2];
        /* a current loop leaves no error in what it sees: the true current has the error the other way round */
        for (unsigned k = 0U; k < 60U; k++) {
            const double da = (m.offset_a[0] - (double)block.state.offset[0] * AMP);
            const double db = (m.offset_a[1] - (double)block.state.offset[1] * AMP);
            m.dc_a = (c_t){-da, -(da + 2.0 * db) / sqrt(3.0)};
            (void)turn();
        }
        assert_known(0.01, 0.004, at("case %u", (unsigned)i));
    }
}

void test_ctl_current_error_takes_smaller_steps_where_the_voltage_shows_seven_times_the_error(void)
{
    ctl_current_error_params_t p = valid_params();
    p.r /= 7.0f; /* half of seven times the error is more than the error: it would swing up */
    begin(p);
    for (unsigned k = 0U; k < 200U; k++) {
        const double da = (m.offset_a[0] - (double)block.state.offset[0] * AMP);
        const double db = (m.offset_a[1] - (double)block.state.offset[1] * AMP);
        m.dc_a = (c_t){-da, -(da + 2.0 * db) / sqrt(3.0)};
        (void)turn();
    }
    assert_known(0.01, 0.004, "R / 7");
}

/* ---- held ---------------------------------------------------------------------------------------------------------------- */

static void assert_untouched(int verdict, int wanted, const char *text)
{
    TEST_ASSERT_EQUAL_INT_MESSAGE(wanted, verdict, text);
    TEST_ASSERT_EQUAL_FLOAT_MESSAGE(0.0f, block.state.offset[0], text);
    TEST_ASSERT_EQUAL_FLOAT_MESSAGE(1.0f, block.state.gain[0], text);
}

void test_ctl_current_error_holds_and_says_why(void)
{
    m.forwards_a = (c_t){0.0, 0.15};
    (void)turn();
    (void)turn();
    assert_untouched(turn(), CTL_CURRENT_ERROR_SMALL, "0.15 A");

    setUp();
    m.rpm = 14.0;
    assert_untouched(turn(), CTL_CURRENT_ERROR_SLOW, "1.07 s a turn");
    assert_untouched(turn(), CTL_CURRENT_ERROR_SLOW, "and the next");

    setUp();
    m.rpm = 5000.0;
    (void)turn();
    (void)turn();
    assert_untouched(turn(), CTL_CURRENT_ERROR_FAST, "333 Hz");

    setUp();
    assert_untouched(turn(), CTL_CURRENT_ERROR_NOTHING, "not from the beginning");
    assert_untouched(turn(), CTL_CURRENT_ERROR_UNSTEADY, "nothing to compare with");
    for (unsigned k = 0U; k < 10U; k++) {
        m.rpm *= 1.12;
        assert_untouched(turn(), CTL_CURRENT_ERROR_UNSTEADY, "faster by 12 % a turn");
    }
}

void test_ctl_current_error_holds_at_the_voltage_limit(void)
{
    (void)turn();
    (void)turn();
    ctl_turn_now_t now = now_at(0.0);
    now.v_limit = num_of(hypot(value_of(now.v.d), value_of(now.v.q)) * 1.02);
    ctl_turn_t complete = {.samples = block.state.samples, .whole = true, .end = block.state.end};
    complete.end_m = block.state.end_m + 0x40000000U; /* an electrical turn of four */
    assert_untouched((int)ctl_current_error_learn(&block, &complete, &now), CTL_CURRENT_ERROR_VOLTAGE, "2 % below it");
}

/* Swinging over the border at 10 r/min: the turn seems to be over with every swing. */
void test_ctl_current_error_takes_no_swinging_for_a_turn(void)
{
    for (unsigned k = 0U; k < 60000U; k++) {
        const double theta = 0.4 * sin(k * 0.01);
        ctl_turn_note_voltage_unchecked(&turns, in_frame((c_t){0.5, 0.1}, theta, VOLT), angle_of(theta),
                                        angle_of(theta / POLE_PAIRS));
        ctl_turn_note_current_unchecked(&turns, in_frame((c_t){3.0, 1.0}, theta, AMP));
        if (turns.ready != 0U) {
            ctl_turn_now_t now = now_at(theta);
            now.speed = num_of(0.4 * 0.01 * cos(k * 0.01) / EACH_S / POLE_PAIRS / SPEED);
            const int verdict = (int)ctl_current_error_learn(&block, ctl_turn_complete(&turns), &now);
            TEST_ASSERT_TRUE((verdict == CTL_CURRENT_ERROR_UNSTEADY) || (verdict == CTL_CURRENT_ERROR_NOTHING));
            ctl_turn_clear(&turns);
            turns.ready = 0U;
        }
    }
    TEST_ASSERT_EQUAL_FLOAT(0.0f, block.state.offset[0]);
}

void test_ctl_current_error_does_not_learn_from_a_turn_with_a_missing_sample_or_one_that_nobody_read_in_time(void)
{
    (void)turn();
    (void)turn();
    (void)sample();
    ctl_turn_spoil(&turns);
    assert_untouched(turn(), CTL_CURRENT_ERROR_NOTHING, "spoiled");
    assert_untouched(turn(), CTL_CURRENT_ERROR_UNSTEADY, "the next has none before it");

    setUp();
    for (unsigned k = 0U; k < 3000U; k++) { /* without the main loop */
        ctl_turn_note_voltage_unchecked(&turns, in_frame(voltage_v(m.theta), m.theta, VOLT), angle_of(m.theta),
                                        angle_of(m.theta / POLE_PAIRS));
        ctl_turn_note_current_unchecked(&turns, in_frame(seen_a(true_current_a(m.theta)), m.theta, AMP));
        m.theta += we() * EACH_S;
    }
    TEST_ASSERT_EQUAL_UINT16(1U, turns.ready);
    assert_untouched(turn(), CTL_CURRENT_ERROR_NOTHING, "the oldest, of which the beginning is missing");
    assert_untouched(turn(), CTL_CURRENT_ERROR_NOTHING, "several in one");
    TEST_ASSERT_EQUAL_INT(CTL_CURRENT_ERROR_UNSTEADY, turn());
    TEST_ASSERT_EQUAL_INT(CTL_CURRENT_ERROR_LEARNS, turn());
}

/* ---- bounds, and what is no number ------------------------------------------------------------------------------------------ */

void test_ctl_current_error_stays_within_its_bounds_and_says_that_it_stands_there(void)
{
    m.offset_a[0] = 2.5;
    m.gain[0] = 1.4;
    m.gain[1] = 0.6;
    int verdict = 0;
    for (unsigned k = 0U; k < 100U; k++) {
        verdict = turn();
        for (int x = 0; x < 2; x++) {
            TEST_ASSERT_TRUE(fabs((double)block.state.offset[x]) * AMP <= 1.0 + 1e-6);
            TEST_ASSERT_TRUE(fabs((double)block.state.gain[x] - 1.0) <= 0.2 + 1e-6);
        }
    }
    TEST_ASSERT_EQUAL_INT(CTL_CURRENT_ERROR_BOUND, verdict);
}

void test_ctl_current_error_keeps_the_sum_of_the_gains(void)
{
    noise_t noise = {7U};
    for (unsigned k = 0U; k < 400U; k++) { /* as a noise that never ends would move it */
        m.backwards_a = (c_t){noise_next(&noise), noise_next(&noise)};
        m.gain[0] = 1.0 + 0.2 * noise_next(&noise);
        (void)turn();
    }
    TEST_ASSERT_FLOAT_WITHIN(2e-5f, 2.0f, block.state.gain[0] + block.state.gain[1]);
}

void test_ctl_current_error_begins_with_what_it_is_given_cut_to_its_bounds(void)
{
    const float offset[3] = {0.03f, -0.5f, NAN};
    const float gain[3] = {1.05f, 0.2f, INFINITY};
    ctl_current_error_reset(&block, offset, gain);
    TEST_ASSERT_EQUAL_FLOAT(0.03f, block.state.offset[0]);
    TEST_ASSERT_EQUAL_FLOAT(-0.1f, block.state.offset[1]);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, block.state.offset[2]);
    TEST_ASSERT_EQUAL_FLOAT(1.05f, block.state.gain[0]);
    TEST_ASSERT_EQUAL_FLOAT(0.8f, block.state.gain[1]);
    TEST_ASSERT_EQUAL_FLOAT(1.2f, block.state.gain[2]);
}

void test_ctl_current_error_any_turn_leaves_bounded_estimates(void)
{
    noise_t noise = {3U};
    for (unsigned k = 0U; k < 5000U; k++) {
        ctl_turn_t       t = {.samples = 16U + noise_pick(&noise, 30U), .whole = true, .end = block.state.end};
        ctl_sum_t *const sum[] = {&t.i_alpha, &t.i_beta, &t.v_alpha, &t.v_beta, &t.i_re, &t.i_im, &t.v_re, &t.v_im};
        for (size_t x = 0; x < COUNT_OF(sum); x++) {
            *sum[x] = (ctl_sum_t)noise_nasty(&noise);
        }
        t.end_m = block.state.end_m + 0x40000000U;
        const ctl_turn_now_t now = {.i = {noise_nasty(&noise), noise_nasty(&noise)},
                                    .v = {noise_nasty(&noise), noise_nasty(&noise)},
                                    .i_mean = {noise_nasty(&noise), noise_nasty(&noise)},
                                    .speed = num_of(3.0),
                                    .v_limit = NUM_MAX};
        (void)ctl_current_error_learn(&block, &t, &now);
        for (int x = 0; x < 3; x++) {
            TEST_ASSERT_TRUE(fabs((double)block.state.offset[x]) <= 0.1 + 1e-6);
            TEST_ASSERT_TRUE(fabs((double)block.state.gain[x] - 1.0) <= 0.2 + 1e-6);
        }
    }
}

void test_ctl_current_error_refuses_parameters_that_cannot_be(void)
{
    static const float BAD[] = {NAN, INFINITY, -INFINITY, -1.0f};
    for (size_t k = 0; k < COUNT_OF(BAD); k++) {
        for (uint16_t field = CTL_CURRENT_ERROR_GAIN; field <= CTL_CURRENT_ERROR_SPEED; field++) {
            ctl_current_error_params_t p = valid_params();
            float *const of[] = {NULL, &p.gain, &p.least_current, &p.offset_max, &p.gain_max, &p.r, &p.w_l, &p.turns_per_sample};
            *of[field] = BAD[k];
            const ctl_diag_t d = ctl_current_error_check(&p);
            TEST_ASSERT_EQUAL(CTL_ERR_RANGE, d.status);
            TEST_ASSERT_EQUAL_UINT16(field, d.field);
        }
    }
    ctl_current_error_params_t p = valid_params();
    p.pole_pairs = 0U;
    TEST_ASSERT_EQUAL_UINT16(CTL_CURRENT_ERROR_POLE_PAIRS, ctl_current_error_check(&p).field);
    p = valid_params();
    p.r = 0.0f;
    TEST_ASSERT_EQUAL_UINT16(CTL_CURRENT_ERROR_R, ctl_current_error_check(&p).field);
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_current_error_init(NULL, &p));
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_current_error_init(&block, NULL));
}

void test_ctl_current_error_begins_with_nothing_of_a_turn_before(void)
{
    memset(&block.state, 0xA5, sizeof block.state);
    begin(valid_params());
    const ctl_current_error_state_t *const s = &block.state;
    for (int k = 0; k < 4; k++) {
        TEST_ASSERT_EQUAL_FLOAT(0.0f, s->residual[k]);
    }
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_EQUAL_FLOAT(0.0f, s->offset[k]);
        TEST_ASSERT_EQUAL_FLOAT(1.0f, s->gain[k]);
    }
    TEST_ASSERT_EQUAL_FLOAT(1.0f, s->share[0]);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, s->share[1]);
    TEST_ASSERT_EQUAL_UINT32(0U, s->end);
    TEST_ASSERT_EQUAL_UINT32(0U, s->end_m);
    TEST_ASSERT_EQUAL_UINT32(0U, s->samples);
    TEST_ASSERT_EQUAL_UINT32(0U, s->rejected);
    TEST_ASSERT_EQUAL(CTL_CURRENT_ERROR_NOTHING, s->verdict);
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_current_error_init(NULL, NULL));
}

/* Each alone: an offset of 2.5 A where 1 A is the most, a gain of 1.5 beside 0.5 where 20 % are. */
void test_ctl_current_error_says_that_it_stands_at_a_bound_whichever_it_is(void)
{
    for (int which = 0; which < 3; which++) {
        setUp();
        m.offset_a[0] = (which == 0) ? 2.5 : 0.0;
        m.offset_a[1] = (which == 1) ? 2.5 : 0.0;
        m.gain[0] = (which == 2) ? 1.5 : 1.0;
        m.gain[1] = (which == 2) ? 0.5 : 1.0;
        int verdict = 0;
        for (unsigned k = 0U; k < 12U; k++) {
            verdict = turn();
        }
        TEST_ASSERT_EQUAL_INT_MESSAGE(CTL_CURRENT_ERROR_BOUND, verdict, at("case %d", which));
    }
}

/* A turn like the last one, without a sum of anything, at the voltage limit: VOLTAGE says that it counts as one. */
typedef struct {
    double   turns_by_speed, more_travel, more_angle; /* of a turn */
    unsigned samples;
} strange_t;

static int verdict_on(strange_t x)
{
    setUp();
    block.state.samples = 300U;
    block.state.end = 0x10000000U;
    block.state.end_m = 0x20000000U;
    const int  sign = (x.turns_by_speed < 0.0) ? -1 : 1;
    ctl_turn_t t = {.samples = (uint16_t)x.samples, .whole = true};
    t.end = block.state.end + (angle_t)(int32_t)llround(x.more_angle * TURN_STEPS);
    t.end_m = block.state.end_m + (angle_t)(int32_t)llround((sign + x.more_travel) * TURN_STEPS / POLE_PAIRS);
    ctl_turn_now_t now = now_at(0.0);
    now.speed = num_of(x.turns_by_speed / (double)block.params.turns_per_sample / x.samples);
    now.v_limit = num_of(0.0);
    return (int)ctl_current_error_learn(&block, &t, &now);
}

void test_ctl_current_error_takes_for_a_turn_what_the_shaft_the_angle_and_the_speed_say_is_one(void)
{
    static const strange_t ONE[] = {{1.0, 0.0, 0.0, 300U},   {-1.0, 0.0, 0.0, 300U},  {0.21, 0.0, 0.0, 300U},
                                    {4.9, 0.0, 0.0, 300U},   {-0.21, 0.0, 0.0, 300U}, {1.0, 0.12, 0.0, 300U},
                                    {1.0, -0.12, 0.0, 300U}, {-1.0, 0.12, 0.0, 300U}, {1.0, 0.0, 0.12, 300U},
                                    {1.0, 0.0, -0.12, 300U}, {1.0, 0.0, 0.0, 329U},   {1.0, 0.0, 0.0, 273U}};
    static const strange_t NONE[] = {{0.19, 0.0, 0.0, 300U}, {5.1, 0.0, 0.0, 300U},   {-0.19, 0.0, 0.0, 300U},
                                     {1.0, 0.13, 0.0, 300U}, {1.0, -0.13, 0.0, 300U}, {-1.0, -0.13, 0.0, 300U},
                                     {1.0, 0.0, 0.13, 300U}, {1.0, 0.0, -0.13, 300U}, {1.0, 0.0, 0.0, 334U},
                                     {1.0, 0.0, 0.0, 272U},  {1.0, -1.0, 0.0, 300U},  {1.0, -2.0, 0.0, 300U}};
    for (size_t k = 0; k < COUNT_OF(ONE); k++) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(CTL_CURRENT_ERROR_VOLTAGE, verdict_on(ONE[k]), at("one, case %u", (unsigned)k));
    }
    for (size_t k = 0; k < COUNT_OF(NONE); k++) {
        TEST_ASSERT_EQUAL_INT_MESSAGE(CTL_CURRENT_ERROR_UNSTEADY, verdict_on(NONE[k]), at("none, case %u", (unsigned)k));
    }
}

/* 1e6 is far beyond any current: such a sum is counted, and nothing is learned from it. */
void test_ctl_current_error_rejects_a_turn_whose_currents_cannot_be(void)
{
    const double one = per_numeric(1.0, 1.0 / FIXED_STEP);
    for (int which = 0; which < 8; which++) {
        for (int beyond = 0; beyond < 2; beyond++) {
            setUp();
            block.state.samples = 300U;
            ctl_turn_t       t = {.samples = 300U, .whole = true, .end = 0U, .end_m = 0x40000000U};
            ctl_sum_t *const sum[] = {&t.i_alpha, &t.i_beta, &t.i_re, &t.i_im};
            *sum[which / 2] = (ctl_sum_t)(300.0 * one * ((which % 2) ? -1.0 : 1.0) * (beyond ? 1.2e6 : 0.8e6));
            ctl_turn_now_t now = now_at(0.0);
            now.i = now.v = (ctl_dq_t){(num_t)0, (num_t)0};
            now.v_limit = num_of(1.0);
            now.speed = num_of(1.0 / 300.0 / (double)block.params.turns_per_sample);
            const int verdict = (int)ctl_current_error_learn(&block, &t, &now);
            TEST_ASSERT_EQUAL_INT_MESSAGE(beyond ? CTL_CURRENT_ERROR_UNSTEADY : CTL_CURRENT_ERROR_BOUND, verdict,
                                          at("sum %d", which));
            TEST_ASSERT_EQUAL_UINT32(beyond ? 1U : 0U, block.state.rejected);
        }
    }
}

void test_ctl_current_error_takes_the_ends_of_each_range(void)
{
    static const float END[][2] = {{1.0e-6f, 1.0f},   {1.0e-9f, 1.0e6f}, {0.0f, 1.0e6f},     {0.0f, 0.5f},
                                   {1.0e-9f, 1.0e9f}, {0.0f, 1.0e9f},    {1.0e-12f, 1.0e6f}, {-1.0e6f, 1.0e6f}};
    for (size_t k = 0; k < COUNT_OF(END); k++) {
        for (int side = 0; side < 2; side++) {
            ctl_current_error_params_t p = valid_params();
            float *const               of[] = {&p.gain, &p.least_current, &p.offset_max,       &p.gain_max,
                                               &p.r,    &p.w_l,           &p.turns_per_sample, &p.advance_turns};
            const float                end = END[k][side];
            *of[k] = end;
            TEST_ASSERT_EQUAL_MESSAGE(CTL_OK, ctl_current_error_check(&p).status, at("row %u, side %d", (unsigned)k, side));
            *of[k] = (side == 0) ? (end - 0.2f * fmaxf(fabsf(end), 1.0e-12f)) : (end * 1.2f);
            const ctl_diag_t d = ctl_current_error_check(&p);
            TEST_ASSERT_EQUAL_MESSAGE(CTL_ERR_RANGE, d.status, at("beyond row %u, side %d", (unsigned)k, side));
        }
    }
    ctl_current_error_params_t p = valid_params();
    p.pole_pairs = 1U;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_current_error_check(&p).status);
    p.pole_pairs = 0U;
    ASSERT_DIAG(CTL_ERR_RANGE, CTL_CURRENT_ERROR_POLE_PAIRS, 0.0, ctl_current_error_check(&p));
}
