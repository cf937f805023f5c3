/**
 * @file  control/motor/current_reference.h
 * @brief The d and q current that make a torque: most torque per ampere (MTPA), and field weakening at the voltage limit.
 *
 * Torque is counted in torque current, i_T = T / (1.5 p psi): the q current that makes it with id = 0. With k = (Ld - Lq) / psi
 *
 *     i_T = iq (1 + k id)                                                                                (1)
 *
 * MTPA: |i| is smallest for a torque where id (1 + k id) = k iq^2; with u = 1 + k id and t = |k i_T| that is
 *
 *     u^4 - u^3 = t^2,  id = k i_T^2 / u^3,  iq = i_T / u                                                (2)
 *
 * three Newton steps from an upper bound. A surface machine has k = 0, and id = 0 exactly.
 *
 * Field weakening: with n = v / (|w| psi_w), F = psi / Ld and Q = psi / Lq the voltage ellipse, less the resistance, is
 *
 *     (1 + id / F)^2 + (iq / Q)^2 = n^2                                                                  (3)
 *
 * id follows from it for the torque of now; where it meets the circle of the longest current gives the room of the torque. The
 * resistance takes 2 R w psi i_T + R^2 i^2 of v^2. v is what there is of voltage, times a correction that a feedback of the measured
 * voltage makes, so that motor data which are off cost no voltage. The correction falls faster than it rises, within [1/4, 3/2], and
 * goes back to 1 while the voltage is no limit.
 *
 * Maximum torque per volt: with x = 1 + id / F and c = k F / (1 - k F) the largest torque on (3) is where
 *
 *     x = 2 c n^2 / (1 + sqrt(1 + 8 c^2 n^2))                                                            (4)
 *
 * beyond id = -F for Lq > Ld, at it for a surface machine. No d current goes deeper; there the q current is cut to what (3) leaves.
 *
 * Source   Morimoto et al. 1990, "Expansion of operating limits for permanent magnet motor by current vector control"; (2) from
 *          Jahns et al. 1986; (4) is the derivative of iq (1 + k id) along (3).
 * Total    a step with an input that is not finite leaves id where it was, and counts. id within +-id_max, 0 <= iq_max <= its limit.
 * Cost     MTPA 4 divisions, a root and 25 products; field weakening 10 divisions and 10 roots more. Fixed: t up to 60, I F / (2 Q^2) up to 11 (with I the longest current).
 */
#ifndef CONTROL_MOTOR_CURRENT_REFERENCE_H
#define CONTROL_MOTOR_CURRENT_REFERENCE_H

#include "control/motor/frames.h"
#include "control/numeric/diag.h"

typedef struct {
    num_t saliency; /**< k, 1 / current unit. */
    num_t d_full;   /**< F, current unit, > 0. */
    num_t q_full;   /**< Q, current unit, > 0. */
    num_t emf;      /**< psi_w: voltage unit per speed unit, > 0. */
    num_t ohm;      /**< Voltage per current, >= 0. */
    num_t i_max;    /**< Longest current vector, > 0. */
    num_t iq_max;   /**< Largest q current, (0, i_max]. */
    num_t id_max;   /**< Largest d current on either side, [0, i_max]: what the magnets bear. */
    num_t share;    /**< Of the voltage limit that is used: 1 less the margin, [0.5, 1]. */
    num_t smooth;   /**< Share of a new voltage in the mean that the correction follows, (0, 1]. */
    num_t fall;     /**< Gain of the correction in a sample where the voltage is too large, (0, 1]. */
    num_t rise;     /**< Where it is too small, (0, 1]. */
    bool  mtpa;     /**< Most torque per ampere, (2); else id = 0 where the voltage is no limit. */
    bool  weakens;  /**< Field weakening, (3). */
} ctl_reference_params_t;

/** Parameters, and what follows from them. Made by ctl_reference_plan. */
typedef struct {
    ctl_reference_params_t params;
    num_t                  torque_max;  /**< Largest torque current where the voltage is no limit. */
    num_t                  id_at_max;   /**< id there. */
    num_t                  per_d_full;  /**< 1 / F. */
    num_t                  surely;      /**< (4) is at this id or below it. */
    num_t                  share_full;  /**< k F: of the torque that the flux of the magnets makes. */
    num_t                  volt_gain;   /**< c of (4). */
    num_t                  half_square; /**< of h in the .c file */
    num_t                  curvature;   /**< a there. */
} ctl_reference_plan_t;

typedef struct {
    num_t    id;       /**< d current reference. */
    num_t    iq_max;   /**< Bound of the q current. */
    num_t    q_share;  /**< q current per torque current, 1 / (1 + k id). */
    num_t    gain;     /**< Torque current per q current, 1 + k id. */
    num_t    room;     /**< Largest torque current in the next sample. */
    num_t    trim;     /**< Correction of the voltage. */
    num_t    used;     /**< Voltage over what may be used, mean. */
    num_t    drop;     /**< What the resistance takes of the square of the voltage, mean. */
    bool     limited;  /**< The voltage is the limit. */
    uint32_t rejected; /**< Steps with an input that was not finite. */
} ctl_reference_state_t;

typedef struct {
    num_t    torque;  /**< Torque current that is asked for. */
    num_t    speed;   /**< Mechanical. */
    num_t    v_limit; /**< Longest voltage vector there is. */
    ctl_dq_t volt;    /**< Voltage now. */
} ctl_reference_in_t;

enum {
    CTL_REFERENCE_SALIENCY = 1,
    CTL_REFERENCE_D_FULL,
    CTL_REFERENCE_Q_FULL,
    CTL_REFERENCE_EMF,
    CTL_REFERENCE_OHM,
    CTL_REFERENCE_I_MAX,
    CTL_REFERENCE_IQ_MAX,
    CTL_REFERENCE_ID_MAX,
    CTL_REFERENCE_SHARE,
    CTL_REFERENCE_GAIN
};

/** Validate, calculate what follows. On error @p plan stays as it was. */
ctl_diag_t ctl_reference_plan(ctl_reference_plan_t *plan, const ctl_reference_params_t *params);
/** No current, the voltage no limit. */
void ctl_reference_reset(const ctl_reference_plan_t *plan, ctl_reference_state_t *state);
/** One sample, any input; the plan may be another one in each sample. */
void ctl_reference_step(const ctl_reference_plan_t *plan, ctl_reference_state_t *state, const ctl_reference_in_t *in);
/** (2): d current of the torque current @p torque with @p saliency k. Total; t beyond 60 counts as 60, NaN as 0. */
num_t ctl_mtpa_id(num_t saliency, num_t torque);

#endif
