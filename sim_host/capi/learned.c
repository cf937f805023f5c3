/* What the angle observer of the simulated drive has learned. */
#include <stdlib.h>
#include <string.h>

#include "sim_host/capi/sim.h"

bool capi_table_give(es_sim_t *sim)
{
    float amps[DRIVE_OBSERVER_CAPACITY];
    for (int i = 0; i < sim->table_cells; i++) {
        amps[i] = (float)sim->table[i];
    }
    return capi_call_memory_write(sim, amps, (uint16_t)sim->table_cells)
               ? true
               : capi_refuse(&sim->error, ES_NO_ANGLE_TABLE, "param", "memory", (double)sim->table_cells);
}

int es_sim_memory_read(const es_sim_t *sim, double *amps, int room)
{
    float table[DRIVE_OBSERVER_CAPACITY];
    if ((sim == NULL) || !sim->started) {
        return 0;
    }
    const int cells = drive_memory_read(&sim->drive, table, (uint16_t)DRIVE_OBSERVER_CAPACITY);
    for (int i = 0; (amps != NULL) && (i < cells) && (i < room); i++) {
        amps[i] = (double)table[i];
    }
    return cells;
}

bool es_sim_memory_write(es_sim_t *sim, const double *amps, int cells)
{
    if ((sim == NULL) || (amps == NULL)) {
        return false;
    }
    if ((cells < 1) || (cells > (int)DRIVE_OBSERVER_CAPACITY)) {
        return capi_refuse_range(&sim->error, ES_NOT_WHOLE, "param", "cells", (double)cells, 1, (double)DRIVE_OBSERVER_CAPACITY,
                                 "");
    }
    double *const copy = malloc((size_t)cells * sizeof *copy);
    if (copy == NULL) {
        return capi_refuse(&sim->error, ES_NO_MEMORY, "param", "cells", (double)cells);
    }
    memcpy(copy, amps, (size_t)cells * sizeof *copy);
    free(sim->table);
    sim->table = copy;
    sim->table_cells = cells;
    if (sim->started) {
        sim_board_select(&sim->board);
    }
    return !sim->started || capi_table_give(sim);
}

bool es_sim_memory_clear(es_sim_t *sim)
{
    if (sim == NULL) {
        return false;
    }
    free(sim->table);
    sim->table = NULL;
    sim_board_select(&sim->board);
    if (sim->started && !capi_call_memory_clear(sim)) {
        return capi_refuse(&sim->error, ES_RUNNING, "param", "memory", 0.0);
    }
    return true;
}
