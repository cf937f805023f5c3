"""A log that cannot be what its columns say is one line that names file, column and next step; a sound one passes.

Each bad log is a sound record of another simulator with one thing done to it; units are applied by their definition.
"""

from __future__ import annotations

import functools
import json
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evenspin.compare.sound import check_for_comparison
from evenspin.errors import EvenspinError
from evenspin.gap.check import checked
from evenspin.log import LOG_COLUMNS, Case
from evenspin.log.columns import LOG_UNITS
from evenspin.log.csvfile import read_csv
from evenspin.sim import Record

CASES = Path(__file__).parents[3] / "tests" / "data" / "foreign_drive"
FOLDER = CASES / "example_coulomb_and_inertia"  # a third more inertia than meta.json says, and friction
PAIRS = 3
TURNING, LOCKED = "staircase_load", "standstill_steps"
WAIT_S = 5.0
CURRENTS = ("id_ref_a", "iq_ref_a", "id_a", "iq_a", "ia_a", "ib_a")
Columns = dict[str, np.ndarray[Any, Any]]
Change = Callable[[Columns], Columns]


@functools.cache
def sound(name: str, folder: Path = FOLDER) -> Record:
    return read_csv(folder / f"{name}.csv.gz", LOG_COLUMNS, LOG_UNITS)


def case_of(change: Change, names: tuple[str, ...] = (TURNING, LOCKED), only: str | None = None) -> Case:
    """The case with this done to all of its records, or to one."""
    meta = json.loads((FOLDER / "meta.json").read_text())
    records = {}
    for name in names:
        columns = {key: sound(name)[key].copy() for key in LOG_COLUMNS}
        columns = change(columns) if only in (None, name) else columns
        records[name] = Record(LOG_COLUMNS, LOG_UNITS, np.column_stack([columns[key] for key in LOG_COLUMNS]))
    return Case(FOLDER, {**meta, "experiments": list(names)}, records)


def remarks(said: tuple[str, ...]) -> list[str]:
    """Without those on the files of the folder that these cases leave away."""
    return [line for line in said if not line.endswith("is not in meta.json: not read")]


def refusal(case: Case) -> str:
    start = time.monotonic()
    with pytest.raises(EvenspinError) as error:
        checked(case)
    assert time.monotonic() - start < WAIT_S
    assert error.value.exit_code == 2
    text = str(error.value)
    assert "\n" not in text
    return text


def put(value: Any, *names: str) -> Change:
    return lambda c: c | {name: value(c[name]) if callable(value) else np.full_like(c[name], value) for name in names}


def times(factor: float, *names: str) -> Change:
    return put(lambda x: factor * x, *names)


def exchanged(one: str, other: str) -> Change:
    return lambda c: c | {one: c[other], other: c[one]}


def wrapped(factor: float, period: float) -> Callable[[Any], Any]:
    return lambda theta: np.remainder(factor * theta, period)


