/* control/motor/plausibility.c beside a salient machine integrated in double precision: no contradiction in any motion of the machine
 * that the parameters describe, what each tolerance allows and no more, and every wrong signal. Currents count 10 A, voltages
 * 100 V, speeds 100 rad/s, fluxes 0.02 Wb. */
#include "tests/support/numeric.h"

#include "control/motor/plausibility.h"

#define TS_S 1e-4
#define AMP 10.0
#define VOLT 100.0
#define SPEED 100.0
#define FLUX 0.02
#define R_OHM 0.5
#define LD_H 0.9e-3
#define LQ_H 1.2e-3
#define PSI_WB 0.0594
#define POLE_PAIRS 5.0
#define VDC_V 310.0

typedef struct {
    double rest_a, r, l, psi, volt, dc, late; /* Current, and shares of what each tolerance stands for. */
} tolerance_t;
static const tolerance_t NARROW = {.rest_a = 0.05};

static ctl_plausibility_t        check;
static ctl_plausibility_params_t params_of(tolerance_t t)
{
    const ctl_plausibility_params_t p = {.ld = num_of(LD_H * AMP / FLUX),
                                         .lq = num_of(LQ_H * AMP / FLUX),
                                         .psi = num_of(PSI_WB / FLUX),
                                         .r_half = num_of(0.5 * TS_S * R_OHM * AMP / FLUX),
                                         .v = num_of(TS_S * VOLT / FLUX),
                                         .rest = num_of(0.25 * t.rest_a * LQ_H / FLUX),
                                         .per_current = num_of(t.r * TS_S * R_OHM * AMP / FLUX),
                                         .per_change = num_of(t.l * LQ_H * AMP / FLUX),
                                         .per_speed = num_of(t.psi * PSI_WB * POLE_PAIRS * SPEED * TS_S / FLUX),
                                         .per_volt = num_of(t.volt * TS_S * VOLT / FLUX),
                                         .per_dc = num_of(t.dc * TS_S * VOLT / FLUX),
                                         .per_volt_change = num_of(t.late * TS_S * VOLT / FLUX)};
    return p;
}

static void start(tolerance_t t)
{
    const ctl_plausibility_params_t p = params_of(t);
    TEST_ASSERT_EQUAL(CTL_OK, ctl_plausibility_init(&check, &p).status);
}

/* ---- the machine, in the frame of the stator: d flux / dt = v - R i -------------------------------------------------------- */

typedef struct {
    double alpha, beta;
} ab_t;

static struct {
    double r, l, psi; /* True ones over those of the parameters. */
    double theta_e, rad_s, rad_s2;
    ab_t   flux, acting;
    double gain[2], error_a[2]; /* Of the sensors of phases a and b. */
    double lost;                /* Share of the voltage that does not arrive. */
} m;

static void current_of(ab_t flux, double theta_e, double *d, double *q)
{
    const double fd = flux.alpha * cos(theta_e) + flux.beta * sin(theta_e);
    const double fq = flux.beta * cos(theta_e) - flux.alpha * sin(theta_e);
    *d = (fd - m.psi * PSI_WB) / (m.l * LD_H);
    *q = fq / (m.l * LQ_H);
}

static ab_t slope(ab_t flux, double theta_e)
{
    double d, q;
    current_of(flux, theta_e, &d, &q);
    const double part = 1.0 - m.lost;
    const ab_t   v = {part * m.acting.alpha - m.r * R_OHM * (d * cos(theta_e) - q * sin(theta_e)),
                      part * m.acting.beta - m.r * R_OHM * (d * sin(theta_e) + q * cos(theta_e))};
    return v;
}

static void machine_start(double rad_s)
{
    memset(&m, 0, sizeof m);
    m.r = m.l = m.psi = m.gain[0] = m.gain[1] = 1.0;
    m.rad_s = rad_s;
    m.flux.alpha = PSI_WB;
}

