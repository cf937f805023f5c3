"""model.toml: the machine with what was found, ready for the next log. Without a model, in ampere equivalents."""

from __future__ import annotations

from typing import Any

from evenspin.balance.analysis import Analysis
from evenspin.balance.effect_facts import IN_AMPERES, smallest_torque_nm, table_parameter
from evenspin.balance.judge_lines import missing_lines
from evenspin.balance.nominal_model import LINES
from evenspin.balance.ripple_simulation import INDUCTANCE_H, POLE_PAIRS, PSI_WB, RESISTANCE_OHM
from evenspin.balance.shaft_regression import INERTIA, VISCOUS
from evenspin.balance.verdict import OR, Verdict
from evenspin.balance.verdict_file import identified

SHAFT_TORQUES = ("coulomb_friction", "load_torque")  # that every log is fitted with


def model_text(analysis: Analysis, verdict: Verdict) -> str | None:
    """None when the log identifies too little for a machine."""
    import tomlkit

    nominal = analysis.nominal
    found = identified(analysis)
    if nominal is None:
        if INERTIA not in found:
            return None
        document = tomlkit.document()
        document.add(tomlkit.comment("Ampere equivalents: 1.5 p psi = 1 N m/A, so that N m are amperes of q current."))
        document.add(
            tomlkit.comment("Pole pairs, resistance and inductances are stand-ins: the log does not show them.")
        )
        document["name"] = f"{analysis.log.path.name.split('.')[0]}-ampere-equivalents"
        plant: Any = tomlkit.table()
        stand_ins = {
            "pole_pairs": POLE_PAIRS,
            "resistance_ohm": RESISTANCE_OHM,
            "ld_h": INDUCTANCE_H,
            "lq_h": INDUCTANCE_H,
        }
        for key, value in stand_ins.items():
            plant[key] = value
        plant["psi_wb"] = PSI_WB
        plant["inertia_kgm2"] = _short(found[INERTIA]["value"])
        plant["viscous_nms"] = _short(max(_final(analysis, VISCOUS), 0.0))
        document["plant"] = plant
        kt = 1.0
    else:
        document = tomlkit.parse(nominal.machine.document.path.read_text(encoding="utf-8"))
        document["name"] = f"{nominal.machine.name}-gap"
        kt = nominal.kt_nm_per_a
        if nominal.inertia_as2 <= 0.0 and INERTIA in found:
            document["plant"]["inertia_kgm2"] = _short(found[INERTIA]["value"] * kt)
        if VISCOUS in found and "viscous_friction" not in verdict.names and nominal.viscous_as > 0.0:
            off = found[VISCOUS]["value"] / nominal.viscous_as  # a deviation of this unit, within its tolerance
            document["plant"]["viscous_nms"] = _short(float(nominal.machine.plant["viscous_nms"]) * max(off, 0.0))
    if "effects" not in document:
        document["effects"] = tomlkit.table()
    effects: Any = document["effects"]
    for name, value in _shaft_torques(analysis).items():
        table = effects.get(name, tomlkit.table())
        table["torque_nm"] = _short(max(_base_value(nominal, name, "torque_nm") + value * kt, smallest_torque_nm(name)))
        effects[name] = table
    for name, parameters in verdict.parameters.items():
        if OR in name and "cogging" not in name or name in SHAFT_TORQUES:
            continue
        name = name.split(OR)[0]
        table = effects.get(name, tomlkit.table())
        for key, value in _native(name, parameters, kt).items():
            before = _base_value(nominal, name, key)
            table[key] = _short(before * value if key == "factor" else before + value if key == "torque_nm" else value)
        if name in ("cogging",) and len(missing_lines(analysis)) > 1 and analysis.inertia_known:
            effects["torque_ripple"] = _lines(analysis, kt, tomlkit.table())
        elif len(table):
            effects[name] = table
    return tomlkit.dumps(document)


def _final(analysis: Analysis, name: str) -> float:
    friction = analysis.friction
    return friction.final[name] if friction is not None and name in friction.final.names else 0.0


def _shaft_torques(analysis: Analysis) -> dict[str, float]:
    """Friction and load beyond the model, A; what is not separable is written as the first of its names."""
    friction = analysis.friction
    if friction is None:
        return {}
    found: dict[str, float] = {}
    for term in friction.terms:
        value = _final(analysis, f"{term.effect}.torque_a_equiv")
        names = term.effect.split(OR)
        if names[0] in SHAFT_TORQUES and value != 0.0:
            found[names[0] if value > 0.0 or len(names) == 1 else "load_torque"] = value
    return found


def _native(name: str, parameters: dict[str, float], kt: float) -> dict[str, float]:
    """Parameters as the effect's table has them."""
    out: dict[str, float] = {}
    for key, value in parameters.items():
        own = table_parameter(name, key)
        if own is not None:
            out[own] = value * kt if key in IN_AMPERES else value
    incomplete = name == "cogging" and "amplitude_nm" not in out
    return {} if incomplete or name == "current_offset" else out


def _base_value(nominal: Any, name: str, key: str) -> float:
    if nominal is None:
        return 1.0 if key == "factor" else 0.0
    return nominal.machine.effects.get(name, {}).get(key, 1.0 if key == "factor" else 0.0)


def _lines(analysis: Analysis, kt: float, table: Any) -> Any:
    """Several orders at once are the effect torque_ripple."""
    lines = sorted(missing_lines(analysis), key=lambda each: -each.line.amplitude_a)[:LINES]
    for i, each in enumerate(lines, 1):
        table[f"order_{i}"] = each.line.order
        table[f"amplitude_{i}_nm"] = _short(each.line.amplitude_a * kt)
        table[f"phase_{i}_rad"] = _short(each.line.phase_rad)
    return table


def _short(value: float) -> float:
    return float(f"{value:.6g}")
