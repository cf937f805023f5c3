/* Commands and parameters cross from the main loop to the interrupts as a whole, or not at all. */
#include <string.h>

#include "firmware/app/internal.h"
#include "firmware/app/telemetry.h"
#include "mock_hal_clock.h"
#include "mock_hal_encoder.h"
#include "mock_hal_inverter.h"
#include "mock_hal_limits.h"
#include "mock_hal_sample.h"
#include "tests/firmware/support/bench.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

static double shown(uint16_t signal) { return (double)telemetry_read(&drive, signal); }

/* ---- commands ------------------------------------------------------------------------------------------------------- */

void test_drive_command_acts_as_a_whole_with_the_next_sample(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 1.0, 2.0);
    bench_period();
    bench_command(DRIVE_MODE_CURRENT, 0.0, -3.0, -4.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, shown(SIGNAL_id_ref_a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, shown(SIGNAL_iq_ref_a));

    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -3.0, shown(SIGNAL_id_ref_a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -4.0, shown(SIGNAL_iq_ref_a));
}

void test_drive_command_of_several_the_newest_counts(void)
{
    bench_into(DRIVE_RUN);
    for (int k = 1; k <= 7; k++) {
        bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, (double)k);
    }
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 7.0, shown(SIGNAL_iq_ref_a));
}

/* the interrupt never sees the half that is being written */
void test_drive_command_is_written_where_no_interrupt_reads(void)
{
    bench_into(DRIVE_RUN);
    for (int k = 0; k < 5; k++) {
        const drive_command_t before = drive.command[drive.command_at & 1U];
        const uint16_t        at_before = drive.command_at;
        bench_command(DRIVE_MODE_SPEED, 10.0 + k, 0.0, 0.0);

        TEST_ASSERT_EQUAL_MEMORY(&before, &drive.command[at_before & 1U], sizeof before);
        TEST_ASSERT_NOT_EQUAL_UINT16(at_before, drive.command_at);
    }
}

void test_drive_command_with_a_number_that_is_none_is_refused_and_the_old_one_goes_on(void)
{
    const float bad[] = {NAN, INFINITY, -INFINITY, 1.1e6f, -1.1e6f};
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.5, 1.5);
    for (size_t k = 0; k < COUNT_OF(bad); k++) {
        const drive_command_t speed = {.mode = DRIVE_MODE_SPEED, .speed_ref_rad_s = bad[k]};
        const drive_command_t d = {.mode = DRIVE_MODE_CURRENT, .id_ref_a = bad[k]};
        const drive_command_t q = {.mode = DRIVE_MODE_CURRENT, .iq_ref_a = bad[k]};
        TEST_ASSERT_FALSE(drive_command(&drive, &speed));
        TEST_ASSERT_FALSE(drive_command(&drive, &d));
        const drive_command_t target = {.mode = DRIVE_MODE_POSITION, .target_rad = bad[k]};
        TEST_ASSERT_FALSE(drive_command(&drive, &q));
        TEST_ASSERT_FALSE(drive_command(&drive, &target));
    }
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, shown(SIGNAL_id_ref_a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5, shown(SIGNAL_iq_ref_a));
}

void test_drive_command_before_the_start_acts_after_it(void)
{
    bench_into(DRIVE_READY);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 2.0);
    drive_start(&drive);
    drive_background(&drive);
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, shown(SIGNAL_iq_ref_a));
}

void test_drive_command_beyond_the_speed_that_trips_is_refused(void)
{
    const double bad[] = {650.1, -650.1, 1e6, 5000.0};
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_SPEED, 10.0, 0.0, 0.0);
    for (size_t k = 0; k < COUNT_OF(bad); k++) {
        const drive_command_t c = {.mode = DRIVE_MODE_SPEED, .speed_ref_rad_s = (float)bad[k]};
        float                 limit = 0.0f;
        TEST_ASSERT_FALSE(drive_command(&drive, &c));
        TEST_ASSERT_EQUAL_UINT16(DRIVE_COMMAND_SPEED, drive_command_refuses(&drive, &c, &limit));
    }
    TEST_ASSERT_EQUAL_FLOAT(10.0f, drive.command[drive.command_at & 1U].speed_ref_rad_s);
    bench_command(DRIVE_MODE_SPEED, 650.0, 0.0, 0.0);
    bench_command(DRIVE_MODE_SPEED, -650.0, 0.0, 0.0);
}

