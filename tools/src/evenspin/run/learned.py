"""What a drive has learned over the angle: given to a run, taken from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from evenspin.errors import InputError
from evenspin.memory import (
    AngleTable,
    Learned,
    LearnedTable,
    check_table_file,
    is_learned_file,
    read_learned,
    read_table,
    write_learned,
    write_table,
)
from evenspin.memory.table import Array
from evenspin.model.methods import method_word, observer_of
from evenspin.model.setup import Setup
from evenspin.native import tables
from evenspin.native.simulation import Simulation

ARO = "aro"
LINES = 6  # of rdc
REPETITIVE = ("crc", "forc", "fal-forc")


@dataclass(frozen=True, slots=True)
class Part:
    """One table of a drive. `cells`, `limit`: its parameters for these; `same`: what gives its values their meaning."""

    method: str
    turn: str
    unit: str
    cells: str
    limit: str
    same: tuple[str, ...] = ()


def parts_of(drive: Mapping[str, float]) -> list[Part]:
    """The tables that this drive has, in its order."""
    params = tables().params
    found = []
    if observer_of(drive) == ARO:
        found.append(Part(ARO, "mechanical", "A", "aro_cells", "observer_limit_a"))
    method = params["method"].to_text(drive["method"])
    if method in REPETITIVE and params["rc_memory"].to_text(drive["rc_memory"]) == "angle":
        same = ("pole_pairs", "speed_error_gain", "rc_order", "rc_lead")
        found.append(Part(method, "electrical", "unit of the speed error", "rc_cells", "rc_limit_unit", same))
    position = params["position_method"].to_text(drive["position_method"])
    if position in ("silc", "src"):
        found.append(Part(position, "mechanical", "rad/s", "position_cells", "over_speed_rad_s"))
    if position == "rdc" and drive["rdc_learn_gain"] > 0.0:
        found.append(Part("rdc", "mechanical", "A", "position_cells", "iq_limit_a"))
    return found


def table_for(setup: Setup, path: Path) -> Array:
    """The content of this file, if the drive can take it."""
    parts = _need_parts(setup, "--memory")
    if _is_angle_observer(parts) and not is_learned_file(path):
        return _observer_table(setup, path)
    given = read_learned(path)
    wanted, found = ([each.method for each in those] for those in (parts, given))
    if wanted != found:
        must = f"{'+'.join(wanted)}, which this drive learns with"
        raise InputError(
            path, "method", "+".join(found), must, f"add --method {found[0]}, or save the table of this drive"
        )
    for part, table in zip(parts, given, strict=True):
        _check_part(setup, path, part, table)
    return np.concatenate([table.values for table in given])


def _check_part(setup: Setup, path: Path, part: Part, table: LearnedTable) -> None:
    cells, limit = int(setup.drive[part.cells]), setup.drive[part.limit]
    if len(table.values) != cells:
        hint = f"set {part.cells} = {len(table.values)} in [drive]"
        raise InputError(path, f"{part.method}: cells", len(table.values), f"{cells}, the drive's {part.cells}", hint)
    if (table.turn, table.unit) != (part.turn, part.unit):
        must = f"{part.unit}, over the {part.turn} turn"
        raise InputError(path, f"{part.method}: unit", f"{table.unit}, {table.turn}", must, "save it again")
    for name in part.same:
        if table.learned_with.get(name) != setup.drive[name]:
            given = table.learned_with.get(name, "(missing)")
            must = f"{setup.drive[name]:g}, the drive's {name}"
            raise InputError(path, f"{part.method}: {name}", given, must, f"set {name} as it was when this was learned")
    largest = float(np.abs(table.values).max())
    if largest > limit:
        must = f"within +-{limit:g} {part.unit}, the drive's {part.limit}"
        raise InputError(path, f"{part.method}: values", largest, must, f"raise {part.limit} in [drive]")


def _observer_table(setup: Setup, path: Path) -> Array:
    table = read_table(path)
    cells, limit_a = int(setup.drive["aro_cells"]), setup.drive["observer_limit_a"]
    if table.cells != cells:
        hint = f"set aro_cells = {table.cells} in [drive]"
        raise InputError(path, "cells", table.cells, f"{cells}, the drive's aro_cells", hint)
    largest_a = float(abs(table.disturbance_a).max())
    if largest_a > limit_a:
        hint = "raise observer_limit_a in [drive]"
        raise InputError(
            path, "disturbance_a", largest_a, f"within +-{limit_a:g} A, the drive's observer_limit_a", hint
        )
    return table.disturbance_a


def check_saving(setup: Setup, path: Path) -> None:
    """Refuse before the work what cannot be saved after it."""
    parts = _need_parts(setup, "--save-memory")
    check_table_file(path, "--save-memory")
    if not _is_angle_observer(parts) and path.suffix != ".json":
        must = f"a name that ends in .json with {'+'.join(part.method for part in parts)}"
        raise InputError("--save-memory", "file", str(path), must, "a .csv holds the table of aro alone")


def learned_tables(setup: Setup, simulation: Simulation) -> Learned | None:
    """What the drive knows now; None where nothing is learned over the angle."""
    parts = parts_of(setup.drive)
    values = simulation.memory()
    if not parts or not len(values):
        return None
    if _is_angle_observer(parts):
        return AngleTable(values, 1.5 * setup.drive["pole_pairs"] * setup.drive["motor_psi_wb"])
    ends = np.cumsum([int(setup.drive[part.cells]) for part in parts])
    return [
        LearnedTable(part.method, part.turn, part.unit, {name: setup.drive[name] for name in part.same}, piece)
        for part, piece in zip(parts, np.split(values, ends[:-1]), strict=True)
    ]


def save_learned(path: Path, learned: Learned) -> None:
    if isinstance(learned, AngleTable):
        write_table(path, learned)
    else:
        write_learned(path, learned)


def _is_angle_observer(parts: Sequence[Part]) -> bool:
    return [part.method for part in parts] == [ARO]


def _need_whole_lines(setup: Setup, parts: Sequence[Part], option: str) -> None:
    """Lines that drift against the rotor leave something else in every turn."""
    if parts[-1].method != "rdc":
        return
    for number in range(1, LINES + 1):
        cycles = setup.drive[f"rdc_line{number}_cycles"]
        if setup.drive[f"rdc_line{number}_nm"] > 0.0 and cycles != round(cycles):
            must = f"whole with {option} and rdc_learn_gain: what it leaves moves against the rotor from turn to turn"
            hint = "identify with --snap, or leave the table out"
            raise InputError("run", f"rdc_line{number}_cycles", float(f"{cycles:.6g}"), must, hint)


def _need_parts(setup: Setup, option: str) -> list[Part]:
    """Tables there are, or what to do about it."""
    parts = parts_of(setup.drive)
    if parts:
        _need_whole_lines(setup, parts, option)
        return parts
    word = method_word(setup.drive)
    method = tables().params["method"].to_text(setup.drive["method"])
    if method in REPETITIVE:
        memory = tables().params["rc_memory"].to_text(setup.drive["rc_memory"])
        hint = "a memory over time holds the samples of one run: add --set drive.rc_memory=angle, or --method aro"
        raise InputError("run", "rc_memory", memory, f"angle with {option} and method = {word}", hint)
    hint = "what ro keeps are the samples of one run: add --method aro" if word == "ro" else "add --method aro"
    must = (
        f"one that learns over the angle with {option}: aro, repetitive control with rc_memory = angle, silc, src, rdc"
    )
    raise InputError("run", "method", word, must, hint)
