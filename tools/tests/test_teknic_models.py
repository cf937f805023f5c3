"""The motor that the drive's defaults describe, bare and with a flywheel: the gains of its models do not swing. And the
noise of the converter that they are measured with.

Expected: a speed loop in order holds 10 rad/s to what friction and one count of the encoder leave. A rotor that swings
by itself shows many times that, as the bare motor does with the gains of the ten times heavier drive.
"""

import numpy as np
import pytest
from evenspin.model import builtin_models, load_machine, load_scenario
from evenspin.sim import simulate

HEAVY = "speed_kp_a_per_unit = 0.0368\nspeed_ki_a_per_unit_s = 0.92\nobserver_inertia_kgm2 = 7.06e-5\n"
ONE_COUNT_A_MS = 2.0 * np.pi / 4000.0 * 1000.0  # rad/s, 1.57


@pytest.fixture
def swing(tmp_path):
    """Standard deviation of the speed in the last of some seconds at 10 rad/s, and the fault at the end."""

    def run(model: str, drive: str, seconds: float = 3.0) -> tuple[float, float]:
        path = tmp_path / "it.toml"
        path.write_text(
            f'name = "it"\nmodel = "{model}"\nduration_s = {seconds}\nseed = 1\nlog_rate_hz = 2000.0\n'
            f"[drive]\n{drive}\n[[event]]\nat_s = 0.0\nspeed_rpm = 95.5\n"
        )
        log = simulate(load_scenario(path).setup, ("t_s", "true_speed_rad_s", "fault"))
        end = log.between(seconds - 1.0, seconds)["true_speed_rad_s"]
        assert end.mean() == pytest.approx(10.0, abs=0.1)
        return float(end.std()), float(log["fault"][-1])

    return run


WAYS = [("mt", m) for m in ("pi", "crc", "forc", "fal-forc", "dob", "ro", "aro")] + [("pll", "pi"), ("fir", "pi")]


@pytest.mark.parametrize("model", ["teknic2310p", "teknic2310p-flywheel"])
@pytest.mark.parametrize(("source", "method"), WAYS)
def test_no_speed_source_and_no_method_swings_with_the_gains_of_the_model(swing, model, source, method):
    deviation, fault = swing(model, f'speed_source = "{source}"\nmethod = "{method}"')

    assert fault == 0.0
    assert deviation < ONE_COUNT_A_MS / 8.0


@pytest.mark.parametrize(("source", "method"), [("pll", "pi"), ("mt", "dob")])
def test_the_bare_motor_swings_with_the_gains_of_a_drive_ten_times_heavier(swing, source, method):
    with pytest.raises(AssertionError):
        deviation, _ = swing("teknic2310p", f'speed_source = "{source}"\nmethod = "{method}"\n{HEAVY}')
        assert deviation < ONE_COUNT_A_MS


@pytest.mark.parametrize("model", ["teknic2310p", "teknic2310p-flywheel"])
def test_it_starts_as_on_the_bench_with_calibration_and_alignment(swing, model):
    drive = "offset_calibration_periods = 4096\nalign_periods = 32000\nalign_current_a = 3.0"
    deviation, fault = swing(model, drive, 6.0)

    assert fault == 0.0
    assert deviation < ONE_COUNT_A_MS / 8.0


def test_the_two_differ_by_a_flywheel_of_6e_5():
    bare, heavy = (load_machine(builtin_models()[name]) for name in ("teknic2310p", "teknic2310p-flywheel"))

    assert bare.plant["inertia_kgm2"] == pytest.approx(0.001 * 7.0616e-3, rel=1e-3)  # 0.001 oz in s^2
    assert heavy.plant["inertia_kgm2"] - bare.plant["inertia_kgm2"] == pytest.approx(6e-5)
    assert {k for k in bare.plant if bare.plant[k] != heavy.plant[k]} == {"inertia_kgm2"}
    for machine in (bare, heavy):
        assert machine.drive["observer_inertia_kgm2"] == machine.plant["inertia_kgm2"]


def test_the_paper_s_drive_on_the_board_differs_by_the_converter_only():
    paper, board = (load_machine(builtin_models()[name]) for name in ("guo2024", "guo2024-board"))

    assert {k for k in paper.plant if paper.plant[k] != board.plant[k]} == {"current_noise_a", "current_lsb_a"}
    assert (board.drive, board.effects) == (paper.drive, paper.effects)
    # 3.0 V over 4096 codes, 7 mohm x 10 V/V; noise of one code
    assert board.plant["current_lsb_a"] == pytest.approx(3.0 / 4096.0 / 0.07, rel=1e-5)
    assert board.plant["current_noise_a"] == pytest.approx(board.plant["current_lsb_a"], rel=0.05)
