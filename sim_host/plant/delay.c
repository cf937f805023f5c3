#include "sim_host/plant/delay.h"

#define PLACES (SIM_DELAY_PERIODS + 2)

void sim_delay_start(sim_delay_t *d, double periods)
{
    d->newest = 0;
    d->whole = (int)periods;
    d->part = periods - d->whole;
    for (int i = 0; i < PLACES; i++) {
        for (int k = 0; k < 3; k++) {
            d->past[i][k] = 0.5; /* no voltage before the start */
        }
    }
}

void sim_delay_push(sim_delay_t *d, const double duty[3])
{
    d->newest = (d->newest + 1) % PLACES;
    for (int k = 0; k < 3; k++) {
        d->past[d->newest][k] = duty[k];
    }
}

static const double *ago(const sim_delay_t *d, int periods) { return d->past[(d->newest - periods + PLACES) % PLACES]; }

const double *sim_delay_first(const sim_delay_t *d) { return ago(d, d->whole + 1); }
const double *sim_delay_second(const sim_delay_t *d) { return ago(d, d->whole); }