/* 20 000 at random: whatever is asked for, the vector that acts is never longer than the longest, and what was not cut is left. */
void test_drive_command_no_vector_is_longer_than_the_limit(void)
{
    noise_t noise = {7U};
    for (int round = 0; round < 20; round++) {
        drive_params_t p = bench_params();
        p.iq_limit_a = (float)(0.5 + 18.0 * fabs(noise_next(&noise)));
        p.id_limit_a = (float)(18.0 * fabs(noise_next(&noise)));
        bench_run_with(&p);
        const double longest = fmax((double)p.iq_limit_a, (double)p.id_limit_a);
        for (int k = 0; k < 1000; k++) {
            const drive_command_t c = {.mode = DRIVE_MODE_CURRENT,
                                       .id_ref_a = (float)(30.0 * noise_next(&noise)),
                                       .iq_ref_a = (float)(30.0 * noise_next(&noise))};
            float                 limit = 0.0f;
            const bool            whole = drive_command_refuses(&drive, &c, &limit) == DRIVE_COMMAND_FINE;
            TEST_ASSERT_TRUE(drive_command(&drive, &c));
            bench_period();
            const double id = shown(SIGNAL_id_ref_a);
            const double iq = shown(SIGNAL_iq_ref_a);
            TEST_ASSERT_TRUE(hypot(id, iq) <= longest * (1.0 + 1e-6) + 1e-5); /* the numeric's step under the root */
            TEST_ASSERT_TRUE(fabs(iq) <= (double)p.iq_limit_a * (1.0 + 1e-6));
            if (whole) {
                TEST_ASSERT_DOUBLE_WITHIN(1e-5, (double)c.id_ref_a, id);
                TEST_ASSERT_DOUBLE_WITHIN(1e-5, (double)c.iq_ref_a, iq);
            }
        }
    }
}

void test_drive_command_follows_limits_that_are_lowered_while_it_acts(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 6.0, 8.0);
    bench_period();
    drive_params_t p = *drive.params;
    p.iq_limit_a = 5.0f;
    p.id_limit_a = 3.0f;
    uint16_t none = 0U;
    TEST_ASSERT_TRUE(drive_tune(&drive, &p, &none));
    bench_period();

    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 3.0, shown(SIGNAL_id_ref_a));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 4.0, shown(SIGNAL_iq_ref_a));
}

/* ---- parameters ----------------------------------------------------------------------------------------------------- */

static uint16_t culprit;

static bool tune(const drive_params_t *p)
{
    culprit = 0x5555U;
    return drive_tune(&drive, p, &culprit);
}

/* Stop, change, go on. */
static void tune_at_rest(const drive_params_t *p)
{
    drive_stop(&drive);
    drive_background(&drive);
    TEST_ASSERT_TRUE(tune(p));
    bench_period();
    drive_start(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
}

static double q_volts(void)
{
    bench_period();
    return shown(SIGNAL_vq_v);
}

void test_drive_tune_acts_between_two_samples_and_not_before(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.6, q_volts());
    drive_params_t p = *drive.params;
    p.current_kp_v_per_a = 0.9f;

    TEST_ASSERT_TRUE(tune(&p));

    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, culprit);
    TEST_ASSERT_EQUAL_FLOAT(0.6f, drive.params->current_kp_v_per_a); /* the interrupts still have the old ones */
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.9, q_volts());
    TEST_ASSERT_EQUAL_FLOAT(0.9f, drive.params->current_kp_v_per_a);
}

/* limits and gains of one change belong together: an interrupt sees both or none */
void test_drive_tune_protection_limits_change_with_the_rest(void)
{
    bench_into(DRIVE_READY);
    bench.sample.vdc_v = 30.0f;
    bench_period();
    drive_params_t p = *drive.params;
    p.over_voltage_v = (float)per_numeric(28.0, 40.0); /* in fixed point it is a base and may not change */
    p.under_voltage_v = (float)per_numeric(5.0, 31.0); /* looked at while the bridge is on */
    TEST_ASSERT_TRUE(tune(&p));
    ASSERT_NO_FAULT("no sample yet");

    bench_period();
    drive_start(&drive);
    drive_background(&drive);
    bench_periods(20U);

    ASSERT_FAULT((drive_fault_t)per_numeric((double)FAULT_over_voltage, (double)FAULT_under_voltage), "30 V are too much now");
}

void test_drive_tune_refused_changes_nothing(void)
{
    bench_into(DRIVE_RUN);
    bench_periods(25U);
    const drive_params_t params_before = *drive.params;
    const drive_setup_t  setup_before = *drive.setup;
    drive_params_t       p = *drive.params;
    p.current_kp_v_per_a = 0.9f;
    p.iq_limit_a = 21.0f; /* more than trips */

    TEST_ASSERT_FALSE(tune(&p));

    TEST_ASSERT_EQUAL_UINT16(PARAM_iq_limit_a, culprit);
    TEST_ASSERT_EQUAL_MEMORY(&params_before, drive.params, sizeof params_before);
    TEST_ASSERT_EQUAL_MEMORY(&setup_before, drive.setup, sizeof setup_before);
    TEST_ASSERT_EQUAL_UINT16(0U, drive.next_ready);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.6, q_volts());
}

void test_drive_tune_refuses_what_is_out_of_range_or_no_number(void)
{
    bench_into(DRIVE_RUN);
    drive_params_t p = *drive.params;
    p.rc_lead = 16U;
    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_UINT16(PARAM_rc_lead, culprit);

    p = *drive.params;
    p.speed_kp_a_per_unit = NAN;
    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_UINT16(PARAM_speed_kp_a_per_unit, culprit);
}

void test_drive_tune_second_change_waits_until_the_first_was_taken_over(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_period();
    drive_params_t p = *drive.params;
    p.current_kp_v_per_a = 0.9f;
    TEST_ASSERT_TRUE(tune(&p));
    p.current_kp_v_per_a = 0.3f;

    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, culprit); /* nothing wrong with it, but not now */
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.9, q_volts());

    TEST_ASSERT_TRUE(tune(&p));
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.3, q_volts());
}

