"""Found terms as the effects `empirical` and `empirical_voltage` of the simulator, for model.toml.

A time starts with the log, a phase of an angle with its zero. What the simulator has no place for is returned by name.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from evenspin.empirical.term import EmpiricalTerm
from evenspin.native import tables

MOST_LINES = 2
SOFT = 0.002  # of the limit speed, as sim_host/effects/empirical.c has it
CONSTANT = {"time_friction": "coulomb_friction", "time_load": "load_torque"}  # what each is beside, from the start on
TORQUE, VOLTAGE = "empirical", "empirical_voltage"
Effects = dict[str, dict[str, float]]


def effects_of(terms: Sequence[EmpiricalTerm]) -> tuple[Effects, list[str]]:
    """Parameters of the effects, and the families that are not simulated."""
    torque: dict[str, float] = {}
    voltage: dict[str, float] = {}
    dry_nm = 0.0
    left: list[str] = []
    lines = 0
    for term in terms:
        name, size, shape = term.family.name, term.size, term.shape
        top = term.facts["top_rad_s"]
        if name in ("speed_odd", "speed_even") and f"{name[6:]}_nm" not in torque:
            kind = name[6:]
            torque |= {f"{kind}_nm": size, f"{kind}_exponent": shape[0], "limit_rad_s": top}
        elif name == "angle_line" and lines < MOST_LINES:
            lines += 1
            values = {
                "nm": size,
                "order": shape[0],
                "phase_rad": term.phase_rad,
                "growth": shape[1],
                "turns_over": shape[2],
            }
            torque |= {f"line_{lines}_{key}": value for key, value in values.items()}
            torque["limit_rad_s"] = top
        elif name == "position_bump" and "position_nm" not in torque:
            torque |= {"position_nm": size, "position_rad": shape[0], "width_rad": shape[1]}
        elif name == "position_spring":
            torque |= {
                "spring_nm": size,
                "spring_rad": term.facts["middle_rad"],
                "travel_rad": term.facts["travel_rad"],
            }
        elif name == "torque_frequency" and "tone_nm" not in torque:
            torque |= {"tone_nm": size, "tone_hz": shape[0], "tone_rad": _at_start(term)}
        elif name in ("time_load", "time_friction", "time_viscous") and "time_s" not in torque:
            torque |= {f"{name[5:]}_nm": _at_last(term), "limit_rad_s": top, **_time(term)}
        elif name == "reversal":
            dry_nm += max(size, 0.0)
            left.append("the way over which friction builds up after a reversal")
        elif name in ("time_resistance", "time_magnet") and "time_s" not in voltage:
            key = "resistance_ohm" if name == "time_resistance" else "flux_rel"
            voltage |= {key: _at_last(term), **_time(term)}
        elif name == "supply_frequency" and "ripple_rel" not in voltage:
            voltage |= {"ripple_rel": size, "ripple_hz": shape[0], "ripple_rad": _at_start(term)}
        elif name == "supply_power":
            voltage |= {"sag_rel": size, "rated_w": term.facts["rated_nm"] * top}
        else:
            left.append(name)
    found = {TORQUE: torque, VOLTAGE: voltage, "coulomb_friction": {"torque_nm": dry_nm} if dry_nm > 0.0 else {}}
    return {name: _digits(values) for name, values in found.items() if values}, left


def _at_start(term: EmpiricalTerm) -> float:
    """Phase of a frequency where the log starts."""
    return math.remainder(2.0 * math.pi * term.shape[0] * term.facts["start_s"] + term.phase_rad, 2.0 * math.pi)


def _at_last(term: EmpiricalTerm) -> float:
    """After a very long time, where the term is counted at the end of the log."""
    return term.size / -math.expm1(-term.facts["span_s"] / term.shape[0])


def _time(term: EmpiricalTerm) -> dict[str, float]:
    return {"time_s": term.shape[0], "until_s": term.facts["span_s"]}


def _digits(values: dict[str, float]) -> dict[str, float]:
    return {name: float(f"{value:.7g}") for name, value in values.items()}


def at_start(terms: Sequence[EmpiricalTerm], plant: Mapping[str, float]) -> Effects:
    """What terms of the time start from, as effects of constant size. `plant`: the nominal machine."""
    found: Effects = {}
    for term in terms:
        if not term.family.main:
            continue
        # Dry friction that goes through zero as that of the term does: the two may cancel.
        soft_rad_s = SOFT * term.facts["top_rad_s"]
        size = float(term.coefficients[1])
        per_viscous = plant["viscous_nms"] * term.facts["top_rad_s"]
        effect, values = {
            "time_load": ("load_torque", {"torque_nm": size}),
            "time_friction": ("coulomb_friction", {"torque_nm": size, "smooth_rad_s": soft_rad_s}),
            "time_viscous": ("viscous_friction", {"factor": 1.0 + size / per_viscous if per_viscous > 0.0 else 1.0}),
            "time_magnet": ("torque_constant", {"factor": 1.0 - size}),
            "time_resistance": ("winding_resistance", {"factor": 1.0 + size / plant["resistance_ohm"]}),
        }[term.family.name]
        found[effect] = _digits(values)
    return found


def together(first: Mapping[str, Mapping[str, float]], second: Mapping[str, Mapping[str, float]]) -> Effects:
    """Both sets of effects at once: a factor multiplies the other's, any other number adds to it."""
    out = {name: dict(values) for name, values in first.items()}
    for name, values in second.items():
        had = out.setdefault(name, {})
        for key, value in values.items():
            if key not in had:
                had[key] = value
            elif tables().effects[name].params[key].role == "factor":
                had[key] *= value
            else:
                had[key] += value
    return out


def bounded(effects: Mapping[str, Mapping[str, float]]) -> Effects:
    """Within the ranges of the table: what falls with time may start a little beyond one."""
    fields = {name: tables().effects[name].params for name in effects}
    return {
        name: {key: min(max(x, fields[name][key].minimum), fields[name][key].maximum) for key, x in values.items()}
        for name, values in effects.items()
    }
