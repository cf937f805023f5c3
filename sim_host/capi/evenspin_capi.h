/**
 * @file  sim_host/capi/evenspin_capi.h
 * @brief The C interface that Python loads: introspection of the one list of everything, the simulated drive, the blocks.
 *
 * Plain prototypes and typedefs only: the Python side reads this very file (without its preprocessor lines) as its
 * declaration of the library. One library per numeric: evenspin_float and evenspin_fixed.
 * Strings returned are static or live as long as the object that returned them.
 * Every function is total: a NULL handle or an index out of range gives 0, false or NULL.
 */
#ifndef EVENSPIN_CAPI_H
#define EVENSPIN_CAPI_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- what this library is -------------------------------------------------------------------------------------- */

int         es_abi_version(void); /* raised when a prototype below changes */
const char *es_numeric(void);     /* "float" or "fixed" */

/* ---- refusals: why a call returned false, as values; the caller makes the sentence ------------------------------ */

typedef enum {
    ES_NONE,          /* nothing was refused */
    ES_NO_OBJECT,     /* the handle was NULL, or a text was */
    ES_NO_MEMORY,     /* `given` of `name` does not fit into memory */
    ES_UNKNOWN,       /* `list` has nothing of this `name`; `other`: of which effect or block */
    ES_OUT_OF_RANGE,  /* must be within min .. max, `above` and `below` without that end */
    ES_NOT_WHOLE,     /* as ES_OUT_OF_RANGE, and a whole number */
    ES_BREAKS_RULE,   /* within its range, but not what `rule` says */
    ES_LIMITED,       /* must be within min .. max, which is what the parameter `other` says */
    ES_BELOW_OTHER,   /* must be at least the parameter `other` */
    ES_NUMERIC,       /* the numeric cannot hold it; with `other`: not over that parameter */
    ES_TIMES,         /* of an input: no points, or times that are not finite or do not rise */
    ES_BOARD,         /* the board allows at most max */
    ES_OTHERS,        /* the other parameters leave min .. max */
    ES_COMBINATION,   /* does not go with `other`, whose value is `min`; `rule`: why, and what to do */
    ES_NO_FIT,        /* does not fit the other parameters */
    ES_RUNNING,       /* cannot change while the drive runs */
    ES_STARTED,       /* only before the start */
    ES_WAITING,       /* an earlier change has not been taken over yet */
    ES_TWO_SHAFTS,    /* the effects `name` and `other` are both on, and there is one shaft */
    ES_NO_ANGLE_TABLE /* needs method = aro, as many values as cells within the limit, and a drive that does not run */
} es_code_t;

typedef struct {
    es_code_t code;
    const char
        *list; /* what `name` is of: "model", "param", "effect", "effect_param", "input", "signal", "block", "block_param" */
    char name[64];
    const char *other; /* "" without; of an effect_param the effect, of a block_param the block */
    double      given, min, max;
    bool        above, below; /* min, max themselves are not allowed */
    const char *unit;         /* "" without */
    const char *rule;         /* of a block_param: "such that ..."; "" without */
} es_error_t;

/* ---- lists: drive parameters, signals, plant model, effects, faults --------------------------------------------- */

typedef struct {
    const char *name; /* carries its unit as suffix */
    const char *unit; /* "" when dimensionless */
    const char *kind; /* "float", "integer", "flag", "choice" */
    const char *doc;
    const char *choices;         /* for kind "choice": "a|b|c", value = position; else "" */
    double      min, max, value; /* range and default */
    bool        at_rest;         /* drive parameters: only changes while the bridge is off */
    bool        above, below;    /* parameters of blocks: min, max themselves are not allowed */
    const char *rule;            /* parameters of blocks: what else it must be, "such that ..."; "" nothing */
} es_field_t;

