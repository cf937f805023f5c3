"""The referee against logs of a drive simulator written by others: a third program, beside the two of this project.

The floor of 0.15 is theirs: sensor noise, converter steps, and tolerances of the unit, which the nominal model does not
know. 0.165 leaves 10 % for the start angle, known to half an encoder count only.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from evenspin.blind.cases import VALIDATION, gap_between
from evenspin.blind.referee import PWM_HZ, Inputs, Parameters, parameters_of, simulate, with_effects
from evenspin.errors import NativeError
from evenspin.log.case import Case, read_case

CASES = Path(__file__).parents[3] / "tests" / "data" / "foreign_drive"
FLOOR = (0.12, 0.165)
HIDDEN = {
    case: {effect["name"]: effect["parameters"] for effect in content["effects"]}
    for case, content in json.loads((CASES / "truth.json").read_text()).items()
}


def again(case: Case, name: str, drive: Parameters) -> dict[str, np.ndarray]:
    """The record once more, from its references, load and start angle."""
    record, locked = case.experiments[name], name == "validation_steps"
    decimate = 1 if locked else 5
    count = len(record) * decimate
    held = {key: np.repeat(np.nan_to_num(record[key]), decimate) for key in ("id_ref_a", "iq_ref_a", "load_torque_nm")}
    speed = np.interp(np.arange(count) / PWM_HZ, record["t_s"], record["speed_ref_rad_s"])  # ramps, logged at 2 kHz
    half_count_rad = np.pi / case.meta["encoder"]["counts_per_rev"]
    run = {
        "motor.locked": float(locked),
        "motor.start_angle_rad": record["theta_m_rad"][0] + half_count_rad,
        "sensor.current_noise_a": 0.0,
    }
    return simulate(drive | run, Inputs(speed, **held, current_mode=np.full(count, float(locked))), decimate)


def gap(case_name: str, effects: dict[str, dict[str, float]], edges: bool = False) -> float:
    case = read_case(CASES / case_name)
    drive = with_effects(parameters_of(case.meta), effects) | {"bridge.edges": float(edges)}
    logged = {name: {key: case.experiments[name][key] for key in case.experiments[name].names} for name in VALIDATION}
    return gap_between(logged, {name: again(case, name, drive) for name in VALIDATION})


@pytest.mark.parametrize("edges", [False, True], ids=["average", "edges"])
@pytest.mark.parametrize("case", HIDDEN)
def test_a_foreign_drive_with_its_hidden_effects_is_reproduced_down_to_its_noise(case: str, edges: bool) -> None:
    assert FLOOR[0] < gap(case, HIDDEN[case], edges) < FLOOR[1]


@pytest.mark.parametrize(("case", "least"), [("example_current_offset", 0.3), ("example_coulomb_and_inertia", 0.4)])
def test_without_the_hidden_effects_the_gap_stays_open(case: str, least: float) -> None:
    assert gap(case, {}) > least


def test_cogging_with_the_wrong_sign_makes_the_gap_larger() -> None:
    cogging = HIDDEN["example_cogging"]["cogging"]

    wrong = gap("example_cogging", {"cogging": cogging | {"amplitude_nm": -cogging["amplitude_nm"]}})

    assert wrong > 1.2 * gap("example_cogging", {})


def test_an_unknown_parameter_is_refused_with_the_one_that_was_meant() -> None:
    none = np.zeros(10)

    with pytest.raises(NativeError, match=r"did you mean cogging\.order"):
        simulate({"coging.order": 3.0}, Inputs(none, none, none, none, none), 1)


def test_a_value_out_of_its_domain_is_named() -> None:
    none = np.zeros(10)

    with pytest.raises(NativeError, match=r"motor\.inertia_kgm2 is out of its domain"):
        simulate({"motor.inertia_kgm2": 0.0}, Inputs(none, none, none, none, none), 1)
