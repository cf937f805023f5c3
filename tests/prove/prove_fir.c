/* The symmetric filter: every order, any folded taps within +-4, any samples (NaN too).
 * eva: -eva-precision 3 -eva-slevel 100 */
#include "tests/prove/any.h"

#include "control/numeric/angle.c"
#include "control/observer/fir.c"

void prove(void)
{
    ctl_fir_t fir;
    fir.order = any_u16_within(0U, CTL_FIR_ORDER_MAX);
    for (uint16_t i = 0U; i < CTL_FIR_PAIRS; i++) {
        fir.fold[i] = any_num_within(NUM_C(-4.0f), NUM_C(4.0f));
    }
    fir.state.rejected = any_u32();
    ctl_fir_reset(&fir, any_num());
    /*@ loop widen_hints fir.state.past.head, 15; */
    while (any_bool()) {
        const num_t y = ctl_fir_step(&fir, any_num());
        /*@ check the_output_is_a_number: number(y); */
    }
}
