"""The questions of `evenspin motor new` on a terminal: number and unit in one answer, empty for what is not known."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from evenspin.motor.plate import CURRENTS, KE

Ask = Callable[[str], str]
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Question:
    """`units`: what may stand behind the number, and the field that it means; the first holds without a unit."""

    text: str
    units: Mapping[str, str]
    needed: bool = False


QUESTIONS = (
    Question("Pole pairs (or: 8 poles)", {"": "pole_pairs", "pairs": "pole_pairs", "poles": "poles"}, True),
    Question("Supply of the inverter, dc, V", {"v": "supply"}, True),
    Question("Rated current, A", {"a": "rated_current"}, True),
    Question("Peak current, A", {"a": "peak_current"}),
    Question("Rated torque, N m", {"nm": "rated_torque"}),
    Question("Rated speed, r/min", {"rpm": "rated_speed", "r/min": "rated_speed"}),
    Question("Speed constant Kv, r/min per V", {"rpm/v": "kv"}),
    Question("Torque constant Kt, N m/A", {"nm/a": "kt"}),
    Question("Voltage constant Ke, V per 1000 r/min", {"v/krpm": "ke"}),
    Question("Resistance, ohm between terminals (or: 0.3 phase)", {"ll": "ohm_ll", "phase": "ohm_phase"}),
    Question("Inductance, mH between terminals (or: 0.2 phase)", {"ll": "mh_ll", "phase": "mh_phase"}),
    Question("Rotor inertia, kg cm2 (or: 70 gcm2, 7e-6 kgm2)", {"kgcm2": "kgcm2", "gcm2": "gcm2", "kgm2": "kgm2"}),
    Question("Inertia of the load at the motor shaft, kg m2", {"kgm2": "load_kgm2"}),
    Question(
        "Encoder, counts per turn (or: 1000 lines, 17 bits)",
        {"counts": "counts", "lines": "lines", "bits": "bits"},
        True,
    ),
    Question("Largest phase current of the board, A", {"a": "board_current"}),
    Question("Largest dc link of the board, V", {"v": "board_voltage"}),
)  # fmt: skip
CHOICES = {
    "currents": ("Are currents (and Kt) per A rms or peak?", CURRENTS),
    "ke_as": ("Is Ke between terminals or of a phase, rms or peak?", KE),
}
NUMBER = re.compile(r"^([-+]?\d+(?:[.,]\d*)?(?:[eE][-+]?\d+)?|[-+]?[.,]\d+(?:[eE][-+]?\d+)?)\s*(.*)$")


def answers(ask: Ask, say: Say) -> dict[str, float | str]:
    """Fields of a Plate; every question is asked until its answer can be read."""
    found: dict[str, float | str] = {}
    for question in QUESTIONS:
        found |= _answer(question, ask, say)
    for field, (text, words) in CHOICES.items():
        if field == "ke_as" and "ke" not in found:
            continue
        word = ask(f"{text} [{', '.join(words)}]").strip() or words[0]
        while word not in words:
            word = ask(f"one of {', '.join(words)}").strip() or words[0]
        found[field] = word
    return found


def _answer(question: Question, ask: Ask, say: Say) -> dict[str, float | str]:
    while True:
        text = ask(question.text).strip()
        if not text and not question.needed:
            return {}
        read = NUMBER.match(text)
        unit = "" if read is None else re.sub(r"[\s^]", "", read[2].lower()).replace("²", "2")
        names = {**question.units, "": next(iter(question.units.values()))}
        if read is not None and unit in names:
            return {names[unit]: float(read[1].replace(",", "."))}
        units = ", ".join(word for word in question.units if word)
        say(f"a number{f' with {units}' if units else ''}" + ("" if question.needed else ", or nothing"))
