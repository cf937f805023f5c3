"""A measured load against the current that carries it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from evenspin.plausible.dead import is_constant
from evenspin.plausible.finding import Array, Finding
from evenspin.plausible.torque import SMOOTH_S, mean_of, partial_slope

CLEAR = 0.8  # correlation that is beyond doubt
FACTOR = 20.0  # that no torque constant is off by

NEEDED = ("t_s", "speed_rad_s", "iq_a", "load_torque_nm")


def check_load_sign(columns: Mapping[str, Array], nm_per_a: float | None = None) -> Finding | None:
    """The current grows with a load that brakes. @p nm_per_a: of the model, where there is one."""
    t_s, load = columns["t_s"], columns["load_torque_nm"]
    step_s = float(np.median(np.diff(t_s)))
    n = max(1, round(SMOOTH_S / step_s))
    if len(t_s) < 20 * n or not np.isfinite(load).all() or is_constant(load):
        return None
    speed = mean_of(columns["speed_rad_s"], n)
    accel = (speed[n:] - speed[:-n]) / (n * step_s)
    rows = slice(n // 2, n // 2 + len(accel))
    w = speed[rows]
    beside = (accel, w, np.sign(w), np.ones_like(w))
    slope, like = partial_slope(mean_of(load, n)[rows], mean_of(columns["iq_a"], n)[rows], beside)
    if like < -CLEAR:
        data = f"falls where iq_a rises (correlation {like:.2f})"
        return Finding("load_torque_nm", data, "positive where it brakes positive rotation", "turn its sign")
    ratio = slope * nm_per_a if nm_per_a is not None else 1.0
    if like > CLEAR and not 1.0 / FACTOR < ratio < FACTOR:
        hint = "it looks like mN m: convert it" if 5e-4 < ratio < 2e-3 else "is it in N m, and iq_a in A?"
        return Finding("load_torque_nm", f"{1.0 / ratio:.3g} times the torque of the current", "in N m", hint)
    return None
