/* Two masses and backlash against the closed solutions of a free pair of bodies. */
#include "tests/sim_host/support/machine.h"

#define J_KGM2 7.06e-5

static double ratio, omega; /* load_ratio and 2 pi f_res of the test */

void setUp(void)
{
    machine_defaults();
    model.viscous_nms = 0.0;
    /* a motor without torque (at 100 rad/s 2e-12 N m) that asks for one step per period: what the tests see is the shaft's */
    model.psi_wb = 1e-6;
    model.dc_link_v = 1e-3;
    model.resistance_ohm = 1e3;
    model.ld_h = 1.0;
    model.lq_h = 1.0;
}
void tearDown(void) {}

static void shaft(const char *effect, double f_res_hz, double load_ratio, double damping_ratio)
{
    machine_set(effect, "f_res_hz", f_res_hz);
    machine_set(effect, "load_ratio", load_ratio);
    machine_set(effect, "damping_ratio", damping_ratio);
    ratio = load_ratio;
    omega = TWO_PI * f_res_hz;
}

static double momentum(void) { return (1.0 - ratio) * plant.x.speed_rad_s + ratio * plant.load.speed_rad_s; }

/* ---- two_mass --------------------------------------------------------------------------------------------------------- */

/* A torque on the load: both move on with T/J, and twist' = T/(r J) exp(-zeta w t) sin(wd t)/wd.
 * rotor = common + r twist', load = common - (1 - r) twist' */
static void assert_answer_to_a_load_step(double f_res_hz, double load_ratio, double damping_ratio, double tolerance)
{
    const double torque = 0.1;
    shaft("two_mass", f_res_hz, load_ratio, damping_ratio);
    machine_start();
    plant.outside.load_torque_nm = torque;
    const double wd = omega * sqrt(1.0 - damping_ratio * damping_ratio);
    for (int k = 1; k <= 300; k++) {
        machine_voltage(0.0, 0.0, 1);
        const double t = 1e-4 * k;
        const double common = -torque / J_KGM2 * t;
        const double swing = torque / (ratio * J_KGM2) * exp(-damping_ratio * omega * t) * sin(wd * t) / wd;
        const double size = torque / (ratio * J_KGM2) / omega * tolerance;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(size, common + ratio * swing, plant.x.speed_rad_s, at("rotor, %d", k));
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(size, common - (1.0 - ratio) * swing, plant.load.speed_rad_s, at("load, %d", k));
    }
}

/* steps of at most 0.3 rad: phase error 0.3^4 / 120 per rad, over the 30 ms 38 to 940 rad, the lower damping for longer */
void test_two_mass_swings_free_at_its_resonance_and_keeps_the_total_inertia(void)
{
    assert_answer_to_a_load_step(200.0, 0.3, 0.0, 1e-4);
    assert_answer_to_a_load_step(200.0, 0.8, 0.1, 1e-4);
    assert_answer_to_a_load_step(1500.0, 0.5, 0.02, 3e-3);
    assert_answer_to_a_load_step(5000.0, 0.2, 0.02, 3e-3);
}

/* With the rotor held the load swings at the antiresonance, w sqrt(1 - r). */
void test_two_mass_friction_holds_the_rotor_and_the_load_swings_at_the_antiresonance(void)
{
    machine_set("coulomb_friction", "torque_nm", 10.0);
    shaft("two_mass", 120.0, 0.4, 0.0);
    machine_start();
    plant.outside.load_torque_nm = 0.1;
    const double wa = omega * sqrt(0.6);
    for (int k = 1; k <= 500; k++) {
        machine_voltage(0.0, 0.0, 1);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.x.speed_rad_s);
        const double load = -0.1 / (0.4 * J_KGM2) / wa * sin(wa * 1e-4 * k);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, load, plant.load.speed_rad_s); /* of 6 rad/s */
    }
}

