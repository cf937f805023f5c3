"""What a model leaves: lines in the spectrum of steady running that no order of the model takes up."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.features import SIGNALS
from evenspin.gap.forward import Forward
from evenspin.gap.thresholds_evidence import REPEAT_PEAK_SHARE, SPECTRUM_FLOOR_SHARE
from evenspin.log.unit import Unit

SMOOTH_BINS = 5
SKIP_BINS = 2  # trend and window

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Line:
    """A line that the log has and the model has not."""

    record: str
    signal: str
    speed_rad_s: float
    hz: float
    order: float  # mechanical
    amplitude: float  # in the signal's unit
    ratio: float  # power over what the model's noise has there
    seconds: float = math.nan  # of the stretch: a bin of its spectrum is one over that


def spectra(forward: Forward, rows: list[Array]) -> list[Array]:
    """Power spectra (bins x signals) of each steady stretch of each record, hann-windowed, known orders left in."""
    out = []
    for features, values in zip(forward.sets, rows, strict=True):
        for s in features.layout.steady:
            if s.coasting:
                continue
            x = values[s.start : s.end, 1:]
            n = len(x)
            ramp = np.linspace(-1.0, 1.0, n)[:, None]
            x = x - x.mean(axis=0)
            x = x - ramp * (np.sum(ramp * x, axis=0) / np.sum(ramp**2))
            window = np.hanning(n)[:, None]
            out.append(np.abs(np.fft.rfft(x * window, axis=0)) ** 2 / np.sum(window**2))
    return out


def leftover_lines(forward: Forward, model_units: list[Unit], keep: int) -> list[Line]:
    """Lines of the log over the spread of the model's repeats, strongest first."""
    measured = spectra(forward, [forward.rows(i) for i in range(len(forward.sets))])
    repeats = [spectra(forward, forward.simulate(unit)) for unit in model_units]
    lines: list[Line] = []
    at = 0
    for features in forward.sets:
        for s in features.layout.steady:
            if s.coasting:
                continue
            power = np.array([run[at] for run in repeats])
            # what a bin and its neighbours have in any repeat; a line that the model has shows there too
            level = _spread(np.maximum(power.mean(axis=0), REPEAT_PEAK_SHARE * power.max(axis=0)))
            lines += _lines(
                features.layout.record, s.speed_rad_s, (s.end - s.start) / features.rate_hz, measured[at], level
            )
            at += 1
    return sorted(lines, key=lambda line: -line.ratio)[:keep]


def _spread(level: Array) -> Array:
    """Smoothed, but never below what one of the neighbouring bins has."""
    kernel = np.ones(SMOOTH_BINS) / SMOOTH_BINS
    smooth = np.stack([np.convolve(column, kernel, mode="same") for column in level.T], axis=1)
    padded = np.pad(level, ((2, 2), (0, 0)), mode="edge")
    near = np.max([padded[k : k + len(level)] for k in range(5)], axis=0)
    return np.maximum(smooth, near)


def _lines(record: str, speed: float, seconds: float, measured: Array, level: Array) -> list[Line]:
    out = []
    for column, signal in enumerate(SIGNALS):
        base = level[:, column]
        if not np.any(base > 0.0):
            continue
        noise = np.maximum(base, SPECTRUM_FLOOR_SHARE * float(np.median(base[base > 0.0])))
        ratio = measured[:, column] / noise
        ratio[:SKIP_BINS] = 0.0
        peak = int(np.argmax(ratio))
        hz = peak / seconds
        turns_per_s = abs(speed) / math.tau
        amplitude = math.sqrt(float(measured[peak, column]) * 4.0 / max(1.0, 2 * (len(measured) - 1)) * 1.5)
        out.append(
            Line(
                record,
                signal,
                speed,
                hz,
                hz / turns_per_s if turns_per_s > 0 else math.nan,
                amplitude,
                float(ratio[peak]),
                seconds,
            )
        )
    return out
