/* num.h: any operands within +-NUM_MAX (fixed: all there are) for the operations, any value at all for what comes from outside.
 * eva: -eva-precision 6 */
#include "tests/prove/any.h"

#include "control/numeric/num.h"

#ifdef EVENSPIN_FIXED
#define SMALLEST ((num_t)1)
#else
#define SMALLEST 1.4e-45f
#endif

static num_t any_operand(void) { return any_num_within(-NUM_MAX, NUM_MAX); }

static void operations(void)
{
    const num_t sum = num_add(any_operand(), any_operand());
    const num_t difference = num_sub(any_operand(), any_operand());
    const num_t product = num_mul(any_operand(), any_operand());
    const num_t both = num_mac(any_operand(), any_operand(), any_operand());
    const num_t positive = num_div(any_operand(), any_num_within(SMALLEST, NUM_MAX));
    const num_t negative = num_div(any_operand(), any_num_within(-NUM_MAX, -SMALLEST));
    const num_t by_nothing = num_div(any_operand(), (num_t)0);
    const num_t size = num_abs(any_operand());
    const num_t other = num_neg(any_operand());
    /*@ check operations_give_numbers: number(sum) && number(difference) && number(product) && number(both) && number(other); */
    /*@ check a_quotient_is_within_the_range: number(positive) && -NUM_MAX <= positive <= NUM_MAX && number(negative)
          && -NUM_MAX <= negative <= NUM_MAX && number(by_nothing) && -NUM_MAX <= by_nothing <= NUM_MAX; */
    /*@ check a_size_is_not_negative: number(size) && 0 <= size <= NUM_MAX; */
}

static void from_outside(void)
{
    const num_t x = num_from_float(any_float());
    /*@ check any_float_becomes_a_number: number(x) && -NUM_MAX <= x <= NUM_MAX; */
    const num_t whole = num_from_int((int16_t)any_u16());
    /*@ check any_integer_becomes_a_number: number(whole); */
    (void)num_floor(any_num_within(NUM_C(-100.0f), NUM_C(100.0f)));
}

void prove(void)
{
    operations();
    from_outside();
}
