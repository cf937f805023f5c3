"""What a record is reduced to, and the algebra that weighs it."""

from __future__ import annotations

import math
import pkgutil
from pathlib import Path

import numpy as np
import pytest
from evenspin.effects import Scale, hypotheses, known_orders
from evenspin.effects.cogging import slot_order
from evenspin.effects.hypothesis import by_roles
from evenspin.gap.evidence import OUTLIER_SIGMAS, Judge, Noise, robust_cost
from evenspin.gap.features import SIGNALS, FeatureSet
from evenspin.gap.forward import READ, Forward
from evenspin.gap.layout import Bins, Layout, Stretch, layout_of
from evenspin.gap.screening import probe_points
from evenspin.log.case import read_case
from evenspin.log.tolerance import SIGMA, TOLERANCES, unit_of
from evenspin.native import tables

RATE_HZ = 2000.0
MOTOR = {"pole_pairs": 3, "slots": 18, "rated_current_a": 5.0, "rated_torque_nm": 2.0}
SCALE = Scale.of(MOTOR, 4000.0)
EXPLANATIONS = {name for name, effect in tables().effects.items() if not effect.scenario_only}


def steady(speed_rad_s=20.0, rows=1600, orders=(1.0, 3.0, 6.0)):
    layout = Layout("staircase", (Stretch(0, rows, speed_rad_s, 0.0),), ())
    return FeatureSet(layout, orders, RATE_HZ), 0.4 + speed_rad_s * np.arange(rows) / RATE_HZ


def named(features, values):
    def name(key):
        return key.kind if key.order is None else f"{key.part}{key.order:g}"

    return {(key.signal, name(key)): value for key, value in zip(features.keys(), values, strict=True)}


def test_mean_trend_and_orders_of_a_steady_stretch_come_back_as_they_were_put_in():
    features, theta = steady()
    x = np.linspace(-1.0, 1.0, len(theta))
    signals = np.zeros((len(theta), len(SIGNALS)))
    signals[:, 0] = 20.0 + 0.3 * x + 0.2 * np.cos(3.0 * theta) - 0.1 * np.sin(theta)

    got = named(features, features.values(theta, signals))

    for name, value in {"mean": 20.0, "trend": 0.3, "cos3": 0.2, "sin3": 0.0, "sin1": -0.1, "cos6": 0.0}.items():
        assert got[("speed_rad_s", name)] == pytest.approx(value, abs=1e-6)
        assert got[("iq_a", name)] == pytest.approx(0.0, abs=1e-9)


def test_features_do_not_know_at_which_angle_a_stretch_began():
    features, theta = steady()
    wave = lambda angle: np.stack([np.cos(3.0 * angle + 0.7)] * len(SIGNALS), axis=1)  # noqa: E731
    shifted = theta + 1.234

    assert features.values(shifted, wave(shifted)) == pytest.approx(features.values(theta, wave(theta)), abs=0.02)


def test_an_order_that_takes_less_than_a_turn_is_not_fitted():
    slow, theta = steady(speed_rad_s=2.0)  # 0.25 turns

    names = {str(key) for key in slow.keys()}

    assert len(slow.values(theta, np.zeros((len(theta), len(SIGNALS))))) == len(slow.keys())
    assert "staircase speed_rad_s steady0:cos1" not in names
    assert "staircase speed_rad_s steady0:cos6" in names


def test_a_key_is_written_with_its_record_its_signal_and_what_of_which_block():
    layout = Layout(
        "coast_down",
        (Stretch(0, 800, 40.0, 0.0, coasting=True),),
        (Bins("step", np.array([0, 5])), Bins("ramp", np.array([5, 9, 12]))),
    )
    names = [str(key) for key in FeatureSet(layout, (1.0, 2.5), RATE_HZ).keys() if key.signal == "iq_a"]

    assert names == [
        "coast_down iq_a coast0:mean",
        "coast_down iq_a coast0:trend",
        "coast_down iq_a coast0:curve",
        "coast_down iq_a coast0:cos1",
        "coast_down iq_a coast0:sin1",
        "coast_down iq_a step0:0",
        "coast_down iq_a ramp1:0",
        "coast_down iq_a ramp1:1",
    ]


