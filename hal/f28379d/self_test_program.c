/* The program in flash against the check sums that the linker has made of it (crc_table in linker/f28379d_flash.cmd), and the program in
 * RAM against the flash that it was copied from.
 *
 * CRC32_PRIME: polynomial 0x04C11DB7, from zero, most significant bit first, nothing inverted. A word of the C28x is two octets, the
 * less significant first (SPRU513, "CRC ... octets"). */
#include "hal/f28379d/self_test.h"

#if PORT_SELF_TEST

/* Remainder of each nibble. */
static const uint32_t TABLE[16] = {UINT32_C(0x00000000), UINT32_C(0x04C11DB7), UINT32_C(0x09823B6E), UINT32_C(0x0D4326D9),
                                   UINT32_C(0x130476DC), UINT32_C(0x17C56B6B), UINT32_C(0x1A864DB2), UINT32_C(0x1E475005),
                                   UINT32_C(0x2608EDB8), UINT32_C(0x22C9F00F), UINT32_C(0x2F8AD6D6), UINT32_C(0x2B4BCB61),
                                   UINT32_C(0x350C9B64), UINT32_C(0x31CD86D3), UINT32_C(0x3C8EA00A), UINT32_C(0x384FBDBD)};

static uint16_t part;   /* first the records of the table, then the copies */
static uint32_t offset; /* in it */
static uint32_t sum;

static uint32_t add_nibble(uint32_t c, uint16_t nibble) { return (c << 4U) ^ TABLE[((uint16_t)(c >> 28U) ^ nibble) & 0xFU]; }

static uint32_t add_word(uint32_t c, uint16_t word)
{
    uint32_t next = add_nibble(c, (uint16_t)(word >> 4U));
    next = add_nibble(next, word);
    next = add_nibble(next, (uint16_t)(word >> 12U));
    return add_nibble(next, (uint16_t)(word >> 8U));
}

static void next_part(void)
{
    part++;
    offset = 0U;
    sum = 0U;
}

void port_program_begin(void)
{
    part = 0U;
    offset = 0U;
    sum = 0U;
}

static uint32_t end_of_slice(uint32_t words)
{
    return ((words - offset) > PORT_PROGRAM_SLICE_WORDS) ? (offset + PORT_PROGRAM_SLICE_WORDS) : words;
}

static bool record_is_whole(const CRC_RECORD *r)
{
    const uint32_t end = end_of_slice(r->size);
    for (; offset < end; offset++) {
        sum = add_word(sum, port_take(r->addr + offset));
    }
    const bool whole = (offset < r->size) || (sum == r->crc_value);
    if (offset >= r->size) {
        next_part();
    }
    return whole;
}

static bool copy_is_whole(const port_copy_t *c)
{
    const uint32_t end = end_of_slice(c->words);
    bool           whole = true;
    for (; offset < end; offset++) {
        whole = (port_take(c->run + offset) == port_take(c->load + offset)) && whole;
    }
    if (offset >= c->words) {
        next_part();
    }
    return whole;
}

port_program_t port_program_slice(const port_places_t *places, uint32_t *at)
{
    const uint16_t records = (places->sums != NULL) ? places->sums->num_recs : 0U;
    bool           whole = true;
    if ((places->sums != NULL) && (records == 0U)) { /* a program without its sums is not the one that was linked */
        *at = 0U;
        return PORT_PROGRAM_DIFFERS;
    }
    if (part < records) {
        *at = places->sums->recs[part].addr;
        whole = record_is_whole(&places->sums->recs[part]);
    } else if (part < (uint16_t)(records + places->copy_count)) {
        const port_copy_t *const copy = &places->copy[part - records];
        *at = copy->run;
        whole = copy_is_whole(copy);
    } else {
        port_program_begin();
        return PORT_PROGRAM_WHOLE;
    }
    return whole ? PORT_PROGRAM_GOES_ON : PORT_PROGRAM_DIFFERS;
}

#endif