/* With the load held the rotor swings at w sqrt(r). */
void test_two_mass_brake_holds_the_load_and_the_rotor_swings(void)
{
    shaft("two_mass", 120.0, 0.4, 0.0);
    machine_start();
    plant.outside.load_brake_nm = 10.0;
    plant.x.speed_rad_s = 5.0;
    const double wr = omega * sqrt(0.4);
    for (int k = 1; k <= 500; k++) {
        machine_voltage(0.0, 0.0, 1);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.load.speed_rad_s);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 5.0 * cos(wr * 1e-4 * k), plant.x.speed_rad_s);
    }
}

void test_two_mass_brake_stops_the_load_without_turning_it_back(void)
{
    shaft("two_mass", 120.0, 0.5, 0.3);
    model.initial_speed_rad_s = 20.0;
    machine_start();
    plant.outside.load_brake_nm = 0.1;
    for (int k = 0; k < 1000; k++) {
        machine_voltage(0.0, 0.0, 1);
        TEST_ASSERT_TRUE(plant.load.speed_rad_s >= 0.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0,
                              plant.x.speed_rad_s); /* 20 / (0.1 / J) = 14 ms, then it swings out with zeta r w = 113 1/s */
    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.load.speed_rad_s);
}

void test_two_mass_viscous_friction_acts_on_the_rotor(void)
{
    model.viscous_nms = 1e-4;
    shaft("two_mass", 300.0, 0.5, 0.5);
    machine_start();
    plant.outside.load_torque_nm = -0.01;
    machine_voltage(0.0, 0.0, 100000); /* 10 s, 14 time constants J/B */
    ASSERT_REL(1e-5, 100.0, plant.x.speed_rad_s, "T / B");
    /* the shaft carries all of it: twist = -T / k, k = r (1 - r) J w^2 */
    ASSERT_REL(1e-5, 0.01 / (0.25 * J_KGM2 * omega * omega), -plant.load.twist_rad, "twist");
}

/* With the load driven at T and T/B, the shaft carries what the rotor alone loses. */
void test_two_mass_and_backlash_share_the_viscous_friction_between_rotor_and_load(void)
{
    static const char *const effects[] = {"two_mass", "backlash"};
    for (int k = 0; k < 2; k++) {
        setUp();
        model.viscous_nms = 1e-4;
        shaft(effects[k], 300.0, 0.5, 0.5);
        machine_set(effects[k], "load_friction_share", 0.7);
        machine_start();
        plant.outside.load_torque_nm = -0.01;
        machine_voltage(0.0, 0.0, 100000); /* 10 s, 14 time constants J/B */
        ASSERT_REL(1e-5, 100.0, plant.x.speed_rad_s, "T / B of both");
        ASSERT_REL(1e-4, 0.3 * 0.01 / (0.25 * J_KGM2 * omega * omega), -plant.load.twist_rad, "twist");
    }
}

void test_two_mass_hidden_load_torque_acts_on_the_load_and_cogging_on_the_rotor(void)
{
    shaft("two_mass", 50.0, 0.5, 0.0);
    machine_set("load_torque", "torque_nm", 0.1);
    machine_start();
    machine_voltage(0.0, 0.0, 1);
    ASSERT_REL(1e-2, -0.1 / (0.5 * J_KGM2) * 1e-4, plant.load.speed_rad_s, "load moves first");
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, plant.x.speed_rad_s);

    machine_set("load_torque", "torque_nm", 0.0);
    machine_set("cogging", "amplitude_nm", -0.1);
    machine_set("cogging", "phase_rad", 0.5 * PI);
    machine_set("cogging", "order", 1.0);
    machine_start();
    machine_voltage(0.0, 0.0, 1);
    ASSERT_REL(1e-2, 0.1 / (0.5 * J_KGM2) * 1e-4, plant.x.speed_rad_s, "rotor moves first");
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, plant.load.speed_rad_s);
}

