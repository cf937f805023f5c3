"""Torque tied to the angle from slow turns: orders, magnitudes and phases of its lines.

    T(theta) = mean + sum_i L_i sin(w_i theta + phi_i)

The log's first turn is skipped, the others are cut to whole turns and averaged in cells of the angle.
A spectrum finds the lines, least squares over all of them refine order, magnitude and phase: far below the resolution
of 1 / turns. Phases hold at angle 0 of the log's first turn.

Source   Yeh and Liu 2024, section 2.1 (spatial FFT of slow turns).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from evenspin.errors import InputError
from evenspin.identify.estimate import Array, Estimate, nonlinear
from evenspin.identify.source import TURN_RAD, Run

CELLS = 1024  # per turn
MAX_LINES = 6  # as many as the drive knows
ABOVE_FLOOR = 8.0  # a line stands out of the median of the spectrum by this
ABOVE_LARGEST = 0.03  # and is at least this part of the largest
SKIPPED_TURNS = 1
PACES = 16  # per turn: every part must take about the same time
UNEVEN = 1.5
WHERE = "identify cogging"


@dataclass(frozen=True, slots=True)
class Line:
    """One sine over the angle."""

    cycles: Estimate
    amplitude_nm: Estimate
    phase_rad: Estimate
    snapped: bool = False


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Lines, largest first; `theta_rad` and `torque_nm` are the cells, `fit_nm` the model there."""

    lines: Sequence[Line]
    turns: int
    theta_rad: Array
    torque_nm: Array
    fit_nm: Array
    order: Array
    amplitude_nm: Array

    @property
    def resolution(self) -> float:
        return 1.0 / self.turns


def identify_lines(run: Run, *, snap: bool = False, max_lines: int = MAX_LINES) -> Spectrum:
    """`snap`: lines within the resolution of a whole order become that order."""
    theta, torque, turns = _cells(run)
    order, amplitude = _amplitudes(torque, turns)
    starts = _peaks(order, amplitude, max_lines)
    if not starts:
        raise InputError(WHERE, "spectrum", "no line", "with a line above the noise", "record more turns, more slowly")
    lines, fit = _refine(theta, torque, starts, {})
    if snap:
        whole = {i: round(line.cycles.value) for i, line in enumerate(lines) if _near(line, turns)}
        lines, fit = _refine(theta, torque, [line.cycles.value for line in lines], whole)
    ordered = sorted(lines, key=lambda line: -line.amplitude_nm.value)
    return Spectrum(ordered, turns, theta, torque, fit, order, amplitude)


def _near(line: Line, turns: int) -> bool:
    whole = round(line.cycles.value)
    return whole > 0 and abs(line.cycles.value - whole) < 1.0 / turns


def _cells(run: Run) -> tuple[Array, Array, int]:
    """Torque averaged in cells of the angle, over whole turns after the first."""
    travel = np.abs(run.theta_rad - run.theta_rad[0])
    turns = int(np.floor(travel.max() / TURN_RAD + 1e-3)) - SKIPPED_TURNS
    if turns < 1:
        must = f"at least {SKIPPED_TURNS + 1} (the first is skipped)"
        raise InputError(WHERE, "turns", f"{travel.max() / TURN_RAD:.2f}", must, "record longer")
    if (np.diff(run.theta_rad) * np.sign(run.theta_rad[-1] - run.theta_rad[0])).min() < -TURN_RAD / CELLS:
        raise InputError(WHERE, "direction", "both", "one", "turn slowly in one direction")
    _check_pace(run, travel)
    # cells are counted from angle 0 of the log, not from where the run began: phases hold there
    index = np.floor(run.theta_rad * (CELLS / TURN_RAD)).astype(int)
    forward = run.theta_rad[-1] > run.theta_rad[0]
    first = index[0] + (SKIPPED_TURNS * CELLS if forward else -(SKIPPED_TURNS + turns) * CELLS)
    inside = (index >= first) & (index < first + turns * CELLS)
    cell = index[inside] - first
    count = np.bincount(cell, minlength=turns * CELLS)
    filled = count > 0
    if filled.mean() < 0.5:
        given = f"{run.turns / (len(run.theta_rad) * run.ts_s):.3g} turns per s"
        raise InputError(WHERE, "speed", given, "slower, for this log rate", "a few turns per minute")
    torque = np.bincount(cell, run.torque_nm[inside], turns * CELLS) / np.maximum(count, 1)
    angle = np.bincount(cell, run.theta_rad[inside], turns * CELLS) / np.maximum(count, 1)
    grid = (first + np.arange(turns * CELLS) + 0.5) * TURN_RAD / CELLS
    angle = np.where(filled, angle, grid)
    torque = np.interp(angle, angle[filled], torque[filled])
    return angle, torque, turns


