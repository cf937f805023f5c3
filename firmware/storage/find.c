/* What stands in the pages: heads, commits, check sums. Everything is read once and judged by what was read. */
#include <stddef.h>

#include "firmware/link/crc.h"
#include "firmware/storage/format.h"

#define ATTEMPTS 3U /* a bit that reads 0 once and 1 once is no reason to fall back on the older set */
/* After a commit was read once: whoever has taken it has to get it again. */
#define SETTLE_ATTEMPTS 20U

uint32_t store_crc(uint32_t c, const uint16_t *words, uint16_t count)
{
    for (uint16_t i = 0U; i < count; i++) {
        c = crc_octet(crc_octet(c, words[i] & 0xFFU), words[i] >> 8);
    }
    return c;
}

uint32_t store_length(const uint16_t words[STORE_PARTS])
{
    return HEAD_WORDS + store_padded(words[0]) + store_padded(words[1]) + END_WORDS;
}

uint16_t store_part_at(const store_set_t *set, store_part_t part)
{
    const uint32_t before = (part == STORE_TABLE) ? store_padded(set->words[0]) : 0U;
    return (uint16_t)(set->at + HEAD_WORDS + before);
}

uint16_t store_end_at(const store_set_t *set) { return (uint16_t)(set->at + store_length(set->words) - END_WORDS); }

static uint16_t check_of(const uint16_t *words, uint16_t count)
{
    return store_low(crc_value(store_crc(CRC_START, words, count)));
}

void store_make_page(uint16_t block[BLOCK], uint32_t erases)
{
    block[0] = MAGIC_PAGE;
    block[1] = store_low(erases);
    block[2] = store_high(erases);
    block[3] = check_of(block, 3U);
}

void store_make_head(uint16_t head[HEAD_WORDS], const store_set_t *set)
{
    head[0] = MAGIC_HEAD;
    head[1] = store_low(set->sequence);
    head[2] = store_high(set->sequence);
    head[3] = set->words[0];
    head[4] = set->words[1];
    head[5] = store_low(set->tag);
    head[6] = store_high(set->tag);
    head[7] = check_of(head, 7U);
}

static void make_trailer(uint16_t block[BLOCK], const uint32_t crc[STORE_PARTS])
{
    for (uint16_t k = 0U; k < STORE_PARTS; k++) {
        block[2U * k] = store_low(crc[k]);
        block[(2U * k) + 1U] = store_high(crc[k]);
    }
}

void store_make_commit(uint16_t block[BLOCK], const store_set_t *set, const uint32_t crc[STORE_PARTS])
{
    uint16_t covered[HEAD_WORDS];
    store_make_head(covered, set);
    uint32_t c = store_crc(CRC_START, covered, HEAD_WORDS);
    make_trailer(block, crc);
    c = crc_value(store_crc(c, block, BLOCK));
    block[0] = MAGIC_COMMIT;
    block[1] = store_low(set->sequence);
    block[2] = store_low(c);
    block[3] = store_high(c);
}

static bool read_head(uint16_t page, uint16_t at, store_set_t *set)
{
    uint16_t head[HEAD_WORDS];
    for (uint16_t attempt = 0U; attempt < ATTEMPTS; attempt++) {
        const hal_status_t s = hal_storage_read(page, at, head, HEAD_WORDS);
        if ((s == HAL_OK) && (head[0] == MAGIC_HEAD) && (head[7] == check_of(head, 7U))) {
            set->sequence = store_long(head[1], head[2]);
            set->words[0] = head[3];
            set->words[1] = head[4];
            set->tag = store_long(head[5], head[6]);
            set->page = page;
            set->at = at;
            return ((uint32_t)at + store_length(set->words)) <= hal_storage_page_words();
        }
        if ((s == HAL_OK) && (head[0] == UINT16_MAX)) {
            return false; /* erased: seven bits of the magic number cannot all be misread */
        }
    }
    return false;
}

static bool same_block(const uint16_t *a, const uint16_t *b)
{
    return (a[0] == b[0]) && (a[1] == b[1]) && (a[2] == b[2]) && (a[3] == b[3]);
}

