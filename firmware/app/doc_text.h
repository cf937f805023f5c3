/**
 * @file  firmware/app/doc_text.h
 * @brief Texts that explain: the client has them from the same lists, so the chip, where each character is a word, does not.
 */
#ifndef FIRMWARE_APP_DOC_TEXT_H
#define FIRMWARE_APP_DOC_TEXT_H

/* DOC_MEMBER(declaration;) is a member that holds such a text, DOC_TEXT(text) its initializer with the comma behind it. */
#ifdef EVENSPIN_NO_TEXTS
#define DOC_MEMBER(declaration)
#define DOC_TEXT(text)
#else
#define DOC_MEMBER(declaration) declaration
#define DOC_TEXT(text) text,
#endif

#endif
