/* What is corrected by a few numbers of its own: a notch filter behind the speed controller, the error of the encoder's angle, the
 * harmonics of the magnet flux, an inductance that falls with the current. The blocks: tests/control/motor; what they leave in a machine: tools/tests/test_corrections.py. */
#include "firmware/app/internal.h"
#include "firmware/app/memory_check.h"
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

#define KP 0.0368 /* A per electrical rad/s */
#define KI_TS 0.92e-3
#define AMP_TOLERANCE 3e-5

void setUp(void) { bench_start(); }
void tearDown(void) {}

static double iq_ref(void) { return (double)telemetry_read(&drive, SIGNAL_iq_ref_a); }
static double theta(void)
{
    return (double)drive.tracking.theta_m * TWO_PI / TURN_STEPS;
} /* the telemetry has that of the encoder */

/* ---- notch filter ----------------------------------------------------------------------------------------------------------- */

static drive_params_t with_notch(void)
{
    drive_params_t p = bench_params();
    p.speed_inline = 1U;
    p.speed_notch_hz = 60.0f;
    p.speed_notch_damping = 0.3f;
    p.speed_notch_depth = 0.1f;
    return p;
}

/* The transfer function in polynomials of z, as a difference equation: 60 Hz of 1 kHz, damping 0.3, depth 0.1. */
static double notched(double x)
{
    static double x1, x2, y1, y2;
    const double  k = tan(0.5 * TWO_PI * 0.06), wide = 0.6 * k, narrow = 0.06 * k, both = 2.0 * k * k - 2.0;
    if (isnan(x)) {
        x1 = x2 = y1 = y2 = 0.0;
        return 0.0;
    }
    const double y =
        ((1.0 + narrow + k * k) * x + both * x1 + (1.0 - narrow + k * k) * x2 - both * y1 - (1.0 - wide + k * k) * y2) /
        (1.0 + wide + k * k);
    x2 = x1;
    x1 = x;
    y2 = y1;
    y1 = y;
    return y;
}

/* rotor at rest, reference 0.5 rad/s: an error of 2 units, a proportional step and a ramp out of the controller */
void test_corrections_notch_filters_what_the_speed_controller_asks_for(void)
{
    const drive_params_t p = with_notch();
    bench_run_with(&p);
    (void)notched((double)NAN);
    bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
    for (int k = 0; k < 60; k++) {
        bench_periods(10U);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(AMP_TOLERANCE, notched(2.0 * (KP + KI_TS * k)), iq_ref(), at("sample %d", k));
    }
}

void test_corrections_notch_that_is_switched_on_while_running_makes_no_step(void)
{
    drive_params_t p = with_notch();
    p.speed_notch_hz = 0.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 0.5, 0.0, 0.0);
    bench_periods(1000U);
    bench_command(DRIVE_MODE_SPEED, 0.0, 0.0, 0.0); /* error 0: what is left is the integral part */
    bench_periods(100U);
    const double before = iq_ref();
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 2.0 * KI_TS * 100.0, before);
    uint16_t culprit = 0U;
    p.speed_notch_hz = 60.0f;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    for (int k = 0; k < 30; k++) {
        bench_periods(10U);
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, before, iq_ref());
    }
}

void test_corrections_speed_mode_begins_with_the_torque_of_the_mode_before_it(void)
{
    const drive_params_t p = with_notch();
    bench_run_with(&p);
    bench_command(DRIVE_MODE_TORQUE, 100.0, 0.0, 2.0);
    bench_periods(200U);
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0, iq_ref());
    bench_command(DRIVE_MODE_SPEED, 0.0, 0.0, 0.0);
    for (int k = 0; k < 30; k++) {
        bench_periods(10U);
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0, iq_ref());
    }
}

/* ---- angle ------------------------------------------------------------------------------------------------------------------- */

static const double ERROR[4] = {0.03, -0.08, 0.01, 0.02};
#define LARGE 4.5 /* where it is larger than encoder_jump_rad */

static drive_params_t with_error(void)
{
    drive_params_t p = bench_params();
    p.encoder_cos1_rad = (float)ERROR[0];
    p.encoder_sin1_rad = (float)ERROR[1];
    p.encoder_cos2_rad = (float)ERROR[2];
    p.encoder_sin2_rad = (float)ERROR[3];
    p.encoder_jump_rad = 0.05f;
    return p;
}

static double error_at(double m)
{
    return ERROR[0] * cos(m) + ERROR[1] * sin(m) + ERROR[2] * cos(2.0 * m) + ERROR[3] * sin(2.0 * m);
}

static double arc(double rad) { return remainder(rad, TWO_PI); }

