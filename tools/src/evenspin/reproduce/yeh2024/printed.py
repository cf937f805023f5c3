"""What the paper prints, and what an independent double-precision simulation of the same drive gave. Keys of a row.

The independent simulation shares no code with evenspin; see docs/reference/yeh2024.md.
"""

from __future__ import annotations

SPEEDS_RPM = (10.0, 15.0, 20.0)

_Three = tuple[float | None, float | None, float | None]

# (method, key): at 10, 15 and 20 rpm
PAPER: dict[tuple[str, str], _Three] = {
    ("silc", "turn1_rms"): (3.723e-3, None, None),
    ("silc", "turn10_rms"): (0.327e-3, None, None),
    ("silc", "max_turn1"): (30.07e-3, 52.22e-3, 65.64e-3),
    ("src", "max_turn1"): (18.88e-3, 17.93e-3, 28.84e-3),
    ("rdc", "max_turn1"): (12.75e-3, 14.26e-3, 14.51e-3),
    ("rdc", "max_turn1_from_0"): (12.75e-3, 14.26e-3, 14.51e-3),
    ("rdc", "max_reduction_pct"): (85.67, 90.78, 90.65),
    ("silc", "turn2_reduction_pct"): (43.16, 68.79, 78.63),
    ("silc", "turn10_reduction_pct"): (91.21, 94.48, 96.52),
    ("silc", "max_turn10"): (1.011e-3, 1.278e-3, 1.912e-3),
    ("silc", "avg_turn10"): (0.106, None, 0.209),
    ("silc", "raw_max_turns_1_3"): (0.108, None, 0.213),
    ("src", "turn2_reduction_pct"): (91.67, 89.86, 88.58),
    ("src", "turn10_reduction_pct"): (91.29, 91.30, 92.18),
    ("src", "max_turn10"): (0.907e-3, 0.902e-3, 0.988e-3),
    ("src", "avg_turn10"): (0.105, None, 0.209),
    ("src", "raw_max_turns_1_3"): (0.115, None, 0.216),
    ("rdc", "raw_max_turns_1_3"): (1.295e-2, 1.463e-2, 1.485e-2),
}
# One number for all speeds: "at most", not compared.
PAPER_AT_MOST = {("rdc", "turn1_rms"): 1.888e-3, ("rdc", "turn10_rms"): 0.515e-3, ("rdc", "avg_turn10"): 1e-3}

INDEPENDENT: dict[tuple[str, str], _Three] = {
    ("ppi", "turn1_rms"): (3.53e-3, 5.74e-3, 8.83e-3),
    ("ppi", "turn2_reduction_pct"): (31.0, 66.0, 82.0),
    ("ppi", "max_turn10"): (3.8e-3, 3.2e-3, 2.7e-3),
    ("ppi", "avg_turn10"): (0.1047, 0.1571, 0.2094),
    ("ppi", "raw_max_turns_1_3"): (0.108, 0.160, 0.212),
    ("silc", "turn1_rms"): (3.53e-3, 5.74e-3, 8.83e-3),
    ("silc", "turn2_reduction_pct"): (41.0, 69.0, 79.0),
    ("silc", "turn10_reduction_pct"): (89.0, 89.0, 89.0),
    ("silc", "max_turn10"): (1.46e-3, 2.14e-3, 2.91e-3),
    ("silc", "avg_turn10"): (0.1047, 0.1571, 0.2094),
    ("silc", "raw_max_turns_1_3"): (0.108, 0.160, 0.212),
    ("src", "turn1_rms"): (2.88e-3, 5.51e-3, 8.76e-3),
    ("src", "turn2_reduction_pct"): (91.0, 94.0, 96.0),
    ("src", "turn10_reduction_pct"): (91.0, 94.0, 96.0),
    ("src", "max_turn10"): (0.42e-3, 0.52e-3, 0.56e-3),
    ("src", "avg_turn10"): (0.1047, 0.1571, 0.2094),
    ("src", "raw_max_turns_1_3"): (0.108, 0.160, 0.212),
    ("rdc", "turn1_rms"): (0.33e-3, 0.61e-3, 0.90e-3),
    ("rdc", "turn10_rms"): (0.034e-3, 0.0345e-3, 0.035e-3),
    ("rdc", "max_turn10"): (0.051e-3, 0.0535e-3, 0.056e-3),
    ("rdc", "raw_max_turns_1_3"): (0.41e-2, 0.63e-2, 0.85e-2),
    ("rdc-beyond", "raw_max_turns_1_3"): (0.51e-3, 0.69e-3, 0.84e-3),
}
INDEPENDENT_ALL_WRONG = {("rdc", "turn10_rms"): 0.35e-3, ("rdc-beyond", "turn10_rms"): 0.13e-3}


def paper(method: str, key: str, speed_rpm: float) -> float | None:
    return _at(PAPER.get((method, key)), speed_rpm)


def at_most(method: str, key: str) -> float | None:
    return PAPER_AT_MOST.get((method, key))


def independent(method: str, key: str, speed_rpm: float, models: str = "true") -> float | None:
    if models != "true":
        return INDEPENDENT_ALL_WRONG.get((method, key))
    return _at(INDEPENDENT.get((method, key)), speed_rpm)


def _at(values: _Three | None, speed_rpm: float) -> float | None:
    return values[SPEEDS_RPM.index(speed_rpm)] if values is not None and speed_rpm in SPEEDS_RPM else None
