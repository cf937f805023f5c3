"""Simulations side by side, and their results as plain numbers."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

Progress = Callable[[float], None]  # share of the work that is done


def run_all(work: Sequence[Callable[[], Any]], progress: Progress | None) -> list[Any]:
    """Do it on all cores: the library releases the interpreter while it computes."""
    results = []
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        for number, future in enumerate([pool.submit(task) for task in work], start=1):
            results.append(future.result())
            if progress is not None:
                progress(number / len(work))
    return results


def plain(value: Any) -> Any:
    """For JSON: what is not a number becomes null."""
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value
