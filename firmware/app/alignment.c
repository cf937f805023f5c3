/* The alignment: alignment.h says what it does. Everything is whole numbers but the current: the same in both numerics. */
#include "firmware/app/alignment.h"

#include "firmware/app/internal.h"
#include "hal/hal_inverter.h"

#define PULL_QUARTERS 6U /* half of them on the first vector */
#define PATIENCE 8U      /* quarters more for a rotor that still swings */
#define LEAD_IN 3U       /* quarters of a pass before it counts: the vector turns round, the friction changes its side */
#define HOLD_QUARTERS 2U
#define QUARTER_PERIODS_MIN 250U
#define COUNTS_PER_TURN_E 8.0f       /* fewer do not resolve a quarter turn */
#define WINDOW_PERIODS 1000U         /* of the wait: 0.1 s */
#define REST_TURN_E 0.0056f          /* 2 degrees electrical */
#define SETTLED 4U                   /* times that, for a rotor on its vector */
#define SHIFT_MAX 7U                 /* low-pass of 12.8 ms: damps rotors that swing at 20 to 100 rad/s */
#define SHIFT_MIN 2U                 /* low-pass of 0.4 ms: up to 1000 rad/s */
#define LEAD_MAX INT32_C(0x2AAAAAAA) /* 60 degrees */
#define LOAD_MAX 0.0139f             /* 5 degrees electrical */

static uint16_t pass_quarters(const drive_params_t *p) { return (uint16_t)((4U * p->align_turns) + LEAD_IN); }

static uint16_t quarter_periods(const drive_params_t *p)
{
    return (uint16_t)(p->align_periods / ((DRIVE_ALIGN_PASSES * pass_quarters(p)) + PULL_QUARTERS + HOLD_QUARTERS));
}

uint16_t drive_judge_alignment(const drive_params_t *p)
{
    if (p->align_periods == 0U) {
        return PARAM_COUNT;
    }
    if (quarter_periods(p) < QUARTER_PERIODS_MIN) {
        return PARAM_align_periods;
    }
    return (p->encoder_counts < (COUNTS_PER_TURN_E * (float)p->pole_pairs)) ? (uint16_t)PARAM_encoder_counts
                                                                            : (uint16_t)PARAM_COUNT;
}

static uint32_t turns(float x) { return (uint32_t)(x * 4294967296.0f); }

void drive_align_begin(drive_t *d)
{
    const drive_params_t *const p = d->params;
    drive_align_t *const        a = &d->align;
    const drive_align_t         fresh = {.phase = DRIVE_ALIGN_WAIT, .shift = SHIFT_MAX};
    const float                 limit_a = (p->iq_limit_a < p->id_limit_a) ? p->iq_limit_a : p->id_limit_a;
    const float                 current_a = (p->align_current_a < limit_a) ? p->align_current_a : limit_a;
    const float                 count = 2.0f / p->encoder_counts;
    const float                 rest = REST_TURN_E / (float)p->pole_pairs;

    *a = fresh;
    a->quarters = pass_quarters(p);
    a->quarter_periods = quarter_periods(p);
    a->vector_step = (int32_t)(ANGLE_QUARTER / a->quarter_periods);
    a->pace_step = a->vector_step / (int32_t)a->quarter_periods;
    a->current = num_from_float(current_a * d->scale.inv_current);
    a->current_step = num_from_float(current_a * d->scale.inv_current / (2.0f * (float)a->quarter_periods));
    a->wait_periods = (uint32_t)(p->align_rest_s * (float)DRIVE_PWM_HZ);
    a->rest = turns((count > rest) ? count : rest);
}

/* ---- current interrupt ------------------------------------------------------------------------------------------------ */

static void open_window(drive_align_t *a, angle_t theta_m)
{
    a->corner = theta_m;
    a->low = 0U;
    a->high = 0U;
}

static void note_extremes(drive_align_t *a, angle_t theta_m)
{
    const angle_t off = theta_m - a->corner;
    if ((int32_t)off > (int32_t)a->high) {
        a->high = off;
    }
    if ((int32_t)off < (int32_t)a->low) {
        a->low = off;
    }
}

static uint32_t span(const drive_align_t *a) { return a->high - a->low; }
static bool     rests(const drive_align_t *a) { return span(a) <= (2U * a->rest); }

/* A swing that is quick for the low-pass halves its time. */
static void follow_swing(drive_align_t *a, angle_t theta_m)
{
    const int32_t on = (int32_t)(a->rising ? (theta_m - a->extreme) : (a->extreme - theta_m));
    a->age = (uint16_t)(a->age + ((a->age < UINT16_MAX) ? 1U : 0U));
    if (on > 0) {
        a->extreme = theta_m;
        a->extreme_age = a->age;
    } else if (on < -(int32_t)a->rest) { /* it has turned back */
        if ((a->extreme_age < (2U << a->shift)) && (a->shift > SHIFT_MIN)) {
            a->shift--;
        }
        a->age = (uint16_t)(a->age - a->extreme_age);
        a->extreme_age = a->age;
        a->extreme = theta_m;
        a->rising = !a->rising;
    } else {
        /* it stands, or has hardly begun to turn back */
    }
}

