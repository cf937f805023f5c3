"""Causes that no effect of the table is: found on one part of a log, confirmed on another, and said in words.

The foreign torque is taken off the load sensor of a simulated log: the shaft then has a torque that no model knows.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from driven_logs import hide, write_log
from evenspin.driven import run_driven
from evenspin.model.machine import load_machine


def foreign(unseen_nm, **effects: dict[str, float]) -> dict[str, np.ndarray]:
    """A log whose load sensor misses `unseen_nm(theta, speed, t)`."""
    columns = dict(hide(**effects))
    theta = np.unwrap(columns["theta_m_rad"])
    step_s = float(columns["t_s"][1] - columns["t_s"][0])
    speed = np.convolve(np.gradient(theta, step_s), np.ones(9) / 9.0, mode="same")
    columns["load_torque_nm"] = columns["load_torque_nm"] - unseen_nm(theta, speed, columns["t_s"])
    return columns


def verdict_of(columns: dict[str, np.ndarray], folder: Path, out: Path | None = None) -> dict[str, Any]:
    return run_driven([write_log(folder / "log.csv", columns)], "servo", "bench", out).verdict


def test_a_fan_is_a_drag_with_the_square_of_the_speed_and_closes_the_gap(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    verdict = verdict_of(foreign(lambda theta, w, t: 3e-5 * w * np.abs(w)), tmp_path, out)
    (term,) = verdict["empirical"]
    assert verdict["verdict"] == ["unknown"] and verdict["parameters"] == {}
    assert term["depends_on"] == ["speed"] and term["family"] == "speed_odd"
    assert term["parameters"]["exponent"] == pytest.approx(2.0, abs=0.15)
    assert "its square" in term["form"] and "against the motion" in term["form"] and "fan" in term["like"]
    assert verdict["gap_after"] < 1.3 < verdict["gap_after_known"]
    assert verdict["gap_closed"] > 0.85  # goal of such a log, of the gap above noise
    assert (out / "figures" / "beyond_1.svg").is_file()


def test_a_belt_has_its_order_to_a_hundredth_beside_a_known_effect_that_keeps_its_name(tmp_path: Path) -> None:
    columns = foreign(lambda theta, w, t: 0.08 * np.sin(3.47 * theta + 0.4), winding_resistance={"factor": 1.5})
    verdict = verdict_of(columns, tmp_path)
    (term,) = verdict["empirical"]
    assert verdict["verdict"] == ["winding_resistance", "unknown"]
    assert verdict["parameters"]["winding_resistance"]["factor"] == pytest.approx(1.5, rel=0.05)
    assert term["depends_on"] == ["angle"]
    assert term["parameters"]["order"] == pytest.approx(3.47, abs=0.01)
    assert term["parameters"]["torque_nm"] == pytest.approx(0.08, rel=0.06)
    assert term["parameters"]["phase_rad"] == pytest.approx(0.4, abs=0.1)
    assert "constant over speed" in term["form"] and "not tied" in term["form"]


def test_a_torque_of_a_fixed_frequency_is_no_order(tmp_path: Path) -> None:
    verdict = verdict_of(foreign(lambda theta, w, t: 0.1 * np.sin(2.0 * np.pi * 11.3 * t)), tmp_path)
    (term,) = verdict["empirical"]
    assert term["depends_on"] == ["frequency"]
    assert term["parameters"]["frequency_hz"] == pytest.approx(11.3, abs=0.05)  # half the resolution of ten seconds


@pytest.mark.parametrize(("constant_nm", "names"), [(0.0, ["unknown"]), (0.12, ["coulomb_friction", "unknown"])])
def test_friction_that_is_gone_when_warm_is_no_constant_friction(
    constant_nm: float, names: list[str], tmp_path: Path
) -> None:
    """The fit has it as friction of the first second less what warms up; only what is still there has a name."""
    columns = foreign(lambda theta, w, t: np.tanh(w) * (constant_nm + 0.15 * np.exp(-t / 3.0)))
    out = tmp_path / "out"
    out.mkdir()
    verdict = verdict_of(columns, tmp_path, out)
    assert verdict["verdict"] == names
    assert [term["family"] for term in verdict["empirical"]] == ["time_friction"]
    written = load_machine(out / "model.toml").effects["coulomb_friction"]["torque_nm"]
    assert written == pytest.approx(constant_nm + 0.15, abs=0.02)  # at the start, from where the term takes it away


def test_friction_that_falls_for_longer_than_the_log_is_no_constant_friction_as_far_as_it_could_still_fall(
    tmp_path: Path,
) -> None:
    """Ten seconds of an exponential of 8 s: 29 % are left at the end, more than counts, and on their way to none."""
    columns = foreign(lambda theta, w, t: np.tanh(w) * 0.3 * np.exp(-t / 8.0))
    verdict = verdict_of(columns, tmp_path)
    assert verdict["verdict"] == ["unknown"]
    assert [term["family"] for term in verdict["empirical"]] == ["time_friction"]


@pytest.mark.parametrize(
    "effects", [{}, {"inertia": {"factor": 1.3}}, {"cogging": {"amplitude_nm": 0.06, "order": 18.0}}]
)
def test_where_the_table_suffices_there_is_no_term_beside_it(
    effects: dict[str, dict[str, float]], tmp_path: Path
) -> None:
    verdict = verdict_of(hide(**effects), tmp_path)
    assert verdict["empirical"] == []
    assert verdict["verdict"] == list(effects)
    assert verdict["gap_after_known"] == verdict["gap_after"]
