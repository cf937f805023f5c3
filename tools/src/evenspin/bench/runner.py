"""Perform a list of experiments and leave a case folder that `evenspin gap` and `evenspin compare` take as it is.

A record begins at the first tick of the speed loop after the start, at rest, and ends before the stop; its rows stand
at fixed PWM periods, and the torque of the load machine is put beside them by the period in which it changed. The drive
runs the controller that the log format describes (PI, tracking filter, speed loop inside the current interrupt); what
it had before is put back at the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.bench.client import Drive
from evenspin.bench.errors import DriveFaultError, LeftOutError, LostSamplesError
from evenspin.bench.experiments import ExperimentList
from evenspin.bench.numbers import Mode, State, Trigger
from evenspin.bench.operator import Operator
from evenspin.bench.raw import RawWriter
from evenspin.bench.recorder import raw_writer
from evenspin.bench.stream import Block
from evenspin.bench.watch import Watch, trip_of
from evenspin.errors import EvenspinError, InputError
from evenspin.log.columns import LOG_COLUMNS, LOG_UNITS
from evenspin.log.controller import FORMAT_CONTROLLER
from evenspin.log.experiments import CURVES, Experiment
from evenspin.log.meta import meta_of
from evenspin.model import Setup
from evenspin.native import tables
from evenspin.sim.record import Record

STREAMED = tuple(name for name in LOG_COLUMNS if name not in ("t_s", "load_torque_nm"))
CAPTURED = ("id_ref_a", "iq_ref_a", "id_a", "iq_a", "ia_a", "ib_a", "vd_v", "vq_v")  # of a locked rotor; 8 fit
# Beside what the format describes: a drive on a bench may have changed these.
LOG_CONTROLLER = {**FORMAT_CONTROLLER, "observer_hold": "false", "voltage_limit_v": "0"}
SETPOINT_S = 0.005  # between two points of a ramp
SYNC_S = 0.1
LINE_LOAD = 0.9  # of a serial line, for a stream
STREAM_OCTETS_S = 150e3  # of any link: the drive begins one frame in a pass of its main loop, and other work needs some
RATES_HZ = (2000.0, 1000.0, 500.0)
REST_RAD_S = 0.5
REST_S, REST_MAX_S = 0.3, 20.0
FRAME_VALUES, FRAME_REST = 60, 16  # of a stream frame: float32 in it, octets beside them

Progress = Callable[[str, float], None]  # name of the experiment, seconds of all that are done
Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Performed:
    """Records by name, what meta.json says, what was left out with its reason, and what ended the list early."""

    records: Mapping[str, Record]
    meta: Mapping[str, Any]
    left_out: Mapping[str, str]
    ended_by: BaseException | None


def perform(
    drive: Drive, operator: Operator, what: ExperimentList, progress: Progress, say: Say, raw: Path | None = None
) -> Performed:
    """Do them all. A fault, a lost link or Ctrl-C ends the list: a person must check first. What is complete is kept.

    `raw`: a folder for NAME.mcap of each experiment, written while it runs.
    """
    records: dict[str, Record] = {}
    left_out: dict[str, str] = {}
    rates: dict[str, float] = {}
    logged_by: dict[str, str] = {}
    ended_by: BaseException | None = None
    ended_in = ""
    tripped: dict[str, Any] | None = None
    done_s = 0.0
    with _log_controller(drive, say) as parameters:
        for experiment in what.experiments:
            progress(experiment.name, done_s)
            try:
                if experiment.needs_load_machine and not operator.has_load_machine:
                    raise LeftOutError("it needs a load machine")
                logging = how_to_log(drive, experiment)
                if logging.note:
                    say(f"{experiment.name}: {logging.note}")

                def advance(seconds: float, name: str = experiment.name, before_s: float = done_s) -> None:
                    progress(name, before_s + seconds)

                if logging.captures:
                    records[experiment.name] = _by_captures(drive, operator, experiment, logging.rate_hz, advance, raw)
                else:
                    records[experiment.name] = _by_stream(drive, operator, experiment, logging.rate_hz, advance, raw)
                rates[experiment.name] = logging.rate_hz
                logged_by[experiment.name] = "captures" if logging.captures else "stream"
            except LeftOutError as error:
                left_out[experiment.name] = str(error)
                say(f"{experiment.name}: left out: {error}")
            except (EvenspinError, KeyboardInterrupt) as error:
                tripped = trip_of(drive)
                ended_by = error if tripped is None else DriveFaultError(f"{experiment.name}: {tripped['said']}")
                ended_in = experiment.name
                if not records:
                    raise ended_by from error
                break
            done_s += experiment.duration_s
    if not records:
        raise InputError("bench run", "experiments", len(what.experiments), "at least one that this bench can do",
                         "a load machine or another list")  # fmt: skip
    meta = _meta(drive, what, parameters, list(records))
    switched = {e.name: e.current_from_s for e in what.experiments if e.current_from_s is not None}
    meta |= {"current_mode_from_s": switched, "log_rate_hz": rates, "logged_by": logged_by, "left_out": left_out}
    if ended_by is not None:
        text = str(ended_by) or "interrupted"
        meta["ended_by"] = text if text.startswith(ended_in) else f"{ended_in}: {text}"
    if tripped is not None:
        meta["tripped"] = {"experiment": ended_in, **{key: tripped[key] for key in ("t_s", "fault", "text")}}
    return Performed(records, meta, left_out, ended_by)


# ---- what the line can carry


@dataclass(frozen=True, slots=True)
class Logging:
    """How an experiment is logged. `note`: what the person has to know."""

    rate_hz: float
    captures: bool
    note: str


def stream_octets_s(signals: int, rate_hz: float) -> float:
    """What a stream puts on the wire: frames are as full as whole rows allow, but go every 20 ms at least."""
    rows = max(1, min(FRAME_VALUES // signals, int(0.020 * rate_hz)))
    return rate_hz / rows * (FRAME_REST + 4 * signals * rows)


def how_to_log(drive: Drive, experiment: Experiment) -> Logging:
    """A stream at the wanted rate when the link carries it; else captures step by step, or a lower rate."""
    line = drive.link.transport.octets_per_s
    room = min(STREAM_OCTETS_S, LINE_LOAD * line if line is not None else STREAM_OCTETS_S)
    need = stream_octets_s(len(STREAMED), experiment.log_rate_hz)
    if need <= room:
        return Logging(experiment.log_rate_hz, False, "")
    why = (
        f"{len(STREAMED)} signals at {experiment.log_rate_hz:g} Hz are {need / 1000:.0f} kB/s, the link carries "
        f"{room / 1000:.0f} kB/s"
    )
    if experiment.rotor_locked and experiment.mode == "current":
        return Logging(experiment.log_rate_hz, True, f"{why}: each step is captured in the drive and fetched after it")
    for rate_hz in RATES_HZ:
        if rate_hz < experiment.log_rate_hz and stream_octets_s(len(STREAMED), rate_hz) <= room:
            return Logging(rate_hz, False, f"{why}: logged at {rate_hz:g} Hz")
    raise InputError("bench run", "--port", drive.port, "a line of 300000 baud or more", why)


# ---- one experiment


def _by_stream(
    drive: Drive,
    operator: Operator,
    experiment: Experiment,
    rate_hz: float,
    progress: Callable[[float], None],
    raw: Path | None,
) -> Record:
    _prepare(drive, operator, experiment)
    if experiment.mode == "current":
        drive.setpoint(Mode.CURRENT)  # the first step comes when rows do
    blocks: list[Block] = []
    with ExitStack() as open_files, drive.stream(STREAMED, rate_hz=rate_hz) as stream:
        writer = None
        if raw is not None:
            file = raw_writer(drive, raw, experiment.name, STREAMED, stream.decimation)
            writer = open_files.enter_context(file)
        started = _start(drive)
        watch = Watch(drive)
        first = _next_tick(drive, started)
        if experiment.needs_load_machine:
            operator.load(experiment.value("load_torque_nm", 0.0))

        def keep(block: Block) -> None:
            blocks.append(block)
            if writer is not None:
                writer.write(block)
                for happened in watch.new_events(int(block.counters[-1])):
                    writer.event(happened.counter, happened.as_json())

        def collect() -> None:
            while (block := stream.read(0.0)) is not None:
                keep(block)

        _command_through(drive, operator, experiment, first, collect, progress)
        end = first + round(experiment.duration_s * drive.info.pwm_hz)
        while not blocks or int(blocks[-1].counters[-1]) < end:
            block = stream.read(1.0)
            if block is None:
                drive.need_no_fault()
                raise LostSamplesError(f"{experiment.name}: the stream ended early; is the link disturbed?")
            keep(block)
        lost = stream.lost_rows
    _stop_motor(drive, operator)
    if lost:
        raise LostSamplesError(f"{experiment.name}: {lost} rows were lost; use a faster line or a quieter machine")
    counters = np.concatenate([block.counters for block in blocks])
    values = np.concatenate([block.values for block in blocks]).astype(np.float64)
    inside = (counters >= first) & (counters < end)
    columns = dict(zip(STREAMED, values[inside].T, strict=True))
    return _log(experiment, counters[inside], first, drive.info.pwm_hz, columns, operator)


def _by_captures(
    drive: Drive,
    operator: Operator,
    experiment: Experiment,
    rate_hz: float,
    progress: Callable[[float], None],
    raw: Path | None,
) -> Record:
    """A locked rotor in current mode: each step is captured whole, then fetched while the currents are zero.

    The windows are joined to one record. Between them nothing changes but the noise.
    """
    _prepare(drive, operator, experiment)
    decimation = max(1, round(drive.info.pwm_hz / rate_hz))
    with ExitStack() as open_files:
        writer = None
        if raw is not None:
            writer = open_files.enter_context(raw_writer(drive, raw, experiment.name, CAPTURED, decimation))
        parts = _windows(drive, experiment, rate_hz, decimation, progress, writer)
    standing = drive.read(("theta_m_rad", "vdc_v"))
    _stop_motor(drive, operator)
    table = dict(zip(CAPTURED, np.concatenate(parts).T, strict=True))
    rows = len(table["id_a"])
    fixed = {name: np.full(rows, standing[name]) for name in standing}
    still = {name: np.zeros(rows) for name in ("speed_ref_rad_s", "speed_rad_s")}
    counters = decimation * np.arange(rows, dtype=np.int64)
    return _log(experiment, counters, 0, drive.info.pwm_hz, {**table, **fixed, **still}, operator)


def _windows(
    drive: Drive,
    experiment: Experiment,
    rate_hz: float,
    decimation: int,
    progress: Callable[[float], None],
    writer: RawWriter | None,
) -> list[NDArray[np.float64]]:
    """One table for each step, as the drive captured it."""
    parts: list[NDArray[np.float64]] = []
    for at_s, next_s in capture_windows(experiment, drive.capture_rows(len(CAPTURED)) / rate_hz):
        rows = round((next_s - at_s) * rate_hz)
        watched = _watched(experiment, at_s)
        if at_s == 0.0:
            drive.arm_capture(CAPTURED, rows=rows, trigger=Trigger.RISING, signal_name="state",
                              level=State.RUN - 0.5, decimation=decimation)  # fmt: skip
            _start(drive)
        elif watched is None:
            drive.arm_capture(CAPTURED, rows=rows, decimation=decimation)
        else:
            drive.arm_capture(CAPTURED, rows=rows, trigger=Trigger.EITHER, signal_name=watched[0], level=watched[1],
                              decimation=decimation)  # fmt: skip
            _send(drive, experiment, at_s)
        taken = drive.read_capture()
        if writer is not None:
            writer.write(Block(taken.first, decimation, taken.pwm_hz, taken.values))
        parts.append(taken.values.astype(np.float64))
        progress(next_s)
    return parts


def capture_windows(experiment: Experiment, longest_s: float) -> list[tuple[float, float]]:
    """From step to step of the current references; a long pause is cut, for nothing happens in it."""
    changes = {0.0}
    for name in ("id_ref_a", "iq_ref_a"):
        curve = experiment.curves.get(name)
        if curve is not None:
            pairs = zip(curve.t_s[1:], curve.value, curve.value[1:], strict=False)
            changes |= {t for t, before, after in pairs if before != after}
    edges = [*sorted(t for t in changes if t < experiment.duration_s), experiment.duration_s]
    windows = []
    for start, end in zip(edges, edges[1:], strict=False):
        parts = math.ceil((end - start) / longest_s)
        cuts = [round(start + (end - start) * part / parts, 4) for part in range(parts + 1)]
        windows += list(zip(cuts, cuts[1:], strict=False))
    return windows


def _watched(experiment: Experiment, at_s: float) -> tuple[str, float] | None:
    """The reference that steps most, and the middle of its step; None: none does."""
    found = None
    largest = 0.0
    for name in ("id_ref_a", "iq_ref_a"):
        before, after = experiment.value(name, at_s - 1e-6), experiment.value(name, at_s)
        if abs(after - before) > largest:
            largest, found = abs(after - before), (name, 0.5 * (after + before))
    return found


def _prepare(drive: Drive, operator: Operator, experiment: Experiment) -> None:
    drive.need_no_fault()
    drive.find_zero()  # with a free shaft, and before the first row
    operator.lock(experiment.rotor_locked)
    drive.sleep(0.1 if experiment.rotor_locked else 0.3)
    _send(drive, experiment, 0.0)


def _start(drive: Drive) -> int:
    """The period after which the drive runs."""
    drive.events.clear()
    drive.start()
    drive.link.wait(lambda: any(event.state == State.RUN for event in drive.events), 0.5)
    for event in drive.events:
        if event.state == State.RUN:
            return event.counter
    raise DriveFaultError("start: the drive did not say when it began to run; is the link overloaded?")


def _next_tick(drive: Drive, started: int) -> int:
    """The first tick of the speed loop after the start."""
    divider = round(drive.get(["speed_divider"])["speed_divider"])
    return (started // divider + 1) * divider


def _command_through(
    drive: Drive,
    operator: Operator,
    experiment: Experiment,
    first: int,
    collect: Callable[[], None],
    progress: Callable[[float], None],
) -> None:
    """Send references and loads when they are due, by the drive's own time."""
    time = _DriveTime(drive, first)
    sent: tuple[float, ...] | None = None
    load_nm = experiment.value("load_torque_nm", 0.0)
    told_s = 0.0
    for t_s in _instants(experiment):
        while (wait_s := t_s - time.now_s()) > 0.0:
            drive.sleep(min(wait_s, 0.05))
            collect()
        wanted = _reference(experiment, t_s)
        if wanted != sent:
            _send(drive, experiment, t_s)
            sent = wanted
        if experiment.needs_load_machine and experiment.value("load_torque_nm", t_s) != load_nm:
            load_nm = experiment.value("load_torque_nm", t_s)
            operator.load(load_nm)
        collect()
        if t_s - told_s > 0.2:
            told_s = t_s
            progress(t_s)
    while time.now_s() < experiment.duration_s:
        drive.sleep(0.05)
        collect()


