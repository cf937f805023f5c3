/* control/observer/torque_meter.c: the torque that moves a shaft whose motion is known in closed form, its age, and what
 * the torque reference explains. Rig 2 of Tang et al. 2020; speed counts 100 rad/s, torque 1 N m. */
#include "tests/support/numeric.h"

#include "control/observer/torque_meter.h"

#define TS_S 1e-4
#define J_KGM2 9e-4
#define B_NMS 4e-3
#define SPEED_UNIT 100.0

static ctl_meter_t meter;

static ctl_fir_params_t designed(uint16_t order)
{
    ctl_fir_params_t p;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_fir_design(&p, order, num_of(0.1)).status);
    return p;
}

static ctl_meter_params_t params_of(uint16_t order1, uint16_t order2, double b_nms)
{
    const ctl_meter_params_t p = {
        .speed_per_rad = num_of(1.0 / (TS_S * SPEED_UNIT)),
        .torque_per_16 = num_of(J_KGM2 * SPEED_UNIT / (16.0 * TS_S)),
        .a22 = num_of(1.0 - (b_nms * TS_S / J_KGM2)),
        .fir1 = designed(order1),
        .fir2 = designed(order2),
        .actuation = num_of(2.0),
        .step_max_rad = num_of(0.25),
    };
    return p;
}

static ctl_meter_params_t valid_params(void) { return params_of(9U, 10U, 0.0); }

static void start(const ctl_meter_params_t *p) { TEST_ASSERT_EQUAL(CTL_OK, ctl_meter_init(&meter, p).status); }

static angle_t angle_at(double rad)
{
    const double turns = rad / TWO_PI;
    return (angle_t)(uint64_t)llround((turns - floor(turns)) * TURN_STEPS);
}

/* One sample: where the shaft is, and the reference of the sample before. */
static double torque_nm(double rad, double ref_nm)
{
    return value_of(ctl_meter_step(&meter, angle_at(rad), num_of(ref_nm)).torque);
}

/* A step of the angle, 1.5e-9 rad, is J / T_s^2 times that in torque, 1.3e-4 N m, before filters that leave a tenth; a22
 * is known to 3e-8, which is 4e-5 N m at 150 rad/s. Fixed point counts radians in 6e-8: 5.4e-3 N m before the filters. */
#define ROUNDING_NM per_numeric(1.2e-4, 1e-3)

void setUp(void)
{
    const ctl_meter_params_t p = valid_params();
    start(&p);
}
void tearDown(void) {}

/* ---- motions -------------------------------------------------------------------------------------------------------- */

void test_ctl_meter_at_rest_at_any_angle_measures_nothing(void)
{
    static const double PLACES[] = {0.0, 1.0, 3.1415, 6.28};
    for (size_t i = 0; i < COUNT_OF(PLACES); i++) {
        setUp();
        for (int k = 0; k < 40; k++) {
            const ctl_meter_out_t out = ctl_meter_step(&meter, angle_at(PLACES[i]), (num_t)0);

            TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(out.torque));
            TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(out.speed));
        }
        TEST_ASSERT_EQUAL_UINT32(0U, meter.state.rejected);
    }
}

void test_ctl_meter_of_a_constant_acceleration_measures_inertia_times_acceleration(void)
{
    static const double ACCELERATIONS[] = {1000.0, -250.0};
    for (size_t i = 0; i < COUNT_OF(ACCELERATIONS); i++) {
        const double a = ACCELERATIONS[i];
        setUp();
        for (int k = 0; k < 900; k++) {
            const double t = k * TS_S;
            const double got = torque_nm((0.5 * a * t * t) + 6.0, 0.0);
            if (k > 25) { /* 21 samples reach back, one for the first step */
                ASSERT_DOUBLE_WITHIN_AT(ROUNDING_NM, J_KGM2 * a, got, at("%g rad/s^2, sample %d", a, k));
            }
        }
    }
}

void test_ctl_meter_of_a_constant_speed_measures_the_friction(void)
{
    const ctl_meter_params_t p = params_of(9U, 10U, B_NMS);
    start(&p);
    for (int k = 0; k < 300; k++) {
        const double got = torque_nm(-150.0 * k * TS_S, 0.0);
        if (k > 25) {
            TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_NM, -150.0 * B_NMS, got);
        }
    }
}