typedef struct {
    const char *name;
    const char *acts_on; /* "torque", "current_sensor", "angle_sensor", "inverter", "model", ... */
    const char *doc;
    const char *signature;     /* how it shows in a log, for the person who searches it */
    const char *told_apart;    /* what separates it from similar effects; "" when not given */
    bool        scenario_only; /* never the explanation of a log */
    int         param_count;
} es_effect_t;

typedef struct {
    const char *role;             /* "amplitude", "phase", "factor", "order", "sign", "share", "quantity", "detail" */
    double      example;          /* shows clearly in a drive of some hundred watts */
    bool        vector, optional; /* see SIM_VECTOR and SIM_OPTIONAL */
} es_role_t;

typedef struct {
    const char *name;
    const char *cause;
    const char *check; /* first thing to check */
} es_fault_t;

/** Drive parameters that do not go together: when, and why, is a sentence. */
typedef struct {
    const char *name, *param, *other, *why;
} es_combination_t;

int         es_param_count(void); /* drive parameters (firmware/app/parameters.def) */
bool        es_param_info(int index, es_field_t *out);
int         es_signal_count(void); /* everything es_sim_record knows: telemetry of the drive, then the truth of the plant */
bool        es_signal_info(int index, es_field_t *out);
int         es_model_count(void); /* plant model fields (sim_host/plant/model.def) */
bool        es_model_info(int index, es_field_t *out);
int         es_input_count(void); /* time-varying inputs of a simulation, see es_sim_set_input */
bool        es_input_info(int index, es_field_t *out);
int         es_effect_count(void);
bool        es_effect_info(int index, es_effect_t *out);
bool        es_effect_param_info(int effect, int param, es_field_t *out);
bool        es_effect_param_role(int effect, int param, es_role_t *out);
const char *es_effect_neighbour(int effect, int index); /* a similar effect; NULL: no more */
/* an experiment of the log format in which the effect shows, and the condition ("": any); false: no more */
bool     es_effect_shown_by(int effect, int index, const char **experiment, const char **condition);
int      es_combination_count(void);
bool     es_combination_info(int index, es_combination_t *out);
int      es_fault_count(void);
bool     es_fault_info(int index, es_fault_t *out);
int      es_command_count(void);                      /* commands of the bench link (firmware/link/protocol.def) */
bool     es_command_info(int index, es_field_t *out); /* name and doc */
uint32_t es_schema_hash(void);                        /* of parameters, signals, faults and commands, see docs/protocol.md */

/* ---- the simulated drive: the firmware on the plant -------------------------------------------------------------- */

typedef struct es_sim es_sim_t;

es_sim_t         *es_sim_new(void);
void              es_sim_free(es_sim_t *sim);
const es_error_t *es_sim_error(const es_sim_t *sim); /* why the last call on this object returned false; never NULL */

/* For the next es_sim_start; inputs act at once. Each refuses an unknown name, a value that is not finite or out of range. */
bool es_sim_set_model(es_sim_t *sim, const char *name, double value);
bool es_sim_set_param(es_sim_t *sim, const char *name, double value);
bool es_sim_set_effect(es_sim_t *sim, const char *effect, const char *param, double value);
bool es_sim_set_seed(es_sim_t *sim, uint64_t seed);
/* Normal numbers in the order in which a simulation with this seed draws its noise, two of them for each of `count` periods. */
void es_noise(uint64_t seed, double *pairs, int64_t count);
/* The seed, and its noise drawn ahead by es_noise, for simulations that share it: the run is the same to the last bit. The pairs are not
 * copied: they stay until the simulation is freed or its seed is set again. Refused when they are not those of the seed. */
bool es_sim_set_noise(es_sim_t *sim, uint64_t seed, const double *pairs, int64_t count);
/* Value of an input over time: count >= 1 points, t_s rising, first value holds before the first point and the last
 * after the last; linear: ramp between points, else hold. The arrays are copied. */
bool es_sim_set_input(es_sim_t *sim, const char *name, const double *t_s, const double *value, int count, bool linear);

