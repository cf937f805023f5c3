/* Rows of a CSV file. A log of half a minute has millions of numbers, and printf takes most of the time of writing it. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim_host/capi/evenspin_capi.h"

enum { DIGITS = 9, LEAST_FIXED = -4, MOST_SCALE = 27 };

#if LDBL_MANT_DIG >= 64
/* Powers of ten that a long double holds exactly: 5^27 < 2^64. */
static const long double TEN[MOST_SCALE + 1] = {
    1e0L,  1e1L,  1e2L,  1e3L,  1e4L,  1e5L,  1e6L,  1e7L,  1e8L,  1e9L,  1e10L, 1e11L, 1e12L, 1e13L,
    1e14L, 1e15L, 1e16L, 1e17L, 1e18L, 1e19L, 1e20L, 1e21L, 1e22L, 1e23L, 1e24L, 1e25L, 1e26L, 1e27L,
};

/**
 * The DIGITS digits of @p size > 0 and its decimal exponent, rounded as printf does: false where that cannot be said from 64 bits.
 * One multiplication rounds, so the scaled value, below 10^9, is off by less than 10^9 2^-64; nearer than 10^-6 to the middle
 * between two numbers it is left to printf.
 */
static bool digits_of(double size, uint32_t *digits, int *exponent)
{
    const int guess = (int)floor(log10(size));
    for (int e = guess - 1; e <= guess + 1; e++) {
        const int scale = DIGITS - 1 - e;
        if ((scale < 0) || (scale > MOST_SCALE)) {
            return false;
        }
        const long double scaled = (long double)size * TEN[scale];
        if (scaled < 1e9L) {
            uint64_t          whole = (uint64_t)scaled;
            const long double part = scaled - (long double)whole;
            if (fabsl(part - 0.5L) < 1e-6L) {
                return false;
            }
            whole += (part > 0.5L) ? 1U : 0U;
            *exponent = (whole == 1000000000U) ? e + 1 : e;
            *digits = (whole == 1000000000U) ? 100000000U : (uint32_t)whole;
            return *digits >= 100000000U;
        }
    }
    return false;
}
#else
static bool digits_of(double size, uint32_t *digits, int *exponent)
{
    (void)size;
    (void)digits;
    (void)exponent;
    return false;
}
#endif

/** As "%.9g": a plain number, or one with an exponent, without zeros at the end. */
static int write_digits(char *out, uint32_t digits, int exponent)
{
    char text[DIGITS];
    int  count = 0;
    for (int k = DIGITS - 1; k >= 0; k--) {
        text[k] = (char)('0' + (int)(digits % 10U));
        digits /= 10U;
        count = ((count == 0) && (text[k] != '0')) ? k + 1 : count;
    }
    char *const start = out;
    if ((exponent < LEAST_FIXED) || (exponent >= DIGITS)) {
        *out++ = text[0];
        if (count > 1) {
            *out++ = '.';
            memcpy(out, text + 1, (size_t)(count - 1));
            out += count - 1;
        }
        return (int)(out - start) + sprintf(out, "e%+03d", exponent);
    }
    if (exponent < 0) {
        *out++ = '0';
        *out++ = '.';
        for (int k = -1; k > exponent; k--) {
            *out++ = '0';
        }
        memcpy(out, text, (size_t)count);
        return (int)(out + count - start);
    }
    for (int k = 0; k <= exponent; k++) {
        *out++ = text[k];
    }
    if (count > exponent + 1) {
        *out++ = '.';
        memcpy(out, text + exponent + 1, (size_t)(count - exponent - 1));
        out += count - exponent - 1;
    }
    return (int)(out - start);
}

static int write_number(char *out, double value)
{
    if (isnan(value)) {
        return sprintf(out, "nan");
    }
    uint32_t digits = 0;
    int      exponent = 0;
    if (value == 0.0) {
        *out = '0'; /* of either sign */
        return 1;
    }
    if (!isfinite(value) || !digits_of(fabs(value), &digits, &exponent)) {
        return sprintf(out, "%.9g", value);
    }
    *out = '-';
    const int sign = (value < 0.0) ? 1 : 0;
    return sign + write_digits(out + sign, digits, exponent);
}

int64_t es_csv_rows(const double *values, int64_t rows, int columns, char *out, int64_t room)
{
    if ((values == NULL) || (out == NULL) || (rows < 0) || (columns <= 0) || (room / ES_CSV_CELL / columns < rows)) {
        return 0;
    }
    char *const start = out;
    for (int64_t row = 0; row < rows; row++) {
        for (int column = 0; column < columns; column++) {
            out += write_number(out, *values++);
            *out++ = (column + 1 < columns) ? ',' : '\n';
        }
    }
    return (int64_t)(out - start);
}
