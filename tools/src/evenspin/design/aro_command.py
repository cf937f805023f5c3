"""`evenspin design aro`: from a model and what the user changes to a design and its tables."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evenspin.design.aro import (
    WHERE,
    Chain,
    Design,
    Mechanics,
    Memory,
    drive_parameters,
    gain_of,
    place_speed_poles,
)
from evenspin.design.aro_separation import separation_error
from evenspin.errors import InputError
from evenspin.model.machine import find_model, load_machine
from evenspin.native import tables
from evenspin.tableview import TableView, number

SPEEDS_RPM = (100.0, 451.0, 1000.0, 2000.0, 3000.0)
ORDER = 12
MIN_CELLS, MAX_CELLS = 4, 2048


@dataclass(frozen=True, slots=True)
class Choices:
    """What the user gave instead of the model's; None: as the model has it."""

    cells: int | None = None
    gain: float | None = None
    pole: float | None = None
    turns: float | None = None
    forgetting: float | None = None
    pi_hz: float = 16.0
    inertia_kgm2: float | None = None
    viscous_nms: float | None = None
    order: int = ORDER


def prepare(model: str, choices: Choices) -> Design:
    """Load the model, apply the choices, place the poles."""

    def refuse(must: str, hint: str) -> InputError:
        return InputError("--model", "model", model, must, hint)

    machine = load_machine(find_model(model, Path(), refuse))
    drive = {name: field.default for name, field in tables().params.items()} | dict(machine.drive)
    ts_s = 1.0 / machine.plant["pwm_hz"]
    cells = choices.cells if choices.cells is not None else int(drive["aro_cells"])
    if not MIN_CELLS <= cells <= MAX_CELLS:
        raise InputError(WHERE, "--cells", cells, f"within {MIN_CELLS} .. {MAX_CELLS}", "the paper has 200")
    forgetting = _given(choices.forgetting, drive["observer_forgetting"])
    if not 0.0 < forgetting <= 1.0:
        raise InputError(WHERE, "--forgetting", forgetting, "above 0 and at most 1", "1 forgets nothing")
    mechanics = Mechanics(
        _given(choices.inertia_kgm2, machine.plant["inertia_kgm2"]),
        _given(choices.viscous_nms, machine.plant["viscous_nms"]),
        ts_s,
    )
    chain = Chain(
        int(drive["observer_fir1_order"]),
        drive["observer_fir1_hz"],
        int(drive["observer_fir2_order"]),
        drive["observer_fir2_hz"],
        drive["observer_actuation_samples"],
        ts_s,
    )
    memory = Memory(cells, _gain(choices, drive["observer_gain"], cells, forgetting), forgetting, mechanics.a23)
    speed = place_speed_poles(mechanics, chain, choices.pi_hz)
    return Design(mechanics, chain, memory, speed, machine.torque_per_a_nm)


def tables_of(found: Design, order: int = ORDER) -> list[TableView]:
    return [_memory(found), _speed(found), _chain(found, order), _parameters(found)]


def _memory(found: Design) -> TableView:
    memory = found.memory
    verdict = "stable" if memory.stable else "NOT stable"
    rows = [
        ("learning gain a23 L_N", number(memory.gain, 4), ""),
        ("L_N", f"{number(memory.observer_gain, 4)} N m s/rad", f"0 < L_N < {number(memory.bound, 4)}: {verdict}"),
        (f"|lambda|, all {memory.cells} poles", f"{memory.pole:.6f}", "equation 16"),
        ("left of an error per turn", number(abs(memory.per_turn), 4), "lambda^N"),
        ("time constant", f"{number(memory.turns_to(math.exp(-1.0)))} turns", "whatever the speed"),
        ("error down to 10 %", f"{number(memory.turns_to(0.1))} turns", ""),
    ]
    marks = ["", "good" if memory.stable else "bad", "", "", "", ""]
    return TableView("Memory", "", ("", "", ""), rows, marks, left=1)


