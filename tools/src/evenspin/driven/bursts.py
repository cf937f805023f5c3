"""Torque that comes and goes: moments at which the balance of torque is far off, while it holds nearly all the time.

Their rms over a log is small, so that what is left of the whole says little of them; a fit is robust against them, and
no term of constant form describes them: impacts, a tool that cuts, a load machine whose torque is not in the log.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from evenspin.weakform.analysis import Explained

SCATTERS = 6.0  # of what is left nearly always
RATED_SHARE = 0.04  # of the rated torque: no window of twelve healthy logs of blind sets leaves more
MOVED_SHARE = 0.5  # of the torque that accelerates: rows that are late by a part of a window leave a tenth of it
LEAST = 8  # moments; one or two are a knock against the bench
TORQUE = 0  # place of the long windows among the equations of a log


@dataclass(frozen=True, slots=True)
class Bursts:
    """Of one log. `torque_nm`: the median over the moments of the largest that is left in each."""

    log: str
    count: int
    span_s: float
    torque_nm: float

    def __str__(self) -> str:
        return (
            f"{self.log}: {self.count} times in {self.span_s:.3g} s the torque is off for a moment, by "
            f"{self.torque_nm:.3g} N m at the median, and holds between them: impacts, bursts, or steps of a load that "
            "is not in the log"
        )


def bursts_of(found: Explained) -> list[Bursts]:
    """Of each log in which there are some."""
    there = []
    for log, recording in enumerate(found.recordings):
        windows = recording.equations.shaft
        left = np.abs(found.after[log][TORQUE])
        if len(left) == 0:
            continue
        least_nm = max(SCATTERS * 1.4826 * float(np.median(left)), RATED_SHARE * found.scale.rated_torque_nm)
        moved_nm = found.model.logs[log].plant["inertia_kgm2"] * np.abs(recording.equations.acceleration(windows))
        far = np.flatnonzero(left > np.maximum(least_nm, MOVED_SHARE * moved_nm))
        if len(far) == 0:
            continue
        apart = np.diff(windows.centre[windows.used][far]) > windows.bump.rows  # share no row
        moments = np.split(left[far], np.flatnonzero(apart) + 1)
        if len(moments) >= LEAST:
            span_s = len(recording.signals) * recording.signals.period_s
            sizes_nm = [float(np.max(each)) for each in moments]
            there.append(Bursts(recording.signals.name, len(moments), span_s, float(np.median(sizes_nm))))
    return there
