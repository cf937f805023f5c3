/**
 * @file  tests/prove/any.h
 * @brief Values that stand for all values at once, for the value analysis of Frama-C (Eva): with them a harness says what may come.
 */
#ifndef TESTS_PROVE_ANY_H
#define TESTS_PROVE_ANY_H

#include <__fc_builtin.h>

#include "tests/prove/contracts.h"

#include "control/numeric/num.h"

#ifdef EVENSPIN_FIXED
/*@ predicate number(num_t x) = \true; */
#else
/*@ predicate number(num_t x) = \is_finite(x); */
#endif

/* Each read of a volatile object gives any value of its type; of a float, NaN and the infinities as well. */
static volatile uint32_t prove_any_u32;
static volatile int32_t  prove_any_i32;
static volatile uint16_t prove_any_u16;
static volatile float    prove_any_float;
static volatile num_t    prove_any_num;

static inline uint32_t any_u32(void) { return prove_any_u32; }
static inline int32_t  any_i32(void) { return prove_any_i32; }
static inline uint16_t any_u16(void) { return prove_any_u16; }
static inline bool     any_bool(void) { return (prove_any_u16 & 1U) != 0U; }
static inline float    any_float(void) { return prove_any_float; }
static inline num_t    any_num(void) { return prove_any_num; }

/** Any whole number from @p low to @p high. */
static inline uint16_t any_u16_within(uint16_t low, uint16_t high)
{
    const uint16_t x = prove_any_u16;
    return ((x >= low) && (x <= high)) ? x : low;
}

/** Any number from @p low to @p high, no NaN. */
static inline num_t any_num_within(num_t low, num_t high)
{
#ifdef EVENSPIN_FIXED
    const num_t x = prove_any_i32;
    return ((x >= low) && (x <= high)) ? x : low;
#else
    return Frama_C_float_interval(low, high);
#endif
}

#endif
