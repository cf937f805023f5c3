/* sim_host/effects/: nothing when off, something when on, and by hand what each does. */
#include "tests/sim_host/support/machine.h"

void setUp(void)
{
    machine_defaults();
    model.viscous_nms = 2e-5;
}
void tearDown(void) {}

/* ---- the table ------------------------------------------------------------------------------------------------------ */

void test_effects_table_is_in_alphabetical_order_and_explains_every_effect(void)
{
    for (int e = 0; e < sim_effect_total; e++) {
        const sim_effect_t *const x = sim_effects[e];
        TEST_ASSERT_TRUE_MESSAGE((e == 0) || (strcmp(sim_effects[e - 1]->name, x->name) < 0), x->name);
        TEST_ASSERT_TRUE_MESSAGE(strlen(x->acts_on) > 3U, x->name);
        TEST_ASSERT_TRUE_MESSAGE(strlen(x->doc) > 10U, x->name);
        TEST_ASSERT_TRUE_MESSAGE(strlen(x->signature) > 10U, x->name);
        TEST_ASSERT_TRUE_MESSAGE((x->param_count >= 1) && (x->param_count <= SIM_EFFECT_PARAMS), x->name);
        for (int k = 0; k < x->param_count; k++) {
            const sim_effect_param_t *const p = &x->param[k];
            TEST_ASSERT_TRUE_MESSAGE(strlen(p->name) > 2U, x->name);
            TEST_ASSERT_TRUE_MESSAGE(strlen(p->doc) > 3U, p->name);
            TEST_ASSERT_TRUE_MESSAGE((p->min <= p->off) && (p->off <= p->max) && (p->min < p->max), p->name);
        }
    }
}

/* docs: the vocabulary of the measured-log format; more parameters may follow */
void test_effects_names_and_first_parameters_are_those_of_the_log_format(void)
{
    static const char *const WANTED[][6] = {
        {"current_offset", "offset_a_a", "offset_b_a"},
        {"current_gain", "gain_a", "gain_b"},
        {"dead_time", "dead_time_s"},
        {"cogging", "amplitude_nm", "phase_rad", "order"},
        {"flux_harmonics", "torque_ripple_rel", "sign"},
        {"coulomb_friction", "torque_nm"},
        {"stribeck_friction", "torque_nm", "speed_rad_s"},
        {"viscous_friction", "factor"},
        {"inertia", "factor"},
        {"load_torque", "torque_nm"},
        {"misalignment", "amplitude_nm", "phase_rad", "second_rel", "phase2_rad"},
        {"encoder_eccentricity", "amplitude_rad", "phase_rad"},
        {"encoder_offset", "angle_el_rad"},
        {"torque_constant", "factor"},
        {"winding_resistance", "factor"},
        {"current_loop_delay", "extra_periods"},
        {"inductance_saturation", "i_sat_a"},
        {"two_mass", "f_res_hz", "load_ratio", "damping_ratio"},
        {"backlash", "gap_rad", "load_ratio", "f_res_hz", "damping_ratio"},
        {"current_filter", "tau_s"},
    };
    for (size_t i = 0; i < COUNT_OF(WANTED); i++) {
        const sim_effect_t *const x = sim_effects[machine_effect(WANTED[i][0])];
        int                       n = 0;
        while ((n < 5) && (WANTED[i][n + 1] != NULL)) {
            TEST_ASSERT_TRUE_MESSAGE(n < x->param_count, WANTED[i][0]);
            TEST_ASSERT_EQUAL_STRING(WANTED[i][n + 1], x->param[n].name);
            n++;
        }
    }
}

void test_effects_have_examples_within_range_that_do_something(void)
{
    for (int e = 0; e < sim_effect_total; e++) {
        const sim_effect_t *const x = sim_effects[e];
        bool                      acts = false;
        for (int k = 0; k < x->param_count; k++) {
            const sim_effect_param_t *const p = &x->param[k];
            TEST_ASSERT_TRUE_MESSAGE((p->min <= p->example) && (p->example <= p->max), p->name);
            acts = acts || (p->example != p->off);
        }
        TEST_ASSERT_TRUE_MESSAGE(acts, x->name);
        TEST_ASSERT_TRUE_MESSAGE(x->scenario_only || (x->told_apart != NULL), x->name);
    }
}

/* two_mass came after backlash in the table and silently took its place */
void test_effects_of_the_shaft_are_refused_together_by_name(void)
{
    machine_set("backlash", "gap_rad", 0.01);
    machine_set("two_mass", "f_res_hz", 60.0);

    TEST_ASSERT_EQUAL_STRING("two_mass", machine_try_start());
}

