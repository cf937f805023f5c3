/* Angles: every angle, and any number as radians or turns. The turn comes in 16 parts, so that Eva knows the quadrant. */
#include "tests/prove/any.h"

#include "control/numeric/angle.c"

void prove(void)
{
    for (uint16_t k = 0U; k < 16U; k++) {
        const angle_t angle = ((angle_t)k << 28) + (any_u32() & UINT32_C(0x0FFFFFFF));
        num_t         sine, cosine;
        angle_sincos_portable(angle, &sine, &cosine);
        /*@ check sine_and_cosine_are_bounded: number(sine) && number(cosine) && -NUM_C(1.001f) <= sine <= NUM_C(1.001f)
              && -NUM_C(1.001f) <= cosine <= NUM_C(1.001f); */
    }
    const num_t half = angle_to_rad_signed(any_u32());
    /*@ check radians_are_within_half_a_turn: number(half) && -NUM_C(3.1416f) <= half <= NUM_C(3.1416f); */
    const num_t full = angle_to_rad(any_u32());
    /*@ check radians_are_within_a_turn: number(full) && 0 <= full <= NUM_C(6.2832f); */
    const num_t turns = angle_to_turns(any_u32());
    /*@ check turns_are_within_one: number(turns) && 0 <= turns <= NUM_C(1.0f); */
    (void)angle_step_from_rad_unchecked(any_num_within(-NUM_MAX, NUM_MAX));
    (void)angle_step_from_turns(any_num_within(-NUM_MAX, NUM_MAX));
}
