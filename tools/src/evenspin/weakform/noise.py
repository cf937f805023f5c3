"""What noise of the sensors alone leaves of each equation."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.effects.two_mass import follower
from evenspin.weakform.equations import Equations
from evenspin.weakform.signals import Signals
from evenspin.weakform.windows import Bump

Array = NDArray[np.float64]

FREQUENCIES = 1024
BLOCK = 64  # rows: the rms of so many scatters by 9 %


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviation of a row."""

    id_a: float
    iq_a: float
    theta_rad: float
    speed_rad_s: float
    vd_v: float
    vq_v: float


def noise_of(s: Signals) -> Noise:
    """From what neighbouring rows differ by beyond a cubic: noise, rounding, and what happens between slow rows."""
    theta = scatter(s.theta_m_rad) if s.has_angle else 0.0
    speed = 0.0 if s.has_angle else scatter(s.speed_rad_s)
    vd_v, vq_v = (scatter(v) if v is not None else 0.0 for v in (s.vd_v, s.vq_v))
    return Noise(scatter(s.id_a), scatter(s.iq_a), theta, speed, vd_v, vq_v)


def scatter(x: Array) -> float:
    """The lesser of two robust measures.

    That of the rows is one of a few steps where the signal is rounded coarsely, up to twice the noise. The rms of a
    block of rows, median over the blocks in which anything moves, is too much where a record hardly moves.
    """
    fourth = np.diff(x, 4) / math.sqrt(70.0)  # the sum of the squares of 1, 4, 6, 4, 1
    rows = float(1.4826 * np.median(np.abs(fourth - np.median(fourth))))
    squares = np.mean(fourth[: len(fourth) // BLOCK * BLOCK].reshape(-1, BLOCK) ** 2, axis=1)
    moving = squares[squares > 0.0]
    return min(rows, float(np.sqrt(np.median(moving)))) if len(moving) else rows


def floors(e: Equations, noise: Noise) -> list[float]:
    """Per part of a residual, the standard deviation that noise alone would leave."""
    p, r = e.plant["pole_pairs"], e.plant["resistance_ohm"]
    found = []
    for over in (e.shaft.bump, e.fine.bump):
        moved = acceleration_noise(over, noise)
        found.append(math.hypot(torque_noise(over, noise, e.plant), e.plant["inertia_kgm2"] * moved))
    if e.winding is not None:
        over = e.winding.bump
        slip = noise.theta_rad * _norm(over.slope) if noise.theta_rad > 0.0 else noise.speed_rad_s * _norm(over.value)
        flux = p * e.plant["psi_wb"] * slip
        for l_h, current_a, voltage_v, flux_v in (
            (e.plant["ld_h"], noise.id_a, noise.vd_v, 0.0),
            (e.plant["lq_h"], noise.iq_a, noise.vq_v, flux),
        ):
            drop = l_h * current_a * _norm(over.slope), (r * current_a + voltage_v) * _norm(over.value)
            found.append(math.hypot(*drop, flux_v))
    return found


def stated(noise: Noise, plant: Mapping[str, float]) -> Noise:
    """With the current noise of the model where it has one: not all that rows differ by is noise of the sensor."""
    phase_a = math.hypot(plant["current_noise_a"], plant["current_lsb_a"] / math.sqrt(12.0))
    if phase_a <= 0.0:
        return noise
    axis_a = math.sqrt(4.0 / 3.0) * phase_a  # of two sensors, the mean over the angle
    return replace(noise, id_a=min(noise.id_a, axis_a), iq_a=min(noise.iq_a, axis_a))


def acceleration_noise(over: Bump, noise: Noise) -> float:
    """rad/s^2, of a window."""
    return noise.theta_rad * _norm(over.curve) if noise.theta_rad > 0.0 else noise.speed_rad_s * _norm(over.slope)


def torque_noise(over: Bump, noise: Noise, plant: Mapping[str, float]) -> float:
    """N m by noise of the current, of a window."""
    return 1.5 * plant["pole_pairs"] * plant["psi_wb"] * noise.iq_a * _norm(over.value)


def swing_noise(bump: Bump, noise: Noise, f_hz: float, damping: float) -> tuple[float, float]:
    """By noise of the angle: variance of the second derivative of the swing, and covariance with that of the angle."""
    swung_square, swung_real = _swung(f_hz, damping, bump.period_s)
    by_angle = noise.theta_rad > 0.0
    weights, sigma = (bump.curve, noise.theta_rad) if by_angle else (bump.slope, noise.speed_rad_s)
    passed = _passed_square(weights.tobytes()) * sigma**2
    return float(np.mean(passed * swung_square)), float(np.mean(passed * swung_real))


@functools.lru_cache(maxsize=512)
def _swung(f_hz: float, damping: float, period_s: float) -> tuple[Array, Array]:
    """Of what a line of the angle swings: square of its size, and its real part. Every log is tried with one grid."""
    from scipy.signal import freqz

    over, under = follower(f_hz, damping, period_s)
    swung = 1.0 - freqz(over, under, worN=_lines())[1]
    return np.abs(swung) ** 2, swung.real.copy()


@functools.lru_cache(maxsize=32)
def _passed_square(weights: bytes) -> Array:
    """What of the square of a line passes these weights."""
    from scipy.signal import freqz

    return np.asarray(np.abs(freqz(np.frombuffer(weights), worN=_lines())[1]) ** 2)


def _lines() -> Array:
    """rad per row."""
    return np.asarray(np.pi * (np.arange(FREQUENCIES) + 0.5) / FREQUENCIES)


def _norm(weights: Array) -> float:
    return float(np.linalg.norm(weights))
