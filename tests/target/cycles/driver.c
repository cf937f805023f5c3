/**
 * @file  tests/target/cycles/driver.c
 * @brief Drives every block and both interrupts with inputs that reach their long ways, and reports what each call cost.
 *
 * The counter is advanced by code that `evenspin cycles` puts into every basic block of control/ and firmware/. Output, one
 * line a name: name, calls, mean and largest cost in tenths of a cycle.
 *
 * With COUNT_INSTRUCTIONS there is no counter in the program: stores into `mark` tell count_plugin.c where a call begins and
 * ends, and which row it belongs to. Output, one line a row: its number and its name.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "control/motor/plausibility.h"
#include "control/motor/svm.h"
#include "control/numeric/lagrange.h"
#include "control/numeric/num_math.h"
#include "firmware/app/internal.h"
#include "hal/hal_clock.h"
#include "hal/hal_inverter.h"
#include "hal/hal_limits.h"
#include "hal/hal_storage.h"
#include "tests/target/cycles/port.h"

uint64_t evenspin_cycles;

typedef struct {
    const char *name;
    uint64_t    calls, sum, max;
} row_t;
static row_t    rows[200];
static unsigned row_count;

static unsigned row_of(const char *name)
{
    unsigned i = 0U;
    while ((i < row_count) && (strcmp(rows[i].name, name) != 0)) {
        i++;
    }
    if (i == row_count) {
        rows[row_count++].name = name;
    }
    return i;
}

#ifdef COUNT_INSTRUCTIONS
volatile unsigned char mark[256];
#define MEASURE(name, call)                                                                                                      \
    do {                                                                                                                         \
        const unsigned char row_ = row_of(name) + 1U;                                                                            \
        mark[0] = 0U;                                                                                                            \
        __asm__ volatile("" ::: "memory");                                                                                       \
        call;                                                                                                                    \
        __asm__ volatile("" ::: "memory");                                                                                       \
        mark[row_] = 0U;                                                                                                         \
    } while (0)
#else
static void note(const char *name, uint64_t cost)
{
    row_t *const r = &rows[row_of(name)];
    r->calls++;
    r->sum += cost;
    r->max = (cost > r->max) ? cost : r->max;
}
#define MEASURE(name, call)                                                                                                      \
    do {                                                                                                                         \
        const uint64_t before_ = evenspin_cycles;                                                                                \
        call;                                                                                                                    \
        note(name, evenspin_cycles - before_);                                                                                   \
    } while (0)
#endif

static uint32_t seed = 1U;
static float    noise(void) /* +-1 */
{
    seed = (seed * 1664525U) + 1013904223U;
    return ((float)(seed >> 8) / 8388608.0f) - 1.0f;
}

/* ---- what `evenspin cycles` counts as instructions of the TMU and the FPU -------------------------------------------- */
float fpu_min(float a, float b) { return (a < b) ? a : b; }
float fpu_max(float a, float b) { return (a > b) ? a : b; }
float tmu_sin_turns(float x) { return sinf(6.28318531f * x); }
float tmu_cos_turns(float x) { return cosf(6.28318531f * x); }
float tmu_sqrt(float x) { return sqrtf(x); }

#ifdef COUNT_INSTRUCTIONS
#define COSTS(function) ((void)0)
#else
#define COSTS(function) (evenspin_cycles += port_cost.function)
#endif

/* ---- the board ----------------------------------------------------------------------------------------------------- */
static hal_sample_t       sample;
static hal_encoder_edge_t edge;
static uint32_t           clock_now;
static bool               speed_wanted;
hal_status_t              hal_sample_read(hal_sample_t *out)
{
    COSTS(sample_read);
    *out = sample;
    return HAL_OK;
}
hal_status_t hal_encoder_edge(hal_encoder_edge_t *out)
{
    COSTS(encoder_edge);
    *out = edge;
    return HAL_OK;
}
hal_status_t hal_inverter_set_duty(const hal_duty_t *duty)
{
    COSTS(set_duty);
    (void)duty;
    return HAL_OK;
}
hal_status_t         hal_inverter_arm(void) { return HAL_OK; }
void                 hal_inverter_disarm(void) {}
hal_inverter_fault_t hal_inverter_fault(void)
{
    COSTS(inverter_fault);
    return HAL_INVERTER_FINE;
}
void     hal_inverter_clear_fault(void) {}
uint32_t hal_clock_cyc(void)
{
    COSTS(clock_cyc);
    return clock_now;
}
uint32_t     hal_clock_hz(void) { return 200000000U; }
hal_status_t hal_temperature(hal_temperature_t which, float *celsius)
{
    (void)which;
    *celsius = 25.0f;
    return HAL_OK;
}
uint16_t hal_sto(void) { return 0U; }
void     hal_brake_duty(float duty)
{
    COSTS(clock_cyc); /* a register, written instead of read */
    (void)duty;
}
void         hal_limits(hal_limits_t *out) { *out = (hal_limits_t){100.0f, 100.0f, 2000.0f, 1.0f, 0.0f, true}; }
uint16_t     hal_storage_pages(void) { return 0U; }
uint16_t     hal_storage_page_words(void) { return 0U; }
hal_status_t hal_storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count)
{
    (void)page;
    (void)offset;
    (void)words;
    (void)count;
    return HAL_OK;
}
hal_status_t hal_storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count)
{
    (void)page;
    (void)offset;
    (void)words;
    (void)count;
    return HAL_OK;
}
hal_status_t hal_storage_erase(uint16_t page)
{
    (void)page;
    return HAL_OK;
}
void hal_clock_request_speed_isr(void)
{
    COSTS(request_speed_isr);
    speed_wanted = true;
}

