/* sim_host/plant/plant.c: motor, shaft and inverter against solutions that can be written down. */
#include "tests/sim_host/support/machine.h"

void setUp(void)
{
    machine_defaults();
    model.viscous_nms = 0.0;
}
void tearDown(void) {}

/* ---- electrical ----------------------------------------------------------------------------------------------------- */

/* i = v/R (1 - exp(-R t / L)). One period is 0.18 time constants (d axis), a tenth of it a step: (h R/L)^5 / 120 is 2e-11. */
void test_plant_current_of_a_locked_rotor_rises_with_the_time_constant_of_each_axis(void)
{
    model.rotor_locked = 1.0;
    model.lq_h = 0.5e-3;
    model.substeps = 10.0;
    machine_start();
    for (int k = 1; k <= 100; k++) {
        machine_voltage(1.8, -0.9, 1);
        const double t = 1e-4 * k;
        ASSERT_REL(1e-9, 5.0 * (1.0 - exp(-0.36 / 0.2e-3 * t)), plant.x.id_a, at("d, period %d", k));
        ASSERT_REL(1e-9, -2.5 * (1.0 - exp(-0.36 / 0.5e-3 * t)), plant.x.iq_a, at("q, period %d", k));
    }
}

void test_plant_locked_rotor_at_an_angle_sees_the_vector_from_there(void)
{
    model.rotor_locked = 1.0;
    model.initial_angle_rad = 0.3;
    machine_start();
    machine_voltage(1.8 * cos(1.2 + 0.5), 1.8 * sin(1.2 + 0.5), 200); /* 36 time constants */

    ASSERT_REL(1e-9, 5.0 * cos(0.5), plant.x.id_a, "d");
    ASSERT_REL(1e-9, 5.0 * sin(0.5), plant.x.iq_a, "q");
    TEST_ASSERT_EQUAL_DOUBLE(0.3, plant.x.theta_m_rad);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.x.speed_rad_s);
}

void test_plant_phase_currents_are_those_of_the_vector_and_add_up_to_zero(void)
{
    machine_start();
    plant.x.theta_m_rad = 0.0;
    plant.x.id_a = 3.0;
    plant.x.iq_a = 4.0;
    plant.cosine_e = cos(0.7);
    plant.sine_e = sin(0.7);
    double i[3];
    sim_plant_phase_currents(&plant, i);
    for (int k = 0; k < 3; k++) { /* 5 A, atan(4/3) ahead of the d axis */
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, 5.0 * cos(0.7 + atan2(4.0, 3.0) - TWO_PI / 3.0 * k), i[k]);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, i[0] + i[1] + i[2]);
}

/* Short circuit at constant speed: 0 = -R id + we Lq iq, 0 = -R iq - we Ld id - we psi, solved by hand. */
void test_plant_back_emf_drives_the_currents_of_a_shorted_machine_at_constant_speed(void)
{
    model.inertia_kgm2 = 1e3; /* 1e-6 rad/s^2: the speed does not change */
    model.lq_h = 0.35e-3;
    model.initial_speed_rad_s = 100.0;
    model.substeps = 10.0;
    machine_start();
    machine_voltage(0.0, 0.0, 200);

    /* 0.27 N m slow it by 5e-8 in this time, and the currents follow the speed and its square */
    const double we = 400.0;
    const double nn = 0.36 * 0.36 + we * we * 0.2e-3 * 0.35e-3;
    ASSERT_REL(2e-7, -we * we * 0.35e-3 * 6.4e-3 / nn, plant.x.id_a, "d");
    ASSERT_REL(2e-7, -0.36 * we * 6.4e-3 / nn, plant.x.iq_a, "q");
}

void test_plant_shorted_machine_brakes_in_both_directions(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        model.initial_speed_rad_s = 100.0 * sign;
        machine_start();
        machine_voltage(0.0, 0.0, 100);
        TEST_ASSERT_TRUE(sign * plant.x.speed_rad_s < 90.0);
        TEST_ASSERT_TRUE(sign * plant.x.iq_a < 0.0);
    }
}

