#include "firmware/services/param_store.h"

#include <stddef.h>

#include "firmware/app/storage_map.h"
#include "firmware/link/codec.h"
#include "firmware/link/crc.h"
#include "hal/hal_storage.h"

#define SLOTS 2U
#define ATTEMPTS 3U /* a bit that does not read alike each time is no reason to fall back on the older set */
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

typedef struct {
    uint16_t word[HEADER_WORDS];
} header_t;

/* Read a header. @return HAL_OK, HAL_STALE when it is none of this schema, or an error of the storage. */
static hal_status_t read_header(uint16_t slot, uint32_t schema, header_t *head)
{
    const hal_status_t s = hal_storage_read(page_of(slot), 0U, head->word, HEADER_WORDS);
    if (s != HAL_OK) {
        return s;
    }
    const uint16_t *const w = head->word;
    const bool            ours = (w[WORD_MAGIC] == MAGIC) && (w[WORD_COUNT] == (uint16_t)PARAM_COUNT) &&
                                 (w[WORD_SCHEMA_LOW] == low(schema)) && (w[WORD_SCHEMA_HIGH] == high(schema));
    return ours ? HAL_OK : HAL_STALE;
}

/* Read the values behind a header, each once: what the check sum covers is what @p to gets, if anybody wants it. @return
 * whether they are what was saved; if not, @p to is spoiled. */
static bool read_values(uint16_t slot, uint32_t schema, const header_t *head, drive_params_t *to)
{
    uint32_t c = crc_header(head->word[WORD_SEQUENCE], schema);
    bool     fit = true;
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        uint16_t           word[2] = {0U, 0U};
        const hal_status_t s = hal_storage_read(page_of(slot), (uint16_t)(HEADER_WORDS + (2U * i)), word, 2U);
        c = crc_word(crc_word(c, word[0]), word[1]);
        fit = fit && (s == HAL_OK) && ((to == NULL) || params_set(to, i, codec_float(((uint32_t)word[1] << 16) | word[0])));
    }
    return fit && (head->word[WORD_CRC_LOW] == low(c)) && (head->word[WORD_CRC_HIGH] == high(c));
}

/* Whether slot @p a is the newer one of two good headers. */
static bool is_newer(const header_t *a, const header_t *b)
{
    return (uint16_t)(a->word[WORD_SEQUENCE] - b->word[WORD_SEQUENCE]) < 0x8000U;
}

/* The newest set that reads as it was saved: its slot, sequence and values. @return HAL_OK; HAL_STALE: there is none;
 * HAL_SENSOR_FAULT: there is one, and it cannot be read, @p to is spoiled. */
static hal_status_t read_newest(uint32_t schema, uint16_t *found, uint16_t *sequence, drive_params_t *to)
{
    header_t       head[SLOTS];
    const bool     there[SLOTS] = {read_header(0U, schema, &head[0]) == HAL_OK, read_header(1U, schema, &head[1]) == HAL_OK};
    const uint16_t first = (there[1] && (!there[0] || is_newer(&head[1], &head[0]))) ? 1U : 0U;
    for (uint16_t k = 0U; k < SLOTS; k++) {
        const uint16_t slot = first ^ k;
        for (uint16_t attempt = 0U; there[slot] && (attempt < ATTEMPTS); attempt++) {
            if (read_values(slot, schema, &head[slot], to)) {
                *found = slot;
                *sequence = head[slot].word[WORD_SEQUENCE];
                return HAL_OK;
            }
        }
    }
    return (there[0] || there[1]) ? HAL_SENSOR_FAULT : HAL_STALE;
}

hal_status_t param_store_begin(param_store_t *s, const drive_params_t *params, uint32_t schema)
{
    if (!param_store_present()) {
        return HAL_UNSUPPORTED;
    }
    if (s->active) {
        return HAL_BUSY;
    }
    uint16_t sequence = 0U;
    uint16_t last = SLOTS;
    (void)read_newest(schema, &last, &sequence, NULL);
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
static uint16_t offset_of(uint16_t n)
{
    const uint16_t values = (uint16_t)(2U * (uint16_t)PARAM_COUNT);
    return (n < values) ? (uint16_t)(HEADER_WORDS + n) : (uint16_t)((WORDS - 1U) - n);
}

/* What belongs there; the check sum has to be that of all values when it is asked for. */
static uint16_t word_at(const param_store_t *s, uint16_t offset)
{
    const uint16_t head[HEADER_WORDS] = {MAGIC,       s->sequence, low(s->schema), high(s->schema), (uint16_t)PARAM_COUNT,
                                         low(s->crc), high(s->crc)};
    return (offset < HEADER_WORDS) ? head[offset] : value_word(s->params, (uint16_t)(offset - HEADER_WORDS));
}

/* One word of the save: everything but the first word of the header is written, then read back and compared, and only then
 * the first word makes the set exist, which is read back as well. */
static hal_status_t do_word(param_store_t *s)
{
    const uint16_t body = WORDS - 1U;
    const bool     writes = (s->next < body) || (s->next == (2U * body));
    const uint16_t n = (s->next < body) ? s->next : ((s->next < (2U * body)) ? (uint16_t)(s->next - body) : body);
    const uint16_t offset = offset_of(n);
    const uint16_t word = word_at(s, offset);
    s->next++;
    if (writes) {
        if (offset >= HEADER_WORDS) {
            s->crc = crc_word(s->crc, word);
        }
        return hal_storage_write(page_of(s->slot), offset, &word, 1U);
    }
    uint16_t           found = 0U;
    const hal_status_t status = hal_storage_read(page_of(s->slot), offset, &found, 1U);
    return ((status == HAL_OK) && (found != word)) ? HAL_SENSOR_FAULT : status;
}

hal_status_t param_store_step(param_store_t *s)
{
    const uint16_t all = 2U * WORDS;
    hal_status_t   status = HAL_OK;
    if (!s->active) {
        return HAL_OK;
    }
    if (!s->erased) {
        status = hal_storage_erase(page_of(s->slot));
        s->erased = true;
    } else {
        for (uint16_t k = 0U; (k < PARAM_STORE_WORDS_PER_STEP) && (s->next < all) && (status == HAL_OK); k++) {
            status = do_word(s);
        }
    }
    const bool done = s->next >= all;
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
    uint16_t sequence = 0U;
    uint16_t slot = SLOTS;
    return read_newest(schema, &slot, &sequence, params);
}