static void machine_period(void)
{
    const double h = TS_S / 20.0;
    for (int n = 0; n < 20; n++) { /* middle point */
        const double half = m.theta_e + 0.5 * h * POLE_PAIRS * m.rad_s;
        const ab_t   k1 = slope(m.flux, m.theta_e);
        const ab_t   mid = {m.flux.alpha + 0.5 * h * k1.alpha, m.flux.beta + 0.5 * h * k1.beta};
        const ab_t   k2 = slope(mid, half);
        m.flux.alpha += h * k2.alpha;
        m.flux.beta += h * k2.beta;
        m.theta_e += h * POLE_PAIRS * (m.rad_s + 0.5 * h * m.rad_s2);
        m.rad_s += h * m.rad_s2;
    }
}

/* A sample, and a period under voltages that jump about at random. @return what the block says. */
static uint32_t seed;
static double   noise(void) /* +-1 */
{
    seed = (seed * 1664525U) + 1013904223U;
    return ((double)(seed >> 8) / 8388608.0) - 1.0;
}

static bool sample(double volt_v)
{
    double d, q;
    current_of(m.flux, m.theta_e, &d, &q);
    const double alpha = d * cos(m.theta_e) - q * sin(m.theta_e);
    const double beta = d * sin(m.theta_e) + q * cos(m.theta_e);
    const double a = m.gain[0] * alpha + m.error_a[0]; /* two sensors: c is the negative sum */
    const double b = m.gain[1] * (0.5 * (-alpha + sqrt(3.0) * beta)) + m.error_a[1];
    const double read_beta = (a + 2.0 * b) / sqrt(3.0);
    const double emf = POLE_PAIRS * m.rad_s * PSI_WB;
    const ab_t   v = {volt_v * noise() - emf * sin(m.theta_e), volt_v * noise() + emf * cos(m.theta_e)};

    const ctl_plausibility_in_t in = {.current_dq = {num_of((a * cos(m.theta_e) + read_beta * sin(m.theta_e)) / AMP),
                                                     num_of((read_beta * cos(m.theta_e) - a * sin(m.theta_e)) / AMP)},
                                      .rotor = {num_of(sin(m.theta_e)), num_of(cos(m.theta_e))},
                                      .speed = num_of(m.rad_s / SPEED),
                                      .v_dc = num_of(VDC_V / VOLT),
                                      .volt = {num_of(v.alpha / VOLT), num_of(v.beta / VOLT)}};
    const bool                  plausible = ctl_plausibility_step(&check, &in);
    machine_period();
    m.acting = v; /* calculated in this sample, from the next one on */
    return plausible;
}

/* @return samples until the first contradiction, 0: none. */
static int samples_until(int most, double volt_v)
{
    for (int k = 1; k <= most; k++) {
        if (!sample(volt_v)) {
            return k;
        }
    }
    return 0;
}

void setUp(void) { seed = 1U; }
void tearDown(void) {}

void test_plausibility_of_the_machine_itself_holds_in_reversals_and_jumps_of_the_voltage(void)
{
    const double rad_s[] = {0.0, 20.0, -150.0, 250.0};
    for (size_t k = 0; k < COUNT_OF(rad_s); k++) {
        machine_start(rad_s[k]);
        start(NARROW); /* the resistive drop of what the current curves by in a period: emf w T^2 / 12 L = 0.1 A, R T of it */
        m.rad_s2 = -5000.0 * copysign(1.0, rad_s[k]);
        TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_until(800, 15.0), at("from %g rad/s", rad_s[k]));
    }
}

void test_plausibility_ends_two_samples_after_a_sensor_has_jumped(void)
{
    machine_start(60.0);
    start(NARROW);
    TEST_ASSERT_EQUAL_INT(0, samples_until(100, 15.0));
    m.error_a[0] = 1.0;
    TEST_ASSERT_EQUAL_INT(2, samples_until(10, 15.0));
}

