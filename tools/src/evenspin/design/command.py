"""`evenspin design rc`: from a model and what the user changes to a design and its tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.design.rc import PHASE_BAND_HZ, Design, Repetitive, as_json, design, gain_db
from evenspin.design.sampled import sampled_loop
from evenspin.design.source import loop_of, repetitive_of
from evenspin.design.stability import Stability, Verdict, judge
from evenspin.errors import InputError
from evenspin.model.machine import DEFAULT_ORIGIN, Machine, find_model, load_machine
from evenspin.native import tables
from evenspin.tableview import TableView, number

MAX_DELAY_S = 0.1
PLANT_NUMBERS = ("pole_pairs", "resistance_ohm", "ld_h", "lq_h", "psi_wb", "inertia_kgm2", "viscous_nms")
DRIVE_NUMBERS = (
    "current_kp_v_per_a", "current_ki_v_per_as", "speed_kp_a_per_unit", "speed_ki_a_per_unit_s", "speed_error_gain",
)  # fmt: skip
COVERS = (
    "Small-signal, with every sample and delay of current loop, speed measurement and speed loop. Not covered: limits, "
    "encoder steps, dead time, dry friction, elastic shafts, observers."
)


@dataclass(frozen=True, slots=True)
class Choices:
    """What the user gave instead of the model's; None: as the model has it."""

    gain: float | None = None
    lead: int | None = None
    q_side: float | None = None
    q_centre: float | None = None
    q_side2: float | None = None
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
    """What was found, of the loop as the drive runs it and of the paper's, and where its numbers come from.

    `found` is None when the speed loop is unstable by itself: then no bound of a learning gain means anything.
    """

    stability: Stability
    found: Design | None
    first_order: Design
    period_samples: float
    edges_per_sample: float
    gains_db: Mapping[str, Any]
    numbers: Sequence[tuple[str, float, str, str]]  # name, value, unit, where from

    @property
    def stable(self) -> bool:
        return self.stability.verdict is Verdict.STABLE

    def as_json(self) -> dict[str, Any]:
        first_order = as_json(self.first_order)
        bounds = {"k_rc_bound": 0.0, "k_rc_bound_sufficient": 0.0, "rc": first_order["rc"]}
        content = as_json(self.found) if self.found is not None else bounds
        return content | {
            "stable": self.stable,
            "stability": asdict(self.stability),
            "first_order": first_order,
            "edges_per_sample": self.edges_per_sample,
            "numbers": {name: {"value": value, "from": origin} for name, value, _, origin in self.numbers},
            "gains_db": self.gains_db,
            "period_samples": self.period_samples,
        }


def prepare(model: str, choices: Choices) -> Work:
    """Load the model, apply the choices, compute."""

    def refuse(must: str, hint: str) -> InputError:
        return InputError("--model", "model", model, must, hint)

    machine = load_machine(find_model(model, Path(), refuse))
    plant, drive, given = changed(machine, choices)
    loop = loop_of(plant, drive, choices.delay_s or 0.0)
    rc = _with(repetitive_of(drive, fal=choices.fal), choices)
    _check(rc, choices)
    period = 60.0 / (plant["pole_pairs"] * choices.speed_rpm * loop.ts_s)
    whole = max(np.floor(period), 1.0)
    f_hz = np.array(choices.gain_at_hz or (1.0 / (whole * loop.ts_s), 1.0 / (period * loop.ts_s)))
    gains = {}
    for name, is_whole in (("crc", True), ("forc", False)):
        values = gain_db(rc, period, f_hz, loop.ts_s, whole=is_whole)
        gains[name] = {f"{f:.2f}_hz": float(value) for f, value in zip(f_hz, values, strict=True)}
    speed_rad_s, late = choices.speed_rpm * np.pi / 30.0, _periods(choices.delay_s or 0.0, plant["pwm_hz"])
    crc = tables().params["method"].to_text(drive["method"]) == "crc"
    stability = judge(plant, drive, speed_rad_s, rc, whole=crc, delay_periods=late)
    sampled = sampled_loop(plant, drive, speed_rad_s, late)
    found = design(sampled, rc) if stability.radius_alone < 1.0 else None
    edges = sampled.edges_per_sample
    return Work(stability, found, design(loop, rc), period, edges, gains, numbers_of(machine, plant, drive, given))


def changed(machine: Machine, choices: Choices) -> tuple[dict[str, float], dict[str, float], dict[str, str]]:
    """Plant and drive with what the user gave, and the option behind each number that was given by one."""
    plant = dict(machine.plant)
    drive = {name: field.default for name, field in tables().params.items()} | dict(machine.drive)
    given: dict[str, str] = {}

    def take(target: dict[str, float], name: str, value: float | None, option: str) -> None:
        if value is not None:
            target[name], given[name] = value, option

    take(plant, "inertia_kgm2", choices.inertia_kgm2, "--inertia-kgm2")
    take(plant, "viscous_nms", choices.viscous_nms, "--viscous-nms")
    if choices.torque_per_a_nm is not None:
        psi = choices.torque_per_a_nm / (1.5 * plant["pole_pairs"])
        take(plant, "psi_wb", psi, "--torque-per-a-nm")
    take(drive, "speed_kp_a_per_unit", choices.kp_a_per_unit, "--kp")
    take(drive, "speed_ki_a_per_unit_s", choices.ki_a_per_unit_s, "--ki")
    take(drive, "speed_error_gain", choices.error_gain, "--error-gain")
    if choices.current_bandwidth_rad_s is not None:
        wide = choices.current_bandwidth_rad_s
        drive["current_controller"] = tables().params["current_controller"].to_number("pi")
        take(drive, "current_kp_v_per_a", wide * plant["lq_h"], "--bandwidth-rad-s")
        take(drive, "current_ki_v_per_as", wide * plant["resistance_ohm"], "--bandwidth-rad-s")
    return plant, drive, given


