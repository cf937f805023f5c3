"""Experiment lists on virtual drives: the case folder, and whether it says what is hidden in the machine."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from bench_model import MODEL
from evenspin.bench import Drive
from evenspin.bench.experiments import ExperimentList, experiments_toml, plan, read_experiments
from evenspin.bench.operator import PersonOperator
from evenspin.bench.raw import read_raw
from evenspin.bench.runner import perform, stream_octets_s
from evenspin.compare import case_gap
from evenspin.errors import InputError
from evenspin.log import LOG_COLUMNS, read_case
from evenspin.model.machine import builtin_models, load_machine

# Sensor noise and the start angle, known to half a count: what no effect explains. The bounds of test_compare.py, where
# the same motor was logged by a simulator of others.
FLOOR = (0.12, 0.165)
EIGHT = [
    "staircase", "staircase_load", "load_step", "reversal", "coast_down", "standstill_steps", "validation",
    "validation_steps",
]  # fmt: skip


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "clean.toml"
    path.write_text(MODEL)
    return path


@pytest.fixture
def experiments(model: Path, tmp_path: Path) -> Path:
    path = tmp_path / "experiments.toml"
    path.write_text(experiments_toml("clean", model.name, plan(load_machine(model))))
    return path


def test_the_list_has_the_eight_experiments_within_the_ratings(model: Path) -> None:
    machine = load_machine(model)
    found = plan(machine)

    assert [experiment.name for experiment in found] == EIGHT
    assert [e.name for e in found if e.rotor_locked] == ["standstill_steps", "validation_steps"]
    assert [e.name for e in found if e.needs_load_machine] == ["staircase_load", "load_step", "validation"]
    speeds = [abs(v) for e in found if "speed_ref_rad_s" in e.curves for v in e.curves["speed_ref_rad_s"].value]
    # the reference list turns this motor at 600 r/min, 62.8 rad/s
    assert max(speeds) == pytest.approx(62.8, rel=0.02)
    loads = [abs(v) for e in found if e.needs_load_machine for v in e.curves["load_torque_nm"].value]
    assert max(loads) == pytest.approx(1.1, rel=0.01)  # half the rated torque
    currents = [abs(v) for e in found if e.rotor_locked for c in e.curves.values() for v in c.value]
    assert 4.0 < max(currents) <= 0.9 * 5.0


@pytest.mark.parametrize("name", sorted(builtin_models()))
def test_every_built_in_model_gets_a_list_that_reads_back_as_it_was(name: str, tmp_path: Path) -> None:
    machine = load_machine(builtin_models()[name])
    path = tmp_path / "list.toml"
    path.write_text(experiments_toml(machine.name, name, plan(machine)))

    read = read_experiments(path)

    assert read.experiments == plan(machine)
    assert read.machine.plant == machine.plant


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("duration_s = 13.2", "duration_s = 0.0", r"experiment\.duration_s = 0\.0: must be a number in 0.01"),
        ("t_s = [0.0, 1.3,", "t_s = [0.0, 1.3, 1.3,", "must be as many numbers as t_s has"),
        ('name = "load_step"', 'name = "staircase"', "must be a name of its own"),
        ('mode = "speed"', 'mode = "torque"', 'must be "speed" or "current"'),
    ],
)
def test_a_wrong_list_is_told_in_one_line(experiments: Path, old: str, new: str, said: str) -> None:
    experiments.write_text(experiments.read_text().replace(old, new, 1))

    with pytest.raises(InputError, match=said):
        read_experiments(experiments)


def test_the_circle_closes_over_hidden_cogging(evenspin, experiments: Path, model: Path, tmp_path: Path) -> None:
    """Bench run, compare: without anything hidden a floor; cogging opens it; the right cogging closes it."""
    cogging = {"amplitude_nm": 0.15, "order": 18.0, "phase_rad": 0.7}
    hidden = "&".join(f"cogging.{name}={value}" for name, value in cogging.items())
    clean, cogged = tmp_path / "clean", tmp_path / "cogged"

    assert evenspin("bench", "run", experiments, "--port", f"sim:{model}", "--out", clean).status == 0
    assert evenspin("bench", "run", experiments, "--port", f"sim:{model}?{hidden}", "--out", cogged).status == 0

    assert FLOOR[0] < case_gap(clean).gap < FLOOR[1]
    assert case_gap(cogged).gap > 1.25 * case_gap(clean).gap
    assert FLOOR[0] < case_gap(cogged, {"cogging": cogging}).gap < FLOOR[1]
    wrong = {**cogging, "amplitude_nm": -0.15}
    assert case_gap(cogged, {"cogging": wrong}).gap > case_gap(cogged).gap


def test_a_case_has_what_the_format_asks_for(evenspin, experiments: Path, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "case"
    assert evenspin("bench", "run", experiments, "--port", f"sim:{model}", "--out", out).status == 0

    case = read_case(out)
    assert case.meta["experiments"] == EIGHT
    assert case.meta["speed_filter"]["type"] == "tracking_pll"
    assert case.meta["motor"]["resistance_ohm"] == 0.9
    assert case.meta["current_loop"]["kp_v_per_a"] == pytest.approx(6.03)
    assert case.meta["log_rate_hz"]["staircase"] == 2000.0 and case.meta["log_rate_hz"]["validation_steps"] == 10_000.0
    for experiment in plan(load_machine(model)):
        record = case.experiments[experiment.name]
        assert record.names == LOG_COLUMNS
        assert len(record) == round(experiment.duration_s * experiment.log_rate_hz)
        np.testing.assert_allclose(np.diff(record["t_s"]), 1.0 / experiment.log_rate_hz, rtol=1e-5)
        assert record["t_s"][0] == 0.0 and abs(record["speed_rad_s"][0]) < 0.5  # at rest
        assert np.isnan(record["load_torque_nm"]).all() != experiment.needs_load_machine
    raw = read_raw(out / "raw" / "validation.mcap")  # as it came from the drive, from before the start to the stop
    assert raw.whole and raw.lost_rows == 0 and len(raw.record) > 12_000
    assert not (tmp_path / "case.raw").exists()
    staircase = case.experiments["staircase"]
    assert staircase["iq_ref_a"][0] > 0.1  # the first row is that of the first tick of the speed loop
    assert staircase["iq_a"][0] < 0.1
    steps = case.experiments["standstill_steps"]
    assert np.ptp(steps["theta_m_rad"]) == 0.0
    assert steps["id_ref_a"][round(0.3 * 10_000) - 1] == pytest.approx(4.5)  # 0.9 of 5 A, just before it ends
    wanted = next(e for e in plan(load_machine(model)) if e.name == "standstill_steps")
    for name in ("id_ref_a", "iq_ref_a"):
        for row in range(0, len(steps), 100):
            for near in (row, row - 1):  # a step is in the row at which it was due, not before and not after
                if near >= 0:
                    assert steps[name][near] == pytest.approx(wanted.value(name, near / 10_000)), (name, near)
    coast = case.experiments["coast_down"]
    assert np.abs(coast["iq_a"][2600:]).max() < 0.1 < np.abs(coast["iq_a"][:2400]).max()


def test_over_a_serial_line_the_rate_is_lower_and_said(
    evenspin, experiments: Path, model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "case"
    words = ("--only", "validation", "--only", "validation_steps")
    said = evenspin("bench", "run", experiments, "--port", f"sim:{model}?baud=625000", *words, "--out", out)

    assert said.status == 0
    assert "logged at 1000 Hz" in said.out and "captured in the drive" in said.out
    meta = json.loads((out / "meta.json").read_text())
    assert meta["log_rate_hz"] == {"validation": 1000.0, "validation_steps": 10_000.0}
    assert FLOOR[0] < case_gap(out).gap < FLOOR[1]


def test_what_a_stream_needs_is_what_the_protocol_says() -> None:
    assert stream_octets_s(8, 1000.0) == pytest.approx(34.3e3, rel=0.01)  # docs/protocol.md
    assert stream_octets_s(12, 1000.0) == pytest.approx(0.82 * 62.5e3, rel=0.01)


def test_without_a_load_machine_what_needs_one_is_left_out(experiments: Path, model: Path) -> None:
    asked: list[str] = []
    wanted = read_experiments(experiments)
    few = [e for e in wanted.experiments if e.name in ("load_step", "coast_down", "standstill_steps")]
    operator = PersonOperator(lambda request: not asked.append(request) and "Release" in request)

    with Drive.connect(f"sim:{model}") as drive:
        before = drive.get()
        done = perform(
            drive, operator, ExperimentList("few", "", wanted.machine, tuple(few)), lambda *_: None, lambda _: None
        )
        assert drive.get() == before  # the controller of the log format was put back

    assert list(done.records) == ["coast_down"]
    assert "load machine" in done.left_out["load_step"]
    assert "not confirmed" in done.left_out["standstill_steps"]
    assert asked == ["Lock the rotor mechanically"]


def test_a_dry_run_moves_nothing_and_writes_nothing(evenspin, experiments: Path, model: Path, tmp_path: Path) -> None:
    said = evenspin("bench", "run", experiments, "--port", f"sim:{model}", "--dry-run", "--out", tmp_path / "case")

    assert said.status == 0
    assert "staircase_load" in said.out and "load machine" in said.out
    assert not (tmp_path / "case").exists()


def test_what_is_complete_is_kept_when_the_drive_trips(
    evenspin, experiments: Path, model: Path, tmp_path: Path
) -> None:
    model.write_text(model.read_text().replace("[drive]", "[drive]\nover_speed_rad_s = 66.0"))
    text = experiments.read_text()
    first = text.index("[[experiment]]")
    step = text.index("[[experiment]]", text.index('name = "load_step"') - 40)
    experiments.write_text(text[:first] + text[step:] + text[first:step])  # load_step, at half speed, comes first
    out = tmp_path / "case"

    said = evenspin("bench", "run", experiments, "--port", f"sim:{model}", "--out", out)

    assert said.status == 1
    assert "over_speed" in said.err and "are kept" in said.out
    meta = json.loads((out / "meta.json").read_text())
    assert meta["experiments"] and set(meta["experiments"]) < set(EIGHT)
    assert "over_speed" in meta["ended_by"]
    assert read_case(out).experiments.keys() == set(meta["experiments"])
