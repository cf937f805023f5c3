#include "firmware/storage/store.h"

#include <stddef.h>

#include "firmware/link/crc.h"
#include "firmware/storage/format.h"

enum { PHASE_ERASE = 0, PHASE_WRITE, PHASE_READ_BACK, PHASE_COMMIT, PHASE_CONFIRM };

void store_reset(store_t *s)
{
    const store_t power_up = {.active = false};
    *s = power_up;
}

bool store_fits(uint16_t parameter_words, uint16_t table_words)
{
    const uint16_t words[STORE_PARTS] = {parameter_words, table_words};
    return (hal_storage_pages() >= 2U) && ((FIRST_AT + store_length(words)) <= hal_storage_page_words());
}

/* ---- begin ----------------------------------------------------------------------------------------------------------------- */

/* The newest set whose other part reads as it was saved, with the check sum of that part. */
static bool find_source(store_t *s, store_part_t other)
{
    uint32_t below = UINT32_MAX;
    while (store_find(below, NULL, NULL, &s->source).found) {
        if (store_read_part(&s->source, other, NULL, NULL, &s->wanted)) {
            (void)store_settle(&s->source); /* it may read as committed only now */
            return true;
        }
        below = s->source.sequence;
    }
    return false;
}

hal_status_t store_begin(store_t *s, store_part_t part, uint32_t tag, uint16_t words, store_give_t give, const void *from)
{
    const store_part_t other = (part == STORE_PARAMETERS) ? STORE_TABLE : STORE_PARAMETERS;
    store_set_t        newest;
    if (s->active) {
        return HAL_BUSY;
    }
    if ((part != STORE_PARAMETERS) && (part != STORE_TABLE)) {
        return HAL_UNSUPPORTED;
    }
    if (!store_fits((part == STORE_PARAMETERS) ? words : 0U, (part == STORE_TABLE) ? words : 0U)) {
        return HAL_UNSUPPORTED;
    }
    const store_found_t all = store_find(UINT32_MAX, NULL, NULL, &newest);
    if (all.found) { /* from here on the newest set does not depend on how its commit reads */
        const hal_status_t settled = store_settle(&newest);
        if (settled != HAL_OK) {
            return settled;
        }
    }
    const bool has_source = find_source(s, other);
    s->set.sequence = all.sequence + 1U;
    s->set.words[part] = words;
    s->set.words[other] = has_source ? s->source.words[other] : 0U;
    s->set.tag = (part == STORE_PARAMETERS) ? tag : (has_source ? s->source.tag : 0U);
    if (!store_fits(s->set.words[0], s->set.words[1])) {
        return HAL_UNSUPPORTED;
    }
    s->erases = all.erases;
    s->open = s->open && all.found && (newest.page == s->set.page) &&
              (((uint32_t)s->next_at + store_length(s->set.words)) <= hal_storage_page_words());
    if (s->open) {
        s->set.at = s->next_at;
    } else {
        const uint16_t others = (uint16_t)(hal_storage_pages() - 1U); /* the next, or after a failure the one behind it */
        const uint32_t from_page = all.found ? ((uint32_t)newest.page + 1U + (s->failures % others)) : s->failures;
        s->set.page = (uint16_t)(from_page % hal_storage_pages());
        s->set.at = FIRST_AT;
    }
    s->part = part;
    s->give = give;
    s->from = from;
    s->crc[0] = CRC_START;
    s->crc[1] = CRC_START;
    s->read_back[0] = CRC_START;
    s->read_back[1] = CRC_START;
    s->phase = s->open ? (uint16_t)PHASE_WRITE : (uint16_t)PHASE_ERASE;
    s->next = 0U;
    s->active = true;
    return HAL_OK;
}

/* ---- steps ----------------------------------------------------------------------------------------------------------------- */

static hal_status_t verified(uint16_t page, uint16_t at, const uint16_t block[BLOCK])
{
    uint16_t           found[BLOCK];
    const hal_status_t s = hal_storage_read(page, at, found, BLOCK);
    const bool same = (found[0] == block[0]) && (found[1] == block[1]) && (found[2] == block[2]) && (found[3] == block[3]);
    return (s != HAL_OK) ? s : (same ? HAL_OK : HAL_SENSOR_FAULT);
}

