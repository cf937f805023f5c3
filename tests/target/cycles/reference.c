/* Functions whose cycles TI has published (Digital Control Library guide, table 3: call included), written from the operations
 * that the guide counts. They hold the cost model against figures that are known; names as in the guide. */
#include <stdint.h>

extern uint64_t evenspin_cycles;
int             reference_cases(void (*note_case)(const char *, uint64_t));

typedef struct {
    float kp, ki, umax, umin, i10, i6;
} pi_t;
typedef struct {
    float kp, ki, kd, kr, c1, c2, d2, d3, i10, i14, umax, umin, d1;
} pid_t;
typedef struct {
    float b0, b1, a1, d1, d2;
} df11_t;
typedef struct {
    float b0, b1, b2, a1, a2, x1, x2;
} df22_t;

__attribute__((noinline)) static float run_pi(pi_t *p, float r, float y)
{
    const float v2 = p->kp * (r - y);
    const float v4 = (p->i6 * (p->ki * v2)) + p->i10;
    p->i10 = v4;
    const float v5 = v2 + v4;
    float       v9 = (v5 > p->umax) ? p->umax : v5;
    v9 = (v9 < p->umin) ? p->umin : v9;
    p->i6 = (v5 == v9) ? 1.0f : 0.0f;
    return v9;
}

__attribute__((noinline)) static float run_pid(pid_t *p, float r, float y, float l)
{
    const float v5 = p->kr * r - y;
    const float v1 = r - y;
    const float v6 = p->ki * p->kp * v1;
    const float v8 = (v6 * p->i14) + p->i10;
    p->i10 = v8;
    const float v2 = p->kd * p->c1 * y;
    const float v4 = v2 - p->d2 - (p->c2 * p->d3);
    p->d2 = v2;
    p->d3 = v4;
    const float v9 = (p->kp * (v5 - v4)) + v8;
    float       v10 = (v9 > p->umax) ? p->umax : v9;
    v10 = (v10 < p->umin) ? p->umin : v10;
    p->i14 = (v10 == v9) ? l : 0.0f;
    return v10;
}

__attribute__((noinline)) static float run_df11(df11_t *p, float e)
{
    const float u = (e * p->b0) + (p->d1 * p->b1) - (p->d2 * p->a1);
    p->d1 = e;
    p->d2 = u;
    return u;
}

__attribute__((noinline)) static float run_df22(df22_t *p, float e)
{
    const float u = (e * p->b0) + p->x1;
    p->x1 = (e * p->b1) + p->x2 - (u * p->a1);
    p->x2 = (e * p->b2) - (u * p->a2);
    return u;
}

__attribute__((noinline)) static uint16_t run_clamp(float *x, float hi, float lo)
{
    const float before = *x;
    float       y = (before > hi) ? hi : before;
    y = (y < lo) ? lo : y;
    *x = y;
    return (y == before) ? 0U : 1U;
}

__attribute__((noinline)) static void complex_product(const float *a, const float *b, float *y)
{
    y[0] = (a[0] * b[0]) - (a[1] * b[1]);
    y[1] = (a[0] * b[1]) + (a[1] * b[0]);
}

#define CASE(name, call)                                                                                                         \
    do {                                                                                                                         \
        const uint64_t from = evenspin_cycles;                                                                                   \
        call;                                                                                                                    \
        note_case(name, evenspin_cycles - from);                                                                                 \
    } while (0)

int reference_cases(void (*note_case)(const char *, uint64_t))
{
    static pi_t    pi = {1.0f, 0.1f, 1.0f, -1.0f, 0.0f, 1.0f};
    static pid_t   pid = {1.0f, 0.1f, 0.1f, 1.0f, 0.5f, 0.5f, 0.0f, 0.0f, 0.0f, 1.0f, 1.0f, -1.0f, 0.0f};
    static df11_t  df11 = {0.1f, 0.2f, 0.3f, 0.0f, 0.0f};
    static df22_t  df22 = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.0f, 0.0f};
    volatile float in[4] = {0.3f, 5.0f, -5.0f, 0.1f};
    volatile float sink;
    float          x, a[2] = {1.0f, 2.0f}, b[2] = {3.0f, 4.0f}, y[2];
    for (int k = 0; k < 4; k++) {
        x = in[k];
        CASE("DCL_runPI_C2", sink = run_pi(&pi, in[k], 0.5f));
        CASE("DCL_runPID_C2", sink = run_pid(&pid, in[k], 0.5f, 1.0f));
        CASE("DCL_runDF11_C2", sink = run_df11(&df11, in[k]));
        CASE("DCL_runDF22_C4", sink = run_df22(&df22, in[k]));
        CASE("DCL_runClamp_C2", sink = (float)run_clamp(&x, 1.0f, -1.0f));
        CASE("mpy_SP_CSxCS", complex_product(a, b, y));
    }
    return (int)(sink + y[0] + y[1]);
}
