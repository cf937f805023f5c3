/* What this library is, and a clock to measure it with. */
#include <time.h>

#include "control/numeric/num.h"
#include "sim_host/capi/evenspin_capi.h"

int         es_abi_version(void) { return 6; }
const char *es_numeric(void) { return NUM_NAME; }

double es_monotonic_s(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
