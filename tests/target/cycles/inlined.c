/* What the headers define inline, as functions of its own: the driver can only measure what the counter is built into. */
#include "control/motor/pll.h"
#include "control/numeric/angle.h"
#include "control/numeric/num_math.h"

void  inlined_sincos(angle_t angle, num_t *sine, num_t *cosine);
num_t inlined_sqrt(num_t x);
num_t inlined_pll_step(ctl_pll_t *self, angle_t theta);

void  inlined_sincos(angle_t angle, num_t *sine, num_t *cosine) { angle_sincos(angle, sine, cosine); }
num_t inlined_sqrt(num_t x) { return num_sqrt(x); }
num_t inlined_pll_step(ctl_pll_t *self, angle_t theta) { return ctl_pll_step(self, theta); }
