"""What a run leaves behind: the log as a drive would write it, the truth, a summary, pictures."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from evenspin.log import LOG_COLUMNS, meta_of, write_case, write_csv
from evenspin.log.case import write_json
from evenspin.memory import AngleTable, Learned
from evenspin.memory.picture import memory_picture
from evenspin.model.methods import NONE, method_word, observer_of
from evenspin.model.scenario_schema import RPM
from evenspin.model.setup import Setup
from evenspin.native import tables
from evenspin.report.figures import Curve, pictures
from evenspin.report.page import Page, write_page
from evenspin.report.position import position_pictures
from evenspin.run.measures import controls_position, position_pieces, speed_pieces
from evenspin.run.outcome import outcome_of
from evenspin.run.tables import run_tables
from evenspin.sim import Record, truth_signals
from evenspin.sim.many import plain

DEFAULT = "default, not measured"
FLUX = ("flux_cos6", "flux_sin6", "flux_cos12", "flux_sin12")
RO_SAMPLES = 6144  # of the firmware: DRIVE_OBSERVER_CAPACITY in firmware/app/drive.h


def experiment_name(setup: Setup) -> str:
    """The scenario's name as a file name."""
    return re.sub(r"[^a-z0-9]+", "_", setup.name.lower()).strip("_") or "run"


def run_signals() -> tuple[str, ...]:
    """Everything that the drive shows and what only the simulation knows."""
    return tuple(tables().signals)


def _learned(learned: Learned | None) -> Any:
    """Of the observer alone its table, of other methods a list."""
    if learned is None or isinstance(learned, AngleTable):
        return None if learned is None else learned.summary()
    return [table.summary() for table in learned]


def summary_of(setup: Setup, record: Record, numeric: str, learned: Learned | None = None) -> dict[str, Any]:
    """The run in numbers, for a script. `learned`: what was learned over the angle."""
    pieces = [piece for piece in speed_pieces(setup, record) if piece]
    motions = position_pieces(setup, record) if controls_position(setup) else []
    return {
        "scenario": setup.name,
        "method": control_word(setup),
        "numeric": numeric,
        "seed": setup.seed,
        "duration_s": setup.duration_s,
        "log_rate_hz": setup.log_rate_hz,
        "outcome": outcome_of(setup, record).as_json(),
        "fault": _first_fault(record),
        "notice": _notice(setup),
        "base": setup.base,
        "motor_data": motor_data(setup),
        "rejected_count": int(record["rejected_count"][-1]),
        "observer_innovation": _innovation(setup, record, learned),
        "position_control": controls_position(setup),
        "memory": _learned(learned),
        "segments": [plain(piece) for piece in pieces],
        "motions": [plain(piece) for piece in motions],
        "drive": {name: _as_written(name, value) for name, value in setup.drive.items()},
        "plant": dict(setup.plant),
        "effects": {name: dict(params) for name, params in setup.effects.items()},
    }


def write_run(
    folder: Path,
    setup: Setup,
    record: Record,
    summary: Mapping[str, Any],
    command: str,
    learned: Learned | None = None,
) -> None:
    """Everything into an existing, empty folder. The tables are written while the pictures are drawn."""
    name = experiment_name(setup)
    with ThreadPoolExecutor(max_workers=1) as pool:
        tables_written = pool.submit(_write_tables, folder, setup, record, name)
        page = page_of(setup, record, summary, command, learned)
        tables_written.result()
    write_json(folder / "summary.json", summary)
    write_page(folder, page)


def _write_tables(folder: Path, setup: Setup, record: Record, name: str) -> None:
    write_case(folder, meta_of(setup, name, [name]), {name: record.pick(LOG_COLUMNS)})
    truth = ("t_s", *truth_signals())
    write_csv(folder / "truth.csv", truth, record.pick(truth).values)
    if record["isr_max_cycles"][-1] > 0.0:  # the board was given the duration of its interrupts
        from evenspin.cycles.compare import TIMING_FILE, timing_columns  # a tenth of what a run without them takes

        timing = ("t_s", *timing_columns(record.names))
        write_csv(folder / TIMING_FILE, timing, record.pick(timing).values)


