/* March C- (M. Marinescu 1982; A. J. van de Goor, "Using march tests to test SRAMs", 1993): up w0; up r0 w1; up r1 w0; down r0 w1;
 * down r1 w0; r0. It finds stuck and slow cells, cells that change with another one, and addresses that meet. */
#include "hal/f28379d/self_test.h"

#if PORT_SELF_TEST

/* Each word must hold the one and is given the other. */
BOARD_RAM_CODE static uint32_t element(uint32_t first, uint32_t words, bool down, uint16_t held, uint16_t given)
{
    for (uint32_t i = 0U; i < words; i++) {
        const uint32_t at = first + (down ? ((words - 1U) - i) : i);
        if (port_take(at) != held) {
            return at;
        }
        port_put(at, given);
    }
    return UINT32_MAX;
}

BOARD_RAM_CODE uint32_t port_ram_march(uint32_t first, uint32_t words, uint16_t background)
{
    const uint16_t inverse = (uint16_t)(0xFFFFU - background);
    for (uint32_t i = 0U; i < words; i++) {
        port_put(first + i, background);
    }
    uint32_t at = UINT32_MAX;
    for (uint16_t step = 0U; (step < 5U) && (at == UINT32_MAX); step++) {
        const bool odd = (step % 2U) != 0U;
        at = element(first, words, step >= 2U, odd ? inverse : background, (odd || (step == 4U)) ? background : inverse);
    }
    return at;
}

/* One operation of the march on one word: read, compare, write. */
static inline uint16_t turned(uint32_t at, uint16_t held, uint16_t given)
{
    const uint16_t differs = (uint16_t)(port_take(at) ^ held);
    port_put(at, given);
    return differs;
}

/* Without a loop and a branch: the current interrupt waits for it. */
BOARD_RAM_CODE uint32_t port_ram_slice(uint32_t first, uint16_t background)
{
    const uint16_t inverse = (uint16_t)(0xFFFFU - background);
    const uint32_t next = first + 1U;
    const bool     were_off = Interrupt_disableGlobal();
    const uint16_t kept_first = port_take(first);
    const uint16_t kept_next = port_take(next);
    port_put(first, background);
    port_put(next, background);
    uint16_t bad_first = turned(first, background, inverse); /* up */
    uint16_t bad_next = turned(next, background, inverse);
    bad_first |= turned(first, inverse, background);
    bad_next |= turned(next, inverse, background);
    bad_next |= turned(next, background, inverse); /* down */
    bad_first |= turned(first, background, inverse);
    bad_next |= turned(next, inverse, background);
    bad_first |= turned(first, inverse, background);
    bad_next |= turned(next, background, kept_next); /* and back */
    bad_first |= turned(first, background, kept_first);
    if (!were_off) {
        (void)Interrupt_enableGlobal();
    }
    if (bad_first != 0U) {
        return first;
    }
    return (bad_next != 0U) ? next : UINT32_MAX;
}

#endif