void test_two_mass_without_load_or_resonance_is_one_piece(void)
{
    shaft("two_mass", 200.0, 0.0, 0.1);
    machine_start();
    TEST_ASSERT_FALSE(plant.coupling.on);
    shaft("two_mass", 0.0, 0.4, 0.1);
    machine_start();
    TEST_ASSERT_FALSE(plant.coupling.on);
    plant.outside.load_torque_nm = -0.0706;
    machine_voltage(0.0, 0.0, 100);
    ASSERT_REL(1e-9, 10.0, plant.x.speed_rad_s, "1000 rad/s^2");
    TEST_ASSERT_EQUAL_DOUBLE(plant.x.speed_rad_s, sim_plant_load_speed(&plant));
}

void test_two_mass_inertia_factor_is_that_of_the_total(void)
{
    shaft("two_mass", 200.0, 0.4, 1.0);
    machine_set("inertia", "factor", 2.0);
    machine_start();
    plant.outside.load_torque_nm = -0.0706;
    machine_voltage(0.0, 0.0, 1000);
    ASSERT_REL(1e-9, 50.0, momentum(), "half of 1000 rad/s^2");
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, omega, plant.coupling.resonance_rad_s);
}

/* ---- backlash --------------------------------------------------------------------------------------------------------- */

#define GAP_RAD 0.02
#define SPEED_RAD_S 10.0

/* Rotor moves, load rests, in the middle of the play: contact after 1 ms. */
static void start_rotor_alone(double damping_ratio)
{
    machine_set("backlash", "gap_rad", GAP_RAD);
    shaft("backlash", 1000.0, 0.3, damping_ratio);
    machine_start();
    plant.x.speed_rad_s = SPEED_RAD_S;
}

void test_backlash_lets_the_rotor_run_free_within_the_play(void)
{
    start_rotor_alone(0.1);
    for (int k = 1; k <= 9; k++) {
        machine_voltage(0.0, 0.0, 1);
        TEST_ASSERT_EQUAL_DOUBLE(SPEED_RAD_S, plant.x.speed_rad_s);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.load.speed_rad_s);
        TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1e-3 * k, plant.load.twist_rad);
    }
    machine_voltage(0.0, 0.0, 3);
    TEST_ASSERT_TRUE(plant.load.speed_rad_s > 0.1);
}

/* Without damping the two bounce off as billiard balls do: the relative speed turns round. Contact lasts half a period, 0.5 ms. */
void test_backlash_without_damping_bounces_with_all_its_energy(void)
{
    start_rotor_alone(0.0);
    const double common = 0.7 * SPEED_RAD_S;
    machine_voltage(0.0, 0.0, 20); /* 2 ms: after the first bounce, which ends at 1.5 ms */
    /* a flank is met up to 1e-4 of a step late: 0.2 rad of the swing times that; and RK4 loses 0.2^6/144 in 15 steps */
    ASSERT_REL(1e-4, common - 0.3 * SPEED_RAD_S, plant.x.speed_rad_s, "rotor");
    ASSERT_REL(1e-4, common + 0.7 * SPEED_RAD_S, plant.load.speed_rad_s, "load");
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.5 * GAP_RAD - SPEED_RAD_S * 0.5e-3, plant.load.twist_rad);
    machine_voltage(0.0, 0.0, 25); /* 4.5 ms: contact with the other flank from 3.5 to 4 ms */
    ASSERT_REL(2e-4, SPEED_RAD_S, plant.x.speed_rad_s, "rotor again");
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.0, plant.load.speed_rad_s);
}

/* A damped spring that cannot pull (Schwager and Poeschel 2007): e = exp(-b/wd (pi - atan(2 b wd / (wd^2 - b^2)))),
 * b = zeta w: the contact ends where the force is zero. */
