"""Found terms as the effects `empirical` and `empirical_voltage` of the simulator, for model.toml.

A time starts with the log, a phase of an angle with its zero. What the simulator has no place for is returned by name.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from evenspin.empirical.term import EmpiricalTerm

MOST_LINES = 2
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
