"""What a scenario file may hold: its keys, the keys of an event, their units and ranges."""

from __future__ import annotations

import functools
import math
import types
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import pydantic

from evenspin.model.machine import Machine, drive_schema, effects_schema
from evenspin.model.schema import Strict, real
from evenspin.native import tables

RPM = math.pi / 30.0  # rad/s
TURN = 2.0 * math.pi  # rad
MAX_DURATION_S = 3600.0


@dataclass(frozen=True, slots=True)
class EventKey:
    """A key of [[event]] that sets an input: which one, in which unit, and that unit in units of the input."""

    input: str
    unit: str
    scale: Callable[[Machine], float]


def _one(_: Machine) -> float:
    return 1.0


def _rpm(_: Machine) -> float:
    return RPM


def _turn(_: Machine) -> float:
    return TURN


def _torque_per_a(machine: Machine) -> float:
    return machine.torque_per_a_nm


SPEED, CONTROL_MODE, POSITION = "speed_ref_rad_s", "control_mode", "position_ref_rad"
OTHER_UNITS = {
    "speed_rpm": EventKey(SPEED, "rpm", _rpm),
    "speed_rad_s": EventKey(SPEED, "rad/s", _one),
    "position_ref_turn": EventKey(POSITION, "turn", _turn),
    "load_torque_a": EventKey("load_torque_nm", "A of q-axis current", _torque_per_a),
    "load_brake_a": EventKey("load_brake_nm", "A of q-axis current", _torque_per_a),
}
LOADS = {"load_torque_nm", "load_brake_nm"}
CONTROL = {"current": 0.0, "speed": 1.0, "position": 2.0, "torque": 3.0}


@functools.cache
def event_keys() -> dict[str, EventKey]:
    """Keys in other units, then every input by its own name."""
    named = (field for field in tables().inputs.values() if field.name not in (SPEED, CONTROL_MODE))
    return OTHER_UNITS | {field.name: EventKey(field.name, field.unit, _one) for field in named}


@functools.cache
def event_schema() -> type[Strict]:
    def optional(kind: Any, description: str) -> Any:
        return (kind | None, pydantic.Field(None, description=description))

    at_s = pydantic.Field(description=f"a time in 0 .. {MAX_DURATION_S:g} s")
    members: dict[str, Any] = {"at_s": (real(0.0, MAX_DURATION_S), at_s)}
    members |= {
        name: optional(real(), f"a finite number{f' in {key.unit}' if key.unit else ''}")
        for name, key in event_keys().items()
    }
    members["ramp_s"] = optional(real(0.0, MAX_DURATION_S), f"a time in 0 .. {MAX_DURATION_S:g} s")
    members["load_rise_s"] = optional(real(0.0, MAX_DURATION_S), f"a time in 0 .. {MAX_DURATION_S:g} s")
    members["control"] = optional(Literal[*CONTROL], '"current", "speed", "position" or "torque"')
    members["drive"] = optional(drive_schema(), "drive parameters, as in { rc_gain = 0.5 }")
    return pydantic.create_model("Event", __base__=Strict, **members)


@functools.cache
def scenario_schema() -> type[Strict]:
    def described(text: str, default: Any = ...) -> Any:
        return pydantic.Field(default, description=text)

    duration, rate = real(1e-3, MAX_DURATION_S), real(1.0, 1e6)
    members: dict[str, Any] = {
        "name": (str, described("the name of the scenario, in quotes")),
        "description": (str, described("text in quotes", "")),
        "model": (str, described("the name of a built-in model or of a file, in quotes")),
        "duration_s": (duration, described(f"a time in 0.001 .. {MAX_DURATION_S:g} s")),
        "seed": (int, pydantic.Field(1, ge=0, lt=2**63, description="a whole number from 0")),
        "log_rate_hz": (rate, described("a rate in 1 .. 1e6 Hz", 2000.0)),
        "drive": (drive_schema() | None, described("a table [drive]", None)),
        "effects": (effects_schema() | None, described("tables [effects.NAME]", None)),
        "event": (types.GenericAlias(list, event_schema()), described("a list of tables [[event]]", ())),
    }
    return pydantic.create_model("Scenario", __base__=Strict, **members)