void test_drive_tune_keeps_the_integral_parts(void)
{
    drive_params_t p = bench_params();
    p.current_ki_v_per_as = 1080.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_periods(20U);
    p.current_kp_v_per_a = 0.9f;
    TEST_ASSERT_TRUE(tune(&p));

    TEST_ASSERT_DOUBLE_WITHIN(4e-5, 0.9 + 20.0 * 0.108, q_volts());
}

void test_drive_tune_reaches_the_speed_controller_and_the_tracking_filter(void)
{
    drive_params_t p = bench_params();
    p.speed_inline = 1U;
    p.speed_ki_a_per_unit_s = 0.0f;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 1.0, 0.0, 0.0);
    bench_periods(20U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 4.0 * 0.0368, shown(SIGNAL_iq_ref_a));
    p.speed_kp_a_per_unit = 0.1f;
    p.pll_kp_per_s = 2000.0f;
    p.pll_ki_per_s2 = 500000.0f;
    TEST_ASSERT_TRUE(tune(&p));
    bench_periods(10U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.4, shown(SIGNAL_iq_ref_a));

    /* an angle of 0.01 rad is answered by k_i T_s 0.01 at once */
    bench_angle(0.01);
    bench_period();
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.5, value_of(drive.tracking.pll.state.w) * (double)drive.scale.speed_rad_s);
}

/* The blocks of the speed interrupt may not change under it: the current interrupt waits while it was requested. */
void test_drive_tune_waits_while_the_speed_interrupt_is_under_way(void)
{
    bench_into(DRIVE_RUN);
    bench.sample.seq++;
    drive_current_isr(&drive);
    TEST_ASSERT_TRUE(bench.speed_requested); /* requested, and still running */
    drive_params_t p = *drive.params;
    p.current_kp_v_per_a = 0.9f;
    TEST_ASSERT_TRUE(tune(&p));

    bench.sample.seq++;
    drive_current_isr(&drive);
    TEST_ASSERT_EQUAL_FLOAT(0.6f, drive.params->current_kp_v_per_a);

    drive_speed_isr(&drive);
    bench.sample.seq++;
    drive_current_isr(&drive);
    TEST_ASSERT_EQUAL_FLOAT(0.9f, drive.params->current_kp_v_per_a);
}

void test_drive_tune_interrupt_in_the_middle_of_a_change_sees_the_old_parameters(void)
{
    bench_into(DRIVE_RUN);
    bench_command(DRIVE_MODE_CURRENT, 0.0, 0.0, 1.0);
    bench_period();
    drive_params_t p = *drive.params;
    p.current_kp_v_per_a = 0.9f;
    bench.in_clock_hz = bench_period; /* called while the new setup is made */
    TEST_ASSERT_TRUE(tune(&p));

    TEST_ASSERT_NULL(bench.in_clock_hz);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.6, shown(SIGNAL_vq_v));
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.9, q_volts());
}

/* ---- what a change does to memories --------------------------------------------------------------------------------- */

static drive_params_t learning(void)
{
    drive_params_t p = bench_params();
    p.method = DRIVE_METHOD_FORC;
    p.speed_inline = 1U;
    bench_run_with(&p);
    bench_command(DRIVE_MODE_SPEED, 15.707963, 0.0, 0.0);
    bench_periods(1005U);
    TEST_ASSERT_TRUE(shown(SIGNAL_rc_out_unit) > 1.0);
    return p;
}

void test_drive_tune_of_a_gain_keeps_what_the_repetitive_controller_learned(void)
{
    drive_params_t p = learning();
    const double   before = shown(SIGNAL_rc_out_unit);
    p.rc_gain = 0.61f;
    TEST_ASSERT_TRUE(tune(&p));
    bench_periods(10U);

    TEST_ASSERT_DOUBLE_WITHIN(0.05 * before, before, shown(SIGNAL_rc_out_unit));
}

/* the rotor stands: a period adds the gain times the error; without gain the memory only turns round */
void test_drive_tune_of_a_gain_changes_what_is_learned_from_now_on(void)
{
    drive_params_t p = learning();
    p.rc_gain = 0.0f;
    p.rc_q_side = 0.0f;
    p.rc_q_centre = 1.0f;
    TEST_ASSERT_TRUE(tune(&p));
    bench_periods(1500U); /* the last samples with the old gain have come round */
    const double before = shown(SIGNAL_rc_out_unit);
    bench_periods(1000U); /* a period of 100 samples */

    TEST_ASSERT_TRUE(before > 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * before, before, shown(SIGNAL_rc_out_unit));
}

void test_drive_tune_of_order_lead_or_memory_at_rest_begins_anew(void)
{
    for (int what = 0; what < 3; what++) {
        bench_start();
        drive_params_t p = learning();
        p.rc_order = (what == 0) ? 3U : p.rc_order;
        p.rc_lead = (what == 1) ? 4U : p.rc_lead;
        p.rc_memory = (what == 2) ? 1U : p.rc_memory;
        tune_at_rest(&p);
        bench_periods(10U);

        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, 0.0, shown(SIGNAL_rc_out_unit), at("change %d", what));
        bench_periods(1005U);
        TEST_ASSERT_TRUE_MESSAGE(shown(SIGNAL_rc_out_unit) > 1.0, at("change %d learns again", what));
    }
}

