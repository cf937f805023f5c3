/* The control blocks for Python: conversion of numbers, nothing else. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "control/motor/deadbeat.h"
#include "control/motor/frames.h"
#include "control/motor/mt_speed.h"
#include "control/motor/pi.h"
#include "control/motor/pll.h"
#include "control/motor/svm.h"
#include "control/numeric/lagrange.h"
#include "control/numeric/num_math.h"
#include "control/observer/observer.h"
#include "control/observer/torque_meter.h"
#include "control/position/friction.h"
#include "control/position/profile.h"
#include "control/position/rdc.h"
#include "control/position/src.h"
#include "control/repetitive/fal.h"
#include "control/repetitive/repetitive.h"
#include "sim_host/capi/evenspin_capi.h"

#define PI 3.14159265358979323846

static _Thread_local char message[160] = "";

const char *es_block_error(void) { return message; }

static num_t  in(double x) { return num_from_float((float)x); }
static double out(num_t x) { return (double)num_to_float(x); }
/* A signal keeps its NaN or infinity on the way in, so that the block's own guard is what answers. */
#ifdef EVENSPIN_FIXED
static num_t   signal_in(double x) { return isfinite(x) ? in(x) : INT32_MIN; }
static angle_t angle_in(double rad)
{
    return isfinite(rad) ? (angle_t)(int64_t)floor(fmod(rad / (2.0 * PI), 1.0) * 4294967296.0) : 0U;
}
#else
static num_t   signal_in(double x) { return (float)x; }
static angle_t angle_in(double rad)
{
    return isfinite(rad) ? (angle_t)(int64_t)floor(fmod(rad / (2.0 * PI), 1.0) * 4294967296.0) : 0U;
}
#endif

static void explain(const char *field, double given, const char *limit)
{
    (void)snprintf(message, sizeof message, "%s = %g: must be %s", field, given, limit);
}

int es_lagrange(int order, double frac, double *a_out)
{
    if ((a_out == NULL) || (order < 0) || (order >= (int)CTL_LAGRANGE_TAPS)) {
        explain("order", order, "within 0 .. 3");
        return 0;
    }
    if (!((frac >= 0.0) && (frac <= ((order > 0) ? order : 1)))) {
        explain("frac", frac, "within 0 .. order");
        return 0;
    }
    num_t a[CTL_LAGRANGE_TAPS];
    ctl_lagrange((uint16_t)order, in(frac), a);
    for (int k = 0; k <= order; k++) {
        a_out[k] = out(a[k]);
    }
    return order + 1;
}

static bool make_fal(ctl_fal_t *fal, double alpha, double delta)
{
    const ctl_fal_params_t p = {signal_in(alpha), signal_in(delta)};
    const ctl_diag_t       d = ctl_fal_init(fal, &p);
    if (d.status != CTL_OK) {
        explain((d.field == CTL_FAL_ALPHA) ? "alpha" : "delta", (d.field == CTL_FAL_ALPHA) ? alpha : delta,
                (d.field == CTL_FAL_ALPHA) ? "within 0 .. 1 and above 0" : "above 0");
    }
    return d.status == CTL_OK;
}

double es_fal(double e, double alpha, double delta)
{
    ctl_fal_t fal;
    return make_fal(&fal, alpha, delta) ? out(ctl_fal(&fal, signal_in(e))) : (double)NAN;
}

double es_fal_lambda(double e, double alpha, double delta)
{
    ctl_fal_t fal;
    return make_fal(&fal, alpha, delta) ? out(ctl_fal_lambda(&fal, signal_in(e))) : (double)NAN;
}

void es_sincos(double angle_rad, double *sine, double *cosine)
{
    num_t s, c;
    angle_sincos(angle_in(angle_rad), &s, &c);
    *sine = out(s);
    *cosine = out(c);
}

double es_pow(double base, double exponent) { return out(num_pow(in(base), in(exponent))); }

bool es_clarke(double a, double b, double c, double *alpha_beta)
{
    const ctl_abc_t x = {signal_in(a), signal_in(b), signal_in(c)};
    ctl_ab_t        y;
    const bool      good = ctl_clarke(&x, &y);
    alpha_beta[0] = out(y.alpha);
    alpha_beta[1] = out(y.beta);
    return good;
}

