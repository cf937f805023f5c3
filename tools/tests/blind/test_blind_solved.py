"""A fast part of `make blind`: cases of the referee, which shares no code with the simulator of the search, solved."""

from __future__ import annotations

import json
from pathlib import Path

SEED = 21  # a foreign line on the dc link, flux harmonics of 2.5 %, and nothing


def test_a_hidden_effect_is_named_a_foreign_one_is_unknown_and_nothing_is_nothing(evenspin, tmp_path: Path) -> None:
    cases, truth, verdicts = tmp_path / "cases", tmp_path / "truth.json", tmp_path / "verdicts"
    kinds = ("--count", 3, "--kind", "single=1,none=1,outside=1")
    assert evenspin("gap", "blind", "make", "--out", cases, "--truth", truth, *kinds, "--seed", SEED).status == 0

    assert evenspin("gap", "batch", cases, "--out", verdicts).status == 0

    hidden = json.loads(truth.read_text())
    assert {content["kind"] for content in hidden.values()} == {"single", "none", "outside"}
    for case, content in hidden.items():
        verdict = json.loads((verdicts / case / "verdict.json").read_text())
        wanted = ["unknown"] if content["outside"] else [effect["name"] for effect in content["effects"]]
        assert verdict["verdict"] == wanted, case
        if content["effects"]:
            assert verdict["gap_after"] < verdict["gap_before"]
