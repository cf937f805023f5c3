#include "firmware/link/crc.h"

/* Remainder of each nibble by 0x82F63B78, the reflected polynomial 0x1EDC6F41. */
static const uint32_t TABLE[16] = {UINT32_C(0x00000000), UINT32_C(0x105EC76F), UINT32_C(0x20BD8EDE), UINT32_C(0x30E349B1),
                                   UINT32_C(0x417B1DBC), UINT32_C(0x5125DAD3), UINT32_C(0x61C69362), UINT32_C(0x7198540D),
                                   UINT32_C(0x82F63B78), UINT32_C(0x92A8FC17), UINT32_C(0xA24BB5A6), UINT32_C(0xB21572C9),
                                   UINT32_C(0xC38D26C4), UINT32_C(0xD3D3E1AB), UINT32_C(0xE330A81A), UINT32_C(0xF36E6F75)};

uint32_t crc_octet(uint32_t c, uint16_t octet)
{
    uint32_t x = c ^ ((uint32_t)octet & 0xFFU);
    x = TABLE[x & 0xFU] ^ (x >> 4);
    return TABLE[x & 0xFU] ^ (x >> 4);
}

uint32_t crc_value(uint32_t c) { return c ^ UINT32_C(0xFFFFFFFF); }
