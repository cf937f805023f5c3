#include "sim_host/referee/referee.h"

#include <math.h>
#include <string.h>

#include "sim_host/referee/bridge.h"
#include "sim_host/referee/controller.h"
#include "sim_host/referee/machine.h"
#include "sim_host/referee/sensors.h"

enum { ABI_VERSION = 1, MOST_DELAY = 8 };

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
    if (p->drive_speed_periods < 1.0) {
        return (int)(&p->drive_speed_periods - &p->motor_pole_pairs) + 1;
    }
    const double delay = p->current_loop_delay_extra_periods;
    if (delay < 0.0 || delay > MOST_DELAY - 2) {
        return (int)(&p->current_loop_delay_extra_periods - &p->motor_pole_pairs) + 1;
    }
    return 0;
}

typedef struct {
    referee_parameters_t p;
    referee_machine_t    machine;
    referee_controller_t controller;
    referee_noise_t      noise;
    referee_vector_t     queue[MOST_DELAY]; /* voltages asked for; [0] is the newest */
    double               filtered_link_v, dip_left_s;
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
    return factor * p->bridge_dc_link_v;
}

/* What was asked for in a period acts in the next; with extra delay later, if need be from within a period. */
static void act(session_t *self, double link_v, double load_nm, double t_s, double ts_s)
{
    const referee_parameters_t *const p = &self->p;
    const double                      extra = p->current_loop_delay_extra_periods;
    const int                         whole = (int)extra;
    const double                      part = extra - whole;
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

static void write_row(session_t *self, const referee_sample_t *sample, double speed_ref_rad_s, double load_nm, double *row)
{
    const referee_parameters_t *const p = &self->p;
    const referee_machine_t *const    m = &self->machine;
    row[SIGNAL_speed_ref_rad_s] = speed_ref_rad_s;
    row[SIGNAL_speed_rad_s] = self->controller.speed_rad_s;
    row[SIGNAL_theta_m_rad] = sample->theta_m_rad;
    row[SIGNAL_id_ref_a] = self->controller.ref_a.x;
    row[SIGNAL_iq_ref_a] = self->controller.ref_a.y;
    row[SIGNAL_id_a] = self->controller.i_a.x;
    row[SIGNAL_iq_a] = self->controller.i_a.y;
    row[SIGNAL_ia_a] = sample->ia_a;
    row[SIGNAL_ib_a] = sample->ib_a;
    row[SIGNAL_vd_v] = self->controller.v_v.x;
    row[SIGNAL_vq_v] = self->controller.v_v.y;
    row[SIGNAL_vdc_v] = self->filtered_link_v + (p->sensor_vdc_noise_v * referee_noise_normal(&self->noise));
    row[SIGNAL_load_torque_nm] = load_nm + (p->sensor_load_noise_nm * referee_noise_normal(&self->noise));
    row[SIGNAL_true_speed_rad_s] = m->speed_rad_s;
    row[SIGNAL_true_theta_m_rad] = m->theta_rad;
    row[SIGNAL_true_ia_a] = m->i_a.x;
    row[SIGNAL_true_ib_a] = -0.5 * m->i_a.x + (0.5 * REFEREE_SQRT_3 * m->i_a.y);
    row[SIGNAL_true_torque_nm] = m->torque_nm;
    row[SIGNAL_true_load_speed_rad_s] = m->load_speed_rad_s;
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
    referee_controller_init(&self.controller, &self.p, referee_sensors_sample(&self.machine, &self.noise).theta_m_rad);

    for (size_t n = 0; n < periods; n++) {
        const double           t_s = self.p.run_clock_s + ((double)n * ts_s);
        const referee_sample_t sample = referee_sensors_sample(&self.machine, &self.noise);
        const referee_wish_t   wish = {inputs->speed_ref_rad_s[n], inputs->id_ref_a[n], inputs->iq_ref_a[n],
                                       inputs->current_mode[n] != 0.0};
        memmove(&self.queue[1], &self.queue[0], sizeof self.queue - sizeof self.queue[0]);
        self.queue[0] = referee_controller_step(&self.controller, &sample, &wish);
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
