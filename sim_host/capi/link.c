/* The bench link and the non-volatile storage of the simulated drive. */
#include <string.h>

#include "sim_host/capi/sim.h"

bool es_sim_link_open(es_sim_t *sim)
{
    if (sim == NULL) {
        return false;
    }
    if (sim->started) {
        return capi_refuse(&sim->error, ES_STARTED, "param", "link", 1.0);
    }
    sim->linked = true;
    return true;
}

int es_sim_link_write(es_sim_t *sim, const uint8_t *octets, int count)
{
    if ((sim == NULL) || (octets == NULL) || !sim->linked || !sim->started) {
        return 0;
    }
    sim_pipe_t *const p = &sim->board.to_drive;
    int               n = 0;
    while ((n < count) && ((p->head - p->tail) < SIM_LINK_OCTETS)) {
        p->octet[p->head++ % SIM_LINK_OCTETS] = octets[n++];
    }
    return n;
}

int es_sim_link_read(es_sim_t *sim, uint8_t *octets, int room)
{
    if ((sim == NULL) || (octets == NULL) || !sim->linked || !sim->started) {
        return 0;
    }
    sim_pipe_t *const p = &sim->board.from_drive;
    int               n = 0;
    while ((n < room) && (p->tail != p->head)) {
        octets[n++] = (uint8_t)p->octet[p->tail++ % SIM_LINK_OCTETS];
    }
    return n;
}

bool es_sim_reset(es_sim_t *sim, int cause)
{
    if ((sim == NULL) || !sim->linked || !sim->started || (cause < 0) || (cause > (int)HAL_RESET_OTHER)) {
        return false;
    }
    sim_board_reset(&sim->board, (hal_reset_t)cause);
    if (cause == (int)HAL_RESET_POWER_UP) { /* memory comes up with anything */
        memset(&sim->services, 0xA5, sizeof sim->services);
        memset(sim->black_box, 0xA5, sizeof sim->black_box);
    }
    capi_call_services(sim);
    return true;
}

int es_sim_storage_read(const es_sim_t *sim, uint16_t *words, int room)
{
    const int all = SIM_STORAGE_PAGES * SIM_STORAGE_WORDS;
    if ((sim != NULL) && (words != NULL)) {
        memcpy(words, sim->board.storage, (size_t)((room < 0) ? 0 : ((room < all) ? room : all)) * sizeof words[0]);
    }
    return all;
}

bool es_sim_storage_write(es_sim_t *sim, const uint16_t *words, int count)
{
    if ((sim == NULL) || (words == NULL)) {
        return false;
    }
    const int all = SIM_STORAGE_PAGES * SIM_STORAGE_WORDS;
    if (count != all) { /* written as a whole */
        return capi_refuse_range(&sim->error, ES_NOT_WHOLE, "param", "storage", (double)count, all, all, "word");
    }
    memcpy(sim->board.storage, words, (size_t)count * sizeof words[0]);
    sim->storage_kept = true;
    return true;
}
