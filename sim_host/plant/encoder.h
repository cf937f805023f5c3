/**
 * @file  sim_host/plant/encoder.h
 * @brief What the encoder sees, its edges and its index pulse; inside of the plant.
 */
#ifndef SIM_HOST_PLANT_ENCODER_H
#define SIM_HOST_PLANT_ENCODER_H

#include "sim_host/plant/plant.h"

/* floor for |x| < 2^62, without a call */
static inline int64_t sim_whole_below(double x)
{
    const int64_t cut = (int64_t)x;
    return ((double)cut > x) ? cut - 1 : cut;
}

/** Angle of the rotor as the encoder sees it, unwrapped and not rounded. */
static inline double sim_encoder_angle(const sim_plant_t *s)
{
    double angle = s->x.theta_m_rad;
    for (int i = 0; i < s->angle_count; i++) {
        angle = s->angle[i]->effect->angle_sensor(s->angle[i]->p, &s->model, angle);
    }
    return angle - s->origin_rad;
}

/** Start at the present angle. */
void sim_encoder_start(sim_plant_t *s, double edges_per_rev);
/** Note the edges between @p angle_before and the present angle: a step from @p t0_s, @p h long. */
void sim_encoder_note(sim_plant_t *s, double angle_before, double t0_s, double h);

#endif
