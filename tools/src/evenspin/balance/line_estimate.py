"""One line over the angle: amplitude, phase, interval, and whether all parts of the log have it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.balance import shaft_regression
from evenspin.balance.angle_balance import Setting, shaft_balance
from evenspin.balance.line_agreement import in_one_only, part_of_line, same_line
from evenspin.balance.line_search import (
    ABOVE_NOISE,
    OrderBank,
    OrderSpectrum,
    Views,
    fit_lines,
    line_amplitude,
    names_of,
)
from evenspin.balance.nominal_model import Line
from evenspin.balance.regression import Fit
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]


ONE_SPEED_BAND = 0.1  # of a speed: rows within it count as one speed


@dataclass(frozen=True, slots=True)
class FoundLine:
    """Braking torque A sin(order theta + phase) with the half width of the 95 % interval of A."""

    line: Line
    half_a: float
    scatter_a: float  # the part of it that the fit alone gives
    noise_a: float
    agree: float  # difference of the line between the first and the second part of the log, relative
    both: bool  # stands out in each of them, at whatever phase
    one_speed: bool  # is there near one speed and not at the others: a frequency, no torque of the shaft
    validated: bool  # the same in both parts, and in the stretches that fit and those that validate


def estimate_line(
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
    near = _near_one_speed(bank.rows(setting.stretches.slow_rad_s)[rows], np.sum(own**2, axis=1))
    noise_a = float(spectrum.noise_a[np.searchsorted(spectrum.order, k)])
    parts, sets, speeds = (
        [part_of_line(own, alone, part, noise_a) for part in (mask, ~mask)] for mask in (early, fits, near)
    )
    agree = abs(parts[0].phasor - parts[1].phasor) / amplitude
    both = min(abs(part.phasor) for part in parts) > ABOVE_NOISE * noise_a
    same = same_line(amplitude, *parts) and same_line(amplitude, *sets)
    one_speed = same and in_one_only(amplitude, *speeds)  # a line that moved in time differs between speeds as well
    validated = same and not one_speed
    line = Line(k, amplitude, float(np.arctan2(c, s)))
    return FoundLine(line, half, half, noise_a, agree, both, one_speed, validated)


def _near_one_speed(slow_rad_s: Array, weight: Array) -> Flags:
    """Rows near the speed that decides the line. A frequency (a beat of encoder counts with the rows, the mains) is an
    order of the angle at one speed only, and torque of the shaft is the same order at every speed."""
    speed = np.abs(slow_rad_s)
    rank = np.argsort(speed)
    share = np.cumsum(weight[rank])
    deciding = float(speed[rank[min(np.searchsorted(share, 0.5 * share[-1]), len(rank) - 1)]])
    return np.abs(speed - deciding) < ONE_SPEED_BAND * deciding


def widened_intervals(
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
        y, base = shaft_balance(motion, replace(setting, inertia=other))
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
                shaft_regression.MACHINE * each.line.amplitude_a,
            ),
        )
        for each in lines
    )


def current_share(
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
