"""Which orders of the angle are lines: the strongest first, each fitted jointly with those before and with the shaft.

Whether a line is real is judged against the half orders between the whole ones: nothing on the shaft repeats there, so
that what is found there is noise, whatever its colour.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.motion import Motion
from evenspin.balance.regression import Fit, fit
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]
Scalar = TypeVar("Scalar", bound=np.generic)

TURN = 2.0 * np.pi
HIGHEST = 100  # order that is searched for
BAND = 0.4  # of the sampling rate: a line above it would fold
ATTENUATION = 0.03  # the smoothing may leave no less of a line that is searched for
LEAST_TURNS = 4.0
ABOVE_NOISE = 5.0  # times the median of the half orders nearby: chance gives one such line in a few thousand logs
FAINT = 0.02  # of the strongest line: below it is modulation, not an effect
NEARBY = 8  # orders to each side, for the noise
MOST_LINES = 12
BESIDE, MODULATION = 2.0, 0.1  # orders to each side of a line, and share of it
FRACTIONAL = 0.1  # of the strongest line: a half order below it may be its modulation
CHANCE = 1e-4


@dataclass(frozen=True, slots=True)
class OrderSpectrum:
    """Amplitudes over whole and half orders, A."""

    order: Array
    amplitude_a: Array
    noise_a: Array


class OrderBank:
    """Smoothed sin and cos of the orders at every `stride`-th row, made once; and all of them, for what was found."""

    def __init__(self, motion: Motion) -> None:
        assert motion.theta_rad is not None
        self.motion = motion
        self.stride = max(1, int(motion.smooth.sigma_s / motion.smooth.period_s))
        self.made: dict[float, tuple[Array, Array]] = {}
        self.half_turn = np.exp(0.5j * motion.theta_rad)
        self.last = 0, np.ones_like(self.half_turn)

    def rows(self, column: NDArray[Scalar]) -> NDArray[Scalar]:
        """A column, or flags, at the rows of the bank."""
        return column[:: self.stride]

    def __call__(self, order: float) -> tuple[Array, Array]:
        if order not in self.made:
            wave = self.motion.smooth.every(self.wave(order), self.stride)
            self.made[order] = (np.ascontiguousarray(wave.imag), np.ascontiguousarray(wave.real))
        return self.made[order]

    def wave(self, order: float) -> NDArray[np.complex128]:
        """exp(i order theta), not smoothed; the next half order is one multiplication away."""
        half_orders = round(2.0 * order)
        if half_orders == self.last[0] + 1:
            self.last = half_orders, self.last[1] * self.half_turn
        elif half_orders != self.last[0]:
            assert self.motion.theta_rad is not None
            self.last = half_orders, np.exp(0.5j * half_orders * self.motion.theta_rad)
        return self.last[1]

    def whole(self, order: float) -> tuple[Array, Array]:
        wave = self.wave(order)
        return self.motion.smooth(wave.imag), self.motion.smooth(wave.real)


class Views:
    """The log at several widths of the smoothing and shifts of the current, each made once."""

    def __init__(self, make: Callable[[float, float], Motion]) -> None:
        self.make = lru_cache(maxsize=16)(make)
        self.banks: dict[tuple[float, float], OrderBank] = {}

    def __call__(self, sigma_s: float, later_s: float = 0.0) -> Motion:
        return self.make(sigma_s, later_s)

    def bank(self, sigma_s: float, later_s: float) -> OrderBank:
        """The columns of the orders; the latest ones only, which are large."""
        if (sigma_s, later_s) not in self.banks:
            self.banks = {(sigma_s, later_s): OrderBank(self(sigma_s, later_s))}
        return self.banks[sigma_s, later_s]


def names_of(orders: Sequence[float]) -> list[str]:
    return [f"{f}_{k:g}" for k in orders for f in ("sin", "cos")]


def fit_lines(bank: OrderBank, base: dict[str, Array], orders: Sequence[float], y: Array, rows: Flags) -> Fit:
    """Base columns, y and rows are those of the bank's rows."""
    columns = [*base.values(), *(column for k in orders for column in bank(k))]
    return fit([*base, *names_of(orders)], [column[rows] for column in columns], y[rows])


def turns_of(motion: Motion, rows: Flags, order: int) -> float:
    """Turns in those of these rows at which the smoothing leaves something of this order."""
    speed = np.abs(motion.speed_rad_s[rows])
    seen = (order * speed * motion.smooth.sigma_s < np.sqrt(-2.0 * np.log(ATTENUATION))) & (
        speed * order / TURN < BAND / motion.smooth.period_s
    )
    return float(np.sum(seen * speed)) * motion.smooth.period_s / TURN