def _check_pace(run: Run, travel: Array) -> None:
    """Inertia and friction must not appear as a torque tied to the angle: the speed has to be constant."""
    cuts = np.arange(SKIPPED_TURNS * TURN_RAD, travel.max(), TURN_RAD / PACES)
    paces = np.diff(np.searchsorted(np.maximum.accumulate(travel), cuts))
    if len(paces) and paces.max() > UNEVEN * max(paces.min(), 1):
        slow, fast = (TURN_RAD / PACES / run.ts_s / max(n, 1) for n in (paces.max(), paces.min()))
        given = f"{slow:.3g} .. {fast:.3g} rad/s"
        raise InputError(WHERE, "speed", given, "constant", "hold one slow speed for some turns")


def _amplitudes(torque: Array, turns: int) -> tuple[Array, Array]:
    """Spectrum with a Hann window, four points per line of 1 / turns."""
    window = np.hanning(len(torque) + 1)[:-1]
    padded = 4 * len(torque)
    lines = 2.0 * np.abs(np.fft.rfft((torque - torque.mean()) * window, padded)) / window.sum()
    order = np.arange(len(lines)) / (4.0 * turns)
    keep = order <= CELLS / 8.0
    return order[keep], lines[keep]


def _peaks(order: Array, amplitude: Array, most: int) -> list[float]:
    floor = np.median(amplitude)
    largest = amplitude[order >= 0.5].max(initial=0.0)
    found = [
        i
        for i in range(1, len(order) - 1)
        if order[i] >= 0.5
        and amplitude[i] >= amplitude[i - 1]
        and amplitude[i] > amplitude[i + 1]
        and amplitude[i] > max(ABOVE_FLOOR * floor, ABOVE_LARGEST * largest)
    ]
    found.sort(key=lambda i: -amplitude[i])
    return [float(order[i]) for i in found[:most]]


def _refine(theta: Array, torque: Array, starts: Sequence[float], whole: dict[int, int]) -> tuple[list[Line], Array]:
    """Least squares over [mean, (order, sine, cosine) of each line]; orders in `whole` are given."""
    middle = float(theta.mean())  # around the middle order and phase do not depend on each other
    orders = np.array([whole.get(i, start) for i, start in enumerate(starts)], dtype=float)
    phases = np.outer(theta, orders)
    columns = np.hstack((np.ones((len(theta), 1)), np.sin(phases), np.cos(phases)))
    first = np.linalg.lstsq(columns, torque, rcond=None)[0]
    n = len(orders)
    free = [i for i in range(n) if i not in whole]

    def orders_of(p: Array) -> Array:
        result = orders.copy()
        result[free] = p[1 + 2 * n :]
        return result

    def model(p: Array) -> Array:
        angles = np.outer(theta - middle, orders_of(p))
        return p[0] + np.sin(angles) @ p[1 : 1 + n] + np.cos(angles) @ p[1 + n : 1 + 2 * n]

    # from angle 0 to the middle
    a, b = first[1 : 1 + n], first[1 + n :]
    turn = orders * middle
    sine, cosine = a * np.cos(turn) - b * np.sin(turn), a * np.sin(turn) + b * np.cos(turn)
    start = [float(first[0]), *sine, *cosine, *orders[free]]
    unbounded = [np.inf] * len(start)
    estimates, residual = nonlinear(model, start, [-x for x in unbounded], unbounded, torque)
    lines = []
    for i in range(n):
        s, c = estimates[1 + i], estimates[1 + n + i]
        cycles = estimates[1 + 2 * n + free.index(i)] if i in free else Estimate(orders[i], 0.0)
        size = float(np.hypot(s.value, c.value))
        half = float(np.hypot(s.half, c.half)) / np.sqrt(2.0)
        phase = float(np.arctan2(c.value, s.value)) - cycles.value * middle
        sure = float(np.hypot(half / max(size, 1e-12), cycles.half * middle))
        wrapped = float(np.angle(np.exp(1j * phase)))
        lines.append(Line(cycles, Estimate(size, half), Estimate(wrapped, sure), i in whole))
    return lines, torque - residual