void test_corrections_angle_is_without_the_error_of_the_encoder_in_both_directions_of_counting(void)
{
    for (uint16_t reversed = 0U; reversed < 2U; reversed++) {
        setUp();
        drive_params_t p = with_error();
        p.encoder_reversed = reversed;
        bench_angle((reversed != 0U) ? -LARGE : LARGE);
        bench_run_with(&p);
        for (double m = LARGE; m < 11.0; m += 0.01) {
            bench_angle((reversed != 0U) ? -m : m);
            bench_period();
            /* a float of up to 2 pi, and the sine of the error */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-6, 0.0, arc(theta() - (m - error_at(m))), at("%g", m));
        }
        ASSERT_NO_FAULT("a smooth error is no lost encoder");
    }
}

void test_corrections_angle_that_jumps_is_still_a_lost_encoder(void)
{
    const drive_params_t p = with_error();
    bench_run_with(&p);
    bench_angle(1.0);
    bench_period();
    bench_angle(1.0);
    bench_period();
    bench_angle(1.2);
    bench_periods(3U);
    ASSERT_FAULT(FAULT_encoder_lost, "0.2 rad in a period");
}

/* 37 counts in 1 ms; the speed of the shaft is that of the encoder less the slope of the error there */
void test_corrections_mt_speed_is_that_of_the_shaft(void)
{
    drive_params_t p = with_error();
    p.speed_inline = 1U;
    bench_run_with(&p);
    const double w = TWO_PI * 37.0 / 4.0;
    double       m = 2.0;
    bench_period();
    for (int k = 0; k < 40; k++) {
        for (int i = 0; i < 9; i++) {
            m += w * 1e-4;
            bench_angle(m);
            bench_period();
        }
        m += w * 1e-4;
        bench_angle(m);
        bench.edge.edge_count += 37;
        bench.edge.edge_cyc += 200000U;
        bench.clock_cyc = bench.edge.edge_cyc;
        bench_period();
        if (k > 2) {
            const double moved = m - error_at(m) - ((m - 1e-3 * w) - error_at(m - 1e-3 * w)); /* over the same 1 ms */
            /* the slope is taken at the corrected angle: largest error times largest curvature, 0.108 * 0.175 */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.019 * w, moved * 1e3, (double)telemetry_read(&drive, SIGNAL_speed_rad_s),
                                              at("%d", k));
        }
    }
}

void test_corrections_angle_error_changes_at_rest_and_voids_the_zero_that_was_found_without_it(void)
{
    drive_params_t p = bench_params();
    p.encoder_jump_rad = 0.05f;
    bench_angle(LARGE);
    bench_run_with(&p);
    uint16_t             culprit = 0U;
    const drive_params_t q = with_error();
    TEST_ASSERT_FALSE(drive_tune(&drive, &q, &culprit));
    TEST_ASSERT_EQUAL_UINT16(PARAM_encoder_cos1_rad, culprit);
    drive_stop(&drive);
    bench_live(20U);
    drive.zero.found = true;
    drive.zero.pole_pairs = p.pole_pairs;
    p.rc_gain = 0.5f;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    bench_live(20U);
    TEST_ASSERT_TRUE(drive.zero.found);
    TEST_ASSERT_TRUE(drive_tune(&drive, &q, &culprit));
    TEST_ASSERT_FALSE(drive.zero.found);
    bench_live(20U);
    ASSERT_NO_FAULT("the angle may jump then");
    drive_start(&drive);
    bench_live(20U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

/* ---- flux -------------------------------------------------------------------------------------------------------------------- */

static drive_params_t with_flux(void)
{
    drive_params_t p = bench_params();
    p.speed_inline = 1U;
    p.flux_cos6 = 0.06f;
    p.flux_sin6 = -0.02f;
    p.flux_cos12 = 0.01f;
    p.flux_sin12 = 0.03f;
    return p;
}

static double flux_at(double e)
{
    return 0.06 * cos(6.0 * e) - 0.02 * sin(6.0 * e) + 0.01 * cos(12.0 * e) + 0.03 * sin(12.0 * e);
}

void test_corrections_q_current_makes_the_torque_asked_for_whatever_the_flux_is_there(void)
{
    const drive_params_t p = with_flux();
    bench_run_with(&p);
    bench_command(DRIVE_MODE_TORQUE, 100.0, 0.0, 2.0);
    for (double m = 0.0; m < 1.6; m += 0.01) { /* an electrical turn of 4 pole pairs */
        bench_angle(m);
        bench_period();
        if (iq_ref() > 1.999) {
            const double r = flux_at(4.0 * m), iq = value_of(drive.current.ref.q) * (double)drive.scale.current_a;
            /* 1 - r + r^2 for 1 / (1 + r): r^3 / (1 + r) is left */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.0 * fabs(r * r * r) / (1.0 + r) + 1e-5, 2.0 / (1.0 + r), iq, at("%g", m));
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.0, value_of(drive.current.torque) * (double)drive.scale.current_a);
        }
    }
}

