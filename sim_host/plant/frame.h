/**
 * @file  sim_host/plant/frame.h
 * @brief Phases, stator and rotor frame; inside of the plant. The frame turns along with the rotor from step to step.
 */
#ifndef SIM_HOST_PLANT_FRAME_H
#define SIM_HOST_PLANT_FRAME_H

#include <math.h>

#include "sim_host/plant/plant.h"

#define SIM_PI 3.14159265358979323846
#define SIM_SQRT3 1.73205080756887729353

/* Keeps what only some effects need out of the code that every step runs. */
#define SIM_NOINLINE __attribute__((noinline))
#define SIM_WITHIN inline __attribute__((always_inline)) /* and this is that code */

/** Three values without common part from their vector in the frame of the stator, and the vector of any three. */
static inline void sim_to_phases(double alpha, double beta, double i_abc[3])
{
    i_abc[0] = alpha;
    i_abc[1] = 0.5 * (-alpha + SIM_SQRT3 * beta);
    i_abc[2] = -i_abc[0] - i_abc[1];
}

static inline void sim_to_alpha_beta(const double v[3], double ab[2])
{
    ab[0] = (2.0 * v[0] - v[1] - v[2]) / 3.0;
    ab[1] = (v[1] - v[2]) / SIM_SQRT3;
}

/** Set the frame to where the rotor is. */
void sim_frame_turn(sim_plant_t *s);

/** Turn by a small angle; the series is exact to 2e-12 at 0.3 rad. */
static SIM_WITHIN void sim_frame_turn_by(sim_plant_t *s, double angle)
{
    if ((s->turns_left <= 0) || (fabs(angle) > 0.3)) {
        sim_frame_turn(s);
        return;
    }
    const double a2 = angle * angle;
    const double c = 1.0 - a2 * (1.0 / 2 - a2 * (1.0 / 24 - a2 * (1.0 / 720 - a2 * (1.0 / 40320))));
    const double n = angle * (1.0 - a2 * (1.0 / 6 - a2 * (1.0 / 120 - a2 * (1.0 / 5040 - a2 * (1.0 / 362880)))));
    const double cosine = s->cosine_e * c - s->sine_e * n;
    s->sine_e = s->sine_e * c + s->cosine_e * n;
    s->cosine_e = cosine;
    s->turns_left--;
}

#endif
