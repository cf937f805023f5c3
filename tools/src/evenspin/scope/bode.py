"""Frequency responses of `evenspin bench bode`, asked for by a page, of the drive as it runs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from evenspin.bench import Drive
from evenspin.bench.errors import RefusedError
from evenspin.bench.response import Plan, Point, Response, content_of, lines_of, measure, plan_of
from evenspin.errors import EvenspinError
from evenspin.scope.calibrating import StoppableDrive, StoppableLink, StoppedError

Message = dict[str, Any]


class EndedError(EvenspinError):
    """Somebody has ended the measurement; the drive goes on."""


class EndableLink(StoppableLink):
    """Whoever waits for rows notices an end; what takes the excitation away still goes out."""

    def __init__(self, link: Any, stopped: threading.Event, ended: threading.Event) -> None:
        super().__init__(link, stopped)
        self._ended = ended

    def wait(self, arrived: Callable[[], bool], timeout_s: float) -> bool:
        came = super().wait(lambda: self._ended.is_set() or arrived(), timeout_s)
        if self._ended.is_set():
            raise EndedError("ended")
        return came


class EndableDrive(StoppableDrive):
    """The same drive, for a measurement that an end or a stop ends."""

    def __init__(self, drive: Drive, stopped: threading.Event, ended: threading.Event) -> None:
        super().__init__(drive, stopped)
        self.link = EndableLink(drive.link, stopped, ended)  # type: ignore[assignment]


class Bode:
    """One at a time. `send` takes messages for all pages; `done` is called with the drive."""

    def __init__(self, send: Callable[[Message], None], done: Callable[[Drive], None]) -> None:
        self._send, self._done = send, done
        self._stopped, self._ended = threading.Event(), threading.Event()
        self._thread: threading.Thread | None = None
        self.said: Message = {"type": "bode", "status": "none", "part": 0.0, "lines": [], "found": None}

    @property
    def busy(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def start(
        self, drive: Drive, place: str, first_hz: float, last_hz: float | None, points: int, amplitude: float | None
    ) -> None:
        """Refused at once where the plan cannot be."""
        if self.busy:
            raise RefusedError("bode: one is being measured; end it first")
        plan = plan_of(drive, place, first_hz, last_hz, points, amplitude)
        self._stopped, self._ended = threading.Event(), threading.Event()
        self.said = {"type": "bode", "status": "running", "part": 0.0, "lines": [], "found": None}
        self._send(self.said)
        work = (drive, EndableDrive(drive, self._stopped, self._ended), plan)
        self._thread = threading.Thread(target=self._run, args=work, name="scope bode", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Before the stop itself goes out: so nothing of the measurement can follow it."""
        self._stopped.set()

    def end(self) -> None:
        self._ended.set()

    def join(self, seconds: float) -> None:
        if self._thread is not None:
            self._thread.join(seconds)

    def _run(self, drive: Drive, gated: Drive, plan: Plan) -> None:
        points: list[Point] = []
        speed_rad_s, status, lines = 0.0, "failed", [""]

        def each(point: Point) -> None:
            points.append(point)
            self._say("running", self.said["part"], [], Response(plan, speed_rad_s, points))

        def progress(part: float) -> None:
            self._say("running", part, [], Response(plan, speed_rad_s, points))

        try:
            found = measure(gated, plan, progress, each)
            speed_rad_s, status, lines = found.speed_rad_s, "done", lines_of(found)
        except (EndedError, StoppedError) as error:
            status = "ended" if isinstance(error, EndedError) else "stopped"
            lines = [f"{status.capitalize()}; the points before it are shown."]
        except (EvenspinError, OSError) as error:
            lines = [str(error)]
        except Exception as error:  # a mistake of ours: the page must show it
            lines = [f"bode failed: {error!r}"]
        self._done(drive)
        self._say(status, 1.0, lines, Response(plan, speed_rad_s, points))

    def _say(self, status: str, part: float, lines: list[str], found: Response) -> None:
        content = content_of(found) if found.points else None
        self.said = {"type": "bode", "status": status, "part": part, "lines": lines, "found": content}
        self._send(self.said)
