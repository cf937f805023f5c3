"""What a simulation recorded."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.orders import order_amplitudes
from evenspin.api.frames import to_pandas, to_polars, to_xarray
from evenspin.errors import InputError, did_you_mean
from evenspin.model.setup import Setup
from evenspin.run.outcome import Outcome, outcome_of
from evenspin.sim.record import Record

if TYPE_CHECKING:
    import pandas
    import polars
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

COMMAND = "evenspin.Run.save"
PANEL_INCHES = 1.9


class Run:
    """Signals over time. `run["speed_rad_s"]` is an array of shape (rows,) in the unit of its name."""

    def __init__(self, setup: Setup, record: Record, numeric: str = "float") -> None:
        self.setup = setup
        self.record = record
        self.numeric = numeric

    @property
    def names(self) -> tuple[str, ...]:
        """The signals that were recorded; `t_s` is the first."""
        return self.record.names

    @property
    def units(self) -> dict[str, str]:
        """The unit of each signal, "" where there is none."""
        return dict(zip(self.record.names, self.record.units, strict=True))

    @property
    def t_s(self) -> Array:
        """Time, s, shape (rows,)."""
        return self["t_s"]

    def __getitem__(self, name: str) -> Array:
        if name not in self.record:
            raise InputError("run", "signal", name, "one that was recorded", did_you_mean(str(name), self.names))
        return self.record[name]

    def __contains__(self, name: object) -> bool:
        return name in self.record

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        """Rows."""
        return len(self.record)

    @property
    def values(self) -> Array:
        """All of it, shape (rows, signals), in the order of `names`."""
        return self.record.values

    def between(self, start_s: float, end_s: float) -> Run:
        """Rows with start_s <= t_s < end_s."""
        return Run(self.setup, self.record.between(start_s, end_s), self.numeric)

    @property
    def outcome(self) -> Outcome:
        """What became of it: `word` ("ran", "stayed", "tripped", "oscillates"), `text`, `good`. Needs every signal."""
        from evenspin.run import run_signals

        self._need_all(run_signals(), "outcome")
        return outcome_of(self.setup, self.record)

    def summary(self) -> dict[str, Any]:
        """The run in numbers, as summary.json of `evenspin run` has it: `outcome`, and `segments` with the ripple of
        each steady state and what happened after each change. Needs every signal."""
        from evenspin.run import run_signals, summary_of

        self._need_all(run_signals(), "summary")
        return summary_of(self.setup, self.record, self.numeric)

    def orders(self, signal: str = "true_speed_rad_s", orders: Sequence[int] = (1, 2, 6), per: str = "turn") -> Array:
        """Amplitudes of orders, in the unit of the signal, shape (orders,).

        Args:
            signal: what is examined; it should be in a steady state, see `between`.
            orders: whole numbers from 1.
            per: "turn" of the rotor, or "electrical" turn.
        """
        if per not in ("turn", "electrical"):
            raise InputError("orders", "per", per, "turn or electrical", did_you_mean(per, ("turn", "electrical")))
        wanted = tuple(orders)
        if not wanted or any(order != int(order) or order < 1 for order in wanted):
            raise InputError("orders", "orders", wanted, "whole numbers from 1", "correct them")
        angle = self["true_theta_m_rad"] * (1.0 if per == "turn" else self.setup.plant["pole_pairs"])
        return order_amplitudes(self[signal], angle, tuple(int(order) for order in wanted))

    def to_pandas(self) -> pandas.DataFrame:
        """A frame with a column per signal and the index t_s; units in `frame.attrs["units"]`. Needs pandas."""
        return to_pandas(self.record)

    def to_polars(self) -> polars.DataFrame:
        """A frame with a column per signal, t_s among them. Needs polars."""
        return to_polars(self.record)

    def to_xarray(self) -> xarray.Dataset:
        """A data set over t_s with a variable per signal, each with its `units`. Needs xarray."""
        return to_xarray(self.record)

    def plot(self, *signals: str) -> Figure:
        """A matplotlib figure, a panel per signal below each other; true speed and q current when none is named."""
        from evenspin.report.curves import envelope
        from evenspin.report.style import OTHER_COLOURS, drawing, subplots

        chosen = signals or ("true_speed_rad_s", "true_iq_a")
        curves = [(name, *envelope(self.t_s, self[name])) for name in chosen]
        with drawing():
            figure, axes = subplots(len(chosen), height=PANEL_INCHES * len(chosen) + 0.4, sharex=True)
            for panel, (name, t_s, value) in zip(axes.flat, curves, strict=True):
                panel.plot(t_s, value, color=OTHER_COLOURS[0])
                panel.set_ylabel(f"{name} [{self.units[name]}]" if self.units[name] else name)
            axes.flat[-1].set_xlabel("time [s]")
        return figure

    def save(self, folder: str | os.PathLike[str], *, force: bool = False) -> Path:
        """What `evenspin run --out` writes: log, truth, summary, report.html. Needs every signal.

        Args:
            folder: new, empty, or what this wrote before and nobody has changed.
            force: replace also what another command made, and what was changed.
        """
        from evenspin.output import OutputFolder
        from evenspin.output.origin import Origin
        from evenspin.run import run_signals, write_run

        self._need_all(run_signals(), "save")
        with OutputFolder(Path(folder), Origin(COMMAND), option="save", force=force) as place:
            write_run(place, self.setup, self.record, self.summary(), COMMAND)
        return Path(folder)

    def _need_all(self, names: Sequence[str], what: str) -> None:
        missing = [name for name in names if name not in self.record]
        if missing:
            given = f"{len(self.names)} of {len(names)}"
            raise InputError(what, "signals", given, "all of them", "simulate without a list of signals")

    def __repr__(self) -> str:
        return f"Run({self.setup.name!r}, {len(self)} rows, {len(self.names)} signals)"
