"""What the paper prints, and what an independent double-precision simulation of the same drive gave.

Keys are those of a result row. REFERENCE shares no code with evenspin; see docs/reference/guo2024.md.
"""

from __future__ import annotations

from dataclasses import dataclass

TABLE_3_RPM = 255.0


@dataclass(frozen=True, slots=True)
class Printed:
    """One number of the paper: of its simulation, of its experiment, or both."""

    method: str
    speed_rpm: float
    key: str
    simulation: float | None
    experiment: float | None


def _table_3() -> list[Printed]:
    """Table 3; its overshoot column belongs to the start at 150 rpm."""
    keys = ("n1_pct", "q1_pct", "n2_pct", "q2_pct")
    simulation = {
        "pi": (4.89, 3.26, 3.10, 4.12),
        "crc": (0.51, 0.34, 0.71, 0.95),
        "forc": (0.03, 0.02, 0.09, 0.13),
        "fal-forc": (0.03, 0.03, 0.09, 0.12),
    }
    experiment = {
        "pi": (4.34, 4.77, 2.92, 3.21),
        "crc": (0.87, 1.73, 0.48, 0.86),
        "forc": (0.20, 1.12, 0.33, 0.50),
        "fal-forc": (0.19, 1.08, 0.31, 0.46),
    }
    overshoot = {"pi": (15.0, 25.0), "crc": (70.0, 90.0), "forc": (71.0, 95.0), "fal-forc": (35.0, 29.0)}
    lines = [
        Printed(method, TABLE_3_RPM, key, simulation[method][i], experiment[method][i])
        for method in simulation
        for i, key in enumerate(keys)
    ]
    return lines + [Printed(method, 150.0, "overshoot_start_rpm", *pair) for method, pair in overshoot.items()]


PRINTED: tuple[Printed, ...] = (
    *_table_3(),
    Printed("pi", 150.0, "n1_pct", None, 11.8),  # section 4.1
    Printed("pi", 150.0, "n2_pct", None, 5.8),
    Printed("crc", 203.0, "n1_pct", None, 1.12),
    Printed("crc", 203.0, "n2_pct", None, 0.74),
    Printed("forc", 203.0, "n1_pct", None, 0.17),
    Printed("forc", 203.0, "n2_pct", None, 0.16),
    Printed("forc", 150.0, "overshoot_load_rpm", None, 46.0),  # section 4.2
    Printed("fal-forc", 150.0, "overshoot_load_rpm", None, 26.0),
    Printed("forc", 300.0, "overshoot_start_rpm", None, 119.0),
    Printed("forc", 300.0, "overshoot_load_rpm", None, 46.0),
    Printed("fal-forc", 300.0, "overshoot_start_rpm", None, 65.0),
    Printed("fal-forc", 300.0, "overshoot_load_rpm", None, 41.0),
)

N, N_AFTER, Q = ("n1_pct", "n2_pct"), ("n1_after_load_pct", "n2_after_load_pct"), ("q1_pct", "q2_pct")
Q_AFTER = ("q1_after_load_pct", "q2_after_load_pct")
PEAKS = ("overshoot_start_rpm", "overshoot_load_rpm")
START, STEP = ("overshoot_start_rpm",), ("overshoot_step_rpm",)

# (method, speed_rpm, keys, values) of the independent simulation.
REFERENCE: tuple[tuple[str, float, tuple[str, ...], tuple[float, ...]], ...] = (
    # PI at 150 rpm, n2: not here. With a ripple of 10 % the second order depends on whether it is counted over time
    # (theirs, 3.0; ours 3.15) or over the angle (ours, 3.6), because the first order bends one axis against the other.
    ("pi", 150.0, ("n1_pct",), (10.6,)),
    ("pi", 150.0, PEAKS, (14.6, 19.0)),
    ("pi", 255.0, Q, (6.7, 12.2)),
    ("crc", 150.0, PEAKS, (39.0, 42.0)),
    ("crc", 203.0, N, (0.92, 1.76)),
    ("crc", 255.0, N, (0.82, 2.1)),
    ("crc", 255.0, Q, (1.2, 6.0)),
    ("forc", 150.0, N, (0.03, 0.06)),
    ("forc", 150.0, PEAKS, (39.0, 42.0)),
    ("forc", 203.0, N, (0.043, 0.20)),
    ("forc", 203.0, STEP, (33.0,)),
    ("forc", 255.0, N, (0.055, 0.33)),
    ("forc", 255.0, STEP, (40.0,)),
    ("forc", 295.0, STEP, (27.0,)),
    ("fal-forc", 150.0, PEAKS, (14.0, 32.0)),
    ("fal-forc", 203.0, STEP, (23.0,)),
    ("fal-forc", 255.0, N, (0.038, 0.24)),
    ("fal-forc", 255.0, N_AFTER, (0.039, 0.31)),
    ("fal-forc", 255.0, STEP, (27.0,)),
    ("fal-forc", 295.0, N_AFTER, (0.064, 0.45)),
    ("fal-forc", 295.0, STEP, (22.0,)),
    ("pi", 300.0, N, (3.3, 0.85)),
    ("pi", 367.0, N, (2.2, 1.4)),
    ("pi", 430.0, N, (1.7, 1.4)),
    ("pi", 488.0, N, (1.3, 1.4)),
    ("crc", 300.0, N, (0.064, 0.11)),
    ("crc", 367.0, N, (0.78, 1.15)),
    ("crc", 430.0, N, (0.74, 1.36)),
    ("crc", 488.0, N, (0.61, 1.42)),
    ("forc", 300.0, N, (0.064, 0.11)),
    ("forc", 300.0, PEAKS, (90.0, 44.0)),
    ("forc", 367.0, N, (0.078, 0.30)),
    ("forc", 430.0, N, (0.091, 0.44)),
    ("forc", 488.0, N, (0.10, 0.57)),
    ("fal-forc", 300.0, N, (0.045, 0.078)),
    ("fal-forc", 300.0, PEAKS, (25.0, 27.0)),
    ("fal-forc", 367.0, N, (0.058, 0.23)),
    ("fal-forc", 430.0, N, (0.092, 0.38)),
    ("fal-forc", 488.0, N, (0.12, 0.56)),
    ("pi", 900.0, Q_AFTER, (10.2, 11.8)),
    ("pi", 1200.0, Q_AFTER, (6.4, 11.3)),
    ("pi", 900.0, START, (66.0,)),
    ("forc", 900.0, Q_AFTER, (3.6, 11.3)),
    ("forc", 1200.0, Q_AFTER, (3.7, 11.8)),
    ("forc", 900.0, START, (320.0,)),
    ("fal-forc", 900.0, START, (115.0,)),
)


def printed(method: str, speed_rpm: float, key: str) -> Printed | None:
    """The paper's number for this, if it has one."""
    wanted = (method, speed_rpm, key)
    return next((line for line in PRINTED if (line.method, line.speed_rpm, line.key) == wanted), None)
