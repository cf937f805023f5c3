/** @file tests/target/avr/target.h
 *  @brief Output of a test program on the AVR, and what avr-libc lacks. */
#ifndef TESTS_TARGET_AVR_TARGET_H
#define TESTS_TARGET_AVR_TARGET_H

void      target_putchar(int c);
long long llround(double x);

#endif
