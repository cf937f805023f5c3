"""The equations of all logs of one machine at one point of all coordinates, and their columns there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.effects.equations import Acting
from evenspin.weakform.equations import Equations, Residual, Timing
from evenspin.weakform.terms import Term

Array = NDArray[np.float64]
Point = dict[str, Array]

LATE, TURNED, LD, LQ, ZERO, ANSWER, CURRENT_LATE = "late", "turned", "ld", "lq", "zero", "answer", "current_late"


@dataclass
class Model:
    """`base`: effects that the model file has already."""

    logs: Sequence[Equations]
    base: Sequence[Acting]
    terms: Sequence[Term]
    late_s: float
    _foreign: dict[tuple[str, int], list[Array]] = field(default_factory=dict)

    def start(self) -> Point:
        return {term.name: term.off.copy() for term in self.terms}

    def acting(self, point: Mapping[str, Array], log: int) -> list[Acting]:
        acting = list(self.base)
        for term in self.terms:
            z = point[term.name]
            if term.hypothesis is not None and np.any(z[~term.details] != 0.0):
                acting.append((term.effect, term.hypothesis.to_params(z)))
        zero = point.get(f"{ZERO}@{log}")
        if zero is not None and zero[0] != 0.0:
            acting.append(("encoder_offset", {"angle_el_rad": float(zero[0])}))
        return acting

    def residual(self, point: Mapping[str, Array], log: int, shaft_only: bool = False) -> list[Array]:
        equations = self.logs[log]
        timing = Timing(self.late_s + _at(point, f"{LATE}@{log}"), _at(point, f"{TURNED}@{log}"))
        scaled = dict(equations.plant)
        scaled["ld_h"] *= 1.0 + _at(point, LD)
        scaled["lq_h"] *= 1.0 + _at(point, LQ)
        there = replace(equations, plant=scaled)
        parts = there.residual(self.acting(point, log), timing, shaft_only).parts()
        for term in self.terms:
            if term.columns is not None and term.log in (None, log) and np.any(point[term.name] != 0.0):
                for k, column in enumerate(self.foreign(term, log)):
                    own = term_columns(column, len(term))
                    if k < len(parts) and own is not None:
                        parts[k] = parts[k] + own @ point[term.name]
        return parts

    def columns_of(self, term: Term, point: Point, log: int, here: Sequence[Array]) -> list[Array]:
        """Per equation, a column per coordinate of a term."""
        matrices = [np.zeros((len(part), len(term))) for part in here]
        if term.log not in (None, log):
            return matrices
        if term.columns is not None:
            for k, column in enumerate(self.foreign(term, log)):
                own = term_columns(column, len(term))
                if k < len(matrices) and own is not None:
                    matrices[k] = own
        else:
            on = np.any(point[term.name][~term.details] != 0.0)
            for j in range(len(term)):
                if term.details[j] and not on:
                    continue
                z = point[term.name].copy()
                z[j] += term.step[j]
                for k, part in enumerate(self.residual({**point, term.name: z}, log, term.shaft_only)):
                    matrices[k][:, j] = (part - here[k]) / term.step[j]
        return matrices

    def foreign(self, term: Term, log: int) -> list[Array]:
        key = (term.name, log)
        if key not in self._foreign:
            assert term.columns is not None
            self._foreign[key] = list(term.columns(self.logs[log]))  # type: ignore[arg-type]
        return self._foreign[key]


def term_columns(column: Array | None, count: int) -> Array | None:
    return None if column is None else np.asarray(column).reshape(-1, count)


def _at(point: Mapping[str, Array], name: str) -> float:
    z = point.get(name)
    return 0.0 if z is None else float(z[0])


__all__ = ["Model", "Point", "Residual"]
