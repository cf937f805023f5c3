"""Where the angle of a log is zero, with regard to a model: an incremental encoder starts anywhere.

Lines of a model have a phase. Subtracted at the wrong zero they make a balance worse, so the zero is found first, on
the half that fits; where no zero makes the balance better, the lines are left out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.motion import Motion
from evenspin.balance.nominal_model import Line, Nominal
from evenspin.balance.regression import rms
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]

STEPS_PER_CYCLE = 16  # tried in the period of the highest line
SAME = 0.3  # of a step: nearer to the model's own zero than this is that zero
WORTH = 0.03  # share of the residue that the lines must take away at their best zero


def at_zero(lines: tuple[Line, ...], zero_rad: float) -> tuple[Line, ...]:
    """The lines for an angle that is smaller by this than the model's."""
    return tuple(replace(line, phase_rad=line.phase_rad + line.order * zero_rad) for line in lines)


def find_zero(motion: Motion, lines: tuple[Line, ...], rest: Array, rows: Flags) -> float | None:
    """Angle to add, rad; None: this log does not show the lines. `rest`: the balance without the lines, A."""
    if not lines or motion.theta_rad is None:
        return None
    order = np.array([line.order for line in lines])
    phasor = np.array([line.amplitude_a * np.exp(1j * line.phase_rad) for line in lines])
    waves = np.column_stack(
        [
            motion.smooth(np.sin(k * motion.theta_rad))[rows] + 1j * motion.smooth(np.cos(k * motion.theta_rad))[rows]
            for k in order
        ]
    )
    y = rest[rows]
    # A sin(k theta + phase + k zero) = Re(phasor e^(jk zero)) sin + Im(..) cos: one product per zero
    projection = y @ waves
    gram_sin, gram_cos, gram_mix = (waves.real.T @ waves.real, waves.imag.T @ waves.imag, waves.real.T @ waves.imag)
    zeros = np.linspace(0.0, 2.0 * np.pi, int(STEPS_PER_CYCLE * order.max()), endpoint=False)
    turned = phasor * np.exp(1j * np.outer(zeros, order))
    s, c = turned.real, turned.imag
    explained = s @ projection.real + c @ projection.imag
    energy = (
        np.einsum("zi,ij,zj->z", s, gram_sin, s)
        + np.einsum("zi,ij,zj->z", c, gram_cos, c)
        + 2.0 * np.einsum("zi,ij,zj->z", s, gram_mix, c)
    )
    left = np.sum(y**2) - 2.0 * explained + energy
    best = int(np.argmin(left))
    if left[best] > ((1.0 - WORTH) * rms(y)) ** 2 * len(y):
        return None
    near = np.take(left, (best - 1, best, best + 1), mode="wrap")
    bend = near[0] - 2.0 * near[1] + near[2]
    finer = 0.5 * (near[0] - near[2]) / bend if bend > 0.0 else 0.0
    step = float(zeros[1] - zeros[0])
    found = float(zeros[best]) + finer * step
    return 0.0 if abs(np.remainder(found + np.pi, 2.0 * np.pi) - np.pi) < SAME * step else found


def with_zero(nominal: Nominal, zero_rad: float | None) -> Nominal:
    """The model for the angle of this log."""
    return replace(nominal, lines=() if zero_rad is None else at_zero(nominal.lines, zero_rad))
