/* Radians within +-100 become an angle without an overflow of the conversion. */
#include "tests/prove/any.h"

#include "control/numeric/angle.c"

void prove(void) { (void)angle_from_rad_unchecked(any_num_within(-ANGLE_RAD_MAX, ANGLE_RAD_MAX)); }
