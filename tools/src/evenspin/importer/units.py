"""Units as people print them: what dimension, and how many SI units one is.

A table of its own rather than a units library, because what is special here is what those do not know: r/min against
electrical r/min, counts, amperes rms, and Hz of a shaft as turns per second.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

TURN = 2.0 * math.pi
RMS = math.sqrt(2.0)


@dataclass(frozen=True, slots=True)
class Unit:
    """`si`: SI units in one. `counts`: how many make a turn is not known, and si is that of a whole turn."""

    dimension: str  # time, angle, speed, current, voltage, torque, share
    si: float
    counts: bool = False
    electrical: bool = False


UNITS: dict[str, Unit] = {}


def _add(dimension: str, si: float, *names: str, counts: bool = False, electrical: bool = False) -> None:
    for name in names:
        UNITS[_key(name)] = Unit(dimension, si, counts, electrical)


def _key(text: str) -> str:
    text = text.strip().strip("[](){} ").lower()
    text = (
        text.replace("\u00b5", "u").replace("\u03bc", "u").replace("\u00b7", "").replace("\u22c5", "").replace("*", "")
    )
    text = text.replace("\u00b0", "deg").replace("\u207b\u00b9", "^-1").replace("\u03c0", "pi")
    return re.sub(r"[\s_.]+", "", text)


_add("time", 1.0, "s", "sec", "secs", "second", "seconds", "sek")
_add("time", 1e-3, "ms", "msec", "millis", "millisecond", "milliseconds")
_add("time", 1e-6, "us", "usec", "micros", "microsecond", "microseconds")
_add("time", 1e-9, "ns", "nsec", "nanosecond", "nanoseconds")
_add("time", 60.0, "min", "minute", "minutes")
_add("angle", 1.0, "rad", "radian", "radians", "rads")
_add("angle", TURN / 360.0, "deg", "degree", "degrees", "grad")
_add("angle", TURN, "turn", "turns", "rev", "revs", "revolution", "revolutions", "rotations", "cycles", "umdr")
_add(
    "angle",
    TURN,
    "count",
    "counts",
    "cnt",
    "cnts",
    "cpr",
    "ticks",
    "inc",
    "increments",
    "lsb",
    "pulses",
    "steps",
    counts=True,
)
_add("angle", 1.0, "rade", "radel", "radelec", "elrad", "erad", electrical=True)
_add("angle", TURN / 360.0, "dege", "degel", "degelec", "eldeg", "edeg", electrical=True)
_add("speed", 1.0, "rad/s", "rad/sec", "rads", "rads^-1", "rads-1", "rps_rad", "1/s", "s^-1", "radpers", "rad_s")
_add(
    "speed",
    TURN / 60.0,
    "rpm",
    "r/min",
    "rev/min",
    "1/min",
    "min^-1",
    "min-1",
    "u/min",
    "turn/min",
    "turns/min",
    "rmin",
    "tr/min",
    "umin",
)
_add("speed", TURN * 1000.0 / 60.0, "krpm")
_add("speed", TURN, "rps", "rev/s", "r/s", "turn/s", "turns/s", "hz", "rev/sec", "revs/s", "turns/sec")
_add("speed", TURN / 360.0, "deg/s", "deg/sec", "degs", "dps")
_add("speed", TURN, "counts/s", "count/s", "cnt/s", "ticks/s", "cps", counts=True)
_add("speed", TURN / 60.0, "erpm", "rpmel", "elrpm", "rpm_e", electrical=True)
_add("speed", 1.0, "rad/sel", "elrad/s", "erad/s", "rade/s", electrical=True)
_add("speed", TURN, "ehz", "hzel", electrical=True)
_add("current", 1.0, "a", "amp", "amps", "ampere", "amperes", "apk", "apeak", "ap")
_add("current", RMS, "arms", "aeff", "ampsrms", "arm")
_add("current", 1e-3, "ma", "milliamp", "milliamps")
_add("current", 1e-3 * RMS, "marms")
_add("current", 1e3, "ka")
_add("voltage", 1.0, "v", "volt", "volts", "vpk", "vpeak")
_add("voltage", RMS, "vrms", "veff")
_add("voltage", 1e-3, "mv", "millivolt", "millivolts")
_add("voltage", 1e3, "kv")
_add("torque", 1.0, "nm", "newtonmeter", "newtonmetre", "newtonmeters")
_add("torque", 1e-3, "mnm")
_add("torque", 1e-2, "ncm")
_add("torque", 1e3, "knm")
_add("torque", 0.1129848290276167, "lbfin", "lbin", "inlb", "inlbf", "lb-in", "in-lb")
_add("torque", 1.3558179483314004, "lbfft", "lbft", "ftlb", "ftlbf", "ft-lb", "lb-ft")
_add("torque", 0.00706155181422604, "ozin", "ozfin", "oz-in")
_add("torque", 0.0980665, "kgcm", "kgfcm")
_add("share", 1.0, "pu", "p.u.", "perunit", "ratio", "-", "1")
_add("share", 0.01, "%", "percent")

# As a suffix after "_" only what is no word of a name: `speed_ref` is no unit of reference, `i_a` is phase a.
SUFFIXES = (
    "rad/s", "rad_s", "rads", "rpm", "erpm", "deg", "rad", "turns", "turn", "rev", "counts", "count", "cnt", "ms", "us",
    "ns", "sec", "ma", "mv", "amps", "amp", "volts", "volt", "nm", "hz", "deg_s", "rps", "turns_s", "mnm", "arms",
)  # fmt: skip
BRACKETED = re.compile(r"^(?P<name>.*?)\s*[\[({]\s*(?P<unit>[^\[\](){}]*)\s*[\])}]\s*(?P<rest>.*)$")
AFTER = re.compile(r"^(?P<name>.*?\S)\s*(?:\s/\s*|\s+in\s+|,\s+)(?P<unit>\S+)$")


def unit_of(text: str) -> Unit | None:
    """The unit of a printed text, or None when it is none that is known."""
    return UNITS.get(_key(text))


def looks_like_unit(cell: str) -> bool:
    """Whether a cell of a row below the names is a unit."""
    text = cell.strip()
    bracketed = text[:1] in "[(" and text[-1:] in "])" and len(text) > 1
    return bracketed or text in ("-", "\u00b0C", "degC", "C", "bool") or unit_of(text) is not None


def split_unit(header: str) -> tuple[str, str]:
    """`Iq [A]` as ("Iq", "A"); a unit in brackets that is none that is known stays with the name."""
    text = header.strip().strip('"').strip()
    if match := BRACKETED.match(text):
        if unit_of(match["unit"]) is not None:
            return f"{match['name']} {match['rest']}".strip(), match["unit"].strip()
        return text, ""
    if (match := AFTER.match(text)) and unit_of(match["unit"]) is not None:
        return match["name"].strip(), match["unit"]
    lower = text.lower()
    for suffix in sorted(SUFFIXES, key=len, reverse=True):
        if lower.endswith(("_" + suffix, " " + suffix)) and len(text) > len(suffix) + 1:
            return text[: -len(suffix) - 1].strip(), text[-len(suffix) :].replace(
                "_", "/"
            ) if "/" not in suffix else suffix
    for short in ("s", "a", "v"):  # t_s, iq_a, vd_v: only after a name that has this quantity
        if re.fullmatch(
            rf"(?:t|time|timestamp|i[dq]|v[dq]|u[dq]|vdc|udc|vbus|vin|[iu][abcuvw]|v[abc]|i[dq]_ref|i(?:bus|motor))_{short}",
            lower,
        ):
            return text[:-2], text[-1]
    return text, ""