/* ---- blocks -------------------------------------------------------------------------------------------------------- */
static num_t memory[6144];

static void need(ctl_diag_t d, const char *what)
{
    if (d.status != CTL_OK) {
        (void)printf("refused %s %d %u\n", what, (int)d.status, (unsigned)d.field);
    }
}

void  inlined_sincos(angle_t angle, num_t *sine, num_t *cosine);
num_t inlined_sqrt(num_t x);
num_t inlined_pll_step(ctl_pll_t *self, angle_t theta);

static void numeric(void)
{
    num_t s, c, a[CTL_LAGRANGE_TAPS];
    for (uint32_t k = 0U; k < 2000U; k++) {
        MEASURE("angle_sincos", inlined_sincos(k * 0x1234567U, &s, &c));
        MEASURE("angle_from_rad", (void)angle_from_rad(noise() * 20.0f));
        MEASURE("num_sqrt", (void)inlined_sqrt(fabsf(noise()) * 100.0f));
        MEASURE("num_pow", (void)num_pow(fabsf(noise()) * 100.0f, 0.6f));
        MEASURE("ctl_lagrange", ctl_lagrange((uint16_t)(k % 4U), fabsf(noise()), a));
    }
}

static void motor(void)
{
    static ctl_pi_t       pi;
    static ctl_pll_t      pll;
    static ctl_mt_t       mt;
    const ctl_pi_params_t pp = {0.6f, 0.1f, -10.0f, 10.0f, CTL_PI_HOLD_OUTWARD};
    need(ctl_pi_init(&pi, &pp), "pi");
    const ctl_pll_params_t lp = {0.0754f, 0.142f, 1.0e-4f, 3000.0f};
    need(ctl_pll_init(&pll, &lp), "pll");
    const ctl_mt_params_t mp = {200000U, 1.5707963f, 3000.0f, 100U};
    need(ctl_mt_init(&mt, &mp), "mt");
    static ctl_plausibility_t       plausibility;
    const ctl_plausibility_params_t up = {1.0f, 1.0f, 32.0f, 0.09f, 0.5f, 0.1f, 0.05f, 10.0f, 0.001f, 0.03f, 0.5f, 0.2f};
    need(ctl_plausibility_init(&plausibility, &up), "plausibility");
    int32_t  count = 0;
    uint32_t now = 0U;
    for (uint32_t k = 0U; k < 4000U; k++) {
        const ctl_abc_t   i = {noise(), noise(), noise()};
        const ctl_rotor_t r = {0.6f, 0.8f};
        const ctl_dq_t    v = {20.0f * noise(), 20.0f * noise()};
        ctl_ab_t          ab;
        ctl_dq_t          dq;
        ctl_abc_t         duty;
        num_t             out = 0.0f;
        MEASURE("ctl_clarke", (void)ctl_clarke(&i, &ab));
        MEASURE("ctl_park", (void)ctl_park(&ab, &r, &dq));
        MEASURE("ctl_inverse_park", (void)ctl_inverse_park(&v, &r, &ab));
        MEASURE("ctl_vector_limit", (void)ctl_vector_limit(&v, 12.0f, &dq));
        MEASURE("ctl_svm", (void)ctl_svm(&ab, 24.0f, &duty));
        const ctl_plausibility_in_t seen = {dq, r, 100.0f, 24.0f, ab};
        MEASURE("ctl_plausibility_step", (void)ctl_plausibility_step(&plausibility, &seen));
        MEASURE("ctl_pi_output", out = ctl_pi_output(&pi, 30.0f * noise()));
        MEASURE("ctl_pi_commit", ctl_pi_commit(&pi, out));
        MEASURE("ctl_pll_step", (void)inlined_pll_step(&pll, k * 7000000U));
        now += 200000U;
        count += ((k % 300U) < 100U) ? 0 : (int32_t)(5.0f * noise());
        MEASURE("ctl_mt_step", (void)ctl_mt_step(&mt, count, now - (k % 997U), now));
    }
}

