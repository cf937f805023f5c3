"""Speed of the simulator, measured around the library call alone."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from typing import Any

from evenspin.model import builtin_scenario
from evenspin.native import load, tables
from evenspin.sim.run import prepare

SCENARIO, METHOD, SIGNAL = "guo2024/first", "fal-forc", "true_speed_rad_s"
ROW_HZ = 100.0  # one signal at a low rate: what is measured is the simulation, not its recording


def measure(runs: int, numeric: str, progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Median over `runs` of simulated time over time, one thread."""
    clock = load(numeric).lib.es_monotonic_s
    setup = builtin_scenario(SCENARIO).with_changes({"method": tables().params["method"].to_number(METHOD)})
    factors = []
    for number in range(runs):
        simulation = prepare(setup, (SIGNAL,), numeric)
        start_s = clock()
        simulation.run(setup.periods, round(setup.pwm_hz / ROW_HZ))
        factors.append(setup.duration_s / (clock() - start_s))
        if progress is not None:
            progress(number + 1)
    return {
        "sim_seconds_per_second": statistics.median(factors),
        "fastest": max(factors),
        "slowest": min(factors),
        "runs": runs,
        "scenario": SCENARIO,
        "method": METHOD,
        "numeric": numeric,
    }
