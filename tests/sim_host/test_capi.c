/* sim_host/capi/: the lists, refusals with a reason, inputs over time, the same bytes for the same seed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_host/capi/evenspin_capi.h"
#include "unity.h"

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

static es_sim_t *sim;

void setUp(void)
{
    sim = es_sim_new();
    TEST_ASSERT_NOT_NULL(sim);
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "auto_run", 1.0));
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "offset_calibration_periods", 0.0));
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "align_periods", 0.0));
}
void tearDown(void) { es_sim_free(sim); }

static void   start(void) { TEST_ASSERT_TRUE_MESSAGE(es_sim_start(sim), es_sim_error(sim)->name); }
static void   run(int64_t periods) { TEST_ASSERT_EQUAL_INT64(0, es_sim_run(sim, periods, 1, NULL, 0)); }
static double shown(const char *signal) { return es_sim_read(sim, signal); }

static void assert_refused(es_code_t code, const char *list, const char *name)
{
    const es_error_t *const e = es_sim_error(sim);
    TEST_ASSERT_EQUAL_STRING(name, e->name);
    TEST_ASSERT_EQUAL_STRING_MESSAGE(list, e->list, name);
    TEST_ASSERT_EQUAL_INT_MESSAGE(code, e->code, name);
}

/* ---- lists ---------------------------------------------------------------------------------------------------------- */

void test_capi_says_which_numeric_it_is(void)
{
#ifdef EVENSPIN_FIXED
    TEST_ASSERT_EQUAL_STRING("fixed", es_numeric());
#else
    TEST_ASSERT_EQUAL_STRING("float", es_numeric());
#endif
    TEST_ASSERT_TRUE(es_abi_version() >= 1);
}

typedef bool (*info_t)(int index, es_field_t *out);

static void assert_list(info_t info, int count, bool bounded)
{
    es_field_t f;
    es_field_t other;
    TEST_ASSERT_TRUE(count > 0);
    for (int i = 0; i < count; i++) {
        TEST_ASSERT_TRUE(info(i, &f));
        TEST_ASSERT_TRUE(strlen(f.name) > 0U);
        TEST_ASSERT_NOT_NULL_MESSAGE(f.unit, f.name);
        TEST_ASSERT_TRUE_MESSAGE(strlen(f.doc) > 0U, f.name);
        TEST_ASSERT_NOT_NULL_MESSAGE(f.choices, f.name);
        TEST_ASSERT_TRUE_MESSAGE((strcmp(f.kind, "float") == 0) || (strcmp(f.kind, "integer") == 0) ||
                                     (strcmp(f.kind, "flag") == 0) || (strcmp(f.kind, "choice") == 0),
                                 f.name);
        TEST_ASSERT_TRUE_MESSAGE((f.min <= f.value) && (f.value <= f.max), f.name);
        TEST_ASSERT_TRUE_MESSAGE(!bounded || (isfinite(f.min) && isfinite(f.max)), f.name);
        for (int k = 0; k < i; k++) {
            TEST_ASSERT_TRUE(info(k, &other));
            TEST_ASSERT_TRUE_MESSAGE(strcmp(f.name, other.name) != 0, f.name);
        }
    }
    const int outside[] = {-1, count, 1000000, -1000000, 65536, 131072};
    for (size_t k = 0; k < COUNT_OF(outside); k++) {
        TEST_ASSERT_FALSE(info(outside[k], &f));
    }
    TEST_ASSERT_FALSE(info(0, NULL));
}

void test_capi_lists_parameters_signals_model_and_inputs_and_nothing_beyond(void)
{
    assert_list(es_param_info, es_param_count(), true);
    assert_list(es_signal_info, es_signal_count(), false);
    assert_list(es_model_info, es_model_count(), true);
    assert_list(es_input_info, es_input_count(), true);
}

void test_capi_lists_effects_with_their_parameters_and_nothing_beyond(void)
{
    es_effect_t e;
    es_field_t  f;
    for (int i = 0; i < es_effect_count(); i++) {
        TEST_ASSERT_TRUE(es_effect_info(i, &e));
        TEST_ASSERT_TRUE_MESSAGE(strlen(e.signature) > 0U, e.name);
        for (int k = 0; k < e.param_count; k++) {
            TEST_ASSERT_TRUE_MESSAGE(es_effect_param_info(i, k, &f), e.name);
        }
        TEST_ASSERT_FALSE(es_effect_param_info(i, e.param_count, &f));
        TEST_ASSERT_FALSE(es_effect_param_info(i, -1, &f));
    }
    TEST_ASSERT_FALSE(es_effect_info(-1, &e));
    TEST_ASSERT_FALSE(es_effect_info(es_effect_count(), &e));
    TEST_ASSERT_FALSE(es_effect_info(0, NULL));
    TEST_ASSERT_FALSE(es_effect_param_info(-1, 0, &f));
    TEST_ASSERT_FALSE(es_effect_param_info(es_effect_count(), 0, &f));
    TEST_ASSERT_FALSE(es_effect_param_info(0, 0, NULL));
}

