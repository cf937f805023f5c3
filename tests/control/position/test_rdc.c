/* control/position/rdc.c: the model's torque, the robust term and its Lyapunov row, and what is refused. */
#include "tests/support/numeric.h"

#include "control/position/rdc.h"
#include "tests/control/golden/rdc.h"

#define INERTIA 0.0078
#define SAMPLE_S 0.0078125

static ctl_rdc_t rdc;

/* the machine of Yeh and Liu 2024, torque in N m */
static ctl_rdc_params_t valid_params(void)
{
    const ctl_rdc_params_t p = {
        .inertia = num_of(INERTIA),
        .friction = {num_of(0.0339), num_of(0.387), num_of(0.457), num_of(0.551), num_of(1.957)},
        .harmonics = {2U, {{25165824U, num_of(0.14), 871564313U}, {4194304U, num_of(0.022), 356141600U}}},
        .p_row = {num_of(GOLDEN_RDC_P[6] / INERTIA), num_of(GOLDEN_RDC_P[7] / INERTIA), num_of(GOLDEN_RDC_P[8] / INERTIA)},
        .rho = num_of(0.15),
        .sigma = num_of(0.02),
        .sample_s = num_of(SAMPLE_S),
        .integral_max = num_of(100.0)};
    return p;
}

static ctl_rdc_params_t only_robust(void)
{
    ctl_rdc_params_t p = valid_params();
    p.inertia = (num_t)0;
    p.friction.viscous = p.friction.coulomb = p.friction.stat = (num_t)0;
    p.harmonics.lines = 0U;
    return p;
}

static void start(const ctl_rdc_params_t *p) { TEST_ASSERT_EQUAL(CTL_OK, ctl_rdc_init(&rdc, p).status); }

static ctl_setpoint_t command(ctl_position_t position, double speed, double acceleration)
{
    const ctl_setpoint_t c = {position, num_of(speed), num_of(acceleration), false};
    return c;
}

static double step(const ctl_setpoint_t *c, double error, double speed_error)
{
    return value_of(ctl_rdc_step(&rdc, c, num_of(error), num_of(speed_error)));
}

static double friction(double v)
{
    return 0.0339 * v + ((v > 0.0) - (v < 0.0)) * (0.387 + 0.07 * exp(-pow(fabs(v) / 0.551, 1.957)));
}

static double lines(double rad)
{
    return 0.14 * sin(24.0 * rad + TWO_PI * 871564313.0 / TURN_STEPS) +
           0.022 * sin(4.0 * rad + TWO_PI * 356141600.0 / TURN_STEPS);
}

void setUp(void)
{
    const ctl_rdc_params_t p = valid_params();
    start(&p);
}
void tearDown(void) {}

/* ---- the Lyapunov row --------------------------------------------------------------------------------------------------- */

void test_ctl_rdc_golden_p_solves_the_lyapunov_equation(void)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            double sum = (i == j) ? 1.0 : 0.0;
            for (int k = 0; k < 3; k++) {
                sum += GOLDEN_RDC_A[3 * k + i] * GOLDEN_RDC_P[3 * k + j] + GOLDEN_RDC_P[3 * i + k] * GOLDEN_RDC_A[3 * k + j];
            }
            ASSERT_DOUBLE_WITHIN_AT(1e-8, 0.0, sum, at("element %d, %d", i, j)); /* 13 digits of up to 1e3 */
        }
    }
    /* the row that an independent calculation has found, to its digits */
    TEST_ASSERT_DOUBLE_WITHIN(0.5e-9, 1.4977e-5, GOLDEN_RDC_P[6]);
    TEST_ASSERT_DOUBLE_WITHIN(0.5e-7, 2.03552e-2, GOLDEN_RDC_P[7]);
    TEST_ASSERT_DOUBLE_WITHIN(0.5e-8, 3.03823e-3, GOLDEN_RDC_P[8]);
}

void test_ctl_rdc_robust_term_of_the_first_sample_matches_golden(void)
{
    for (size_t k = 0; k < COUNT_OF(GOLDEN_RDC_ROBUST); k++) {
        const golden_rdc_robust_t *const g = &GOLDEN_RDC_ROBUST[k];
        ctl_rdc_params_t                 p = only_robust();
        p.rho = num_of(g->rho);
        p.sigma = num_of(g->sigma);
        start(&p);
        const ctl_setpoint_t rest = command(0, 0.0, 0.0);

        /* s within 2 steps, 7.5 times as much in the boundary layer */
        ASSERT_DOUBLE_WITHIN_AT(per_numeric(2e-7, 20.0 * FIXED_STEP), g->robust, step(&rest, g->error, g->speed_error),
                                at("row %u", (unsigned)k));
        TEST_ASSERT_DOUBLE_WITHIN(per_numeric(2e-7, 20.0 * FIXED_STEP), g->robust, value_of(rdc.state.robust));
    }
}

