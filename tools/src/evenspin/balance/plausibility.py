"""Whether the columns of a single log can be what their names say, with the model where there is one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from evenspin.plausible.currents import CURRENTS, check_currents
from evenspin.plausible.dead import is_constant, is_flicker, unusable_columns
from evenspin.plausible.finding import ChannelError, Finding, is_signal
from evenspin.plausible.kinematics import check_motion, check_wrap, exchanged_speed
from evenspin.plausible.load import check_load_sign
from evenspin.plausible.scales import check_scales, remark_on_inertia
from evenspin.plausible.speed_changes import speed_changes
from evenspin.plausible.torque import ANGLE_SMOOTH_S, SMOOTH_S, acceleration_factor, work_share
from evenspin.plausible.windings import NEEDED, check_windings, measured_windings

Array = NDArray[np.float64]

REPAIR = "repair it and record again"
SIGN = -0.7  # correlation of current and acceleration that leaves no other explanation
FASTEST_RAD_S2 = 2e5  # of small ironless motors
MOSTLY_BRAKES = -0.6  # share of the work
FACTOR = 20.0  # that no inertia is off by
MATCH = 0.1  # of a factor to that of a unit
RPM = 60.0 / (2.0 * np.pi)


class Model(Protocol):
    """What is used of the model."""

    @property
    def inertia_as2(self) -> float: ...
    @property
    def kt_nm_per_a(self) -> float: ...
    @property
    def pole_pairs(self) -> int | None: ...
    def windings(self) -> Mapping[str, float] | None: ...


def check_living(path: Path, columns: Mapping[str, Array]) -> None:
    """Every channel moves, as far as it must."""
    why = unusable_columns(columns, ("speed_ref_rad_s",))
    current = columns["iq_a"]
    if why is None and is_constant(current):
        why = f"iq_a is {_first(current):g} in every row: a dead channel, or the current never flowed"
    if why is None and is_flicker(current[np.isfinite(current)]):
        why = "only the last digit of iq_a moves: a dead channel, or the current never flowed"
    motion = [name for name in ("theta_m_rad", "speed_rad_s") if name in columns]
    dead = [name for name in motion if is_constant(columns[name])]
    if why is None and dead and (len(dead) == len(motion) or "theta_m_rad" in dead or _first(columns[dead[0]]) == 0.0):
        moves = len(dead) < len(motion) or ("speed_rad_s" in dead and _first(columns["speed_rad_s"]) != 0.0)
        which = "a dead channel" if moves else "the shaft never turned"
        values = " and ".join(f"{name} is {_first(columns[name]):g}" for name in dead)
        why = f"{values} in every row: {which}"
    if why is not None:
        raise ChannelError(path, why, REPAIR)


def check_beside(path: Path, columns: Mapping[str, Array]) -> None:
    """Where the log has the other currents too, they belong to iq_a and the angle."""
    if not {*CURRENTS, "theta_m_rad"} <= set(columns):
        return
    good = np.all([is_signal(columns[name]) for name in (*CURRENTS, "theta_m_rad")], axis=0)
    if np.count_nonzero(good) < 2 or any(is_constant(columns[name][good]) for name in CURRENTS):
        return
    found = check_currents({name: column[good] for name, column in columns.items()}, 0)
    if found is not None:
        raise found.error(path)


def check_units(path: Path, columns: Mapping[str, Array], beside: Mapping[str, Array] | None = None) -> tuple[str, ...]:
    """Angle, speed and time of one shaft, the current that accelerates it, and what voltages and load say of both.

    Returns:
        What is possible and yet worth a look, a sentence each.
    """
    t_s, iq = columns["t_s"], columns["iq_a"]
    theta, speed = columns.get("theta_m_rad"), columns.get("speed_rad_s")
    found = None
    if theta is not None and speed is not None:
        others = {name: columns[name] for name in ("iq_a", "speed_ref_rad_s") if name in columns}
        found = exchanged_speed(t_s, theta, speed, others) or check_motion(t_s, theta, speed)
    if found is None and theta is not None and speed is None:
        found = check_wrap(theta)
    shaft = speed if speed is not None else _rate(t_s, theta)
    if found is None and shaft is not None:
        found = _check_machine({**columns, **(beside or {}), "speed_rad_s": shaft})
    if found is None and shaft is not None:
        factor, like = acceleration_factor(t_s, shaft, iq, SMOOTH_S if speed is not None else ANGLE_SMOOTH_S)
        if factor < 0.0 and like < SIGN:
            data = f"falls where the shaft speeds up (correlation {like:.2f} with the acceleration)"
            hint = "probably the opposite sign of iq_a, or of angle and speed: negate it"
            found = Finding("iq_a", data, "positive where it accelerates in positive direction", hint)
    if found is not None:
        raise found.error(path)
    return _doubts(t_s, shaft, iq) if shaft is not None else ()


def _doubts(t_s: Array, speed: Array, current: Array) -> tuple[str, ...]:
    changes = speed_changes(t_s, speed, current)
    doubts = []
    if changes.decide and float(np.median(changes.accelerations)) > FASTEST_RAD_S2:
        doubts.append(
            f"the shaft accelerates with {np.median(changes.accelerations):.3g} rad/s^2, more than motors do: "
            "is the time in seconds, and the speed in rad/s?"
        )
    work = work_share(speed, current)
    if not changes.decide and work < MOSTLY_BRAKES:
        doubts.append(
            "the current brakes the shaft nearly all the time: unless a load drives it, the sign of iq_a is wrong"
        )
    return tuple(doubts)


def _check_machine(columns: Mapping[str, Array]) -> Finding | None:
    """Signs and exchanges that no machine allows: what voltages show comes first, because it names the column."""
    found = None
    if set(NEEDED) <= set(columns) and not any(is_constant(columns[name]) for name in NEEDED):
        found = check_windings(columns)
    if found is None:
        changes = speed_changes(columns["t_s"], columns["speed_rad_s"], columns["iq_a"])
        if changes.decide and changes.vote < 0.0:
            data = f"flows against the change of the speed in {len(changes.slopes)} changes from one speed to another"
            hint = "it looks like the opposite sign of iq_a, or of angle and speed: turn it (scale = -1 in MAP.toml)"
            found = Finding("iq_a", data, "positive where it accelerates in positive direction", hint)
    if found is None and "load_torque_nm" in columns:
        found = check_load_sign(columns)
    return found


def check_against(path: Path, columns: Mapping[str, Array | None], model: Model) -> tuple[str, ...]:
    """The numbers of a model show the units of what no other column shows; what stays in doubt is a remark."""
    t_s, iq, theta, speed = (columns.get(name) for name in ("t_s", "iq_a", "theta_m_rad", "speed_rad_s"))
    shaft = speed if speed is not None else _rate(t_s, theta)
    if t_s is None or iq is None or shaft is None:
        return ()
    has_angle, has_speed = theta is not None, speed is not None
    known = {name: column for name, column in columns.items() if column is not None}
    ratios, sigmas = _ratios({**known, "speed_rad_s": shaft}, model)
    found = check_scales(ratios, sigmas, model.pole_pairs or 1, has_angle, has_speed)
    if found is None and "load_torque_nm" in known:
        found = check_load_sign({**known, "speed_rad_s": shaft}, model.kt_nm_per_a)
    if found is not None:
        raise found.error(path)
    if model.inertia_as2 <= 0.0:
        return ()
    ratio = ratios.get("inertia", math.nan)
    if math.isnan(ratio):
        factor, like = acceleration_factor(t_s, shaft, iq, SMOOTH_S if speed is not None else ANGLE_SMOOTH_S)
        ratio = factor / model.inertia_as2 if like > -SIGN else math.nan
    if not ratio > 0.0:
        return ()
    units = {"iq_a in mA": 1e3}
    if theta is None:
        units |= {"speed_rad_s in r/min": 1.0 / RPM, "speed_rad_s in degrees per second": np.pi / 180.0}
        units |= {"t_s in milliseconds": 1e3, "speed_rad_s converted from r/min, though it was rad/s": RPM}
    if speed is None:
        units |= {"theta_m_rad in degrees": np.pi / 180.0, "theta_m_rad in turns": 2.0 * np.pi}
    seen = [name for name, unit in units.items() if abs(ratio / unit - 1.0) < MATCH and not 0.2 < unit < 8.0]
    if not seen and 1.0 / FACTOR < ratio < FACTOR:
        remark = remark_on_inertia(ratio, model.pole_pairs or 1, has_angle, has_speed) if len(ratios) < 2 else None
        return () if remark is None else (remark,)
    data = f"accelerates the shaft with {ratio:.3g} times the inertia of the model"
    hint = (
        f"the factor is that of {' or '.join(seen)}: convert it"
        if seen
        else "are current, speed and model in SI units?"
    )
    raise Finding("iq_a", data, "what the model's inertia asks for", hint).error(path)


def _ratios(columns: Mapping[str, Array], model: Model) -> tuple[dict[str, float], dict[str, float]]:
    """What the log says of the machine over what the model says, and how sure that is."""
    ratios: dict[str, float] = {}
    sigmas: dict[str, float] = {}
    changes = speed_changes(columns["t_s"], columns["speed_rad_s"], columns["iq_a"])
    if changes.decide and model.inertia_as2 > 0.0:
        ratios["inertia"] = changes.slope / model.inertia_as2
        sigmas["inertia"] = changes.scatter
    windings = measured_windings(columns) if set(NEEDED) <= set(columns) else None
    numbers = model.windings()
    if windings is not None and numbers is not None:
        for name, value in windings.items():
            if numbers.get(name, 0.0) > 0.0:
                ratios[name] = value / numbers[name]
    return ratios, sigmas


def _rate(t_s: Array | None, theta: Array | None) -> Array | None:
    """Of the angle alone, for the averages of many rows."""
    if t_s is None or theta is None:
        return None
    turn = 2.0 * np.pi
    step = np.diff(theta)
    if np.ptp(theta) <= turn * 1.001:
        step = step - turn * np.round(step / turn)
    return np.gradient(np.concatenate(([0.0], np.cumsum(step))), t_s)


def _first(column: Array) -> float:
    good = column[np.isfinite(column)]
    return float(good[0]) + 0.0
