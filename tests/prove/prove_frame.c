/* The link's decoder: any octets (16 bits each) in any order, for ever; what is read of the frames.
 * eva: -eva-precision 3 -eva-slevel 0 */
#include "tests/prove/any.h"

#include "firmware/link/codec.c"
#include "firmware/link/crc.c"
#include "firmware/link/frame.c"

static void receive(void)
{
    static frame_decoder_t d;
    frame_decoder_reset(&d);
    /*@ loop widen_hints d.count, 253, 254; */
    while (any_bool()) {
        if (frame_decode(&d, any_u16()) == FRAME_GOOD) {
            codec_reader_t r = frame_payload(&d);
            (void)frame_type(&d);
            (void)frame_seq(&d);
            /*@ loop widen_hints r.at, 247, 248; */
            while (any_bool()) {
                (void)codec_get_u8(&r);
                (void)codec_get_u16(&r);
                (void)codec_get_i32(&r);
                (void)codec_get_f32(&r);
            }
        }
        /*@ check the_count_stays_inside: d.count <= FRAME_MAX; */
    }
}

void prove(void) { receive(); }
