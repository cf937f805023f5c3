/* firmware/app/parameters.c: one table, one struct, and nothing that does not fit gets in. */
#include <string.h>

#include "firmware/app/parameters.h"
#include "tests/support/numeric.h"

static drive_params_t params;

void setUp(void) { params_default(&params); }
void tearDown(void) {}

static const param_info_t *row(uint16_t i)
{
    const param_info_t *const info = params_info(i);
    TEST_ASSERT_NOT_NULL(info);
    return info;
}

static uint16_t parts_of(const char *choices)
{
    uint16_t n = 1U;
    for (const char *c = choices; *c != '\0'; c++) {
        n = (uint16_t)(n + ((*c == '|') ? 1U : 0U));
    }
    return n;
}

static void assert_refused(uint16_t index, float value, const char *why)
{
    drive_params_t before = params;

    TEST_ASSERT_FALSE_MESSAGE(params_set(&params, index, value), why);
    TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&before, &params, sizeof params, why);
}

void test_parameters_table_has_one_row_per_parameter_and_no_more(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        (void)row(i);
    }
    TEST_ASSERT_NULL(params_info(PARAM_COUNT));
    TEST_ASSERT_NULL(params_info(UINT16_MAX));
}

void test_parameters_every_default_lies_within_its_range(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        const param_info_t *const p = row(i);
        TEST_ASSERT_TRUE_MESSAGE(p->min <= p->def, p->name);
        TEST_ASSERT_TRUE_MESSAGE(p->def <= p->max, p->name);
        TEST_ASSERT_TRUE_MESSAGE(p->min < p->max, p->name);
        TEST_ASSERT_TRUE_MESSAGE(isfinite((double)p->min) && isfinite((double)p->max), p->name);
    }
}

void test_parameters_every_row_is_named_and_explained_once(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        const param_info_t *const p = row(i);
        TEST_ASSERT_TRUE_MESSAGE(strlen(p->name) > 0U, at("row %u", (unsigned)i));
        TEST_ASSERT_TRUE_MESSAGE(strlen(p->doc) > 10U, p->name);
        TEST_ASSERT_NOT_NULL_MESSAGE(params_unit(p), p->name);
        for (uint16_t k = 0U; k < i; k++) {
            TEST_ASSERT_TRUE_MESSAGE(strcmp(p->name, row(k)->name) != 0, p->name);
        }
    }
}

void test_parameters_choices_name_every_value_and_flags_have_two(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        const param_info_t *const p = row(i);
        if (p->kind == PARAM_KIND_CHOICE) {
            TEST_ASSERT_EQUAL_FLOAT_MESSAGE(0.0f, p->min, p->name);
            TEST_ASSERT_EQUAL_FLOAT_MESSAGE((float)(parts_of(params_choices(p)) - 1U), p->max, p->name);
        } else {
            TEST_ASSERT_EQUAL_STRING_MESSAGE("", params_choices(p), p->name);
        }
        if (p->kind == PARAM_KIND_FLAG) {
            TEST_ASSERT_EQUAL_FLOAT_MESSAGE(0.0f, p->min, p->name);
            TEST_ASSERT_EQUAL_FLOAT_MESSAGE(1.0f, p->max, p->name);
        }
    }
}

void test_parameters_position_of_a_name_is_its_row(void)
{
    TEST_ASSERT_EQUAL_STRING("pole_pairs", row(PARAM_pole_pairs)->name);
    TEST_ASSERT_EQUAL_STRING("speed_source", row(PARAM_speed_source)->name);
    TEST_ASSERT_EQUAL_STRING("rc_fal_delta", row(PARAM_rc_fal_delta)->name);
    TEST_ASSERT_EQUAL_STRING("non_finite_limit", row(PARAM_non_finite_limit)->name);
}

void test_parameters_default_gives_the_default_of_every_row(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        TEST_ASSERT_EQUAL_FLOAT_MESSAGE(row(i)->def, params_get(&params, i), row(i)->name);
    }
    TEST_ASSERT_EQUAL_UINT16(PARAM_COUNT, params_check(&params));
}

