"""Which drives are there, and how to open one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from urllib.parse import parse_qsl

from evenspin.bench.errors import NoDeviceError
from evenspin.bench.transport import (
    ControlClient,
    LocalTransport,
    LockstepTransport,
    SerialTransport,
    SocketTransport,
    Transport,
)
from evenspin.drive import VirtualDrive
from evenspin.drive.registry import Note, running
from evenspin.errors import InputError, did_you_mean
from evenspin.model.machine import find_model, load_machine
from evenspin.native import NUMERICS, tables

SIM = "sim:"
SOCKET = "socket://"


@dataclass(frozen=True, slots=True)
class Port:
    """A place where a drive may be."""

    name: str
    what: str


def find_ports() -> list[Port]:
    """Virtual drives that run on this machine, then serial ports that are on USB."""
    from serial.tools import list_ports

    found = [Port(note.port, f"virtual drive, model {note.model}, --speed {note.speed}") for note in running()]
    found += [Port(port.device, port.description) for port in sorted(list_ports.comports()) if port.vid is not None]
    return found


def choose_port(given: str | None) -> str:
    """What the user gave, or else the only one that there is."""
    if given is not None:
        return given
    found = find_ports()
    if len(found) == 1:
        return found[0].name
    if not found:
        why = "no virtual drive and no serial port on USB is there; start `evenspin drive --pty`"
        raise NoDeviceError(why, "--port")
    names = ", ".join(f"{port.name} ({port.what})" for port in found)
    raise NoDeviceError(f"{len(found)} drives were found, say which: {names}", "--port")


def open_transport(name: str) -> Transport:
    """Open a port by its name."""
    check_port(name)
    if name.startswith(SIM):
        return LocalTransport(name, virtual_drive(name))
    if name.startswith(SOCKET):
        address = _address(name)
        note = note_of(name)
        if note is not None and note.speed == "max":
            return LockstepTransport(name, address, ControlClient(note.control), note.octets_per_s)
        return SocketTransport(name, address, note.octets_per_s if note is not None else None)
    note = note_of(name)
    return SerialTransport(name) if note is None else SerialTransport(name, octets_per_s=note.octets_per_s)


def check_port(name: str | None) -> None:
    """Refuse what can never be a port, without opening it."""
    if name is None or name.startswith(SIM):
        return  # `virtual_drive` checks these
    if name.startswith(SOCKET):
        _address(name)
    elif "://" in name:
        hint = "sockets are written socket://HOST:PORT"
        raise InputError("bench", "--port", name, "a serial device, socket://HOST:PORT or sim:MODEL", hint)


def note_of(name: str) -> Note | None:
    """The note of a virtual drive on this machine."""
    return next((note for note in running() if note.port == name), None)


def virtual_drive(name: str) -> VirtualDrive:
    """`sim:MODEL?effect.param=value&plant.field=value&seed=1&baud=625000&fresh=1`."""
    model, _, query = name.removeprefix(SIM).partition("?")
    machine = load_machine(
        find_model(model, Path(), lambda must, hint: InputError("bench", "--port", name, f"sim: and {must}", hint))
    )
    effects: dict[str, dict[str, float]] = {}
    plant: dict[str, float] = {}
    options: dict[str, float] = {}
    numeric = NUMERICS[0]
    for key, text in parse_qsl(query, keep_blank_values=True):
        if key == "numeric":
            numeric = text
            continue
        group, _, field = key.rpartition(".")
        try:
            value = float(text)
        except ValueError:
            raise InputError("bench", f"--port {key}", text, "a number", f"write {key}=VALUE") from None
        if group == "plant":
            plant[field] = value
        elif group in tables().effects:
            effects.setdefault(group, {})[field] = value
        elif not group and field in ("seed", "baud", "fresh"):
            options[field] = value
        else:
            known = [*tables().effects, "plant", "seed", "baud", "numeric", "fresh"]
            must = "an effect with its parameter, plant.FIELD, seed, baud, numeric or fresh"
            raise InputError("bench", "--port", key, must, did_you_mean(group or field, known))
    seed = int(options.get("seed", 1))
    fresh = bool(options.get("fresh", 0.0))
    return VirtualDrive(
        machine, effects, plant=plant, seed=seed, numeric=numeric, baud=options.get("baud"), fresh=fresh
    )


def _address(name: str) -> tuple[str, int]:
    host, _, port = name.removeprefix(SOCKET).rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise InputError("bench", "--port", name, "socket://HOST:PORT", "for example socket://127.0.0.1:7007")
    return host.strip("[]"), int(port)
