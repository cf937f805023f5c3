/* Delay, current filter and saturation on a locked or driven machine, against solutions that can be written down. */
#include <complex.h>

#include "tests/sim_host/support/machine.h"

#define R_OHM 0.36
#define L_H 0.2e-3
#define PERIOD_S 1e-4

void setUp(void)
{
    machine_defaults();
    model.viscous_nms = 0.0;
    model.rotor_locked = 1.0;
    model.substeps = 10.0; /* (0.018)^5 / 120 per step: the tests see the effect, not the integration */
}
void tearDown(void) {}

/* ---- current_loop_delay ----------------------------------------------------------------------------------------------- */

static double step_answer(double t) { return (t > 0.0) ? 1.8 / R_OHM * (1.0 - exp(-R_OHM / L_H * t)) : 0.0; }

void test_delay_shifts_the_answer_of_a_coil_by_whole_and_broken_periods(void)
{
    const double extra[] = {0.01, 0.5, 1.0, 1.3, 2.0, 3.75, 8.0};
    for (size_t e = 0; e < COUNT_OF(extra); e++) {
        machine_set("current_loop_delay", "extra_periods", extra[e]);
        machine_start();
        for (int k = 1; k <= 40; k++) {
            machine_voltage((k <= 20) ? 1.8 : 0.0, 0.0, 1);
            const double t = PERIOD_S * (k - extra[e]);
            const double wanted = step_answer(t) - step_answer(t - 20.0 * PERIOD_S);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(5e-9, wanted, plant.x.id_a, at("%g periods, after %d", extra[e], k));
        }
    }
}

void test_delay_is_continuous_where_it_passes_a_whole_number(void)
{
    double current[3];
    for (int k = 0; k < 3; k++) {
        machine_set("current_loop_delay", "extra_periods", 2.0 + 1e-7 * (k - 1));
        machine_start();
        machine_voltage(1.8, 0.0, 4);
        current[k] = plant.x.id_a;
    }
    const double slope = 1.8 / L_H * exp(-R_OHM / L_H * 2e-4) * PERIOD_S * 1e-7; /* 5.8e-8 A */
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * slope, slope, current[0] - current[1]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * slope, slope, current[1] - current[2]);
}

void test_delay_leaves_time_and_shaft_where_they_are(void)
{
    model.rotor_locked = 0.0;
    model.psi_wb = 0.0;
    model.initial_speed_rad_s = 50.0;
    machine_set("current_loop_delay", "extra_periods", 1.4);
    machine_start();
    machine_voltage(0.0, 0.0, 1000);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.1, plant.time_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 5.0, plant.x.theta_m_rad);
}

/* ---- current_filter ---------------------------------------------------------------------------------------------------- */

static double read_a(void)
{
    sim_reading_t r;
    sim_plant_read(&plant, &r);
    return r.ia_a;
}

/* i = v/R (1 - exp(-t/te)) behind tau: v/R (1 - (te exp(-t/te) - tau exp(-t/tau)) / (te - tau)) */
void test_current_filter_answers_a_step_as_two_time_constants_in_series(void)
{
    const double tau[] = {1e-7, 1e-5, 5e-5, 3e-4, 1e-3, 0.1};
    const double te = L_H / R_OHM;
    for (size_t n = 0; n < COUNT_OF(tau); n++) {
        machine_set("current_filter", "tau_s", tau[n]);
        machine_start();
        for (int k = 1; k <= 50; k++) {
            machine_voltage(1.8, 0.0, 1);
            const double t = PERIOD_S * k;
            const double seen = 5.0 * (1.0 - (te * exp(-t / te) - tau[n] * exp(-t / tau[n])) / (te - tau[n]));
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-8, seen, read_a(), at("tau %g s, period %d", tau[n], k));
            TEST_ASSERT_DOUBLE_WITHIN(1e-8, step_answer(t), plant.x.id_a); /* the current itself is what it is */
        }
    }
}

