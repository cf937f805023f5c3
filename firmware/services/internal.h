/**
 * @file  firmware/services/internal.h
 * @brief What the files of the services share: one function per request.
 */
#ifndef FIRMWARE_SERVICES_INTERNAL_H
#define FIRMWARE_SERVICES_INTERNAL_H

#include "firmware/link/protocol.h"
#include "firmware/services/services.h"

#define SERVICES_NO_FIELD 0xFFFFU

/* request_<message>: read the payload, write the answer. Its length is within the limits of protocol.def. */
#define MESSAGE(name, type, shortest, longest)                                                                                   \
    link_refusal_t request_##name(services_t *s, codec_reader_t *in, codec_writer_t *out);
#include "firmware/link/protocol.def"

/** Refuse with the details of the refusal. */
link_refusal_t services_refuse(services_t *s, link_refusal_t why, uint16_t field, float low, float high);
/** Refuse a payload that is not @p expected octets long; else LINK_FINE. */
link_refusal_t services_length(services_t *s, const codec_reader_t *in, uint16_t expected);
/** Refuse an index that is not below @p count; else LINK_FINE. */
link_refusal_t services_index(services_t *s, uint16_t index, uint16_t count);

/** A save of parameters or of what was learned is in progress. */
bool services_saving(const services_t *s);
/** State of the session, as bits (docs/protocol.md). */
uint16_t services_flags(const services_t *s);
/** Parameters in force, or those that wait for the interrupt. */
const drive_params_t *services_params(const services_t *s);
/** requests_command.c: the save is over. */
link_refusal_t services_stored(services_t *s, hal_status_t status);
/** kept.c: at the start, everything to zero but what the run before a reset has left and can be believed. */
void services_take_kept(services_t *s, const services_setup_t *setup);
/** What is there now may be believed after a reset. */
void services_mark(services_t *s);
/** Main loop: mark again what has changed. */
void services_attend_mark(services_t *s);
/** Switch the drive off and forget arm. */
void services_disarm(services_t *s);

#endif