static hal_status_t write_block(uint16_t page, uint16_t at, const uint16_t block[BLOCK])
{
    const hal_status_t s = hal_storage_write(page, at, block, BLOCK);
    return (s == HAL_OK) ? verified(page, at, block) : s;
}

static hal_status_t erase(store_t *s)
{
    uint16_t     block[BLOCK];
    hal_status_t status = hal_storage_erase(s->set.page);
    store_make_page(block, s->erases + 1U);
    status = (status == HAL_OK) ? write_block(s->set.page, 0U, block) : status;
    s->phase = PHASE_WRITE;
    return status;
}

/* Word @p i of a part as it is to be saved: given, or from the source. */
static hal_status_t part_word(const store_t *s, store_part_t part, uint16_t i, uint16_t *word)
{
    if (part == s->part) {
        *word = s->give(s->from, i);
        return HAL_OK;
    }
    return hal_storage_read(s->source.page, (uint16_t)(store_part_at(&s->source, part) + i), word, 1U);
}

/* The block at an offset of the set, as it is to be saved; in which part it lies, and how many of its words are of it. */
static hal_status_t block_at(const store_t *s, uint16_t offset, uint16_t block[BLOCK], store_part_t *part, uint16_t *count)
{
    const uint16_t at = (uint16_t)(s->set.at + offset);
    *count = 0U;
    if (offset < HEAD_WORDS) {
        uint16_t head[HEAD_WORDS];
        store_make_head(head, &s->set);
        for (uint16_t i = 0U; i < BLOCK; i++) {
            block[i] = head[offset + i];
        }
        return HAL_OK;
    }
    if (at >= store_end_at(&s->set)) { /* the trailer */
        for (uint16_t k = 0U; k < STORE_PARTS; k++) {
            block[2U * k] = store_low(crc_value(s->crc[k]));
            block[(2U * k) + 1U] = store_high(crc_value(s->crc[k]));
        }
        return HAL_OK;
    }
    *part = (at < store_part_at(&s->set, STORE_TABLE)) ? STORE_PARAMETERS : STORE_TABLE;
    const uint16_t first = (uint16_t)(at - store_part_at(&s->set, *part));
    hal_status_t   status = HAL_OK;
    for (uint16_t i = 0U; i < BLOCK; i++) {
        block[i] = 0U; /* behind the end */
        if (((uint16_t)(first + i) < s->set.words[*part]) && (status == HAL_OK)) {
            status = part_word(s, *part, (uint16_t)(first + i), &block[i]);
            *count = (uint16_t)(i + 1U);
        }
    }
    return status;
}

/* Blocks from the head to the trailer, written and then read back. */
static hal_status_t write_body(store_t *s, bool back)
{
    const uint16_t body = (uint16_t)(store_end_at(&s->set) - s->set.at + BLOCK);
    uint16_t       block[BLOCK];
    hal_status_t   status = HAL_OK;
    for (uint16_t n = 0U; (n < STORE_BLOCKS_PER_STEP) && (s->next < body) && (status == HAL_OK); n++) {
        store_part_t   part = STORE_PARAMETERS;
        uint16_t       count = 0U;
        const uint16_t at = (uint16_t)(s->set.at + s->next);
        if (back && (s->next >= HEAD_WORDS) &&
            (at < store_end_at(&s->set))) { /* as it reads, against the sum of what was meant */
            part = (at < store_part_at(&s->set, STORE_TABLE)) ? STORE_PARAMETERS : STORE_TABLE;
            const uint16_t left = (uint16_t)(s->set.words[part] - (at - store_part_at(&s->set, part)));
            status = hal_storage_read(s->set.page, at, block, BLOCK);
            s->read_back[part] = store_crc(s->read_back[part], block, (left < BLOCK) ? left : BLOCK);
        } else {
            status = block_at(s, s->next, block, &part, &count);
            if (!back && (count > 0U)) {
                s->crc[part] = store_crc(s->crc[part], block, count);
            }
            status = (status != HAL_OK)
                         ? status
                         : (back ? verified(s->set.page, at, block) : hal_storage_write(s->set.page, at, block, BLOCK));
        }
        s->next = (uint16_t)(s->next + BLOCK);
    }
    if ((status == HAL_OK) && (s->next >= body)) {
        s->next = 0U;
        s->phase++;
        const store_part_t other = (s->part == STORE_PARAMETERS) ? STORE_TABLE : STORE_PARAMETERS;
        if (back && ((s->read_back[0] != s->crc[0]) || (s->read_back[1] != s->crc[1]))) {
            status = HAL_SENSOR_FAULT; /* a cell did not keep what was written */
        }
        if ((s->set.words[other] > 0U) && (crc_value(s->crc[other]) != s->wanted)) {
            status = HAL_SENSOR_FAULT; /* what was copied is not what had been saved */
        }
    }
    return status;
}