bool es_inverse_clarke(double alpha, double beta, double *abc)
{
    const ctl_ab_t x = {signal_in(alpha), signal_in(beta)};
    ctl_abc_t      y;
    const bool     good = ctl_inverse_clarke(&x, &y);
    abc[0] = out(y.a);
    abc[1] = out(y.b);
    abc[2] = out(y.c);
    return good;
}

static ctl_rotor_t rotor_at(double angle_rad)
{
    ctl_rotor_t r;
    angle_sincos(angle_in(angle_rad), &r.sine, &r.cosine);
    return r;
}

bool es_park(double alpha, double beta, double angle_rad, double *dq)
{
    const ctl_ab_t    x = {signal_in(alpha), signal_in(beta)};
    const ctl_rotor_t r = rotor_at(angle_rad);
    ctl_dq_t          y;
    const bool        good = ctl_park(&x, &r, &y);
    dq[0] = out(y.d);
    dq[1] = out(y.q);
    return good;
}

bool es_inverse_park(double d, double q, double angle_rad, double *alpha_beta)
{
    const ctl_dq_t    x = {signal_in(d), signal_in(q)};
    const ctl_rotor_t r = rotor_at(angle_rad);
    ctl_ab_t          y;
    const bool        good = ctl_inverse_park(&x, &r, &y);
    alpha_beta[0] = out(y.alpha);
    alpha_beta[1] = out(y.beta);
    return good;
}

bool es_vector_limit(double d, double q, double limit, double *dq)
{
    const ctl_dq_t x = {signal_in(d), signal_in(q)};
    ctl_dq_t       y;
    const bool     untouched = ctl_vector_limit(&x, signal_in(limit), &y);
    dq[0] = out(y.d);
    dq[1] = out(y.q);
    return untouched;
}

bool es_svm(double v_alpha, double v_beta, double v_dc, double *duty_abc)
{
    const ctl_ab_t x = {signal_in(v_alpha), signal_in(v_beta)};
    ctl_abc_t      y;
    const bool     good = ctl_svm(&x, signal_in(v_dc), &y);
    duty_abc[0] = out(y.a);
    duty_abc[1] = out(y.b);
    duty_abc[2] = out(y.c);
    return good;
}

/* ---- repetitive controller -------------------------------------------------------------------------------------------------- */

struct es_rc {
    ctl_rc_t rc;
    num_t    memory[];
};

es_rc_t *es_rc_new(double gain, int lead, double q_side, double q_centre, int order, int fal_at, double alpha, double delta,
                   bool truncate, int memory, int capacity, double limit, double freeze_above, int freeze_samples)
{
    static const char *const NAME[] = {"(pointer)", "gain",  "lead",   "q",     "order",        "fal_at",
                                       "alpha",     "delta", "memory", "limit", "freeze_above", "capacity"};
    static const char *const LIMIT[] = {"valid",
                                        "within 0 .. 100",
                                        "within 0 .. 15 samples, at least 2 for memory \"angle\"",
                                        "such that |centre| + 2 |side| <= 1",
                                        "within 0 .. 3",
                                        "\"input\" or \"output\"",
                                        "above 0 and at most 1",
                                        "above 0",
                                        "\"keep\", \"clear\" or \"angle\"",
                                        "above 0",
                                        ">= 0",
                                        "at least lead + order + 5, at most 32000 samples or 4096 cells"};
    const double given[] = {0, gain, lead, q_centre, order, fal_at, alpha, delta, memory, limit, freeze_above, capacity};

    if ((capacity < 1) || (capacity > 32000)) {
        explain(NAME[11], capacity, LIMIT[11]);
        return NULL;
    }
    if ((lead < 0) || (lead > 60000) || (order < 0) || (order > 60000) || (freeze_samples < 0) || (freeze_samples > 60000)) {
        explain((lead < 0) || (lead > 60000) ? "lead" : (((order < 0) || (order > 60000)) ? "order" : "freeze_samples"),
                (lead < 0) || (lead > 60000) ? lead : (((order < 0) || (order > 60000)) ? order : freeze_samples),
                "a small whole number >= 0");
        return NULL;
    }
    const ctl_rc_params_t p = {
        .gain = signal_in(gain),
        .lead = (uint16_t)lead,
        .q = {signal_in(q_side), signal_in(q_centre)},
        .order = (uint16_t)order,
        .truncate = truncate,
        .fal_at = (ctl_rc_fal_at_t)fal_at,
        .fal = {signal_in(alpha), signal_in(delta)},
        .memory = (ctl_rc_memory_t)memory,
        .limit = signal_in(limit),
        .freeze_above = signal_in(freeze_above),
        .freeze_samples = (uint16_t)freeze_samples,
    };
    /* a caller thinks in periods: room for the taps around the longest one comes on top */
    const int slack = (memory == (int)CTL_RC_ANGLE) ? 0 : 8;
    es_rc_t  *rc = calloc(1, sizeof *rc + (size_t)(capacity + slack) * sizeof rc->memory[0]);
    if (rc == NULL) {
        explain("capacity", capacity, "smaller: not enough memory");
        return NULL;
    }
    const ctl_diag_t d = ctl_rc_init(&rc->rc, &p, rc->memory, (uint16_t)(capacity + slack));
    if (d.status != CTL_OK) {
        const uint16_t f = (d.field < 12U) ? d.field : 0U;
        explain(NAME[f], given[f], LIMIT[f]);
        free(rc);
        return NULL;
    }
    return rc;
}

