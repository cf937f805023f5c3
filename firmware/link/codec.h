/**
 * @file  firmware/link/codec.h
 * @brief Numbers to octets and back, little endian. An octet is the low 8 bits of a uint16_t: char has 16 bits on the chip.
 *
 * Total: writing beyond the end writes nothing and sets `over`, reading beyond it gives 0 and sets `over`.
 */
#ifndef FIRMWARE_LINK_CODEC_H
#define FIRMWARE_LINK_CODEC_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint16_t *octets;
    uint16_t  room, at;
    bool      over; /**< Something did not fit. */
} codec_writer_t;

typedef struct {
    const uint16_t *octets;
    uint16_t        count, at;
    bool            over; /**< More was wanted than there is. */
} codec_reader_t;

codec_writer_t codec_writer(uint16_t *octets, uint16_t room);
void           codec_put_u8(codec_writer_t *w, uint16_t x); /* the low 8 bits */
void           codec_put_u16(codec_writer_t *w, uint16_t x);
void           codec_put_u32(codec_writer_t *w, uint32_t x);
void           codec_put_f32(codec_writer_t *w, float x);
/** Length and characters; what is beyond 255 is cut. */
void codec_put_str(codec_writer_t *w, const char *text);

codec_reader_t codec_reader(const uint16_t *octets, uint16_t count);
uint16_t       codec_get_u8(codec_reader_t *r);
uint16_t       codec_get_u16(codec_reader_t *r);
uint32_t       codec_get_u32(codec_reader_t *r);
int32_t        codec_get_i32(codec_reader_t *r);
float          codec_get_f32(codec_reader_t *r); /* any bits: the caller judges NaN */

/** Bits of a float and back. */
uint32_t codec_bits(float x);
float    codec_float(uint32_t bits);

#endif