def test_bins_are_means_over_their_rows():
    layout = Layout("reversal", (), (Bins("ramp", np.array([2, 4, 10])),))
    features = FeatureSet(layout, (1.0,), RATE_HZ)
    signals = np.outer(np.arange(12.0), np.ones(len(SIGNALS)))

    got = features.values(np.zeros(12), signals).reshape(2, len(SIGNALS))

    assert got[:, 0] == pytest.approx([2.5, 6.5])


@pytest.mark.parametrize(
    ("pole_pairs", "slots", "order"), [(3, 18, 18), (4, 12, 24), (5, 12, 60), (4, 9, 72), (7, 12, 84)]
)
def test_cogging_repeats_with_the_least_common_multiple_of_slots_and_poles(pole_pairs, slots, order):
    assert slot_order(pole_pairs, slots) == order
    assert float(order) in known_orders(Scale(5.0, 1.0, pole_pairs, slots, 4000.0))


class FakeReplay:
    def __init__(self, record, locked=False, released=None):
        self.name, self.locked, self._released = record, locked, released

    def released_at(self):
        return self._released


def record_of(speed_ref, load=None):
    from evenspin.sim.record import Record

    n = len(speed_ref)
    columns = {
        "t_s": np.arange(n) / RATE_HZ,
        "speed_ref_rad_s": speed_ref,
        "speed_rad_s": speed_ref,
        "load_torque_nm": np.full(n, np.nan) if load is None else load,
    }
    return Record(tuple(columns), ("",) * len(columns), np.stack(list(columns.values()), axis=1))


def test_a_staircase_has_a_steady_stretch_per_level_behind_its_transient():
    layout = layout_of(FakeReplay("staircase"), record_of(np.repeat([10.0, 20.0, -10.0], 1600)))

    assert [round(s.speed_rad_s) for s in layout.steady] == [10, 20, -10]
    assert [(s.start, s.end) for s in layout.steady] == [(600, 1600), (2200, 3200), (3800, 4800)]
    assert [b.kind for b in layout.bins] == ["step"] * 3


def test_a_ramp_is_cut_into_even_bins_and_has_no_steady_stretch():
    ref = np.concatenate((np.zeros(400), np.linspace(0.0, 30.0, 1000), np.full(200, 30.0)))

    layout = layout_of(FakeReplay("reversal"), record_of(ref))

    ramp = next(b for b in layout.bins if b.kind == "ramp")
    assert abs(ramp.edges[0] - 400) <= 2
    assert set(np.diff(ramp.edges)) <= {49, 50, 51}
    assert all(s.end <= 402 or s.start >= 1398 for s in layout.steady)


def test_a_step_of_the_load_parts_a_stretch():
    load = np.repeat([0.0, 1.0], 2000) + np.random.default_rng(1).normal(0.0, 0.02, 4000)

    layout = layout_of(FakeReplay("load_step"), record_of(np.full(4000, 30.0), load))

    assert len(layout.steady) == 2
    assert [round(s.load_nm) for s in layout.steady] == [0, 1]
    assert abs(layout.bins[1].edges[0] - 2000) <= 12


# ---- weighing ---------------------------------------------------------------------------------------------------


def judge(n=400, sigma=0.5):
    return Judge(Noise(np.full(n, sigma), np.ones(n, dtype=bool), np.zeros(n, dtype=np.int64), (("a", "b", "c"),)))


