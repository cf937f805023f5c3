/**
 * @file  firmware/link/crc.h
 * @brief CRC-32/ISCSI (CRC-32C, Castagnoli): Hamming distance 6 up to 5243 bits (Koopman 2002, "32-bit cyclic redundancy codes
 *        for Internet applications"), so up to five wrong bits in a frame are always seen.
 *
 *     c = CRC_START; c = crc_octet(c, x) for each x; crc_value(c) is the check sum.
 *
 * Cost: two lookups in a table of 16.
 */
#ifndef FIRMWARE_LINK_CRC_H
#define FIRMWARE_LINK_CRC_H

#include <stdint.h>

#define CRC_START UINT32_C(0xFFFFFFFF)
/** What crc_octet holds after a message and its own check sum, least octet first. */
#define CRC_RESIDUE UINT32_C(0xB798B438)

uint32_t crc_octet(uint32_t c, uint16_t octet);
uint32_t crc_value(uint32_t c);

#endif
