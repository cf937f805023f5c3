/* Most torque per ampere, and field weakening up to twice the base speed, on a salient machine: against the equations of the machine,
 * searched in double precision. */
#include "tests/scenario/support/rig.h"

/* 4 pole pairs, 24 V; base speed without load: 0.95 * 24 / sqrt(3) / (4 * 6.4e-3) = 514 rad/s */
#define PAIRS 4.0
#define PSI 6.4e-3
#define LD 0.3e-3
#define LQ 0.5e-3
#define OHM 0.1
#define VDC 24.0
#define V_LIMIT (0.95 * VDC / sqrt(3.0))
#define BASE (V_LIMIT / (PAIRS * PSI))
#define ID_MAX 15.0
#define VISCOUS 2.0e-5

static void machine(void)
{
    rig_new();
    rig_model("ld_h", LD);
    rig_model("lq_h", LQ);
    rig_model("resistance_ohm", OHM);
    rig_model("viscous_nms", VISCOUS);
    rig_param("motor_ld_h", LD);
    rig_param("motor_lq_h", LQ);
    rig_param("motor_resistance_ohm", OHM);
    rig_param("current_kp_v_per_a", 1.0);
    rig_param("current_ki_v_per_as", 250.0);
    rig_param("id_limit_a", ID_MAX);
    rig_param("over_current_a", 30.0);
    rig_param("over_speed_rad_s", 1300.0);
    rig_param("link_withstand_v", 60.0); /* the machine makes 58 V at 1300 rad/s */
    rig_param("mtpa", 1.0);
    rig_param("field_weakening", 1.0);
}

void setUp(void) { machine(); }
void tearDown(void) { rig_free(); }

static double torque_nm(double id, double iq) { return 1.5 * PAIRS * iq * (PSI + (LD - LQ) * id); }
static double voltage(double w, double id, double iq)
{
    return hypot(OHM * id - PAIRS * w * LQ * iq, OHM * iq + PAIRS * w * (PSI + LD * id));
}

/* The shortest current that makes this torque, below this voltage. */
static double shortest(double nm, double w, double v_max, double *best_id)
{
    double best = INFINITY;
    for (int k = 0; k <= 20000; k++) {
        const double id = -ID_MAX * k / 20000.0;
        const double iq = nm / (1.5 * PAIRS * (PSI + (LD - LQ) * id));
        if ((hypot(id, iq) < best) && (voltage(w, id, iq) <= v_max)) {
            best = hypot(id, iq);
            *best_id = id;
        }
    }
    return best;
}

/* Mean of a signal over so many periods. */
static double mean(const char *signal, int periods)
{
    double sum = 0.0;
    for (int k = 0; k < periods; k++) {
        rig_run(1);
        sum += rig_read(signal);
    }
    return sum / periods;
}

static double volts(int periods)
{
    double sum = 0.0;
    for (int k = 0; k < periods; k++) {
        rig_run(1);
        sum += hypot(rig_read("vd_v"), rig_read("vq_v"));
    }
    return sum / periods;
}

/* ---- most torque per ampere ---------------------------------------------------------------------------------------------- */

void test_field_weakening_mtpa_carries_a_load_with_the_least_current(void)
{
    for (double load = 0.05; load < 0.4; load += 0.15) {
        machine();
        rig_input("speed_ref_rad_s", 100.0);
        rig_input("load_brake_nm", load);
        rig_start();
        rig_run(6000);
        double       id = 0.0;
        const double least = shortest(load + VISCOUS * 100.0, 100.0, V_LIMIT, &id);
        const double i = hypot(mean("true_id_a", 1000), mean("true_iq_a", 1000));
        TEST_ASSERT_EQUAL_STRING("none", rig_fault());
        TEST_ASSERT_TRUE_MESSAGE(i < 1.001 * least, at("%g N m: %g A, least %g A", load, i, least));
    }
}

void test_field_weakening_without_either_parameter_has_no_d_current(void)
{
    rig_param("mtpa", 0.0);
    rig_param("field_weakening", 0.0);
    rig_input("speed_ref_rad_s", 2.0 * BASE);
    rig_start();
    for (int k = 0; k < 6000; k++) {
        rig_run(1);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_read("id_ref_a"));
    }
    TEST_ASSERT_TRUE_MESSAGE(rig_read("true_speed_rad_s") < 1.6 * BASE, "as fast without field weakening");
}

/* ---- field weakening -------------------------------------------------------------------------------------------------------- */

static void assert_operating_point(double w, double load, double method, int deadbeat)
{
    double       id = 0.0;
    const double nm = load + VISCOUS * w;
    const double least = shortest(nm, w, V_LIMIT, &id);
    const double d = mean("true_id_a", 5000), q = mean("true_iq_a", 5000);
    const char  *text =
        at("method %g, deadbeat %d: %g rad/s %g N m: id %g iq %g, best id %g, %g A", method, deadbeat, w, load, d, q, id, least);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("none", rig_fault(), text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.01 * w, w, mean("true_speed_rad_s", 500), text);
    /* an observer that learns moves the speed: means over 50 ms of this torque have a standard deviation of 10 %, over 500 ms of 3 % */
    TEST_ASSERT_TRUE_MESSAGE(torque_nm(d, q) > 0.93 * nm, text);
    TEST_ASSERT_TRUE_MESSAGE(hypot(d, q) < 1.02 * least, text); /* the ripple of the voltage takes a part of its mean */
    TEST_ASSERT_TRUE_MESSAGE(volts(500) < 1.01 * V_LIMIT, text);
}