void test_capi_lists_faults_and_nothing_beyond(void)
{
    es_fault_t f;
    TEST_ASSERT_TRUE(es_fault_info(0, &f));
    TEST_ASSERT_EQUAL_STRING("none", f.name);
    for (int i = 1; i < es_fault_count(); i++) {
        TEST_ASSERT_TRUE(es_fault_info(i, &f));
        TEST_ASSERT_TRUE_MESSAGE(strlen(f.check) > 0U, f.name);
    }
    TEST_ASSERT_FALSE(es_fault_info(-1, &f));
    TEST_ASSERT_FALSE(es_fault_info(es_fault_count(), &f));
    TEST_ASSERT_FALSE(es_fault_info(0, NULL));
}

/* ---- refusals ------------------------------------------------------------------------------------------------------- */

void test_capi_set_refuses_names_that_do_not_exist(void)
{
    TEST_ASSERT_FALSE(es_sim_set_model(sim, "resistance", 1.0));
    assert_refused(ES_UNKNOWN, "model", "resistance");
    TEST_ASSERT_FALSE(es_sim_set_param(sim, "kp", 1.0));
    assert_refused(ES_UNKNOWN, "param", "kp");
    TEST_ASSERT_FALSE(es_sim_set_effect(sim, "gremlins", "count", 1.0));
    assert_refused(ES_UNKNOWN, "effect", "gremlins");
    TEST_ASSERT_FALSE(es_sim_set_effect(sim, "cogging", "count", 1.0));
    assert_refused(ES_UNKNOWN, "effect_param", "count");
    TEST_ASSERT_EQUAL_STRING("cogging", es_sim_error(sim)->other);
    const double t = 0.0;
    TEST_ASSERT_FALSE(es_sim_set_input(sim, "wind", &t, &t, 1, false));
    assert_refused(ES_UNKNOWN, "input", "wind");
    const char *const signal[2] = {"iq_a", "noise"};
    TEST_ASSERT_FALSE(es_sim_record(sim, signal, 2));
    assert_refused(ES_UNKNOWN, "signal", "noise");
}

void test_capi_set_refuses_values_that_are_no_numbers_or_out_of_range_and_says_the_limits(void)
{
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e30, -1e30};
    for (size_t k = 0; k < COUNT_OF(bad); k++) {
        TEST_ASSERT_FALSE(es_sim_set_model(sim, "resistance_ohm", bad[k]));
        assert_refused(ES_OUT_OF_RANGE, "model", "resistance_ohm");
        TEST_ASSERT_FALSE(es_sim_set_param(sim, "over_current_a", bad[k]));
        assert_refused(ES_OUT_OF_RANGE, "param", "over_current_a");
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, 0.1, es_sim_error(sim)->min); /* a float */
        TEST_ASSERT_EQUAL_DOUBLE(1000.0, es_sim_error(sim)->max);
        TEST_ASSERT_EQUAL_STRING("A", es_sim_error(sim)->unit);
        TEST_ASSERT_EQUAL_DOUBLE(bad[k], es_sim_error(sim)->given);
        TEST_ASSERT_FALSE(es_sim_set_effect(sim, "dead_time", "dead_time_s", bad[k]));
        assert_refused(ES_OUT_OF_RANGE, "effect_param", "dead_time_s");
        TEST_ASSERT_EQUAL_STRING("dead_time", es_sim_error(sim)->other);
        const double t = 0.0;
        TEST_ASSERT_FALSE(es_sim_set_input(sim, "load_torque_nm", &t, &bad[k], 1, false));
        assert_refused(ES_OUT_OF_RANGE, "input", "load_torque_nm");
    }
}

void test_capi_set_refuses_fractions_of_whole_numbers(void)
{
    TEST_ASSERT_FALSE(es_sim_set_model(sim, "pole_pairs", 2.5));
    assert_refused(ES_NOT_WHOLE, "model", "pole_pairs");
    TEST_ASSERT_FALSE(es_sim_set_param(sim, "pole_pairs", 2.5));
    assert_refused(ES_NOT_WHOLE, "param", "pole_pairs");
    TEST_ASSERT_FALSE(es_sim_set_model(sim, "rotor_locked", 0.5));
}

