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

/* ---- lists: drive parameters, signals, plant model, effects, faults --------------------------------------------- */

typedef struct {
    const char *name; /* carries its unit as suffix */
    const char *unit; /* "" when dimensionless */
    const char *kind; /* "float", "integer", "flag", "choice" */
    const char *doc;
    const char *choices;         /* for kind "choice": "a|b|c", value = position; otherwise "" */
    double      min, max, value; /* range and default */
    bool        at_rest;         /* drive parameters: only changes while the bridge is off */
} es_field_t;

typedef struct {
    const char *name;
    const char *acts_on; /* "torque", "current_sensor", "angle_sensor", "inverter", "model", ... */
    const char *doc;
    const char *signature;     /* how it shows in a log, for the person who looks for it */
    const char *told_apart;    /* what separates it from effects that look alike; "" when nobody said */
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
    const char *check; /* first thing to look at */
} es_fault_t;

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
const char *es_effect_neighbour(int effect, int index); /* an effect that looks alike; NULL: no more */
/* an experiment of the log format in which the effect shows, and the condition ("": any); false: no more */
bool     es_effect_shown_by(int effect, int index, const char **experiment, const char **condition);
int      es_fault_count(void);
bool     es_fault_info(int index, es_fault_t *out);
int      es_command_count(void);                      /* commands of the bench link (firmware/link/protocol.def) */
bool     es_command_info(int index, es_field_t *out); /* name and doc */
uint32_t es_schema_hash(void);                        /* of parameters, signals, faults and commands, see docs/protocol.md */

/* ---- the simulated drive: the firmware on the plant -------------------------------------------------------------- */

typedef struct es_sim es_sim_t;

es_sim_t   *es_sim_new(void);
void        es_sim_free(es_sim_t *sim);
const char *es_sim_error(const es_sim_t *sim); /* why the last call on this object said false: "name = value: limit" */

/* For the next es_sim_start; inputs act at once. Each refuses an unknown name, a value that is not finite or out of range. */
bool es_sim_set_model(es_sim_t *sim, const char *name, double value);
bool es_sim_set_param(es_sim_t *sim, const char *name, double value);
bool es_sim_set_effect(es_sim_t *sim, const char *effect, const char *param, double value);
bool es_sim_set_seed(es_sim_t *sim, uint64_t seed);
/* Value of an input over time: count >= 1 points, t_s rising, first value holds before the first point and the last
 * after the last; linear: ramp between points, otherwise hold. The arrays are copied. */
bool es_sim_set_input(es_sim_t *sim, const char *name, const double *t_s, const double *value, int count, bool linear);

bool es_sim_start(es_sim_t *sim); /* checks everything, builds plant and drive; time 0; with auto_run = 1
 * and without a link the simulation gives the start command, and no timeout runs; with a link auto_run counts as on the board: only as
 * stored, see es_sim_storage_write, and under the timeout of the link. */

/* Run up to `periods` PWM periods and write every decimate-th sample (the first one at the start) of the chosen
 * signals to out, row by row. Returns the rows written; stops early when `capacity_rows` is full. A fault of the drive
 * does not stop the simulation (signal "fault" tells). May be called again to go on. */
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
/* The non-volatile storage. read: number of words there are. write: kept over the next starts, which else erase it. */
int  es_sim_storage_read(const es_sim_t *sim, uint16_t *words, int room);
bool es_sim_storage_write(es_sim_t *sim, const uint16_t *words, int count);

/* ---- blocks -------------------------------------------------------------------------------------------------------- */

/* Coefficients A_0..A_order of z^-frac; out has room for 4. Returns how many were written, 0 when refused. */
int    es_lagrange(int order, double frac, double *out);
double es_fal(double e, double alpha, double delta);
double es_fal_lambda(double e, double alpha, double delta);
void   es_sincos(double angle_rad, double *sine, double *cosine);
double es_pow(double base, double exponent);
bool   es_clarke(double a, double b, double c, double *alpha_beta);
bool   es_inverse_clarke(double alpha, double beta, double *abc);
bool   es_park(double alpha, double beta, double angle_rad, double *dq);
bool   es_inverse_park(double d, double q, double angle_rad, double *alpha_beta);
bool   es_vector_limit(double d, double q, double limit, double *dq);
bool   es_svm(double v_alpha, double v_beta, double v_dc, double *duty_abc);

typedef struct es_rc es_rc_t;
/* fal_at: 0 no fal, 1 at the memory input (A), 2 lambda at the output (B). memory: 0 keep, 1 clear, 2 angle.
 * NULL when refused; es_block_error() then says field, value and limit. */
es_rc_t    *es_rc_new(double gain, int lead, double q_side, double q_centre, int order, int fal_at, double alpha, double delta,
                      bool truncate, int memory, int capacity, double limit, double freeze_above, int freeze_samples);
void        es_rc_free(es_rc_t *rc);
void        es_rc_reset(es_rc_t *rc);
double      es_rc_step(es_rc_t *rc, double error, double period_samples, double theta_e_rad);
uint32_t    es_rc_rejected(const es_rc_t *rc);
const char *es_block_error(void);

