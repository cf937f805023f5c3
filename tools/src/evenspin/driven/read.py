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
from evenspin.driven.signals import VOLTAGES, Signals, signals_of
from evenspin.effects import Scale
from evenspin.effects.equations import Acting, has_equation
from evenspin.errors import InputError
from evenspin.log.textfile import read_text
from evenspin.model.machine import Machine, find_model, load_machine

Array = NDArray[np.float64]

BESIDE = ("id_a", *VOLTAGES, "vdc_v", "load_torque_nm")
RATED_SHARE = 99.0  # percentile of the current that stands for a rated current that the model does not give
NEEDED = ("id_a", *VOLTAGES)


@dataclass(frozen=True, slots=True)
class Log:
    path: Path
    signals: Signals
    repairs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Nominal:
    """`base`: effects that the model has already; `assumed`: what it leaves open and is taken instead."""

    machine: Machine
    plant: dict[str, float]
    base: tuple[Acting, ...]
    scale: Scale
    assumed: tuple[str, ...]


def has_voltages(path: Path) -> bool:
    """Whether a log has what the equations of the winding need."""
    return set(NEEDED) <= set(header_of(read_text(path)))


def read_logs(paths: Sequence[Path], model: str | Path) -> list[Log]:
    logs: list[Log] = []
    nominal = read_nominal(model)
    for path in paths:
        log = read_log(path)
        columns: dict[str, Array] = {"t_s": log.t_s, "iq_a": log.iq_a}
        for name in ("theta_m_rad", "speed_rad_s"):
            values = getattr(log, name)
            if values is not None:
                columns[name] = values
        motion = {name: columns.get(name) for name in ("t_s", "iq_a", "theta_m_rad", "speed_rad_s")}
        check_against(path, motion, nominal)
        columns |= _beside(path, log.t_s)
        name = _name(path)
        same = sum(each.signals.name.split("#")[0] == name for each in logs)
        logs.append(Log(path, signals_of(f"{name}#{same + 1}" if same else name, columns), log.repairs))
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


def nominal_of(model: str | Path, logs: Sequence[Log]) -> Nominal:
    def refuse(must: str, hint: str) -> InputError:
        return InputError("gap", "--model", str(model), must, hint)

    machine = load_machine(find_model(str(model), Path(), refuse))
    plant = dict(machine.plant)
    assumed = []
    if "pwm_hz" not in machine.plant_from:
        assumed.append(f"pwm_hz is not in the model: {plant['pwm_hz']:g} Hz assumed; dead_time_s goes with its inverse")
    current = plant["rated_current_a"]
    if current <= 0.0:
        current = max(float(np.percentile(np.hypot(log.signals.id_a, log.signals.iq_a), RATED_SHARE)) for log in logs)
        assumed.append(f"rated_current_a is not in the model: sizes are measured by the {current:.3g} A of the log")
    torque = plant["rated_torque_nm"]
    if torque <= 0.0:
        torque = machine.torque_per_a_nm * current
    if plant["viscous_nms"] <= 0.0:
        plant["viscous_nms"] = 1e-3 * torque / max(float(np.max(np.abs(log.signals.speed_rad_s))) for log in logs)
        assumed.append(f"viscous_nms is 0 in the model: its factor is that of {plant['viscous_nms']:.3g} N m s/rad")
    p, slots = int(plant["pole_pairs"]), int(plant["slots"])
    counts = plant["counts_per_rev"] if plant["counts_per_rev"] > 0.0 else 1e9
    base = tuple((name, params) for name, params in machine.effects.items() if has_equation(name))
    lost = [name for name in machine.effects if not has_equation(name)]
    if lost:
        assumed.append(f"{', '.join(lost)} of the model: not in the equations that the log is held against")
    return Nominal(machine, plant, base, Scale(current, torque, p, slots, counts), tuple(assumed))


def _name(path: Path) -> str:
    return path.name.removesuffix(".gz").removesuffix(".csv")
