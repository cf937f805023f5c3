"""Causes that the table of effects does not have: found instead of a name, the verdict is `unknown`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.effects import Scale
from evenspin.weakform.equations import Equations
from evenspin.weakform.terms import Term, foreign_term

Array = NDArray[np.float64]

LEAST_TORQUE = 0.006  # of the rated torque
LEAST_VOLTS = 0.04  # of the voltage over the resistance at the rated current
SLOW = 4


def foreign_terms(scale: Scale, plant: dict[str, float], top_rad_s: float, has_voltages: bool) -> list[Term]:
    torque = LEAST_TORQUE * scale.rated_torque_nm
    volts = LEAST_VOLTS * plant["resistance_ohm"] * scale.rated_current_a
    found = [
        foreign_term(
            "torque with the square of the speed",
            _shaft(lambda e: [_w(e) * np.abs(_w(e)) / top_rad_s**2]),
            [2.0 * torque],
        ),
        foreign_term(
            "torque with the cube of the speed", _shaft(lambda e: [_w(e) ** 3 / top_rad_s**3]), [2.0 * torque]
        ),
        foreign_term("a load that changes slowly", _shaft(_slow), [torque] * SLOW),
        foreign_term(
            "friction that changes slowly",
            _shaft(lambda e: [np.tanh(_w(e) / e.soft_rad_s) * x for x in _slow(e)[:2]]),
            [torque] * 2,
        ),
    ]
    if has_voltages:
        found += [
            foreign_term(
                "a resistance that changes slowly",
                _windings(lambda e: [(e.signals.id_a * x, e.signals.iq_a * x) for x in _slow(e)[:2]]),
                [0.05 * plant["resistance_ohm"]] * 2,
                over_time=True,
            ),
            foreign_term("a voltage with the speed squared", _windings(_speed_squared), [2.0 * volts] * 1),
            foreign_term(
                "phases of different resistance",
                _windings(_unbalance),
                [0.08 * plant["resistance_ohm"]] * 2,
                over_angle=True,
            ),
        ]
    return found


def order_term(order: float, least_nm: float) -> Term:
    """A line over the angle at an order that no effect has."""
    return foreign_term(
        f"torque of order {order:g} of the angle",
        _shaft(
            lambda e: [
                e.shown(order) * np.sin(order * e.signals.theta_m_rad),
                e.shown(order) * np.cos(order * e.signals.theta_m_rad),
            ]
        ),
        [least_nm] * 2,
    )


def frequency_term(hz: float, least_nm: float) -> Term:
    return foreign_term(
        f"torque of {hz:g} Hz",
        _shaft(lambda e: [np.sin(2.0 * np.pi * hz * e.signals.t_s), np.cos(2.0 * np.pi * hz * e.signals.t_s)]),
        [least_nm] * 2,
    )


def _shaft(rows: Callable[[Equations], Sequence[Array]]) -> Callable[[Equations], Sequence[Array | None]]:
    def columns(e: Equations) -> Sequence[Array | None]:
        found = rows(e)
        return [np.column_stack([-over.value(x) for x in found]) for over in (e.shaft, e.fine)]

    return columns


def _windings(
    rows: Callable[[Equations], Sequence[tuple[Array, Array]]],
) -> Callable[[Equations], Sequence[Array | None]]:
    def columns(e: Equations) -> Sequence[Array | None]:
        if e.winding is None:
            return [None]
        pairs = rows(e)
        return [
            None,
            None,
            np.column_stack([-e.winding.value(d) for d, _ in pairs]),
            np.column_stack([-e.winding.value(q) for _, q in pairs]),
        ]

    return columns


def _w(e: Equations) -> Array:
    return e.signals.speed_rad_s


def _slow(e: Equations) -> list[Array]:
    t = e.signals.t_s
    x = (t - t[0]) / max(t[-1] - t[0], 1e-9)
    return [np.cos(np.pi * k * x) for k in range(1, SLOW + 1)]


def _speed_squared(e: Equations) -> list[tuple[Array, Array]]:
    w = _w(e)
    top = max(float(np.max(np.abs(w))), 1e-9)
    return [(np.zeros_like(w), w * np.abs(w) / top**2)]


def _unbalance(e: Equations) -> list[tuple[Array, Array]]:
    """A phase with more resistance: the drop of its current, in the rotor frame."""
    s = e.signals
    theta_e = e.plant["pole_pairs"] * s.theta_m_rad
    out = []
    for turn in (0.0, 2.0 * np.pi / 3.0):
        cos, sin = np.cos(theta_e - turn), np.sin(theta_e - turn)
        phase = s.id_a * cos - s.iq_a * sin
        out.append((2.0 / 3.0 * phase * cos, -2.0 / 3.0 * phase * sin))
    return out
