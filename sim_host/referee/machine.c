#include "sim_host/referee/machine.h"

#include <math.h>
#include <stddef.h>

#include "sim_host/referee/foreign.h"

void referee_machine_init(referee_machine_t *self, const referee_parameters_t *p)
{
    *self = (referee_machine_t){.p = p};
    const bool   backlash = p->backlash_f_res_hz > 0.0;
    const bool   shaft = !backlash && (p->two_mass_f_res_hz > 0.0);
    const double f_res_hz = backlash ? p->backlash_f_res_hz : p->two_mass_f_res_hz;
    const double ratio = backlash ? p->backlash_load_ratio : p->two_mass_load_ratio;
    const double damping = backlash ? p->backlash_damping_ratio : p->two_mass_damping_ratio;

    self->motor_inertia_kgm2 = p->motor_inertia_kgm2;
    if (backlash || shaft) { /* free-free resonance: w^2 = k (1/J_m + 1/J_l), damping_ratio of that mode */
        const double w_rad_s = 2.0 * REFEREE_PI * f_res_hz;
        self->load_inertia_kgm2 = p->motor_inertia_kgm2 * ratio;
        self->motor_inertia_kgm2 = p->motor_inertia_kgm2 - self->load_inertia_kgm2;
        const double reduced_kgm2 = self->motor_inertia_kgm2 * self->load_inertia_kgm2 / p->motor_inertia_kgm2;
        self->stiffness_nm_rad = w_rad_s * w_rad_s * reduced_kgm2;
        self->damping_nms = 2.0 * damping * w_rad_s * reduced_kgm2;
        self->half_gap_rad = backlash ? (0.5 * p->backlash_gap_rad) : 0.0;
    }
    self->l_mean_h = 0.5 * (p->motor_ld_h + p->motor_lq_h);
    self->l_swing_h = 0.5 * (p->motor_ld_h - p->motor_lq_h);
    self->angle_torque = (p->cogging_amplitude_nm != 0.0) || (p->misalignment_amplitude_nm != 0.0) ||
                         (p->foreign_order_torque_amplitude_nm != 0.0);
    self->time_torque = p->fixed_frequency_torque_amplitude_nm != 0.0;
    self->resistance_ohm = p->motor_resistance_ohm;
    self->psi_wb = p->motor_psi_wb;
    const bool holds = (p->coulomb_friction_smooth_rad_s == 0.0) && (p->coulomb_friction_spring_rad == 0.0);
    self->holding_nm = holds ? p->coulomb_friction_torque_nm : 0.0;
    self->dry_friction_nm = self->holding_nm;
    self->theta_rad = p->motor_start_angle_rad;
    self->load_theta_rad = self->theta_rad;
}

void referee_machine_age(referee_machine_t *self, double t_s, double period_s, referee_noise_t *noise)
{
    const referee_parameters_t *const p = self->p;
    const double                      warm = 1.0 - exp(-t_s / p->resistance_drift_time_s);
    self->resistance_ohm = p->motor_resistance_ohm * (1.0 + (p->resistance_drift_rise_rel * warm));
    self->psi_wb = p->motor_psi_wb * (1.0 - (p->magnet_drift_fall_rel * (1.0 - exp(-t_s / p->magnet_drift_time_s))));
    self->dry_friction_nm = self->holding_nm + (p->friction_drift_torque_nm * exp(-t_s / p->friction_drift_time_s));
    if (p->torque_bursts_amplitude_nm != 0.0) {
        self->burst_left_s -= period_s;
        if (self->burst_left_s <= 0.0) {
            self->burst_nm = 0.0;
            if (referee_noise_uniform(noise) < (p->torque_bursts_rate_hz * period_s)) {
                const double height = p->torque_bursts_amplitude_nm * (0.5 + referee_noise_uniform(noise));
                self->burst_nm = (referee_noise_uniform(noise) < 0.5) ? -height : height;
                self->burst_left_s = p->torque_bursts_length_s * (0.5 + referee_noise_uniform(noise));
            }
        }
    }
}