void test_effects_of_the_shaft_go_with_a_delay_of_the_bridge(void)
{
    machine_set("backlash", "gap_rad", 0.01);
    machine_set("current_loop_delay", "extra_periods", 1.0);

    TEST_ASSERT_NULL(machine_try_start());
}

/* ---- on and off ----------------------------------------------------------------------------------------------------- */

#define ROWS 400
#define COLUMNS 6
static double off_trace[ROWS][COLUMNS];
static double on_trace[ROWS][COLUMNS];

/* A drive by hand that everything shows in: turning, loaded, read every period. */
static void experiment(double (*trace)[COLUMNS])
{
    model.initial_speed_rad_s = 30.0;
    machine_start();
    for (int k = 0; k < ROWS; k++) {
        sim_reading_t r;
        plant.outside.load_torque_nm = 0.01;
        sim_plant_read(&plant, &r);
        machine_dq_voltage(0.2, 1.5, 1);
        const double row[COLUMNS] = {r.ia_a, r.ib_a, r.theta_m_rad, plant.x.speed_rad_s, plant.x.id_a, plant.x.iq_a};
        memcpy(trace[k], row, sizeof row);
    }
}

static bool traces_differ(void)
{
    for (int k = 0; k < ROWS; k++) {
        for (int c = 0; c < COLUMNS; c++) {
            if (fabs(off_trace[k][c] - on_trace[k][c]) > 1e-6) {
                return true;
            }
        }
    }
    return false;
}

/* A number that is neither off nor an end of the range, and not too large for a small motor. */
static double some_value(const sim_effect_param_t *p)
{
    if (strncmp(p->name, "order", 5) == 0) {
        return 6.0;
    }
    if (strcmp(p->unit, "rad/s") == 0) {
        return 40.0; /* the experiment turns with 30 rad/s */
    }
    if (strcmp(p->unit, "Hz") == 0) {
        return 300.0;
    }
    if (strcmp(p->name, "i_sat_a") == 0) {
        return 10.0; /* the currents of the experiment */
    }
    const double wanted = (p->off == 0.0) ? 0.01 : p->off * 1.25;
    const double step = (wanted <= p->max) ? wanted : ((p->off != 0.0) ? p->off * 0.75 : 0.25 * p->max);
    return (step >= p->min) ? step : p->min;
}

void test_effects_every_effect_of_the_table_does_something_when_it_is_on(void)
{
    model.counts_per_rev = 0.0;
    experiment(off_trace);
    for (int e = 0; e < sim_effect_total; e++) {
        machine_defaults();
        model.counts_per_rev = 0.0;
        for (int k = 0; k < sim_effects[e]->param_count; k++) {
            effect_values[e][k] = some_value(&sim_effects[e]->param[k]);
        }
        experiment(on_trace);
        TEST_ASSERT_EQUAL_INT_MESSAGE(1, plant.acting_count, sim_effects[e]->name);
        TEST_ASSERT_TRUE_MESSAGE(traces_differ(), sim_effects[e]->name);
    }
}

void test_effects_none_acts_when_all_are_off(void)
{
    experiment(off_trace);
    TEST_ASSERT_EQUAL_INT(0, plant.acting_count);
    TEST_ASSERT_EQUAL_INT(SIM_PLAIN, plant.kind);
    for (int e = 0; e < sim_effect_total; e++) {
        machine_defaults();
        for (int k = 0; k < sim_effects[e]->param_count; k++) {
            effect_values[e][k] = sim_effects[e]->param[k].off;
        }
        experiment(on_trace);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(off_trace, on_trace, sizeof off_trace, sim_effects[e]->name);
    }
}

/* The code without hooks and the code with hooks are one machine: a torque of nothing makes the difference. */
void test_effects_machine_with_hooks_is_the_machine_without(void)
{
    experiment(off_trace);
    machine_set("cogging", "order", 24.0); /* on, but with no amplitude */
    experiment(on_trace);
    TEST_ASSERT_EQUAL_INT(SIM_WITH_HOOKS, plant.kind);
    for (int k = 0; k < ROWS; k++) {
        for (int c = 0; c < COLUMNS; c++) {
            /* sums in another order: 400 roundings of 1e-15 of 30 rad/s */
            TEST_ASSERT_DOUBLE_WITHIN(1e-10, off_trace[k][c], on_trace[k][c]);
        }
    }
}

