/**
 * @file  tests/firmware/support/accesses.h
 * @brief An interrupt between any two accesses to memory of the code that it preempts.
 *
 * The code is compiled with -fsanitize=thread, which calls a function before each load and store, in the order that the optimised
 * code has; these functions are here, and the sanitizer's library is not linked.
 */
#ifndef TESTS_FIRMWARE_SUPPORT_ACCESSES_H
#define TESTS_FIRMWARE_SUPPORT_ACCESSES_H

#include <stddef.h>
#include <stdint.h>

/** Run @p code; @p interrupt comes once, before its access @p number, counted from 1. @return accesses that were counted: up to the
 *  interrupt, or all of them when there were fewer. */
uint32_t accesses_run(void (*code)(void), uint32_t number, void (*interrupt)(void));
/** Run @p code, and say what it writes: @p size bytes at @p at. */
void accesses_watch(void (*code)(void), void (*written)(const void *at, size_t size));

#endif
