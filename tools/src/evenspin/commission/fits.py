"""From samples to the numbers of a motor, each with half of its 95 % interval.

Winding, d axis, T = PWM period; a voltage acts in the period after its sample:

    i[k+2] = a i[k+1] + (1 - a) / R v[k] + c,   a = exp(-R T / L)                                        (1)

Shaft, between two instants, in ampere of q current (k = 1.5 p psi), for each stretch:

    J/k (w2 - w1) + B/k (th2 - th1) + C/k * integral of sgn(w) = integral of iq                           (2)

which needs no derivative of the angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.bench.errors import DriveFaultError
from evenspin.identify.estimate import Estimate, linear

Array = NDArray[np.float64]

LAG = 5  # rows from a reference of the current to the current
OVERLAP = 4  # windows in the length of one
STANDING = 0.01  # of the largest speed


@dataclass(frozen=True, slots=True)
class Winding:
    """Of one axis. `left`: rms of the current that (1) does not explain, over the rms of its change."""

    inductance_h: Estimate
    left: float


def inductance(current_a: Array, voltage_v: Array, resistance_ohm: float, period_s: float) -> Winding:
    """(1), with R known.

    The noise of the current would pull `a` towards 0. Its instrument is the current that the voltages alone explain:
    the fit is repeated with (1) simulated instead of the measured current, until the two agree.
    """
    i, v = current_a - current_a[0], voltage_v
    rows = len(i) - 2
    constant = np.ones(rows)
    columns = [constant]
    driven = v[:-2] / resistance_ohm
    seen = i[1:-1]
    a, spread = 0.9, math.inf
    for _ in range(30):
        # i[k+2] - driven = a (i[k+1] - driven) + ...
        x = np.column_stack([i[1:-1] - driven, *columns])
        z = np.column_stack([seen - driven, *columns])
        y = i[2:] - driven
        solution = np.linalg.lstsq(z.T @ x, z.T @ y, rcond=None)[0]
        left = y - x @ solution
        before, a = a, float(min(max(solution[0], 1e-6), 1.0 - 1e-9))
        inverse = np.linalg.pinv(z.T @ x)
        covariance = inverse @ (z.T @ z) @ inverse.T * float(left @ left) / max(rows - x.shape[1], 1)
        spread = 1.96 * math.sqrt(max(float(covariance[0, 0]), 0.0))
        seen = _simulated(a, solution[1:], columns, driven, float(np.mean(i[:2])))
        if abs(a - before) < 1e-9:
            break
    value = -resistance_ohm * period_s / math.log(a)
    half = resistance_ohm * period_s / (a * math.log(a) ** 2) * spread
    change = float(np.std(i)) or math.inf
    return Winding(Estimate(value, half), float(np.std(left)) / change)


def _simulated(a: float, rest: Array, columns: list[Array], driven: Array, first: float) -> Array:
    """Current of (1) from its voltages alone; row k is i[k+1]."""
    push = (1.0 - a) * driven + sum(weight * column for weight, column in zip(rest, columns, strict=True))
    out = np.empty(len(driven))
    now = first
    for k, value in enumerate(push):
        out[k] = now
        now = a * now + value
    return out


def edges(
    taken: Array,
    period_s: float,
    window: int,
    resistance_ohm: float | None = None,
    emf_vs_per_rad: float | None = None,
) -> tuple[Estimate, Estimate]:
    """(L, R) from a current that is switched to and fro (columns: current, voltage, angle of the shaft,
    reference of the current):

        T sum(v) = L (i2 - i1) + R T sum(i) + c n T + p psi (th2 - th1)                                    (3)

    over windows of n rows, since the integral of the back-EMF is the flux that passes, however the shaft moves.
    R given: only L is looked for. `emf_vs_per_rad`: p psi, when it is known; an angle in steps would pull its estimate
    towards 0.
    The noise of a small current would make L too large: the reference, which has none, is the instrument of its change.
    """
    current_a, voltage_v, theta_rad, reference_a = taken.T
    v = np.concatenate(([0.0], np.cumsum(voltage_v)))
    i = np.concatenate(([0.0], np.cumsum(0.5 * (current_a[1:] + current_a[:-1]))))
    first = np.arange(LAG, len(current_a) - window - 2, max(window // 8, 1))
    last = first + window
    # The voltage of row k acts from row k + 1 to row k + 2.
    flux_vs = period_s * (v[last - 1] - v[first - 1])
    impulse = period_s * (i[last] - i[first])
    change = reference_a[last - LAG] - reference_a[first - LAG]
    columns = [current_a[last] - current_a[first], np.full(len(first), window * period_s)]
    travel = theta_rad[last] - theta_rad[first]
    if emf_vs_per_rad is not None:
        flux_vs = flux_vs - emf_vs_per_rad * travel
    elif np.ptp(taken[:, 2]) > 0.0:
        columns.append(travel)
    if resistance_ohm is None:
        found = _by_instrument(np.column_stack([columns[0], impulse, *columns[1:]]), change, flux_vs)
        return found[0], found[1]
    found = _by_instrument(np.column_stack(columns), change, flux_vs - resistance_ohm * impulse)
    return _between_samples(found[0], resistance_ohm, period_s), Estimate(resistance_ohm, 0.0)


def _between_samples(found: Estimate, resistance_ohm: float, period_s: float) -> Estimate:
    """The mean of two samples is not that of an exponential between them: in (3) L becomes R T (1 / (1 - a) - 1/2)."""
    a = 1.0 - 1.0 / (max(found.value, 1e-12) / (resistance_ohm * period_s) + 0.5)
    if not 0.0 < a < 1.0:
        return found
    value = -resistance_ohm * period_s / math.log(a)
    return Estimate(value, found.half * value / found.value)


def _by_instrument(columns: Array, instrument: Array, values: Array) -> list[Estimate]:
    """The first column holds noise: it is identified by what makes it change and has none."""
    z = np.column_stack((instrument, columns[:, 1:]))
    weights = np.linalg.pinv(z.T @ columns)
    solution = weights @ (z.T @ values)
    left = values - columns @ solution
    covariance = weights @ (z.T @ z) @ weights.T * float(left @ left) / max(len(values), 1) / 0.1  # windows overlap
    half = 1.96 * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return [Estimate(float(value), float(h)) for value, h in zip(solution, half, strict=True)]


@dataclass(frozen=True, slots=True)
class Flux:
    """`angle_rad`: by how much the drive's d axis leads that of the magnets, electrical."""

    psi_wb: Estimate
    angle_rad: Estimate
    lq_h: Estimate


