"""Things that several tests need."""

from __future__ import annotations

import gc
from collections.abc import Callable
from pathlib import Path

import pytest
from evenspin.cli import main
from evenspin.reproduce.guo2024 import Result, reproduce
from said import Said

# Files that take longest, longest first by their processor time: begun at the end, one core would wait for the other.
LONG_FILES = (
    "test_reproduce_tang2020.py",
    "test_driven_names.py",
    "test_balance_other_drives.py",
    "test_driven_beyond.py",
    "test_effect_in_one_file.py",
    "test_balance_lines.py",
    "test_api.py",
    "test_scope_page.py",
    "test_gap_rest.py",
    "test_scope_browser.py",
    "test_driven_empirical_effect.py",
    "test_rules.py",
    "test_cycles.py",
    "test_gap_result.py",
    "test_gap_periodic.py",
    "test_blind_hard.py",
    "test_balance_simulated_logs.py",
    "test_driven_torque_only.py",
    "test_balance_real_logs.py",
    "test_circle.py",
    "test_blind_cases.py",
    "test_wheel.py",
    "test_scope_kept.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    rank = {name: position for position, name in enumerate(LONG_FILES)}
    items.sort(key=lambda item: rank.get(item.path.name, len(rank)))  # the others stay as they are


def pytest_collection_finish() -> None:
    """What was collected lives to the end: no collection of garbage has to look through it."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def evenspin(capsys: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    """Call the command in this process."""

    def call(*words: object) -> Said:
        capsys.readouterr()
        status = 0
        try:
            main([str(word) for word in words])
        except SystemExit as stop:
            status = int(stop.code or 0)
        said = capsys.readouterr()
        return Said(status, said.out, said.err)

    return call


SCENARIO = """\
name = "short"
model = "guo2024"
duration_s = 0.5
seed = 3
log_rate_hz = 2000.0

[drive]
method = "forc"

[[event]]
at_s = 0.0
speed_rpm = 300.0
load_brake_a = 1.0

[[event]]
at_s = 0.25
load_brake_a = 2.0
"""


@pytest.fixture
def scenario_text() -> str:
    return SCENARIO


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "short.toml"
    path.write_text(SCENARIO)
    return path


@pytest.fixture(scope="session")
def float_result() -> Result:
    return reproduce("float")


@pytest.fixture(scope="session")
def fixed_result() -> Result:
    return reproduce("fixed")
