"""What is of a log and of no machine: what the controller answers to noise, and how late the current of a row is.

What the controller answers to noise of its current sensors, which is in the logged current and in the voltage.

The drive commands -kp n of a noise n that the current never had, many times R n: a resistance, and whatever else
goes with the current, would be pulled by it. What the current of a window has beyond that of the windows before and
after, per axis, takes it up. Its size is no effect of the machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evenspin.weakform.equations import Equations
from evenspin.weakform.terms import Term, unit_term
from evenspin.weakform.windows import Windows

Array = NDArray[np.float64]


def answer_term(name: str, plant: dict[str, float], log: int) -> Term:
    """Two coordinates, V/A, d and q; as good as free."""
    most = plant["dc_link_v"] / max(plant["current_lsb_a"], 1e-3)
    one, two = unit_term(name, most, 1.0, log=log), np.ones(2)
    held = most * two
    flags = np.zeros(2, dtype=bool)
    return replace(
        one,
        off=0.0 * two,
        step=two,
        held=held,
        free=held,
        low=-np.inf * two,
        high=np.inf * two,
        details=flags,
        columns=_columns,
    )


def late_current(name: str, period_s: float, plant: dict[str, float], log: int) -> Term:
    """Current and angle of a row are not of the same instant: torque of the current, as much later.

    The voltage is late against the current by a term of its own, so that what the motion induces moves with both.
    """
    most_s = 0.5 * period_s + 1.0 / plant["pwm_hz"]

    def columns(e: Equations) -> Sequence[Array | None]:
        pole_pairs, psi_wb = plant["pole_pairs"], plant["psi_wb"]
        torque = 1.5 * pole_pairs * psi_wb * e.signals.iq_a
        shaft = [over.slope(torque)[:, None] for over in (e.shaft, e.fine)]
        if e.winding is None:
            return shaft
        faster = pole_pairs * e.acceleration(e.winding)
        d_v = -faster * e.winding.value(plant["lq_h"] * e.signals.iq_a)
        q_v = faster * e.winding.value(psi_wb + plant["ld_h"] * e.signals.id_a)
        return [*shaft, d_v[:, None], q_v[:, None]]

    edge = np.full(1, most_s + 0.5 * period_s)  # those of the row before, at most
    return replace(unit_term(name, most_s, 0.1 * most_s, log=log), columns=columns, low=-edge, high=edge)


def _columns(e: Equations) -> Sequence[Array | None]:
    if e.winding is None:
        return [None, None]
    d, q = (_beyond(e.winding, amps) for amps in (e.signals.id_a, e.signals.iq_a))
    none = np.zeros(len(d))
    return [None, None, np.column_stack((d, none)), np.column_stack((none, q))]


def _beyond(over: Windows, signal: Array) -> Array:
    """Of each window, less the mean of the nearest that share no row with it."""
    values = over.value(signal)
    at = over.centre[over.used].astype(np.float64)
    apart = 2.0 * over.bump.half + 1.0
    return np.asarray(values - 0.5 * (np.interp(at - apart, at, values) + np.interp(at + apart, at, values)))
