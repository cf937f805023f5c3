"""evenspin: makes a permanent-magnet synchronous motor turn evenly.

The names below load when they are used: `import evenspin` stays quick.

    evenspin.blocks      the control blocks of the firmware, one call each
    evenspin.model       model and scenario files
    evenspin.sim         run a scenario through the firmware
    evenspin.log         the measured-log format
    evenspin.analysis    orders, distortion, overshoot
    evenspin.bench       a drive on the bench, real or virtual
"""

from __future__ import annotations

import importlib
from types import ModuleType

_PARTS = ("analysis", "bench", "blocks", "design", "log", "model", "native", "report", "reproduce", "sim")

__all__ = [*_PARTS, "version"]


def version() -> str:
    """Version of the installed package."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        return installed("evenspin")
    except PackageNotFoundError:
        return "0+unknown"


def __getattr__(name: str) -> ModuleType:
    if name in _PARTS:
        return importlib.import_module(f"evenspin.{name}")
    raise AttributeError(f"module 'evenspin' has no attribute '{name}'")
