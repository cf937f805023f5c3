"""Full-rate captures for the page: armed, waited for, fetched, one at a time, again and again if wanted."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from evenspin.bench import Capture, Drive, Trigger
from evenspin.bench.numbers import CaptureStatus
from evenspin.errors import EvenspinError
from evenspin.scope import messages

POLL_S = 0.05
SAY: dict[CaptureStatus, tuple[str, str]] = {
    CaptureStatus.FILLING_PRE: ("filling", "Recording what comes before the trigger"),
    CaptureStatus.WAITING: ("waiting", "Waiting for the trigger"),
    CaptureStatus.FILLING_POST: ("recording", "Triggered, recording"),
    CaptureStatus.COMPLETE: ("fetching", "Fetching"),
}

Send = Callable[[dict[str, Any]], None]


class Capturing:
    """`send` gets status messages, `done` the record. Both are called from the thread of the capture."""

    def __init__(self, send: Send, done: Callable[[Capture, str], None]) -> None:
        self._send, self._done = send, done
        self._cancel = threading.Event()
        self._thread: threading.Thread | None = None
        self._last = ""

    @property
    def busy(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def start(self, drive: Drive, wanted: messages.ArmCapture) -> int:
        """Returns the rows. A wrong choice is refused here, with the reason."""
        self.cancel()
        rows, pre = self._arm(drive, wanted)
        self._cancel = threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(drive, wanted, rows, pre, self._cancel), name="scope capture", daemon=True
        )
        self._thread.start()
        return rows

    def cancel(self) -> None:
        self._cancel.set()
        if self._thread is not None:
            self._thread.join(5.0)

    def _arm(self, drive: Drive, wanted: messages.ArmCapture) -> tuple[int, int]:
        trigger = Trigger[wanted.trigger.upper()]
        edge = trigger in (Trigger.RISING, Trigger.FALLING, Trigger.EITHER)
        rows = min(wanted.rows, drive.capture_rows(max(1, len(wanted.signals))))
        pre = 0 if trigger is Trigger.IMMEDIATE else int(rows * wanted.pre_pct / 100.0)
        drive.arm_capture(
            wanted.signals, rows=rows, pre=pre, trigger=trigger, level=wanted.level if edge else 0.0,
            signal_name=(wanted.signal or wanted.signals[0]) if edge else None, decimation=wanted.decimation,
        )  # fmt: skip
        return rows, pre

    def _run(self, drive: Drive, wanted: messages.ArmCapture, rows: int, pre: int, cancel: threading.Event) -> None:
        try:
            while True:
                taken = self._await(drive, cancel)
                if taken is None:
                    self._say("cancelled", "Cancelled")
                    return
                self._done(taken, _title(wanted))
                if not wanted.repeat:
                    self._say("complete", "Complete")
                    return
                self._arm(drive, wanted)
        except (EvenspinError, OSError) as error:
            self._say("failed", str(error))

    def _await(self, drive: Drive, cancel: threading.Event) -> Capture | None:
        while not cancel.is_set():
            state = drive.capture_state()
            if state.status in SAY:
                self._say(*SAY[state.status])
            if state.status == CaptureStatus.COMPLETE:
                return drive.read_capture()
            if state.status in (CaptureStatus.NEVER, CaptureStatus.STOPPED):
                return None
            cancel.wait(POLL_S)
        return None

    def _say(self, status: str, text: str) -> None:
        if status != self._last:
            self._last = status
            self._send({"type": "capture", "status": status, "text": text})


def _title(wanted: messages.ArmCapture) -> str:
    if wanted.trigger in ("immediate", "manual", "fault"):
        return {"immediate": "taken at once", "manual": "triggered by hand", "fault": "at the fault"}[wanted.trigger]
    sign = {"rising": "rises above", "falling": "falls below", "either": "crosses"}[wanted.trigger]
    return f"{wanted.signal or wanted.signals[0]} {sign} {wanted.level:g}"
