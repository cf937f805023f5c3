/**
 * @file  control/motor/current_error.h
 * @brief Offsets and gain differences of the current sensors, from means of voltage and current over electrical turns.
 *
 * Over a turn the flux comes back to where it began, so that whatever the speed, the load and their ripple did meanwhile
 *
 *     mean(v) = R mean(i)                                                                                 (1)
 *     mean(v e^{j theta}) = (R - j w L) mean(i e^{j theta})                                               (2)
 *
 * hold for the true vectors in the stationary frame. The measured current is i + n conj(i) + o: unequal gains make n, offsets o. With
 * the voltage commands, what a corrected current still has of either is
 *
 *     o = mean(i) - mean(v) / R                                                                           (3)
 *     n = [ mean(i e^{j theta}) - mean(v e^{j theta}) / (R - j w L) ] I / |I|^2,   I = mean(i e^{-j theta}) (4)
 *
 * Two sensors, c = -a - b:   n = (e_a - e_b) / sqrt(3) e^{j 30 deg}, gains 1 + e
 * Three sensors:             e_x = 2 Re(n e^{j phi_x}), phi = 0, 120, 240 deg
 * Offsets of a and b are the phase values of o; of three sensors the part that all have in common stays, and does not act.
 * The gain that all sensors have in common cannot be known from electrical signals; it is kept, and makes no ripple.
 *
 * Each turn takes a share of the residual away. (3) and (4) vanish with the error itself, so that a wrong R or L changes how fast
 * that goes and not where it ends: as long as nothing else asks for a dc or a negative-sequence current. What a torque ripple of the
 * first or second electrical order asks for, with a repetitive controller or an observer that cancels it, counts as an error by the
 * share by which R is wrong. Where a residual turns round from one turn to the next the share was too large, and is halved.
 *
 * Held     outside of steady speed, for turns of more than CTL_TURN_LONGEST or less than CTL_TURN_SHORTEST samples, below a least
 *          current, at the voltage limit. Estimates stay within their bounds: of two sensors whose gains are bounded by g, a wrong
 *          correction turns the current vector by g / sqrt(3) at most.
 * Source   own derivation from the stator equation; the current-error model is that of Guo et al. 2024, section 2.
 * Total    ctl_current_error_learn: sums that are not finite are not learned from, and counted.
 * Cost     a sample: 8 sums and 16 products, half of them in each of two periods; learn: once per turn, main loop, in float in both numerics,
 *          as configuration.
 */
#ifndef CONTROL_MOTOR_CURRENT_ERROR_H
#define CONTROL_MOTOR_CURRENT_ERROR_H

#include "control/motor/frames.h"
#include "control/numeric/angle.h"
#include "control/numeric/diag.h"

#define CTL_TURN_LONGEST 5000U /**< Samples of a turn; every second one counts: 1 s at 10 kHz, */
#define CTL_TURN_SHORTEST 16U  /**< and 312 Hz. */

/** Sums of many samples: exact in fixed point, where Q7.24 would saturate. */
#ifdef EVENSPIN_FIXED
typedef int64_t ctl_sum_t;
#else
typedef float ctl_sum_t;
#endif

/** Sums over one electrical turn. */
typedef struct {
    ctl_sum_t i_alpha, i_beta, v_alpha, v_beta; /**< Stationary frame. */
    ctl_sum_t i_re, i_im, v_re, v_im;           /**< Times e^{j theta}: what turns backwards stands. */
    angle_t   end, end_m; /**< Angles of the rotor and of the shaft at its end, the first sample of the next turn. */
    uint32_t  samples;
    bool      whole; /**< From one pass of angle 0, where the turn before it ended, to the next, without a missing sample. */
} ctl_turn_t;

