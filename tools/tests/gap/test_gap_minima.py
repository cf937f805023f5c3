"""The search among many minima of cost, on a model of one line whose answers are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from evenspin.effects import Coordinate, Hypothesis, Scale, hypotheses
from evenspin.gap.candidate import Candidate, Model, noise_price
from evenspin.gap.evidence import Judge, Noise
from evenspin.gap.fitting import Fitter
from evenspin.gap.minima import MinimaSearch, neighbours
from evenspin.gap.strategies import Detents, Downhill, LocalMinima, strategy_for
from evenspin.gap.thresholds_evidence import NEIGHBOUR_SHARE
from evenspin.log.tolerance import SIGMA

T_S = np.linspace(0.0, 1.0, 400)
RING_HZ, RAMP = 23.0, 0.7  # what the log of these tests has; the starts are at 15, 20 and 30 Hz
MOTOR = {"rated_current_a": 5.0, "rated_torque_nm": 1.0, "pole_pairs": 4, "slots": 12}


def ring(hz):
    return np.sin(2.0 * math.pi * hz * T_S) * np.exp(-2.0 * T_S)


class OneLine:
    """A forward model without a simulator: a ring of some frequency and a ramp of some height."""

    measured = ring(RING_HZ) + RAMP * T_S

    def __init__(self):
        self.simulations = 0

    def many(self, units):
        self.simulations += len(units)
        return [self.features(unit.effects) for unit in units]

    @staticmethod
    def features(effects):
        hz = effects.get("ring", {}).get("hz")
        return (0.0 if hz is None else ring(hz)) + effects.get("ramp", {}).get("height", 0.0) * T_S


LIBRARY = {
    "ring": Hypothesis(
        "ring",
        (Coordinate("log_hz", 0.03, math.log(5.0), math.log(100.0), 0.2),),
        lambda z: {"hz": math.exp(float(z[0]))},
        lambda z: 2.0,
        tuple((math.log(hz),) for hz in (15.0, 20.0, 30.0)),
        linear=False,
    ),
    "ramp": Hypothesis(
        "ramp", (Coordinate("height", 0.1),), lambda z: {"height": float(z[0])}, lambda z: 2.0, ((0.0,),)
    ),
}


def noise(sigma):
    n = len(T_S)
    return Noise(np.full(n, sigma), np.ones(n, dtype=bool), np.zeros(n, dtype=np.int64), (("a", "b", "c"),))


@pytest.fixture
def fitter():
    return Fitter(OneLine(), LIBRARY, np.zeros((len(T_S), len(SIGMA))), Judge(noise(0.05)))


def test_a_ring_is_found_from_starts_between_which_the_cost_has_minima_of_its_own(fitter):
    home = {"ring": np.array([math.log(15.0)]), "ramp": np.array([0.0])}
    straight = fitter.descended(fitter.model(home), 8)  # downhill alone

    found = MinimaSearch(fitter, MinimaSearch(fitter, home).lowest()).bottom()

    assert abs(math.exp(straight.z["ring"][0]) - RING_HZ) > 3.0
    assert math.exp(found["ring"][0]) == pytest.approx(RING_HZ, rel=0.02)


def test_a_linear_partner_follows_without_simulations_of_its_own(fitter):
    alone = MinimaSearch(fitter, {"ring": np.array([math.log(15.0)])})
    before = fitter.forward.simulations
    alone.lowest()
    one = fitter.forward.simulations - before
    pair = MinimaSearch(fitter, {"ring": np.array([math.log(15.0)]), "ramp": np.array([0.1])})
    before = fitter.forward.simulations

    found = pair.lowest()

    assert fitter.forward.simulations - before == one
    assert found["ramp"][0] == pytest.approx(RAMP, abs=0.03)  # the ring is 2 % off at most: its mean is


def test_the_bottom_is_found_near_a_point_and_limits_hold(fitter):
    near = MinimaSearch(fitter, {"ring": np.array([math.log(22.0)]), "ramp": np.array([RAMP])}).bottom()
    edge = MinimaSearch(fitter, {"ring": np.array([math.log(100.0)]), "ramp": np.array([RAMP])}).bottom()

    assert math.exp(near["ring"][0]) == pytest.approx(RING_HZ, rel=0.003)
    assert math.log(5.0) <= edge["ring"][0] <= math.log(100.0)


def test_neighbours_of_a_model_move_its_nonlinear_effects_only_and_by_what_a_search_may_leave():
    z = {"ring": np.array([3.0]), "ramp": np.array([0.4])}

    near = neighbours(LIBRARY, z, 8)

    off = np.array([n["ring"][0] for n in near]) - 3.0
    assert len(set(off)) == 8 and np.max(np.abs(off)) <= NEIGHBOUR_SHARE * 0.2
    assert off.min() < -0.02 and off.max() > 0.02  # both sides
    assert all(n["ramp"][0] == 0.4 for n in near)
    assert neighbours(LIBRARY, {"ramp": np.array([0.4])}, 8) == []


def test_a_model_pays_for_noise_that_it_brings_as_the_norm_of_a_normal_density_says():
    wide = replace(noise(0.05), sigma=np.where(np.arange(len(T_S)) < 10, 0.1, 0.05))

    assert noise_price(wide, noise(0.05)) == pytest.approx(2.0 * 10 * math.log(2.0))
    assert noise_price(noise(0.05), wide) == pytest.approx(-2.0 * 10 * math.log(2.0))


def test_a_model_without_noise_of_its_own_is_held_against_others_by_its_cost():
    plain = Model({}, np.zeros(0), np.zeros(0), np.zeros(0), 7.0, np.zeros(0))

    assert (plain.own_cost, plain.likelihood_cost) == (7.0, 7.0)
    own = replace(plain, own=3.0, likely=5.0)
    assert (own.own_cost, own.likelihood_cost) == (3.0, 5.0)


def test_another_noise_is_another_fitter_and_the_old_one_keeps_its_own(fitter):
    loud = fitter.with_noise(noise(0.5))

    model = fitter.model({"ring": np.array([math.log(15.0)])})

    assert loud.judged(model).cost < 0.1 * model.cost
    assert fitter.judged(model).cost == model.cost


def test_each_lead_gets_the_strategy_that_its_effects_need(fitter):
    detent = Hypothesis("cogging", LIBRARY["ramp"].coordinates, dict, lambda z: 2.0, ((0.0,),), rests=True)
    with_detent = replace(fitter, library={**LIBRARY, "cogging": detent})
    ramp, ring, cogging = ({name: np.zeros(1)} for name in ("ramp", "ring", "cogging"))

    assert isinstance(strategy_for(with_detent, Candidate(ramp, 1.0)), Downhill)
    assert isinstance(strategy_for(with_detent, Candidate(ramp | ring, 1.0)), LocalMinima)
    assert isinstance(strategy_for(with_detent, Candidate(ramp | cogging, 1.0)), Detents)
    # what was refined already keeps its phase
    assert isinstance(strategy_for(with_detent, Candidate(ramp | cogging, 1.0, frozenset({"ramp"}))), Downhill)


def test_play_repeats_least_with_all_friction_on_the_rotor_and_there_is_one_shaft():
    library = hypotheses(Scale.of(MOTOR, 4000.0))
    backlash = library["backlash"]
    place = np.array(backlash.starts[0])

    least_repeatable = backlash.to_params(backlash.least_repeatable(place))

    assert least_repeatable == {**backlash.to_params(place), "load_friction_share": 0.0}
    assert {name for name, h in library.items() if h.is_shaft} == {"backlash", "two_mass"}
