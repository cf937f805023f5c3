/* A drive configured as the measured-log format describes it, against a second implementation of that text.
 *
 * Everything below `the text` is written from the description of the controller in the log format and from the dq
 * equations of a motor, in double precision, without a line of the project: currents and angle are sampled, the tracking
 * filter, the speed controller (every 10th period) and the current controllers follow, then the voltage of the previous
 * period acts for 100 us. The motor is integrated with 20 steps per period. */
#include "tests/scenario/support/rig.h"

#define PERIODS 3000
#define VDC 60.0

/* a motor of the size in the example cases of the format, on a dc link low enough for the voltage limit to act */
#define POLES 3.0
#define R 0.9
#define LD 0.0024
#define LQ 0.0030
#define PSI 0.1
#define J 0.0008
#define B 0.002
#define CUR_KP 6.0
#define CUR_KI 2261.9
#define SPD_KP 0.134
#define SPD_KI 2.02
#define IQ_MAX 8.0
#define PLL_KP 754.0
#define PLL_KI 142122.0

static double speed_ref(double t) { return (t < 0.12) ? 60.0 : -25.0; }
static double load(double t) { return (t < 0.06) ? 0.0 : ((t < 0.2) ? 0.5 : -0.3); }

/* what is compared */
enum { SPEED, ID, IQ, VD, VQ, TRUE_SPEED, TRUE_IQ, COLUMNS };
static const char *const SIGNAL[COLUMNS] = {"speed_rad_s", "id_a", "iq_a", "vd_v", "vq_v", "true_speed_rad_s", "true_iq_a"};
static double            mine[PERIODS][COLUMNS];
static double            theirs[PERIODS][COLUMNS];
static int               v_limited, i_limited; /* how often, in the second implementation */

/* ---- the text ------------------------------------------------------------------------------------------------------- */

typedef struct {
    double id, iq, w, th;
} motor_t;

static motor_t slope(motor_t x, double v_alpha, double v_beta, double load_nm)
{
    const double  e = POLES * x.th;
    const double  vd = v_alpha * cos(e) + v_beta * sin(e);
    const double  vq = v_beta * cos(e) - v_alpha * sin(e);
    const double  we = POLES * x.w;
    const motor_t d = {(vd - R * x.id + we * LQ * x.iq) / LD, (vq - R * x.iq - we * (LD * x.id + PSI)) / LQ,
                       (1.5 * POLES * (PSI * x.iq + (LD - LQ) * x.id * x.iq) - B * x.w - load_nm) / J, x.w};
    return d;
}

static motor_t moved(motor_t x, motor_t d, double h)
{
    const motor_t y = {x.id + h * d.id, x.iq + h * d.iq, x.w + h * d.w, x.th + h * d.th};
    return y;
}

static motor_t period(motor_t x, double v_alpha, double v_beta, double load_nm)
{
    const double h = 1e-4 / 20.0;
    for (int k = 0; k < 20; k++) {
        const motor_t a = slope(x, v_alpha, v_beta, load_nm);
        const motor_t b = slope(moved(x, a, h / 2.0), v_alpha, v_beta, load_nm);
        const motor_t c = slope(moved(x, b, h / 2.0), v_alpha, v_beta, load_nm);
        const motor_t d = slope(moved(x, c, h), v_alpha, v_beta, load_nm);
        x = moved(moved(moved(moved(x, a, h / 6.0), b, h / 3.0), c, h / 3.0), d, h / 6.0);
    }
    return x;
}

static double encoder(double angle, double counts)
{
    const double count = TWO_PI / counts;
    return (counts > 0.0) ? floor(angle / count) * count : angle;
}

static double rounded(double i, double lsb) { return (lsb > 0.0) ? round(i / lsb) * lsb : i; }

