#include "firmware/link/codec.h"

#define OCTET 0xFFU

typedef union {
    float    number;
    uint32_t bits;
} both_t; /* float has 32 bits, IEEE 754, on every machine that this runs on */

uint32_t codec_bits(float x)
{
    both_t both;
    both.number = x;
    return both.bits;
}

float codec_float(uint32_t bits)
{
    both_t both;
    both.bits = bits;
    return both.number;
}

codec_writer_t codec_writer(uint16_t *octets, uint16_t room)
{
    const codec_writer_t w = {octets, room, 0U, false};
    return w;
}

void codec_put_u8(codec_writer_t *w, uint16_t x)
{
    if (w->at < w->room) {
        w->octets[w->at] = x & OCTET;
        w->at++;
    } else {
        w->over = true;
    }
}

void codec_put_u16(codec_writer_t *w, uint16_t x)
{
    codec_put_u8(w, x & OCTET);
    codec_put_u8(w, x >> 8);
}

void codec_put_u32(codec_writer_t *w, uint32_t x)
{
    codec_put_u16(w, (uint16_t)(x & UINT32_C(0xFFFF)));
    codec_put_u16(w, (uint16_t)(x >> 16));
}

void codec_put_f32(codec_writer_t *w, float x) { codec_put_u32(w, codec_bits(x)); }

void codec_put_str(codec_writer_t *w, const char *text)
{
    uint16_t n = 0U;
    while ((n < OCTET) && (text[n] != '\0')) {
        n++;
    }
    codec_put_u8(w, n);
    for (uint16_t i = 0U; i < n; i++) {
        codec_put_u8(w, (uint16_t)text[i]);
    }
}

codec_reader_t codec_reader(const uint16_t *octets, uint16_t count)
{
    const codec_reader_t r = {octets, count, 0U, false};
    return r;
}

uint16_t codec_get_u8(codec_reader_t *r)
{
    if (r->at >= r->count) {
        r->over = true;
        return 0U;
    }
    const uint16_t x = r->octets[r->at] & OCTET;
    r->at++;
    return x;
}

uint16_t codec_get_u16(codec_reader_t *r)
{
    const uint16_t low = codec_get_u8(r);
    const uint16_t high = codec_get_u8(r);
    return (uint16_t)((uint16_t)(high << 8) | low); /* high is an octet: the shift stays inside 16 bits */
}

uint32_t codec_get_u32(codec_reader_t *r)
{
    const uint32_t low = codec_get_u16(r);
    const uint32_t high = codec_get_u16(r);
    return (high << 16) | low;
}

int32_t codec_get_i32(codec_reader_t *r)
{
    const uint32_t x = codec_get_u32(r);
    return (x <= (uint32_t)INT32_MAX) ? (int32_t)x : (-1 - (int32_t)(UINT32_MAX - x));
}

float codec_get_f32(codec_reader_t *r) { return codec_float(codec_get_u32(r)); }