/* Torque that brakes positive rotation and depends on the angle or the time. */
static double braking_torque(const referee_machine_t *self, double theta_rad, double t_s)
{
    const referee_parameters_t *const p = self->p;
    double                            brake_nm = 0.0;
    if (self->angle_torque) {
        brake_nm += p->cogging_amplitude_nm * sin((p->cogging_order * theta_rad) + p->cogging_phase_rad);
        brake_nm +=
            p->misalignment_amplitude_nm * (sin(theta_rad + p->misalignment_phase_rad) +
                                            (p->misalignment_second_rel * sin((2.0 * theta_rad) + p->misalignment_phase2_rad)));
        brake_nm += p->foreign_order_torque_amplitude_nm *
                    (sin((p->foreign_order_torque_order * theta_rad) + p->foreign_order_torque_phase_rad) +
                     (p->foreign_order_torque_second_rel * sin(2.0 * p->foreign_order_torque_order * theta_rad)));
    }
    if (self->time_torque) {
        brake_nm += p->fixed_frequency_torque_amplitude_nm *
                    sin((2.0 * REFEREE_PI * p->fixed_frequency_torque_frequency_hz * t_s) + p->fixed_frequency_torque_phase_rad);
    }
    return brake_nm + self->burst_nm;
}

/* Dry friction over one step: it can stop the rotor, and hold it, but never turn it. */
static double with_dry_friction(const referee_machine_t *self, double speed_rad_s, double h_s)
{
    const referee_parameters_t *const p = self->p;
    double                            friction_nm = self->dry_friction_nm;
    if (p->stribeck_friction_torque_nm != 0.0) {
        const double ratio = speed_rad_s / p->stribeck_friction_speed_rad_s;
        friction_nm += p->stribeck_friction_torque_nm * exp(-ratio * ratio);
    }
    const double loss_rad_s = friction_nm * h_s / self->motor_inertia_kgm2;
    if (speed_rad_s > loss_rad_s) {
        return speed_rad_s - loss_rad_s;
    }
    return (speed_rad_s < -loss_rad_s) ? (speed_rad_s + loss_rad_s) : 0.0;
}

/* A spring that slides when it is stretched to the friction (Prandtl), after the shaft has moved. */
static double stretched(const referee_parameters_t *p, double spring_nm, double moved_rad)
{
    const double most_nm = p->coulomb_friction_torque_nm;
    const double now_nm = spring_nm + (most_nm * moved_rad / p->coulomb_friction_spring_rad);
    return (now_nm > most_nm) ? most_nm : ((now_nm < -most_nm) ? -most_nm : now_nm);
}

static double shaft_torque(const referee_machine_t *self, double twist_rad, double twist_rad_s)
{
    const double gap_rad = self->half_gap_rad;
    if (gap_rad == 0.0) {
        return (self->stiffness_nm_rad * twist_rad) + (self->damping_nms * twist_rad_s);
    }
    if (fabs(twist_rad) <= gap_rad) {
        return 0.0;
    }
    const double pressed_rad = twist_rad - copysign(gap_rad, twist_rad);
    const double torque_nm = (self->stiffness_nm_rad * pressed_rad) + (self->damping_nms * twist_rad_s);
    return ((torque_nm > 0.0) == (twist_rad > 0.0)) ? torque_nm : 0.0; /* flanks push, they do not pull */
}

