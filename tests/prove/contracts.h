/**
 * @file  tests/prove/contracts.h
 * @brief What four functions of control/numeric/num.h promise, for proofs of the float build.
 *
 * Eva (Frama-C 25) keeps "NaN" beside an interval whatever the value is compared with, and so cannot see that a comparison rejects it. It takes
 * these contracts instead of the code; contracts_hold.c checks them with the code for all 2^32 floats.
 */
#ifndef TESTS_PROVE_CONTRACTS_H
#define TESTS_PROVE_CONTRACTS_H

#include <stdbool.h>
#include <stdint.h>

#ifdef EVENSPIN_FIXED

typedef int32_t num_t;

/*@ assigns \result \from x;
    ensures -2147483647 <= \result <= 2147483647; */
static inline num_t num_from_float(float x);

#else

typedef float num_t;

/*@ requires \is_finite(lo) && \is_finite(hi) && lo <= hi;
    assigns \result \from x, lo, hi;
    ensures \is_finite(\result) && lo <= \result <= hi;
    behavior not_negative:
      assumes \is_finite(x) && x >= 0 && hi >= 0;
      ensures \result >= 0; */
static inline num_t num_clamp(num_t x, num_t lo, num_t hi);

/*@ assigns \result \from x;
    behavior good:
      assumes \is_finite(x) && -1.0e12f <= x <= 1.0e12f;
      ensures \result == 1;
    behavior bad:
      assumes !(\is_finite(x) && -1.0e12f <= x <= 1.0e12f);
      ensures \result == 0;
    complete behaviors;
    disjoint behaviors; */
static inline bool num_is_finite(num_t x);

/*@ requires \is_finite(fallback) && \valid(rejected);
    assigns \result \from x, fallback;
    assigns *rejected \from *rejected, x;
    ensures \is_finite(\result);
    behavior in_range:
      assumes -1.0e12f <= fallback <= 1.0e12f;
      ensures -1.0e12f <= \result <= 1.0e12f; */
static inline num_t num_guard(num_t x, num_t fallback, uint32_t *rejected);

/*@ assigns \result \from x;
    ensures \is_finite(\result) && -1.0e12f <= \result <= 1.0e12f; */
static inline num_t num_from_float(float x);

#endif

#endif