void test_drive_tune_away_from_repetitive_control_takes_its_correction_off(void)
{
    drive_params_t p = learning();
    p.method = DRIVE_METHOD_PI;
    tune_at_rest(&p);
    bench_periods(10U);

    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, shown(SIGNAL_rc_out_unit));
    TEST_ASSERT_EQUAL_UINT32(0U, drive_rejected(&drive));
}

void test_drive_tune_every_method_can_follow_every_other(void)
{
    const uint16_t methods = (uint16_t)(params_info(PARAM_method)->max + 1.0f);
    for (uint16_t from = 0U; from < methods; from++) {
        for (uint16_t to = 0U; to < methods; to++) {
            bench_start();
            drive_params_t p = bench_params();
            p.method = from;
            bench_run_with(&p);
            bench_command(DRIVE_MODE_SPEED, 15.707963, 0.0, 0.0);
            bench_periods(200U);
            p.method = to;
            tune_at_rest(&p);
            bench_periods(200U);

            TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, drive.state, at("%u to %u", (unsigned)from, (unsigned)to));
            ASSERT_DUTIES_LEGAL(at("%u to %u", (unsigned)from, (unsigned)to));
            TEST_ASSERT_EQUAL_UINT16_MESSAGE(to, drive.params->method, at("%u to %u", (unsigned)from, (unsigned)to));
        }
    }
}

/* ---- electrical zero ------------------------------------------------------------------------------------------------ */

static double theta_e(void)
{
    bench_period();
    return (double)drive.tracking.theta_e / TURN_STEPS * TWO_PI;
}

void test_drive_tune_of_the_encoder_offset_acts_at_once_when_the_encoder_is_absolute(void)
{
    bench_into(DRIVE_READY);
    bench_angle(0.5);
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 2.0, theta_e());
    drive_params_t p = *drive.params;
    p.encoder_offset_rad = 0.75f;
    TEST_ASSERT_TRUE(tune(&p));

    TEST_ASSERT_DOUBLE_WITHIN(2e-6, 2.75, theta_e());
}

void test_drive_tune_leaves_the_zero_that_an_alignment_has_found(void)
{
    drive_params_t p = bench_params();
    p.align_periods = BENCH_ALIGN_PERIODS;
    drive_init(&drive, &p);
    drive_background(&drive);
    bench_rotor(4.0, 2.0);
    bench_align();
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    bench.rotor_pairs = 0.0;
    bench_angle(0.0); /* the rotor of the bench has its d axis at encoder angle 0 */

    p.encoder_offset_rad = 0.75f;
    p.align_periods = 0U; /* of the next start-up */
    tune_at_rest(&p);

    TEST_ASSERT_DOUBLE_WITHIN(5e-3, 0.0, remainder(theta_e(), TWO_PI)); /* as the alignment has found it */
}

/* ---- what the electrical angle stands on ------------------------------------------------------------------------------ */

/* Another value that the parameter could have: the other end of its range. */
static bool other_value(drive_params_t *p, uint16_t index)
{
    const param_info_t *const info = params_info(index);
    const float               now = params_get(p, index);
    return params_set(p, index, (now == info->min) ? info->max : info->min);
}

/* One reason after the other: the range and the other parameters come first, then the bridge. */
void test_drive_tune_refuses_what_only_changes_at_rest_while_the_bridge_is_armed(void)
{
    const drive_state_t armed[] = {DRIVE_RUN, DRIVE_ALIGN};
    for (size_t k = 0; k < COUNT_OF(armed); k++) {
        bench_start();
        bench_into(armed[k]);
        const drive_params_t params_before = *drive.params;
        const drive_setup_t  setup_before = *drive.setup;
        uint16_t             tried = 0U;
        for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
            drive_params_t p = *drive.params;
            TEST_ASSERT_TRUE(other_value(&p, i));
            if (!params_only_at_rest(i)) {
                continue;
            }
            tried++;
            TEST_ASSERT_FALSE_MESSAGE(tune(&p), params_info(i)->name);
            TEST_ASSERT_TRUE_MESSAGE(culprit < (uint16_t)PARAM_COUNT, params_info(i)->name);
            TEST_ASSERT_TRUE(drive_needs_rest(&drive, i));
        }
        TEST_ASSERT_TRUE(tried > 30U);
        TEST_ASSERT_EQUAL_UINT16(0U, drive.next_ready);
        TEST_ASSERT_EQUAL_MEMORY(&setup_before, drive.setup, sizeof setup_before);
        TEST_ASSERT_EQUAL_MEMORY(&params_before, drive.params, sizeof params_before);
        bench_periods(2U);
        ASSERT_NO_FAULT("it runs on");
    }
}