void test_corrections_q_current_stays_within_its_limit_and_current_mode_has_the_current_asked_for(void)
{
    const drive_params_t p = with_flux();
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 3.0);
    for (double m = 0.0; m < 1.6; m += 0.01) {
        bench_angle(m);
        bench_period();
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 3.0, value_of(drive.current.ref.q) * (double)drive.scale.current_a);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, value_of(drive.current.q.state.x)); /* and no voltage of the harmonics */
    }
    bench_command(DRIVE_MODE_SPEED, 300.0, 0.0, 0.0);
    for (double m = 0.0; m < 1.6; m += 0.01) {
        bench_angle(m);
        bench_period();
        TEST_ASSERT_TRUE(fabs(value_of(drive.current.ref.q)) * (double)drive.scale.current_a <= 10.0 * 1.000001);
    }
}

/* v = R di + p w (psi r + L d(di)/d(angle)), where the rotor will be in 1.5 periods; as the integral part holds it, without gains of its own */
void test_corrections_voltage_of_the_harmonics_is_that_of_the_machine(void)
{
    const drive_params_t p = with_flux();
    bench_run_with(&p);
    bench_command(DRIVE_MODE_TORQUE, 200.0, 0.0, 2.0);
    for (int end = 0; end < 12; end++) {
        bench_spin(100.0, 0.13 * end);
        const double w = value_of(drive.tracking.pll.state.w) * (double)drive.scale.speed_rad_s;
        const double e = 4.0 * (0.13 * end + 1.5e-4 * w);
        const double step = 1e-4, i0 = 2.0 / (1.0 + flux_at(e - step)), i1 = 2.0 / (1.0 + flux_at(e + step));
        const double expected =
            0.36 * (0.5 * (i0 + i1) - 2.0) + 4.0 * w * (6.4e-3 * flux_at(e) + 0.2e-3 * (i1 - i0) / (2.0 * step));
        /* r^3 of the series, six times that in the slope: 0.08^3 * 2 A * 6 * 400 / s * 0.2 mH; and the speed of the filter */
        TEST_ASSERT_DOUBLE_WITHIN(3e-3, expected, value_of(drive.current.q.state.x) * (double)drive.scale.voltage_v);
    }
}

/* ---- saturation ---------------------------------------------------------------------------------------------------------------- */

static drive_params_t with_saturation(float cross)
{
    drive_params_t p = bench_params();
    p.saturation_a = 6.0f;
    p.saturation_cross = cross;
    return p;
}

/* Without an integral part, at angle 0: alpha is d, beta is q. The currents stay where they are while the references are elsewhere. */
void test_corrections_proportional_gain_falls_with_the_inductance_between_reference_and_current(void)
{
    for (int cross = 0; cross < 2; cross++) {
        bench_start();
        const drive_params_t p = with_saturation((float)cross);
        bench_run_with(&p);
        bench_command(DRIVE_MODE_CURRENT, 0.0, 2.0, 4.0);
        bench_currents(4.0, 2.0, 0.0);
        double alpha, beta;
        for (int k = 0; k < 3; k++) { /* the sample before counts: from the second period on it is the same */
            bench_period();
            bench_voltage(&alpha, &beta);
        }
        /* three eighths of the way: 3.25 A and 2.75 A; the inductance at each alone, or at the amplitude of both, of 6 A */
        const double d2 = 3.25 * 3.25 / 36.0, q2 = 2.75 * 2.75 / 36.0, kp = (double)p.current_kp_v_per_a;
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, -2.0 * kp / (1.0 + d2 + cross * q2), alpha);
        TEST_ASSERT_DOUBLE_WITHIN(2e-4, 2.0 * kp / (1.0 + q2 + cross * d2), beta);
    }
}

void test_corrections_gain_that_follows_saturation_is_whole_again_for_the_next_start(void)
{
    const drive_params_t p = with_saturation(0.0f);
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 6.0);
    bench_currents(0.0, 6.0, 0.0);
    bench_period();
    bench_period();
    const double whole = value_of(drive.setup->current.pi.kp);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5 * whole + 1e-7, 0.5 * whole, value_of(drive.current.q.params.kp));
    drive_check_memory(&drive);
    ASSERT_NO_FAULT("a gain that follows is no changed memory");
    drive_stop(&drive);
    bench_live(20U);
    drive_start(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_DOUBLE(whole, value_of(drive.current.q.params.kp));
}

void test_corrections_gain_above_that_of_the_set_is_a_changed_memory(void)
{
    const drive_params_t p = with_saturation(0.0f);
    bench_run_with(&p);
    drive.current.d.params.kp = num_mul(NUM_C(1.5f), drive.setup->current.pi.kp);
    drive_check_memory(&drive);
    TEST_ASSERT_EQUAL_INT(FAULT_memory_changed, drive.fault);
}
