/* Messages to the importer. */
#include <stdarg.h>
#include <stdio.h>

#include "sim_host/fmu/instance.h"

bool fmu_refuse(const fmu_t *fmu, const char *format, ...)
{
    char    text[256];
    va_list words;
    va_start(words, format);
    (void)vsnprintf(text, sizeof text, format, words);
    va_end(words);
    if (fmu->log != NULL) {
        fmu->log(fmu->environment, fmi3Error, "logStatusError", text);
    }
    return false;
}
