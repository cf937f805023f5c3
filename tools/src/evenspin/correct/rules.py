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
DELAY_PERIODS = 1.5  # from the sample to the middle of its voltage: what the current loop is designed with

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
    chosen: Callable[[Found], Sequence[Sequence[Change]]] | None = None  # by simulation, which of these is made as well
    beside: Callable[[Found, Sequence[str]], Quantity] | None = (
        None  # must not grow; of the same kind, and chosen by, too
    )


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


def _turned_rad(found: Found) -> float:
    """By which the encoder is ahead of the shaft, mechanical."""
    return found.effects.get("encoder_offset", {}).get("angle_el_rad", 0.0) / found.nominal.machine["pole_pairs"]


def _line(found: Found, effect: str, order: float, amplitude: float, phase: float, halves: tuple[str, str]) -> _Line:
    """As the drive has it: no negative amplitude, and over the angle of its encoder instead of that of the shaft."""
    turned = _turned_rad(found)
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


def _soft(found: Found) -> list[Changes]:
    """Where the sign of a current is not sure: from its noise up to the ripple that the current has of the bridge."""
    least = max(found.nominal.current_noise_a, tables().params["dead_time_soft_a"].minimum)
    return [[known("dead_time_soft_a", least * factor)] for factor in (1.0, 2.0, 4.0, 8.0, 16.0)]


def _sixth(found: Found, effects: Sequence[str]) -> Quantity:
    order = 6.0 * found.nominal.machine["pole_pairs"]
    return Quantity("current_ripple", ("staircase", "staircase_load"), (order,))


def _encoder_offset(found: Found, effects: Sequence[str]) -> Changes:
    half = found.half("encoder_offset", "angle_el_rad")
    return [moved("encoder_offset_rad", -found.effects["encoder_offset"]["angle_el_rad"], half)]


def _eccentricity(found: Found, effects: Sequence[str]) -> Changes:
    """The encoder shows m = x + A sin(x + phase); over m instead of x the error has a second order of A^2 / 2."""
    p = found.effects["encoder_eccentricity"]
    size, phase = p["amplitude_rad"], p["phase_rad"] - _turned_rad(found)
    half, half_phase = (found.half("encoder_eccentricity", name) for name in ("amplitude_rad", "phase_rad"))
    first = (math.sin(phase), math.cos(phase))
    second = -0.5 * size * size
    return [
        known("encoder_cos1_rad", size * first[0], abs(first[0]) * half + abs(size * first[1]) * half_phase),
        known("encoder_sin1_rad", size * first[1], abs(first[1]) * half + abs(size * first[0]) * half_phase),
        known("encoder_cos2_rad", second * math.sin(2.0 * phase)),
        known("encoder_sin2_rad", second * math.cos(2.0 * phase)),
    ]


def _beyond(name: str, effect: str, parameter: str) -> Callable[[Found, Sequence[str]], str]:
    """What is larger than the parameter may be is not corrected in part."""

    def why(found: Found, effects: Sequence[str]) -> str:
        field = tables().params[name]
        if abs(found.effects[effect][parameter]) <= field.maximum:
            return ""
        return f"it is larger than the {field.maximum:g} {field.unit} that {name} takes".replace("  ", " ")

    return why


def _flux(found: Found, effects: Sequence[str]) -> Changes:
    """And the numbers of the motor by which the drive calculates the voltage of these harmonics."""
    p = found.effects["flux_harmonics"]
    return [
        known(
            "flux_cos6",
            math.copysign(p["torque_ripple_rel"], p["sign"]),
            found.half("flux_harmonics", "torque_ripple_rel"),
        ),
        known("motor_psi_wb", found.machine("psi_wb")),
        known("motor_resistance_ohm", found.machine("resistance_ohm")),
        known("motor_lq_h", found.machine("lq_h")),
    ]


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


def _delay(found: Found, effects: Sequence[str]) -> Changes:
    """The phase margin that the current loop was designed for, with the bandwidth that leaves it; the voltage vector is
    turned on by the angle that the delay adds."""
    periods, half = (
        found.effects["current_loop_delay"]["extra_periods"],
        found.half("current_loop_delay", "extra_periods"),
    )
    return [*_slower(periods, half), moved("angle_advance_periods", periods, half)]