/* ---- (3) ----------------------------------------------------------------------------------------------------------------- */

static double robust(double s) { return value_of(ctl_rdc_robust(num_of(s), num_of(0.15), num_of(0.02))); }

void test_ctl_rdc_robust_is_a_line_inside_of_the_boundary_layer(void)
{
    for (double s = -0.0199; s < 0.02; s += 0.0007) {
        TEST_ASSERT_DOUBLE_WITHIN(per_numeric(1e-7, 9.0 * FIXED_STEP), -7.5 * s, robust(s));
    }
}

void test_ctl_rdc_robust_is_the_bound_against_the_error_outside(void)
{
    const double far[] = {0.0201, 0.1, 1.0, 100.0};
    for (size_t k = 0; k < COUNT_OF(far); k++) {
        ASSERT_NUM_WITHIN(FIXED_STEP, -0.15, ctl_rdc_robust(num_of(far[k]), num_of(0.15), num_of(0.02)));
        ASSERT_NUM_WITHIN(FIXED_STEP, 0.15, ctl_rdc_robust(num_of(-far[k]), num_of(0.15), num_of(0.02)));
    }
}

void test_ctl_rdc_robust_is_continuous_at_the_edge(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, robust(0.02 - 1e-7), robust(0.02 + 1e-7));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, robust(-0.02 - 1e-7), robust(-0.02 + 1e-7));
}

void test_ctl_rdc_robust_is_odd_monotonous_and_bounded(void)
{
    double last = 0.15;
    for (double s = -0.05; s <= 0.05; s += 0.0003) {
        TEST_ASSERT_DOUBLE_WITHIN(per_numeric(1e-7, FIXED_STEP), -robust(s), robust(-s));
        TEST_ASSERT_TRUE(robust(s) <= last + FIXED_STEP);
        last = robust(s);
    }
    for (size_t k = 0; k < COUNT_OF(NASTY); k++) {
        ASSERT_BOUNDED_AT(0.15 + FIXED_STEP, ctl_rdc_robust(NASTY[k], num_of(0.15), num_of(0.02)), at("value %u", (unsigned)k));
    }
}

void test_ctl_rdc_without_rho_has_no_robust_term(void)
{
    ctl_rdc_params_t p = only_robust();
    p.rho = (num_t)0;
    start(&p);
    const ctl_setpoint_t rest = command(0, 0.0, 0.0);

    TEST_ASSERT_EQUAL_DOUBLE(0.0, step(&rest, 0.5, -3.0));
}

/* ---- (2) ----------------------------------------------------------------------------------------------------------------- */

void test_ctl_rdc_first_state_is_the_integral_of_the_error(void)
{
    const ctl_setpoint_t rest = command(0, 0.0, 0.0);
    double               sum = 0.0;
    for (int k = 0; k < 50; k++) {
        const double error = 0.125 * (k % 7) - 0.25;
        (void)step(&rest, error, 0.0);
        sum += SAMPLE_S * error;
        ASSERT_NUM_WITHIN_AT(per_numeric(1e-7, FIXED_STEP), sum, rdc.state.x1, at("sample %d", k));
    }
}

void test_ctl_rdc_integral_alone_asks_for_torque(void)
{
    ctl_rdc_params_t p = only_robust();
    p.p_row[0] = num_of(2.0);
    p.p_row[1] = p.p_row[2] = (num_t)0;
    start(&p);
    const ctl_setpoint_t rest = command(0, 0.0, 0.0);
    for (int k = 0; k < 8; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, -7.5 * 2.0 * SAMPLE_S * 0.03125 * (k + 1), step(&rest, 0.03125, 5.0));
    }
}

void test_ctl_rdc_integral_stops_at_its_limit_in_both_directions_and_comes_back(void)
{
    ctl_rdc_params_t p = valid_params();
    p.integral_max = num_of(0.0625);
    start(&p);
    const ctl_setpoint_t rest = command(0, 0.0, 0.0);
    for (int k = 0; k < 40; k++) {
        (void)step(&rest, 1.0, 0.0);
        ASSERT_NUM_WITHIN(1e-8, fmin(0.0625, SAMPLE_S * (k + 1)), rdc.state.x1);
    }
    (void)step(&rest, -1.0, 0.0);
    ASSERT_NUM_WITHIN(1e-8, 0.0625 - SAMPLE_S, rdc.state.x1);
    for (int k = 0; k < 40; k++) {
        (void)step(&rest, -1.0, 0.0);
    }
    ASSERT_NUM_WITHIN(1e-8, -0.0625, rdc.state.x1);
}

