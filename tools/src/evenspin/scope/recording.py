"""What is streamed, recorded into a folder as `evenspin bench record` leaves one, while all pages go on showing it."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from evenspin.bench.errors import RefusedError
from evenspin.bench.kept import RAW, beside, where_it_is
from evenspin.bench.raw import RawWriter, read_raw
from evenspin.bench.recorder import Recorded, source_facts, source_of
from evenspin.bench.stream import Block
from evenspin.bench.watch import Watch
from evenspin.errors import EvenspinError
from evenspin.log import write_csv
from evenspin.output import OutputFolder
from evenspin.output.origin import Origin
from evenspin.scope.feed import Feed, Live

Message = dict[str, Any]


class Recording:
    """`take` is called by the thread that reads the drive; everything else by workers. What goes wrong ends it, is
    reported to all pages, and leaves the raw file."""

    def __init__(self, feed: Feed, made: Origin, send: Callable[[Message], None]) -> None:
        self._feed, self._made, self._send = feed, made, send
        self._guard = threading.Lock()
        self._writer: RawWriter | None = None
        self._ended = ""  # why it ended by itself
        self._live: Live | None = None
        self._watch: Watch | None = None
        self._rows = self._first = self._last = 0
        self.said: Message = {"type": "recording", "on": False, "folder": "", "text": ""}
        feed.on_block = self.take

    @property
    def on(self) -> bool:
        return self._writer is not None

    @property
    def seconds(self) -> float:
        live = self._live
        return self._rows / live.rate_hz if live is not None else 0.0

    def start(self) -> Message:
        drive, live = self._feed.need_drive(), self._feed.live
        if self.on or live is None:
            raise RefusedError(
                "record: a recording is running; end it first" if self.on else "record: no rows come yet"
            )
        folder = free_folder()
        self._output = OutputFolder(folder, self._made, recording=True)
        self._raw = beside(folder, RAW)
        units = [drive.signals[name].unit for name in live.names]
        self._watch, self._drive = Watch(drive), drive
        self._rows, self._lost, self._live, self._ended = 0, live.stream.lost_rows, live, ""
        pwm_hz = drive.info.pwm_hz
        writer = RawWriter(self._raw, live.names, units, live.stream.decimation, pwm_hz, source_of(drive))
        self._closing = contextlib.ExitStack()
        self._closing.enter_context(writer)
        with self._guard:
            self._writer = writer
        return self._say(True, f"Recording into {folder}/")

    def take(self, live: Live, block: Block) -> None:
        """The next rows of the stream."""
        with self._guard:
            writer = self._writer
            if writer is None or self._ended:
                return
            if live is not self._live:
                self._end_soon("the signals were changed")
                return
            try:
                self._first = self._first if self._rows else block.counter
                self._last = int(block.counters[-1])
                writer.write(block)
                self._rows += len(block)
                assert self._watch is not None
                for each in self._watch.new_events(self._last):
                    writer.event(each.counter, each.as_json())
            except (OSError, EvenspinError) as error:
                self._end_soon(f"it failed: {getattr(error, 'strerror', None) or error}")

    def lost(self) -> None:
        """The drive was unplugged."""
        with self._guard:
            if self._writer is not None and not self._ended:
                self._end_soon("the drive was lost")

    def _end_soon(self, why: str) -> None:
        self._ended = why
        threading.Thread(target=self.end, name="scope recording", daemon=True).start()

    def end(self) -> Message:
        """Make a CSV of it. The answer says where it is."""
        with self._guard:
            writer, self._writer = self._writer, None
        if writer is None:
            raise RefusedError("record: nothing is being recorded")
        try:
            self._closing.close()
            if not self._rows:
                self._raw.unlink(missing_ok=True)
                return self._say(False, "Nothing was recorded: no row came.")
            self._finish()
        except (OSError, EvenspinError) as error:
            kept = where_it_is([self._raw])
            text = getattr(error, "strerror", None) or getattr(error, "bare", str(error))
            return self._say(
                False, "; ".join(part for part in (f"The recording is not complete: {text}", kept) if part)
            )
        reason = f" It ended because {self._ended}." if self._ended else ""
        return self._say(False, f"{self._rows} rows in {self._output.path}/recording.csv.{reason}")

    def _finish(self) -> None:
        watch, live = self._watch, self._live
        assert watch is not None and live is not None
        if not self._drive.link.lost:
            with contextlib.suppress(EvenspinError):
                watch.close(self._last)
        lost = live.stream.lost_rows - self._lost
        done = Recorded(self._rows, lost, 0, self._first, float(self._drive.info.pwm_hz), tuple(watch.all))
        recording = read_raw(self._raw)
        with self._output as folder:
            write_csv(folder / "recording.csv", recording.record.names, recording.record.values)
            self._output.bring(self._raw, "raw.mcap")
            self._output.facts = {"source": source_facts(self._drive), "recorded": done.as_json()}

    def close(self) -> None:
        if self.on:
            with contextlib.suppress(EvenspinError):
                self.end()

    def _say(self, on: bool, text: str) -> Message:
        self.said = {"type": "recording", "on": on, "folder": str(self._output.path), "text": text}
        self._send(self.said)
        return {"text": text, "folder": str(self._output.path)}


def free_folder(now: Callable[[], time.struct_time] = time.localtime) -> Path:
    """A new name in the folder in which the command was started."""
    name = time.strftime("scope-%Y%m%d-%H%M%S", now())
    names = (Path(f"{name}{number}") for number in ("", *(f"-{n}" for n in range(2, 1000))))
    return next(path for path in names if not path.exists() and not beside(path, RAW).exists())
