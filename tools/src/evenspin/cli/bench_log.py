"""`evenspin bench record|convert|plan|run|soak`: what leaves files."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.bench_capture import SIGNALS
from evenspin.cli.bench_port import PortOption, connected
from evenspin.cli.options import Force, JsonFile, OutFolder, SignalsOption, SpeedOption
from evenspin.cli.origin import origin
from evenspin.cli.output import check_json_file, console, write_json


def register(app: typer.Typer) -> None:
    for command in (record, convert, plan, run, soak):
        app.command(command.__name__)(command)


def record(
    out: OutFolder,
    port: PortOption = None,
    signal: SignalsOption = None,
    rate: Annotated[float, typer.Option(metavar="HZ", help="10000 Hz over a whole number.")] = 1000.0,
    seconds: Annotated[float, typer.Option(min=0.0, help="For how long; 0: until Ctrl-C.")] = 0.0,
    speed: SpeedOption = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Record a stream: raw.mcap while it runs (it survives a crash), then a CSV. Ctrl-C ends it and stops the motor.

    Exit status 1 when the drive tripped meanwhile; the recording goes on to its end and is complete.

    Example: `evenspin bench record --speed 30 --seconds 10 --out out/recording`
    """
    from evenspin.bench.errors import DriveFaultError
    from evenspin.bench.kept import RAW, beside, keeping, refuse_rescued, room_for
    from evenspin.bench.raw import read_raw
    from evenspin.bench.recorder import record as record_stream
    from evenspin.bench.recorder import source_facts
    from evenspin.log import write_csv
    from evenspin.output import OutputFolder
    from evenspin.sim.progress import progress_bar

    check_json_file(json_file)
    names = tuple(signal or SIGNALS)
    output = OutputFolder(out, origin(), recording=True, force=force)
    raw = beside(out, RAW)  # outside: it must survive when this program does not
    refuse_rescued(raw, force)
    screen = console(json_file)
    with keeping(raw):
        bar_s = seconds or 3600.0
        with connected(port, reconnect_s=10.0) as drive, room_for(raw), progress_bar("recording", bar_s) as bar:
            drive.schema.signal_numbers(names)
            done = record_stream(
                drive, names, raw, rate_hz=rate, seconds=seconds, speed_rad_s=speed, progress=bar.update,
                tripped=lambda t_s, what: screen.print(f"THE DRIVE TRIPPED at {t_s:.3f} s: {what.text}"),
            )  # fmt: skip
            source = source_facts(drive)
        recording = read_raw(raw)
        with output as folder:
            write_csv(folder / "recording.csv", recording.record.names, recording.record.values)
            output.bring(raw, "raw.mcap")
            output.facts = {"source": source, "recorded": done.as_json()}
    if json_file is not None:
        write_json(done.as_json(), json_file)
    trip = done.trip
    tripped = f"; THE DRIVE TRIPPED at {done.t_s(trip):.3f} s: {trip.fault}" if trip is not None else ""
    screen.print(f"{done.rows} rows, {done.lost_rows} lost, {done.reconnects} reconnects{tripped}")
    screen.print(f"{out}/recording.csv", style="bold")
    if trip is not None:
        at_s, last_s = done.t_s(trip), recording.record["t_s"][-1]
        raise DriveFaultError(
            f"bench record: {out} is complete, but the drive tripped at {at_s:.3f} s of {last_s:.3f} s: {trip.fault}"
        )


