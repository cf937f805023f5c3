/* Unity on the AVR: int of 16 bits, pointers of 16 bits, double of 32 bits. */
#include "target.h"

#define UNITY_INT_WIDTH 16
#define UNITY_LONG_WIDTH 32
#define UNITY_POINTER_WIDTH 16
#define UNITY_INCLUDE_DOUBLE
#define UNITY_SUPPORT_64
#define UNITY_OUTPUT_CHAR(c) target_putchar(c)