bool es_sim_start(es_sim_t *sim); /* checks everything, builds plant and drive; time 0; with auto_run = 1
 * and without a link the simulation gives the start command, and no timeout runs; with a link auto_run counts as on the board: only as
 * stored, see es_sim_storage_write, and under the timeout of the link. */

/* Run up to `periods` PWM periods and write every decimate-th sample (the first one at the start) of the chosen
 * signals to out, row by row. Returns the rows written; stops early when `capacity_rows` is full. A fault of the drive
 * does not stop the simulation (reported by the signal "fault"). May be called again to go on. */
bool    es_sim_record(es_sim_t *sim, const char *const *signals, int count);
int64_t es_sim_run(es_sim_t *sim, int64_t periods, int decimate, double *out, int64_t capacity_rows);
double  es_sim_time(const es_sim_t *sim);                     /* s */
double  es_sim_read(const es_sim_t *sim, const char *signal); /* value of a signal in the last period; NaN if unknown */
/* Live changes while running (parameters are taken over between two samples). */
bool es_sim_tune(es_sim_t *sim, const char *param, double value);

/* What the angle observer has learned, A of q current over one mechanical turn; number of cells, 0 without one.
 * Writing and clearing need a drive that does not run; before es_sim_start a table waits until the start. */
int  es_sim_memory_read(const es_sim_t *sim, double *amps, int room);
bool es_sim_memory_write(es_sim_t *sim, const double *amps, int cells);
bool es_sim_memory_clear(es_sim_t *sim);

/* ---- the bench link of the simulated drive (docs/protocol.md) ------------------------------------------------------ */

/* Before es_sim_start: the services of the firmware run, too, once a period each for interrupt and main loop. The counter
 * on the link is the number of the period. */
bool es_sim_link_open(es_sim_t *sim);
/* Octets to the drive: how many were taken (4096 wait at most); octets from it: how many came. Between calls of es_sim_run. */
int es_sim_link_write(es_sim_t *sim, const uint8_t *octets, int count);
int es_sim_link_read(es_sim_t *sim, uint8_t *octets, int room);
/* The processor starts again, between calls of es_sim_run, while the machine goes on: hal_reset_t says why. Memory that its start-up leaves
 * alone stays, but for a power-up (1), after which it holds anything. false: no link is open, the run has not begun, or no such cause. */
bool es_sim_reset(es_sim_t *sim, int cause);
/* The non-volatile storage. read: number of words there are. write: kept over the next starts, which else erase it. */
int  es_sim_storage_read(const es_sim_t *sim, uint16_t *words, int room);
bool es_sim_storage_write(es_sim_t *sim, const uint16_t *words, int count);

/* ---- a memory that changes by itself: for campaigns of faults (sim_host/capi/regions.def) --------------------------- */

int         es_region_count(void); /* parts of the state of the drive */
const char *es_region_name(int index);
int         es_sim_region_bits(es_sim_t *sim, int index); /* of a started drive */
bool        es_sim_flip(es_sim_t *sim, int index, int bit);

/* ---- the trace of the simulated drive: everything that its firmware takes in, to replay it (docs/replay.md) --------- */

const char *es_firmware_id(void);   /* changes with every source of the firmware */
int         es_trace_version(void); /* of what stands in the streams */
int         es_trace_streams(void);
/* Before es_sim_start: from the start on everything is taken down, the signals themselves every `rows_every` periods. */
bool es_sim_trace_open(es_sim_t *sim, int rows_every);
/* Between calls of es_sim_run: octets in a stream; copy them, all or none; then begin again with empty streams. taken: false when
 * there was not enough memory, and what was written is not whole. */
int64_t es_sim_trace_size(const es_sim_t *sim, int stream);
int64_t es_sim_trace_read(const es_sim_t *sim, int stream, uint8_t *octets, int64_t room);
bool    es_sim_trace_taken(es_sim_t *sim);

