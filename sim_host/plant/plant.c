#include "sim_host/plant/plant.h"

#include <math.h>
#include <stddef.h>

#include "sim_host/plant/encoder.h"
#include "sim_host/plant/frame.h"
#include "sim_host/plant/machine.h"
#include "sim_host/plant/step.h"

#define BRIDGE_STEPS 2 /* per period while an effect makes the voltage follow the currents, which cross zero between steps */

static bool has_shaft(const sim_parts_t *x) { return (x->resonance_hz > 0.0) || x->has_backlash; }

static bool is_other_shaft(const sim_parts_t *a, const sim_parts_t *b)
{
    return (a->resonance_hz != b->resonance_hz) || (a->load_ratio != b->load_ratio) || (a->damping_ratio != b->damping_ratio) ||
           (a->load_friction_share != b->load_friction_share) || (a->has_backlash != b->has_backlash) ||
           (a->backlash_rad != b->backlash_rad);
}

/* @return the name of an effect for which there is no place beside another one, or NULL. */
static const char *collect_effects(sim_plant_t *s, const double (*values)[SIM_EFFECT_PARAMS])
{
    for (int e = 0; (e < sim_effect_total) && (s->acting_count < SIM_EFFECTS_MAX); e++) {
        const sim_effect_t *const effect = sim_effects[e];
        bool                      on = false;
        for (int k = 0; k < effect->param_count; k++) {
            on = on || (values[e][k] != effect->param[k].off);
        }
        if (!on) {
            continue;
        }
        sim_acting_t *const a = &s->acting[s->acting_count++];
        a->effect = effect;
        for (int k = 0; k < SIM_EFFECT_PARAMS; k++) {
            a->p[k] = values[e][k];
        }
        if (effect->model != NULL) {
            effect->model(a->p, &s->model);
        }
        if (effect->parts != NULL) {
            const sim_parts_t before = s->parts;
            effect->parts(a->p, &s->parts);
            if (has_shaft(&before) && is_other_shaft(&before, &s->parts)) {
                return effect->name;
            }
        }
        if (effect->linkage_wb != NULL) {
            s->saturation = a;
        }
        if (effect->bristle_nm != NULL) {
            s->bristle = a;
        }
        if (effect->torque_nm != NULL) {
            s->torque[s->torque_count++] = a;
        }
        if (effect->friction_nm != NULL) {
            s->friction[s->friction_count++] = a;
        }
        if (effect->flux != NULL) {
            s->flux[s->flux_count++] = a;
        }
        if (effect->phase_voltage != NULL) {
            s->voltage[s->voltage_count++] = a;
        }
        if (effect->current_sensor != NULL) {
            s->current[s->current_count++] = a;
        }
        if (effect->angle_sensor != NULL) {
            s->angle[s->angle_count++] = a;
        }
    }
    return NULL;
}

/* With a load behind a coupling `model.viscous_nms` is what is left for the rotor. */
static void share_friction(sim_plant_t *s)
{
    if (s->coupling.on) {
        s->coupling.load_viscous_nms = s->parts.load_friction_share * s->model.viscous_nms;
        s->model.viscous_nms -= s->coupling.load_viscous_nms;
    }
}

/* One step has a relative error of (h / tau)^5 / 120 in a transient, and angle^6 / 720 in the turned voltage: 0.4 and
 * 0.3 rad keep both near 1e-6 at the speed where the back-EMF fills the dc link, and far below it at ordinary ones.
 * A swinging shaft loses angle^6 / 144 of its amplitude a step: 0.3 rad add 2e-5 to its damping ratio. */
static int needed_substeps(const sim_plant_t *s)
{
    const sim_model_t *const m = &s->model;
    const double             l_min = (m->ld_h < m->lq_h) ? m->ld_h : m->lq_h;
    const double             decay = m->resistance_ohm / l_min * s->period_s / 0.4;
    const double             flux = (m->psi_wb > 1e-9) ? m->psi_wb : 1e-9;
    const double             turn = m->dc_link_v / SIM_SQRT3 / flux * s->period_s / 0.3;
    const double             swing = s->coupling.on ? s->coupling.resonance_rad_s * s->period_s / 0.3 : 0.0;
    const double             bridge = (s->voltage_count > 0) ? BRIDGE_STEPS : 1.0;
    double                   need = (decay > turn) ? decay : turn;
    need = (swing > need) ? swing : need;
    need = ceil((bridge > need) ? bridge : need);
    return (need < 1.0) ? 1 : ((need > 100.0) ? 100 : (int)need);
}