/* 45 counts of 2^17 a sample: a number of radians that fixed point does not have, the same in every sample. */
void test_ctl_meter_speed_of_equal_steps_has_no_mean_error(void)
{
    for (int direction = -1; direction <= 1; direction += 2) {
        const double expected = direction * 45.0 / 131072.0 * TWO_PI / TS_S / SPEED_UNIT;
        double       sum = 0.0;
        setUp();
        for (int k = 0; k < 4050; k++) {
            const angle_t theta = (angle_t)((uint32_t)(45 * k) << 15);
            const num_t   speed = ctl_meter_step(&meter, (direction > 0) ? theta : (0U - theta), (num_t)0).speed;
            sum += (k >= 50) ? (value_of(speed) / 4000.0) : 0.0;
        }
        /* 1e-7 of it; taps that do not quite add up to 1, half a step each */
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(per_numeric(2e-7, 5.0 * FIXED_STEP), expected, sum, at("direction %d", direction));
    }
}

void test_ctl_meter_speed_is_that_of_half_a_sample_and_half_the_filter_ago(void)
{
    for (uint16_t order = 0; order <= CTL_FIR_ORDER_MAX; order++) {
        const ctl_meter_params_t p = params_of(order, 10U, 0.0);
        start(&p);
        for (int k = 0; k < 200; k++) {
            const double          t = k * TS_S;
            const ctl_meter_out_t out = ctl_meter_step(&meter, angle_at(20.0 * t + (2000.0 * t * t)), (num_t)0);
            if (k > 16) {
                const double then = t - ((0.5 + (order / 2.0)) * TS_S);
                /* half a sample of this acceleration is 0.2 rad/s; the angle rounds to 1.5e-5 (float), 6e-4 rad/s */
                ASSERT_NUM_WITHIN_AT(per_numeric(4e-5, 6e-4) / SPEED_UNIT, (20.0 + (4000.0 * then)) / SPEED_UNIT, out.speed,
                                     at("order %u, sample %d", order, k));
            }
        }
    }
}

/* Delay in samples and gain with which a torque of that frequency arrives. The motion that it causes is known in closed
 * form: theta = A / (j w (j w J + B)). The label says the age; the rest is what is measured here. */
static double age_of_sine(const ctl_meter_params_t *p, double frequency_hz, double b_nms, double *gain)
{
    const double w = TWO_PI * frequency_hz;
    const double amplitude = 0.5;
    const int    samples = (int)llround(40.0 / (frequency_hz * TS_S)); /* forty cycles */
    const double size = 1.0 / (w * hypot(w * J_KGM2, b_nms));
    const double turned = -(TWO_PI / 4.0) - atan2(w * J_KGM2, b_nms);
    double       in_phase = 0.0;
    double       in_quadrature = 0.0;
    start(p);
    for (int k = -60; k < samples; k++) {
        const double phase = w * k * TS_S;
        const double got = torque_nm(2.0 + (12.0 * k * TS_S) + (amplitude * size * sin(phase + turned)), 0.0) - (12.0 * b_nms);
        if (k >= 0) {
            in_phase += got * sin(phase) * 2.0 / samples;
            in_quadrature += got * cos(phase) * 2.0 / samples;
        }
    }
    *gain = hypot(in_phase, in_quadrature) / amplitude;
    return -atan2(in_quadrature, in_phase) / (w * TS_S);
}

static double gain_of_filters(const ctl_meter_params_t *p, double frequency_hz)
{
    const double                  x = frequency_hz * TS_S;
    const ctl_fir_params_t *const fir[] = {&p->fir1, &p->fir2};
    double                        gain = 1.0;
    for (size_t n = 0; n < COUNT_OF(fir); n++) {
        double sum = 0.0;
        for (uint16_t i = 0; i <= fir[n]->order; i++) {
            sum += value_of(fir[n]->tap[i]) * cos(TWO_PI * x * (i - (fir[n]->order / 2.0)));
        }
        gain *= sum;
    }
    return gain;
}

/* Of the chain: both filters, and the two differences, which average over a sample each. */
static double gain_of(const ctl_meter_params_t *p, double frequency_hz)
{
    const double half_phase = TWO_PI * frequency_hz * TS_S / 2.0;
    return gain_of_filters(p, frequency_hz) * pow(sin(half_phase) / half_phase, 2.0);
}

