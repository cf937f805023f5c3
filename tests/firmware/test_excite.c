/* firmware/app/excite.c, and what the interrupts make of it: a sine of known frequency, amplitude and place; when it ends. */
#include <math.h>

#include "firmware/app/internal.h"
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

#define AMP_TOLERANCE 1e-5 /* of 10 A: the float, and some steps of 6e-8 of the base */

void setUp(void) { bench_start(); }
void tearDown(void) {}

static double read(uint16_t signal) { return (double)telemetry_read(&drive, signal); }

static uint16_t excite(drive_excite_t where, double amplitude, double hz)
{
    const drive_excitation_t e = {where, (float)amplitude, (float)hz};
    float                    low;
    float                    high;
    float                    made;
    const uint16_t           field = drive_excite(&drive, &e, &low, &high, &made);
    if (field == (uint16_t)DRIVE_EXCITE_FINE) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * hz, hz, (double)made);
    }
    return field;
}

static void run(drive_mode_t mode, double speed, double iq)
{
    const drive_params_t p = bench_params();
    bench_run_with(&p);
    bench_command(mode, speed, 0.0, iq);
    bench_periods(1U);
}

static double sine(double amplitude, double hz, unsigned k) { return amplitude * sin(2.0 * PI_OF_CIRCLE * hz * k * 1e-4); }

void test_excite_current_mode_adds_a_sine_to_the_commanded_current(void)
{
    run(DRIVE_MODE_CURRENT, 0.0, 1.5);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_EXCITE_FINE, excite(DRIVE_EXCITE_CURRENT, 0.5, 437.0));
    for (unsigned k = 1U; k < 300U; k++) {
        bench_period();
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 1.5 + sine(0.5, 437.0, k), read(SIGNAL_iq_ref_a));
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, sine(0.5, 437.0, k), read(SIGNAL_excitation_a));
    }
    drive_background(&drive);
    ASSERT_NO_FAULT("and the memory check knows of it");
}

/* an integral part of 0, so that the torque asked for stands: 0.0368 A per unit, 4 units per rad/s, at rest */
void test_excite_speed_mode_adds_it_to_what_the_speed_loop_asks_for(void)
{
    drive_params_t p = bench_params();
    p.speed_ki_a_per_unit_s = 0.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 10.0, 0.0, 0.0);
    bench_periods(20U);
    const double asked = 4.0 * 0.0368 * 10.0;
    TEST_ASSERT_EQUAL_UINT16(DRIVE_EXCITE_FINE, excite(DRIVE_EXCITE_CURRENT, 0.25, 80.0));
    for (unsigned k = 1U; k < 300U; k++) {
        bench_period();
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, asked + sine(0.25, 80.0, k), read(SIGNAL_iq_ref_a));
    }
}

/* another frequency goes on from the phase that there is; another place begins where its own phase is */
void test_excite_changes_frequency_without_a_step(void)
{
    run(DRIVE_MODE_CURRENT, 0.0, 0.0);
    (void)excite(DRIVE_EXCITE_CURRENT, 1.0, 100.0);
    bench_periods(25U); /* a quarter turn: at its top, where the sine has no slope */
    (void)excite(DRIVE_EXCITE_CURRENT, 1.0, 50.0);
    bench_period();
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, cos(2.0 * PI_OF_CIRCLE * 50.0 * 1e-4), read(SIGNAL_iq_ref_a));
}

void test_excite_stays_within_the_current_limit(void)
{
    run(DRIVE_MODE_CURRENT, 0.0, 9.0);
    (void)excite(DRIVE_EXCITE_CURRENT, 8.0, 100.0);
    for (unsigned k = 1U; k < 100U; k++) {
        bench_period();
        const double there = fmin(sine(8.0, 100.0, k), 1.0);
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 9.0 + there, read(SIGNAL_iq_ref_a));
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, there, read(SIGNAL_excitation_a)); /* what the limit leaves of it */
    }
}