void test_drive_tune_names_what_only_changes_at_rest(void)
{
    const uint16_t named[] = {PARAM_pole_pairs, PARAM_encoder_counts,      PARAM_encoder_offset_rad, PARAM_encoder_reversed,
                              PARAM_method,     PARAM_position_method,     PARAM_position_cells,     PARAM_aro_cells,
                              PARAM_rc_order,   PARAM_observer_fir1_order, PARAM_speed_source,       PARAM_lost_sample_limit,
                              PARAM_stall_s};
    bench_into(DRIVE_RUN);
    for (size_t k = 0; k < COUNT_OF(named); k++) {
        drive_params_t p = *drive.params;
        TEST_ASSERT_TRUE(params_set(
            &p, named[k],
            (float)((params_get(&p, named[k]) == 1.0f)
                        ? 0.0f
                        : ((named[k] == (uint16_t)PARAM_encoder_counts)                                                ? 4096.0f
                           : ((named[k] == (uint16_t)PARAM_aro_cells) || (named[k] == (uint16_t)PARAM_position_cells)) ? 100.0f
                                                                                                                       : 1.0f))));
        TEST_ASSERT_FALSE(tune(&p));
        TEST_ASSERT_EQUAL_STRING(params_info(named[k])->name, params_info(culprit)->name);
    }
}

/* What fits between two samples: nothing else may lead to a memory that is cleared or a filter that is started. */
void test_drive_tune_nothing_that_changes_while_running_gives_a_block_another_shape(void)
{
    for (uint16_t method = 0U; method < 7U; method++) {
        for (uint16_t position = 0U; position < 4U; position++) {
            drive_params_t base = bench_params();
            base.method = method;
            base.position_method = position;
            static drive_setup_t before, after; /* zeroed: what a set does not use is not made */
            if (drive_make_setup(&base, &before) != (uint16_t)PARAM_COUNT) {
                continue; /* these do not go together */
            }
            uint16_t tried = 0U;
            for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
                const param_info_t *const info = params_info(i);
                for (int end = 0; (end < 2) && !params_only_at_rest(i); end++) {
                    drive_params_t p = base;
                    after = before;
                    TEST_ASSERT_TRUE(params_set(&p, i, (end == 0) ? info->min : info->max));
                    if (drive_make_setup(&p, &after) == (uint16_t)PARAM_COUNT) {
                        tried++;
                        TEST_ASSERT_EQUAL_UINT16_MESSAGE(0U, drive_shape_changes(&before, &after), info->name);
                    }
                }
            }
            TEST_ASSERT_TRUE(tried > 60U);
        }
    }
}

/* What the take-over of a running drive may change, and what must go on as it was: integrators, filters, memories. */
static void into_learning(drive_params_t *p)
{
    bench_run_with(p);
    bench_command(DRIVE_MODE_SPEED, 15.707963, 0.0, 0.0);
    bench_currents(0.3, -0.2, 0.0);
    bench_periods(505U);
}

void test_drive_tune_while_running_leaves_every_memory_integrator_and_filter_as_it_is(void)
{
    static num_t rc_memory[DRIVE_RC_CAPACITY], observer_memory[DRIVE_OBSERVER_CAPACITY];
    for (uint16_t method = 0U; method < 7U; method++) {
        bench_start();
        drive_params_t base = bench_params();
        base.method = method;
        base.current_ki_v_per_as = 100.0f;
        into_learning(&base);
        for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
            drive_params_t p = base;
            const float    now = params_get(&p, i);
            if (params_only_at_rest(i) || !params_set(&p, i, (now == 0.0f) ? params_info(i)->max : (0.5f * now)) || !tune(&p)) {
                continue;
            }
            const ctl_pi_state_t           d_axis = drive.current.d.state, q_axis = drive.current.q.state;
            const ctl_pi_state_t           speed = drive.speed.pi.state;
            const ctl_pll_state_t          pll = drive.tracking.pll.state;
            const ctl_mt_state_t           mt = drive.speed.mt.state;
            const ctl_meter_state_t        meter = drive.observer.meter.state;
            const ctl_angle_memory_state_t memory = drive.observer.observer.state.memory.state;
            const ctl_ring_t               time = drive.speed.rc.state.time;
            (void)memcpy(rc_memory, drive.rc_memory, sizeof rc_memory);
            (void)memcpy(observer_memory, drive.observer_memory, sizeof observer_memory);

            drive_take_over(&drive);

            const char *const name = params_info(i)->name;
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&d_axis, &drive.current.d.state, sizeof d_axis, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&q_axis, &drive.current.q.state, sizeof q_axis, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&speed, &drive.speed.pi.state, sizeof speed, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&pll, &drive.tracking.pll.state, sizeof pll, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&mt, &drive.speed.mt.state, sizeof mt, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&meter, &drive.observer.meter.state, sizeof meter, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&memory, &drive.observer.observer.state.memory.state, sizeof memory, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&time, &drive.speed.rc.state.time, sizeof time, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(rc_memory, drive.rc_memory, sizeof rc_memory, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(observer_memory, drive.observer_memory, sizeof observer_memory, name);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&p, drive.params, sizeof p, name);
            TEST_ASSERT_TRUE(tune(&base));
            drive_take_over(&drive);
        }
    }
}

void test_drive_tune_takes_the_angle_at_rest(void)
{
    bench_into(DRIVE_READY);
    drive_params_t p = *drive.params;
    p.pole_pairs = 3U;
    p.encoder_reversed = 1U;
    TEST_ASSERT_TRUE(tune(&p));
    TEST_ASSERT_FALSE(drive_needs_rest(&drive, PARAM_pole_pairs));
    TEST_ASSERT_FALSE(drive_needs_rest(&drive, PARAM_COUNT));
}