void test_backlash_with_damping_bounces_with_the_restitution_of_a_spring_that_never_pulls(void)
{
    const double zeta[] = {0.05, 0.2, 0.5};
    for (size_t k = 0; k < COUNT_OF(zeta); k++) {
        start_rotor_alone(zeta[k]);
        machine_voltage(0.0, 0.0, 20);
        const double b = zeta[k];
        const double wd = sqrt(1.0 - b * b);
        const double restitution = exp(-b / wd * (PI - atan2(2.0 * b * wd, wd * wd - b * b)));
        ASSERT_REL(1e-3, -restitution * SPEED_RAD_S, plant.x.speed_rad_s - plant.load.speed_rad_s, at("zeta %g", b));
    }
}

void test_backlash_conserves_momentum_and_never_gains_energy(void)
{
    start_rotor_alone(0.1);
    double before = SPEED_RAD_S;
    for (int k = 0; k < 3000; k++) {
        machine_voltage(0.0, 0.0, 1);
        ASSERT_REL(1e-9, 0.7 * SPEED_RAD_S, momentum(), at("period %d", k));
        const double apart = fabs(plant.load.twist_rad) - 0.5 * GAP_RAD;
        const double relative = plant.x.speed_rad_s - plant.load.speed_rad_s;
        const double stored = (apart > 0.0) ? omega * apart : 0.0;
        const double energy = sqrt(relative * relative + stored * stored); /* as a speed; 1 / mu left out */
        TEST_ASSERT_TRUE_MESSAGE(energy <= before * (1.0 + 1e-6) + 1e-9, at("period %d: %g, %g", k, energy, before));
        before = energy;
    }
    TEST_ASSERT_TRUE(before < 0.2 * SPEED_RAD_S);
}

/* Under a torque that keeps its sign the flank stays closed and rotor and load go on together. */
void test_backlash_under_load_moves_as_one_piece(void)
{
    machine_set("backlash", "gap_rad", GAP_RAD);
    shaft("backlash", 1000.0, 0.3, 0.1);
    machine_start();
    plant.outside.load_torque_nm = 0.05;
    machine_voltage(0.0, 0.0, 10000);
    const double speed = -0.05 / J_KGM2 * 1.0;
    ASSERT_REL(1e-9, speed, momentum(), "T / J");
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, plant.load.speed_rad_s, plant.x.speed_rad_s);
    /* pulled by the load: twist = gap/2 and what the shaft gives under (1 - r) T */
    ASSERT_REL(1e-6, 0.5 * GAP_RAD + 0.7 * 0.05 / (0.21 * J_KGM2 * omega * omega), plant.load.twist_rad, "twist");
}

/* There is one shaft: which of two resonances it has is not for the order of the files to decide. */
void test_backlash_and_two_mass_are_refused_together(void)
{
    machine_set("backlash", "gap_rad", GAP_RAD);
    shaft("backlash", 1000.0, 0.3, 0.1);
    shaft("two_mass", 200.0, 0.6, 0.02);
    TEST_ASSERT_EQUAL_STRING("two_mass", machine_try_start());
}

void test_backlash_on_a_locked_rotor_costs_nothing(void)
{
    model.rotor_locked = 1.0;
    machine_set("backlash", "gap_rad", GAP_RAD);
    machine_start();
    TEST_ASSERT_EQUAL_INT(SIM_PLAIN, plant.kind);
    TEST_ASSERT_EQUAL_INT(1, plant.substeps);
}

/* Chatter in a tiny play must not eat time. */
void test_backlash_of_almost_nothing_keeps_the_time_and_the_momentum(void)
{
    machine_set("backlash", "gap_rad", 1e-7);
    shaft("backlash", 3000.0, 0.3, 0.0);
    machine_start();
    plant.x.speed_rad_s = SPEED_RAD_S;
    machine_voltage(0.0, 0.0, 1000);
    ASSERT_REL(1e-9, 0.7 * SPEED_RAD_S * 0.1, plant.x.theta_m_rad - 0.3 * plant.load.twist_rad, "centre of mass");
    ASSERT_REL(1e-9, 0.7 * SPEED_RAD_S, momentum(), "speed");
}
