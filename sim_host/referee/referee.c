#include "sim_host/referee/referee.h"

#include <math.h>
#include <string.h>

#include "sim_host/referee/bridge.h"
#include "sim_host/referee/controller.h"
#include "sim_host/referee/machine.h"
#include "sim_host/referee/other_drive.h"
#include "sim_host/referee/sensors.h"

enum { ABI_VERSION = 2, MOST_DELAY = 8 };

static const char *const PARAMETER_NAMES[] = {
#define REFEREE_PARAMETER(group, name, initial) #group "." #name,
#include "sim_host/referee/parameters.def"
#undef REFEREE_PARAMETER
};

static const double PARAMETER_DEFAULTS[] = {
#define REFEREE_PARAMETER(group, name, initial) initial,
#include "sim_host/referee/parameters.def"
#undef REFEREE_PARAMETER
};

static const char *const SIGNAL_NAMES[] = {
#define REFEREE_SIGNAL(name) #name,
#include "sim_host/referee/signals.def"
#undef REFEREE_SIGNAL
};

enum {
#define REFEREE_SIGNAL(name) SIGNAL_##name,
#include "sim_host/referee/signals.def"
#undef REFEREE_SIGNAL
    SIGNALS
};

enum { PARAMETERS = sizeof PARAMETER_DEFAULTS / sizeof PARAMETER_DEFAULTS[0] };

int referee_abi_version(void) { return ABI_VERSION; }

size_t referee_parameter_count(void) { return PARAMETERS; }

const char *referee_parameter_name(size_t index) { return (index < PARAMETERS) ? PARAMETER_NAMES[index] : NULL; }

double referee_parameter_default(size_t index) { return (index < PARAMETERS) ? PARAMETER_DEFAULTS[index] : 0.0; }

size_t referee_signal_count(void) { return SIGNALS; }

const char *referee_signal_name(size_t index) { return (index < SIGNALS) ? SIGNAL_NAMES[index] : NULL; }

/* The first parameter that makes no sense, plus one; 0: all do. Places count from motor.pole_pairs, the first. */
static int first_bad(const double *values, const referee_parameters_t *p)
{
    for (int k = 0; k < PARAMETERS; k++) {
        if (!isfinite(values[k])) {
            return k + 1;
        }
    }
    const double *const positive[] = {
        &p->motor_pole_pairs,
        &p->motor_ld_h,
        &p->motor_lq_h,
        &p->motor_inertia_kgm2,
        &p->motor_rated_current_a,
        &p->bridge_dc_link_v,
        &p->bridge_pwm_hz,
        &p->sensor_vdc_filter_s,
        &p->drive_speed_periods,
        &p->run_step_s,
        &p->stribeck_friction_speed_rad_s,
        &p->two_mass_load_ratio,
        &p->backlash_load_ratio,
        &p->resistance_drift_time_s,
        &p->friction_drift_time_s,
        &p->magnet_drift_time_s,
        &p->position_load_width_rad,
        &p->presliding_length_rad,
    };
    for (size_t k = 0; k < sizeof positive / sizeof positive[0]; k++) {
        if (!(*positive[k] > 0.0)) {
            return (int)(positive[k] - &p->motor_pole_pairs) + 1;
        }
    }
    const double *const ratios[] = {&p->two_mass_load_ratio, &p->backlash_load_ratio};
    for (size_t k = 0; k < sizeof ratios / sizeof ratios[0]; k++) {
        if (!(*ratios[k] < 1.0)) { /* the rotor has some of the inertia */
            return (int)(ratios[k] - &p->motor_pole_pairs) + 1;
        }
    }
    const double *const not_negative[] = {&p->coulomb_friction_smooth_rad_s, &p->coulomb_friction_spring_rad};
    for (size_t k = 0; k < sizeof not_negative / sizeof not_negative[0]; k++) {
        if (*not_negative[k] < 0.0) {
            return (int)(not_negative[k] - &p->motor_pole_pairs) + 1;
        }
    }
    if ((p->coulomb_friction_smooth_rad_s > 0.0) && (p->coulomb_friction_spring_rad > 0.0)) { /* one form at a time */
        return (int)(&p->coulomb_friction_spring_rad - &p->motor_pole_pairs) + 1;
    }
    if (p->drive_speed_periods < 1.0) {
        return (int)(&p->drive_speed_periods - &p->motor_pole_pairs) + 1;
    }
    if (p->other_computation_periods != 0.0 && p->other_computation_periods != 1.0) {
        return (int)(&p->other_computation_periods - &p->motor_pole_pairs) + 1;
    }
    const double delay = p->current_loop_delay_extra_periods;
    if (delay < 0.0 || delay > MOST_DELAY - 2) {
        return (int)(&p->current_loop_delay_extra_periods - &p->motor_pole_pairs) + 1;
    }
    return 0;
}

