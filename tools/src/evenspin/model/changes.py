"""Changes of a scenario by name, as if they were written in its files.

rc_gain = 0.4                    a parameter of the drive (docs/parameters.md), words and switches as in TOML
method = "fal-forc+dob"          repetitive control and an observer beside it
inertia_kgm2 = 1e-4              a number of [plant] (docs/model.md): the drive gets it, too, unless [drive] states it
cogging.amplitude_nm = 0.02      a parameter of an effect (docs/effects.md)
seed, duration_s, log_rate_hz    keys of the scenario
speed_rpm = 300                  a key of the one event that has it; event.2.speed_rpm: of the second event
drive.NAME, plant.NAME           where drive and plant both have the name
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from evenspin.errors import InputError, did_you_mean
from evenspin.model.document import Document
from evenspin.model.methods import drive_of_word
from evenspin.native import Field, tables

SCENARIO = {"seed": "a whole number from 0", "duration_s": "a time in s", "log_rate_hz": "a rate in Hz"}
METHOD = "method"
WHERE = "change"


@dataclass(frozen=True, slots=True)
class Changes:
    """What is changed, in the keys of the files. `events`: (place in the list, key) and value."""

    scenario: Mapping[str, Any] = field(default_factory=dict)
    drive: Mapping[str, Any] = field(default_factory=dict)
    plant: Mapping[str, Any] = field(default_factory=dict)
    effects: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    events: Mapping[tuple[int, str], Any] = field(default_factory=dict)

    def of_scenario(self, document: Document) -> Document:
        """The scenario with what belongs into its file."""
        values: dict[str, Any] = dict(self.scenario)
        values |= {"drive": self.drive} if self.drive else {}
        values |= {"effects": self.effects} if self.effects else {}
        if self.events:
            events = [dict(event) for event in document.data.get("event", ())]
            for (index, key), value in self.events.items():
                events[index][key] = value
            values["event"] = events
        return document.with_values(values) if values else document

    def located(self, error: InputError) -> InputError:
        """An error about a changed value is not one of the line in the file."""
        names = {*self.scenario, *self.drive, *self.plant, *(key for _, key in self.events)}
        return replace(error, where=WHERE, line=None) if error.key.split(".")[-1] in names else error

    def of_model(self, document: Document) -> Document:
        return document.with_values({"plant": self.plant}) if self.plant else document


NO_CHANGES = Changes()


def changes_of(given: Mapping[str, Any], document: Document, where: str = WHERE) -> Changes:
    """Each name is found, and each value checked; what is wrong is an InputError. `document`: the scenario."""
    found = Changes({}, {}, {}, {}, {})
    for name, value in given.items():
        _put(found, str(name), _plain(value), document, where)
    return found


def parsed_changes(words: Sequence[str], option: str = "--set") -> dict[str, Any]:
    """From the command line: NAME=VALUE, each name once."""
    found: dict[str, Any] = {}
    for word in words:
        name, equals, text = word.partition("=")
        if not equals or not name or not text:
            raise InputError(option, "change", word, "NAME=VALUE", "such as rc_gain=0.4 or cogging.amplitude_nm=0.02")
        if name in found:
            raise InputError(option, "change", word, "the only one of its name", f"{name} is given twice: keep one")
        found[name] = parsed_value(text)
    return found


def parsed_value(text: str) -> Any:
    """A number, a switch, or a word."""
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def known_names() -> list[str]:
    """Everything that can be changed by name, but for keys of events."""
    effects = (f"{name}.{param}" for name, effect in tables().effects.items() for param in effect.params)
    return [*SCENARIO, *tables().params, *tables().model, *effects]


def _put(found: Any, name: str, value: Any, document: Document, where: str) -> None:
    head, _, rest = name.partition(".")
    of_drive, of_plant = name in tables().params, name in tables().model
    if name in SCENARIO:
        found.scenario[name] = value
    elif name == METHOD and isinstance(value, str):
        for key, number in drive_of_word(value, where, METHOD).items():
            found.drive[key] = tables().params[key].to_text(number)
    elif of_drive and of_plant:
        must = f"named drive.{name} or plant.{name}: both have it"
        raise InputError(where, name, value, must, "drive.: what the drive assumes, plant.: what the machine is")
    elif of_drive or head == "drive" and rest in tables().params:
        key = name if of_drive else rest
        found.drive[key] = checked(tables().params[key], value, where, name)
    elif of_plant or head == "plant" and rest in tables().model:
        key = name if of_plant else rest
        found.plant[key] = checked(tables().model[key], value, where, name)
    elif name in tables().effects and isinstance(value, Mapping):
        for param, number in value.items():
            _put(found, f"{name}.{param}", _plain(number), document, where)
    elif head in tables().effects and rest in tables().effects[head].params:
        limits = tables().effects[head].params[rest]
        found.effects.setdefault(head, {})[rest] = checked(limits, value, where, name)
    else:
        found.events[_event_key(name, value, document, where)] = value


def checked(limits: Field, value: Any, where: str, name: str) -> Any:
    """The value as TOML has it, within the range of its field."""
    if limits.kind == "choice":
        if isinstance(value, int | float) and not isinstance(value, bool) and value in range(len(limits.choices)):
            return limits.choices[int(value)]
        if value in limits.choices:
            return value
        hint = did_you_mean(value, limits.choices) if isinstance(value, str) else "correct the value"
        raise InputError(where, name, value, limits.allowed(), hint)
    if limits.kind == "flag" and (isinstance(value, bool) or value in (0, 1)):
        return bool(value)
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and limits.kind != "flag"
    if is_number and math.isfinite(value) and limits.minimum <= value <= limits.maximum:
        if limits.kind != "integer":
            return float(value)
        if float(value).is_integer():
            return int(value)
    raise InputError(where, name, value, limits.allowed(), "correct the value")


def _event_key(name: str, value: Any, document: Document, where: str) -> tuple[int, str]:
    """Which event, and which key of it."""
    events = document.data.get("event")
    events = events if isinstance(events, list | tuple) else []
    words = name.split(".")
    if len(words) == 3 and words[0] == "event":
        if not words[1].isdigit() or not 1 <= int(words[1]) <= len(events):
            must = f"event.1 to event.{len(events)}" if events else "of a scenario with events"
            raise InputError(where, name, value, must, "events are counted from 1, in the order of the file")
        return int(words[1]) - 1, words[2]
    having = [index for index, event in enumerate(events) if isinstance(event, Mapping) and name in event]
    if len(having) == 1:
        return having[0], name
    if having:
        which = ", ".join(f"event.{index + 1}.{name}" for index in having)
        raise InputError(where, name, value, "of one event", f"it stands in several: {which}")
    head, _, rest = name.partition(".")
    if head in tables().effects:
        hint = did_you_mean(rest, tables().effects[head].params)
        raise InputError(where, name, value, f"a parameter of the effect {head}", hint)
    keys = {key for event in events if isinstance(event, Mapping) for key in event}
    must = "a parameter of the drive, a number of [plant], EFFECT.PARAMETER, or a key of the scenario"
    raise InputError(where, name, value, must, did_you_mean(name, [*known_names(), *tables().effects, *keys]))


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
