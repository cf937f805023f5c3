/* The motion profile: any target in every sample, any limits that init accepts, from rest; no overflow of 64 bits. */
#include "tests/prove/any.h"

#include "control/position/profile.c"
#include "control/position/ramp.c"

static int64_t any_i64(void) { return (int64_t)(((uint64_t)any_u32() << 32) | any_u32()); }
static int64_t any_step(int64_t low)
{
    const int64_t x = (int64_t)(any_u32() & UINT32_C(0x7FFFFFFF));
    return (x >= low) ? x : low;
}

void prove(void)
{
    ctl_profile_t self;
    self.params.speed = any_step(1);
    self.params.acceleration = any_step(0);
    self.params.smooth = any_u16_within(1U, CTL_PROFILE_SMOOTH_MAX);
    self.params.speed_scale = any_num_within(NUM_EPS, NUM_C(100.0f));
    self.params.accel_scale = any_num_within(NUM_EPS, NUM_C(100.0f));
    ctl_profile_reset(&self.state, any_i64());
    while (any_bool()) {
        const ctl_setpoint_t s = ctl_profile_step(&self, any_i64());
        const num_t          w = s.speed;
        /*@ check the_speed_is_a_number: number(w); */
    }
}
