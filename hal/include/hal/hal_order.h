/**
 * @file  hal/include/hal/hal_order.h
 * @brief Order between plain data and the flag that hands them to an interrupt, or takes them from one.
 *
 * Data cross with a volatile word: a flag, an index, a count. C keeps volatile accesses in their order, but a plain load or store
 * may move past them, and an interrupt between the two would meet a flag without its data. So the side that can be interrupted
 * by the other one puts hal_order() between them:
 *
 *     data = ...; hal_order(); flag = 1;              if (flag != 0) { hal_order(); ... = data; }
 *
 * The interrupt itself needs none: the other side does not run before it has ended. Where the data are a word or two they can be
 * volatile themselves instead. A word is handed over whole, 16 and 32 bits on the C28x; 64 bits are two accesses, and need two
 * copies and an index.
 *
 * No load or store of memory that others can see moves across hal_order(), in either direction. One core needs no more than that.
 * Cost     none with gcc and clang. With TI's compiler a call of a function that it cannot inline, about 10 cycles; so it must
 *          not be linked with link-time optimisation (--opt_level=4), which could. Not tried: there is no such compiler here.
 */
#ifndef HAL_HAL_ORDER_H
#define HAL_HAL_ORDER_H

#if defined(__GNUC__)
static inline void hal_order(void) { __asm__ volatile("" ::: "memory"); }
#else
void hal_order(void);
#endif

#endif