def convert(
    raw: Annotated[Path, typer.Argument(metavar="RAW.mcap", help="Also one that broke off.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE.csv", help="A new file, or what this made before.")],
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """A raw recording as CSV, as far as it was written.

    Example: `evenspin bench convert out/recording.raw.mcap --out rescued.csv`
    """
    from evenspin.bench.raw import read_raw
    from evenspin.log import write_csv
    from evenspin.output import OutputFile

    check_json_file(json_file)
    output = OutputFile(out, origin(raw), force=force)
    recording = read_raw(raw)
    with output as place:
        write_csv(place, recording.record.names, recording.record.values)
    if json_file is not None:
        content = {"rows": len(recording.record), "lost_rows": recording.lost_rows, "whole": recording.whole}
        write_json(content | {"source": recording.source, "events": list(recording.events)}, json_file)
    screen = console(json_file)
    for event in recording.events:
        if "fault" in event:
            screen.print(f"THE DRIVE TRIPPED at {event['t_s']:.3f} s: {event['text']}")
    screen.print(f"{len(recording.record)} rows{'' if recording.whole else ', the file broke off'}")
    screen.print(f"{out}", style="bold")


def plan(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A model file .toml, or a built-in model.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE.toml", help="A new file, or what this made before.")],
    top_speed: Annotated[
        float | None, typer.Option("--top-speed", metavar="RAD_S", help="Default: from the model's voltage.")
    ] = None,
    force: Force = False,
) -> None:
    """Write the experiment list of the gap workflow for a motor, to check, to change, and to run.

    Example: `evenspin bench plan guo2024 --out experiments.toml`
    """
    from evenspin.bench.experiments import experiments_toml, plan
    from evenspin.errors import InputError
    from evenspin.model.machine import find_model, load_machine
    from evenspin.output import OutputFile

    output = OutputFile(out, origin(model), force=force)
    machine = load_machine(
        find_model(model, Path(), lambda must, hint: InputError("bench plan", "MODEL", model, must, hint))
    )
    experiments = plan(machine, top_speed)
    output.write(experiments_toml(machine.name, model, experiments))
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
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Perform a list of experiments; leaves a case folder for `evenspin gap` and `evenspin compare`.

    The motor turns in both directions, and stops at the end, at Ctrl-C, and when the link breaks. A trip ends the list
    with exit status 1; the experiments before it are kept.

    Example: `evenspin bench run experiments.toml --port sim:guo2024 --out out/case`
    """
    from dataclasses import replace

    from evenspin.bench.experiments import read_experiments
    from evenspin.bench.kept import FOLDER, beside, keeping, recordings_in, refuse_rescued, room_for, where_it_is
    from evenspin.bench.operator import operator_for
    from evenspin.bench.runner import how_to_log, perform
    from evenspin.errors import InputError, did_you_mean
    from evenspin.log import write_case
    from evenspin.output import OutputFolder
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
    made = origin(experiments, wanted.machine.document.path)
    output = OutputFolder(out, made, recording=True, force=force)
    raw = beside(out, FOLDER)  # outside: it must survive when this program does not
    refuse_rescued(raw, force)
    with keeping(raw), connected(port) as drive:
        operator = operator_for(drive.link.transport, lambda request: yes or typer.confirm(request, err=True))
        if dry_run:
            for experiment in wanted.experiments:
                logging = how_to_log(drive, experiment)
                needs = ["load machine"] * experiment.needs_load_machine + ["locked rotor"] * experiment.rotor_locked
                by = "captures" if logging.captures else "stream"
                screen.print(f"{experiment.name:18} {experiment.duration_s:6.2f} s, {by} at {logging.rate_hz:g} Hz "
                             f"{', '.join(needs)} {logging.note}")  # fmt: skip
            return
        virtual = operator.has_load_machine  # only a virtual drive has one that a program moves
        question = "The motor is going to turn in both directions. Go on?"
        if not virtual and not yes and not typer.confirm(question, err=True):
            raise typer.Exit(1)
        with room_for(raw), progress_bar("experiments", total_s) as bar:
            raw.mkdir(parents=True)
            done = perform(drive, operator, wanted, lambda name, seconds: bar.update(seconds), screen.print, raw)
    with keeping(raw), output as folder:
        write_case(folder, done.meta, done.records)
        for path in recordings_in(raw):
            output.bring(path, f"raw/{path.name}")
    with contextlib.suppress(OSError):
        raw.rmdir()
    if json_file is not None:
        content = {name: len(record) for name, record in done.records.items()}
        more = {"left_out": dict(done.left_out), "tripped": done.meta.get("tripped")}
        write_json({"case": str(out), "rows": content, **more}, json_file)
    for name, record in done.records.items():
        screen.print(f"{name:18} {len(record):6} rows, {done.meta['log_rate_hz'][name]:g} Hz")
    screen.print(f"{out}", style="bold")
    if done.ended_by is not None:
        tripped = "THE DRIVE TRIPPED. " if "tripped" in done.meta else ""
        count = f"{len(done.records)} of {len(wanted.experiments)}"
        screen.print(f"{tripped}The list ended early, after {count}; they are kept.")
        unfinished = [path for path in recordings_in(out / "raw") if path.stem not in done.records]
        if where := where_it_is(unfinished):
            screen.print(f"Of the one that it ended in {where}.")
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
