"""What repeats with the angle: lines of the torque balance in mechanical orders, with the shaft they were fitted with.

Columns are sin and cos of order times angle, smoothed like everything else, so a wandering speed does no harm. A speed
controller that answers the ripple does none either: the measured current is part of the balance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.balance import shaft
from evenspin.balance.agreement import part_of_line, same_line
from evenspin.balance.angle_zero import find_zero, with_zero
from evenspin.balance.controller import vertex
from evenspin.balance.detection import least_of, thresholds_of
from evenspin.balance.friction import FrictionResult, again
from evenspin.balance.grid import SHAFT, Flags, Grid, Smoother
from evenspin.balance.lines import (
    ABOVE_NOISE,
    OrderBank,
    OrderSpectrum,
    Views,
    find_lines,
    fit_lines,
    highest_order,
    line_amplitude,
    names_of,
    shown,
)
from evenspin.balance.motion import Motion
from evenspin.balance.nominal import Line, Nominal, torque_of
from evenspin.balance.odd import Odd, without_odd
from evenspin.balance.regression import Fit, fit, rms
from evenspin.balance.shaft import Drive
from evenspin.balance.stretches import Stretches

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
class FoundLine:
    """Braking torque A sin(order theta + phase) with the half width of the 95 % interval of A."""

    line: Line
    half_a: float
    scatter_a: float  # the part of it that the fit alone tells
    noise_a: float
    agree: float  # difference of the first and the second part of what the log tells of this line, relative
    both: bool  # stands out in each of them, at whatever phase
    validated: bool  # the same in both parts, and in the stretches that fit and those that validate


@dataclass(frozen=True, slots=True)
class AngleResult:
    """`inertia_known`: the log or the model tells J/Kt. Without it amplitudes are not torque."""

    motion: Motion
    rows: Flags
    fit_rows: Flags
    validation_rows: Flags
    highest: int
    spectrum: OrderSpectrum
    lines: tuple[FoundLine, ...]
    strange: tuple[tuple[float, float], ...]  # (order, A) of lines between the whole orders
    odd_s: tuple[Odd, ...]
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


@dataclass(frozen=True, slots=True)
class Inertia:
    """J/Kt from the joint fit of the shaft, or from the model."""

    value_as2: float
    half_as2: float


@dataclass(frozen=True, slots=True)
class Setting:
    """Everything but the motion that lines are judged with."""

    nominal: Nominal | None
    drive: Drive
    stretches: Stretches
    inertia: Inertia | None
    shift_s: float  # how far apart in time current and motion of one row may be
    friction: FrictionResult | None = None  # with values of the whole log


def weigh_orders(motions: Views, sigma_s: float, setting: Setting, later_s: float = 0.0) -> AngleResult | None:
    """None: too little angle."""
    motion = motions(sigma_s, later_s)
    turning = _turning(motion, setting.stretches)
    highest = highest_order(motion, turning)
    if highest < 2:
        return None
    bank = motions.bank(sigma_s, later_s)
    y, base = _balance(motion, setting)
    thin_y, thin_base = y[:: bank.stride], {name: column[:: bank.stride] for name, column in base.items()}
    rows = bank.rows(turning)
    orders, spectrum = find_lines(bank, thin_base, thin_y, rows, highest)
    found = fit_lines(bank, thin_base, orders, thin_y, rows)
    columns = [*thin_base.values(), *(column for k in orders for column in bank(k))]
    left = thin_y - np.column_stack(columns) @ found.value
    kept_rows, odd = without_odd(bank.rows(motion.t_s), left, rows, bank.rows(motion.good), rms(motion.iq_a[turning]))
    if odd:
        rows = kept_rows
        orders, spectrum = find_lines(bank, thin_base, thin_y, rows, highest)
        found = fit_lines(bank, thin_base, orders, thin_y, rows)
    lines = tuple(_line(k, bank, found, thin_base, thin_y, rows, setting, spectrum) for k in orders if k % 1.0 == 0.0)
    if setting.inertia is not None:
        lines = _widened(lines, motions, sigma_s, later_s, setting, rows)
    kept = [each.line.order for each in lines if each.validated]
    full = np.zeros_like(motion.good)
    full[:: bank.stride] = rows
    first, second = full & setting.stretches.fits, full & ~setting.stretches.fits
    before, after = _residues(bank, base, kept, y, first, setting)
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
        odd,
        known.value_as2,
        known.half_as2,
        setting.inertia is not None,
        found[setting.drive.friction],
        found.half(setting.drive.friction),
        before,
        after,
        rms(before[second]),
        rms(after[second]),
        _current_share(bank, thin_base, kept, thin_y, rows, lines),
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
        found = weigh_orders(motions, sigma_s, setting)
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
        sure = max((each.line.amplitude_a / each.scatter_a for each in real), default=0.0)
        if sure > CLEARER * most:
            best, most = sigma_s, sure
    return best, least_of(thresholds)


def _turning(motion: Motion, stretches: Stretches) -> Flags:
    rows = shaft.moving_rows(motion, stretches)
    if not np.any(rows):
        return rows
    rest = Smoother(REST_S, motion.smooth.period_s)(np.abs(motion.raw_speed_rad_s))
    return rows & (rest > REST_SHARE * np.median(np.abs(motion.raw_speed_rad_s[rows])))


def _balance(motion: Motion, setting: Setting) -> tuple[Array, dict[str, Array]]:
    """What the lines have to explain, and the columns of the shaft beside them."""
    given = with_zero(setting.nominal, None) if setting.nominal is not None else None
    y = motion.iq_a - shaft.known_part(motion, given)
    used = [*shaft.base_terms(motion, setting.drive), *shaft.dry_terms(motion, setting.drive)]
    base = {term.effect: term.columns[0] for term in used}
    if setting.inertia is not None:
        known = given.inertia_as2 if given is not None else 0.0
        y = y - (setting.inertia.value_as2 - known) * base.pop("inertia")
    return y, base


def current_lag(grid: Grid, found: AngleResult, setting: Setting) -> float:
    """How much later than the torque balance the logged current is, s: the lag with the smallest residue.

    0 when it makes little difference. Logs write the current of another instant than the angle, and at a ripple of tens
    of hertz a millisecond matters.
    """
    if not found.lines or setting.inertia is None:
        return 0.0
    motion = found.motion
    bank = OrderBank(motion)
    y, base = _balance(motion, setting)
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


def _residues(
    bank: OrderBank, base: dict[str, Array], kept: Sequence[float], y: Array, first: Flags, setting: Setting
) -> tuple[Array, Array]:
    """Without and with what was found, over the whole grid; the stretches that fit tell the coefficients."""
    motion, nominal = bank.motion, setting.nominal
    shaft_part = _shaft_part(motion, setting, base)
    lines: dict[str, tuple[Array, ...]] = {f"line_{k:g}": bank.whole(k) for k in kept}
    if shaft_part is not None:  # friction is that of the whole log, as it is written
        after = _rest(lines, y - shaft_part, first)[0] if lines else y - shaft_part
        inner = None
    else:
        shaft_columns: dict[str, tuple[Array, ...]] = {name: (column,) for name, column in base.items()}
        after, inner = _rest(shaft_columns | lines, y, first)
    if inner is not None and "inertia" in base:  # the same inertia before and after: the one that the lines do not bend
        y = y - inner["inertia"] * base["inertia"]
    if nominal is not None:
        before = y
        if nominal.inertia_as2 > 0.0 and setting.inertia is not None:
            before = before + (setting.inertia.value_as2 - nominal.inertia_as2) * motion.accel_rad_s2
        zero_rad = find_zero(motion, nominal.lines, before, first)
        if zero_rad is not None and motion.theta_rad is not None:
            before = before - motion.smooth(torque_of(with_zero(nominal, zero_rad).lines, motion.theta_rad))
        return before, after
    own = [name for name in base if name == "viscous_friction"] or [setting.drive.friction]
    return _rest({name: (base[name],) for name in own}, y, first)[0], after


def _shaft_part(motion: Motion, setting: Setting, base: dict[str, Array]) -> Array | None:
    """Friction and load as they were found beside the lines; None where the inertia is not known."""
    found = setting.friction
    if found is None or "inertia" in base:
        return None
    columns = [
        (name, column)
        for term in (again(term, motion) for term in found.terms if term.effect != "inertia")
        for name, column in zip(shaft.names_of([term]), term.columns, strict=True)
    ]
    return sum((found.final[name] * column for name, column in columns), np.zeros_like(motion.iq_a))


def _rest(columns: dict[str, tuple[Array, ...]], y: Array, first: Flags) -> tuple[Array, Fit]:
    names = [f"{name}_{i}" if len(group) > 1 else name for name, group in columns.items() for i in range(len(group))]
    flat = [column for group in columns.values() for column in group]
    found = fit(names, [column[first] for column in flat], y[first])
    return y - np.column_stack(flat) @ found.value, found


def _line(
    k: float, bank: OrderBank, found: Fit, base: dict[str, Array], y: Array, rows: Flags, setting: Setting,
    spectrum: OrderSpectrum,
) -> FoundLine:  # fmt: skip
    """With all else as the joint fit has it, the line of two parts of the log that know equally much of it."""
    s, c = (found[name] for name in names_of([k]))
    amplitude = float(np.hypot(s, c))
    half = max(found.half(name) for name in names_of([k]))
    own = np.column_stack([column[rows] for column in bank(k)])
    alone = found.residual + own @ np.array([s, c])
    weight = np.cumsum(np.sum(own**2, axis=1))
    early = weight < 0.5 * weight[-1]
    fits = bank.rows(setting.stretches.fits)[rows]
    parts, sets = ([part_of_line(own, alone, part) for part in (mask, ~mask)] for mask in (early, fits))
    noise_a = float(spectrum.noise_a[np.searchsorted(spectrum.order, k)])
    agree = abs(parts[0].phasor - parts[1].phasor) / amplitude
    both = min(abs(part.phasor) for part in parts) > ABOVE_NOISE * noise_a
    validated = same_line(amplitude, *parts) and same_line(amplitude, *sets)
    return FoundLine(Line(k, amplitude, float(np.arctan2(c, s))), half, half, noise_a, agree, both, validated)


def _widened(
    lines: tuple[FoundLine, ...], motions: Views, sigma_s: float, later_s: float, setting: Setting, rows: Flags
) -> tuple[FoundLine, ...]:
    """Intervals with what the inertia may be off by, half a row between current and angle, and the machine itself."""
    assert setting.inertia is not None
    if not lines:
        return lines
    orders = [each.line.order for each in lines]
    inertia = setting.inertia
    off: list[dict[float, float]] = []
    cases = [(replace(inertia, value_as2=inertia.value_as2 + side * inertia.half_as2), 0.0) for side in (-1.0, 1.0)]
    cases += [(inertia, side * setting.shift_s) for side in (-1.0, 1.0)]
    for other, shift_s in cases:
        motion = motions(sigma_s, later_s + shift_s)
        bank = OrderBank(motion)
        y, base = _balance(motion, replace(setting, inertia=other))
        thin = {name: column[:: bank.stride] for name, column in base.items()}
        found = fit_lines(bank, thin, orders, y[:: bank.stride], rows)
        off.append({k: line_amplitude(found, k) for k in orders})
    return tuple(
        replace(
            each,
            half_a=math.hypot(
                each.half_a,
                *(
                    max(abs(case[each.line.order] - each.line.amplitude_a) for case in pair)
                    for pair in (off[:2], off[2:])
                ),
                shaft.MACHINE * each.line.amplitude_a,
            ),
        )
        for each in lines
    )


def _current_share(
    bank: OrderBank, base: dict[str, Array], kept: Sequence[float], y: Array, rows: Flags, lines: Sequence[FoundLine]
) -> float:
    """Change of the strongest line per ampere of q current, relative to the line: 0 for cogging."""
    if not kept:
        return 0.0
    motion, k = bank.motion, kept[0]
    iq = motion.iq_a - np.mean(motion.iq_a)
    wave = iq * bank.wave(k)
    smooth = motion.smooth.every(wave, bank.stride)
    found = fit_lines(bank, base | {"iq_0": smooth.imag, "iq_1": smooth.real}, kept, y, rows)
    strongest = max((each.line.amplitude_a for each in lines), default=0.0)
    return float(np.hypot(found["iq_0"], found["iq_1"])) / max(strongest, 1e-12)
