/* Running: interrupts and main loop of the firmware, period by period. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_host/capi/sim.h"

#define MAIN_LOOP_PERIODS 10U /* one pass of the main loop per millisecond */

static void interrupts(es_sim_t *s)
{
    trace_t *const t = s->board.trace;
    trace_enter(t, TRACE_current_isr);
    drive_current_isr(&s->drive);
    trace_leave(t);
    trace_enter(t, TRACE_watch_isr);
    drive_watch_isr(&s->drive);
    trace_leave(t);
    if (sim_board_speed_due(&s->board)) {
        sim_board_speed_begin(&s->board);
        trace_enter(t, TRACE_speed_isr);
        drive_speed_isr(&s->drive);
        trace_leave(t);
        sim_board_speed_end(&s->board);
    }
    if (s->linked) {
        trace_enter(t, TRACE_services_sample);
        services_sample(&s->services);
        trace_leave(t);
    }
    if ((s->board.periods % MAIN_LOOP_PERIODS) == 0U) {
        capi_call_background(s);
    }
    if (s->linked) {
        trace_enter(t, TRACE_services_pass);
        services_pass(&s->services);
        trace_leave(t);
    }
    capi_trace_period(s);
}

int64_t es_sim_run(es_sim_t *sim, int64_t periods, int decimate, double *out, int64_t capacity_rows)
{
    if ((sim == NULL) || !sim->started || (decimate < 1)) {
        return 0;
    }
    sim_board_select(&sim->board);
    int64_t rows = 0;
    for (int64_t k = 0; k < periods; k++) {
        const bool due = (out != NULL) && ((sim->board.periods % (uint64_t)decimate) == 0U);
        if (due && (rows >= capacity_rows)) {
            break;
        }
        const double t_s = (double)sim->board.periods * sim->board.plant.period_s;
        if (t_s + CAPI_GRACE_S >= sim->inputs_until) {
            capi_inputs_apply(sim, t_s);
        }
        interrupts(sim);
        if (due) {
            for (int i = 0; i < sim->signal_count; i++) {
                out[rows * sim->signal_count + i] = capi_signal_read(sim, sim->signal[i]);
            }
            rows++;
        }
        sim_board_period(&sim->board);
    }
    return rows;
}

double es_sim_time(const es_sim_t *sim) { return (sim != NULL) ? (double)sim->board.periods / (double)DRIVE_PWM_HZ : 0.0; }

double es_sim_read(const es_sim_t *sim, const char *signal)
{
    const int i = ((sim != NULL) && (signal != NULL) && sim->started) ? capi_signal_find(signal) : -1;
    return (i >= 0) ? capi_signal_read(sim, i) : (double)NAN;
}

bool es_sim_tune(es_sim_t *sim, const char *param, double value)
{
    if ((sim == NULL) || (param == NULL) || !sim->started) {
        return false;
    }
    drive_params_t p = *sim->drive.params;
    if (!capi_param_set(sim, &p, param, value)) {
        return false;
    }
    sim_board_select(&sim->board);
    uint16_t culprit = PARAM_COUNT;
    if (!capi_call_tune(sim, capi_param_index(param), &p, &culprit)) {
        if (drive_needs_rest(&sim->drive, culprit) && (params_get(&p, culprit) <= drive_board_max(culprit))) {
            return capi_refuse(&sim->error, ES_RUNNING, "param", params_info(culprit)->name, value);
        }
        return (culprit < (uint16_t)PARAM_COUNT) ? capi_param_refuse(sim, &p, culprit)
                                                 : capi_refuse(&sim->error, ES_WAITING, "param", param, value);
    }
    return true;
}