/* A constant vector in a turning rotor: the filter sees its electrical frequency, 1 / (1 + j w tau). */
void test_current_filter_turns_and_shortens_a_rotating_current(void)
{
    model.rotor_locked = 0.0;
    model.inertia_kgm2 = 1e3;
    model.initial_speed_rad_s = 200.0;
    model.substeps = 20.0;
    machine_set("current_filter", "tau_s", 4e-4);
    machine_start();
    machine_voltage(0.0, 0.0, 300); /* shorted: 54 electrical time constants, 75 of the filter */
    const double         we = 4.0 * plant.x.speed_rad_s;
    const double complex i = (plant.x.id_a + I * plant.x.iq_a) * cexp(I * 4.0 * plant.x.theta_m_rad);
    const double complex seen = i / (1.0 + I * we * 4e-4);
    sim_reading_t        r;
    sim_plant_read(&plant, &r);
    TEST_ASSERT_TRUE(cabs(i) > 3.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, creal(seen), r.ia_a);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -0.5 * creal(seen) + 0.5 * SQRT3 * cimag(seen), r.ib_a);
}

/* One step per period is what the nominal machine gets: 0.18 of a time constant, cubic error (0.18)^4 / 384. */
void test_current_filter_needs_no_finer_steps_than_the_machine(void)
{
    model.substeps = 0.0;
    machine_set("current_filter", "tau_s", 1e-5);
    machine_start();
    machine_voltage(1.8, 0.0, 1);
    const double te = L_H / R_OHM;
    const double seen = 5.0 * (1.0 - (te * exp(-1e-4 / te) - 1e-5 * exp(-10.0)) / (te - 1e-5));
    ASSERT_REL(2e-5, seen, read_a(), "after one period");
}

void test_current_filter_lies_before_gain_offset_and_rounding(void)
{
    machine_set("current_filter", "tau_s", 1e-3);
    machine_set("current_gain", "gain_a", 1.1);
    machine_set("current_offset", "offset_a_a", 0.2);
    machine_start();
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.2, read_a()); /* the offset is there from the start */
    machine_voltage(1.8, 0.0, 500);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 5.0 * 1.1 + 0.2, read_a());
}

void test_current_filter_follows_the_current_down_with_the_gates_off(void)
{
    machine_set("current_filter", "tau_s", 1e-4);
    machine_start();
    machine_voltage(1.8, 0.0, 200);
    machine_coast(5); /* 12 V against 5 A: gone within 0.1 ms */
    TEST_ASSERT_EQUAL_DOUBLE(0.0, plant.x.id_a);
    const double left = read_a();
    TEST_ASSERT_TRUE((left > 0.0) && (left < 5.0 * exp(-3.0)));
    machine_coast(10);
    ASSERT_REL(1e-9, left * exp(-10.0), read_a(), "ten time constants later");
}

/* ---- inductance_saturation --------------------------------------------------------------------------------------------- */

/* Without resistance the flux linkage is v t, so that i = i_sat tan(v t / (L i_sat)). */
void test_saturation_current_rises_as_the_tangent_of_the_volt_seconds(void)
{
    model.resistance_ohm = 1e-4; /* takes 1e-3 V of 0.9 V at 10 A */
    model.lq_h = 0.5e-3;
    machine_set("inductance_saturation", "i_sat_a", 8.0);
    machine_start();
    for (int k = 1; k <= 15; k++) {
        machine_voltage(0.9, -0.9, 1);
        const double vt = 0.9 * PERIOD_S * k;
        ASSERT_REL(2e-3, 8.0 * tan(vt / (L_H * 8.0)), plant.x.id_a, at("d, period %d", k));
        ASSERT_REL(2e-3, -8.0 * tan(vt / (0.5e-3 * 8.0)), plant.x.iq_a, at("q, period %d", k));
    }
    TEST_ASSERT_TRUE(plant.x.id_a > 8.0);
}

void test_saturation_ends_at_the_same_current_as_without(void)
{
    model.substeps = 0.0;
    machine_set("inductance_saturation", "i_sat_a", 2.0);
    machine_start();
    machine_voltage(7.2, 0.0, 400); /* 20 A: ten times i_sat */
    ASSERT_REL(1e-9, 20.0, plant.x.id_a, "v / R");
}

