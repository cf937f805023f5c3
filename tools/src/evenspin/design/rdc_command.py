"""`evenspin design rdc`: from a model and what the user changes to a design and its tables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from evenspin.design.rdc import RdcDesign, RdcLoop, design
from evenspin.design.rdc_intervals import Motion, Uncertainty, table_of, uncertainty
from evenspin.errors import InputError
from evenspin.model.machine import find_model, load_machine
from evenspin.native import tables
from evenspin.tableview import TableView


def prepare(model: str, choices: Mapping[str, float | None]) -> RdcDesign:
    """`choices`: fields of RdcLoop, rho_nm, sigma, q; None as the model has it."""

    def refuse(must: str, hint: str) -> InputError:
        return InputError("--model", "model", model, must, hint)

    machine = load_machine(find_model(model, Path(), refuse))
    drive = {name: field.default for name, field in tables().params.items()} | dict(machine.drive)
    plant = machine.plant
    loop_fields = {field.name for field in fields(RdcLoop)}
    loop = RdcLoop(
        kpp_per_s=drive["position_kp_per_s"],
        kvp_a_per_rad_s=drive["position_kv_a_per_rad_s"],
        ti_s=drive["position_ti_s"],
        torque_per_a_nm=machine.torque_per_a_nm,
        inertia_kgm2=plant["inertia_kgm2"],
        viscous_nms=plant["viscous_nms"],
        ts_s=drive["speed_divider"] / plant["pwm_hz"],
        current_bandwidth_rad_s=drive["current_kp_v_per_a"] / plant["lq_h"],
        interrupt_s=0.0 if drive["speed_inline"] else 1.0 / plant["pwm_hz"],
        delay_samples=int(drive["torque_delay_samples"]),
    )
    given = {name: value for name, value in choices.items() if value is not None}
    changes: dict[str, Any] = {name: value for name, value in given.items() if name in loop_fields}
    loop = replace(loop, **changes)
    rho, sigma = given.get("rho_nm", drive["rdc_rho_nm"]), given.get("sigma", drive["rdc_sigma"])
    return design(loop, rho, sigma, given.get("q", 1.0))


def uncertainty_of(
    identified: Path | None, speed_rpm: float | None, accel_rad_s2: float | None, turns: float | None
) -> Uncertainty | None:
    """What an identification leaves open in a motion; None without one."""
    motion = {"--speed-rpm": speed_rpm, "--accel-rad-s2": accel_rad_s2, "--turns": turns}
    if identified is None:
        for name, value in motion.items():
            if value is not None:
                raise InputError("design rdc", name, value, "left out without --identified", "add --identified FILE")
        return None
    speed = 20.0 if speed_rpm is None else speed_rpm
    chosen = Motion(speed * math.pi / 30.0, accel_rad_s2 or 0.0, 10.0 if turns is None else turns)
    return uncertainty(identified, chosen)


def tables_of(found: RdcDesign, left_open: Uncertainty | None = None) -> list[TableView]:
    loop = found.loop
    rows = [
        ("eigenvalues of A", ", ".join(_root(value) for value in found.eigenvalues), "1/s, stable"),
        ("third row of P", ", ".join(f"{value:.6g}" for value in found.p_row), f"q = {found.q:g}"),
        ("rho / sigma", f"{found.ratio:.4g}", f"{found.rho_nm:g} N m / {found.sigma:g}"),
        ("chatters above", f"{found.limit:.3g}", f"with a delay of {loop.delay_samples} samples"),
        ("", f"{found.limit_undelayed:.3g}", "without"),
        (
            "error settles below",
            f"{found.error_bound:.3g}",
            f"rad s, rad and rad/s together (theorem 1), while the model errs by less than {found.rho_nm:g} N m",
        ),
    ]
    text = found.warning or "The limit is where a root of the sampled loop leaves the unit circle."
    marks = ["", "", "bad" if found.warning else "good", "", "", ""]
    views = [TableView("Robust driving control", text, ("", "", ""), rows, marks, left=1)]
    return views if left_open is None else [*views, table_of(left_open, found.rho_nm)]


def drive_text(found: RdcDesign) -> str:
    return "\n".join(["[drive]", *(f"{name} = {value:.6g}" for name, value in found.drive().items()), ""])


def _root(value: complex) -> str:
    return f"{value.real:.1f}" if abs(value.imag) < 1e-9 else f"{value.real:.1f} {value.imag:+.1f}j"
