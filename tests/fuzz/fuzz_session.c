/* libFuzzer: the services of the drive on anything that a client may send.
 *
 * Input: a row of steps, each an octet and what belongs to it.
 *   0..127    a request of this type: octet length, payload; framed and with the right check sum
 *   128..191  (step - 127) octets, raw
 *   192..253  (step - 191) x 8 periods
 *   254       the storage fails from here on, or works again
 *   255       hello with the right schema
 *
 * Holds for every input: what the drive says are frames; every request is answered or refused, once; a client without the schema
 * changes no parameter and starts nothing; duties are inside [0, 1]; a pass takes few octets. */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "firmware/link/protocol.h"
#include "firmware/services/services.h"
#include "hal/hal_clock.h"
#include "hal/hal_inverter.h"
#include "hal/hal_limits.h"
#include "hal/hal_link.h"
#include "hal/hal_storage.h"

#define PAGES 4U
#define WORDS 512U
#define ROOM 8192U

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static drive_t         drive;
static services_t      services;
static drive_params_t  defaults;
static float           capture[300], black_box[200];
static frame_decoder_t listener;
static uint8_t         to_drive[ROOM];
static size_t          sent, taken;
static uint32_t        clock_cyc, seq, answers, requests;
static uint16_t        taken_in_pass;
static bool            armed, storage_fails, speed_wanted;
static uint16_t        storage[PAGES][WORDS];

static void must(bool holds)
{
    if (!holds) {
        abort();
    }
}

/* ---- the board --------------------------------------------------------------------------------------------------------- */

hal_status_t hal_sample_read(hal_sample_t *out)
{
    const hal_sample_t s = {0.1f, -0.2f, 0.1f, 24.0f, UINT32_C(683565276), 0U, ++seq};
    *out = s;
    return HAL_OK;
}
hal_status_t hal_encoder_edge(hal_encoder_edge_t *out)
{
    memset(out, 0, sizeof *out);
    return HAL_OK;
}
hal_status_t hal_inverter_set_duty(const hal_duty_t *duty)
{
    must((duty->a >= 0.0f) && (duty->a <= 1.0f) && (duty->b >= 0.0f) && (duty->b <= 1.0f) && (duty->c >= 0.0f) &&
         (duty->c <= 1.0f));
    return HAL_OK;
}
hal_status_t hal_inverter_arm(void)
{
    armed = true;
    return HAL_OK;
}
void                 hal_inverter_disarm(void) { armed = false; }
hal_inverter_fault_t hal_inverter_fault(void) { return HAL_INVERTER_FINE; }
void                 hal_inverter_clear_fault(void) {}
uint32_t             hal_clock_cyc(void) { return clock_cyc; }
uint32_t             hal_clock_hz(void) { return 200000000U; }
void                 hal_clock_request_speed_isr(void) { speed_wanted = true; }
uint32_t             hal_link_lost(void) { return 0U; }

uint16_t hal_link_read(uint16_t *octets, uint16_t limit)
{
    uint16_t n = 0U;
    while ((n < limit) && (taken < sent)) {
        octets[n++] = to_drive[taken++];
    }
    taken_in_pass = (uint16_t)(taken_in_pass + n);
    return n;
}

uint16_t hal_link_write(const uint16_t *octets, uint16_t count)
{
    for (uint16_t i = 0U; i < count; i++) {
        must(octets[i] <= 0xFFU);
        const frame_event_t e = frame_decode(&listener, octets[i]);
        must(e != FRAME_DROPPED);
        if ((e == FRAME_GOOD) && (frame_type(&listener) >= 0x80U)) {
            answers++;
        }
    }
    return count;
}

hal_status_t hal_temperature(hal_temperature_t which, float *celsius)
{
    (void)which;
    *celsius = 25.0f;
    return HAL_OK;
}
uint16_t     hal_sto(void) { return 0U; }
void         hal_brake_duty(float duty) { (void)duty; }
void         hal_limits(hal_limits_t *out) { *out = (hal_limits_t){20.0f, 40.0f, 2000.0f, 1.0f, 0.0f, true}; }
uint16_t     hal_storage_pages(void) { return PAGES; }
uint16_t     hal_storage_page_words(void) { return WORDS; }
hal_status_t hal_storage_read(uint16_t page, uint16_t offset, uint16_t *words, uint16_t count)
{
    must((page < PAGES) && ((uint32_t)offset + count <= WORDS));
    memcpy(words, &storage[page][offset], count * sizeof words[0]);
    return storage_fails ? HAL_SENSOR_FAULT : HAL_OK;
}
hal_status_t hal_storage_write(uint16_t page, uint16_t offset, const uint16_t *words, uint16_t count)
{
    must((page < PAGES) && ((uint32_t)offset + count <= WORDS));
    must(((offset % HAL_STORAGE_BLOCK_WORDS) == 0U) && ((count % HAL_STORAGE_BLOCK_WORDS) == 0U));
    for (uint16_t i = 0U; i < count; i++) {
        storage[page][offset + i] &= words[i];
    }
    return storage_fails ? HAL_BUSY : HAL_OK;
}
hal_status_t hal_storage_erase(uint16_t page)
{
    must(page < PAGES);
    memset(storage[page], 0xFF, sizeof storage[page]);
    return storage_fails ? HAL_BUSY : HAL_OK;
}