/* printed values of Guo et al. 2024 and what docs derive from them */
void test_parameters_defaults_are_those_of_the_published_drive(void)
{
    TEST_ASSERT_EQUAL_UINT16(4U, params.pole_pairs);
    TEST_ASSERT_EQUAL_FLOAT(4000.0f, params_get(&params, PARAM_encoder_counts));
    TEST_ASSERT_EQUAL_FLOAT(0.6f, params.current_kp_v_per_a);
    TEST_ASSERT_EQUAL_FLOAT(1080.0f, params.current_ki_v_per_as);
    TEST_ASSERT_EQUAL_FLOAT(0.0368f, params.speed_kp_a_per_unit);
    TEST_ASSERT_EQUAL_FLOAT(0.92f, params.speed_ki_a_per_unit_s);
    TEST_ASSERT_EQUAL_FLOAT(4.0f, params.speed_error_gain);
    TEST_ASSERT_EQUAL_FLOAT(0.6f, params.rc_gain);
    TEST_ASSERT_EQUAL_UINT16(5U, params.rc_lead);
    TEST_ASSERT_EQUAL_UINT16(2U, params.rc_order);
    TEST_ASSERT_EQUAL_FLOAT(0.45f, params.rc_q_side);
    TEST_ASSERT_EQUAL_FLOAT(0.10f, params.rc_q_centre);
    TEST_ASSERT_EQUAL_FLOAT(0.6f, params.rc_fal_alpha);
    TEST_ASSERT_EQUAL_FLOAT(0.4f, params.rc_fal_delta);
    TEST_ASSERT_EQUAL_FLOAT(10.0f, params.iq_limit_a);
}

void test_parameters_set_takes_both_ends_of_every_range_and_get_gives_them_back(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        const float end[2] = {row(i)->min, row(i)->max};
        for (int k = 0; k < 2; k++) {
            TEST_ASSERT_TRUE_MESSAGE(params_set(&params, i, end[k]), row(i)->name);
            TEST_ASSERT_EQUAL_FLOAT_MESSAGE(end[k], params_get(&params, i), row(i)->name);
        }
    }
}

void test_parameters_set_changes_no_other_parameter(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        params_default(&params);
        TEST_ASSERT_TRUE(params_set(&params, i, row(i)->max));
        for (uint16_t k = 0U; k < (uint16_t)PARAM_COUNT; k++) {
            if (k != i) {
                TEST_ASSERT_EQUAL_FLOAT_MESSAGE(row(k)->def, params_get(&params, k), at("%s by %s", row(k)->name, row(i)->name));
            }
        }
    }
}

void test_parameters_set_refuses_the_next_float_beyond_every_end(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        assert_refused(i, nextafterf(row(i)->max, INFINITY), row(i)->name);
        assert_refused(i, nextafterf(row(i)->min, -INFINITY), row(i)->name);
    }
}

void test_parameters_set_refuses_what_is_not_finite(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        assert_refused(i, NAN, row(i)->name);
        assert_refused(i, INFINITY, row(i)->name);
        assert_refused(i, -INFINITY, row(i)->name);
    }
}

void test_parameters_set_refuses_a_fraction_for_a_whole_number(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        if (row(i)->kind != PARAM_KIND_FLOAT) {
            assert_refused(i, row(i)->min + 0.5f, row(i)->name);
        }
    }
}

void test_parameters_set_takes_a_fraction_for_a_real_number(void)
{
    TEST_ASSERT_TRUE(params_set(&params, PARAM_rc_gain, 0.5256f));
    TEST_ASSERT_EQUAL_FLOAT(0.5256f, params.rc_gain);
}

void test_parameters_beyond_the_table_there_is_nothing_to_get_or_set(void)
{
    TEST_ASSERT_EQUAL_FLOAT(0.0f, params_get(&params, PARAM_COUNT));
    assert_refused(PARAM_COUNT, 0.0f, "the first beyond");
    assert_refused(UINT16_MAX, 0.0f, "the last there is");
}

void test_parameters_check_finds_each_end_that_is_passed(void)
{
    params.pole_pairs = 0U;
    TEST_ASSERT_EQUAL_UINT16(PARAM_pole_pairs, params_check(&params));
    params_default(&params);
    params.pole_pairs = 51U;
    TEST_ASSERT_EQUAL_UINT16(PARAM_pole_pairs, params_check(&params));
    params_default(&params);
    params.method = UINT16_MAX;
    TEST_ASSERT_EQUAL_UINT16(PARAM_method, params_check(&params));
    params_default(&params);
    params.over_voltage_v = NAN;
    TEST_ASSERT_EQUAL_UINT16(PARAM_over_voltage_v, params_check(&params));
}

void test_parameters_check_names_the_first_of_several(void)
{
    params.rc_gain = -1.0f;
    params.over_speed_rad_s = INFINITY;
    params.align_current_a = NAN;

    TEST_ASSERT_EQUAL_UINT16(PARAM_rc_gain, params_check(&params));
}

