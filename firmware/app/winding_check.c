/* Voltages, currents and angle against the equation of the windings: the share of the setup. Its step is in watch_isr.c. Main
 * loop. control/motor/plausibility.h has the equations. */
#include "firmware/app/internal.h"

#define VOLT_SHARE 0.05f  /* of the voltage: divider of the dc link, and its filter behind a link that changes */
#define LATE_PERIODS 0.3f /* by which the voltage may act late: filter of the currents, drivers */
#define LEGS 1.82f        /* |alpha| + |beta| of what three legs lose, over the loss of one: 4/3 (sin 30 + cos 30 degrees) */
#define DIAGONAL 1.3f     /* |alpha| + |beta| of a vector, over the same of one across to it: at most sqrt(2) */
#define COUNTS 1.8f       /* of the encoder by which an angle may be off the ones before, along the diagonal */
#define NEW_SHARE 0.25f   /* of the error in each period; the rest is kept */
#define ROOM 32.0f        /* base currents that the largest flux makes of the reference inductance */

/* Least slope of the flux over the current, over that of small currents: at the largest current that is asked for. */
static float least_slope(const drive_params_t *p)
{
    const float i_a = (p->id_limit_a > p->iq_limit_a) ? p->id_limit_a : p->iq_limit_a;
    const float x = (p->saturation_a > 0.0f) ? (i_a / p->saturation_a) : 0.0f;
    return 1.0f / (1.0f + ((1.0f + p->saturation_cross) * x * x));
}

static float larger(float a, float b) { return (a > b) ? a : b; }

void drive_make_plausibility(const drive_params_t *p, drive_setup_t *s)
{
    drive_plausibility_setup_t *const m = &s->plausibility;
    ctl_plausibility_params_t *const  c = &m->run;
    const float                       ts_s = 1.0f / (float)DRIVE_PWM_HZ;
    const float                       l_h = larger(p->motor_ld_h, p->motor_lq_h);
    const float                       reach_wb = larger(p->motor_psi_wb, ts_s * p->over_voltage_v);
    const float                       unit_wb = larger(l_h * s->scale.current_a, reach_wb / ROOM); /* what one inside is */
    const float                       per_h = s->scale.current_a / unit_wb;
    const float                       per_v = ts_s * s->scale.voltage_v / unit_wb;
    const float                       psi = p->motor_psi_wb / unit_wb;
    const float                       drop = ts_s * p->motor_resistance_ohm * per_h;
    const float                       turns_e = (float)p->pole_pairs * DRIVE_TWO_PI / p->encoder_counts;
    const float noise = (p->plausibility_share * p->over_current_a * l_h / unit_wb) + (COUNTS * psi * turns_e);
    const float moved = DIAGONAL * psi * (float)p->pole_pairs * s->scale.speed_rad_s * ts_s;

    /* Each change of the flux of iron that saturates is that of a current through an inductance between the least slope and that of
     * small currents: the middle of both, and half their difference as a tolerance. */
    const float slope = least_slope(p);
    const float middle = 0.5f * (1.0f + slope);

    c->ld = drive_number(p->motor_ld_h * middle * per_h);
    c->lq = drive_number(p->motor_lq_h * middle * per_h);
    c->psi = drive_number(psi);
    c->r_half = drive_number(0.5f * drop);
    c->v = drive_number(per_v);
    c->rest = num_max(drive_number(NEW_SHARE * noise), NUM_EPS);
    c->per_current = drive_number(p->motor_resistance_tolerance * drop);
    c->per_change = drive_number((p->motor_inductance_tolerance + 0.5f * (1.0f - slope)) * l_h * per_h);
    c->per_speed = drive_number(p->motor_flux_tolerance * moved);
    c->per_volt = drive_number(VOLT_SHARE * per_v);
    c->per_dc = drive_number(LEGS * p->bridge_tolerance * per_v);
    c->per_volt_change = drive_number(LATE_PERIODS * per_v);

    /* the currents are in the frame of the vector, the magnets and the axes wherever the shaft is */
    m->align = m->run;
    m->align.psi = (num_t)0;
    m->align.per_speed = drive_number(moved);
    m->align.per_change = num_add(c->per_change, num_abs(num_sub(c->ld, c->lq)));
    m->used = p->plausibility_share > 0.0f;
}
