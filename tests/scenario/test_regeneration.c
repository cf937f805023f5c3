/* A motor with a flywheel brakes into a dc link whose supply takes nothing back: what happens without and with a limit. */
#include "tests/scenario/support/rig.h"

#define STOPS_S 1.6
#define TRIPS_V 40.0 /* over_voltage_v by default */

/* 1e-3 kg m2 at 450 rad/s are 101 Ws; 2.2 mF take 1.1 Ws from 24 to 40 V. The filter is that of the board for the F28379D. */
void setUp(void)
{
    rig_new();
    rig_model("inertia_kgm2", 1e-3);
    rig_param("speed_kp_a_per_unit", 0.5); /* 14 times that of the defaults, as the inertia is */
    rig_model("dc_link_f", 2.2e-3);
    rig_model("vdc_filter_hz", 345.0);
    rig_step("speed_ref_rad_s", 450.0, STOPS_S, 0.0);
}
void tearDown(void) { rig_free(); }

static double largest_v;

/* To the stop, and so long after it; largest_v is the true dc link meanwhile. */
static void brake_for(double seconds)
{
    rig_start();
    rig_run((int64_t)(1e4 * STOPS_S));
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 450.0, rig_read("true_speed_rad_s"));
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    largest_v = 0.0;
    for (int64_t k = 0; k < (int64_t)(1e4 * seconds); k++) {
        rig_run(1);
        largest_v = fmax(largest_v, rig_read("true_dc_link_v"));
    }
}

/* 10 A of 0.0384 N m/A at 450 rad/s are 173 W, 54 W of them heat in the winding: 1.8 V in 1 ms. */
void test_regeneration_of_a_flywheel_trips_the_drive_without_a_limit(void)
{
    brake_for(0.05);
    TEST_ASSERT_EQUAL_STRING("over_voltage", rig_fault());
    TEST_ASSERT_TRUE_MESSAGE(largest_v > TRIPS_V, at("%g V", largest_v));
}

void test_regeneration_limit_keeps_the_dc_link_below_its_end_and_the_drive_running(void)
{
    rig_param("regeneration_limit_v", 36.0);
    brake_for(0.5);
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    TEST_ASSERT_TRUE_MESSAGE((largest_v > 33.0) && (largest_v < 36.5), at("%g V", largest_v));
    TEST_ASSERT_EQUAL_DOUBLE(4.0, rig_read("state"));
    /* the winding takes what is left of the braking: the shaft turns on, slower by what it lost until the capacitor was full */
    TEST_ASSERT_TRUE_MESSAGE(rig_read("true_speed_rad_s") > 400.0, at("%g rad/s", rig_read("true_speed_rad_s")));
}

/* A load brakes it to where 10 A are heat in the winding, 112 rad/s; from there it stops within 0.1 Nm.. */
void test_regeneration_limit_stops_a_shaft_that_a_load_has_braked(void)
{
    rig_param("regeneration_limit_v", 36.0);
    rig_step("load_brake_nm", 0.0, STOPS_S, 0.2);
    brake_for(3.0);
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    TEST_ASSERT_TRUE_MESSAGE(largest_v < 36.5, at("%g V", largest_v));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 0.0, rig_read("true_speed_rad_s"));
}

/* 119 W at 4 ohm are an on-time of 0.56, at 29.56 V; until the first of it acts the voltage rises for 1 ms, by 1.9 V at most. All of the
 * 101 Ws but what the winding takes go into the resistor. */
void test_regeneration_into_a_brake_resistor_stops_the_flywheel_within_the_time_of_its_torque(void)
{
    rig_model("brake_ohm", 4.0);
    rig_param("chopper_v", 29.0);
    rig_param("chopper_ohm", 4.0);
    rig_param("chopper_continuous_w", 20.0);
    rig_param("chopper_thermal_s", 30.0);
    brake_for(1.6); /* 450 rad/s at 0.384 N m are 1.17 s */
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    TEST_ASSERT_TRUE_MESSAGE((largest_v > 29.0) && (largest_v < 31.5), at("%g V", largest_v));
    TEST_ASSERT_DOUBLE_WITHIN(1.0, 0.0, rig_read("true_speed_rad_s"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_read("true_brake_w"));
    /* heat of the energy E: E / (20 W 30 s); 101 Ws less the 36 to 64 Ws in the winding, and 1.5 s of cooling at most */
    const double warm = rig_read("chopper_heat");
    TEST_ASSERT_TRUE_MESSAGE((warm > 0.055) && (warm < 0.11), at("heat %g", warm));
}

void test_regeneration_into_a_brake_resistor_that_is_too_small_trips_by_its_name(void)
{
    rig_model("brake_ohm", 4.0);
    rig_param("chopper_v", 29.0);
    rig_param("chopper_ohm", 4.0);
    rig_param("chopper_continuous_w", 10.0);
    rig_param("chopper_thermal_s", 1.0);
    brake_for(0.5);
    TEST_ASSERT_EQUAL_STRING("brake_overload", rig_fault());
    TEST_ASSERT_TRUE_MESSAGE(largest_v < 31.5, at("%g V", largest_v));
}

void test_regeneration_of_a_board_without_resistor_is_refused_a_chopper(void)
{
    rig_param("chopper_v", 29.0);
    TEST_ASSERT_FALSE(es_sim_start(rig));
    TEST_ASSERT_EQUAL_STRING("chopper_v", es_sim_error(rig)->name);
}
