"""What repeats with the angle: lines of the torque balance in mechanical orders, with the shaft they were fitted with.

Columns are sin and cos of order times angle, smoothed like everything else, so a wandering speed does no harm. A speed
controller that answers the ripple does none either: the measured current is part of the balance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance import shaft_regression
from evenspin.balance.angle_balance import Inertia, Setting, residues_of, shaft_balance
from evenspin.balance.controller import vertex
from evenspin.balance.detection_threshold import least_of, thresholds_of
from evenspin.balance.line_estimate import FoundLine, current_share, estimate_line, widened_intervals
from evenspin.balance.line_search import (
    OrderBank,
    OrderSpectrum,
    Views,
    find_lines,
    fit_lines,
    highest_order,
    line_amplitude,
    shown,
)
from evenspin.balance.motion import Motion
from evenspin.balance.outliers import Outlier, without_outliers
from evenspin.balance.regression import rms
from evenspin.balance.smoothing import Smoother
from evenspin.balance.stretches import Stretches
from evenspin.balance.time_grid import SHAFT, Flags, Grid

Array = NDArray[np.float64]

SIGMA_S = 2.5e-3  # smoothing: short, for lines of some ten hertz; at least SIGMA_ROWS rows
SIGMA_ROWS = 1.2
REST_SHARE = 0.1  # of the median speed: a rotor slower than this on average over REST_S may stick
REST_S = 0.05
LAGS_S = np.arange(-1e-3, 2.01e-3, 0.25e-3)  # of the logged current behind the torque balance
LAG_GAIN = 0.1  # share of the residue that a lag must take away to be believed
ALIGNMENT_ROWS = 0.5
SHOWN = 0.1  # of what the shortest smoothing leaves of a line's power: with less, another part of the log is judged
CLEARER = 1.2  # by which another smoothing has to be clearer to be taken


@dataclass(frozen=True, slots=True)
class AngleResult:
    """`inertia_known`: the log or the model gives J/Kt. Without it amplitudes are not torque."""

    motion: Motion
    rows: Flags
    fit_rows: Flags
    validation_rows: Flags
    highest: int
    spectrum: OrderSpectrum
    lines: tuple[FoundLine, ...]
    fractional: tuple[tuple[float, float], ...]  # (order, A) of lines between the whole orders
    outliers: tuple[Outlier, ...]
    inertia_as2: float
    inertia_half_as2: float
    inertia_known: bool
    drag_a: float
    drag_half_a: float
    before: Array
    after: Array
    before_rms_a: float
    after_rms_a: float
    current_share: float  # of the strongest line, per A of q current: flux harmonics would give about 1 / A of torque


def find_angle_orders(motions: Views, sigma_s: float, setting: Setting, later_s: float = 0.0) -> AngleResult | None:
    """None: too little angle."""
    motion = motions(sigma_s, later_s)
    turning = _turning(motion, setting.stretches)
    highest = highest_order(motion, turning)
    if highest < 2:
        return None
    bank = motions.bank(sigma_s, later_s)
    y, base = shaft_balance(motion, setting)
    thin_y, thin_base = y[:: bank.stride], {name: column[:: bank.stride] for name, column in base.items()}
    rows = bank.rows(turning)
    orders, spectrum = find_lines(bank, thin_base, thin_y, rows, highest)
    found = fit_lines(bank, thin_base, orders, thin_y, rows)
    columns = [*thin_base.values(), *(column for k in orders for column in bank(k))]
    left = thin_y - np.column_stack(columns) @ found.value
    kept_rows, outlier = without_outliers(
        bank.rows(motion.t_s), left, rows, bank.rows(motion.good), rms(motion.iq_a[turning])
    )
    if outlier:
        rows = kept_rows
        orders, spectrum = find_lines(bank, thin_base, thin_y, rows, highest)
        found = fit_lines(bank, thin_base, orders, thin_y, rows)
    lines = tuple(
        estimate_line(k, bank, found, thin_base, thin_y, rows, setting, spectrum) for k in orders if k % 1.0 == 0.0
    )
    if setting.inertia is not None:
        lines = widened_intervals(lines, motions, sigma_s, later_s, setting, rows)
    kept = [each.line.order for each in lines if each.validated]
    full = np.zeros_like(motion.good)
    full[:: bank.stride] = rows
    first, second = full & setting.stretches.fits, full & ~setting.stretches.fits
    before, after = residues_of(bank, base, kept, y, first, setting)
    known = setting.inertia if setting.inertia is not None else Inertia(found["inertia"], found.half("inertia"))
    return AngleResult(
        motion,
        full,
        first,
        second,
        highest,
        spectrum,
        lines,
        tuple((k, line_amplitude(found, k)) for k in orders if k % 1.0),
        outlier,
        known.value_as2,
        known.half_as2,
        setting.inertia is not None,
        found[setting.drive.friction],
        found.half(setting.drive.friction),
        before,
        after,
        rms(before[second]),
        rms(after[second]),
        current_share(bank, thin_base, kept, thin_y, rows, lines),
    )


def best_sigma(motions: Views, tried_s: Sequence[float], setting: Setting) -> tuple[float, dict[int, float]]:
    """The smoothing at which the strongest line stands out most: short for fast lines, long for a noisy angle.

    And the detection threshold of each order, at the smoothing that shows it best.
    """
    thresholds = []
    best, most = min(tried_s, key=lambda sigma_s: abs(sigma_s - SIGMA_S)), 0.0
    shortest = motions(min(tried_s), 0.0)
    turning = _turning(shortest, setting.stretches)
    for sigma_s in tried_s:
        found = find_angle_orders(motions, sigma_s, setting)
        if found is None:
            continue
        bank = motions.bank(sigma_s, 0.0)
        thresholds.append(thresholds_of(bank, bank.rows(found.rows), found.spectrum))
        real = [
            each
            for each in found.lines
            if each.validated
            and shown(found.motion, found.rows, each.line.order) > SHOWN * shown(shortest, turning, each.line.order)
        ]
        distinct = max((each.line.amplitude_a / each.scatter_a for each in real), default=0.0)
        if distinct > CLEARER * most:
            best, most = sigma_s, distinct
    return best, least_of(thresholds)


def _turning(motion: Motion, stretches: Stretches) -> Flags:
    rows = shaft_regression.moving_rows(motion, stretches)
    if not np.any(rows):
        return rows
    rest = Smoother(REST_S, motion.smooth.period_s)(np.abs(motion.raw_speed_rad_s))
    return rows & (rest > REST_SHARE * np.median(np.abs(motion.raw_speed_rad_s[rows])))


def current_lag(grid: Grid, found: AngleResult, setting: Setting) -> float:
    """How much later than the torque balance the logged current is, s: the lag with the smallest residue.

    0 when it makes little difference. Logs write the current of another instant than the angle, and at a ripple of tens
    of hertz a millisecond matters.
    """
    if not found.lines or setting.inertia is None:
        return 0.0
    motion = found.motion
    bank = OrderBank(motion)
    y, base = shaft_balance(motion, setting)
    thin = {name: column[:: bank.stride] for name, column in base.items()}
    rest = (motion.iq_a - y)[:: bank.stride]
    orders, rows = [each.line.order for each in found.lines], bank.rows(found.rows)

    def residue(lag_s: float) -> float:
        late = motion.smooth.every(grid.column(SHAFT, lag_s), bank.stride) - rest
        return rms(fit_lines(bank, thin, orders, late, rows).residual)

    tried = np.array([residue(lag_s) for lag_s in LAGS_S])
    if np.min(tried) > (1.0 - LAG_GAIN) * residue(0.0):
        return 0.0
    return vertex(LAGS_S, tried)
