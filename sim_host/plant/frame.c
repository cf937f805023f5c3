#include "sim_host/plant/frame.h"

#define ROTATIONS_MAX 256

void sim_frame_turn(sim_plant_t *s)
{
    const double theta_e = s->model.pole_pairs * s->x.theta_m_rad;
    s->cosine_e = cos(theta_e);
    s->sine_e = sin(theta_e);
    s->turns_left = ROTATIONS_MAX;
}
