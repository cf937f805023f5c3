/* A current sensor, a phase or the encoder fails while the drive turns, and the firmware has nothing but two currents, its voltages
 * and the angle: off within milliseconds, in speed and in current mode, the current not above what trips; and no trip where the
 * machine is off by what the tolerances say. */
#include "tests/scenario/support/rig.h"

static double iron_a; /* at which current the iron saturates, as the drive knows; 0: never */

void setUp(void)
{
    iron_a = 0.0;
    rig_new();
}
void tearDown(void) { rig_free(); }

#define MOMENTS 12
#define SETTLED_PERIODS 2000
#define OVER_CURRENT_A 20.0

/* One of the parts, and what it does from then on. */
typedef struct {
    const char *name, *input;
    double      healthy, failed;
    int         most_periods; /* from the failure to the trip */
} part_t;

static const part_t PARTS[] = {
    {"dead sensor", "current_a_gain", 1.0, 0.0, 150},
    {"sensor reversed", "current_b_gain", 1.0, -1.0, 60},
    {"sensor that stands", "current_a_stands", 0.0, 1.0, 150},
    {"open phase a", "open_phase", 0.0, 1.0, 150},
    {"open phase b", "open_phase", 0.0, 2.0, 150},
    {"open phase c", "open_phase", 0.0, 3.0, 150},
};

/* 6 A at 100 rad/s, or the same current as a torque against a brake that holds the speed there. */
static void turn(bool speed_mode)
{
    if (iron_a > 0.0) {
        rig_effect("inductance_saturation", "i_sat_a", iron_a);
        rig_param("saturation_a", iron_a);
    }
    rig_model("current_noise_a", 0.01);
    rig_model("viscous_nms", 0.0023); /* 0.23 N m at 100 rad/s, of 0.0384 N m/A: 6 A */
    rig_input("control_mode", speed_mode ? 1.0 : 0.0);
    rig_input("speed_ref_rad_s", 100.0);
    rig_input("iq_ref_a", 6.0);
}

static double largest_current(void)
{
    return fmax(fabs(rig_read("true_ia_a")), fmax(fabs(rig_read("true_ib_a")), fabs(rig_read("true_ic_a"))));
}

static void assert_found(const part_t *part, bool speed_mode, int moment)
{
    const int at_period = SETTLED_PERIODS + 13 * moment; /* 13: an electrical turn at 100 rad/s has 157 */
    double    most_a = 0.0;
    int       k = 0;
    rig_new();
    turn(speed_mode);
    rig_step(part->input, part->healthy, at_period * 1e-4, part->failed);
    rig_start();
    rig_run(at_period);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("none", rig_fault(), part->name);
    for (; (k < part->most_periods) && (rig_read("fault") == 0.0); k++) {
        rig_run(1);
        most_a = fmax(most_a, largest_current());
    }
    const char *const text = at("%s, moment %d, mode %d: %d periods, %g A", part->name, moment, speed_mode, k, most_a);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("current_implausible", rig_fault(), text);
    TEST_ASSERT_TRUE_MESSAGE(most_a < OVER_CURRENT_A, text);
    const double gates = rig_read("gate_periods");
    rig_run(1000);
    TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(gates, rig_read("gate_periods"), text);
}

void test_plausibility_finds_a_part_that_fails_at_any_moment_in_speed_and_in_current_mode(void)
{
    for (size_t k = 0; k < COUNT_OF(PARTS); k++) {
        for (int moment = 0; moment < MOMENTS; moment++) {
            assert_found(&PARTS[k], true, moment);
            assert_found(&PARTS[k], false, moment);
        }
    }
}

/* The tolerance that the saturation needs hides none of them; a reversed sensor makes the current loop trip by itself there. */
void test_plausibility_finds_a_part_that_fails_on_saturated_iron(void)
{
    iron_a = 3.0;
    for (size_t k = 0; k < COUNT_OF(PARTS); k++) {
        if (strcmp(PARTS[k].name, "sensor reversed") == 0) {
            continue;
        }
        for (int moment = 0; moment < MOMENTS; moment += 4) {
            assert_found(&PARTS[k], true, moment);
            assert_found(&PARTS[k], false, moment);
        }
    }
}

/* In current mode nothing else looks at the encoder: the back-EMF of 2.6 V turns on where the angle stands. */
void test_plausibility_finds_an_encoder_that_stands_in_current_mode(void)
{
    for (int moment = 0; moment < MOMENTS; moment++) {
        const part_t encoder = {"encoder that stands", "encoder_stuck", 0.0, 1.0, 150};
        assert_found(&encoder, false, moment);
    }
}