void test_capi_input_refuses_times_that_do_not_rise_and_lists_without_points(void)
{
    const double v[3] = {1.0, 2.0, 3.0};
    const double down[3] = {0.0, 2.0, 1.0};
    const double twice[3] = {0.0, 1.0, 1.0};
    const double nan[3] = {0.0, NAN, 1.0};
    const double never[3] = {0.0, 1.0, INFINITY};
    const double good[3] = {0.0, 1.0, 2.0};
    TEST_ASSERT_FALSE(es_sim_set_input(sim, "speed_ref_rad_s", down, v, 3, false));
    TEST_ASSERT_FALSE(es_sim_set_input(sim, "speed_ref_rad_s", twice, v, 3, false));
    TEST_ASSERT_FALSE(es_sim_set_input(sim, "speed_ref_rad_s", nan, v, 3, false));
    TEST_ASSERT_FALSE(es_sim_set_input(sim, "speed_ref_rad_s", never, v, 3, false));
    assert_refused(ES_TIMES, "input", "speed_ref_rad_s");
    TEST_ASSERT_FALSE(es_sim_set_input(sim, "speed_ref_rad_s", good, v, 0, false));
    TEST_ASSERT_FALSE(es_sim_set_input(sim, "speed_ref_rad_s", good, v, -3, false));
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "speed_ref_rad_s", good, v, 3, false));
}

void test_capi_start_refuses_what_does_not_fit_together_and_names_it(void)
{
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "under_voltage_v", 50.0));
    TEST_ASSERT_FALSE(es_sim_start(sim));
    assert_refused(ES_OTHERS, "param", "under_voltage_v");
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "under_voltage_v", 10.0));
    start();

    TEST_ASSERT_TRUE(es_sim_set_model(sim, "pwm_hz", 20e3));
    TEST_ASSERT_FALSE(es_sim_start(sim));
    assert_refused(ES_OUT_OF_RANGE, "model", "pwm_hz");
    TEST_ASSERT_EQUAL_DOUBLE(10e3, es_sim_error(sim)->min);
    TEST_ASSERT_EQUAL_DOUBLE(10e3, es_sim_error(sim)->max);
}

void test_capi_refused_start_leaves_nothing_that_runs(void)
{
    start();
    run(10);
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "iq_limit_a", 1000.0));
    TEST_ASSERT_FALSE(es_sim_start(sim));
    double row[4];
    TEST_ASSERT_EQUAL_INT64(0, es_sim_run(sim, 4, 1, row, 4));
    TEST_ASSERT_TRUE(isnan(shown("iq_a")));
    TEST_ASSERT_FALSE(es_sim_tune(sim, "rc_gain", 0.5));
}

void test_capi_record_refuses_too_many_none_and_nothing(void)
{
    static const char *many[1000];
    for (size_t k = 0; k < COUNT_OF(many); k++) {
        many[k] = "iq_a";
    }
    TEST_ASSERT_FALSE(es_sim_record(sim, many, 1000));
    TEST_ASSERT_FALSE(es_sim_record(sim, many, 97));
    TEST_ASSERT_TRUE(es_sim_record(sim, many, 96));
    TEST_ASSERT_FALSE(es_sim_record(sim, many, 0));
    TEST_ASSERT_FALSE(es_sim_record(sim, many, -1));
    TEST_ASSERT_FALSE(es_sim_record(sim, NULL, 1));
    const char *const nothing[2] = {"iq_a", NULL};
    TEST_ASSERT_FALSE(es_sim_record(sim, nothing, 2));
}

