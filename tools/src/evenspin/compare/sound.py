"""Whether a record of a case can be what its columns say, before anything is simulated or compared."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.compare.resimulate import Replay
from evenspin.errors import InputError
from evenspin.log.case import META, Case
from evenspin.log.columns import LOG_COLUMNS
from evenspin.log.experiments import ALWAYS_LOADED, LOCKED
from evenspin.log.meta_numbers import MetaNumbers
from evenspin.plausible.currents import check_currents, wrong_pole_pairs
from evenspin.plausible.dead import dead_record, unusable_columns
from evenspin.plausible.drive import Drive, check_references, check_torque, check_voltages
from evenspin.plausible.finding import ChannelError, is_signal
from evenspin.plausible.kinematics import check_motion, exchanged_speed
from evenspin.sim.record import Record

MOST_PERIODS = 200.0  # of the PWM between two rows: 20 ms at 10 kHz
PERIODS = 0.02  # a sampling time may differ from a whole number of PWM periods by this share
TIMES = (("milliseconds", 1e-3), ("microseconds", 1e-6), ("minutes", 60.0))
LOST_CONTROL = 3.0  # times the limit: a drive with such a current has lost control, and no relation holds
NOT_SPEEDS = ("speed_ref_rad_s", "id_a", "iq_a", "vd_v", "vq_v", "iq_ref_a", "load_torque_nm")
OPTIONAL = ("vdc_v", "load_torque_nm")  # nan in every row where they were not measured
NEEDED = tuple(name for name in LOG_COLUMNS if name not in OPTIONAL)


def drive_of(path: Path, meta: Mapping[str, Any]) -> Drive:
    numbers = MetaNumbers(path / META, meta)
    motor = {
        key: numbers.number("motor", key)
        for key in (
            "resistance_ohm", "ld_h", "lq_h", "psi_wb", "inertia_kgm2", "viscous_nms",
            "rated_current_a", "rated_torque_nm",
        )
    }  # fmt: skip
    return Drive(
        pole_pairs=int(numbers.number("motor", "pole_pairs")),
        iq_limit_a=numbers.number("speed_loop", "iq_limit_a"),
        counts_per_rev=numbers.number("encoder", "counts_per_rev"),
        **motor,
    )


def check_time(case: Case, name: str, record: Record) -> None:
    """Rows are spaced by a whole number of PWM periods, and not by too many."""
    pwm_hz = MetaNumbers(case.path / META, case.meta).positive("pwm_hz")
    step_s = float(np.median(np.diff(record["t_s"])))
    if _is_possible(step_s * pwm_hz):
        return
    given = f"{step_s * pwm_hz:.3g} PWM periods between rows"
    unit = next((unit for unit, seconds in TIMES if _is_possible(step_s * seconds * pwm_hz)), None)
    if unit is not None:
        must = f"1 .. {MOST_PERIODS:g} of {1.0 / pwm_hz:g} s (pwm_hz in meta.json)"
        raise InputError(case.file(name), "t_s", given, must, f"it looks like {unit}: convert it to seconds")
    raise InputError(
        case.file(name), "t_s", given, f"a whole number of them, at most {MOST_PERIODS:g}",
        f"pwm_hz = {pwm_hz:g} in meta.json contradicts the log",
    )  # fmt: skip


def _is_possible(periods: float) -> bool:
    whole = abs(periods - round(periods)) <= PERIODS * max(periods, 1.0)
    return whole and 0.5 <= periods <= MOST_PERIODS


def unusable(record: Record) -> str | None:
    """Why the record cannot even be mended."""
    return unusable_columns(_columns(record), OPTIONAL)


def dead_channel(name: str, record: Record, drive: Drive) -> str | None:
    """Why the record says nothing; None where it does."""
    columns = _columns(record)
    if not np.any(columns["vdc_v"]):
        return "vdc_v is 0 in every row: a dead channel (nan says that it was not measured)"
    return dead_record(columns, name in LOCKED, drive.pole_pairs, drive.counts_per_rev)


def check_for_comparison(case: Case, names: Iterable[str]) -> None:
    """Records that are compared as they are, without anything left out or mended."""
    drive = drive_of(case.path, case.meta)
    for name in names:
        record = case.experiments[name]
        why = unusable(record)
        if why is None and len(record) > 1:
            bad = [key for key in NEEDED if not is_signal(record[key], key).all()]
            if bad:
                given = f"{int(np.count_nonzero(~is_signal(record[bad[0]], bad[0])))} rows that are not numbers"
                raise InputError(case.file(name), bad[0], given, "a number in every row", "`evenspin gap` mends a few")
            if not np.all(np.diff(record["t_s"]) > 0.0):
                given = f"{int(np.count_nonzero(np.diff(record['t_s']) <= 0.0))} rows that repeat or go back"
                raise InputError(case.file(name), "t_s", given, "rising in every row", "sort the rows by time")
            why = dead_channel(name, record, drive)
        if why is not None:
            raise ChannelError(case.file(name), why, "repair it and record again")
        replay = Replay(case.path, case.meta, name, record)
        check_time(case, name, record)
        check_record(case, name, record, drive, speed_mode=not replay.locked and replay.released_at() is None)


def check_record(case: Case, name: str, record: Record, drive: Drive, speed_mode: bool) -> None:
    """A column that is another one, in another unit or of another sign is an error that names it."""
    columns, locked = _columns(record), name in LOCKED
    found = None
    if not locked:
        motion = columns["t_s"], columns["theta_m_rad"], columns["speed_rad_s"]
        found = exchanged_speed(*motion, {key: columns[key] for key in NOT_SPEEDS})
        found = found or check_motion(*motion, drive.pole_pairs, drive.counts_per_rev)
    if found is None and not locked:  # an angle that stands fits some number of pole pairs by chance
        pole_pairs = wrong_pole_pairs(columns, drive.pole_pairs)
        if pole_pairs is not None:
            must = f"{pole_pairs}, as ia_a, ib_a, id_a, iq_a and theta_m_rad of {case.file(name).name} say"
            electrical = "correct it, or theta_m_rad and speed_rad_s are electrical: divide by the pole pairs"
            hint = electrical if pole_pairs == 1 else "correct it"
            raise InputError(case.path / META, "motor.pole_pairs", drive.pole_pairs, must, hint)
    found = found or check_currents(columns, drive.pole_pairs)
    found = found or check_references(columns, drive, speed_mode and not locked)
    under_control = float(np.max(np.abs(columns["iq_a"]))) < LOST_CONTROL * max(drive.iq_limit_a, drive.rated_current_a)
    if under_control:
        found = found or check_voltages(columns, drive)
    if under_control and not locked and found is None:
        measured = bool(np.isfinite(columns["load_torque_nm"]).any())
        found = check_torque(columns, drive, measured, name in ALWAYS_LOADED)
    if found is not None:
        raise found.error(case.file(name))


def _columns(record: Record) -> dict[str, Any]:
    return {name: record[name] for name in record.names}
