"""The torque balance over the angle: what the lines have to explain, and what they leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance import shaft_regression
from evenspin.balance.angle_zero import find_zero, with_zero
from evenspin.balance.friction import FrictionResult, again
from evenspin.balance.line_search import OrderBank
from evenspin.balance.motion import Motion
from evenspin.balance.nominal_model import Nominal, torque_of
from evenspin.balance.regression import Fit, fit
from evenspin.balance.shaft_regression import Drive
from evenspin.balance.stretches import Stretches
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Inertia:
    """J/Kt from the joint fit of the shaft, or from the model."""

    value_as2: float
    half_as2: float


@dataclass(frozen=True, slots=True)
class Setting:
    """Everything but the motion that lines are judged with."""

    nominal: Nominal | None
    drive: Drive
    stretches: Stretches
    inertia: Inertia | None
    shift_s: float  # how far apart in time current and motion of one row may be
    friction: FrictionResult | None = None  # with values of the whole log


def shaft_balance(motion: Motion, setting: Setting) -> tuple[Array, dict[str, Array]]:
    """What the lines have to explain, and the columns of the shaft beside them."""
    given = with_zero(setting.nominal, None) if setting.nominal is not None else None
    y = motion.iq_a - shaft_regression.known_part(motion, given)
    used = [*shaft_regression.base_terms(motion, setting.drive), *shaft_regression.dry_terms(motion, setting.drive)]
    base = {term.effect: term.columns[0] for term in used}
    if setting.inertia is not None:
        known = given.inertia_as2 if given is not None else 0.0
        y = y - (setting.inertia.value_as2 - known) * base.pop("inertia")
    return y, base


def residues_of(
    bank: OrderBank, base: dict[str, Array], kept: Sequence[float], y: Array, first: Flags, setting: Setting
) -> tuple[Array, Array]:
    """Without and with what was found, over the whole grid; the coefficients come from the fitting stretches."""
    motion, nominal = bank.motion, setting.nominal
    shaft_part = _shaft_part(motion, setting, base)
    lines: dict[str, tuple[Array, ...]] = {f"line_{k:g}": bank.whole(k) for k in kept}
    if shaft_part is not None:  # friction is that of the whole log, as it is written
        after = _rest(lines, y - shaft_part, first)[0] if lines else y - shaft_part
        inner = None
    else:
        shaft_columns: dict[str, tuple[Array, ...]] = {name: (column,) for name, column in base.items()}
        after, inner = _rest(shaft_columns | lines, y, first)
    if inner is not None and "inertia" in base:  # the same inertia before and after: the one that the lines do not bend
        y = y - inner["inertia"] * base["inertia"]
    if nominal is not None:
        before = y
        if nominal.inertia_as2 > 0.0 and setting.inertia is not None:
            before = before + (setting.inertia.value_as2 - nominal.inertia_as2) * motion.accel_rad_s2
        zero_rad = find_zero(motion, nominal.lines, before, first)
        if zero_rad is not None and motion.theta_rad is not None:
            before = before - motion.smooth(torque_of(with_zero(nominal, zero_rad).lines, motion.theta_rad))
        return before, after
    own = [name for name in base if name == "viscous_friction"] or [setting.drive.friction]
    return _rest({name: (base[name],) for name in own}, y, first)[0], after


def _shaft_part(motion: Motion, setting: Setting, base: dict[str, Array]) -> Array | None:
    """Friction and load as they were found beside the lines; None where the inertia is not known."""
    found = setting.friction
    if found is None or "inertia" in base:
        return None
    columns = [
        (name, column)
        for term in (again(term, motion) for term in found.terms if term.effect != "inertia")
        for name, column in zip(shaft_regression.names_of([term]), term.columns, strict=True)
    ]
    return sum((found.final[name] * column for name, column in columns), np.zeros_like(motion.iq_a))


def _rest(columns: dict[str, tuple[Array, ...]], y: Array, first: Flags) -> tuple[Array, Fit]:
    names = [f"{name}_{i}" if len(group) > 1 else name for name, group in columns.items() for i in range(len(group))]
    flat = [column for group in columns.values() for column in group]
    found = fit(names, [column[first] for column in flat], y[first])
    return y - np.column_stack(flat) @ found.value, found
