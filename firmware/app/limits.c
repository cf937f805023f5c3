/* What a parameter may be beside its own range: what the board bears, and what the other parameters leave. Main loop. */
#include <stddef.h>

#include "control/numeric/num_math.h"
#include "firmware/app/internal.h"
#include "hal/hal_limits.h"
#include "hal/hal_sample.h"

/* Below it no current flows in any motor that these boards drive: whoever asks for less means something else. */
#define VOLTAGE_LIMIT_LEAST_V 0.1f

static float least(float a, float b) { return (a < b) ? a : b; }

/* Nothing that would trip. */
float drive_longest_a(const drive_params_t *p)
{
    return least((p->iq_limit_a > p->id_limit_a) ? p->iq_limit_a : p->id_limit_a, p->over_current_a);
}

float drive_id_max_a(const drive_params_t *p) { return least(p->id_limit_a, drive_longest_a(p)); }

float drive_emf_v(const drive_params_t *p) { return 1.7320508f * (float)p->pole_pairs * p->motor_psi_wb * p->over_speed_rad_s; }

/* In the frame of the rotor the current turns around its final value, w psi / (R + j w L), and comes nearer by exp(-t R / L): after
 * half a turn it is beyond by exp(-pi R / (w L)), which is less than 1 / (1 + x + x^2 / 2); what flowed before comes on top. With two
 * inductances the worse of each. */
float drive_short_a(const drive_params_t *p)
{
    const float w = (float)p->pole_pairs * p->over_speed_rad_s;
    const float low = w * least(p->motor_ld_h, p->motor_lq_h);
    const float high = w * ((p->motor_ld_h > p->motor_lq_h) ? p->motor_ld_h : p->motor_lq_h);
    const float r = p->motor_resistance_ohm;
    const float impedance = num_to_float(num_sqrt(num_from_float(1.0f + ((r / low) * (r / low))))) * low;
    const float x = 3.1415927f * r / high;
    return ((w * p->motor_psi_wb / impedance) * (1.0f + (1.0f / (1.0f + x + (0.5f * x * x))))) + drive_longest_a(p);
}

/* A board without a sensor judges no temperature. */
static float hottest(hal_temperature_t which, float range)
{
    float celsius = 0.0f;
    return (hal_temperature(which, &celsius) == HAL_UNSUPPORTED) ? 0.0f : range;
}

/* The board's limit of a parameter, or the end of its range where the board has none. */
static float most(const hal_limits_t *board, uint16_t param)
{
    const param_info_t *const info = params_info(param);
    if (info == NULL) {
        return 0.0f;
    }
    switch (param) {
    case PARAM_over_current_a:
    case PARAM_iq_limit_a:
    case PARAM_id_limit_a:
    case PARAM_align_current_a:
        return least(info->max, board->current_a);
    case PARAM_over_voltage_v:
    case PARAM_voltage_limit_v:
        return least(info->max, board->dc_link_v);
    case PARAM_over_speed_rad_s:
        return least(info->max, board->speed_rad_s);
    case PARAM_offset_limit_a:
        return least(info->max, board->offset_a);
    case PARAM_motor_trip_c:
        return hottest(HAL_TEMPERATURE_MOTOR, info->max);
    case PARAM_bridge_trip_c:
        return hottest(HAL_TEMPERATURE_BRIDGE, info->max);
    case PARAM_chopper_v:
        return board->has_chopper ? info->max : 0.0f;
    case PARAM_encoder_counts:
        return (board->encoder_counts > 0.0f) ? board->encoder_counts : info->max;
    default:
        return info->max;
    }
}

float drive_board_max(uint16_t param)
{
    hal_limits_t board;
    hal_limits(&board);
    return most(&board, param);
}

uint16_t drive_board_refuses(const drive_params_t *p)
{
    static const uint16_t BOUND[] = {PARAM_over_current_a,  PARAM_over_voltage_v,  PARAM_over_speed_rad_s,
                                     PARAM_offset_limit_a,  PARAM_iq_limit_a,      PARAM_id_limit_a,
                                     PARAM_align_current_a, PARAM_voltage_limit_v, PARAM_chopper_v};
    hal_limits_t          board;
    hal_limits(&board);
    if ((board.encoder_counts > 0.0f) && (p->encoder_counts != board.encoder_counts)) {
        return PARAM_encoder_counts;
    }
    if ((p->motor_trip_c > 0.0f) && !(p->motor_trip_c <= most(&board, PARAM_motor_trip_c))) {
        return PARAM_motor_trip_c;
    }
    if ((p->bridge_trip_c > 0.0f) && !(p->bridge_trip_c <= most(&board, PARAM_bridge_trip_c))) {
        return PARAM_bridge_trip_c;
    }
    for (uint16_t k = 0U; k < (uint16_t)(sizeof BOUND / sizeof BOUND[0]); k++) {
        if (!(params_get(p, BOUND[k]) <= most(&board, BOUND[k]))) {
            return BOUND[k];
        }
    }
    return PARAM_COUNT;
}

