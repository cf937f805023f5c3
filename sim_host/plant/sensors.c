/* What the converter and the encoder read at the start of a period. */
#include <math.h>

#include "sim_host/plant/encoder.h"
#include "sim_host/plant/machine.h"

static double convert(double x, double lsb, double range)
{
    const double y = (lsb > 0.0) ? rint(x / lsb) * lsb : x;
    return (y > range) ? range : ((y < -range) ? -range : y);
}

/* Many at once: a draw that is thrown away, one in five, would stop the processor from working ahead in the step that follows. */
SIM_NOINLINE static void draw_noise(sim_plant_t *s)
{
    double used[2];
    for (; s->noise_ahead_at > 0; s->noise_ahead_at--) { /* what others drew for it: it goes on from there */
        sim_random_normal2(&s->noise, used);
    }
    for (int k = 0; k < SIM_NOISE_PAIRS; k++) {
        sim_random_normal2(&s->noise, s->noise_pair[k]);
    }
    s->noise_left = SIM_NOISE_PAIRS;
}

static inline const double *next_noise(sim_plant_t *s)
{
    if (s->noise_ahead_at < s->noise_ahead_count) {
        return &s->noise_ahead[2 * s->noise_ahead_at++];
    }
    if (s->noise_left == 0) {
        s->noise_ahead_count = 0;
        draw_noise(s);
    }
    return s->noise_pair[SIM_NOISE_PAIRS - s->noise_left--];
}

/** The reading of an angle in counts of this turn: whole numbers, so that wrapping is exact. */
static double counted(sim_plant_t *s, double angle)
{
    const double per_turn = s->model.counts_per_rev;
    const double n = (double)sim_whole_below(angle / s->count_rad);
    double       count = n - s->first_count;
    if ((count < 0.0) || (count >= per_turn)) { /* in another turn than at the last reading */
        s->first_count = per_turn * (double)sim_whole_below(n / per_turn);
        count = n - s->first_count;
    }
    return count;
}

void sim_plant_read(sim_plant_t *s, sim_reading_t *out)
{
    const sim_model_t *const m = &s->model;
    double                   i[3];
    if (s->parts.current_lag_s > 0.0) {
        sim_to_phases(s->lagging_a[0], s->lagging_a[1], i);
    } else {
        sim_plant_phase_currents(s, i);
    }
    for (int k = 0; k < s->current_count; k++) {
        s->current[k]->effect->current_sensor(s->current[k]->p, i);
    }
    if (m->current_noise_a > 0.0) {
        const double *const n = next_noise(s);
        i[0] += m->current_noise_a * n[0];
        i[1] += m->current_noise_a * n[1];
    }
    out->ia_a = convert(i[0], m->current_lsb_a, m->current_range_a);
    out->ib_a = convert(i[1], m->current_lsb_a, m->current_range_a);
    out->vdc_v = s->vdc_filtered_v;

    double angle = sim_encoder_angle(s);
    if (m->counts_per_rev > 0.0) {
        angle = counted(s, angle) * s->count_rad;
    } else {
        angle -= 2.0 * SIM_PI * (double)sim_whole_below(angle * (0.5 / SIM_PI));
    }
    out->theta_m_rad = ((angle < 0.0) || (angle >= 2.0 * SIM_PI)) ? 0.0 : angle;

    s->at_read = s->x;
    s->load_nm = s->outside.load_torque_nm + sim_direction_of(sim_plant_load_speed(s)) * s->outside.load_brake_nm;
}