static void repetitive(void)
{
    static const char *const NAMES[3][3] = {{"ctl_rc_step keep", "ctl_rc_step clear", "ctl_rc_step angle"},
                                            {"ctl_rc_step fal keep", "ctl_rc_step fal clear", "ctl_rc_step fal angle"},
                                            {"ctl_rc_step fal keep five taps", "", "ctl_rc_step fal angle five taps"}};
    static ctl_rc_t          rc;
    static ctl_fal_t         fal;
    const ctl_fal_params_t   fp = {0.6f, 0.4f};
    need(ctl_fal_init(&fal, &fp), "fal");
    for (uint32_t k = 0U; k < 2000U; k++) {
        MEASURE("ctl_fal", (void)ctl_fal(&fal, 5.0f * noise()));
        MEASURE("ctl_fal_lambda", (void)ctl_fal_lambda(&fal, 5.0f * noise()));
        MEASURE("ctl_period_ratio", (void)ctl_period_ratio(15707.0f, 100.0f + (90.0f * noise())));
    }
    for (int f = 0; f < 3; f++) {
        for (int m = 0; m < 3; m += 2) {
            const ctl_rc_params_t p = {0.6f,
                                       5U,
                                       {0.45f, 0.1f, (f > 1) ? -0.05f : 0.0f},
                                       2U,
                                       false,
                                       (f != 0) ? CTL_RC_FAL_INPUT : CTL_RC_FAL_NONE,
                                       fp,
                                       (ctl_rc_memory_t)m,
                                       1000.0f,
                                       0.0f,
                                       0U};
            need(ctl_rc_init(&rc, &p, memory, (m == 2) ? 256U : 512U), "rc");
            angle_t at = 0U;
            for (uint32_t k = 0U; k < 4000U; k++) {
                const ctl_period_t n = ctl_period_ratio(15707.0f, 157.0f + ((k > 2000U) ? (0.3f * noise()) : 0.0f));
                at += 43000000U;
                MEASURE(NAMES[f][m], (void)ctl_rc_step(&rc, 5.0f * noise(), n, at));
            }
        }
    }
}

static void position(void)
{
    static ctl_profile_t       profile;
    static ctl_ilc_t           ilc;
    static ctl_src_t           src;
    const ctl_ilc_params_t     ip = {0.2f, 12U, 4.0f};
    const ctl_src_params_t     sp = {0.03f, 0x3F000000U, 4.0f};
    const ctl_profile_params_t pp = {(int64_t)1 << 22, (int64_t)1 << 14, 16U, 1.0e-3f, 1.0e-3f};
    need(ctl_profile_init(&profile, &pp), "profile");
    ctl_profile_reset(&profile.state, 0);
    need(ctl_ilc_init(&ilc, &ip, memory, 720U), "ilc");
    angle_t at = 0U;
    for (uint32_t k = 0U; k < 6000U; k++) {
        MEASURE("ctl_profile_step", (void)ctl_profile_step(&profile, (k < 3000U) ? ((int64_t)1 << 33) : -((int64_t)1 << 32)));
        at += 14000000U + (uint32_t)(int32_t)(1.0e6f * noise());
        MEASURE("ctl_ilc_step", (void)ctl_ilc_step(&ilc, at, noise()));
    }
    need(ctl_src_init(&src, &sp, memory, 720U), "src");
    for (uint32_t k = 0U; k < 6000U; k++) {
        at += 14000000U;
        MEASURE("ctl_src_step", (void)ctl_src_step(&src, at, 10.0f + noise(), noise()));
    }
}

/* ---- the drive ----------------------------------------------------------------------------------------------------- */
typedef struct {
    const char *current_row, *speed_row;
    uint16_t    method, deadbeat, position, is_position, rc_memory, cubic, observer, correction, dead, model, weakening, guard;
} variant_t;