def _filter(found: Found, effects: Sequence[str]) -> Changes:
    periods = found.effects["current_filter"]["tau_s"] * found.nominal.supply["pwm_hz"]
    return _slower(periods, found.half("current_filter", "tau_s") * found.nominal.supply["pwm_hz"])


def _saturation(found: Found, effects: Sequence[str]) -> Changes:
    """As the simulator has it; beyond nothing and all of the other axis' current a share has no meaning."""
    p = found.effects["inductance_saturation"]
    return [
        known("saturation_a", p["i_sat_a"], found.half("inductance_saturation", "i_sat_a")),
        known("saturation_cross", min(max(p.get("by_amplitude", 0.0), 0.0), 1.0)),
    ]


def _slower(periods: float, half: float) -> Changes:
    """The gain at the crossover goes with the bandwidth, and the phase lost there with bandwidth times delay."""
    factor = DELAY_PERIODS / (DELAY_PERIODS + periods)
    slope = factor**2 / DELAY_PERIODS
    return [scaled(name, factor, slope * half) for name in ("current_kp_v_per_a", "current_ki_v_per_as")]


def _notch(found: Found, effects: Sequence[str]) -> Changes:
    return [known("speed_notch_depth", NOTCH_DEPTH)]


def _notches(found: Found) -> list[Changes]:
    """At the resonance a notch keeps the speed loop from exciting it. Below, it turns the phase there, and a loop that
    excites may damp instead: which of them does is simulated."""
    hz, half = found.effects["two_mass"]["f_res_hz"], found.half("two_mass", "f_res_hz")
    return [
        [known("speed_notch_hz", share * hz, share * half), known("speed_notch_damping", damping)]
        for share in NOTCH_AT
        for damping in NOTCH_DAMPING
    ]


def _swing(record: str) -> Callable[[Found, Sequence[str]], Quantity]:
    return lambda found, effects: Quantity("swing", (record,), hz=(found.effects["two_mass"]["f_res_hz"],))


def _overshoot(found: Found, effects: Sequence[str]) -> Quantity:
    return Quantity("current_overshoot", ("standstill_steps",))


def _speed_step(found: Found, effects: Sequence[str]) -> Quantity:
    return Quantity("speed_step", ("staircase",))


def _current_step(found: Found, effects: Sequence[str]) -> Quantity:
    return Quantity("current_step", ("standstill_steps",))


GAINS = ("speed_kp_a_per_unit", "speed_ki_a_per_unit_s")
NOTCH_DEPTH = 0.05
NOTCH_AT, NOTCH_DAMPING = (0.7, 0.8, 0.9, 1.0), (0.3, 0.6, 1.0)  # of the resonance

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
    "current_loop_delay": Rule(
        ("current_kp_v_per_a", "current_ki_v_per_as", "angle_advance_periods"), _delay, _overshoot
    ),
    "current_filter": Rule(("current_kp_v_per_a", "current_ki_v_per_as"), _filter, _overshoot),
    "encoder_eccentricity": Rule(
        ("encoder_cos1_rad", "encoder_sin1_rad", "encoder_cos2_rad", "encoder_sin2_rad"), _eccentricity,
        lambda found, effects: Quantity("speed_ripple", ("staircase",), (1.0,)),
        unless=_beyond("encoder_cos1_rad", "encoder_eccentricity", "amplitude_rad"),
    ),
    "flux_harmonics": Rule(
        ("flux_cos6", "motor_psi_wb", "motor_resistance_ohm", "motor_lq_h"), _flux,
        _electrical(6, ("staircase_load",)), unless=_beyond("flux_cos6", "flux_harmonics", "torque_ripple_rel"),
    ),
    "inductance_saturation": Rule(("saturation_a", "saturation_cross"), _saturation, _current_step),
    "two_mass": Rule(
        ("speed_notch_hz", "speed_notch_damping", "speed_notch_depth"), _notch, _swing("staircase"),
        chosen=_notches, beside=_swing("load_step"),
    ),
    "backlash": NoRule("no controller takes a gap away: the coupling has to be mended"),
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
