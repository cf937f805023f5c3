#include "control/position/profile.h"

#include <math.h>

#include "sim_host/capi/block.h"

enum { SPEED, ACCEL, SMOOTH, TS };

#define TURN_Q32 4294967296.0
#define HALF_TURN_Q32 2147483647.0

/* One unit is the largest speed, and the largest acceleration: both numerics keep their digits. */
typedef struct {
    ctl_profile_t profile;
    double        speed_unit, accel_unit;
} profile_t;

static ctl_position_t position_in(double rad)
{
    const double turns = rad / (2.0 * CAPI_PI);
    return (fabs(turns) < INFINITY) ? (ctl_position_t)llrint(turns * TURN_Q32) : 0;
}

static int start(void *self, const double *p, num_t *memory, int cells)
{
    profile_t *const made = self;
    const double     ts_s = p[TS];
    const double     step = p[SPEED] * ts_s / (2.0 * CAPI_PI) * TURN_Q32;
    const double     change = p[ACCEL] * ts_s * ts_s / (2.0 * CAPI_PI) * TURN_Q32;
    (void)memory;
    (void)cells;
    if (!((step >= 1.0) && (step < HALF_TURN_Q32))) {
        return SPEED;
    }
    if (!(change < HALF_TURN_Q32)) {
        return ACCEL;
    }
    made->speed_unit = p[SPEED];
    made->accel_unit = (p[ACCEL] > 0.0) ? p[ACCEL] : 1.0;
    const ctl_profile_params_t params = {
        .speed = (int64_t)step,
        .acceleration = ((change > 0.0) && (change < 1.0)) ? 1 : (int64_t)change,
        .smooth = (uint16_t)p[SMOOTH],
        .speed_scale = capi_signal_in(2.0 * CAPI_PI / 65536.0 / ts_s / made->speed_unit),
        .accel_scale = capi_signal_in(2.0 * CAPI_PI / 1048576.0 / (ts_s * ts_s) / made->accel_unit),
    };
    return (ctl_profile_init(&made->profile, &params).status == CTL_OK) ? CAPI_STARTED : SPEED;
}

static void step(void *self, const double *in, double *out)
{
    profile_t *const     p = self;
    const ctl_setpoint_t s = ctl_profile_step(&p->profile, position_in(in[0]));
    out[0] = (double)s.position / TURN_Q32 * 2.0 * CAPI_PI;
    out[1] = capi_out(s.speed) * p->speed_unit;
    out[2] = capi_out(s.acceleration) * p->accel_unit;
    out[3] = s.done ? 1.0 : 0.0;
}

static void reset(void *self, const double *in, double *out)
{
    (void)out;
    ctl_profile_reset(&((profile_t *)self)->profile.state, position_in(in[0]));
}

const capi_block_t block_profile = {
    .name = "profile",
    .doc = "A motion to a target, which may move, with limited speed, acceleration and jerk.",
    .param =
        {
            [SPEED] = {"speed_rad_s", "rad/s", CAPI_REAL, 1.0, 0.0, INFINITY, "Largest speed.", CAPI_ABOVE,
                       .rule = "such that a sample is at most half a turn, and the numeric can hold it"},
            [ACCEL] = {"accel_rad_s2", "rad/s^2", CAPI_REAL, 20.0, 0.0, INFINITY, "Largest acceleration; 0: the speed jumps.",
                       .rule = "at most half a turn per sample^2"},
            [SMOOTH] = {"smooth_samples", "sample", CAPI_WHOLE, 1, 1, 64,
                        "Samples over which the acceleration builds up; 1: at once."},
            [TS] = {"ts_s", "s", CAPI_REAL, 1.0e-3, 0.0, INFINITY, "Sampling time.", CAPI_ABOVE},
        },
    .action =
        {
            {"step", "Advance one sample towards the target; done: at it and at rest.", "target_rad",
             "position_rad|speed_rad_s|acceleration_rad_s2|done", step},
            {"reset", "Stand there.", "position_rad", NULL, reset},
        },
    .size = sizeof(profile_t),
    .start = start,
};