class _DriveTime:
    """Time of the drive since the start of a record. Asked for now and then: a virtual drive on a busy machine lags."""

    def __init__(self, drive: Drive, first: int) -> None:
        self._drive, self._first = drive, first
        self._sync()

    def _sync(self) -> None:
        now = self._drive.state()
        if now.state != State.RUN:
            self._drive.need_no_fault()
            raise DriveFaultError("the drive has stopped by itself; was the link silent for too long?")
        self._asked_s = self._drive.link.transport.clock()
        self._ahead_s = (now.counter - self._first) / self._drive.info.pwm_hz - self._asked_s

    def now_s(self) -> float:
        clock = self._drive.link.transport.clock
        if clock() - self._asked_s > SYNC_S:
            self._sync()
        return clock() + self._ahead_s


def _instants(experiment: Experiment) -> Iterator[float]:
    """When something is to be sent, and now and then when not, for progress."""
    times = set(np.arange(0.0, experiment.duration_s, 0.1).round(6).tolist())
    if experiment.current_from_s is not None:
        times.add(experiment.current_from_s)
    for curve in experiment.curves.values():
        times |= set(curve.t_s)
        if curve.linear:
            for start, end, low, high in zip(curve.t_s, curve.t_s[1:], curve.value, curve.value[1:], strict=False):
                if low != high:
                    times |= set(np.arange(start, end, SETPOINT_S).round(6).tolist())
    yield from sorted(t for t in times if t < experiment.duration_s)


