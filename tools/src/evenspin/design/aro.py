"""Pole placement for the angle-based repetitive observer (ARO) and the speed controller beside it.

    plant         w[k+1] = a22 w[k] + a21 T[k],  a21 = a23 = T_s / J,  a22 = 1 - B T_s / J                   (1)
    memory        lambda^N = Q - a23 L_N;  stable for 0 < L_N < 2 / a23 (Q = 1)                             (16)
    speed loop    z^3 - (a22 + 1) z^2 + (a22 + K_P a21) z + (K_I - K_P) a21 = 0                             (17)
    double pole   (17) without the delay of the torque, at p = exp(-w T_s):
                  K_P = (1 + a22 - 2 p) / a21,  K_I = (1 - p)^2 / a21

Each turn the memory error shrinks by Q - a23 L_N, so the time constant is a number of turns, whatever the speed.

Ages. The measured torque is 1/2 + n1/2 + 1/2 + n2/2 samples old (symmetric filters delay by half their order); the
printed label 1 + n1 + 1 + n2 counts whole orders.

Source   Tang et al. 2020, equations 1, 16 to 20.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.blocks import AngleMemory, Fir
from evenspin.errors import InputError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

WHERE = "design aro"


@dataclass(frozen=True, slots=True)
class Mechanics:
    """Equation 1. SI units."""

    inertia_kgm2: float
    viscous_nms: float
    ts_s: float

    def __post_init__(self) -> None:
        if not 0.0 < self.inertia_kgm2 < math.inf:
            raise InputError(WHERE, "inertia_kgm2", self.inertia_kgm2, "finite and above 0", "correct the model")
        if not 0.0 <= self.viscous_nms < math.inf:
            raise InputError(WHERE, "viscous_nms", self.viscous_nms, "finite and from 0", "correct the model")
        if not 0.0 < self.a22 <= 1.0:
            must = f"below J / T_s = {self.inertia_kgm2 / self.ts_s:g} N m s/rad"
            raise InputError(WHERE, "viscous_nms", self.viscous_nms, must, "correct the model")

    @property
    def a23(self) -> float:
        return self.ts_s / self.inertia_kgm2

    @property
    def a22(self) -> float:
        return 1.0 - self.viscous_nms * self.a23


@dataclass(frozen=True, slots=True)
class Chain:
    """Filters of the torque measurement, and the samples from a torque reference to the middle of its action."""

    fir1_order: int
    fir1_hz: float
    fir2_order: int
    fir2_hz: float
    actuation_samples: float
    ts_s: float

    @property
    def age_samples(self) -> float:
        return 1.0 + (self.fir1_order + self.fir2_order) / 2.0

    @property
    def printed_label(self) -> int:
        return 2 + self.fir1_order + self.fir2_order

    def gain(self, f_hz: Array) -> Array:
        """Part of a torque ripple that the measurement sees; the phase is corrected by the age. At most 1 is left over.

        Two symmetric filters, and the two averages over a sample that differences of angle and speed are.
        """
        f_hz = np.asarray(f_hz, dtype=float)
        return self._fir(1, f_hz) * self._fir(2, f_hz) * np.sinc(f_hz * self.ts_s) ** 2

    def taps(self, number: int) -> Array:
        order, corner_hz = (self.fir1_order, self.fir1_hz) if number == 1 else (self.fir2_order, self.fir2_hz)
        return np.array(Fir(order, corner_hz * self.ts_s).taps)

    def _fir(self, number: int, f_hz: Array) -> Array:
        taps = self.taps(number)
        place = np.arange(len(taps)) - (len(taps) - 1) / 2.0
        return np.cos(2.0 * np.pi * np.outer(f_hz, place) * self.ts_s) @ taps


@dataclass(frozen=True, slots=True)
class Memory:
    """Equation 16."""

    cells: int
    gain: float  # a23 L_N
    forgetting: float
    a23: float

    @property
    def observer_gain(self) -> float:
        """L_N, N m s/rad."""
        return self.gain / self.a23

    @property
    def bound(self) -> float:
        """L_N has to stay below this: 2 / a23, or what forgetting leaves of it."""
        return (1.0 + self.forgetting) / self.a23

    @property
    def stable(self) -> bool:
        return 0.0 < self.observer_gain < self.bound

    @property
    def per_turn(self) -> float:
        """lambda^N: what is left of an error after a turn."""
        return self.forgetting - self.gain

    @property
    def pole(self) -> float:
        """|lambda|: the radius on which the N poles lie."""
        return abs(self.per_turn) ** (1.0 / self.cells)

    def turns_to(self, part: float) -> float:
        """Turns until an error has shrunk to this part."""
        left = abs(self.per_turn)
        return math.inf if left >= 1.0 else 0.0 if left == 0.0 else math.log(part) / math.log(left)


@dataclass(frozen=True, slots=True)
class SpeedControl:
    """Gains in N m s/rad (K_I per sample) and the poles that they give."""

    kp_nms: float
    ki_nms: float
    pole_hz: float
    wanted: float  # the double pole p
    roots: Complex  # of (17)
    real_roots: Complex  # with the delays of this drive

    @property
    def stable(self) -> bool:
        return bool(np.abs(self.roots).max() < 1.0 and np.abs(self.real_roots).max() < 1.0)


@dataclass(frozen=True, slots=True)
class Design:
    """Everything `evenspin design aro` reports."""

    mechanics: Mechanics
    chain: Chain
    memory: Memory
    speed: SpeedControl
    torque_per_a_nm: float

    @property
    def stable(self) -> bool:
        return self.memory.stable and self.speed.stable


def gain_of(*, cells: int, forgetting: float, pole: float | None, turns: float | None) -> float:
    """a23 L_N from |lambda| or from the time constant in turns; equation 16."""
    if pole is not None:
        if not 0.0 <= pole < 1.0:
            raise InputError(WHERE, "--pole", pole, "from 0 and below 1, the unit circle", "try 0.99974")
        return forgetting - pole**cells
    assert turns is not None
    if not 0.0 < turns < 1e6:
        raise InputError(WHERE, "--turns", turns, "above 0 and below 1e6", "try 20")
    return forgetting - math.exp(-1.0 / turns)


def place_speed_poles(mechanics: Mechanics, chain: Chain, pole_hz: float) -> SpeedControl:
    """PI gains for a double pole, the roots of (17), and those with every delay of the drive."""
    nyquist_hz = 0.5 / mechanics.ts_s
    if not 0.0 < pole_hz < nyquist_hz:
        raise InputError(WHERE, "--pi-hz", pole_hz, f"above 0 and below {nyquist_hz:g} Hz", "try 16")
    a21, a22 = mechanics.a23, mechanics.a22
    wanted = math.exp(-2.0 * math.pi * pole_hz * mechanics.ts_s)
    kp, ki = (1.0 + a22 - 2.0 * wanted) / a21, (1.0 - wanted) ** 2 / a21
    if not kp > 0.0:
        must = (
            f"above {mechanics.viscous_nms / mechanics.inertia_kgm2 / (4.0 * math.pi):.3g} Hz, where friction alone is"
        )
        raise InputError(WHERE, "--pi-hz", pole_hz, must, "raise it")
    roots = _roots(polynomial_17(mechanics, kp, ki))
    return SpeedControl(kp, ki, pole_hz, wanted, roots, _roots_with_delays(mechanics, chain, kp, ki))


def polynomial_17(mechanics: Mechanics, kp_nms: float, ki_nms: float) -> list[float]:
    """Coefficients of equation 17, highest power first."""
    a21, a22 = mechanics.a23, mechanics.a22
    return [1.0, -(a22 + 1.0), a22 + kp_nms * a21, (ki_nms - kp_nms) * a21]


def _roots_with_delays(mechanics: Mechanics, chain: Chain, kp: float, ki: float) -> Complex:
    """Torque in the middle `actuation` samples after its reference; speed from the angle difference through FIR 1."""
    a21, a22 = mechanics.a23, mechanics.a22
    delay = max(chain.actuation_samples - 0.5, 0.0)
    whole = math.floor(delay)
    torque = [1.0 - (delay - whole), delay - whole]  # of z^-whole and the one after
    speed = np.convolve(chain.taps(1), [0.5, 0.5])
    numerator = a21 * np.convolve(np.convolve([kp, ki - kp], torque), speed)
    denominator = np.convolve([1.0, -1.0], [1.0, -a22])
    # In powers of 1/z: (1 - 1/z)(1 - a22/z) + z^-(1 + whole) numerator = 0
    total = np.zeros(max(3, 1 + whole + len(numerator)))
    total[:3] += denominator
    total[1 + whole : 1 + whole + len(numerator)] += numerator
    return _roots(np.trim_zeros(total, "b"))


def _roots(polynomial: Sequence[float] | Array) -> Complex:
    """The slowest first."""
    roots = np.asarray(np.roots(polynomial), dtype=np.complex128)
    return roots[np.argsort(-np.abs(roots), kind="stable")]


def convergence(memory: Memory, turns: int, write: str = "one") -> tuple[Array, Array]:
    """(turns, distance to where the memory ends, over its start): the block of the firmware learns a known ripple."""
    grid = 2.0 * np.pi * np.arange(memory.cells) / memory.cells
    wanted = _ripple(grid) * memory.gain / (1.0 - memory.forgetting + memory.gain)
    block = AngleMemory(memory.cells, memory.gain, memory.forgetting, write)
    step = 2.0 * np.pi / (2.0 * memory.cells)  # two samples per cell; the first points of a turn are its last ones
    errors = [1.0]
    samples = 2 * memory.cells
    for turn in range(turns):
        for k in range(samples):
            theta = (turn * samples + k) * step
            block.write(theta, float(_ripple(theta)))
        error = np.array(block.memory) - wanted
        errors.append(float(np.sqrt(np.mean(error[1:] ** 2) / np.mean(wanted[1:] ** 2))))
    return np.arange(turns + 1.0), np.array(errors)


def _ripple(theta: Any) -> Any:
    return np.sin(12.0 * theta + 0.3) + 0.3 * np.sin(24.0 * theta + 1.1) + 0.2 * np.sin(5.0 * theta)


def as_json(found: Design) -> dict[str, Any]:
    """The design as plain numbers."""
    memory, speed, chain, mechanics = found.memory, found.speed, found.chain, found.mechanics
    return {
        "stable": found.stable,
        "mechanics": {
            "inertia_kgm2": mechanics.inertia_kgm2,
            "viscous_nms": mechanics.viscous_nms,
            "ts_s": mechanics.ts_s,
            "a21": mechanics.a23,
            "a22": mechanics.a22,
            "a23": mechanics.a23,
        },
        "memory": {
            "cells": memory.cells,
            "gain_a23_ln": memory.gain,
            "ln": memory.observer_gain,
            "ln_bound": memory.bound,
            "forgetting": memory.forgetting,
            "pole": memory.pole,
            "per_turn": memory.per_turn,
            "stable": memory.stable,
            "time_constant_turns": _finite(memory.turns_to(math.exp(-1.0))),
            "turns_to_10_pct": _finite(memory.turns_to(0.1)),
        },
        "speed": {
            "pole_hz": speed.pole_hz,
            "double_pole": speed.wanted,
            "kp_nms": speed.kp_nms,
            "ki_nms": speed.ki_nms,
            "polynomial_17": polynomial_17(mechanics, speed.kp_nms, speed.ki_nms),
            "roots_17": _pairs(speed.roots),
            "roots_with_delays": _pairs(speed.real_roots),
            "stable": speed.stable,
        },
        "age_samples": chain.age_samples,
        "printed_label_samples": chain.printed_label,
        "actuation_samples": chain.actuation_samples,
        "drive": drive_parameters(found),
    }


def drive_parameters(found: Design) -> dict[str, float]:
    """What goes into [drive] of a model; the speed error in rad/s, the speed loop at the rate of the current loop."""
    per_a = found.torque_per_a_nm
    return {
        "observer_gain": found.memory.gain,
        "observer_forgetting": found.memory.forgetting,
        "aro_cells": found.memory.cells,
        "observer_inertia_kgm2": found.mechanics.inertia_kgm2,
        "observer_viscous_nms": found.mechanics.viscous_nms,
        "speed_error_gain": 1.0,
        "speed_kp_a_per_unit": found.speed.kp_nms / per_a,
        "speed_ki_a_per_unit_s": found.speed.ki_nms / found.mechanics.ts_s / per_a,
    }


def _pairs(roots: Sequence[complex] | Complex) -> list[list[float]]:
    return [[float(root.real), float(root.imag)] for root in roots]


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
