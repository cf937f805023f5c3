"""The separation principle of the repetitive observer: beside each other, memory and speed loop keep the poles that
each has alone.

    state   X_I, T_ref, w, X_d (N), observer's X_d (N)                                                     (14)
    det(z I - Phi) = (z^N - 1) (z^N + a23 L_N - Q)
                     (z^3 - (a22 + 1) z^2 + (a22 + K_P a21) z + (K_I - K_P) a21)                            (15)

Checked as a whole: the determinant of the matrix of 2 N + 3 states against the product, at points inside and outside of
the unit circle.

Source   Tang et al. 2020, equations 12 to 17.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evenspin.design.aro import Mechanics, Memory, SpeedControl, polynomial_17

Array = NDArray[np.float64]

CELLS = 100  # a determinant of 203 states; what holds for these holds for any number
RADII = (0.9, 0.99, 1.01, 1.1)
ANGLES_RAD = (0.0, 0.4, 1.3, 2.2, 3.0)


def whole_loop(mechanics: Mechanics, memory: Memory, speed: SpeedControl, cells: int) -> Array:
    """Phi of (14)."""
    first, second = np.eye(cells)[0], np.eye(cells)[1]
    turn = np.roll(np.eye(cells), 1, axis=1)  # a33: each value moves up by one, the first comes last
    forgetting = turn.copy()
    forgetting[-1, 0] = memory.forgetting
    gain = np.zeros((cells, 1))
    gain[-1, 0] = memory.observer_gain  # L_1 to L_N-1 are 0
    seen = gain @ (mechanics.a23 * first)[None, :]
    phi = np.zeros((3 + 2 * cells, 3 + 2 * cells))
    phi[0, [0, 2]] = 1.0, -1.0
    phi[1, [0, 2]] = speed.ki_nms, -speed.kp_nms
    phi[1, 3 + cells :] = -second  # the compensation: what acts one sample later
    phi[2, 1:3] = mechanics.a23, mechanics.a22
    phi[2, 3 : 3 + cells] = mechanics.a23 * first
    phi[3 : 3 + cells, 3 : 3 + cells] = turn
    phi[3 + cells :, 3 : 3 + cells] = seen
    phi[3 + cells :, 3 + cells :] = forgetting - seen
    return phi


def off_product(phi: Array, mechanics: Mechanics, memory: Memory, speed: SpeedControl, cells: int) -> float:
    """Largest relative difference of the two sides of (15)."""
    worst = 0.0
    for radius in RADII:
        for angle in ANGLES_RAD:
            z = radius * np.exp(1j * angle)
            sign, size = np.linalg.slogdet(z * np.eye(len(phi)) - phi)
            turn = z**cells
            product = (turn - 1.0) * (turn + memory.gain - memory.forgetting)
            product *= np.polyval(polynomial_17(mechanics, speed.kp_nms, speed.ki_nms), z)
            worst = max(worst, float(abs(sign * np.exp(size) / product - 1.0)))
    return worst


def separation_error(mechanics: Mechanics, memory: Memory, speed: SpeedControl) -> float:
    """How far the poles of the whole are from being those of the parts: rounding, some 1e-9."""
    cells = min(memory.cells, CELLS)
    return off_product(whole_loop(mechanics, memory, speed, cells), mechanics, memory, speed, cells)