/* Named here once more, by what each is: the electrical angle, protection, and the kind or size of a memory or a filter. */
void test_parameters_that_only_change_at_rest_are_angle_protection_and_shape(void)
{
    static const uint16_t REST[] = {PARAM_pole_pairs,
                                    PARAM_encoder_counts,
                                    PARAM_encoder_offset_rad,
                                    PARAM_encoder_reversed,
                                    PARAM_over_current_a,
                                    PARAM_over_voltage_v,
                                    PARAM_under_voltage_v,
                                    PARAM_over_speed_rad_s,
                                    PARAM_voltage_limit_v,
                                    PARAM_offset_limit_a,
                                    PARAM_encoder_jump_rad,
                                    PARAM_encoder_jump_periods,
                                    PARAM_lost_sample_limit,
                                    PARAM_non_finite_limit,
                                    PARAM_encoder_index_rad,
                                    PARAM_motor_trip_c,
                                    PARAM_motor_derate_c,
                                    PARAM_bridge_trip_c,
                                    PARAM_bridge_derate_c,
                                    PARAM_regeneration_limit_v,
                                    PARAM_regeneration_band_v,
                                    PARAM_chopper_v,
                                    PARAM_chopper_band_v,
                                    PARAM_chopper_ohm,
                                    PARAM_chopper_continuous_w,
                                    PARAM_chopper_thermal_s,
                                    PARAM_sto_discrepancy_s,
                                    PARAM_restart_limit,
                                    PARAM_restart_window_s,
                                    PARAM_stall_s,
                                    PARAM_stall_torque_a,
                                    PARAM_stall_torque_s,
                                    PARAM_speed_deviation_s,
                                    PARAM_zero_check,
                                    PARAM_plausibility_share,
                                    PARAM_motor_resistance_tolerance,
                                    PARAM_motor_inductance_tolerance,
                                    PARAM_motor_flux_tolerance,
                                    PARAM_bridge_tolerance,
                                    PARAM_mtpa,
                                    PARAM_field_weakening,
                                    PARAM_link_withstand_v,
                                    PARAM_position_min_turn,
                                    PARAM_position_max_turn,
                                    PARAM_following_error_rad,
                                    PARAM_following_error_samples,
                                    PARAM_method,
                                    PARAM_position_method,
                                    PARAM_disturbance_observer,
                                    PARAM_speed_source,
                                    PARAM_speed_divider,
                                    PARAM_speed_inline,
                                    PARAM_rc_lead,
                                    PARAM_rc_order,
                                    PARAM_rc_q_side2,
                                    PARAM_rc_memory,
                                    PARAM_rc_cells,
                                    PARAM_aro_cells,
                                    PARAM_position_cells,
                                    PARAM_observer_fir1_order,
                                    PARAM_observer_fir1_hz,
                                    PARAM_observer_fir2_order,
                                    PARAM_observer_fir2_hz,
                                    PARAM_current_correction,
                                    PARAM_current_sensors,
                                    PARAM_current_offset_a_a,
                                    PARAM_current_offset_b_a,
                                    PARAM_current_offset_c_a,
                                    PARAM_current_gain_a,
                                    PARAM_current_gain_b,
                                    PARAM_current_gain_c,
                                    PARAM_current_offset_max_a,
                                    PARAM_current_gain_max,
                                    PARAM_dead_time_s,
                                    PARAM_dead_time_soft_a,
                                    PARAM_encoder_cos1_rad,
                                    PARAM_encoder_sin1_rad,
                                    PARAM_encoder_cos2_rad,
                                    PARAM_encoder_sin2_rad,
                                    PARAM_flux_cos6,
                                    PARAM_flux_sin6,
                                    PARAM_flux_cos12,
                                    PARAM_flux_sin12,
                                    PARAM_saturation_a,
                                    PARAM_saturation_cross,
                                    PARAM_motor_continuous_a,
                                    PARAM_motor_thermal_s,
                                    PARAM_bridge_continuous_a,
                                    PARAM_bridge_thermal_s};
    for (uint16_t k = 0U; k < (uint16_t)PARAM_COUNT; k++) {
        bool listed = false;
        for (size_t i = 0; i < COUNT_OF(REST); i++) {
            listed = listed || (REST[i] == k);
        }
        TEST_ASSERT_EQUAL_MESSAGE(listed, params_only_at_rest(k), row(k)->name);
    }
    TEST_ASSERT_FALSE(params_only_at_rest(PARAM_COUNT));
}