void test_effects_all_of_them_can_act_at_once_but_a_second_shaft(void)
{
    const int second_shaft = machine_effect("two_mass");
    for (int e = 0; e < sim_effect_total; e++) {
        for (int k = 0; (k < sim_effects[e]->param_count) && (e != second_shaft); k++) {
            effect_values[e][k] = some_value(&sim_effects[e]->param[k]);
        }
    }
    experiment(on_trace);
    TEST_ASSERT_EQUAL_INT(sim_effect_total - 1, plant.acting_count);
    for (int k = 0; k < ROWS; k++) {
        for (int c = 0; c < COLUMNS; c++) {
            TEST_ASSERT_TRUE(isfinite(on_trace[k][c]));
        }
    }
}

/* ---- formulas ------------------------------------------------------------------------------------------------------- */

/* Torque at an angle, from the acceleration of a machine that nothing else moves. */
static double torque_at(double theta_m, double speed)
{
    model.psi_wb = 0.0;
    model.viscous_nms = 0.0;
    model.inertia_kgm2 = 100.0; /* stands where it is put: 1e-4 N m move it by 5e-15 rad */
    model.substeps = 1.0;
    model.initial_angle_rad = theta_m;
    model.initial_speed_rad_s = speed;
    machine_start();
    machine_voltage(0.0, 0.0, 1);
    return (plant.x.speed_rad_s - speed) * 100.0 / 1e-4;
}

void test_effects_cogging_brakes_with_the_sine_of_its_order(void)
{
    machine_set("cogging", "amplitude_nm", 0.5);
    machine_set("cogging", "order", 24.0);
    machine_set("cogging", "phase_rad", 0.4);
    for (int k = 0; k < 20; k++) {
        const double theta = 0.1 * k;
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, -0.5 * sin(24.0 * theta + 0.4), torque_at(theta, 0.0));
    }
}

void test_effects_misalignment_brakes_with_the_first_and_second_order(void)
{
    machine_set("misalignment", "amplitude_nm", 0.5);
    machine_set("misalignment", "phase_rad", 0.4);
    machine_set("misalignment", "second_rel", 0.3);
    machine_set("misalignment", "phase2_rad", -1.0);
    for (int k = 0; k < 20; k++) {
        const double theta = 0.33 * k;
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, -0.5 * (sin(theta + 0.4) + 0.3 * sin(2.0 * theta - 1.0)), torque_at(theta, 0.0));
    }
}

void test_effects_torque_ripple_brakes_with_the_sum_of_its_lines(void)
{
    machine_set("torque_ripple", "order_1", 1.0);
    machine_set("torque_ripple", "amplitude_1_nm", 0.2);
    machine_set("torque_ripple", "phase_1_rad", 0.3);
    machine_set("torque_ripple", "order_4", 6.0);
    machine_set("torque_ripple", "amplitude_4_nm", -0.1);
    machine_set("torque_ripple", "order_6", 60.0);
    machine_set("torque_ripple", "amplitude_6_nm", 0.05);
    machine_set("torque_ripple", "phase_6_rad", 2.0);
    for (int k = 0; k < 20; k++) {
        const double theta = 0.33 * k;
        const double sum = 0.2 * sin(theta + 0.3) - 0.1 * sin(6.0 * theta) + 0.05 * sin(60.0 * theta + 2.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-8, -sum, torque_at(theta, 0.0));
    }
}

void test_effects_torque_ripple_has_the_sines_of_angles_of_any_size(void)
{
    extern const sim_effect_t effect_torque_ripple;
    for (int line = 0; line < 6; line++) {
        double p[SIM_EFFECT_PARAMS] = {0.0};
        p[3 * line] = 36.0;
        p[3 * line + 1] = 1.0;
        p[3 * line + 2] = 0.3;
        for (double theta = -3e5; theta < 3e5; theta += 17.03) {
            const sim_shaft_t shaft = {.theta_m_rad = theta};
            TEST_ASSERT_DOUBLE_WITHIN(1e-15, -sin(36.0 * theta + 0.3), effect_torque_ripple.torque_nm(p, &shaft));
        }
        for (double theta = 1e-9; theta < 1e290; theta *= -3.7) { /* what the last bit of an angle is worth decides */
            const sim_shaft_t shaft = {.theta_m_rad = theta};
            const double      angle = 36.0 * theta + 0.3;
            TEST_ASSERT_DOUBLE_WITHIN(1e-15 + 1e-16 * fabs(angle), -sin(angle), effect_torque_ripple.torque_nm(p, &shaft));
            TEST_ASSERT_DOUBLE_WITHIN(1.0 + 1e-15, 0.0, effect_torque_ripple.torque_nm(p, &shaft));
        }
    }
}