void test_ctl_rdc_reset_forgets_the_integral_and_keeps_the_count(void)
{
    const ctl_setpoint_t rest = command(0, 0.0, 0.0);
    (void)step(&rest, 1.0, 1.0);
    (void)ctl_rdc_step(&rdc, &rest, NOT_FINITE[0], (num_t)0);
    TEST_ASSERT_EQUAL_UINT32(1U, rdc.state.rejected);

    ctl_rdc_reset(&rdc.state);

    TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(rdc.state.x1));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(rdc.state.robust));
    TEST_ASSERT_EQUAL_UINT32(1U, rdc.state.rejected);
}

/* ---- (1) ----------------------------------------------------------------------------------------------------------------- */

void test_ctl_rdc_without_error_is_the_model_on_the_command(void)
{
    const double speeds[] = {2.0944, -2.0944, 0.3, -0.3, 0.0};
    const double accelerations[] = {0.0, 20.0, -20.0};
    for (size_t i = 0; i < COUNT_OF(speeds); i++) {
        for (size_t k = 0; k < COUNT_OF(accelerations); k++) {
            for (int turn = -3; turn <= 3; turn++) {
                const double         part = 0.13 * (double)(turn + 4);
                const ctl_setpoint_t c =
                    command(turn * CTL_ONE_TURN + (ctl_position_t)(part * TURN_STEPS), speeds[i], accelerations[k]);
                const double want = INERTIA * accelerations[k] + friction(speeds[i]) + lines(TWO_PI * part);

                ASSERT_DOUBLE_WITHIN_AT(3e-6, want, step(&c, 0.0, 0.0), at("v %g, a %g", speeds[i], accelerations[k]));
            }
        }
    }
}

void test_ctl_rdc_at_the_stop_has_no_friction_but_keeps_the_lines(void)
{
    const ctl_setpoint_t c = command(CTL_ONE_TURN / 8, 0.0, 0.0);

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, lines(TWO_PI / 8.0), step(&c, 0.0, 0.0));
}

void test_ctl_rdc_is_model_plus_robust_term(void)
{
    const ctl_setpoint_t c = command(CTL_ONE_TURN / 5, 1.5, -7.0);
    const double         model = INERTIA * -7.0 + friction(1.5) + lines(TWO_PI / 5.0);

    TEST_ASSERT_DOUBLE_WITHIN(3e-6, model - 0.15, step(&c, 0.5, 1.0));
    TEST_ASSERT_DOUBLE_WITHIN(3e-6, model + 0.15, step(&c, -2.0, -3.0));
}

/* ---- not a number --------------------------------------------------------------------------------------------------------- */

void test_ctl_rdc_input_that_is_not_a_number_counts_as_nothing_and_is_counted(void)
{
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        const ctl_rdc_params_t p = valid_params();
        start(&p);
        const ctl_setpoint_t good = command(77, 1.0, 3.0);
        const double         want = step(&good, 0.0, 0.0);
        start(&p);
        const ctl_setpoint_t no_a = {77, num_of(1.0), NOT_FINITE[k], false};
        const ctl_setpoint_t no_v = {77, NOT_FINITE[k], num_of(3.0), false};

        TEST_ASSERT_EQUAL_DOUBLE(want, value_of(ctl_rdc_step(&rdc, &good, NOT_FINITE[k], (num_t)0)));
        TEST_ASSERT_EQUAL_UINT32(1U, rdc.state.rejected);
        TEST_ASSERT_EQUAL_DOUBLE(want, value_of(ctl_rdc_step(&rdc, &good, (num_t)0, NOT_FINITE[k])));
        TEST_ASSERT_EQUAL_UINT32(2U, rdc.state.rejected);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, want - INERTIA * 3.0, step(&no_a, 0.0, 0.0));
        TEST_ASSERT_DOUBLE_WITHIN(3e-6, want - friction(1.0), step(&no_v, 0.0, 0.0));
        TEST_ASSERT_EQUAL_UINT32(4U, rdc.state.rejected);
    }
}

void test_ctl_rdc_output_stays_finite_for_any_input(void)
{
    noise_t noise = {109U};
    for (int k = 0; k < 20000; k++) {
        const ctl_setpoint_t c = {(ctl_position_t)(((uint64_t)noise_bits(&noise) << 32) | noise_bits(&noise)),
                                  noise_nasty(&noise), noise_nasty(&noise), false};
        const num_t          out = ctl_rdc_step(&rdc, &c, noise_nasty(&noise), noise_nasty(&noise));

        ASSERT_BOUNDED_AT(0.1 * num_max_value() + 128.0, out,
                          at("sample %d", k)); /* inertia and viscous friction together 0.05 */
        ASSERT_BOUNDED_AT(0.15 + FIXED_STEP, rdc.state.robust, at("sample %d", k));
        ASSERT_BOUNDED_AT(100.0, rdc.state.x1, at("sample %d", k));
    }
    TEST_ASSERT_TRUE(rdc.state.rejected > 1000U);
}

