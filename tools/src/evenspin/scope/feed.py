"""The one connection to the drive: opened, read, and opened again after it was lost. Pages come and go without it.

One thread reads the stream into a History, a second asks for the state. Both only ever write here; pages read. After a
lost link the drive has stopped by itself, and nothing in here starts it again.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from evenspin.bench import Drive, Stream
from evenspin.bench.errors import LinkLostError, NoDeviceError
from evenspin.bench.messages import DriveState, Event
from evenspin.bench.stream import Block
from evenspin.errors import EvenspinError
from evenspin.scope.history import History

AGAIN_S = 0.5
STATE_S = 0.2
READ_S = 0.1
DEFAULT_RATE_HZ = 1000.0
DEFAULT_SIGNALS = (
    "speed_ref_rad_s", "speed_rad_s", "iq_ref_a", "iq_a", "id_a", "vq_v", "vdc_v", "theta_m_rad",
)  # fmt: skip

OpenDrive = Callable[[Callable[[Event], None]], Drive]
Notify = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Live:
    """A stream and where its rows go. A new choice of signals is a new one, with another number."""

    number: int
    names: tuple[str, ...]
    rate_hz: float
    stream: Stream
    history: History


@dataclass(frozen=True, slots=True)
class Connection:
    """`status`: "connected", or "searching" with the reason and what to try in `text`."""

    status: str
    text: str


@dataclass
class Feed:
    """`notify` is called from threads of the feed with what changed: "link", "drive", "state" or "layout"."""

    open_drive: OpenDrive
    notify: Notify = lambda _: None
    signals: tuple[str, ...] = DEFAULT_SIGNALS
    rate_hz: float = DEFAULT_RATE_HZ
    drive: Drive | None = None
    live: Live | None = None
    state: DriveState | None = None
    values: dict[str, float] = field(default_factory=dict)
    connection: Connection = Connection("searching", "Searching for the drive.")
    on_block: Callable[[Live, Block], None] = lambda *_: None  # what else shall have the rows; must not wait
    on_lost: Callable[[], None] = lambda: None

    def __post_init__(self) -> None:
        self._closing = threading.Event()
        self._news = threading.Event()  # of the drive: ask for its state now
        self._silent: LinkLostError | None = None
        self._numbers = 0
        self._choosing = threading.RLock()
        self._thread = threading.Thread(target=self._run, name="scope feed", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """Stop the motor and hang up."""
        self._closing.set()
        self._news.set()
        if self._thread.is_alive():
            self._thread.join(5.0)

    def need_drive(self) -> Drive:
        drive = self.drive
        if drive is None:
            raise NoDeviceError(f"no drive is connected: {self.connection.text}")
        return drive

    def watch(self, names: Sequence[str], rate_hz: float) -> Live:
        """Stream these signals from now on, also after the drive was unplugged."""
        with self._choosing:
            drive = self.need_drive()
            live = self._stream(drive, tuple(names), rate_hz)
            self.signals, self.rate_hz = live.names, rate_hz
        self.notify("layout")
        return live

    def refresh_values(self) -> dict[str, float]:
        self.values = self.need_drive().get()
        return self.values

    def ask_state_soon(self) -> None:
        self._news.set()

    # ---- connection

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                drive = self.open_drive(lambda _: self._news.set())
            except Exception as error:  # whatever it is: say it, and try again
                self._say("searching", _text(error))
                self._closing.wait(AGAIN_S)
                continue
            text = ""
            try:
                self._attach(drive)
                self._read_on(drive)
            except Exception as error:  # a thread that ends unseen would leave a page that shows the past
                text = _text(error)
            finally:
                self.drive = self.live = self.state = None
                self.on_lost()
                drive.close()
            if not self._closing.is_set():
                self._say("searching", f"{text}. The drive stops by itself; start it again when it is back.")
                self._closing.wait(AGAIN_S)

    def _attach(self, drive: Drive) -> None:
        self._silent = None
        self.values = drive.get()
        self.state = drive.state()
        with self._choosing:
            names = tuple(name for name in self.signals if name in drive.signals) or tuple(drive.signals)[:2]
            self._stream(drive, names[: drive.info.stream_signals], self.rate_hz)
            self.drive = drive
        self._say("connected", drive.port)
        for topic in ("drive", "state", "layout"):
            self.notify(topic)

    def _stream(self, drive: Drive, names: tuple[str, ...], rate_hz: float) -> Live:
        stream = drive.stream(names, rate_hz=rate_hz)
        self._numbers += 1
        self.live = Live(self._numbers, names, rate_hz, stream, History(names))
        return self.live

    def _read_on(self, drive: Drive) -> None:
        asker = threading.Thread(target=self._ask_on, args=(drive,), name="scope state", daemon=True)
        asker.start()
        while not self._closing.is_set() and self._silent is None:
            live = self.live
            assert live is not None
            block = live.stream.read(READ_S)
            if block is not None:
                live.history.append(block.t_s, block.values, gap_before=block.lost_before > 0)
                self.on_block(live, block)
        if self._silent is not None:
            raise self._silent

    def _ask_on(self, drive: Drive) -> None:
        while not self._closing.is_set() and self._silent is None and not drive.link.lost:
            self._news.wait(STATE_S)
            self._news.clear()
            try:
                state = drive.state()
            except Exception as error:  # also an answer that cannot be read: it is not the drive that it was
                if self.drive is drive:
                    self._silent = LinkLostError(str(error))
                return
            if self.drive is drive:
                self.state = state
                self.notify("state")

    def _say(self, status: str, text: str) -> None:
        connection = Connection(status, text)
        if connection != self.connection:
            self.connection = connection
            self.notify("link")


def opener(port: str | None) -> OpenDrive:
    """Opens this port, or the only one there is: also another one after it was plugged in again."""

    def open_drive(on_event: Callable[[Event], None]) -> Drive:
        return Drive.connect(port, on_event=on_event)

    return open_drive


def _text(error: Exception) -> str:
    return error.bare if isinstance(error, EvenspinError) else str(error)
