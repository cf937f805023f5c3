"""A term that a log shows runs in the simulator: hidden there, found in the log, and simulated behind the firmware."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from driven_logs import columns_of, hide, write_log
from evenspin.driven import run_driven
from evenspin.empirical.effect import effects_of
from evenspin.model.machine import load_machine

HIDDEN = {
    "fan and belt": {
        "empirical": {
            "odd_nm": 0.15,
            "limit_rad_s": 70.0,
            "line_1_nm": 0.06,
            "line_1_order": 3.47,
            "line_1_phase_rad": 1.1,
        }
    },
    "warm winding": {"empirical_voltage": {"resistance_ohm": 0.8, "time_s": 3.0}},
    "load that builds up": {"empirical": {"load_nm": 0.3, "time_s": 3.0}},
}
# What the firmware answers: a torque shows in the q current, a resistance in the q voltage.
SHOWS = {"fan and belt": "iq_a", "warm winding": "vq_v", "load that builds up": "iq_a"}


@pytest.mark.parametrize("cause", HIDDEN)
def test_what_was_found_closes_the_gap_of_a_run_of_the_firmware(cause: str, tmp_path: Path) -> None:
    hidden = hide(**HIDDEN[cause])
    out = tmp_path / "out"
    out.mkdir()
    verdict = run_driven([write_log(tmp_path / "log.csv", hidden)], "servo", "bench", out).verdict
    assert verdict["verdict"] == ["unknown"] and verdict["empirical_not_simulated"] == []
    found = load_machine(out / "model.toml").effects
    simulated = columns_of(tuple((name, tuple(params.items())) for name, params in found.items()))
    nominal = columns_of()

    def gap(columns: dict[str, np.ndarray]) -> float:
        off = columns[SHOWS[cause]] - hidden[SHOWS[cause]]
        width = 20  # 10 ms: the noise of the sensors is the same, but for what the loop makes of another torque
        return float(np.sqrt(np.mean(np.convolve(off, np.ones(width) / width, mode="valid") ** 2)))

    assert gap(simulated) < 0.15 * gap(nominal)  # goal of such a log: 85 % of the gap


def test_numbers_of_the_effect_are_those_that_were_hidden(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    run_driven([write_log(tmp_path / "log.csv", hide(**HIDDEN["fan and belt"]))], "servo", "bench", out)
    found = load_machine(out / "model.toml").effects["empirical"]
    at_70 = found["odd_nm"] * (70.0 / found["limit_rad_s"]) ** found["odd_exponent"]
    assert at_70 == pytest.approx(0.15, rel=0.1)  # viscous friction within its tolerance takes some of it
    assert found["line_1_order"] == pytest.approx(3.47, abs=0.005)
    assert found["line_1_nm"] == pytest.approx(0.06, rel=0.08)  # the smallest of the two, in ten seconds
    assert found["line_1_phase_rad"] == pytest.approx(1.1, abs=0.1)


def test_what_the_simulator_has_no_place_for_is_said() -> None:
    assert effects_of([]) == ({}, [])
