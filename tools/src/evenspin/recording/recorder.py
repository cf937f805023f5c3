"""Recording a simulated drive."""

from __future__ import annotations

from typing import BinaryIO

from evenspin.build import build
from evenspin.native import load
from evenspin.native.simulation import Simulation
from evenspin.recording.file import Head, Writer
from evenspin.recording.player import signal_names

ROWS_EVERY = 10  # periods: 1 ms, within which a difference is named
PART_PERIODS = 10000


class Recorder:
    """Everything that the firmware of one simulation takes in: `begin` before it starts, `keep` after each piece of the
    run, `close` at the end."""

    def __init__(
        self,
        file: BinaryIO,
        *,
        numeric: str,
        what: str,
        seed: int,
        pwm_hz: float,
        linked: bool = False,
        command: str = "",
        rows_every: int = ROWS_EVERY,
    ) -> None:
        library = load(numeric)
        self.head = Head(
            trace=library.lib.es_trace_version(),
            numeric=numeric,
            firmware=library.text(library.lib.es_firmware_id()),
            schema=library.lib.es_schema_hash(),
            signals=signal_names(numeric),
            pwm_hz=pwm_hz,
            rows_every=rows_every,
            linked=linked,
            what=what,
            seed=seed,
            made_by=str(build()),
            command=command,
        )
        self._writer = Writer(file, self.head)
        self._simulation: Simulation | None = None
        self._waiting = 0

    @property
    def periods(self) -> int:
        return self._writer.periods + self._waiting

    def begin(self, simulation: Simulation) -> None:
        simulation.open_trace(self.head.rows_every)
        self._simulation = simulation

    def keep(self, periods: int) -> None:
        """So many periods were run since the last call."""
        self._waiting += periods
        if self._waiting >= PART_PERIODS:
            self._put()

    def close(self) -> None:
        if self._waiting:
            self._put()
        self._writer.close()

    def _put(self) -> None:
        assert self._simulation is not None
        self._writer.part(self._waiting, self._simulation.take_trace())
        self._waiting = 0