/* Where the vector is set: against the motion of the rotor about it. */
static angle_t damped(drive_align_t *a, angle_t deviation)
{
    const int32_t off = (int32_t)(deviation - a->slow);
    int32_t       lead = LEAD_MAX;
    a->slow += (angle_t)(off >> a->shift);
    if (off < (LEAD_MAX / 4)) {
        lead = (off > -(LEAD_MAX / 4)) ? (4 * off) : -LEAD_MAX;
    }
    return a->opposed ? (a->vector + (angle_t)lead) : (a->vector - (angle_t)lead);
}

static void wait(drive_t *d)
{
    drive_align_t *const a = &d->align;
    if (a->period == 0U) {
        open_window(a, d->tracking.theta_m);
    }
    note_extremes(a, d->tracking.theta_m);
    a->period++;
    if (a->period < WINDOW_PERIODS) {
        return;
    }
    a->waited += WINDOW_PERIODS;
    a->period = 0U;
    if (span(a) <= a->rest) {
        a->phase = DRIVE_ALIGN_RESTS;
    } else if (a->waited >= a->wait_periods) {
        drive_trip(d, FAULT_align_turning);
    } else {
        /* another window */
    }
}

/* The end of a quarter of the pull: after some time the rotor must have come to rest on the vector. Where it is driven instead of
 * damped the encoder counts down, or two phases are swapped: the passes show its direction. */
static void end_pull(drive_t *d)
{
    drive_align_t *const a = &d->align;
    if (a->quarter < PULL_QUARTERS) {
        return;
    }
    if (span(a) <= (SETTLED * a->rest)) {
        a->quarter = 0U;
        a->phase = DRIVE_ALIGN_SWEEP;
    } else if (a->quarter < (PULL_QUARTERS + PATIENCE)) {
        /* it may still come */
    } else if (!a->opposed) {
        a->quarter = 0U;
        a->opposed = true;
        a->shift = SHIFT_MAX;
        a->vector = 0U - ANGLE_QUARTER;
    } else {
        drive_trip(d, FAULT_align_unsettled);
    }
}

static void end_quarter(drive_t *d)
{
    drive_align_t *const a = &d->align;
    a->period = 0U;
    a->quarter++;
    if (a->phase == DRIVE_ALIGN_PULL) {
        end_pull(d);
    } else if (a->phase == DRIVE_ALIGN_SWEEP) {
        if (a->quarter > LEAD_IN) {
            a->seen[a->pass].moved += (int32_t)(d->tracking.theta_m - a->corner) / 64;
        }
        if (a->quarter == a->quarters) {
            a->quarter = 0U;
            a->pass++;
        }
        if (a->pass == DRIVE_ALIGN_PASSES) {
            a->phase = DRIVE_ALIGN_HOLD;
        }
    } else if ((a->quarter >= HOLD_QUARTERS) && (rests(a) || (a->quarter >= (HOLD_QUARTERS + PATIENCE)))) {
        a->phase = DRIVE_ALIGN_DONE;
        return; /* what the last window saw is still to be judged */
    } else {
        /* the vector stands */
    }
    open_window(a, d->tracking.theta_m);
}

/* Measure during a pass, only once the motion is steady. */
static void measure(drive_align_t *a, angle_t deviation)
{
    if ((a->pass == 0U) && (a->quarter == LEAD_IN) && (a->period == 0U)) {
        a->from = deviation;
    }
    a->seen[a->pass].sum += (int32_t)(deviation - a->from) / 65536;
}

static void move_vector(drive_align_t *a)
{
    const bool full =
        (a->phase == DRIVE_ALIGN_PULL) || ((a->phase == DRIVE_ALIGN_SWEEP) && (a->pass < (DRIVE_ALIGN_PASSES / 2U)));
    const num_t wanted = full ? a->current : num_mul(a->current, NUM_C(0.5f));
    a->current_now = num_clamp(wanted, num_sub(a->current_now, a->current_step), num_add(a->current_now, a->current_step));
    a->vector += (angle_t)a->pace;
    int32_t pace = 0;
    if (a->phase == DRIVE_ALIGN_SWEEP) {
        pace = ((a->pass & 1U) == 0U) ? a->vector_step : -a->vector_step;
    } else if ((a->phase == DRIVE_ALIGN_PULL) && (a->quarter == (PULL_QUARTERS / 2U))) {
        pace = a->vector_step; /* with what it takes to stop a quarter turn */
    } else {
        /* it stands */
    }
    const int32_t more = pace - a->pace;
    a->pace += (more > a->pace_step) ? a->pace_step : ((more < -a->pace_step) ? -a->pace_step : more);
}

