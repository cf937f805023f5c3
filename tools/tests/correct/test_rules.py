"""The table of corrections: complete, as the documentation has it, and each correction takes away what its effect adds.

The machine that is corrected is simulated with the effect in it; what counteracts it comes from the rules alone.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evenspin.correct.changes import ADD, TIMES, Change, composed, known, scaled
from evenspin.correct.found import Found
from evenspin.correct.predict import Prediction
from evenspin.correct.proposal import Correction, _doubt, _Draft, _harm, _together, propose
from evenspin.correct.quantities import Quantity
from evenspin.correct.rules import RULES, NoRule, Rule, as_markdown
from evenspin.errors import InputError
from evenspin.gap import plan as planning
from evenspin.log.case import Case
from evenspin.log.meta_numbers import MetaNumbers
from evenspin.log.nominal import Nominal
from evenspin.model.machine import builtin_models, load_machine
from evenspin.native import tables

ROOT = Path(__file__).resolve().parents[3]
EFFECTS = {  # outside of what a healthy unit may be off by
    "cogging": {"amplitude_nm": -0.05, "phase_rad": 0.7, "order": 18.0},
    "misalignment": {"amplitude_nm": 0.05, "phase_rad": 0.7, "second_rel": 0.5, "phase2_rad": 1.0},
    "current_offset": {"offset_a_a": 0.1, "offset_b_a": -0.05},
    "current_gain": {"gain_a": 1.02, "gain_b": 0.98},
    "dead_time": {"dead_time_s": 1.7e-6},
    "coulomb_friction": {"torque_nm": 0.06},
    "stribeck_friction": {"torque_nm": 0.06, "speed_rad_s": 8.0, "shape": 2.0},
    "inertia": {"factor": 1.2},
    "torque_constant": {"factor": 0.92},
    "winding_resistance": {"factor": 1.25},
    "encoder_offset": {"angle_el_rad": -0.07},
    "current_loop_delay": {"extra_periods": 1.0},
    "current_filter": {"tau_s": 8e-5},
    "encoder_eccentricity": {"amplitude_rad": 0.007, "phase_rad": 2.2},
    "flux_harmonics": {"torque_ripple_rel": 0.03, "sign": -1.0, "fifth_share": 0.5},
    "inductance_saturation": {"i_sat_a": 6.0, "by_amplitude": 0.0, "by_slope": 0.0},
    "two_mass": {"f_res_hz": 60.0, "load_ratio": 0.6, "damping_ratio": 0.02, "load_friction_share": 0.5},
}


def _proposed(effects, halves=None, recorded=()):
    """A log with these effects, and what is proposed when they are known, within `halves`."""
    machine = replace(load_machine(builtin_models()["servo"]), effects=effects)
    experiments = planning.plan(machine, 1)
    meta = planning.meta(experiments, "case")
    found = Found(effects, halves or {}, np.zeros(9), Nominal.of(MetaNumbers(Path("case"), meta)))
    shown = [(rule.spoils, rule.beside) for rule in map(RULES.__getitem__, effects)]
    wanted = {
        name
        for effect, quantities in zip(effects, shown, strict=True)
        for quantity in quantities
        if quantity is not None
        for name in quantity(found, [effect]).records
    }
    wanted = set(recorded) or wanted
    case = Case(Path("case"), meta, {e.name: planning.perform(e) for e in experiments if e.name in wanted})
    return propose(case, "case", tuple(effects), found)


def test_every_effect_of_the_simulator_has_a_correction_or_a_reason():
    assert set(RULES) == set(tables().effects)
    for rule in RULES.values():
        names = rule.parameters if isinstance(rule, Rule) else ()
        assert set(names) <= set(tables().params)
        assert isinstance(rule, Rule) or len(rule.reason) > 20


def test_the_documentation_has_the_table():
    assert as_markdown() in (ROOT / "docs" / "corrections.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("effect", EFFECTS)
def test_a_correction_takes_four_fifths_of_what_its_effect_adds_and_changes_what_the_table_says(effect):
    proposal = _proposed({effect: EFFECTS[effect]})

    assert proposal.left == ()
    (correction,) = proposal.corrections
    assert correction.predicted.reduction >= 0.8
    # the log and the simulation of the machine that made it agree: other noise is all that differs
    assert correction.predicted.log == pytest.approx(correction.predicted.without, rel=0.1)
    rule = RULES[effect]
    assert {change.parameter for change in correction.changes} <= {
        *rule.parameters, *(f"rdc_line2_{x}" for x in ("cycles", "nm", "rad"))
    }  # fmt: skip


@pytest.mark.parametrize("effect", [name for name, rule in RULES.items() if isinstance(rule, NoRule)])
def test_what_the_drive_cannot_correct_is_said_with_the_reason_and_changes_nothing(effect):
    case = Case(Path("case"), {}, {})
    machine = load_machine(builtin_models()["servo"])
    meta = planning.meta(planning.plan(machine, 1), "case")
    params = {name: field.default for name, field in tables().effects[effect].params.items()}
    found = Found({effect: params}, {}, np.zeros(9), Nominal.of(MetaNumbers(Path("case"), meta)))
    proposal = propose(case, "case", (effect, "unknown"), found)

    assert proposal.corrections == ()
    assert [each.effect for each in proposal.left] == [effect]


def test_a_size_that_its_interval_swallows_is_not_corrected():
    wide = {"cogging": {"amplitude_nm": 0.001, "phase_rad": 1.3}}  # at its end the line would add what it takes away
    proposal = _proposed({"cogging": EFFECTS["cogging"]}, wide)

    assert proposal.corrections == ()
    assert "uncertain" in proposal.left[0].reason


def test_a_ripple_is_measured_under_load_where_the_staircase_was_not_recorded():
    proposal = _proposed({"cogging": EFFECTS["cogging"]}, recorded=("staircase_load",))
    assert proposal.corrections[0].spoils.records == ("staircase_load",)
    assert proposal.corrections[0].predicted.reduction > 0.8

    nowhere = _proposed({"cogging": EFFECTS["cogging"]}, recorded=("reversal",))
    assert nowhere.corrections == () and "was not recorded" in nowhere.left[0].reason


def test_what_spoils_nothing_is_not_corrected():
    proposal = _proposed({"winding_resistance": {"factor": 1.01}})

    assert proposal.corrections == ()
    assert "not worth it: current after a step" in proposal.left[0].reason


def test_viscous_friction_is_fed_forward_as_far_as_it_is_beyond_nominal():
    (correction,) = _proposed({"viscous_friction": {"factor": 1.7}}).corrections
    values = {change.parameter: change.value for change in correction.changes}
    assert values["rdc_viscous_nms"] == pytest.approx(0.7 * 0.002)  # of the servo model
    assert correction.predicted.reduction > 0.8

    less = _proposed({"viscous_friction": {"factor": 0.7}})
    assert less.corrections == () and "less of it than nominal" in less.left[0].reason


def test_frictions_are_one_correction_and_lines_are_counted_through():
    both = {"coulomb_friction": {"torque_nm": 0.04}, "stribeck_friction": EFFECTS["stribeck_friction"]}
    proposal = _proposed({**both, "misalignment": EFFECTS["misalignment"], "cogging": EFFECTS["cogging"]})

    assert [c.name for c in proposal.corrections] == ["friction", "misalignment", "cogging"]
    values = composed({c.name: c.changes for c in proposal.corrections}, dict.fromkeys(tables().params, 0.0))
    assert values["rdc_coulomb_nm"] == pytest.approx(0.04)
    assert values["rdc_static_nm"] == pytest.approx(0.10)  # the whole static friction, docs/parameters.md
    assert [values[f"rdc_line{n}_cycles"] for n in (1, 2, 3)] == [1.0, 2.0, 18.0]
    assert values["rdc_line3_nm"] == pytest.approx(0.05)  # no line has a negative amplitude
    assert all(c.predicted.reduction > 0.8 for c in proposal.corrections)


def test_a_slower_current_loop_has_the_phase_margin_of_the_designed_one():
    (correction,) = _proposed({"current_loop_delay": EFFECTS["current_loop_delay"]}).corrections
    values = {change.parameter: change.value for change in correction.changes}
    # with kp / ki = L / R the open loop is kp / (s L) exp(-s T): its margin is 90 degrees less kp T / L, and kp T stays
    assert values["current_kp_v_per_a"] * (1.5 + 1.0) == pytest.approx(1.5)
    assert values["current_ki_v_per_as"] == values["current_kp_v_per_a"]  # the zero stays on the pole of the winding


def test_a_correction_that_another_spoils_is_left_out_naming_it():
    class Together:
        """Two corrections that take half away alone; beside the second one the first does harm."""

        def predict(self, quantity, corrections, effects):
            spoiled = effects == ("one",) and len(corrections) > 1
            after = 2.0 if spoiled else 0.5
            return Prediction(1.0, 0.0, 1.0, after, after, after)

    quantity = Quantity("speed_ripple", ("staircase",), (1.0,))
    alone = Prediction(1.0, 0.0, 1.0, 0.5, 0.5, 0.5)
    corrections = [Correction(name, (name,), (), quantity, alone) for name in ("one", "two")]
    left = []

    (kept,) = _together(Together(), corrections, left)
    assert kept == corrections[1]
    assert left[0].effect == "one" and left[0].reason.startswith("beside the correction of two uncertain")


def test_what_chance_makes_as_small_as_the_correction_would_is_not_corrected():
    """A speed after a reversal goes with the place of the shaft, by more than with a friction that is little off."""
    quantity = Quantity("reversal", ("reversal",))
    draft = Correction("friction", ("viscous_friction",), (), quantity, Prediction(2.6, 1.5, 2.7, 1.7, 1.2, 2.5, 2.6))
    assert _doubt(draft, draft.predicted) == ""
    by_chance = replace(draft.predicted, without_low=1.4)
    assert "may be 1.4 r/min by chance alone, and up to 2.5 r/min with the correction" in _doubt(draft, by_chance)


def test_the_least_without_a_correction_is_that_of_several_runs_which_differ_by_noise_alone():
    predicted = _proposed({"cogging": EFFECTS["cogging"]}).corrections[0].predicted
    # noise of 0.02 A against a cogging of 50 mN m: the runs are close together
    assert 0.98 * predicted.without < predicted.without_low <= predicted.without
    assert predicted.without_low > predicted.high


def test_a_slow_current_loop_makes_the_correction_of_the_resistance_uncertain():
    both = {"winding_resistance": {"factor": 1.25}, "current_loop_delay": EFFECTS["current_loop_delay"]}
    proposal = _proposed(both)

    assert [c.name for c in proposal.corrections] == ["current_loop_delay"]
    assert proposal.left[0].effect == "winding_resistance" and "uncertain" in proposal.left[0].reason


def test_a_line_beside_a_wrong_electrical_zero_stands_over_the_angle_of_the_encoder():
    effects = {"cogging": EFFECTS["cogging"], "encoder_offset": {"angle_el_rad": 0.3}}
    proposal = _proposed(effects)

    # at order 18 and with 3 pole pairs the line turns by 18 * 0.3 / 3 = 1.8 rad: a wrong sign would double the ripple
    assert {c.name: c.predicted.reduction > 0.8 for c in proposal.corrections} == {
        "cogging": True,
        "encoder_offset": True,
    }


def test_the_angle_of_a_disc_off_centre_beside_a_wrong_electrical_zero_stands_over_the_angle_of_the_encoder():
    effects = {
        "encoder_eccentricity": {"amplitude_rad": 0.01, "phase_rad": 2.2},
        "encoder_offset": {"angle_el_rad": 0.3},
    }
    proposal = _proposed(effects)

    # with 3 pole pairs the angle is ahead by 0.1 rad
    values = {c.parameter: c.value for each in proposal.corrections for c in each.changes}
    assert math.atan2(values["encoder_cos1_rad"], values["encoder_sin1_rad"]) == pytest.approx(2.2 - 0.1)
    assert {c.name: c.predicted.reduction > 0.9 for c in proposal.corrections} == dict.fromkeys(effects, True)


def test_what_is_larger_than_its_parameter_is_not_corrected_in_part():
    proposal = _proposed({"encoder_eccentricity": {"amplitude_rad": 0.11, "phase_rad": 0.0}}, recorded=("reversal",))
    assert proposal.left[0].reason == "it is larger than the 0.1 rad that encoder_cos1_rad takes"


def test_a_notch_is_proposed_only_where_load_steps_were_recorded_and_do_not_swing_more():
    shaft = {"two_mass": EFFECTS["two_mass"]}
    nowhere = _proposed(shaft, recorded=("staircase",))
    assert nowhere.corrections == () and "shows in load_step, which was not recorded" in nowhere.left[0].reason

    class Grown:
        """A machine whose loop has damped the resonance by itself until the notch came."""

        found = Found(shaft, {}, np.zeros(9), None)

        def grows(self, quantity, changes):
            assert quantity.records == ("load_step",) and quantity.hz == (60.0,)
            return 0.5, 0.53

    draft = _Draft("two_mass", ("two_mass",), (), Quantity("swing", ("staircase",), hz=(60.0,)))
    assert _harm(Grown(), draft).endswith("would grow from 0.5 to 0.53 r/min")
    Grown.grows = lambda self, quantity, changes: (0.5, 0.52)
    assert _harm(Grown(), draft) == ""


def test_a_notch_where_the_resonance_hardly_shows_is_not_worth_it_or_uncertain():
    stiff = {"two_mass": {"f_res_hz": 140.0, "load_ratio": 0.25, "damping_ratio": 0.06, "load_friction_share": 0.5}}
    proposal = _proposed(stiff)
    assert proposal.corrections == ()
    assert "swing of the speed at 140 Hz" in proposal.left[0].reason


def test_factors_multiply_and_two_values_for_one_parameter_are_refused_naming_both():
    gains = {"inertia": [scaled("speed_kp_a_per_unit", 1.2, 0.0)], "flux": [scaled("speed_kp_a_per_unit", 0.5, 0.0)]}
    assert composed(gains, {"speed_kp_a_per_unit": 2.0}) == {"speed_kp_a_per_unit": pytest.approx(1.2)}
    same = {"one": [known("speed_model_ff", 1.0)], "two": [known("speed_model_ff", 1.0)]}
    assert composed(same, {"speed_model_ff": 0.0}) == {"speed_model_ff": 1.0}
    fight = {"one": [known("motor_psi_wb", 0.1)], "two": [known("motor_psi_wb", 0.2)]}
    with pytest.raises(InputError, match=r"two.*motor_psi_wb.*one"):
        composed(fight, {"motor_psi_wb": 0.1})
    mixed = {"one": [Change("dead_time_s", ADD, 1e-6, 0, 0)], "two": [Change("dead_time_s", TIMES, 2.0, 0, 0)]}
    with pytest.raises(InputError, match="dead_time_s"):
        composed(mixed, {"dead_time_s": 0.0})


def test_an_interval_never_leaves_the_range_of_its_parameter():
    assert known("rdc_line1_nm", 0.01, 0.02).low == 0.0
    assert math.isclose(known("rdc_line1_nm", 0.01, 0.02).high, 0.03)
