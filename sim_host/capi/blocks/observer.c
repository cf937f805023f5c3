#include "control/observer/observer.h"

#include "control/observer/torque_meter.h"
#include <math.h>

#include "sim_host/capi/block.h"

enum {
    KIND,
    INERTIA,
    VISCOUS,
    TS,
    FIR1_ORDER,
    FIR1_HZ,
    FIR2_ORDER,
    FIR2_HZ,
    ACTUATION,
    AGE,
    GAIN,
    FORGETTING,
    CELLS,
    WRITE,
    READ
};

#define LIMIT_NM 1.0e6
#define RO_SAMPLES 8192

typedef struct {
    ctl_meter_t    meter;
    ctl_observer_t observer;
} torque_observer_t;

static int cells(const double *p) { return ((int)p[KIND] == (int)CTL_OBSERVER_ARO) ? (int)p[CELLS] : RO_SAMPLES; }

static int start_meter(ctl_meter_t *meter, const double *p, ctl_meter_params_t *m)
{
    static const int PARAM_OF[] = {[CTL_METER_SPEED] = TS,     [CTL_METER_TORQUE] = INERTIA, [CTL_METER_A22] = VISCOUS,
                                   [CTL_METER_FIR1] = FIR1_HZ, [CTL_METER_FIR2] = FIR2_HZ,   [CTL_METER_ACTUATION] = ACTUATION,
                                   [CTL_METER_STEP] = TS};
    m->speed_per_rad = capi_signal_in(1.0 / p[TS]);
    m->torque_per_16 = capi_signal_in(p[INERTIA] / p[TS] / 16.0);
    m->a22 = capi_signal_in(1.0 - p[VISCOUS] * p[TS] / p[INERTIA]);
    m->actuation = capi_signal_in(p[ACTUATION]);
    m->step_max_rad = NUM_C(3.1415f);
    if (ctl_fir_design(&m->fir1, (uint16_t)p[FIR1_ORDER], capi_signal_in(p[FIR1_HZ] * p[TS])).status != CTL_OK) {
        return FIR1_HZ;
    }
    if (ctl_fir_design(&m->fir2, (uint16_t)p[FIR2_ORDER], capi_signal_in(p[FIR2_HZ] * p[TS])).status != CTL_OK) {
        return FIR2_HZ;
    }
    return capi_refused(ctl_meter_init(meter, m), PARAM_OF, sizeof PARAM_OF / sizeof PARAM_OF[0], INERTIA);
}

static int start(void *self, const double *p, num_t *memory, int count)
{
    static const int PARAM_OF[] = {
        [CTL_OBSERVER_KIND] = KIND,  [CTL_OBSERVER_GAIN] = GAIN,      [CTL_OBSERVER_FORGETTING] = FORGETTING,
        [CTL_OBSERVER_LIMIT] = GAIN, [CTL_OBSERVER_AGE] = AGE,        [CTL_OBSERVER_AHEAD] = ACTUATION,
        [CTL_OBSERVER_RAD] = TS,     [CTL_OBSERVER_FAST_GAIN] = GAIN, [CTL_OBSERVER_REST] = GAIN,
        [CTL_OBSERVER_SYNC] = GAIN,  [CTL_OBSERVER_MEMORY] = CELLS};
    torque_observer_t *const made = self;
    ctl_meter_params_t       m;
    const int                refused = start_meter(&made->meter, p, &m);
    if (refused != CAPI_STARTED) {
        return refused;
    }
    const ctl_observer_params_t o = {
        .kind = (ctl_observer_kind_t)(int)p[KIND],
        .memory = {capi_signal_in(p[GAIN]), capi_signal_in(p[FORGETTING]), (ctl_write_t)(int)p[WRITE], (ctl_read_t)(int)p[READ],
                   capi_in(LIMIT_NM)},
        .age_half = (p[AGE] > 0.0) ? (uint16_t)(2.0 * p[AGE] + 0.5) : ctl_meter_age_half(&m),
        .ahead = m.actuation,
        .rad_per_64 = capi_signal_in(64.0 * p[TS]),
        .fast_gain = capi_signal_in(p[GAIN]),
    };
    return capi_refused(ctl_observer_init(&made->observer, &o, memory, (uint16_t)count), PARAM_OF,
                        sizeof PARAM_OF / sizeof PARAM_OF[0], KIND);
}

/* As the current interrupt does it, but with the speed of the first filter, which is what a log has: the drive gives the
 * observer that of its tracking filter. */
