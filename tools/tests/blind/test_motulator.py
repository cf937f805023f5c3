"""A machine of motulator behind the drive of the log format: a third simulator, which must agree with the referee."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evenspin.blind import cases, motulator_drive, referee
from evenspin.blind.experiments import Experiment, all_experiments
from evenspin.blind.motors import draw_motor
from evenspin.errors import InputError

SIGNALS = ("speed_rad_s", "id_a", "iq_a", "vd_v", "vq_v", "iq_ref_a")


@pytest.fixture(scope="module")
def drive() -> tuple[dict[str, Any], Mapping[str, Experiment]]:
    rng = np.random.default_rng(5)
    meta = draw_motor(rng)
    motor = meta["motor"]
    return meta, {e.name: e for e in all_experiments(rng, motor["rated_current_a"], motor["rated_torque_nm"])}


def both(
    drive: tuple[dict[str, Any], Mapping[str, Experiment]], name: str, seconds: float, **effects: float
) -> list[dict[str, np.ndarray]]:
    """The same record by the referee and by motulator, without noise."""
    meta, experiments = drive
    experiment = experiments[name]
    count = round(seconds * referee.PWM_HZ)
    columns = experiment.inputs.__dataclass_fields__
    inputs = referee.Inputs(**{key: getattr(experiment.inputs, key)[:count] for key in columns})
    p = referee.parameters_of(meta) | {
        "sensor.current_noise_a": 0.0,
        "sensor.current_lsb_a": 0.0,
        "motor.locked": float(experiment.locked),
    }
    p |= {"motor.start_angle_rad": 1.0, **motulator_drive.LEFT_OPEN, **effects}
    return [simulate(p, inputs, experiment.decimate) for simulate in (referee.simulate, motulator_drive.simulate)]


def test_with_a_locked_rotor_both_are_the_same_to_the_steps_of_their_integration(drive) -> None:
    one, other = both(drive, "standstill_steps", 0.2)
    for signal in ("id_a", "iq_a", "vd_v", "vq_v"):
        assert np.abs(one[signal] - other[signal]).max() < 1e-6 * np.abs(one[signal]).max(initial=1.0), signal


def test_saturation_of_each_axis_is_the_same_flux_in_both(drive) -> None:
    saturated = {"inductance_saturation.i_sat_a": 0.8 * drive[0]["motor"]["rated_current_a"]}
    linear, _ = both(drive, "standstill_steps", 0.4)
    change, off = 0.0, []
    for step_s in (4e-6, 1e-6):
        one, other = both(drive, "standstill_steps", 0.4, **saturated, **{"run.step_s": step_s})
        change = np.abs(one["vd_v"] - linear["vd_v"]).max()
        off.append(np.abs(one["vd_v"] - other["vd_v"]).max() / change)
    assert change > 1.0
    # The referee takes the slope in the middle of a step: an error of second order, and nothing else.
    assert off[0] < 1e-3
    assert off[0] / off[1] > 10.0


@pytest.mark.parametrize(
    "effects",
    [
        {},
        {"two_mass.f_res_hz": 120.0, "two_mass.load_ratio": 0.4},
        {"stribeck_friction.torque_nm": 0.02, "stribeck_friction.speed_rad_s": 8.0},
    ],
    ids=["stiff", "two masses", "stribeck"],
)
def test_a_turning_shaft_differs_by_what_counts_of_the_encoder_make(drive, effects: dict[str, float]) -> None:
    """A count earlier or later moves the speed of the tracking filter and the voltages for a moment."""
    one, other = both(drive, "load_step", 1.0, **effects)
    half = len(one["speed_rad_s"]) // 2  # past standstill, where their frictions differ
    count_rad = 2.0 * np.pi / drive[0]["encoder"]["counts_per_rev"]
    limit = {"speed_rad_s": 754.0 * count_rad, "iq_ref_a": 0.02 * drive[0]["motor"]["rated_current_a"]}
    for signal, most in limit.items():
        assert np.sqrt(np.mean((one[signal][half:] - other[signal][half:]) ** 2)) < most, signal


def test_what_motulator_does_not_have_is_refused(drive) -> None:
    with pytest.raises(InputError, match=r"dead_time\.dead_time_s"):
        both(drive, "standstill_steps", 0.01, **{"dead_time.dead_time_s": 2e-6})
    with pytest.raises(InputError, match="per_axis"):
        both(
            drive,
            "standstill_steps",
            0.01,
            **{"inductance_saturation.i_sat_a": 2.0, "inductance_saturation.per_axis": 0.0},
        )


def test_a_set_of_motulator_hides_only_what_it_has() -> None:
    plans = cases.plan_cases({"single": 20, "pair": 5}, 3, motulator_drive.EFFECTS, cases.MOTULATOR)
    assert {name for plan in plans for name in plan.names} <= set(motulator_drive.EFFECTS)
    assert {plan.simulator for plan in plans} == {cases.MOTULATOR}


@pytest.mark.parametrize(
    ("words", "about"),
    [
        (("--simulator", "motulater"), "did you mean motulator"),
        (("--simulator", "motulator", "--effects", "dead_time", "--kind", "single", "--count", "1"), "dead_time"),
        (("--simulator", "motulator", "--kind", "beside", "--count", "1"), "--kind"),
    ],
)
def test_a_choice_that_motulator_cannot_make_is_one_line(
    evenspin, tmp_path: Path, words: tuple[str, ...], about: str
) -> None:
    said = evenspin("gap", "blind", "make", "--out", tmp_path / "a", *words)
    assert (said.status, len(said.err.splitlines())) == (2, 1)
    assert about in said.err
    assert not (tmp_path / "a").exists()
