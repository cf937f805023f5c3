/**
 * @file  firmware/storage/format.h
 * @brief How a set lies in a page: between store.c, which writes, and find.c, which reads.
 */
#ifndef FIRMWARE_STORAGE_FORMAT_H
#define FIRMWARE_STORAGE_FORMAT_H

#include "firmware/storage/store.h"

#define BLOCK HAL_STORAGE_BLOCK_WORDS
#define HEAD_WORDS (2U * BLOCK)
#define END_WORDS (3U * BLOCK) /* trailer, commit, confirm */
#define FIRST_AT BLOCK         /* behind the block of the page itself */
#define MAGIC_PAGE UINT16_C(0xE5A6)
#define MAGIC_HEAD UINT16_C(0xE5B1)
#define MAGIC_COMMIT UINT16_C(0xE5C3)

static inline uint16_t store_low(uint32_t x) { return (uint16_t)(x & UINT32_C(0xFFFF)); }
static inline uint16_t store_high(uint32_t x) { return (uint16_t)(x >> 16); }
static inline uint32_t store_long(uint16_t low, uint16_t high) { return ((uint32_t)high << 16) | low; }
static inline uint32_t store_padded(uint16_t words) { return ((uint32_t)words + (BLOCK - 1U)) & ~(uint32_t)(BLOCK - 1U); }

/* find.c */
uint32_t store_crc(uint32_t c, const uint16_t *words, uint16_t count);
uint32_t store_length(const uint16_t words[STORE_PARTS]); /* of a whole set */
uint16_t store_part_at(const store_set_t *set, store_part_t part);
uint16_t store_end_at(const store_set_t *set); /* of the trailer */
void     store_make_page(uint16_t block[BLOCK], uint32_t erases);
void     store_make_head(uint16_t head[HEAD_WORDS], const store_set_t *set);
void     store_make_commit(uint16_t block[BLOCK], const store_set_t *set, const uint32_t crc[STORE_PARTS]);

/** What the pages hold. */
typedef struct {
    uint32_t sequence; /* the highest of any head, committed or not */
    uint32_t erases;   /* the highest of any page */
    bool     found;
} store_found_t;

/* The newest committed set below a number that @p fits (NULL: any). */
typedef bool (*store_fits_t)(const store_set_t *set, const void *wanted);
store_found_t store_find(uint32_t below, store_fits_t fits, const void *wanted, store_set_t *set);
/* Read one part of a set, each word once. @return whether it reads as it was saved; @p crc: its check sum. */
bool store_read_part(const store_set_t *set, store_part_t part, store_take_t take, void *to, uint32_t *crc);
/* Its confirm, where only the commit is there. */
hal_status_t store_settle(const store_set_t *set);

#endif
