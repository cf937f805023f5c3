#include "sim_host/referee/other_drive.h"

#include <math.h>

void referee_other_drive_init(referee_other_drive_t *self, const referee_parameters_t *p, double theta_m_rad)
{
    *self = (referee_other_drive_t){.p = p, .theta_m_rad = theta_m_rad, .pll_rad = theta_m_rad, .tick_rad = theta_m_rad};
}

static double limited(double x, double limit) { return fmax(-limit, fmin(limit, x)); }

/* Angle and speed: what the encoder says, or what a loop that tracks it says. */
static void locate(referee_other_drive_t *self, double measured_rad, double ts_s, bool speed_tick)
{
    const referee_parameters_t *const p = self->p;
    const double                      before_rad = self->theta_m_rad;
    const double                      measured = before_rad + remainder(measured_rad - before_rad, 2.0 * REFEREE_PI);
    const double                      tracked_rad = self->pll_rad; /* what the last period foresaw for this sample */
    const double                      error_rad = measured - tracked_rad;
    self->pll_rad_s += p->drive_pll_ki * error_rad * ts_s;
    self->pll_rad += (self->pll_rad_s + (p->drive_pll_kp * error_rad)) * ts_s;
    if (speed_tick) {
        const double tick_s = ts_s * p->drive_speed_periods;
        const double raw_rad_s = (measured - self->tick_rad) / tick_s;
        self->filtered_rad_s += (raw_rad_s - self->filtered_rad_s) * tick_s / (p->other_speed_filter_s + tick_s);
        self->tick_rad = measured;
    }
    self->speed_rad_s = (p->other_speed_by_difference != 0.0) ? self->filtered_rad_s : self->pll_rad_s;
    self->theta_m_rad = (p->other_angle_from_pll != 0.0) ? tracked_rad : measured;
}

static void speed_control(referee_other_drive_t *self, double ref_rad_s, double ts_s)
{
    const referee_parameters_t *const p = self->p;
    const double                      error = ref_rad_s - self->speed_rad_s;
    const double                      proportional = (p->other_speed_loop_ip != 0.0) ? -self->speed_rad_s : error;
    const double                      wanted_a = (p->drive_speed_kp_a_per_rad_s * proportional) + self->speed_integral_a;
    self->torque_a = limited(wanted_a, p->drive_iq_limit_a);
    self->speed_integral_a += p->drive_speed_ki_a_per_rad * error * ts_s;
    self->speed_integral_a += self->torque_a - wanted_a; /* back-calculation in one step */
}

/* The current vector of a given length with most torque, for the motor that the drive believes in. */
static referee_vector_t share_out(const referee_parameters_t *p, double torque_a)
{
    const double     swing_h = p->other_lq_h - p->other_ld_h;
    referee_vector_t ref = {0.0, torque_a};
    if (p->other_most_torque_per_ampere != 0.0 && swing_h > 0.0) {
        const double x = 0.25 * p->other_psi_wb / swing_h;
        ref.x = x - sqrt((x * x) + (0.5 * torque_a * torque_a));
        ref.y = copysign(sqrt(fmax((torque_a * torque_a) - (ref.x * ref.x), 0.0)), torque_a);
    }
    return ref;
}

static void current_control(referee_other_drive_t *self, double ts_s)
{
    const referee_parameters_t *const p = self->p;
    const double                      limit_v = p->bridge_dc_link_v / REFEREE_SQRT_3;
    const double                      speed_e_rad_s = p->motor_pole_pairs * self->speed_rad_s;
    const double                      ahead = p->other_feed_forward * speed_e_rad_s;
    const referee_vector_t            error = {self->ref_a.x - self->i_a.x, self->ref_a.y - self->i_a.y};
    const referee_vector_t            wanted = {
        (p->drive_current_kp_v_per_a * error.x) + self->integral_v.x - (ahead * p->other_lq_h * self->ref_a.y),
        (p->drive_current_kp_v_per_a * error.y) + self->integral_v.y +
            (ahead * ((p->other_ld_h * self->ref_a.x) + p->other_psi_wb)),
    };
    const double size_v = hypot(wanted.x, wanted.y);
    const double scale = (size_v > limit_v) ? (limit_v / size_v) : 1.0;
    self->v_v = (referee_vector_t){wanted.x * scale, wanted.y * scale};
    if (scale == 1.0) {
        self->integral_v.x += p->drive_current_ki_v_per_as * error.x * ts_s;
        self->integral_v.y += p->drive_current_ki_v_per_as * error.y * ts_s;
    }
}

referee_vector_t referee_other_drive_step(referee_other_drive_t *self, const referee_sample_t *sample, const referee_wish_t *wish)
{
    const referee_parameters_t *const p = self->p;
    const double                      ts_s = 1.0 / p->bridge_pwm_hz;
    const bool                        speed_tick = self->period == 0U;
    locate(self, sample->theta_m_rad, ts_s, speed_tick);

    const double late_rad = p->other_angle_delay_s * p->motor_pole_pairs * self->speed_rad_s;
    const double theta_e_rad = (p->motor_pole_pairs * self->theta_m_rad) - late_rad;
    const double alpha_a = sample->ia_a;
    const double beta_a = (sample->ia_a + (2.0 * sample->ib_a)) / REFEREE_SQRT_3;
    const double c = cos(theta_e_rad);
    const double s = sin(theta_e_rad);
    self->i_a = (referee_vector_t){(alpha_a * c) + (beta_a * s), (beta_a * c) - (alpha_a * s)};

    if (wish->current_mode) {
        self->ref_a = (referee_vector_t){wish->id_ref_a, wish->iq_ref_a};
        self->speed_integral_a = wish->iq_ref_a;
    } else if (speed_tick) {
        speed_control(self, wish->speed_ref_rad_s, ts_s * p->drive_speed_periods);
        self->ref_a = share_out(p, self->torque_a);
    }
    self->period = (self->period + 1U) % (unsigned)p->drive_speed_periods;
    current_control(self, ts_s);

    const double ahead_rad = theta_e_rad + (p->drive_angle_advance_periods * ts_s * p->motor_pole_pairs * self->speed_rad_s);
    const double ca = cos(ahead_rad);
    const double sa = sin(ahead_rad);
    return (referee_vector_t){(self->v_v.x * ca) - (self->v_v.y * sa), (self->v_v.x * sa) + (self->v_v.y * ca)};
}
