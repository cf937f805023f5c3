"""Blind cases: in the format, inside the tolerances, the same for the same seed, and with something to find."""

from __future__ import annotations

import json
import math
from collections import Counter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from evenspin.blind import cases as making
from evenspin.blind.cases import Plan, draw_unit, gap_between, make_case, plan_cases, run_experiments, why_unfit
from evenspin.blind.experiments import all_experiments
from evenspin.blind.motors import draw_motor
from evenspin.blind.referee import parameter_names, parameters_of, with_effects
from evenspin.blind.truth import Truth, read_truth, write_truth
from evenspin.blind.vocabulary import EFFECTS, OUTSIDE, go_together
from evenspin.log.case import read_case
from evenspin.native import tables

# Of the format sheet, with the parameters that each name has.
VOCABULARY = {
    "current_offset": {"offset_a_a", "offset_b_a"},
    "current_gain": {"gain_a", "gain_b"},
    "dead_time": {"dead_time_s"},
    "cogging": {"amplitude_nm", "phase_rad", "order"},
    "flux_harmonics": {"torque_ripple_rel", "sign"},
    "coulomb_friction": {"torque_nm"},
    "stribeck_friction": {"torque_nm", "speed_rad_s"},
    "viscous_friction": {"factor"},
    "inertia": {"factor"},
    "load_torque": {"torque_nm"},
    "misalignment": {"amplitude_nm", "phase_rad", "second_rel", "phase2_rad"},
    "encoder_eccentricity": {"amplitude_rad", "phase_rad"},
    "encoder_offset": {"angle_el_rad"},
    "current_loop_delay": {"extra_periods"},
    "torque_constant": {"factor"},
    "winding_resistance": {"factor"},
    "inductance_saturation": {"i_sat_a"},
    "two_mass": {"f_res_hz", "load_ratio", "damping_ratio"},
    "backlash": {"gap_rad", "load_ratio", "f_res_hz", "damping_ratio"},
    "current_filter": {"tau_s"},
}
EXPERIMENTS_S = {
    "staircase": 13.2,
    "staircase_load": 6.2,
    "load_step": 3.6,
    "reversal": 7.2,
    "coast_down": 5.2,
    "standstill_steps": 1.08,
    "validation": 6.0,
    "validation_steps": 0.6,
}


def test_a_drive_that_has_lost_control_of_its_speed_is_no_case() -> None:
    """A cubic error of the current sensors of 15 % made one: at the limit in 99 % of its load step."""
    run: Any
    held: Any
    run, held = SimpleNamespace(name="load_step", locked=False), SimpleNamespace(name="standstill_steps", locked=True)

    def kept(at_limit: float, held_at_limit: float, speed_rad_s: float = 30.0) -> bool:
        def record(share: float) -> dict[str, np.ndarray]:
            iq_ref_a = np.where(np.arange(100) < 100 * share, -8.0, 3.0)
            return {"iq_ref_a": iq_ref_a, "true_speed_rad_s": np.full(100, speed_rad_s)}

        records = {"load_step": record(at_limit), "standstill_steps": record(held_at_limit)}
        return making.is_under_control(records, [run, held], 8.0)

    assert kept(0.0, 0.0) and kept(0.4, 1.0)
    assert not kept(0.6, 0.0)
    assert not kept(0.0, 0.0, 151.0) and not kept(0.0, 0.0, math.nan)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Truth]:
    folder = tmp_path_factory.mktemp("blind") / "case_0007"
    return folder, make_case(Plan("case_0007", (1, 7), "single", 2, ("encoder_offset",)), folder)


def test_the_vocabulary_is_that_of_the_format() -> None:
    rng, meta = np.random.default_rng(1), draw_motor(np.random.default_rng(1))

    assert {name: set(draw(rng, meta, 1)) for name, draw in EFFECTS.items()} == VOCABULARY


def test_every_drawn_effect_has_the_reported_parameters_of_the_table() -> None:
    rng, meta = np.random.default_rng(1), draw_motor(np.random.default_rng(1))
    reported = {name: {p.name for p in e.params.values() if p.reported} for name, e in tables().effects.items()}

    assert {name: set(draw(rng, meta, 1)) for name, draw in EFFECTS.items()}.items() <= reported.items()


def test_effects_of_one_shaft_are_not_hidden_together() -> None:
    assert not go_together(("two_mass", "backlash"))
    assert go_together(("two_mass", "cogging")) and go_together(("backlash", "fan_load")) and go_together(())


