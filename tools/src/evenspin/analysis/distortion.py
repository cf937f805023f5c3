"""Distortion of the stator current."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.orders import whole_turns

Array = NDArray[np.float64]

_TURN_120 = np.exp(2j * np.pi / 3.0)


def space_vector(ia_a: Array, ib_a: Array, ic_a: Array) -> NDArray[np.complex128]:
    """Amplitude-invariant space vector of three phase currents, stator frame."""
    return (2.0 / 3.0) * (ia_a + _TURN_120 * ib_a + _TURN_120.conjugate() * ic_a)


def distortion_pct(current_a: NDArray[np.complex128], theta_e_rad: Array) -> float:
    """Rms of everything that is not the positive-sequence fundamental, in % of the fundamental.

    Dc and negative sequence count. Whole electrical turns at the end of the window are used.
    """
    part = whole_turns(theta_e_rad)
    if part.stop == 0:
        return float("nan")
    rotating = np.exp(1j * theta_e_rad[part])
    weight = np.ones(len(rotating))
    weight[[0, -1]] = 0.5  # both ends are the same place of a turn
    current = current_a[part]
    fundamental = np.sum(weight * current * rotating.conj()) / weight.sum()
    if fundamental == 0.0:
        return float("nan")
    residual = current - fundamental * rotating
    rms = np.sqrt(np.sum(weight * np.abs(residual) ** 2) / weight.sum())
    return float(100.0 * rms / abs(fundamental))