def numbers_of(
    machine: Machine, plant: Mapping[str, float], drive: Mapping[str, float], given: Mapping[str, str]
) -> list[tuple[str, float, str, str]]:
    """What the verdict is calculated with."""
    found = []
    for name in PLANT_NUMBERS:
        origin = given.get(name, machine.plant_from.get(name, "not given: 0 or off"))
        found.append((name, plant[name], tables().model[name].unit, origin))
    for name in DRIVE_NUMBERS:
        origin = given.get(name, machine.drive_from.get(name, DEFAULT_ORIGIN))
        found.append((name, drive[name], tables().params[name].unit, origin))
    return found


def _periods(delay_s: float, pwm_hz: float) -> int:
    """A delay of the loop in PWM periods, rounded up: late is the unsafe side."""
    if not 0.0 <= delay_s <= MAX_DELAY_S:
        raise InputError("design rc", "--delay-s", delay_s, f"in 0 .. {MAX_DELAY_S:g} s", "leave it out")
    return int(np.ceil(delay_s * pwm_hz - 1e-9))


def tables_of(work: Work) -> list[TableView]:
    """Without bounds when the speed loop is unstable by itself."""
    margins = [] if work.found is None else [_margins(work, work.found), _leads(work.found), _gains(work)]
    return [_verdict(work), *margins, _numbers(work)]


def _verdict(work: Work) -> TableView:
    found = work.stability
    word = "marginal, not to be called stable" if found.verdict is Verdict.MARGINAL else str(found.verdict)
    rows = [
        ("verdict", word, found.reason),
        ("largest pole, speed loop alone", f"{found.radius_alone:.5g}", "stable below 1, per speed sample"),
        ("largest pole, with repetitive control", f"{found.radius:.5g}", ""),
    ]
    text = COVERS
    if work.edges_per_sample < 1.0:
        text += f" The encoder gives {work.edges_per_sample:.2g} edges in a speed sample: M/T speed is later than here."
    title = f"Speed loop with k_rc = {work.first_order.rc.gain:g} at {found.speed_rad_s * 30.0 / np.pi:.4g} r/min"
    marks = ["good" if found.verdict is Verdict.STABLE else "bad", "", ""]
    return TableView(title, text, ("", "", ""), rows, marks, left=1)


def _margins(work: Work, found: Design) -> TableView:
    first = work.first_order
    ripple_hz = np.array([1.0, 2.0]) / (work.period_samples * found.loop.ts_s)
    q = ", ".join(f"{value:.3f}" for value in found.rc.q(ripple_hz, found.loop.ts_s))

    def both(value: Callable[[Design], str]) -> tuple[str, str]:
        return value(found), value(first)

    def at(value: float, f_hz: float) -> str:
        return f"{number(value, 4)} at {number(f_hz)} Hz"

    rows = [
        ("max |M|", *both(lambda d: at(d.max_m, d.max_m_hz))),
        (f"largest |phase of z^{found.rc.lead} M|", *both(lambda d: f"{d.margins.phase_deg:.1f} deg")),
        ("|phase| < 90 deg up to", *both(lambda d: f"{d.margins.phase_90_hz:.0f} Hz")),
        ("largest gain of fal", *both(lambda d: number(d.lambda_max, 5))),
        ("bound on k_rc, sufficient", *both(lambda d: number(d.margins.bound_sufficient / d.lambda_max))),
        ("bound on k_rc, every speed", *both(lambda d: at(d.margins.bound / d.lambda_max, d.margins.bound_hz))),
        (f"Q at {ripple_hz[0]:.4g} and {ripple_hz[1]:.4g} Hz, orders 1 and 2", q, q),
        ("max |Q (1 - k_rc z^m M)|", *both(lambda d: at(d.margins.contraction, d.margins.contraction_hz))),
        ("recommended lead m", *both(lambda d: str(d.recommended_lead))),
    ]
    text = f"Phase: up to {PHASE_BAND_HZ:g} Hz. Sufficient: 2 min cos(phase) / max |M|. First order: as in the paper."
    header = ("", "as the drive runs it", "first-order current loop")
    return TableView("Repetitive control in the speed loop", text, header, rows, left=1)


def _numbers(work: Work) -> TableView:
    rows = [(name, f"{value:.6g}", unit, origin) for name, value, unit, origin in work.numbers]
    marks = ["bad" if origin == DEFAULT_ORIGIN else "" for *_, origin in rows]
    return TableView("Calculated with", "", ("number", "value", "unit", "from"), rows, marks, left=1)


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
    if not rc.q_peak <= 1.0 + 1e-6:
        must = f"such that |Q| <= 1 at every frequency, here up to {rc.q_peak:.4g}"
        must = must if rc.q_side2 else "such that |centre| + 2 |side| <= 1"
        raise InputError("design rc", "--q-centre", rc.q_centre, must, "try 0.1 and 0.45")
    if not 0.0 < choices.speed_rpm < 1e6:
        raise InputError("design rc", "--speed-rpm", choices.speed_rpm, "above 0", "try 300")
    for f_hz in choices.gain_at_hz:
        if not 0.0 < f_hz < 1e6:
            raise InputError("design rc", "--gain-at", f_hz, "above 0", "give a frequency in Hz")