/* The end of a set as it reads now. @return whether it is committed. */
static bool read_end(const store_set_t *set, uint32_t crc[STORE_PARTS], bool *confirmed, bool *blank)
{
    static const uint16_t BLANK[BLOCK] = {UINT16_MAX, UINT16_MAX, UINT16_MAX, UINT16_MAX};
    uint16_t              end[BLOCK];
    uint16_t              wanted[BLOCK];
    const uint16_t        at = store_end_at(set);
    for (uint16_t attempt = 0U; attempt < ATTEMPTS; attempt++) {
        if (hal_storage_read(set->page, at, end, BLOCK) != HAL_OK) {
            continue;
        }
        crc[0] = store_long(end[0], end[1]);
        crc[1] = store_long(end[2], end[3]);
        store_make_commit(wanted, set, crc);
        const bool committed =
            (hal_storage_read(set->page, (uint16_t)(at + BLOCK), end, BLOCK) == HAL_OK) && same_block(end, wanted);
        const bool read = hal_storage_read(set->page, (uint16_t)(at + (2U * BLOCK)), end, BLOCK) == HAL_OK;
        *confirmed = read && same_block(end, wanted);
        *blank = read && same_block(end, BLANK);
        if (committed || *confirmed) {
            return true;
        }
    }
    return false;
}

static bool is_committed(const store_set_t *set)
{
    uint32_t crc[STORE_PARTS];
    bool     confirmed = false;
    bool     blank = false;
    return read_end(set, crc, &confirmed, &blank);
}

store_found_t store_find(uint32_t below, store_fits_t fits, const void *wanted, store_set_t *set)
{
    store_found_t  found = {0U, 0U, false};
    const uint16_t words = hal_storage_page_words();
    for (uint16_t page = 0U; page < hal_storage_pages(); page++) {
        uint16_t begin[BLOCK];
        if ((hal_storage_read(page, 0U, begin, BLOCK) == HAL_OK) && (begin[0] == MAGIC_PAGE) &&
            (begin[3] == check_of(begin, 3U))) {
            const uint32_t erases = store_long(begin[1], begin[2]);
            found.erases = (erases > found.erases) ? erases : found.erases;
        }
        uint32_t at = FIRST_AT;
        while ((at + HEAD_WORDS + END_WORDS) <= words) {
            store_set_t here;
            if (!read_head(page, (uint16_t)at, &here)) {
                at += BLOCK; /* erased, or a head that does not read: what stands behind it still counts */
                continue;
            }
            at += store_length(here.words);
            found.sequence = (here.sequence > found.sequence) ? here.sequence : found.sequence;
            if ((here.sequence < below) && (!found.found || (here.sequence > set->sequence)) &&
                ((fits == NULL) || fits(&here, wanted)) && is_committed(&here)) {
                *set = here;
                found.found = true;
            }
        }
    }
    return found;
}

bool store_read_part(const store_set_t *set, store_part_t part, store_take_t take, void *to, uint32_t *crc)
{
    for (uint16_t attempt = 0U; attempt < ATTEMPTS; attempt++) {
        uint32_t wanted[STORE_PARTS];
        uint32_t c = CRC_START;
        bool     confirmed = false;
        bool     blank = false;
        bool     good = read_end(set, wanted, &confirmed, &blank);
        for (uint16_t i = 0U; (i < set->words[part]) && good; i++) {
            uint16_t word = 0U;
            good = hal_storage_read(set->page, (uint16_t)(store_part_at(set, part) + i), &word, 1U) == HAL_OK;
            c = store_crc(c, &word, 1U);
            if (take != NULL) {
                take(to, i, word);
            }
        }
        *crc = crc_value(c);
        if (good && (*crc == wanted[part])) {
            return true;
        }
    }
    return false;
}

hal_status_t store_settle(const store_set_t *set)
{
    uint32_t crc[STORE_PARTS];
    uint16_t block[BLOCK];
    bool     confirmed = false;
    bool     blank = false;
    bool     committed = false;
    for (uint16_t k = 0U; (k < SETTLE_ATTEMPTS) && !committed; k++) {
        committed = read_end(set, crc, &confirmed, &blank);
    }
    if (!committed || confirmed || !blank) {
        return HAL_OK; /* a confirm that was begun shows, too, that the commit had been finished */
    }
    store_make_commit(block, set, crc);
    return hal_storage_write(set->page, (uint16_t)(store_end_at(set) + (2U * BLOCK)), block, BLOCK);
}
