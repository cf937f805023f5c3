"""Record a stream into a raw file, and notice what happens to the drive meanwhile."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evenspin.bench.client import Capture, Drive
from evenspin.bench.numbers import State
from evenspin.bench.raw import RawWriter
from evenspin.bench.stream import Block
from evenspin.bench.watch import Happened, Watch

ALIGN_POLL_S = 0.02


@dataclass(frozen=True, slots=True)
class Recorded:
    """`first`: the period of the first row; `happened`: changes of the drive's state, with a trip."""

    rows: int
    lost_rows: int
    reconnects: int
    first: int
    pwm_hz: float
    happened: Sequence[Happened]

    @property
    def trip(self) -> Happened | None:
        return next((each for each in self.happened if each.is_trip), None)

    def t_s(self, what: Happened) -> float:
        """From the first row."""
        return (what.counter - self.first) / self.pwm_hz

    def as_json(self) -> dict[str, Any]:
        """For a manifest and for scripts."""
        events = [{"t_s": self.t_s(each), **each.as_json()} for each in self.happened]
        trip = next((each for each in events if "fault" in each), None)
        content = {"rows": self.rows, "lost_rows": self.lost_rows, "reconnects": self.reconnects}
        return content | {"trip": trip, "events": events}


def record(
    drive: Drive,
    names: Sequence[str],
    raw: Path,
    *,
    rate_hz: float,
    seconds: float,
    speed_rad_s: float | None,
    progress: Callable[[float], None],
    tripped: Callable[[float, Happened], None],
) -> Recorded:
    """Until `seconds` have passed (0: until Ctrl-C). A drive that has to find its electrical zero aligns before the
    first row, which would be those of another motion. A trip does not end it; `tripped` is called at once, with the
    time from the first row."""
    first: int | None = None
    rows = last = 0
    if speed_rad_s is not None:
        _align(drive)
    with drive.stream(names, rate_hz=rate_hz) as stream:
        per_row_s = stream.decimation / drive.info.pwm_hz
        units = [drive.signals[name].unit for name in names]
        watch = Watch(drive)
        with RawWriter(raw, names, units, stream.decimation, drive.info.pwm_hz, source_of(drive)) as file:

            def note(happened: Sequence[Happened]) -> None:
                for each in happened:
                    file.event(each.counter, each.as_json())
                    if each.is_trip:
                        tripped((each.counter - (last if first is None else first)) / drive.info.pwm_hz, each)

            with contextlib.suppress(KeyboardInterrupt):
                if speed_rad_s is not None:
                    drive.run_speed(speed_rad_s)
                while not seconds or rows * per_row_s < seconds:
                    block = stream.read()
                    if block is not None:
                        first = block.counter if first is None else first
                        last = int(block.counters[-1])
                        file.write(block)
                        rows += len(block)
                        progress(rows * per_row_s)
                    note(watch.new_events(last))
            note(watch.close(last))
        return Recorded(
            rows, stream.lost_rows, stream.reconnects, first or 0, float(drive.info.pwm_hz), tuple(watch.all)
        )


def _align(drive: Drive) -> None:
    """A first start at rest, where the drive aligns at its first start."""
    if drive.state().state == State.RUN or not drive.get(("align_periods",))["align_periods"]:
        return
    drive.run_speed(0.0)
    while drive.state().state != State.RUN:
        drive.need_no_fault()
        drive.sleep(ALIGN_POLL_S)


def source_of(drive: Drive) -> str:
    return f"{drive.info.name} {drive.info.firmware} schema {drive.info.schema:08x}"


def raw_writer(drive: Drive, folder: Path, name: str, signals: Sequence[str], decimation: int) -> RawWriter:
    """NAME.mcap in this folder, for rows of this drive."""
    units = [drive.signals[signal].unit for signal in signals]
    pwm_hz = float(drive.info.pwm_hz)
    return RawWriter(folder / f"{name}.mcap", signals, units, decimation, pwm_hz, source_of(drive))


def write_raw_capture(path: Path, taken: Capture, source: str, happened: Sequence[Happened]) -> None:
    """A capture as a raw recording whose time counts from the trigger."""
    with RawWriter(path, taken.names, taken.units, taken.decimation, taken.pwm_hz, source, taken.trigger) as file:
        file.write(Block(taken.first, taken.decimation, taken.pwm_hz, taken.values))
        for each in happened:
            file.event(each.counter, each.as_json())


def source_facts(drive: Drive) -> Mapping[str, str]:
    """Where a recording comes from, for its manifest."""
    return {
        "port": drive.port,
        "drive": drive.info.name,
        "firmware": drive.info.firmware,
        "numeric": drive.info.numeric,
        "schema": f"{drive.info.schema:08x}",
    }
