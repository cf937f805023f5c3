"""The log on an even grid in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.log_reader import Log

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SHAFT = "shaft_iq_a"  # the current without what a measured load takes


@dataclass(frozen=True, slots=True)
class Grid:
    """The log on an even grid. `good`: no gap in time nearby."""

    t_s: Array
    period_s: float
    columns: dict[str, Array]
    gaps_s: Array

    def column(self, name: str, later_s: float = 0.0) -> Array:
        """A column, read `later_s` later: which corrects a known lag."""
        value = self.columns[name]
        return value if later_s == 0.0 else np.interp(self.t_s + later_s, self.t_s, value)

    def good(self, reach_s: float) -> Flags:
        """Rows with no gap and no end of the record within this reach."""
        good = (self.t_s > self.t_s[0] + reach_s) & (self.t_s < self.t_s[-1] - reach_s)
        for start_s, end_s in self.gaps_s:
            good &= (self.t_s < start_s - reach_s) | (self.t_s > end_s + reach_s)
        return good


def grid_of(log: Log) -> Grid:
    count = int(np.floor((log.t_s[-1] - log.t_s[0]) / log.period_s + 1e-6)) + 1
    t_s = log.t_s[0] + log.period_s * np.arange(count)
    given: dict[str, Array | None] = {
        "iq_a": log.iq_a,
        "theta_m_rad": log.theta_m_rad,
        "speed_rad_s": log.speed_rad_s,
        "speed_ref_rad_s": log.speed_ref_rad_s,
    }
    columns = {name: np.interp(t_s, log.t_s, value) for name, value in given.items() if value is not None}
    columns[SHAFT] = columns["iq_a"]
    return Grid(t_s, log.period_s, columns, log.gaps_s)
