/* Voltages, currents and angle against the equation of the windings: the share of the setup. Its step is in watch_isr.c. Main
 * loop. control/motor/plausibility.h has the equations. */
#include "firmware/app/internal.h"

#define VOLT_SHARE 0.05f  /* of the voltage: divider of the dc link, and its filter behind a link that changes */
#define LATE_PERIODS 0.3f /* by which the voltage may act late: filter of the currents, drivers */
#define LEGS 1.82f       /* |alpha| + |beta| of what three legs lose, over the loss of one: 4/3 (sin 30 + cos 30 degrees) */
#define DIAGONAL 1.3f     /* |alpha| + |beta| of a vector, over the same of one across to it: at most sqrt(2) */
#define COUNTS 1.8f       /* of the encoder by which an angle may be off the ones before, along the diagonal */
#define NEW_SHARE 0.25f   /* of the error in each period; the rest is kept */
#define ROOM 32.0f        /* base currents that the largest flux makes of the reference inductance */

static float larger(float a, float b) { return (a > b) ? a : b; }

void drive_make_plausibility(const drive_params_t *p, drive_setup_t *s)
{
    drive_plausibility_setup_t *const m = &s->plausibility;
    const drive_scale_t *const        scale = &s->scale;
    const float                       ts_s = 1.0f / (float)DRIVE_PWM_HZ;
    const float                       we = (float)p->pole_pairs * scale->speed_rad_s;
    const float                       l_h = larger(p->motor_ld_h, p->motor_lq_h);
    const float                       difference_h = 2.0f * (l_h - (0.5f * (p->motor_ld_h + p->motor_lq_h)));
    const float                       count_wb = p->motor_psi_wb * DRIVE_TWO_PI * (float)p->pole_pairs / p->encoder_counts;
    const float                       reach_wb = larger(p->motor_psi_wb, ts_s * p->over_voltage_v);
    const float                       unit_wb = larger(l_h * scale->current_a, reach_wb / ROOM); /* what one inside is */

    ctl_plausibility_params_t c = {.ld = num_from_float(p->motor_ld_h * scale->current_a / unit_wb),
                                   .lq = num_from_float(p->motor_lq_h * scale->current_a / unit_wb),
                                   .psi = num_from_float(p->motor_psi_wb / unit_wb),
                                   .r_half = num_from_float(0.5f * ts_s * p->motor_resistance_ohm * scale->current_a / unit_wb),
                                   .v = num_from_float(ts_s * scale->voltage_v / unit_wb)};
    const float               noise_wb = (p->plausibility_share * p->over_current_a * l_h) + (COUNTS * count_wb);
    const float               psi_wb = DIAGONAL * p->motor_psi_wb * we * ts_s;
    c.rest = num_max(num_from_float(NEW_SHARE * noise_wb / unit_wb), NUM_EPS);
    c.per_current = num_mul(num_from_float(2.0f * p->motor_resistance_tolerance), c.r_half);
    c.per_change = num_from_float(p->motor_inductance_tolerance * l_h * scale->current_a / unit_wb);
    c.per_speed = num_from_float(p->motor_flux_tolerance * psi_wb / unit_wb);
    c.per_volt = num_mul(NUM_C(VOLT_SHARE), c.v);
    c.per_dc = num_mul(num_from_float(LEGS * p->bridge_tolerance), c.v);
    c.per_volt_change = num_mul(NUM_C(LATE_PERIODS), c.v);
    m->run = c;

    /* the currents are in the frame of the vector, the magnets wherever the shaft is */
    c.psi = (num_t)0;
    c.per_speed = num_from_float(psi_wb / unit_wb);
    c.per_change = num_add(c.per_change, num_from_float(difference_h * scale->current_a / unit_wb));
    m->align = c;
    m->used = p->plausibility_share > 0.0f;
}
