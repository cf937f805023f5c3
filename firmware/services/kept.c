/* What the run before a reset has left in the memory of the services and of the black box, which the C start-up of a board does not
 * clear. After power-up that memory holds anything: it is believed only with its mark, a check sum over what says how to read it, and
 * never when the board says that it was just switched on. */
#include <string.h>

#include "firmware/link/crc.h"
#include "firmware/services/internal.h"
#include "firmware/services/schema.h"

#define MAGIC UINT32_C(0x5EB0C4A7)
#define RESETS_MAX 255U

static uint32_t add(uint32_t c, uint32_t x)
{
    uint32_t next = c;
    for (uint16_t k = 0U; k < 4U; k++) {
        next = crc_octet(next, (uint16_t)((x >> (8U * k)) & 0xFFU));
    }
    return next;
}

static uint32_t sum_of(const services_t *s, uint32_t schema)
{
    const recorder_t *const        r = &s->recorder[SERVICES_BLACK_BOX];
    const recorder_config_t *const c = &r->config;
    const services_past_t *const   p = &s->past;
    const uint32_t                 word[] = {schema,
                                             (uint32_t)sizeof *s,
                                             r->values,
                                             r->end,
                                             r->number,
                                             c->count,
                                             c->decimation,
                                             c->pre,
                                             c->post,
                                             r->after,
                                             (uint32_t)c->trigger,
                                             (uint32_t)p->rows,
                                             p->resets,
                                             (uint32_t)p->fault,
                                             p->detail,
                                             (uint32_t)p->state,
                                             p->counter};
    uint32_t                       sum = CRC_START;
    for (uint16_t i = 0U; i < (uint16_t)(sizeof(word) / sizeof(word[0])); i++) {
        sum = add(sum, word[i]);
    }
    for (uint16_t i = 0U; i < RECORDER_SIGNALS; i++) {
        sum = add(sum, c->signal[i]);
    }
    return crc_value(sum);
}

void services_mark(services_t *s)
{
    s->mark.magic = MAGIC;
    s->mark.number = s->recorder[SERVICES_BLACK_BOX].number;
    s->mark.sum = sum_of(s, s->schema);
}

void services_attend_mark(services_t *s)
{
    if (s->mark.number != s->recorder[SERVICES_BLACK_BOX].number) { /* it records again */
        s->past.rows = false;
        services_mark(s);
    }
}

/* Nothing was recorded since an earlier reset: what is known of the run before that stays. */
static services_past_t past_of(const services_t *s)
{
    services_past_t past = s->past;
    if (!past.rows) {
        past.rows = true;
        past.resets = 0U;
        past.fault = ((uint16_t)s->found.fault < (uint16_t)FAULT_COUNT) ? s->found.fault : FAULT_none;
        past.detail = s->found.detail;
        past.state = ((unsigned)s->seen_state < (unsigned)DRIVE_STATES) ? s->seen_state : DRIVE_INIT;
        past.counter = s->counter;
    }
    past.resets = (uint16_t)((past.resets < RESETS_MAX) ? (past.resets + 1U) : RESETS_MAX);
    return past;
}

void services_take_kept(services_t *s, const services_setup_t *setup)
{
    const uint32_t    schema = schema_hash();
    recorder_t *const box = &s->recorder[SERVICES_BLACK_BOX];
    services_past_t   past = {0};
    const bool kept = (setup->reset != HAL_RESET_POWER_UP) && (s->mark.magic == MAGIC) && (s->mark.sum == sum_of(s, schema)) &&
                      recorder_revive(box, setup->black_box, setup->black_box_values, s->counter);
    recorder_t rows = {0};
    if (kept) {
        past = past_of(s);
        rows = *box;
    }
    (void)memset(s, 0, sizeof *s); /* zero bits are 0, 0.0f, NULL and false on every machine that runs this */
    s->schema = schema;
    recorder_init(box, setup->black_box, setup->black_box_values);
    if (kept) {
        s->past = past;
        *box = rows;
    }
}
