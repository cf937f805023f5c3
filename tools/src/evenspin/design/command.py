"""`evenspin design rc`: from a model and what the user changes to a design and its tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.design.rc import PHASE_BAND_HZ, Design, Repetitive, design, gain_db
from evenspin.design.source import loop_of, repetitive_of
from evenspin.errors import InputError
from evenspin.model.machine import find_model, load_machine
from evenspin.native import tables
from evenspin.tableview import TableView, number


@dataclass(frozen=True, slots=True)
class Choices:
    """What the user gave instead of the model's; None: as the model has it."""

    gain: float | None = None
    lead: int | None = None
    q_side: float | None = None
    q_centre: float | None = None
    order: int | None = None
    fal: bool = False
    inertia_kgm2: float | None = None
    viscous_nms: float | None = None
    torque_per_a_nm: float | None = None
    kp_a_per_unit: float | None = None
    ki_a_per_unit_s: float | None = None
    error_gain: float | None = None
    current_bandwidth_rad_s: float | None = None
    delay_s: float | None = None
    speed_rpm: float = 307.0
    gain_at_hz: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Work:
    """A design and the gains that were asked for."""

    found: Design
    period_samples: float
    gains_db: Mapping[str, Any]


def prepare(model: str, choices: Choices) -> Work:
    """Load the model, apply the choices, compute."""

    def refuse(must: str, hint: str) -> InputError:
        return InputError("--model", "model", model, must, hint)

    machine = load_machine(find_model(model, Path(), refuse))
    drive = {name: field.default for name, field in tables().params.items()} | dict(machine.drive)
    loop = _with(loop_of(machine.plant, drive), choices)
    rc = _with(repetitive_of(drive, fal=choices.fal), choices)
    _check(rc, choices)
    period = 60.0 / (machine.plant["pole_pairs"] * choices.speed_rpm * loop.ts_s)
    whole = max(np.floor(period), 1.0)
    f_hz = np.array(choices.gain_at_hz or (1.0 / (whole * loop.ts_s), 1.0 / (period * loop.ts_s)))
    gains = {}
    for name, is_whole in (("crc", True), ("forc", False)):
        values = gain_db(rc, period, f_hz, loop.ts_s, whole=is_whole)
        gains[name] = {f"{f:.2f}_hz": float(value) for f, value in zip(f_hz, values, strict=True)}
    return Work(design(loop, rc), period, gains)


def tables_of(work: Work) -> list[TableView]:
    found = work.found
    own = found.margins
    verdict = "stable" if found.stable else "NOT stable"
    rows = [
        ("max |M|", number(found.max_m, 4), f"at {number(found.max_m_hz)} Hz"),
        (f"largest |phase of z^{own.lead} M|", f"{own.phase_deg:.1f} deg", f"up to {PHASE_BAND_HZ:g} Hz"),
        ("|phase| < 90 deg", f"{own.phase_90_hz:.0f} Hz", "up to here"),
        ("largest gain of fal", number(found.lambda_max, 5), "delta^(alpha-1)" if found.rc.fal else "no fal"),
        ("bound on k_rc, sufficient", number(own.bound_sufficient / found.lambda_max, 4), "2 min cos / max |M|"),
        ("bound on k_rc, exact", number(own.bound / found.lambda_max, 4), f"reached at {number(own.bound_hz)} Hz"),
        ("max |Q (1 - k_rc z^m M)|", number(own.contraction, 4), f"at {number(own.contraction_hz)} Hz"),
        ("recommended lead m", str(found.recommended_lead), "smallest of the line above"),
        (f"k_rc = {found.rc.gain:g}", verdict, ""),
    ]
    result = TableView("Repetitive control in the speed loop", "", ("", "", ""), rows, left=1)
    return [result, _leads(found), _gains(work)]


def _leads(found: Design) -> TableView:
    rows = [
        (
            str(each.lead),
            f"{each.phase_deg:.1f}",
            f"{each.phase_90_hz:.0f}",
            number(each.bound_sufficient / found.lambda_max),
            number(each.bound / found.lambda_max),
            number(each.contraction),
        )
        for each in found.by_lead
    ]
    marks = ["good" if each.lead == found.recommended_lead else "" for each in found.by_lead]
    header = ("m", "phase deg", "90 deg Hz", "k_rc suff.", "k_rc exact", "max |Q(1 - k_rc z^m M)|")
    return TableView("By lead", "", header, rows, marks, left=0)


def _gains(work: Work) -> TableView:
    gains = work.gains_db
    whole = int(work.period_samples)
    rows = [(at.removesuffix("_hz"), f"{gains['crc'][at]:.1f}", f"{gains['forc'][at]:.1f}") for at in gains["crc"]]
    header = ("Hz", f"CRC, N = {whole}, dB", f"FORC, N = {work.period_samples:.2f}, dB")
    return TableView("|1 + G_RC|", "", header, rows, left=0)


def _with(base: Any, choices: Choices) -> Any:
    """The dataclass with every field that the user gave."""
    names = {field.name for field in fields(base)} - {"fal"}
    given = {field.name: getattr(choices, field.name) for field in fields(choices) if field.name in names}
    return replace(base, **{name: value for name, value in given.items() if value is not None})


def _check(rc: Repetitive, choices: Choices) -> None:
    if not 0.0 < rc.gain < 100.0:
        raise InputError("design rc", "--k-rc", rc.gain, "above 0 and below 100", "try 0.6")
    if not abs(rc.q_centre) + 2.0 * abs(rc.q_side) <= 1.0 + 1e-6:
        must = "such that |centre| + 2 |side| <= 1"
        raise InputError("design rc", "--q-centre", rc.q_centre, must, "try 0.1 and 0.45")
    if not 0.0 < choices.speed_rpm < 1e6:
        raise InputError("design rc", "--speed-rpm", choices.speed_rpm, "above 0", "try 300")
    for f_hz in choices.gain_at_hz:
        if not 0.0 < f_hz < 1e6:
            raise InputError("design rc", "--gain-at", f_hz, "above 0", "give a frequency in Hz")