static void move(referee_machine_t *self, double h_s, double load_torque_nm, double t_s)
{
    const referee_parameters_t *const p = self->p;
    const double                      speed = self->speed_rad_s;
    double                            torque_nm = self->torque_nm - braking_torque(self, self->theta_rad, t_s);
    torque_nm -= p->fan_load_torque_nm_s2 * speed * fabs(speed);
    torque_nm -= referee_foreign_torque(p, self->theta_rad, speed) + self->bristle_nm;
    if (p->presliding_torque_nm != 0.0) {
        self->bristle_nm = referee_foreign_bristle(p, self->bristle_nm, speed * h_s);
    }
    const double load_nm = load_torque_nm + p->load_torque_torque_nm;
    double       viscous_nms = p->motor_viscous_nms;
    double       border_nms = 0.0; /* of Coulomb friction that rises with the speed */
    if (p->coulomb_friction_spring_rad > 0.0) {
        torque_nm -= self->spring_nm;
        self->spring_nm = stretched(p, self->spring_nm, speed * h_s);
    } else if (p->coulomb_friction_smooth_rad_s > 0.0) {
        border_nms = p->coulomb_friction_torque_nm / hypot(speed, p->coulomb_friction_smooth_rad_s);
    }

    if (self->load_inertia_kgm2 > 0.0) {
        const double shaft_nm = shaft_torque(self, self->theta_rad - self->load_theta_rad, speed - self->load_speed_rad_s);
        torque_nm -= shaft_nm;
        const double friction_nm = p->motor_viscous_nms * p->motor_load_friction_share * self->load_speed_rad_s;
        self->load_speed_rad_s += (shaft_nm - load_nm - friction_nm) * h_s / self->load_inertia_kgm2;
        viscous_nms *= 1.0 - p->motor_load_friction_share;
    } else {
        torque_nm -= load_nm;
    }
    const double decay = 0.5 * h_s * (viscous_nms + border_nms) / self->motor_inertia_kgm2; /* trapezoidal */
    const double free = ((speed * (1.0 - decay)) + (torque_nm * h_s / self->motor_inertia_kgm2)) / (1.0 + decay);
    self->speed_rad_s = with_dry_friction(self, free, h_s);
}

/* Differential inductances at a current; cosine and sine of the rotor's electrical angle. */
static void saturate(const referee_machine_t *self, referee_vector_t i_a, double c, double s, double *l_mean_h, double *l_swing_h)
{
    const double per_a = 1.0 / self->p->inductance_saturation_i_sat_a;
    const double d = ((i_a.x * c) + (i_a.y * s)) * per_a;
    const double q = ((i_a.y * c) - (i_a.x * s)) * per_a;
    if (self->p->inductance_saturation_per_axis == 0.0) {
        const double soft = 1.0 / (1.0 + (d * d) + (q * q));
        *l_mean_h *= soft;
        *l_swing_h *= soft;
        return;
    }
    const double ld_h = self->p->motor_ld_h / (1.0 + (d * d));
    const double lq_h = self->p->motor_lq_h / (1.0 + (q * q));
    *l_mean_h = 0.5 * (ld_h + lq_h);
    *l_swing_h = 0.5 * (ld_h - lq_h);
}