bool drive_align_step(drive_t *d)
{
    drive_align_t *const a = &d->align;
    const angle_t        theta_m = d->tracking.theta_m;
    const angle_t        theta_e = theta_m * d->setup->tracking.pole_pairs;
    const uint16_t       phase = a->phase;
    if (phase == (uint16_t)DRIVE_ALIGN_WAIT) {
        wait(d);
        return false;
    }
    if ((phase == (uint16_t)DRIVE_ALIGN_RESTS) || (phase == (uint16_t)DRIVE_ALIGN_DONE)) {
        return false;
    }
    note_extremes(a, theta_m);
    follow_swing(a, theta_m);
    move_vector(a);
    a->at = damped(a, theta_e - a->vector);
    if ((phase == (uint16_t)DRIVE_ALIGN_SWEEP) && (a->quarter >= LEAD_IN)) {
        measure(a, theta_e - a->at);
    }
    a->period++;
    if (a->period == a->quarter_periods) {
        end_quarter(d);
    }
    return true;
}

/* ---- main loop -------------------------------------------------------------------------------------------------------- */

void drive_align_pull(drive_t *d)
{
    drive_align_t *const a = &d->align;
    a->period = 0U;
    a->quarter = 0U;
    a->vector = 0U - ANGLE_QUARTER;
    a->slow = (d->tracking.theta_m * d->setup->tracking.pole_pairs) - a->vector;
    a->extreme = d->tracking.theta_m;
    open_window(a, d->tracking.theta_m);
    a->phase = DRIVE_ALIGN_PULL; /* last: from here on it belongs to the current interrupt */
}

static float size(float x) { return (x < 0.0f) ? -x : x; }

/* Motion of the shaft in a pass, over that of a rotor which follows. */
static float followed(const drive_t *d, uint16_t pass)
{
    const uint16_t turns_e = (uint16_t)((d->align.quarters - LEAD_IN) / 4U);
    const float    expected = 67108864.0f * (float)turns_e / (float)d->setup->tracking.pole_pairs;
    const float    moved = (float)d->align.seen[pass].moved / expected;
    return ((pass & 1U) == 0U) ? moved : -moved;
}

/* The vector was not followed as it should: what the motion shows. */
static drive_align_result_t explain(const drive_t *d, float slack)
{
    const float          forward = followed(d, 0U);
    const float          back = followed(d, 1U);
    const float          mean = 0.5f * (forward + back);
    const float          pairs = (float)d->setup->tracking.pole_pairs;
    drive_align_result_t r = {FAULT_align_blocked, 0U, 0U};
    if ((size(forward - back) > (0.1f + (2.0f * slack))) || (size(mean) < (0.02f + slack))) {
        return r; /* it did not turn evenly in both directions, or not at all */
    }
    if (mean < 0.0f) {
        r.fault = FAULT_align_direction;
        return r;
    }
    const float seen = pairs / mean;
    const float whole = (float)(uint16_t)(seen + 0.5f);
    if ((whole != pairs) && (whole >= 1.0f) && (whole <= 50.0f) && (size(seen - whole) < 0.25f)) {
        r.fault = FAULT_align_pole_pairs;
        r.detail = (uint16_t)whole;
    } else if ((size(mean - 1.0f) < 0.125f) && (followed(d, 2U) > 0.25f)) {
        r.fault = FAULT_align_load; /* the whole current was enough, half of it was not */
    } else {
        /* nothing that has a name */
    }
    return r;
}

drive_align_result_t drive_align_judge(const drive_t *d)
{
    const drive_align_t *const a = &d->align;
    const uint16_t             whole_turns_e = (uint16_t)((a->quarters - LEAD_IN) / 4U);
    const float                turns_e = (float)whole_turns_e;
    const float                samples = 4.0f * turns_e * (float)a->quarter_periods * 65536.0f;
    const float                pairs = (float)d->setup->tracking.pole_pairs;
    const float                slack = 1.5f * pairs / (d->params->encoder_counts * turns_e);
    const float                near_pairs = 0.5f / (pairs + 1.0f); /* halfway to one pole pair more */
    const float                limit = ((near_pairs < 0.125f) ? near_pairs : 0.125f) + slack;
    float                      mean[DRIVE_ALIGN_PASSES];
    drive_align_result_t       r = {FAULT_none, 0U, 0U};
    for (uint16_t k = 0U; k < DRIVE_ALIGN_PASSES; k++) {
        if (!(size(followed(d, k) - 1.0f) <= limit)) {
            return explain(d, slack);
        }
        mean[k] = (float)a->seen[k].sum / samples;
    }
    const float full = 0.5f * (mean[0] + mean[1]);
    const float load = (0.5f * (mean[2] + mean[3])) - full;
    if (!rests(a)) {
        r.fault = FAULT_align_unsettled;
    } else if (size(load) > LOAD_MAX) {
        r.fault = FAULT_align_load;
    } else {
        r.zero_e = 0U - (a->from + (angle_t)(int32_t)((full - load) * 4294967296.0f));
    }
    return r;
}

bool drive_fault_voids_zero(drive_fault_t fault)
{
    return (fault == FAULT_encoder_lost) || (fault == FAULT_encoder_error) || (fault == FAULT_stall) ||
           (fault == FAULT_over_speed) || (fault == FAULT_speed_deviation) || (fault == FAULT_electrical_zero) ||
           (fault == FAULT_current_implausible) || (fault == FAULT_encoder_index);
}
