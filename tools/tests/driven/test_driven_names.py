"""Logs of the simulated drive with an effect hidden: the equations name it without knowing the controller."""

import json

import numpy as np
import pytest
from driven_logs import hide, write_log
from evenspin.driven import run_driven

# Sizes about twice what a bench leaves open; tolerances: 3 % of size, as asked of any log, and what ten seconds leave.
HIDDEN = {
    "cogging": ({"amplitude_nm": 0.06, "phase_rad": 1.0, "order": 18.0}, "amplitude_nm", 0.05),
    "coulomb_friction": ({"torque_nm": 0.06}, "torque_nm", 0.05),
    "inertia": ({"factor": 1.3}, "factor", 0.03),
    "torque_constant": ({"factor": 0.9}, "factor", 0.01),
    "winding_resistance": ({"factor": 1.4}, "factor", 0.04),
    "dead_time": ({"dead_time_s": 1.5e-6}, "dead_time_s", 0.08),
    "current_offset": ({"offset_a_a": 0.2, "offset_b_a": -0.1}, "offset_a_a", 0.05),
}


@pytest.mark.parametrize("effect", HIDDEN)
def test_a_hidden_effect_is_named_with_its_size(effect, tmp_path):
    params, key, tolerance = HIDDEN[effect]
    log = write_log(tmp_path / "log.csv", hide(**{effect: params}))
    result = run_driven([log], "servo", "bench", None)
    assert result.verdict["verdict"] == [effect]
    assert result.verdict["parameters"][effect][key] == pytest.approx(params[key], rel=tolerance)
    interval = result.verdict["intervals"][effect][key]
    assert interval["low"] <= params[key] <= interval["high"]
    assert result.verdict["gap_after"] < result.verdict["gap_before"]


def test_a_pair_that_acts_in_different_equations_is_named_as_a_pair(tmp_path):
    columns = hide(coulomb_friction={"torque_nm": 0.06}, winding_resistance={"factor": 1.4})
    result = run_driven([write_log(tmp_path / "log.csv", columns)], "servo", "bench", None)
    assert sorted(result.verdict["verdict"]) == ["coulomb_friction", "winding_resistance"]


def test_a_healthy_machine_has_no_name_and_is_all_clear(tmp_path):
    result = run_driven([write_log(tmp_path / "log.csv", hide())], "servo", "bench", None)
    assert result.verdict["verdict"] == []
    assert result.verdict["clear"]


def test_a_drag_with_the_square_of_the_speed_is_unknown_and_not_viscous(tmp_path):
    columns = dict(hide())
    # A fan that the load sensor does not see: the sensor then reads that much less.
    columns["theta_m_rad"] = np.unwrap(columns["theta_m_rad"])
    speed = np.convolve(np.gradient(columns["theta_m_rad"], columns["t_s"]), np.ones(9) / 9.0, mode="same")
    columns["load_torque_nm"] = columns["load_torque_nm"] - 0.15 * speed * np.abs(speed) / 70.0**2
    result = run_driven([write_log(tmp_path / "log.csv", columns)], "servo", "bench", None)
    assert result.verdict["verdict"] == ["unknown"]
    assert "square of the speed" in " ".join(result.verdict["unexplained"])
    assert result.verdict["parameters"] == {}


def test_what_is_within_the_tolerance_of_a_bench_is_an_effect_in_the_laboratory(tmp_path):
    log = write_log(tmp_path / "log.csv", hide(encoder_offset={"angle_el_rad": 0.1}))
    assert run_driven([log], "servo", "bench", None).verdict["verdict"] == []
    laboratory = run_driven([log], "servo", "laboratory", None).verdict
    assert laboratory["verdict"] == ["encoder_offset"]
    assert laboratory["parameters"]["encoder_offset"]["angle_el_rad"] == pytest.approx(0.1, abs=0.01)


def test_what_is_written_is_a_model_that_leaves_nothing_to_name(tmp_path):
    log = write_log(tmp_path / "log.csv", hide(winding_resistance={"factor": 1.4}))
    out = tmp_path / "out"
    out.mkdir()
    run_driven([log], "servo", "bench", out)
    assert json.loads((out / "verdict.json").read_text())["verdict"] == ["winding_resistance"]
    assert (out / "report.html").is_file()
    again = run_driven([log], out / "model.toml", "bench", None)
    assert again.verdict["verdict"] == []
