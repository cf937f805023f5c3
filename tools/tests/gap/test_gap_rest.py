"""What no known effect explains in a case folder, turned into terms: found, confirmed, simulated, written.

The causes are put into the records by the simulator's effect `empirical`, with numbers of this file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evenspin.compare import Replay
from evenspin.effects import Scale
from evenspin.gap.candidate import Model
from evenspin.gap.finding import Finding
from evenspin.gap.folder import write_result
from evenspin.gap.headline import summary_of
from evenspin.gap.investigate import Investigation
from evenspin.gap.outcome import Outcome, Trace
from evenspin.gap.plan import meta, perform, plan
from evenspin.gap.rest import Rest, rest_of, turning_records
from evenspin.gap.rest_model import _better
from evenspin.gap.result import CaseResult, result_of
from evenspin.gap.verdict import verdict_json
from evenspin.log import write_case
from evenspin.log.case import Case, read_case
from evenspin.log.unit import Unit
from evenspin.model import load_machine
from evenspin.weakform.signals import joined
from evenspin.weakform.windows import Bump, Windows
from test_gap_result import MACHINE

HEALTHY = MACHINE.partition("[effects.")[0]
SECONDS = {"staircase": 9.0, "coast_down": 1.5, "validation": 2.0}
FAN_NM, TOP_RAD_S = 0.2, 62.8  # 9 % of the rated torque at 600 r/min
FAN = f"[effects.empirical]\nodd_nm = {FAN_NM}\nodd_exponent = 2.0\nlimit_rad_s = {TOP_RAD_S}\n"
NOTHING: Mapping[str, Mapping[str, float]] = {}


def case_of(machine: str, folder: Path, seconds: Mapping[str, float] = SECONDS) -> Case:
    """Records back to back: `{start_s}` in the model file is the time at which each begins."""
    records, chosen, clock_s = {}, [], 0.0
    for name, duration_s in seconds.items():
        path = folder / f"{name}.toml"
        path.write_text(machine.replace("{start_s}", f"{clock_s}"))
        experiment = next(e for e in plan(load_machine(path)) if e.name == name)
        experiment = replace(experiment, setup=replace(experiment.setup, duration_s=duration_s))
        records[name] = perform(experiment)
        chosen.append(experiment)
        clock_s += duration_s
    case = folder / "case"
    case.mkdir()
    write_case(case, meta(chosen, "small"), records)
    return read_case(case)


def rest_in(case: Case) -> Rest:
    name, record = next(iter(case.experiments.items()))
    nominal = Replay(case.path, case.meta, name, record).nominal
    return rest_of(case, nominal, Scale.of(case.meta["motor"], 4000.0), NOTHING)


@pytest.fixture(scope="module")
def fan(tmp_path_factory: pytest.TempPathFactory) -> Case:
    return case_of(HEALTHY + FAN, tmp_path_factory.mktemp("fan"))


def test_a_fan_is_a_drag_with_the_square_of_the_speed(fan: Case) -> None:
    rest = rest_in(fan)

    (term,) = rest.terms
    assert term.family.name == "speed_odd"
    # 10 % of the exponent and 5 % of the torque: half of the intervals that the records of 12 s give
    assert term.shape[0] == pytest.approx(2.0, abs=0.2)
    assert rest.effects["empirical"]["odd_nm"] == pytest.approx(FAN_NM, rel=0.05)
    assert rest.not_simulated == () and term.t > 3.5


def test_in_a_healthy_machine_and_beside_known_effects_there_is_no_term(tmp_path: Path) -> None:
    known = "[effects.coulomb_friction]\ntorque_nm = 0.06\n[effects.viscous_friction]\nfactor = 1.6\n"

    assert rest_in(case_of(HEALTHY + known, tmp_path)).terms == ()


@pytest.mark.search
def test_friction_that_falls_over_all_records_has_one_time_constant(tmp_path: Path) -> None:
    falls = (
        "[effects.empirical]\nfriction_nm = -0.2\ntime_s = 5.0\nlimit_rad_s = 62.8\nstart_s = {start_s}\n"
        "[effects.coulomb_friction]\ntorque_nm = 0.25\nsmooth_rad_s = 0.126\n"
    )

    rest = rest_in(case_of(HEALTHY + falls, tmp_path))

    (term,) = rest.terms
    assert term.family.name == "time_friction"
    assert term.shape[0] == pytest.approx(5.0, rel=0.15)
    assert rest.effects["empirical"]["friction_nm"] == pytest.approx(-0.2, rel=0.1)
    assert rest.effects["coulomb_friction"]["torque_nm"] == pytest.approx(0.25, rel=0.1)


def test_without_a_record_that_no_fit_sees_nothing_is_confirmed(fan: Case) -> None:
    fitted = {name: record for name, record in fan.experiments.items() if name != "validation"}

    assert rest_in(replace(fan, experiments=fitted)) == Rest()


def test_records_follow_each_other_on_one_clock_and_no_window_reaches_across(fan: Case) -> None:
    starts = fan.starts_s()
    parts = turning_records(fan)

    assert list(starts.values()) == pytest.approx([0.0, 9.0, 10.5], abs=2e-3)
    assert parts["validation"].t_s[0] == starts["validation"]
    whole = joined("all", list(parts.values()))
    windows = Windows.over(len(whole), Bump.of(12e-3, whole.period_s))
    centres = windows.where(windows.all_of(whole.good)).centre[windows.all_of(whole.good)]
    begins = np.cumsum([0, *(len(part) for part in parts.values())])[1:-1]
    for begin in begins:
        assert not np.any((centres + windows.bump.half >= begin) & (centres - windows.bump.half < begin))
    assert len(centres) > 0.9 * len(windows.centre)
    assert np.ptp(parts["staircase"].theta_m_rad) > 2.0 * math.pi and not whole.one_travel


def test_a_record_is_simulated_from_its_place_on_the_clock(fan: Case) -> None:
    record = fan.experiments["coast_down"]
    warm = {"load_nm": 0.1, "time_s": 5.0, "limit_rad_s": 60.0}
    late = Replay(fan.path, fan.meta, "coast_down", record, start_s=4.0)
    early = Replay(fan.path, fan.meta, "coast_down", record)

    signals = ("speed_rad_s", "iq_a")
    by_clock = late.run(signals, Unit({"empirical": warm}))
    by_hand = early.run(signals, Unit({"empirical": {**warm, "start_s": 4.0}}))
    at_once = early.run(signals, Unit({"empirical": warm}))

    assert np.array_equal(by_clock, by_hand)
    assert float(np.max(np.abs(by_clock - at_once))) > 0.1


def outcome(gap: float) -> Outcome:
    """One record whose speed is off by so much; the other four signals are right."""
    values = np.zeros((10, 5))
    return Outcome((Trace("validation", np.arange(10.0), values, values + [math.sqrt(5.0) * gap, 0, 0, 0, 0]),))


def cost(value: float) -> Model:
    empty = np.empty(0)
    return Model({}, empty, empty, empty, value, empty)


@pytest.mark.parametrize(
    ("gap_after", "cost_after", "stands"),
    [
        (0.98, 5000.0, True),  # 4 % of the squared gap
        (0.995, 5000.0, False),  # 1 %
        (1.0, 4000.0, True),  # not worse, and a cost of 1000 less on the other records
        (1.0, 4700.0, False),  # 300
        (1.01, 1000.0, False),  # worse on the records that no fit saw
    ],
)
def test_terms_stand_where_the_simulation_is_better_with_them(gap_after, cost_after, stands):
    assert _better(outcome(gap_after), outcome(1.0), cost(5000.0), cost(cost_after)) == stands


@pytest.fixture(scope="module")
def result(fan: Case) -> CaseResult:
    """As if the search had named nothing."""
    investigation = Investigation(fan, 1)
    try:
        nothing = investigation.search.nothing
        expected = investigation.expected_cost(nothing)
        finding = Finding(nothing, (), True, nothing.cost, expected, (), (nothing,), (nothing,))
        return result_of(fan, investigation, finding)
    finally:
        investigation.forward.close()


@pytest.mark.search
def test_the_verdict_has_the_term_and_the_gap_with_and_without_it(result: CaseResult, tmp_path: Path) -> None:
    content = verdict_json(result)

    assert content["verdict"] == ["unknown"] and content["parameters"] == {}
    (term,) = content["empirical"]
    assert term["depends_on"] == ["speed"] and "a fan" in term["like"] and "its square" in term["form"]
    interval = term["intervals"]["torque_nm"]
    assert interval["low"] < FAN_NM * (term["measured_over"]["top_rad_s"] / TOP_RAD_S) ** 2 < interval["high"]
    assert content["gap_after_known"] == content["gap_before"]
    # what is left is noise: 5 % for one draw of it
    assert content["gap_after"] == pytest.approx(content["gap_floor"], rel=0.05)
    assert content["gap_closed"] > 0.95
    left = content["left"]
    assert left["cost_with_empirical"] < 0.1 * left["cost"]
    assert any("against the motion, grows with its square" in s for s in summary_of(result))

    write_result(tmp_path, result, "evenspin gap case")
    page = (tmp_path / "report.html").read_text()
    assert "What does it depend on?" in page and "a fan, windage" in page
    assert (tmp_path / "figures/beyond_1.svg").is_file()
    model = load_machine(tmp_path / "model.toml")
    assert model.effects["empirical"]["odd_nm"] == pytest.approx(FAN_NM, rel=0.05)
    assert json.loads((tmp_path / "verdict.json").read_text())["empirical"][0]["family"] == "speed_odd"
