"""Make blind cases: a motor, a unit of it inside the tolerances, hidden effects, the eight records of the format."""

from __future__ import annotations

import gzip
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.blind import motulator_drive
from evenspin.blind.experiments import Experiment, all_experiments
from evenspin.blind.motors import draw_motor
from evenspin.blind.referee import PWM_HZ, Inputs, Parameters, parameters_of, simulate, with_effects
from evenspin.blind.truth import Truth
from evenspin.blind.vocabulary import EFFECTS, KINDS, OUTSIDE, SIZES, go_together
from evenspin.errors import EvenspinError
from evenspin.log.case import META, write_json
from evenspin.log.columns import LOG_COLUMNS

SEVERAL = {"pair": 2, "triple": 3}
MIX = {"single": 0.6, "pair": 0.2, "none": 0.1, "outside": 0.1}
LOST_SHARE = 0.5  # of a record at the current limit: the speed is not controlled any more
EDGES_SHARE = 0.25  # of the cases: every switching edge instead of the average voltage
# The gap and the tolerances, written apart from evenspin.log on purpose: docs/log-format.md is what both follow.
GAP_UNITS = {"speed_rad_s": 1.0, "id_a": 0.1, "iq_a": 0.1, "vd_v": 1.0, "vq_v": 1.0}
VALIDATION = ("validation", "validation_steps")
# What units of one type differ by; drawn evenly within the bounds.
TOLERANCE = {
    "motor.resistance_ohm": 0.012,
    "motor.inductance": 0.015,
    "motor.psi_wb": 0.004,
    "motor.inertia_kgm2": 0.012,
    "motor.viscous_nms": 0.04,
}
OFFSET_TOLERANCE_A = 0.010
GAIN_TOLERANCE = 0.002
DECIMALS = (5, 5, 5, 6, 4, 4, 5, 5, 5, 5, 4, 4, 3, 4)  # of LOG_COLUMNS

REFEREE, MOTULATOR = "referee", "motulator"
SIMULATORS = (REFEREE, MOTULATOR)

Record = dict[str, NDArray[np.float64]]
Simulate = Callable[[Mapping[str, float], Inputs, int], Record]


@dataclass(frozen=True, slots=True)
class Plan:
    """What one case is to hide; the values are drawn with the motor."""

    case: str
    seed: tuple[int, int]
    kind: str
    size: int
    names: tuple[str, ...]
    simulator: str = REFEREE  # that makes the records


def plan_cases(counts: Mapping[str, int], seed: int, names: Sequence[str] = (), simulator: str = REFEREE) -> list[Plan]:
    """So many cases of each kind. Effects and sizes take turns, so that all of them come up equally often."""
    rng = np.random.default_rng([seed, 0])
    within = [name for name in EFFECTS if not names or name in names]
    outside = [name for name in OUTSIDE if not names or name in names]
    drafts: list[tuple[str, int, tuple[str, ...]]] = []
    turn = {"single": _turns(rng, within), "outside": _turns(rng, outside)}
    for kind in KINDS:
        for k in range(counts.get(kind, 0)):
            if kind in SEVERAL:
                drafts.append((kind, int(rng.integers(1, len(SIZES))), _draw_set(rng, within, SEVERAL[kind])))
            elif kind == "none":
                drafts.append((kind, 0, ()))
            elif kind == "beside":
                (known, size), (foreign, _) = turn["single"](k), turn["outside"](k)
                drafts.append((kind, max(size, 1), (known, foreign)))
            else:
                name, size = turn[kind](k)
                drafts.append((kind, size, (name,)))
    order = rng.permutation(len(drafts))  # the number of a case says nothing
    return [
        Plan(f"case_{n + 1:04d}", (seed, n + 1), kind, size, chosen, simulator)
        for n, (kind, size, chosen) in enumerate(drafts[k] for k in order)
    ]