void es_rc_free(es_rc_t *rc) { free(rc); }

void es_rc_reset(es_rc_t *rc)
{
    if (rc != NULL) {
        ctl_rc_reset(&rc->rc);
    }
}

double es_rc_step(es_rc_t *rc, double error, double period_samples, double theta_e_rad)
{
    if (rc == NULL) {
        return (double)NAN;
    }
    ctl_period_t n = {0U, (num_t)0};
    if (period_samples >= 65535.0) {
        n.whole = 65535U;
    } else if (period_samples > 0.0) {
        n.whole = (uint16_t)period_samples;
        n.fraction = in(period_samples - (double)n.whole);
    } else {
        /* not a period: the block cuts it and counts */
    }
    return out(ctl_rc_step(&rc->rc, signal_in(error), n, angle_in(theta_e_rad)));
}

uint32_t es_rc_rejected(const es_rc_t *rc) { return (rc != NULL) ? rc->rc.state.rejected : 0U; }

/* ---- PI, tracking filter, M/T speed ------------------------------------------------------------------------------------------- */

struct es_pi {
    ctl_pi_t pi;
};
struct es_pll {
    ctl_pll_t pll;
};
struct es_mt {
    ctl_mt_t mt;
};

es_pi_t *es_pi_new(double kp, double ki_ts, double out_min, double out_max, int anti_windup)
{
    static const char *const NAME[] = {"anti_windup", "kp", "ki_ts", "out_min", "out_max"};
    const double             given[] = {anti_windup, kp, ki_ts, out_min, out_max};
    const ctl_pi_params_t    p = {signal_in(kp), signal_in(ki_ts), signal_in(out_min), signal_in(out_max),
                                  (ctl_pi_anti_windup_t)anti_windup};
    es_pi_t                 *made = calloc(1, sizeof *made);
    const ctl_diag_t         d = ctl_pi_init((made != NULL) ? &made->pi : NULL, &p);
    if (d.status != CTL_OK) {
        const uint16_t f = (d.field < 5U) ? d.field : 0U;
        explain(NAME[f], given[f], (d.status == CTL_ERR_RELATION) ? "below out_max" : "finite, gains >= 0");
        free(made);
        return NULL;
    }
    return made;
}
void   es_pi_free(es_pi_t *pi) { free(pi); }
void   es_pi_reset(es_pi_t *pi, double integrator) { ctl_pi_reset(&pi->pi, signal_in(integrator)); }
double es_pi_output(es_pi_t *pi, double error) { return out(ctl_pi_output(&pi->pi, signal_in(error))); }
void   es_pi_commit(es_pi_t *pi, double realised)
{
    /* the exact value that was proposed must not look limited because it came back through a double */
    const num_t r = signal_in(realised);
    ctl_pi_commit(&pi->pi, r);
}