def test_a_column_is_found_with_its_amount_and_a_fair_interval():
    random = np.random.default_rng(2)
    column = random.normal(size=(400, 1))
    amounts = []
    for _ in range(200):
        y = 0.8 * column[:, 0] + random.normal(0.0, 0.5 * math.sqrt(1.5), 400)  # two probes behind a model add a half
        fit = judge().fit(y, np.zeros((400, len(SIGMA))), column)
        amounts.append((fit.amount[0], math.sqrt(fit.covariance[0, 0])))
    got, reported = np.array(amounts).T

    assert np.mean(got) == pytest.approx(0.8, abs=4.0 * np.std(got) / math.sqrt(200))
    assert np.mean(reported) == pytest.approx(np.std(got), rel=0.25)  # 200 draws: 5 %; the soft loss: some per cent


def test_a_few_wild_residuals_do_not_move_the_amount():
    random = np.random.default_rng(3)
    column = random.normal(size=(400, 1))
    y = 0.8 * column[:, 0] + random.normal(0.0, 0.5, 400)
    outliers = y.copy()
    outliers[:10] += 500.0

    fit = judge().fit(outliers, np.zeros((400, len(SIGMA))), column)

    assert fit.amount[0] == pytest.approx(judge().fit(y, np.zeros((400, len(SIGMA))), column).amount[0], abs=0.06)


def test_a_tolerance_is_only_moved_as_far_as_its_prior_lets_it():
    nuisance = np.zeros((400, len(SIGMA)))
    nuisance[:, 0] = 1e-3  # hardly visible: one sigma of it changes nothing
    y = np.full(400, 0.01)

    assert abs(judge().fit(y, nuisance).delta[0]) < 0.1 * SIGMA[0]


def test_the_cost_of_small_residuals_is_chi_square_and_of_large_ones_their_logarithm():
    assert robust_cost(np.array([0.1])) == pytest.approx(0.01, rel=1e-3)
    assert robust_cost(np.array([1e6])) == pytest.approx(
        2.0 * OUTLIER_SIGMAS**2 * math.log(1e6 / OUTLIER_SIGMAS), rel=1e-6
    )


# ---- hypotheses -------------------------------------------------------------------------------------------------


def test_every_effect_of_the_table_is_a_hypothesis_but_sums_of_others():
    assert set(hypotheses(SCALE)) == EXPLANATIONS


@pytest.mark.parametrize("name", sorted(EXPLANATIONS))
def test_every_start_and_probe_of_a_hypothesis_is_within_the_ranges_of_its_effect(name):
    hypothesis = hypotheses(SCALE)[name]
    fields = tables().effects[name].params
    for start in hypothesis.starts:
        z = np.array(start, dtype=float)
        for i, coordinate in enumerate(hypothesis.coordinates):
            moved = z.copy()
            moved[i] += coordinate.probe
            for param, value in hypothesis.to_params(hypothesis.clip(moved)).items():
                assert fields[param].minimum <= value <= fields[param].maximum, (param, value)


def test_an_effect_without_a_module_is_searched_by_the_roles_of_its_parameters():
    """Cogging as somebody would search it who knows nothing but its file."""
    cogging = by_roles("cogging", SCALE)
    stribeck = by_roles("stribeck_friction", SCALE)
    gains = by_roles("current_gain", SCALE)

    assert len(cogging.coordinates) == 2 and cogging.magnitude(np.zeros(2)) == 0.0
    assert cogging.to_params(np.array([0.0, 0.3])) == pytest.approx(
        {"amplitude_nm": 0.3, "phase_rad": math.pi / 2.0, "order": 24.0}
    )
    assert stribeck.to_params(np.array([0.1, 0.0])) == {"torque_nm": 0.1, "speed_rad_s": 1.0, "shape": 2.0}
    assert gains.to_params(np.array([0.0, math.log(1.1)])) == pytest.approx({"gain_a": 1.0, "gain_b": 1.1})


