"""A recording: everything that the firmware took in, as a file from which it runs again (docs/replay.md)."""

from evenspin.recording.file import ENDING, Head, Part, RecordingError, RecordingFile, Writer
from evenspin.recording.player import Difference, Player
from evenspin.recording.recorder import ROWS_EVERY, Recorder

__all__ = [
    "ENDING",
    "ROWS_EVERY",
    "Difference",
    "Head",
    "Part",
    "Player",
    "Recorder",
    "RecordingError",
    "RecordingFile",
    "Writer",
]