/* ---- torque --------------------------------------------------------------------------------------------------------- */

static void hold_currents(double id_a, double iq_a)
{
    model.rotor_locked = 1.0;
    machine_start();
    machine_voltage(0.36 * id_a, 0.36 * iq_a, 2000); /* 60 time constants of 1.2 mH */
    sim_reading_t reading;
    sim_plant_read(&plant, &reading);
}

void test_plant_torque_is_that_of_the_magnets_and_of_the_saliency(void)
{
    model.ld_h = 0.9e-3;
    model.lq_h = 1.2e-3;
    model.psi_wb = 0.0594;
    model.pole_pairs = 5.0;
    hold_currents(-2.0, 3.0);

    ASSERT_REL(1e-9, 1.5 * 5.0 * (0.0594 * 3.0 + (0.9e-3 - 1.2e-3) * (-2.0) * 3.0), sim_plant_torque(&plant), "ipm");
}

void test_plant_torque_of_a_machine_without_magnets_is_reluctance_torque(void)
{
    model.ld_h = 1.2e-3;
    model.lq_h = 0.9e-3;
    model.psi_wb = 0.0;
    hold_currents(2.0, 3.0);

    ASSERT_REL(1e-9, 1.5 * 4.0 * 0.3e-3 * 6.0, sim_plant_torque(&plant), "reluctance");
}

void test_plant_torque_accelerates_the_inertia(void)
{
    model.psi_wb = 0.0; /* no back-EMF: the load alone */
    machine_start();
    plant.outside.load_torque_nm = -0.0706;
    for (int k = 1; k <= 50; k++) {
        machine_voltage(0.0, 0.0, 1);
        ASSERT_REL(1e-9, 1000.0 * 1e-4 * k, plant.x.speed_rad_s, at("period %d", k));
        ASSERT_REL(1e-9, 0.5 * 1000.0 * 1e-8 * k * k, plant.x.theta_m_rad, at("period %d", k));
    }
}

void test_plant_positive_q_current_turns_forward(void)
{
    machine_start();
    machine_dq_voltage(0.0, 2.0, 100);

    TEST_ASSERT_TRUE(plant.x.speed_rad_s > 10.0);
    TEST_ASSERT_TRUE(plant.x.theta_m_rad > 0.0);
}

/* ---- friction and loads --------------------------------------------------------------------------------------------- */

/* w = w0 exp(-B t / J), theta = w0 J / B (1 - ...); without magnets nothing else acts. */
void test_plant_viscous_coast_down_is_exponential(void)
{
    model.psi_wb = 0.0;
    model.viscous_nms = 7.06e-4; /* 0.1 s */
    model.initial_speed_rad_s = -300.0;
    machine_start();
    for (int k = 1; k <= 5000; k++) {
        machine_voltage(0.0, 0.0, 1);
        if (k % 500 == 0) {
            const double decay = exp(-1e-4 * k / 0.1);
            ASSERT_REL(1e-9, -300.0 * decay, plant.x.speed_rad_s, at("period %d", k));
            ASSERT_REL(1e-9, -30.0 * (1.0 - decay), plant.x.theta_m_rad, at("period %d", k));
        }
    }
}

static void assert_dry_coast_down(double w0, const char *text)
{
    /* decelerates by T/J = 1000 rad/s^2 and stands after |w0|/1000 s and w0^2 / 2000 rad */
    const double sign = (w0 > 0.0) ? 1.0 : -1.0;
    const double stop_s = fabs(w0) / 1000.0;
    for (int k = 1; k <= 1500; k++) {
        machine_voltage(0.0, 0.0, 1);
        const double t = 1e-4 * k;
        if (t < stop_s) {
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, w0 - sign * 1000.0 * t, plant.x.speed_rad_s, text);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, w0 * t - sign * 500.0 * t * t, plant.x.theta_m_rad, text);
        } else {
            TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(0.0, plant.x.speed_rad_s, text); /* exactly, and for ever */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, sign * w0 * w0 / 2000.0, plant.x.theta_m_rad, text);
        }
    }
}