es_pll_t *es_pll_new(double kp, double ki, double ts_s)
{
    const ctl_pll_params_t p = {signal_in(kp * ts_s), signal_in(ki * ts_s), signal_in(ts_s), signal_in(3.0 / ts_s)};
    es_pll_t              *made = calloc(1, sizeof *made);
    const ctl_diag_t       d = ctl_pll_init((made != NULL) ? &made->pll : NULL, &p);
    if (d.status != CTL_OK) {
        explain((d.field == CTL_PLL_KP) ? "kp" : ((d.field == CTL_PLL_KI) ? "ki" : "ts_s"),
                (d.field == CTL_PLL_KP) ? kp : ((d.field == CTL_PLL_KI) ? ki : ts_s),
                (d.field == CTL_PLL_KP) ? "above 0 and at most 1 / ts_s" : "above 0");
        free(made);
        return NULL;
    }
    return made;
}
void   es_pll_free(es_pll_t *pll) { free(pll); }
void   es_pll_reset(es_pll_t *pll, double angle_rad) { ctl_pll_reset(&pll->pll, angle_in(angle_rad)); }
double es_pll_step(es_pll_t *pll, double angle_rad) { return out(ctl_pll_step(&pll->pll, angle_in(angle_rad))); }

es_mt_t *es_mt_new(int counts_per_rev, double clock_hz, double ts_s)
{
    if ((counts_per_rev < 1) || !(clock_hz > 0.0) || !(ts_s > 0.0) || !(clock_hz * ts_s >= 1.0) || !(clock_hz * ts_s < 4e9)) {
        explain("counts_per_rev, clock_hz, ts_s", counts_per_rev, "above 0, and clock_hz ts_s within 1 .. 4e9");
        return NULL;
    }
    const ctl_mt_params_t p = {(uint32_t)(clock_hz * ts_s + 0.5), signal_in(2.0 * PI / counts_per_rev / ts_s), in(1e5), 100U};
    es_mt_t              *made = calloc(1, sizeof *made);
    if (ctl_mt_init((made != NULL) ? &made->mt : NULL, &p).status != CTL_OK) {
        explain("counts_per_rev", counts_per_rev, "such that one count per sample is a speed that the numeric can hold");
        free(made);
        return NULL;
    }
    return made;
}
void   es_mt_free(es_mt_t *mt) { free(mt); }
double es_mt_step(es_mt_t *mt, int32_t edge_count, uint32_t edge_cyc, uint32_t now_cyc)
{
    return out(ctl_mt_step(&mt->mt, edge_count, edge_cyc, now_cyc));
}

/* ---- observers, deadbeat ----------------------------------------------------------------------------------------------------- */

#define FALLBACK_LIMIT 1.0e6

struct es_angle_memory {
    ctl_angle_memory_t memory;
    double             last_rad, last_value; /* of the newest sample that was good */
    bool               primed;
    num_t              cell[];
};

static bool cells_fit(int cells)
{
    if ((cells < 4) || (cells > 4096)) {
        explain("cells", cells, "within 4 .. 4096");
        return false;
    }
    return true;
}

es_angle_memory_t *es_angle_memory_new(int cells, double gain, double forgetting, int write, int read, double limit)
{
    static const char *const NAME[] = {"cells", "gain", "forgetting", "write", "read", "limit", "cells"};
    static const char *const LIMIT[] = {
        "valid",   "above 0 and at most 1", "within 0 .. 1", "\"one\", \"all\" or \"hat\"", "\"linear\" or \"cubic\"",
        "above 0", "within 4 .. 4096"};
    const double given[] = {cells, gain, forgetting, write, read, limit, cells};
    if (!cells_fit(cells)) {
        return NULL;
    }
    const ctl_angle_memory_params_t p = {signal_in(gain), signal_in(forgetting), (ctl_write_t)write, (ctl_read_t)read,
                                         signal_in(limit)};
    es_angle_memory_t              *made = calloc(1, sizeof *made + (size_t)cells * sizeof made->cell[0]);
    const ctl_diag_t                d =
        ctl_angle_memory_init((made != NULL) ? &made->memory : NULL, &p, (made != NULL) ? made->cell : NULL, (uint16_t)cells);
    if (d.status != CTL_OK) {
        const uint16_t f = (d.field < 7U) ? d.field : 0U;
        explain(NAME[f], given[f], LIMIT[f]);
        free(made);
        return NULL;
    }
    return made;
}
void es_angle_memory_free(es_angle_memory_t *memory) { free(memory); }

