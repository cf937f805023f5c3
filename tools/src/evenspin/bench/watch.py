"""What happens to the drive while it is recorded: every change of its state, a trip above all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from evenspin.bench import messages
from evenspin.bench.client import Drive
from evenspin.bench.messages import COUNTER_MODULUS, Event
from evenspin.bench.numbers import State
from evenspin.errors import EvenspinError


@dataclass(frozen=True, slots=True)
class Happened:
    """`counter`: the PWM period, counted as the rows are."""

    counter: int
    state: State
    fault: str  # its name; "" when this is no trip
    text: str  # with cause and first check

    @property
    def is_trip(self) -> bool:
        return self.state == State.FAULT

    def as_json(self) -> dict[str, Any]:
        content: dict[str, Any] = {"state": self.state.name.lower()}
        return content | {"fault": self.fault, "text": self.text} if self.is_trip else content


class Watch:
    """State changes from here on. `new_events` gives those since its last call, `close` checks once more at the end."""

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._tripped_before = drive.state().state == State.FAULT
        self._seen = len(drive.events)
        self.all: list[Happened] = []

    @property
    def trip(self) -> Happened | None:
        """The first one."""
        return next((each for each in self.all if each.is_trip), None)

    def new_events(self, near: int) -> list[Happened]:
        """`near`: the period of a row of about now; the drive's own counter turns over."""
        events = self._drive.events
        fresh = [self._happened(event, near) for event in events[self._seen :]]
        self._seen = len(events)
        self.all += fresh
        return fresh

    def close(self, near: int) -> list[Happened]:
        """The last events, and a trip that has not been reported yet, such as one while the link was down."""
        fresh = self.new_events(near)
        now = self._drive.state()
        if now.state != State.FAULT or self._tripped_before or self.trip is not None:
            return fresh
        found = self._drive.fault(samples=False)
        text = messages.fault_text(self._drive.schema, now.fault, now.detail)
        self.all.append(Happened(whole(found.period, near), State.FAULT, found.name, text))
        return [*fresh, self.all[-1]]

    def _happened(self, event: Event, near: int) -> Happened:
        if event.state != State.FAULT:
            return Happened(whole(event.counter, near), event.state, "", "")
        text = messages.fault_text(self._drive.schema, event.fault, event.detail)
        return Happened(whole(event.counter, near), event.state, self._drive.schema.fault(event.fault).name, text)


def whole(counter: int, near: int) -> int:
    """The drive's counter of 32 bits as one that goes on: the nearest to `near`."""
    ahead = (counter - near) % COUNTER_MODULUS
    return near + (ahead if ahead < COUNTER_MODULUS // 2 else ahead - COUNTER_MODULUS)


def trip_of(drive: Drive) -> dict[str, Any] | None:
    """If the drive has tripped: the time from its start (None when it is not known), the fault, and a sentence."""
    if drive.link.lost:
        return None
    try:
        now = drive.state()
        if now.state != State.FAULT:
            return None
        found = drive.fault(samples=False)
    except EvenspinError:
        return None
    runs = [event.counter for event in drive.events if event.state == State.RUN]
    t_s = (found.period - runs[-1]) / drive.info.pwm_hz if runs else None
    at = f" at {t_s:.3f} s" if t_s is not None else ""
    return {"t_s": t_s, "fault": found.name, "text": found.text, "said": f"the drive tripped{at}: {found.text}"}
