/* From the parameter list to the blocks. Main loop. */
#include "firmware/app/internal.h"
#include "firmware/app/memory_check.h"
#include "hal/hal_clock.h"

static drive_scale_t make_scale(const drive_params_t *p)
{
#ifdef EVENSPIN_FIXED
    /* limits of the drive at 2 and 4 per unit: a wide margin to 128, and 6e-8 of these bases as the smallest step */
    const float   speed = p->over_speed_rad_s * 0.25f;
    drive_scale_t s = {p->over_current_a * 0.5f, p->over_voltage_v * 0.5f, speed, speed * p->speed_error_gain, 1.0f, 1.0f, 1.0f};
#else
    drive_scale_t s = {1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f};
    (void)p;
#endif
    s.inv_current = 1.0f / s.current_a;
    s.inv_voltage = 1.0f / s.voltage_v;
    s.inv_speed = 1.0f / s.speed_rad_s;
    return s;
}

num_t drive_number(float x) { return num_from_float(x); }

num_t drive_fitted(float x, uint16_t param, uint16_t *culprit)
{
    const num_t n = drive_number(x);
    if ((num_abs(n) >= NUM_MAX) && (*culprit == (uint16_t)PARAM_COUNT)) {
        *culprit = param;
    }
    return n;
}

ctl_pi_params_t drive_pi(num_t kp, num_t ki_ts, float limit, ctl_pi_anti_windup_t anti_windup)
{
    const ctl_pi_params_t pi = {kp, ki_ts, drive_number(-limit), drive_number(limit), anti_windup};
    return pi;
}

/* Checks that need no block: ranges, the board's maxima, and what the parameters leave each other. */
static uint16_t refused(const drive_params_t *p)
{
    uint16_t bad = params_check(p);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_board_refuses(p);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_relation_refuses(p);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_combination_refuses(p);
    return (bad != (uint16_t)PARAM_COUNT) ? bad : drive_judge_alignment(p);
}

static uint16_t make(const drive_params_t *p, drive_setup_t *s)
{
    s->scale = make_scale(p);
    s->limits = (drive_limits_t){p->over_current_a, p->over_voltage_v, p->under_voltage_v, p->over_speed_rad_s};
    s->period_cyc = hal_clock_hz() / DRIVE_PWM_HZ;
    drive_make_thermal(p, &s->scale, &s->thermal);
    drive_make_braking(p, &s->scale, &s->braking);
    drive_make_correction(p, &s->scale, &s->sensors);
    drive_make_plausibility(p, s);
    uint16_t bad = drive_make_current(p, &s->scale, &s->current);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_make_reference(p, &s->scale, &s->reference);
    s->more = s->reference.used || s->thermal.used || s->braking.chops;
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_make_tracking(p, &s->scale, &s->tracking);
    drive_make_motion(p, s);
    drive_make_stall(p, s);
    drive_make_index(p, s);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_make_speed(p, &s->scale, &s->speed);
    return (bad != (uint16_t)PARAM_COUNT) ? bad : drive_make_observer(p, &s->scale, &s->observer);
}

/* Every block judges, on copies: what is refused must not have changed anything. */
static uint16_t judge(const drive_setup_t *s)
{
    uint16_t bad = drive_judge_current(&s->current);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_judge_correction(&s->sensors);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_judge_tracking(&s->tracking);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_judge_speed(&s->speed);
    return (bad != (uint16_t)PARAM_COUNT) ? bad : drive_judge_observer(&s->observer);
}

uint16_t drive_make_setup(const drive_params_t *p, drive_setup_t *s)
{
    uint16_t bad = refused(p);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : make(p, s);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : judge(s);
    bad = (bad != (uint16_t)PARAM_COUNT) ? bad : drive_make_position(p, &s->scale, &s->position);
    return (bad != (uint16_t)PARAM_COUNT) ? bad : drive_judge_position(&s->position);
}

uint16_t drive_build(drive_t *d)
{
    drive_setup_t *const s = &d->set[0].setup; /* the set in force */
    const uint16_t       bad = drive_make_setup(d->params, s);
    if (bad != (uint16_t)PARAM_COUNT) {
        /* no block has memory: none may run, although the interrupts go on in FAULT */
        s->speed.rc_used = false;
        s->observer.meter_used = false;
        s->observer.used = false;
        s->sensors.used = false;
        s->reference.used = false;
        s->more = false;
        s->sensors.learns = false;
        drive_build_correction(&d->sensors, &s->sensors, &s->scale);
        return bad;
    }
    d->scale = s->scale;
    d->zero.e = s->tracking.encoder_offset;
    /* all of these were accepted a moment ago */
    drive_build_current(&d->current, &s->current);
    drive_build_correction(&d->sensors, &s->sensors, &s->scale);
    drive_build_tracking(&d->tracking, &s->tracking);
    drive_build_speed(&d->speed, &s->speed, d->rc_memory);
    drive_build_meter(&d->observer, &s->observer);
    drive_build_observer(&d->observer, &s->observer, d->observer_memory);
    drive_build_position(&d->position, &s->position);
    drive_build_position_memory(&d->position, s, d->observer_memory, (uint16_t)DRIVE_OBSERVER_CAPACITY);
    d->thermal.share = 1.0f;
    drive_command_again(d);
    drive_keep_set(d, &d->set[0]);
    return PARAM_COUNT;
}

void drive_rest(drive_t *d)
{
    drive_rest_current(&d->current, &d->setup->current);
    drive_rest_speed(&d->speed, &d->setup->speed);
    drive_rest_reference(&d->reference, &d->setup->reference);
    drive_rest_observer(&d->observer, &d->setup->observer);
    drive_rest_position(&d->position);
    ctl_turn_spoil(&d->sensors.log); /* a new run */
    d->sensors.held = (ctl_dq_t){(num_t)0, (num_t)0};
    ctl_plausibility_restart(&d->plausibility);
    drive_command_nothing(d);
}