void test_plant_coulomb_coast_down_is_linear_and_stops_exactly_without_turning_back(void)
{
    const double w0[] = {100.0, -100.0, 33.333, -0.04};
    for (size_t k = 0; k < COUNT_OF(w0); k++) {
        model.psi_wb = 0.0;
        model.initial_speed_rad_s = w0[k];
        machine_set("coulomb_friction", "torque_nm", 0.0706);
        machine_start();
        assert_dry_coast_down(w0[k], at("from %g rad/s", w0[k]));
    }
}

void test_plant_brake_stops_like_dry_friction(void)
{
    const double w0[] = {100.0, -77.7};
    for (size_t k = 0; k < COUNT_OF(w0); k++) {
        model.psi_wb = 0.0;
        model.initial_speed_rad_s = w0[k];
        machine_start();
        plant.outside.load_brake_nm = 0.0706;
        assert_dry_coast_down(w0[k], at("from %g rad/s", w0[k]));
    }
}

void test_plant_brake_cannot_push_a_rotor_that_stands(void)
{
    machine_start();
    plant.outside.load_brake_nm = 5.0;
    machine_voltage(0.0, 0.0, 500);

    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.x.speed_rad_s);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.x.theta_m_rad);
}

void test_plant_friction_holds_what_is_smaller_and_lets_go_what_is_larger(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        model.psi_wb = 0.0;
        machine_set("coulomb_friction", "torque_nm", 0.02);
        machine_start();
        plant.outside.load_brake_nm = 0.03;
        plant.outside.load_torque_nm = -0.0499 * sign;
        machine_voltage(0.0, 0.0, 500);
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(0.0, plant.x.speed_rad_s, "0.0499 of 0.05 N m");

        plant.outside.load_torque_nm = -(0.05 + 0.0706) * sign;
        machine_voltage(0.0, 0.0, 500);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, 50.0 * sign, plant.x.speed_rad_s, "0.0706 N m too much: 1000 rad/s^2");
    }
}

/* 0.05 N m slow it down by 708 rad/s^2 with 0.03 N m of friction on top; then it turns back with 0.05 - 0.03 */
void test_plant_load_that_may_drive_turns_the_shaft_back_through_friction(void)
{
    model.psi_wb = 0.0;
    model.initial_speed_rad_s = 20.0;
    machine_set("coulomb_friction", "torque_nm", 0.03);
    machine_start();
    plant.outside.load_torque_nm = 0.05;
    machine_voltage(0.0, 0.0, 1000);

    const double stop_s = 20.0 / (0.08 / 7.06e-5);
    ASSERT_REL(1e-9, -(0.02 / 7.06e-5) * (0.1 - stop_s), plant.x.speed_rad_s, "after the reversal");
}

void test_plant_load_sensor_shows_what_brakes_positive_rotation(void)
{
    sim_reading_t reading;
    for (int sign = -1; sign <= 1; sign++) {
        model.initial_speed_rad_s = 10.0 * sign;
        machine_start();
        plant.outside.load_torque_nm = 0.01;
        plant.outside.load_brake_nm = 0.04;
        sim_plant_read(&plant, &reading);
        TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.01 + 0.04 * sign, plant.load_nm);
    }
}

void test_plant_locked_rotor_stands_whatever_pulls(void)
{
    model.rotor_locked = 1.0;
    model.initial_speed_rad_s = 50.0;
    model.initial_angle_rad = 1.0;
    machine_start();
    plant.outside.load_torque_nm = -10.0;
    machine_voltage(3.0, 3.0, 100);

    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.x.speed_rad_s);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, plant.x.theta_m_rad);
}

/* ---- energy --------------------------------------------------------------------------------------------------------- */

/* One second at 200000 periods: what the bridge delivers is copper loss, friction, work on the load, and what is stored.
 * Powers are summed by the trapezoidal rule at the ends of the periods: (5 us / 0.55 ms)^2 / 12 is 7e-6 of a transient. */