def flux(
    theta_e_rad: Array,
    id_a: Array,
    iq_a: Array,
    vd_v: Array,
    vq_v: Array,
    use: Array,
    rate_hz: float,
    window: int,
    ld_h: float,
) -> Flux:
    """Voltage equations over windows of so many rows, all of them in `use`, th the electrical angle:

        sum(vq) T = psi cos (th2 - th1) + Ld sum(id we) T + Lq (iq2 - iq1) + R' sum(iq) T + c sum(sgn we) T
        sum(vd) T = -psi sin (th2 - th1) - Lq sum(iq we) T + R'' sum(id) T + c T                             (4)

    R' is left free: beside the resistance it holds the lag of the angle that an acceleration makes.
    """  # fmt: skip
    period = 1.0 / rate_hz
    we = np.convolve(np.gradient(theta_e_rad) * rate_hz, np.ones(5) / 5.0, "same")
    first = np.arange(2, len(use) - window - 2, max(window // 2, 1))
    inside = np.concatenate(([0], np.cumsum(use)))
    first = first[inside[first + window + 1] - inside[first] == window + 1]
    if len(first) < 12 and window > 5:
        return flux(theta_e_rad, id_a, iq_a, vd_v, vq_v, use, rate_hz, window // 2, ld_h)
    if len(first) < 12:
        raise DriveFaultError(
            "spin: too few rows with a steady current; is the shaft blocked, or does it turn by fits?"
        )

    def total(values: Array) -> Array:
        sums = np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1])))) * period
        return sums[first + window] - sums[first]

    def change(values: Array) -> Array:
        smooth = np.convolve(values, np.ones(3) / 3.0, "same")
        return smooth[first + window] - smooth[first]

    travel = change(theta_e_rad)
    ones = np.ones_like(we)
    columns = np.column_stack((travel, change(iq_a), total(iq_a), total(np.sign(we))))
    (along, *_), _ = linear(columns, total(vq_v) - ld_h * total(id_a * we), 0.5)
    columns = np.column_stack((travel, -total(iq_a * we), total(id_a), total(ones)))
    (across, lq, *_), _ = linear(columns, total(vd_v), 0.5)
    psi = math.hypot(along.value, across.value)
    angle = math.atan2(-across.value, along.value)
    return Flux(Estimate(psi, along.half), Estimate(angle, across.half / psi), lq)


@dataclass(frozen=True, slots=True)
class Mechanics:
    """Per ampere of q current; `left`: rms of what (2) leaves, over the rms of the current impulse."""

    inertia: Estimate
    viscous: Estimate
    coulomb: Estimate
    left: float


def mechanics(theta_rad: Array, iq_a: Array, rate_hz: float, window: int, steady: NDArray[np.bool_]) -> Mechanics:
    """(2) over windows of so many rows. `steady`: rows away from a change of the current, where the speed bends."""
    slope = np.arange(3, -4, -1) * rate_hz / 28.0  # of a straight line through seven rows
    speed = np.convolve(theta_rad, slope, "same")
    speed[:3], speed[-3:] = speed[3], speed[-4]
    push, way = np.cumsum(iq_a) / rate_hz, np.cumsum(np.sign(speed)) / rate_hz
    first = np.arange(4, len(theta_rad) - window - 4, max(window // OVERLAP, 1))
    last = first + window
    standing = np.concatenate(([0], np.cumsum(np.abs(speed) < STANDING * np.abs(speed).max())))
    moving = standing[last] - standing[first] < 0.2 * window  # dry friction of a shaft that stands is anything
    first, last = (rows[moving & steady[first] & steady[last]] for rows in (first, last))
    columns = np.column_stack((speed[last] - speed[first], theta_rad[last] - theta_rad[first], way[last] - way[first]))
    impulse = push[last] - push[first]
    (inertia, viscous, coulomb), left = linear(columns, impulse, 1.0 / OVERLAP)
    part = float(np.std(left)) / (float(np.std(impulse)) or math.inf)
    return Mechanics(inertia, viscous, coulomb, part)
