/* Transforms, vector limit and modulation: any voltage, any dc link, NaN included. */
#include "tests/prove/any.h"

#include "control/motor/frames.c"
#include "control/motor/svm.c"
#include "control/numeric/num_math.c"

void prove(void)
{
    const ctl_ab_t v = {any_num(), any_num()};
    ctl_abc_t      duty;
    (void)ctl_svm(&v, any_num(), &duty);
    /*@ check duties_are_within_0_and_1: number(duty.a) && number(duty.b) && number(duty.c) && 0 <= duty.a <= NUM_C(1.0f)
          && 0 <= duty.b <= NUM_C(1.0f) && 0 <= duty.c <= NUM_C(1.0f); */
    const ctl_abc_t   abc = {any_num(), any_num(), any_num()};
    const ctl_rotor_t rotor = {any_num(), any_num()};
    ctl_ab_t          ab;
    ctl_dq_t          dq;
    (void)ctl_clarke(&abc, &ab);
    /*@ check clarke_gives_numbers: number(ab.alpha) && number(ab.beta); */
    (void)ctl_park(&v, &rotor, &dq);
    /*@ check park_gives_numbers: number(dq.d) && number(dq.q); */
    const ctl_dq_t given = {any_num(), any_num()};
    (void)ctl_inverse_park(&given, &rotor, &ab);
    /*@ check inverse_park_gives_numbers: number(ab.alpha) && number(ab.beta); */
    ctl_abc_t back;
    (void)ctl_inverse_clarke(&v, &back);
    /*@ check inverse_clarke_gives_numbers: number(back.a) && number(back.b) && number(back.c); */
}
