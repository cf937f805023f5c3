"""Is the result what it should be? Bands have two sides: suddenly much better needs a check, too."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from evenspin.reproduce.check import Check
from evenspin.reproduce.yeh2024.measure import Row, find, reduction_pct
from evenspin.reproduce.yeh2024.printed import SPEEDS_RPM, independent

LAG_PER_RPM = math.pi / 30.0 / 10.0  # rad: speed over k_pp = 10 1/s
LAG_BAND = 0.02
REFERENCE_BAND = 0.12

Band = tuple[float, float]

# (method, key): bands at 10, 15 and 20 rpm
ACCEPTANCE: dict[tuple[str, str], tuple[Band, Band, Band]] = {
    ("silc", "turn2_reduction_pct"): ((38.0, 46.0), (65.0, 72.0), (75.0, 82.0)),
    ("silc", "turn10_reduction_pct"): ((88.0, 97.0),) * 3,
    ("src", "turn2_reduction_pct"): ((88.0, 99.5),) * 3,
    ("src", "turn10_reduction_pct"): ((90.0, 99.5),) * 3,
    ("rdc", "turn10_rms"): ((0.01e-3, 0.05e-3),) * 3,
    ("rdc", "max_turn10"): ((0.02e-3, 0.1e-3),) * 3,
    ("rdc", "avg_turn10"): ((-1e-5, 1e-5),) * 3,
    ("rdc", "raw_max_turns_1_3"): ((2e-3, 1.6e-2),) * 3,
    ("rdc-beyond", "raw_max_turns_1_3"): ((0.05e-3, 1e-3),) * 3,
    ("rdc-beyond", "turn10_rms"): ((0.002e-3, 0.05e-3),) * 3,
    ("rdc-beyond", "avg_turn10"): ((-1e-5, 1e-5),) * 3,
}
ALL_WRONG: dict[str, Band] = {"rdc": (0.1e-3, 0.4e-3), "rdc-beyond": (0.02e-3, 0.15e-3)}  # turn10_rms

# What identification has to find of the simulated machine: relative bands, then those of (cycles, amplitude, phase)
IDENTIFIED = {
    "inertia_kgm2": (0.780e-2, 0.02),
    "viscous_nms": (0.339e-1, 0.02),
    "coulomb_nm": (0.387, 0.02),
    "static_nm": (0.457, 0.02),
    "stribeck_rad_s": (0.551, 0.08),
    "shape": (1.957, 0.10),
}
LINES = (
    ("main line", (5.724e-6 * 2**22, 0.140, 1.275), (0.001, 0.02 * 0.140, 0.03)),
    ("second line", (9.678e-7 * 2**22, 0.022, 0.521), (0.001, 0.02 * 0.022, 0.05)),
)

# Raw error of RDC against the learning methods: (what, key, least reduction, %)
AGAINST = (("turns 1-3", "raw_max_turns_1_3", 90.0), ("turn 10", "raw_max_turn10", 99.0))


def check_rows(rows: Sequence[Row]) -> list[Check]:
    """Everything that can be checked with the rows there are."""
    return [*_bands(rows), *_lags(rows), *_all_wrong(rows), *_against_learning(rows), *_against_reference(rows)]


def check_identified(found: Mapping[str, Any]) -> list[Check]:
    """What identification found against what the simulated machine has."""
    checks = [
        Check(f"identified {name}", "", found[name], (1.0 - band) * true, (1.0 + band) * true, True)
        for name, (true, band) in IDENTIFIED.items()
    ]
    for index, (name, true, bands) in enumerate(LINES):
        line = found["lines"][index] if index < len(found["lines"]) else {}
        for key, value, band in zip(("cycles", "amplitude_nm", "phase_rad"), true, bands, strict=True):
            what = f"identified {name}: {key}"
            checks.append(Check(what, "", line.get(key, math.nan), value - band, value + band, True))
    return checks


def _bands(rows: Sequence[Row]) -> Iterator[Check]:
    for (method, key), bands in ACCEPTANCE.items():
        for speed_rpm, (low, high) in zip(SPEEDS_RPM, bands, strict=True):
            row = find(rows, method, speed_rpm)
            if row is not None:
                yield _of_row(row, key, low, high, required=True)


def _lags(rows: Sequence[Row]) -> Iterator[Check]:
    for row in rows:
        if row["method"] in ("ppi", "silc", "src"):
            lag = LAG_PER_RPM * row["speed_rpm"]
            yield _of_row(row, "avg_turn10", (1.0 - LAG_BAND) * lag, (1.0 + LAG_BAND) * lag, required=True)


def _all_wrong(rows: Sequence[Row]) -> Iterator[Check]:
    for row in rows:
        if row.get("models") == "all wrong":
            yield _of_row(row, "turn10_rms", *ALL_WRONG[row["method"]], required=True)


def _against_learning(rows: Sequence[Row]) -> Iterator[Check]:
    for speed_rpm in SPEEDS_RPM:
        rdc = find(rows, "rdc", speed_rpm)
        for method in ("silc", "src"):
            other = find(rows, method, speed_rpm)
            if rdc is None or other is None:
                continue
            for what, key, least in AGAINST:
                value = reduction_pct(other[key], rdc[key])
                yield Check(
                    f"rdc at {speed_rpm:g} rpm: raw error below {method}, {what} [%]", "", value, least, 100.0, True
                )


def _against_reference(rows: Sequence[Row]) -> Iterator[Check]:
    for row in rows:
        for key in ("turn1_rms", "max_turn10", "raw_max_turns_1_3", "turn10_rms"):
            value = independent(row["method"], key, row["speed_rpm"], row.get("models", "true"))
            if value is not None:
                low, high = (1.0 - REFERENCE_BAND) * value, (1.0 + REFERENCE_BAND) * value
                yield _of_row(row, key, low, high, required=False)


def _of_row(row: Mapping[str, Any], key: str, low: float, high: float, *, required: bool) -> Check:
    wrong = ", models all wrong" if row.get("models") == "all wrong" else ""
    what = f"{row['method']} at {row['speed_rpm']:g} rpm{wrong}: {key}"
    return Check(what, key, row[key], low, high, required, f"{row['method']}{wrong}", row["speed_rpm"])