def test_the_load_of_a_shaft_is_a_part_of_the_total_inertia() -> None:
    """0.3, 0.8 and 2 times the rotor's, give or take 15 %: 0.20..0.26, 0.40..0.48 and 0.63..0.70 of the total."""
    rng, meta = np.random.default_rng(2), draw_motor(np.random.default_rng(1))

    drawn = np.array([[EFFECTS["two_mass"](rng, meta, size)["load_ratio"] for size in range(3)] for _ in range(50)])

    assert drawn.min(axis=0) == pytest.approx([0.203, 0.405, 0.630], abs=0.01)
    assert drawn.max(axis=0) == pytest.approx([0.257, 0.479, 0.697], abs=0.01)


@pytest.mark.parametrize("name", [*EFFECTS, *OUTSIDE])
def test_every_effect_opens_a_gap_that_grows_with_its_size(name: str) -> None:
    """On one motor; the validation records, without noise."""
    rng = np.random.default_rng(3)
    meta = draw_motor(rng)
    experiments = all_experiments(rng, meta["motor"]["rated_current_a"], meta["motor"]["rated_torque_nm"])
    nominal = parameters_of(meta) | {"sensor.current_noise_a": 0.0, "run.step_s": 1e-5}

    def run(size: int | None) -> dict:
        effect = {} if size is None else {name: {**EFFECTS, **OUTSIDE}[name](np.random.default_rng(5), meta, size)}
        return run_experiments(with_effects(nominal, effect), experiments, [1.0] * 8, 1, making.VALIDATION)

    clean = run(None)
    small, large = gap_between(run(0), clean), gap_between(run(2), clean)
    assert 0.004 < small < large  # the smallest: a drift or a backlash, seen better in other records
    assert large > 0.02


def test_factors_are_those_of_the_motor_and_the_rest_are_parameters_of_the_referee() -> None:
    nominal = {"motor.psi_wb": 0.1, "motor.inertia_kgm2": 2.0, "motor.resistance_ohm": 3.0, "motor.viscous_nms": 4.0}

    drive = with_effects(nominal, {"inertia": {"factor": 1.5}, "torque_constant": {"factor": 0.9}})

    assert drive["motor.inertia_kgm2"] == pytest.approx(3.0)
    assert drive["motor.psi_wb"] == pytest.approx(0.09)
    others = {f"{name}.{key}" for name, keys in VOCABULARY.items() for key in keys if key != "factor"}
    assert others <= set(parameter_names())


def test_a_case_is_in_the_format(made: tuple[Path, Truth]) -> None:
    case = read_case(made[0])

    assert case.meta["case"] == "case_0007"
    assert {name: len(record) for name, record in case.experiments.items()} == {
        name: round(seconds * (10000 if "steps" in name else 2000)) for name, seconds in EXPERIMENTS_S.items()
    }
    for name, record in case.experiments.items():
        measured = name in ("staircase_load", "load_step", "validation")
        assert np.isfinite(record["load_torque_nm"]).all() == measured
        assert np.isnan(record["load_torque_nm"]).all() == (not measured)
        others = [key for key in record.names if key != "load_torque_nm"]
        assert np.isfinite(record.pick(others).values).all()


def test_the_case_itself_does_not_tell_what_is_hidden(made: tuple[Path, Truth]) -> None:
    example = Path(__file__).parents[3] / "tests" / "data" / "foreign_drive" / "example_clean" / "meta.json"
    meta = json.loads((made[0] / "meta.json").read_text())

    assert set(meta) == set(json.loads(example.read_text()))
    assert sorted(path.name for path in made[0].iterdir()) == sorted(
        ["meta.json", *(f"{name}.csv.gz" for name in EXPERIMENTS_S)]
    )


def test_the_hidden_encoder_offset_is_in_the_log(made: tuple[Path, Truth]) -> None:
    """A frame that leads the magnets by delta sees v_d = w_e psi sin(delta) while nothing flows."""
    case, truth = read_case(made[0]), made[1]
    (entry,) = truth.effects
    delta = entry["parameters"]["angle_el_rad"]
    motor, record = case.meta["motor"], case.experiments["staircase"]
    fast = (record["t_s"] > 6.2) & (record["t_s"] < 6.6)
    w_e = motor["pole_pairs"] * np.mean(record["speed_rad_s"][fast])

    expected_v = w_e * (motor["psi_wb"] * np.sin(delta) - motor["lq_h"] * np.mean(record["iq_a"][fast]))

    # 5 %: flux and current of the unit, and what noise and half a count (of the angle) leave
    half_count_v = w_e * motor["psi_wb"] * np.pi / case.meta["encoder"]["counts_per_rev"] * motor["pole_pairs"]
    tolerance_v = 0.05 * abs(expected_v) + half_count_v + 0.02
    assert np.mean(record["vd_v"][fast]) == pytest.approx(expected_v, abs=tolerance_v)