void es_angle_memory_write(es_angle_memory_t *memory, double theta_rad, double value)
{
    ctl_angle_memory_t *const m = &memory->memory;
    if (!isfinite(theta_rad)) { /* an angle_t cannot say "not a number": count it as the block would */
        num_count(&m->state.rejected);
        return;
    }
    /* neither can it say more than half a turn: the unwrapped angle does */
    const double step = (memory->primed && isfinite(value)) ? theta_rad - memory->last_rad : 0.0;
    if (fabs(step) > PI) {
        num_count(&m->state.rejected);
        ctl_angle_memory_pause(m);
    } else if ((fabs(step) >= 0.5 * PI) && (m->params.write != CTL_WRITE_ONE)) {
        /* the block takes less than a quarter of a turn at once: go along the straight line in three */
        for (int k = 1; k <= 2; k++) {
            const double part = (double)k / 3.0;
            ctl_angle_memory_write(m, angle_in(memory->last_rad + part * step),
                                   signal_in(memory->last_value + part * (value - memory->last_value)), m->params.gain);
        }
    } else {
        /* an ordinary step */
    }
    ctl_angle_memory_write(m, angle_in(theta_rad), signal_in(value), m->params.gain);
    if (isfinite(value)) {
        memory->last_rad = theta_rad;
        memory->last_value = value;
        memory->primed = true;
    }
}

double es_angle_memory_read(const es_angle_memory_t *memory, double theta_rad)
{
    return out(ctl_angle_memory_read(&memory->memory, angle_in(theta_rad)));
}

int es_angle_memory_cells(const es_angle_memory_t *memory, double *values, int room)
{
    const ctl_grid_t *const grid = &memory->memory.state.grid;
    for (int i = 0; (i < (int)grid->cells) && (i < room); i++) {
        values[i] = out(grid->cell[i]);
    }
    return grid->cells;
}

uint32_t es_angle_memory_rejected(const es_angle_memory_t *memory) { return memory->memory.state.rejected; }

struct es_fir {
    ctl_fir_t fir;
};

es_fir_t *es_fir_new(int order, double cutoff_over_rate, double *taps_out)
{
    ctl_fir_params_t p;
    es_fir_t        *made = calloc(1, sizeof *made);
    const uint16_t   n = ((order >= 0) && (order <= 60000)) ? (uint16_t)order : 60000U;
    if ((made == NULL) || (ctl_fir_design(&p, n, signal_in(cutoff_over_rate)).status != CTL_OK) ||
        (ctl_fir_init(&made->fir, &p).status != CTL_OK)) {
        explain((n > CTL_FIR_ORDER_MAX) ? "order" : "cutoff_over_rate", (n > CTL_FIR_ORDER_MAX) ? order : cutoff_over_rate,
                (n > CTL_FIR_ORDER_MAX) ? "within 0 .. 15" : "above 0.0001 and below 0.5");
        free(made);
        return NULL;
    }
    for (int i = 0; (taps_out != NULL) && (i <= order); i++) {
        taps_out[i] = out(p.tap[i]);
    }
    return made;
}
void   es_fir_free(es_fir_t *fir) { free(fir); }
double es_fir_step(es_fir_t *fir, double x) { return out(ctl_fir_step(&fir->fir, signal_in(x))); }
double es_fir_delay_samples(const es_fir_t *fir) { return 0.5 * fir->fir.order; }

struct es_observer {
    ctl_meter_t    meter;
    ctl_observer_t observer;
    num_t          speed_slow; /* nobody says at what speed it is meant to turn: that of the last 100 samples */
    num_t          memory[8192];
};

