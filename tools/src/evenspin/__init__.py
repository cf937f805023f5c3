"""evenspin: makes a permanent-magnet synchronous motor turn evenly.

    import evenspin as es

    run = es.load("guo2024/first").change(method="fal-forc").simulate()
    run["speed_rad_s"], run.to_pandas(), run.plot()

`load`, `Scenario`, `Run`, `find_gap`, `Gap`, `name_plate`, `replay_recording`, `list_scenarios` and the other lists,
and `EvenspinError` are the library for users (docs/api.md). The packages below are what it is made of:

    evenspin.blocks      the control blocks of the firmware, one call each
    evenspin.model       model and scenario files
    evenspin.sim         run a scenario through the firmware
    evenspin.log         the measured-log format
    evenspin.analysis    orders, distortion, overshoot
    evenspin.bench       a drive on the bench, real or virtual

All of it loads when it is used: `import evenspin` stays quick.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from evenspin.api import (
        EvenspinError,
        Gap,
        Replayed,
        Run,
        Scenario,
        find_gap,
        list_effects,
        list_models,
        list_parameters,
        list_scenarios,
        list_signals,
        load,
        name_plate,
        replay_recording,
    )
    from evenspin.build import version

_PARTS = ("analysis", "bench", "blocks", "design", "log", "model", "native", "report", "reproduce", "sim")

__all__ = [
    "EvenspinError",
    "Gap",
    "Replayed",
    "Run",
    "Scenario",
    "list_effects",
    "find_gap",
    "load",
    "list_models",
    "name_plate",
    "replay_recording",
    "list_parameters",
    "list_scenarios",
    "list_signals",
    "version",
]


def __getattr__(name: str) -> Any:
    if name in _PARTS:
        return importlib.import_module(f"evenspin.{name}")
    if name == "version":
        return importlib.import_module("evenspin.build").version
    if name in __all__:
        return getattr(importlib.import_module("evenspin.api"), name)
    from evenspin.errors import did_you_mean

    raise AttributeError(f"module 'evenspin' has no attribute '{name}'; {did_you_mean(name, [*__all__, *_PARTS])}")


def __dir__() -> list[str]:
    return sorted([*__all__, *_PARTS])
