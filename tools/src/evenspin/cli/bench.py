"""`evenspin bench`: watch a drive, tune it, keep its parameters. Recording is in cli/bench_log.py."""

from __future__ import annotations

import contextlib
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from evenspin.cli import bench_apply, bench_bode, bench_calibrate, bench_capture, bench_config, bench_log
from evenspin.cli.bench_config import shown_value
from evenspin.cli.bench_port import PortOption, connected
from evenspin.cli.options import Force, JsonFile
from evenspin.cli.output import check_json_file, console, write_json

if TYPE_CHECKING:
    from evenspin.bench import Drive

app = typer.Typer(no_args_is_help=True, help="Watch a drive, tune it, record it: a board, or a virtual drive.")


def register(parent: typer.Typer) -> None:
    parent.add_typer(app, name="bench")
    for command in (ports, info, watch, get, fault, stop, clear, save):
        app.command(command.__name__)(command)
    app.command("set")(set_)
    bench_config.register(app)
    bench_capture.register(app)
    bench_log.register(app)
    bench_calibrate.register(app)
    bench_bode.register(app)
    bench_apply.register(app)


def ports(json_file: JsonFile = None) -> None:
    """Drives that can be connected: virtual ones that run on this machine, and serial ports on USB.

    Example: `evenspin bench ports`
    """
    from evenspin.bench import find_ports

    found = find_ports()
    if json_file is not None:
        write_json([{"port": port.name, "what": port.what} for port in found], json_file)
    screen = console(json_file)
    for port in found:
        screen.print(f"{port.name}  {port.what}")
    if not found:
        screen.print("none; start one: evenspin drive --pty")


def info(port: PortOption = None, json_file: JsonFile = None) -> None:
    """What the drive is, and how it is: state, last fault with its advice, interrupt time, losses on the link.

    Example: `evenspin bench info --port /dev/ttyUSB0`
    """
    check_json_file(json_file)
    with connected(port) as drive:
        content = _info(drive)
    if json_file is not None:
        write_json(content, json_file)
    screen = console(json_file)
    for key, value in content.items():
        screen.print(f"{key:16} {value}")


def _info(drive: Drive) -> dict[str, Any]:
    from evenspin.bench.numbers import Flag, ResetCause

    now, timing, fault = drive.state(), drive.timing(), drive.fault(samples=False)
    cyc_us = 1e6 / timing.cpu_hz if timing.cpu_hz else 0.0
    return {
        "port": drive.port,
        "name": drive.info.name,
        "firmware": drive.info.firmware,
        "numeric": drive.info.numeric,
        "protocol": drive.info.version,
        "schema": f"{drive.info.schema:08x}",
        "may_write": drive.info.may_write,
        "read_only": drive.read_only_reason,
        "pwm_hz": drive.info.pwm_hz,
        "state": now.state.name.lower(),
        "mode": now.mode.name.lower(),
        "uptime_s": now.counter / drive.info.pwm_hz,
        "reset_cause": ResetCause.of(now.flags).name.lower(),
        "zero_known": bool(now.flags & Flag.STARTED_UP),
        "last_fault": fault.text,
        "isr_us": round(timing.isr_last_cyc * cyc_us, 2),
        "isr_max_us": round(timing.isr_max_cyc * cyc_us, 2),
        "pass_max_us": round(timing.pass_max_cyc * cyc_us, 1),
        "rejected": now.rejected,
        "frames_bad": now.frames_bad + drive.link.bad_frames,
        "octets_lost": now.octets_lost,
        "parameters": len(drive.parameters),
        "signals": len(drive.signals),
        "capture_values": drive.info.recorder_values[0] if drive.info.recorder_values else 0,
    }


def watch(
    signals: Annotated[
        list[str] | None, typer.Argument(metavar="[SIGNAL]...", help="Default: speed and currents.")
    ] = None,
    port: PortOption = None,
    seconds: Annotated[float, typer.Option(min=0.0, help="For how long; 0: until Ctrl-C.")] = 0.0,
    speed: Annotated[float | None, typer.Option("--speed", metavar="RAD_S", help="Turn at this speed.")] = None,
    rate: Annotated[float, typer.Option(min=1.0, max=100.0, help="Lines per second.")] = 4.0,
    json_file: JsonFile = None,
) -> None:
    """Signals as they are, line by line. With --speed the motor turns; it stops at the end.

    With --json each line is a JSON object.

    Example: `evenspin bench watch speed_rad_s iq_a --speed 30 --seconds 5`
    """
    names = tuple(signals or ("speed_ref_rad_s", "speed_rad_s", "iq_a", "vdc_v", "state", "fault"))
    screen = console(json_file)
    with connected(port, reconnect_s=10.0) as drive:
        drive.schema.signal_numbers(names)
        screen.print("  ".join(f"{name:>16}" for name in names))
        if speed is not None:
            drive.run_speed(speed)
        start_s = drive.link.transport.clock()
        with contextlib.suppress(KeyboardInterrupt):
            while seconds == 0.0 or drive.link.transport.clock() - start_s < seconds:
                values = drive.read(names)
                if json_file is not None:
                    sys.stdout.write(json.dumps(values) + "\n")
                    sys.stdout.flush()
                else:
                    screen.print("  ".join(f"{_as_word(drive, name, value):>16}" for name, value in values.items()))
                drive.need_no_fault()
                drive.sleep(1.0 / rate)


