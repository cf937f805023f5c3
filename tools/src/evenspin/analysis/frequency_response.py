"""A frequency response from rows that a sine of known frequency runs through.

Each part of the rows is fitted, by least squares, with a sine and a cosine of that frequency, a constant and a drift.
Rows may be farther apart than half a period of the sine: its frequency is known exactly, so its image is as good, as
long as it stays away from standing still. A response is the ratio of two such phasors, weighed by that of the
excitation, which is free of what the loop feeds back of the noise (instrumental variable: Soderstrom and Stoica 1989,
"System Identification", chapter 10).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Ratio:
    """Output over input at one frequency."""

    value: complex
    coherence: float  # 0 to 1: share of the power at this frequency, in both signals, that the excitation has caused
    error: float  # half width of the 95 % interval over |value|, from the scatter between the parts

    @property
    def gain_db(self) -> float:
        return 20.0 * math.log10(abs(self.value)) if abs(self.value) > 0.0 else -math.inf

    @property
    def phase_deg(self) -> float:
        return math.degrees(math.atan2(self.value.imag, self.value.real))


def phasors(t_s: Array, values: Array, f_hz: float, parts: int) -> Complex:
    """P of Re(P exp(j 2 pi f t)) in each part of the rows: parts x columns. At least 8 rows a part."""
    bounds = np.linspace(0, len(t_s), parts + 1).astype(int)
    if int(np.min(np.diff(bounds))) < 8:
        raise ValueError(f"{len(t_s)} rows in {parts} parts: at least 8 rows a part are needed")
    found = np.empty((parts, values.shape[1]), dtype=np.complex128)
    for number, (first, last) in enumerate(zip(bounds[:-1], bounds[1:], strict=True)):
        t = t_s[first:last]
        turns = np.mod(f_hz * t, 1.0)
        drift = (t - t.mean()) / (t[-1] - t[0])
        columns = np.column_stack((np.cos(2.0 * np.pi * turns), np.sin(2.0 * np.pi * turns), np.ones_like(t), drift))
        fit, *_ = np.linalg.lstsq(columns, values[first:last], rcond=None)
        found[number] = fit[0] - 1j * fit[1]
    return found


def ratio(output: Complex, source: Complex, excitation: Complex, floor: tuple[float, float]) -> Ratio:
    """Of two signals, part by part. `floor`: what output and source have at this frequency without excitation."""
    reference = excitation / np.abs(excitation)
    weighed_out, weighed_in = output * reference.conj(), source * reference.conj()
    over = weighed_in.mean()
    value = complex(weighed_out.mean() / over) if abs(over) > 0.0 else 0j
    parts = len(output)
    rest = weighed_out - value * weighed_in
    spread = math.sqrt(float(np.sum(np.abs(rest) ** 2)) / (parts * max(parts - 1, 1)))
    error = 2.0 * spread / abs(weighed_out.mean()) if abs(weighed_out.mean()) > 0.0 else math.inf
    coherence = min(_share(weighed_out, floor[0]), _share(weighed_in, floor[1]))
    return Ratio(value, float(coherence), float(error))


def _share(weighed: Complex, floor: float) -> float:
    power = float(np.mean(np.abs(weighed) ** 2)) + floor**2
    return float(abs(weighed.mean()) ** 2) / power if power > 0.0 else 0.0


def frequencies(first_hz: float, last_hz: float, points: int, row_hz: float) -> Array:
    """Evenly spaced over the logarithm; those whose image at this row rate would nearly stand still are moved away from
    it.
    """
    wanted = np.geomspace(first_hz, last_hz, points)
    half, away = 0.5 * row_hz, 0.04 * row_hz
    found = []
    for f_hz in wanted:
        near = half * round(f_hz / half)
        if near > 0.0 and abs(f_hz - near) < away:
            above = near + away
            f_hz = above if f_hz >= near and above <= last_hz else near - away
        found.append(float(f_hz))
    return np.unique(np.round(found, 6))


@dataclass(frozen=True, slots=True)
class Margins:
    """Of a loop gain that was measured point by point; NaN: no crossing in the range."""

    crossover_hz: float
    phase_deg: float
    gain_db: float
    gain_hz: float


def margins(f_hz: Sequence[float], loop: Sequence[complex]) -> Margins:
    """Phase margin where |L| last falls through 1, gain margin where the phase then first passes -180 degrees; straight
    lines between the points, over the logarithm of the frequency."""
    x = np.log(np.asarray(f_hz, dtype=float))
    level = 20.0 * np.log10(np.abs(np.asarray(loop)))
    phase = np.degrees(np.unwrap(np.angle(np.asarray(loop))))
    phase -= 360.0 * round((phase[0] + 90.0) / 360.0)
    falls = [k for k in range(len(x) - 1) if level[k] >= 0.0 > level[k + 1]]
    crossover = phase_margin = math.nan
    start = 0
    if falls:
        start = falls[-1]
        part = level[start] / (level[start] - level[start + 1])
        crossover = math.exp(x[start] + part * (x[start + 1] - x[start]))
        phase_margin = 180.0 + phase[start] + part * (phase[start + 1] - phase[start])
    for k in range(start, len(x) - 1):
        if phase[k] >= -180.0 > phase[k + 1]:
            part = (phase[k] + 180.0) / (phase[k] - phase[k + 1])
            at = math.exp(x[k] + part * (x[k + 1] - x[k]))
            gain_margin = -float(level[k] + part * (level[k + 1] - level[k]))
            return Margins(crossover, float(phase_margin), gain_margin, at)
    return Margins(crossover, float(phase_margin), math.nan, math.nan)