/* ---- steps --------------------------------------------------------------------------------------------------------------- */

static void period(void)
{
    clock_cyc += 20000U;
    drive_current_isr(&drive);
    drive_watch_isr(&drive);
    if (speed_wanted) {
        speed_wanted = false;
        drive_speed_isr(&drive);
    }
    services_sample(&services);
    drive_background(&drive);
    taken_in_pass = 0U;
    services_pass(&services);
    must(taken_in_pass <= SERVICES_OCTETS_PER_PASS);
}

static void put(uint16_t octet)
{
    if (sent < ROOM) {
        to_drive[sent++] = (uint8_t)octet;
    }
}

static void ask(uint16_t type, const uint8_t *payload, size_t count)
{
    static frame_t  f;
    static uint16_t wire[FRAME_WIRE_MAX];
    frame_begin(&f, type, requests);
    for (size_t i = 0; i < count; i++) {
        codec_put_u8(&f.payload, payload[i]);
    }
    const uint16_t n = frame_end(&f, wire);
    if ((n == 0U) || (sent + n + 1U > ROOM)) {
        return;
    }
    put(0U); /* whatever stood there before */
    for (uint16_t i = 0U; i < n; i++) {
        put(wire[i]);
    }
    requests++;
}

static void hello(void)
{
    const uint8_t payload[6] = {1U,
                                0U,
                                (uint8_t)services.schema,
                                (uint8_t)(services.schema >> 8),
                                (uint8_t)(services.schema >> 16),
                                (uint8_t)(services.schema >> 24)};
    ask(LINK_hello, payload, 6U);
}

static bool defaults_in_force(void)
{
    for (uint16_t i = 0U; i < (uint16_t)PARAM_COUNT; i++) {
        if (params_get(drive.params, i) != params_get(&defaults, i)) {
            return false;
        }
    }
    return true;
}

static void power_up(void)
{
    const services_setup_t setup = {&drive, &defaults, "fuzz", capture, black_box, 300U, 200U, HAL_RESET_POWER_UP};
    memset(storage, 0xFF, sizeof storage);
    sent = 0U;
    taken = 0U;
    clock_cyc = 0U;
    seq = 0U;
    answers = 0U;
    requests = 0U;
    storage_fails = false;
    speed_wanted = false;
    params_default(&defaults);
    defaults.offset_calibration_periods = 0U;
    defaults.align_periods = 0U;
    frame_decoder_reset(&listener);
    services_start(&services, &setup);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bool   known = false; /* the client may have shown the schema */
    bool   raw = false;   /* it may have said anything: answers cannot be counted */
    size_t at = 0U;
    power_up();
    while (at < size) {
        const uint16_t step = data[at++];
        if (step < 128U) {
            const size_t want = (at < size) ? data[at++] : 0U;
            const size_t have = (want < size - at) ? want : (size - at);
            known = known || ((step == LINK_hello) && (have == 6U));
            ask(step, &data[at], (have < FRAME_PAYLOAD_MAX) ? have : FRAME_PAYLOAD_MAX);
            at += have;
        } else if (step < 192U) {
            for (uint16_t i = 0U; (i < step - 127U) && (at < size); i++) {
                put(data[at++]);
            }
            raw = true;
        } else if (step < 254U) {
            for (uint16_t i = 0U; i < (step - 191U) * 8U; i++) {
                period();
            }
        } else if (step == 254U) {
            storage_fails = !storage_fails;
        } else {
            hello();
            known = true;
        }
    }
    for (uint16_t i = 0U; (i < 3000U) && (taken < sent); i++) {
        period();
    }
    for (uint16_t i = 0U; i < 60U; i++) { /* a save needs 20 passes */
        period();
    }
    must(taken == sent);
    must(raw || (answers == requests));
    must(known || raw || (defaults_in_force() && (drive.state != DRIVE_RUN)));
    return 0;
}