void test_ctl_meter_reproduces_a_disturbance_with_the_age_it_declares(void)
{
    static const struct {
        uint16_t order1, order2, age_half;
    } CHAINS[] = {{9U, 10U, 21U}, {0U, 0U, 2U}, {1U, 0U, 3U}, {4U, 15U, 21U}, {15U, 15U, 32U}, {3U, 10U, 15U}};
    static const double FREQUENCIES_HZ[] = {25.0, 80.0, 180.0, 400.0};
    for (size_t c = 0; c < COUNT_OF(CHAINS); c++) {
        const ctl_meter_params_t p = params_of(CHAINS[c].order1, CHAINS[c].order2, 0.0);
        TEST_ASSERT_EQUAL_UINT16(CHAINS[c].age_half, ctl_meter_age_half(&p));
        for (size_t f = 0; f < COUNT_OF(FREQUENCIES_HZ); f++) {
            const char *const text = at("orders %u and %u, %g Hz", CHAINS[c].order1, CHAINS[c].order2, FREQUENCIES_HZ[f]);
            double            gain = 0.0;
            const double      measured = age_of_sine(&p, FREQUENCIES_HZ[f], 0.0, &gain);
            const double      cycle = 1.0 / (FREQUENCIES_HZ[f] * TS_S); /* an age is known but for whole cycles */
            const double      age = measured + (cycle * round(((CHAINS[c].age_half / 2.0) - measured) / cycle));

            /* the rounding, averaged over forty cycles, against a sine of 0.5 N m */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.02 * (25.0 / FREQUENCIES_HZ[f]), CHAINS[c].age_half / 2.0, age, text);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-3, gain_of(&p, FREQUENCIES_HZ[f]), gain, text);
        }
    }
}

void test_ctl_meter_with_friction_is_true_to_the_same_age(void)
{
    const ctl_meter_params_t p = params_of(9U, 10U, B_NMS);
    double                   gain = 0.0;

    /* the friction of half a sample earlier than the acceleration: B T_s / 2 J of a sample at most, 2e-4 */
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 10.5, age_of_sine(&p, 25.0, B_NMS, &gain));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, gain_of(&p, 25.0), gain);
}

void test_ctl_meter_of_the_paper_passes_what_its_filters_let_through(void)
{
    const ctl_meter_params_t p = valid_params();

    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.97, gain_of_filters(&p, 180.0));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.86, gain_of_filters(&p, 400.0));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.71, gain_of_filters(&p, 600.0));
}

void test_ctl_meter_age_counts_half_samples_for_all_orders(void)
{
    ctl_meter_params_t p = valid_params();
    for (uint16_t n1 = 0; n1 <= CTL_FIR_ORDER_MAX; n1++) {
        for (uint16_t n2 = 0; n2 <= CTL_FIR_ORDER_MAX; n2++) {
            p.fir1.order = n1;
            p.fir2.order = n2;
            /* half a sample for each of the two differences, half the order for each filter */
            TEST_ASSERT_EQUAL_UINT16((uint16_t)(2.0 * (0.5 + (n1 / 2.0) + 0.5 + (n2 / 2.0))), ctl_meter_age_half(&p));
        }
    }
}

/* ---- the reference ---------------------------------------------------------------------------------------------------- */

void test_ctl_meter_of_a_blocked_shaft_measures_what_holds_it(void)
{
    for (int k = 0; k < 60; k++) {
        const double got = torque_nm(1.0, 0.75);
        if (k > 25) {
            TEST_ASSERT_DOUBLE_WITHIN(per_numeric(1e-6, 24.0 * FIXED_STEP), -0.75, got);
        }
    }
}

static double reference_at(int k, noise_t *noise)
{
    return (0.4 * sin(0.05 * k)) + ((k % 40) < 20 ? 0.3 : -0.3) + noise_next(noise);
}

/* Largest torque that is left when only the reference moves the plant of the paper: T_e[k] = T_ref[k-1],
 * w[k+1] = a22 w[k] + a23 T_e[k], theta[k+1] = theta[k] + T_s w[k]. */
static double left_over_in_the_plant_of_the_paper(double actuation)
{
    ctl_meter_params_t p = params_of(9U, 10U, B_NMS);
    noise_t            noise = {71U};
    double             theta = 1.0;
    double             w = 0.0;
    double             ref_last = 0.0;
    double             worst = 0.0;
    p.actuation = num_of(actuation);
    start(&p);
    for (int k = 0; k < 4000; k++) {
        worst = fmax(worst, fabs(torque_nm(theta, ref_last)));
        theta += TS_S * w;
        w += TS_S / J_KGM2 * (ref_last - (B_NMS * w));
        ref_last = value_of(num_of(reference_at(k, &noise)));
    }
    return worst;
}