void test_capi_is_total_for_no_object_and_no_text(void)
{
    const double      x = 0.0;
    double            y[1];
    const char *const s[1] = {"iq_a"};
    es_sim_free(NULL);
    TEST_ASSERT_EQUAL_INT(ES_NO_OBJECT, es_sim_error(NULL)->code);
    TEST_ASSERT_FALSE(es_sim_set_model(NULL, "slots", 1.0));
    TEST_ASSERT_FALSE(es_sim_set_param(NULL, "rc_gain", 1.0));
    TEST_ASSERT_FALSE(es_sim_set_effect(NULL, "cogging", "order", 1.0));
    TEST_ASSERT_FALSE(es_sim_set_seed(NULL, 1U));
    TEST_ASSERT_FALSE(es_sim_set_input(NULL, "id_ref_a", &x, &x, 1, false));
    TEST_ASSERT_FALSE(es_sim_start(NULL));
    TEST_ASSERT_FALSE(es_sim_record(NULL, s, 1));
    TEST_ASSERT_EQUAL_INT64(0, es_sim_run(NULL, 1, 1, y, 1));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, es_sim_time(NULL));
    TEST_ASSERT_TRUE(isnan(es_sim_read(NULL, "iq_a")));
    TEST_ASSERT_FALSE(es_sim_tune(NULL, "rc_gain", 1.0));

    TEST_ASSERT_FALSE(es_sim_set_model(sim, NULL, 1.0));
    TEST_ASSERT_FALSE(es_sim_set_param(sim, NULL, 1.0));
    TEST_ASSERT_FALSE(es_sim_set_effect(sim, NULL, "order", 1.0));
    TEST_ASSERT_FALSE(es_sim_set_effect(sim, "cogging", NULL, 1.0));
    TEST_ASSERT_FALSE(es_sim_set_input(sim, NULL, &x, &x, 1, false));
    TEST_ASSERT_FALSE(es_sim_set_input(sim, "id_ref_a", NULL, &x, 1, false));
    TEST_ASSERT_FALSE(es_sim_set_input(sim, "id_ref_a", &x, NULL, 1, false));
    start();
    TEST_ASSERT_FALSE(es_sim_tune(sim, NULL, 1.0));
    TEST_ASSERT_TRUE(isnan(es_sim_read(sim, NULL)));
    TEST_ASSERT_TRUE(isnan(es_sim_read(sim, "no such signal")));
}

void test_capi_before_the_start_nothing_runs(void)
{
    double row[1];
    TEST_ASSERT_EQUAL_INT64(0, es_sim_run(sim, 10, 1, row, 1));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, es_sim_time(sim));
    TEST_ASSERT_TRUE(isnan(shown("iq_a")));
    TEST_ASSERT_FALSE(es_sim_tune(sim, "rc_gain", 0.5));
}

/* ---- running -------------------------------------------------------------------------------------------------------- */

void test_capi_time_goes_by_periods(void)
{
    start();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, es_sim_time(sim));
    run(1234);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.1234, es_sim_time(sim));
}

void test_capi_drive_runs_from_the_first_period_when_nothing_else_is_asked_for(void)
{
    start();
    run(1);
    TEST_ASSERT_EQUAL_DOUBLE(4.0, shown("state"));
    TEST_ASSERT_EQUAL_DOUBLE(1.0, shown("gate_periods"));
}

void test_capi_rows_are_those_of_every_decimated_period_from_the_first_on(void)
{
    const char *const signal[2] = {"t_s", "state"};
    double            row[8][2];
    TEST_ASSERT_TRUE(es_sim_record(sim, signal, 2));
    start();
    TEST_ASSERT_EQUAL_INT64(7, es_sim_run(sim, 31, 5, &row[0][0], 8)); /* 0, 5, ... 30 */
    for (int k = 0; k < 7; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, 5e-4 * k, row[k][0]);
        TEST_ASSERT_EQUAL_DOUBLE(4.0, row[k][1]);
    }
    TEST_ASSERT_EQUAL_INT64(1, es_sim_run(sim, 5, 5, &row[0][0], 8)); /* goes on with 35 */
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 35e-4, row[0][0]);
}

void test_capi_run_stops_where_the_next_row_has_no_room(void)
{
    const char *const signal[1] = {"t_s"};
    double            row[3];
    TEST_ASSERT_TRUE(es_sim_record(sim, signal, 1));
    start();
    TEST_ASSERT_EQUAL_INT64(3, es_sim_run(sim, 100, 10, row, 3));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 30e-4, es_sim_time(sim)); /* the row of 3 ms is the next */
    TEST_ASSERT_EQUAL_INT64(1, es_sim_run(sim, 1, 10, row, 3));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 30e-4, row[0]);
}

void test_capi_run_with_a_senseless_request_does_nothing(void)
{
    double row[1];
    start();
    TEST_ASSERT_EQUAL_INT64(0, es_sim_run(sim, 10, 0, row, 1));
    TEST_ASSERT_EQUAL_INT64(0, es_sim_run(sim, 10, -1, row, 1));
    TEST_ASSERT_EQUAL_INT64(0, es_sim_run(sim, -10, 1, row, 1));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, es_sim_time(sim));
}

/* ---- inputs --------------------------------------------------------------------------------------------------------- */

void test_capi_input_that_holds_steps_in_the_period_of_its_time(void)
{
    const double t[3] = {0.0, 0.01, 0.02};
    const double v[3] = {1.0, 2.0, -3.0};
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "speed_ref_rad_s", t, v, 3, false));
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "speed_divider", 1.0));
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "speed_inline", 1.0));
    start();
    for (int k = 0; k < 300; k++) {
        run(1);
        TEST_ASSERT_EQUAL_DOUBLE((k < 100) ? 1.0 : ((k < 200) ? 2.0 : -3.0), shown("speed_ref_rad_s"));
    }
}

