/* The referee's machine against what can be written down: exponentials, stopping times, resonances, power. */
#include <math.h>
#include <unity.h>

#include "sim_host/referee/machine.h"
#include "tests/sim_host/referee/support/defaults.h"

static const double H_S = 5e-6;

static referee_parameters_t p;
static referee_machine_t    machine;

void setUp(void) { p = plain_motor(); }

void tearDown(void) {}

static void run(double duration_s, double v_alpha, double load_nm)
{
    const int steps = (int)lround(duration_s / H_S);
    for (int n = 0; n < steps; n++) {
        referee_machine_step(&machine, H_S, (referee_vector_t){v_alpha, 0.0}, load_nm, n * H_S);
    }
}

void test_referee_machine_locked_current_rises_exponentially(void)
{
    p.motor_locked = 1.0;
    referee_machine_init(&machine, &p);

    run(5e-3, 10.0, 0.0); /* one time constant */

    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 10.0 * (1.0 - exp(-1.0)), machine.i_a.x); /* trapezoidal: (h/tau)^2 / 12 */
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.0, machine.i_a.y);
}

void test_referee_machine_locked_salient_rotor_current_bends_toward_the_easy_axis(void)
{
    p.motor_locked = 1.0;
    p.motor_ld_h = 2e-3;
    p.motor_start_angle_rad = REFEREE_PI / 12.0; /* 45 degrees electrical */
    referee_machine_init(&machine, &p);

    run(1e-3, 10.0, 0.0);

    const double d = (10.0 / sqrt(2.0)) * (1.0 - exp(-0.5)); /* v_d = 10 cos 45, v_q = -10 sin 45 */
    const double q = -(10.0 / sqrt(2.0)) * (1.0 - exp(-0.2));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, (d - q) / sqrt(2.0), machine.i_a.x);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, (d + q) / sqrt(2.0), machine.i_a.y);
}

void test_referee_machine_saturated_current_rises_as_the_differential_inductance_says(void)
{
    p.motor_locked = 1.0;
    p.motor_resistance_ohm = 0.0;
    p.inductance_saturation_i_sat_a = 4.0;
    referee_machine_init(&machine, &p);

    run(2e-3, 10.0, 0.0);

    /* L di / (1 + (i/s)^2) = v dt: i = s tan(v t / (L s)); 0.5 %, for L is that of the start of a step */
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 4.0 * tan(10.0 * 2e-3 / (5e-3 * 4.0)), machine.i_a.x);
}

void test_referee_machine_axes_may_saturate_for_themselves(void)
{
    p.motor_locked = 1.0;
    p.motor_resistance_ohm = 0.0;
    p.inductance_saturation_i_sat_a = 4.0;
    p.inductance_saturation_per_axis = 1.0;
    referee_machine_init(&machine, &p);

    for (int n = 0; n < 400; n++) { /* 10 V in d, 5 V in q */
        referee_machine_step(&machine, H_S, (referee_vector_t){10.0, 5.0}, 0.0, 0.0);
    }

    TEST_ASSERT_DOUBLE_WITHIN(0.03, 4.0 * tan(1.0), machine.i_a.x);
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 4.0 * tan(0.5), machine.i_a.y);
}

void test_referee_machine_friction_at_the_load_brakes_the_load(void)
{
    p.motor_resistance_ohm = 1e6;
    p.two_mass_f_res_hz = 100.0;
    p.two_mass_damping_ratio = 0.1;
    p.motor_viscous_nms = 2e-3;
    p.motor_load_friction_share = 1.0;
    referee_machine_init(&machine, &p);
    machine.speed_rad_s = 60.0;
    machine.load_speed_rad_s = 60.0;

    run(0.5, 0.0, 0.0);

    TEST_ASSERT_DOUBLE_WITHIN(0.05, 60.0 * exp(-1.0), machine.speed_rad_s);
    TEST_ASSERT_TRUE(machine.theta_rad > machine.load_theta_rad); /* the rotor pulls the load that is braked */
}

void test_referee_machine_viscous_friction_coasts_exponentially(void)
{
    p.motor_resistance_ohm = 1e6; /* hardly any braking current */
    p.motor_viscous_nms = 2e-3;
    referee_machine_init(&machine, &p);
    machine.speed_rad_s = 60.0;
    machine.load_speed_rad_s = 60.0;

    run(0.5, 0.0, 0.0); /* J / B */

    TEST_ASSERT_DOUBLE_WITHIN(0.01, 60.0 * exp(-1.0), machine.speed_rad_s);
}

