"""A record as numbers that do not depend on when the rotor passed: means, trends, angle orders, bins after steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.layout import Bins, Layout, Stretch
from evenspin.gap.thresholds_evidence import COAST_ORDER_MAX, ORDER_CYCLES

SIGNALS = ("speed_rad_s", "id_a", "iq_a", "vd_v", "vq_v")


@dataclass(frozen=True, slots=True)
class FeatureKey:
    """What one feature is about."""

    record: str
    signal: str
    kind: str  # "mean", "trend", "curve" or "order" of a stretch; "step", "ramp" or "coast": a bin
    block: int  # which of the layout's steady stretches, or of its runs of bins
    coasting: bool = False  # the stretch
    order: float | None = None  # mechanical
    part: str = ""  # "cos" or "sin" of the order
    bin: int | None = None  # of the run of bins

    @property
    def group(self) -> tuple[str, str, str]:
        """Features that have a noise level in common."""
        return self.record, self.signal, self.kind

    def __str__(self) -> str:
        if self.bin is not None:
            return f"{self.record} {self.signal} {self.kind}{self.block}:{self.bin}"
        what = self.kind if self.order is None else f"{self.part}{self.order:g}"
        return f"{self.record} {self.signal} {'coast' if self.coasting else 'steady'}{self.block}:{what}"


@dataclass(frozen=True, slots=True)
class FeatureSet:
    """What one record is reduced to, always in the same order."""

    layout: Layout
    orders: tuple[float, ...]
    rate_hz: float

    def keys(self) -> list[FeatureKey]:
        """One a value, in their order."""
        record = self.layout.record
        out: list[FeatureKey] = []
        for i, s in enumerate(self.layout.steady):
            for kind, order, part in self._columns(s):
                out += [FeatureKey(record, signal, kind, i, s.coasting, order, part) for signal in SIGNALS]
        for i, bins in enumerate(self.layout.bins):
            for k in range(len(bins.edges) - 1):
                out += [FeatureKey(record, signal, bins.kind, i, bin=k) for signal in SIGNALS]
        return out

    def values(self, theta_m_rad: NDArray[np.float64], signals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Features of five signals (columns as SIGNALS) against the drive's own angle."""
        parts = [self._steady(stretch, theta_m_rad, signals) for stretch in self.layout.steady]
        parts += [_bin_means(bins, signals) for bins in self.layout.bins]
        return np.concatenate(parts) if parts else np.zeros(0)

    def _columns(self, stretch: Stretch) -> list[tuple[str, float | None, str]]:
        """Kind, order and part of each column of the fit to a stretch."""
        shape = ("mean", "trend", "curve") if stretch.coasting else ("mean", "trend")
        return [(kind, None, "") for kind in shape] + [
            ("order", k, part) for k in self._visible(stretch) for part in ("cos", "sin")
        ]

    def _visible(self, stretch: Stretch) -> list[float]:
        """Orders that this stretch separates from one another, from a trend, and from their own mirror image."""
        if stretch.coasting:
            return [k for k in self.orders if k <= COAST_ORDER_MAX]
        turns = abs(stretch.speed_rad_s) * (stretch.end - stretch.start) / self.rate_hz / (2.0 * math.pi)
        chosen: list[float] = []
        for k in self.orders:
            cycles = _folded(k * turns, (stretch.end - stretch.start) / 2.0)
            if cycles >= ORDER_CYCLES and all(
                abs(cycles - _folded(c * turns, (stretch.end - stretch.start) / 2.0)) >= ORDER_CYCLES for c in chosen
            ):
                chosen.append(k)
        return chosen

    def _steady(self, s: Stretch, theta: NDArray[np.float64], signals: NDArray[np.float64]) -> NDArray[np.float64]:
        angle = theta[s.start : s.end]
        x = np.linspace(-1.0, 1.0, s.end - s.start)
        columns = [np.ones_like(x), x] + ([x * x - 1.0 / 3.0] if s.coasting else [])
        for k in self._visible(s):
            columns += [np.cos(k * angle), np.sin(k * angle)]
        a = np.stack(columns, axis=1)
        gram = a.T @ a
        gram[np.diag_indices_from(gram)] *= 1.0 + 1e-9  # a rotor that stands makes columns equal
        return np.asarray(np.linalg.solve(gram, a.T @ signals[s.start : s.end]), dtype=np.float64).ravel()


def _folded(cycles: float, nyquist: float) -> float:
    folded = cycles % (2.0 * nyquist)
    return min(folded, 2.0 * nyquist - folded)


def _bin_means(bins: Bins, signals: NDArray[np.float64]) -> NDArray[np.float64]:
    first, last = int(bins.edges[0]), int(bins.edges[-1])
    sums = np.add.reduceat(signals[first:last], bins.edges[:-1] - first, axis=0)
    return (sums / np.diff(bins.edges)[:, None]).ravel()