/* The d axis aligned on a rotor that follows; one sensor is dead from the start. */
void test_plausibility_finds_a_dead_sensor_in_the_alignment(void)
{
    turn(true);
    rig_param("align_periods", 12000.0);
    rig_step("current_b_gain", 1.0, 0.3, 0.0);
    rig_start();
    rig_run(8000);
    TEST_ASSERT_EQUAL_STRING("current_implausible", rig_fault());
    TEST_ASSERT_TRUE(rig_read("true_iq_a") < 1.0);
}

/* R off by 20 %, L by 15 %, the magnets by 3 %, 0.5 us of dead time, all at once and in the worst directions, sensors off by 5 %, while
 * the drive reverses at its limits. */
void test_plausibility_lets_a_machine_at_the_ends_of_its_tolerances_work(void)
{
    for (int corner = 0; corner < 16; corner++) {
        rig_new();
        rig_model("current_noise_a", 0.02);
        rig_model("resistance_ohm", 0.36 * (((corner & 1) != 0) ? 1.2 : 0.8));
        rig_model("ld_h", 0.2e-3 * (((corner & 2) != 0) ? 1.15 : 0.85));
        rig_model("lq_h", 0.2e-3 * (((corner & 2) != 0) ? 1.15 : 0.85));
        rig_model("psi_wb", 6.4e-3 * (((corner & 4) != 0) ? 1.03 : 0.97));
        rig_effect("current_gain", "gain_a", ((corner & 8) != 0) ? 1.05 : 0.95);
        rig_effect("dead_time", "dead_time_s", 0.5e-6);
        rig_effect("current_offset", "offset_a_a", 0.2);
        const double t[4] = {0.0, 0.15, 0.3, 0.45};
        const double v[4] = {400.0, -400.0, 30.0, -30.0};
        TEST_ASSERT_TRUE(es_sim_set_input(rig, "speed_ref_rad_s", t, v, 4, false));
        rig_start();
        rig_run(6000);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("none", rig_fault(), at("corner %d", corner));
    }
}

/* Iron whose inductance halves at 3 A, a third of the limit: steps of the d current in a shaft at rest, or reversals of the speed with
 * full torque. The drive knows it, or believes the inductance of small currents. */
static double worst_on_saturated_iron(bool steps, double knows_a)
{
    static const double T[] = {0.0, 0.1, 0.2, 0.3, 0.4}, D[] = {0.0, 8.0, -8.0, 0.0, 10.0},
                        W[] = {0.0, 300.0, -300.0, 100.0, 100.0};
    double              worst = 0.0;
    rig_new();
    rig_effect("inductance_saturation", "i_sat_a", 3.0);
    rig_param("saturation_a", knows_a);
    rig_input("control_mode", steps ? 0.0 : 1.0);
    TEST_ASSERT_TRUE(es_sim_set_input(rig, steps ? "id_ref_a" : "speed_ref_rad_s", T, steps ? D : W, COUNT_OF(T), false));
    rig_start();
    for (int k = 0; k < 5000; k++) {
        rig_run(1);
        worst = fmax(worst, rig_read("contradiction"));
    }
    return worst;
}

void test_plausibility_knows_the_saturation_that_is_corrected(void)
{
    for (int steps = 0; steps < 2; steps++) {
        const double with = worst_on_saturated_iron(steps != 0, 3.0);
        TEST_ASSERT_EQUAL_STRING("none", rig_fault());
        TEST_ASSERT_TRUE_MESSAGE(with < 0.5, at("steps %d: %g of what is allowed", steps, with));
        TEST_ASSERT_TRUE(worst_on_saturated_iron(steps != 0, 0.0) > 1.0);
    }
}

/* A supply that sags by a fifth, faster than the filter of its measurement follows. */
void test_plausibility_waits_while_the_dc_link_changes(void)
{
    for (double then = 19.0; then < 31.0; then += 10.0) {
        rig_new();
        turn(true);
        rig_step("dc_link_v", 24.0, 0.2, then);
        rig_start();
        rig_run(6000);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("none", rig_fault(), at("%g V", then));
    }
}

void test_plausibility_of_share_0_is_never_judged(void)
{
    turn(true);
    rig_param("plausibility_share", 0.0);
    rig_step("current_a_gain", 1.0, 0.2, 0.0);
    rig_start();
    rig_run(4000);
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_read("contradiction"));
}
