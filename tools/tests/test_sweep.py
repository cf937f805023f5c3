"""`evenspin sweep`: every combination, each number that of a run by itself; what is refused is a row."""

import csv
import json

import evenspin as es
import numpy as np
import pytest
from evenspin.grid import axes_of, parsed_axes, run_grid
from evenspin.grid.axes import combinations
from evenspin.grid.pictures import abscissa, pictures
from evenspin.model.scenario import scenario_document


@pytest.fixture
def swept(evenspin, scenario, tmp_path):
    vary = ("--vary", "method=crc,forc", "--vary", "rc_gain=0.2:0.4:3")
    said = evenspin("sweep", scenario, *vary, "--set", "seed=5", "--out", tmp_path / "out", "--json")
    assert said.status == 0, said.err
    return said, tmp_path / "out"


def test_every_combination_is_a_run_with_a_row_for_each_steady_state(swept):
    said, out = swept
    rows = list(csv.DictReader((out / "sweep.csv").open()))

    assert len(rows) == 2 * 3 * 2
    assert {(row["method"], row["rc_gain"]) for row in rows} == {
        (m, g) for m in ("crc", "forc") for g in ("0.2", "0.3", "0.4")
    }
    assert [row["start_s"] for row in rows[:2]] == ["0", "0.25"]
    assert len(json.loads(said.out)["rows"]) == len(rows)


def test_the_numbers_are_those_of_a_run_by_itself(swept, scenario):
    _, out = swept
    row = [
        each
        for each in csv.DictReader((out / "sweep.csv").open())
        if (each["method"], each["rc_gain"]) == ("forc", "0.3")
    ]
    alone = es.load(scenario).change(method="forc", rc_gain=0.3, seed=5).simulate().summary()["segments"]

    for key in ("speed_rms_rpm", "n1_pct", "overshoot_rpm", "iq_mean_a"):
        assert [float(each[key]) for each in row] == pytest.approx([each[key] for each in alone], rel=1e-6)


def test_there_is_a_picture_for_each_number_with_a_line_for_each_method(swept):
    _, out = swept
    page = (out / "report.html").read_text()

    assert (out / "figures" / "speed_rms_rpm.svg").is_file()
    assert '"label":"crc"' in page and '"label":"forc"' in page


def test_a_frame_comes_from_python_as_well():
    pytest.importorskip("pandas")
    grid = es.load("guo2024/third").sweep(seed=[1, 2])

    frame = grid.to_pandas()

    assert list(frame["seed"].unique()) == [1, 2] and len(frame) == len(grid.rows)
    assert frame["speed_rms_rpm"].min() > 0.0


def test_what_was_changed_before_holds_in_every_run():
    events = [{"at_s": 0.0, "speed_rpm": 300.0}]
    scenario = es.load({"name": "s", "model": "guo2024", "duration_s": 0.4, "event": events}).change(method="crc")
    row = scenario.sweep(rc_gain=[0.3]).rows[0]
    alone = scenario.change(rc_gain=0.3).simulate().summary()["segments"][0]

    assert row["speed_rms_rpm"] == alone["speed_rms_rpm"]


def test_a_combination_that_is_refused_or_trips_is_a_row_that_says_so(evenspin, scenario, tmp_path):
    """The over-current limit must not lie below the limit of the q current; a supply of 5 V is below the least."""
    said = evenspin("sweep", scenario, "--vary", "iq_limit_a=5,1000", "--out", tmp_path / "out", "--json")
    rows = json.loads(said.out)["rows"]

    assert said.status == 0
    assert [row["outcome"] for row in rows] == ["ran", "ran", "refused"]
    assert "iq_limit_a" in rows[2]["why"]


def test_when_no_run_gets_to_its_end_the_status_says_so(evenspin, scenario, tmp_path):
    said = evenspin("sweep", scenario, "--vary", "auto_run=false", "--out", tmp_path / "out")

    assert said.status == 1 and "no run got to its end" in said.err and "auto_run" in said.err
    assert (tmp_path / "out" / "sweep.csv").is_file()


def test_a_position_scenario_is_swept_by_its_motions():
    events = [{"at_s": 0.0, "control": "position", "position_ref_turn": 1.0}]
    scenario = es.load({"name": "p", "model": "yeh2024", "duration_s": 4.0, "event": events})
    grid = scenario.sweep({"profile_speed_rad_s": [2.0, 3.0]}, position_method=["ppi", "rdc"])

    assert {row["moves"] for row in grid.rows} == {True, False}
    assert "error_rms_mrad" in grid.measures and abscissa(grid) == "profile_speed_rad_s"
    assert {picture.name for picture in pictures(grid)} >= {"error_rms_mrad"}


