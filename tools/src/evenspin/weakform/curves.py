"""A found term over what it depends on, and what the log shows beside it, for the picture in the report."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.empirical.library import sections
from evenspin.empirical.rows import Rows
from evenspin.empirical.term import Curve, EmpiricalTerm
from evenspin.weakform.beyond_rows import columns_of
from evenspin.weakform.equations import Equations

Array = NDArray[np.float64]

BINS = 30
POINTS = 120
LEAST_IN_BIN = 4


def curve_of(term: EmpiricalTerm, rows: Rows, e: Equations, without: Sequence[Array]) -> Curve | None:
    """`without`: what is left of every equation without this term. None: there is nothing to draw it over."""
    over = _over(term, rows)
    if over is None:
        return None
    label, unit, u, factor_shape = over
    parts = columns_of(e, term.family.columns(rows, term.shape))
    use = next(
        (
            k
            for k in ((1, 0, 3, 2) if factor_shape == "phase" else (0, 1, 3, 2))
            if k < len(parts) and parts[k] is not None
        ),
        None,
    )
    if use is None:
        return None
    column = parts[use]
    assert column is not None
    w = e.windows()[use]
    at = w.at_centre(u)
    modelled = -column @ term.coefficients
    scale = _scale(term, rows, e, use, factor_shape)
    keep = np.abs(scale) > 0.1 * float(np.max(np.abs(scale)))
    low, high = (float(x) for x in np.percentile(at[keep], (0.5, 99.5)))
    edges = np.linspace(low, high, BINS + 1)
    number = np.digitize(at, edges) - 1
    x, data, value = [], [], []
    for k in range(BINS):
        own = keep & (number == k)
        if np.count_nonzero(own) < LEAST_IN_BIN:
            continue
        power = float(np.sum(scale[own] ** 2))
        x.append(float(np.mean(at[own])))
        data.append(float(np.sum(scale[own] * without[use][own])) / power)
        value.append(float(np.sum(scale[own] * modelled[own])) / power)
    if len(x) < 3:
        return None
    spread = np.sqrt(np.einsum("ij,jk,ik->i", column, term.covariance, column))
    half = [
        1.96 * float(np.sum(np.abs(scale[own]) * spread[own])) / float(np.sum(scale[own] ** 2))
        for own in (keep & (number == k) for k in range(BINS))
        if np.count_nonzero(own) >= LEAST_IN_BIN
    ]
    return Curve(label, unit, np.array(x), np.array(value), np.array(half), np.array(x), np.array(data))


def _over(term: EmpiricalTerm, rows: Rows) -> tuple[str, str, Array, str] | None:
    name = term.family.name
    if name in ("speed_odd", "speed_even"):
        return "speed [rad/s]", "N m", rows.speed_rad_s, "one"
    if name == "angle_line":
        phase = np.mod(term.shape[0] * rows.theta_rad, 2.0 * np.pi)
        return f"angle within one of {term.shape[0]:.4g} periods per turn [rad]", "N m", phase, "phase"
    if name.startswith("position_"):
        return "position [rad]", "N m", rows.theta_rad, "one"
    if name.startswith("time_"):
        unit = {"time_magnet": "share", "time_resistance": "ohm"}.get(name, "N m")
        return "time [s]", unit, rows.t_s, "grown"
    if name == "torque_frequency":
        return (
            f"time within one period of {term.shape[0]:.4g} Hz [rad]",
            "N m",
            np.mod(2.0 * np.pi * term.shape[0] * rows.t_s, 2.0 * np.pi),
            "one",
        )
    if name == "reversal":
        way = np.zeros(len(rows.t_s))
        for first, end, _ in sections(rows):
            way[first:end] = np.abs(rows.theta_rad[first:end] - rows.theta_rad[first])
        return "way since the last reversal [rad]", "N m", np.minimum(way, 6.0 * term.shape[0]), "direction"
    if name == "current_friction":
        return "torque of the motor [N m]", "N m", rows.torque_nm, "one"
    return None


def _scale(term: EmpiricalTerm, rows: Rows, e: Equations, use: int, kind: str) -> Array:
    """What the curve is multiplied by to be what is left of a window."""
    w = e.windows()[use]
    count = int(np.count_nonzero(w.used))
    if kind == "one":
        return np.ones(count)
    if kind == "direction":
        return np.asarray(np.sign(w.at_centre(rows.speed_rad_s)))
    if kind == "grown":
        parts = columns_of(e, term.family.columns(rows, term.shape))[use]
        assert parts is not None
        return np.asarray(-parts[:, 1])
    order, power, over = term.shape
    speed = w.at_centre(rows.speed_rad_s)
    size = (np.abs(speed) / rows.top_rad_s) ** power * w.bump.transform(order * speed)
    return np.asarray(size * (np.sign(speed) if over else 1.0))