static void assert_energy_balance(void)
{
    model.pwm_hz = 200e3;
    model.viscous_nms = 1e-4;
    model.lq_h = 0.3e-3;
    machine_start();
    plant.outside.load_torque_nm = 0.03;
    const double h = 5e-6;
    double       in = 0.0, copper = 0.0, friction = 0.0, work = 0.0;
    for (int k = 0; k < 200000; k++) {
        const double e0 = 4.0 * plant.x.theta_m_rad;
        const double vq = (k < 100000) ? 4.0 : 2.5;
        const double ab[2] = {-vq * sin(e0), vq * cos(e0)};
        for (int end = 0; end < 2; end++) {
            const sim_state_t *const x = &plant.x;
            const double             e = 4.0 * x->theta_m_rad;
            const double             vd_now = ab[0] * cos(e) + ab[1] * sin(e);
            const double             vq_now = ab[1] * cos(e) - ab[0] * sin(e);
            in += 0.5 * h * 1.5 * (vd_now * x->id_a + vq_now * x->iq_a);
            copper += 0.5 * h * 1.5 * 0.36 * (x->id_a * x->id_a + x->iq_a * x->iq_a);
            friction += 0.5 * h * 1e-4 * x->speed_rad_s * x->speed_rad_s;
            work += 0.5 * h * 0.03 * x->speed_rad_s;
            if (end == 0) {
                machine_voltage(ab[0], ab[1], 1);
            }
        }
    }
    const double stored = 0.75 * (0.2e-3 * plant.x.id_a * plant.x.id_a + 0.3e-3 * plant.x.iq_a * plant.x.iq_a) +
                          0.5 * 7.06e-5 * plant.x.speed_rad_s * plant.x.speed_rad_s;
    TEST_ASSERT_TRUE(in > 1.0);
    TEST_ASSERT_TRUE((copper > 0.03 * in) && (friction > 0.03 * in) && (work > 0.03 * in)); /* none of them is idle */
    TEST_ASSERT_DOUBLE_WITHIN(1e-5 * in, in, copper + friction + work + stored);
}

void test_plant_energy_of_one_second_adds_up(void) { assert_energy_balance(); }

/* the same through the code for machines with effects: a torque that gives and takes over a turn, and flux harmonics */
void test_plant_energy_of_one_second_adds_up_with_flux_harmonics(void)
{
    machine_set("flux_harmonics", "torque_ripple_rel", 0.1);
    assert_energy_balance();
}

/* ---- integration ---------------------------------------------------------------------------------------------------- */

static sim_state_t end_state(int substeps)
{
    model.substeps = substeps;
    model.lq_h = 0.3e-3;
    model.initial_speed_rad_s = 60.0;
    machine_start();
    machine_voltage(2.0, 3.0, 5); /* constant in the stationary frame: the rotor turns in it by 0.12 rad electrical */
    return plant.x;
}

static double distance(sim_state_t a, sim_state_t b)
{
    return fabs(a.id_a - b.id_a) + fabs(a.iq_a - b.iq_a) + fabs(a.speed_rad_s - b.speed_rad_s) +
           fabs(a.theta_m_rad - b.theta_m_rad);
}

void test_plant_integration_is_of_fourth_order(void)
{
    const sim_state_t best = end_state(200);
    double            before = distance(end_state(1), best);
    TEST_ASSERT_TRUE(before > 1e-8); /* there is something to get smaller */
    for (int n = 2; n <= 8; n *= 2) {
        const double now = distance(end_state(n), best);
        TEST_ASSERT_TRUE_MESSAGE((before / now > 12.0) && (before / now < 24.0),
                                 at("%d steps: %g times better", n, before / now));
        before = now;
    }
}

void test_plant_chooses_steps_that_are_fine_enough_by_itself(void)
{
    const sim_state_t best = end_state(200);
    const sim_state_t own = end_state(0);

    TEST_ASSERT_TRUE(plant.substeps >= 1);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * fabs(best.iq_a), best.iq_a, own.iq_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5 * fabs(best.speed_rad_s), best.speed_rad_s, own.speed_rad_s);
}

