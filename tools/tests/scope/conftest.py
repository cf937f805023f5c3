"""What the tests of the scope share."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from virtual_bench import Bench, running_bench

if TYPE_CHECKING:
    from browser import Browser


@pytest.fixture(autouse=True)
def own_registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(os.environ, "XDG_RUNTIME_DIR", str(tmp_path))


@pytest.fixture
def bench() -> Iterator[Bench]:
    with running_bench() as made:
        yield made


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """One page for all tests of a file, with the motor turning. Files in which it rests have a page of their own."""
    from hands import opened_page, turn  # where there is no browser, the other tests run

    with opened_page(tmp_path_factory.mktemp("registry")) as (browser, _):
        turn(browser)
        yield browser