/* a salient machine: the current that makes the torque is smaller, and so is what an excitation of the torque adds to it */
void test_excite_most_torque_per_ampere_scales_it_as_the_torque(void)
{
    drive_params_t p = bench_params();
    p.speed_ki_a_per_unit_s = 0.0f;
    p.mtpa = 1U;
    p.motor_ld_h = 0.2e-3f;
    p.motor_lq_h = 0.8e-3f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 30.0, 0.0, 0.0);
    bench_periods(30U);
    const double alone = read(SIGNAL_iq_ref_a);
    const double share = alone / (4.0 * 0.0368 * 30.0);
    TEST_ASSERT_TRUE(share < 0.95);
    TEST_ASSERT_EQUAL_UINT16(DRIVE_EXCITE_FINE, excite(DRIVE_EXCITE_CURRENT, 0.25, 80.0));
    for (unsigned k = 1U; k < 300U; k++) {
        bench_period();
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, share * sine(0.25, 80.0, k), read(SIGNAL_excitation_a));
        TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, alone + (share * sine(0.25, 80.0, k)), read(SIGNAL_iq_ref_a));
    }
}

/* held from one speed sample to the next; it acts one period after its sample, as what the loop asks for */
void test_excite_torque_is_held_as_long_as_what_the_speed_loop_asks_for(void)
{
    for (unsigned mode = 0U; mode < 2U; mode++) {
        drive_params_t p = bench_params();
        p.speed_ki_a_per_unit_s = 0.0f;
        bench_run_with(&p);
        bench_command((mode == 0U) ? DRIVE_MODE_SPEED : DRIVE_MODE_CURRENT, 10.0, 0.0, 4.0 * 0.0368 * 10.0);
        bench_periods(20U); /* the next period is one with a speed sample */
        const double asked = 4.0 * 0.0368 * 10.0;
        TEST_ASSERT_EQUAL_UINT16(DRIVE_EXCITE_FINE, excite(DRIVE_EXCITE_TORQUE, 0.25, 80.0));
        const double first = (double)drive.current.excite_phase / 4294967296.0;
        for (unsigned k = 0U; k < 300U; k++) {
            bench_period();
            const unsigned samples = (k == 0U) ? 0U : (((k - 1U) / 10U) + 1U);
            const double   e = (samples == 0U) ? 0.0 : (0.25 * sin(2.0 * PI_OF_CIRCLE * (first + (80e-3 * samples))));
            TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, asked + e, read(SIGNAL_iq_ref_a));
            TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, e, read(SIGNAL_excitation_a));
        }
    }
}

/* every sample of the speed loop, beside the reference and on top of a ramp */
void test_excite_speed_reference_is_a_sine_of_the_sample_rate_of_the_loop(void)
{
    for (unsigned ramped = 0U; ramped < 2U; ramped++) {
        drive_params_t p = bench_params();
        p.speed_ramp_rad_s2 = (ramped != 0U) ? 1.0e5f : 0.0f;
        bench_run_with(&p);
        bench_command(DRIVE_MODE_SPEED, 20.0, 0.0, 0.0);
        bench_periods(200U);
        const double before = (double)drive.speed.excite_phase / 4294967296.0;
        TEST_ASSERT_EQUAL_UINT16(DRIVE_EXCITE_FINE, excite(DRIVE_EXCITE_SPEED, 2.0, 37.0));
        for (unsigned k = 1U; k < 60U; k++) {
            bench_periods(10U);
            const double turns = before + (37e-3 * k);
            TEST_ASSERT_DOUBLE_WITHIN(1e-4, 20.0 + (2.0 * sin(2.0 * PI_OF_CIRCLE * turns)), read(SIGNAL_speed_ref_rad_s));
            TEST_ASSERT_EQUAL_DOUBLE(0.0, read(SIGNAL_excitation_a));
        }
    }
}

static bool acts(void) { return drive.order[drive.command_at].excite_step != 0U; }