def _as_word(drive: Drive, name: str, value: float) -> str:
    """A state and a fault have names; their numbers are for programs."""
    from evenspin.bench.numbers import State

    if name == "state" and value in list(State):
        return State(int(value)).name.lower()
    if name == "fault":
        return drive.schema.fault(int(value)).name
    return f"{value:.5g}"


def get(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]...", help="Default: all of them.")] = None,
    port: PortOption = None,
    json_file: JsonFile = None,
) -> None:
    """Parameters of the drive, with unit and range.

    Example: `evenspin bench get speed_kp_a_per_unit`
    """
    from evenspin.bench.config import shortest
    from evenspin.tableview import TableView, print_table

    check_json_file(json_file)
    with connected(port) as drive:
        values = drive.get(names or None)
        fields = {name: drive.parameters[name] for name in values}
    if json_file is not None:
        write_json({name: shortest(value) for name, value in values.items()}, json_file)
    rows = []
    for name, value in values.items():
        field = fields[name]
        shown = field.to_text(value) if field.kind in ("choice", "flag") else f"{shortest(value):g}"
        rows.append((name, shown, field.unit, field.allowed()))
    print_table(TableView("Parameters", "", ("name", "value", "unit", "range"), rows, left=4), console(json_file))


SAVED = "Kept over a power cycle."


def set_(
    settings: Annotated[list[str], typer.Argument(metavar="NAME=VALUE...", help="Numbers, or words of a choice.")],
    port: PortOption = None,
    keep: Annotated[bool, typer.Option("--save", help="Keep them over a power cycle.")] = False,
    json_file: JsonFile = None,
) -> None:
    """Change parameters: all of them between two samples of the current loop, or none.

    Example: `evenspin bench set method=forc rc_gain=0.4`
    """
    from evenspin.bench.client import parse_value
    from evenspin.bench.config import shortest
    from evenspin.errors import InputError

    check_json_file(json_file)
    with connected(port) as drive:
        wanted = {}
        for word in settings:
            name, equals, text = word.partition("=")
            if not equals:
                raise InputError("bench set", "NAME=VALUE", word, "a name, =, and a value", "for example rc_gain=0.4")
            if name in wanted:
                raise InputError("bench set", "NAME=VALUE", word, "the only one of its name", "keep one of the two")
            wanted[name] = parse_value(drive.schema.parameter(name), text)
        fields = {name: drive.parameters[name] for name in wanted}
        held = drive.set(wanted)
        if keep:
            drive.save()
    if json_file is not None:
        write_json({name: shortest(value) for name, value in held.items()}, json_file)
    screen = console(json_file)
    for name, value in held.items():
        unit = f" {fields[name].unit}" if fields[name].unit else ""
        screen.print(f"{name} = {shown_value(fields[name], value)}{unit}")
    if keep:
        screen.print(SAVED)


def fault(
    port: PortOption = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="The last samples before it, CSV: a new file.")
    ] = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """The last fault: its cause, what to check first, and the samples before it; after a reset, what was before that.

    Example: `evenspin bench fault --out fault.csv`
    """
    from evenspin.bench.kept import RAW, beside, keeping, refuse_rescued
    from evenspin.cli.bench_capture import CaptureFiles

    check_json_file(json_file)
    files = CaptureFiles(out, force) if out is not None else None
    if out is not None:
        refuse_rescued(beside(out, RAW), force)
    with connected(port) as drive:
        report = drive.fault(samples=out is not None)
        if out is not None and files is not None and report.last_samples is not None:
            raw = beside(out, RAW)
            with keeping(raw):
                files.write(raw, report.last_samples, drive, [])
    screen = console(json_file)
    screen.print(report.text)
    if report.before_reset:
        screen.print(report.before_reset)
    if out is not None and report.last_samples is not None:
        screen.print(f"{out}", style="bold")
    elif out is not None and (report.number or report.before_reset):
        screen.print("The samples are not complete, or were overwritten by a new start.")
    if json_file is not None:
        content = {"number": report.number, "name": report.name, "cause": report.cause, "check": report.check}
        content |= {"detail": report.detail, "before_reset": report.before_reset}
        write_json(content | {"period": report.period}, json_file)


def stop(port: PortOption = None) -> None:
    """Switch the bridge off; the motor coasts.

    Example: `evenspin bench stop`
    """
    with connected(port) as drive:
        drive.stop()
    console().print("The bridge is off.")


def clear(port: PortOption = None) -> None:
    """Leave the fault state, if the cause is gone.

    Example: `evenspin bench clear`
    """
    with connected(port) as drive:
        drive.clear_fault()
        drive.sleep(0.05)
        drive.need_no_fault()
    console().print("No fault.")


def save(port: PortOption = None) -> None:
    """Keep the parameters over a power cycle.

    Example: `evenspin bench save`
    """
    with connected(port) as drive:
        drive.save()
    console().print(SAVED)
