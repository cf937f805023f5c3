"""The eight experiments of the log format, its tolerances and its controller: one home, checked by the blind bench."""

from __future__ import annotations

import math

import numpy as np
import pytest
from evenspin.bench.experiments import plan as bench_plan
from evenspin.bench.runner import LOG_CONTROLLER
from evenspin.blind import cases
from evenspin.blind.experiments import all_experiments
from evenspin.gap.plan import plan as gap_plan
from evenspin.gap.plan import top_speed
from evenspin.log.controller import FORMAT_CONTROLLER, format_controller
from evenspin.log.experiments import EXPERIMENTS, FITTED, LOADED, LOCKED, VALIDATION
from evenspin.log.plan import Sizes, eight_experiments
from evenspin.log.tolerance import TOLERANCES
from evenspin.model import builtin_models, load_machine
from evenspin.native import tables

RPM = math.pi / 30.0
RATED_A, RATED_NM = 4.0, 1.6
PWM_HZ = 10_000.0
SAME = ("staircase", "staircase_load", "load_step", "coast_down", "standstill_steps")  # neither random nor a ramp


@pytest.fixture(scope="module")
def eight():
    return {e.name: e for e in eight_experiments(Sizes(600.0 * RPM, 0.5 * RATED_NM, RATED_A))}


def test_the_classes_name_the_experiments_by_what_they_command(eight):
    assert tuple(eight) == EXPERIMENTS == (*FITTED, *VALIDATION)
    assert tuple(name for name, e in eight.items() if e.rotor_locked) == LOCKED
    assert tuple(name for name, e in eight.items() if e.needs_load_machine) == LOADED


@pytest.mark.parametrize("name", SAME)
def test_at_600_rpm_they_are_those_that_the_blind_bench_has_on_its_own(eight, name):
    """Two lists that were written apart: a wrong level, time or order in either shows."""
    theirs = next(e for e in all_experiments(np.random.default_rng(1), RATED_A, RATED_NM) if e.name == name)
    mine = eight[name]

    assert mine.duration_s == pytest.approx(theirs.duration_s)
    assert mine.log_rate_hz == PWM_HZ / theirs.decimate
    t_s = np.arange(len(theirs.inputs)) / PWM_HZ
    for curve in ("speed_ref_rad_s", "id_ref_a", "iq_ref_a", "load_torque_nm"):
        sampled = [mine.value(curve, t) for t in t_s[::50]]
        np.testing.assert_allclose(sampled, getattr(theirs.inputs, curve)[::50], rtol=1e-9, err_msg=curve)
    current = mine.mode == "current" or (mine.current_from_s is not None and t_s >= mine.current_from_s)
    np.testing.assert_array_equal(np.broadcast_to(current, t_s.shape), theirs.inputs.current_mode > 0.5)


@pytest.mark.parametrize("model", sorted(builtin_models()))
def test_the_bench_and_the_virtual_drive_perform_the_same_list_at_their_own_top_speed(model):
    machine = load_machine(builtin_models()[model])
    scale = max(bench_plan(machine)[4].curves["speed_ref_rad_s"].value) / top_speed(machine)

    for bench, virtual in zip(bench_plan(machine), gap_plan(machine, 2024), strict=True):
        assert (bench.name, bench.duration_s) == (virtual.name, virtual.setup.duration_s)
        for name, unit in (("speed_ref_rad_s", scale), ("load_torque_nm", 1.0)):
            assert (name in bench.curves) == (name in virtual.setup.inputs)
            if name in bench.curves:
                mine, theirs = bench.curves[name], virtual.setup.inputs[name]
                assert mine.t_s == theirs.t_s
                assert mine.value == pytest.approx([unit * v for v in theirs.value], abs=2e-6)  # written in 6 decimals


def test_the_controller_of_the_format_is_set_by_the_bench_and_known_to_the_drive():
    params = tables().params
    assert LOG_CONTROLLER.items() >= FORMAT_CONTROLLER.items()
    for name, value in format_controller().items():
        assert params[name].to_text(value) == FORMAT_CONTROLLER[name]


def test_the_tolerances_are_those_that_the_blind_bench_draws_units_from():
    """Written apart on purpose: docs/log-format.md is what both follow."""
    sigma = {t.name: t.sigma for t in TOLERANCES}
    bounds = {name.split(".")[1].split("_")[0]: bound for name, bound in cases.TOLERANCE.items()}
    bounds["flux"] = bounds.pop("psi")
    assert {name: sigma[name] for name in bounds} == bounds
    assert {sigma["offset_a"], sigma["offset_b"]} == {cases.OFFSET_TOLERANCE_A}
    assert {sigma["gain_a"], sigma["gain_b"]} == {cases.GAIN_TOLERANCE}


def test_an_effect_that_is_a_tolerance_only_larger_stands_in_the_table_as_one():
    effects = tables().effects
    for tolerance in TOLERANCES:
        if tolerance.sensor is not None:
            effect, param = tolerance.sensor
            assert tolerance.effect == effect and effects[effect].params[param].vector
        elif tolerance.effect:
            assert [p.role for p in effects[tolerance.effect].params.values()] == ["factor"]
            assert effects[tolerance.effect].acts_on == "model"