static void second_implementation(double angle0, double counts, double lsb)
{
    const double T = 1e-4;
    motor_t      x = {0.0, 0.0, 0.0, angle0};
    v_limited = i_limited = 0;
    double th = encoder(angle0, counts), w = 0.0;
    double speed_x = 0.0, d_x = 0.0, q_x = 0.0, iq_ref = 0.0;
    double v_alpha = 0.0, v_beta = 0.0;
    for (int k = 0; k < PERIODS; k++) {
        /* sample */
        const double angle = encoder(x.th, counts);
        const double e_true = POLES * x.th;
        const double ia = rounded(x.id * cos(e_true) - x.iq * sin(e_true), lsb);
        const double ib = rounded(x.id * cos(e_true - TWO_PI / 3.0) - x.iq * sin(e_true - TWO_PI / 3.0), lsb);
        const double e = POLES * angle;
        const double i_beta = (ia + 2.0 * ib) / sqrt(3.0);
        const double id = ia * cos(e) + i_beta * sin(e);
        const double iq = i_beta * cos(e) - ia * sin(e);
        /* tracking filter */
        const double apart = remainder(angle - th, TWO_PI);
        w += PLL_KI * apart * T;
        th += (w + PLL_KP * apart) * T;
        /* speed controller */
        if (k % 10 == 0) {
            const double err = speed_ref(k * T) - w;
            const double u = SPD_KP * err + speed_x;
            iq_ref = fmin(IQ_MAX, fmax(-IQ_MAX, u));
            i_limited += (iq_ref != u) ? 1 : 0;
            if ((iq_ref == u) || ((u > IQ_MAX) && (err < 0.0)) || ((u < -IQ_MAX) && (err > 0.0))) {
                speed_x += SPD_KI * err * 1e-3;
            }
        }
        /* current controllers */
        const double ed = 0.0 - id;
        const double eq = iq_ref - iq;
        double       vd = CUR_KP * ed + d_x;
        double       vq = CUR_KP * eq + q_x;
        const double length = hypot(vd, vq);
        const double limit = VDC / sqrt(3.0);
        if (length > limit) {
            vd *= limit / length;
            vq *= limit / length;
            v_limited++;
        } else {
            d_x += CUR_KI * ed * T;
            q_x += CUR_KI * eq * T;
        }
        const double row[COLUMNS] = {w, id, iq, vd, vq, x.w, x.iq};
        (void)memcpy(mine[k], row, sizeof row);
        /* the voltage of the previous period acts; this one will, 1.5 periods of the speed further on */
        x = period(x, v_alpha, v_beta, load(k * T));
        const double ahead = e + 1.5 * T * POLES * w;
        v_alpha = vd * cos(ahead) - vq * sin(ahead);
        v_beta = vd * sin(ahead) + vq * cos(ahead);
    }
}

/* ---- the project ---------------------------------------------------------------------------------------------------- */

static void project(double angle0, double counts, double lsb)
{
    rig_new();
    rig_model("pole_pairs", POLES);
    rig_model("resistance_ohm", R);
    rig_model("ld_h", LD);
    rig_model("lq_h", LQ);
    rig_model("psi_wb", PSI);
    rig_model("inertia_kgm2", J);
    rig_model("viscous_nms", B);
    rig_model("dc_link_v", VDC);
    rig_model("counts_per_rev", counts);
    rig_model("current_lsb_a", lsb);
    rig_model("initial_angle_rad", angle0);
    rig_param("pole_pairs", POLES);
    rig_param("speed_source", 0.0);
    rig_param("speed_inline", 1.0);
    rig_param("angle_advance_periods", 1.5);
    rig_param("current_kp_v_per_a", CUR_KP);
    rig_param("current_ki_v_per_as", CUR_KI);
    rig_param("speed_error_gain", 1.0);
    rig_param("speed_kp_a_per_unit", SPD_KP);
    rig_param("speed_ki_a_per_unit_s", SPD_KI);
    rig_param("iq_limit_a", IQ_MAX);
    rig_param("pll_kp_per_s", PLL_KP);
    rig_param("pll_ki_per_s2", PLL_KI);
    rig_param("over_voltage_v", 100.0);
    rig_param("plausibility_share", 0.0); /* the described drive has no such check, and this one does not know its motor */
    rig_step("speed_ref_rad_s", 60.0, 0.12, -25.0);
    const double t[3] = {0.0, 0.06, 0.2};
    const double v[3] = {0.0, 0.5, -0.3};
    TEST_ASSERT_TRUE(es_sim_set_input(rig, "load_torque_nm", t, v, 3, false));
    TEST_ASSERT_TRUE(es_sim_record(rig, SIGNAL, COLUMNS));
    rig_start();
    TEST_ASSERT_EQUAL_INT64(PERIODS, es_sim_run(rig, PERIODS, 1, &theirs[0][0], PERIODS));
    TEST_ASSERT_EQUAL_STRING("none", rig_fault());
}

