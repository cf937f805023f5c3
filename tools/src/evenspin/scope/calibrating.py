"""Calibrations of `evenspin bench calibrate`, asked for by a page. A stop ends one wherever it is: nothing more of it
goes out to the drive, and the parameters are those from before."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from evenspin.bench import Drive
from evenspin.bench import calibrate as work
from evenspin.bench.errors import RefusedError
from evenspin.bench.frames import Frame
from evenspin.bench.link import ANSWER_S, Link
from evenspin.bench.messages import Ask
from evenspin.bench.operator import operator_for
from evenspin.bench.stream import Stream
from evenspin.errors import EvenspinError
from evenspin.output import OutputFile
from evenspin.output.origin import Origin

Message = dict[str, Any]
ANSWER_WAIT_S = 600.0  # for a person who locks a rotor


class StoppedError(EvenspinError):
    """A stop has ended the work."""

    exit_code = 1


class StoppableLink:
    """The link of a drive as long as nobody has stopped; then every request raises StoppedError."""

    def __init__(self, link: Link, stopped: threading.Event) -> None:
        self._link, self._stopped = link, stopped

    def __getattr__(self, name: str) -> Any:
        return getattr(self._link, name)

    @property
    def keep_alive(self) -> bool:
        return self._link.keep_alive

    @keep_alive.setter
    def keep_alive(self, on: bool) -> None:
        self._link.keep_alive = on and not self._stopped.is_set()

    def _check(self) -> None:
        if self._stopped.is_set():
            raise StoppedError("stopped")

    def ask(self, kind: Ask, payload: bytes = b"", timeout_s: float = ANSWER_S) -> Frame:
        self._check()
        return self._link.ask(kind, payload, timeout_s)

    def ask_all(self, requests: Sequence[tuple[Ask, bytes]], timeout_s: float = ANSWER_S) -> Iterator[Frame]:
        self._check()
        for frame in self._link.ask_all(requests, timeout_s):
            self._check()
            yield frame

    def wait(self, arrived: Callable[[], bool], timeout_s: float) -> bool:
        came = self._link.wait(lambda: self._stopped.is_set() or arrived(), timeout_s)
        self._check()
        return came


class StoppableDrive(Drive):
    """The same drive, for work that a stop ends."""

    def __init__(self, drive: Drive, stopped: threading.Event) -> None:
        self.__dict__.update(drive.__dict__)
        self._drive = drive
        self.link = StoppableLink(drive.link, stopped)  # type: ignore[assignment]

    @property
    def streaming(self) -> Stream | None:
        """There is one stream at a time, whoever asked for it."""
        return self._drive.streaming

    @streaming.setter
    def streaming(self, stream: Stream | None) -> None:
        self._drive.streaming = stream


class Calibrating:
    """One at a time. `send` takes messages for all pages; `done` is called with the drive and what was there before."""

    def __init__(
        self, made: Origin, send: Callable[[Message], None], done: Callable[[Drive, str, dict[str, float]], None]
    ) -> None:
        self._made, self._send, self._done = made, send, done
        self._stopped = threading.Event()
        self._answered = threading.Event()
        self._answer = False
        self._thread: threading.Thread | None = None
        self.said: Message = {"type": "calibration", "status": "none", "name": "", "part": 0.0, "lines": []}

    @property
    def busy(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def start(self, drive: Drive, name: str, known: Sequence[str]) -> Message:
        if self.busy:
            raise RefusedError("calibrate: one is running; stop it first")
        procedure = work.procedure(name)
        drive.need_no_fault()
        self._stopped = threading.Event()
        self._say("running", procedure.name, 0.0, [procedure.moves])
        self._thread = threading.Thread(
            target=self._run, args=(drive, name, tuple(known), self._stopped), name="scope calibration", daemon=True
        )
        self._thread.start()
        return {}

    def stop(self) -> None:
        """Before the stop itself goes out: so nothing of the calibration can follow it."""
        self._stopped.set()
        self._answered.set()

    def answer(self, yes: bool) -> None:
        self._answer = yes
        self._answered.set()

    def join(self, seconds: float) -> None:
        if self._thread is not None:
            self._thread.join(seconds)

    def _ask(self, request: str) -> bool:
        self._answered.clear()
        self._answer = False
        self._say("question", self.said["name"], self.said["part"], [request])
        self._answered.wait(ANSWER_WAIT_S)
        self._say("running", self.said["name"], self.said["part"], [])
        return self._answer and not self._stopped.is_set()

    def _run(self, drive: Drive, name: str, known: tuple[str, ...], stopped: threading.Event) -> None:
        status, lines = "failed", [""]
        before: dict[str, float] = {}
        try:
            before = drive.get()
            gated = StoppableDrive(drive, stopped)
            operator = operator_for(drive.link.transport, self._ask)
            done = work.calibrate(gated, operator, name, lambda part: self._progress(name, part), known)
            status, lines = self._write(drive, done)
        except StoppedError:
            status, lines = "stopped", ["Stopped; the parameters are those from before."]
        except (EvenspinError, OSError) as error:
            lines = [str(error)]
        except Exception as error:  # a mistake of ours: the page must show it
            lines = [f"calibrate failed: {error!r}"]
        try:
            if status in ("stopped", "failed") and before and not drive.link.lost:
                drive.stop_at_once()
                _put_back(drive, before)
        except EvenspinError as error:
            lines.append(f"The parameters could not be put back: {error}; restore them by hand.")
        self._done(drive, name if status == "good" else "", before)
        self._say(status, name, 1.0, lines)

    def _progress(self, name: str, part: float) -> None:
        part = min(1.0, max(0.0, part))
        if part - self.said["part"] >= 0.01:
            self._say("running", name, part, self.said["lines"])

    def _write(self, drive: Drive, done: work.Calibration) -> tuple[str, list[str]]:
        path = work.free_file(done.name)
        try:
            OutputFile(path, self._made, recording=True).write(work.calibration_toml(done, drive))
        except (EvenspinError, OSError) as error:  # do not continue without the means to restore
            if done.good:
                drive.set(done.before)
            raise EvenspinError(f"{error}; the drive has the values from before the calibration") from None
        names = ", ".join(done.found.parameters)
        stored = [f"{names}: {'measured now, in force; Save keeps it' if done.good else 'not stored'}"] if names else []
        notes = [done.found.note] if done.found.note else []
        return "good" if done.good else "not good", [*done.lines, *notes, *stored, f"Written: {path}"]

    def _say(self, status: str, name: str, part: float, lines: list[str]) -> None:
        self.said = {"type": "calibration", "status": status, "name": name, "part": part, "lines": lines}
        self._send(self.said)


def _put_back(drive: Drive, before: dict[str, float]) -> None:
    held = drive.get()
    changed = {name: value for name, value in before.items() if np.float32(held[name]) != np.float32(value)}
    if changed:
        drive.set(changed)


def procedures() -> list[Message]:
    """What the page offers, in the order in which it makes sense."""
    return [{"name": each.name, "goal": each.goal, "moves": each.moves} for each in work.PROCEDURES.values()]
