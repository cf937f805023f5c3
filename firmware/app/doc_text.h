/**
 * @file  firmware/app/doc_text.h
 * @brief Texts that explain: the client has them from the same lists, so the chip, where each character is a word, does not.
 */
#ifndef FIRMWARE_APP_DOC_TEXT_H
#define FIRMWARE_APP_DOC_TEXT_H

#ifdef EVENSPIN_NO_TEXTS
#define DOC_TEXT(text) ""
#else
#define DOC_TEXT(text) text
#endif

#endif