es_observer_t *es_observer_new(int kind, double inertia_kgm2, double viscous_nms, double ts_s, int fir1_order, double fir1_hz,
                               int fir2_order, double fir2_hz, double actuation_samples, double age_samples, double gain,
                               double forgetting, int cells, int write, int read)
{
    if (!(inertia_kgm2 > 0.0) || !(ts_s > 0.0)) {
        explain(!(inertia_kgm2 > 0.0) ? "inertia_kgm2" : "ts_s", !(inertia_kgm2 > 0.0) ? inertia_kgm2 : ts_s, "above 0");
        return NULL;
    }
    if (!(age_samples >= 0.0) || !(age_samples <= (double)CTL_ARO_AGE_MAX)) {
        explain("age_samples", age_samples, "within 0 (the true one) .. 31");
        return NULL;
    }
    if (!cells_fit(cells)) {
        return NULL;
    }
    ctl_meter_params_t m = {
        .speed_per_rad = signal_in(1.0 / ts_s),
        .torque_per_16 = signal_in(inertia_kgm2 / ts_s / 16.0),
        .a22 = signal_in(1.0 - viscous_nms * ts_s / inertia_kgm2),
        .actuation = signal_in(actuation_samples),
        .step_max_rad = NUM_C(3.1415f),
    };
    es_observer_t *made = calloc(1, sizeof *made);
    ctl_diag_t     d = ctl_fir_design(&m.fir1, (uint16_t)fir1_order, signal_in(fir1_hz * ts_s));
    if (d.status == CTL_OK) {
        d = ctl_fir_design(&m.fir2, (uint16_t)fir2_order, signal_in(fir2_hz * ts_s));
    }
    if ((made == NULL) || (d.status != CTL_OK)) {
        explain("fir1_order, fir1_hz, fir2_order, fir2_hz", fir1_hz,
                "such that orders are within 0 .. 15 and corners below half the rate");
        free(made);
        return NULL;
    }
    if (ctl_meter_init(&made->meter, &m).status != CTL_OK) {
        explain("inertia_kgm2, viscous_nms, actuation_samples", inertia_kgm2,
                "finite, B T_s / J within 0 .. 1, actuation within 0.5 .. 12");
        free(made);
        return NULL;
    }
    const ctl_observer_params_t o = {
        .kind = (ctl_observer_kind_t)kind,
        .memory = {signal_in(gain), signal_in(forgetting), (ctl_write_t)write, (ctl_read_t)read, in(FALLBACK_LIMIT)},
        .age_half = (age_samples > 0.0) ? (uint16_t)(2.0 * age_samples + 0.5) : ctl_meter_age_half(&m),
        .ahead = m.actuation,
        .rad_per_speed = signal_in(ts_s),
        .fast_gain = signal_in(gain),
    };
    d = ctl_observer_init(&made->observer, &o, made->memory, (kind == (int)CTL_OBSERVER_ARO) ? (uint16_t)cells : 8192U);
    if (d.status != CTL_OK) {
        explain((d.field == CTL_OBSERVER_GAIN) ? "gain" : "kind, forgetting, write, read",
                (d.field == CTL_OBSERVER_GAIN) ? gain : kind, "in range");
        free(made);
        return NULL;
    }
    return made;
}
void es_observer_free(es_observer_t *observer) { free(observer); }

double es_observer_step(es_observer_t *observer, double theta_m_rad, double ref_last_nm, double *seen)
{
    const angle_t         theta = angle_in(theta_m_rad);
    const ctl_meter_out_t m = ctl_meter_step(&observer->meter, theta, signal_in(ref_last_nm));
    if (seen != NULL) {
        seen[0] = out(m.speed);
        seen[1] = out(m.torque);
    }
    ctl_observer_target(&observer->observer, observer->speed_slow);
    observer->speed_slow = num_mac(observer->speed_slow, NUM_C(0.01f), num_sub(m.speed, observer->speed_slow));
    return out(ctl_observer_step(&observer->observer, theta, m.speed, m.torque));
}
double es_observer_age_samples(const es_observer_t *observer) { return 0.5 * observer->observer.params.age_half; }

struct es_deadbeat {
    ctl_deadbeat_t deadbeat;
};

