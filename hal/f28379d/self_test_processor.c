/* Operations of the processor on operands that the compiler does not know, folded into one number that is known.
 *
 * Adder with carry, multiplier of 16, 32 and 64 bits, shifter, logic, a bit walking through 32, signed compare and division, and of the
 * floating-point unit sum, product, quotient, comparison and both conversions; results of floats are exact, or cut where the
 * quotient of the trigonometric unit may differ in its last bit. Not its sine, cosine and root. */
#include "hal/f28379d/self_test.h"

#if PORT_SELF_TEST

#define SCALE 1024.0f

const volatile port_operands_t port_operands = {
    {0xA5C3U, 0x5A3CU, 0xFFFFU, 0x0003U},
    {UINT32_C(0x80000001), UINT32_C(0x12345678), UINT32_C(0x9ABCDEF0), UINT32_C(0xFFFFFFFF)},
    {INT32_C(-1234567), INT32_C(89)},
    {1.5f, -2.25f, 16777215.0f, 1.0f, 3.75f, 1.25f}};

/* Turned by a bit and added: no single change cancels. */
static uint32_t fold(uint32_t s, uint32_t x) { return ((s << 1U) | (s >> 31U)) + x; }

static uint32_t of_words(uint32_t s, const volatile port_operands_t *of)
{
    const uint32_t a = of->word[0];
    const uint32_t b = of->word[1];
    uint32_t       r = fold(s, a + b);
    r = fold(r, a * b);
    r = fold(r, (a << 3U) ^ (b >> 5U));
    r = fold(r, (uint16_t)(of->word[2] - of->word[0]));
    r = fold(r, (a & b) | of->word[3]);
    return fold(r, a / of->word[3]);
}

static uint32_t of_dwords(uint32_t s, const volatile port_operands_t *of)
{
    const uint32_t p = of->dword[0];
    const uint32_t q = of->dword[1];
    const uint32_t u = of->dword[2];
    const uint64_t wide = (uint64_t)u * of->dword[3];
    uint32_t       r = fold(s, p + u);
    r = fold(r, p - q);
    r = fold(r, q * u);
    r = fold(r, (uint32_t)(wide >> 32U));
    r = fold(r, (uint32_t)wide);
    for (uint16_t k = 0U; k < 32U; k++) {
        const uint32_t bit = p << k;
        r = fold(r, (bit ^ q) - (bit & u));
    }
    return r;
}

static uint32_t of_numbers(uint32_t s, const volatile port_operands_t *of)
{
    const int32_t m = of->number[0];
    const int32_t n = of->number[1];
    uint32_t      r = fold(s, (uint32_t)(m * n));
    r = fold(r, (uint32_t)(m / n));
    return fold(r, (m < n) ? 5U : 7U);
}

static uint32_t scaled(float x) { return (uint32_t)(int32_t)(x * SCALE); }

static uint32_t of_reals(uint32_t s, const volatile port_operands_t *of)
{
    const float x = of->real[0];
    const float y = of->real[1];
    uint32_t    r = fold(s, scaled(x + y));
    r = fold(r, scaled(x * y));
    r = fold(r, (uint32_t)(int32_t)(of->real[2] + of->real[3]));
    r = fold(r, (uint32_t)(int32_t)((of->real[4] / of->real[5] * SCALE) + 0.5f));
    r = fold(r, scaled((float)of->number[1] * x));
    return fold(r, (x > y) ? 11U : 13U);
}

uint32_t port_processor_signature(const volatile port_operands_t *of)
{
    return of_reals(of_numbers(of_dwords(of_words(0U, of), of), of), of);
}

#endif