/* What a drive with @p params asks for and drives, sample by sample, after @p changes at rest that end with these. */
typedef struct {
    num_t iq_ref, vd, vq, robust;
} answer_t;
enum { ANSWERS = 60 };

static drive_params_t another_set(uint16_t method, uint16_t position, uint16_t controller, float factor)
{
    drive_params_t p = bench_params();
    p.method = method;
    p.position_method = position;
    p.current_controller = controller;
    p.speed_divider = 1U;
    p.speed_inline = 1U;
    p.motor_resistance_ohm *= factor;
    p.motor_psi_wb *= factor;
    p.current_kp_v_per_a *= factor;
    p.profile_speed_rad_s = 30.0f * factor;
    p.profile_accel_rad_s2 = 9000.0f * factor;
    p.profile_smooth_samples = (uint16_t)(4.0f * factor);
    p.position_kp_per_s = 8.0f * factor;
    p.position_kv_a_per_rad_s = 0.05f * factor;
    p.rdc_inertia_kgm2 = 1.0e-4f * factor;
    p.rdc_viscous_nms = 1.0e-4f * factor;
    p.rdc_p33 = 1.0e-5f * factor;
    p.rdc_rho_nm = 0.01f * factor;
    return p;
}

static void answers_of(const drive_params_t *p, const drive_params_t *before, unsigned changes, answer_t *out)
{
    bench_start();
    bench_run_with((changes > 0U) ? before : p);
    for (unsigned k = changes; k > 0U; k--) {
        drive_stop(&drive);
        drive_background(&drive);
        TEST_ASSERT_TRUE(tune(((k & 1U) != 0U) ? p : before));
        bench_periods(2U);
    }
    drive_start(&drive);
    drive_background(&drive);
    TEST_ASSERT_EQUAL_INT(DRIVE_RUN, drive.state);
    const bool            repetitive = (p->method != (uint16_t)DRIVE_METHOD_PI) && (p->method < (uint16_t)DRIVE_METHOD_DOB);
    const drive_command_t c = {.mode = repetitive ? DRIVE_MODE_SPEED : DRIVE_MODE_POSITION, /* refused in position mode */
                               .speed_ref_rad_s = 20.0f,
                               .target_turns = 3};
    TEST_ASSERT_TRUE(drive_command(&drive, &c));
    for (unsigned k = 0U; k < (unsigned)ANSWERS; k++) {
        bench_currents(0.1, 0.3, 0.01 * k);
        bench_period();
        out[k] = (answer_t){drive.speed.iq_ref, drive.current.volt.d, drive.current.volt.q, drive.position.rdc.robust};
    }
}

/* Either set can be the one in force: it is another one after every change. */
void test_drive_tune_whichever_set_is_in_force_the_drive_is_the_one_that_began_with_these_numbers(void)
{
    static answer_t want[ANSWERS], got[ANSWERS], other[ANSWERS];
    for (uint16_t v = 0U; v < 7U * 4U * 2U; v++) {
        const uint16_t       method = (uint16_t)(v % 7U), position = (uint16_t)((v / 7U) % 4U), controller = (uint16_t)(v / 28U);
        const drive_params_t p = another_set(method, position, controller, 2.0f);
        const drive_params_t before = another_set(method, position, controller, 1.0f);
        if ((method >= (uint16_t)DRIVE_METHOD_DOB) && ((position == 1U) || (position == 2U))) {
            continue; /* these do not go together */
        }
        answers_of(&p, &before, 0U, want);
        answers_of(&before, &p, 0U, other);
        TEST_ASSERT_TRUE_MESSAGE(memcmp(want, other, sizeof want) != 0, at("case %u: the sets make no difference", v));
        for (unsigned changes = 1U; changes <= 3U; changes++) {
            answers_of(&p, &before, changes, got);
            TEST_ASSERT_EQUAL_MEMORY_MESSAGE(want, got, sizeof want, at("case %u, %u changes", v, changes));
        }
    }
}

/* ---- set up at rest, while the interrupts run on ------------------------------------------------------------------------ */

typedef struct {
    ctl_rc_t       rc;
    ctl_meter_t    meter;
    ctl_observer_t observer;
    ctl_ilc_t      ilc, learn;
    ctl_src_t      src;
    num_t          rc_memory[DRIVE_RC_CAPACITY], observer_memory[DRIVE_OBSERVER_CAPACITY];
} blocks_t;

static void look(blocks_t *b)
{
    (void)memset(b, 0, sizeof *b);
    (void)memcpy(&b->rc, &drive.speed.rc, sizeof b->rc);
    (void)memcpy(&b->meter, &drive.observer.meter, sizeof b->meter);
    (void)memcpy(&b->observer, &drive.observer.observer, sizeof b->observer);
    (void)memcpy(&b->ilc, &drive.position.ilc, sizeof b->ilc);
    (void)memcpy(&b->learn, &drive.position.learn, sizeof b->learn);
    (void)memcpy(&b->src, &drive.position.src, sizeof b->src);
    (void)memcpy(b->rc_memory, drive.rc_memory, sizeof b->rc_memory);
    (void)memcpy(b->observer_memory, drive.observer_memory, sizeof b->observer_memory);
}

