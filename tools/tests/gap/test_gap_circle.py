"""The whole circle: experiments over the link of a virtual drive with cogging hidden in its plant; then the search."""

from __future__ import annotations

import json
from pathlib import Path

import pytest


def test_cogging_hidden_in_the_virtual_drive_is_named_from_what_the_bench_recorded(evenspin, tmp_path: Path) -> None:
    hidden = {"amplitude_nm": 0.05, "phase_rad": 0.7, "order": 18.0}
    port = "sim:servo?" + "&".join(f"cogging.{name}={value}" for name, value in hidden.items())
    experiments, case, out = (tmp_path / name for name in ("experiments.toml", "case", "gap"))
    evenspin("bench", "plan", "servo", "--out", experiments)
    evenspin("bench", "run", experiments, "--port", port, "--out", case)

    evenspin("gap", case, "--out", out)

    verdict = json.loads((out / "verdict.json").read_text())
    assert verdict["verdict"] == ["cogging"]
    found = verdict["parameters"]["cogging"]
    assert found["order"] == 18.0
    assert found["amplitude_nm"] == pytest.approx(0.05, rel=0.05)
    assert found["phase_rad"] == pytest.approx(0.7, abs=0.1)
    # closed, but for a start that was not at rest: the rotor rocks in its detents before an experiment begins
    assert verdict["gap_after"] - verdict["gap_floor"] < 0.3 * (verdict["gap_before"] - verdict["gap_floor"])
