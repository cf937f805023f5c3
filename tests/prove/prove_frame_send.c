/* Frames that are sent: any payload, lengths 0, 31, ... 248; each octet has its place on the wire.
 * eva: -eva-precision 0 -eva-slevel 1 -eva-min-loop-unroll 256 */
#include "tests/prove/any.h"

#include "firmware/link/codec.c"
#include "firmware/link/crc.c"
#include "firmware/link/frame.c"

static void fill(void)
{
    static frame_t f;
    frame_begin(&f, any_u16(), any_u16());
    /*@ loop widen_hints f.payload.at, 247, 248; */
    while (any_bool()) {
        codec_put_u8(&f.payload, any_u16());
        codec_put_u16(&f.payload, any_u16());
        codec_put_u32(&f.payload, any_u32());
        codec_put_f32(&f.payload, any_float());
    }
    /*@ check the_payload_stays_inside: f.payload.at <= FRAME_PAYLOAD_MAX; */
}

void prove(void)
{
    static frame_t  f;
    static uint16_t wire[FRAME_WIRE_MAX];
    fill();
    frame_begin(&f, any_u16(), any_u16());
    /*@ loop unroll 9; */
    for (uint16_t length = 0U; length <= FRAME_PAYLOAD_MAX; length = (uint16_t)(length + 31U)) {
        f.payload.at = length;
        const uint16_t sent = frame_end(&f, wire);
        /*@ check the_wire_has_room: sent <= FRAME_WIRE_MAX; */
    }
}