void test_effects_load_torque_brakes_positive_rotation_and_keeps_its_sign(void)
{
    machine_set("load_torque", "torque_nm", 0.3);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8, -0.3, torque_at(1.0, 0.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, -0.3, torque_at(1.0, 50.0));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, -0.3, torque_at(1.0, -50.0));
}

void test_effects_load_torque_is_what_the_sensor_does_not_show(void)
{
    machine_set("load_torque", "torque_nm", 0.3);
    machine_start();
    sim_reading_t r;
    sim_plant_read(&plant, &r);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.load_nm);
}

void test_effects_coulomb_friction_opposes_motion_with_one_size(void)
{
    machine_set("coulomb_friction", "torque_nm", 0.3);
    const double speed[] = {0.5, 50.0, 500.0};
    for (size_t k = 0; k < COUNT_OF(speed); k++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, -0.3, torque_at(1.0, speed[k]));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.3, torque_at(1.0, -speed[k]));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, torque_at(1.0, 0.0));
}

void test_effects_stribeck_friction_falls_with_the_square_of_the_speed(void)
{
    machine_set("stribeck_friction", "torque_nm", 0.3);
    machine_set("stribeck_friction", "speed_rad_s", 4.0);
    const double speed[] = {0.5, 2.0, 4.0, 8.0, 30.0};
    for (size_t k = 0; k < COUNT_OF(speed); k++) {
        const double size = 0.3 * exp(-speed[k] * speed[k] / 16.0);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, -size, torque_at(1.0, speed[k]));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, size, torque_at(1.0, -speed[k]));
    }
}

void test_effects_stribeck_friction_adds_to_coulomb_friction_at_standstill(void)
{
    machine_set("stribeck_friction", "torque_nm", 0.03);
    machine_set("coulomb_friction", "torque_nm", 0.02);
    model.psi_wb = 0.0;
    machine_start();
    plant.outside.load_torque_nm = 0.0499;
    machine_voltage(0.0, 0.0, 100);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.x.speed_rad_s);
    plant.outside.load_torque_nm = 0.0501;
    machine_voltage(0.0, 0.0, 100);
    TEST_ASSERT_TRUE(plant.x.speed_rad_s < 0.0);
}

static void assert_factor(const char *effect, const double *field, double nominal)
{
    machine_set(effect, "factor", 1.3);
    machine_start();
    ASSERT_REL(1e-12, 1.3 * nominal, *field, effect);
}

void test_effects_factors_multiply_the_number_of_the_model(void)
{
    assert_factor("inertia", &plant.model.inertia_kgm2, model.inertia_kgm2);
    assert_factor("viscous_friction", &plant.model.viscous_nms, model.viscous_nms);
    assert_factor("torque_constant", &plant.model.psi_wb, model.psi_wb);
    assert_factor("winding_resistance", &plant.model.resistance_ohm, model.resistance_ohm);
}

void test_effects_factor_acts_in_the_machine_and_not_only_in_its_model(void)
{
    machine_set("inertia", "factor", 2.0);
    model.psi_wb = 0.0;
    model.viscous_nms = 0.0;
    machine_start();
    plant.outside.load_torque_nm = -0.0706;
    machine_voltage(0.0, 0.0, 100);
    ASSERT_REL(1e-9, 5.0, plant.x.speed_rad_s, "half of 1000 rad/s^2");
}

/* h_q = sign A psi cos(6 theta_e): in the torque per ampere, and in the back-EMF */
static void flux(double theta_m, double *h_q)
{
    model.rotor_locked = 1.0;
    model.initial_angle_rad = theta_m;
    machine_start();
    plant.x.iq_a = 2.0;
    sim_reading_t r;
    sim_plant_read(&plant, &r);
    *h_q = sim_plant_torque(&plant) / (1.5 * 4.0 * 2.0) - 6.4e-3;
}

void test_effects_flux_harmonics_are_the_sixth_electrical_order_of_the_torque_per_ampere(void)
{
    machine_set("flux_harmonics", "torque_ripple_rel", 0.05);
    for (int sign = -1; sign <= 1; sign += 2) {
        machine_set("flux_harmonics", "sign", sign);
        for (int k = 0; k < 20; k++) {
            double h_q;
            flux(0.07 * k, &h_q);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, sign * 0.05 * 6.4e-3 * cos(24.0 * 0.07 * k), h_q);
        }
    }
}

