/* Maxima of the board, from board.h. The comparators' level bounds the software's over-current limit: beyond it the hardware
 * would trip first, without a word about which phase. */
#include "hal/hal_limits.h"
#include "hal/hal_sample.h"

#include "hal/f28379d/board.h"

#define TWO_PI 6.28318531f

void hal_limits(hal_limits_t *out)
{
    out->current_a = BOARD_TRIP_A;
    out->dc_link_v = BOARD_OVER_VOLTAGE_V;
    out->speed_rad_s = TWO_PI * BOARD_EDGES_HZ / (float)BOARD_ENCODER_COUNTS;
    out->offset_a = BOARD_OFFSET_LIMIT_A;
    out->encoder_counts = (float)BOARD_ENCODER_COUNTS; /* angle, wrap and index are computed with it */
}

/* Neither board has a sensor whose value can be read: of its own heat the DRV8305 warns by itself (gate_driver.c). */
hal_status_t hal_temperature(hal_temperature_t which, float *celsius)
{
    (void)which;
    *celsius = 0.0f;
    return HAL_UNSUPPORTED;
}
