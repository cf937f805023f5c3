"""The bench: one client for the virtual drive and the real one.

from evenspin.bench import Drive

with Drive.connect() as drive:
    print(drive.info.name, drive.state().state.name)
"""

from evenspin.bench.client import Capture, Drive, FaultReport
from evenspin.bench.messages import Event, Info
from evenspin.bench.numbers import Excite, Mode, State, Trigger
from evenspin.bench.ports import Port, find_ports
from evenspin.bench.stream import Block, Stream

__all__ = [
    "Block", "Capture", "Drive", "Event", "Excite", "FaultReport", "Info", "Mode", "Port", "State", "Stream", "Trigger",
    "find_ports",
]  # fmt: skip