def _reference(experiment: Experiment, t_s: float) -> tuple[float, ...]:
    current = experiment.mode == "current" or (
        experiment.current_from_s is not None and t_s >= experiment.current_from_s - 1e-9
    )
    return (float(current), *(experiment.value(name, t_s) for name in CURVES[:3]))


def _send(drive: Drive, experiment: Experiment, t_s: float) -> None:
    current, speed, id_a, iq_a = _reference(experiment, t_s)
    mode = Mode.CURRENT if current else Mode.SPEED
    drive.setpoint(mode, speed_rad_s=speed, id_a=id_a, iq_a=iq_a)


def _stop_motor(drive: Drive, operator: Operator) -> None:
    """Brake to a standstill, switch off, take the load away."""
    drive.need_no_fault()
    drive.setpoint(Mode.SPEED)
    clock = drive.link.transport.clock
    until_s, still_since_s = clock() + REST_MAX_S, clock()
    if operator.has_load_machine:
        operator.load(0.0)
    while clock() - still_since_s < REST_S:
        if abs(drive.read(("speed_rad_s",))["speed_rad_s"]) > REST_RAD_S:
            still_since_s = clock()
        if clock() > until_s:
            raise DriveFaultError("the motor does not come to rest; is the load machine off?")
        drive.sleep(0.02)
    drive.stop()
    drive.sleep(0.3)


