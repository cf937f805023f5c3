#include "firmware/app/memory_check.h"

#include <string.h>

#include "firmware/app/internal.h"

#define PART ((uint16_t)(64U * sizeof(uint32_t))) /* of a set in one pass */

/* Turned by a bit and added: each step can be undone, so a single change never cancels. */
static uint32_t add(uint32_t sum, const void *memory, uint16_t from, uint16_t to)
{
    const unsigned char *const at = (const unsigned char *)memory;
    for (uint16_t i = from; i < to; i = (uint16_t)(i + sizeof sum)) { /* structs with a float are whole words of 32 bits */
        uint32_t word = 0U;
        (void)memcpy(&word, &at[i], sizeof word);
        sum = ((sum << 1U) | (sum >> 31U)) + word;
    }
    return sum;
}

static uint16_t in_force(const drive_t *d) { return (uint16_t)((d->setup == &d->set[0].setup) ? 0U : 1U); }

static uint32_t sum_of_set(const drive_set_t *set) { return add(1U, set, 0U, (uint16_t)sizeof *set); }

static uint32_t sum_of_command(const drive_t *d, uint16_t at)
{
    const uint32_t command = add(1U, &d->command[at], 0U, (uint16_t)sizeof d->command[at]);
    return add(command, &d->order[at], 0U, (uint16_t)sizeof d->order[at]);
}

static uint32_t sum_of_zero(const drive_t *d)
{
    const struct {
        angle_t e;
        float   offset[3];
    } all = {d->zero.e, {d->offset_a_a, d->offset_b_a, d->offset_c_a}};
    return add(1U, &all, 0U, (uint16_t)sizeof all);
}

void drive_keep_set(drive_t *d, const drive_set_t *set)
{
    d->kept.set[(set == &d->set[0]) ? 0U : 1U] = sum_of_set(set);
    d->kept.at = (uint16_t)sizeof *set; /* a round that has begun may be of this one */
}

void drive_keep_command(drive_t *d, uint16_t at)
{
    d->kept.command[at] = sum_of_command(d, at);
    d->kept.command_at = at;
}

void drive_keep_zero(drive_t *d) { d->kept.zero = sum_of_zero(d); }

/* ---- checks: true when all is as it was ---------------------------------------------------------------------------- */

static bool command_is_kept(const drive_t *d)
{
    const uint16_t at = d->command_at;
    return (at == d->kept.command_at) && (sum_of_command(d, at) == d->kept.command[at]);
}

/* A part of the set in force; the sum is judged at its end. */
static bool set_is_kept(drive_t *d)
{
    drive_kept_t *const k = &d->kept;
    const uint16_t      of = in_force(d);
    const uint16_t      size = (uint16_t)sizeof d->set[0];
    if ((k->at >= size) || (k->of != of)) { /* begin again */
        k->at = 0U;
        k->of = of;
        k->sum = 1U;
    }
    const uint16_t end = (uint16_t)(k->at + PART);
    const uint16_t to = (end < size) ? end : size;
    k->sum = add(k->sum, &d->set[of], k->at, to);
    k->at = to;
    return (to < size) || (k->sum == k->set[of]);
}

/* Bit by bit: one was copied from the other. Only numbers without a gap between them. */
static bool same(const void *copy, const void *of, size_t size) { return memcmp(copy, of, size) == 0; }

/* The limits of each controller are +-out_max. */
static bool same_pi(const ctl_pi_t *pi, const ctl_pi_params_t *p)
{
    return same(&pi->params, p, 4U * sizeof(num_t)) && (pi->params.anti_windup == p->anti_windup) && (pi->bound == p->out_max);
}

/* The current interrupt calculates the proportional gain in every period from that of the set, where it follows a saturation. */
static bool same_current_pi(const ctl_pi_t *pi, const ctl_pi_params_t *p, bool saturates)
{
    ctl_pi_t as_set = *pi;
    if (saturates && (pi->params.kp >= (num_t)0) && (pi->params.kp <= p->kp)) {
        as_set.params.kp = p->kp;
    }
    return same_pi(&as_set, p);
}

static bool copies_are_kept(const drive_t *d)
{
    const drive_setup_t *const   s = d->setup;
    const ctl_mt_params_t *const mt = &d->speed.mt.params;
    return same_current_pi(&d->current.d, &s->current.pi, s->sensors.saturates) &&
           same_current_pi(&d->current.q, &s->current.pi, s->sensors.saturates) && same_pi(&d->speed.pi, &s->speed.pi) &&
           same_pi(&d->position.pi, &s->position.velocity_pi) &&
           same(&d->tracking.pll.params, &s->tracking.pll, sizeof s->tracking.pll) &&
           same(mt, &s->speed.mt, sizeof(uint32_t) + (2U * sizeof(num_t))) && (mt->stop_samples == s->speed.mt.stop_samples) &&
           same(&d->scale, &s->scale, sizeof s->scale);
}

/* The interrupts only ever make FAULT of the state. An alignment begins with the bridge off. */
static bool state_is_kept(const drive_t *d)
{
    const drive_state_t state = d->state;
    if (state == DRIVE_FAULT) {
        return d->fault != FAULT_none;
    }
    if (state == DRIVE_SHORT) {
        return d->kept.bridge && (d->stopping.how == DRIVE_STOP_SHORT);
    }
    return d->kept.bridge ? drive_state_is_armed(state) : ((unsigned)state <= (unsigned)DRIVE_READY);
}

void drive_check_memory(drive_t *d)
{
    uint16_t what = 0U;
    if (!state_is_kept(d)) {
        what = DRIVE_MEMORY_STATE;
    } else if (d->fault == FAULT_configuration) {
        return; /* no set was ever in force */
    } else if (!command_is_kept(d)) {
        what = DRIVE_MEMORY_COMMAND;
    } else if (d->kept.bridge && (sum_of_zero(d) != d->kept.zero)) {
        what = DRIVE_MEMORY_ZERO;
    } else if ((d->next_ready == 0U) && !copies_are_kept(d)) {
        what = DRIVE_MEMORY_COPIES;
    } else if (!set_is_kept(d)) {
        what = DRIVE_MEMORY_PARAMETERS;
    } else {
        return;
    }
    if (d->fault == FAULT_none) {
        d->fault_detail = what;
    }
    drive_trip(d, FAULT_memory_changed);
}

bool drive_recover_memory(drive_t *d)
{
    const uint16_t of = in_force(d);
    if ((sum_of_set(&d->set[of]) != d->kept.set[of]) || !copies_are_kept(d)) {
        return false;
    }
    const drive_command_t nothing = {.mode = DRIVE_MODE_SPEED};
    (void)drive_command(d, &nothing);
    d->started_up = false;
    return true;
}