void test_ctl_meter_explains_all_that_the_reference_does_in_the_plant_of_the_paper(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_NM, 0.0, left_over_in_the_plant_of_the_paper(2.0));
}

void test_ctl_meter_with_a_wrong_actuation_leaves_a_part_of_the_reference(void)
{
    TEST_ASSERT_TRUE(left_over_in_the_plant_of_the_paper(1.0) > 0.1);
    TEST_ASSERT_TRUE(left_over_in_the_plant_of_the_paper(3.0) > 0.1);
    TEST_ASSERT_TRUE(left_over_in_the_plant_of_the_paper(1.75) > 0.03);
}

void test_ctl_meter_explains_a_torque_that_acts_from_one_sample_to_two_samples_later(void)
{
    /* constant over that sample, in the middle after 1.5: w and theta integrated exactly; no friction, so that the mean of
     * two samples' torque is exactly what the interpolation takes */
    ctl_meter_params_t p = valid_params();
    noise_t            noise = {72U};
    double             theta = 2.0;
    double             w = -30.0;
    double             acting = 0.0;
    double             ref_last = 0.0;
    p.actuation = num_of(1.5);
    start(&p);
    for (int k = 0; k < 4000; k++) {
        const double got = torque_nm(theta, ref_last);
        if (k > 25) { /* it began at speed */
            TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_NM, 0.0, got);
        }
        const double ref = value_of(num_of(reference_at(k, &noise)));
        /* from k to k+1 acts what was asked for at k-1 */
        acting = ref_last;
        theta += (TS_S * w) + (0.5 * TS_S * TS_S / J_KGM2 * acting);
        w += TS_S / J_KGM2 * acting;
        ref_last = ref;
    }
}

void test_ctl_meter_holds_the_reference_back_by_actuation_and_one(void)
{
    /* no filters: the impulse of the reference comes out where it was held back to, shared between two samples */
    for (int half = 1; half <= 24; half++) {
        ctl_meter_params_t p = params_of(0U, 0U, 0.0);
        p.actuation = num_of(half / 2.0);
        start(&p);
        for (int k = 0; k < 20; k++) {
            const double got = torque_nm(0.0, (k == 1) ? 1.0 : 0.0); /* issued at 0 */
            const double behind = k - (1.0 + (half / 2.0));

            TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(-fmax(0.0, 1.0 - fabs(behind)), got, at("actuation %g, sample %d", half / 2.0, k));
        }
    }
}

/* ---- what must not disturb --------------------------------------------------------------------------------------------- */

void test_ctl_meter_passes_zero_and_the_end_of_the_turn_without_a_trace(void)
{
    for (int direction = -1; direction <= 1; direction += 2) {
        setUp();
        for (int k = 0; k < 2000; k++) {
            const double got = torque_nm(direction * 100.0 * k * TS_S, 0.0);
            if (k > 25) {
                TEST_ASSERT_DOUBLE_WITHIN(ROUNDING_NM, 0.0, got);
            }
        }
        TEST_ASSERT_EQUAL_UINT32(0U, meter.state.rejected);
    }
}

void test_ctl_meter_takes_a_jump_for_the_step_before_it_and_counts_it(void)
{
    double jump = 0.0;
    for (int k = 0; k < 300; k++) {
        jump += ((k == 100) ? 3.0 : 0.0) + ((k == 160) ? -1.5 : 0.0);
        const double got = torque_nm((100.0 * k * TS_S) + jump, 0.0);
        if (k > 25) {
            ASSERT_DOUBLE_WITHIN_AT(ROUNDING_NM, 0.0, got, at("sample %d", k));
        }
    }
    TEST_ASSERT_EQUAL_UINT32(2U, meter.state.rejected);
}

void test_ctl_meter_takes_the_largest_step_and_no_larger_one(void)
{
    static const struct {
        double   step;
        uint32_t rejected;
    } STEPS[] = {{0.2499, 0U}, {-0.2499, 0U}, {0.2501, 1U}, {-0.2501, 1U}, {3.1, 1U}, {-3.1, 1U}};
    for (size_t i = 0; i < COUNT_OF(STEPS); i++) {
        setUp();
        (void)torque_nm(1.0, 0.0);
        (void)torque_nm(1.0 + STEPS[i].step, 0.0);

        TEST_ASSERT_EQUAL_UINT32(STEPS[i].rejected, meter.state.rejected);
    }
}