void test_excite_ends_with_a_command_an_end_and_a_stop(void)
{
    run(DRIVE_MODE_CURRENT, 0.0, 1.0);
    (void)excite(DRIVE_EXCITE_TORQUE, 0.5, 250.0); /* a quarter of its period from one sample to the next */
    bench_periods(15U);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 2.0);
    bench_period();
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0, read(SIGNAL_iq_ref_a));

    (void)excite(DRIVE_EXCITE_CURRENT, 0.5, 100.0);
    bench_periods(5U);
    TEST_ASSERT_TRUE(acts());
    (void)excite(DRIVE_EXCITE_NONE, 0.0, 0.0);
    bench_period();
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0, read(SIGNAL_iq_ref_a));

    (void)excite(DRIVE_EXCITE_CURRENT, 0.5, 100.0);
    drive_stop(&drive);
    drive_background(&drive);
    TEST_ASSERT_FALSE(acts());
    drive_start(&drive);
    bench_live(20U);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    TEST_ASSERT_DOUBLE_WITHIN(AMP_TOLERANCE, 2.0, read(SIGNAL_iq_ref_a));
    ASSERT_NO_FAULT("after a run without it");
}

void test_excite_ends_with_a_fault_and_with_the_ramp_of_a_stop(void)
{
    drive_params_t p = bench_params();
    p.over_speed_rad_s = 100.0f;
    p.profile_speed_rad_s = 1.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 5.0, 0.0, 0.0);
    bench_live(20U);
    (void)excite(DRIVE_EXCITE_SPEED, 1.0, 10.0);
    bench_live(20U);
    drive_stop_by(&drive, DRIVE_STOP_RAMP);
    TEST_ASSERT_FALSE(acts());
    TEST_ASSERT_EQUAL_UINT16(DRIVE_EXCITE_STATE, excite(DRIVE_EXCITE_CURRENT, 0.5, 100.0));

    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 0.0);
    (void)excite(DRIVE_EXCITE_CURRENT, 0.5, 100.0);
    bench.sample.ia_a = 1000.0f;
    bench_live(20U);
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, drive.state);
    TEST_ASSERT_FALSE(acts());
    TEST_ASSERT_EQUAL_DOUBLE(0.0, read(SIGNAL_excitation_a));
}

/* New limits in the middle: what no longer fits ends, what fits goes on. */
void test_excite_ends_where_a_new_parameter_set_refuses_it(void)
{
    run(DRIVE_MODE_CURRENT, 0.0, 0.0);
    drive_params_t p = bench_params();
    uint16_t       culprit;
    (void)excite(DRIVE_EXCITE_CURRENT, 3.0, 100.0);
    p.iq_limit_a = 4.0f;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    bench_live(20U);
    TEST_ASSERT_TRUE(acts());
    p.iq_limit_a = 2.0f;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &culprit));
    bench_live(20U);
    TEST_ASSERT_FALSE(acts());
    ASSERT_NO_FAULT("with either");
}

/* What would be learned of the sine, and played back, refuses it: unless it is frozen, and where it does not act. */
void test_excite_is_refused_where_something_learns(void)
{
    static const struct {
        drive_method_t method;
        bool           angle, hold, refused;
    } CASE[] = {{DRIVE_METHOD_PI, false, false, false},      {DRIVE_METHOD_DOB, false, false, false},
                {DRIVE_METHOD_ARO, false, false, true},      {DRIVE_METHOD_ARO, false, true, false},
                {DRIVE_METHOD_FAL_FORC, false, false, true}, {DRIVE_METHOD_FORC, true, true, false}};
    for (unsigned k = 0U; k < sizeof CASE / sizeof CASE[0]; k++) {
        drive_params_t p = bench_params();
        p.method = (uint16_t)CASE[k].method;
        p.rc_memory = CASE[k].angle ? (uint16_t)CTL_RC_ANGLE : (uint16_t)CTL_RC_KEEP;
        p.observer_hold = CASE[k].hold ? 1U : 0U;
        bench_run_with(&p);
        bench_command(DRIVE_MODE_SPEED, 10.0, 0.0, 0.0);
        bench_periods(20U);
        TEST_ASSERT_EQUAL_UINT16(CASE[k].refused ? DRIVE_EXCITE_WHERE : DRIVE_EXCITE_FINE,
                                 excite(DRIVE_EXCITE_CURRENT, 0.5, 100.0));
    }
}