/** Two turns: one that the interrupt sums up, and one for the main loop. */
typedef struct {
    ctl_turn_t        turn[2];
    volatile uint16_t at;    /**< Which of the two is being summed up. */
    volatile uint16_t ready; /**< The other one is complete; cleared by who has read it, and has set it to zero. */
    angle_t           theta; /**< Of the last sample that counts, */
    ctl_rotor_t       rotor; /**< its sine and cosine. */
} ctl_turn_log_t;

typedef struct {
    float    gain;             /**< Share of the residual that a turn of 250 samples or more corrects, (0, 1]. */
    float    least_current;    /**< Of the mean current vector, current unit, > 0. */
    float    offset_max;       /**< Bound of each offset, current unit, >= 0. */
    float    gain_max;         /**< Bound of each gain's distance from 1, [0, 0.5]. */
    float    r;                /**< R, voltage over current unit, > 0. */
    float    w_l;              /**< (Ld + Lq) / 2 times electrical base speed: voltage per current and speed unit, >= 0. */
    float    turns_per_sample; /**< Electrical turns per speed unit and sample that counts, > 0. */
    float    advance_turns;    /**< How far the frame of the voltage is ahead of the angle, electrical turns per speed unit. */
    uint16_t pole_pairs;
    bool     three; /**< Three sensors; else two, of a and b. */
} ctl_current_error_params_t;

/** What the last turn was good for. */
typedef enum {
    CTL_CURRENT_ERROR_NOTHING = 0, /**< No whole turn yet. */
    CTL_CURRENT_ERROR_LEARNS,
    CTL_CURRENT_ERROR_SLOW,     /**< More than CTL_TURN_LONGEST samples, or no turn at all. */
    CTL_CURRENT_ERROR_FAST,     /**< Less than CTL_TURN_SHORTEST samples. */
    CTL_CURRENT_ERROR_UNSTEADY, /**< Another speed than in the turn before. */
    CTL_CURRENT_ERROR_VOLTAGE,  /**< At the voltage limit. */
    CTL_CURRENT_ERROR_SMALL,    /**< Too little current. */
    CTL_CURRENT_ERROR_BOUND /**< Learns, and an estimate stands at its bound: the error is larger, or is none of the sensors. */
} ctl_current_error_verdict_t;

typedef struct {
    float                       offset[3]; /**< Current unit; the third of three sensors only. */
    float                       gain[3];
    float                       share[2];    /**< By which the gain is lowered, of offsets and of gains: 1/16 to 1. */
    float                       residual[4]; /**< o and n of the last turn. */
    angle_t                     end, end_m;  /**< Of the last turn. */
    uint32_t                    samples;     /**< Of the last turn; 0: none. */
    ctl_current_error_verdict_t verdict;
    uint32_t                    rejected;
} ctl_current_error_state_t;

typedef struct {
    ctl_current_error_params_t params;
    ctl_current_error_state_t  state;
} ctl_current_error_t;

enum {
    CTL_CURRENT_ERROR_GAIN = 1,
    CTL_CURRENT_ERROR_LEAST,
    CTL_CURRENT_ERROR_OFFSET_MAX,
    CTL_CURRENT_ERROR_GAIN_MAX,
    CTL_CURRENT_ERROR_R,
    CTL_CURRENT_ERROR_L,
    CTL_CURRENT_ERROR_SPEED,
    CTL_CURRENT_ERROR_POLE_PAIRS
};

/** Are these parameters good? */
ctl_diag_t ctl_current_error_check(const ctl_current_error_params_t *p);
/** Validate, begin with no offsets and gains of 1. On error @p self stays as it was. */
ctl_diag_t ctl_current_error_init(ctl_current_error_t *self, const ctl_current_error_params_t *params);
/** Begin with these estimates, cut to their bounds; NULL: none known. Each has three elements. The count stays. */
void ctl_current_error_reset(ctl_current_error_t *self, const float *offset, const float *gain);
/** The drive when a turn is learned from, about where it ended; in the frame of the rotor. */
typedef struct {
    ctl_dq_t i, v;
    ctl_dq_t i_mean; /**< Mean current over the turn, about. */
    num_t    speed;
    num_t    v_limit; /**< Longest voltage vector. */
} ctl_turn_now_t;

