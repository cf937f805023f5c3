/* What the encoder's rounding does at a target speed, and how far the speed drifts so that it is not learned. Main loop. */
#include "control/observer/observer.h"

#define HARMONICS 4U
/* Waves of the rounding per turn, / 256: */
#define WAVES_LEAST 6400U /* 25 */
#define OFF_BELOW 97U     /* 0.38 above a whole one, the golden section: no multiple of it comes near a whole one soon */
#define OFF_ABOVE 159U    /* and below the next */

/* Order of the turn that the rounding error of the encoder has, folded by sampling, and 1, where it is slow and a whole one; else 0. */
static uint16_t rounding_order(const ctl_observer_params_t *p, uint32_t step)
{
    if (!(p->sync_band > (num_t)0) || (p->encoder_counts == 0U)) {
        return 0U;
    }
    const uint32_t cycles = (uint32_t)((uint64_t)p->encoder_counts * step); /* counts per sample without the whole ones, 2^-32 */
    const uint32_t folded = (cycles < UINT32_C(0x80000000)) ? cycles : (0U - cycles);
#ifdef EVENSPIN_FIXED
    const uint32_t band = (uint32_t)p->sync_band << 8;
#else
    const uint32_t band = (uint32_t)(p->sync_band * 4294967040.0f);
#endif
    const uint32_t order = (folded + (step / 2U)) / step; /* nearest; turns of the sawtooth per turn of the shaft, below 2^16 */
    const uint32_t off = angle_size(folded - (order * step));
    return ((folded < band) && (off < (step / 16U))) ? (uint16_t)(order + 1U) : (uint16_t)0U;
}

/* Angle in one sample at that speed, at most half a turn. */
static uint32_t step_at(const ctl_observer_params_t *p, num_t speed)
{
#ifdef EVENSPIN_FIXED
    /* not rounded in between: orders of the rounding differ by parts of 10^-7 */
    const uint64_t rad = ((uint64_t)num_abs(speed) * (uint64_t)p->rad_per_64) >> 22; /* 2^-32 */
    const uint64_t most = UINT64_C(13493037704);                                     /* pi 2^32 */
    return (uint32_t)((((rad < most) ? rad : most) * UINT64_C(683565276)) >> 32);
#else
    return angle_step_from_rad(num_abs(speed * (p->rad_per_64 * 0.015625f)));
#endif
}

/* The same in 2^-48 turns, within 2e-7 of it: 0.03 counts per turn of 2^17. A speed of half a turn per sample is the largest. */
static uint64_t fine_step_at(const ctl_observer_params_t *p, num_t speed)
{
#ifdef EVENSPIN_FIXED
    const uint64_t rad = (uint64_t)num_abs(speed) * (uint64_t)p->rad_per_64; /* of 64 samples, 2^-48 */
    const uint64_t most = UINT64_C(56594528765327474);                       /* 64 pi 2^48 */
    return ((((rad < most) ? rad : most) >> 16) * UINT64_C(10680707)) >> 16; /* 2^32 / (128 pi) */
#else
    const float turns = num_abs(speed) * (p->rad_per_64 * 2.4867959858e-3f); /* 1 / (128 pi) */
    return (uint64_t)(((turns < 0.5f) ? turns : 0.5f) * 281474976710656.0f);
#endif
}

/* Where the waves of the rounding have to go, from @p waves per turn; both / 256. */
static uint32_t waves_wanted(uint32_t waves, uint32_t most)
{
    const uint32_t near = (waves - (waves % 256U)) + (((waves % 256U) < 128U) ? OFF_BELOW : OFF_ABOVE);
    const uint32_t far = WAVES_LEAST + OFF_BELOW;
    return ((near < WAVES_LEAST) && ((far - waves) <= most)) ? far : near;
}