def test_truth_knows_floor_nominal_and_named_gap(made: tuple[Path, Truth], tmp_path: Path) -> None:
    truth = made[1]

    assert truth.gap_floor < truth.gap_named < truth.gap_nominal
    assert truth.verdict == ["encoder_offset"]
    write_truth(tmp_path / "truth.json", {"case_0007": truth})
    assert read_truth(tmp_path / "truth.json") == {"case_0007": truth}


def test_the_same_seed_writes_the_same_bytes(made: tuple[Path, Truth], tmp_path: Path) -> None:
    again = tmp_path / "case_0007"

    make_case(Plan("case_0007", (1, 7), "single", 2, ("encoder_offset",)), again)

    for path in made[0].iterdir():
        assert path.read_bytes() == (again / path.name).read_bytes()


def test_the_unit_is_inside_the_tolerances_and_uses_them() -> None:
    rng = np.random.default_rng(2)
    nominal = parameters_of(draw_motor(rng))
    units = [draw_unit(rng, nominal)[0] for _ in range(300)]

    for key, bound in (("resistance_ohm", 0.012), ("ld_h", 0.015), ("psi_wb", 0.004), ("inertia_kgm2", 0.012)):
        off = np.array([unit[f"motor.{key}"] / nominal[f"motor.{key}"] - 1.0 for unit in units])
        assert bound * 0.95 < np.abs(off).max() <= bound * 1.000001
        assert abs(off.mean()) < 0.1 * bound * 1.8  # three standard errors of an even distribution
    offsets = np.array([unit["sensor.offset_a_a"] for unit in units])
    assert 0.009 < np.abs(offsets).max() <= 0.010


def test_drives_are_as_the_example_says_they_are_designed() -> None:
    for seed in range(40):
        meta = draw_motor(np.random.default_rng(seed))
        motor, current, speed, pll = (meta[k] for k in ("motor", "current_loop", "speed_loop", "speed_filter"))
        assert current["ki_v_per_as"] / current["kp_v_per_a"] == pytest.approx(motor["resistance_ohm"] / motor["ld_h"])
        assert 1800.0 < current["kp_v_per_a"] / motor["ld_h"] < 3100.0
        assert pll["kp"] ** 2 == pytest.approx(4.0 * pll["ki"])
        assert speed["iq_limit_a"] == pytest.approx(1.6 * motor["rated_current_a"])
        assert 2 <= motor["pole_pairs"] <= 11
        torque_nm = 1.5 * motor["pole_pairs"] * motor["psi_wb"] * motor["rated_current_a"]
        assert motor["rated_torque_nm"] == pytest.approx(torque_nm, rel=0.06)  # two digits


def test_a_drive_at_its_voltage_limit_is_unfit() -> None:
    rng = np.random.default_rng(4)
    meta = draw_motor(rng)
    experiments = all_experiments(rng, meta["motor"]["rated_current_a"], meta["motor"]["rated_torque_nm"])
    drive = parameters_of(meta) | {"run.step_s": 1e-5}

    assert why_unfit(meta, run_experiments(drive, experiments, [0.0] * 8, 1), experiments) == ""
    weak = meta | {"dc_link_v": 0.3 * meta["dc_link_v"]}
    drive["bridge.dc_link_v"] = weak["dc_link_v"]
    assert "voltage limit" in why_unfit(weak, run_experiments(drive, experiments, [0.0] * 8, 1), experiments)


def test_effects_and_sizes_come_up_equally_often_and_in_no_order() -> None:
    plans = plan_cases({"single": 60, "pair": 10, "none": 6, "outside": 12}, seed=5)

    assert [plan.case for plan in plans] == [f"case_{n:04d}" for n in range(1, 89)]
    singles = Counter((plan.names[0], plan.size) for plan in plans if plan.kind == "single")
    assert set(singles) == {(name, size) for name in EFFECTS for size in range(3)}
    assert {plan.names[0] for plan in plans if plan.kind == "outside"} == set(OUTSIDE)
    assert all(set(plan.names) != {"two_mass", "backlash"} for plan in plans)
    kinds = [plan.kind for plan in plans]
    assert sorted(kinds) != kinds
    assert plan_cases({"single": 60, "pair": 10, "none": 6, "outside": 12}, seed=5) == plans
