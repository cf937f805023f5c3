"""The search for one case: which effects, how large. Screening is cheap, refinement has the simulation in the loop."""

from __future__ import annotations

import math

from evenspin.gap import screening
from evenspin.gap.candidate import Candidate, Model
from evenspin.gap.fitting import Fitter
from evenspin.gap.screening import Signature
from evenspin.gap.strategies import Downhill, strategy_for

STEPS_MAX = 8


class Search:
    """Screening and refinement around the explanation that stands at the moment.

    `fitter` is the view of the log that all costs are taken by. `reconsider` replaces it; models from before have to be
    judged again (`fitter.judged`) before their costs compare.
    """

    def __init__(self, fitter: Fitter, nothing: Model) -> None:
        self.fitter = fitter
        self.nothing = nothing  # the machine without any effect
        self._of_nothing: list[Signature] | None = None
        self._of_last: tuple[Model, frozenset[str] | None, list[Signature]] | None = None

    def reconsider(self, model: Model) -> None:
        """Take noise level and tolerances around a model from now on."""
        self.fitter = self.fitter.around(model)

    def candidates(
        self,
        model: Model,
        size: int = 1,
        keep: int = 6,
        borrowed: bool = False,
        among: frozenset[str] | None = None,
    ) -> list[Candidate]:
        """Sets of `size` more effects, best first, as a linear fit sees them; one candidate a set of names.

        `borrowed`: with the signatures of the bare machine, which cost nothing more; good enough to see which effects
        are not left to find. `among`: only these effects; None: all.
        """
        known = self._signatures(self.nothing, None) if borrowed else self._signatures(model, among)
        return screening.candidates(self.fitter, model, known, size, keep)

    def refine(
        self, candidate: Candidate | Model, steps: int = STEPS_MAX, beat: float = math.inf, downhill: bool = False
    ) -> Model:
        """The best model found from a candidate; gives up where a cost of `beat` is out of reach.

        `downhill`: only downhill from where the candidate is, also for effects whose cost has many minima. A model was
        refined before and goes on downhill in any case.
        """
        if downhill or isinstance(candidate, Model):
            return Downhill().refine(self.fitter, candidate, steps, beat)
        strategy = strategy_for(self.fitter, candidate)
        return strategy.refine(self.fitter, candidate, steps, beat)

    def _signatures(self, model: Model, among: frozenset[str] | None) -> list[Signature]:
        """Signatures cost simulations: those of the bare machine and of the last model are kept."""
        if model is self.nothing:
            if self._of_nothing is None:
                self._of_nothing = screening.signatures(self.fitter, model)
            return self._of_nothing
        if self._of_last is None or self._of_last[0] is not model or self._of_last[1] != among:
            self._of_last = (model, among, screening.signatures(self.fitter, model, among))
        return self._of_last[2]