/* Every word of these blocks stands for one that the main loop is about to write: the interrupts neither write it nor, since
 * the bytes would make stray pointers and counts, walk along it. */
static void spoil(void)
{
    (void)memset(&drive.speed.rc, 0x5A, sizeof drive.speed.rc);
    (void)memset(&drive.observer.meter, 0x5A, sizeof drive.observer.meter);
    (void)memset(&drive.observer.observer, 0x5A, sizeof drive.observer.observer);
    (void)memset(&drive.position.ilc, 0x5A, sizeof drive.position.ilc);
    (void)memset(&drive.position.learn, 0x5A, sizeof drive.position.learn);
    (void)memset(&drive.position.src, 0x5A, sizeof drive.position.src);
    (void)memset(drive.rc_memory, 0x5A, sizeof drive.rc_memory);
    (void)memset(drive.observer_memory, 0x5A, sizeof drive.observer_memory);
}

void test_drive_tune_interrupts_keep_away_from_blocks_that_are_being_set_up(void)
{
    static blocks_t     before, after;
    const drive_state_t rest[] = {DRIVE_READY, DRIVE_INIT, DRIVE_OFFSET_CALIBRATION, DRIVE_FAULT};
    const drive_mode_t  mode[] = {DRIVE_MODE_SPEED, DRIVE_MODE_POSITION};
    for (size_t k = 0; k < COUNT_OF(rest) * COUNT_OF(mode) * 7U; k++) {
        if ((mode[(k / 7U) % 2U] == DRIVE_MODE_POSITION) && ((k % 7U) >= DRIVE_METHOD_CRC) &&
            ((k % 7U) <= DRIVE_METHOD_FAL_FORC)) {
            continue; /* these do not go together */
        }
        bench_start();
        bench_into(rest[k / 14U]);
        drive_params_t p = *drive.params;
        p.method = (uint16_t)(k % 7U);
        p.speed_source = (p.method == 0U) ? 2U : 1U; /* pi with the meter for the speed */
        p.speed_inline = (uint16_t)(k & 1U);
        TEST_ASSERT_TRUE(tune(&p));
        bench_periods(3U);
        bench_command(mode[(k / 7U) % 2U], 50.0, 0.0, 0.0);

        drive_withdraw(&drive, DRIVE_SHAPE_REPETITIVE | DRIVE_SHAPE_METER | DRIVE_SHAPE_OBSERVER | DRIVE_SHAPE_POSITION);
        spoil();
        look(&before);
        bench_periods(25U);
        look(&after);

        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&before, &after, sizeof before, at("case %u", (unsigned)k));
    }
}

/* From the moment at which their memory changes hands to the one at which the interrupt takes the change over. */
void test_drive_tune_at_rest_withdraws_what_it_sets_up_until_the_interrupt_takes_over(void)
{
    bench_into(DRIVE_READY);
    drive_params_t p = *drive.params;
    p.method = DRIVE_METHOD_ARO;
    TEST_ASSERT_TRUE(tune(&p));
    bench_periods(3U);
    TEST_ASSERT_TRUE(drive.setup->observer.meter_used && drive.setup->observer.used);
    p.observer_fir1_order = 12U;
    p.aro_cells = 300U;
    TEST_ASSERT_TRUE(tune(&p));
    TEST_ASSERT_FALSE(drive.setup->observer.meter_used || drive.setup->observer.used);
    bench_periods(1U);
    TEST_ASSERT_TRUE(drive.setup->observer.meter_used && drive.setup->observer.used);
    bench_periods(20U);

    p.method = DRIVE_METHOD_FORC;
    TEST_ASSERT_TRUE(tune(&p));
    bench_periods(20U);
    TEST_ASSERT_TRUE(drive.setup->speed.rc_used);
    p.rc_order = 3U;
    TEST_ASSERT_TRUE(tune(&p));
    TEST_ASSERT_FALSE(drive.setup->speed.rc_used);
    bench_periods(20U);
    TEST_ASSERT_TRUE(drive.setup->speed.rc_used);
}

/* The blocks are set up when drive_tune comes back; the interrupt only takes flags and numbers over. */
void test_drive_tune_at_rest_sets_up_before_the_interrupt_takes_over(void)
{
    static blocks_t before, after;
    bench_into(DRIVE_READY);
    for (uint16_t method = 0U; method < 7U; method++) {
        drive_params_t p = *drive.params;
        p.method = method;
        p.aro_cells = 2048U;
        TEST_ASSERT_TRUE(tune(&p));
        look(&before);
        bench.sample.seq++;
        drive_current_isr(&drive);
        look(&after);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(before.rc_memory, after.rc_memory, sizeof before.rc_memory,
                                         at("method %u", (unsigned)method));
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(before.observer_memory, after.observer_memory, sizeof before.observer_memory,
                                         at("method %u", (unsigned)method));
        TEST_ASSERT_EQUAL_UINT16(method, drive.params->method);
        bench_periods(20U);
    }
    ASSERT_NO_FAULT("never");
}

/* ---- the board's maxima ------------------------------------------------------------------------------------------------- */