void referee_machine_step(referee_machine_t *self, double h_s, referee_vector_t v_v, double load_torque_nm, double t_s)
{
    const referee_parameters_t *const p = self->p;
    const bool                        locked = p->motor_locked != 0.0;
    if (!locked) {
        self->theta_rad += 0.5 * h_s * self->speed_rad_s;
        self->load_theta_rad += 0.5 * h_s * self->load_speed_rad_s;
    }
    const double theta_e_rad = p->motor_pole_pairs * self->theta_rad;
    const double speed_e_rad_s = p->motor_pole_pairs * self->speed_rad_s;
    const double c = cos(theta_e_rad);
    const double s = sin(theta_e_rad);

    /* The magnets' voltage per electrical rad/s, in the rotor frame first. Fifth and seventh harmonics of the phase
     * voltage turn at -5 and +7 times: both are the sixth in the rotor frame. */
    double flux_d = 0.0;
    double flux_q = self->psi_wb;
    if (p->flux_harmonics_torque_ripple_rel != 0.0) {
        const double ripple_wb = p->motor_psi_wb * p->flux_harmonics_torque_ripple_rel * p->flux_harmonics_sign;
        const double seventh_wb = ripple_wb * (1.0 - p->flux_harmonics_fifth_share);
        const double fifth_wb = -ripple_wb * p->flux_harmonics_fifth_share;
        flux_q += (seventh_wb - fifth_wb) * cos(6.0 * theta_e_rad);
        flux_d -= (seventh_wb + fifth_wb) * sin(6.0 * theta_e_rad);
    }
    const referee_vector_t flux = {(flux_d * c) - (flux_q * s), (flux_d * s) + (flux_q * c)};

    const double           r = 0.5 * self->resistance_ohm;
    const double           r_a = r * (1.0 + ((2.0 / 3.0) * p->phase_unbalance_rise_rel)); /* phase a lies on alpha */
    const referee_vector_t i = self->i_a;
    const bool             saturates = p->inductance_saturation_i_sat_a > 0.0;
    const bool             crosses = p->cross_saturation_wb_per_a2 != 0.0;
    referee_cross_t        cross = {0};
    double                 l_swing_h = self->l_swing_h;
    for (int pass = 0; pass < ((saturates || crosses) ? 2 : 1);
         pass++) { /* the second with the inductances in the middle of the step */
        /* Inductance matrix [a b; b d], how it turns [g k; k -g], and its fall with the current. */
        double l_mean_h = self->l_mean_h;
        l_swing_h = self->l_swing_h;
        const referee_vector_t middle = {0.5 * (i.x + self->i_a.x), 0.5 * (i.y + self->i_a.y)};
        if (crosses) {
            cross = referee_foreign_cross(p, middle, c, s, speed_e_rad_s);
        }
        if (saturates) {
            saturate(self, middle, c, s, &l_mean_h, &l_swing_h);
        }
        const double c2 = (c * c) - (s * s);
        const double s2 = 2.0 * s * c;
        const double turn = 2.0 * speed_e_rad_s * l_swing_h;
        const double g = -turn * s2;
        const double k = turn * c2;
        const double per_s = 1.0 / h_s;
        const double a = (l_mean_h + (l_swing_h * c2) + cross.a_h) * per_s;
        const double b = ((l_swing_h * s2) + cross.b_h) * per_s;
        const double d = (l_mean_h - (l_swing_h * c2) + cross.d_h) * per_s;
        const double right_x =
            ((a - r_a - (0.5 * g)) * i.x) + ((b - (0.5 * k)) * i.y) + v_v.x - (speed_e_rad_s * flux.x) - cross.turning_v.x;
        const double right_y =
            ((b - (0.5 * k)) * i.x) + ((d - r + (0.5 * g)) * i.y) + v_v.y - (speed_e_rad_s * flux.y) - cross.turning_v.y;
        const double m11 = a + r_a + (0.5 * g);
        const double m12 = b + (0.5 * k);
        const double m22 = d + r - (0.5 * g);
        const double scale = 1.0 / ((m11 * m22) - (m12 * m12));
        self->i_a.x = ((m22 * right_x) - (m12 * right_y)) * scale;
        self->i_a.y = ((m11 * right_y) - (m12 * right_x)) * scale;
    }

    const double ix = 0.5 * (i.x + self->i_a.x);
    const double iy = 0.5 * (i.y + self->i_a.y);
    const double id = (ix * c) + (iy * s);
    const double iq = (iy * c) - (ix * s);
    self->torque_nm =
        1.5 * p->motor_pole_pairs * ((flux_q * iq) + (flux_d * id) + (2.0 * l_swing_h * id * iq) + cross.torque_wb_a);

    if (p->current_filter_tau_s > 0.0) {
        const double share = h_s / (p->current_filter_tau_s + (0.5 * h_s));
        self->i_filtered_a.x += (ix - self->i_filtered_a.x) * share;
        self->i_filtered_a.y += (iy - self->i_filtered_a.y) * share;
    } else {
        self->i_filtered_a = self->i_a;
    }
    if (locked) {
        return;
    }
    move(self, h_s, load_torque_nm, t_s);
    if (self->load_inertia_kgm2 == 0.0) {
        self->load_speed_rad_s = self->speed_rad_s;
    }
    self->theta_rad += 0.5 * h_s * self->speed_rad_s;
    self->load_theta_rad += 0.5 * h_s * self->load_speed_rad_s;
}
