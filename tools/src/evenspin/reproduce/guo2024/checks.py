"""Is the result what it should be? Bands have two sides: suddenly much better needs a check, too."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from evenspin.reproduce.check import Check
from evenspin.reproduce.guo2024.printed import REFERENCE

# The reference has an ideal encoder and no delay of the speed measurement; ours has 4000 counts and an M/T measurement.
REFERENCE_BAND = 0.12
FIXED_BAND_PP = 0.05  # percentage points

Rows = Iterable[Mapping[str, Any]]


# (method, speed_rpm, key, low, high)
ACCEPTANCE = (
    ("pi", 255.0, "n1_pct", 4.2, 4.9),
    ("pi", 255.0, "n2_pct", 2.9, 5.2),
    ("pi", 150.0, "n1_pct", 10.0, 12.0),
    ("crc", 255.0, "n1_pct", 0.5, 0.95),
    ("forc", 255.0, "n1_pct", 0.02, 0.06),
    ("forc", 255.0, "n2_pct", 0.1, 0.45),
    ("fal-forc", 255.0, "n1_pct", 0.015, 0.045),
    ("fal-forc", 255.0, "n2_pct", 0.08, 0.32),
    *((method, 150.0, key, 0.005, 0.07) for method in ("crc", "forc", "fal-forc") for key in ("n1_pct", "n2_pct")),
)

# What goes beyond the paper, at the four speeds of the first set after the load step: n1 and n2 at most the best of an
# independent simulation without sensor correction, and targets of ours for the rest. (key, low, high)
BEYOND = "fal-forc-beyond"
BEYOND_BANDS = (
    ("n1_after_load_pct", 0.0005, 0.011),
    ("n2_after_load_pct", 0.005, 0.11),
    ("overshoot_load_rpm", 0.5, 9.0),
    ("overshoot_step_rpm", 0.02, 2.0),
    ("load_dip_rpm", 5.0, 30.0),
)
BEYOND_SPEEDS = (150.0, 203.0, 255.0, 295.0)
# What is left when the errors of the current sensors are learned and taken off, at the four speeds before and after the
# load step; from an independent simulation of such a correction. (key, low, high)
CORRECTED = "corrected"
CORRECTED_BANDS = (
    ("n1_pct", 0.0, 0.01),
    ("n2_pct", 0.0, 0.01),
    ("distortion_pct", 0.0, 0.3),
    ("n1_after_load_pct", 0.0, 0.01),
    ("n2_after_load_pct", 0.0, 0.01),
    ("distortion_after_load_pct", 0.0, 0.3),
    ("overshoot_load_rpm", 0.02, 10.0),
    ("overshoot_step_rpm", 0.02, 2.0),
)
# q current at the highest speeds over that of PI: (speed_rpm, key, low, high)
FAST_RATIOS: tuple[tuple[float, str, float, float], ...] = (
    (900.0, "q1_after_load_pct", 0.001, 0.2),
    (900.0, "q2_after_load_pct", 0.01, 0.2),
    (1200.0, "q1_after_load_pct", 0.001, 0.2),
    (1200.0, "q2_after_load_pct", 0.01, 0.2),
)

# fal-FORC over FORC at 150 rpm, where the paper compares them: (what, key, low, high)
RATIOS = (
    ("start overshoot, fal-forc / forc", "overshoot_start_rpm", 0.2, 0.5),
    ("load overshoot, fal-forc / forc", "overshoot_load_rpm", 0.5, 0.8),
    ("load dip, fal-forc / forc", "load_dip_rpm", 0.95, 1.05),
)


def check_rows(rows: Rows) -> list[Check]:
    """Everything that can be checked with the rows there are."""
    found = {(row["method"], row["speed_rpm"]): row for row in rows}
    checks = [
        _of_row(found[method, speed], key, low, high, required=True)
        for method, speed, key, low, high in ACCEPTANCE
        if (method, speed) in found
    ]
    forc, fal = found.get(("forc", 150.0)), found.get(("fal-forc", 150.0))
    if forc is not None and fal is not None:
        checks += [Check(what, "", fal[key] / forc[key], low, high, True) for what, key, low, high in RATIOS]
    return [*checks, *_beyond(found), *_against_reference(found)]


def check_fixed(rows: Rows, float_rows: Rows) -> list[Check]:
    """Speed residues of the fixed-point build against those of the float build."""
    pairs = {(row["method"], row["speed_rpm"]): row for row in float_rows}
    return [
        Check(
            f"{row['method']} at {row['speed_rpm']:g} rpm: {key}, fixed - float",
            "",
            row[key] - pairs[row["method"], row["speed_rpm"]][key],
            -FIXED_BAND_PP,
            FIXED_BAND_PP,
            True,
        )
        for row in rows
        for key in ("n1_pct", "n2_pct")
    ]


def _beyond(found: Mapping[tuple[str, float], Mapping[str, Any]]) -> Iterator[Check]:
    for method, all_bands in ((BEYOND, BEYOND_BANDS), (CORRECTED, CORRECTED_BANDS)):
        for speed in BEYOND_SPEEDS:
            row = found.get((method, speed))
            if row is not None:
                bands = [band for band in all_bands if row[band[0]] is not None]
                yield from (_of_row(row, key, low, high, required=True) for key, low, high in bands)
    for speed, key, low, high in FAST_RATIOS:
        row, pi = found.get((BEYOND, speed)), found.get(("pi", speed))
        if row is not None and pi is not None:
            yield Check(f"{BEYOND} / pi at {speed:g} rpm: {key}", "", row[key] / pi[key], low, high, True)


def _of_row(row: Mapping[str, Any], key: str, low: float, high: float, required: bool) -> Check:
    what = f"{row['method']} at {row['speed_rpm']:g} rpm: {key}"
    return Check(what, key, row[key], low, high, required, row["method"], row["speed_rpm"])


def _against_reference(found: Mapping[tuple[str, float], Mapping[str, Any]]) -> Iterator[Check]:
    for method, speed, keys, values in REFERENCE:
        if (method, speed) in found:
            for key, value in zip(keys, values, strict=True):
                low, high = (1 - REFERENCE_BAND) * value, (1 + REFERENCE_BAND) * value
                yield _of_row(found[method, speed], key, low, high, required=False)