void test_plant_takes_more_steps_for_a_faster_machine(void)
{
    model.resistance_ohm = 4.0; /* 2 time constants per period: 5 steps of 0.4 */
    machine_start();
    TEST_ASSERT_EQUAL_INT(5, plant.substeps);
}

void test_plant_angle_of_the_frame_does_not_drift_over_many_turns(void)
{
    model.inertia_kgm2 = 1e3; /* the short circuit slows it by a millionth */
    model.initial_speed_rad_s = 500.0;
    model.substeps = 1.0; /* the frame turns by 0.2 rad a step, and is computed again after 256 */
    machine_start();
    machine_voltage(0.0, 0.0, 20000); /* 1000 rad */

    const double e = 4.0 * plant.x.theta_m_rad;
    TEST_ASSERT_DOUBLE_WITHIN(1e-2, 1000.0, plant.x.theta_m_rad);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, cos(e), plant.cosine_e);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, sin(e), plant.sine_e);
}

/* ---- gates off ------------------------------------------------------------------------------------------------------ */

/* Phases b and c carry the current against the whole dc link: 2 L di/dt = -Vdc - 2 R i, hence
 * i = (i0 + Vdc/2R) exp(-R t/L) - Vdc/2R until it is gone. Phase a has none and floats. */
void test_plant_gates_off_two_phases_conduct_against_the_dc_link_until_their_current_is_gone(void)
{
    model.rotor_locked = 1.0;
    model.ld_h = model.lq_h = 10e-3;
    model.substeps = 10.0;
    machine_start();
    plant.x.iq_a = 4.0 / (0.5 * SQRT3); /* on beta: i_b = 4 A, i_c = -4 A */
    const double tau = 10e-3 / 0.36;
    const double pull = 24.0 / 0.72;
    const double gone_s = tau * log(1.0 + 4.0 / pull);
    for (int k = 1; k <= 60; k++) {
        machine_coast(1);
        double i[3];
        sim_plant_phase_currents(&plant, i);
        const double t = 1e-4 * k;
        const double expected = (t < gone_s) ? (4.0 + pull) * exp(-t / tau) - pull : 0.0;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-9, 0.0, i[0], at("a, period %d", k));
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, expected, i[1], at("b, period %d", k));
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, -expected, i[2], at("c, period %d", k));
    }
}

/* The same while the rotor turns: 2 L di/dt = -Vdc - 2 R i - (e_b - e_c), and phase a lies at its own back-EMF. With
 * e_k = -we psi sin(theta_e - 2 pi k / 3) the difference e_b - e_c is sqrt(3) we psi cos(theta_e). Which phase floats does not
 * matter: everything is turned by a third of a turn for the next. */
void test_plant_gates_off_two_phases_conduct_against_the_back_emf_while_the_third_floats(void)
{
    for (int n = 0; n < 15; n++) {
        const int    floating = n % 3;
        const double ahead = 0.7 * n; /* of the rotor against the current vector, electrical */
        model.ld_h = model.lq_h = 10e-3;
        model.inertia_kgm2 = 1e3;
        model.initial_speed_rad_s = 200.0;
        model.initial_angle_rad = (ahead + TWO_PI / 3.0 * floating) / 4.0;
        model.substeps = 20.0;
        machine_start();
        const double amps = 4.0 / (0.5 * SQRT3); /* the next phase carries 4 A, the one after it -4 A */
        plant.x.id_a = amps * sin(ahead);
        plant.x.iq_a = amps * cos(ahead);
        double i_next = 4.0;
        double t = 0.0;
        for (int k = 1; k <= 20; k++) { /* a tenth of its life */
            machine_coast(1);
            for (int m = 0; m < 1000; m++) { /* midpoints: (1e-7 800)^2 of the back-EMF */
                const double e = SQRT3 * 800.0 * 6.4e-3 * cos(ahead + 800.0 * (t + 0.5e-7));
                i_next += 1e-7 * (-24.0 - 0.72 * i_next - e) / 20e-3;
                t += 1e-7;
            }
            double i[3];
            sim_plant_phase_currents(&plant, i);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-6, 0.0, i[floating], at("case %d, period %d", n, k));
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-5, i_next, i[(floating + 1) % 3], at("case %d, period %d", n, k));
        }
    }
}