def test_orders_at_which_effects_show_come_from_the_effects_the_plainest_first():
    """p = 4 and 9 slots: shaft 1 and 2, electrical 4 and 8, sixth electrical 24, slots and poles 72, slots alone 9."""
    assert known_orders(Scale(5.0, 1.0, 4, 9, 4000.0)) == (1.0, 2.0, 4.0, 8.0, 24.0, 72.0, 9.0)
    assert known_orders(Scale(5.0, 1.0, 4, 0, 4000.0)) == (1.0, 2.0, 4.0, 8.0, 24.0)


def test_every_module_of_an_effect_is_named_like_one():
    import evenspin.effects

    modules = {module.name for module in pkgutil.iter_modules(evenspin.effects.__path__)}
    assert modules - set(tables().effects) == {"equations", "hypothesis", "registry"}


def test_every_effect_that_may_explain_a_log_says_how_it_shows_and_what_it_looks_like():
    from evenspin.log.experiments import EXPERIMENTS

    for name in EXPLANATIONS:
        effect = tables().effects[name]
        assert effect.told_apart and effect.shown_by and effect.confused_with, name
        assert set(effect.shown_by) <= set(EXPERIMENTS), name
        assert set(effect.confused_with) <= EXPLANATIONS - {name}, name


def test_the_example_of_every_effect_is_within_its_range_and_does_something():
    for effect in tables().effects.values():
        assert all(p.minimum <= p.example <= p.maximum for p in effect.params.values()), effect.name
        assert any(p.example != p.default for p in effect.params.values()), effect.name


def test_amplitude_and_phase_are_those_of_the_sine_and_cosine_parts():
    cogging = hypotheses(SCALE)["cogging"]
    phase = 2.1

    params = cogging.to_params(0.3 * np.array([math.cos(phase), math.sin(phase)]))

    assert params == pytest.approx({"amplitude_nm": 0.3, "phase_rad": phase, "order": 18.0})


def test_the_edge_of_a_tolerance_has_the_magnitude_one():
    library = hypotheses(SCALE)

    for name, tolerance in (("inertia", 0.012), ("winding_resistance", 0.012), ("torque_constant", 0.004)):
        assert library[name].magnitude(np.array([math.log(1.0 + 3.0 * tolerance)])) == pytest.approx(1.0, rel=0.03)


def test_an_effect_and_a_tolerance_of_the_same_sensor_add_up():
    delta = np.zeros(len(TOLERANCES))
    delta[5] = 0.01

    unit = unit_of({"current_offset": {"offset_a_a": 0.1}}, delta)

    assert unit.effects["current_offset"] == pytest.approx({"offset_a_a": 0.11})


def test_the_log_format_says_the_tolerances():
    text = (Path(__file__).parents[3] / "docs" / "log-format.md").read_text()

    for word in ("1.2 %", "1.5 %", "0.4 %", "4 %", "10 mA", "0.2 %"):
        assert word in text


def test_the_second_order_of_a_misalignment_is_probed_beside_the_first_to_which_it_is_relative():
    misalignment = hypotheses(SCALE)["misalignment"]

    first, _, second, _ = probe_points(misalignment, np.zeros(4))

    assert misalignment.to_params(first)["second_rel"] == 0.0
    assert misalignment.to_params(second) == pytest.approx(
        {"amplitude_nm": 0.04, "phase_rad": 0.0, "second_rel": 1.0, "phase2_rad": 0.0}
    )


def test_what_no_feature_needs_is_not_simulated_and_no_feature_changes():
    """Where a coasting rotor has become slow nothing is compared."""
    forward = Forward(read_case(Path(__file__).parents[3] / "tests" / "data" / "foreign_drive" / "example_clean"), 1)
    unit = unit_of({}, None, 3, 0.25)
    whole = [replay.run(READ, unit) for replay in forward.replays]

    rows = {replay.name: len(record) for replay, record in zip(forward.replays, forward.simulate(unit), strict=True)}

    assert rows["coast_down"] < 0.5 * len(forward.case.experiments["coast_down"])
    assert rows["staircase"] == len(forward.case.experiments["staircase"])
    assert np.array_equal(forward.features(unit), forward.reduced(whole))
    forward.close()
