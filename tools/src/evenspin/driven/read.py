"""Logs in SI units as signals, and what the model file gives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.csv_rows import header_of, rows_of
from evenspin.balance.log_reader import read_log
from evenspin.balance.nominal_model import read_nominal
from evenspin.balance.plausibility import check_against
from evenspin.driven.motor import MOTOR, first_values
from evenspin.effects import Scale
from evenspin.effects.equations import Acting, has_equation
from evenspin.errors import InputError
from evenspin.log.textfile import read_text
from evenspin.model.machine import Machine, find_model, load_machine
from evenspin.weakform.signals import VOLTAGES, Signals, signals_of

Array = NDArray[np.float64]

BESIDE = ("id_a", *VOLTAGES, "vdc_v", "load_torque_nm")
RATED_SHARE = 99.0  # percentile of the current that stands for a rated current that the model does not give
NEEDED = ("id_a", *VOLTAGES)
SHAFT_NUMBERS = ("pole_pairs", "psi_wb", "inertia_kgm2", "viscous_nms")
AMPERES = 1e-4  # N m per A from 1: a model that a torque balance wrote, in ampere equivalents
SALIENT = 1.2  # lq over ld, from which the d current makes torque


@dataclass(frozen=True, slots=True)
class Log:
    path: Path
    signals: Signals
    repairs: tuple[str, ...]
    doubts: tuple[str, ...] = ()  # a unit or a sign that may be wrong


LEAST_RATE_HZ = 25.0  # for what does not repeat with the angle


@dataclass(frozen=True, slots=True)
class Nominal:
    """`base`: effects that the model has already; `assumed`: what it leaves open and is taken instead."""

    machine: Machine
    plant: dict[str, float]
    base: tuple[Acting, ...]
    scale: Scale
    assumed: tuple[str, ...]
    estimated: tuple[str, ...] = ()  # numbers of the plant that the model leaves open: from the logs


def has_voltages(path: Path) -> bool:
    """Whether a log has what the equations of the winding need."""
    return set(NEEDED) <= set(header_of(read_text(path)))


def serves(paths: Sequence[Path], model: str | Path) -> bool:
    """Whether the equations of the machine can be held against these logs: those of the winding where voltages were
    recorded, that of the torque where the model states what it is made of."""
    if any(has_voltages(path) for path in paths):
        return True
    machine = _machine(model)
    in_amperes = abs(machine.torque_per_a_nm - 1.0) < AMPERES
    return set(SHAFT_NUMBERS) <= set(machine.plant_from) and not in_amperes


def read_logs(paths: Sequence[Path], model: str | Path) -> list[Log]:
    logs: list[Log] = []
    nominal = None if missing_of(_machine(model), paths) else read_nominal(model)
    for path in paths:
        log = read_log(path, LEAST_RATE_HZ)
        columns: dict[str, Array] = {"t_s": log.t_s, "iq_a": log.iq_a}
        for name in ("theta_m_rad", "speed_rad_s"):
            values = getattr(log, name)
            if values is not None:
                columns[name] = values
        motion = {name: columns.get(name) for name in ("t_s", "iq_a", "theta_m_rad", "speed_rad_s")}
        remarks = () if nominal is None else check_against(path, {**motion, **log.beside}, nominal)
        columns |= _beside(path, log.t_s)
        name = _name(path)
        same = sum(each.signals.name.split("#")[0] == name for each in logs)
        signals = signals_of(f"{name}#{same + 1}" if same else name, columns)
        logs.append(Log(path, signals, log.repairs, (*log.doubts, *remarks)))
    return logs


def _beside(path: Path, t_s: Array) -> dict[str, Array]:
    """The other columns, at the rows that the reader has kept."""
    text = read_text(path)
    header = header_of(text)
    names = [name for name in BESIDE if name in header]
    table = rows_of(path, text, [header.index(name) for name in ("t_s", *names)], [])
    table = table[np.isfinite(table[:, 0])]
    table = table[np.argsort(table[:, 0], kind="stable")]
    found = {}
    for name, values in zip(names, table[:, 1:].T, strict=True):
        there = np.isfinite(values)
        if np.count_nonzero(there) > 1:
            found[name] = np.interp(t_s, table[there, 0], values[there])
    return found


def _machine(model: str | Path) -> Machine:
    def refuse(must: str, hint: str) -> InputError:
        return InputError("gap", "--model", str(model), must, hint)

    return load_machine(find_model(str(model), Path(), refuse), ("pole_pairs",))


def missing_of(machine: Machine, paths: Sequence[Path]) -> tuple[str, ...]:
    """Numbers that the equations of these logs need, and the model leaves open."""
    needed = MOTOR if any(has_voltages(path) for path in paths) else SHAFT_NUMBERS
    return tuple(name for name in needed if name not in machine.plant_from)


def nominal_of(model: str | Path, logs: Sequence[Log]) -> Nominal:
    machine = _machine(model)
    plant = dict(machine.plant)
    assumed = []
    missing = missing_of(machine, [log.path for log in logs])
    if "dc_link_v" not in machine.plant_from:
        plant["dc_link_v"] = _dc_link_v(logs)
        assumed.append(f"dc_link_v is not in the model: {plant['dc_link_v']:.3g} V of the log")
    if missing:
        plant = first_values([log.signals for log in logs], plant, missing)
        assumed.append(f"{', '.join(missing)}: not in the model, estimated from the log; an effect of them has no name")
    voltages = any(log.signals.has_voltages for log in logs)
    if "pwm_hz" not in machine.plant_from and voltages:
        assumed.append(f"pwm_hz is not in the model: {plant['pwm_hz']:g} Hz assumed; dead_time_s goes with its inverse")
    current = plant["rated_current_a"]
    if current <= 0.0:
        current = max(float(np.percentile(np.hypot(log.signals.id_a, log.signals.iq_a), RATED_SHARE)) for log in logs)
        assumed.append(f"rated_current_a is not in the model: sizes are measured by the {current:.3g} A of the log")
    torque = plant["rated_torque_nm"]
    if torque <= 0.0:
        torque = 1.5 * plant["pole_pairs"] * plant["psi_wb"] * current
    if plant["viscous_nms"] <= 0.0:
        plant["viscous_nms"] = 1e-3 * torque / max(float(np.max(np.abs(log.signals.speed_rad_s))) for log in logs)
        assumed.append(f"viscous_nms is 0 in the model: its factor is that of {plant['viscous_nms']:.3g} N m s/rad")
    p, slots = int(plant["pole_pairs"]), int(plant["slots"])
    counts = plant["counts_per_rev"] if plant["counts_per_rev"] > 0.0 else 1e9
    if plant["lq_h"] > SALIENT * plant["ld_h"] and not all(log.signals.has_id for log in logs):
        assumed.append("id_a is not in the log and taken as 0: the reluctance torque of this machine is left out")
    base = tuple((name, params) for name, params in machine.effects.items() if has_equation(name))
    lost = [name for name in machine.effects if not has_equation(name)]
    if lost:
        assumed.append(f"{', '.join(lost)} of the model: not in the equations that the log is held against")
    return Nominal(machine, plant, base, Scale(current, torque, p, slots, counts), tuple(assumed), missing)


def _dc_link_v(logs: Sequence[Log]) -> float:
    measured = [float(np.median(log.signals.vdc_v)) for log in logs if log.signals.vdc_v is not None]
    if measured:
        return measured[0]
    sizes = [
        np.hypot(s.vd_v, s.vq_v) for s in (log.signals for log in logs) if s.vd_v is not None and s.vq_v is not None
    ]
    return float(np.sqrt(3.0) * max(np.max(size) for size in sizes)) if sizes else 0.0


def _name(path: Path) -> str:
    return path.name.removesuffix(".gz").removesuffix(".csv")