/* What the controller, either of the two, has to show. */
typedef struct {
    referee_vector_t ref_a, i_a, v_v;
    double           speed_rad_s, theta_m_rad;
} shown_t;

typedef struct {
    referee_parameters_t  p;
    referee_machine_t     machine;
    referee_controller_t  controller;
    referee_other_drive_t other;
    referee_noise_t       noise;
    referee_vector_t      queue[MOST_DELAY]; /* voltages asked for; [0] is the newest */
    double                filtered_link_v, dip_left_s;
    shown_t               shown;
    double                sum[SIGNALS]; /* since the last row */
    size_t                summed;
} session_t;

static double link_voltage(session_t *self, double t_s, double ts_s)
{
    const referee_parameters_t *const p = &self->p;
    double                            factor = 1.0;
    if (p->supply_ripple_amplitude_rel != 0.0) {
        factor += p->supply_ripple_amplitude_rel * sin(2.0 * REFEREE_PI * p->supply_ripple_frequency_hz * t_s);
    }
    if (p->supply_dips_depth_rel != 0.0) {
        self->dip_left_s -= ts_s;
        if (self->dip_left_s <= 0.0 && referee_noise_uniform(&self->noise) < (p->supply_dips_rate_hz * ts_s)) {
            self->dip_left_s = p->supply_dips_length_s;
        }
        factor -= (self->dip_left_s > 0.0) ? p->supply_dips_depth_rel : 0.0;
    }
    const referee_vector_t asked = self->queue[1];
    const referee_vector_t i = self->machine.i_a;
    const double           drawn_a = 1.5 * ((asked.x * i.x) + (asked.y * i.y)) / p->bridge_dc_link_v;
    return (factor * p->bridge_dc_link_v) - (p->supply_sag_resistance_ohm * drawn_a);
}

/* What was asked for in a period acts in the next; with extra delay later, if need be from within a period. */
static void act(session_t *self, double link_v, double load_nm, double t_s, double ts_s)
{
    const referee_parameters_t *const p = &self->p;
    const double                      extra = p->current_loop_delay_extra_periods;
    const int                         whole = (int)extra + ((p->other_in_use != 0.0) ? (int)p->other_computation_periods - 1 : 0);
    const double                      part = extra - floor(extra);
    const referee_vector_t            newer = self->queue[1 + whole];
    const referee_vector_t            older = self->queue[1 + whole + ((part > 0.0) ? 1 : 0)];
    if (part > 0.0 && p->bridge_edges == 0.0) {
        referee_bridge_average(&self->machine, older, link_v, load_nm, t_s, part * ts_s);
        referee_bridge_average(&self->machine, newer, link_v, load_nm, t_s + (part * ts_s), (1.0 - part) * ts_s);
        return;
    }
    const referee_vector_t mean = {(part * older.x) + ((1.0 - part) * newer.x), (part * older.y) + ((1.0 - part) * newer.y)};
    referee_bridge_period(&self->machine, mean, link_v, load_nm, t_s);
}

/* One control period of the drive: the voltage that it asks for. */
static referee_vector_t control(session_t *self, const referee_sample_t *sample, const referee_wish_t *wish)
{
    if (self->p.other_in_use == 0.0) {
        const referee_controller_t *const c = &self->controller;
        const referee_vector_t            v_v = referee_controller_step(&self->controller, sample, wish);
        self->shown = (shown_t){c->ref_a, c->i_a, c->v_v, c->speed_rad_s, sample->theta_m_rad};
        return v_v;
    }
    const referee_other_drive_t *const o = &self->other;
    const referee_vector_t             v_v = referee_other_drive_step(&self->other, sample, wish);
    const double                       theta_m_rad = o->theta_m_rad - (self->p.other_angle_delay_s * o->speed_rad_s);
    self->shown = (shown_t){o->ref_a, o->i_a, o->v_v, o->speed_rad_s, theta_m_rad};
    return v_v;
}

static const int MEANS[] = {SIGNAL_speed_rad_s, SIGNAL_id_a, SIGNAL_iq_a, SIGNAL_vd_v, SIGNAL_vq_v, SIGNAL_vdc_v};

enum { MEAN_SIGNALS = sizeof MEANS / sizeof MEANS[0] };

