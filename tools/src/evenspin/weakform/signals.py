"""The columns of a log on an even grid, as the equations take them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.weakform.windows import Bump

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SPEED_S = 2.5e-3  # half width of the bump that makes the speed out of the angle
SPEED_ROWS = 5
GAP_PERIODS = 3.0
FASTEST_HZ = 4500.0  # faster rows are averaged: the equations of the machine are slower
LOAD_S = 25e-3  # over which a measured load is averaged
LOADED = 0.1  # of the rated torque, that a measured load has to move by
SLOW_S = 1.0 / 75.0  # rows further apart do not show what repeats with the angle, nor what a shaft does at its slowest
VOLTAGES = ("vd_v", "vq_v")


@dataclass(frozen=True, slots=True)
class Signals:
    """Rows with an even step. What the drive measured, in its own frame; `speed_rad_s` is made from the angle."""

    name: str
    period_s: float
    t_s: Array
    theta_m_rad: Array  # unwrapped; integrated from the speed where no angle was recorded
    has_angle: bool
    speed_rad_s: Array
    id_a: Array
    iq_a: Array
    vd_v: Array | None
    vq_v: Array | None
    vdc_v: Array | None
    load_nm: Array
    has_load: bool
    has_id: bool
    good: Flags  # no gap in time, every value there
    one_travel: bool = True  # the angle counts from the same place in all rows

    @property
    def shows_orders(self) -> bool:
        """Whether what repeats with the angle is more than a beat with the rows."""
        return self.has_angle and self.period_s < SLOW_S

    @property
    def has_voltages(self) -> bool:
        return self.vd_v is not None and self.vq_v is not None

    def loaded(self, rated_nm: float) -> bool:
        """Whether a load was measured that moves: a column of noise fixes no torque per ampere."""
        rows = max(1, round(LOAD_S / self.period_s))
        count = len(self.load_nm) // rows
        if not self.has_load or count < 2:
            return False
        low, high = np.percentile(_mean(self.load_nm[: count * rows], rows), (2.0, 98.0))
        return bool(high - low > LOADED * rated_nm)

    def __len__(self) -> int:
        return len(self.t_s)


def signals_of(name: str, columns: Mapping[str, Array]) -> Signals:
    """From the columns of a log in SI units; `theta_m_rad` is unwrapped."""
    t_s = columns["t_s"]
    period_s = float(np.median(np.diff(t_s)))
    count = int(np.floor((t_s[-1] - t_s[0]) / period_s + 1e-6)) + 1
    grid_s = t_s[0] + period_s * np.arange(count)
    wanted = ("theta_m_rad", "speed_rad_s", "id_a", "iq_a", *VOLTAGES, "vdc_v", "load_torque_nm")
    even: dict[str, Array] = {}
    good: Any = np.ones(count, dtype=bool)
    for key in wanted:
        values = columns.get(key)
        if values is None or not np.isfinite(values).any():
            continue
        there = np.isfinite(values)
        even[key] = np.interp(grid_s, t_s[there], values[there])
        if not there.all():
            good &= np.interp(grid_s, t_s, (~there).astype(float)) == 0.0
    late = np.flatnonzero(np.diff(t_s) > GAP_PERIODS * period_s)
    for k in late:
        good = np.asarray(good & ((grid_s <= t_s[k]) | (grid_s >= t_s[k + 1])))
    step = max(1, int(np.floor(1.0 / (period_s * FASTEST_HZ))))
    if step > 1:
        rows = count // step * step
        even = {key: _mean(values[:rows], step) for key, values in even.items()}
        good = good[:rows].reshape(-1, step).all(axis=1)
        grid_s, period_s = _mean(grid_s[:rows], step), period_s * step
    has_angle = "theta_m_rad" in even
    if has_angle:
        theta = even["theta_m_rad"]
        speed = smoothed_slope(theta, period_s)
    else:
        speed = even["speed_rad_s"]
        theta = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * period_s)))
    zero = np.zeros(len(grid_s))
    return Signals(
        name,
        period_s,
        grid_s,
        theta,
        has_angle,
        speed,
        even.get("id_a", zero),
        even["iq_a"],
        even.get("vd_v"),
        even.get("vq_v"),
        even.get("vdc_v"),
        even.get("load_torque_nm", zero),
        "load_torque_nm" in even,
        "id_a" in even,
        good,
    )


def joined(name: str, parts: Sequence[Signals]) -> Signals:
    """Records of one drive by one clock, one after the other; no window reaches from one into the next. The angle of
    each counts from where it was when it began."""

    def chained(values: Callable[[Signals], Array]) -> Array:
        return np.concatenate([values(part) for part in parts])

    def all_have(values: Callable[[Signals], Array | None]) -> Array | None:
        found = [part for part in map(values, parts) if part is not None]
        return np.concatenate(found) if len(found) == len(parts) else None

    good = [part.good.copy() for part in parts]
    for flags in good:
        flags[0] = False
    return Signals(
        name,
        parts[0].period_s,
        chained(lambda s: s.t_s),
        chained(lambda s: s.theta_m_rad),
        all(part.has_angle for part in parts),
        chained(lambda s: s.speed_rad_s),
        chained(lambda s: s.id_a),
        chained(lambda s: s.iq_a),
        all_have(lambda s: s.vd_v),
        all_have(lambda s: s.vq_v),
        all_have(lambda s: s.vdc_v),
        chained(lambda s: s.load_nm),
        any(part.has_load for part in parts),
        all(part.has_id for part in parts),
        np.concatenate(good),
        one_travel=False,
    )


def smoothed_slope(values: Array, period_s: float) -> Array:
    """Derivative of every row, smoothed over a few of them."""
    bump = Bump.of(max(SPEED_S, SPEED_ROWS * period_s), period_s)
    inner = np.convolve(values, bump.slope[::-1], mode="valid")
    return np.asarray(np.concatenate((np.full(bump.half, inner[0]), inner, np.full(bump.half, inner[-1]))))


def _mean(values: Array, step: int) -> Array:
    return np.asarray(values.reshape(-1, step).mean(axis=1))
