/* Stands in for crc_tbl.h of TI's compiler (SPRU513): the tables of check sums that the linker makes. */
#ifndef TESTS_HAL_FAKE_DRIVERLIB_CRC_TBL_H
#define TESTS_HAL_FAKE_DRIVERLIB_CRC_TBL_H

#include <stdint.h>

typedef struct crc_record {
    uint16_t crc_alg_ID, page_id;
    uint32_t addr, size; /* size in words of 16 bits */
    uint32_t crc_value;
} CRC_RECORD;

typedef struct crc_table {
    uint16_t   rec_size, num_recs;
    CRC_RECORD recs[1];
} CRC_TABLE;

#endif
