/* The first start of a drive that does not know its electrical zero, on the simulated machine: brakes, loads, a shaft that still
 * turns, one that is blocked, friction and cogging, rotors from light to heavy. It ends at the right zero, or is refused by name. */
#include <math.h>
#include <string.h>

#include "tests/scenario/support/shaft.h"
#include "tests/support/numeric.h"

#define PAIRS 4.0
#define FRICTION_NM 0.0054 /* 2 % of the rated torque */
#define COGGING_NM 0.0108  /* 4 % */
#ifdef __SANITIZE_ADDRESS__
#define EVERY 4 /* of the angles that a test begins at: it is five times as slow, for the same lines of code */
#else
#define EVERY 1
#endif

static int right, refused;

void setUp(void)
{
    right = 0;
    refused = 0;
    shaft_new();
}
void tearDown(void) {}

static void power_up_at(double theta_m)
{
    shaft.model.initial_angle_rad = theta_m;
    shaft_power_up();
    shaft_speed(50.0);
    shaft_run(1200); /* offsets */
}

/* After the start: right or refused, and never a runaway, whatever held the shaft meanwhile and lets go of it then. */
static void judge(double error_deg, const char *text)
{
    shaft_settle(120000);
    const double error = shaft_zero_error_deg();
    shaft.board.plant.outside.load_brake_nm = 0.0;
    shaft.board.plant.outside.load_torque_nm = 0.0;
    if (shaft.drive.state == DRIVE_FAULT) {
        const uint64_t gates = shaft.board.gate_periods;
        TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE("align_", shaft_fault(), 6, text);
        TEST_ASSERT_FALSE_MESSAGE(drive_zero_is_known(&shaft.drive), text);
        shaft_run(1000);
        TEST_ASSERT_EQUAL_UINT64_MESSAGE(gates, shaft.board.gate_periods, text);
        refused++;
        return;
    }
    TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_RUN, shaft.drive.state, text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(error_deg, 0.0, error, text);
    shaft_watch();
    shaft_run(10000);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("none", shaft_fault(), text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(3.0, 50.0, shaft_rad_s(), text); /* cogging makes ripple */
    TEST_ASSERT_TRUE_MESSAGE(shaft.backwards_rad_s > -3.0, text);
    right++;
}

static double start_angle(int k, int of) { return TWO_PI / PAIRS / of * k + 0.01; }

/* ---- before a start ------------------------------------------------------------------------------------------------------ */

void test_alignment_without_a_start_nothing_moves_in_ten_seconds(void)
{
    for (int k = 0; k < 4; k++) {
        shaft_new();
        power_up_at(0.3 * k);
        drive_clear_fault(&shaft.drive);
        shaft_run(100000);
        TEST_ASSERT_EQUAL_INT(DRIVE_READY, shaft.drive.state);
        TEST_ASSERT_EQUAL_UINT64(0U, shaft.board.gate_periods);
        TEST_ASSERT_EQUAL_DOUBLE(0.3 * k, shaft.board.plant.x.theta_m_rad);
    }
}

/* ---- brakes and loads ---------------------------------------------------------------------------------------------------- */

void test_alignment_under_a_holding_brake_is_right_or_refused(void)
{
    for (int k = 0; k < 16; k += EVERY) {
        shaft_new();
        power_up_at(start_angle(k, 16));
        shaft.board.plant.outside.load_brake_nm = 0.06;
        drive_start(&shaft.drive);
        judge(3.0, at("brake, from angle %d", k));
    }
    TEST_ASSERT_EQUAL_INT(16 / EVERY, right); /* 4 A pull with 0.154 N m */
}

/* 0.0384 N m hold what 1 A pulls */
void test_alignment_with_the_drag_of_a_brake_of_one_ampere_is_right_with_the_default_current_and_refused_with_less(void)
{
    for (int k = 0; k < 16; k += EVERY) {
        for (int little = 0; little < 2; little++) {
            shaft_new();
            shaft_effect("coulomb_friction", "torque_nm", 0.0384);
            if (little != 0) {
                shaft.params.align_current_a = 1.0f;
                shaft.params.align_periods = 9000U;
            }
            power_up_at(start_angle(k, 16));
            drive_start(&shaft.drive);
            judge(3.0, at("drag, little %d, from angle %d", little, k));
        }
    }
    TEST_ASSERT_EQUAL_INT(16 / EVERY, right);
    TEST_ASSERT_EQUAL_INT(16 / EVERY, refused);
}

/* A load that drives the shaft: it never rests; and one that hangs in the friction, which leaves the mean of both ways. */
void test_alignment_under_a_load_is_right_or_refused(void)
{
    const double load_nm[] = {0.05, -0.05, 0.004, -0.03, 0.03, 0.04};
    const double drag_nm[] = {0.0, 0.0, FRICTION_NM, 0.05, 0.05, 0.05};
    for (size_t n = 0; n < COUNT_OF(load_nm); n++) {
        for (int k = 0; k < 4; k++) {
            shaft_new();
            shaft_effect("coulomb_friction", "torque_nm", drag_nm[n]);
            shaft.params.align_rest_s = 0.3f;
            shaft.model.initial_angle_rad = start_angle(k, 4);
            shaft_power_up();
            shaft.board.plant.outside.load_torque_nm = load_nm[n];
            shaft_speed(50.0);
            drive_start(&shaft.drive);
            judge(3.0, at("load %g over drag %g, from angle %d", load_nm[n], drag_nm[n], k));
        }
    }
    TEST_ASSERT_EQUAL_INT(4, right); /* the small one */
}

/* ---- a shaft that turns, or is blocked ----------------------------------------------------------------------------------- */

void test_alignment_after_a_fault_at_speed_waits_for_the_shaft(void)
{
    for (int n = 0; n < 4; n++) {
        shaft_new();
        shaft.params.align_periods = 9000U;
        shaft.model.viscous_nms = 2e-4; /* runs out in some seconds */
        power_up_at(0.2);
        shaft_speed(50.0 + 150.0 * n);
        drive_start(&shaft.drive);
        shaft_settle(20000);
        shaft_run(12000);
        TEST_ASSERT_EQUAL_INT(DRIVE_RUN, shaft.drive.state);
        shaft.board.disturbance.encoder_error = true;
        shaft_run(10);
        shaft.board.disturbance.encoder_error = false;
        TEST_ASSERT_EQUAL_STRING("encoder_error", shaft_fault());
        drive_clear_fault(&shaft.drive);
        shaft_run(20);
        shaft_speed(50.0);
        drive_start(&shaft.drive);
        judge(3.0, at("cleared at %d rad/s", 50 + 150 * n));
    }
    TEST_ASSERT_EQUAL_INT(4, right);
}

void test_alignment_of_a_shaft_that_coasts_for_long_is_refused_by_name_with_the_bridge_off(void)
{
    shaft.params.align_rest_s = 1.0f;
    shaft.model.initial_speed_rad_s = 100.0;
    power_up_at(0.0);
    drive_start(&shaft.drive);
    shaft_settle(20000);
    TEST_ASSERT_EQUAL_STRING("align_turning", shaft_fault());
    TEST_ASSERT_EQUAL_UINT64(0U, shaft.board.gate_periods);
}

/* Blocked from some moment of the alignment on: refused; freed, cleared and started again it is right. */
void test_alignment_of_a_shaft_that_was_blocked_on_the_way_is_refused_and_the_next_one_is_right(void)
{
    for (int n = 0; n < 11; n++) {
        shaft_new();
        shaft.params.align_periods = 12000U;
        power_up_at(0.7);
        drive_start(&shaft.drive);
        shaft_run(500 + n * 1100);
        shaft.board.plant.outside.load_brake_nm = SHAFT_LOCKED_NM;
        shaft_settle(30000);
        TEST_ASSERT_EQUAL_INT_MESSAGE(DRIVE_FAULT, shaft.drive.state, at("blocked in %d", n));
        shaft.board.plant.outside.load_brake_nm = 0.0;
        drive_clear_fault(&shaft.drive);
        shaft_run(20);
        drive_start(&shaft.drive);
        judge(3.0, at("blocked in %d", n));
    }
    TEST_ASSERT_EQUAL_INT(11, right);
}

/* ---- accuracy ------------------------------------------------------------------------------------------------------------ */

/* 32 angles of a whole turn of the shaft; cogging with whole and with half periods in an electrical turn */
void test_alignment_is_within_three_degrees_with_friction_and_cogging(void)
{
    const double order[] = {24.0, 12.0, 18.0, 6.0};
    for (int k = 0; k < 32; k += EVERY) {
        shaft_new();
        shaft_effect("coulomb_friction", "torque_nm", FRICTION_NM);
        shaft_effect("cogging", "amplitude_nm", COGGING_NM);
        shaft_effect("cogging", "order", order[k % 4]);
        shaft_effect("cogging", "phase_rad", 0.2 * k);
        power_up_at(TWO_PI / 32.0 * k);
        drive_start(&shaft.drive);
        judge(1.0, at("order %g from %d of 32", order[k % 4], k));
    }
    TEST_ASSERT_EQUAL_INT(32 / EVERY, right);
}

/* over a whole turn of the shaft even what has one period in it averages out */
void test_alignment_over_a_turn_of_the_shaft_takes_out_every_torque_that_is_tied_to_the_angle(void)
{
    const double order[] = {1.0, 2.0, 3.0, 5.0};
    for (int k = 0; k < 4; k++) {
        shaft_new();
        shaft.params.align_turns = 4U;
        shaft.params.align_periods = 60000U;
        shaft_effect("coulomb_friction", "torque_nm", FRICTION_NM);
        shaft_effect("cogging", "amplitude_nm", 2.0 * COGGING_NM);
        shaft_effect("cogging", "order", order[k]);
        power_up_at(1.5 * k);
        drive_start(&shaft.drive);
        judge(1.0, at("order %g", order[k]));
    }
    TEST_ASSERT_EQUAL_INT(4, right);
}

void test_alignment_settles_light_and_heavy_rotors(void)
{
    const double inertia[] = {7.06e-6, 2e-5, 2e-4, 3e-4};
    for (size_t n = 0; n < COUNT_OF(inertia); n++) {
        for (int k = 0; k < 4; k++) {
            shaft_new();
            shaft.model.inertia_kgm2 = inertia[n];
            shaft.model.viscous_nms = 2.6e-6;
            shaft.params.speed_kp_a_per_unit *=
                (float)fmin(1.0, inertia[n] / 7.06e-5); /* the loop as quick as with the nominal rotor */
            shaft.params.speed_ki_a_per_unit_s *= (float)fmin(1.0, inertia[n] / 7.06e-5);
            power_up_at(start_angle(k, 4));
            drive_start(&shaft.drive);
            judge(1.0, at("%g kg m2 from angle %d", inertia[n], k));
        }
    }
    TEST_ASSERT_EQUAL_INT(16, right);
}

/* The mean over the way is finer than a count: it takes away the half count that an encoder's angle lies behind, which one reading
 * cannot. */
void test_alignment_of_a_coarse_encoder_is_finer_than_its_counts(void)
{
    for (double counts = 64.0; counts <= 1024.0; counts *= 4.0) {
        for (int k = 0; k < 4; k++) {
            shaft_new();
            shaft_effect("coulomb_friction", "torque_nm", FRICTION_NM);
            shaft.model.counts_per_rev = counts;
            shaft.params.encoder_counts = (float)counts;
            shaft.params.encoder_jump_rad = 3.0f;
            shaft.params.align_periods = 18000U;
            power_up_at(start_angle(k, 4));
            drive_start(&shaft.drive);
            shaft_settle(40000);
            TEST_ASSERT_EQUAL_STRING("none", shaft_fault());
            const double count_deg = 360.0 * PAIRS / counts;
            ASSERT_DOUBLE_WITHIN_AT(0.1 * count_deg + 0.3, 0.5 * count_deg, shaft_zero_error_deg(),
                                    at("%g counts from angle %d", counts, k));
        }
    }
}

/* ---- what is set wrongly ------------------------------------------------------------------------------------------------- */

void test_alignment_names_wrong_pole_pairs_with_the_right_number(void)
{
    const uint16_t set[] = {1U, 2U, 3U, 5U, 6U};
    for (size_t n = 0; n < COUNT_OF(set); n++) {
        for (int k = 0; k < 4; k++) {
            shaft_new();
            shaft.params.pole_pairs = set[n];
            shaft_effect("coulomb_friction", "torque_nm", (k % 2 == 0) ? FRICTION_NM : 0.0);
            power_up_at(start_angle(k, 4));
            drive_start(&shaft.drive);
            shaft_settle(100000);
            TEST_ASSERT_EQUAL_STRING_MESSAGE("align_pole_pairs", shaft_fault(), at("%u set", set[n]));
            TEST_ASSERT_EQUAL_UINT16(4U, shaft.drive.fault_detail);
        }
    }
}

void test_alignment_names_an_encoder_that_counts_the_other_way(void)
{
    for (int k = 0; k < 8; k++) {
        shaft_new();
        shaft.params.encoder_reversed = 1U;
        shaft_effect("coulomb_friction", "torque_nm", (k % 2 == 0) ? FRICTION_NM : 0.0);
        power_up_at(start_angle(k, 8));
        drive_start(&shaft.drive);
        shaft_settle(100000);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("align_direction", shaft_fault(), at("from angle %d", k));
    }
}

/* The encoder stands, or a phase is open: the vector turns, and the angle does not. */
void test_alignment_with_a_stuck_encoder_is_refused(void)
{
    power_up_at(0.5);
    shaft.board.disturbance.encoder_stuck = true;
    drive_start(&shaft.drive);
    shaft_settle(100000);
    TEST_ASSERT_EQUAL_STRING("align_blocked", shaft_fault());
}