def test_parquet_has_the_same_columns(evenspin, scenario, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    evenspin("sweep", scenario, "--vary", "method=pi,forc", "--parquet", "--out", tmp_path / "out")

    table = parquet.read_table(tmp_path / "out" / "sweep.parquet")

    header = (tmp_path / "out" / "sweep.csv").read_text().split("\n", 1)[0]
    assert table.column_names == header.split(",") and table.num_rows == 4


@pytest.mark.parametrize(("words", "values"), [
    ("rc_gain=0.1:0.5:5", [0.1, 0.2, 0.3, 0.4, 0.5]), ("rc_gain=1e-3:1:4:log", [1e-3, 1e-2, 0.1, 1.0]),
    ("rc_gain=0.1,0.7", [0.1, 0.7]), ("seed=1,2", [1, 2]), ("method=pi", ["pi"]),
    ("speed_inline=true,false", [True, False]),
    ("psi_wb=0.02:0.01:3", [0.02, 0.015, 0.01]),
])  # fmt: skip
def test_values_are_lists_spans_and_decades(words, values):
    found = next(iter(parsed_axes([words]).values()))

    assert list(found) == (pytest.approx(values) if isinstance(values[0], float) else values)


def test_the_last_axis_varies_fastest():
    assert [tuple(each.values()) for each in combinations({"a": (1, 2), "b": (3, 4)})] == [
        (1, 3),
        (1, 4),
        (2, 3),
        (2, 4),
    ]


@pytest.mark.parametrize(("words", "said"), [
    (["--vary", "rc_gain"], "NAME=A,B,C"), (["--vary", "rc_gain="], "NAME=A,B,C"), (["--vary", "=1"], "NAME=A,B,C"),
    (["--vary", "rc_gain=0:1"], "FIRST:LAST:COUNT"), (["--vary", "rc_gain=0:1:1"], "COUNT in 2 .. 100000"),
    (["--vary", "rc_gain=0:1:3:log"], "one sign"), (["--vary", "rc_gain=0:inf:3"], "FIRST:LAST:COUNT"),
    (["--vary", "rc_gain=0:1:3:lin"], "FIRST:LAST:COUNT"), (["--vary", "rc_gain=0:1:999999999"], "FIRST:LAST:COUNT"),
    (["--vary", "rcgain=1"], "did you mean rc_gain"), (["--vary", "rc_gain=1,99"], "a number in 0 .. 10"),
    (["--vary", "method=pi,frc"], "did you mean forc"), (["--vary", "rc_gain=1,1"], "each value once"),
    (["--vary", "rc_gain=1", "--vary", "rc_gain=2"], "given once"),
    (["--vary", "rc_gain=1", "--set", "rc_gain=2"], "either varied or set"),
    (["--vary", "rc_gain=1", "--set", "seed"], "NAME=VALUE"),
    (["--vary", "rc_gain=1", "--set", "seed=1", "--set", "seed=2"], "given twice"),
    (["--vary", "rc_gain=0:1:1000", "--vary", "seed=" + ",".join(map(str, range(101)))], "at most 100000"),
    (["--vary", "duration_s=0.1"], "no run got to its end"),
])  # fmt: skip
def test_a_wrong_word_is_one_line(evenspin, scenario, tmp_path, words, said):
    answer = evenspin("sweep", scenario, *words, "--out", tmp_path / "out")

    assert answer.status == (1 if "no run" in said else 2)
    assert said in answer.err and answer.err.count("\n") == 1


@pytest.mark.parametrize(("axes", "said"), [
    ({}, "at least one name"), ({"rc_gain": []}, "at least one value"), ({"rc_gain": 3}, "a list of values"),
    ({"method": "pi"}, "a list of values"), ({"rc_gain": [1.0, 1.0]}, "each value once"),
])  # fmt: skip
def test_wrong_axes_from_python_are_one_line(axes, said):
    with pytest.raises(es.EvenspinError, match=said):
        axes_of(axes)


def test_workers_do_not_change_a_number(scenario):
    document = scenario_document(str(scenario))
    one, many = (run_grid(document, {"seed": (1, 2, 3)}, {}, workers=n).rows for n in (1, 3))

    assert one == many


def test_numpy_arrays_are_axes():
    assert axes_of({"rc_gain": np.linspace(0.1, 0.3, 3)})["rc_gain"] == pytest.approx((0.1, 0.2, 0.3))


def test_run_takes_changes_as_if_they_stood_in_the_file(evenspin, scenario, tmp_path):
    said = evenspin(
        "run", scenario, "--set", "rc_gain=0.3", "--set", "cogging.amplitude_nm=0.01", "--out", tmp_path / "a", "--json"
    )
    summary = json.loads(said.out)

    assert (summary["drive"]["rc_gain"], summary["effects"]["cogging"]) == (0.3, {"amplitude_nm": 0.01})


@pytest.mark.parametrize(("words", "said"), [
    (("--set", "rcgain=1"), "did you mean rc_gain"), (("--set", "rc_gain=99"), "a number in 0 .. 10"),
    (("--set", "method=forc", "--method", "crc"), "given without --set method=forc"),
    (("--set", "seed=3", "--seed", "4"), "given without --set seed=3"),
])  # fmt: skip
def test_a_wrong_change_of_a_run_is_one_line(evenspin, scenario, tmp_path, words, said):
    answer = evenspin("run", scenario, *words, "--out", tmp_path / "a")

    assert answer.status == 2 and said in answer.err and answer.err.count("\n") == 1
    assert not (tmp_path / "a").exists()
