"""A case before it is investigated: what is missing, what contradicts meta.json, what was mended.

What makes the work impossible is an error. What can be mended or left out is, and is reported; so is what only seems
odd: an odd log is not refused, because the effect that is searched may be what is odd about it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.compare import Replay
from evenspin.compare.sound import check_record, check_time, dead_channel, drive_of, unusable
from evenspin.errors import MISSING, InputError
from evenspin.gap.repair import repaired
from evenspin.gap.thresholds_records import (
    COARSE_COHERENCE,
    COUNTS_COHERENCE,
    CURRENT_EXCESS,
    DC_LINK_SHARE,
    FINE_RAD,
    LEAST_ROWS,
    PERIODS_SHARE,
    REST_RAD_S,
    REST_SHARE,
    STILL_COUNTS,
    VOLTAGE_EXCESS,
)
from evenspin.log.case import META, Case, read_case
from evenspin.log.experiments import EXPERIMENTS, FITTED, LOADED, LOCKED, VALIDATION
from evenspin.log.meta_numbers import HINT, MetaNumbers, value_of
from evenspin.plausible.currents import ODD, park_share
from evenspin.plausible.drive import Drive
from evenspin.plausible.finding import ChannelError
from evenspin.sim.record import Record

POSITIVE = (
    ("motor", "pole_pairs"),
    ("motor", "resistance_ohm"),
    ("motor", "ld_h"),
    ("motor", "lq_h"),
    ("motor", "psi_wb"),
    ("motor", "inertia_kgm2"),
    ("motor", "rated_current_a"),
    ("motor", "rated_torque_nm"),
    ("dc_link_v",),
    ("pwm_hz",),
    ("current_loop", "ts_s"),
    ("speed_loop", "ts_s"),
)


def checked_case(folder: Path) -> tuple[Case, tuple[str, ...]]:
    """The case, mended, and what to know about it."""
    return checked(read_case(folder))


def checked(case: Case) -> tuple[Case, tuple[str, ...]]:
    folder = case.path
    messages = list(_check_meta(folder, case.meta))
    messages += _files(folder, case)
    drive = drive_of(folder, case.meta)
    alive, dead = _alive(case, drive, messages)
    _enough(case, alive, dead, messages)
    records: dict[str, Record] = {}
    for name, record in alive.items():
        check_time(case, name, record)
        replay = Replay(case.path, case.meta, name, record)  # it names what is missing in meta.json
        check_record(case, name, record, drive, speed_mode=not replay.locked and replay.released_at() is None)
        if _starts_at_rest(name, record, messages):
            records[name] = record
    _enough(case, records, dead, messages)
    _one_from_rest(case, alive, records)
    case = replace(case, experiments=records)
    messages += _contradictions(case)
    return case, tuple(messages)


def _alive(case: Case, drive: Drive, messages: list[str]) -> tuple[dict[str, Record], dict[str, str]]:
    """Mended records, and why others say nothing."""
    alive: dict[str, Record] = {}
    dead: dict[str, str] = {}
    for name, record in case.experiments.items():
        if name not in EXPERIMENTS:
            messages.append(f"{name} is not an experiment of the format: left out")
            continue
        why, mended = unusable(record), None
        if why is None:
            mended = repaired(record, messages, name)
            if mended is None or not _has_rows(name, mended, messages):
                continue
            why = dead_channel(name, mended, drive)
        if why is not None:
            dead[name] = why
            messages.append(f"{name}: {why}: left out")
        elif mended is not None:
            alive[name] = mended
    return alive, dead


def _enough(case: Case, records: Mapping[str, Record], dead: Mapping[str, str], messages: list[str]) -> None:
    """Something to fit, and a shaft that turns in some record if it should have."""
    turning = [name for name in dead if name not in LOCKED] or list(dead)
    if turning and all(name in LOCKED for name in records):
        data = f"{dead[turning[0]]} ({len(dead)} of {len(case.experiments)} records say nothing)"
        raise ChannelError(case.file(turning[0]), data, "repair it and record again")
    if all(name in VALIDATION for name in records):
        why = "; ".join(messages[-3:]) or f"record one of {', '.join(FITTED)}"
        raise InputError(case.path, "experiments", list(records), "at least one record to fit", why)


def _one_from_rest(case: Case, alive: Mapping[str, Record], records: Mapping[str, Record]) -> None:
    """A locked rotor alone says nothing about the shaft, and a verdict on it would."""
    moving = [name for name in alive if name not in LOCKED]
    if moving and all(name in LOCKED for name in records):
        hint = "a load turns the shaft while the bridge is off: hold it until the drive runs, and record again"
        raise InputError(
            case.path, "experiments", ", ".join(moving), "at rest at the start, one of them at least", hint
        )


def _check_meta(folder: Path, meta: Mapping[str, Any]) -> Iterator[str]:
    path = folder / META
    numbers = MetaNumbers(path, meta)
    for keys in POSITIVE:
        numbers.positive(*keys)
    numbers.voltage_limit_v()
    pwm_hz = meta["pwm_hz"]
    for key, limit in (("current_loop", 1.5), ("speed_loop", math.inf)):
        periods = meta[key]["ts_s"] * pwm_hz
        if abs(periods - round(periods)) > PERIODS_SHARE * max(periods, 1.0) or not 0.5 < periods < limit:
            must = "one PWM period" if limit < math.inf else "a whole number of PWM periods"
            raise InputError(path, f"{key}.ts_s", meta[key]["ts_s"], f"{must} of {1.0 / pwm_hz:g} s", HINT)
    delay = value_of(meta, ("current_loop", "computation_delay_periods"))
    if delay is not MISSING and delay != 1:
        raise InputError(path, "current_loop.computation_delay_periods", delay, "1", HINT)
    kind = value_of(meta, ("speed_filter", "type"))
    if kind is not MISSING and kind != "tracking_pll":
        hint = "a log of another drive: evenspin gap LOG.csv --model model.toml"
        raise InputError(path, "speed_filter.type", kind, '"tracking_pll"', hint)
    if numbers.slots() == 0:
        yield "motor.slots is not in meta.json: cogging is searched at order 6 p only"


def _files(folder: Path, case: Case) -> Iterator[str]:
    listed = case.meta["experiments"]
    for name in listed:
        if name not in case.experiments:
            yield f"{name} is in meta.json, but there is no file of it"
    for path in sorted(folder.glob("*.csv*")):
        name = path.name.removesuffix(".gz").removesuffix(".csv")
        if name in EXPERIMENTS and name not in listed:
            yield f"{path.name} is not in meta.json: not read"


def _has_rows(name: str, record: Record, messages: list[str]) -> bool:
    if len(record) < LEAST_ROWS:
        messages.append(f"{name}: {len(record)} rows are too few (at least {LEAST_ROWS}): left out")
        return False
    if name in LOADED and np.isnan(record["load_torque_nm"]).all():
        messages.append(f"{name}: load_torque_nm was not measured, and without it nothing can be simulated: left out")
        return False
    return True


def _starts_at_rest(name: str, record: Record, messages: list[str]) -> bool:
    top = float(np.max(np.abs(record["speed_rad_s"])))
    if name in LOCKED or abs(float(record["speed_rad_s"][0])) <= max(REST_SHARE * top, REST_RAD_S):
        return True
    messages.append(f"{name}: it does not start at rest, so that it cannot be simulated: left out")
    return False


def _contradictions(case: Case) -> Iterator[str]:
    motor = case.meta["motor"]
    counts = float(case.meta["encoder"]["counts_per_rev"])
    for name, record in case.experiments.items():
        if name in LOCKED:
            moved = float(np.ptp(np.unwrap(record["theta_m_rad"])))
            if counts > 0.0 and moved > STILL_COUNTS * math.tau / counts:
                yield f"{name}: the rotor is stated to be locked, but it turned by {moved:.3g} rad"
        off = park_share({key: record[key] for key in record.names}, int(motor["pole_pairs"]))
        if off > ODD:
            yield (
                f"{name}: id_a and iq_a do not follow from ia_a, ib_a and the angle "
                f"({100 * off:.0f} % of the current is at odds)"
            )
    yield from _check_counts(case, counts)
    measured = np.concatenate([record["vdc_v"] for record in case.experiments.values()])
    measured = measured[np.isfinite(measured)]
    dc_v = float(np.median(measured)) if len(measured) else case.meta["dc_link_v"]
    if not abs(dc_v / case.meta["dc_link_v"] - 1.0) < DC_LINK_SHARE:
        yield f"vdc_v is {dc_v:.4g} V, dc_link_v in meta.json {case.meta['dc_link_v']:g} V"
    limit_v = MetaNumbers(case.path / META, case.meta).voltage_limit_v() or case.meta["dc_link_v"] / math.sqrt(3.0)
    top_v = max(float(np.max(np.hypot(r["vd_v"], r["vq_v"]))) for r in case.experiments.values())
    if top_v > VOLTAGE_EXCESS * limit_v:
        yield f"the drive commanded {top_v:.4g} V; the limit that follows from meta.json is {limit_v:.4g} V"
    limit_a = float(case.meta["speed_loop"]["iq_limit_a"])
    turning = [r for name, r in case.experiments.items() if name not in LOCKED]
    top_a = max((float(np.max(np.abs(r["iq_ref_a"]))) for r in turning), default=0.0)
    if top_a > CURRENT_EXCESS * limit_a:
        yield f"iq_ref_a reaches {top_a:.4g} A; speed_loop.iq_limit_a in meta.json is {limit_a:g} A"


def _check_counts(case: Case, counts: float) -> Iterator[str]:
    """The angle moves in whole counts, and in all of them."""
    if counts <= 0.0 or math.tau / counts < FINE_RAD:
        return
    turning = [r["theta_m_rad"] for name, r in case.experiments.items() if name not in LOCKED]
    theta = np.concatenate(turning or [np.empty(0)])
    if len(theta) < LEAST_ROWS:
        return
    steps = theta / (math.tau / counts)
    if abs(np.mean(np.exp(2j * np.pi * steps))) < COUNTS_COHERENCE:
        yield f"theta_m_rad does not move in counts of 2 pi / {counts:g}, as encoder.counts_per_rev in meta.json says"
        return
    for part in (2, 3, 4, 5, 8, 10):
        if counts % part == 0 and abs(np.mean(np.exp(2j * np.pi * steps / part))) > COARSE_COHERENCE:
            yield f"theta_m_rad moves in steps of {part} counts: is encoder.counts_per_rev {counts / part:g}?"
            return