/* In the stationary frame the magnets' flux per phase then has a fifth harmonic alone, or a seventh alone. */
void test_effects_flux_harmonics_split_into_the_fifth_and_the_seventh_by_their_share(void)
{
    const sim_effect_t *const x = sim_effects[machine_effect("flux_harmonics")];
    for (int share = 0; share <= 1; share++) {
        double       at_5 = 0.0;
        double       at_7 = 0.0;
        const double p[SIM_EFFECT_PARAMS] = {0.05, 1.0, share};
        for (int k = 0; k < 64; k++) {
            const double theta = k * 3.14159265358979323846 / 32.0;
            sim_flux_t   h = {0.0, 0.0};
            x->flux(p, &model, theta, 0.0, &h);
            const double emf_a = h.d_wb * cos(theta) - h.q_wb * sin(theta);
            at_5 += emf_a * sin(5.0 * theta) / 32.0;
            at_7 += emf_a * sin(7.0 * theta) / 32.0;
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, (share == 1) ? 0.05 * model.psi_wb : 0.0, fabs(at_5));
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, (share == 0) ? 0.05 * model.psi_wb : 0.0, fabs(at_7));
    }
}

/* At constant speed with open currents diq/dt = -we (psi + h_q) / Lq at the start. */
void test_effects_flux_harmonics_show_in_the_back_emf(void)
{
    machine_set("flux_harmonics", "torque_ripple_rel", 0.05);
    model.inertia_kgm2 = 1e3;
    model.initial_speed_rad_s = 100.0;
    model.pwm_hz = 200e3;
    for (int k = 0; k < 10; k++) {
        const double theta = 0.07 * k;
        model.initial_angle_rad = theta;
        machine_start();
        machine_voltage(0.0, 0.0, 1);
        const double emf = 400.0 * 6.4e-3 * (1.0 + 0.05 * cos(24.0 * theta));
        /* 5 us: decay by 0.9 % half-way, and the angle moves on by 0.3 of a thousandth turn */
        ASSERT_REL(0.006, -emf * 5e-6 / 0.2e-3 * (1.0 - 0.5 * 5e-6 * 1800.0), plant.x.iq_a, at("at %g", theta));
    }
}

void test_effects_current_offset_adds_to_the_phase_sensors(void)
{
    machine_set("current_offset", "offset_a_a", 0.2);
    machine_set("current_offset", "offset_b_a", -0.05);
    machine_start();
    plant.x.id_a = 1.0; /* a: 1 A, b: -0.5 A */
    sim_reading_t r;
    sim_plant_read(&plant, &r);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.2, r.ia_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.55, r.ib_a);
    double i[3];
    sim_plant_phase_currents(&plant, i);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0, i[0]); /* the current itself is what it is */
}

void test_effects_current_gain_multiplies_the_phase_sensors(void)
{
    machine_set("current_gain", "gain_a", 1.1);
    machine_set("current_gain", "gain_b", 0.9);
    machine_start();
    plant.x.id_a = 1.0;
    sim_reading_t r;
    sim_plant_read(&plant, &r);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.1, r.ia_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.45, r.ib_a);
}

void test_effects_sensor_errors_come_before_rounding_and_clipping(void)
{
    machine_set("current_gain", "gain_a", 1.1);
    model.current_lsb_a = 0.25;
    model.current_range_a = 2.0;
    machine_start();
    plant.x.id_a = 1.0;
    sim_reading_t r;
    sim_plant_read(&plant, &r);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0, r.ia_a); /* 1.1 rounds down */
    plant.x.id_a = 1.9;
    sim_plant_read(&plant, &r);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2.0, r.ia_a); /* 2.09 is beyond */
}

static double seen_angle(double theta_m)
{
    model.counts_per_rev = 0.0;
    model.initial_angle_rad = theta_m;
    machine_start();
    sim_reading_t r;
    sim_plant_read(&plant, &r);
    return r.theta_m_rad;
}

void test_effects_encoder_eccentricity_adds_the_sine_of_the_angle(void)
{
    machine_set("encoder_eccentricity", "amplitude_rad", 0.02);
    machine_set("encoder_eccentricity", "phase_rad", 0.5);
    for (int k = 1; k < 60; k++) {
        const double theta = 0.1 * k;
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, theta + 0.02 * sin(theta + 0.5), seen_angle(theta));
    }
}

