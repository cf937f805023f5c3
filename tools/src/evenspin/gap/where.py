"""Where the gap is: residuals of the fit records by signal, speed, load, angle order, transient; before and after."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.evidence import robust_cost
from evenspin.gap.features import SIGNALS, FeatureKey
from evenspin.gap.layout import Layout, Stretch

RPM = math.pi / 30.0
LOAD_SHARE = 0.02  # of the largest load: less is the offset of a torque sensor
WORDS = {
    "mean": "mean level",
    "trend": "trend within a level",
    "curve": "curve within a level",
    "order": "angle order",
    "step": "after a step",
    "ramp": "along a ramp",
    "coast": "coasting down",
}

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Subject:
    """What a feature is about, with the steady stretch that it is of, if it is of one."""

    key: FeatureKey
    stretch: Stretch | None

    @property
    def what(self) -> str:
        return f"order {self.key.order:g}" if self.key.order is not None else WORDS[self.key.kind]

    @property
    def level(self) -> str:
        """Speed level, in rpm; coasting and transients have none."""
        if self.stretch is None or self.stretch.coasting:
            return ""
        return f"{self.stretch.speed_rad_s / RPM:.0f} rpm"


@dataclass(frozen=True, slots=True)
class Contribution:
    """A line of the ranked table."""

    record: str
    signal: str
    what: str
    strongest: str  # speed or load at which it is largest
    share: float  # of the excess of all
    before: float  # rms residual, sigmas
    after: float


@dataclass(frozen=True, slots=True)
class HeatMap:
    """rms residual in sigmas: signals by columns; nan where there is no feature."""

    blocks: tuple[tuple[str, tuple[str, ...]], ...]  # title and its columns
    before: Array
    after: Array


def subjects(keys: Sequence[FeatureKey], layouts: Iterable[Layout]) -> tuple[Subject, ...]:
    """What every feature is about, in the order of the keys; `layouts`: of the fit records."""
    by_record = {layout.record: layout for layout in layouts}
    return tuple(Subject(key, by_record[key.record].steady[key.block] if key.bin is None else None) for key in keys)


def ranked(where: Sequence[Subject], before: Array, after: Array) -> list[Contribution]:
    """Largest share of the excess first. `before`, `after`: residuals in sigmas."""
    groups: dict[tuple[str, str, str], list[int]] = defaultdict(list)
    for i, subject in enumerate(where):
        groups[(subject.key.record, subject.key.signal, subject.what)].append(i)
    loaded = LOAD_SHARE * max((abs(p.stretch.load_nm) for p in where if p.stretch), default=0.0)
    excess = {key: _excess(before[rows]) for key, rows in groups.items()}
    total = sum(excess.values()) or 1.0
    contributions = [
        Contribution(
            *key, _strongest(rows, where, before, loaded), excess[key] / total, _rms(before[rows]), _rms(after[rows])
        )
        for key, rows in groups.items()
    ]
    return sorted(contributions, key=lambda each: -each.share)


def heat_map(where: Sequence[Subject], before: Array, after: Array) -> HeatMap:
    """By record, by speed level (steady running), by angle order, by kind of transient."""
    records = tuple(dict.fromkeys(p.key.record for p in where))
    levels = sorted({p.stretch.speed_rad_s for p in where if p.stretch and not p.stretch.coasting})
    names = tuple(dict.fromkeys(f"{w / RPM:.0f} rpm" for w in levels))
    orders = tuple(f"order {k:g}" for k in sorted({p.key.order for p in where if p.key.order is not None}))
    kinds = tuple(WORDS[k] for k in ("step", "ramp", "coast") if any(p.key.kind == k for p in where))
    blocks = (("record", records), ("steady speed", names), ("angle", orders), ("transient", kinds))
    columns: dict[tuple[str, str, str], list[int]] = defaultdict(list)
    for i, subject in enumerate(where):
        key = subject.key
        columns[("record", key.record, key.signal)].append(i)
        columns[("steady speed", subject.level, key.signal)].append(i)
        columns[("angle" if key.order is not None else "transient", subject.what, key.signal)].append(i)
    filled = tuple((title, names) for title, names in blocks if names)
    places = [(title, name) for title, names in filled for name in names]
    shape = (len(SIGNALS), len(places))
    maps = [np.full(shape, np.nan), np.full(shape, np.nan)]
    for row, signal in enumerate(SIGNALS):
        for column, place in enumerate(places):
            rows = columns.get((*place, signal))
            if rows:
                maps[0][row, column], maps[1][row, column] = _rms(before[rows]), _rms(after[rows])
    return HeatMap(filled, maps[0], maps[1])


def _excess(residual: Array) -> float:
    """Robust cost over what noise of one sigma would have; never negative."""
    return max(0.0, robust_cost(residual) - len(residual))


def _rms(residual: Array) -> float:
    return float(np.sqrt(np.mean(residual**2)))


def _strongest(rows: Iterable[int], where: Sequence[Subject], residual: Array, loaded_nm: float) -> str:
    """At which speed and load (above `loaded_nm`); nothing where the group has none."""
    by_level: dict[str, list[float]] = defaultdict(list)
    for i in rows:
        stretch = where[i].stretch
        if stretch is not None:
            load = f", {stretch.load_nm:.2g} N m" if abs(stretch.load_nm) > loaded_nm else ""
            coasting = "coasting at " if stretch.coasting else ""
            by_level[f"{coasting}{stretch.speed_rad_s / RPM:.0f} rpm{load}"].append(float(residual[i] ** 2))
    return max(by_level, key=lambda level: float(np.mean(by_level[level])), default="")
