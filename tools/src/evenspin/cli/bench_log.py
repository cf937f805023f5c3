"""`evenspin bench capture|record|convert|plan|run|soak`: what leaves files."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from evenspin.cli.bench_port import PortOption, connected
from evenspin.cli.options import JsonFile, OutFolder
from evenspin.cli.output import check_json_file, command_line, console, write_json

if TYPE_CHECKING:
    from evenspin.bench import Capture, Drive

SIGNALS = ("speed_ref_rad_s", "speed_rad_s", "theta_m_rad", "id_a", "iq_ref_a", "iq_a", "vd_v", "vq_v")
SignalsOption = Annotated[
    list[str] | None,
    typer.Option("--signal", metavar="NAME", help="Several times; default: speed, currents, voltages."),
]
SpeedOption = Annotated[
    float | None,
    typer.Option("--speed", metavar="RAD_S", help="Turn at this speed meanwhile; the motor stops at the end."),
]


def register(app: typer.Typer) -> None:
    for command in (capture, record, convert, plan, run, soak):
        app.command(command.__name__)(command)


def capture(
    out: Annotated[Path, typer.Option("--out", metavar="FILE.csv", help="Is replaced.")],
    port: PortOption = None,
    signal: SignalsOption = None,
    rows: Annotated[int | None, typer.Option(min=1, help="Default: as many as fit.")] = None,
    pre: Annotated[int, typer.Option(min=0, help="Rows before the trigger.")] = 0,
    decimation: Annotated[int, typer.Option(min=1, max=65535, help="PWM periods per row.")] = 1,
    trigger: Annotated[
        str, typer.Option(metavar="WHEN", help="now, fault, SIGNAL>LEVEL, SIGNAL<LEVEL or SIGNAL=LEVEL (either way).")
    ] = "now",
    seconds: Annotated[float, typer.Option(min=0.0, help="How long to wait for the trigger.")] = 10.0,
    speed: SpeedOption = None,
    json_file: JsonFile = None,
) -> None:
    """Signals at the full rate, held in the drive's memory around a trigger: CSV, time in s from the trigger.

    Example: `evenspin bench capture --signal iq_a --signal vq_v --trigger "iq_a>2" --pre 200 --speed 30 --out step.csv`
    """
    from evenspin.sim.progress import progress_bar

    check_json_file(json_file)
    names = tuple(signal or SIGNALS)
    with connected(port) as drive:
        options = _trigger(drive, trigger)
        wanted = rows if rows is not None else drive.capture_rows(len(names))
        drive.arm_capture(names, rows=wanted, pre=pre, decimation=decimation, **options)
        if speed is not None:
            drive.run_speed(speed)
        with progress_bar("capture", 1.0) as bar:
            taken = drive.read_capture(seconds + wanted * decimation / drive.info.pwm_hz, progress=bar.update)
    write_capture(out, taken)
    if json_file is not None:
        content = {"rows": len(taken.values), "pre": taken.pre, "first": taken.first, "trigger": taken.trigger}
        write_json(content | {"signals": list(taken.names), "file": str(out)}, json_file)
    console(json_file).print(f"{out}", style="bold")


def _trigger(drive: Drive, word: str) -> dict[str, Any]:
    from evenspin.bench import Trigger
    from evenspin.errors import InputError

    if word in ("now", "fault"):
        return {"trigger": Trigger.IMMEDIATE if word == "now" else Trigger.FAULT}
    for mark, kind in ((">", Trigger.RISING), ("<", Trigger.FALLING), ("=", Trigger.EITHER)):
        name, found, level = word.partition(mark)
        if found:
            drive.schema.signal_numbers([name])
            with contextlib.suppress(ValueError):
                return {"trigger": kind, "signal_name": name, "level": float(level)}
    raise InputError("bench capture", "--trigger", word, "now, fault, or SIGNAL>LEVEL", 'for example "iq_a>2"')


def write_capture(path: Path, taken: Capture) -> None:
    """A CSV with the time from the trigger."""
    import numpy as np

    from evenspin.log import write_csv

    write_csv(path, ("t_s", *taken.names), np.column_stack((taken.t_s, taken.values.astype(float))))


def record(
    out: OutFolder,
    port: PortOption = None,
    signal: SignalsOption = None,
    rate: Annotated[float, typer.Option(metavar="HZ", help="10000 Hz over a whole number.")] = 1000.0,
    seconds: Annotated[float, typer.Option(min=0.0, help="For how long; 0: until Ctrl-C.")] = 0.0,
    speed: SpeedOption = None,
    json_file: JsonFile = None,
) -> None:
    """Record a stream: raw.mcap while it runs (it survives a crash), then a CSV. Ctrl-C ends it and stops the motor.

    Example: `evenspin bench record --speed 30 --seconds 10 --out out/recording`
    """
    from evenspin.bench.raw import RawWriter, read_raw
    from evenspin.log import OutputFolder, write_csv
    from evenspin.sim.progress import progress_bar

    check_json_file(json_file)
    names = tuple(signal or SIGNALS)
    output = OutputFolder(out, command_line("bench", "record", "--out", "DIR"))
    working = out.absolute().parent / f"{out.name}.raw.mcap"  # outside: it must survive when this program does not
    with connected(port, reconnect_s=10.0) as drive:
        units = [drive.signals[name].unit for name in names if name in drive.signals]
        with drive.stream(names, rate_hz=rate) as stream:
            working.parent.mkdir(parents=True, exist_ok=True)
            source = f"{drive.info.name} {drive.info.firmware} schema {drive.info.schema:08x}"
            with (
                RawWriter(working, names, units, stream.decimation, drive.info.pwm_hz, source) as raw,
                progress_bar("recording", seconds or 3600.0) as bar,
                contextlib.suppress(KeyboardInterrupt),
            ):
                if speed is not None:
                    drive.run_speed(speed)
                rows_wanted = seconds * drive.info.pwm_hz / stream.decimation if seconds else float("inf")
                rows = 0
                while rows < rows_wanted:
                    block = stream.read()
                    if block is not None:
                        raw.write(block)
                        rows += len(block)
                        bar.update(rows * stream.decimation / drive.info.pwm_hz)
            lost, reconnects = stream.lost_rows, stream.reconnects
    recording = read_raw(working)
    with output as folder:
        working.replace(folder / "raw.mcap")
        write_csv(folder / "recording.csv", recording.record.names, recording.record.values)
    if json_file is not None:
        write_json({"rows": len(recording.record), "lost_rows": lost, "reconnects": reconnects}, json_file)
    screen = console(json_file)
    screen.print(f"{len(recording.record)} rows, {lost} lost, {reconnects} reconnects")
    screen.print(f"{out}/recording.csv", style="bold")


def convert(
    raw: Annotated[Path, typer.Argument(metavar="RAW.mcap", help="Also one that broke off.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE.csv", help="Is replaced.")],
    json_file: JsonFile = None,
) -> None:
    """A raw recording as CSV, as far as it was written.

    Example: `evenspin bench convert out/recording.raw.mcap --out rescued.csv`
    """
    from evenspin.bench.raw import read_raw
    from evenspin.log import write_csv

    check_json_file(json_file)
    recording = read_raw(raw)
    write_csv(out, recording.record.names, recording.record.values)
    if json_file is not None:
        content = {"rows": len(recording.record), "lost_rows": recording.lost_rows, "whole": recording.whole}
        write_json(content | {"source": recording.source}, json_file)
    screen = console(json_file)
    screen.print(f"{len(recording.record)} rows{'' if recording.whole else ', the file broke off'}")
    screen.print(f"{out}", style="bold")


def plan(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A model file .toml, or a built-in model.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE.toml", help="Is replaced.")],
    top_speed: Annotated[
        float | None, typer.Option("--top-speed", metavar="RAD_S", help="Default: from the model's voltage.")
    ] = None,
) -> None:
    """Write the experiment list of the gap workflow for a motor, to look at, to change, and to run.

    Example: `evenspin bench plan guo2024 --out experiments.toml`
    """
    from evenspin.bench.experiments import experiments_toml, plan
    from evenspin.errors import InputError
    from evenspin.model.machine import find_model, load_machine

    machine = load_machine(
        find_model(model, Path(), lambda must, hint: InputError("bench plan", "MODEL", model, must, hint))
    )
    experiments = plan(machine, top_speed)
    out.write_text(experiments_toml(machine.name, model, experiments), encoding="utf-8")
    screen = console()
    for experiment in experiments:
        needs = ["load machine"] * experiment.needs_load_machine + ["locked rotor"] * experiment.rotor_locked
        screen.print(f"{experiment.name:18} {experiment.duration_s:6.2f} s  {', '.join(needs)}")
    screen.print(f"{out}", style="bold")


def run(
    experiments: Annotated[Path, typer.Argument(metavar="EXPERIMENTS.toml", help="`evenspin bench plan` writes one.")],
    out: OutFolder,
    port: PortOption = None,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="NAME", help="Only this one; several times.")
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would be done; nothing moves.")] = False,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before the motor moves.")] = False,
    json_file: JsonFile = None,
) -> None:
    """Perform a list of experiments; leaves a case folder for `evenspin gap` and `evenspin compare`.

    The motor turns in both directions, and stops at the end, at Ctrl-C, and when the link breaks.

    Example: `evenspin bench run experiments.toml --port sim:guo2024 --out out/case`
    """
    import shutil
    from dataclasses import replace

    from evenspin.bench.experiments import read_experiments
    from evenspin.bench.hand import hand_for
    from evenspin.bench.runner import how_to_log, perform
    from evenspin.errors import InputError, did_you_mean
    from evenspin.log import OutputFolder, write_case
    from evenspin.sim.progress import progress_bar

    check_json_file(json_file)
    wanted = read_experiments(experiments)
    names = [experiment.name for experiment in wanted.experiments]
    for name in only or []:
        if name not in names:
            raise InputError("bench run", "--only", name, "an experiment of the list", did_you_mean(name, names))
    if only:
        wanted = replace(wanted, experiments=tuple(e for e in wanted.experiments if e.name in only))
    total_s = sum(experiment.duration_s for experiment in wanted.experiments)
    screen = console(json_file)
    output = OutputFolder(out, command_line("bench", "run", str(experiments), "--out", "DIR"))
    with connected(port) as drive:
        hand = hand_for(drive.link.transport, lambda request: yes or typer.confirm(request, err=True))
        if dry_run:
            for experiment in wanted.experiments:
                way = how_to_log(drive, experiment)
                needs = ["load machine"] * experiment.needs_load_machine + ["locked rotor"] * experiment.rotor_locked
                by = "captures" if way.captures else "stream"
                screen.print(f"{experiment.name:18} {experiment.duration_s:6.2f} s, {by} at {way.rate_hz:g} Hz "
                             f"{', '.join(needs)} {way.note}")  # fmt: skip
            return
        virtual = hand.has_load_machine  # only a virtual drive has one that a program moves
        question = "The motor is going to turn in both directions. Go on?"
        if not virtual and not yes and not typer.confirm(question, err=True):
            raise typer.Exit(1)
        raw = out.absolute().parent / f"{out.name}.raw"  # outside: it must survive when this program does not
        raw.mkdir(parents=True, exist_ok=True)
        with progress_bar("experiments", total_s) as bar:
            done = perform(drive, hand, wanted, lambda name, seconds: bar.update(seconds), screen.print, raw)
    with output as folder:
        write_case(folder, done.meta, done.records)
        shutil.move(raw, folder / "raw")
    if json_file is not None:
        content = {name: len(record) for name, record in done.records.items()}
        write_json({"case": str(out), "rows": content, "left_out": dict(done.left_out)}, json_file)
    for name, record in done.records.items():
        screen.print(f"{name:18} {len(record):6} rows, {done.meta['log_rate_hz'][name]:g} Hz")
    screen.print(f"{out}", style="bold")
    if done.ended_by is not None:
        screen.print(f"The list ended early, after {len(done.records)} of {len(wanted.experiments)}; they are kept.")
        raise done.ended_by


def soak(
    port: PortOption = None,
    seconds: Annotated[float, typer.Option(min=1.0)] = 600.0,
    rate: Annotated[float, typer.Option(metavar="HZ")] = 1000.0,
    speed: SpeedOption = None,
    json_file: JsonFile = None,
) -> None:
    """Stream 8 signals and count what is lost. Exit status 1 when a single sample is.

    Example: `evenspin bench soak --seconds 60`
    """
    import time

    from evenspin.bench.errors import LostSamplesError
    from evenspin.sim.progress import progress_bar

    check_json_file(json_file)
    with connected(port) as drive:
        if speed is not None:
            drive.run_speed(speed)
        began_s = time.monotonic()
        with drive.stream(SIGNALS, rate_hz=rate) as stream, progress_bar("soak", seconds) as bar:
            wanted = round(seconds * drive.info.pwm_hz / stream.decimation)
            rows = 0
            while rows < wanted:
                block = stream.read(2.0)
                if block is None:
                    raise LostSamplesError(f"soak: no rows for 2 s, after {rows}")
                rows += len(block)
                bar.update(rows * stream.decimation / drive.info.pwm_hz)
            took_s = time.monotonic() - began_s
            now = drive.state()
            content = {
                "rows": rows,
                "signals": len(SIGNALS),
                "lost_rows": stream.lost_rows,
                "lost_frames": stream.lost_frames,
                "lost_in_drive": now.stream_lost,
                "bad_frames": now.frames_bad + drive.link.bad_frames,
                "octets_lost": now.octets_lost,
                "drive_s": rows * stream.decimation / drive.info.pwm_hz,
                "took_s": round(took_s, 3),
            }
    if json_file is not None:
        write_json(content, json_file)
    console(json_file).print(", ".join(f"{key} {value:g}" for key, value in content.items()))
    if content["lost_rows"] or content["lost_in_drive"] or content["octets_lost"]:
        raise LostSamplesError(f"soak: {content['lost_rows']} rows were lost of {rows}")