void test_plausibility_of_one_disturbed_sample_is_no_reason_to_stop(void)
{
    machine_start(60.0);
    start((tolerance_t){.rest_a = 1.0});
    TEST_ASSERT_EQUAL_INT(0, samples_until(100, 15.0));
    m.error_a[0] = 2.0; /* seen with 2 (1 + 1 / sqrt(3)) A, then a quarter of that is left */
    TEST_ASSERT_TRUE(sample(15.0));
    m.error_a[0] = 0.0;
    TEST_ASSERT_EQUAL_INT(0, samples_until(100, 15.0));
}

/* Each cause by itself: within its tolerance it passes, at twice the tolerance it is found, and without one it is found, too. */
static void assert_bounded(const char *name, tolerance_t tolerance, double *cause, double within, double beyond)
{
    const double healthy = *cause;
    machine_start(200.0);
    start(tolerance);
    *cause = within;
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, samples_until(1000, 10.0), at("%s within its tolerance", name));
    machine_start(200.0);
    start(tolerance);
    *cause = beyond;
    TEST_ASSERT_TRUE_MESSAGE(samples_until(1000, 10.0) > 0, at("%s beyond its tolerance", name));
    machine_start(200.0);
    start(NARROW);
    *cause = within;
    TEST_ASSERT_TRUE_MESSAGE(samples_until(1000, 10.0) > 0, at("%s without a tolerance", name));
    *cause = healthy;
}

void test_plausibility_allows_each_parameter_its_tolerance_and_not_much_more(void)
{
    machine_start(0.0);
    /* sqrt(2): the sum of two components of an error that lies across what it is measured by */
    assert_bounded("resistance", (tolerance_t){.rest_a = 0.05, .r = 0.3}, &m.r, 1.2, 2.0);
    assert_bounded("inductance", (tolerance_t){.rest_a = 0.05, .l = 0.3}, &m.l, 1.2, 2.0);
    assert_bounded("flux", (tolerance_t){.rest_a = 0.05, .psi = 0.15}, &m.psi, 1.1, 1.4);
    assert_bounded("voltage", (tolerance_t){.rest_a = 0.05, .volt = 0.15}, &m.lost, 0.1, 0.4);
    assert_bounded("bridge", (tolerance_t){.rest_a = 0.05, .dc = 0.15}, &m.lost, 0.1, 0.9);
}

void test_plausibility_finds_every_kind_of_wrong_sensor(void)
{
    static const struct {
        const char *name;
        double      gain_a, gain_b, error_a;
    } wrong[] = {{"dead", 0.0, 1.0, 0.0},      {"half", 0.5, 1.0, 0.0},   {"reversed", -1.0, 1.0, 0.0},
                 {"both dead", 0.0, 0.0, 0.0}, {"double", 2.0, 1.0, 0.0}, {"shifted", 1.0, 1.0, 3.0}};
    for (size_t k = 0; k < COUNT_OF(wrong); k++) {
        machine_start(100.0);
        start((tolerance_t){0.1, 0.2, 0.15, 0.05, 0.0, 0.002, 0.0});
        TEST_ASSERT_EQUAL_INT(0, samples_until(300, 15.0));
        m.gain[0] = wrong[k].gain_a;
        m.gain[1] = wrong[k].gain_b;
        m.error_a[0] = wrong[k].error_a;
        const int after = samples_until(300, 15.0);
        TEST_ASSERT_TRUE_MESSAGE((after > 0) && (after < 100), at("%s: %d samples", wrong[k].name, after));
    }
}

void test_plausibility_says_nothing_in_the_first_three_samples_after_a_restart(void)
{
    machine_start(200.0);
    start(NARROW);
    m.error_a[0] = 5.0;
    (void)samples_until(50, 10.0);
    ctl_plausibility_restart(&check.state);
    m.gain[0] = -1.0;
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_TRUE(sample(10.0));
    }
    TEST_ASSERT_TRUE(samples_until(10, 10.0) > 0);
}

