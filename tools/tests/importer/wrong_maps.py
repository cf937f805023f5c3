"""Every sign, frame and unit error of a map, one at a time, on simulated and real logs: seen, or taken for true?

The errors are made in the columns themselves, under the names of the log format: what a wrong map leaves, or a
converter of one's own. `make wrong-maps` prints the table.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from evenspin.blind.bench_drives import draw_bench_unit, draw_drive, nominal_of
from evenspin.blind.bench_profile import draw_inputs, follows
from evenspin.blind.logs import MODEL, model_text
from evenspin.blind.referee import simulate
from evenspin.blind.styles import signals_of
from evenspin.errors import EvenspinError
from evenspin.log.csvfile import read_csv

Array = np.ndarray
Columns = dict[str, Array]
REAL = Path(__file__).resolve().parents[3] / "tests" / "data" / "laas_servo"
RPM, DEG, TURN = 30.0 / math.pi, 180.0 / math.pi, 2.0 * math.pi
DQ, PHASES = ("id_a", "iq_a"), ("ia_a", "ib_a", "ic_a")
VOLTS = ("vd_v", "vq_v")
SETS = {
    "everything": ("theta_m_rad", "speed_rad_s", *DQ, "ia_a", "ib_a", *VOLTS, "load_torque_nm"),
    "dq and voltages": ("theta_m_rad", "speed_rad_s", *DQ, *VOLTS),
    "voltages, no angle": ("speed_rad_s", *DQ, *VOLTS),
    "voltages, no speed": ("theta_m_rad", *DQ, *VOLTS),
    "iq, angle, speed": ("theta_m_rad", "speed_rad_s", "iq_a"),
    "iq, speed": ("speed_rad_s", "iq_a"),
    "iq, angle": ("theta_m_rad", "iq_a"),
    "phase currents, angle": ("theta_m_rad", *PHASES),
}


@dataclass(frozen=True)
class Base:
    """A right log. `pole_pairs` is what a wrong reading would mistake it by."""

    name: str
    columns: Columns
    pole_pairs: int
    model: str | None = None


@dataclass(frozen=True)
class Mistake:
    """`needs`: columns, all of which have to be there. `change`: what the wrong map makes of them."""

    name: str
    needs: tuple[str, ...]
    change: Callable[[Columns, int], Columns]


def _times(factor: float, *names: str) -> Callable[[Columns, int], Columns]:
    return lambda c, p: c | {name: factor * c[name] for name in names if name in c}


def _exchanged(one: str, other: str) -> Callable[[Columns, int], Columns]:
    return lambda c, p: c | {one: c[other], other: c[one]}


def _wrapped(c: Columns, p: int) -> Columns:
    return c | {"theta_m_rad": np.mod(p * c["theta_m_rad"], TURN)}


CURRENTS = (*DQ, *PHASES)
MISTAKES = (
    Mistake("all currents of the opposite sign", (), _times(-1.0, *CURRENTS)),
    Mistake("iq of the opposite sign", ("id_a", "iq_a"), _times(-1.0, "iq_a")),
    Mistake("id and iq exchanged", ("id_a", "iq_a"), _exchanged("id_a", "iq_a")),
    Mistake("speed in r/min", ("speed_rad_s",), _times(RPM, "speed_rad_s")),
    Mistake("speed taken for r/min", ("speed_rad_s",), _times(1.0 / RPM, "speed_rad_s")),
    Mistake("speed in turns per second", ("speed_rad_s",), _times(1.0 / TURN, "speed_rad_s")),
    Mistake("speed in degrees per second", ("speed_rad_s",), _times(DEG, "speed_rad_s")),
    Mistake("electrical speed", ("speed_rad_s",), lambda c, p: c | {"speed_rad_s": p * c["speed_rad_s"]}),
    Mistake("speed of the opposite sign", ("speed_rad_s",), _times(-1.0, "speed_rad_s")),
    Mistake("electrical angle", ("theta_m_rad",), _wrapped),
    Mistake("angle in degrees", ("theta_m_rad",), _times(DEG, "theta_m_rad")),
    Mistake("angle in turns", ("theta_m_rad",), _times(1.0 / TURN, "theta_m_rad")),
    Mistake("angle taken for degrees", ("theta_m_rad",), _times(1.0 / DEG, "theta_m_rad")),
    Mistake("angle of the opposite sign", ("theta_m_rad",), _times(-1.0, "theta_m_rad")),
    Mistake(
        "angle and speed of the opposite sign",
        ("theta_m_rad", "speed_rad_s"),
        _times(-1.0, "theta_m_rad", "speed_rad_s"),
    ),
    Mistake("time in ms", (), _times(1e3, "t_s")),
    Mistake("time taken for ms", (), _times(1e-3, "t_s")),
    Mistake("currents in mA", (), _times(1e3, *CURRENTS)),
    Mistake("currents taken for mA", (), _times(1e-3, *CURRENTS)),
    Mistake("dq currents rms", DQ, _times(math.sqrt(0.5), *DQ)),
    Mistake("dq currents power-invariant", DQ, _times(math.sqrt(1.5), *DQ)),
    Mistake("all currents rms", (), _times(math.sqrt(0.5), *CURRENTS)),
    Mistake("phases a and b exchanged", ("ia_a", "ib_a"), _exchanged("ia_a", "ib_a")),
    Mistake("phases a and c exchanged", PHASES, _exchanged("ia_a", "ic_a")),
    Mistake("phase a of the opposite sign", ("ia_a",), _times(-1.0, "ia_a")),
    Mistake("voltages of the opposite sign", VOLTS, _times(-1.0, *VOLTS)),
    Mistake("vd and vq exchanged", VOLTS, _exchanged("vd_v", "vq_v")),
    Mistake("vq of the opposite sign", VOLTS, _times(-1.0, "vq_v")),
    Mistake("voltages in mV", VOLTS, _times(1e3, *VOLTS)),
    Mistake("voltages rms", VOLTS, _times(math.sqrt(0.5), *VOLTS)),
    Mistake("voltages from line to line", VOLTS, _times(math.sqrt(3.0), *VOLTS)),
    Mistake("load of the opposite sign", ("load_torque_nm",), _times(-1.0, "load_torque_nm")),
    Mistake("load in mN m", ("load_torque_nm",), _times(1e3, "load_torque_nm")),
)


def laas_bases() -> Iterator[Base]:
    for name in ("acc_current", "rolling_1", "speed_test"):
        names = ("t_s", "theta_m_rad", "speed_rad_s", "iq_a")
        record = read_csv(REAL / f"{name}.csv.gz", names, ("",) * len(names))
        yield Base(f"LAAS {name}", {key: np.array(record[key]) for key in names}, 12)


def simulated_bases(count: int, folder: Path, seconds: float = 16.0, rate_hz: float = 1000.0) -> Iterator[Base]:
    rng = np.random.default_rng(20)
    number = 0
    while number < count:
        drive = draw_drive(rng)
        if drive.meta["pwm_hz"] % rate_hz or drive.controller["other.most_torque_per_ampere"]:
            continue
        nominal = nominal_of(drive)
        unit = draw_bench_unit(rng, drive, nominal)
        inputs = draw_inputs(rng, drive, seconds, 0.4 * drive.meta["motor"]["rated_torque_nm"])
        log = simulate(unit, inputs, round(drive.meta["pwm_hz"] / rate_hz))
        if not follows(log, drive):
            continue
        number += 1
        pairs = drive.meta["motor"]["pole_pairs"]
        signals = signals_of(log, pairs, rate_hz, drive.meta["encoder"]["counts_per_rev"])
        signals["theta_m_rad"] = signals["theta_rad"]
        names = {"t_s", *PHASES, *SETS["everything"]}
        model = folder / f"{number}_{MODEL}"
        model.write_text(model_text(f"drive_{number}", drive), encoding="utf-8")
        yield Base(f"drive {number}", {name: signals[name] for name in names}, pairs, str(model))


SPEED_SCALES = (
    "speed in r/min",
    "speed taken for r/min",
    "speed in turns per second",
    "speed in degrees per second",
    "electrical speed",
)
ANGLE_SCALES = ("electrical angle", "angle in degrees", "angle in turns", "angle taken for degrees")
TIME_SCALES = ("time in ms", "time taken for ms")
CURRENT_SCALES = ("currents in mA", "currents taken for mA", "all currents rms")
DQ_SCALES = ("dq currents rms", "dq currents power-invariant")
VOLT_SCALES = ("voltages in mV", "voltages rms", "voltages from line to line")


def leaves_a_trace(mistake: str, columns: Columns, model: str | None) -> bool:
    """Whether two columns, or a column and the model, contradict each other after this mistake."""
    if model is not None:
        return True
    both = {"theta_m_rad", "speed_rad_s"} <= set(columns)
    phases = {"id_a", "ia_a"} <= set(columns)
    wrapped = "theta_m_rad" in columns and np.ptp(columns["theta_m_rad"]) <= TURN
    turns_with_current = "id_a" not in columns and "ia_a" in columns
    if mistake in SPEED_SCALES or mistake in TIME_SCALES:
        return both
    if mistake in ANGLE_SCALES:
        return both or phases or turns_with_current or (wrapped and mistake != "electrical angle")
    if mistake in DQ_SCALES:
        return phases
    return mistake not in (*CURRENT_SCALES, *VOLT_SCALES, "load in mN m")


@dataclass
class Outcome:
    base: str
    given: str  # name of the set of columns, with or without a model
    mistake: str  # "" for none
    said: str  # the error, or a remark; "converted" where the log that comes out is the right one; "" for none of it
    trace: bool = True  # leaves_a_trace

    @property
    def detected(self) -> bool:
        return bool(self.said)


def cases_of(base: Base) -> Iterator[tuple[str, Columns, str | None]]:
    for name, wanted in SETS.items():
        if set(wanted) <= set(base.columns):
            columns = {key: base.columns[key] for key in ("t_s", *wanted)}
            yield name, columns, None
            if base.model is not None:
                yield f"{name}, model", columns, base.model


def outcomes(
    base: Base, folder: Path, only: Callable[[str, str], bool] = lambda given, mistake: True
) -> Iterator[Outcome]:
    for given, columns, model in cases_of(base):
        if only(given, ""):
            said, _ = reading(columns, base.pole_pairs, model, folder)
            yield Outcome(base.name, given, "", said)
        for mistake in MISTAKES:
            if not set(mistake.needs) <= set(columns) or not only(given, mistake.name):
                continue
            said, iq = reading(mistake.change(columns, base.pole_pairs), base.pole_pairs, model, folder)
            if not said and "iq_a" not in columns and iq is not None:
                right = base.columns["iq_a"]
                said = "converted" if np.std(iq - right) < 0.1 * np.std(right) else ""
            yield Outcome(base.name, given, mistake.name, said, leaves_a_trace(mistake.name, columns, model))


def reading(columns: Mapping[str, Array], pole_pairs: int, model: str | None, folder: Path) -> tuple[str, Array | None]:
    """What `evenspin gap` says before it begins to work, "" when it takes the log; and the current that it takes."""
    from evenspin.balance.log_reader import read_log
    from evenspin.balance.nominal_model import read_nominal
    from evenspin.balance.plausibility import check_against
    from evenspin.cli.log import check_log, write_log
    from evenspin.driven import serves
    from evenspin.driven.read import read_logs
    from evenspin.importer import ColumnMap, import_table
    from evenspin.importer import Mapping as Map
    from evenspin.importer.table import RawColumn, RawTable

    file = folder / "log.csv"
    try:
        if "iq_a" in columns:
            write_log(columns, file)
            log = read_log(file)
        else:
            table = RawTable(
                file, "text", tuple(RawColumn(name, "", values) for name, values in columns.items()), None, ()
            )
            units = {"t_s": "s", "theta_m_rad": "rad"}
            maps = {name: ColumnMap(name, units.get(name, "A"), 1.0, 0.0, "") for name in columns}
            write_log(import_table(table, Map(maps, pole_pairs=pole_pairs)).columns, file)
            check_log(file, file)
            log = read_log(file)
        remarks: tuple[str, ...] = log.doubts
        if model is not None and serves([file], model):
            remarks = read_logs([file], model)[0].doubts
        elif model is not None:
            names = ("t_s", "iq_a", "theta_m_rad", "speed_rad_s")
            motion = {name: getattr(log, name) for name in names}
            remarks = (*remarks, *check_against(file, {**motion, **log.beside}, read_nominal(model)))
    except EvenspinError as error:
        return str(error).replace(str(file), "log"), None
    return "".join(f"remark: {text}" for text in remarks[:1]), log.iq_a


def table_of(found: list[Outcome]) -> str:
    """Detected of all, by mistake and by what was given."""
    wrong = [o for o in found if o.mistake]
    sets = list(dict.fromkeys(o.given for o in wrong))
    lines = []
    for name in dict.fromkeys(o.mistake for o in wrong):
        own = [o for o in wrong if o.mistake == name]
        own = [o for o in own if o.trace] or own
        cells = [(s, [o.detected for o in own if o.given == s]) for s in sets]
        missed = ", ".join(f"{s} {cell.count(False)}/{len(cell)}" for s, cell in cells if cell.count(False))
        lines.append(f"{name:42s} {sum(o.detected for o in own):3d} of {len(own):3d}   missed: {missed or '-'}")
    false = [o for o in found if not o.mistake and o.detected]
    for trace, words in (
        (True, "that leave a trace"),
        (False, "that leave none: another unit, and nothing to hold it against"),
    ):
        own = [o.detected for o in wrong if o.trace == trace]
        lines.append(f"mistakes {words}: {sum(own)} of {len(own)} seen ({100.0 * np.mean(own):.1f} %)")
    lines.append(f"right logs refused or remarked on: {len(false)} of {sum(not o.mistake for o in found)}")
    lines += [f"  {o.base}, {o.given}: {o.said[:170]}" for o in false]
    return "\n".join(lines)


if __name__ == "__main__":
    drives = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        everything = [o for base in (*laas_bases(), *simulated_bases(drives, place)) for o in outcomes(base, place)]
    print(table_of(everything))