def page_of(
    setup: Setup, record: Record, summary: Mapping[str, Any], command: str, learned: Learned | None = None
) -> Page:
    fault = summary["fault"]
    effects = [f"{name} ({', '.join(f'{k} = {v:g}' for k, v in p.items())})" for name, p in setup.effects.items()]
    facts = (
        ("method", summary["method"]),
        ("duration", f"{setup.duration_s:g} s, a row every {1000.0 / setup.log_rate_hz:g} ms"),
        ("effects", "; ".join(effects) or "none"),
        ("motor", f"what [plant] does not state is that of {setup.base}" if setup.base else "as [plant] states it"),
        ("the drive assumes", "; ".join(_shown(*each) for each in summary["motor_data"].items()) or "no motor data"),
        ("numeric", summary["numeric"]),
        ("seed", str(setup.seed)),
        ("result", summary["outcome"]["text"] or "it ran"),
        ("fault", f"{fault['name']} at {fault['t_s']:g} s: {fault['cause']}" if fault else "none"),
    )
    if summary["motions"]:
        drawn = position_pictures(setup, summary["method"], record)
    else:
        drawn = pictures(setup, [Curve(summary["method"], record)])
    if isinstance(learned, AngleTable) and not learned.empty:
        drawn.append(memory_picture(learned))
    return Page(
        title=setup.name,
        summary="The drive firmware on the simulated machine. The log beside this page is what a drive would log.",
        facts=facts,
        tables=run_tables(summary),
        pictures=drawn,
        command=command,
    )


def control_word(setup: Setup) -> str:
    """The methods of the run as one word; in position mode that of the position control comes first."""
    word = method_word(setup.drive)
    if not controls_position(setup):
        return word
    position = tables().params["position_method"].to_text(setup.drive["position_method"])
    return position if word == "pi" else f"{position}+{word}"


def motor_data(setup: Setup) -> dict[str, dict[str, Any]]:
    """Motor data that this drive calculates with, and where each number comes from."""
    params = tables().params
    used: list[str] = []
    if observer_of(setup.drive) != NONE:
        used += ["motor_psi_wb", "observer_inertia_kgm2", "observer_viscous_nms"]
    if params["current_controller"].to_text(setup.drive["current_controller"]) == "deadbeat":
        used += ["motor_resistance_ohm", "motor_ld_h", "motor_lq_h", "motor_psi_wb"]
    if any(setup.drive[name] != 0.0 for name in FLUX):
        used += ["motor_resistance_ohm", "motor_lq_h", "motor_psi_wb"]
    if controls_position(setup) and params["position_method"].to_text(setup.drive["position_method"]) == "rdc":
        used += ["motor_psi_wb", "rdc_inertia_kgm2", "rdc_viscous_nms", "rdc_coulomb_nm"]
    return {
        name: {"value": setup.drive[name], "unit": params[name].unit, "from": setup.drive_from.get(name, DEFAULT)}
        for name in dict.fromkeys(used)
    }


def assumed(summary: Mapping[str, Any]) -> str:
    """One line about motor data that nobody gave; empty when there are none."""
    names = [name for name, each in summary["motor_data"].items() if each["from"] == DEFAULT]
    return f"{', '.join(names)}: {DEFAULT}; give {'it' if len(names) == 1 else 'them'} in [drive]" if names else ""


def _shown(name: str, each: Mapping[str, Any]) -> str:
    return f"{name} = {each['value']:.6g} {each['unit']} ({each['from']})"


def _notice(setup: Setup) -> str:
    """A method that rests for the whole run because a turn is longer than its memory."""
    if observer_of(setup.drive) != "ro":
        return ""
    curve = setup.inputs.get("speed_ref_rad_s")
    fastest = max((abs(value) for value in curve.value), default=0.0) if curve is not None else 0.0
    if controls_position(setup):
        fastest = max(fastest, setup.drive["profile_speed_rad_s"])
    slowest = 2.0 * math.pi * setup.pwm_hz / RO_SAMPLES
    if not 0.0 < fastest < slowest:
        return ""
    return (
        f"ro is off: a turn at {fastest / RPM:.4g} r/min is longer than its memory of {RO_SAMPLES} samples; "
        f"it needs {slowest / RPM:.4g} r/min, aro has no such limit"
    )


def _observer_learned(learned: Learned | None) -> bool:
    if learned is None or isinstance(learned, AngleTable):
        return learned is not None and not learned.empty
    return any(table.method == "aro" and bool(table.values.any()) for table in learned)


def _innovation(setup: Setup, record: Record, learned: Learned | None) -> float | None:
    """How far learning has come, 1 nothing, near 0 all; None where nothing is being learned."""
    if not _observer_learned(learned) or setup.drive["observer_hold"]:
        return None
    return float(record["observer_innovation"][-1])


def _first_fault(record: Record) -> dict[str, Any] | None:
    tripped = record["fault"] > 0.0
    if not tripped.any():
        return None
    row = int(tripped.argmax())
    fault = tables().faults[int(record["fault"][row])]
    return {"name": fault.name, "t_s": float(record["t_s"][row]), "cause": fault.cause, "check": fault.check}


def _as_written(name: str, value: float) -> float | int | bool | str:
    field = tables().params[name]
    if field.kind == "choice":
        return field.to_text(value)
    if field.kind == "flag":
        return bool(value)
    return int(value) if field.kind == "integer" else value