void test_referee_machine_dry_friction_stops_in_time_and_holds(void)
{
    p.motor_resistance_ohm = 1e6;
    p.coulomb_friction_torque_nm = 0.05;
    referee_machine_init(&machine, &p);
    machine.speed_rad_s = 10.0; /* stops after J w / T = 0.2 s */

    run(0.19, 0.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.5, machine.speed_rad_s);
    run(0.02, 0.0, 0.0);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, machine.speed_rad_s);
    run(0.01, 0.0, 0.049); /* load below the friction */
    TEST_ASSERT_EQUAL_DOUBLE(0.0, machine.speed_rad_s);
    run(0.01, 0.0, 0.06); /* and above: (0.01 / J) t */
    TEST_ASSERT_DOUBLE_WITHIN(0.002, -0.1, machine.speed_rad_s);
}

void test_referee_machine_coulomb_friction_that_rises_with_the_speed_lets_a_loaded_shaft_creep(void)
{
    p.motor_resistance_ohm = 1e6;
    p.coulomb_friction_torque_nm = 0.05;
    p.coulomb_friction_smooth_rad_s = 0.4;
    referee_machine_init(&machine, &p);
    machine.speed_rad_s = 10.0;

    run(0.1, 0.0, 0.0); /* T / J = 50 rad/s^2, less 1 - w / hypot(w, s) = 0.1 to 0.3 % */
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 5.0, machine.speed_rad_s);
    run(1.0, 0.0, 0.03); /* w / hypot(w, s) = 0.6 */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -0.4 * 0.75, machine.speed_rad_s);
}

void test_referee_machine_coulomb_friction_that_gives_way_is_a_spring_until_it_slides(void)
{
    p.motor_resistance_ohm = 1e6;
    p.motor_viscous_nms = 0.1; /* 10 ms: no swing is left */
    p.coulomb_friction_torque_nm = 0.05;
    p.coulomb_friction_spring_rad = 0.01;
    referee_machine_init(&machine, &p);
    const double start = machine.theta_rad;

    run(0.5, 0.0, 0.03); /* 0.6 of it */
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.006, machine.theta_rad - start);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0, machine.speed_rad_s);
    run(0.5, 0.0, 0.08); /* slides: (0.08 - 0.05) / B */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, -0.3, machine.speed_rad_s);
}

void test_referee_machine_stribeck_adds_friction_at_low_speed_only(void)
{
    p.motor_resistance_ohm = 1e6;
    p.stribeck_friction_torque_nm = 0.05;
    p.stribeck_friction_speed_rad_s = 5.0;
    referee_machine_init(&machine, &p);

    machine.speed_rad_s = 50.0;
    run(0.01, 0.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 50.0, machine.speed_rad_s);
    machine.speed_rad_s = 2.5; /* exp(-1/4) of it */
    run(0.001, 0.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-4, 2.5 - (0.05 * exp(-0.25)), machine.speed_rad_s);
}

void test_referee_machine_torque_is_the_power_of_the_back_emf(void)
{
    p.flux_harmonics_torque_ripple_rel = 0.2;
    p.flux_harmonics_fifth_share = 0.3; /* with a part in d */
    p.motor_inertia_kgm2 = 1e6;         /* the speed stays */
    referee_machine_init(&machine, &p);
    machine.speed_rad_s = 50.0;

    double work_j = 0.0;
    double copper_j = 0.0;
    double fed_j = 0.0;
    for (int n = 0; n < 20000; n++) {
        const referee_vector_t v = {20.0 * cos(400.0 * n * H_S), 20.0 * sin(400.0 * n * H_S)};
        const referee_vector_t i = machine.i_a;
        referee_machine_step(&machine, H_S, v, 0.0, 0.0);
        const double x = 0.5 * (i.x + machine.i_a.x);
        const double y = 0.5 * (i.y + machine.i_a.y);
        work_j += machine.torque_nm * 50.0 * H_S;
        copper_j += 1.5 * ((x * x) + (y * y)) * H_S;
        fed_j += 1.5 * ((v.x * x) + (v.y * y)) * H_S;
    }
    const double stored = 0.75 * 5e-3 * ((machine.i_a.x * machine.i_a.x) + (machine.i_a.y * machine.i_a.y));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * copper_j, fed_j, work_j + copper_j + stored);
}