# ---- the log


def _log(
    experiment: Experiment,
    counters: NDArray[np.int64],
    first: int,
    pwm_hz: float,
    columns: Mapping[str, NDArray[np.float64]],
    operator: Operator,
) -> Record:
    load_nm = np.full(len(counters), np.nan)
    if experiment.needs_load_machine:
        steps = operator.loads(first)
        at = np.searchsorted([period for period, _ in steps], counters, side="right") - 1
        load_nm = np.array([torque for _, torque in steps])[np.maximum(at, 0)]
    known = {"t_s": (counters - first) / pwm_hz, "load_torque_nm": load_nm, **columns}
    return Record(LOG_COLUMNS, LOG_UNITS, np.column_stack([known[name] for name in LOG_COLUMNS]))


def _meta(drive: Drive, what: ExperimentList, parameters: Mapping[str, float], names: Sequence[str]) -> dict[str, Any]:
    """Nominal motor of the model file, controller of the drive."""
    machine = what.machine
    setup = Setup(machine.name, machine.plant, parameters, {}, {}, (), 1.0, 1.0, 1)
    meta = meta_of(setup, what.name, names)
    meta["source"] = {
        "drive": drive.info.name,
        "firmware": drive.info.firmware,
        "numeric": drive.info.numeric,
        "schema": f"{drive.info.schema:08x}",
    }
    return meta


@contextmanager
def _log_controller(drive: Drive, say: Say) -> Iterator[dict[str, float]]:
    """The controller of the log format while it lasts; yields the parameters in force."""
    from evenspin.bench.client import parse_value

    wanted = {name: parse_value(drive.parameters[name], word) for name, word in LOG_CONTROLLER.items()}
    before = drive.get(list(wanted))
    drive.set(wanted)
    try:
        yield {**{name: field.default for name, field in tables().params.items()}, **drive.get()}
    finally:
        if not drive.link.lost:
            try:
                drive.stop()
                drive.set(before)
            except EvenspinError as error:  # what was recorded is worth more
                say(f"The drive may still have the controller of the log: {error}")
