/* From power-up to turning: offset calibration, alignment, run, from wherever the rotor stands. */
#include "tests/scenario/support/rig.h"

/* calibration, 0.1 s in which the shaft must rest, the alignment, passes of the main loop; and 0.5 s to turn */
#define CALIBRATION 1000
#define REST 1000
#define ALIGNMENT 20000
#define ALIGNED (CALIBRATION + REST + ALIGNMENT + 2000)
#define TURNS (ALIGNED + 5000)

void setUp(void) { rig_new(); }
void tearDown(void) { rig_free(); }

static void start_from(double theta_m, double speed_ref)
{
    rig_new();
    rig_param("offset_calibration_periods", (double)CALIBRATION);
    rig_param("align_periods", (double)ALIGNMENT);
    rig_model("initial_angle_rad", theta_m);
    rig_input("speed_ref_rad_s", speed_ref);
}

/* Two readings 50 ms apart: speed is right, and so is the sign of the angle. */
static void assert_turns(double speed_ref, const char *text)
{
    TEST_ASSERT_EQUAL_STRING_MESSAGE("none", rig_fault(), text);
    TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(4.0, rig_read("state"), text);
    const double before = rig_read("true_theta_m_rad");
    rig_run(500);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.01 * fabs(speed_ref), 0.05 * speed_ref / 0.05,
                                      (rig_read("true_theta_m_rad") - before) / 0.05, text);
}

/* 16 angles of one electrical turn, also exactly opposite to each vector of the alignment; no friction to hold the rotor,
 * hardly any to damp it */
void test_start_up_from_any_angle_turns_in_the_right_direction(void)
{
    for (int k = 0; k < 16; k++) {
        const double theta_m = TWO_PI / 4.0 / 16.0 * k;
        const double ref = (k % 2 == 0) ? 15.708 : -15.708;
        start_from(theta_m, ref);
        rig_start();
        rig_run(TURNS);
        assert_turns(ref, at("from %g rad", theta_m));
    }
}

/* an incremental encoder begins at 0 wherever the rotor stands */
void test_start_up_aligns_an_incremental_encoder(void)
{
    for (int k = 0; k < 4; k++) {
        start_from(0.4 * k + 0.1, 15.708);
        rig_model("encoder_absolute", 0.0);
        rig_start();
        rig_run(TURNS);
        assert_turns(15.708, at("from %g rad", 0.4 * k + 0.1));
    }
}

void test_start_up_calibration_takes_the_offsets_of_the_sensors_away(void)
{
    start_from(0.3, 15.708);
    rig_effect("current_offset", "offset_a_a", 0.2);
    rig_effect("current_offset", "offset_b_a", -0.3);
    rig_start();
    rig_run(TURNS + 5000);
    assert_turns(15.708, "with offsets");
    /* what the drive believes is what flows, one period of change apart; 0.2 A of offset would show as up to 0.3 A */
    TEST_ASSERT_DOUBLE_WITHIN(0.05, rig_read("true_iq_a"), rig_read("iq_a"));
    TEST_ASSERT_DOUBLE_WITHIN(0.05, rig_read("true_id_a"), rig_read("id_a"));
}

void test_start_up_calibration_averages_noise(void)
{
    start_from(0.3, 0.0);
    rig_model("current_noise_a", 0.1);
    rig_effect("current_offset", "offset_a_a", 0.2);
    rig_param("offset_calibration_periods", 4096.0);
    rig_param("align_periods", 0.0);
    rig_param("auto_run", 0.0);
    rig_start();
    rig_run(4200);
    TEST_ASSERT_EQUAL_DOUBLE(3.0, rig_read("state"));
    double sum = 0.0;
    for (int k = 0; k < 4000; k++) {
        rig_run(1);
        sum += rig_read("ia_a");
    }
    /* two means of 4000 samples of 0.1 A: sigma 2.2 mA, five of it */
    TEST_ASSERT_DOUBLE_WITHIN(0.011, 0.0, sum / 4000.0);
}

void test_start_up_takes_the_time_that_its_parameters_say(void)
{
    start_from(0.0, 0.0);
    rig_start();
    rig_run(CALIBRATION / 2);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_read("state"));
    rig_run(CALIBRATION / 2 + 100); /* a pass of the main loop every millisecond */
    TEST_ASSERT_EQUAL_DOUBLE(2.0, rig_read("state"));
    rig_run(REST + ALIGNMENT - 300); /* whole periods of a quarter turn: the alignment is up to one of its 36 shorter */
    TEST_ASSERT_EQUAL_DOUBLE(2.0, rig_read("state"));
    rig_run(300);
    TEST_ASSERT_EQUAL_DOUBLE(4.0, rig_read("state"));
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
}

void test_start_up_with_an_absolute_encoder_needs_no_alignment(void)
{
    rig_model("initial_angle_rad", 1.234);
    rig_input("speed_ref_rad_s", -15.708);
    rig_start();
    rig_run(4000);
    assert_turns(-15.708, "absolute");
}

/* The disc is turned by 0.4 rad electrical; the drive knows it. */
void test_start_up_encoder_offset_parameter_takes_a_turned_disc_away(void)
{
    rig_effect("encoder_offset", "angle_el_rad", 0.4);
    rig_param("encoder_offset_rad", -0.4);
    rig_input("control_mode", 0.0);
    rig_input("iq_ref_a", 3.0);
    rig_model("rotor_locked", 1.0);
    rig_model("initial_angle_rad", 0.7);
    rig_start();
    rig_run(300);
    /* all of it on the q axis, within a count of the encoder: 6.3 mrad electrical of 3 A */
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 0.0, rig_read("true_id_a"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 3.0, rig_read("true_iq_a"));
}