typedef struct {
    uint16_t param;
    float    most;
} bound_t;

static const hal_limits_t SMALL_BOARD = {25.0f, 45.0f, 700.0f, 0.8f, 0.0f, true};
static const bound_t BOUND[] = {{PARAM_over_current_a, 25.0f},  {PARAM_iq_limit_a, 25.0f},       {PARAM_id_limit_a, 25.0f},
                                {PARAM_align_current_a, 25.0f}, {PARAM_over_voltage_v, 45.0f},   {PARAM_voltage_limit_v, 45.0f},
                                {PARAM_offset_limit_a, 0.8f},   {PARAM_over_speed_rad_s, 700.0f}};

void test_drive_tune_no_limit_goes_beyond_the_maximum_of_the_board(void)
{
    const drive_state_t state[] = {DRIVE_READY, DRIVE_RUN};
    for (size_t k = 0; k < COUNT_OF(BOUND) * COUNT_OF(state); k++) {
        const bound_t *const b = &BOUND[k / 2U];
        bench_start();
        bench.limits = SMALL_BOARD;
        bench_into(state[k % 2U]);
        TEST_ASSERT_EQUAL_FLOAT(b->most, drive_board_max(b->param));
        const float beyond[] = {nextafterf(b->most, INFINITY), params_info(b->param)->max};
        for (size_t i = 0; i < COUNT_OF(beyond); i++) {
            drive_params_t p = *drive.params;
            TEST_ASSERT_TRUE(params_set(&p, b->param, beyond[i]));
            TEST_ASSERT_FALSE(tune(&p));
            TEST_ASSERT_EQUAL_STRING(params_info(b->param)->name, params_info(culprit)->name);
        }
    }
}

void test_drive_init_takes_the_maximum_of_the_board_and_nothing_beyond(void)
{
    for (size_t k = 0; k < COUNT_OF(BOUND) * 2U; k++) {
        bench_start();
        bench.limits = SMALL_BOARD;
        drive_params_t p = bench_params();
        p.over_current_a = 25.0f;
        const bool beyond = (k & 1U) != 0U;
        TEST_ASSERT_TRUE(
            params_set(&p, BOUND[k / 2U].param, beyond ? nextafterf(BOUND[k / 2U].most, INFINITY) : BOUND[k / 2U].most));
        drive_init(&drive, &p);

        TEST_ASSERT_EQUAL_INT_MESSAGE(beyond ? FAULT_configuration : FAULT_none, drive.fault,
                                      params_info(BOUND[k / 2U].param)->name);
        TEST_ASSERT_EQUAL_UINT16(beyond ? BOUND[k / 2U].param : 0U, drive.fault_detail);
    }
}

void test_drive_tune_refuses_a_voltage_limit_that_lets_no_current_flow(void)
{
    const float none[] = {1.0e-30f, 1.0e-6f, 0.0999f};
    bench_into(DRIVE_READY);
    for (size_t k = 0; k < COUNT_OF(none); k++) {
        drive_params_t p = *drive.params;
        p.voltage_limit_v = none[k];
        TEST_ASSERT_FALSE(tune(&p));
        TEST_ASSERT_EQUAL_UINT16(PARAM_voltage_limit_v, culprit);
    }
    drive_params_t p = *drive.params;
    p.voltage_limit_v = 0.1f;
    TEST_ASSERT_TRUE(tune(&p));
}

/* ---- bases of the fixed build --------------------------------------------------------------------------------------- */

static void assert_base_refused(uint16_t index, float value)
{
    drive_params_t p = *drive.params;
    TEST_ASSERT_TRUE(params_set(&p, index, value));
    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_STRING(params_info(index)->name, params_info(culprit)->name);
}

void test_drive_tune_in_fixed_point_refuses_a_new_base_by_the_name_of_its_parameter(void)
{
    FIXED_ONLY();
    bench_into(DRIVE_READY);
    assert_base_refused(PARAM_over_current_a, 30.0f);
    assert_base_refused(PARAM_over_voltage_v, 50.0f);
    assert_base_refused(PARAM_over_speed_rad_s, 700.0f);
    assert_base_refused(PARAM_speed_error_gain, 1.0f);
}

/* the product of the two is a base as well, and stays */
void test_drive_tune_in_fixed_point_is_not_fooled_by_two_changes_that_cancel(void)
{
    FIXED_ONLY();
    bench_into(DRIVE_READY);
    drive_params_t p = *drive.params;
    p.over_speed_rad_s *= 2.0f;
    p.speed_error_gain *= 0.5f;

    TEST_ASSERT_FALSE(tune(&p));
    TEST_ASSERT_EQUAL_UINT16(PARAM_over_speed_rad_s, culprit);
}

void test_drive_tune_in_float_takes_new_limits_at_rest(void)
{
    FLOAT_ONLY();
    bench_into(DRIVE_READY);
    drive_params_t p = *drive.params;
    p.over_current_a = 15.0f;
    p.over_speed_rad_s = 100.0f;
    TEST_ASSERT_TRUE(tune(&p));
    bench_period();

    bench.sample.ia_a = 16.0f;
    bench_period();
    ASSERT_FAULT(FAULT_over_current, "16 of 15 A");
}
