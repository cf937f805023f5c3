"""From a name plate to the numbers of [plant], each with its origin and its range, and what contradicts.

What a plate leaves open is estimated where the size of the machine says something about it (LAWS), and marked. Nothing
replaces the pole pairs, the torque constant, the supply, the encoder and the rated current: without them there is no
model, only another motor's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from evenspin.errors import InputError
from evenspin.motor.flux import AGREE, Flux, flux_of, meaning
from evenspin.motor.plate import RPM, Plate, flag, text_of

ASK_ENCODER = ("counts", "lines", "bits")
ASK_FLUX = ("ke", "kt", "kv", "psi_wb")
PER_TURN_E = 16  # encoder counts per electrical turn that the check of the electrical zero needs
SHEET_L, SHEET_J, SHEET_R_LOW, SHEET_R_HIGH = 0.2, 0.1, 0.10, 0.40  # the winding gets 75 K warmer: 30 % more
TIME_CONSTANT_S = (2e-5, 0.2)  # L / R of machines from drone motors to servo drives
TORQUE_AGREES = 0.3  # rated torque against Kt times rated current: saturation, iron losses, rounding


@dataclass(frozen=True, slots=True)
class Value:
    """A number of [plant]. `estimated`: nothing on the plate says it."""

    value: float
    low: float
    high: float
    origin: str
    estimated: bool = False

    @property
    def comment(self) -> str:
        word = "ESTIMATE, " if self.estimated else ""
        span = "" if self.low == self.high == self.value else f", {self.low:.3g} .. {self.high:.3g}"
        return f"{word}{self.origin}{span}"


@dataclass(frozen=True, slots=True)
class Resolved:
    """`numbers` by the names of [plant]; `contradictions` and `remarks`: one line each."""

    numbers: dict[str, Value]
    contradictions: tuple[str, ...]
    remarks: tuple[str, ...]
    peak_current_a: Value
    max_speed_rad_s: Value

    @property
    def plant(self) -> dict[str, float]:
        return {name: each.value for name, each in self.numbers.items()}

    @property
    def estimated(self) -> list[str]:
        return [name for name, each in self.numbers.items() if each.estimated]


def resolve(plate: Plate) -> Resolved:
    """Every number, or an InputError that lists what a plate has to say."""
    _need(plate)
    against: list[str] = []
    remarks: list[str] = []
    pole_pairs = _pole_pairs(plate, against)
    counts = _counts(plate, against)
    ways = flux_of(plate, pole_pairs)
    flux = ways[0]
    against += _disagreements(plate, ways)
    supply = plate.supply or 0.0
    rated = _rated_current(plate, against)
    torque_per_a = 1.5 * pole_pairs * flux.psi_wb
    base = supply / math.sqrt(3.0) / (pole_pairs * flux.psi_wb)
    rated_torque = _rated_torque(plate, torque_per_a * rated, against)
    against += _speeds(plate, base, rated_torque)
    size_w = rated_torque * (plate.rated_speed * RPM if plate.rated_speed else 0.8 * base)
    numbers = {
        "pole_pairs": _exact(pole_pairs, plate.said("pole_pairs" if plate.pole_pairs else "poles")),
        "psi_wb": Value(
            flux.psi_wb, flux.psi_wb * (1.0 - flux.tolerance), flux.psi_wb * (1.0 + flux.tolerance), flux.origin
        ),
    }
    numbers["resistance_ohm"] = _resistance(plate, base * pole_pairs * flux.psi_wb / rated, size_w, against)
    numbers |= _inductances(plate, numbers["resistance_ohm"].value, size_w, against)
    numbers["inertia_kgm2"] = _inertia(plate, rated_torque, against)
    numbers["viscous_nms"] = _viscous(plate, rated_torque, base)
    numbers["rated_current_a"] = _exact(rated, _peak_of(plate, "rated_current"))
    numbers["rated_torque_nm"] = Value(rated_torque, rated_torque, rated_torque, _torque_origin(plate))
    numbers["dc_link_v"] = _exact(supply, plate.said("supply"))
    numbers["counts_per_rev"] = _exact(counts, plate.said(plate.given(*ASK_ENCODER)[0]))
    if plate.board_current is not None:
        numbers["board_current_a"] = _exact(plate.board_current, plate.said("board_current"))
    if plate.board_voltage is not None:
        numbers["board_dc_link_v"] = _exact(plate.board_voltage, plate.said("board_voltage"))
    against += _board(plate, rated, supply)
    against += _encoder(counts, pole_pairs)
    remarks += _remarks(plate, numbers)
    peak = _peak_current(plate, rated, against)
    return Resolved(numbers, tuple(against), tuple(remarks), peak, _max_speed(plate, base))


# ---- what has to be there


def _need(plate: Plate) -> None:
    missing = []
    if not plate.given("pole_pairs", "poles"):
        missing.append("--pole-pairs or --poles")
    if not plate.given(*ASK_FLUX) and len(plate.given("rated_torque", "rated_current")) < 2:
        missing.append("one of --ke, --kt, --kv, --psi-wb")
    missing += [] if plate.given(*ASK_ENCODER) else ["one of --lines, --counts, --bits"]
    missing += [flag(name) for name in ("supply", "rated_current") if getattr(plate, name) is None]
    if missing:
        given = "(missing)"
        hint = "`evenspin commission` measures pole pairs and constants of a motor without a data sheet"
        raise InputError("motor new", "name plate", given, f"given with {', '.join(missing)}", hint)


def _exact(value: float, origin: str) -> Value:
    return Value(value, value, value, origin)


def _pole_pairs(plate: Plate, against: list[str]) -> float:
    if plate.poles is not None and plate.poles % 2:
        against.append(f"{plate.said('poles')}: poles come in pairs; is it --pole-pairs {plate.poles:g}?")
    both = plate.poles is not None and plate.pole_pairs is not None
    if both and plate.poles != 2.0 * (plate.pole_pairs or 0.0):
        against.append(f"{plate.said('poles')} against {plate.said('pole_pairs')}: there are two poles in a pair")
    return plate.pole_pairs if plate.pole_pairs is not None else max(1.0, (plate.poles or 2.0) // 2)


def _counts(plate: Plate, against: list[str]) -> float:
    found = {}
    if plate.counts is not None:
        found["counts"] = plate.counts
    if plate.lines is not None:
        found["lines"] = 4.0 * plate.lines
    if plate.bits is not None:
        found["bits"] = 2.0**plate.bits
    first = next(iter(found))
    for name, counts in found.items():
        if counts != found[first]:
            against.append(
                f"{plate.said(first)} against {plate.said(name)}: {found[first]:g} and {counts:g} counts per turn; "
                "a line gives four counts"
            )
    return found[first]


# ---- what must agree


def _disagreements(plate: Plate, ways: Sequence[Flux]) -> list[str]:
    found = []
    for other in ways[1:]:
        ratio = other.psi_wb / ways[0].psi_wb
        if abs(math.log(ratio)) > AGREE:
            why = meaning(ratio)
            found.append(
                f"{plate.said(ways[0].name)} against {plate.said(other.name)}: flux linkages {ways[0].psi_wb:.4g} and "
                f"{other.psi_wb:.4g} Wb, factor {ratio:.3g}{f' ({why})' if why else ''}"
            )
    return found


def _rated_current(plate: Plate, against: list[str]) -> float:
    rated = (plate.rated_current or 0.0) * plate.per_peak
    if plate.peak_current is not None and plate.peak_current < (plate.rated_current or 0.0):
        against.append(f"{plate.said('peak_current')} is below {plate.said('rated_current')}")
    return rated


def _rated_torque(plate: Plate, by_current: float, against: list[str]) -> float:
    if plate.rated_torque is None:
        return by_current
    ratio = plate.rated_torque / by_current
    if abs(math.log(ratio)) > TORQUE_AGREES:
        why = meaning(ratio)
        against.append(
            f"{plate.said('rated_torque')} against torque constant times {plate.said('rated_current')} = "
            f"{by_current:.3g} N m, factor {ratio:.3g}{f' ({why})' if why else ''}"
        )
    return plate.rated_torque


def _torque_origin(plate: Plate) -> str:
    return plate.said("rated_torque") if plate.rated_torque is not None else "torque constant times rated current"


def _speeds(plate: Plate, base_rad_s: float, rated_torque: float) -> list[str]:
    found = []
    for name in plate.given("rated_speed"):
        speed = getattr(plate, name) * RPM
        if speed > 1.15 * base_rad_s:
            found.append(
                f"{plate.said(name)} against {plate.said('supply')}: the back-EMF fills the dc link at "
                f"{base_rad_s / RPM:.4g} r/min; is the constant rms or peak, the supply ac or dc?"
            )
    if plate.rated_power is not None and plate.rated_speed is not None and plate.rated_torque is not None:
        power = rated_torque * plate.rated_speed * RPM
        if abs(math.log(plate.rated_power / power)) > 0.15:
            found.append(
                f"{plate.said('rated_power')} against {plate.said('rated_torque')} at {plate.said('rated_speed')} = "
                f"{power:.4g} W"
            )
    if plate.max_speed is not None and plate.rated_speed is not None and plate.max_speed < plate.rated_speed:
        found.append(f"{plate.said('max_speed')} is below {plate.said('rated_speed')}")
    return found


def _board(plate: Plate, rated_a: float, supply_v: float) -> list[str]:
    found = []
    if plate.board_current is not None and plate.board_current < rated_a:
        found.append(
            f"{plate.said('board_current')} is below the peak of {plate.said('rated_current')}, {rated_a:.4g} A"
        )
    if plate.board_voltage is not None and plate.board_voltage <= supply_v:
        found.append(f"{plate.said('board_voltage')} is not above {plate.said('supply')}")
    return found


def _encoder(counts: float, pole_pairs: float) -> list[str]:
    if counts < PER_TURN_E * pole_pairs:
        per_turn = counts / pole_pairs
        return [
            f"{counts:g} counts per turn against {pole_pairs:g} pole pairs: {per_turn:.3g} counts per electrical turn, "
            f"{PER_TURN_E} are the least that tell the electrical zero; are these lines instead of counts?"
        ]
    return []


def _remarks(plate: Plate, numbers: dict[str, Value]) -> list[str]:
    """What is possible and worth a second look."""
    found = []
    r, lq = numbers["resistance_ohm"], numbers["lq_h"]
    tau = lq.value / r.value
    if not TIME_CONSTANT_S[0] <= tau <= TIME_CONSTANT_S[1] and not (r.estimated or lq.estimated):
        found.append(
            f"L / R = {1e3 * tau:.3g} ms is outside {1e3 * TIME_CONSTANT_S[0]:g} .. {1e3 * TIME_CONSTANT_S[1]:g} ms: "
            "is the inductance in mH, are both numbers of a phase or both between terminals?"
        )
    drop = numbers["rated_current_a"].value * r.value / (numbers["dc_link_v"].value / math.sqrt(3.0))
    if drop > 0.5:
        found.append(f"the rated current takes {100.0 * drop:.0f} % of the supply in the resistance alone")
    if plate.load_kgm2 is None:
        found.append("no --load-kgm2: the inertia is that of the rotor alone, and what is coupled to it counts as much")
    return found


# ---- the numbers that a plate may leave open


def _resistance(plate: Plate, base_ohm: float, size_w: float, against: list[str]) -> Value:
    found = {
        name: getattr(plate, name) / (2.0 if name == "ohm_ll" else 1.0) for name in plate.given("ohm_ll", "ohm_phase")
    }
    against += _twice(plate, found)
    if found:
        name, value = next(iter(found.items()))
        return Value(value, value * (1.0 - SHEET_R_LOW), value * (1.0 + SHEET_R_HIGH), plate.said(name))
    part = min(0.25, max(0.02, 0.12 * (size_w / 100.0) ** -0.3))  # of the base impedance: losses fall with the size
    value = part * base_ohm
    return Value(value, value / 3.0, value * 3.0, f"{100.0 * part:.0f} % of the base impedance", estimated=True)


def _inductances(plate: Plate, resistance: float, size_w: float, against: list[str]) -> dict[str, Value]:
    if (plate.mh_d is None) != (plate.mh_q is None):
        raise InputError("motor new", "--mh-d, --mh-q", "one of the two", "given together", "or give --mh-phase")
    by_axis = {"ld_h": plate.mh_d, "lq_h": plate.mh_q}
    phase = {
        name: getattr(plate, name) / (2.0 if name == "mh_ll" else 1.0) for name in plate.given("mh_ll", "mh_phase")
    }
    against += _twice(plate, phase)
    if plate.mh_d is not None and plate.mh_q is not None and phase:
        name, value = next(iter(phase.items()))
        low, high = sorted((plate.mh_d, plate.mh_q))
        if not 0.85 * low <= value <= 1.15 * high:
            against.append(
                f"{plate.said(name)} against {plate.said('mh_d')} and {plate.said('mh_q')}: not between them"
            )
    result = {}
    for axis, given in by_axis.items():
        if given is not None:
            value, origin, span, estimated = 1e-3 * given, plate.said(f"mh_{axis[1]}"), 1.0 + SHEET_L, False
        elif phase:
            name, millihenry = next(iter(phase.items()))
            value, origin, span, estimated = (
                1e-3 * millihenry,
                f"{plate.said(name)}, no saliency known",
                1.0 + SHEET_L,
                False,
            )
        else:
            tau_s = min(1e-2, max(3e-4, 1e-3 * (size_w / 100.0) ** 0.5))
            value, origin, span, estimated = (
                tau_s * resistance,
                f"a time constant L/R of {1e3 * tau_s:.2g} ms",
                4.0,
                True,
            )
        result[axis] = Value(value, value / span, value * span, origin, estimated)
    return result


def _twice(plate: Plate, found: dict[str, float]) -> list[str]:
    """The same quantity between terminals and of a phase."""
    if len(found) < 2:
        return []
    (a, x), (b, y) = found.items()
    return [] if abs(math.log(x / y)) < 0.1 else [f"{plate.said(a)} against {plate.said(b)}: two phases are in series"]


def _inertia(plate: Plate, rated_torque: float, against: list[str]) -> Value:
    scale = {"gcm2": 1e-7, "kgcm2": 1e-4, "kgm2": 1.0}
    found = {name: getattr(plate, name) * scale[name] for name in plate.given(*scale)}
    for name, value in list(found.items())[1:]:
        first = next(iter(found))
        if abs(math.log(value / found[first])) > 0.05:
            against.append(f"{plate.said(first)} against {plate.said(name)}: {found[first]:.4g} and {value:.4g} kg m^2")
    load = plate.load_kgm2 or 0.0
    more = f" and {plate.said('load_kgm2')}" if load else ""
    if found:
        name, rotor = next(iter(found.items()))
        value = rotor + load
        return Value(value, value * (1.0 - SHEET_J), value * (1.0 + SHEET_J), plate.said(name) + more)
    rotor = 4e-5 * rated_torque**1.5
    return Value(rotor + load, rotor / 5.0 + load, 5.0 * rotor + load, f"a rotor of this torque{more}", estimated=True)


def _viscous(plate: Plate, rated_torque: float, base_rad_s: float) -> Value:
    if plate.viscous_nms is not None:
        value = plate.viscous_nms
        return Value(value, 0.5 * value, 2.0 * value, plate.said("viscous_nms"))
    value = 0.01 * rated_torque / base_rad_s
    return Value(value, 0.0, 5.0 * value, "1 % of the rated torque at the top speed", estimated=True)


def _peak_of(plate: Plate, name: str) -> str:
    return f"{plate.said(name)} {plate.currents}"


def _peak_current(plate: Plate, rated_a: float, against: list[str]) -> Value:
    if plate.peak_current is not None:
        return _exact(max(plate.peak_current * plate.per_peak, rated_a), _peak_of(plate, "peak_current"))
    return Value(2.0 * rated_a, rated_a, 3.0 * rated_a, "twice the rated current", estimated=True)


def _max_speed(plate: Plate, base_rad_s: float) -> Value:
    if plate.max_speed is not None:
        return _exact(plate.max_speed * RPM, plate.said("max_speed"))
    if plate.rated_speed is not None:
        return Value(plate.rated_speed * RPM, plate.rated_speed * RPM, base_rad_s, plate.said("rated_speed"))
    return Value(base_rad_s, 0.9 * base_rad_s, 1.1 * base_rad_s, f"{text_of('supply')} filled by the back-EMF", True)