static void step(void *self, const double *in, double *out)
{
    torque_observer_t *const o = self;
    const angle_t            theta = capi_angle_in(in[0]);
    const num_t              ref = capi_signal_in(in[1]);
    ctl_meter_out_t          m;
    num_t                    expected;
    if (!capi_usable(in, 2)) {
        m = ctl_meter_step(&o->meter, theta, ref);
        expected = ctl_observer_step(&o->observer, theta, m.speed, m.torque);
    } else {
        const num_t travel = ctl_meter_travel(&o->meter, theta);
        if (ctl_meter_is_fast(&o->meter, travel) && o->observer.state.ready) {
            m.torque = ctl_meter_torque_fast(&o->meter, theta, travel, ref);
            m.speed = ctl_meter_speed_unchecked(&o->meter);
            expected = ctl_observer_step_fast(&o->observer, theta, m.speed, m.torque);
        } else {
            m.torque = ctl_meter_torque_unchecked(&o->meter, theta, ref);
            m.speed = ctl_meter_speed_unchecked(&o->meter);
            expected = ctl_observer_step_unchecked(&o->observer, theta, m.speed, m.torque);
        }
    }
    out[0] = capi_out(expected);
    out[1] = capi_out(m.speed);
    out[2] = capi_out(m.torque);
}

static void target(void *self, const double *in, double *out)
{
    (void)out;
    ctl_observer_target(&((torque_observer_t *)self)->observer, capi_usable(in, 1) ? capi_signal_in(in[0]) : (num_t)0);
}

static void age(void *self, const double *in, double *out)
{
    (void)in;
    out[0] = 0.5 * ((const torque_observer_t *)self)->observer.params.age_half;
}

const capi_block_t block_observer =
    {
        .name = "observer",
        .doc = "Measures the disturbance torque from the encoder and predicts it for the moment when a reference of now acts.",
        .param =
            {
                [KIND] = {"kind", "", CAPI_CHOICE, 2, 0, 2, "One state, memory over time, or memory over the angle.",
                          .choices = "dob|ro|aro"},
                [INERTIA] = {"inertia_kgm2", "kg m^2", CAPI_REAL, 7.06e-5, 0.0, 1000.0, "Inertia that it assumes.", CAPI_ABOVE,
                             .rule = "such that the numeric can hold inertia over sampling time"},
                [VISCOUS] = {"viscous_nms", "N m s/rad", CAPI_REAL, 0.0, 0.0, 1000.0, "Viscous friction that it assumes.",
                             .rule = "at most inertia_kgm2 / ts_s"},
                [TS] = {"ts_s", "s", CAPI_REAL, 1.0e-4, 0.0, INFINITY, "Sampling time.", CAPI_ABOVE,
                        .rule = "such that the numeric can hold it"},
                [FIR1_ORDER] = {"fir1_order", "", CAPI_WHOLE, 9, 0, 15, "Order of the filter of the speed."},
                [FIR1_HZ] = {"fir1_hz", "Hz", CAPI_REAL, 1000.0, 0.0, INFINITY, "Corner of the filter of the speed.", CAPI_ABOVE,
                             .rule = "within 0.0001 and 0.5 of the sampling rate"},
                [FIR2_ORDER] = {"fir2_order", "", CAPI_WHOLE, 10, 0, 15, "Order of the filter of the torque."},
                [FIR2_HZ] = {"fir2_hz", "Hz", CAPI_REAL, 1000.0, 0.0, INFINITY, "Corner of the filter of the torque.", CAPI_ABOVE,
                             .rule = "within 0.0001 and 0.5 of the sampling rate"},
                [ACTUATION] = {"actuation_samples", "sample", CAPI_REAL, 2.0, 0.5, 12.0,
                               "From a torque reference to the middle of its action."},
                [AGE] = {"age_samples", "sample", CAPI_REAL, 0.0, 0.0, 31.0,
                         "Age that it takes the measured torque to have; 0: the true one, from its filters."},
                [GAIN] = {"gain", "", CAPI_REAL, 0.05, 0.0, 1.0, "Learning gain a23 L_N.", CAPI_ABOVE,
                          .rule = "such that the numeric can hold it"},
                [FORGETTING] = {"forgetting", "", CAPI_REAL, 1.0, 0.0, 1.0, "Q; 1 forgets nothing."},
                [CELLS] = {"cells", "1/turn", CAPI_WHOLE, 200, 4, 4096, "aro: grid points per turn."},
                [WRITE] = {"write", "", CAPI_CHOICE, 0, 0, 2, "aro: which points a sample writes.", .choices = "one|all|hat"},
                [READ] = {"read", "", CAPI_CHOICE, 0, 0, 1, "aro: interpolation of the read-out.", .choices = "linear|cubic"},
            },
        .action =
            {
                {"step", "Angle now and torque reference of the last sample; gives the expected disturbance torque.",
                 "theta_m_rad|ref_last_nm", "expected_nm|speed_rad_s|torque_nm", step},
                {"target", "The speed at which the motor is meant to turn: ro takes its period from it.", "speed_rad_s", NULL,
                 target},
                {"age", "Age of the measured torque as it counts it.", NULL, "age_samples", age},
            },
        .size = sizeof(torque_observer_t),
        .cells = cells,
        .start = start,
};
