#include "sim_host/referee/controller.h"

#include <math.h>

void referee_controller_init(referee_controller_t *self, const referee_parameters_t *p, double theta_m_rad)
{
    *self = (referee_controller_t){.p = p, .pll_theta_rad = theta_m_rad};
}

static void track(referee_controller_t *self, double theta_m_rad, double ts_s)
{
    const double error_rad = remainder(theta_m_rad - self->pll_theta_rad, 2.0 * REFEREE_PI);
    self->speed_rad_s += self->p->drive_pll_ki * error_rad * ts_s;
    self->pll_theta_rad += (self->speed_rad_s + (self->p->drive_pll_kp * error_rad)) * ts_s;
    self->pll_theta_rad = remainder(self->pll_theta_rad, 2.0 * REFEREE_PI);
}

static double speed_control(referee_controller_t *self, double ref_rad_s, double ts_s)
{
    const double limit_a = self->p->drive_iq_limit_a;
    const double error = ref_rad_s - self->speed_rad_s;
    const double wanted_a = (self->p->drive_speed_kp_a_per_rad_s * error) + self->speed_integral_a;
    const double given_a = fmax(-limit_a, fmin(limit_a, wanted_a));
    const bool   pushes = (given_a != wanted_a) && ((error > 0.0) == (wanted_a > 0.0));
    if (!pushes) {
        self->speed_integral_a += self->p->drive_speed_ki_a_per_rad * error * ts_s;
    }
    return given_a;
}

static void current_control(referee_controller_t *self, double ts_s)
{
    const referee_parameters_t *const p = self->p;
    const double                      limit_v = p->bridge_dc_link_v / REFEREE_SQRT_3;
    const referee_vector_t            error = {self->ref_a.x - self->i_a.x, self->ref_a.y - self->i_a.y};
    self->v_v.x = (p->drive_current_kp_v_per_a * error.x) + self->integral_v.x;
    self->v_v.y = (p->drive_current_kp_v_per_a * error.y) + self->integral_v.y;
    const double size_v = hypot(self->v_v.x, self->v_v.y);
    if (size_v > limit_v) {
        self->v_v.x *= limit_v / size_v;
        self->v_v.y *= limit_v / size_v;
        return;
    }
    self->integral_v.x += p->drive_current_ki_v_per_as * error.x * ts_s;
    self->integral_v.y += p->drive_current_ki_v_per_as * error.y * ts_s;
}

referee_vector_t referee_controller_step(referee_controller_t *self, const referee_sample_t *sample, const referee_wish_t *wish)
{
    const referee_parameters_t *const p = self->p;
    const double                      ts_s = 1.0 / p->bridge_pwm_hz;
    track(self, sample->theta_m_rad, ts_s);

    const double theta_e_rad = p->motor_pole_pairs * sample->theta_m_rad;
    const double alpha_a = sample->ia_a;
    const double beta_a = (sample->ia_a + (2.0 * sample->ib_a)) / REFEREE_SQRT_3;
    const double c = cos(theta_e_rad);
    const double s = sin(theta_e_rad);
    self->i_a = (referee_vector_t){(alpha_a * c) + (beta_a * s), (beta_a * c) - (alpha_a * s)};

    self->ref_a.x = wish->id_ref_a;
    if (wish->current_mode) {
        if (!self->was_current_mode) {
            self->speed_integral_a = 0.0;
        }
        self->ref_a.y = wish->iq_ref_a;
    } else if (self->period == 0U) {
        self->ref_a.y = speed_control(self, wish->speed_ref_rad_s, ts_s * p->drive_speed_periods);
    }
    self->was_current_mode = wish->current_mode;
    self->period = (self->period + 1U) % (unsigned)p->drive_speed_periods;
    current_control(self, ts_s);

    const double ahead_rad = theta_e_rad + (p->drive_angle_advance_periods * ts_s * p->motor_pole_pairs * self->speed_rad_s);
    const double ca = cos(ahead_rad);
    const double sa = sin(ahead_rad);
    return (referee_vector_t){(self->v_v.x * ca) - (self->v_v.y * sa), (self->v_v.x * sa) + (self->v_v.y * ca)};
}
