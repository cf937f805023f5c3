"""How far the model that robust driving control feeds forward may be off, from the 95 % intervals of an identification:
what rho, the bound of its robust term, has to cover (equation 30: |eta| < rho).

    friction   each parameter of T(v) = B v + [T_c + (T_s - T_c) exp(-(v / v_s)^shape)] to the end of its interval that
               changes the torque more, the sum of these at the speed up to the fastest at which it is largest
    inertia    half of its interval times the acceleration of the command
    each line  half of that of its amplitude, and the amplitude times that of its phase and, over the turns of a motion,
               of its cycles, at most twice the amplitude

All of them at once and all the same sign is the sum; independent of each other, the root of the sum of squares.
Friction parameters of one fit are correlated, so the sum is more than it can be. What the model does not have (lines
below those that were found, temperature) is in neither, and the acceleration that the loop adds times the error of
the inertia is not, either.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.errors import InputError, reason
from evenspin.tableview import TableView, number

FRICTION = ("viscous_nms", "coulomb_nm", "static_nm", "stribeck_rad_s", "shape")
HINT = "`evenspin identify ... --json FILE` writes one"
SPEEDS = 400  # of the search for where friction is least certain
MAX_BYTES = 10_000_000


@dataclass(frozen=True, slots=True)
class Motion:
    """What the axis is to do."""

    speed_rad_s: float
    accel_rad_s2: float
    turns: float

    def __post_init__(self) -> None:
        for name, value, least in (
            ("--speed-rpm", self.speed_rad_s, 0.0),
            ("--accel-rad-s2", self.accel_rad_s2, 0.0),
            ("--turns", self.turns, 0.0),
        ):
            if not least <= value < 1e9:
                raise InputError("design rdc", name, value, "finite and at least 0", "how the axis is moved")


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """Torque by part, N m."""

    parts: Mapping[str, float]

    @property
    def sum_nm(self) -> float:
        return sum(self.parts.values())

    @property
    def rss_nm(self) -> float:
        return math.sqrt(sum(part * part for part in self.parts.values()))

    def as_json(self) -> dict[str, Any]:
        return {"parts_nm": dict(self.parts), "sum_nm": self.sum_nm, "rss_nm": self.rss_nm}


def read_identified(path: Path) -> Mapping[str, Any]:
    """The JSON of `evenspin identify`."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError(path, "size", path.stat().st_size, f"at most {MAX_BYTES} bytes", HINT)
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(path, "file", reason(error), "JSON of an identification", HINT) from None
    if not isinstance(content, Mapping) or not isinstance(content.get("interval_95"), Mapping):
        raise InputError(path, "interval_95", "(missing)", "intervals by name", HINT)
    return content


def uncertainty(path: Path, motion: Motion) -> Uncertainty:
    """What the model may be off by in this motion."""
    content = read_identified(path)
    intervals = {name: _interval(path, name, each) for name, each in content["interval_95"].items()}
    parts: dict[str, float] = {}
    known = [name for name in FRICTION if name in intervals]
    if known:
        parts |= _friction(path, content, {name: intervals[name] for name in known}, motion.speed_rad_s)
    if "inertia_kgm2" in intervals:
        low, high = intervals["inertia_kgm2"]
        parts["inertia_kgm2"] = 0.5 * (high - low) * motion.accel_rad_s2
    for index, line in enumerate(content.get("lines", ()), start=1):
        parts[f"line {index}"] = _line(path, index, line, motion.turns)
    if not parts:
        raise InputError(path, "interval_95", "(empty)", "intervals of friction, inertia or lines", HINT)
    return Uncertainty(parts)


def _friction(
    path: Path, content: Mapping[str, Any], intervals: Mapping[str, tuple[float, float]], fastest_rad_s: float
) -> dict[str, float]:
    """By parameter, at the speed at which their sum is largest."""
    values = {name: _number(path, name, content.get(name, 0.0 if name != "shape" else 1.0)) for name in FRICTION}
    if "static_nm" not in intervals:
        values |= {"static_nm": values["coulomb_nm"], "stribeck_rad_s": 1.0}
    v = np.linspace(0.0, fastest_rad_s, SPEEDS + 1)
    middle = _torque(v, values)
    off = {
        name: np.max([np.abs(_torque(v, {**values, name: end}) - middle) for end in ends], axis=0)
        for name, ends in intervals.items()
    }
    worst = int(np.argmax(np.sum(list(off.values()), axis=0)))
    return {name: float(each[worst]) for name, each in off.items()}


def _torque(v: Any, values: Mapping[str, float]) -> Any:
    slow = np.exp(-((v / max(values["stribeck_rad_s"], 1e-9)) ** values["shape"]))
    return values["viscous_nms"] * v + values["coulomb_nm"] + (values["static_nm"] - values["coulomb_nm"]) * slow


def _line(path: Path, index: int, line: Any, turns: float) -> float:
    where = f"lines[{index}]"
    if not isinstance(line, Mapping) or not isinstance(line.get("half_interval_95"), Mapping):
        raise InputError(path, where, line, "a line with half_interval_95", HINT)
    half = {key: _number(path, f"{where}.{key}", value) for key, value in line["half_interval_95"].items()}
    amplitude = _number(path, f"{where}.amplitude_nm", line.get("amplitude_nm"))
    angle = half.get("phase_rad", 0.0) + 2.0 * math.pi * turns * half.get("cycles", 0.0)
    turned = 2.0 if angle >= math.pi else 2.0 * math.sin(0.5 * angle)
    return half.get("amplitude_nm", 0.0) + abs(amplitude) * turned


def _interval(path: Path, name: str, given: Any) -> tuple[float, float]:
    if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != 2:
        raise InputError(path, f"interval_95.{name}", given, "[low, high]", HINT)
    low, high = (_number(path, f"interval_95.{name}", end) for end in given)
    if low > high:
        raise InputError(path, f"interval_95.{name}", given, "low first", HINT)
    return low, high


def _number(path: Path, name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(path, name, value, "a finite number", HINT)
    return float(value)


def table_of(found: Uncertainty, rho_nm: float) -> TableView:
    """The parts, and whether rho covers them."""
    rows = [(name, number(part), "") for name, part in found.parts.items()]
    rows.append(("independent of each other", number(found.rss_nm), ""))
    covered = found.sum_nm <= rho_nm
    verdict = f"rho = {rho_nm:g} N m covers it" if covered else f"rho = {rho_nm:g} N m does not cover it"
    rows.append(("all at once: rho at least", number(found.sum_nm), verdict))
    text = (
        "Torque that the model may be off by, by the 95 % intervals of the identification; less what it does not have."
    )
    marks = [*([""] * (len(rows) - 1)), "good" if covered else "bad"]
    return TableView("What rho has to cover", text, ("part", "N m", ""), rows, marks, left=1)
