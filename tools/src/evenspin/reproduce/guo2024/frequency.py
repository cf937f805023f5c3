"""Numbers of the paper that need no simulation: gains of the controllers, margins, fal."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from evenspin.blocks import lambda_
from evenspin.design.loop import SpeedLoop
from evenspin.design.rc import Repetitive, design, gain_db
from evenspin.design.source import loop_of, repetitive_of
from evenspin.model import builtin_scenario
from evenspin.reproduce.guo2024.checks import Check

SPEED_RPM = 307.0  # figures 4 and 10
PRINTED_GAINS = (36.7, 12.5)  # dB, CRC with N = 48, at its own frequency and at that of the ripple
PRINTED_K_RC = 0.525
GAINS_AT_06 = (37.9, 13.8)
GAIN_BAND_DB = 0.1
LAMBDA_MAX = 1.4427


def gains_db(rc: Repetitive, loop: SpeedLoop, pole_pairs: float) -> dict[str, Any]:
    """|1 + G_RC| of CRC (N = 48) and FORC (N = 48.86) at 20.83 and 20.47 Hz."""
    period = 60.0 / (pole_pairs * SPEED_RPM * loop.ts_s)
    f_hz = np.array([1.0 / (int(period) * loop.ts_s), 1.0 / (period * loop.ts_s)])
    found: dict[str, Any] = {"crc": {}, "forc": {}}
    for gain in (PRINTED_K_RC, 0.6):
        this = Repetitive(gain, rc.lead, rc.q_side, rc.q_centre, rc.order)
        for name, whole in (("crc", True), ("forc", False)):
            values = gain_db(this, period, f_hz, loop.ts_s, whole=whole)
            found[name][f"k_rc_{gain:g}"] = {f"{f:.2f}_hz": float(v) for f, v in zip(f_hz, values, strict=True)}
    return found


def frequency_results() -> tuple[dict[str, Any], dict[str, Any], list[Check]]:
    """(gains_db, limits, checks)."""
    setup = builtin_scenario("guo2024/first").setup
    loop, rc = loop_of(setup.plant, setup.drive), repetitive_of(setup.drive, fal=False)
    gains = gains_db(rc, loop, setup.plant["pole_pairs"])
    found = design(loop, rc)
    late = design(replace(loop, delay_s=loop.ts_s), rc)
    alpha, delta = setup.drive["rc_fal_alpha"], setup.drive["rc_fal_delta"]
    lambda_max = lambda_(0.0, alpha, delta)
    limits = {
        "lambda_max": lambda_max,
        "max_m": found.max_m,
        "phase_deg": found.margins.phase_deg,
        "k_rc_bound": found.margins.bound_sufficient,
        "k_rc_bound_exact": found.margins.bound,
        "k_rc_bound_fal": found.margins.bound_sufficient / lambda_max,
        "max_q_1_minus_k_zm_m": found.margins.contraction,
        "one_sample_delay": {
            "max_m": late.max_m,
            "phase_deg": late.margins.phase_deg,
            "k_rc_bound": late.margins.bound_sufficient,
        },
        "paper": {"max_m": 1.31, "phase_deg": 27.4, "k_rc_bound": 1.355, "k_rc_bound_fal": 0.968, "lambda_max": 1.4},
    }
    return gains, limits, [*_gain_checks(gains), *_limit_checks(limits)]


def _gain_checks(gains: dict[str, Any]) -> list[Check]:
    wanted = ((PRINTED_K_RC, PRINTED_GAINS), (0.6, GAINS_AT_06))
    return [
        Check(
            f"|1 + G_RC| of crc, k_rc {k_rc:g}, at {at.removesuffix('_hz')} Hz [dB]",
            "",
            value,
            expected - GAIN_BAND_DB,
            expected + GAIN_BAND_DB,
            required=True,
        )
        for k_rc, pair in wanted
        for (at, value), expected in zip(gains["crc"][f"k_rc_{k_rc:g}"].items(), pair, strict=True)
    ]


def _limit_checks(limits: dict[str, Any]) -> list[Check]:
    late = limits["one_sample_delay"]
    expected = (
        ("max|M|", limits["max_m"], 1.20, 0.01),
        ("largest |phase of z^5 M| up to 40 Hz [deg]", limits["phase_deg"], 34.0, 0.6),
        ("bound on k_rc", limits["k_rc_bound"], 1.38, 0.01),
        ("max|M|, one sample of delay", late["max_m"], 1.22, 0.01),
        ("largest |phase|, one sample of delay [deg]", late["phase_deg"], 40.0, 0.6),
        ("bound on k_rc, one sample of delay", late["k_rc_bound"], 1.25, 0.01),
        ("max|Q (1 - k_rc z^5 M)|", limits["max_q_1_minus_k_zm_m"], 0.82, 0.005),
    )
    lambda_max = limits["lambda_max"]
    return [Check("largest lambda of fal", "", lambda_max, LAMBDA_MAX - 1e-4, LAMBDA_MAX + 1e-4, required=True)] + [
        Check(what, "", value, middle - half, middle + half, required=False) for what, value, middle, half in expected
    ]