void test_capi_input_that_ramps_is_linear_between_its_points_and_constant_outside(void)
{
    const double t[2] = {0.005, 0.015};
    const double v[2] = {10.0, 30.0};
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "speed_ref_rad_s", t, v, 2, true));
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "speed_divider", 1.0));
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "speed_inline", 1.0));
    start();
    for (int k = 0; k < 250; k++) {
        run(1);
        const double now = fmin(30.0, fmax(10.0, 10.0 + 2000.0 * (1e-4 * k - 0.005)));
        TEST_ASSERT_DOUBLE_WITHIN(2e-6, now, shown("speed_ref_rad_s")); /* a float */
    }
}

void test_capi_input_switches_at_one_half(void)
{
    const double t[2] = {0.0, 0.01};
    const double v[2] = {0.49, 0.51};
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "encoder_error", t, v, 2, false));
    start();
    run(100);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, shown("fault"));
    run(1);
    TEST_ASSERT_TRUE(shown("fault") > 0.0);
}

void test_capi_current_references_arrive_when_only_one_of_them_changes(void)
{
    const double t[2] = {0.0, 0.01};
    const double zero[1] = {0.0};
    const double d[2] = {1.0, 2.0};
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "control_mode", t, zero, 1, false));
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "id_ref_a", t, d, 2, false));
    start();
    run(100);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, shown("id_ref_a"));
    run(1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 2.0, shown("id_ref_a"));
}

void test_capi_main_loop_passes_once_a_millisecond(void)
{
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "offset_calibration_periods", 15.0));
    start();
    run(20); /* 15 periods are over, and the next pass is that of period 20 */
    TEST_ASSERT_EQUAL_DOUBLE(1.0, shown("state"));
    run(1);
    TEST_ASSERT_EQUAL_DOUBLE(3.0, shown("state"));
}

void test_capi_clock_for_the_benchmark_runs_forward_in_seconds(void)
{
    const double t0 = es_monotonic_s();
    double       t1 = t0;
    int          readings = 0;
    while ((t1 - t0 < 1e-3) && (readings < 10000000)) {
        const double next = es_monotonic_s();
        TEST_ASSERT_TRUE(next >= t1);
        t1 = next;
        readings++;
    }
    TEST_ASSERT_TRUE((readings > 10) && (readings < 1000000)); /* a reading takes more than 1 ns and less than 0.1 ms */
}

void test_capi_load_and_dc_link_inputs_reach_the_machine(void)
{
    const double t[2] = {0.0, 0.01};
    const double load[2] = {0.0, 0.123};
    const double brake[2] = {0.0, 0.456};
    const double vdc[2] = {24.0, 30.0};
    TEST_ASSERT_TRUE(es_sim_set_model(sim, "initial_speed_rad_s", 30.0));
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "load_torque_nm", t, load, 2, false));
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "load_brake_nm", t, brake, 2, false));
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "dc_link_v", t, vdc, 2, false));
    start();
    run(100);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, shown("load_torque_nm"));
    run(1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.579, shown("load_torque_nm"));
    run(2000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 30.0, shown("vdc_v"));
}

static void assert_load_and_reference(double load_nm, double ref_rad_s)
{
    TEST_ASSERT_EQUAL_DOUBLE(load_nm, shown("load_torque_nm"));
    TEST_ASSERT_EQUAL_DOUBLE(ref_rad_s, shown("speed_ref_rad_s"));
}

void test_capi_inputs_that_move_at_different_times_each_act_at_their_own_and_again_after_another_start(void)
{
    const double t_load[4] = {0.0, 0.01, 0.02, 0.04};
    const double load[4] = {0.0, 0.1, 0.2, 0.3};
    const double t_ref[2] = {0.0, 0.015};
    const double ref[2] = {5.0, 7.0};
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "speed_divider", 1.0));
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "speed_inline", 1.0));
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "load_torque_nm", t_load, load, 4, false));
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "speed_ref_rad_s", t_ref, ref, 2, false));
    for (int again = 0; again < 2; again++) {
        start();
        run(1);
        assert_load_and_reference(0.0, 5.0);
        run(120);
        assert_load_and_reference(0.1, 5.0);
        run(40);
        assert_load_and_reference(0.1, 7.0);
        run(60);
        assert_load_and_reference(0.2, 7.0); /* the reference has no point left, the load has */
        run(200);
        assert_load_and_reference(0.3, 7.0);
    }
}

