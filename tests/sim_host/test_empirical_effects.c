/* sim_host/effects/empirical*.c: terms that a log shows and no effect explains, by hand. */
#include "tests/sim_host/support/machine.h"

static double p[SIM_EFFECT_PARAMS];
static double v[SIM_EFFECT_PARAMS];

static void off(const sim_effect_t *x, double *values)
{
    for (int k = 0; k < x->param_count; k++) {
        values[k] = x->param[k].off;
    }
}

static void put(const char *effect, double *values, const char *param, double value)
{
    const sim_effect_t *const x = sim_effects[machine_effect(effect)];
    for (int k = 0; k < x->param_count; k++) {
        if (strcmp(x->param[k].name, param) == 0) {
            values[k] = value;
            return;
        }
    }
    TEST_FAIL_MESSAGE(param);
}

static void set(const char *param, double value) { put("empirical", p, param, value); }
static void set_v(const char *param, double value) { put("empirical_voltage", v, param, value); }

static double torque(double theta_rad, double speed_rad_s, double time_s)
{
    const sim_shaft_t shaft = {theta_rad, speed_rad_s, time_s};
    return sim_effects[machine_effect("empirical")]->torque_nm(p, &shaft);
}

void setUp(void)
{
    machine_defaults();
    off(sim_effects[machine_effect("empirical")], p);
    off(sim_effects[machine_effect("empirical_voltage")], v);
}
void tearDown(void) {}

void test_empirical_drag_is_a_power_of_the_speed_and_stays_beyond_what_was_measured(void)
{
    set("odd_nm", 0.4);
    set("limit_rad_s", 80.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.1, torque(1.0, 40.0, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.1, torque(1.0, -40.0, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.4, torque(1.0, 300.0, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.4, torque(1.0, -300.0, 0.0));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, fabs(torque(1.0, 0.0, 0.0)));
    set("odd_nm", -0.4);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.1, torque(1.0, 40.0, 0.0));
    set("odd_nm", 0.0);
    set("even_nm", 0.4);
    set("even_exponent", 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2, torque(1.0, -40.0, 0.0));
}

void test_empirical_line_has_any_order_and_turns_over_with_the_direction(void)
{
    set("limit_rad_s", 50.0);
    set("line_1_nm", 0.2);
    set("line_1_order", 3.47);
    set("line_1_phase_rad", 0.4);
    set("line_2_nm", 0.1);
    set("line_2_order", 7.0);
    set("line_2_growth", 2.0);
    set("line_2_turns_over", 1.0);
    for (int k = 0; k < 12; k++) {
        const double theta = 0.7 * k;
        const double fixed = 0.2 * sin(3.47 * theta + 0.4);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, -fixed - 0.1 * 0.16 * sin(7.0 * theta), torque(theta, 20.0, 0.0));
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, -fixed + 0.1 * 0.16 * sin(7.0 * theta), torque(theta, -20.0, 0.0));
    }
}

void test_empirical_position_is_a_bump_and_a_spring_that_ends_with_the_travel(void)
{
    set("position_nm", 0.3);
    set("position_rad", 20.0);
    set("width_rad", 4.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.3, torque(20.0, 5.0, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.3 * exp(-1.0), torque(16.0, -5.0, 0.0));
    set("position_nm", 0.0);
    set("spring_nm", 0.6);
    set("spring_rad", 10.0);
    set("travel_rad", 40.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.15, torque(20.0, 5.0, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.3, torque(500.0, 5.0, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.3, torque(-500.0, 5.0, 0.0));
}

void test_empirical_terms_of_time_grow_with_their_time_constant_and_stay_at_the_end_of_the_log(void)
{
    set("limit_rad_s", 50.0);
    set("time_s", 10.0);
    set("until_s", 20.0);
    set("load_nm", 0.2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2 * (1.0 - exp(-1.0)), torque(0.0, 30.0, 10.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, torque(0.0, 30.0, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2 * (1.0 - exp(-2.0)), torque(0.0, 30.0, 500.0));
    set("load_nm", 0.0);
    set("friction_nm", 0.2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.2 * (1.0 - exp(-1.0)), torque(0.0, -30.0, 10.0));
    set("friction_nm", 0.0);
    set("viscous_nm", 0.2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2 * 0.6 * (1.0 - exp(-1.0)), torque(0.0, 30.0, 10.0));
    set("viscous_nm", 0.0);
    set("tone_nm", 0.2);
    set("tone_hz", 5.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2, torque(0.0, 30.0, 0.05)); /* a quarter of a period */
}

void test_empirical_time_goes_on_where_a_run_starts_within_the_log(void)
{
    set("time_s", 10.0);
    set("start_s", 8.0);
    set("load_nm", 0.2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2 * (1.0 - exp(-1.0)), torque(0.0, 30.0, 2.0));
    set("until_s", 10.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2 * (1.0 - exp(-1.0)), torque(0.0, 30.0, 50.0));
    set("load_nm", 0.0);
    set("tone_nm", 0.2);
    set("tone_hz", 0.125);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2, torque(0.0, 30.0, 2.0)); /* a quarter of a period past the first one */

    sim_flux_t h = {0.0, 0.0};
    set_v("flux_rel", 0.2);
    set_v("time_s", 5.0);
    set_v("start_s", 3.0);
    sim_effects[machine_effect("empirical_voltage")]->flux(v, &model, 0.3, 2.0, &h);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2 * (1.0 - exp(-1.0)) * model.psi_wb, h.q_wb);
}

void test_empirical_voltage_takes_the_drop_of_a_warm_winding_and_the_sag_and_ripple_of_a_supply(void)
{
    const sim_effect_t *const x = sim_effects[machine_effect("empirical_voltage")];
    const sim_bridge_t        bridge = {.time_s = 2.0, .begin_a = {3.0, -1.0, -2.0}, .end_a = {3.0, -1.0, -2.0}};
    const double              full[3] = {10.0, -4.0, -6.0};
    double                    u[3] = {10.0, -4.0, -6.0};
    set_v("time_s", 2.0);
    set_v("resistance_ohm", 0.5);
    x->phase_voltage(v, &bridge, u);
    const double r = 0.5 * (1.0 - exp(-1.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 10.0 - 3.0 * r, u[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -6.0 + 2.0 * r, u[2]);

    set_v("resistance_ohm", 0.0);
    set_v("sag_rel", 0.1);
    set_v("rated_w", 92.0); /* the load is 30 + 4 + 12 = 46 W */
    memcpy(u, full, sizeof u);
    x->phase_voltage(v, &bridge, u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 9.5, u[0]);
    set_v("rated_w", 1.0); /* no farther than twice the rated power */
    memcpy(u, full, sizeof u);
    x->phase_voltage(v, &bridge, u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 8.0, u[0]);

    set_v("sag_rel", 0.0);
    set_v("ripple_rel", 0.05);
    set_v("ripple_hz", 100.125); /* a quarter of a period past 200 whole ones */
    memcpy(u, full, sizeof u);
    x->phase_voltage(v, &bridge, u);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 9.5, u[0]);
}

void test_empirical_voltage_takes_flux_that_is_lost_with_time(void)
{
    const sim_effect_t *const x = sim_effects[machine_effect("empirical_voltage")];
    sim_flux_t                h = {0.0, 0.0};
    set_v("flux_rel", 0.2);
    set_v("time_s", 5.0);
    x->flux(v, &model, 0.3, 5.0, &h);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2 * (1.0 - exp(-1.0)) * model.psi_wb, h.q_wb);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, h.d_wb);
}