/* ---- blocks: what runs in the interrupts, one by one ---------------------------------------------------------------- */

/* Functions without a memory. Those that may refuse say false and why; `error` may be NULL. */
bool   es_lagrange(int order, double frac, double *out, es_error_t *error); /* A_0 .. A_order of z^-frac; out: order + 1 */
bool   es_fal(double e, double alpha, double delta, double *out, es_error_t *error);
bool   es_fal_lambda(double e, double alpha, double delta, double *out, es_error_t *error);
void   es_sincos(double angle_rad, double *sine, double *cosine);
double es_pow(double base, double exponent);
bool   es_clarke(double a, double b, double c, double *alpha_beta); /* false: not finite, or limited */
bool   es_inverse_clarke(double alpha, double beta, double *abc);
bool   es_park(double alpha, double beta, double angle_rad, double *dq);
bool   es_inverse_park(double d, double q, double angle_rad, double *alpha_beta);
bool   es_vector_limit(double d, double q, double limit, double *dq);
bool   es_svm(double v_alpha, double v_beta, double v_dc, double *duty_abc);
/* Coulomb and Stribeck friction at a speed, torque unit. */
bool es_stribeck(double speed, double coulomb, double stat, double v_s, double shape, double *torque, es_error_t *error);
/* Robust term for e = [integral of the angle error, angle error, speed error]. */
bool es_rdc_robust_term(const double *e, const double *p_row, double inertia, double rho, double sigma, double *torque,
                        es_error_t *error);
/* Low-pass of the spatial repetitive controller at this speed, bilinear without prewarping: b[3], a[3]. */
bool es_spatial_lowpass(double cutoff_per_rad, double speed, double ts, double *b, double *a, es_error_t *error);

/* Blocks with a memory: each is a file in sim_host/capi/blocks/, which lists its parameters and what can be done with it. */
typedef struct {
    const char *name;
    const char *doc;
    int         param_count, action_count;
} es_block_info_t;

typedef struct {
    const char *name;    /* "step", "reset", ... */
    const char *doc;     /* with what it takes and what it gives */
    const char *inputs;  /* "a|b|c", with units as suffixes; "" none */
    const char *outputs; /* the same */
    int         input_count, output_count;
} es_action_t;

typedef struct es_block es_block_t;

int         es_block_count(void);
bool        es_block_info(int index, es_block_info_t *out);
bool        es_block_param_info(int block, int param, es_field_t *out);
bool        es_block_action_info(int block, int action, es_action_t *out);
es_block_t *es_block_new(const char *block, es_error_t *error); /* parameters as by default; NULL: no such block, no memory */
void        es_block_free(es_block_t *block);
bool        es_block_set(es_block_t *block, const char *param, double value, es_error_t *error); /* for the next start */
bool        es_block_start(es_block_t *block, es_error_t *error); /* from rest, also when it ran before */
/* Do action number `action` of the list; false before the start and for a number that is none. */
bool es_block_do(es_block_t *block, int action, const double *in, double *out);
/* The table of a block: its taps, or what it has learned. Returns the length, writes as many as there is room for. */
int es_block_table(const es_block_t *block, double *out, int room);

/* ---- writing --------------------------------------------------------------------------------------------------------- */

enum { ES_CSV_CELL = 20 }; /* characters that a number and its comma take at most, and the end of a text in between */
/* Rows of a CSV file, each number as "%.9g" writes it, and 0 without a sign. Returns the characters written, no 0 behind them; 0
 * when `room` is less than ES_CSV_CELL for each number. */
int64_t es_csv_rows(const double *values, int64_t rows, int columns, char *out, int64_t room);

/* ---- measuring ------------------------------------------------------------------------------------------------------ */

double es_monotonic_s(void); /* clock for the simulator's own benchmark */

#ifdef __cplusplus
}
#endif
#endif
