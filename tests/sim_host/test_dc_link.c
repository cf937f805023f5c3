/* sim_host/plant/dc_link.c and its part of inverter.c: a capacitor behind a rectifier, against energies and closed forms. */
#include "tests/sim_host/support/machine.h"

#define CAPACITY_F 2.2e-3

void setUp(void)
{
    machine_defaults();
    model.viscous_nms = 0.0;
    model.dc_link_f = CAPACITY_F;
    model.supply_ohm = 0.1;
}
void tearDown(void) {}

static double volt(void) { return sim_plant_dc_link_v(&plant); }
static double stored_ws(void) { return 0.5 * CAPACITY_F * volt() * volt(); }
static double moving_ws(void) { return 0.5 * model.inertia_kgm2 * plant.x.speed_rad_s * plant.x.speed_rad_s; }
static double square_a2(void) { return plant.x.id_a * plant.x.id_a + plant.x.iq_a * plant.x.iq_a; }
static double winding_ws(void) { return 1.5 * 0.5 * model.ld_h * square_a2(); }

/* Nothing else takes or gives energy: what the shaft loses is in the resistance of the winding, or in the capacitor. */
void test_dc_link_takes_what_a_braking_motor_does_not_turn_into_heat(void)
{
    model.initial_speed_rad_s = 300.0;
    model.substeps = 4.0;
    machine_start();
    plant.outside.dc_link_v = 1.0; /* a source that has nothing to give */
    const double before = stored_ws() + moving_ws() + winding_ws();
    double       heat_ws = 0.0;
    for (int k = 0; k < 500; k++) {
        const double square = square_a2();
        const double emf_v = model.pole_pairs * plant.x.speed_rad_s * model.psi_wb;
        machine_dq_voltage(0.0, emf_v - 5.0 * model.resistance_ohm, 1);
        heat_ws += 1.5 * model.resistance_ohm * 0.5 * (square + square_a2()) * 1e-4;
    }
    TEST_ASSERT_TRUE_MESSAGE((volt() > 40.0) && (moving_ws() < 1.5), at("%g V, %g Ws", volt(), moving_ws()));
    ASSERT_REL(2e-3, before - heat_ws, stored_ws() + moving_ws() + winding_ws(), "energy");
}

/* A locked winding at 3.6 V takes 1.5 3.6 10 = 54 W: (24 - v) / 0.1 v = 54. The motor's voltage is the same on every dc link. */
void test_dc_link_falls_behind_the_resistance_of_its_supply(void)
{
    model.rotor_locked = 1.0;
    machine_start();
    machine_voltage(3.6, 0.0, 1);
    for (int k = 0; k < 2000; k++) {
        machine_voltage(3.6, 0.0, 1);
    }
    ASSERT_REL(1e-6, 12.0 + sqrt(144.0 - 5.4), volt(), "V");
    ASSERT_REL(1e-6, 10.0, plant.x.id_a, "A");
}

/* 22 periods are 10 time constants R C. */
void test_dc_link_is_charged_by_its_source_and_not_discharged(void)
{
    machine_start();
    plant.outside.dc_link_v = 30.0;
    for (int k = 1; k <= 22; k++) {
        machine_coast(1);
        ASSERT_REL(1e-12, 30.0 - 6.0 * exp(-1e-4 * k / (0.1 * CAPACITY_F)), volt(), at("period %d", k));
    }
    const double full = volt();
    plant.outside.dc_link_v = 10.0;
    machine_coast(1000);
    TEST_ASSERT_EQUAL_DOUBLE(full, volt());
    TEST_ASSERT_EQUAL_DOUBLE(full, plant.link_v); /* and the bridge has that voltage */
}

/* From 25 V at 10 A of the bridge to the source's 24 V in C 1 V / 10 A = 2.2 periods, then towards 24 - 0.1 10 with the time R C. */
void test_dc_link_passes_the_voltage_of_its_source_within_a_period(void)
{
    sim_dc_link_t link;
    sim_dc_link_start(&link, 25.0, CAPACITY_F, 0.1);
    link.taken_ws = 10.0 * 0.5 * (25.0 + 23.2) * 1e-3; /* about 10 A over 1 ms */
    sim_dc_link_period(&link, 24.0, 0.0, 1e-3);
    const double left_s = 1e-3 - 1.0 * CAPACITY_F / 10.0;
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 23.0 + exp(-left_s / (0.1 * CAPACITY_F)), link.volt_v);
}