/* The commit and then the confirm: the same block twice. */
static hal_status_t seal(store_t *s)
{
    const uint32_t crc[STORE_PARTS] = {crc_value(s->crc[0]), crc_value(s->crc[1])};
    const uint16_t after = (s->phase == (uint16_t)PHASE_COMMIT) ? BLOCK : (uint16_t)(2U * BLOCK);
    uint16_t       block[BLOCK];
    store_make_commit(block, &s->set, crc);
    const hal_status_t status = write_block(s->set.page, (uint16_t)(store_end_at(&s->set) + after), block);
    s->phase++;
    if (after == BLOCK) {
        return status;
    }
    s->doubtful = status != HAL_OK; /* the commit stands, so the save is done */
    return HAL_OK;
}

hal_status_t store_step(store_t *s)
{
    if (!s->active) {
        return HAL_OK;
    }
    hal_status_t status;
    switch (s->phase) {
    case PHASE_ERASE:
        status = erase(s);
        break;
    case PHASE_WRITE:
    case PHASE_READ_BACK:
        status = write_body(s, s->phase == (uint16_t)PHASE_READ_BACK);
        break;
    default:
        status = seal(s);
        break;
    }
    if (status != HAL_OK) {
        s->active = false;
        s->failures++;
        s->open = false; /* what has failed stays behind: a fresh page */
    } else if (s->phase > (uint16_t)PHASE_CONFIRM) {
        s->active = false;
        s->open = !s->doubtful;
        s->next_at = (uint16_t)(s->set.at + store_length(s->set.words));
    } else {
        /* goes on */
    }
    return status;
}

/* ---- load ------------------------------------------------------------------------------------------------------------------ */

typedef struct {
    store_part_t part;
    uint32_t     tag;
    uint16_t     words;
} wanted_t;

static bool fits_wanted(const store_set_t *set, const void *wanted)
{
    const wanted_t *const w = (const wanted_t *)wanted;
    return (set->words[w->part] == w->words) && ((w->part != STORE_PARAMETERS) || (set->tag == w->tag));
}

hal_status_t store_load(const store_t *s, store_part_t part, uint32_t tag, uint16_t words, store_take_t take, void *to)
{
    const wanted_t wanted = {part, tag, words};
    hal_status_t   status = HAL_STALE;
    uint32_t       below = UINT32_MAX;
    store_set_t    set;
    if (s->active) {
        return HAL_BUSY;
    }
    if (!store_fits((part == STORE_PARAMETERS) ? words : 0U, (part == STORE_TABLE) ? words : 0U)) {
        return HAL_UNSUPPORTED;
    }
    while (store_find(below, fits_wanted, &wanted, &set).found) {
        uint32_t crc = 0U;
        if (store_read_part(&set, part, take, to, &crc)) {
            (void)store_settle(&set); /* so that it is the one at the next power-up, too */
            return HAL_OK;
        }
        status = HAL_SENSOR_FAULT;
        below = set.sequence;
    }
    return status;
}