static double worst[COLUMNS], rms[COLUMNS];

static void compare(void)
{
    for (int c = 0; c < COLUMNS; c++) {
        double sum = 0.0;
        worst[c] = 0.0;
        for (int k = 0; k < PERIODS; k++) {
            const double apart = fabs(mine[k][c] - theirs[k][c]);
            worst[c] = fmax(worst[c], apart);
            sum += apart * apart;
        }
        rms[c] = sqrt(sum / PERIODS);
    }
}

static void assert_close(int column, double worst_allowed, double rms_allowed)
{
    TEST_ASSERT_TRUE_MESSAGE(worst[column] <= worst_allowed, at("%s: %g apart", SIGNAL[column], worst[column]));
    TEST_ASSERT_TRUE_MESSAGE(rms[column] <= rms_allowed, at("%s: %g apart on average", SIGNAL[column], rms[column]));
}

void setUp(void) {}
void tearDown(void) { rig_free(); }

void test_log_format_drive_with_an_ideal_encoder_is_the_described_one_sample_by_sample(void)
{
    second_implementation(1.3, 0.0, 0.0);
    project(1.3, 0.0, 0.0);
    compare();

    /* Both limits have acted, and let go again. */
    TEST_ASSERT_TRUE((v_limited > 3) && (v_limited < 500));
    TEST_ASSERT_TRUE((i_limited > 5) && (i_limited < 150));
    TEST_ASSERT_TRUE((mine[1100][SPEED] > 55.0) && (mine[PERIODS - 1][SPEED] < -20.0));
    /* What differs is rounding. Float: an angle has steps of 2.4e-7 (or 4.8e-7) rad, in the filter 1400 times that per
     * second, in the frame 3 times that of 8 A; duties have steps of 6e-8 of 60 V. It adds up as a random walk that the
     * loops pull back, to some ten times one step. Fixed point: a step of 6e-8 of 10 A, 50 V, 162.5 rad/s and of the gains
     * per unit, of which the integral gain of the speed, 2.02e-3 16.25, has the largest error: 2e-6 of it. */
    assert_close(SPEED, per_numeric(2e-4, 5e-4), per_numeric(4e-5, 1.5e-4));
    assert_close(TRUE_SPEED, per_numeric(1e-4, 5e-4), per_numeric(5e-5, 2e-4));
    assert_close(ID, 2e-5, 4e-6);
    assert_close(IQ, per_numeric(2.5e-5, 6e-5), per_numeric(6e-6, 2e-5));
    assert_close(TRUE_IQ, per_numeric(2.5e-5, 6e-5), per_numeric(6e-6, 2e-5));
    assert_close(VD, 1.2e-4, 3e-5);
    assert_close(VQ, per_numeric(1.5e-4, 3e-4), per_numeric(2.5e-5, 8e-5));
}

void test_log_format_drive_with_encoder_and_converter_is_the_described_one(void)
{
    second_implementation(1.3, 4000.0, 0.009765625);
    project(1.3, 4000.0, 0.009765625);
    compare();

    /* Now and then one of the two sees a count or a converter step a sample earlier, from a difference in the last digit.
     * A count is 0.022 rad/s in the filter and 4.7 mrad of 8 A in the frame; a step of the converter is 0.01 A and, times
     * 6 V/A, 0.06 V. A few of them together at worst, half of one on average. */
    assert_close(SPEED, 0.15, 0.02);
    assert_close(TRUE_SPEED, 0.03, 0.01);
    assert_close(ID, 0.08, 0.01);
    assert_close(IQ, 0.05, 0.01);
    assert_close(VD, 0.5, 0.05);
    assert_close(VQ, 0.3, 0.05);
}