void test_effects_encoder_offset_is_electrical(void)
{
    machine_set("encoder_offset", "angle_el_rad", 0.4);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.1, seen_angle(1.0)); /* 4 pole pairs */
}

void test_effects_angle_errors_move_the_edges_too(void)
{
    machine_set("encoder_offset", "angle_el_rad", 0.4);
    model.inertia_kgm2 = 1e3;
    model.psi_wb = 0.0;
    model.viscous_nms = 0.0;
    model.initial_speed_rad_s = 100.0;
    machine_start();
    machine_voltage(0.0, 0.0, 100); /* turned by 1 rad, seen at 1.1 rad */
    const double count = TWO_PI / 4000.0;
    TEST_ASSERT_EQUAL_INT64((int64_t)floor(1.1 / count), plant.edge_count);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, (floor(1.1 / count) * count - 0.1) / 100.0, plant.edge_time_s);
}

/* Each phase loses Td f Vdc against its current: with i_a > 0 > i_b = i_c the vector on phase a loses
 * (2 + 1 + 1) / 3 of it: 2 us 10 kHz 24 V = 0.48 V, times 4/3 = 0.64 V. */
void test_effects_dead_time_takes_its_average_voltage_from_every_phase(void)
{
    machine_set("dead_time", "dead_time_s", 2e-6);
    model.rotor_locked = 1.0;
    for (int sign = -1; sign <= 1; sign += 2) {
        machine_start();
        machine_voltage(1.8 * sign, 0.0, 300);
        ASSERT_REL(1e-9, (1.8 - 0.64) / 0.36 * sign, plant.x.id_a, at("sign %d", sign));
        TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, plant.x.iq_a);
    }
}

static void lose(const double end_a[3], double v[3])
{
    const double p[SIM_EFFECT_PARAMS] = {2e-6}; /* 0.48 V, which move 0.048 A */
    sim_bridge_t bridge = {.pwm_hz = 10e3, .dc_link_v = 24.0, .length_s = 1e-4, .inverse_h = 1e3};
    memcpy(bridge.begin_a, end_a, sizeof bridge.begin_a);
    memcpy(bridge.end_a, end_a, sizeof bridge.end_a);
    v[0] = v[1] = v[2] = 12.0;
    sim_effects[machine_effect("dead_time")]->phase_voltage(p, &bridge, v);
}

void test_effects_dead_time_leaves_a_phase_without_current_alone(void)
{
    double v[3];
    lose((const double[3]){2.0, 0.0, -2.0}, v);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 12.0 - 0.48, v[0]);
    TEST_ASSERT_EQUAL_DOUBLE(12.0, v[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 12.0 + 0.48, v[2]);
}

/* The star point takes a third of what a lone phase gives: 0.01 A need 0.1 V, so 0.15 V at this phase. */
void test_effects_dead_time_takes_a_small_current_to_zero_and_not_beyond(void)
{
    double v[3];
    lose((const double[3]){2.0, 0.01, -2.01}, v);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 12.0 - 0.48, v[0]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 12.0 - 0.15, v[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 12.0 + 0.48, v[2]);
    lose((const double[3]){0.02, -0.01, -0.01}, v); /* all three: mean 0 again */
    const double mean = (v[0] + v[1] + v[2]) / 3.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.2, v[0] - mean);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.1, v[1] - mean);
}

/* 0.3 V is less than the 0.64 V above: the diodes block. Without the effect 0.83 A would flow. */
void test_effects_dead_time_lets_no_current_flow_below_its_own_voltage(void)
{
    machine_set("dead_time", "dead_time_s", 2e-6);
    model.rotor_locked = 1.0;
    for (int k = 0; k < 12; k++) {
        machine_start();
        plant.x.id_a = 0.2; /* what flows at first goes */
        for (int n = 0; n < 20; n++) {
            machine_voltage(0.3 * cos(0.5 * k), 0.3 * sin(0.5 * k), 1);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, plant.x.id_a);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, plant.x.iq_a);
    }
}

/* The phase of a current that just passes zero loses its full voltage again. */
void test_effects_dead_time_opposes_a_current_that_the_voltage_carries_through_zero(void)
{
    machine_set("dead_time", "dead_time_s", 2e-6);
    model.rotor_locked = 1.0;
    machine_start();
    plant.x.id_a = -0.2;
    machine_voltage(1.8, 0.0, 300);
    ASSERT_REL(1e-9, (1.8 - 0.64) / 0.36, plant.x.id_a, "above zero");
}