BAD: dict[str, tuple[Change, str]] = {
    "all zero": (put(0.0, *LOG_COLUMNS[1:]), "is 0 in every row"),
    "time stands": (put(0.0, "t_s"), "t_s is 0 in every row"),
    "iq_a zero": (put(0.0, "iq_a"), "iq_a is 0 in every row: a dead channel"),
    "iq_a constant": (put(0.7, "iq_a"), "iq_a is 0.7 in every row: a dead channel"),
    "ia_a zero": (put(0.0, "ia_a"), "ia_a is 0 in every row"),
    "voltage zero": (put(0.0, "vq_v"), "vq_v is 0 in every row"),
    "dc link zero": (put(0.0, "vdc_v"), "vdc_v is 0 in every row"),
    "references zero": (put(0.0, "iq_ref_a"), "iq_ref_a is 0 in every row"),
    "speed reference zero": (put(0.0, "speed_ref_rad_s"), "speed_ref_rad_s is 0 in every row"),
    "load zero": (put(0.0, "load_torque_nm"), "load_torque_nm: 0 in every row"),
    "no number": (put(math.nan, "iq_a"), "iq_a has no number in any row"),
    "speed zero": (put(0.0, "speed_rad_s"), "speed_rad_s is 0 in every row"),
    "angle constant": (put(1.2, "theta_m_rad"), "theta_m_rad is 1.2 in every row"),
    "never turned": (
        lambda c: put(1.2, "theta_m_rad")(put(0.0, "speed_rad_s")(c)),
        "the shaft never turned",
    ),
    "never flowed": (
        put(lambda x: 0.01 * np.random.default_rng(1).normal(size=len(x)), *CURRENTS[2:]),
        "the current never flowed",
    ),
    "iq_a stuck": (
        put(lambda x: np.where(np.arange(len(x)) < len(x) // 2, x, x[len(x) // 2]), "iq_a"),
        r"iq_a stands at .* stuck",
    ),
    "milliseconds": (times(1e3, "t_s"), "t_s = .*it looks like milliseconds"),
    "microseconds": (times(1e6, "t_s"), "t_s = .*it looks like microseconds"),
    "minutes": (times(1.0 / 60.0, "t_s"), "t_s = .*it looks like minutes"),
    "r/min": (times(30.0 / math.pi, "speed_rad_s"), r"9\.5\d* times .*speed_rad_s in r/min"),
    "degrees per second": (times(180.0 / math.pi, "speed_rad_s"), "speed_rad_s in degrees per second"),
    "electrical speed": (times(PAIRS, "speed_rad_s"), "speed_rad_s in electrical rad"),
    "reference in r/min": (times(30.0 / math.pi, "speed_ref_rad_s"), "speed_ref_rad_s.*r/min"),
    "degrees": (put(np.degrees, "theta_m_rad"), "theta_m_rad in degrees"),
    "turns": (times(0.5 / math.pi, "theta_m_rad"), "theta_m_rad in turns"),
    "counts": (times(4000 / math.tau, "theta_m_rad"), "theta_m_rad in counts"),
    "electrical angle": (put(wrapped(PAIRS, math.tau), "theta_m_rad"), "theta_m_rad in electrical rad"),
    "all electrical": (
        lambda c: times(PAIRS, "speed_rad_s")(put(wrapped(PAIRS, math.tau), "theta_m_rad")(c)),
        r"pole_pairs = 3: must be 1.*electrical",
    ),
    "iq_a in mA": (times(1e3, "iq_a"), "iq_a is in mA"),
    "measured currents in mA": (times(1e3, *CURRENTS[2:]), "ia_a and ib_a are in mA"),
    "all currents in mA": (times(1e3, *CURRENTS), "the currents look like mA"),
    "axes exchanged": (exchanged("id_a", "iq_a"), "id_a and iq_a are exchanged"),
    "phases exchanged": (exchanged("ia_a", "ib_a"), "ia_a and ib_a are exchanged"),
    "angle for speed": (exchanged("theta_m_rad", "speed_rad_s"), "theta_m_rad and speed_rad_s look swapped"),
    "current for speed": (exchanged("iq_a", "speed_rad_s"), "exchange the names speed_rad_s and iq_a"),
    "reference for speed": (exchanged("speed_ref_rad_s", "speed_rad_s"), "speed_rad_s and speed_ref_rad_s"),
    "voltages exchanged": (exchanged("vd_v", "vq_v"), "vd_v, vq_v: .*exchanged"),
    "sign of iq_a": (times(-1.0, "iq_a"), "iq_a has the opposite sign"),
    "sign of all currents": (times(-1.0, *CURRENTS), "opposite sign"),
    "sign of the speed": (times(-1.0, "speed_rad_s"), "one of the two has the opposite sign"),
    "sign of the voltages": (times(-1.0, "vd_v", "vq_v"), "opposite sign"),
    "sign of the load": (times(-1.0, "load_torque_nm"), "load_torque_nm: .*turn its sign"),
    "load in mN m": (times(1e3, "load_torque_nm"), "load_torque_nm: .*mN m"),
    "power invariant": (times(math.sqrt(1.5), "id_a", "iq_a"), "power-invariant"),
    "not in order": (
        lambda c: {name: column[np.random.default_rng(1).permutation(len(column))] for name, column in c.items()},
        "t_s repeats or goes back too often",
    ),
}


@pytest.mark.parametrize("what", BAD)
def test_a_log_that_cannot_be_so_is_one_line_within_seconds(what: str) -> None:
    import re

    change, said = BAD[what]

    text = refusal(case_of(change))

    assert re.search(said, text), text


@pytest.mark.parametrize("what", ["iq_a zero", "milliseconds", "r/min", "axes exchanged", "no number", "degrees"])
def test_what_is_compared_is_checked_likewise(what: str) -> None:
    case = case_of(BAD[what][0], (TURNING,))

    with pytest.raises(EvenspinError, match=BAD[what][1]):
        check_for_comparison(case, [TURNING])


def test_a_record_whose_channel_is_dead_is_left_out_and_said_where_others_live() -> None:
    case, said = checked(case_of(put(0.0, "iq_a"), (TURNING, "load_step", LOCKED), only="load_step"))

    assert list(case.experiments) == [TURNING, LOCKED]
    assert any(line.startswith("load_step: iq_a is 0 in every row") and "left out" in line for line in said)


def test_a_unit_that_is_wrong_in_one_file_names_that_file() -> None:
    text = refusal(case_of(times(30.0 / math.pi, "speed_rad_s"), (TURNING, "load_step"), only="load_step"))

    assert "load_step.csv.gz" in text and "r/min" in text


@pytest.mark.parametrize("name", ["coast_down", LOCKED, "reversal", "load_step", "validation"])
def test_what_rests_or_coasts_as_it_should_is_taken_without_a_word(name: str) -> None:
    case, said = checked(case_of(lambda c: c, (TURNING, name)))

    assert list(case.experiments) == [TURNING, name]
    assert remarks(said) == []


def test_a_dc_link_that_was_not_measured_is_nan_and_no_matter() -> None:
    assert remarks(checked(case_of(put(math.nan, "vdc_v")))[1]) == []


GAIN = 1.05  # of one phase sensor: 25 times the tolerance
ODD: dict[str, Change] = {
    "sensor offset": lambda c: with_phases(c, c["ia_a"] + 0.3, c["ib_a"]),
    "sensor gain": lambda c: with_phases(c, GAIN * c["ia_a"], c["ib_a"]),
    "voltages a half more": times(1.5, "vd_v", "vq_v"),
    "load sensor off by a fifth": times(1.2, "load_torque_nm"),
    "angle with eccentricity": lambda c: c | {"theta_m_rad": c["theta_m_rad"] + 0.02 * np.sin(c["theta_m_rad"])},
}


def with_phases(c: Columns, ia: Any, ib: Any) -> Columns:
    """What a drive makes of its phase sensors: the amplitude-invariant transform with the electrical angle."""
    angle = PAIRS * c["theta_m_rad"]
    ic = -ia - ib
    third = 2.0 * math.pi / 3.0
    d = 2.0 / 3.0 * (ia * np.cos(angle) + ib * np.cos(angle - third) + ic * np.cos(angle + third))
    q = -2.0 / 3.0 * (ia * np.sin(angle) + ib * np.sin(angle - third) + ic * np.sin(angle + third))
    return c | {"ia_a": ia, "ib_a": ib, "id_a": d, "iq_a": q}


@pytest.mark.parametrize("what", ODD)
def test_what_an_effect_could_do_to_a_log_is_not_refused(what: str) -> None:
    case, _ = checked(case_of(ODD[what]))

    assert list(case.experiments) == [TURNING, LOCKED]


@pytest.mark.parametrize("factor", [1.0 / 3.0, 0.5, 2.0, 3.0])
@pytest.mark.parametrize("key", ["inertia_kgm2", "resistance_ohm", "viscous_nms"])
def test_motor_data_that_are_off_by_a_factor_of_three_are_not_refused(key: str, factor: float) -> None:
    case = case_of(lambda c: c)
    case.meta["motor"][key] *= factor  # type: ignore[index]

    assert list(checked(case)[0].experiments) == [TURNING, LOCKED]


@pytest.mark.parametrize("example", ["example_clean", "example_cogging", "example_current_offset"])
def test_every_record_of_a_sound_case_is_taken_without_a_word(example: str) -> None:
    folder = CASES / example
    meta = json.loads((folder / "meta.json").read_text())
    start = time.monotonic()

    case, said = checked(Case(folder, meta, {name: sound(name, folder) for name in meta["experiments"]}))

    assert list(case.experiments) == meta["experiments"]
    assert said == ()
    assert time.monotonic() - start < WAIT_S


@pytest.mark.parametrize("limit", ["dc_link_v/sqrt(2)", "none", "svm", "", True, -5.0, [], {}])
def test_a_voltage_limit_that_is_not_known_names_what_is(limit: Any) -> None:
    case = case_of(lambda c: c)
    case.meta["current_loop"]["v_limit"] = limit  # type: ignore[index]

    assert 'must be "dc_link_v/sqrt(3)" or a number of volts above 0' in refusal(case)


def test_a_voltage_limit_in_volts_is_that_of_the_simulated_drive() -> None:
    from evenspin.compare import resimulate

    case = case_of(lambda c: c, ("load_step",))
    record = case.experiments["load_step"]
    short = Record(record.names, record.units, record.values[:400].copy())
    case.meta["current_loop"]["v_limit"] = 5.0  # type: ignore[index]

    v = resimulate(case.path, case.meta, "load_step", short, ("vd_v", "vq_v"))

    assert float(np.max(np.hypot(v[:, 0], v[:, 1]))) == pytest.approx(5.0, rel=1e-3)  # of 25 V without it


@pytest.mark.parametrize("slots", ["many", 10**400, -3, 2.5, True, [18]])
def test_slots_that_no_motor_has_are_one_line(slots: Any) -> None:
    case = case_of(lambda c: c)
    case.meta["motor"]["slots"] = slots  # type: ignore[index]

    assert "motor.slots = " in refusal(case)