/** One turn of corrected currents. @return what it was good for; the estimates are in the state. Main loop. */
ctl_current_error_verdict_t ctl_current_error_learn(ctl_current_error_t *self, const ctl_turn_t *turn, const ctl_turn_now_t *now);

/** The turn that is complete, while `ready`. Then ctl_turn_clear and, after it, `ready` = 0 give it back to the interrupt. Main loop. */
static inline const ctl_turn_t *ctl_turn_complete(const ctl_turn_log_t *log) { return &log->turn[(log->at & 1U) ^ 1U]; }
void                            ctl_turn_clear(ctl_turn_log_t *log);

/** Whether the turn that is being summed up is too long to be learned from. */
static inline bool ctl_turn_is_slow(const ctl_turn_log_t *log) { return log->turn[log->at & 1U].samples >= CTL_TURN_LONGEST; }

/** A sample is missing: the turn that is being summed up will not count. */
static inline void ctl_turn_spoil(ctl_turn_log_t *log) { log->turn[log->at & 1U].whole = false; }

/*
 * Every second sample counts, and the period in which one is taken does half of the work, the next one the other half: first
 * ctl_turn_note_voltage_unchecked, with what then begins to act, and when the current of that sample has been controlled,
 * ctl_turn_note_current_unchecked. All numbers finite.
 */

/* The turn is over. */
static inline void ctl_turn_close_unchecked(ctl_turn_log_t *log, angle_t theta, angle_t theta_m)
{
    ctl_turn_t *const t = &log->turn[log->at];
    t->end = theta;
    t->end_m = theta_m;
    if (log->ready == 0U) {
        log->at ^= 1U;
        log->ready = 1U;
        log->turn[log->at].whole = true;
    } else { /* nobody has looked at the last one yet: this one will not count */
        t->whole = false;
        t->samples = 0U;
    }
}

/**
 * @param v        voltage command that begins to act, in the frame of the rotor; advance_turns is how far that frame is ahead of @p theta.
 * @param theta_m  angle of the shaft.
 */
static inline void ctl_turn_note_voltage_unchecked(ctl_turn_log_t *log, ctl_dq_t v, angle_t theta, angle_t theta_m)
{
    /* from the negative to the positive half turn, once a turn in either direction */
    if (((~theta & log->theta) >> 31) != 0U) {
        ctl_turn_close_unchecked(log, theta, theta_m);
    }
    log->theta = theta;
    angle_sincos(theta, &log->rotor.sine, &log->rotor.cosine);

    ctl_turn_t *const t = &log->turn[log->at];
    const ctl_ab_t    ab = ctl_inverse_park_unchecked(v, log->rotor);
    t->samples++;
    t->v_alpha += ab.alpha;
    t->v_beta += ab.beta;
    /* d = alpha cos + beta sin and q = beta cos - alpha sin are known: a product each for the other direction */
    t->v_re += num_sub(num_mul(ab.alpha, num_add(log->rotor.cosine, log->rotor.cosine)), v.d);
    t->v_im += num_mac(v.q, ab.alpha, num_add(log->rotor.sine, log->rotor.sine));
}

/** @param i  current of the sample, in the frame of the rotor. */
static inline void ctl_turn_note_current_unchecked(ctl_turn_log_t *log, ctl_dq_t i)
{
    ctl_turn_t *const t = &log->turn[log->at];
    const ctl_ab_t    ab = ctl_inverse_park_unchecked(i, log->rotor);
    t->i_alpha += ab.alpha;
    t->i_beta += ab.beta;
    t->i_re += num_sub(num_mul(ab.alpha, num_add(log->rotor.cosine, log->rotor.cosine)), i.d);
    t->i_im += num_mac(i.q, ab.alpha, num_add(log->rotor.sine, log->rotor.sine));
}

#endif