void test_ctl_meter_reference_that_is_not_finite_counts_as_the_one_before_it(void)
{
    ctl_meter_t        twin;
    ctl_meter_params_t p = valid_params();
    noise_t            noise = {73U};
    double             last = 0.0;
    uint32_t           wrong = 0U;
    TEST_ASSERT_EQUAL(CTL_OK, ctl_meter_init(&twin, &p).status);
    for (int k = 0; k < 200; k++) {
        const bool    is_wrong = (k % 11) == 5;
        const angle_t theta = angle_at(0.001 * k);
        last = is_wrong ? last : noise_next(&noise);
        wrong += is_wrong ? 1U : 0U;
        const num_t           given = is_wrong ? NOT_FINITE[(size_t)k % COUNT_OF(NOT_FINITE)] : num_of(last);
        const ctl_meter_out_t want = ctl_meter_step(&twin, theta, num_of(last));
        const ctl_meter_out_t got = ctl_meter_step(&meter, theta, given);

        TEST_ASSERT_EQUAL_DOUBLE(value_of(want.torque), value_of(got.torque));
        TEST_ASSERT_EQUAL_DOUBLE(value_of(want.speed), value_of(got.speed));
    }
    TEST_ASSERT_EQUAL_UINT32(wrong, meter.state.rejected);
}

void test_ctl_meter_counter_stops_at_its_end(void)
{
    (void)torque_nm(0.0, 0.0);
    meter.state.rejected = UINT32_MAX - 1U;

    (void)ctl_meter_step(&meter, angle_at(2.0), NOT_FINITE[0]);

    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, meter.state.rejected);
}

void test_ctl_meter_reset_starts_from_rest_at_any_angle_and_keeps_the_count(void)
{
    for (int k = 0; k < 50; k++) {
        (void)torque_nm(0.02 * k, 1.0);
    }
    (void)ctl_meter_step(&meter, 0U, NOT_FINITE[0]);
    const uint32_t rejected = meter.state.rejected;

    ctl_meter_reset(&meter);

    for (int k = 0; k < 50; k++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, torque_nm(4.0, 0.0));
    }
    TEST_ASSERT_EQUAL_UINT32(rejected, meter.state.rejected);
    TEST_ASSERT_TRUE(rejected > 0U);
}

void test_ctl_meter_output_is_bounded_whatever_comes(void)
{
    const ctl_meter_params_t p = params_of(9U, 10U, B_NMS);
    noise_t                  noise = {74U};
    start(&p);
    for (int k = 0; k < 5000; k++) {
        const ctl_meter_out_t out = ctl_meter_step(&meter, noise_bits(&noise), noise_nasty(&noise));

        ASSERT_BOUNDED_AT(2.0 * num_max_value(), out.torque, at("sample %d", k));
        ASSERT_BOUNDED_AT(1.01 * 0.25 / (TS_S * SPEED_UNIT), out.speed,
                          at("sample %d", k)); /* the largest step, and no overshoot */
    }
}

/* ---- configuration ------------------------------------------------------------------------------------------------------ */

static void assert_rejected(const ctl_meter_params_t *p, ctl_status_t status, uint16_t field)
{
    (void)torque_nm(1.0, 0.5);
    const ctl_meter_t before = meter;

    const ctl_diag_t got = ctl_meter_init(&meter, p);

    TEST_ASSERT_EQUAL(status, got.status);
    TEST_ASSERT_EQUAL_UINT16(field, got.field);
    ASSERT_SAME_BITS(before, meter);
}

void test_ctl_meter_init_rejects_scales_that_are_not_positive(void)
{
    ctl_meter_params_t p = valid_params();
    p.speed_per_rad = (num_t)0;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_SPEED);
    p = valid_params();
    p.torque_per_16 = num_of(-1.0);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_TORQUE);
}

void test_ctl_meter_init_rejects_a_pole_outside_of_0_and_1(void)
{
    ctl_meter_params_t p = valid_params();
    p.a22 = num_of(1.0001);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_A22);
    p.a22 = num_of(-0.0001);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_A22);
    p.a22 = (num_t)0;
    start(&p);
}

void test_ctl_meter_init_rejects_an_actuation_outside_of_its_range(void)
{
    ctl_meter_params_t p = valid_params();
    p.actuation = num_of(0.49);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_ACTUATION);
    p.actuation = num_of(12.01);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_ACTUATION);
}

