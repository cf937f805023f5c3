/**
 * @file  tests/target/cycles/services.c
 * @brief What the services of the bench link cost in the current interrupt and in a pass of the main loop.
 *
 * The signals are the dearest there are, so that a choice of a client costs no more.
 */
#include <stdint.h>
#include <string.h>

#include "firmware/app/telemetry.h"
#include "firmware/link/protocol.h"
#include "firmware/services/services.h"
#include "hal/hal_link.h"

extern uint64_t evenspin_cycles;

int services_cases(drive_t *drive, void (*note)(const char *name, uint64_t cost));

static services_t     services;
static drive_params_t defaults;
static float          capture[6140], black_box[2048];
static uint16_t       to_drive[8 * FRAME_WIRE_MAX];
static uint32_t       sent, taken;

uint16_t hal_link_read(uint16_t *octets, uint16_t limit)
{
    uint16_t n = 0U;
    while ((n < limit) && (taken < sent)) {
        octets[n++] = to_drive[taken++];
    }
    return n;
}
uint16_t hal_link_write(const uint16_t *octets, uint16_t count)
{
    (void)octets;
    return (count < 6U) ? count : 6U; /* as many as 625000 baud take in a period */
}
uint32_t hal_link_lost(void) { return 0U; }

static void measure(void (*note)(const char *name, uint64_t cost), const char *sample, const char *pass, uint32_t periods)
{
    for (uint32_t k = 0U; k < periods; k++) {
        uint64_t before = evenspin_cycles;
        services_sample(&services);
        if (sample != NULL) {
            note(sample, evenspin_cycles - before);
        }
        before = evenspin_cycles;
        services_pass(&services);
        note(pass, evenspin_cycles - before);
    }
}

static void ask(frame_t *f)
{
    sent = frame_end(f, to_drive);
    taken = 0U;
}

int services_cases(drive_t *drive, void (*note)(const char *name, uint64_t cost))
{
    static const uint16_t  DEAR[12] = {SIGNAL_rejected_count, SIGNAL_observer_innovation,
                                       SIGNAL_position_rad,   SIGNAL_position_ref_rad,
                                       SIGNAL_speed_rad_s,    SIGNAL_rc_period_samples,
                                       SIGNAL_compensation_a, SIGNAL_iq_a,
                                       SIGNAL_vq_v,           SIGNAL_id_a,
                                       SIGNAL_vd_v,           SIGNAL_robust_a};
    recorder_config_t      c = {{0U}, 8U, 1U, 100U, 100U, RECORDER_RISING, SIGNAL_rejected_count, 1.0e9f};
    frame_t                f;
    const services_setup_t setup = {drive, &defaults, "cycles", capture, black_box, 6140U, 2048U, HAL_RESET_POWER_UP};
    params_default(&defaults);
    services_start(&services, &setup);
    (void)memcpy(c.signal, DEAR, sizeof c.signal);

    measure(note, "services_sample black box", "services_pass idle", 2000U);
    stream_configure(&services.stream, DEAR, 8U, 10U, 0U);
    measure(note, "services_sample black box, stream of 8", "services_pass stream of 8", 4000U);
    recorder_start(&services.recorder[SERVICES_BLACK_BOX], &c);
    stream_configure(&services.stream, DEAR, 12U, 10U, 0U);
    recorder_start(&services.recorder[SERVICES_CAPTURE], &c);
    measure(note, "services_sample everything, dearest signals", "services_pass stream of 12", 4000U);

    frame_begin(&f, LINK_hello, 1U);
    codec_put_u16(&f.payload, LINK_VERSION);
    codec_put_u32(&f.payload, services.schema);
    ask(&f);
    measure(note, NULL, "services_pass hello", 200U);
    frame_begin(&f, LINK_set, 1U);
    codec_put_u8(&f.payload, 3U);
    codec_put_u8(&f.payload, 40U);
    for (uint16_t i = 0U; i < 40U; i++) {
        codec_put_u16(&f.payload, i);
        codec_put_f32(&f.payload, params_get(drive->params, i));
    }
    ask(&f);
    measure(note, NULL, "services_pass set of 40", 200U);
    frame_begin(&f, LINK_list, 1U);
    codec_put_u8(&f.payload, 0U);
    codec_put_u16(&f.payload, 0U);
    ask(&f);
    measure(note, NULL, "services_pass list", 200U);
    return 0;
}