/* of variant_t.guard */
#define GUARD_RAMP 1U   /* a reference that goes along an S curve all the time */
#define GUARD_TORQUE 2U /* torque mode, in and out of its limit */
#define GUARD_HEAT 4U   /* I2t of motor and bridge */
#define GUARD_NOTCH 8U  /* notch filter behind the speed controller */
#define GUARD_ANGLE 16U /* error of the encoder, with the speed by M/T */
#define GUARD_FLUX 32U  /* harmonics of the magnet flux */
#define GUARD_BRAKE 64U /* a dc link that bounds the braking */
#define GUARD_IRON 256U /* inductance that falls with the current */
#define GUARD_SINE 128U /* excitation of the current, of the torque and of the speed, one after the other */

static const variant_t VARIANTS[] = {
    {"current_isr pi", "speed_isr pi", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr pi deadbeat", "speed_isr pi deadbeat", 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr current correction", "speed_isr current correction", 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0},
    {"current_isr dead time", "speed_isr dead time", 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0},
    {"current_isr speed ramp", "speed_isr speed ramp", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, GUARD_RAMP},
    {"current_isr torque mode", "speed_isr torque mode", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, GUARD_TORQUE},
    {"current_isr overload", "speed_isr overload", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, GUARD_HEAT},
    {"current_isr braking", "speed_isr braking", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, GUARD_BRAKE},
    {"current_isr speed notch", "speed_isr speed notch", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, GUARD_NOTCH},
    {"current_isr encoder error", "speed_isr encoder error", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, GUARD_ANGLE},
    {"current_isr flux harmonics", "speed_isr flux harmonics", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, GUARD_FLUX},
    {"current_isr saturation", "speed_isr saturation", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, GUARD_IRON},
    {"current_isr excitation", "speed_isr excitation", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, GUARD_SINE},
    {"current_isr speed model", "speed_isr speed model", 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0},
    {"current_isr field weakening", "speed_isr field weakening", 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0},
    {"current_isr aro field weakening", "speed_isr aro field weakening", 6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0},
    {"current_isr crc", "speed_isr crc", 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr forc", "speed_isr forc", 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr fal-forc", "speed_isr fal-forc", 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr fal-forc angle", "speed_isr fal-forc angle", 3, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr fal-forc angle dob", "speed_isr fal-forc angle dob", 3, 0, 0, 0, 2, 0, 1, 0, 0, 0, 0, 0},
    {"current_isr dob", "speed_isr dob", 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr ro", "speed_isr ro", 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr aro", "speed_isr aro", 6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr aro extended", "speed_isr aro extended", 6, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0},
    {"current_isr dob deadbeat", "speed_isr dob deadbeat", 4, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr ro deadbeat", "speed_isr ro deadbeat", 5, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr aro deadbeat", "speed_isr aro deadbeat", 6, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr position ppi", "speed_isr position ppi", 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr position silc", "speed_isr position silc", 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr position src", "speed_isr position src", 0, 0, 2, 1, 0, 0, 0, 0, 0, 0, 0, 0},
    {"current_isr position rdc", "speed_isr position rdc", 0, 0, 3, 1, 0, 0, 0, 0, 0, 0, 0, 0},
};

static drive_t drive;

/* A call of its own: in the block it is inlined. */
static num_t __attribute__((noinline)) harmonics_at(const ctl_harmonics_t *lines, ctl_position_t position)
{
    return ctl_harmonics(lines, position);
}

static void run(const variant_t *v)
{
    drive_params_t p;
    params_default(&p);
    p.offset_calibration_periods = 0U;
    p.align_periods = 0U;
    p.method = v->method;
    p.current_controller = v->deadbeat;
    p.rc_memory = v->rc_memory;
    p.disturbance_observer = v->observer;
    p.rc_freeze_above_unit = (v->observer != 0U) ? 5.0f : 0.0f; /* all that goes beyond the published method */
    p.speed_setpoint_weight = (v->observer != 0U) ? 0.0f : 1.0f;
    p.speed_deviation_s = 60.0f; /* this shaft does not care about torque, */
    p.bridge_tolerance = 1.0f;   /* these currents not about voltages */
    p.motor_inductance_tolerance = 10.0f;
    p.current_correction = v->correction;
    p.dead_time_s = (v->dead != 0U) ? 1.0e-6f : 0.0f;
    p.speed_model_ff = v->model;
    const uint32_t seed_of_the_others = seed; /* a row of its own changes no other row's numbers */
    if ((v->guard & GUARD_RAMP) != 0U) {
        p.speed_ramp_rad_s2 = 1000.0f;
        p.speed_jerk_rad_s3 = 20000.0f;
    }
    p.speed_notch_hz = ((v->guard & GUARD_NOTCH) != 0U) ? 60.0f : 0.0f;
    p.encoder_sin1_rad = ((v->guard & GUARD_ANGLE) != 0U) ? 0.01f : 0.0f;
    p.flux_cos6 = ((v->guard & GUARD_FLUX) != 0U) ? 0.05f : 0.0f;
    p.saturation_a = ((v->guard & GUARD_IRON) != 0U) ? 8.0f : 0.0f;
    if ((v->guard & GUARD_HEAT) != 0U) {
        p.motor_continuous_a = 90.0f;
        p.bridge_continuous_a = 90.0f;
    }
    if ((v->guard & GUARD_BRAKE) != 0U) {
        p.regeneration_limit_v = 25.0f; /* of 24 V: a quarter of the torque is left */
        p.regeneration_band_v = 1.333f;
        p.chopper_v = 23.0f;
        p.chopper_band_v = 0.6f;
        p.chopper_continuous_w = 1000.0f;
    }
    if (v->weakening != 0U) { /* a speed from 5 % below the base speed of this machine to 15 % above */
        p.mtpa = 1U;
        p.field_weakening = 1U;
        p.motor_lq_h = 0.3e-3f;
        p.motor_psi_wb = 0.034f;
        p.link_withstand_v = 1000.0f;
    }
    p.position_method = v->position;
    p.following_error_rad = 100.0f;
    p.profile_speed_rad_s = 40.0f;
    p.profile_accel_rad_s2 = 500.0f;
    p.over_current_a = 100.0f;
    p.over_speed_rad_s = 2000.0f;
    p.aro_write = 0U; /* as printed, which the published figure is for */
    if (v->cubic != 0U) {
        p.aro_write = 2U; /* the default */
        p.aro_read = 1U;
        p.aro_remove_mean = 1U;
    }
    if ((v->position == 3U) || (v->model != 0U)) {
        p.rdc_coulomb_nm = 0.01f;
        p.rdc_static_nm = 0.015f;
        p.rdc_line1_cycles = 4.0f;
        p.rdc_line1_nm = 0.01f;
        p.rdc_line2_cycles = 24.0f;
        p.rdc_line2_nm = 0.01f;
        p.rdc_p31 = 0.1f;
        p.rdc_p32 = 0.1f;
        p.rdc_p33 = 0.1f;
        p.rdc_rho_nm = 0.01f;
    }
    (void)memset(&drive, 0, sizeof drive);
    sample = (hal_sample_t){0.0f, 0.0f, 0.0f, 24.0f, 0U, 0U, 0U};
    edge = (hal_encoder_edge_t){0, 0U, 0U, 0.0f};
    drive_init(&drive, &p);
    drive_start(&drive);
    for (int pass = 0; pass < 5; pass++) {
        drive_background(&drive);
    }
    float turn = 0.0f, speed = 0.0f;
    for (uint32_t k = 0U; k < 20000U; k++) {
        drive_command_t c = {(v->is_position != 0U)              ? DRIVE_MODE_POSITION
                             : ((v->guard & GUARD_TORQUE) != 0U) ? DRIVE_MODE_TORQUE
                                                                 : DRIVE_MODE_SPEED,
                             100.0f + (float)(k % 40U),
                             0.0f,
                             ((v->guard & GUARD_TORQUE) != 0U) ? 3.0f : 0.0f,
                             (k < 10000U) ? 20 : -20,
                             1.0f};
        speed = (k < 4000U) ? ((float)k * 0.025f) : (100.0f + (20.0f * sinf((float)k * 0.01f)));
        turn += speed * 1.0e-4f / 6.2831853f;
        turn -= floorf(turn);
        if (v->is_position != 0U) { /* follow the command, with some error */
            const float wanted =
                (float)(uint32_t)(uint64_t)(drive.position.setpoint.position + drive.position.zero) / 4294967296.0f;
            turn = wanted + (0.002f * sinf((float)k * 0.005f));
            turn -= floorf(turn);
        }
        sample.theta_m = (uint32_t)floorf(turn * 4000.0f) * 1073742U;
        sample.ia_a = 4.0f * noise();
        sample.ib_a = 4.0f * noise();
        sample.ic_a = -sample.ia_a - sample.ib_a;
        sample.seq++;
        clock_now += 20000U;
        sample.at_cyc = clock_now;
        edge.edge_count += (int32_t)(speed * 0.0636f);
        edge.edge_cyc = clock_now - 77U;
        if ((k % 10U) == 0U) {
            (void)drive_command(&drive, &c);
            if ((v->guard & GUARD_SINE) != 0U) {
                const drive_excitation_t e = {(drive_excite_t)(1U + ((k / 10U) % 3U)), 1.0f, 133.0f};
                float                    low, high, hz;
                (void)drive_excite(&drive, &e, &low, &high, &hz);
            }
            drive_background(&drive);
        }
        if (k < 20U) { /* start-up: no sample before this one, no durations noted yet */
            drive_current_isr(&drive);
            drive_watch_isr(&drive);
            if (speed_wanted) {
                drive_speed_isr(&drive);
            }
            speed_wanted = false;
            continue;
        }
        MEASURE(v->current_row, drive_current_isr(&drive));
        MEASURE("watch run", drive_watch_isr(&drive));
        if (speed_wanted) {
            speed_wanted = false;
            MEASURE(v->speed_row, drive_speed_isr(&drive));
        }
    }
    if (v->guard != 0U) {
        seed = seed_of_the_others;
    }
    if (drive.state != DRIVE_RUN) {
        (void)printf("refused %s state %d fault %d detail %u\n", v->current_row, (int)drive.state, (int)drive.fault,
                     (unsigned)drive.fault_detail);
    }
    /* The observers of the last variant, alone, with what the drive made of their parameters. */
    if (v->method >= 4U) {
        static const char *const NAMES[] = {"ctl_observer_step dob", "ctl_observer_step ro", "ctl_observer_step aro",
                                            "ctl_observer_step aro extended"};
        angle_t                  at = 0U;
        for (uint32_t k = 0U; k < 8000U; k++) {
            at += 7000000U + (uint32_t)(int32_t)(1.0e6f * noise());
            ctl_meter_out_t seen;
            MEASURE("ctl_meter_step", seen = ctl_meter_step(&drive.observer.meter, at, noise()));
            MEASURE(NAMES[(v->method - 4U) + v->cubic],
                    (void)ctl_observer_step(&drive.observer.observer, at, 100.0f + seen.speed * 0.001f, noise()));
            if ((k % 10U) == 0U) {
                MEASURE("ctl_observer_target", ctl_observer_target(&drive.observer.observer, 100.0f + noise()));
            }
        }
        for (uint32_t k = 0U; k < 2000U; k++) {
            MEASURE("ctl_fir_step", (void)ctl_fir_step(&drive.observer.meter.state.speed_fir, noise()));
        }
    }
    if (v->deadbeat != 0U) {
        static ctl_deadbeat_t deadbeat;
        need(ctl_deadbeat_init(&deadbeat, &drive.setup->current.deadbeat), "deadbeat");
        for (uint32_t k = 0U; k < 4000U; k++) {
            const ctl_dq_t m = {4.0f * noise(), 4.0f * noise()}, r = {4.0f * noise(), 4.0f * noise()},
                           u = {4.0f * noise(), 4.0f * noise()};
            MEASURE("ctl_deadbeat_step", (void)ctl_deadbeat_step(&deadbeat, &m, &r, 100.0f, &u));
        }
    }
    if (v->position == 3U) {
        static ctl_rdc_t rdc;
        need(ctl_rdc_init(&rdc, &drive.setup->position.rdc), "rdc");
        for (uint32_t k = 0U; k < 4000U; k++) {
            const ctl_setpoint_t s = {(ctl_position_t)k * 9000000, 30.0f * noise(), 4.0f * noise(), false};
            MEASURE("ctl_rdc_step", (void)ctl_rdc_step(&rdc, &s, noise(), noise()));
            MEASURE("ctl_friction", (void)ctl_friction(&rdc.params.friction, 3.0f * noise()));
            MEASURE("ctl_harmonics", (void)harmonics_at(&rdc.params.harmonics, (ctl_position_t)k * 9000000));
        }
    }
}

/* ---- parameters on their way to the interrupt --------------------------------------------------------------------------- */
static void begin_with(const drive_params_t *p, uint32_t running)
{
    (void)memset(&drive, 0, sizeof drive);
    sample = (hal_sample_t){0.0f, 0.0f, 0.0f, 24.0f, 0U, 0U, 0U};
    drive_init(&drive, p);
    if (running != 0U) {
        drive_start(&drive);
    }
    for (int pass = 0; pass < 5; pass++) {
        drive_background(&drive);
    }
}

static void change(const char *tune_row, const char *take_over_row, const drive_params_t *p)
{
    uint16_t culprit = 0U;
    bool     taken = false;
    MEASURE(tune_row, taken = drive_tune(&drive, p, &culprit));
    if (!taken) {
        (void)printf("refused %s parameter %u\n", take_over_row, (unsigned)culprit);
        return;
    }
    MEASURE(take_over_row, drive_take_over(&drive));
}

/* Gains while the drive runs. */
static void change_gains(const char *row, uint16_t method, uint16_t position)
{
    drive_params_t p;
    params_default(&p);
    p.offset_calibration_periods = 0U;
    p.align_periods = 0U;
    p.method = method;
    p.aro_cells = 2048U;
    p.position_method = position;
    begin_with(&p, 1U);
    for (int k = 0; k < 20; k++) {
        p.current_kp_v_per_a = 0.5f + (0.01f * (float)k);
        p.speed_kp_a_per_unit = 0.03f + (0.001f * (float)k);
        p.rc_gain = 0.3f + (0.01f * (float)k);
        p.rc_fal_alpha = 0.5f + (0.01f * (float)k);
        p.observer_gain = 0.01f + (0.01f * (float)k);
        p.observer_inertia_kgm2 = 7.0e-5f + (1.0e-6f * (float)k);
        p.position_kp_per_s = 5.0f + (float)k;
        change("drive_tune gains", row, &p);
    }
}

#ifdef COUNT_INSTRUCTIONS
#define WHOLE_SETS 1U /* an emulated processor is slow */
#else
#define WHOLE_SETS 6U
#endif

/* Another value of a parameter: an end of its range, the next choice, or one nearby. */
static float another(const drive_params_t *p, uint16_t index)
{
    const param_info_t *const info = params_info(index);
    const float               now = params_get(p, index);
    const float               chance = noise();
    if (info->max <= 6.0f) { /* switches, choices, and what is as small */
        return (now < info->max) ? floorf(now + 1.0f) : info->min;
    }
    if (info->kind != PARAM_KIND_FLOAT) {
        return floorf(info->min + (fabsf(chance) * (info->max - info->min)));
    }
    if (chance > 0.8f) {
        return info->max;
    }
    return (chance > 0.7f) ? info->min : (now * (1.0f + (0.3f * noise())));
}

/* Everything at once that may change while the drive runs, as far as the parameters let each other. */
static void change_whole_set(drive_params_t *p)
{
    static drive_setup_t scratch;
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        drive_params_t trial = *p;
        if (!params_only_at_rest(i) && params_set(&trial, i, another(p, i)) &&
            (drive_make_setup(&trial, &scratch) == (uint16_t)PARAM_COUNT)) {
            *p = trial;
        }
    }
}

/* Every method with every position method and either current controller: whole sets, then every parameter alone to both ends. */
static void change_all_that_may(void)
{
    static drive_setup_t scratch;
    for (unsigned v = 0U; v < 7U * 4U * 2U; v++) {
        drive_params_t p;
        params_default(&p);
        p.offset_calibration_periods = 0U;
        p.align_periods = 0U;
        p.method = (uint16_t)(v % 7U);
        p.position_method = (uint16_t)((v / 7U) % 4U);
        p.current_controller = (uint16_t)(v / 28U);
        p.rc_order = (uint16_t)(1U + (v % 3U));
        if (drive_make_setup(&p, &scratch) != (uint16_t)PARAM_COUNT) {
            continue; /* these do not go together */
        }
        begin_with(&p, 1U);
        for (unsigned k = 0U; k < WHOLE_SETS; k++) {
            change_whole_set(&p);
            change("drive_tune running", "take-over running", &p);
        }
#ifndef COUNT_INSTRUCTIONS
        for (unsigned i = 0U; i < 2U * (unsigned)PARAM_COUNT; i++) {
            const uint16_t index = (uint16_t)(i / 2U);
            drive_params_t one = p;
            if (!params_only_at_rest(index) &&
                params_set(&one, index, ((i & 1U) != 0U) ? params_info(index)->max : params_info(index)->min) &&
                (drive_make_setup(&one, &scratch) == (uint16_t)PARAM_COUNT)) {
                change("drive_tune running", "take-over running", &one);
            }
        }
#endif
        if (drive.state != DRIVE_RUN) {
            (void)printf("refused take-over running state %d\n", (int)drive.state);
        }
    }
}

/* Every method and size to every other, at rest: the main loop sets up, the interrupt takes over. */
static void change_shapes(void)
{
    drive_params_t set[16];
    unsigned       sets = 0U;
    for (unsigned method = 0U; method < 7U; method++) {
        for (unsigned large = 0U; large < 2U; large++) {
            drive_params_t *const p = &set[sets++];
            params_default(p);
            p->offset_calibration_periods = 0U;
            p->align_periods = 0U;
            p->method = (uint16_t)method;
            p->current_controller = (uint16_t)large;
            p->aro_cells = (large != 0U) ? 2048U : 200U;
            p->position_cells = (large != 0U) ? 2048U : 100U;
            p->position_method = (uint16_t)(((method < 4U) && (large != 0U)) ? method : 0U);
            p->observer_fir1_order = (large != 0U) ? 15U : 9U;
            p->observer_fir2_order = (large != 0U) ? 15U : 10U;
            p->speed_source = (uint16_t)((large != 0U) ? 2U : 1U);
        }
    }
    for (unsigned a = 0U; a < sets; a++) {
        for (unsigned b = 0U; b < sets; b++) {
            begin_with(&set[a], 0U);
            change("drive_tune at rest", "take-over at rest", &set[b]);
        }
    }
}

/* A whole alignment, with a rotor that follows its vector and swings a little. */
static void alignment(void)
{
    drive_params_t p;
    params_default(&p);
    p.bridge_tolerance = 1.0f;
    p.motor_inductance_tolerance = 10.0f;
    p.offset_calibration_periods = 0U;
    p.over_current_a = 100.0f;
    (void)memset(&drive, 0, sizeof drive);
    sample = (hal_sample_t){0.0f, 0.0f, 0.0f, 24.0f, 0U, 0U, 0U};
    edge = (hal_encoder_edge_t){0, 0U, 0U, 0.0f};
    drive_init(&drive, &p);
    drive_start(&drive);
    float rotor = 0.0f;
    for (uint32_t k = 0U; (k < 60000U) && (drive.state != DRIVE_RUN) && (drive.state != DRIVE_FAULT); k++) {
        const float swing = 0.002f * sinf((float)k * 0.03f);
        if (drive.align.phase >= (uint16_t)DRIVE_ALIGN_PULL) {
            rotor += 0.01f * ((float)(int32_t)(drive.align.vector - (angle_t)(int64_t)(rotor * 4294967296.0f)) / 4294967296.0f);
        }
        sample.theta_m = (uint32_t)(int64_t)floorf((rotor + swing) * 1000.0f) * 1073742U;
        sample.ia_a = 4.0f * noise();
        sample.ib_a = 4.0f * noise();
        sample.ic_a = -sample.ia_a - sample.ib_a;
        if (drive.align.phase < (uint16_t)DRIVE_ALIGN_PULL) {
            sample.theta_m = 0U;
        }
        sample.seq++;
        clock_now += 20000U;
        sample.at_cyc = clock_now;
        edge.edge_cyc = clock_now - 77U;
        if ((k % 10U) == 0U) {
            drive_background(&drive);
        }
        if (k < 20U) {
            drive_current_isr(&drive);
            drive_watch_isr(&drive);
            if (speed_wanted) {
                drive_speed_isr(&drive);
            }
            speed_wanted = false;
            continue;
        }
        MEASURE("current_isr align", drive_current_isr(&drive));
        MEASURE("watch align", drive_watch_isr(&drive));
        if (speed_wanted) {
            speed_wanted = false;
            MEASURE("speed_isr align", drive_speed_isr(&drive));
        }
    }
    if (drive.state != DRIVE_RUN) {
        (void)printf("refused alignment state %d fault %d phase %u pass %u\n", (int)drive.state, (int)drive.fault,
                     drive.align.phase, drive.align.pass);
    }
}

int services_cases(drive_t *of, void (*note_case)(const char *, uint64_t));

int main(void)
{
#ifndef COUNT_INSTRUCTIONS
    if (port_cases(note) != 0) {
        (void)printf("refused port\n");
    }
#endif
    numeric();
    motor();
    repetitive();
    position();
    for (unsigned i = 0U; i < sizeof VARIANTS / sizeof VARIANTS[0]; i++) {
        run(&VARIANTS[i]);
    }
    change_gains("take-over gains pi", 0U, 0U);
    change_gains("take-over gains fal-forc", 3U, 0U);
    change_gains("take-over gains aro", 6U, 0U);
    change_gains("take-over gains position src", 0U, 2U);
    change_all_that_may();
    change_shapes();
    alignment();
    run(&VARIANTS[sizeof VARIANTS / sizeof VARIANTS[0] - 1U]); /* the services look at a drive that runs */
#ifdef COUNT_INSTRUCTIONS
    for (unsigned i = 0U; i < row_count; i++) {
        (void)printf("%u\t%s\n", i + 1U, rows[i].name);
    }
#else
    (void)services_cases(&drive, note);
    for (unsigned i = 0U; i < row_count; i++) {
        (void)printf("%s\t%llu\t%llu\t%llu\n", rows[i].name, (unsigned long long)rows[i].calls,
                     (unsigned long long)(rows[i].sum / rows[i].calls), (unsigned long long)rows[i].max);
    }
#endif
    return 0;
}
