/* Maxima of the board, from board.h. The comparators' level bounds the software's over-current limit: beyond it the hardware
 * would trip first, without a word about which phase. */
#include "hal/hal_inverter.h"
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
    out->has_chopper = false;
}

/* Neither board has an input for safe torque off: the trip zones go through the processor's own logic, and EN_GATE is a pin of it. */
uint16_t hal_sto(void) { return 0U; }

/* Neither board has a switch for a brake resistor, and no gate driver for one: chopper_v is refused. */
void hal_brake_duty(float duty) { (void)duty; }

/* Neither board has a sensor whose value can be read: of its own heat the DRV8305 warns by itself (gate_driver.c). */
hal_status_t hal_temperature(hal_temperature_t which, float *celsius)
{
    (void)which;
    *celsius = 0.0f;
    return HAL_UNSUPPORTED;
}
