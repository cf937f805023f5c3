/**
 * @file  sim_host/capi/sim.h
 * @brief The simulated drive, as the files of this folder share it: setup.c makes it, inputs.c moves it, run.c runs it.
 */
#ifndef SIM_HOST_CAPI_SIM_H
#define SIM_HOST_CAPI_SIM_H

#include "firmware/app/drive.h"
#include "firmware/app/telemetry.h"
#include "firmware/services/services.h"
#include "sim_host/board/board.h"
#include "sim_host/capi/error.h"
#include "sim_host/trace/trace.h"

#define CAPI_SIGNALS_MAX 96
#define CAPI_CAPTURE_VALUES 6140 /* as on the chip, see linker/f28379d_flash.cmd */
#define CAPI_BLACK_BOX_VALUES 2048

enum {
#define INPUT(name, unit, def, lo, hi, doc) INPUT_##name,
#include "sim_host/capi/inputs.def"
#undef INPUT
    INPUT_COUNT
};

/** A value over time: count points, 0 when it was never set. */
typedef struct {
    double *t_s, *value;
    int     count, at; /**< `at`: the point that holds now. */
    bool    linear;
    double  now;
} capi_track_t;

struct es_sim {
    sim_board_t     board;
    drive_t         drive;
    sim_model_t     model;
    drive_params_t  params;
    double          effect[SIM_EFFECTS_MAX][SIM_EFFECT_PARAMS];
    uint64_t        seed;
    const double   *noise; /**< Of this seed, drawn ahead, two numbers a period; NULL: none. */
    int64_t         noise_periods;
    capi_track_t    input[INPUT_COUNT];
    bool            started;
    drive_command_t sent;
    bool            home_asked;
    double         *table; /**< Learned table that waits for the start. */
    int             table_cells;
    double          inputs_until;        /**< Time at which an input changes next; -INFINITY: all of them are passed on. */
    int             moving[INPUT_COUNT]; /**< Inputs that have points left, and how many these are. */
    int             moving_count;
    int             signal[CAPI_SIGNALS_MAX];
    int             signal_count;
    bool            linked; /**< The services run. */
    services_t      services;
    float           capture[CAPI_CAPTURE_VALUES], black_box[CAPI_BLACK_BOX_VALUES];
    bool            storage_kept; /**< Over the next start. */
    trace_t         trace;        /**< Written while board.trace points at it. */
    es_error_t      error;
};

/** inputs.c: every input at its default, or at the first point again. */
void capi_inputs_default(es_sim_t *sim);
void capi_inputs_rewind(es_sim_t *sim);
void capi_inputs_free(es_sim_t *sim);
/** inputs.c: pass to plant, board and drive what holds at @p t_s. */
void capi_inputs_apply(es_sim_t *sim, double t_s);
/** inputs.c: refuse a speed reference that would only trip the drive. */
bool capi_reference_fits(es_sim_t *sim);

/** calls.c: calls of the firmware that no interrupt and no main loop makes, taken down in the trace. */
void capi_call_init(es_sim_t *sim);
void capi_call_services(es_sim_t *sim);
void capi_call_start(es_sim_t *sim);
void capi_call_background(es_sim_t *sim);
void capi_call_home(es_sim_t *sim);
void capi_call_command(es_sim_t *sim, const drive_command_t *command);
bool capi_call_tune(es_sim_t *sim, uint16_t param, const drive_params_t *params, uint16_t *culprit);
bool capi_call_memory_write(es_sim_t *sim, const float *amps, uint16_t cells);
bool capi_call_memory_clear(es_sim_t *sim);

/** signals.c: the list of the drive's telemetry and the truth of the plant. @return NULL, or -1, when there is none. */
const signal_info_t *capi_signal_info(int index);
int                  capi_signal_find(const char *name);
double               capi_signal_read(const es_sim_t *sim, int index);

/** trace.c: the end of a period, with all signals, where a trace is written. */
void capi_trace_period(es_sim_t *sim);

/** setup.c: position of a parameter in the table; PARAM_COUNT: there is none of this name. */
int capi_param_index(const char *name);
/** setup.c: set a parameter by its name in @p p. */
bool capi_param_set(es_sim_t *sim, drive_params_t *p, const char *name, double value);
/** setup.c: refuse because the drive does not take parameter @p culprit of @p p. */
bool capi_param_refuse(es_sim_t *sim, const drive_params_t *p, uint16_t culprit);
/** learned.c: pass the waiting table to the drive. */
bool capi_table_give(es_sim_t *sim);

/** A step at 0.1 s acts in the period that starts at 0.1 s, however that was rounded. */
#define CAPI_GRACE_S 0.5e-6

#endif