const char *sim_plant_start(sim_plant_t *s, const sim_model_t *m, const double (*values)[SIM_EFFECT_PARAMS], double edges_per_rev,
                            uint64_t seed)
{
    static const sim_plant_t nothing;
    *s = nothing;
    s->model = *m;
    for (int i = 0; i < sim_model_count(); i++) {
        if (!sim_field_accepts(sim_model_info(i), *sim_model_at(&s->model, i))) {
            return sim_model_info(i)->name;
        }
    }
    const char *const crowded = collect_effects(s, values);
    if (crowded != NULL) {
        return crowded;
    }
    s->period_s = 1.0 / s->model.pwm_hz;
    if (s->model.rotor_locked == 0.0) { /* what hangs on a locked rotor does not show */
        sim_coupling_start(&s->coupling, s->model.inertia_kgm2, s->parts.load_ratio, s->parts.resonance_hz,
                           s->parts.damping_ratio, s->parts.has_backlash, s->parts.backlash_rad);
        share_friction(s);
    }
    sim_delay_start(&s->delay, s->parts.delay_periods);
    s->substeps = (s->model.substeps > 0.0) ? (int)s->model.substeps : needed_substeps(s);
    s->inv_ld = 1.0 / s->model.ld_h;
    s->inv_lq = 1.0 / s->model.lq_h;
    s->inv_inertia = s->coupling.on ? s->coupling.inv_rotor : 1.0 / s->model.inertia_kgm2;
    s->torque_per_amp = 1.5 * s->model.pole_pairs;
    const bool hooks = (s->flux_count > 0) || (s->torque_count > 0) || (s->friction_count > 0);
    if (s->coupling.on) {
        s->kind = SIM_COUPLED;
    } else if (s->saturation != NULL) {
        s->kind = SIM_SATURATING;
    } else {
        s->kind = hooks ? SIM_WITH_HOOKS : SIM_PLAIN;
    }
    s->x.theta_m_rad = s->model.initial_angle_rad;
    sim_frame_turn(s);
    s->x.speed_rad_s = (s->model.rotor_locked != 0.0) ? 0.0 : s->model.initial_speed_rad_s;
    s->load.speed_rad_s = s->x.speed_rad_s;
    s->outside.dc_link_v = s->model.dc_link_v;
    s->vdc_filtered_v = s->model.dc_link_v;
    sim_dc_link_start(&s->link, s->model.dc_link_v, s->model.dc_link_f, s->model.supply_ohm);
    s->link_v = s->model.dc_link_v;
    s->vdc_gain = 1.0 - exp(-2.0 * SIM_PI * s->model.vdc_filter_hz * s->period_s);
    sim_encoder_start(s, edges_per_rev);
    sim_random_seed(&s->noise, seed);
    return NULL;
}

void sim_plant_phase_currents(const sim_plant_t *s, double i_abc[3])
{
    const double c = s->cosine_e;
    const double n = s->sine_e;
    sim_to_phases(s->x.id_a * c - s->x.iq_a * n, s->x.id_a * n + s->x.iq_a * c, i_abc);
}

double sim_plant_dc_link_v(const sim_plant_t *s) { return s->link.on ? s->link.volt_v : s->outside.dc_link_v; }

static double brake_s(const sim_plant_t *s)
{
    return (s->model.brake_ohm > 0.0) ? (s->outside.brake_duty / s->model.brake_ohm) : 0.0;
}

double sim_plant_brake_w(const sim_plant_t *s) { return brake_s(s) * sim_plant_dc_link_v(s) * sim_plant_dc_link_v(s); }

void sim_plant_end_link_period(sim_plant_t *s) { sim_dc_link_period(&s->link, s->outside.dc_link_v, brake_s(s), s->period_s); }

double sim_plant_torque(const sim_plant_t *s) { return sim_motor_torque(s, &s->at_read); }

double sim_plant_load_speed(const sim_plant_t *s) { return s->coupling.on ? s->load.speed_rad_s : s->x.speed_rad_s; }