/* ---- refused ---------------------------------------------------------------------------------------------------------------- */

static void assert_refused(const ctl_rdc_params_t *p, ctl_status_t status, uint16_t field)
{
    const ctl_rdc_t  before = rdc;
    const ctl_diag_t got = ctl_rdc_init(&rdc, p);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL(field, got.field);
    TEST_ASSERT_EQUAL_MEMORY(&before, &rdc, sizeof rdc);
}

void test_ctl_rdc_init_without_object_or_parameters_is_null(void)
{
    const ctl_rdc_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_rdc_init(NULL, &p));
    assert_refused(NULL, CTL_ERR_NULL, 0U);
}

void test_ctl_rdc_init_rejects_static_below_coulomb_as_static(void)
{
    ctl_rdc_params_t p = valid_params();
    p.friction.stat = num_of(0.3);

    assert_refused(&p, CTL_ERR_RELATION, CTL_RDC_STATIC);
}

void test_ctl_rdc_init_rejects_other_friction_as_friction(void)
{
    ctl_rdc_params_t p = valid_params();
    p.friction.shape = num_of(20.0);

    assert_refused(&p, CTL_ERR_RANGE, CTL_RDC_FRICTION);
}

void test_ctl_rdc_init_rejects_too_many_lines(void)
{
    ctl_rdc_params_t p = valid_params();
    p.harmonics.lines = CTL_HARMONICS_MAX + 1U;

    assert_refused(&p, CTL_ERR_RANGE, CTL_RDC_HARMONICS);
}

void test_ctl_rdc_init_rejects_negative_inertia_bound_width_and_times(void)
{
    const struct {
        uint16_t field;
        double   bad;
    } row[] = {{CTL_RDC_INERTIA, -1e-3}, {CTL_RDC_RHO, -1e-3},  {CTL_RDC_SIGMA, 0.0},
               {CTL_RDC_SIGMA, -1.0},    {CTL_RDC_SAMPLE, 0.0}, {CTL_RDC_SAMPLE, -1e-3}};
    for (size_t k = 0; k < COUNT_OF(row); k++) {
        ctl_rdc_params_t p = valid_params();
        num_t *const     at_field[] = {NULL, &p.inertia, NULL, NULL, NULL, NULL, &p.rho, &p.sigma, &p.sample_s};
        *at_field[row[k].field] = num_of(row[k].bad);
        assert_refused(&p, CTL_ERR_RANGE, row[k].field);
    }
}

void test_ctl_rdc_init_rejects_what_is_not_a_number_wherever_it_is(void)
{
    for (size_t k = 0; k < COUNT_OF(NOT_FINITE); k++) {
        for (int f = 0; f < 8; f++) {
            ctl_rdc_params_t p = valid_params();
            num_t *const     place[] = {&p.inertia, &p.p_row[0], &p.p_row[1], &p.p_row[2],
                                        &p.rho,     &p.sigma,    &p.sample_s, &p.integral_max};
            const uint16_t   field[] = {CTL_RDC_INERTIA, CTL_RDC_P,     CTL_RDC_P,      CTL_RDC_P,
                                        CTL_RDC_RHO,     CTL_RDC_SIGMA, CTL_RDC_SAMPLE, CTL_RDC_SAMPLE};
            *place[f] = NOT_FINITE[k];
            assert_refused(&p, CTL_ERR_RANGE, field[f]);
        }
    }
}

/* ---- without looking ------------------------------------------------------------------------------------------------------ */

void test_ctl_rdc_raw_is_the_same_for_numbers(void)
{
    const ctl_rdc_params_t p = valid_params();
    noise_t                noise = {117U};
    start(&p);
    ctl_rdc_t twin = rdc;
    for (int k = 0; k < 300; k++) {
        const ctl_setpoint_t c =
            command((ctl_position_t)noise_bits(&noise) * 5, 4.0 * noise_next(&noise), 10.0 * noise_next(&noise));
        const num_t error = num_of(0.01 * noise_next(&noise));
        const num_t speed_error = num_of(noise_next(&noise));

        TEST_ASSERT_TRUE_MESSAGE(ctl_rdc_step(&twin, &c, error, speed_error) ==
                                     ctl_rdc_step_unchecked(&rdc.params, &rdc.state, &c, error, speed_error),
                                 at("sample %d", k));
        const ctl_rdc_params_t *const q = &rdc.params;
        const num_t measure = num_mac(num_mac(num_mul(q->p_row[0], rdc.state.x1), q->p_row[1], error), q->p_row[2], speed_error);
        ASSERT_NUM_WITHIN_AT(per_numeric(1e-7, 3.0 * FIXED_STEP) * value_of(q->rho) / 0.25,
                             value_of(ctl_rdc_robust(measure, q->rho, q->sigma)), rdc.state.robust, at("sample %d", k));
    }
}
