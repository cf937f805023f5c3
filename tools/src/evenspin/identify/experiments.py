"""The experiments of identification on the simulated drive: what to command, and the log that comes of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from evenspin.errors import InputError, NativeError
from evenspin.identify.source import Run
from evenspin.log.columns import LOG_COLUMNS
from evenspin.model import InputCurve, Machine, Setup
from evenspin.model.machine import SIMULATED, find_model, load_machine
from evenspin.native import tables
from evenspin.sim import Record, simulate

TURN_RAD = 2.0 * np.pi
LOG_HZ = 1000.0
NOISE_NM = 0.010  # standard deviation of the torque that a row measures
# Noise of two measured phases becomes this much in the q axis, root mean square over the angle: sqrt((1 + 5 / 3) / 2).
PHASES_TO_Q = (4.0 / 3.0) ** 0.5

# Speeds of the friction experiment, as parts of the fastest; a turn at each, in both directions.
SLOWNESS = (240, 120, 80, 60, 40, 30, 24, 20, 17, 14, 12, 9, 7, 5, 3, 2, 1)
FRICTION_PARTS = tuple(1.0 / slower for slower in SLOWNESS)
SETTLE_S = 0.4  # before a stretch counts; see source.constant_stretches
SLOW_RPM = 3.0
SLOW_TURNS = 12.0
RAMPS = 24  # of the acceleration experiment, up and down


@dataclass(frozen=True, slots=True)
class Experiment:
    """One run of the drive."""

    name: str
    setup: Setup


def plan(model: str, kinds: Sequence[str], top_rad_s: float = 12.0, noise_nm: float = NOISE_NM) -> list[Experiment]:
    """`kinds` of friction, inertia, cogging; `top_rad_s`: fastest speed."""
    if not 0.0 < top_rad_s < 1e4:
        raise InputError("identify", "--top-speed", top_rad_s, "above 0 rad/s", "try 12")
    if not 0.0 <= noise_nm < 1e3:
        raise InputError("identify", "--noise", noise_nm, "at least 0 N m", "try 0.01")
    machine = load_machine(find_model(model, Path(), _refuse(model)), SIMULATED)
    base = _base(machine, noise_nm)
    made: list[Experiment] = []
    if "friction" in kinds:
        speeds = [part * top_rad_s for part in FRICTION_PARTS]
        made += [
            Experiment(f"friction_{word}_{half}", _stairs(base, [sign * v for v in speeds[start::2]]))
            for sign, word in ((1.0, "forward"), (-1.0, "backward"))
            for half, start in (("a", 0), ("b", 1))
        ]
    if "inertia" in kinds:
        made.append(Experiment("inertia", _ramps(base, top_rad_s)))
    if "cogging" in kinds:
        speed = SLOW_RPM * TURN_RAD / 60.0
        made.append(Experiment("cogging", _curve(base, [0.0], [speed], SLOW_TURNS * TURN_RAD / speed + 1.0)))
    return made


def perform(experiment: Experiment, numeric: str = "float", seed: int = 1) -> Record:
    """The log, with the columns of a log only."""
    setup = replace(experiment.setup, seed=seed)
    record = simulate(setup, (*LOG_COLUMNS, "fault"), numeric)
    if record["fault"].any():
        fault = tables().faults[int(record["fault"].max())]
        raise NativeError(f"{experiment.name}: the drive tripped: {fault.name}; {fault.check}")
    return record.pick(LOG_COLUMNS)


def by_kind(runs: Sequence[Run]) -> dict[str, list[Run]]:
    """Runs of experiments, named as `plan` names them."""
    sorted_runs: dict[str, list[Run]] = {}
    for run in runs:
        sorted_runs.setdefault(run.name.partition("_")[0], []).append(run)
    return sorted_runs


STARTED = {"auto_run": 1.0}  # whoever performs an experiment starts the drive


def torque_per_a(experiment: Experiment) -> float:
    return 1.5 * experiment.setup.plant["pole_pairs"] * experiment.setup.plant["psi_wb"]


def _base(machine: Machine, noise_nm: float) -> Setup:
    drive = {name: field.default for name, field in tables().params.items()} | dict(machine.drive) | STARTED
    noise_a = noise_nm / machine.torque_per_a_nm / PHASES_TO_Q
    return Setup(
        name=f"identify {machine.name}",
        plant={**machine.plant, "current_noise_a": noise_a},
        drive=drive,
        effects=machine.effects,
        inputs={},
        tunes=(),
        duration_s=1.0,
        log_rate_hz=LOG_HZ,
        seed=1,
    )


def _stairs(base: Setup, speeds: Sequence[float]) -> Setup:
    """One speed after the other, each for a little more than a turn."""
    times, t_s = [], 0.0
    for speed in speeds:
        times.append(t_s)
        # whole milliseconds: the reference changes with a row of the log
        t_s += float(np.ceil((1.08 * TURN_RAD / abs(speed) + SETTLE_S) * LOG_HZ)) / LOG_HZ
    return _curve(base, times, speeds, t_s)


def _ramps(base: Setup, top_rad_s: float) -> Setup:
    """Up and down between a quarter of the speed and the whole of it."""
    slow, ramp_s = 0.25 * top_rad_s, 0.09
    times = [0.0, 0.5] + [0.5 + ramp_s * (k + 1) for k in range(RAMPS)]
    values = [slow, slow] + [top_rad_s if k % 2 == 0 else slow for k in range(RAMPS)]
    return _curve(base, times, values, times[-1] + 0.2, linear=True)


def _curve(
    base: Setup, t_s: Sequence[float], speed: Sequence[float], duration_s: float, *, linear: bool = False
) -> Setup:
    inputs = {"speed_ref_rad_s": InputCurve(tuple(t_s), tuple(speed), linear)}
    return replace(base, inputs=inputs, duration_s=float(np.ceil(duration_s * 100.0)) / 100.0)


def _refuse(model: str) -> Callable[[str, str], InputError]:
    return lambda must, hint: InputError("identify", "MODEL", model, must, hint)
