/**
 * @file  sim_host/plant/plant.h
 * @brief The machine: dq motor with saliency, average-voltage inverter, shaft, load, sensors. Knows no firmware.
 *
 *     Ld did/dt = vd - R id + we (Lq iq - h_d)                                                           (1)
 *     Lq diq/dt = vq - R iq - we (Ld id + psi + h_q)                                                     (2)
 *     T = 1.5 p ((psi + h_q) iq + h_d id + (Ld - Lq) id iq)                                              (3)
 *     J dw/dt = T + sum of torques - B w - load - sign(w) friction                                       (4)
 *
 * Amplitude-invariant frame, d on the magnets. h_d, h_q: flux harmonics, 0 without that effect. With saturation the
 * flux linkages of the axes take the place of Ld id and Lq iq, their slopes that of Ld and Lq on the left. With a shaft
 * that is not stiff (coupling.h) J is that of the rotor, load, brake and a share of B act on the load, the remainder on the rotor.
 * Integration: fixed-step RK4 in the rotor frame; the phase voltage is constant over a step and turned by the small
 * angle that the rotor has moved, one sine and cosine a step. Friction is exact at standstill: a step in which the
 * speed passes zero ends there, and the shaft stays when the remaining torque is below the friction.
 *
 * plant.c starts it, inverter.c makes a period of steps, dc_link.c the voltage between two periods, step.c one step of runge_kutta over the rates of machine;
 * encoder.c follows the angle as it goes, sensors.c reads at the start of a period.
 */
#ifndef SIM_HOST_PLANT_PLANT_H
#define SIM_HOST_PLANT_PLANT_H

#include <stdint.h>

#include "sim_host/plant/coupling.h"
#include "sim_host/plant/dc_link.h"
#include "sim_host/plant/delay.h"
#include "sim_host/plant/effect.h"
#include "sim_host/plant/random.h"

#define SIM_EFFECTS_MAX 32

typedef struct {
    double id_a, iq_a;
    double speed_rad_s;
    double theta_m_rad; /**< Unwrapped. */
} sim_state_t;

/** A load that is not one piece with the rotor. */
typedef struct {
    double speed_rad_s;
    double twist_rad; /**< Rotor angle minus load angle. */
} sim_load_t;

/** What acts from outside during a period. */
typedef struct {
    double load_torque_nm; /**< Positive brakes positive rotation; may drive. */
    double load_brake_nm;  /**< >= 0; opposes motion, holds at standstill. */
    double dc_link_v;      /**< Of the source; the dc link itself, where the model has no capacitor. */
    double brake_duty;     /**< Mean on-time of the switch of the brake resistor. */
    int    open_phase;     /**< 1, 2, 3: phase a, b, c of the motor is open; 0: none. */
} sim_outside_t;

/** What the converter reads. */
typedef struct {
    double ia_a, ib_a, vdc_v;
    double theta_m_rad; /**< [0, 2 pi). */
} sim_reading_t;

/** An effect that acts, with its numbers. */
typedef struct {
    const sim_effect_t *effect;
    double              p[SIM_EFFECT_PARAMS];
} sim_acting_t;

/** Which features the step has to handle. */
typedef enum {
    SIM_PLAIN,      /**< No effect acts on torque, friction or flux. */
    SIM_WITH_HOOKS, /**< Some do. */
    SIM_SATURATING, /**< Saturation, too. */
    SIM_COUPLED     /**< A load behind a coupling, with or without saturation. */
} sim_machine_kind_t;

#define SIM_STEPS_KEPT 32
#define SIM_NOISE_PAIRS 32

/** One integration step as the encoder saw it. */
typedef struct {
    double before_rad, after_rad; /**< Measured angle, unwrapped. */
    double t0_s, h_s;
} sim_seen_step_t;

