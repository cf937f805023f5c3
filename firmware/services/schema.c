#include "firmware/services/schema.h"

#include <stddef.h>

#include "firmware/app/doc_text.h"
#include "firmware/app/telemetry.h"
#include "firmware/link/crc.h"
#include "firmware/link/protocol.h"

typedef struct {
    const char *name;
    DOC_MEMBER(const char *doc;)
} command_info_t;

static const command_info_t COMMANDS[LINK_COMMANDS] = {
#define COMMAND(name, doc) {#name, DOC_TEXT(doc)},
#include "firmware/link/protocol.def"
};

uint16_t schema_count(uint16_t kind)
{
    static const uint16_t COUNT[SCHEMA_KINDS] = {PARAM_COUNT, SIGNAL_COUNT, FAULT_COUNT, LINK_COMMANDS};
    return (kind < (uint16_t)SCHEMA_KINDS) ? COUNT[kind] : 0U;
}

const char *schema_name(uint16_t kind, uint16_t index)
{
    switch (kind) {
    case SCHEMA_PARAMETERS:
        return params_info(index)->name;
    case SCHEMA_SIGNALS:
        return telemetry_info(index)->name;
    case SCHEMA_FAULTS:
        return faults_info(index)->name;
    default:
        return COMMANDS[index].name;
    }
}

void schema_record(uint16_t kind, uint16_t index, codec_writer_t *w)
{
    if (kind == (uint16_t)SCHEMA_PARAMETERS) {
        const param_info_t *const p = params_info(index);
        codec_put_u8(w, p->kind);
        codec_put_u8(w, params_only_at_rest(index) ? SCHEMA_AT_REST : 0U);
        codec_put_f32(w, p->min);
        codec_put_f32(w, p->max);
        codec_put_f32(w, p->def);
        codec_put_str(w, schema_name(kind, index));
        codec_put_str(w, params_unit(p));
        codec_put_str(w, params_choices(p));
    } else if (kind == (uint16_t)SCHEMA_SIGNALS) {
        codec_put_str(w, schema_name(kind, index));
        codec_put_str(w, telemetry_info(index)->unit);
    } else {
        codec_put_str(w, schema_name(kind, index));
    }
}

#ifdef EVENSPIN_NO_TEXTS
const char *schema_text(uint16_t kind, uint16_t index, uint16_t part)
{
    (void)kind;
    (void)index;
    (void)part;
    return NULL;
}
#else
const char *schema_text(uint16_t kind, uint16_t index, uint16_t part)
{
    switch (kind) {
    case SCHEMA_FAULTS:
        return (part == 0U) ? faults_info(index)->cause : faults_info(index)->check;
    case SCHEMA_PARAMETERS:
        return (part == 0U) ? params_info(index)->doc : "";
    case SCHEMA_SIGNALS:
        return (part == 0U) ? telemetry_info(index)->doc : "";
    default:
        return (part == 0U) ? COMMANDS[index].doc : "";
    }
}
#endif

uint32_t schema_hash(void)
{
    static uint16_t record[SCHEMA_RECORD_MAX]; /* too long for the stack of the chip */
    uint32_t        c = CRC_START;
    for (uint16_t kind = 0U; kind < (uint16_t)SCHEMA_KINDS; kind++) {
        for (uint16_t index = 0U; index < schema_count(kind); index++) {
            codec_writer_t w = codec_writer(record, SCHEMA_RECORD_MAX);
            schema_record(kind, index, &w);
            c = crc_octet(c, kind);
            for (uint16_t i = 0U; i < w.at; i++) {
                c = crc_octet(c, record[i]);
            }
        }
    }
    return crc_value(c);
}