es_deadbeat_t *es_deadbeat_new(double r_ohm, double ld_h, double lq_h, double psi_wb, int pole_pairs, double ts_s,
                               double correction)
{
    const ctl_deadbeat_params_t p = {
        signal_in(r_ohm),       signal_in(ld_h / ts_s),       signal_in(lq_h / ts_s),       signal_in(ts_s / ld_h),
        signal_in(ts_s / lq_h), signal_in(pole_pairs * ld_h), signal_in(pole_pairs * lq_h), signal_in(pole_pairs * psi_wb),
        signal_in(correction),  in(FALLBACK_LIMIT),           in(FALLBACK_LIMIT),
    };
    static const char *const NAME[] = {"(pointer)", "r_ohm", "ld_h", "lq_h", "psi_wb", "correction", "limit"};
    const double             given[] = {0, r_ohm, ld_h, lq_h, psi_wb, correction, 0};
    es_deadbeat_t           *made = calloc(1, sizeof *made);
    const ctl_diag_t         d = ctl_deadbeat_init((made != NULL) ? &made->deadbeat : NULL, &p);
    if (d.status != CTL_OK) {
        const uint16_t f = (d.field < 7U) ? d.field : 0U;
        explain(NAME[f], given[f], (f == CTL_DEADBEAT_CORRECTION) ? "within 0 .. 0.5" : "above 0 and finite");
        free(made);
        return NULL;
    }
    return made;
}
void es_deadbeat_free(es_deadbeat_t *deadbeat) { free(deadbeat); }

void es_deadbeat_step(es_deadbeat_t *deadbeat, const double *x, double *v)
{
    const ctl_dq_t meas = {signal_in(x[0]), signal_in(x[1])};
    const ctl_dq_t ref = {signal_in(x[2]), signal_in(x[3])};
    const ctl_dq_t last = {signal_in(x[5]), signal_in(x[6])};
    const ctl_dq_t y = ctl_deadbeat_step(&deadbeat->deadbeat, &meas, &ref, signal_in(x[4]), &last);
    v[0] = out(y.d);
    v[1] = out(y.q);
}

/* ---- position drive ---------------------------------------------------------------------------------------------------------- */

bool es_stribeck(double speed, double coulomb, double stat, double stribeck, double shape, double *torque)
{
    static const char *const NAME[] = {"(pointer)", "viscous", "coulomb", "static", "v_s", "shape"};
    static const char *const LIMIT[] = {"given", "0", "at least 0", "at least 0", "above 0", "within 0.1 .. 10"};
    const double             given[] = {0.0, 0.0, coulomb, stat, stribeck, shape};
    const ctl_friction_t     p = {(num_t)0, signal_in(coulomb), signal_in(stat), signal_in(stribeck), signal_in(shape)};
    const ctl_diag_t         d = ctl_friction_check(&p);
    if (d.status != CTL_OK) {
        const uint16_t f = (d.field < 6U) ? d.field : 0U;
        explain(NAME[f], given[f], (d.status == CTL_ERR_RELATION) ? "at least coulomb" : LIMIT[f]);
        return false;
    }
    *torque = out(ctl_friction(&p, signal_in(speed)));
    return true;
}

bool es_rdc_robust_term(const double *e, const double *p_row, double inertia, double rho, double sigma, double *torque)
{
    if (!(inertia > 0.0)) {
        explain("inertia", inertia, "above 0");
        return false;
    }
    ctl_rdc_params_t p = {
        .inertia = signal_in(inertia),
        .friction = {(num_t)0, (num_t)0, (num_t)0, NUM_C(1.0f), NUM_C(1.0f)},
        .p_row = {signal_in(p_row[0] / inertia), signal_in(p_row[1] / inertia), signal_in(p_row[2] / inertia)},
        .rho = signal_in(rho),
        .sigma = signal_in(sigma),
        .sample_s = NUM_EPS, /* the integral is given, it does not advance */
        .integral_max = NUM_C(100.0f),
    };
    ctl_rdc_t        rdc;
    const ctl_diag_t d = ctl_rdc_init(&rdc, &p);
    if (d.status != CTL_OK) {
        const bool is_sigma = d.field == (uint16_t)CTL_RDC_SIGMA;
        const bool is_rho = d.field == (uint16_t)CTL_RDC_RHO;
        explain(is_sigma ? "sigma" : (is_rho ? "rho" : ((d.field == (uint16_t)CTL_RDC_P) ? "p_row" : "inertia")),
                is_sigma ? sigma : (is_rho ? rho : ((d.field == (uint16_t)CTL_RDC_P) ? p_row[0] : inertia)),
                is_sigma ? "above 0" : (is_rho ? "at least 0" : "such that the numeric can hold p_row over inertia"));
        return false;
    }
    const ctl_setpoint_t rest = {0, (num_t)0, (num_t)0, true};
    rdc.state.x1 = signal_in(e[0]);
    *torque = out(ctl_rdc_step(&rdc, &rest, signal_in(e[1]), signal_in(e[2])));
    return true;
}