def _speed(found: Design) -> TableView:
    speed, ts_s = found.speed, found.mechanics.ts_s
    rows = [
        ("double pole", f"{speed.wanted:.6f}", f"2 pi {number(speed.pole_hz)} rad/s"),
        ("K_P", f"{number(speed.kp_nms, 4)} N m s/rad", ""),
        ("K_I per sample", f"{number(speed.ki_nms / 1e-3, 4)} mN m s/rad", f"{number(speed.ki_nms / ts_s, 4)} N m/rad"),
    ]
    for name, roots in (("(17)", speed.roots), ("with all delays", speed.real_roots)):
        for root in _visible(roots, ts_s):
            rows.append((f"root, {name}", _complex(root), f"{_hertz(root, ts_s)}"))
    off = separation_error(found.mechanics, found.memory, speed)
    rows.append(("memory and loop together", "each keeps its poles", f"(14), (15): off by {off:.1g}"))
    text = "Delays: torque reference to torque, and the speed filter. Roots faster than 1 kHz are left out."
    return TableView("Speed controller", text, ("", "", ""), rows, left=1)


def _chain(found: Design, order: int) -> TableView:
    chain = found.chain
    speeds = np.array(SPEEDS_RPM)
    seen = chain.gain(order * speeds / 60.0)
    rows = [
        (f"{rpm:g}", f"{order * rpm / 60.0:g}", number(gain), f"{20.0 * math.log10(max(abs(1.0 - gain), 1e-6)):.0f}")
        for rpm, gain in zip(speeds, seen.tolist(), strict=True)
    ]
    text = (
        f"The measured torque is {chain.age_samples:g} samples old: 1/2 + {chain.fir1_order}/2 + 1/2 + "
        f"{chain.fir2_order}/2 (the printed label is k-{chain.printed_label}). It is read out "
        f"{chain.actuation_samples:g} samples ahead. The filters show less of a fast ripple; so much of it stays."
    )
    header = ("rpm", f"order {order}, Hz", "part that is seen", "residue, dB")
    return TableView("Torque measurement", text, header, rows, left=0)


def _parameters(found: Design) -> TableView:
    rows = [(name, f"{value:.6g}") for name, value in drive_parameters(found).items()]
    text = "The speed loop runs in the current interrupt (speed_divider = 1, speed_inline = true, speed_source = fir)."
    return TableView("For [drive]", text, ("", ""), rows, left=1)


def _gain(choices: Choices, model_gain: float, cells: int, forgetting: float) -> float:
    given = {"--gain": choices.gain, "--pole": choices.pole, "--turns": choices.turns}
    named = [name for name, value in given.items() if value is not None]
    if len(named) > 1:
        raise InputError(WHERE, named[1], given[named[1]], f"left out beside {named[0]}", "each of them sets the pole")
    if choices.pole is not None or choices.turns is not None:
        return gain_of(cells=cells, forgetting=forgetting, pole=choices.pole, turns=choices.turns)
    gain = _given(choices.gain, model_gain)
    if not math.isfinite(gain):
        raise InputError(WHERE, "--gain", gain, "finite", "the paper has 0.05")
    return gain


def _given(choice: float | None, other: float) -> float:
    return other if choice is None else choice


def _visible(roots: np.ndarray, ts_s: float) -> list[complex]:
    """One of each conjugate pair, and none that has died out before anyone can see it."""
    slow = math.exp(-2.0 * math.pi * 1000.0 * ts_s)
    return [complex(root) for root in roots if root.imag >= -1e-12 and abs(root) > slow]


def _complex(root: complex) -> str:
    return f"{root.real:.5f}" + (f" +- {root.imag:.5f} j" if root.imag > 1e-9 else "")


def _hertz(root: complex, ts_s: float) -> str:
    s = np.log(root) / ts_s
    damping = -s.real / abs(s) if abs(s) > 0.0 else 1.0
    return f"{number(abs(s) / (2.0 * math.pi))} Hz, damping {damping:.2f}"