/* sqrt(3) 4 700 6.4e-3 = 31.04 V between two terminals; at 500 rad/s it is 22.2 V and no diode conducts. */
void test_dc_link_is_charged_by_the_diodes_from_a_motor_that_turns_faster_than_it(void)
{
    model.inertia_kgm2 = 10.0;
    model.initial_speed_rad_s = 700.0;
    model.substeps = 20.0; /* of the tops of the six pulses, where the last of it comes from */
    machine_start();
    machine_coast(3000);
    TEST_ASSERT_TRUE_MESSAGE((volt() > 30.9) && (volt() < 31.05), at("%g V", volt()));

    model.initial_speed_rad_s = 500.0;
    machine_start();
    machine_coast(3000);
    TEST_ASSERT_EQUAL_DOUBLE(24.0, volt());
    TEST_ASSERT_EQUAL_DOUBLE(0.0, square_a2());

    model.dc_link_f = 0.0; /* stiff: not rectified */
    model.initial_speed_rad_s = 700.0;
    machine_start();
    machine_coast(3000);
    TEST_ASSERT_EQUAL_DOUBLE(24.0, volt());
    TEST_ASSERT_EQUAL_DOUBLE(0.0, square_a2());
}

/* Far below the motor's voltage all three phases conduct all the time: six steps of fundamental 2 / pi 10 V in phase with the current,
 * 2800 psi = 17.92 V = |6.37 + (0.36 + j 0.56) i|, which gives 20.5 A; its fifth and seventh are below a twentieth. */
void test_dc_link_far_below_the_motor_draws_a_current_of_three_phases(void)
{
    model.inertia_kgm2 = 10.0;
    model.initial_speed_rad_s = 700.0;
    model.dc_link_f = 100.0;
    model.dc_link_v = 10.0;
    model.substeps = 20.0;
    machine_start();
    machine_coast(100);
    double mean = 0.0;
    for (int k = 0; k < 900; k++) {
        machine_coast(1);
        mean += square_a2() / 900.0;
    }
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 20.5, sqrt(mean));
}

/* Six pulses a turn, 0.36 ohm: what the shaft loses is heat of the winding, or in the capacitor. */
void test_dc_link_energy_of_the_diodes_comes_from_the_shaft(void)
{
    model.initial_speed_rad_s = 700.0;
    model.inertia_kgm2 = 1e-3;
    model.substeps = 20.0;
    machine_start();
    const double before = stored_ws() + moving_ws();
    double       heat_ws = 0.0;
    for (int k = 0; k < 1000; k++) {
        const double square = square_a2();
        machine_coast(1);
        heat_ws += 1.5 * model.resistance_ohm * 0.5 * (square + square_a2()) * 1e-4;
    }
    const double gained = stored_ws() - 0.5 * CAPACITY_F * 24.0 * 24.0;
    TEST_ASSERT_TRUE_MESSAGE(gained > 0.3, at("%g Ws", gained));
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.03 * (gained + heat_ws), before - heat_ws, stored_ws() + moving_ws() + winding_ws(),
                                      at("gained %g, heat %g Ws", gained, heat_ws));
}

/* 10 A in the winding when the gates go off: 1.5/2 L i^2 = 15 mWs, less what its resistance takes. */
void test_dc_link_gets_the_energy_of_the_winding_when_the_gates_go_off(void)
{
    model.rotor_locked = 1.0;
    model.substeps = 20.0;
    machine_start();
    machine_voltage(3.6, 0.0, 200);
    plant.outside.dc_link_v = 1.0;
    const double before = stored_ws();
    const double most = winding_ws();
    machine_coast(50);
    TEST_ASSERT_TRUE_MESSAGE((stored_ws() > before + 0.7 * most) && (stored_ws() < before + most),
                             at("%g of %g mWs", 1e3 * (stored_ws() - before), 1e3 * most));
}
