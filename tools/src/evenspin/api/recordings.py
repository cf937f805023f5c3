"""Recordings of everything that a drive took in."""

from __future__ import annotations

import os
from pathlib import Path

from evenspin.replay import Replayed, Window, replay


def replay_recording(
    path: str | os.PathLike[str],
    *,
    until_s: float | None = None,
    past_fault: bool = False,
    other_firmware: bool = False,
    before_s: float = 0.05,
    after_s: float = 0.01,
) -> Replayed:
    """The firmware once more, from a recording that `evenspin run --record` or `evenspin drive --record` wrote.

    Args:
        path: the recording.
        until_s: stop there at the latest.
        past_fault: do not stop at the first fault.
        other_firmware: replay what another firmware has recorded, up to the first difference.
        before_s: how much of all signals is kept before the fault, or before the end where there is none.
        after_s: how long it goes on after the fault.

    Raises:
        EvenspinError: a recording that is damaged, cut, or of another firmware.
    """
    window = Window(before_s, after_s)
    return replay(Path(path), until_s=until_s, past_fault=past_fault, other_firmware=other_firmware, window=window)
