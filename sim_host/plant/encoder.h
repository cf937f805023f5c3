/**
 * @file  sim_host/plant/encoder.h
 * @brief What the encoder sees, its edges and its index pulse; inside of the plant.
 */
#ifndef SIM_HOST_PLANT_ENCODER_H
#define SIM_HOST_PLANT_ENCODER_H

#include "sim_host/plant/frame.h"
#include "sim_host/plant/whole.h"

/** Angle of the rotor as the encoder sees it, unwrapped and not rounded. */
static SIM_WITHIN double sim_encoder_angle(const sim_plant_t *s)
{
    double angle = s->x.theta_m_rad;
    for (int i = 0; i < s->angle_count; i++) {
        angle = s->angle[i]->effect->angle_sensor(s->angle[i]->p, &s->model, angle);
    }
    return angle - s->origin_rad;
}

/** Start at the present angle. */
void sim_encoder_start(sim_plant_t *s, double edges_per_rev);
/** A step in which the index may have been passed: its edges and the index, now. */
void sim_encoder_note_index(sim_plant_t *s, const sim_seen_step_t *step);

/** Keep a step from @p t0_s, @p h long, that began at the measured angle @p before_rad and has ended at the present one. */
static SIM_WITHIN void sim_encoder_note(sim_plant_t *s, double before_rad, double t0_s, double h)
{
    const double after_rad = sim_encoder_angle(s);
    if (s->seen_count == SIM_STEPS_KEPT) {
        sim_plant_find_edge(s);
    }
    sim_seen_step_t *const step = &s->seen[s->seen_count];
    step->before_rad = before_rad;
    step->after_rad = after_rad;
    step->t0_s = t0_s;
    step->h_s = h;
    if ((after_rad > s->turn_low_rad) && (after_rad < s->turn_high_rad)) {
        s->seen_count++;
    } else {
        const sim_seen_step_t at_index = *step;
        sim_encoder_note_index(s, &at_index);
    }
}

#endif
