"""Words for what a drive runs beside its speed controller: "pi", "fal-forc", "aro", "fal-forc+dob"."""

from __future__ import annotations

from collections.abc import Mapping

from evenspin.errors import InputError, did_you_mean
from evenspin.native import tables

NONE = "none"


def observer_of(drive: Mapping[str, float]) -> str:
    """The observer of the disturbance torque, whichever parameter asks for it; "none" without."""
    params = tables().params
    word = params["method"].to_text(drive["method"])
    beside = params["disturbance_observer"]
    return word if word in beside.choices else beside.to_text(drive["disturbance_observer"])


def method_word(drive: Mapping[str, float]) -> str:
    """The drive's methods as one word."""
    word, observer = tables().params["method"].to_text(drive["method"]), observer_of(drive)
    if observer == NONE:
        return word
    return observer if word in ("pi", observer) else f"{word}+{observer}"


def method_words() -> list[str]:
    """Every word that `drive_of_word` takes."""
    observers = tables().params["disturbance_observer"].choices[1:]
    alone = tables().params["method"].choices
    return [*alone, *(f"{word}+{observer}" for word in alone if word not in observers for observer in observers)]


def drive_of_word(word: str, where: str = "run", key: str = "--method") -> dict[str, float]:
    """The drive parameters that such a word sets."""
    if word not in method_words():
        alone = " or ".join(f'"{each}"' for each in tables().params["method"].choices)
        allowed = f'{alone}, or repetitive control and an observer such as "fal-forc+dob"'
        raise InputError(where, key, word, allowed, did_you_mean(word, method_words()))
    method, _, observer = word.partition("+")
    params = tables().params
    return {
        "method": params["method"].to_number(method),
        "disturbance_observer": params["disturbance_observer"].to_number(observer or NONE),
    }
