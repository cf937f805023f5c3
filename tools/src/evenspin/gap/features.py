"""A record as numbers that do not depend on when the rotor passed: means, trends, angle orders, bins after steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.layout import Bins, Layout, Stretch

SIGNALS = ("speed_rad_s", "id_a", "iq_a", "vd_v", "vq_v")
Label = tuple[str, str, str, str]  # record, signal, kind, detail


@dataclass(frozen=True, slots=True)
class FeatureSet:
    """What one record is boiled down to, always in the same order."""

    layout: Layout
    orders: tuple[float, ...]
    rate_hz: float

    def labels(self) -> list[Label]:
        record = self.layout.record
        out: list[Label] = []
        for i, stretch in enumerate(self.layout.steady):
            where = f"{'coast' if stretch.coasting else 'steady'}{i}"
            names = self._columns(stretch)
            out += [(record, signal, _kind(name), f"{where}:{name}") for name in names for signal in SIGNALS]
        for i, bins in enumerate(self.layout.bins):
            for k in range(len(bins.edges) - 1):
                out += [(record, signal, bins.kind, f"{bins.kind}{i}:{k}") for signal in SIGNALS]
        return out

    def values(self, theta_m_rad: NDArray[np.float64], signals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Features of five signals (columns as SIGNALS) against the drive's own angle."""
        parts = [self._steady(stretch, theta_m_rad, signals) for stretch in self.layout.steady]
        parts += [_bin_means(bins, signals) for bins in self.layout.bins]
        return np.concatenate(parts) if parts else np.zeros(0)

    def _columns(self, stretch: Stretch) -> list[str]:
        base = ["mean", "trend", "curve"] if stretch.coasting else ["mean", "trend"]
        return base + [f"{part}{k:g}" for k in self._visible(stretch) for part in ("cos", "sin")]

    def _visible(self, stretch: Stretch) -> list[float]:
        """Orders that can be told from one another, from a trend, and from their own mirror image in this stretch."""
        if stretch.coasting:
            return [k for k in self.orders if k <= 2.0]
        turns = abs(stretch.speed_rad_s) * (stretch.end - stretch.start) / self.rate_hz / (2.0 * math.pi)
        chosen: list[float] = []
        for k in self.orders:
            cycles = _folded(k * turns, (stretch.end - stretch.start) / 2.0)
            if cycles >= 0.8 and all(
                abs(cycles - _folded(c * turns, (stretch.end - stretch.start) / 2.0)) >= 0.8 for c in chosen
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
    rest = cycles % (2.0 * nyquist)
    return min(rest, 2.0 * nyquist - rest)


def _kind(name: str) -> str:
    return "order" if name.startswith(("cos", "sin")) else name


def _bin_means(bins: Bins, signals: NDArray[np.float64]) -> NDArray[np.float64]:
    first, last = int(bins.edges[0]), int(bins.edges[-1])
    sums = np.add.reduceat(signals[first:last], bins.edges[:-1] - first, axis=0)
    return (sums / np.diff(bins.edges)[:, None]).ravel()