/* T = 1.5 p ((psi + psi_d) iq - psi_q id) */
void test_saturation_makes_the_reluctance_torque_of_its_flux_linkages(void)
{
    model.ld_h = 0.3e-3;
    model.lq_h = 0.6e-3;
    machine_set("inductance_saturation", "i_sat_a", 6.0);
    machine_start();
    plant.x.id_a = -4.0;
    plant.x.iq_a = 9.0;
    (void)read_a();
    const double d = 0.3e-3 * 6.0 * atan(-4.0 / 6.0);
    const double q = 0.6e-3 * 6.0 * atan(9.0 / 6.0);
    ASSERT_REL(1e-12, 6.0 * ((6.4e-3 + d) * 9.0 - q * -4.0), sim_plant_torque(&plant), "torque");
}

/* Steady state at speed: vd = R id - we psi_q(iq), vq = R iq + we (psi + psi_d(id)). */
void test_saturation_makes_the_cross_coupling_of_its_flux_linkages(void)
{
    model.rotor_locked = 0.0;
    model.inertia_kgm2 = 1e3;
    model.initial_speed_rad_s = 100.0;
    model.substeps = 20.0;
    model.pwm_hz = 200e3; /* the voltage turns with the rotor */
    machine_set("inductance_saturation", "i_sat_a", 6.0);
    machine_start();
    const double we = 400.0;
    const double q = L_H * 6.0 * atan(9.0 / 6.0);
    const double d = L_H * 6.0 * atan(3.0 / 6.0);
    const double half = 0.5 * we / model.pwm_hz; /* the vector stands during a period, its middle is what counts */
    const double vd = 0.36 * 3.0 - we * q;
    const double vq = 0.36 * 9.0 + we * (6.4e-3 + d);
    machine_dq_voltage(vd * cos(half) - vq * sin(half), vd * sin(half) + vq * cos(half), 10000);
    ASSERT_REL(1e-3, 3.0, plant.x.id_a, "id");
    ASSERT_REL(1e-3, 9.0, plant.x.iq_a, "iq");
}

void test_saturation_linkage_is_odd_and_its_slope_the_differential_inductance(void)
{
    const sim_effect_t *const e = sim_effects[machine_effect("inductance_saturation")];
    const double              own[3] = {3.0, 0.0, 0.0};
    for (double i = -60.0; i <= 60.0; i += 0.7) { /* beyond 30 A the slope stays at 1 % */
        double       slope, ignored;
        const double h = 1e-5;
        (void)e->linkage_wb(own, L_H, i, 5.0, &slope);
        const double rise = e->linkage_wb(own, L_H, i + h, 5.0, &ignored) - e->linkage_wb(own, L_H, i - h, 5.0, &ignored);
        const double wanted = L_H / (1.0 + i * i / 9.0);
        ASSERT_REL(1e-12, (wanted > 0.01 * L_H) ? wanted : 0.01 * L_H, slope, at("slope at %g A", i));
        ASSERT_REL(1e-5, slope, rise / (2.0 * h), at("difference at %g A", i));
        const double mixed[3] = {3.0, 0.3, 0.6};
        (void)e->linkage_wb(mixed, L_H, i, 5.0, &slope);
        TEST_ASSERT_EQUAL_DOUBLE(slope, e->slope_h(mixed, L_H, i, 5.0)); /* alone it is the same */
        TEST_ASSERT_EQUAL_DOUBLE(-e->linkage_wb(own, L_H, i, 5.0, &ignored), e->linkage_wb(own, L_H, -i, 5.0, &ignored));
    }
}