void test_capi_dc_link_of_the_model_counts_when_no_input_is_given(void)
{
    TEST_ASSERT_TRUE(es_sim_set_model(sim, "dc_link_v", 20.0));
    start();
    run(10);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 20.0, shown("vdc_v"));
}

void test_capi_input_given_while_running_acts_at_once(void)
{
    const double t = 0.0;
    const double v = 12.0;
    start();
    run(100);
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "speed_ref_rad_s", &t, &v, 1, false));
    run(20);
    TEST_ASSERT_EQUAL_DOUBLE(12.0, shown("speed_ref_rad_s"));
}

void test_capi_start_again_begins_again(void)
{
    const double t[2] = {0.0, 0.05};
    const double v[2] = {10.0, 20.0};
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "speed_ref_rad_s", t, v, 2, false));
    start();
    run(1000);
    const double first = shown("true_theta_m_rad");
    start();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, es_sim_time(sim));
    run(1000);
    TEST_ASSERT_EQUAL_DOUBLE(first, shown("true_theta_m_rad"));
}

/* ---- determinism ---------------------------------------------------------------------------------------------------- */

#define ROWS 2000

static void trace(uint64_t seed, double (*row)[5])
{
    static const char *const SIGNAL[5] = {"true_speed_rad_s", "iq_a", "vd_v", "ia_a", "rejected_count"};
    const double             t = 0.0;
    const double             v = 15.0;
    es_sim_t *const          s = es_sim_new();
    TEST_ASSERT_TRUE(es_sim_set_param(s, "auto_run", 1.0) && es_sim_set_param(s, "offset_calibration_periods", 0.0) &&
                     es_sim_set_param(s, "align_periods", 0.0) && es_sim_set_param(s, "method", 3.0));
    TEST_ASSERT_TRUE(es_sim_set_model(s, "current_noise_a", 0.03));
    TEST_ASSERT_TRUE(es_sim_set_effect(s, "current_offset", "offset_a_a", 0.2));
    TEST_ASSERT_TRUE(es_sim_set_input(s, "speed_ref_rad_s", &t, &v, 1, false));
    TEST_ASSERT_TRUE(es_sim_set_seed(s, seed));
    TEST_ASSERT_TRUE(es_sim_record(s, SIGNAL, 5));
    TEST_ASSERT_TRUE(es_sim_start(s));
    TEST_ASSERT_EQUAL_INT64(ROWS, es_sim_run(s, ROWS, 1, &row[0][0], ROWS));
    es_sim_free(s);
}

void test_capi_same_seed_gives_the_same_bytes_and_another_seed_others(void)
{
    static double first[ROWS][5];
    static double second[ROWS][5];
    trace(42U, first);
    trace(42U, second);
    TEST_ASSERT_EQUAL_MEMORY(first, second, sizeof first);

    trace(43U, second);
    TEST_ASSERT_TRUE(memcmp(first, second, sizeof first) != 0);
}

static void noisy_rows(es_sim_t *s, double (*row)[2])
{
    static const char *const SIGNAL[2] = {"ia_a", "iq_a"};
    TEST_ASSERT_TRUE(es_sim_set_param(s, "auto_run", 1.0));
    TEST_ASSERT_TRUE(es_sim_set_param(s, "offset_calibration_periods", 0.0));
    TEST_ASSERT_TRUE(es_sim_set_param(s, "align_periods", 0.0));
    TEST_ASSERT_TRUE(es_sim_set_model(s, "current_noise_a", 0.02));
    TEST_ASSERT_TRUE(es_sim_record(s, SIGNAL, 2));
    TEST_ASSERT_TRUE(es_sim_start(s));
    TEST_ASSERT_EQUAL_INT64(ROWS, es_sim_run(s, ROWS, 1, &row[0][0], ROWS));
}

void test_capi_noise_that_was_drawn_ahead_gives_the_same_bytes_also_where_it_ends_within_the_run(void)
{
    static double own[ROWS][2];
    static double shared[ROWS][2];
    static double pairs[ROWS + 1][2];
    const int64_t count[4] = {1, 37, ROWS - 1, ROWS + 1};
    TEST_ASSERT_TRUE(es_sim_set_seed(sim, 77));
    noisy_rows(sim, own);
    TEST_ASSERT_TRUE(own[5][0] != own[6][0]); /* there is noise */
    es_noise(77, &pairs[0][0], ROWS + 1);
    for (size_t k = 0; k < COUNT_OF(count); k++) {
        es_sim_t *const other = es_sim_new();
        TEST_ASSERT_TRUE(es_sim_set_noise(other, 77, &pairs[0][0], count[k]));
        noisy_rows(other, shared);
        TEST_ASSERT_EQUAL_MEMORY(own, shared, sizeof own);
        noisy_rows(other, shared); /* from the start again */
        TEST_ASSERT_EQUAL_MEMORY(own, shared, sizeof own);
        es_sim_free(other);
    }
}

