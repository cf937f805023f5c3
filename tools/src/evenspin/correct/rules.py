"""The table: which parameters of the drive counteract which effect, what that effect spoils, and why the drive cannot.

docs/corrections.md has it as `as_markdown` writes it; a test holds the two against each other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from evenspin.correct.changes import Change, known, moved, scaled
from evenspin.correct.found import Found
from evenspin.correct.quantities import Quantity
from evenspin.native import tables

LINES = 6  # of torque over the angle that the drive feeds forward
FRICTION = "friction"
NONE = {"factor": 1.0}

Changes = list[Change]


@dataclass(frozen=True, slots=True)
class Rule:
    """What counteracts an effect. `group`: effects with the same are one correction, made from all of them.

    `parameters`: all that `changes` may change, for people.
    """

    parameters: tuple[str, ...]
    changes: Callable[[Found, Sequence[str]], Changes]
    spoils: Callable[[Found, Sequence[str]], Quantity]
    group: str = ""
    lines: Callable[[Found, str], list[tuple[float, float, float, float, float]]] | None = None
    unless: Callable[[Found, Sequence[str]], str] = lambda found, effects: ""  # why there is nothing to correct
    chosen: Callable[[Found], tuple[str, tuple[float, ...]]] | None = None  # a parameter by simulation, of these values


@dataclass(frozen=True, slots=True)
class NoRule:
    """Why the drive cannot, or need not."""

    reason: str


# ---- torque over the angle, and friction: the model that speed_model_ff feeds forward


def _model(found: Found) -> Changes:
    """What every torque that is fed forward is calculated with, whichever effects are named.

    Of the viscous friction only what is named beyond the nominal one: that was there when the gains were designed, and
    with it fed forward, too, the speed would do something else than designed.
    """
    beyond = found.nominal.machine["viscous_nms"] * (found.effects.get("viscous_friction", NONE)["factor"] - 1.0)
    half = found.nominal.machine["viscous_nms"] * found.half("viscous_friction", "factor")
    return [
        known("speed_model_ff", 1.0),
        known("motor_psi_wb", found.machine("psi_wb")),
        known("rdc_viscous_nms", max(beyond, 0.0), half if beyond > 0.0 else 0.0),
    ]


def _line(found: Found, effect: str, order: float, amplitude: float, phase: float, halves: tuple[str, str]) -> _Line:
    """As the drive has it: no negative amplitude, and over the angle of its encoder instead of that of the shaft."""
    turned = found.effects.get("encoder_offset", {}).get("angle_el_rad", 0.0) / found.nominal.machine["pole_pairs"]
    if amplitude < 0.0:
        amplitude, phase = -amplitude, phase + math.pi
    phase = math.remainder(phase - order * turned, math.tau)
    return order, amplitude, phase, found.half(effect, halves[0]), found.half(effect, halves[1])


_Line = tuple[float, float, float, float, float]  # order, N m, rad, and half of the intervals of the last two


def _cogging_lines(found: Found, effect: str) -> list[_Line]:
    p = found.effects[effect]
    return [_line(found, effect, p["order"], p["amplitude_nm"], p["phase_rad"], ("amplitude_nm", "phase_rad"))]


def _misalignment_lines(found: Found, effect: str) -> list[_Line]:
    p = found.effects[effect]
    first = _line(found, effect, 1.0, p["amplitude_nm"], p["phase_rad"], ("amplitude_nm", "phase_rad"))
    second_nm = p["amplitude_nm"] * p.get("second_rel", 0.0)
    half_nm = abs(p["amplitude_nm"]) * found.half(effect, "second_rel")
    if abs(second_nm) <= half_nm:  # not known to be there
        return [first]
    order, amplitude, phase, _, half_rad = _line(
        found, effect, 2.0, second_nm, p.get("phase2_rad", 0.0), ("amplitude_nm", "phase2_rad")
    )
    return [first, (order, amplitude, phase, half_nm, half_rad)]


def line_changes(lines: Sequence[_Line], first: int) -> Changes:
    """Lines of the drive from number `first` on."""
    changes: Changes = []
    for number, (order, amplitude_nm, phase_rad, half_nm, half_rad) in enumerate(lines, first):
        changes += [
            known(f"rdc_line{number}_cycles", order),
            known(f"rdc_line{number}_nm", amplitude_nm, half_nm),
            known(f"rdc_line{number}_rad", phase_rad, half_rad),
        ]
    return changes


def _cogging_spoils(found: Found, effects: Sequence[str]) -> Quantity:
    return Quantity("speed_ripple", ("staircase",), (found.effects[effects[0]]["order"],))


def _misalignment_spoils(found: Found, effects: Sequence[str]) -> Quantity:
    orders = tuple(line[0] for line in _misalignment_lines(found, effects[0]))
    return Quantity("speed_ripple", ("staircase",), orders)


def _friction_changes(found: Found, effects: Sequence[str]) -> Changes:
    dry = found.effects.get("coulomb_friction", {}).get("torque_nm", 0.0)
    half = found.half("coulomb_friction", "torque_nm")
    changes = [*_model(found), known("rdc_coulomb_nm", dry, half)]
    stribeck = found.effects.get("stribeck_friction")
    if stribeck is None:
        return [*changes, known("rdc_static_nm", dry, half)]
    return [
        *changes,
        known("rdc_static_nm", dry + stribeck["torque_nm"], half + found.half("stribeck_friction", "torque_nm")),
        known("rdc_stribeck_rad_s", stribeck["speed_rad_s"], found.half("stribeck_friction", "speed_rad_s")),
        known("rdc_shape", stribeck.get("shape", 2.0)),
    ]


def _less_friction(found: Found, effects: Sequence[str]) -> str:
    """Friction below the nominal one is not fed forward: that would push."""
    if list(effects) == ["viscous_friction"] and found.effects["viscous_friction"]["factor"] < 1.0:
        return "there is less of it than nominal, and the drive only feeds forward what is beyond"
    return ""


def _reversal(found: Found, effects: Sequence[str]) -> Quantity:
    return Quantity("reversal", ("reversal",))


def _lines_changes(found: Found, effects: Sequence[str]) -> Changes:
    return _model(found)  # the lines come in `proposal`, which counts them


LINE_PARAMETERS = (
    "speed_model_ff", "motor_psi_wb", "rdc_viscous_nms", "rdc_line1_cycles", "rdc_line1_nm", "rdc_line1_rad",
)  # fmt: skip
FRICTION_PARAMETERS = (
    "speed_model_ff", "motor_psi_wb", "rdc_viscous_nms", "rdc_coulomb_nm", "rdc_static_nm", "rdc_stribeck_rad_s",
    "rdc_shape",
)  # fmt: skip
FRICTION_RULE = Rule(FRICTION_PARAMETERS, _friction_changes, _reversal, FRICTION, unless=_less_friction)


# ---- sensors and bridge


def _current_offset(found: Found, effects: Sequence[str]) -> Changes:
    return _sensors(found, "current_offset", "offset_{}_a", "current_offset_{}_a")


def _current_gain(found: Found, effects: Sequence[str]) -> Changes:
    return _sensors(found, "current_gain", "gain_{}", "current_gain_{}")


def _sensors(found: Found, effect: str, theirs: str, ours: str) -> Changes:
    p = found.effects[effect]
    changes = [known("current_correction", "fixed")]
    return changes + [
        known(ours.format(x), p[theirs.format(x)], found.half(effect, theirs.format(x))) for x in ("a", "b")
    ]


def _electrical(order: int, records: tuple[str, ...]) -> Callable[[Found, Sequence[str]], Quantity]:
    return lambda found, effects: Quantity("speed_ripple", records, (order * found.nominal.machine["pole_pairs"],))


def _dead_time(found: Found, effects: Sequence[str]) -> Changes:
    p = found.effects["dead_time"]
    return [known("dead_time_s", p["dead_time_s"], found.half("dead_time", "dead_time_s"))]


def _soft(found: Found) -> tuple[str, tuple[float, ...]]:
    """Where the sign of a current is not sure: from its noise up to the ripple that the current has of the bridge."""
    least = max(found.nominal.current_noise_a, tables().params["dead_time_soft_a"].minimum)
    return "dead_time_soft_a", tuple(least * factor for factor in (1.0, 2.0, 4.0, 8.0, 16.0))


def _sixth(found: Found, effects: Sequence[str]) -> Quantity:
    order = 6.0 * found.nominal.machine["pole_pairs"]
    return Quantity("current_ripple", ("staircase", "staircase_load"), (order,))


def _encoder_offset(found: Found, effects: Sequence[str]) -> Changes:
    half = found.half("encoder_offset", "angle_el_rad")
    return [moved("encoder_offset_rad", -found.effects["encoder_offset"]["angle_el_rad"], half)]


def _commutation(found: Found, effects: Sequence[str]) -> Quantity:
    return Quantity("commutation", ("staircase",))


# ---- the motor that the gains were made for


def _factor(found: Found, effect: str) -> tuple[float, float]:
    return found.effects[effect]["factor"], found.half(effect, "factor")


def _inertia(found: Found, effects: Sequence[str]) -> Changes:
    factor, half = _factor(found, "inertia")
    inertia, half_j = found.machine("inertia_kgm2"), found.nominal.machine["inertia_kgm2"] * half
    return [
        scaled("speed_kp_a_per_unit", factor, half),
        scaled("speed_ki_a_per_unit_s", factor, half),
        known("rdc_inertia_kgm2", inertia, half_j),
        known("observer_inertia_kgm2", inertia, half_j),
    ]


def _torque_constant(found: Found, effects: Sequence[str]) -> Changes:
    factor, half = _factor(found, "torque_constant")
    return [
        scaled("speed_kp_a_per_unit", 1.0 / factor, half / factor**2),
        scaled("speed_ki_a_per_unit_s", 1.0 / factor, half / factor**2),
        known("motor_psi_wb", found.machine("psi_wb")),
    ]


def _winding_resistance(found: Found, effects: Sequence[str]) -> Changes:
    factor, half = _factor(found, "winding_resistance")
    half_ohm = found.nominal.machine["resistance_ohm"] * half
    return [
        scaled("current_ki_v_per_as", factor, half),
        known("motor_resistance_ohm", found.machine("resistance_ohm"), half_ohm),
    ]


def _speed_step(found: Found, effects: Sequence[str]) -> Quantity:
    return Quantity("speed_step", ("staircase",))


def _current_step(found: Found, effects: Sequence[str]) -> Quantity:
    return Quantity("current_step", ("standstill_steps",))


GAINS = ("speed_kp_a_per_unit", "speed_ki_a_per_unit_s")

RULES: Mapping[str, Rule | NoRule] = {
    "current_offset": Rule(
        ("current_correction", "current_offset_a_a", "current_offset_b_a"), _current_offset,
        _electrical(1, ("staircase",)),
    ),
    "current_gain": Rule(
        ("current_correction", "current_gain_a", "current_gain_b"), _current_gain,
        _electrical(2, ("staircase_load",)),
    ),
    "dead_time": Rule(("dead_time_s", "dead_time_soft_a"), _dead_time, _sixth, chosen=_soft),
    "cogging": Rule(LINE_PARAMETERS, _lines_changes, _cogging_spoils, lines=_cogging_lines),
    "misalignment": Rule(LINE_PARAMETERS, _lines_changes, _misalignment_spoils, lines=_misalignment_lines),
    "coulomb_friction": FRICTION_RULE,
    "stribeck_friction": FRICTION_RULE,
    "viscous_friction": FRICTION_RULE,
    "inertia": Rule((*GAINS, "rdc_inertia_kgm2", "observer_inertia_kgm2"), _inertia, _speed_step),
    "torque_constant": Rule((*GAINS, "motor_psi_wb"), _torque_constant, _speed_step),
    "winding_resistance": Rule(("current_ki_v_per_as", "motor_resistance_ohm"), _winding_resistance, _current_step),
    "encoder_offset": Rule(("encoder_offset_rad",), _encoder_offset, _commutation),
    "encoder_eccentricity": NoRule("the drive has no table that corrects its angle: centre the disc of the encoder"),
    "flux_harmonics": NoRule(
        "their torque goes with the current, and the lines that the drive feeds forward do not; a repetitive method "
        "(method = fal-forc, disturbance_observer = aro) takes the speed ripple"
    ),
    "inductance_saturation": NoRule("the gain of the current controllers would have to follow the current"),
    "two_mass": NoRule("the drive has no notch filter: lower the gains of the speed loop, or stiffen the coupling"),
    "backlash": NoRule("no controller takes a gap away: the coupling has to be mended"),
    "current_filter": NoRule("the drive cannot take a lag of its sensors back: `evenspin tune` with less bandwidth"),
    "current_loop_delay": NoRule("no controller takes a delay back: `evenspin tune` with less bandwidth"),
    "load_torque": NoRule("none is needed: the integral part of the speed controller carries a constant torque"),
    "torque_ripple": NoRule("no verdict names it: it stands in scenarios only"),
    "empirical": NoRule("terms that no effect of the table explains have no correction"),
    "empirical_voltage": NoRule("terms that no effect of the table explains have no correction"),
}  # fmt: skip


def rule_of(effect: str) -> Rule | NoRule:
    """An effect that has been added to the simulator alone has no correction yet."""
    return RULES.get(effect, NoRule("no correction of this effect is known"))


def as_markdown() -> str:
    """The table as it stands in docs/corrections.md."""
    rows = ["| named by `evenspin gap` | parameters of the drive |", "|---|---|"]
    for effect, rule in RULES.items():
        if isinstance(rule, Rule):
            rows.append(f"| `{effect}` | {', '.join(f'`{name}`' for name in rule.parameters)} |")
    rows += ["", "| named | why the drive does not correct it |", "|---|---|"]
    rows += [f"| `{effect}` | {rule.reason} |" for effect, rule in RULES.items() if isinstance(rule, NoRule)]
    return "\n".join(rows)
