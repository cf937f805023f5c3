"""Terms of the empirical library at a shape, and the logs that they are tried on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.empirical.library import Family, Shape
from evenspin.empirical.rows import Rows
from evenspin.weakform.analysis import ZERO_TERM, Explained
from evenspin.weakform.beyond_rows import columns_of, least_sizes, rows_of, term_of
from evenspin.weakform.equations import Equations
from evenspin.weakform.fit import Gatherer
from evenspin.weakform.model import ZERO, Model
from evenspin.weakform.noise import floors, noise_of
from evenspin.weakform.search import Edges
from evenspin.weakform.terms import SHAFT, Kind, Term
from evenspin.weakform.windows import Windows

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Candidate:
    family: Family
    shape: Shape
    log: int | None
    gain: float


class Search:
    """The logs, the terms that are no cause from outside, and the windows that fit."""

    def __init__(self, found: Explained) -> None:
        self.found = found
        # A shaft was judged on unseen stretches, and is not found here without that.
        known = [term for term in found.model.terms if term.effect != SHAFT or term.name in found.named]
        self.base = [term for term in known if term.kind is not Kind.FOREIGN]
        self.logs: Sequence[Equations] = found.model.logs
        self.scale = found.scale
        self._rows = {
            id(e.signals): rows_of(e, found.scale, found.top_rad_s, _zero(found, k)) for k, e in enumerate(self.logs)
        }
        self.sizes = least_sizes(found.scale, dict(self.logs[0].plant))
        self.floors = [floors(each.equations, noise_of(each.signals)) for each in found.recordings]
        self.fits = [~flags for each in found.recordings for flags in each.unseen]
        stretches = [each.stretch for each in found.recordings]
        everything = [[np.ones(len(flags), dtype=bool) for flags in each.unseen] for each in found.recordings]
        self.stretches = stretches
        self.fundamentals: list[float] = []  # orders of the lines that were chosen
        self.model = Model(self.logs, found.model.base, list(self.base), found.model.late_s)
        self.gatherer = Gatherer(self.model, everything, stretches)
        self.edges = Edges(
            found.tolerances.torque * found.scale.rated_torque_nm,
            found.tolerances.volts * self.logs[0].plant["dc_link_v"],
        )

    def rows(self, e: Equations) -> Rows:
        return self._rows[id(e.signals)]

    def set_terms(self, more: Mapping[str, Candidate]) -> list[Term]:
        self.model.terms = [*self.base, *(self.term(c) for c in more.values())]
        return list(self.model.terms)

    def columns(self, family: Family, shape: Shape, log: int | None) -> list[Array | None]:
        """Over all logs and equations, in the order of the pieces."""
        out: list[Array | None] = []
        for number, e in enumerate(self.logs):
            parts = len(e.windows())
            if log in (None, number):
                out += columns_of(e, family.columns(self.rows(e), shape))[:parts]
            else:
                out += [None] * parts
        return out

    def count(self, family: Family, shape: Shape) -> int:
        return len(family.columns(self.rows(self.logs[0]), shape))

    def term(self, c: Candidate) -> Term:
        logs = self.logs if c.log is None else [self.logs[c.log]]
        sizes = self.sizes
        if c.family.name == "angle_line" and any(_is_multiple(c.shape[0], order) for order in self.fundamentals):
            sizes = {unit: HARMONIC * size for unit, size in sizes.items()}
        return term_of(c.family, c.shape, sizes, self.rows, logs, c.log)

    def windows(self) -> list[tuple[int, int, Windows]]:
        return [(log, k, w) for log, e in enumerate(self.logs) for k, w in enumerate(e.windows())]


def _zero(found: Explained, log: int) -> float:
    names = (ZERO_TERM, f"{ZERO}@{log}")
    return float(sum(found.point[name][0] for name in names if name in found.point))


HARMONIC = 0.35  # of the least size: multiples of a line that is there already


def _is_multiple(order: float, of: float) -> bool:
    times = round(order / of)
    return 2 <= times <= 6 and abs(order / times - of) < 0.004 * of
