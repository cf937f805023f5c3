#include "control/position/ramp.h"

/* Travel of the steps a, 2 a, ... n a; n >= 0. */
static int64_t travel_of(int64_t n, int64_t a) { return a * (int64_t)((uint64_t)(n * (n + 1)) >> 1); }

/* Largest step <= top from which the travel is enough to stop, each following step a less; too small when top is more than
 * 2 a above it. From n a <= step < (n + 1) a it takes (n + 1) step - (a + ... + n a). */
static int64_t fastest(int64_t travel, int64_t top, int64_t a)
{
    int64_t n = (int64_t)((uint32_t)top / (uint32_t)a); /* both are below 2^31: 32 bits divide in a tenth of the time */
    if (((top * (n + 1)) - travel_of(n, a)) <= travel) {
        return top;
    }
    for (uint16_t k = 0U; (k < 2U) && (travel_of(n, a) > travel); k++) {
        n--;
    }
    return (travel + travel_of(n, a)) / (n + 1);
}

/* Next step towards a target `travel` ahead (travel >= 0), from `step` (negative: moving away). */
static int64_t next_step(int64_t rate, int64_t a, int64_t travel, int64_t step)
{
    if (a == 0) {
        return (travel < rate) ? travel : rate;
    }
    if (step < 0) {
        return ((step + a) < 0) ? (step + a) : 0;
    }
    const int64_t slower = (step > a) ? (step - a) : 0;
    int64_t       faster = step + a;
    if (faster > rate) { /* at the limit, or a limit that has become lower */
        faster = (slower > rate) ? slower : rate;
    }
    const int64_t right = fastest(travel, faster, a);
    return (right > slower) ? right : slower; /* no more than braking, even when the target comes too near for it */
}

int64_t ctl_ramp_next(int64_t rate, int64_t change, int64_t travel, int64_t step)
{
    if (travel < 0) {
        return -next_step(rate, change, (travel == INT64_MIN) ? INT64_MAX : -travel, -step);
    }
    return next_step(rate, change, travel, step);
}

int64_t ctl_ramp_step_unchecked(const ctl_ramp_params_t *params, ctl_ramp_state_t *state, int64_t target)
{
    const int64_t travel = (int64_t)((uint64_t)target - (uint64_t)state->at);
    state->step = ctl_ramp_next(params->rate, params->change, travel, state->step);
    state->at = (int64_t)((uint64_t)state->at + (uint64_t)state->step);
    return state->at;
}
