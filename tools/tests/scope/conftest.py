"""What the tests of the scope share."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from virtual_bench import Bench, running_bench


@pytest.fixture(autouse=True)
def own_registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(os.environ, "XDG_RUNTIME_DIR", str(tmp_path))


@pytest.fixture
def bench() -> Iterator[Bench]:
    with running_bench() as made:
        yield made