def _turns(rng: np.random.Generator, names: list[str]) -> Callable[[int], tuple[str, int]]:
    shuffled = list(rng.permutation(names)) if names else []
    offset = rng.integers(0, len(SIZES), len(names))

    def at(k: int) -> tuple[str, int]:
        n = k % len(shuffled)
        return str(shuffled[n]), int((offset[n] + k // len(shuffled)) % len(SIZES))

    return at


def _draw_set(rng: np.random.Generator, names: list[str], count: int) -> tuple[str, ...]:
    while True:
        drawn = tuple(str(name) for name in rng.choice(names, count, replace=False))
        if go_together(drawn):
            return drawn


def draw_unit(rng: np.random.Generator, nominal: Parameters) -> tuple[Parameters, dict[str, float]]:
    """A unit inside of the tolerances, and what it differs by (factors, and A)."""
    factor = {key: 1.0 + rng.uniform(-bound, bound) for key, bound in TOLERANCE.items()}
    offsets = {f"sensor.offset_{x}_a": rng.uniform(-OFFSET_TOLERANCE_A, OFFSET_TOLERANCE_A) for x in "ab"}
    gains = {f"sensor.gain_{x}": 1.0 + rng.uniform(-GAIN_TOLERANCE, GAIN_TOLERANCE) for x in "ab"}
    unit = dict(nominal) | offsets | gains
    for key, value in factor.items():
        for name in ("motor.ld_h", "motor.lq_h") if key == "motor.inductance" else (key,):
            unit[name] *= value
    return unit, {key: float(value) for key, value in (factor | offsets | gains).items()}


def run_experiments(
    parameters: Parameters,
    experiments: Sequence[Experiment],
    angles_rad: Sequence[float],
    seed: int,
    only: Sequence[str] = (),
    by: Simulate = simulate,
) -> dict[str, Record]:
    """Back to back: what changes with time goes on from record to record, also past those that are left out."""
    records, clock_s = {}, 0.0
    for number, (experiment, angle_rad) in enumerate(zip(experiments, angles_rad, strict=True)):
        if only and experiment.name not in only:
            clock_s += experiment.duration_s
            continue
        own = {
            "motor.locked": float(experiment.locked),
            "motor.start_angle_rad": angle_rad,
            "run.clock_s": clock_s,
            "run.seed": float(seed * 100 + number),
        }
        records[experiment.name] = by(parameters | own, experiment.inputs, experiment.decimate)
        clock_s += experiment.duration_s
    return records


def without_noise(parameters: Parameters) -> Parameters:
    return parameters | {"sensor.current_noise_a": 0.0, "sensor.load_noise_nm": 0.0, "sensor.vdc_noise_v": 0.0}


def gap_between(one: Mapping[str, Record], other: Mapping[str, Record]) -> float:
    """As docs/log-format.md defines it."""
    squares = [
        np.mean((one[name][signal] - other[name][signal]) ** 2) / unit**2
        for name in VALIDATION
        for signal, unit in GAP_UNITS.items()
    ]
    return float(np.sqrt(np.mean(squares)))


def why_unfit(meta: Mapping[str, Any], records: Mapping[str, Record], experiments: Sequence[Experiment]) -> str:
    """A drive without effects must be able to do every experiment: what it cannot do, or nothing."""
    limit_v = meta["dc_link_v"] / math.sqrt(3.0)
    for experiment in experiments:
        record = records[experiment.name]
        size_v = np.hypot(record["vd_v"], record["vq_v"])
        if np.mean(size_v > 0.97 * limit_v) > 0.02:
            return f"{experiment.name}: at the voltage limit"
        if experiment.locked or experiment.name == "coast_down":
            continue
        if np.mean(np.abs(record["iq_ref_a"]) >= meta["speed_loop"]["iq_limit_a"]) > 0.15:
            return f"{experiment.name}: at the current limit"
        error = np.abs(record["true_speed_rad_s"] - record["speed_ref_rad_s"])
        if np.median(error) > 1.5:
            return f"{experiment.name}: does not follow"
    return ""


def make_case(plan: Plan, folder: Path) -> Truth:
    """Draw until the drive is fit, write the case into `folder` and return what is hidden in it."""
    rng = np.random.default_rng(plan.seed)
    for _ in range(50):
        meta = draw_motor(rng)
        motor = meta["motor"]
        experiments = all_experiments(rng, motor["rated_current_a"], motor["rated_torque_nm"])
        angles_rad = list(rng.uniform(0.0, 2.0 * math.pi, len(experiments)))
        nominal = parameters_of(meta) | {
            "sensor.vdc_noise_v": meta["dc_link_v"] / 1500.0,
            "sensor.load_noise_nm": 0.009 * motor["rated_torque_nm"],
        }
        unit, differs = draw_unit(rng, nominal)
        edges = rng.uniform() < EDGES_SHARE and plan.simulator == REFEREE
        unit["bridge.edges"] = float(edges)
        effects = {name: {**EFFECTS, **OUTSIDE}[name](rng, meta, plan.size) for name in plan.names}
        seed = int(rng.integers(1, 2**40))
        if not why_unfit(meta, run_experiments(unit, experiments, angles_rad, seed), experiments):
            hidden = with_effects(unit, effects)
            left_open = _left_open(rng, effects, motor["rated_current_a"])
            by = simulate
            if plan.simulator == MOTULATOR:
                left_open |= motulator_drive.LEFT_OPEN
                by = motulator_drive.simulate
            hidden |= left_open
            records = run_experiments(hidden, experiments, angles_rad, seed, by=by)
            if is_under_control(records, experiments, meta["speed_loop"]["iq_limit_a"]):
                break
    else:
        raise EvenspinError(f"{plan.case}: no motor can do this with {', '.join(plan.names)}")

    write_records(folder, meta | {"case": plan.case}, experiments, records)

    def quiet(parameters: Parameters) -> dict[str, Record]:
        return run_experiments(without_noise(parameters), experiments, angles_rad, seed, VALIDATION)

    clean = quiet(nominal)
    alone = {name: gap_between(quiet(with_effects(nominal, {name: effects[name]})), clean) for name in effects}
    entries = [{"name": name, "parameters": effects[name]} for name in sorted(effects, key=lambda name: -alone[name])]
    return Truth(
        effects=[entry for entry in entries if entry["name"] in EFFECTS],
        outside=[entry for entry in entries if entry["name"] in OUTSIDE],
        kind=plan.kind,
        size=SIZES[plan.size] if plan.names else "",
        inverter="edges" if edges else "average",
        simulator=plan.simulator,
        seed=plan.seed[0],
        unit=differs,
        left_open=left_open,
        gap_alone=alone,
        gap_nominal=gap_between(records, clean),
        gap_named=gap_between(records, quiet(with_effects(nominal, effects))),
        gap_floor=gap_between(records, quiet(hidden)),
    )


def _left_open(rng: np.random.Generator, names: Collection[str], rated_a: float) -> Parameters:
    """What the vocabulary does not say about an effect: any simulator may have it in one way or another."""
    result: Parameters = {}
    if "flux_harmonics" in names:
        result["flux_harmonics.fifth_share"] = float(rng.uniform(0.3, 0.7))
    if "inductance_saturation" in names:
        result["inductance_saturation.per_axis"] = float(rng.uniform() < 0.5)
    if "coulomb_friction" in names:
        result |= _friction_at_standstill(rng)
    if "dead_time" in names:
        result["dead_time.soft_a"] = float(rng.choice((0.0, 0.01))) * rated_a
    if "two_mass" in names or "backlash" in names:
        result["motor.load_friction_share"] = float(rng.choice((0.0, 0.5)))
    return result


def _friction_at_standstill(rng: np.random.Generator) -> Parameters:
    """It holds the shaft, rises over some speeds, or gives way over some travel before it slides."""
    form = rng.integers(0, 3)
    if form == 1:
        return {"coulomb_friction.smooth_rad_s": float(np.exp(rng.uniform(np.log(0.05), np.log(1.0))))}
    if form == 2:
        return {"coulomb_friction.spring_rad": float(np.exp(rng.uniform(np.log(5e-4), np.log(0.01))))}
    return {}


def is_under_control(records: Mapping[str, Record], experiments: Sequence[Experiment], iq_limit_a: float) -> bool:
    """An effect may spoil the drive, but not tear it apart: a log of that says nothing about its cause."""
    for experiment in experiments:
        record = records[experiment.name]
        size = np.abs(record["true_speed_rad_s"]).max()
        if not np.isfinite(size) or size > 150.0:
            return False
        if not experiment.locked and np.mean(np.abs(record["iq_ref_a"]) >= 0.99 * iq_limit_a) > LOST_SHARE:
            return False
    return True


def write_records(
    folder: Path, meta: dict[str, Any], experiments: Sequence[Experiment], records: Mapping[str, Record]
) -> None:
    folder.mkdir(parents=True)
    write_json(folder / META, {"case": meta.pop("case")} | meta | {"experiments": [e.name for e in experiments]})
    row = ",".join(f"%.{n}f" for n in DECIMALS) + "\n"
    for experiment in experiments:
        record = dict(records[experiment.name])
        count = len(record["speed_rad_s"])
        record["t_s"] = np.arange(count) * experiment.decimate / PWM_HZ
        if not experiment.load_measured:
            record["load_torque_nm"] = np.full(count, np.nan)
        table = np.column_stack([record[name] for name in LOG_COLUMNS])
        text = ",".join(LOG_COLUMNS) + "\n" + (row * count) % tuple(table.ravel().tolist())
        with (folder / f"{experiment.name}.csv.gz").open("wb") as file:
            file.write(gzip.compress(text.encode("ascii"), compresslevel=5, mtime=0))


def make_set(
    plans: Sequence[Plan], folder: Path, jobs: int, progress: Callable[[int], None] = lambda done: None
) -> dict[str, Truth]:
    """All cases below `folder`, by several processes; the truths in the order of the plans."""
    truths: dict[str, Truth] = {}
    with ProcessPoolExecutor(max_workers=jobs) as pool:
        waiting = {pool.submit(make_case, plan, folder / plan.case): plan for plan in plans}
        for done, future in enumerate(as_completed(waiting), start=1):
            truths[waiting[future].case] = future.result()
            progress(done)
    return {plan.case: truths[plan.case] for plan in plans}