void test_capi_noise_of_another_seed_and_none_at_all_are_refused(void)
{
    double pairs[4][2];
    es_noise(77, &pairs[0][0], 4);
    TEST_ASSERT_FALSE(es_sim_set_noise(sim, 78, &pairs[0][0], 4));
    assert_refused(ES_BREAKS_RULE, "noise", "seed");
    TEST_ASSERT_FALSE(es_sim_set_noise(sim, 77, &pairs[0][0], 0));
    assert_refused(ES_NOT_WHOLE, "noise", "count");
    TEST_ASSERT_FALSE(es_sim_set_noise(sim, 77, NULL, 4));
    TEST_ASSERT_FALSE(es_sim_set_noise(NULL, 77, &pairs[0][0], 4));
    es_noise(77, NULL, 4);
}

void test_capi_two_simulations_side_by_side_do_not_disturb_each_other(void)
{
    const double    t = 0.0;
    const double    v[2] = {15.0, -15.0};
    es_sim_t *const other = es_sim_new();
    TEST_ASSERT_TRUE(es_sim_set_param(other, "auto_run", 1.0) && es_sim_set_param(other, "offset_calibration_periods", 0.0) &&
                     es_sim_set_param(other, "align_periods", 0.0));
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "speed_ref_rad_s", &t, &v[0], 1, false));
    TEST_ASSERT_TRUE(es_sim_set_input(other, "speed_ref_rad_s", &t, &v[1], 1, false));
    start();
    TEST_ASSERT_TRUE(es_sim_start(other));
    for (int k = 0; k < 300; k++) {
        run(10);
        TEST_ASSERT_EQUAL_INT64(0, es_sim_run(other, 10, 1, NULL, 0));
    }
    const double here = shown("true_speed_rad_s");
    const double there = es_sim_read(other, "true_speed_rad_s");
    es_sim_free(other);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 15.0, here);
    TEST_ASSERT_DOUBLE_WITHIN(1.0, -15.0, there);
}

/* ---- tuning --------------------------------------------------------------------------------------------------------- */

void test_capi_tune_acts_while_running(void)
{
    const double t = 0.0;
    const double v = 300.0;
    TEST_ASSERT_TRUE(es_sim_set_input(sim, "speed_ref_rad_s", &t, &v, 1, false));
    start();
    run(20);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 10.0, shown("iq_ref_a"));
    TEST_ASSERT_TRUE_MESSAGE(es_sim_tune(sim, "iq_limit_a", 4.0), es_sim_error(sim)->name);
    run(20);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 4.0, shown("iq_ref_a"));
}

void test_capi_tune_refuses_and_says_why(void)
{
    start();
    run(20);
    TEST_ASSERT_FALSE(es_sim_tune(sim, "kp", 1.0));
    assert_refused(ES_UNKNOWN, "param", "kp");
    TEST_ASSERT_FALSE(es_sim_tune(sim, "rc_lead", 2.5));
    assert_refused(ES_NOT_WHOLE, "param", "rc_lead");
    TEST_ASSERT_FALSE(es_sim_tune(sim, "iq_limit_a", NAN));
    TEST_ASSERT_FALSE(es_sim_tune(sim, "iq_limit_a", 500.0)); /* beyond over_current_a */
    assert_refused(ES_BOARD, "param", "iq_limit_a");
    TEST_ASSERT_EQUAL_DOUBLE(20.0, es_sim_error(sim)->max); /* over_current_a of the board */
    TEST_ASSERT_FALSE(es_sim_tune(sim, "pole_pairs", 3.0));
    assert_refused(ES_RUNNING, "param", "pole_pairs");
    TEST_ASSERT_TRUE(es_sim_tune(sim, "iq_limit_a", 5.0));
    TEST_ASSERT_FALSE(es_sim_tune(sim, "id_limit_a", 5.0));
    assert_refused(ES_WAITING, "param", "id_limit_a");
    run(20); /* the speed interrupt may be under way in the next period */
    TEST_ASSERT_TRUE(es_sim_tune(sim, "id_limit_a", 5.0));
}

/* ---- what the angle observer has learned ---------------------------------------------------------------------------- */

static double table[200];
static double back[200];

static const double *wave(double size)
{
    for (int i = 0; i < 200; i++) {
        table[i] = size * cos(0.0314159265 * i);
    }
    return table;
}

static void aro(void)
{
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "method", 6.0));
    TEST_ASSERT_TRUE(es_sim_set_param(sim, "auto_run", 0.0));
}