void test_ctl_meter_init_rejects_a_largest_step_of_nothing_or_more_than_half_a_turn(void)
{
    ctl_meter_params_t p = valid_params();
    p.step_max_rad = (num_t)0;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_STEP);
    p.step_max_rad = num_of(3.15);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_STEP);
}

void test_ctl_meter_init_names_the_filter_that_is_refused(void)
{
    ctl_meter_params_t p = valid_params();
    p.fir1.tap[0] = num_of(0.5);
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_FIR1);
    p = valid_params();
    p.fir2.order = CTL_FIR_ORDER_MAX + 1U;
    assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_FIR2);
}

void test_ctl_meter_init_rejects_what_is_not_finite_in_every_field(void)
{
    for (size_t i = 0; i < COUNT_OF(NOT_FINITE); i++) {
        ctl_meter_params_t p = valid_params();
        p.speed_per_rad = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_SPEED);
        p = valid_params();
        p.torque_per_16 = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_TORQUE);
        p = valid_params();
        p.a22 = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_A22);
        p = valid_params();
        p.actuation = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_ACTUATION);
        p = valid_params();
        p.step_max_rad = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_STEP);
        p = valid_params();
        p.fir2.tap[5] = NOT_FINITE[i];
        assert_rejected(&p, CTL_ERR_RANGE, CTL_METER_FIR2);
    }
}

void test_ctl_meter_init_without_a_pointer_says_so(void)
{
    const ctl_meter_params_t p = valid_params();

    ASSERT_DIAG(CTL_ERR_NULL, 0U, 0.0, ctl_meter_init(NULL, &p));
    assert_rejected(NULL, CTL_ERR_NULL, 0U);
}

/* ---- other parameters, and without looking ----------------------------------------------------------------------------------- */

void test_ctl_meter_tune_to_the_same_parameters_leaves_no_trace(void)
{
    ctl_meter_t              twin = meter;
    const ctl_meter_params_t p = valid_params();
    noise_t                  noise = {75U};
    for (int k = 0; k < 200; k++) {
        const num_t   ref = num_of(noise_next(&noise));
        const angle_t theta = angle_at(0.002 * k);
        if ((k % 50) == 25) {
            ctl_meter_tune(&meter, &p);
        }
        const ctl_meter_out_t want = ctl_meter_step(&twin, theta, ref);
        const num_t           torque = ctl_meter_torque_unchecked(&meter, theta, ref);
        const ctl_meter_out_t got = {ctl_meter_speed_unchecked(&meter), torque};

        ASSERT_SAME_BITS(want, got);
    }
}

void test_ctl_meter_prepare_shows_only_when_it_is_taken(void)
{
    ctl_meter_t        twin = meter;
    ctl_meter_params_t p = valid_params();
    p.actuation = num_of(3.625);
    p.torque_per_16 = num_mul(p.torque_per_16, num_of(0.5));
    for (int k = 0; k < 120; k++) {
        if (k == 20) {
            ctl_meter_prepare(&meter, &p);
        }
        if (k == 60) {
            ctl_meter_take_prepared(&meter, &p);
            ctl_meter_tune(&twin, &p);
        }
        const num_t           ref = num_of(sin(0.2 * k));
        const angle_t         theta = angle_at(0.002 * k);
        const ctl_meter_out_t want = ctl_meter_step(&twin, theta, ref);
        const ctl_meter_out_t got = ctl_meter_step(&meter, theta, ref);
        ASSERT_SAME_BITS(want, got);
    }
}

