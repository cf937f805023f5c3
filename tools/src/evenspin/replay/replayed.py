"""A recording, replayed: how far, with which difference, to which fault, and the signals around it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError
from evenspin.native import tables
from evenspin.recording import Difference, Head, Player, RecordingFile
from evenspin.run.outcome import STATES
from evenspin.sim.record import Record

Array = NDArray[np.float64]

CHUNK = 2000  # periods at once
TIME = "t_s"
FAULT, STATE = "fault", "state"


@dataclass(frozen=True, slots=True)
class Window:
    """How much is kept at the full rate before and after the fault, or before the end where there is none, s."""

    before_s: float = 0.05
    after_s: float = 0.01


@dataclass(frozen=True, slots=True)
class Fault:
    """The first fault of a replay, in the period at whose end it is there."""

    name: str
    period: int
    t_s: float
    cause: str
    check: str

    def __str__(self) -> str:
        return f"{self.name} at {self.t_s:g} s, PWM period {self.period}"

    def as_json(self) -> dict[str, Any]:
        return {"name": self.name, "period": self.period, "t_s": self.t_s, "cause": self.cause, "check": self.check}


@dataclass(frozen=True, slots=True)
class Replayed:
    """`record`: all signals, a row per PWM period, around the fault or before the end. `difference`: None when the
    firmware did the same, bit for bit."""

    path: Path
    head: Head
    periods: int  # replayed
    whole: bool  # to the end of the recording
    fault: Fault | None
    difference: Difference | None
    record: Record

    @property
    def t_s(self) -> float:
        """Time replayed."""
        return self.periods / self.head.pwm_hz

    @property
    def same(self) -> bool:
        return self.difference is None

    def as_json(self) -> dict[str, Any]:
        row = self.record.values[-1] if len(self.record) else []
        head = self.head
        return {
            "recording": str(self.path),
            "of": head.what,
            "numeric": head.numeric,
            "firmware": head.firmware,
            "made_by": head.made_by,
            "command": head.command,
            "periods": self.periods,
            "t_s": self.t_s,
            "whole": self.whole,
            "same": self.same,
            "difference": self.difference.as_json() if self.difference is not None else None,
            "fault": self.fault.as_json() if self.fault is not None else None,
            "end": {name: _plain(float(value)) for name, value in zip(self.record.names, row, strict=True)}
            if len(row) else {},
        }  # fmt: skip


def replay(
    path: Path,
    *,
    until_s: float | None = None,
    past_fault: bool = False,
    other_firmware: bool = False,
    window: Window | None = None,
    progress: Callable[[float], None] | None = None,
) -> Replayed:
    """Run the firmware from the recording, up to its first fault and `window.after_s` beyond (`past_fault`: to the
    end), at most to `until_s`, and only to the first difference."""
    window = window if window is not None else Window()
    file = RecordingFile(path)
    head = file.head
    player = Player(path, head, other_firmware=other_firmware)
    kept = _Kept(player.signals, head.pwm_hz, window)
    last = _period(until_s, head.pwm_hz)
    if last is not None and last < 1:
        raise InputError(path, "--until", until_s, f"at least {1.0 / head.pwm_hz:g} s", "one PWM period")
    whole = True
    for part in file.parts():
        if not whole or player.ended:
            break
        player.feed(part)
        whole = _run(player, part.periods, kept, last, past_fault)
        if progress is not None:
            progress(player.periods / head.pwm_hz)
    if last is not None and whole and player.periods < last and not player.ended:
        raise InputError(
            path,
            "--until",
            until_s,
            f"at most {player.periods / head.pwm_hz:g} s, its length",
            "leave it out for all of it",
        )
    return Replayed(
        path, head, player.periods, whole and not player.ended, kept.fault, player.difference(), kept.record()
    )


def _run(player: Player, periods: int, kept: _Kept, last: int | None, past_fault: bool) -> bool:
    """A part; False when it stops within or at its end."""
    left = periods
    while left > 0 and not player.ended:
        stop = kept.stop(past_fault)
        ends = [end for end in (last, stop) if end is not None]
        room = min(ends, default=player.periods + left) - player.periods
        if room <= 0:
            return False
        rows = player.run(min(left, room, CHUNK))
        kept.take(rows, player.periods - len(rows))
        left -= len(rows)
        if not len(rows):
            break
    return True


class _Kept:
    """The rows around the first fault, or the newest ones."""

    def __init__(self, signals: tuple[str, ...], pwm_hz: float, window: Window) -> None:
        self._signals, self._pwm_hz = signals, pwm_hz
        self._before = max(1, round(window.before_s * pwm_hz))
        self._after = max(0, round(window.after_s * pwm_hz))
        self._rows: list[Array] = []
        self._first = 0  # period of the first row
        self.fault: Fault | None = None
        self._column = signals.index(FAULT)

    def stop(self, past_fault: bool) -> int | None:
        """Periods after which a replay that stops at the fault is over."""
        return None if past_fault or self.fault is None else self.fault.period + 1 + self._after

    def take(self, rows: Array, first: int) -> None:
        tripped = rows[:, self._column] > 0.0
        if self.fault is None and tripped.any():
            self._note(first + int(tripped.argmax()), int(rows[tripped.argmax(), self._column]))
        if self.fault is None:
            self._add(rows)
            self._forget(first + len(rows) - self._before)
        else:
            end = self.fault.period + 1 + self._after
            self._add(rows[: max(0, end - first)])
            self._forget(self.fault.period - self._before)

    def _note(self, period: int, number: int) -> None:
        fault = tables().faults[number]
        self.fault = Fault(fault.name, period, period / self._pwm_hz, fault.cause, fault.check)

    def _add(self, rows: Array) -> None:
        if len(rows):
            self._rows.append(rows)

    def _forget(self, before: int) -> None:
        """What lies before this period."""
        while self._rows and self._first + len(self._rows[0]) <= before:
            self._first += len(self._rows.pop(0))

    def record(self) -> Record:
        values = np.concatenate(self._rows) if self._rows else np.empty((0, len(self._signals)))
        end = self._first + len(values)
        wanted = (self.fault.period if self.fault is not None else end) - self._before
        values = values[max(0, wanted - self._first) :]
        periods = np.arange(end - len(values), end)
        units = tuple(tables().signals[name].unit for name in self._signals)
        table = np.column_stack((periods / self._pwm_hz, values))
        return Record((TIME, *self._signals), ("s", *units), table)


def _period(t_s: float | None, pwm_hz: float) -> int | None:
    return None if t_s is None else round(t_s * pwm_hz)


def state_name(value: float) -> str:
    return STATES[int(value)] if 0 <= value < len(STATES) else f"{value:g}"


def _plain(value: float) -> float | str:
    return value if np.isfinite(value) else str(value)
