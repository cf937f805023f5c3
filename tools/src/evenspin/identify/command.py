"""`evenspin identify`: from logs, or from experiments on the simulated drive, to what was found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from evenspin.errors import InputError
from evenspin.identify.experiments import NOISE_NM, Experiment, by_kind, perform, plan, torque_per_a
from evenspin.identify.pictures import pictures
from evenspin.identify.result import Identified, drive_text, identify, model_text, tables_of
from evenspin.identify.source import check_torque, read_runs, run_of
from evenspin.log import meta_of, write_case
from evenspin.log.case import META, read_meta, write_json
from evenspin.log.meta import MOTOR_KEYS
from evenspin.log.meta_numbers import MetaNumbers
from evenspin.model.machine import SIMULATED, Machine, find_model, load_machine
from evenspin.native import load, tables
from evenspin.report.page import Page, write_page
from evenspin.sim import Record
from evenspin.sim.many import Progress, run_all


@dataclass(frozen=True, slots=True)
class Choices:
    """What the user gave."""

    kinds: Sequence[str]
    snap: bool = False
    stribeck: bool = True
    torque: str = "measured"
    torque_per_a_nm: float | None = None
    top_rad_s: float = 12.0
    noise_nm: float = NOISE_NM
    seed: int = 1
    numeric: str = "float"


@dataclass(frozen=True, slots=True)
class Work:
    """What was found, in what; `records` are the logs of experiments that were performed here."""

    found: Identified
    choices: Choices
    name: str
    plant: Mapping[str, float]
    base: Machine | None
    experiments: Sequence[Experiment] = ()
    records: Sequence[Record] = ()


def from_logs(paths: Sequence[Path], choices: Choices) -> Work:
    """One kind of experiment per call: every log belongs to it."""
    if not paths:
        raise InputError("identify", "LOG", "(missing)", "a case folder or a CSV file", "or give --run sim MODEL")
    runs = read_runs(paths, choices.torque, choices.torque_per_a_nm)
    found = identify(dict.fromkeys(choices.kinds, runs), snap=choices.snap, stribeck=choices.stribeck)
    folder = paths[0] if paths[0].is_dir() else paths[0].parent
    meta = read_meta(folder / META) if (folder / META).is_file() else {}
    plant = MetaNumbers(folder / META, meta).plant(MOTOR_KEYS)
    return Work(found, choices, str(meta.get("case", paths[0].stem)), plant, None)


def from_simulation(model: str, choices: Choices, progress: Progress | None = None) -> Work:
    """Perform the experiments first."""
    check_torque(choices.torque)
    load(choices.numeric)
    experiments = plan(model, choices.kinds, choices.top_rad_s, choices.noise_nm)
    records = run_all([_later(experiment, choices) for experiment in experiments], progress)
    runs = [
        run_of(record, experiment.name, torque_per_a(experiment), choices.torque)
        for experiment, record in zip(experiments, records, strict=True)
    ]
    found = identify(by_kind(runs), snap=choices.snap, stribeck=choices.stribeck)
    path = find_model(model, Path(), lambda must, hint: InputError("identify", "MODEL", model, must, hint))
    machine = load_machine(path, SIMULATED)
    return Work(found, choices, machine.name, machine.plant, machine, experiments, records)


def write(folder: Path, work: Work, command: str) -> None:
    """Model, drive parameters, numbers, report, and the logs of experiments performed here."""
    name = f"{work.name}-identified"
    plant = {key: value for key, value in work.plant.items() if key in tables().model}
    (folder / "model.toml").write_text(model_text(work.found, name, plant, work.base), encoding="utf-8")
    (folder / "drive.toml").write_text(drive_text(work.found), encoding="utf-8")
    write_json(folder / "identified.json", work.found.as_json())
    write_page(folder, page_of(work, command))
    if work.experiments:
        names = [experiment.name for experiment in work.experiments]
        log = folder / "log"
        log.mkdir()
        meta = meta_of(work.experiments[0].setup, work.name, names)
        write_case(log, meta, dict(zip(names, work.records, strict=True)))


def page_of(work: Work, command: str) -> Page:
    simulated = bool(work.experiments)
    noise = (
        f"{1e3 * work.choices.noise_nm:g} mN m per row, as noise of the phase currents" if simulated else "of the log"
    )
    facts = (
        ("machine", work.name),
        ("experiments", ", ".join(e.name for e in work.experiments) if simulated else "logs that were given"),
        ("torque", f"torque constant times the {work.choices.torque} q current"),
        ("noise", noise),
    )
    return Page(
        title=f"Identification: {', '.join(work.choices.kinds)}",
        summary="Inertia, friction and the torque tied to the angle, with 95 % confidence intervals.",
        facts=facts,
        tables=tables_of(work.found),
        pictures=pictures(work.found),
        command=command,
    )


def _later(experiment: Experiment, choices: Choices) -> Callable[[], Record]:
    return lambda: perform(experiment, choices.numeric, choices.seed)
