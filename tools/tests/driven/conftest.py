"""What tests of logs with voltages share."""

from __future__ import annotations

import pytest
from evenspin.driven import run
from evenspin.weakform.beyond import Beyond


@pytest.fixture(params=["by the table", pytest.param("whole", marks=pytest.mark.search)])
def by_the_table(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Effects of the table alone. Three quarters of the time go into what may act beside them, which all tests without
    this fixture go through, above all test_driven_beyond.py; `make test-searches` does it whole for these, too."""
    if request.param == "by the table":
        monkeypatch.setattr(run, "look_beyond", lambda search, say: Beyond(search.found, {}, {}, search.found.after))
