"""Make logs of other drives: a drive, what a bench user does, a hidden effect, a file as another program writes it."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.blind.bench_drives import Drive, draw_bench_unit, draw_drive, nominal_of
from evenspin.blind.bench_effects import (
    EFFECTS,
    ELECTRICAL,
    OF_THE_ANGLE,
    OUTSIDE,
    SHAFT,
    SHAFT_ROWS_HZ,
    UNLOGGED_LOAD,
    Values,
    true_values,
)
from evenspin.blind.bench_profile import draw_inputs, follows
from evenspin.blind.foreign_effects import FOREIGN, placed
from evenspin.blind.log_visible import Bench, tolerances_of, visible
from evenspin.blind.referee import Inputs, Parameters, simulate, with_effects
from evenspin.blind.styles import STYLES, Style, columns_of, signals_of
from evenspin.blind.vocabulary import SIZES, go_together
from evenspin.errors import MISSING, EvenspinError, InputError, reason
from evenspin.log.case import write_json

MIX = {"single": 0.5, "pair": 0.15, "none": 0.15, "outside": 0.2}
VOLTAGE_SHARE = 0.65
RATES_HZ = (200.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0, 10000.0, 16000.0, 20000.0)
SECONDS = ((500.0, 60.0), (1000.0, 50.0), (2000.0, 40.0), (5000.0, 25.0), (1e9, 12.0))  # up to a rate
FINEST_RAD = 1.2  # electrical angle from row to row, where the electrical angle is what is logged
MODEL = "model.toml"


@dataclass(frozen=True, slots=True)
class LogPlan:
    log: str
    seed: tuple[int, int]
    kind: str
    size: int
    names: tuple[str, ...]
    voltages: bool
    style: str


@dataclass(frozen=True, slots=True)
class LogTruth:
    """What is hidden in a log, and what the log is."""

    file: str
    kind: str
    size: str
    effects: dict[str, Values]  # of the vocabulary, beside the model file
    outside: dict[str, Values]
    style: str
    rate_hz: float
    seconds: float
    rows: int
    voltage: str  # "" where there is none
    load: bool
    nm_per_a: float
    controller: Mapping[str, float] = field(default_factory=dict)
    unit: Mapping[str, float] = field(default_factory=dict)
    shown: Mapping[str, float] = field(default_factory=dict)  # standard deviations that each effect shows by
    alike: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  # and beside which other it hardly does


def plan_logs(count: int, seed: int) -> list[LogPlan]:
    """Effects, sizes and styles take turns; with and without voltages are mixed."""
    rng = np.random.default_rng([seed, 0, 77])
    counts = {kind: int(share * count) for kind, share in MIX.items()}
    counts["single"] += count - sum(counts.values())
    kinds = [kind for kind, n in counts.items() for _ in range(n)]
    singles = [str(name) for name in rng.permutation(list(EFFECTS))]
    foreign = [str(name) for name in rng.permutation(list(OUTSIDE))]
    styles = [style for _ in range(1 + count // len(STYLES)) for style in rng.permutation(len(STYLES))]
    turns = {"single": 0, "outside": 0}
    plans = []
    for number, kind in enumerate(rng.permutation(kinds), start=1):
        style = STYLES[styles[number - 1]]
        voltages = bool(style.voltages) and rng.uniform() < VOLTAGE_SHARE * len(STYLES) / (len(STYLES) - 2)
        names: tuple[str, ...] = ()
        if kind in turns:
            table = singles if kind == "single" else foreign
            while True:
                names = (table[turns[str(kind)] % len(table)],)
                turns[str(kind)] += 1
                if _shows(names, style, voltages):
                    break
        elif kind == "pair":
            while not (names and go_together(names) and _shows(names, style, voltages)):
                names = tuple(str(name) for name in rng.choice(list(EFFECTS), 2, replace=False))
        size = int(rng.integers(0 if len(names) == 1 else 1, len(SIZES)))
        plans.append(LogPlan(f"log_{seed}_{number:04d}", (seed, number), str(kind), size, names, voltages, style.name))
    return plans


FOREIGN_MIX = {"foreign": 53, "beside": 27, "none": 20, "single": 20}  # of 120
UNSEEN_PARTS = ("two_mass", "backlash")  # not searched for in logs with voltages


def plan_foreign_logs(count: int, seed: int, only_voltages: bool = True) -> list[LogPlan]:
    """Causes that no table lists, alone and beside a known effect, clean units, and known effects alone."""
    rng = np.random.default_rng([seed, 1, 77])
    kinds = [kind for kind, share in FOREIGN_MIX.items() for _ in range(round(share * count / 120.0))]
    kinds = (kinds + ["foreign"] * count)[:count]
    styles = [style for style in STYLES if style.voltages or not only_voltages]
    names = [name for name in EFFECTS if name not in UNSEEN_PARTS]
    turns = {"foreign": list(rng.permutation(list(FOREIGN))), "known": list(rng.permutation(names))}
    next_of = {"foreign": 0, "known": 0}

    def turn(table: str) -> str:
        next_of[table] += 1
        return str(turns[table][(next_of[table] - 1) % len(turns[table])])

    plans = []
    for number, kind in enumerate(rng.permutation(kinds), start=1):
        wanted: tuple[str, ...] = ()
        if kind in ("foreign", "beside"):
            wanted += (turn("foreign"),)
        if kind in ("beside", "single"):
            wanted += (turn("known"),)
            while (
                kind == "beside"
                and set(wanted) & {"position", "presliding", "cold_grease", "gravity"}
                and wanted[1]
                in (
                    "coulomb_friction",
                    "stribeck_friction",
                    "load_torque",
                    "misalignment",
                )
            ):
                wanted = (wanted[0], turn("known"))  # one thing with two names
        while True:
            style = styles[int(rng.integers(len(styles)))]
            voltages = bool(style.voltages) and (only_voltages or rng.uniform() < VOLTAGE_SHARE)
            if _shows(wanted, style, voltages):
                break
        plans.append(
            LogPlan(
                f"log_{seed}_{number:04d}",
                (seed, number),
                str(kind),
                int(rng.integers(len(SIZES))),
                wanted,
                voltages,
                style.name,
            )
        )
    return plans


def _shows(names: Sequence[str], style: Style, voltages: bool) -> bool:
    """Whether the log has what can show these effects. A single electrical one is hidden without voltages, too: it
    must not be called anything else."""
    for name in names:
        if name in OF_THE_ANGLE and style.angle == "none":
            return False
        if name in SHAFT and style.most_hz < SHAFT_ROWS_HZ:
            return False
        if name in FOREIGN:
            cause = FOREIGN[name]
            if (
                (cause.angle and style.angle == "none")
                or style.most_hz < cause.rows_hz
                or (cause.voltages and not voltages)
            ):
                return False
        if not voltages and name in OUTSIDE and OUTSIDE[name][1]:
            return False
        if not voltages and name in (*ELECTRICAL, "torque_constant") and len(names) > 1:
            return False
    return True


def make_log(plan: LogPlan, folder: Path) -> LogTruth:
    """Draw until the drive can do what is asked of it, write the log and the model file into `folder`."""
    rng = np.random.default_rng([*plan.seed, 78])
    style = next(style for style in STYLES if style.name == plan.style)
    for _ in range(60):
        drive = draw_drive(rng)
        rate_hz = _rate(rng, drive, style, plan.names)
        if rate_hz is None or (drive.controller["other.most_torque_per_ampere"] and style.currents == "abc"):
            continue  # an electrical zero from phase currents supposes that id is kept at 0
        seconds = next(s for most_hz, s in SECONDS if rate_hz <= most_hz)
        nominal = nominal_of(drive) | {"run.mean": float(style.means), "run.seed": float(rng.integers(1, 2**40))}
        unit = draw_bench_unit(rng, drive, nominal)
        values = {name: _draw(name)(rng, drive, plan.size) for name in plan.names}
        unlogged = values.get(UNLOGGED_LOAD, {}).get("torque_nm", 0.0)
        load = bool(style.load) and not unlogged and rng.uniform() < 0.6
        inputs = draw_inputs(
            rng, drive, seconds, unlogged or 0.5 * float(load) * drive.meta["motor"]["rated_torque_nm"]
        )
        if "position" in values:
            values["position"] = placed(values["position"], inputs, drive.meta["pwm_hz"])
        decimate = round(drive.meta["pwm_hz"] / rate_hz)
        if not _can(unit, inputs, drive):
            continue
        hidden = _hidden(unit, values)
        signals = simulate(hidden, inputs, decimate)
        if (
            np.all(np.isfinite(signals["iq_a"]))
            and np.abs(signals["true_speed_rad_s"]).max() < 2.0 * drive.full_speed_rad_s
        ):
            break
    else:
        raise EvenspinError(f"{plan.log}: no drive can do this with {', '.join(plan.names)}")

    folder.mkdir(parents=True)
    motor = drive.meta["motor"]
    table = signals_of(signals, motor["pole_pairs"], rate_hz, drive.meta["encoder"]["counts_per_rev"])
    file = folder / f"recording{style.suffix}"
    columns = columns_of(style, plan.voltages, load)
    style.write(file, columns, table)
    (folder / MODEL).write_text(model_text(plan.log, drive), encoding="utf-8")
    shown, alike = visible(
        Bench(unit, drive.meta["pwm_hz"], decimate, tuple(c.signal for c in columns), plan.voltages),
        unit,
        (hidden, inputs),
        {name: _without(name, unit, values, inputs) for name in values},
        tolerances_of(drive, nominal, unit),
        rate_hz,
    )
    return LogTruth(
        file=f"{plan.log}/{file.name}",
        kind=plan.kind,
        size=SIZES[plan.size] if plan.names else "",
        effects={name: true_values(name, v, hidden, nominal) for name, v in values.items() if name in EFFECTS},
        outside={name: v for name, v in values.items() if name in OUTSIDE or name in FOREIGN},
        style=style.name,
        rate_hz=rate_hz,
        seconds=seconds,
        rows=len(table["t_s"]),
        voltage=style.voltage if plan.voltages else "",
        load=load,
        nm_per_a=drive.nm_per_a,
        controller=drive.controller | {"pwm_hz": drive.meta["pwm_hz"]},
        unit={key: value for key, value in unit.items() if key not in nominal or nominal[key] != value},
        shown=shown,
        alike=alike,
    )


def _hidden(unit: Parameters, values: Mapping[str, Values]) -> Parameters:
    return with_effects(
        unit, {FOREIGN[n].referee if n in FOREIGN else n: v for n, v in values.items() if n != UNLOGGED_LOAD}
    )


def _without(name: str, unit: Parameters, values: Mapping[str, Values], inputs: Inputs) -> tuple[Parameters, Inputs]:
    """The twin that lacks one effect."""
    if name == UNLOGGED_LOAD:
        inputs = replace(inputs, load_torque_nm=np.zeros(len(inputs)))
    return _hidden(unit, {other: v for other, v in values.items() if other != name}), inputs


def _draw(name: str) -> Callable[[np.random.Generator, Drive, int], Values]:
    if name in FOREIGN:
        return FOREIGN[name].draw
    return EFFECTS[name] if name in EFFECTS else OUTSIDE[name][0]


def _rate(rng: np.random.Generator, drive: Drive, style: Style, names: Sequence[str]) -> float | None:
    pwm_hz = drive.meta["pwm_hz"]
    pairs = drive.meta["motor"]["pole_pairs"] if style.angle == "electrical" else 1
    least_hz = drive.full_speed_rad_s * pairs / FINEST_RAD
    if any(name in SHAFT for name in names):
        least_hz = max(least_hz, SHAFT_ROWS_HZ)
    least_hz = max([least_hz, *(FOREIGN[name].rows_hz for name in names if name in FOREIGN)])
    rates = [hz for hz in RATES_HZ if pwm_hz % hz == 0.0 and least_hz <= hz <= style.most_hz]
    return float(rng.choice(rates)) if rates else None


def _can(unit: Parameters, inputs: Inputs, drive: Drive) -> bool:
    """Tried with a coarser step: a machine that cannot do it is drawn again."""
    return follows(simulate(unit | {"run.step_s": 1.0 / drive.meta["pwm_hz"]}, inputs, 50), drive)


def model_text(name: str, drive: Drive) -> str:
    meta = drive.meta
    plant = meta["motor"] | {
        "dc_link_v": meta["dc_link_v"],
        "counts_per_rev": meta["encoder"]["counts_per_rev"],
        "current_noise_a": meta["current_noise_a"],
        "current_lsb_a": meta["current_lsb_a"],
    }
    return (
        "\n".join([f'name = "{name}"', "", "[plant]", *(f"{key} = {value!r}" for key, value in plant.items())]) + "\n"
    )


def make_logs(
    plans: Sequence[LogPlan], folder: Path, jobs: int, progress: Callable[[int], None] = lambda done: None
) -> dict[str, LogTruth]:
    """All logs below `folder`; the truths in the order of the plans."""
    truths: dict[str, LogTruth] = {}
    with ProcessPoolExecutor(max_workers=jobs) as pool:
        waiting = {pool.submit(make_log, plan, folder / plan.log): plan for plan in plans}
        for done, future in enumerate(as_completed(waiting), start=1):
            truths[waiting[future].log] = future.result()
            progress(done)
    return {plan.log: truths[plan.log] for plan in plans}


def write_log_truth(path: Path, truths: Mapping[str, LogTruth]) -> None:
    write_json(path, {log: asdict(truth) for log, truth in truths.items()})


def read_log_truth(path: Path) -> dict[str, LogTruth]:
    hint = "`evenspin gap blind make-logs` writes it"
    try:
        content: dict[str, dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
        return {log: LogTruth(**entry) for log, entry in content.items()}
    except FileNotFoundError:
        raise InputError(path, "file", MISSING, "an existing file", hint) from None
    except (OSError, ValueError) as error:
        raise InputError(path, "file", reason(error), "JSON", hint) from None
    except (AttributeError, TypeError) as error:
        raise InputError(path, "content", str(error), "{log: {file, kind, effects, ...}}", hint) from None
