#include "firmware/services/param_store.h"

#include "firmware/app/storage_map.h"
#include "firmware/link/codec.h"
#include "firmware/link/crc.h"
#include "hal/hal_storage.h"

#define SLOTS 2U
#define MAGIC UINT16_C(0xE52A)
enum { WORD_MAGIC = 0, WORD_SEQUENCE, WORD_SCHEMA_LOW, WORD_SCHEMA_HIGH, WORD_COUNT, WORD_CRC_LOW, WORD_CRC_HIGH, HEADER_WORDS };
#define WORDS (HEADER_WORDS + (2U * (uint16_t)PARAM_COUNT))

bool param_store_present(void) { return (hal_storage_pages() >= STORAGE_PARAMETER_PAGES) && (hal_storage_page_words() >= WORDS); }

static uint16_t page_of(uint16_t slot) { return (uint16_t)((hal_storage_pages() - STORAGE_PARAMETER_PAGES) + slot); }

static uint32_t crc_word(uint32_t c, uint16_t word) { return crc_octet(crc_octet(c, word & 0xFFU), word >> 8); }

static uint16_t low(uint32_t x) { return (uint16_t)(x & UINT32_C(0xFFFF)); }
static uint16_t high(uint32_t x) { return (uint16_t)(x >> 16); }

/* Two words a value: a float by its bits, whatever the kind of the parameter. */
static uint16_t value_word(const drive_params_t *p, uint16_t i)
{
    const uint32_t bits = codec_bits(params_get(p, i >> 1));
    return ((i & 1U) == 0U) ? low(bits) : high(bits);
}

static uint32_t crc_header(uint16_t sequence, uint32_t schema)
{
    uint32_t c = crc_word(CRC_START, sequence);
    c = crc_word(crc_word(c, low(schema)), high(schema));
    return crc_word(c, (uint16_t)PARAM_COUNT);
}

/* Check a slot. @return HAL_OK with its sequence, HAL_STALE when there is no good set, or an error of the storage. */
static hal_status_t inspect(uint16_t slot, uint32_t schema, uint16_t *sequence)
{
    uint16_t     head[HEADER_WORDS];
    hal_status_t s = hal_storage_read(page_of(slot), 0U, head, HEADER_WORDS);
    if (s != HAL_OK) {
        return s;
    }
    if ((head[WORD_MAGIC] != MAGIC) || (head[WORD_COUNT] != (uint16_t)PARAM_COUNT) || (head[WORD_SCHEMA_LOW] != low(schema)) ||
        (head[WORD_SCHEMA_HIGH] != high(schema))) {
        return HAL_STALE;
    }
    uint32_t c = crc_header(head[WORD_SEQUENCE], schema);
    for (uint16_t i = 0U; i < 2U * (uint16_t)PARAM_COUNT; i++) {
        uint16_t word = 0U;
        s = hal_storage_read(page_of(slot), (uint16_t)(HEADER_WORDS + i), &word, 1U);
        if (s != HAL_OK) {
            return s;
        }
        c = crc_word(c, word);
    }
    *sequence = head[WORD_SEQUENCE];
    return ((head[WORD_CRC_LOW] == low(c)) && (head[WORD_CRC_HIGH] == high(c))) ? HAL_OK : HAL_STALE;
}

/* Slot of the newest good set, or SLOTS. */
static uint16_t newest(uint32_t schema, uint16_t *sequence)
{
    uint16_t found = SLOTS;
    for (uint16_t slot = 0U; slot < SLOTS; slot++) {
        uint16_t n = 0U;
        if ((inspect(slot, schema, &n) == HAL_OK) && ((found == SLOTS) || ((uint16_t)(n - *sequence) < 0x8000U))) {
            found = slot;
            *sequence = n;
        }
    }
    return found;
}

hal_status_t param_store_begin(param_store_t *s, const drive_params_t *params, uint32_t schema)
{
    if (!param_store_present()) {
        return HAL_UNSUPPORTED;
    }
    if (s->active) {
        return HAL_BUSY;
    }
    uint16_t       sequence = 0U;
    const uint16_t last = newest(schema, &sequence);
    s->params = params;
    s->schema = schema;
    s->slot = (last == 0U) ? 1U : 0U;
    s->sequence = (uint16_t)(sequence + 1U);
    s->crc = crc_header(s->sequence, schema);
    s->next = 0U;
    s->erased = false;
    s->active = true;
    return HAL_OK;
}

/* Word `n` in the order of writing: values upwards, then the header downwards. */
static void word_at(param_store_t *s, uint16_t n, uint16_t *offset, uint16_t *word)
{
    const uint16_t values = (uint16_t)(2U * (uint16_t)PARAM_COUNT);
    if (n < values) {
        *offset = (uint16_t)(HEADER_WORDS + n);
        *word = value_word(s->params, n);
        s->crc = crc_word(s->crc, *word);
        return;
    }
    const uint16_t head[HEADER_WORDS] = {MAGIC, s->sequence, low(s->schema), high(s->schema), (uint16_t)PARAM_COUNT, low(s->crc), high(s->crc)};
    *offset = (uint16_t)((WORDS - 1U) - n);
    *word = head[*offset];
}

hal_status_t param_store_step(param_store_t *s)
{
    hal_status_t status = HAL_OK;
    if (!s->active) {
        return HAL_OK;
    }
    if (!s->erased) {
        status = hal_storage_erase(page_of(s->slot));
        s->erased = true;
    } else {
        for (uint16_t k = 0U; (k < PARAM_STORE_WORDS_PER_STEP) && (s->next < WORDS) && (status == HAL_OK); k++) {
            uint16_t offset = 0U;
            uint16_t word = 0U;
            word_at(s, s->next, &offset, &word);
            status = hal_storage_write(page_of(s->slot), offset, &word, 1U);
            s->next++;
        }
    }
    const bool done = s->next >= WORDS;
    s->active = (status == HAL_OK) && !done;
    if (status != HAL_OK) {
        return HAL_SENSOR_FAULT;
    }
    return done ? HAL_OK : HAL_BUSY;
}

hal_status_t param_store_load(drive_params_t *params, uint32_t schema)
{
    if (!param_store_present()) {
        return HAL_UNSUPPORTED;
    }
    uint16_t       sequence = 0U;
    const uint16_t slot = newest(schema, &sequence);
    if (slot == SLOTS) {
        return HAL_STALE;
    }
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        uint16_t           word[2] = {0U, 0U};
        const hal_status_t s = hal_storage_read(page_of(slot), (uint16_t)(HEADER_WORDS + (2U * i)), word, 2U);
        if (s != HAL_OK) {
            return s;
        }
        /* a value out of range cannot be: the check sum was good. Then the one in force stays. */
        (void)params_set(params, i, codec_float(((uint32_t)word[1] << 16) | word[0]));
    }
    return HAL_OK;
}