void test_plausibility_of_what_is_not_a_number_ends_in_the_second_sample(void)
{
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        for (int field = 0; field < 8; field++) {
            ctl_plausibility_in_t in = {.rotor = {(num_t)0, num_of(1.0)}, .v_dc = num_of(1.0)};
            num_t *const          at_field[] = {&in.current_dq.d, &in.current_dq.q, &in.rotor.sine, &in.rotor.cosine,
                                                &in.speed,        &in.v_dc,         &in.volt.alpha, &in.volt.beta};
            start(NARROW);
            for (int n = 0; n < 10; n++) {
                TEST_ASSERT_TRUE(ctl_plausibility_step(&check, &in));
            }
            *at_field[field] = NOT_FINITE[k];
            TEST_ASSERT_TRUE(ctl_plausibility_step(&check, &in));
            TEST_ASSERT_FALSE(ctl_plausibility_step(&check, &in));
        }
    }
}

void test_plausibility_stays_bounded_whatever_comes(void)
{
    start(NARROW);
    for (uint32_t k = 0U; k < 20000U; k++) {
        num_t x[8];
        for (size_t i = 0; i < 8U; i++) {
            seed = (seed * 1664525U) + 1013904223U;
            x[i] = NASTY[(seed >> 16) % COUNT_OF(NASTY)];
        }
        const ctl_plausibility_in_t in = {{x[0], x[1]}, {x[2], x[3]}, x[4], x[5], {x[6], x[7]}};
        (void)ctl_plausibility_step(&check, &in);
        TEST_ASSERT_TRUE((check.state.skip > 0U) || num_is_finite(check.state.error.alpha));
        TEST_ASSERT_TRUE((check.state.skip > 0U) || num_is_finite(check.state.error.beta));
    }
    machine_start(100.0); /* and then it works as ever */
    ctl_plausibility_restart(&check.state);
    TEST_ASSERT_EQUAL_INT(0, samples_until(300, 10.0));
}

void test_plausibility_refuses_parameters_that_describe_no_motor(void)
{
    const ctl_plausibility_params_t good = params_of(NARROW);
    ctl_plausibility_params_t       p = good;
    num_t *const field[] = {&p.ld,          &p.lq,         &p.psi,       &p.r_half,   &p.v,      &p.rest,
                            &p.per_current, &p.per_change, &p.per_speed, &p.per_volt, &p.per_dc, &p.per_volt_change};
    start(NARROW);
    for (size_t k = 0; k < COUNT_OF(field); k++) {
        const num_t was = *field[k];
        const num_t bad[] = {num_of(-0.1), NOT_FINITE[0]};
        for (size_t n = 0; n < COUNT_OF(bad); n++) {
            *field[k] = bad[n];
            const ctl_diag_t d = ctl_plausibility_init(&check, &p);
            TEST_ASSERT_EQUAL(CTL_ERR_RANGE, d.status);
            TEST_ASSERT_EQUAL_UINT16(k + 1U, d.field);
        }
        *field[k] = was;
    }
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_plausibility_init(&check, NULL));
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_plausibility_init(NULL, &p));
}

void test_plausibility_of_an_ideal_bridge_and_a_motor_without_magnets_or_resistance_is_accepted(void)
{
    const ctl_plausibility_params_t good = params_of(NARROW);
    ctl_plausibility_params_t       p = good;
    num_t *const                    may_be_zero[] = {&p.psi,       &p.r_half,   &p.per_current, &p.per_change,
                                                     &p.per_speed, &p.per_volt, &p.per_dc,      &p.per_volt_change};
    for (size_t k = 0; k < COUNT_OF(may_be_zero); k++) {
        p = good;
        *may_be_zero[k] = (num_t)0;
        TEST_ASSERT_EQUAL_MESSAGE(CTL_OK, ctl_plausibility_init(&check, &p).status, at("%u", (unsigned)k));
    }
    num_t *const must_be[] = {&p.ld, &p.lq, &p.v, &p.rest};
    for (size_t k = 0; k < COUNT_OF(must_be); k++) {
        p = good;
        *must_be[k] = (num_t)0;
        TEST_ASSERT_EQUAL_MESSAGE(CTL_ERR_RANGE, ctl_plausibility_init(&check, &p).status, at("%u", (unsigned)k));
    }
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_plausibility_init(&check, NULL));
    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_plausibility_init(NULL, &good));
}

