/* The tests in turn: each whole at the start, then a slice in every pass of the main loop. */
#include "hal/f28379d/self_test.h"

#if PORT_SELF_TEST

#define NOWHERE UINT32_MAX
#define TURNS 3U

static const uint16_t BACKGROUND[] = {0x0000U, 0x5555U, 0x3333U, 0x0F0FU, 0x00FFU}; /* bits of a word against each other */
#define BACKGROUNDS ((uint16_t)(sizeof(BACKGROUND) / sizeof(BACKGROUND[0])))
#define AT_START 2U /* of these, over whole regions */

static hal_inverter_fault_t found;
static uint32_t             found_at;
static uint16_t             turn, region, background;
static uint32_t             offset; /* of the next slice in its region */

static void fail(hal_inverter_fault_t what, uint32_t at)
{
    if (found == HAL_INVERTER_FINE) {
        found = what;
        found_at = at;
    }
}

static void test_ram_whole(const port_places_t *p)
{
    for (uint16_t k = 0U; k < p->fresh_count; k++) {
        for (uint16_t b = 0U; b < AT_START; b++) {
            const uint32_t at = port_ram_march(p->fresh[k].first, p->fresh[k].words, BACKGROUND[b]);
            if (at != NOWHERE) {
                fail(HAL_INVERTER_RAM_TEST, at);
            }
        }
        for (uint32_t i = 0U; i < p->fresh[k].words; i++) {
            port_put(p->fresh[k].first + i, 0U); /* as the C start-up has left it */
        }
    }
}

/* The last slice of a region may begin a word earlier: a region has at least one slice. */
static void test_ram(const port_places_t *p)
{
    if (region >= p->ram_count) {
        region = 0U;
        offset = 0U;
        background = (uint16_t)((background + 1U) % BACKGROUNDS);
        return;
    }
    const port_region_t *const r = &p->ram[region];
    if (r->words >= PORT_RAM_SLICE_WORDS) {
        const uint32_t last = r->words - PORT_RAM_SLICE_WORDS;
        const uint32_t at = port_ram_slice(r->first + ((offset < last) ? offset : last), BACKGROUND[background]);
        if (at != NOWHERE) {
            fail(HAL_INVERTER_RAM_TEST, at);
        }
    }
    offset += PORT_RAM_SLICE_WORDS;
    if (offset >= r->words) {
        offset = 0U;
        region++;
    }
}

static port_program_t test_program(const port_places_t *p)
{
    uint32_t             at = 0U;
    const port_program_t result = port_program_slice(p, &at);
    if (result == PORT_PROGRAM_DIFFERS) {
        fail(HAL_INVERTER_PROGRAM_TEST, at);
    }
    return result;
}

static void test_processor(const port_places_t *p)
{
    if (port_processor_signature(p->operands) != PORT_PROCESSOR_SIGNATURE) {
        fail(HAL_INVERTER_PROCESSOR_TEST, 0U);
    }
}

void port_self_test_start(void)
{
    const port_places_t *const places = port_self_test_places();
    found = HAL_INVERTER_FINE;
    found_at = 0U;
    turn = 0U;
    region = 0U;
    offset = 0U;
    background = 0U;
    test_processor(places);
    test_ram_whole(places);
    port_program_begin();
    while (test_program(places) == PORT_PROGRAM_GOES_ON) {
    }
}

void port_self_test_slice(void)
{
    const port_places_t *const places = port_self_test_places();
    if (turn == 0U) {
        test_ram(places);
    } else if (turn == 1U) {
        (void)test_program(places);
    } else {
        test_processor(places);
    }
    turn = (uint16_t)((turn + 1U) % TURNS);
    if (found != HAL_INVERTER_FINE) {
        hal_inverter_disarm();
        port_trip_note(found);
    }
}

hal_inverter_fault_t port_self_test_found(void) { return found; }
uint32_t             port_self_test_address(void) { return found_at; }

#endif