/* How far the speed has to be off @p speed, so that the rounding does not come back in the next turn as it was in this one. */
static bool find_drift(const ctl_observer_params_t *p, num_t speed, num_t *drift)
{
    const uint64_t step = fine_step_at(p, speed);
    if ((step < (UINT64_C(65540) << 16)) || (step > (UINT64_C(1) << 45)) || (p->encoder_counts == 0U)) {
        return false; /* slower than 2^-16 turns per sample, or eight samples per turn and fewer */
    }
    uint32_t harmonic = 0U; /* of the sawtooth: the one that folds to the lowest frequency passes the filters */
    uint64_t folded = UINT64_MAX;
    bool     forwards = false;
    for (uint32_t h = 1U; h <= HARMONICS; h++) {
        const uint64_t cycles = ((uint64_t)p->encoder_counts * h * step) & UINT64_C(0xFFFFFFFFFFFF); /* without the whole ones */
        const bool     up = cycles < (UINT64_C(1) << 47);
        const uint64_t size = up ? cycles : ((UINT64_C(1) << 48) - cycles);
        if (size < folded) {
            harmonic = h;
            folded = size;
            forwards = up;
        }
    }
#ifdef EVENSPIN_FIXED
    const uint64_t band = (uint64_t)(uint32_t)p->sync_band << 24;
#else
    const uint64_t band = (uint64_t)(p->sync_band * 281474976710656.0f);
#endif
    if (folded >= band) {
        return false;
    }
    const uint32_t waves = (uint32_t)(((folded * 256U) + (step / 2U)) / step); /* below 2^24 */
    const uint32_t most = p->drift_most * harmonic;
    const uint32_t wanted = waves_wanted(waves, most);
    const int32_t  more = (int32_t)wanted - (int32_t)waves;
    if (((more < 0) ? -more : more) > (int32_t)most) {
        return false;
    }
    const int32_t faster = forwards ? more : -more; /* counts per turn, / 256, times the harmonic */
#ifdef EVENSPIN_FIXED
    const int64_t parts = (int64_t)p->encoder_counts * harmonic * 256;
    const int64_t change = (int64_t)speed * faster;
    *drift = (num_t)((change + ((change < 0) ? -(parts / 2) : (parts / 2))) / parts);
#else
    *drift = speed * ((float)faster / ((float)p->encoder_counts * (float)harmonic * 256.0f));
#endif
    return true;
}

void ctl_observer_target(ctl_observer_t *self, num_t speed)
{
    const ctl_observer_params_t *const p = &self->params;
    ctl_observer_state_t *const        s = &self->state;
    const num_t                        w = num_guard(speed, (num_t)0, &s->rejected);
    uint16_t                           samples = UINT16_MAX;
    uint16_t                           rounding = 0U;
    const uint32_t                     step = step_at(p, w);
    if (step > UINT32_C(65540)) { /* 2^32 / 65535 */
        const uint32_t whole = UINT32_MAX / step;
        samples = (uint16_t)(whole + (((UINT32_MAX - (whole * step)) > (step / 2U)) ? 1U : 0U));
        rounding = rounding_order(p, step);
    }
    s->turn_samples = samples; /* each at once: an interrupt reads them */
    s->rounding = rounding;
    num_t drift = (num_t)0;
    s->drifting = s->drifts && find_drift(p, w, &drift);
    s->drift = drift;
    s->synchronous = (!s->drifting) && (rounding != 0U) && (rounding != s->kept_rounding);
}

void ctl_observer_keep_rounding(ctl_observer_t *self)
{
    ctl_observer_state_t *const           s = &self->state;
    const ctl_angle_memory_state_t *const m = &s->memory.state;
    uint16_t                              order = 0U;
    if ((self->params.kind == CTL_OBSERVER_ARO) && (s->rounding != 0U) && !s->drifting) {
        order = (uint16_t)((s->rounding - 1U) % m->grid.cells);
        order = ((2U * (uint32_t)order) > m->grid.cells) ? (uint16_t)(m->grid.cells - order) : order; /* as N points see it */
    }
    ctl_kept_order_step(&s->kept, &m->grid, order, m->position.below, self->params.memory.limit);
    s->kept_rounding = (s->kept.known != 0U) ? s->rounding : (uint16_t)0U;
}
