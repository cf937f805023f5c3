"""`evenspin drive`: a drive for the bench tools where no board is."""

from __future__ import annotations

import os
import signal
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from evenspin.cli.options import Numeric, NumericOption
from evenspin.cli.origin import origin
from evenspin.cli.recording import RecordOption, check_record, recorder_to


class Speed(StrEnum):
    REAL = "real"
    MAX = "max"


def register(app: typer.Typer) -> None:
    app.command("drive")(drive)


def drive(
    pty: Annotated[bool, typer.Option("--pty", help="Offer the link on a pseudo terminal, as a serial port.")] = False,
    tcp: Annotated[str | None, typer.Option(metavar="HOST:PORT", help="Offer it on TCP; port 0: a free one.")] = None,
    model: Annotated[str, typer.Option(metavar="MODEL", help="A model file .toml, or a built-in model.")] = "guo2024",
    effect: Annotated[
        list[str] | None,
        typer.Option("--effect", metavar="NAME.PARAM=VALUE", help="Hide this in the machine; several times."),
    ] = None,
    speed: Annotated[Speed, typer.Option(help="real: by the clock; max: in lockstep with the client.")] = Speed.REAL,
    baud: Annotated[float | None, typer.Option(help="Octets pass no faster than over such a serial line.")] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**63 - 1, help="Seed of the sensor noise.")] = 1,
    numeric: NumericOption = Numeric.FLOAT,
    record: RecordOption = None,
) -> None:
    """Run the firmware on the simulated machine behind the link that a board has. Ends with Ctrl-C.

    The first line says the port, for --port of `evenspin bench`. With --record the recording is there when it ends.

    Example: `evenspin drive --pty --effect cogging.amplitude_nm=0.01 --effect cogging.order=12`
    """
    from evenspin.cli.compare import parse_effects
    from evenspin.drive import VirtualDrive
    from evenspin.drive.registry import Note, announced
    from evenspin.drive.server import Server
    from evenspin.drive.virtual import PWM_HZ
    from evenspin.errors import InputError
    from evenspin.model.machine import find_model, load_machine

    if pty == (tcp is not None):
        given = "both" if pty else "neither"
        raise InputError("drive", "--pty, --tcp", given, "one of the two", "evenspin drive --pty")
    if pty and speed is Speed.MAX:
        raise InputError("drive", "--speed", "max", "with --tcp", "evenspin drive --tcp 127.0.0.1:0 --speed max")
    check_record(record)
    path = find_model(model, Path(), lambda must, hint: InputError("drive", "--model", model, must, hint))
    effects = parse_effects(effect or [])
    machine = load_machine(path)
    address = _address(tcp) if tcp is not None else None
    with recorder_to(record, origin(path), None, numeric.value, machine.name, seed, PWM_HZ, linked=True) as recorder:
        virtual = VirtualDrive(machine, effects, seed=seed, numeric=numeric.value, baud=baud, recorder=recorder)
        server = Server(virtual, address=address, lockstep=speed is Speed.MAX, say=_say)
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda *_: server.stop())
        note = Note(os.getpid(), server.port, server.control, virtual.machine.name, speed.value, virtual.octets_per_s)
        with announced(note):
            print(server.port, flush=True)
            _say(f"model {virtual.machine.name}, speed {speed.value}, load machine and clock at {server.control}")
            try:
                server.run()
            except KeyboardInterrupt:
                _say("stopped")
    if record is not None:
        _say(f"recorded: {record}")


def _address(word: str) -> tuple[str, int]:
    from evenspin.errors import InputError

    host, _, port = word.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise InputError("drive", "--tcp", word, "HOST:PORT", "for example 127.0.0.1:7007")
    return host.strip("[]"), int(port)


def _say(text: str) -> None:
    print(f"evenspin drive: {text}", file=sys.stderr, flush=True)
