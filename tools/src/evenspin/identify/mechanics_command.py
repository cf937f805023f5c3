"""`evenspin identify mechanics`: from logs, or from a pseudo-random torque on the simulated drive, to J and B."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.errors import InputError
from evenspin.identify.mechanics import WHERE, Mechanics, identify_mechanics
from evenspin.identify.prbs import Plan, perform, plan, setup_of
from evenspin.identify.source import Run, read_runs, run_of
from evenspin.log import meta_of, write_case
from evenspin.log.case import META, read_meta, write_json
from evenspin.log.meta import MOTOR_KEYS
from evenspin.log.meta_numbers import MetaNumbers
from evenspin.model.machine import SIMULATED, Machine, find_model, load_machine
from evenspin.native import tables
from evenspin.report.figures import Picture
from evenspin.report.page import Page, write_page
from evenspin.report.style import OTHER_COLOURS, REFERENCE_COLOUR, drawing, subplots, to_svg
from evenspin.sim import Record
from evenspin.tableview import TableView, number

EXPERIMENT = "prbs"
PLANT_KEYS = {"inertia_kgm2": "observer_inertia_kgm2", "viscous_nms": "observer_viscous_nms"}


@dataclass(frozen=True, slots=True)
class Work:
    """What was found, in what. `base` and `record`: of an experiment performed here; `plant`: of a log."""

    found: Mechanics
    runs: Sequence[Run]
    name: str
    plant: Mapping[str, float]
    base: Machine | None = None
    wanted: Plan | None = None
    record: Record | None = None
    seed: int = 1

    def as_json(self) -> dict[str, Any]:
        found = self.found
        named = {"inertia_kgm2": found.inertia_kgm2, "viscous_nms": found.viscous_nms, "constant_nm": found.constant_nm}
        content: dict[str, Any] = {name: estimate.value for name, estimate in named.items()}
        content["interval_95"] = {name: [e.value - e.half, e.value + e.half] for name, e in named.items()}
        content |= {"windows": len(found.t_s), "window_s": found.window_s}
        content["residual_rms_nm"] = float(found.residual_nm.std())
        if self.wanted is not None:
            content["experiment"] = self.wanted.as_json()
        return content


def machine_of(model: str) -> tuple[Machine, dict[str, float]]:
    """A model, and all parameters of its drive."""
    path = find_model(model, Path(), lambda must, hint: InputError(WHERE, "MODEL", model, must, hint))
    machine = load_machine(path, SIMULATED)
    return machine, {name: field.default for name, field in tables().params.items()} | dict(machine.drive)


def from_simulation(model: str, settings: Mapping[str, Any], window_s: float, seed: int, numeric: str) -> Work:
    """Perform the experiment first."""
    machine, drive = machine_of(model)
    wanted = plan(machine, drive, **settings)
    record = perform(machine, drive, wanted, seed, numeric)
    runs = [run_of(record, EXPERIMENT, machine.torque_per_a_nm)]
    found = identify_mechanics(runs, window_s)
    return Work(found, runs, machine.name, machine.plant, machine, wanted, record, seed)


def from_logs(paths: Sequence[Path], torque_per_a_nm: float | None, window_s: float) -> Work:
    if not paths:
        raise InputError(WHERE, "LOG", "(missing)", "a case folder or a CSV file", "or give --run sim MODEL")
    runs = read_runs(paths, torque_per_a_nm=torque_per_a_nm)
    folder = paths[0] if paths[0].is_dir() else paths[0].parent
    meta = read_meta(folder / META) if (folder / META).is_file() else {}
    plant = MetaNumbers(folder / META, meta).plant(MOTOR_KEYS)
    return Work(identify_mechanics(runs, window_s), runs, str(meta.get("case", paths[0].stem)), plant)


def tables_of(work: Work) -> list[TableView]:
    found = work.found
    named = (
        ("inertia J", "kg m^2", found.inertia_kgm2, "inertia_kgm2"),
        ("viscous friction B", "N m s/rad", found.viscous_nms, "viscous_nms"),
        ("constant torque", "N m", found.constant_nm, ""),
    )
    rows = [
        (name, unit, f"{e.value:.5g}", f"{e.half:.2g}", _model(work, key), _deviation(work, key, e.value))
        for name, unit, e, key in named
    ]
    text = (
        f"+-: half of the 95 % confidence interval, from {len(found.t_s)} windows of {found.window_s:g} s; "
        f"the torque that they leave unexplained is {number(1e3 * float(found.residual_nm.std()))} mN m rms. "
        "Constant torque: Coulomb friction and load."
    )
    return [TableView("Mechanics", text, ("", "unit", "value", "+-", "model", "off"), rows)]


def write(folder: Path, work: Work, command: str) -> None:
    """Model, numbers, report, and the log of an experiment performed here."""
    (folder / "model.toml").write_text(model_text(work), encoding="utf-8")
    write_json(folder / "identified.json", work.as_json())
    write_page(folder, page_of(work, command))
    if work.base is not None and work.record is not None and work.wanted is not None:
        log = folder / "log"
        log.mkdir()
        setup = setup_of(work.base, machine_drive(work.base), work.wanted, work.seed)
        write_case(log, meta_of(setup, work.name, [EXPERIMENT]), {EXPERIMENT: work.record})


def machine_drive(machine: Machine) -> dict[str, float]:
    return {name: field.default for name, field in tables().params.items()} | dict(machine.drive)


def model_text(work: Work) -> str:
    """The model file with J and B replaced, its comments kept; of a log, a new one with what meta.json states."""
    import tomlkit

    values = {"inertia_kgm2": work.found.inertia_kgm2.value, "viscous_nms": work.found.viscous_nms.value}
    values = {key: float(f"{value:.6g}") for key, value in values.items()}
    if work.base is not None:
        document = tomlkit.parse(work.base.document.path.read_text(encoding="utf-8"))
    else:
        document = tomlkit.document()
        document["plant"] = tomlkit.table()
        for key, value in work.plant.items():
            if key in tables().model:
                whole = tables().model[key].kind == "integer"
                document["plant"][key] = int(value) if whole else value
    document["name"] = f"{work.name}-identified"
    for name in ("plant", "drive"):
        if name not in document:
            document[name] = tomlkit.table()
    for key, param in PLANT_KEYS.items():
        document["plant"][key] = values[key]
        document["drive"][param] = values[key]
    effects = document.get("effects", {})
    for effect in ("inertia", "viscous_friction"):
        effects.pop(effect, None)  # factors on what has been replaced
    return tomlkit.dumps(document)


def page_of(work: Work, command: str) -> Page:
    facts = [("machine", work.name)]
    if work.wanted is not None:
        wanted = work.wanted.as_json()
        facts.append(("experiment", ", ".join(f"{key} {value:.4g}" for key, value in wanted.items())))
    else:
        facts.append(("logs", ", ".join(run.name for run in work.runs)))
    return Page(
        title="Identification: mechanics",
        summary="Inertia and viscous friction from a pseudo-random torque, with 95 % confidence intervals.",
        facts=facts,
        tables=tables_of(work),
        pictures=[picture_of(work)],
        command=command,
    )


def picture_of(work: Work) -> Picture:
    with drawing():
        figure, data = draw(work)
        svg = to_svg(figure)
    text = "Means over the windows: speed, torque of the current, and what inertia and friction do not explain."
    return Picture("mechanics", "Pseudo-random torque", text, svg, data)


def draw(work: Work) -> tuple[Any, dict[str, Any]]:
    """Call it within `drawing`."""
    found = work.found
    figure, axes = subplots(3, 1, height=6.0, sharex=len(work.runs) == 1)
    explained = found.torque_nm - found.residual_nm
    x = found.t_s if len(work.runs) == 1 else np.arange(len(found.t_s), dtype=float)
    axes[0, 0].plot(x, found.speed_rad_s * 30.0 / np.pi, color=OTHER_COLOURS[0])
    axes[0, 0].set(ylabel="speed [rpm]")
    axes[1, 0].plot(
        x, found.torque_nm, color=REFERENCE_COLOUR, alpha=0.35, linewidth=2.5, label="torque constant x q current"
    )
    axes[1, 0].plot(x, explained, color=OTHER_COLOURS[2], label="J dw/dt + B w + constant")
    axes[1, 0].set(ylabel="torque [N m]")
    axes[1, 0].legend(ncols=2)
    axes[2, 0].plot(x, 1e3 * found.residual_nm, color=OTHER_COLOURS[3])
    axes[2, 0].set(ylabel="not explained [mN m]", xlabel="time [s]" if len(work.runs) == 1 else "window [-]")
    data = {
        "t_s": found.t_s,
        "speed_rad_s": found.speed_rad_s,
        "torque_nm": found.torque_nm,
        "residual_nm": found.residual_nm,
    }
    return figure, data


def _model(work: Work, key: str) -> str:
    return f"{work.plant[key]:.5g}" if key in work.plant else "-"


def _deviation(work: Work, key: str, value: float) -> str:
    known = work.plant.get(key, 0.0)
    return f"{100.0 * (value / known - 1.0):+.2f} %" if known else "-"
