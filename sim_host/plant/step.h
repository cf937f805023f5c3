/**
 * @file  sim_host/plant/step.h
 * @brief One integration step under constant voltage, and what ends it early; inside of the plant.
 */
#ifndef SIM_HOST_PLANT_STEP_H
#define SIM_HOST_PLANT_STEP_H

#include "sim_host/plant/machine.h"

/** Currents and their slopes in the frame of the stator, alpha and beta. */
typedef struct {
    double i[2], slope[2];
} sim_still_t;

/** A step under this voltage, before friction is decided: friction does not act, the shaft is free. */
static SIM_WITHIN sim_step_t sim_step_begin(const sim_plant_t *s, const double v_ab[2])
{
    const double     c = s->cosine_e;
    const double     n = s->sine_e;
    const sim_step_t step = {
        .vd_v = v_ab[0] * c + v_ab[1] * n, .vq_v = v_ab[1] * c - v_ab[0] * n, .theta0_rad = s->x.theta_m_rad};
    return step;
}

/** The dc link at the end of a period, where it is not stiff. */
void sim_plant_end_link_period(sim_plant_t *s);
/** At the start of the @p step. */
sim_still_t sim_stator_view(const sim_plant_t *s, const sim_step_t *step);
/** Advance by at most h; ends early where a speed passes zero against friction, and at the flanks of a coupling unless
 *  this is the @p last piece. @return time done. */
double sim_step_piece(sim_plant_t *s, const double v_ab[2], double h, bool last, double t0_s);

#endif