void test_capi_memory_given_before_the_start_is_there_after_it(void)
{
    aro();
    TEST_ASSERT_TRUE(es_sim_memory_write(sim, wave(1.5), 200));
    start();
    TEST_ASSERT_EQUAL_INT(200, es_sim_memory_read(sim, back, 200));
    for (int i = 0; i < 200; i++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, table[i], back[i]); /* a float, or a step of 6e-8 of 10 A */
    }
}

void test_capi_memory_can_be_replaced_and_cleared_while_the_drive_waits(void)
{
    aro();
    start();
    TEST_ASSERT_TRUE(es_sim_memory_write(sim, wave(1.5), 200));
    TEST_ASSERT_EQUAL_INT(200, es_sim_memory_read(sim, back, 200));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.5, back[0]);
    TEST_ASSERT_TRUE(es_sim_memory_clear(sim));
    TEST_ASSERT_EQUAL_INT(200, es_sim_memory_read(sim, back, 200));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, back[0]);
}

void test_capi_memory_read_writes_no_more_than_there_is_room_for(void)
{
    aro();
    TEST_ASSERT_TRUE(es_sim_memory_write(sim, wave(1.5), 200));
    start();
    back[10] = 77.0;
    TEST_ASSERT_EQUAL_INT(200, es_sim_memory_read(sim, back, 10)); /* how many there are */
    TEST_ASSERT_EQUAL_DOUBLE(77.0, back[10]);
    TEST_ASSERT_EQUAL_INT(200, es_sim_memory_read(sim, NULL, 200));
    TEST_ASSERT_EQUAL_INT(200, es_sim_memory_read(sim, back, -5));
}

void test_capi_memory_refuses_senseless_sizes_and_a_running_drive(void)
{
    aro();
    TEST_ASSERT_FALSE(es_sim_memory_write(sim, wave(1.0), 0));
    TEST_ASSERT_FALSE(es_sim_memory_write(sim, wave(1.0), -1));
    TEST_ASSERT_FALSE(es_sim_memory_write(sim, wave(1.0), 100000000));
    assert_refused(ES_NOT_WHOLE, "param", "cells");
    TEST_ASSERT_EQUAL_DOUBLE(1.0, es_sim_error(sim)->min);
    TEST_ASSERT_FALSE(es_sim_memory_write(sim, NULL, 200));
    TEST_ASSERT_FALSE(es_sim_memory_write(NULL, table, 200));
    TEST_ASSERT_FALSE(es_sim_memory_clear(NULL));
    TEST_ASSERT_EQUAL_INT(0, es_sim_memory_read(NULL, back, 200));
    TEST_ASSERT_EQUAL_INT(0, es_sim_memory_read(sim, back, 200)); /* not started */

    TEST_ASSERT_TRUE(es_sim_set_param(sim, "auto_run", 1.0));
    start();
    run(100);
    TEST_ASSERT_FALSE(es_sim_memory_write(sim, wave(1.0), 200));
    TEST_ASSERT_FALSE(es_sim_memory_clear(sim));
}

/* ---- rows of a CSV file --------------------------------------------------------------------------------------------- */

void test_capi_writes_rows_as_printf_does_and_nothing_without_room(void)
{
    const double values[] = {0.0, -0.0, 1.0, -12.5, 1e-5, 123456789.5, 999999999.9, 1e300, 0.1, -2.00000001};
    char         out[10 * ES_CSV_CELL];
    char         expected[256];
    int          length = 0;
    for (int k = 0; k < 10; k++) {
        const double shown_value = values[k] + 0.0;
        length +=
            snprintf(expected + length, sizeof expected - (size_t)length, "%.9g%c", shown_value, ((k % 5) < 4) ? ',' : '\n');
    }

    const int64_t written = es_csv_rows(values, 2, 5, out, sizeof out);

    TEST_ASSERT_EQUAL_INT64(length, written);
    TEST_ASSERT_EQUAL_STRING_LEN(expected, out, (size_t)length);
    TEST_ASSERT_EQUAL_INT64(0, es_csv_rows(values, 2, 5, out, (int64_t)sizeof out - 1));
    TEST_ASSERT_EQUAL_INT64(0, es_csv_rows(values, 2, 0, out, sizeof out));
    TEST_ASSERT_EQUAL_INT64(0, es_csv_rows(values, -1, 5, out, sizeof out));
    TEST_ASSERT_EQUAL_INT64(0, es_csv_rows(NULL, 2, 5, out, sizeof out));
    TEST_ASSERT_EQUAL_INT64(0, es_csv_rows(values, 2, 5, NULL, sizeof out));
}
