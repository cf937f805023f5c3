"""Numbers of a meta.json that was written by others. What is no number, or none that a drive has, is one line."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from evenspin.errors import MISSING, InputError
from evenspin.native import Field, tables

HINT = "docs/log-format.md describes meta.json"
V_LIMIT = "dc_link_v/sqrt(3)"
PARAMS = {  # keys of meta.json that a parameter of the drive stands for, and so has the range of
    ("current_loop", "kp_v_per_a"): "current_kp_v_per_a",
    ("current_loop", "ki_v_per_as"): "current_ki_v_per_as",
    ("current_loop", "angle_advance_periods"): "angle_advance_periods",
    ("current_loop", "v_limit"): "voltage_limit_v",
    ("speed_loop", "kp_a_per_rad_s"): "speed_kp_a_per_unit",
    ("speed_loop", "ki_a_per_rad"): "speed_ki_a_per_unit_s",
    ("speed_loop", "iq_limit_a"): "iq_limit_a",
    ("speed_filter", "kp"): "pll_kp_per_s",
    ("speed_filter", "ki"): "pll_ki_per_s2",
}


def value_of(meta: Any, path: tuple[str, ...]) -> Any:
    """MISSING where a key, or what it is in, is not there."""
    for key in path:
        meta = meta.get(key, MISSING) if isinstance(meta, Mapping) else MISSING
    return meta


def is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(float(value))
    except OverflowError:  # a whole number of hundreds of digits
        return False


class MetaNumbers:
    """Errors name the file and the key."""

    def __init__(self, file: Path, content: Mapping[str, Any]) -> None:
        self.file, self.content = file, content

    def number(self, *path: str) -> float:
        value = value_of(self.content, path)
        if not is_number(value):
            raise self.refusal(path, "a finite number")
        field = field_of(path)
        if field is not None:
            whole = field.kind != "integer" or float(value).is_integer()
            if not (field.minimum <= value <= field.maximum and whole):
                raise self.refusal(path, field.allowed())
        return float(value)

    def positive(self, *path: str) -> float:
        value = value_of(self.content, path)
        if not (is_number(value) and value > 0.0):
            raise self.refusal(path, "a number above 0")
        return self.number(*path)

    def slots(self) -> int:
        """0: not known."""
        value = value_of(self.content, ("motor", "slots"))
        return 0 if value is MISSING or value is None else int(self.number("motor", "slots"))

    def voltage_limit_v(self) -> float:
        """0: what the dc link gives."""
        path = ("current_loop", "v_limit")
        value = value_of(self.content, path)
        if value is MISSING or (isinstance(value, str) and value.replace(" ", "") == V_LIMIT):
            return 0.0
        if not (is_number(value) and value > 0.0):
            raise self.refusal(path, f'"{V_LIMIT}" or a number of volts above 0')
        return self.number(*path)

    def plant(self, motor_keys: Iterable[str]) -> dict[str, float]:
        """The numbers of the machine that are there; a motor key without a number, or with null, is not there."""
        paths = [*(("motor", key) for key in motor_keys), ("dc_link_v",), ("pwm_hz",)]
        given = [path for path in paths if value_of(self.content, path) not in (MISSING, None)]
        return {path[-1]: self.number(*path) for path in given}

    def refusal(self, path: tuple[str, ...], must: str) -> InputError:
        return InputError(self.file, ".".join(path), value_of(self.content, path), must, HINT)


def field_of(path: tuple[str, ...]) -> Field | None:
    """What the simulator's tables say of it."""
    known = tables()
    if path in PARAMS:
        return known.params[PARAMS[path]]
    return known.model.get(path[-1]) if len(path) == 1 or path[0] in ("motor", "encoder") else None