void test_ctl_meter_fast_path_gives_the_same_bits_and_leaves_out_first_angles_jumps_and_long_filters(void)
{
    ctl_meter_t twin = meter;
    noise_t     noise = {76U};
    int         fast = 0;
    for (int k = 0; k < 300; k++) {
        const num_t   ref = num_of(noise_next(&noise));
        const angle_t theta = angle_at((0.02 * k) + ((k > 200) ? 1.0 : 0.0)); /* a jump of 1 rad after 200 */
        const num_t   want = ctl_meter_torque_unchecked(&twin, theta, ref);
        const num_t   travel = ctl_meter_travel(&meter, theta);
        if ((k == 0) || (k == 201)) {
            TEST_ASSERT_FALSE(ctl_meter_is_fast(&meter, travel));
        }
        if (ctl_meter_is_fast(&meter, travel)) {
            fast++;
            const num_t got = ctl_meter_torque_fast(&meter, theta, travel, ref);
            ASSERT_SAME_BITS(want, got);
        } else {
            (void)ctl_meter_torque_unchecked(&meter, theta, ref);
        }
    }
    TEST_ASSERT_EQUAL_INT(298, fast);

    const ctl_meter_params_t orders[] = {params_of(9U, 10U, 0.0), params_of(10U, 10U, 0.0)};
    for (uint16_t i = 0; i < 2; i++) {
        start(&orders[i]);
        (void)ctl_meter_torque_unchecked(&meter, 0U, (num_t)0);
        TEST_ASSERT_EQUAL(i == 0, ctl_meter_is_fast(&meter, (num_t)0));
    }
    ctl_meter_params_t far = params_of(9U, 10U, 0.0);
    far.step_max_rad = num_of(1.6); /* more than a quarter turn: an observer has to look at its steps itself */
    start(&far);
    (void)ctl_meter_torque_unchecked(&meter, 0U, (num_t)0);
    TEST_ASSERT_FALSE(ctl_meter_is_fast(&meter, (num_t)0));
}

void test_ctl_meter_speed_that_nobody_asked_for_resumes_from_the_speed_of_now(void)
{
    for (int k = 0; k < 50; k++) {
        (void)ctl_meter_torque_unchecked(&meter, angle_at(0.01 * k), (num_t)0); /* 100 rad/s: 1 */
    }

    ctl_meter_resume_speed(&meter);

    for (int k = 50; k < 60; k++) {
        (void)ctl_meter_torque_unchecked(&meter, angle_at(0.01 * k), (num_t)0);
        ASSERT_NUM_WITHIN(1e-5, 1.0, ctl_meter_speed_unchecked(&meter));
    }
}

/* Other filters than before, of other lengths: after a reset all is as in a meter that never had others. */
void test_ctl_meter_tuned_to_other_filters_is_after_a_reset_as_a_new_one(void)
{
    const ctl_meter_params_t p = params_of(4U, 12U, 0.001);
    for (int k = 0; k < 50; k++) {
        (void)torque_nm(0.02 * k, 1.0);
    }
    ctl_meter_tune(&meter, &p);
    ctl_meter_reset(&meter);
    ctl_meter_t tuned = meter;
    memset(&meter, 0xA5, sizeof meter);
    start(&p);
    TEST_ASSERT_EQUAL_UINT32(0U, meter.state.rejected);
    TEST_ASSERT_EQUAL_UINT32(0U, meter.state.speed_fir.state.rejected);
    TEST_ASSERT_EQUAL_UINT16(ctl_meter_age_half(&meter.params), ctl_meter_age_half(&tuned.params));
    TEST_ASSERT_EQUAL_UINT16(2U + 4U + 12U, ctl_meter_age_half(&tuned.params)); /* a filter of order n is n half samples late */
    for (int k = 0; k < 100; k++) {
        const ctl_meter_out_t want = ctl_meter_step(&meter, angle_at(0.01 * k), num_of(0.5));
        const ctl_meter_out_t got = ctl_meter_step(&tuned, angle_at(0.01 * k), num_of(0.5));
        TEST_ASSERT_TRUE_MESSAGE((want.speed == got.speed) && (want.torque == got.torque), at("sample %d", k));
    }
}

void test_ctl_meter_step_of_exactly_the_largest_is_no_jump_and_one_of_a_little_more_is(void)
{
    ctl_meter_params_t p = valid_params();
    p.step_max_rad = ctl_meter_travel(&meter, meter.state.theta + 0x08000000U);
    for (uint32_t more = 0U; more < 2U; more++) {
        start(&p);
        const angle_t from = 0x10000000U;
        (void)ctl_meter_step(&meter, from, (num_t)0);
        (void)ctl_meter_step(&meter, from + 0x08000000U + (more * 0x1000U), (num_t)0);
        TEST_ASSERT_EQUAL_UINT32(more, meter.state.rejected);
    }
}

void test_ctl_meter_that_is_accepted_names_no_field(void)
{
    const ctl_meter_params_t p = valid_params();
    ASSERT_DIAG(CTL_OK, 0U, 0.0, ctl_meter_check(&p));
    ASSERT_DIAG(CTL_OK, 0U, 0.0, ctl_meter_init(&meter, &p));
}
