/* A memory that changes by itself: one bit of the state of the drive. */
#include <string.h>

#include "sim_host/capi/sim.h"

enum {
#define REGION(name, lvalue, doc) REGION_##name,
#include "sim_host/capi/regions.def"
#undef REGION
    REGION_COUNT
};

static const char *const NAMES[REGION_COUNT] = {
#define REGION(name, lvalue, doc) #name,
#include "sim_host/capi/regions.def"
#undef REGION
};

int         es_region_count(void) { return (int)REGION_COUNT; }
const char *es_region_name(int index) { return ((index >= 0) && (index < (int)REGION_COUNT)) ? NAMES[index] : ""; }

static drive_set_t *in_force(es_sim_t *s)
{
    return (s->drive.setup == &s->drive.set[0].setup) ? &s->drive.set[0] : &s->drive.set[1];
}

static unsigned char *region(es_sim_t *s, int index, size_t *octets)
{
    switch (index) {
#define REGION(name, lvalue, doc)                                                                                                \
    case REGION_##name:                                                                                                          \
        *octets = sizeof(lvalue);                                                                                                \
        return (unsigned char *)(uintptr_t)&(lvalue); /* volatile or not */
#include "sim_host/capi/regions.def"
#undef REGION
    default:
        *octets = 0;
        return NULL;
    }
}

int es_sim_region_bits(es_sim_t *sim, int index)
{
    size_t octets = 0;
    if ((sim != NULL) && sim->started) {
        (void)region(sim, index, &octets);
    }
    return (int)(8U * octets);
}

bool es_sim_flip(es_sim_t *sim, int index, int bit)
{
    size_t octets = 0;
    if ((sim == NULL) || !sim->started) {
        return false;
    }
    unsigned char *const at = region(sim, index, &octets);
    if ((at == NULL) || (bit < 0) || (bit >= (int)(8U * octets))) {
        return false;
    }
    at[bit / 8] ^= (unsigned char)(1U << (bit % 8));
    return true;
}
