#include "fake_memory.h"

#include <string.h>

#include "fake_chip.h"

fake_memory_t fake_memory;
port_places_t fake_places = {.operands = &port_operands};

void fake_memory_power_on(void)
{
    (void)memset(&fake_memory, 0, sizeof fake_memory);
    (void)memset(&fake_places, 0, sizeof fake_places);
    fake_places.operands = &port_operands;
}

const port_places_t *port_self_test_places(void) { return &fake_places; }

static void count(void)
{
    fake_memory.masked_accesses = chip.intm ? (fake_memory.masked_accesses + 1U) : 0U;
    if (fake_memory.masked_accesses > fake_memory.longest_masked) {
        fake_memory.longest_masked = fake_memory.masked_accesses;
    }
}

static uint32_t place_of(uint32_t address)
{
    const uint32_t at = (address - FAKE_MEMORY_FIRST) % FAKE_MEMORY_WORDS;
    return ((fake_memory.defect == FAKE_MEMORY_SAME_ADDRESS) && (at == fake_memory.by)) ? fake_memory.at : at;
}

uint16_t port_take(uint32_t address)
{
    count();
    const uint32_t at = place_of(address);
    uint16_t       word = fake_memory.word[at];
    if ((at == fake_memory.at) && (fake_memory.defect == FAKE_MEMORY_STUCK_LOW)) {
        word &= (uint16_t)~fake_memory.bit;
    }
    if ((at == fake_memory.at) && (fake_memory.defect == FAKE_MEMORY_STUCK_HIGH)) {
        word |= fake_memory.bit;
    }
    return word;
}

void port_put(uint32_t address, uint16_t word)
{
    fake_memory_t *const m = &fake_memory;
    count();
    m->unmasked_writes += chip.intm ? 0U : 1U;
    const uint32_t at = place_of(address);
    const uint16_t before = m->word[at];
    m->word[at] = word;
    if ((at == m->at) && (m->defect == FAKE_MEMORY_NO_RISE)) {
        m->word[at] &= (uint16_t)~(m->bit & ~before);
    }
    if ((at == m->at) && (m->defect == FAKE_MEMORY_BIT_FOLLOWS)) {
        m->word[at] = (uint16_t)((word & (uint16_t)~m->bit) | (((word & m->by) != 0U) ? m->bit : 0U));
    }
    if ((at == m->by) && (m->defect == FAKE_MEMORY_COUPLED) && ((word & (uint16_t)~before & m->bit) != 0U)) {
        m->word[m->at] ^= m->bit;
    }
    if ((at == m->by) && (m->defect == FAKE_MEMORY_COPIES)) {
        m->word[m->at] = (uint16_t)((m->word[m->at] & (uint16_t)~m->bit) | (word & m->bit));
    }
}