bool es_spatial_lowpass(double cutoff_per_rad, double speed_rad_s, double ts_s, double *b, double *a)
{
    const double k = cutoff_per_rad * fabs(speed_rad_s) * ts_s * 0.5;
    if (!(cutoff_per_rad > 0.0) || !(ts_s > 0.0)) {
        explain(!(cutoff_per_rad > 0.0) ? "cutoff_per_rad" : "ts", !(cutoff_per_rad > 0.0) ? cutoff_per_rad : ts_s, "above 0");
        return false;
    }
    if (!(k <= 1.0)) {
        explain("speed", speed_rad_s, "such that cutoff_per_rad |speed| ts / 2 is at most 1");
        return false;
    }
    const ctl_src_filter_t f = ctl_src_filter(in(k));
    b[0] = out(f.b0);
    b[1] = 2.0 * b[0];
    b[2] = b[0];
    a[0] = 1.0;
    a[1] = out(f.a1);
    a[2] = out(f.a2);
    return true;
}

#define TURN_Q32 4294967296.0

struct es_profile {
    ctl_profile_t profile;
    double        speed_unit, accel_unit;
};

static ctl_position_t position_in(double rad)
{
    const double turns = rad / (2.0 * PI);
    return (fabs(turns) < 1.0e9) ? (ctl_position_t)llrint(turns * TURN_Q32) : 0;
}

es_profile_t *es_profile_new(double speed_rad_s, double accel_rad_s2, int smooth, double ts_s)
{
    const double step = speed_rad_s * ts_s / (2.0 * PI) * TURN_Q32;
    const double change = accel_rad_s2 * ts_s * ts_s / (2.0 * PI) * TURN_Q32;
    if (!(ts_s > 0.0)) {
        explain("ts_s", ts_s, "above 0");
        return NULL;
    }
    if (!((step >= 1.0) && (step < 2147483647.0))) {
        explain("speed_rad_s", speed_rad_s, "above 0 and at most half a turn per sample");
        return NULL;
    }
    if (!((change >= 0.0) && (change < 2147483647.0))) {
        explain("accel_rad_s2", accel_rad_s2, "at least 0 and at most half a turn per sample^2");
        return NULL;
    }
    if ((smooth < 1) || (smooth > (int)CTL_PROFILE_SMOOTH_MAX)) {
        explain("smooth", smooth, "within 1 .. 64");
        return NULL;
    }
    es_profile_t *made = calloc(1, sizeof *made);
    if (made == NULL) {
        explain("smooth", smooth, "smaller: not enough memory");
        return NULL;
    }
    /* One unit is the largest speed, and the largest acceleration: both numerics keep their digits. */
    made->speed_unit = speed_rad_s;
    made->accel_unit = (accel_rad_s2 > 0.0) ? accel_rad_s2 : 1.0;
    const ctl_profile_params_t p = {
        .speed = (int64_t)step,
        .acceleration = ((change > 0.0) && (change < 1.0)) ? 1 : (int64_t)change,
        .smooth = (uint16_t)smooth,
        .speed_scale = signal_in(2.0 * PI / 65536.0 / ts_s / made->speed_unit),
        .accel_scale = signal_in(2.0 * PI / 1048576.0 / (ts_s * ts_s) / made->accel_unit),
    };
    if (ctl_profile_init(&made->profile, &p).status != CTL_OK) {
        explain("speed_rad_s", speed_rad_s, "such that the numeric can hold a 65536th of a turn per sample in units of it");
        free(made);
        return NULL;
    }
    return made;
}
void es_profile_free(es_profile_t *profile) { free(profile); }
void es_profile_reset(es_profile_t *profile, double position_rad)
{
    ctl_profile_reset(&profile->profile, position_in(position_rad));
}

bool es_profile_step(es_profile_t *profile, double target_rad, double *result)
{
    const ctl_setpoint_t s = ctl_profile_step(&profile->profile, position_in(target_rad));
    result[0] = (double)s.position / TURN_Q32 * 2.0 * PI;
    result[1] = out(s.speed) * profile->speed_unit;
    result[2] = out(s.acceleration) * profile->accel_unit;
    return s.done;
}
