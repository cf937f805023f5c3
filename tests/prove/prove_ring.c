/* Ring and window: every capacity of the list, any head and fill that can be, any delay, any sequence of calls. */
#include "tests/prove/any.h"

#include "control/memory/ring.c"
#include "control/memory/window.h"

static void ring_of(uint16_t capacity, num_t *memory)
{
    ctl_ring_t ring = {memory, capacity, any_u16_within(0U, (uint16_t)(capacity - 1U)), any_u16_within(0U, capacity)};
    while (any_bool()) {
        ctl_ring_push(&ring, any_num());
        (void)ctl_ring_get(&ring, any_u16());
        /*@ check head_and_fill_stay_inside: ring.head < ring.capacity && ring.filled <= ring.capacity; */
    }
    ctl_ring_set(&ring, any_u16(), any_num());
    /*@ check set_leaves_head_and_fill_inside: ring.head < ring.capacity && ring.filled <= ring.capacity; */
    ctl_ring_fill_zero(&ring);
    ctl_ring_clear(&ring);
}

static void window(void)
{
    ctl_window_t w;
    ctl_window_fill(&w, any_num());
    while (any_bool()) {
        const num_t *const newest = ctl_window_push(&w, any_num());
        (void)newest[any_u16_within(0U, CTL_WINDOW_SIZE - 1U)];
        (void)newest[-(int16_t)any_u16_within(0U, CTL_WINDOW_MARGIN)];
        /*@ check head_stays_inside: w.head < CTL_WINDOW_SIZE; */
    }
    ctl_long_window_t l;
    ctl_long_window_fill(&l, any_num());
    while (any_bool()) {
        const num_t *const newest = ctl_long_window_push(&l, any_num());
        (void)newest[any_u16_within(0U, CTL_LONG_WINDOW_SIZE - 1U)];
        /*@ check head_stays_inside: l.head < CTL_LONG_WINDOW_SIZE; */
    }
}

void prove(void)
{
    static num_t memory[16];
    ring_of(2U, memory);
    ring_of(7U, memory);
    ring_of(16U, memory);
    window();
}
