#include "sim_host/plant/encoder.h"

#define TURN (2.0 * SIM_PI)
#define ROUNDING 1e-12 /* relative: more than an angle and its quotient are rounded by */

/** The turn of the index that the measured angle is in. */
static void take_turn(sim_plant_t *s, int64_t turn)
{
    const double low = (double)turn * TURN - s->origin_rad;
    const double margin = ROUNDING * (TURN + fabs((double)turn * TURN) + fabs(s->origin_rad));
    s->index_turn = turn;
    s->turn_low_rad = low + margin;
    s->turn_high_rad = low + TURN - margin;
}

void sim_encoder_start(sim_plant_t *s, double edges_per_rev)
{
    const int64_t turn = sim_whole_below(sim_encoder_angle(s) * (0.5 / SIM_PI));
    s->index_passes = (s->model.encoder_absolute != 0.0) ? 1U : 0U;
    s->origin_rad = (s->index_passes != 0U) ? 0.0 : sim_encoder_angle(s);
    take_turn(s, turn);
    s->count_rad = (s->model.counts_per_rev > 0.0) ? 2.0 * SIM_PI / s->model.counts_per_rev : 0.0;
    s->first_count = 0.0;
    s->edge_pitch_rad = 2.0 * SIM_PI / edges_per_rev;
    s->edge_cell = sim_whole_below(sim_encoder_angle(s) / s->edge_pitch_rad);
    s->edge_count = s->edge_cell;
    s->seen_count = 0;
}

static double wrapped(double angle)
{
    const double a = angle - 2.0 * SIM_PI * (double)sim_whole_below(angle * (0.5 / SIM_PI));
    return (a < 0.0) ? 0.0 : a;
}

/** The last edge of a step between two cells. */
static void take_edge(sim_plant_t *s, const sim_seen_step_t *step, int64_t from, int64_t to)
{
    const double travel = step->after_rad - step->before_rad;
    s->edge_count = (to > from) ? to : (to + 1);
    const double part = (travel != 0.0) ? ((double)s->edge_count * s->edge_pitch_rad - step->before_rad) / travel : 1.0;
    s->edge_time_s = step->t0_s + step->h_s * ((part < 0.0) ? 0.0 : ((part > 1.0) ? 1.0 : part));
}

/* Backwards to the newest step that ended in another cell than the one before it. */
void sim_plant_find_edge(sim_plant_t *s)
{
    int           last = s->seen_count - 1;
    int64_t       cell = (last >= 0) ? sim_whole_below(s->seen[last].after_rad / s->edge_pitch_rad) : s->edge_cell;
    const int64_t now = cell;
    for (; last >= 0; last--) {
        const int64_t before = (last > 0) ? sim_whole_below(s->seen[last - 1].after_rad / s->edge_pitch_rad) : s->edge_cell;
        if (before != cell) {
            take_edge(s, &s->seen[last], before, cell);
            break;
        }
    }
    s->edge_cell = now;
    s->seen_count = 0;
}

void sim_encoder_note_index(sim_plant_t *s, const sim_seen_step_t *step)
{
    sim_plant_find_edge(s);
    const int64_t cell = sim_whole_below(step->after_rad / s->edge_pitch_rad);
    if (cell == s->edge_cell) {
        return;
    }
    take_edge(s, step, s->edge_cell, cell);
    s->edge_cell = cell;
    const int64_t turn = sim_whole_below((step->after_rad + s->origin_rad) * (0.5 / SIM_PI));
    if (turn != s->index_turn) {
        const int64_t passed = (turn > s->index_turn) ? turn : (turn + 1);
        take_turn(s, turn);
        s->index_passes = (uint16_t)((s->index_passes < UINT16_MAX) ? (s->index_passes + 1U) : 1U);
        s->index_rad = wrapped((double)passed * 2.0 * SIM_PI - s->origin_rad);
    }
}
