"""Torque mode and ways to stop, from the link and from a scenario."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import evenspin as es
import numpy as np
import pytest
from evenspin.bench import Drive, State
from evenspin.bench.errors import RefusedError
from evenspin.errors import EvenspinError, InputError

SCENARIO = """
name = "torque"
model = "guo2024"
duration_s = 0.8
[drive]
method = "{method}"
[[event]]
at_s = 0.0
control = "torque"
iq_ref_a = 2.0
speed_rad_s = 60.0
"""


@pytest.fixture
def drive() -> Iterator[Drive]:
    with Drive.connect("sim:guo2024") as connected:
        yield connected


def test_a_scenario_in_torque_mode_ends_at_the_limit_of_the_speed(tmp_path: Path) -> None:
    path = tmp_path / "torque.toml"
    path.write_text(SCENARIO.format(method="pi"))
    run = es.load(path).simulate()
    assert np.max(run["iq_ref_a"]) == pytest.approx(2.0, abs=1e-3)
    assert np.mean(run["speed_rad_s"][-200:]) == pytest.approx(60.0, abs=0.5)


def test_torque_mode_with_an_observer_is_refused_and_both_are_named(tmp_path: Path) -> None:
    path = tmp_path / "torque.toml"
    path.write_text(SCENARIO.format(method="aro"))
    with pytest.raises(EvenspinError) as refused:
        es.load(path).simulate()
    assert "method" in str(refused.value)
    assert "torque" in str(refused.value)


def test_a_torque_in_newton_metres_is_the_q_current_that_makes_it(drive: Drive) -> None:
    drive.torque(torque_nm=0.05, speed_limit_rad_s=40.0)
    drive.start()
    drive.sleep(0.01)
    assert drive.read(["iq_ref_a"])["iq_ref_a"] == pytest.approx(0.05 / (1.5 * 4 * 6.4e-3), rel=1e-4)
    drive.sleep(0.5)
    assert drive.read(["speed_rad_s"])["speed_rad_s"] == pytest.approx(40.0, abs=1.5)
    with pytest.raises(RefusedError):
        drive.torque(iq_a=1000.0, speed_limit_rad_s=40.0)
    with pytest.raises(InputError, match="iq_a"):
        drive.torque(torque_nm=1.0, iq_a=1.0, speed_limit_rad_s=40.0)
    with pytest.raises(InputError, match="speed_limit_rad_s"):
        drive.torque(iq_a=1.0, speed_limit_rad_s=-1.0)


def test_a_stop_by_ramp_takes_its_time_and_the_bridge_is_off_at_its_end(drive: Drive) -> None:
    drive.set({"stop_action": 1.0, "stop_ramp_rad_s2": 200.0})
    drive.run_speed(60.0)
    drive.sleep(0.5)
    drive.stop()
    drive.sleep(0.15)
    assert drive.state().state is State.RUN
    assert drive.read(["speed_ref_rad_s"])["speed_ref_rad_s"] == pytest.approx(30.0, abs=5.0)
    drive.sleep(0.5)
    assert drive.state().state is State.READY
