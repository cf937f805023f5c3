"""Currents and voltages: units, scale, and a current along the q axis or what makes one."""

from __future__ import annotations

import math

import numpy as np

from evenspin.importer import motion
from evenspin.importer.choose import Choice
from evenspin.importer.names import QUANTITIES
from evenspin.importer.state import State
from evenspin.importer.units import unit_of

SI_UNITS = {"current": "A", "voltage": "V", "torque": "N m", "share": "1"}
INVARIANT = math.sqrt(1.5)
CLEAR = 0.5  # multiple correlation of a column with acceleration and motion from which it is a torque current
APART = 0.15  # by which the second-best column has to be worse


def guess_others(state: State) -> None:
    """Printed units are taken; a missing one is SI, and said so."""
    for quantity, choice in state.chosen.items():
        dimension = QUANTITIES[quantity]
        if quantity in state.units or dimension in ("time", "angle", "speed"):
            continue
        unit = unit_of(choice.column.unit)
        if unit is not None and unit.dimension == dimension:
            state.units[quantity] = choice.column.unit
        elif unit is not None and unit.dimension == "share" and dimension != "share":
            state.questions.append(f"{quantity}: {choice.column.name!r} is per unit: give scale, its base in SI units")
        else:
            state.units[quantity] = SI_UNITS[dimension]
            state.because(quantity, f"no unit is printed: taken for {state.units[quantity]}")
    duties = [name for name in ("duty_a", "duty_b", "duty_c") if name in state.chosen]
    if duties and not state.chosen[duties[0]].column.unit:
        top = float(np.nanmax(np.abs(state.values(duties[0]))))
        if 1.5 < top <= 100.5:
            state.units |= dict.fromkeys(duties, "%")
        elif top > 100.5:
            state.questions.append(f"{duties[0]}: values up to {top:g} are neither a share nor percent: give scale")


def guess_current(state: State) -> None:
    if "iq_a" not in state.chosen:
        pair = ("ia_a", "ib_a") if "ia_a" in state.chosen else ("ialpha_a", "ibeta_a")
        if all(name in state.chosen for name in pair):
            if not {"theta_m_rad", "theta_e_rad"} & set(state.chosen):
                state.questions.append("theta_m_rad: phase currents need an angle to give iq_a, and no column is one")
            return
        _by_data(state)
    if "iq_a" not in state.chosen:
        free = [state.table.columns[i].name for i in state.free()]
        shown = ", ".join(repr(name) for name in free[:8]) or "none is left"
        state.questions.append(
            f"iq_a: no column is the current along the q axis, and no two are phase currents (left: {shown})"
        )
        return
    _invariance(state)


def _by_data(state: State) -> None:
    """The one column that is left and follows acceleration and motion as torque does."""
    t = state.seconds()
    speed = state.values("speed_rad_s") if "speed_rad_s" in state.chosen else None
    if t is None or speed is None:
        return
    ranked = []
    for i in state.free():
        column = state.table.columns[i]
        unit = unit_of(column.unit)
        if (unit is None or unit.dimension == "current") and np.ptp(np.nan_to_num(column.values)) > 0.0:
            ranked.append((_torque_like(t, speed, column.values), i))
    ranked.sort(reverse=True)
    if ranked and ranked[0][0] > CLEAR and (len(ranked) == 1 or ranked[1][0] < ranked[0][0] - APART):
        column = state.table.columns[ranked[0][1]]
        state.chosen["iq_a"] = Choice(column, f"it follows acceleration and motion ({ranked[0][0]:.2f} of 1)")
        state.units["iq_a"] = column.unit or "A"


def _torque_like(t: motion.Array, speed: motion.Array, values: motion.Array) -> float:
    """Multiple correlation of the mean over windows with change of speed, speed and its direction."""
    edges = np.unique(np.linspace(0, len(t) - 1, min(motion.WINDOWS, max(8, len(t) // 25))).astype(int))
    span = np.diff(t[edges])
    mean = np.diff(np.concatenate(([0.0], np.cumsum(np.nan_to_num(values))))[edges]) / np.maximum(np.diff(edges), 1)
    middle = 0.5 * (speed[edges[1:]] + speed[edges[:-1]])
    columns = np.column_stack([np.diff(speed[edges]) / span, middle, np.sign(middle), np.ones(len(middle))])
    good = np.isfinite(columns).all(axis=1) & np.isfinite(mean)
    if np.count_nonzero(good) < 12:
        return 0.0
    columns, mean = columns[good], mean[good] - np.mean(mean[good])
    scale = np.linalg.norm(columns, axis=0)
    fit, *_ = np.linalg.lstsq(columns / np.where(scale > 0.0, scale, 1.0), mean, rcond=None)
    left = mean - columns / np.where(scale > 0.0, scale, 1.0) @ fit
    total = float(mean @ mean)
    return math.sqrt(max(0.0, 1.0 - float(left @ left) / total)) if total > 0.0 else 0.0


def _invariance(state: State) -> None:
    """Where phase currents stand beside dq, their lengths tell an rms or a power-invariant scale."""
    names = ("iq_a", "id_a", "ia_a", "ib_a")
    if not set(names) <= set(state.chosen):
        return
    size = {name: state.values(name) * state.unit(name).si for name in names}
    dq = float(np.nanmean(size["iq_a"] ** 2 + size["id_a"] ** 2))
    a, b = size["ia_a"], size["ib_a"]
    phase = float(np.nanmean((4.0 / 3.0) * (a * a + a * b + b * b)))
    if not (dq > 0.0 and phase > 0.0):
        return
    ratio = math.sqrt(dq / phase)
    for value, words in ((INVARIANT, "power-invariant"), (1.0 / math.sqrt(2.0), "rms values")):
        if abs(ratio / value - 1.0) < 0.02:
            state.scale |= {
                name: 1.0 / value for name in ("iq_a", "id_a", "iq_ref_a", "id_ref_a") if name in state.chosen
            }
            state.notes.append(
                f"dq currents are {ratio:.4g} times as long as the phase currents make them: {words}, brought to peak"
            )
            return
    if abs(ratio - 1.0) > 0.1:
        state.questions.append(
            f"iq_a, ia_a: dq currents are {ratio:.3g} times as long as phase currents make them: which unit is wrong?"
        )
