/* I2t of motor and bridge: the speed interrupt heats and cools, the main loop makes the current limits of it, and of the temperatures that
 * sensors show. The heat outlives everything but drive_init. */
#include "control/motor/thermal.h"
#include "firmware/app/internal.h"

#define FAST_HZ 60.0f /* electrical: from here on a leg has the mean of its turns, which samples at 1 kHz may miss */
#define STEP_SHARE 0.005f
#define BAD_PASSES                                                                                                               \
    16U /* of a sensor, in a row: two rounds of the memory check, which by then has found a limit that has changed */
#define TRIPS_Q24 ((int32_t)(CTL_THERMAL_TRIPS * 16777216.0f))

static ctl_thermal_params_t part(float continuous_a, float tau_s, float ts_s)
{
    const float                per_amp = (continuous_a > 0.0f) ? (1.0f / continuous_a) : 0.0f;
    const ctl_thermal_params_t p = {per_amp * per_amp, ctl_thermal_rate(ts_s, tau_s)};
    return p;
}

void drive_make_thermal(const drive_params_t *p, const drive_scale_t *scale, drive_thermal_setup_t *s)
{
    const float ts_s = (float)p->speed_divider / (float)DRIVE_PWM_HZ;
    s->used = (p->motor_continuous_a > 0.0f) || (p->bridge_continuous_a > 0.0f);
    s->motor = part(p->motor_continuous_a, p->motor_thermal_s, ts_s);
    s->bridge = part(p->bridge_continuous_a, p->bridge_thermal_s, ts_s);
    s->fast = drive_number(DRIVE_TWO_PI * FAST_HZ / (float)p->pole_pairs * scale->inv_speed);
}

void drive_heat(drive_t *d)
{
    const drive_thermal_setup_t *const s = &d->setup->thermal;
    drive_thermal_t *const             t = &d->thermal;
    const float                        square[3] = {d->ia_a * d->ia_a, d->ib_a * d->ib_a, d->ic_a * d->ic_a};
    const float                        mean = (square[0] + square[1] + square[2]) * (2.0f / 3.0f); /* of the vector */
    const bool                         fast = num_abs(d->tracking.pll.state.w) > s->fast;

    ctl_thermal_step(&s->motor, &t->motor, mean);
    bool hot = false;
    for (uint16_t k = 0U; k < 3U; k++) { /* twice: a sine has half of its amplitude's square */
        ctl_thermal_step(&s->bridge, &t->leg[k], fast ? mean : (2.0f * square[k]));
        hot |= ctl_thermal_beyond(t->leg[k], TRIPS_Q24);
    }
    if (!drive_is_armed(d)) {
        return;
    }
    if (ctl_thermal_beyond(t->motor, TRIPS_Q24)) {
        drive_trip(d, FAULT_motor_overload);
    }
    if (hot) {
        drive_trip(d, FAULT_bridge_overload);
    }
}

float drive_motor_heat(const drive_t *d) { return ctl_thermal_heat(d->thermal.motor); }

float drive_bridge_heat(const drive_t *d)
{
    const ctl_heat_t *const leg = d->thermal.leg;
    const ctl_heat_t        two = (leg[0] > leg[1]) ? leg[0] : leg[1];
    return ctl_thermal_heat((two > leg[2]) ? two : leg[2]);
}

/* Square of the current that a part allows; @p share of its load that a leg may have more than the mean. */
static float allowed(float heat, const ctl_thermal_params_t *p, float most_a, float share)
{
    const float most = most_a * most_a * p->per_square * share;
    return (p->per_square > 0.0f) ? (ctl_thermal_allowed(heat, most) / (p->per_square * share)) : (most_a * most_a);
}

/* What a sensor leaves of the longest current vector. NaN is hot. */
static float attend_sensor(drive_t *d, hal_temperature_t which, float derate_c, float trip_c, drive_fault_t fault)
{
    float celsius = 0.0f;
    if (!(trip_c > 0.0f)) {
        d->thermal.celsius[which] = 0.0f;
        return 1.0f;
    }
    const bool works = hal_temperature(which, &celsius) == HAL_OK;
    const bool hot = !(celsius < trip_c);
    d->thermal.celsius[which] = celsius;
    uint16_t *const bad = &d->thermal.bad[which];
    *bad = (drive_is_armed(d) && (!works || hot)) ? (uint16_t)(*bad + 1U) : 0U;
    if (*bad > BAD_PASSES) {
        d->fault_detail = works ? 0U : (uint16_t)(which + 1);
        drive_trip(d, works ? fault : FAULT_temperature_sensor);
    }
    if (!works || hot) {
        return works ? 0.0f : 1.0f;
    }
    const float part_of = (trip_c - celsius) / (trip_c - derate_c);
    return ((derate_c > 0.0f) && (part_of < 1.0f)) ? part_of : 1.0f;
}

static float sensors_allow(drive_t *d, const drive_params_t *p)
{
    const float motor = attend_sensor(d, HAL_TEMPERATURE_MOTOR, p->motor_derate_c, p->motor_trip_c, FAULT_motor_temperature);
    const float bridge = attend_sensor(d, HAL_TEMPERATURE_BRIDGE, p->bridge_derate_c, p->bridge_trip_c, FAULT_over_temperature);
    return (motor < bridge) ? motor : bridge;
}

void drive_attend_thermal(drive_t *d)
{
    const drive_set_t *const set = drive_newest(d);
    const float              most = drive_longest_a(&set->params);
    const float              by_motor = allowed(drive_motor_heat(d), &set->setup.thermal.motor, most, 1.0f);
    const float              by_bridge = allowed(drive_bridge_heat(d), &set->setup.thermal.bridge, most, 2.0f);
    const float              square = (by_motor < by_bridge) ? by_motor : by_bridge;
    const bool               derates = set->setup.thermal.used && (square < (most * most * (1.0f - STEP_SHARE)));
    const float              by_heat = derates ? num_to_float(num_sqrt(num_from_float(square / (most * most)))) : 1.0f;
    const float              by_sensor = sensors_allow(d, &set->params);
    const float              part_of = (by_heat < by_sensor) ? by_heat : by_sensor;
    const float              step = part_of - d->thermal.share;
    if ((step > STEP_SHARE) || (step < -STEP_SHARE) || ((part_of == 1.0f) != (d->thermal.share == 1.0f))) {
        d->thermal.share = part_of;
        drive_command_again(d);
    }
}
