"""What an experiment logged, as identification needs it: angle over many turns, speed, torque."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import MISSING, InputError
from evenspin.log.case import META, read_case, read_meta, recording_in
from evenspin.log.columns import LOG_COLUMNS, LOG_UNITS
from evenspin.log.csvfile import header_of, read_csv
from evenspin.log.experiments import LOCKED
from evenspin.model.machine import Machine
from evenspin.plausible.currents import CURRENTS, check_currents
from evenspin.plausible.dead import is_constant, unusable_columns
from evenspin.plausible.finding import ChannelError, is_signal
from evenspin.plausible.kinematics import check_motion
from evenspin.sim.record import Record

Array = NDArray[np.float64]

TURN_RAD = 2.0 * np.pi
USED = ("t_s", "theta_m_rad", "iq_a", "iq_ref_a")
NEEDED = frozenset((*USED, "speed_ref_rad_s", "speed_rad_s"))
TORQUE_FROM = ("measured", "command")


@dataclass(frozen=True, slots=True)
class Run:
    """One log. `torque_nm` is what the motor gives; `theta_rad` goes on over the turns."""

    name: str
    ts_s: float
    theta_rad: Array
    speed_ref_rad_s: Array
    torque_nm: Array

    def part(self, rows: slice) -> Run:
        return Run(self.name, self.ts_s, self.theta_rad[rows], self.speed_ref_rad_s[rows], self.torque_nm[rows])

    @property
    def turns(self) -> float:
        return float(abs(self.theta_rad[-1] - self.theta_rad[0]) / TURN_RAD)


def read_runs(paths: Sequence[Path], torque: str = "measured", torque_per_a_nm: float | None = None) -> list[Run]:
    """Logs: case folders, or single CSV files with the meta.json of their folder beside them."""
    check_torque(torque)
    runs = []
    for path in [recording_in(each) or each for each in paths]:
        if path.is_dir():
            case = read_case(path)
            meta, records = case.meta, dict(case.experiments)
        else:
            records = {path.name.removesuffix(".gz").removesuffix(".csv"): _read_log(path)}
            meta = _meta_beside(path) if torque_per_a_nm is None else {}
        for name, record in records.items():
            if name not in LOCKED:
                _check_signals(path / f"{name}.csv" if path.is_dir() else path, record, torque)
        k_t = torque_per_a_nm if torque_per_a_nm is not None else _torque_per_a(path, meta)
        runs += [run_of(record, name, k_t, torque, path) for name, record in records.items()]
    return runs


def _meta_beside(path: Path) -> Mapping[str, Any]:
    if (path.parent / META).exists():
        return read_meta(path.parent / META)
    hint = f"1.5 times pole pairs times flux linkage, which {META} of a case would say"
    raise InputError(path, "--torque-per-a-nm", MISSING, f"given for a log without {META}", hint)


def _read_log(path: Path) -> Record:
    """A single file needs the columns that are used; of the others those that it has are checked, too."""
    there = set(header_of(path)) | NEEDED
    names = [name for name in LOG_COLUMNS if name in there]
    read = read_csv(path, names, [LOG_UNITS[LOG_COLUMNS.index(name)] for name in names])
    missing = np.full(len(read), np.nan)
    columns = [read[name] if name in read else missing for name in LOG_COLUMNS]
    return Record(LOG_COLUMNS, LOG_UNITS, np.column_stack(columns))


def torque_from(machine: Machine | None, torque_per_a_nm: float | None) -> str:
    """Where the torque of an ampere comes from, on which every result in N m rests."""
    if torque_per_a_nm is not None:
        return f"Torque per ampere: {torque_per_a_nm:g} N m/A, as given."
    if machine is not None:
        return f"Torque per ampere: {machine.calculated_with(('pole_pairs', 'psi_wb'))}"
    return "Torque per ampere: from pole_pairs and psi_wb of meta.json, nominal values that nobody measured here."


def _check_signals(file: Path, record: Record, torque: str) -> None:
    """A channel that is dead or in another unit would be identified as a machine."""
    columns = {name: record[name] for name in record.names}
    current = "iq_ref_a" if torque == "command" else "iq_a"
    why = unusable_columns(columns, [name for name in LOG_COLUMNS if name not in USED])
    dead = next((name for name in ("theta_m_rad", current) if why is None and is_constant(columns[name])), None)
    if dead is not None:
        why = f"{dead} is {columns[dead][0] + 0.0:g} in every row: a dead channel, or a shaft that never turned"
    if why is not None:
        raise ChannelError(file, why, "repair it and record again, or leave this log out")
    if not all(is_signal(columns[name], name).all() for name in (*USED, "speed_rad_s")):
        return  # reported for each column later
    found = check_motion(columns["t_s"], columns["theta_m_rad"], columns["speed_rad_s"])
    if found is None and all(is_signal(columns[name]).all() for name in CURRENTS):
        found = check_currents(columns, 0)
    if found is not None:
        raise found.error(file)


def check_torque(torque: str) -> None:
    if torque not in TORQUE_FROM:
        raise InputError("identify", "--torque", torque, "measured or command", "measured is the default")


def run_of(record: Record, name: str, torque_per_a_nm: float, torque: str = "measured", path: Path | str = "") -> Run:
    """`command`: the torque of a row is the command of the row before, which acts now."""
    if len(record) < 3:
        raise InputError(path or name, name, f"{len(record)} rows", "at least 3 rows", "record longer")
    for column in ("t_s", "theta_m_rad", "iq_a", "iq_ref_a"):
        if not is_signal(record[column], column).all():
            raise InputError(path or name, column, "nan", "finite in every row", "correct the log")
    if torque == "command":
        current = np.concatenate((record["iq_ref_a"][:1], record["iq_ref_a"][:-1]))
    else:
        current = record["iq_a"]
    steps_s = np.diff(record["t_s"])
    ts_s = float(np.median(steps_s))
    if not ts_s > 0.0 or np.abs(steps_s - ts_s).max() > 0.01 * ts_s:
        raise InputError(path or name, "t_s", name, "evenly spaced and rising", "fill the gaps, or cut the log there")
    theta = np.unwrap(record["theta_m_rad"])
    return Run(name, ts_s, theta, np.array(record["speed_ref_rad_s"]), torque_per_a_nm * current)


def constant_stretches(run: Run, settle_s: float = 0.3) -> list[Run]:
    """Where the speed reference is constant, without the time in which the speed follows it."""
    reference = run.speed_ref_rad_s
    cuts = np.flatnonzero(np.abs(np.diff(reference)) > 1e-9 * (1.0 + np.abs(reference[1:]))) + 1
    edges = [0, *cuts.tolist(), len(reference)]
    settle = round(settle_s / run.ts_s)
    found = []
    for start, end in zip(edges[:-1], edges[1:], strict=True):
        if reference[start] != 0.0 and end - start > settle + 2:
            found.append(run.part(slice(start + settle, end)))
    return found


def whole_turns(run: Run) -> slice | None:
    """The longest end of it that is a whole number of turns; None when it is less than one."""
    travel = np.abs(run.theta_rad - run.theta_rad[-1])
    turns = np.floor(travel[0] / TURN_RAD + 1e-6)
    if turns < 1:
        return None
    return slice(int(np.argmin(np.abs(travel - turns * TURN_RAD))), len(travel))


def _torque_per_a(path: Path, meta: Mapping[str, Any]) -> float:
    motor = meta.get("motor", {})
    try:
        value = 1.5 * float(motor["pole_pairs"]) * float(motor["psi_wb"])
    except (KeyError, TypeError, ValueError, OverflowError):
        value = 0.0
    if not value > 0.0:
        given = motor.get("psi_wb", MISSING) if isinstance(motor, Mapping) else MISSING
        must = "a flux linkage above 0, for the torque of an ampere"
        raise InputError(path, "motor.psi_wb", given, must, "give --torque-per-a-nm")
    return value