static void measure(session_t *self, const referee_sample_t *sample, double speed_ref_rad_s, double load_nm, double *row)
{
    const referee_parameters_t *const p = &self->p;
    const referee_machine_t *const    m = &self->machine;
    row[SIGNAL_speed_ref_rad_s] = speed_ref_rad_s;
    row[SIGNAL_speed_rad_s] = self->shown.speed_rad_s;
    row[SIGNAL_theta_m_rad] = sample->theta_m_rad;
    row[SIGNAL_id_ref_a] = self->shown.ref_a.x;
    row[SIGNAL_iq_ref_a] = self->shown.ref_a.y;
    row[SIGNAL_id_a] = self->shown.i_a.x;
    row[SIGNAL_iq_a] = self->shown.i_a.y;
    row[SIGNAL_ia_a] = sample->ia_a;
    row[SIGNAL_ib_a] = sample->ib_a;
    row[SIGNAL_vd_v] = self->shown.v_v.x;
    row[SIGNAL_vq_v] = self->shown.v_v.y;
    row[SIGNAL_vdc_v] = self->filtered_link_v + (p->sensor_vdc_noise_v * referee_noise_normal(&self->noise));
    row[SIGNAL_load_torque_nm] = load_nm + (p->sensor_load_noise_nm * referee_noise_normal(&self->noise));
    row[SIGNAL_valpha_v] = self->queue[0].x;
    row[SIGNAL_vbeta_v] = self->queue[0].y;
    row[SIGNAL_drive_theta_m_rad] = self->shown.theta_m_rad;
    row[SIGNAL_true_speed_rad_s] = m->speed_rad_s;
    row[SIGNAL_true_theta_m_rad] = m->theta_rad;
    row[SIGNAL_true_ia_a] = m->i_a.x;
    row[SIGNAL_true_ib_a] = -0.5 * m->i_a.x + (0.5 * REFEREE_SQRT_3 * m->i_a.y);
    row[SIGNAL_true_torque_nm] = m->torque_nm;
    row[SIGNAL_true_load_speed_rad_s] = m->load_speed_rad_s;
}

static void add_up(session_t *self)
{
    const shown_t *const now = &self->shown;
    const double values[MEAN_SIGNALS] = {now->speed_rad_s, now->i_a.x, now->i_a.y, now->v_v.x, now->v_v.y, self->filtered_link_v};
    for (int k = 0; k < MEAN_SIGNALS; k++) {
        self->sum[MEANS[k]] += values[k];
    }
    self->summed++;
}

static void write_row(session_t *self, const referee_sample_t *sample, double speed_ref_rad_s, double load_nm, double *row)
{
    measure(self, sample, speed_ref_rad_s, load_nm, row);
    if (self->p.run_mean != 0.0) {
        for (int k = 0; k < MEAN_SIGNALS; k++) {
            row[MEANS[k]] = self->sum[MEANS[k]] / (double)self->summed;
            self->sum[MEANS[k]] = 0.0;
        }
        self->summed = 0U;
    }
}

int referee_run(const double *parameters, const referee_inputs_t *inputs, size_t periods, size_t decimate, double *log)
{
    if (parameters == NULL || inputs == NULL || log == NULL || decimate == 0U) {
        return -1;
    }
    session_t self = {.filtered_link_v = 0.0};
    memcpy(&self.p, parameters, sizeof self.p);
    const int bad = first_bad((const double *)&self.p, &self.p);
    if (bad != 0) {
        return bad;
    }
    const double ts_s = 1.0 / self.p.bridge_pwm_hz;
    self.filtered_link_v = self.p.bridge_dc_link_v;
    referee_noise_seed(&self.noise, (uint64_t)fabs(self.p.run_seed));
    referee_machine_init(&self.machine, &self.p);
    const double start_rad = referee_sensors_sample(&self.machine, &self.noise).theta_m_rad;
    referee_controller_init(&self.controller, &self.p, start_rad);
    referee_other_drive_init(&self.other, &self.p, start_rad);

    for (size_t n = 0; n < periods; n++) {
        const double           t_s = self.p.run_clock_s + ((double)n * ts_s);
        const referee_sample_t sample = referee_sensors_sample(&self.machine, &self.noise);
        const referee_wish_t   wish = {inputs->speed_ref_rad_s[n], inputs->id_ref_a[n], inputs->iq_ref_a[n],
                                       inputs->current_mode[n] != 0.0};
        memmove(&self.queue[1], &self.queue[0], sizeof self.queue - sizeof self.queue[0]);
        self.queue[0] = control(&self, &sample, &wish);
        add_up(&self);
        if (n % decimate == 0U) {
            write_row(&self, &sample, wish.speed_ref_rad_s, inputs->load_torque_nm[n], &log[(n / decimate) * SIGNALS]);
        }
        referee_machine_age(&self.machine, t_s, ts_s, &self.noise);
        const double link_v = link_voltage(&self, t_s, ts_s);
        self.filtered_link_v += (link_v - self.filtered_link_v) * ts_s / self.p.sensor_vdc_filter_s;
        act(&self, link_v, inputs->load_torque_nm[n], t_s, ts_s);
    }
    return 0;
}
