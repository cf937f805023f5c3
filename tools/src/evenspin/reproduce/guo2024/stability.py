"""Does the repetitive controller settle? In the time domain, through the firmware."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from evenspin.analysis.segments import RAD_S, WINDOW_S
from evenspin.model import builtin_scenario
from evenspin.native import tables
from evenspin.sim import simulate


@dataclass(frozen=True, slots=True)
class Trial:
    """A learning gain and the peak-to-peak speed that it has to leave behind."""

    method: str
    k_rc: float
    low_rpm: float
    high_rpm: float
    expectation: str

    @property
    def name(self) -> str:
        return f"{self.method} at k_rc {self.k_rc:g}: {self.expectation}"


# Residues of a stable controller are below 1 rpm peak to peak; a limit cycle of fal stays small, an unstable FORC grows
# until the current limit stops it.
TRIALS = (
    Trial("forc", 1.35, 0.1, 1.5, "stable"),
    Trial("forc", 1.8, 50.0, 2000.0, "unstable"),
    Trial("fal-forc", 0.968, 0.1, 1.5, "clean"),
    Trial("fal-forc", 1.36, 3.0, 30.0, "limit cycle"),
)


def ripple_rpm(trial: Trial, numeric: str) -> float:
    """Peak-to-peak true speed in the steady window of the stability scenario."""
    scenario = builtin_scenario("guo2024/stability")
    method = tables().params["method"].to_number(trial.method)
    setup = scenario.with_changes({"method": method, "rc_gain": trial.k_rc})
    record = simulate(setup, ("t_s", "true_speed_rad_s"), numeric)
    window = record.between(setup.duration_s - WINDOW_S, setup.duration_s)
    return float(np.ptp(window["true_speed_rad_s"]) / RAD_S)


def as_json(trial: Trial, measured_rpm: float) -> dict[str, Any]:
    return {
        "method": trial.method,
        "k_rc": trial.k_rc,
        "expectation": trial.expectation,
        "peak_to_peak_rpm": measured_rpm,
        "settles": measured_rpm < TRIALS[0].high_rpm,
    }
