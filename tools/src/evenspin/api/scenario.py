"""A scenario: what happens to a drive, and when."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from evenspin.api.run import Run
from evenspin.errors import InputError, NativeError, did_you_mean
from evenspin.model.changes import changes_of
from evenspin.model.document import Document, document_of
from evenspin.model.scenario import Scenario as Checked
from evenspin.model.scenario import scenario_document, scenario_from
from evenspin.native import NUMERICS, tables
from evenspin.run.outcome import stopped
from evenspin.sim import simulate

if TYPE_CHECKING:
    from evenspin.grid import Grid
    from evenspin.tune.tuning import Tuning


class Scenario:
    """A scenario with its model; `load` makes one. It never changes: `change` gives another."""

    def __init__(self, document: Document, changed: Mapping[str, Any] | None = None) -> None:
        self._document = document
        self._changed = dict(changed or {})
        self._checked = scenario_from(document, changes_of(self._changed, document))

    @property
    def name(self) -> str:
        """As the file says it."""
        return self._checked.setup.name

    @property
    def duration_s(self) -> float:
        """Simulated time, s."""
        return self._checked.setup.duration_s

    @property
    def drive(self) -> dict[str, float | int | bool | str]:
        """Every parameter of the drive by name, choices as words."""
        fields = tables().params
        setup = self._checked.setup.drive
        return {
            name: fields[name].to_text(value)
            if fields[name].kind == "choice"
            else bool(value)
            if fields[name].kind == "flag"
            else int(value)
            if fields[name].kind == "integer"
            else value
            for name, value in setup.items()
        }

    @property
    def plant(self) -> dict[str, float]:
        """Every number of the simulated machine by name."""
        return dict(self._checked.setup.plant)

    @property
    def effects(self) -> dict[str, dict[str, float]]:
        """Effects of model and scenario with what they state."""
        return {name: dict(params) for name, params in self._checked.setup.effects.items()}

    @property
    def checked(self) -> Checked:
        """What it comes to, in the terms of `evenspin.model`."""
        return self._checked

    def change(self, changes: Mapping[str, Any] | None = None, /, **named: Any) -> Scenario:
        """The same with other values, as if they were written in its files.

        Args:
            changes: by name, for names with a dot: `{"cogging.amplitude_nm": 0.02, "event.2.load_brake_a": 1.0}`.
            named: the same as keywords: `method="fal-forc+dob"`, `rc_gain=0.4`, `inertia_kgm2=1e-4`, `seed=3`,
                `duration_s=4.0`, `cogging={"amplitude_nm": 0.02, "order": 12}`.

        Raises:
            EvenspinError: no such name, with what was probably meant, or a value that is not allowed.
        """
        return Scenario(self._document, {**self._changed, **(changes or {}), **named})

    def simulate(self, signals: Sequence[str] | None = None, *, numeric: str = "float") -> Run:
        """Run the firmware on the machine, from rest to `duration_s`.

        Args:
            signals: names of `evenspin.list_signals()`; every one when left out.
            numeric: "float" or "fixed", the arithmetic of the firmware.

        Warns:
            UserWarning: the drive never ran, or tripped; `Run.outcome` says what became of it.
        """
        if isinstance(signals, str):
            raise InputError("simulate", "signals", signals, "a list of names", f'write ["{signals}"]')
        for name in signals or ():
            if name not in tables().signals:
                raise InputError("simulate", "signal", name, "a signal", did_you_mean(name, tables().signals))
        if numeric not in NUMERICS:
            raise InputError("simulate", "numeric", numeric, "float or fixed", did_you_mean(numeric, NUMERICS))
        setup = self._checked.setup
        wanted = tuple(dict.fromkeys(("t_s", *(tables().signals if signals is None else signals))))
        try:
            run = Run(setup, simulate(setup, wanted, numeric), numeric)
        except NativeError as error:
            raise self._checked.locate(error) from None
        if "state" in run and "fault" in run and (text := stopped(setup, run.record)):
            warnings.warn(text, stacklevel=2)
        return run

    def sweep(
        self,
        axes: Mapping[str, Iterable[Any]] | None = None,
        /,
        *,
        workers: int | None = None,
        numeric: str = "float",
        **named: Iterable[Any],
    ) -> Grid:
        """Every combination of these values, on all cores.

        Args:
            axes: names as `change` takes them, each with its values: `{"cogging.amplitude_nm": [0.0, 0.01, 0.02]}`.
            workers: runs at a time, one per core when left out.
            numeric: as `simulate` has it.
            named: the same as keywords: `method=["pi", "forc"], rc_gain=numpy.linspace(0.1, 0.5, 5)`.

        Returns:
            Grid: `rows`, a mapping for each run and each of its steady states or motions; `to_pandas()`.
        """
        from evenspin.grid import axes_of, run_grid

        given = axes_of({**(axes or {}), **named})
        return run_grid(self._document, given, self._changed, workers=workers, numeric=numeric)

    def tune(self, goal: str = "smooth", *, methods: bool = False) -> Tuning:
        """Parameters for its machine: `tuning.drive` by name, `tuning.good`, `tuning.problems`.

        Args:
            goal: "stiff", "smooth" or "quiet".
            methods: try every method against ripple, too, which takes longest.
        """
        from evenspin.tune.tuning import tune

        return tune(self._checked.machine, goal, methods=methods)

    def tuned(self, goal: str = "smooth") -> Scenario:
        """The same with the drive that `tune` proposes for its machine."""
        fields = tables().params
        return self.change({f"drive.{name}": value for name, value in self.tune(goal).drive.items() if name in fields})

    def __repr__(self) -> str:
        changed = "".join(f", {name}={value!r}" for name, value in self._changed.items())
        return f"Scenario({self.name!r}{changed})"


def load(scenario: str | os.PathLike[str] | Mapping[str, Any]) -> Scenario:
    """A scenario by its name, from its file, or from its keys and values.

    Args:
        scenario: a name of `evenspin.list_scenarios()`, a file .toml, or a mapping with what such a file has; there
            `model` may be a mapping, too, with `plant`, `drive` and `effects`.
    """
    if isinstance(scenario, Mapping):
        return Scenario(document_of({"name": "own"} | dict(scenario), "scenario", Path()))
    if not isinstance(scenario, str | os.PathLike):
        raise InputError("load", "scenario", scenario, "a name, a file or a mapping", "see evenspin.list_scenarios()")
    return Scenario(scenario_document(os.fspath(scenario)))
