"""`evenspin bench capture`, and the file that holds a capture."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from evenspin.cli.bench_port import PortOption, connected
from evenspin.cli.options import Force, JsonFile, SignalsOption, SpeedOption
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, json_text, write_json

if TYPE_CHECKING:
    from evenspin.bench import Capture, Drive
    from evenspin.bench.watch import Happened

SIGNALS = ("speed_ref_rad_s", "speed_rad_s", "theta_m_rad", "id_a", "iq_ref_a", "iq_a", "vd_v", "vq_v")
NOW, ON_FAULT = "now", "fault"


def register(app: typer.Typer) -> None:
    app.command("capture")(capture)


def capture(
    out: Annotated[Path, typer.Option("--out", metavar="FILE.csv", help="A new file; FILE.csv.json says more.")],
    port: PortOption = None,
    signal: SignalsOption = None,
    rows: Annotated[int | None, typer.Option(min=1, help="Default: as many as fit.")] = None,
    pre: Annotated[int, typer.Option(min=0, help="Rows before the trigger.")] = 0,
    decimation: Annotated[int, typer.Option(min=1, max=65535, help="PWM periods per row.")] = 1,
    trigger: Annotated[
        str,
        typer.Option(metavar="WHEN", help="now, fault, SIGNAL>LEVEL, SIGNAL<LEVEL or SIGNAL=LEVEL (either direction)."),
    ] = NOW,
    seconds: Annotated[float, typer.Option(min=0.0, help="How long to wait for the trigger.")] = 10.0,
    speed: SpeedOption = None,
    fetch: Annotated[
        bool, typer.Option("--fetch", help="Only fetch the capture that the drive still holds; nothing moves.")
    ] = False,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Signals at the full rate, held in the drive's memory around a trigger: CSV, time in s from the trigger.

    Exit status 1 when the drive trips meanwhile, unless the trip is what was waited for (--trigger fault).

    Example: `evenspin bench capture --signal iq_a --signal vq_v --trigger "iq_a>2" --pre 200 --speed 30 --out step.csv`
    """
    from evenspin.bench.errors import DriveFaultError, RefusedError
    from evenspin.bench.kept import RAW, beside, keeping, refuse_rescued
    from evenspin.bench.watch import Watch
    from evenspin.sim.progress import progress_bar

    check_json_file(json_file)
    if fetch:
        chosen = {"--signal": signal, "--rows": rows, "--pre": pre, "--speed": speed}
        _refuse_with_fetch(chosen | {"--trigger": trigger if trigger != NOW else None,
                                     "--decimation": decimation if decimation != 1 else None})  # fmt: skip
    files = CaptureFiles(out, force)
    raw = beside(out, RAW)
    refuse_rescued(raw, force)
    names = tuple(signal or SIGNALS)
    with connected(port) as drive, keeping(raw, lambda: _still_there(drive, out)):
        watch = Watch(drive)
        wanted = 0
        if not fetch:
            options = _trigger(drive, trigger)
            wanted = rows if rows is not None else drive.capture_rows(len(names))
            drive.arm_capture(names, rows=wanted, pre=pre, decimation=decimation, **options)
        if speed is not None:
            drive.run_speed(speed)
        try:
            with progress_bar("capture", 1.0) as bar:
                taken = drive.read_capture(seconds + wanted * decimation / drive.info.pwm_hz, progress=bar.update)
        except RefusedError as error:
            watch.close(0)
            if watch.trip is None:
                raise
            raise DriveFaultError(f"{error}; the drive tripped meanwhile: {watch.trip.text}") from None
        watch.close(taken.trigger)
        files.write(raw, taken, drive, watch.all)
    if json_file is not None:
        content = {"rows": len(taken.values), "pre": taken.pre, "first": taken.first, "trigger": taken.trigger}
        events = events_of(taken, watch.all)
        write_json(content | {"signals": list(taken.names), "file": str(out), "events": events}, json_file)
    screen = console(json_file)
    trip = watch.trip
    if trip is not None:
        at_s = (trip.counter - taken.trigger) / taken.pwm_hz
        screen.print(f"{len(taken.values)} rows; THE DRIVE TRIPPED {at_s:.4f} s from the trigger: {trip.text}")
    screen.print(f"{out}", style="bold")
    if trip is not None and trigger != ON_FAULT and not fetch:
        raise DriveFaultError(f"bench capture: {out} is complete, but the drive tripped: {trip.fault}")


class CaptureFiles:
    """A CSV, and beside it what a CSV cannot say. Nothing that was measured is replaced."""

    def __init__(self, path: Path, force: bool) -> None:
        from evenspin.output import OutputFile

        made = origin()
        self.table = OutputFile(path, made, recording=True, force=force)
        self.facts = OutputFile(path.with_name(f"{path.name}.json"), made, recording=True, force=force)

    def write(self, raw: Path, taken: Capture, drive: Drive, happened: list[Happened]) -> None:
        """Through a raw file, which goes when both are there."""
        import numpy as np

        from evenspin.bench.kept import room_for
        from evenspin.bench.recorder import source_facts, source_of, write_raw_capture
        from evenspin.log import write_csv
        from evenspin.output.manifest import describe, hash_of

        with room_for(raw):
            write_raw_capture(raw, taken, source_of(drive), happened)
        with self.table as place:
            write_csv(place, ("t_s", *taken.names), np.column_stack((taken.t_s, taken.values.astype(float))))
            known = {self.table.path.name: hash_of(place)}
        facts: dict[str, Any] = {"rows": len(taken.values), "pre": taken.pre, "decimation": taken.decimation}
        facts |= {
            "pwm_hz": taken.pwm_hz,
            "units": dict(zip(taken.names, taken.units, strict=True)),
            "events": events_of(taken, happened),
        }
        content = describe(self.table.origin, known, recording=True)
        self.facts.write(json_text(content | {"source": dict(source_facts(drive)), "recorded": facts}))
        raw.unlink(missing_ok=True)


def events_of(taken: Capture, happened: list[Happened]) -> list[dict[str, Any]]:
    """With the time from the trigger."""
    return [{"t_s": (each.counter - taken.trigger) / taken.pwm_hz, **each.as_json()} for each in happened]


def _trigger(drive: Drive, word: str) -> dict[str, Any]:
    from evenspin.bench import Trigger
    from evenspin.errors import InputError

    if word in (NOW, ON_FAULT):
        return {"trigger": Trigger.IMMEDIATE if word == NOW else Trigger.FAULT}
    for mark, kind in ((">", Trigger.RISING), ("<", Trigger.FALLING), ("=", Trigger.EITHER)):
        name, found, level = word.partition(mark)
        if found:
            drive.schema.signal_numbers([name])
            with contextlib.suppress(ValueError):
                return {"trigger": kind, "signal_name": name, "level": float(level)}
    raise InputError("bench capture", "--trigger", word, "now, fault, or SIGNAL>LEVEL", 'for example "iq_a>2"')


def _refuse_with_fetch(given: dict[str, object]) -> None:
    from evenspin.errors import InputError

    for option, value in given.items():
        if value:
            raise InputError("bench capture", option, value, "left out with --fetch", "the drive has captured already")


def _still_there(drive: Drive, out: Path) -> str:
    """What the memory of a drive still holds when nothing of it came to a file."""
    import shlex

    from evenspin.bench.transport import LocalTransport

    if isinstance(drive.link.transport, LocalTransport):  # it ends with this program
        return ""
    command = f"evenspin bench capture --fetch --port {shlex.quote(drive.port)} --out {shlex.quote(str(out))}"
    return f"a complete capture stays in the drive until the next one or a reset: `{command}`"
