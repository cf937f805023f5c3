"""Phase quantities in the rotor frame, amplitude-invariant, and the electrical zero from the currents themselves."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_POLE_PAIRS = 30
CLEAR = 0.6  # length of the mean direction, of 1, from which the currents belong to an angle


def clarke(a: Array, b: Array, c: Array | None = None) -> tuple[Array, Array]:
    """Alpha and beta of three phases; of two, the third is what makes the sum zero."""
    third = -a - b if c is None else c
    return (2.0 * a - b - third) / 3.0, (b - third) / math.sqrt(3.0)


def park(alpha: Array, beta: Array, theta_e_rad: Array) -> tuple[Array, Array]:
    """d and q."""
    cos, sin = np.cos(theta_e_rad), np.sin(theta_e_rad)
    return alpha * cos + beta * sin, beta * cos - alpha * sin


def pole_pairs_of(alpha: Array, beta: Array, theta_m_rad: Array) -> tuple[int, int, float]:
    """Pole pairs and direction (1 or -1) with which the current vector turns with the shaft, and how clearly, 0..1."""
    vector = _doubled(alpha, beta)
    best = (1, 1, 0.0)
    for pairs in range(1, MOST_POLE_PAIRS + 1):
        for direction in (1, -1):
            clear = abs(np.mean(vector * np.exp(-2j * direction * pairs * theta_m_rad)))
            if clear > best[2]:
                best = (pairs, direction, float(clear))
    return best


def zero_of(alpha: Array, beta: Array, theta_e_rad: Array, drives: Callable[[Array], bool]) -> tuple[float, float]:
    """Electrical zero, rad, of a drive that keeps id near 0, and how clearly it shows, 0..1.

    The vector stands on the q axis, ahead or behind; doubling its angle makes both the same. @p drives tells whether
    a q current has the sign of the torque.
    """
    turned = np.mean(_doubled(alpha, beta) * np.exp(-2j * theta_e_rad))
    zero = 0.5 * float(np.angle(turned)) - 0.5 * math.pi
    _, iq = park(alpha, beta, theta_e_rad + zero)
    if not drives(iq):
        zero += math.pi
    return math.remainder(zero, 2.0 * math.pi), float(abs(turned))


def _doubled(alpha: Array, beta: Array) -> NDArray[np.complex128]:
    """Unit weight in all: the square of the vector by the mean square of its length."""
    vector = (alpha + 1j * beta) ** 2
    size = float(np.mean(np.abs(vector)))
    return np.asarray(vector / size if size > 0.0 else vector, dtype=np.complex128)


def zero_between(
    alpha: Array, beta: Array, d: Array, q: Array, theta_m_rad: Array, pole_pairs: int | None
) -> tuple[int, float, float]:
    """Pole pairs, electrical zero, and how clearly (0..1) phase currents are the dq currents turned by the angle."""
    product = (alpha + 1j * beta) * np.conj(d + 1j * q)
    size = float(np.mean(np.abs(product)))
    best = (pole_pairs or 1, 0.0, 0.0)
    if not size > 0.0:
        return best
    for pairs in [pole_pairs] if pole_pairs else range(1, MOST_POLE_PAIRS + 1):
        mean = np.mean(product * np.exp(-1j * pairs * theta_m_rad)) / size
        if abs(mean) > best[2]:
            best = (pairs, float(np.angle(mean)), float(abs(mean)))
    return best