void test_referee_machine_salient_torque_is_the_power_that_is_neither_heat_nor_stored(void)
{
    p.motor_ld_h = 2e-3;
    p.motor_inertia_kgm2 = 1e6;
    referee_machine_init(&machine, &p);
    machine.speed_rad_s = 50.0;

    double rest_j = 0.0; /* of what was fed */
    double work_j = 0.0;
    for (int n = 0; n < 20000; n++) {
        const double           angle = (150.0 * n * H_S) + 2.0; /* with the rotor: d and q current */
        const referee_vector_t v = {25.0 * cos(angle), 25.0 * sin(angle)};
        const referee_vector_t i = machine.i_a;
        referee_machine_step(&machine, H_S, v, 0.0, 0.0);
        const double x = 0.5 * (i.x + machine.i_a.x);
        const double y = 0.5 * (i.y + machine.i_a.y);
        work_j += machine.torque_nm * 50.0 * H_S;
        rest_j += 1.5 * ((v.x * x) + (v.y * y) - (x * x) - (y * y)) * H_S;
    }
    const double theta_e = 3.0 * machine.theta_rad;
    const double id = (machine.i_a.x * cos(theta_e)) + (machine.i_a.y * sin(theta_e));
    const double iq = (machine.i_a.y * cos(theta_e)) - (machine.i_a.x * sin(theta_e));
    const double stored_j = 0.75 * ((2e-3 * id * id) + (5e-3 * iq * iq));
    const double reluctance_j = 1.5 * 3.0 * 3e-3 * fabs(id * iq) * 50.0 * 0.1;
    TEST_ASSERT_TRUE(reluctance_j > 0.02 * fabs(work_j)); /* there is something to see */
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * reluctance_j, rest_j, work_j + stored_j);
}

/* Amplitude of sin(order theta_e) in phase a of an open motor, over that of the first order. */
static double emf_order(int order)
{
    const int n = 4000;
    double    first = 0.0;
    double    wanted = 0.0;
    for (int k = 0; k < n; k++) {
        const double theta_e = 2.0 * REFEREE_PI * k / n;
        p.motor_start_angle_rad = theta_e / 3.0;
        referee_machine_init(&machine, &p);
        machine.speed_rad_s = 1e-3; /* hardly moves in a step */
        referee_machine_step(&machine, H_S, (referee_vector_t){0.0, 0.0}, 0.0, 0.0);
        first += machine.i_a.x * sin(theta_e);
        wanted += machine.i_a.x * sin(order * theta_e);
    }
    return wanted / first;
}

void test_referee_machine_flux_harmonics_are_the_fifth_and_seventh_of_the_phase(void)
{
    p.motor_resistance_ohm = 1e6;
    p.motor_inertia_kgm2 = 1e6;
    p.flux_harmonics_torque_ripple_rel = 0.1;
    p.flux_harmonics_fifth_share = 0.3;

    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.03, emf_order(5));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.07, emf_order(7));
    p.flux_harmonics_sign = -1.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.03, emf_order(5));
}

void test_referee_machine_fan_slows_down_as_one_over_time(void)
{
    p.motor_resistance_ohm = 1e6;
    p.fan_load_torque_nm_s2 = 1e-4;
    referee_machine_init(&machine, &p);
    machine.speed_rad_s = -60.0;

    run(0.5, 0.0, 0.0);

    TEST_ASSERT_DOUBLE_WITHIN(0.01, -60.0 / (1.0 + (1e-4 * 60.0 * 0.5 / 1e-3)), machine.speed_rad_s);
}

void test_referee_machine_uneven_phase_has_its_resistance_in_its_path(void)
{
    p.motor_locked = 1.0;
    p.phase_unbalance_rise_rel = 0.3;
    referee_machine_init(&machine, &p);

    run(0.1, 10.0, 0.0); /* phase a against b and c in parallel: 1.3 + 0.5 instead of 1.5 ohm */

    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 10.0 * 1.5 / 1.8, machine.i_a.x);
}

void test_referee_machine_misalignment_brakes_at_both_orders(void)
{
    p.motor_resistance_ohm = 1e6;
    p.misalignment_amplitude_nm = 0.1;
    p.misalignment_phase_rad = 0.3;
    p.misalignment_second_rel = 0.5;
    p.misalignment_phase2_rad = 0.7;
    p.motor_start_angle_rad = 1.0;
    referee_machine_init(&machine, &p);

    run(1e-4, 0.0, 0.0);

    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.01 * (sin(1.3) + (0.5 * sin(2.7))), machine.speed_rad_s);
}

