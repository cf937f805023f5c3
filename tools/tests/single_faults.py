"""Every single fault that the simulator can inject, at moments spread over start, run-up, load, reversal or motion: how
long until the bridge is off, and how far current and speed have gone by then. `make single-faults` writes
docs/single-faults.md.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import bit_flips
import numpy as np
from evenspin.model.machine import builtin_models, load_machine
from evenspin.native import tables
from evenspin.native.simulation import Simulation

PAGE = Path(__file__).resolve().parents[2] / "docs" / "single-faults.md"
PERIOD_S = 1e-4
WATCHED_PERIODS = 15000
SPEED, CURRENT, POSITION = 1.0, 0.0, 2.0
HEALTHY = {"current_a_gain": 1.0, "current_b_gain": 1.0}


@dataclass(frozen=True)
class Setup:
    name: str
    model: str
    mode: float
    drive: dict[str, float]


@dataclass(frozen=True)
class Fault:
    """What an input becomes at the moment of the fault; `always`: what the board is like. `why`: if it is not found."""

    name: str
    becomes: dict[str, float]
    always: tuple[str, ...] = ()
    ramp: bool = False  # so much a second
    why: str = ""


SETUPS = (
    Setup("speed, pi", "guo2024", SPEED, {}),
    Setup("speed, aro", "guo2024", SPEED, {"method": 6.0, "speed_source": 0.0}),
    Setup("current", "guo2024", CURRENT, {}),
    Setup("position, rdc", "guo2024", POSITION, {"position_method": 3.0, "following_error_rad": 100.0}),
    Setup("speed, pi, 150 V", "servo", SPEED, {}),
    Setup("speed, deadbeat, 310 V", "tang2020-rig1", SPEED, {}),
)

SHIFT = (
    "in a resting motor a shifted reading looks like another resistance, in a turning one its drop R 3 A "
    "stays below dead time and tolerances; found when the reading jumps by more than they allow. A third "
    "sensor closes it: the sum of the currents"
)
HALF = (
    "found while the wrong share of the current, its drop and its change with the angle, is larger than the "
    "tolerances of R and L. A third sensor closes it: the sum of the currents"
)
REST = (
    "in current mode a shaft that stands still is in order, and while the motor is slow its back-EMF is below "
    "the tolerances. A second encoder, or Hall signals, would close it"
)
CREEP = (
    "the torque falls with the cosine of the angle that is lost, and the back-EMF contradicts once that is "
    "more than motor_flux_tolerance. With an index pulse (encoder_index_rad) it is found at the next one"
)
SAG = (
    "under_voltage_v of these models is the default, 10 V: a fifth of their link is above it. Set "
    "under_voltage_v for the link"
)
INLINE = "the speed loop of this model runs inside the current interrupt: there is no such interrupt"
FAULTS = (
    Fault("sensor a reads 0", {"current_a_gain": 0.0}),
    Fault("sensor a stands", {"current_a_stands": 1.0}),
    Fault("sensor a reversed", {"current_a_gain": -1.0}),
    Fault("sensor a reads half", {"current_a_gain": 0.5}, why=HALF),
    Fault("sensor a shifted by 3 A", {"current_a_offset_a": 3.0}, why=SHIFT),
    Fault("sensor b reads 0", {"current_b_gain": 0.0}),
    Fault("all currents read 0", {"current_a_gain": 0.0, "current_b_gain": 0.0}),
    Fault("sensor a reads 0, three sensors", {"current_a_gain": 0.0}, ("third_sensor",)),
    Fault("sensor a stands, three sensors", {"current_a_stands": 1.0}, ("third_sensor",)),
    Fault("sensor a reads half, three sensors", {"current_a_gain": 0.5}, ("third_sensor",)),
    Fault("sensor a shifted by 3 A, three sensors", {"current_a_offset_a": 3.0}, ("third_sensor",)),
    Fault("current is not a number", {"current_nan": 1.0}),
    Fault("phase a open", {"open_phase": 1.0}),
    Fault("phase c open", {"open_phase": 3.0}),
    Fault("encoder stands", {"encoder_stuck": 1.0}, why=REST),
    Fault("encoder jumps by 5 degrees", {"encoder_slip_rad": 0.0873}),
    Fault("encoder slips by 2 rad/s", {"encoder_slip_rad": 2.0}, ramp=True, why=CREEP),
    Fault("encoder error line", {"encoder_error": 1.0}),
    Fault("no new sample", {"sample_lost": 1.0}),
    Fault("comparator", {"inverter_fault": 1.0}),
    Fault("gate driver", {"inverter_fault": 2.0}),
    Fault("dc link falls to a fifth", {"dc_link_v": 0.2}, why=SAG),
    Fault("dc link rises to 2.2 times", {"dc_link_v": 2.2}),
    Fault("current interrupt takes 1.1 periods", {"isr_load_cyc": 22000.0}),
    Fault("speed interrupt takes 11 periods", {"speed_isr_load_cyc": 220000.0}, why=INLINE),
)


@dataclass(frozen=True)
class Outcome:
    fault: str  # first report, "none" when there is none
    phase: str
    periods: int  # from the fault to the bridge off
    current: float  # largest until then, over over_current_a
    speed: float  # largest until then, over the largest before


def phases_of(mode: float) -> tuple[tuple[float, str], ...]:
    """From which second on."""
    if mode == SPEED:
        return (0.0, "start"), (0.05, "run"), (0.3, "load"), (0.4, "reversal")
    if mode == CURRENT:
        return (0.0, "start"), (0.15, "reversal"), (0.3, "step")
    return (0.0, "motion"), (0.4, "way back")


def last_moment_s(mode: float) -> float:
    return {SPEED: 0.6, CURRENT: 0.5, POSITION: 0.7}[mode]


def prepared(setup: Setup, seed: int, numeric: str) -> tuple[Simulation, float, float]:
    """A drive on its course. @return it, its over-current limit, its dc link."""
    machine = load_machine(builtin_models()[setup.model])
    plant = {**machine.plant}
    plant["current_noise_a"] = max(plant["current_noise_a"], 0.01)
    plant["current_lsb_a"] = max(plant["current_lsb_a"], 0.0105)
    drive = {**machine.drive, **setup.drive, "offset_calibration_periods": 0.0, "align_periods": 0.0, "auto_run": 1.0}
    limit_a = drive.get("iq_limit_a", 10.0)
    torque_nm = 1.5 * plant["pole_pairs"] * plant["psi_wb"] * limit_a
    top = min(0.4 * plant["dc_link_v"] / math.sqrt(3.0) / (plant["pole_pairs"] * plant["psi_wb"]), 200.0)
    inputs: dict[str, tuple[list[float], list[float]]] = {"control_mode": ([0.0], [setup.mode])}
    if setup.mode == SPEED:
        inputs["speed_ref_rad_s"] = [0.0, 0.4], [top, -top] if seed % 2 else [0.3 * top, top]
        inputs["load_brake_nm"] = [0.0, 0.3], [0.1 * torque_nm, 0.4 * torque_nm]
    elif setup.mode == CURRENT:
        plant["viscous_nms"] = 0.8 * torque_nm / top
        inputs["iq_ref_a"] = [0.0, 0.15, 0.3], [0.5 * limit_a, -0.3 * limit_a, 0.8 * limit_a]
    else:
        inputs["position_ref_rad"] = [0.0, 0.4], [20.0, -20.0]
        inputs["load_brake_nm"] = [0.0], [0.2 * torque_nm]
        drive |= {"profile_speed_rad_s": 50.0, "profile_accel_rad_s2": 500.0}
        drive["position_kv_a_per_rad_s"] = drive.get("speed_kp_a_per_unit", 0.0368) * drive.get("speed_error_gain", 4.0)
    simulation = Simulation(numeric)
    for name, value in plant.items():
        simulation.set_model(name, value)
    for name, value in drive.items():
        simulation.set_param(name, value)
    for name, (t_s, values) in inputs.items():
        simulation.set_input(name, t_s, values)
    simulation.set_seed(seed + 1)
    return simulation, drive.get("over_current_a", 20.0), plant["dc_link_v"]


def inject(setup: Setup, fault: Fault, moment: int, moments: int, numeric: str = "float") -> Outcome:
    simulation, over_a, dc_link_v = prepared(setup, moment, numeric)
    rnd = random.Random(f"{setup.name} {fault.name} {moment}")
    share = (moment + rnd.random()) / moments
    at = round((0.005 + share * (last_moment_s(setup.mode) - 0.005)) / PERIOD_S)
    for name in fault.always:
        simulation.set_input(name, [0.0], [1.0])
    for name, value in fault.becomes.items():
        before, after = HEALTHY.get(name, 0.0), value
        if name == "dc_link_v":
            before, after = dc_link_v, value * dc_link_v
        if fault.ramp:
            times = [0.0, at * PERIOD_S, at * PERIOD_S + 10.0]
            simulation.set_input(name, times, [before, before, before + 10.0 * after], linear=True)
        else:
            simulation.set_input(name, [0.0, at * PERIOD_S], [before, after])
    simulation.start()
    simulation.record(["fault", "true_ia_a", "true_ib_a", "true_ic_a", "true_speed_rad_s"])
    healthy = simulation.run(at)
    if healthy[-1, 0] != 0:
        raise RuntimeError(f"{setup.name}: {tables().faults[int(healthy[-1, 0])].name} before the fault")
    rows = simulation.run(WATCHED_PERIODS)
    found = np.nonzero(rows[:, 0])[0]
    end = int(found[0]) + 1 if found.size else len(rows)
    phase = [name for from_s, name in phases_of(setup.mode) if from_s <= at * PERIOD_S][-1]
    name = tables().faults[int(rows[end - 1, 0])].name if found.size else "none"
    current = float(np.abs(rows[:end, 1:4]).max()) / over_a
    speed = float(np.abs(rows[:end, 4]).max() / max(float(np.abs(healthy[:, 4]).max()), 20.0))
    return Outcome(name, phase, end, current, speed)


def line(fault: Fault, outcomes: Sequence[Outcome]) -> str:
    found = sorted(one.periods for one in outcomes if one.fault != "none")
    missed = Counter(one.phase for one in outcomes if one.fault == "none")
    reports = Counter(one.fault for one in outcomes if one.fault != "none")
    times = f"{found[len(found) // 2] / 10:.1f} | {found[-1] / 10:.1f}" if found else "- | -"
    words = ", ".join(f"`{name}`" + (f" {count}" if len(reports) > 1 else "") for name, count in reports.most_common())
    missing = ", ".join(f"{phase} {count}" for phase, count in sorted(missed.items()))
    worst = f"{max(one.current for one in outcomes):.2f} | {max(one.speed for one in outcomes):.2f}"
    return f"| {fault.name} | {len(found)} of {len(outcomes)} | {times} | {worst} | {words or '-'} | {missing} |"


def page(moments: int, results: Iterable[tuple[Setup, Fault, Sequence[Outcome]]]) -> str:
    lines = [
        "<!-- Made by `make single-faults`. Do not edit. -->", "", "# Single faults", "",
        f"Each fault at {moments} moments spread over the operation,",
        "simulated for 1.5 s with everything else healthy. *ms*: from the fault to the bridge off, median and",
        "longest. *Current*: the largest of the true phase currents until then, over `over_current_a`. *Speed*:",
        "the largest until then, over the largest before the fault. *Not found in*: phases of the operation, and",
        "how often. Without *three sensors* the board has two current sensors. What the simulator cannot inject is",
        "not here: a current interrupt that does not come (the hardware of the board switches off,",
        "`late_interrupt`), shorts, a switch that stays on. The comparators of the board, which switch off above",
        "1.0 by themselves, are left out on purpose. A memory that changes by itself has the last chapter.",
        "",
    ]  # fmt: skip
    gaps: dict[str, list[str]] = {}
    last = None
    for setup, fault, outcomes in results:
        if setup != last:
            lines += ["", f"## {setup.name} (`{setup.model}`)", ""]
            lines += ["| fault | found | ms | longest | current | speed | first report | not found in |"]
            lines += ["| --- | --- | --- | --- | --- | --- | --- | --- |"]
            last = setup
        lines.append(line(fault, outcomes))
        if any(one.fault == "none" for one in outcomes):
            gaps.setdefault(fault.name, []).append(setup.name)
    why = {fault.name: fault.why for fault in FAULTS}
    lines += [
        "",
        "## Gaps",
        "",
        "| fault | not always found in | why, and what would close it |",
        "| --- | --- | --- |",
    ]
    lines += [f"| {name} | {'; '.join(setups)} | {why[name] or 'not known'} |" for name, setups in gaps.items()]
    return "\n".join(lines) + "\n"


def all_results(moments: int) -> Iterable[tuple[Setup, Fault, list[Outcome]]]:
    for number, setup in enumerate(SETUPS):
        for fault in FAULTS:
            if sys.stderr.isatty():
                print(f"\r{number + 1} of {len(SETUPS)}: {fault.name:44s}", end="", file=sys.stderr)
            yield setup, fault, [inject(setup, fault, k, moments) for k in range(moments)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--moments", type=int, default=64)
    parser.add_argument("--flips", type=int, default=300, help="bit flips for each part of the state and method")
    parser.add_argument("--only-flips", action="store_true", help="leave the rest of the page as it is")
    parser.add_argument("--page", type=Path, default=PAGE)
    arguments = parser.parse_args()
    if arguments.only_flips:
        rest = arguments.page.read_text(encoding="utf-8").partition(bit_flips.TITLE)[0].rstrip() + "\n"
    else:
        rest = page(arguments.moments, all_results(arguments.moments))
    arguments.page.write_text(rest + bit_flips.chapter(arguments.flips), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