void test_plausibility_begins_without_knowledge_whatever_was_there(void)
{
    const ctl_ab_t zero = {(num_t)0, (num_t)0};
    memset(&check, 0xA5, sizeof check);
    start(NARROW);
    const ctl_plausibility_state_t *const s = &check.state;
    const ctl_ab_t                        part[] = {s->error, s->before, s->current, s->acting, s->next};
    for (size_t k = 0; k < COUNT_OF(part); k++) {
        TEST_ASSERT_TRUE_MESSAGE((part[k].alpha == zero.alpha) && (part[k].beta == zero.beta), at("part %u", (unsigned)k));
    }
    TEST_ASSERT_TRUE(s->allowed == (num_t)0);
    TEST_ASSERT_EQUAL_UINT16(CTL_PLAUSIBILITY_SKIP, s->skip);
    TEST_ASSERT_EQUAL_UINT16(0U, s->against);
}

/* A sample is lost; the machine goes on, with the voltage of the sample before, then without. What came before says nothing any more. */
void test_plausibility_begins_again_after_a_sample_that_is_no_number(void)
{
    machine_start(60.0);
    start(NARROW);
    TEST_ASSERT_EQUAL_INT(0, samples_until(100, 15.0));
    const ctl_plausibility_in_t lost = {.current_dq = {NOT_FINITE[0], (num_t)0}};
    TEST_ASSERT_TRUE(ctl_plausibility_step(&check, &lost));
    machine_period();
    m.acting = (ab_t){0.0, 0.0};
    TEST_ASSERT_EQUAL_INT(0, samples_until(100, 15.0));
}

/* Each of what is kept becomes too large by itself, from inputs and parameters at the ends of their ranges: it begins again. */
void test_plausibility_begins_again_when_what_it_keeps_is_no_number(void)
{
    FLOAT_ONLY(); /* fixed point ends at its limits */
    for (int which = 0; which < 5; which++) {
        ctl_plausibility_params_t p = params_of(NARROW);
        ctl_plausibility_in_t     in = {.rotor = {num_of(0.0), num_of(1.0)}};
        const double              far = 0.9 * num_max_value();
        if ((which == 1) || (which == 3)) { /* the d axis along beta */
            in.rotor = (ctl_rotor_t){num_of(1.0), num_of(0.0)};
        }
        p.ld = num_of((which >= 2) ? 10.0 : 0.9);
        p.per_speed = num_of(10.0);
        TEST_ASSERT_EQUAL(CTL_OK, ctl_plausibility_init(&check, &p).status);
        if (which < 2) { /* the flux jumps from one end to the other: the error alone, on this axis alone */
            in.current_dq.d = num_of(-far);
            for (unsigned k = 0U; k <= CTL_PLAUSIBILITY_SKIP; k++) {
                TEST_ASSERT_TRUE(ctl_plausibility_step(&check, &in) || (k == CTL_PLAUSIBILITY_SKIP));
            }
            TEST_ASSERT_EQUAL_UINT16(0U, check.state.skip);
            in.current_dq.d = num_of(far);
        } else if (which < 4) {
            in.current_dq.d = num_of(far); /* flux */
        } else {
            in.speed = num_of(far); /* what is allowed */
        }
        (void)ctl_plausibility_step(&check, &in);
        TEST_ASSERT_EQUAL_UINT16_MESSAGE(CTL_PLAUSIBILITY_SKIP, check.state.skip, at("case %d", which));
    }
}