typedef struct es_pi es_pi_t;
es_pi_t             *es_pi_new(double kp, double ki_ts, double out_min, double out_max, int anti_windup);
void                 es_pi_free(es_pi_t *pi);
void                 es_pi_reset(es_pi_t *pi, double integrator);
double               es_pi_output(es_pi_t *pi, double error);
void                 es_pi_commit(es_pi_t *pi, double realised);

typedef struct es_pll es_pll_t;
es_pll_t             *es_pll_new(double kp, double ki, double ts_s);
void                  es_pll_free(es_pll_t *pll);
void                  es_pll_reset(es_pll_t *pll, double angle_rad);
double                es_pll_step(es_pll_t *pll, double angle_rad); /* returns speed, rad/s */

typedef struct es_mt es_mt_t;
es_mt_t             *es_mt_new(int counts_per_rev, double clock_hz, double ts_s);
void                 es_mt_free(es_mt_t *mt);
double               es_mt_step(es_mt_t *mt, int32_t edge_count, uint32_t edge_cyc, uint32_t now_cyc); /* rad/s */

typedef struct es_angle_memory es_angle_memory_t;
/* write: 0 one, 1 all, 2 hat; read: 0 linear, 1 cubic. Angles are unwrapped radians. */
es_angle_memory_t *es_angle_memory_new(int cells, double gain, double forgetting, int write, int read, double limit);
void               es_angle_memory_free(es_angle_memory_t *memory);
void               es_angle_memory_write(es_angle_memory_t *memory, double theta_rad, double value);
double             es_angle_memory_read(const es_angle_memory_t *memory, double theta_rad);
int                es_angle_memory_cells(const es_angle_memory_t *memory, double *out, int room);
uint32_t           es_angle_memory_rejected(const es_angle_memory_t *memory);

typedef struct es_fir es_fir_t;
/* Hamming low-pass; taps_out may be NULL or have room for order + 1. */
es_fir_t *es_fir_new(int order, double cutoff_over_rate, double *taps_out);
void      es_fir_free(es_fir_t *fir);
double    es_fir_step(es_fir_t *fir, double x);
double    es_fir_delay_samples(const es_fir_t *fir);

typedef struct es_observer es_observer_t;
/* Meter and observer as the drive has them; torque and reference in N m, SI throughout. kind: 0 dob, 1 ro, 2 aro.
 * age_samples 0: the true one. */
es_observer_t *es_observer_new(int kind, double inertia_kgm2, double viscous_nms, double ts_s, int fir1_order, double fir1_hz,
                               int fir2_order, double fir2_hz, double actuation_samples, double age_samples, double gain,
                               double forgetting, int cells, int write, int read);
void           es_observer_free(es_observer_t *observer);
/* One sample: estimate of the disturbance torque when a reference of now acts, N m. seen: [speed rad/s, torque N m]. */
double es_observer_step(es_observer_t *observer, double theta_m_rad, double ref_last_nm, double *seen);
double es_observer_age_samples(const es_observer_t *observer);

typedef struct es_deadbeat es_deadbeat_t;
es_deadbeat_t             *es_deadbeat_new(double r_ohm, double ld_h, double lq_h, double psi_wb, int pole_pairs, double ts_s,
                                           double correction);
void                       es_deadbeat_free(es_deadbeat_t *deadbeat);
/* in: [id, iq, id_ref, iq_ref, speed_m rad/s, vd_last, vq_last]; out: [vd, vq] */
void es_deadbeat_step(es_deadbeat_t *deadbeat, const double *in, double *out);

/* Coulomb and Stribeck friction at a speed, torque unit; false when refused. */
bool es_stribeck(double speed, double coulomb, double stat, double stribeck, double shape, double *torque);
/* Robust term for e = [integral of the angle error, angle error, speed error]; false when refused. */
bool es_rdc_robust_term(const double *e, const double *p_row, double inertia, double rho, double sigma, double *torque);
/* Low-pass of the spatial repetitive controller at this speed, bilinear without prewarping: b[3], a[3]; false when refused. */
bool es_spatial_lowpass(double cutoff_per_rad, double speed_rad_s, double ts_s, double *b, double *a);

typedef struct es_profile es_profile_t;
/* Motion profile; acceleration 0: unlimited. smooth: samples of the mean that limits the jerk. */
es_profile_t *es_profile_new(double speed_rad_s, double accel_rad_s2, int smooth, double ts_s);
void          es_profile_free(es_profile_t *profile);
void          es_profile_reset(es_profile_t *profile, double position_rad);
/* One sample; out: [position rad, speed rad/s, acceleration rad/s^2]. Returns true at the target and at rest. */
bool es_profile_step(es_profile_t *profile, double target_rad, double *out);

/* ---- measuring ------------------------------------------------------------------------------------------------------ */

double es_monotonic_s(void); /* clock for the simulator's own benchmark */

#ifdef __cplusplus
}
#endif
#endif