/* Phase a carries in, b and c carry out: 2/3 Vdc against phase a, L di_a/dt = -2/3 Vdc - R i_a, while b and c share it as
 * they began, L d(i_b - i_c)/dt = -R (i_b - i_c). When b arrives at zero, a and c go on alone: 2 L di/dt = -Vdc - 2 R i. */
void test_plant_gates_off_three_phases_become_two_and_then_none(void)
{
    for (int n = 0; n < 12; n++) {
        const int    first = n % 3;
        const double rotor = 0.5 * n; /* locked anywhere: it does not matter */
        model.rotor_locked = 1.0;
        model.ld_h = model.lq_h = 10e-3;
        model.substeps = 10.0;
        model.initial_angle_rad = rotor / 4.0;
        machine_start();
        /* i_a = 5, i_b = -2.5 + 1, i_c = -2.5 - 1, for the first phase as a */
        const double length = hypot(5.0, 2.0 / SQRT3);
        const double angle = atan2(2.0 / SQRT3, 5.0) + TWO_PI / 3.0 * first - rotor;
        plant.x.id_a = length * cos(angle);
        plant.x.iq_a = length * sin(angle);
        const double tau = 10e-3 / 0.36;
        const double x1 = 16.0 / 0.36;
        const double x2 = 24.0 / 0.72;
        /* i_b = (-i_a + 2 decay) / 2 = 0 where (5 + x1) decay - x1 = 2 decay */
        const double t1 = tau * log((3.0 + x1) / x1);
        const double i1 = (5.0 + x1) * exp(-t1 / tau) - x1;
        const double t2 = t1 + tau * log(1.0 + i1 / x2);
        for (int k = 1; k <= 60; k++) {
            machine_coast(1);
            const double t = 1e-4 * k;
            const double decay = exp(-t / tau);
            const double i_a = (t < t1) ? (5.0 + x1) * decay - x1 : ((t < t2) ? (i1 + x2) * exp(-(t - t1) / tau) - x2 : 0.0);
            const double i_b = (t < t1) ? 0.5 * (2.0 * decay - i_a) : 0.0;
            double       i[3];
            sim_plant_phase_currents(&plant, i);
            /* the crossing is found on the tangent of a step of 10 us: (h / tau)^2 of it */
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, i_a, i[first], at("a, case %d, period %d", n, k));
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, i_b, i[(first + 1) % 3], at("b, case %d, period %d", n, k));
        }
    }
}

void test_plant_gates_off_every_current_dies_within_three_periods_and_stays_dead(void)
{
    for (int steps = 0; steps <= 8; steps += 2) {
        for (int k = 0; k < 24; k++) {
            model.substeps = steps;
            model.initial_speed_rad_s = (k % 3 - 1) * 200.0;
            model.initial_angle_rad = 0.21 * k;
            machine_start();
            plant.x.id_a = 6.0 * cos(TWO_PI / 24.0 * k);
            plant.x.iq_a = 6.0 * sin(TWO_PI / 24.0 * k);
            machine_coast(3); /* 6 A take 24 V / (1.5 L) 75 us alone */
            for (int n = 0; n < 200; n++) {
                TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(0.0, hypot(plant.x.id_a, plant.x.iq_a),
                                                 at("steps %d, case %d, period %d", steps, k, n));
                machine_coast(1);
            }
        }
    }
}

void test_plant_gates_off_the_rotor_coasts_without_electrical_torque(void)
{
    model.viscous_nms = 7.06e-4;
    model.initial_speed_rad_s = 300.0;
    machine_start();
    machine_coast(1000);

    /* the terminals follow the back-EMF in the middle of each step, not in every instant: 5e-4 of the speed in 0.1 s */
    ASSERT_REL(5e-4, 300.0 * exp(-1.0), plant.x.speed_rad_s, "0.1 s");
}

