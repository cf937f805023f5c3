"""From a guess about the machine to the features of every record: the simulation in the loop, on all cores."""

from __future__ import annotations

import copy
import os
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from evenspin.compare import Replay
from evenspin.effects import Scale, known_orders
from evenspin.gap.features import SIGNALS, FeatureKey, FeatureSet
from evenspin.gap.layout import Layout, layout_of
from evenspin.log.case import Case
from evenspin.log.experiments import VALIDATION
from evenspin.log.unit import Unit

READ = ("theta_m_rad", *SIGNALS)
KEPT = 128  # simulated machines whose features are kept: a search comes back to the same points


Key = tuple[object, ...]


def _key_of(unit: Unit) -> Key:
    effects = tuple((name, tuple(sorted(params.items()))) for name, params in sorted(unit.effects.items()))
    return effects, tuple(sorted(unit.factors.items())), unit.noise_seed, unit.count_part


def _touches(key: FeatureKey, layout: Layout, uncertain: Mapping[str, NDArray[np.bool_]]) -> bool:
    rows = uncertain.get(key.record)
    if rows is None or key.bin is None:
        return False
    edges = layout.bins[key.block].edges
    return bool(rows[int(edges[key.bin]) : int(edges[key.bin + 1])].any())


class Forward:
    """The fit records of a case. `features(unit)` is what such a unit would have logged, reduced to features."""

    def __init__(self, case: Case, workers: int | None = None) -> None:
        self.case = case
        self.orders = known_orders(Scale.of(case.meta["motor"], float(case.meta["encoder"]["counts_per_rev"])))
        self.replays: list[Replay] = []
        self.sets: list[FeatureSet] = []
        self._measured_rows: list[NDArray[np.float64]] = []
        starts = case.starts_s()
        for name, record in case.experiments.items():
            if name in VALIDATION:
                continue
            replay = Replay(case.path, case.meta, name, record, starts[name])
            features = FeatureSet(
                layout_of(replay, record), self.orders, 1.0 / float(np.median(np.diff(record["t_s"])))
            )
            self.replays.append(replay)
            self.sets.append(features)
            self._measured_rows.append(np.ascontiguousarray(record.pick(READ).values))
        self.keys: list[FeatureKey] = [key for features in self.sets for key in features.keys()]
        self.measured = self.reduced(self._measured_rows)
        self.compared = np.ones(len(self.keys), dtype=np.bool_)
        self._pool = ThreadPoolExecutor(workers or os.cpu_count() or 1)
        self.simulations = 0
        self._kept: OrderedDict[Key, NDArray[np.float64]] = OrderedDict()

    def on(self, case: Case, uncertain: Mapping[str, NDArray[np.bool_]]) -> Forward:
        """The same simulations held against other records of the same experiments.

        `uncertain`: rows of a record that say nothing; a bin that has one of them is not compared.
        """
        other = copy.copy(self)
        other.case = case
        other._measured_rows = [
            np.ascontiguousarray(case.experiments[each.layout.record].pick(READ).values) for each in self.sets
        ]
        other.measured = other.reduced(other._measured_rows)
        layouts = {each.layout.record: each.layout for each in self.sets}
        other.compared = np.array([not _touches(key, layouts[key.record], uncertain) for key in self.keys])
        return other

    def rows(self, index: int) -> NDArray[np.float64]:
        """What was measured, columns as READ."""
        return self._measured_rows[index]

    def simulate(self, unit: Unit) -> list[NDArray[np.float64]]:
        """Per record: rows with the columns READ, as far as they are compared."""
        self.simulations += 1
        return [
            replay.run(READ, unit, features.layout.end)
            for replay, features in zip(self.replays, self.sets, strict=True)
        ]

    def features(self, unit: Unit) -> NDArray[np.float64]:
        """The same machine with the same noise logs the same: it is simulated once."""
        key = _key_of(unit)
        found = self._kept.get(key)
        if found is None:
            found = self.reduced(self.simulate(unit))
            found.setflags(write=False)
            self._kept[key] = found
            while len(self._kept) > KEPT:
                self._kept.popitem(last=False)
        return found

    def reduced(self, records: list[NDArray[np.float64]]) -> NDArray[np.float64]:
        parts = [
            features.values(rows[:, 0], np.ascontiguousarray(rows[:, 1:]))
            for features, rows in zip(self.sets, records, strict=True)
        ]
        return np.concatenate(parts)

    def many(self, units: Sequence[Unit], done: Callable[[], None] | None = None) -> list[NDArray[np.float64]]:
        """Simulate several machines in parallel; the library runs without holding Python back."""
        out = []
        for result in self._pool.map(self.features, units):
            out.append(result)
            if done is not None:
                done()
        return out

    def close(self) -> None:
        self._pool.shutdown(wait=False, cancel_futures=True)
