#include "sim_host/plant/encoder.h"

#include "sim_host/plant/frame.h"

void sim_encoder_start(sim_plant_t *s, double edges_per_rev)
{
    s->index_turn = sim_whole_below(sim_encoder_angle(s) * (0.5 / SIM_PI));
    s->index_seen = s->model.encoder_absolute != 0.0;
    s->origin_rad = s->index_seen ? 0.0 : sim_encoder_angle(s);
    s->edge_pitch_rad = 2.0 * SIM_PI / edges_per_rev;
    s->edge_cell = sim_whole_below(sim_encoder_angle(s) / s->edge_pitch_rad);
    s->edge_count = s->edge_cell;
}

static double wrapped(double angle)
{
    const double a = angle - 2.0 * SIM_PI * (double)sim_whole_below(angle * (0.5 / SIM_PI));
    return (a < 0.0) ? 0.0 : a;
}

static void note_index(sim_plant_t *s, double angle)
{
    const int64_t turn = sim_whole_below((angle + s->origin_rad) * (0.5 / SIM_PI));
    if (turn != s->index_turn) {
        const int64_t passed = (turn > s->index_turn) ? turn : (turn + 1);
        s->index_turn = turn;
        s->index_seen = true;
        s->index_rad = wrapped((double)passed * 2.0 * SIM_PI - s->origin_rad);
    }
}

void sim_encoder_note(sim_plant_t *s, double angle_before, double t0_s, double h)
{
    const double  angle = sim_encoder_angle(s);
    const int64_t cell = sim_whole_below(angle / s->edge_pitch_rad);
    if (cell != s->edge_cell) {
        s->edge_count = (cell > s->edge_cell) ? cell : (cell + 1);
        const double travel = angle - angle_before;
        const double part = (travel != 0.0) ? ((double)s->edge_count * s->edge_pitch_rad - angle_before) / travel : 1.0;
        s->edge_time_s = t0_s + h * ((part < 0.0) ? 0.0 : ((part > 1.0) ? 1.0 : part));
        s->edge_cell = cell;
        note_index(s, angle);
    }
}
