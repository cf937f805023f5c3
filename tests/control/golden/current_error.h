/* Made by `python3 tests/control/golden/make_golden.py`; do not edit. */
#ifndef TESTS_CONTROL_GOLDEN_CURRENT_ERROR_H
#define TESTS_CONTROL_GOLDEN_CURRENT_ERROR_H

/* sensor errors in A and as gains, and what half of them looks like after one turn of 3 A at 0.3 rad */
typedef struct { int three; double oa, ob, oc, ga, gb, gc, learned_oa, learned_ob, learned_oc, learned_ga, learned_gb, learned_gc; } golden_current_error_t;
static const golden_current_error_t GOLDEN_CURRENT_ERROR[4] = {
    {0U, 0.2, 0.05, 0.0, 1.1, 0.9, 1.0, 1.0000000000000e-01, 2.5000000000000e-02, 0.0, 1.0498338870432e+00, 9.5016611295681e-01, 1.0},
    {0U, -0.3, 0.1, 0.0, 0.95, 1.02, 1.0, -1.5000000000000e-01, 5.0000000000000e-02, 0.0, 9.8224097668189e-01, 1.0177590233181e+00, 1.0},
    {1U, 0.1, -0.2, 0.25, 1.03, 0.92, 1.05, 2.5000000000000e-02, -1.2500000000000e-01, 1.0000000000000e-01, 1.0150000000000e+00, 9.6000000000000e-01, 1.0250000000000e+00},
    {1U, 0.0, 0.0, 0.3, 1.0, 1.0, 0.9, -5.0000000000000e-02, -5.0000000000000e-02, 1.0000000000000e-01, 1.0172413793103e+00, 1.0172413793103e+00, 9.6551724137931e-01},
};

#endif