/* The slope is that of the integral, the torque that of the lowered inductances: L / (1 + 16/36) and L / (1 + 81/36). */
void test_saturation_by_slope_lowers_the_reluctance_torque_of_each_axis(void)
{
    model.ld_h = 0.3e-3;
    model.lq_h = 0.6e-3;
    machine_set("inductance_saturation", "i_sat_a", 6.0);
    machine_set("inductance_saturation", "by_slope", 1.0);
    machine_start();
    plant.x.id_a = -4.0;
    plant.x.iq_a = 9.0;
    (void)read_a();
    const double ld_h = 0.3e-3 / (1.0 + 16.0 / 36.0);
    const double lq_h = 0.6e-3 / (1.0 + 81.0 / 36.0);
    ASSERT_REL(1e-12, 6.0 * (6.4e-3 * 9.0 + (ld_h - lq_h) * -36.0), sim_plant_torque(&plant), "torque");
}

void test_saturation_by_slope_steps_as_the_integral_does(void)
{
    double after[2];
    for (int by_slope = 0; by_slope < 2; by_slope++) {
        machine_set("inductance_saturation", "i_sat_a", 6.0);
        machine_set("inductance_saturation", "by_slope", by_slope);
        machine_start();
        machine_voltage(2.0, -1.0, 5);
        after[by_slope] = plant.x.iq_a;
        TEST_ASSERT_TRUE(fabs(plant.x.id_a) > 1.0);
    }
    TEST_ASSERT_EQUAL_DOUBLE(after[0], after[1]);
}

static void start_by_amplitude(double i_sat_a)
{
    model.ld_h = 0.3e-3;
    model.lq_h = 0.6e-3;
    machine_set("inductance_saturation", "i_sat_a", i_sat_a);
    machine_set("inductance_saturation", "by_amplitude", 1.0);
    machine_start();
}

/* 1 V against L / (1 + 3^2 + 4^2 over 5^2) = L / 2, whichever axis carries which part of the 5 A. */
void test_saturation_by_amplitude_lowers_both_axes_alike(void)
{
    for (int swap = 0; swap < 2; swap++) {
        model.resistance_ohm = 1e-4;
        start_by_amplitude(5.0);
        const double id = swap ? 4.0 : 3.0;
        const double iq = swap ? 3.0 : 4.0;
        plant.x.id_a = id;
        plant.x.iq_a = iq;
        machine_voltage(0.001, 0.001, 1); /* moves 0.7 mA */
        ASSERT_REL(1e-3, (0.001 - 1e-4 * id) * PERIOD_S / 0.15e-3, plant.x.id_a - id, "d");
        ASSERT_REL(1e-3, (0.001 - 1e-4 * iq) * PERIOD_S / 0.3e-3, plant.x.iq_a - iq, "q");
    }
}

/* T = 1.5 p (psi iq + (Ld - Lq) id iq) with the lowered inductances: 16 + 81 over 36 */
void test_saturation_by_amplitude_lowers_the_reluctance_torque(void)
{
    start_by_amplitude(6.0);
    plant.x.id_a = -4.0;
    plant.x.iq_a = 9.0;
    (void)read_a();
    const double soft = 1.0 / (1.0 + 97.0 / 36.0);
    ASSERT_REL(1e-12, 6.0 * (6.4e-3 * 9.0 + -0.3e-3 * soft * -36.0), sim_plant_torque(&plant), "torque");
}

void test_saturation_by_amplitude_ends_at_the_same_current_as_without(void)
{
    model.substeps = 0.0;
    start_by_amplitude(2.0);
    machine_voltage(7.2, -3.6, 800); /* 22 A: the inductance rests at 1 % */
    ASSERT_REL(1e-9, 20.0, plant.x.id_a, "d: v / R");
    ASSERT_REL(1e-9, -10.0, plant.x.iq_a, "q: v / R");
}

void test_saturation_stays_finite_however_small_its_current(void)
{
    model.substeps = 0.0;
    machine_set("inductance_saturation", "i_sat_a", 1e-6);
    machine_start();
    for (int k = 0; k < 200; k++) {
        machine_voltage((k % 7 < 3) ? 12.0 : -12.0, 5.0, 1);
        TEST_ASSERT_TRUE(fabs(plant.x.id_a) < 12.0 / R_OHM + 1e-6);
    }
}
