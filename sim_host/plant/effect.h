/**
 * @file  sim_host/plant/effect.h
 * @brief What a non-ideal effect is: a descriptor with its parameters and the places where it acts.
 *
 * One effect is one file in sim_host/effects/, which defines `const sim_effect_t effect_<name>` in `<name>.c`. The build
 * collects the files, so that a new file is a new effect: for the simulator, the command line, the documentation and
 * the gap workflow, which searches its parameters by their roles. A hook that is NULL does not act; hooks of effects
 * that are off cost nothing. The build refuses more than SIM_EFFECTS_MAX effects, and a second one with a linkage_wb or a
 * bristle_nm.
 */
#ifndef SIM_HOST_PLANT_EFFECT_H
#define SIM_HOST_PLANT_EFFECT_H

#include "sim_host/plant/model.h"

#define SIM_EFFECT_PARAMS 32
#define SIM_EFFECT_NEIGHBOURS 4
#define SIM_DELAY_PERIODS 8

/** The shaft as an effect sees it. */
typedef struct {
    double theta_m_rad; /**< Unwrapped. */
    double speed_rad_s;
    double time_s; /**< Since the start, at the start of the period. */
} sim_shaft_t;

/** Magnet flux beside its fundamental, in the rotor frame, and at which electrical angle. */
typedef struct {
    double d_wb, q_wb; /**< Added to back-EMF per electrical speed: e_d = w d_wb, e_q = w (psi + q_wb). */
} sim_flux_t;

/** The bridge as an effect sees it, over one integration step. */
typedef struct {
    double pwm_hz, dc_link_v;
    double time_s;           /**< Of the step, since the start. */
    double from_s, length_s; /**< The step, from the start of its PWM period. */
    double begin_a[3];       /**< Phase currents at the start of the step. */
    double end_a[3];         /**< Phase currents at its end, if no effect acted on the voltage. */
    double inverse_h;        /**< Inverse inductance, mean of the axes. */
} sim_bridge_t;

/** Parts that the nominal machine does not have. All 0: none of them. */
typedef struct {
    double delay_periods;       /**< The bridge follows the duties this much later, up to SIM_DELAY_PERIODS; fractions count. */
    double current_lag_s;       /**< Time constant of the current measurement. */
    double resonance_hz;        /**< Shaft between rotor and load, both free; 0: they are one piece. */
    double damping_ratio;       /**< Of this resonance. */
    double load_ratio;          /**< Inertia of the load over the total, [0, 1). */
    double load_friction_share; /**< Of the viscous friction, on the load. */
    double backlash_rad;        /**< Total backlash of the shaft. */
    bool   has_backlash;        /**< The shaft can push but not pull, even with a backlash of 0. */
} sim_parts_t;

/** What a parameter is, for whoever searches it or reports it. */
typedef enum {
    SIM_AMPLITUDE = 0, /**< How large the effect is: none at `off`. */
    SIM_PHASE,         /**< Angle, rad, of the amplitude before it: an angle that is 2 pi off is the same one. */
    SIM_FACTOR,        /**< On a number of the nominal machine; 1: as nominal. */
    SIM_ORDER,         /**< Cycles per turn: follows from the machine and is not searched. */
    SIM_SIGN,          /**< +1 or -1. */
    SIM_SHARE,         /**< Part of a whole, 0 to 1. */
    SIM_QUANTITY,      /**< A number of its own, such as a frequency or a speed, that means nothing while the effect is off. */
    SIM_DETAIL         /**< How the effect is modelled: fitted along, not reported. */
} sim_role_t;

#define SIM_VECTOR 1U   /**< Together with the others that have this flag: only the length of all says how large one is. */
#define SIM_OPTIONAL 2U /**< May be nothing although the effect acts. */

typedef struct {
    const char *name, *unit, *doc;
    double      off, min, max;
    sim_role_t  role;
    double      example; /**< Shows clearly in a drive of some hundred watts. */
    unsigned    flags;
} sim_effect_param_t;

/** An experiment of the log format, and under which condition an effect shows in it ("": any). */
typedef struct {
    const char *experiment, *condition;
} sim_shown_by_t;

typedef struct {
    const char        *name;
    const char        *acts_on; /**< For people: "torque", "current_sensor", ... */
    const char        *doc;
    const char        *signature;                            /**< How it shows in a log. */
    const char        *confused_with[SIM_EFFECT_NEIGHBOURS]; /**< Similar effects; NULL: no more. */
    sim_shown_by_t     shown_by[SIM_EFFECT_NEIGHBOURS];      /**< Experiments that make it identifiable. */
    const char        *told_apart;                           /**< What separates it from the similar effects. */
    bool               scenario_only; /**< Never the explanation of a log: a sum of others, or a fault on purpose. */
    bool               at_load;       /**< torque_nm acts on the load, where that is not one piece with the rotor. */
    int                param_count;
    sim_effect_param_t param[SIM_EFFECT_PARAMS];

    /** Parameter @p p is off when every parameter has its off value; else the effect acts. */
    void (*model)(const double *p, sim_model_t *m);     /**< Change the machine before the start. */
    void (*parts)(const double *p, sim_parts_t *parts); /**< Add parts before the start. */
    /** Flux linkage of an axis of nominal inductance @p l_h from its own current and that of the other axis, and the
     *  inductance against which the own one changes. One effect at most. */
    double (*linkage_wb)(const double *p, double l_h, double i_a, double other_a, double *slope_h);
    /** This slope_h alone, where that is cheaper; NULL: linkage_wb is asked. */
    double (*slope_h)(const double *p, double l_h, double i_a, double other_a);
    double (*torque_nm)(const double *p, const sim_shaft_t *shaft); /**< Torque on the shaft, positive drives it forward. */
    double (*friction_nm)(const double *p, double speed_abs_rad_s); /**< Size of a torque that opposes any motion, >= 0. */
    /** Friction that a rotor meets before it slides, against positive motion, after it has moved by this angle from where
     *  the friction was @p held_nm. The plant keeps it from step to step. One effect at most. */
    double (*bristle_nm)(const double *p, double held_nm, double moved_rad, double speed_abs_rad_s);
    void (*flux)(const double *p, const sim_model_t *m, double theta_e_rad, double time_s, sim_flux_t *flux);
    void (*phase_voltage)(const double *p, const sim_bridge_t *bridge, double v_abc_v[3]);
    void (*current_sensor)(const double *p, double i_ab_a[2]);                         /**< Phases a and b, before noise. */
    double (*angle_sensor)(const double *p, const sim_model_t *m, double theta_m_rad); /**< Angle that the encoder sees. */
} sim_effect_t;

/** The table, in alphabetical order (made by the build from the files of sim_host/effects/). */
extern const sim_effect_t *const sim_effects[];
extern const int                 sim_effect_total;

#endif