void test_referee_machine_cogging_brakes_where_its_sine_is_positive(void)
{
    p.motor_resistance_ohm = 1e6;
    p.cogging_amplitude_nm = 0.1;
    p.cogging_order = 18.0;
    p.cogging_phase_rad = 0.5 * REFEREE_PI;
    referee_machine_init(&machine, &p);

    run(1e-4, 0.0, 0.0);

    TEST_ASSERT_DOUBLE_WITHIN(1e-5, -0.01, machine.speed_rad_s); /* -A / J t */
}

static int crossings_of_twist(double duration_s)
{
    int    crossings = 0;
    double last = machine.theta_rad - machine.load_theta_rad;
    for (int n = 0; n < (int)lround(duration_s / H_S); n++) {
        referee_machine_step(&machine, H_S, (referee_vector_t){0.0, 0.0}, 0.0, 0.0);
        const double twist = machine.theta_rad - machine.load_theta_rad;
        crossings += (twist > 0.0) != (last > 0.0);
        last = twist;
    }
    return crossings;
}

void test_referee_machine_two_masses_ring_at_the_free_resonance(void)
{
    p.motor_resistance_ohm = 1e6;
    p.two_mass_f_res_hz = 100.0;
    p.two_mass_load_ratio = 0.75; /* of the total */
    p.two_mass_damping_ratio = 0.001;
    referee_machine_init(&machine, &p);
    machine.theta_rad = 0.01;

    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.25e-3, machine.motor_inertia_kgm2);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.75e-3, machine.load_inertia_kgm2);
    TEST_ASSERT_INT_WITHIN(1, 200, crossings_of_twist(1.0));
    /* what one gains the other loses, but for the braking of 1 Mohm */
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.0, (0.25 * machine.speed_rad_s) + (0.75 * machine.load_speed_rad_s));
}

void test_referee_machine_two_masses_lose_what_the_damping_ratio_says(void)
{
    p.motor_resistance_ohm = 1e6;
    p.two_mass_f_res_hz = 100.0;
    p.two_mass_damping_ratio = 0.02;
    referee_machine_init(&machine, &p);
    machine.theta_rad = 0.01;

    run(0.1, 0.0, 0.0); /* ten periods */

    const double twist = machine.theta_rad - machine.load_theta_rad;
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.01 * exp(-0.02 * 2.0 * REFEREE_PI * 10.0), twist);
}

void test_referee_machine_play_carries_nothing_inside_the_gap(void)
{
    p.motor_resistance_ohm = 1e6;
    p.backlash_f_res_hz = 150.0;
    p.backlash_gap_rad = 0.02;
    referee_machine_init(&machine, &p);
    machine.speed_rad_s = 1.0;

    run(0.0099, 0.0, 0.0); /* half of the play is 0.01 rad */
    TEST_ASSERT_EQUAL_DOUBLE(0.0, machine.load_speed_rad_s);
    run(0.0015, 0.0, 0.0); /* in contact */
    TEST_ASSERT_TRUE(machine.load_speed_rad_s > 0.1);
    TEST_ASSERT_TRUE(machine.speed_rad_s < 0.9);
}

void test_referee_machine_filter_delays_the_measured_current_only(void)
{
    p.motor_locked = 1.0;
    p.current_filter_tau_s = 1e-3;
    referee_machine_init(&machine, &p);

    run(1e-3, 10.0, 0.0);

    const double true_a = 10.0 * (1.0 - exp(-0.2));
    /* two unequal poles, 5 ms and 1 ms */
    const double seen_a = 10.0 * (1.0 - ((5.0 * exp(-0.2)) - exp(-1.0)) / 4.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, true_a, machine.i_a.x);
    TEST_ASSERT_DOUBLE_WITHIN(5e-3, seen_a, machine.i_filtered_a.x);
}

void test_referee_machine_warming_raises_the_resistance(void)
{
    referee_noise_t noise;
    referee_noise_seed(&noise, 1U);
    p.resistance_drift_rise_rel = 0.5;
    p.resistance_drift_time_s = 10.0;
    referee_machine_init(&machine, &p);

    referee_machine_age(&machine, 10.0, 1e-4, &noise);

    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0 + (0.5 * (1.0 - exp(-1.0))), machine.resistance_ohm);
}