typedef struct {
    sim_model_t         model;
    sim_state_t         x;
    sim_load_t          load;
    sim_outside_t       outside;
    sim_random_t        noise;
    double              noise_pair[SIM_NOISE_PAIRS][2]; /**< Normal numbers drawn ahead. */
    int                 noise_left;                     /**< Numbers of noise_pair that are not used yet: the last ones. */
    const double       *noise_ahead;                    /**< What noise would draw first, in pairs; NULL: it draws by itself. */
    int64_t             noise_ahead_count;              /**< So many pairs. */
    int64_t             noise_ahead_at;                 /**< Pairs used. */
    double              time_s;
    double              period_s;
    int                 substeps;
    double              sine_e, cosine_e;            /**< Sine and cosine of the electrical angle, rotated from step to step. */
    int                 turns_left;                  /**< Rotations left until they are computed again. */
    double              inv_ld, inv_lq, inv_inertia; /**< A step does not divide. */
    double              torque_per_amp;              /**< 1.5 p. */
    sim_machine_kind_t  kind;
    sim_parts_t         parts;
    sim_coupling_t      coupling;
    sim_delay_t         delay;
    double              lagging_a[2]; /**< Currents behind the filter of the measurement, alpha and beta. */
    const sim_acting_t *saturation;   /**< NULL: none. */
    const sim_acting_t *bristle;      /**< NULL: none. */
    double              bristle_nm;   /**< Friction before the rotor slides, against positive motion. */
    sim_dc_link_t       link;
    double              link_v; /**< Dc-link voltage of this period. */
    double              vdc_filtered_v, vdc_gain;
    sim_state_t         at_read; /**< At the last start of a period. */
    double              load_nm; /**< What the torque sensor reads. */

    int          acting_count;
    sim_acting_t acting[SIM_EFFECTS_MAX];
    /* the acting effects by hook, so that a step visits only who has something to do */
    int                 torque_count, friction_count, flux_count, voltage_count, current_count, angle_count;
    const sim_acting_t *torque[SIM_EFFECTS_MAX], *friction[SIM_EFFECTS_MAX], *flux[SIM_EFFECTS_MAX], *voltage[SIM_EFFECTS_MAX],
        *current[SIM_EFFECTS_MAX], *angle[SIM_EFFECTS_MAX];

    double          count_rad, first_count; /**< Angle of a count of the reading; first count of the present turn. */
    double          edge_pitch_rad;         /**< Angle between two encoder edges. */
    sim_seen_step_t seen[SIM_STEPS_KEPT];   /**< Steps whose edges nobody has asked for yet: sim_plant_find_edge. */
    int             seen_count;
    int64_t         edge_cell;  /**< floor(measured angle / pitch), before these steps. */
    int64_t         edge_count; /**< Position of the last edge passed, and when. */
    double          edge_time_s;
    double          origin_rad;                  /**< Angle that the encoder reads as 0: 0 for an absolute one. */
    int64_t         index_turn;                  /**< floor(measured angle / turn). */
    double          turn_low_rad, turn_high_rad; /**< Within these the measured angle is in this turn for sure. */
    uint16_t        index_passes;                /**< How often the index pulse has been passed; after 65535 comes 1. */
    double          index_rad;                   /**< Encoder reading at the index pulse, [0, 2 pi). */
} sim_plant_t;

/**
 * Start the machine.
 * @param values  SIM_EFFECT_PARAMS numbers for each effect of the table, in its order.
 * @param edges_per_rev encoder edges per turn for the edge timer (an ideal encoder has them, too).
 * @return NULL, or the name of what does not fit: a field of the model, or an effect on a shaft that another one has.
 */
const char *sim_plant_start(sim_plant_t *s, const sim_model_t *m, const double (*values)[SIM_EFFECT_PARAMS], double edges_per_rev,
                            uint64_t seed);
/** One PWM period with phase duties in [0, 1]; with gates off (@p armed false) the diodes conduct until the current is gone. */
void sim_plant_period(sim_plant_t *s, const double duty[3], bool armed);
/** Sample the sensors now; draws noise. */
void sim_plant_read(sim_plant_t *s, sim_reading_t *out);
/** Bring edge_cell, edge_count and edge_time_s up to now. Steps only keep what this needs: a drive asks once in many of them. */
void sim_plant_find_edge(sim_plant_t *s);
/** Torque of the motor, (3), when the sensors were sampled last. */
double sim_plant_torque(const sim_plant_t *s);
/** Dc-link voltage now, V. */
double sim_plant_dc_link_v(const sim_plant_t *s);
/** Power in the brake resistor now, W. */
double sim_plant_brake_w(const sim_plant_t *s);
/** True phase currents, A. */
void sim_plant_phase_currents(const sim_plant_t *s, double i_abc[3]);
/** Speed of the load: the rotor's, where they are one piece. */
double sim_plant_load_speed(const sim_plant_t *s);

#endif
