"""Whether the columns of a single log can be what their names say, with the model where there is one."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from evenspin.plausible.currents import CURRENTS, check_currents
from evenspin.plausible.dead import is_constant, is_flicker, unusable_columns
from evenspin.plausible.finding import ChannelError, Finding, is_signal
from evenspin.plausible.kinematics import check_motion, check_wrap, exchanged_speed
from evenspin.plausible.torque import ANGLE_SMOOTH_S, SMOOTH_S, acceleration_factor

Array = NDArray[np.float64]

REPAIR = "repair it and record again"
SIGN = -0.7  # correlation of current and acceleration that leaves no other explanation
FACTOR = 20.0  # that no inertia is off by
MATCH = 0.1  # of a factor to that of a unit
RPM = 60.0 / (2.0 * np.pi)


class Model(Protocol):
    """What is used of the model."""

    @property
    def inertia_as2(self) -> float: ...
    @property
    def viscous_as(self) -> float: ...


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


def check_units(path: Path, columns: Mapping[str, Array]) -> None:
    """Angle, speed and time of one shaft, and the current that accelerates it."""
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
        factor, like = acceleration_factor(t_s, shaft, iq, SMOOTH_S if speed is not None else ANGLE_SMOOTH_S)
        if factor < 0.0 and like < SIGN:
            data = f"falls where the shaft speeds up (correlation {like:.2f} with the acceleration)"
            hint = "probably the opposite sign of iq_a, or of angle and speed: negate it"
            found = Finding("iq_a", data, "positive where it accelerates in positive direction", hint)
    if found is not None:
        raise found.error(path)


def check_against(path: Path, columns: Mapping[str, Array | None], model: Model) -> None:
    """The inertia of a model shows the unit of what no other column shows: a current, a speed or an angle alone."""
    t_s, iq, theta, speed = (columns[name] for name in ("t_s", "iq_a", "theta_m_rad", "speed_rad_s"))
    shaft = speed if speed is not None else _rate(t_s, theta)
    if t_s is None or iq is None or shaft is None or model.inertia_as2 <= 0.0:
        return
    factor, like = acceleration_factor(t_s, shaft, iq, SMOOTH_S if speed is not None else ANGLE_SMOOTH_S)
    ratio = factor / model.inertia_as2
    if not (like > -SIGN and ratio > 0.0):
        return
    units = {"iq_a in mA": 1e3}
    if theta is None:
        units |= {"speed_rad_s in r/min": 1.0 / RPM, "speed_rad_s in degrees per second": np.pi / 180.0}
        units |= {"t_s in milliseconds": 1e3}
    if speed is None:
        units |= {"theta_m_rad in degrees": np.pi / 180.0, "theta_m_rad in turns": 2.0 * np.pi}
    seen = [name for name, unit in units.items() if abs(ratio / unit - 1.0) < MATCH and not 0.2 < unit < 10.0]
    if not seen and 1.0 / FACTOR < ratio < FACTOR:
        return
    data = f"accelerates the shaft with {ratio:.3g} times the inertia of the model"
    hint = (
        f"the factor is that of {' or '.join(seen)}: convert it"
        if seen
        else "are current, speed and model in SI units?"
    )
    raise Finding("iq_a", data, "what the model's inertia asks for", hint).error(path)


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