void test_plant_gates_off_diodes_return_energy_and_never_drive(void)
{
    machine_start();
    plant.x.iq_a = 5.0;
    machine_coast(5);
    const double kick = plant.x.speed_rad_s; /* the dying current still pushes a little: at most i kT L i / Vdc / J */
    TEST_ASSERT_TRUE((kick > 0.0) && (kick < 0.2));
    machine_coast(1000);

    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * kick, kick, plant.x.speed_rad_s);
}

/* ---- dc link -------------------------------------------------------------------------------------------------------- */

void test_plant_voltage_follows_the_dc_link_of_now(void)
{
    model.rotor_locked = 1.0;
    machine_start();
    double duty[3];
    machine_duties(1.8, 0.0, duty);
    plant.outside.dc_link_v = 12.0; /* half of what the duties were made for */
    for (int k = 0; k < 200; k++) {
        sim_plant_period(&plant, duty, true);
    }
    ASSERT_REL(1e-9, 2.5, plant.x.id_a, "half the current");
}

void test_plant_common_part_of_the_duties_has_no_effect(void)
{
    model.rotor_locked = 1.0;
    machine_start();
    const double all[3] = {0.9, 0.9, 0.9};
    for (int k = 0; k < 100; k++) {
        sim_plant_period(&plant, all, true);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, plant.x.id_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, plant.x.iq_a);
}

/* ---- start ---------------------------------------------------------------------------------------------------------- */

void test_plant_start_refuses_every_field_outside_its_range_by_name(void)
{
    for (int i = 0; i < sim_model_count(); i++) {
        const sim_field_t *const f = sim_model_info(i);
        const double             bad[] = {NAN, INFINITY, -INFINITY, nextafter(f->max, INFINITY), nextafter(f->min, -INFINITY)};
        for (size_t k = 0; k < COUNT_OF(bad); k++) {
            machine_defaults();
            *sim_model_at(&model, i) = bad[k];
            TEST_ASSERT_EQUAL_STRING(
                f->name, sim_plant_start(&plant, &model, (const double (*)[SIM_EFFECT_PARAMS])effect_values, 4000.0, 1U));
        }
        if (f->kind != SIM_REAL) {
            machine_defaults();
            *sim_model_at(&model, i) = f->min + 0.5;
            TEST_ASSERT_EQUAL_STRING(
                f->name, sim_plant_start(&plant, &model, (const double (*)[SIM_EFFECT_PARAMS])effect_values, 4000.0, 1U));
        }
    }
}

void test_plant_model_table_names_every_field_once_with_its_default_in_range(void)
{
    for (int i = 0; i < sim_model_count(); i++) {
        const sim_field_t *const f = sim_model_info(i);
        TEST_ASSERT_TRUE_MESSAGE(sim_field_accepts(f, f->def), f->name);
        TEST_ASSERT_TRUE_MESSAGE(strlen(f->doc) > 5U, f->name);
        for (int k = 0; k < i; k++) {
            TEST_ASSERT_TRUE_MESSAGE(strcmp(f->name, sim_model_info(k)->name) != 0, f->name);
        }
    }
    TEST_ASSERT_NULL(sim_model_info(-1));
    TEST_ASSERT_NULL(sim_model_info(sim_model_count()));
    TEST_ASSERT_EQUAL_INT((int)(sizeof(sim_model_t) / sizeof(double)), sim_model_count());
    TEST_ASSERT_EQUAL_PTR(&model.substeps, sim_model_at(&model, sim_model_count() - 1));
}

void test_plant_start_forgets_the_run_before(void)
{
    machine_start();
    const sim_plant_t fresh = plant;
    machine_dq_voltage(1.0, 5.0, 100);
    machine_start();

    TEST_ASSERT_EQUAL_MEMORY(&fresh, &plant, sizeof plant);
}