def shown(motion: Motion, rows: Flags, order: float) -> float:
    """Share of a line's power that the smoothing leaves, over all turns of these rows."""
    speed = np.abs(motion.speed_rad_s[rows])
    left = np.exp(-((order * speed * motion.smooth.sigma_s) ** 2))
    return float(np.sum(left * speed) / max(np.sum(speed), 1e-300))


def highest_order(motion: Motion, rows: Flags) -> int:
    """The highest order that several turns of the log can show; 0: none."""
    seen = [k for k in range(1, HIGHEST + 1) if turns_of(motion, rows, k) >= LEAST_TURNS]
    return max(seen, default=0)


def find_lines(
    bank: OrderBank, base: dict[str, Array], y: Array, rows: Flags, highest: int
) -> tuple[list[float], OrderSpectrum]:
    """Orders, strongest first, half orders among them; and the spectrum with every line at its joint amplitude."""
    orders = np.arange(1, 2 * highest + 1) / 2.0
    flat = np.array([column[rows] for k in orders for column in bank(k)])
    columns = _without_shaft(base, flat, rows).reshape(len(orders), 2, -1)
    gram = np.einsum("kin,kjn->kij", columns, columns) + 1e-12 * np.eye(2)
    whole = orders % 1.0 == 0.0
    chosen: list[float] = []
    found = fit_lines(bank, base, chosen, y, rows)
    while True:
        project = columns @ found.residual
        phasor = np.linalg.solve(gram, project[..., None])[..., 0]
        amplitude = np.hypot(phasor[:, 0], phasor[:, 1])
        noise = _noise(orders, amplitude, whole)
        gain = np.sum(phasor * project, axis=1)
        strongest = max((line_amplitude(found, k) for k in chosen), default=0.0)
        stands = (amplitude > ABOVE_NOISE * noise) & (amplitude > np.where(whole, FAINT, FRACTIONAL) * strongest)
        stands &= whole | (amplitude > 2.0 * ABOVE_NOISE * noise)
        stands &= ~np.isin(orders, chosen)
        for k in chosen:  # beside a strong line: its modulation, once or twice per turn
            stands &= (np.abs(orders - k) > BESIDE) | (amplitude > MODULATION * line_amplitude(found, k))
        if not np.any(stands) or len(chosen) >= MOST_LINES:
            break
        chosen.append(float(orders[np.argmax(np.where(stands, gain, -1.0))]))
        found = fit_lines(bank, base, chosen, y, rows)
    while chosen:  # a line that the later ones made superfluous goes
        noise_at = dict(zip(orders.tolist(), noise.tolist(), strict=True))
        strongest = max(line_amplitude(found, k) for k in chosen)
        weak = [k for k in chosen if line_amplitude(found, k) < max(ABOVE_NOISE * noise_at[k], FAINT * strongest)]
        weak += [k for k in chosen if k not in weak and found.p_value(names_of([k])) > CHANCE]
        if not weak:
            break
        chosen.remove(min(weak, key=lambda k: line_amplitude(found, k)))
        found = fit_lines(bank, base, chosen, y, rows)
    for k in chosen:
        amplitude[np.searchsorted(orders, k)] = line_amplitude(found, k)
    ranked = sorted(chosen, key=lambda k: -line_amplitude(found, k))
    return ranked, OrderSpectrum(orders, amplitude, noise)


def _without_shaft(base: dict[str, Array], columns: Array, rows: Flags) -> Array:
    """What the shaft cannot explain of these columns: the amplitude that it leaves is that of the joint fit.

    A shaft that cogs is accelerated by its cogging, so that a wrong inertia alone takes up a part of the line.
    """
    if not base:
        return columns
    shaft = np.stack([column[rows] for column in base.values()])
    shaft = shaft / (np.sqrt(np.mean(shaft**2, axis=1, keepdims=True)) + 1e-30)
    return columns - (columns @ shaft.T) @ np.linalg.pinv(shaft @ shaft.T, rcond=1e-10, hermitian=True) @ shaft


def line_amplitude(found: Fit, order: float) -> float:
    sine, cosine = names_of([order])
    return float(np.hypot(found[sine], found[cosine]))


def _noise(orders: Array, amplitude: Array, whole: Flags) -> Array:
    at, size = orders[~whole], amplitude[~whole]
    return np.array([float(np.median(size[np.abs(at - o) <= NEARBY])) for o in orders])
