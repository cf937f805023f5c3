"""What is named in logs whose truth is known: they come from the project's simulator, in ampere equivalents."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import balance_recordings as recordings
import numpy as np
import pytest
from evenspin.balance import run_balance
from evenspin.errors import InputError

COULOMB = {"coulomb_friction": {"torque_nm": 0.05}}
COGGING = {"cogging": {"amplitude_nm": 0.1, "phase_rad": 1.0, "order": 24.0}}
MODEL = f"""\
name = "ampere equivalents"
[plant]
pole_pairs = 1
resistance_ohm = 50.0
ld_h = 0.05
lq_h = 0.05
psi_wb = {2.0 / 3.0!r}
inertia_kgm2 = %g
viscous_nms = %g
"""


def verdict_of(folder: Path, columns: dict[str, np.ndarray], model: Path | None = None) -> dict[str, Any]:
    return run_balance(recordings.write(folder / "log.csv", columns), model, None).verdict


def model_of(folder: Path, inertia: float = 1.0, viscous: float = 1.0) -> Path:
    path = folder / "model.toml"
    path.write_text(MODEL % (inertia * recordings.INERTIA_AS2, viscous * recordings.VISCOUS_AS))
    return path


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_nothing_is_named_where_nothing_is_missing(tmp_path: Path, seed: int) -> None:
    for columns in (recordings.sweep({}, seed=seed), recordings.level({}, seed=seed)):
        verdict = verdict_of(tmp_path, columns)

        assert verdict["verdict"] == []
        assert verdict["parameters"] == {}
        assert verdict["unexplained"] == []


def test_inertia_and_viscous_friction_of_a_swept_log_are_right(tmp_path: Path) -> None:
    found = verdict_of(tmp_path, recordings.sweep({}))["identified"]

    for name, truth in (
        ("inertia.inertia_as2_per_rad", recordings.INERTIA_AS2),
        ("viscous_friction.viscous_as_per_rad", recordings.VISCOUS_AS),
    ):
        assert found[name]["low"] < truth < found[name]["high"]
        assert found[name]["half"] < 0.08 * truth


@pytest.mark.parametrize("torque_a", [0.01, 0.08])
def test_coulomb_friction_is_named_with_its_torque(tmp_path: Path, torque_a: float) -> None:
    verdict = verdict_of(tmp_path, recordings.sweep({"coulomb_friction": {"torque_nm": torque_a}}))

    assert verdict["verdict"] == ["coulomb_friction"]
    # a residual of the filter of the speed estimate: a few tenths of a milliampere
    assert verdict["parameters"]["coulomb_friction"]["torque_a_equiv"] == pytest.approx(torque_a, rel=0.02, abs=5e-4)
    assert verdict["gap_after"] < 0.5 * verdict["gap_before"]


def test_a_load_of_fixed_sign_is_not_friction(tmp_path: Path) -> None:
    verdict = verdict_of(tmp_path, recordings.sweep({"load_torque": {"torque_nm": 0.03}}))

    assert verdict["verdict"] == ["load_torque"]
    assert verdict["parameters"]["load_torque"]["torque_a_equiv"] == pytest.approx(0.03, rel=0.05)


def test_stribeck_friction_is_named_where_it_is_with_a_warning_where_it_is_passed_too_fast(tmp_path: Path) -> None:
    low = {"stribeck_friction": {"torque_nm": 0.08, "speed_rad_s": 15.0, "shape": 2.0}}

    verdict = verdict_of(tmp_path, recordings.sweep(COULOMB | low))

    assert set(verdict["verdict"]) == {"coulomb_friction", "stribeck_friction"}
    assert any("not identifiable" in text and "stribeck" in text for text in verdict["warnings"])


def test_misalignment_is_named_in_a_swept_log(tmp_path: Path) -> None:
    verdict = verdict_of(tmp_path, recordings.sweep({"misalignment": {"amplitude_nm": 0.05, "phase_rad": 1.0}}))

    assert verdict["verdict"] == ["misalignment"]
    assert verdict["parameters"]["misalignment"]["amplitude_a_equiv"] == pytest.approx(0.05, rel=0.05)
    assert verdict["parameters"]["misalignment"]["phase_rad"] == pytest.approx(1.0, abs=0.05)


def test_cogging_beside_friction_is_found_in_a_swept_log_at_its_slow_rows(tmp_path: Path) -> None:
    verdict = verdict_of(tmp_path, recordings.sweep(COULOMB | COGGING))
    cogging = verdict["parameters"]["cogging"]

    assert set(verdict["verdict"]) == {"cogging", "coulomb_friction"}
    assert cogging["order"] == 24
    assert cogging["amplitude_a_equiv"] == pytest.approx(0.1, rel=0.05)
    assert cogging["phase_rad"] == pytest.approx(1.0, abs=0.05)


def test_cogging_at_one_speed_is_known_better_with_the_inertia_of_a_model(tmp_path: Path) -> None:
    """Alone, the start from rest tells the inertia; the interval then has to say how well."""
    small = {"cogging": {"amplitude_nm": 0.03, "phase_rad": 1.0, "order": 24.0}}
    columns = recordings.level(COULOMB | small)

    alone = verdict_of(tmp_path, columns)
    helped = verdict_of(tmp_path, columns, model_of(tmp_path))

    own = alone["parameters"]["cogging"]
    assert own["order"] == 24.0
    assert own["amplitude_a_equiv"] == pytest.approx(0.03, abs=own["amplitude_half_a_equiv"])
    assert helped["parameters"]["cogging"]["amplitude_a_equiv"] == pytest.approx(0.03, rel=0.05)
    assert helped["parameters"]["cogging"]["phase_rad"] == pytest.approx(1.0, abs=0.1)


def test_a_model_with_the_wrong_inertia_is_corrected(tmp_path: Path) -> None:
    verdict = verdict_of(tmp_path, recordings.sweep({}), model_of(tmp_path, inertia=1.0 / 1.25))

    assert verdict["verdict"] == ["inertia"]
    assert verdict["parameters"]["inertia"]["factor"] == pytest.approx(1.25, rel=0.01)
    assert "torque_constant" in dict(verdict["alternatives"])


@pytest.mark.parametrize(("inertia", "viscous"), [(1.02, 1.0), (0.98, 1.0), (1.0, 1.05), (1.0, 0.95)])
def test_a_model_within_tolerance_is_left_alone(tmp_path: Path, inertia: float, viscous: float) -> None:
    verdict = verdict_of(tmp_path, recordings.sweep({}), model_of(tmp_path, inertia, viscous))

    assert verdict["verdict"] == []


def test_the_effects_of_the_model_are_not_missing(tmp_path: Path) -> None:
    path = model_of(tmp_path)
    path.write_text(path.read_text() + "[effects.coulomb_friction]\ntorque_nm = 0.05\n")

    verdict = verdict_of(tmp_path, recordings.sweep(COULOMB), path)

    assert verdict["verdict"] == []


@pytest.mark.parametrize(("torque_a", "named"), [(0.055, []), (0.08, ["coulomb_friction"])])
def test_friction_off_the_model_is_named_when_it_is_far_off(tmp_path: Path, torque_a: float, named: list[str]) -> None:
    path = model_of(tmp_path)
    path.write_text(path.read_text() + "[effects.coulomb_friction]\ntorque_nm = 0.05\n")
    columns = recordings.sweep({"coulomb_friction": {"torque_nm": torque_a}})

    verdict = verdict_of(tmp_path, columns, path)

    assert verdict["verdict"] == named
    found = verdict["identified"]["coulomb_friction.torque_a_equiv"]["value"]  # whole, not what is beyond the model
    assert found == pytest.approx(torque_a, rel=0.03)


def test_a_speed_estimate_of_second_order_does_not_bend_the_friction(tmp_path: Path) -> None:
    """The tracking filter smears a reversal; undone, nothing is left that would seem to be curvature."""
    verdict = verdict_of(tmp_path, recordings.sweep({"coulomb_friction": {"torque_nm": 0.08}}))

    assert verdict["unexplained"] == []
    assert verdict["time"]["speed_estimate_late_s"] == pytest.approx(
        754.0 / 142122.0, rel=0.02
    )  # kp / ki of the filter


@pytest.mark.parametrize("missing", ["speed_rad_s", "theta_m_rad"])
def test_coulomb_friction_is_found_from_angle_or_speed_alone(tmp_path: Path, missing: str) -> None:
    columns = recordings.sweep(COULOMB)
    del columns[missing]

    verdict = verdict_of(tmp_path, columns)

    assert verdict["verdict"] == ["coulomb_friction"]
    assert verdict["parameters"]["coulomb_friction"]["torque_a_equiv"] == pytest.approx(0.05, rel=0.1)


def test_a_friction_that_drifts_is_reported(tmp_path: Path) -> None:
    columns = recordings.sweep(COULOMB)
    columns["iq_a"] += 0.04 * columns["t_s"] / columns["t_s"][-1] * np.sign(columns["speed_rad_s"])

    verdict = verdict_of(tmp_path, columns)

    assert any("drift" in text for text in verdict["unexplained"])


def test_a_line_that_is_not_tied_to_the_shaft_is_unknown(tmp_path: Path) -> None:
    columns = recordings.level(COULOMB)
    columns["iq_a"] += 0.05 * np.sin(10.5 * np.unwrap(columns["theta_m_rad"]))

    verdict = verdict_of(tmp_path, columns)

    assert verdict["verdict"] == ["unknown"]
    assert any("10.5" in text for text in verdict["unexplained"])


def test_a_motor_that_hardly_turns_is_refused(tmp_path: Path) -> None:
    t_s = 1e-3 * np.arange(2000)
    columns = {"theta_m_rad": 0.1 * np.sin(t_s), "speed_rad_s": 0.1 * np.cos(t_s), "iq_a": -0.1 * np.sin(t_s)}

    with pytest.raises(InputError, match="one turn"):
        verdict_of(tmp_path, {"t_s": 1e-3 * np.arange(2000)} | columns)


def test_a_log_that_allows_no_judgement_says_so(tmp_path: Path) -> None:
    columns = recordings.level(COULOMB)
    del columns["theta_m_rad"]

    result = run_balance(recordings.write(tmp_path / "log.csv", columns), None, None)

    assert result.verdict["verdict"] == []
    assert any("does not mean that none is missing" in text for text in result.warnings)
    assert "no judgement" in result.summary[0]


def test_angle_and_speed_that_disagree_are_refused(tmp_path: Path) -> None:
    columns = recordings.sweep({})
    columns["theta_m_rad"] = np.degrees(np.unwrap(columns["theta_m_rad"]))

    with pytest.raises(InputError, match="theta_m_rad in degrees"):
        verdict_of(tmp_path, columns)


def test_gaps_and_repeats_change_little(tmp_path: Path) -> None:
    columns = recordings.sweep(COULOMB)
    kept = np.ones(len(columns["t_s"]), dtype=bool)
    kept[3000:3030] = kept[7000:7005] = False
    rows = np.flatnonzero(kept)
    rows = np.sort(np.concatenate((rows, rows[100:110])))  # and ten rows twice
    torn = {name: value[rows] for name, value in columns.items()}

    whole, mended = verdict_of(tmp_path, columns), verdict_of(tmp_path, torn)

    assert mended["verdict"] == whole["verdict"]
    assert len(mended["repairs"]) > len(whole["repairs"])
    for name, each in whole["identified"].items():
        assert mended["identified"][name]["value"] == pytest.approx(each["value"], rel=0.03)
