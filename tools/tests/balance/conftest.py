"""The real logs, each analysed once."""

from __future__ import annotations

from pathlib import Path

import balance_recordings as recordings
import pytest
from evenspin.balance import BalanceResult, run_balance


def _run(name: str, model: Path | None, folder: Path) -> BalanceResult:
    return run_balance(recordings.REAL / f"{name}.csv.gz", model, folder)


@pytest.fixture(scope="session")
def free_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[BalanceResult, Path]:
    """acc_current: the free motor, its speed swept through zero."""
    folder = tmp_path_factory.mktemp("acc_current")
    return _run("acc_current", None, folder), folder


@pytest.fixture(scope="session")
def speed_test(
    free_run: tuple[BalanceResult, Path], tmp_path_factory: pytest.TempPathFactory
) -> tuple[BalanceResult, Path]:
    """speed_test with the shaft that acc_current gave."""
    folder = tmp_path_factory.mktemp("speed_test")
    return _run("speed_test", free_run[1] / "model.toml", folder), folder


@pytest.fixture(scope="session")
def rolling(
    free_run: tuple[BalanceResult, Path], tmp_path_factory: pytest.TempPathFactory
) -> tuple[BalanceResult, Path]:
    folder = tmp_path_factory.mktemp("rolling_1")
    return _run("rolling_1", free_run[1] / "model.toml", folder), folder