/* Twice the base speed with load steps, both current controllers, ripple methods on. */
void test_field_weakening_reaches_twice_the_base_speed_with_least_current(void)
{
    static const double METHOD[] = {0.0, 3.0, 6.0}; /* pi, fal-forc, aro */
    for (size_t k = 0; k < COUNT_OF(METHOD); k++) {
        for (int deadbeat = 0; deadbeat < 2; deadbeat++) {
            const double w = 2.0 * BASE, load = 0.06;
            machine();
            rig_param("method", METHOD[k]);
            rig_param("current_controller", deadbeat);
            rig_param("aro_remove_mean", 1.0); /* a steady load is the speed controller's part */
            rig_param("rc_memory", 2.0);       /* over the angle, with a stop while the speed changes */
            rig_param("rc_freeze_above_unit", 20.0);
            rig_input("speed_ref_rad_s", w);
            rig_step("load_torque_nm", 0.0, 2.2, load);
            rig_start();
            double most_a = 0.0;
            for (int n = 0; n < 9000; n++) {
                rig_run(1);
                most_a = fmax(most_a, hypot(rig_read("true_id_a"), rig_read("true_iq_a")));
            }
            TEST_ASSERT_TRUE_MESSAGE(most_a < 1.15 * ID_MAX, at("method %g, deadbeat %d: %g A", METHOD[k], deadbeat, most_a));
            assert_operating_point(w, 0.0, METHOD[k], deadbeat);
            rig_run(16000);
            assert_operating_point(w, load, METHOD[k], deadbeat);
        }
    }
}

/* From twice the base speed through 0 to the same backwards: braking at the limit. */
void test_field_weakening_reverses_at_twice_the_base_speed(void)
{
    rig_step("speed_ref_rad_s", 2.0 * BASE, 1.0, -2.0 * BASE);
    rig_start();
    double most = 0.0;
    for (int n = 0; n < 25000; n++) {
        rig_run(1);
        most = fmax(most, rig_read("contradiction"));
    }
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * BASE, -2.0 * BASE, rig_read("true_speed_rad_s"));
    TEST_ASSERT_TRUE_MESSAGE(most < 0.8, at("contradiction %g", most)); /* 1 trips */
}

/* The link loses a fifth at once: the current loop has too little for some samples, then the d current is larger. */
void test_field_weakening_follows_a_dc_link_that_sags(void)
{
    const double w = 1.6 * BASE;
    rig_input("speed_ref_rad_s", w);
    rig_step("dc_link_v", VDC, 1.0, 0.8 * VDC);
    rig_start();
    rig_run(9900);
    const double before = mean("true_id_a", 100);
    rig_run(2000);
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * w, w, rig_read("true_speed_rad_s"));
    TEST_ASSERT_TRUE(mean("true_id_a", 100) < before - 1.0);
    TEST_ASSERT_TRUE(volts(100) < 1.02 * 0.8 * V_LIMIT);
}

/* More than id_limit_a can weaken: the speed ends where the voltage does, nothing trips, and no current passes its limit. */
void test_field_weakening_ends_at_the_largest_d_current_without_a_trip(void)
{
    rig_param("id_limit_a", 5.0); /* psi - Ld 5 A = 4.9e-3: 671 rad/s */
    rig_input("speed_ref_rad_s", 1000.0);
    rig_start();
    for (int n = 0; n < 20000; n++) {
        rig_run(1);
        TEST_ASSERT_TRUE(rig_read("id_ref_a") > -5.001);
    }
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
    TEST_ASSERT_DOUBLE_WITHIN(20.0, V_LIMIT / (PAIRS * (PSI - LD * 5.0)), rig_read("true_speed_rad_s"));
}

/* Motor data within their tolerances, the drive does not know: the voltage is kept, and nothing trips. */
void test_field_weakening_with_another_motor_than_the_parameters_say(void)
{
    for (int corner = 0; corner < 8; corner++) {
        machine();
        rig_model("psi_wb", PSI * (((corner & 1) != 0) ? 1.05 : 0.95));
        rig_model("ld_h", LD * (((corner & 2) != 0) ? 1.2 : 0.8));
        rig_model("lq_h", LQ * (((corner & 2) != 0) ? 1.2 : 0.8));
        rig_model("resistance_ohm", OHM * (((corner & 4) != 0) ? 1.25 : 0.8));
        rig_input("speed_ref_rad_s", 1.7 * BASE);
        rig_step("load_torque_nm", 0.0, 0.8, 0.05);
        rig_start();
        rig_run(16000);
        TEST_ASSERT_EQUAL_STRING_MESSAGE("none", rig_fault(), at("corner %d", corner));
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.02 * BASE, 1.7 * BASE, rig_read("true_speed_rad_s"), at("corner %d", corner));
        const double v = volts(200);
        TEST_ASSERT_TRUE_MESSAGE(v < 1.01 * V_LIMIT, at("corner %d: %g V", corner, v));
    }
}

/* In current mode both currents are as asked for, at any speed. */
void test_field_weakening_leaves_current_mode_alone(void)
{
    rig_input("control_mode", 0.0);
    rig_input("id_ref_a", 1.0);
    rig_input("iq_ref_a", 2.0);
    rig_start();
    rig_run(200);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, rig_read("id_ref_a"));
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.0, rig_read("iq_ref_a"));
}