/* What the other parameters leave of a range. */
static void narrow(const drive_params_t *p, uint16_t param, float *low, float *high)
{
    switch (param) {
    case PARAM_under_voltage_v:
        *high = p->over_voltage_v;
        break;
    case PARAM_iq_limit_a:
    case PARAM_align_current_a:
    case PARAM_motor_continuous_a:
    case PARAM_bridge_continuous_a:
        *high = least(*high, p->over_current_a);
        break;
    case PARAM_regeneration_limit_v: /* and there is a band below it */
        *high = least(*high, p->over_voltage_v);
        *low = (p->regeneration_limit_v > 0.0f) ? p->regeneration_band_v : *low;
        break;
    case PARAM_chopper_v: /* full on before the braking is bounded, and before the trip */
        *high = (p->regeneration_limit_v > 0.0f) ? (p->regeneration_limit_v - p->regeneration_band_v) : p->over_voltage_v;
        *high = (*high > p->chopper_band_v) ? (*high - p->chopper_band_v) : 0.0f;
        break;
    case PARAM_chopper_continuous_w: /* what the thermal model counts */
        *low = (p->chopper_continuous_w > 0.0f)
                   ? (p->over_voltage_v * p->over_voltage_v / (p->chopper_ohm * CTL_THERMAL_LOAD_MAX))
                   : *low;
        break;
    case PARAM_motor_derate_c: /* beyond it the drive has tripped */
        *high = (p->motor_trip_c > 1.0f) ? (p->motor_trip_c - 1.0f) : 0.0f;
        break;
    case PARAM_bridge_derate_c:
        *high = (p->bridge_trip_c > 1.0f) ? (p->bridge_trip_c - 1.0f) : 0.0f;
        break;
    case PARAM_stall_torque_a: /* more is never asked for */
        *high = least(*high, p->iq_limit_a);
        break;
    case PARAM_voltage_limit_v:
        *low = (p->voltage_limit_v > 0.0f) ? VOLTAGE_LIMIT_LEAST_V : *low;
        break;
    case PARAM_profile_speed_rad_s:
        *high = p->over_speed_rad_s;
        break;
    case PARAM_current_offset_a_a:
    case PARAM_current_offset_b_a:
    case PARAM_current_offset_c_a:
        *low = -p->current_offset_max_a;
        *high = p->current_offset_max_a;
        break;
    case PARAM_current_gain_a:
    case PARAM_current_gain_b:
    case PARAM_current_gain_c:
        *low = 1.0f - p->current_gain_max;
        *high = 1.0f + p->current_gain_max;
        break;
    default:
        break;
    }
}

void drive_relation(const drive_params_t *p, uint16_t param, float *low, float *high)
{
    const param_info_t *const info = params_info(param);
    *low = (info != NULL) ? info->min : 0.0f;
    *high = drive_board_max(param);
    if (param == (uint16_t)PARAM_encoder_counts) {
        hal_limits_t board;
        hal_limits(&board);
        *low = (board.encoder_counts > 0.0f) ? board.encoder_counts : *low;
    }
    narrow(p, param, low, high);
}

/* A voltage below that of the trip: at the same value the two could not be distinguished. */
static bool fits(const drive_params_t *p, uint16_t param)
{
    const float x = params_get(p, param);
    float       low = params_info(param)->min;
    float       high = params_info(param)->max;
    narrow(p, param, &low, &high);
    return (x >= low) && ((param == (uint16_t)PARAM_under_voltage_v) ? (x < high) : (x <= high));
}

uint16_t drive_relation_refuses(const drive_params_t *p)
{
    static const uint16_t RELATED[] = {
        PARAM_under_voltage_v,      PARAM_iq_limit_a,         PARAM_align_current_a,     PARAM_voltage_limit_v,
        PARAM_profile_speed_rad_s,  PARAM_current_offset_a_a, PARAM_current_offset_b_a,  PARAM_current_offset_c_a,
        PARAM_current_gain_a,       PARAM_current_gain_b,     PARAM_current_gain_c,      PARAM_motor_continuous_a,
        PARAM_bridge_continuous_a,  PARAM_stall_torque_a,     PARAM_motor_derate_c,      PARAM_bridge_derate_c,
        PARAM_regeneration_limit_v, PARAM_chopper_v,          PARAM_chopper_continuous_w};
    for (uint16_t k = 0U; k < (uint16_t)(sizeof RELATED / sizeof RELATED[0]); k++) {
        if (!fits(p, RELATED[k])) {
            return RELATED[k];
        }
    }
    return PARAM_COUNT;
}
