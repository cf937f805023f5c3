"""What the angle observer learned: kept in a file, given back, frozen, looked at, emptied."""

import json
import math

import numpy as np
import pytest
from evenspin.errors import InputError
from evenspin.memory import AngleTable, read_table, write_table

DRIVE = """\
name = "short"
model = "tang2020-rig2"
duration_s = {duration}
seed = 1
log_rate_hz = 1000.0

[drive]
method = "aro"
aro_fast_s = 20.0

[[event]]
at_s = 0.0
speed_rpm = 200.0
"""


@pytest.fixture
def drive(tmp_path):
    """A scenario file that runs so many seconds."""

    def make(duration=3.0, extra=""):
        path = tmp_path / f"short_{duration:g}.toml"
        path.write_text(DRIVE.format(duration=duration).replace("[drive]\n", f"[drive]\n{extra}\n"))
        return path

    return make


def ripple_pct(folder):
    """First and second electrical order, 10th of the mechanical turn among them, in the steady state."""
    return json.loads((folder / "summary.json").read_text())["segments"][-1]["n2_pct"]


# ---- files ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".csv", ".json"])
@pytest.mark.parametrize("torque_per_a_nm", [None, 0.4455])
def test_a_table_comes_back_as_it_was_written(tmp_path, suffix, torque_per_a_nm):
    table = AngleTable(np.float32(np.random.default_rng(1).normal(size=720)).astype(float), torque_per_a_nm)

    write_table(tmp_path / f"table{suffix}", table)

    back = read_table(tmp_path / f"table{suffix}")
    assert back.disturbance_a == pytest.approx(table.disturbance_a, rel=1e-8)
    assert back.torque_per_a_nm == (None if torque_per_a_nm is None else pytest.approx(torque_per_a_nm, rel=1e-5))
    assert [path.name for path in tmp_path.iterdir()] == [f"table{suffix}"]  # nothing is left beside it


def test_the_columns_carry_their_units(tmp_path):
    write_table(tmp_path / "table.csv", AngleTable(np.array([0.0, 1.0, 0.0, -1.0]), 0.5))

    header, first, second, *_ = (tmp_path / "table.csv").read_text().splitlines()

    assert header == "cell,theta_m_rad,disturbance_a,disturbance_nm"
    assert first == "0,0,0,0"
    assert [float(cell) for cell in second.split(",")] == pytest.approx([1.0, math.pi / 2.0, 1.0, 0.5])


def test_the_orders_of_a_table_are_the_amplitudes_of_its_lines():
    theta = 2.0 * np.pi * np.arange(200) / 200
    table = AngleTable(0.3 + 0.2 * np.sin(12.0 * theta + 0.3) + 0.05 * np.cos(24.0 * theta), 0.5)

    assert table.orders()[[0, 12, 24, 13]] == pytest.approx([0.3, 0.2, 0.05, 0.0], abs=1e-9)
    summary = table.summary()
    assert (summary["cells"], summary["unit"]) == (200, "A")
    assert summary["orders_nm"]["12"] == pytest.approx(0.1)
    assert summary["rms_a"] == pytest.approx(math.hypot(0.2, 0.05) / math.sqrt(2.0))


GOOD = "cell,theta_m_rad,disturbance_a\n" + "".join(f"{k},{k},0.1\n" for k in range(8))
JSON = '{"format": "evenspin angle memory 1", "cells": %d, "unit": "%s", "disturbance_a": %s}'


@pytest.mark.parametrize(("name", "text", "reported"), [
    ("t.csv", GOOD.replace("3,3,0.1", "3,3,nan"), "cell 3 = nan"),
    ("t.csv", GOOD.replace("3,3,0.1", "3,3,1e9"), "cell 3 = "),
    ("t.csv", GOOD.replace("3,3,0.1", "3,3,x"), ":5: disturbance_a = 'x'"),
    ("t.csv", GOOD.replace("3,3,", "4,3,"), ":5: cell = 4.0: must be 3"),
    ("t.csv", GOOD.replace("disturbance_a", "torque"), "disturbance_a"),
    ("t.csv", "\n".join(GOOD.splitlines()[:3]), "cells = 2: must be within 4"),
    ("t.csv", "", "in the header"),
    ("t.json", "{", "JSON"),
    ("t.json", "[1, 2]", "format"),
    ("t.json", JSON % (3, "A", "[1, 2, 3, 4]"), "cells = 3"),
    ("t.json", JSON % (4, "Nm", "[1, 2, 3, 4]"), "unit"),
    ("t.json", JSON % (4, "A", "[1, 2, 3, NaN]"), "numbers"),
    ("t.txt", GOOD, ".csv or .json"),
])  # fmt: skip
def test_a_file_that_is_no_table_is_refused_in_one_line(tmp_path, name, text, reported):
    path = tmp_path / name
    path.write_text(text)

    with pytest.raises(InputError) as refusal:
        read_table(path)

    assert reported in str(refusal.value)
    assert "\n" not in str(refusal.value)


# ---- runs ----------------------------------------------------------------------------------------------------------


def test_what_was_learned_acts_from_the_start_of_the_next_run(evenspin, drive, tmp_path):
    table = tmp_path / "learned.csv"

    learned = evenspin("run", drive(6.0), "--out", tmp_path / "one", "--save-memory", table)
    cold = evenspin("run", drive(1.0), "--out", tmp_path / "cold", "--freeze-learning")
    warm = evenspin("run", drive(1.0), "--out", tmp_path / "warm", "--freeze-learning", "--memory", table)

    assert (learned.status, cold.status, warm.status) == (0, 0, 0)
    assert str(table) in learned.out
    assert ripple_pct(tmp_path / "cold") > 0.3
    assert ripple_pct(tmp_path / "warm") < 0.25 * ripple_pct(tmp_path / "cold")


def test_frozen_learning_leaves_the_table_as_it_is(evenspin, drive, tmp_path):
    before, after = tmp_path / "before.csv", tmp_path / "after.csv"
    assert evenspin("run", drive(2.0), "--out", tmp_path / "one", "--save-memory", before).status == 0

    said = evenspin(
        "run", drive(1.0), "--out", tmp_path / "two", "--freeze-learning", "--memory", before, "--save-memory", after
    )

    assert said.status == 0
    assert after.read_text() == before.read_text()


def test_the_summary_tells_how_far_learning_has_come(evenspin, drive, tmp_path):
    unlearned = {}
    for duration in (0.4, 8.0):
        out = tmp_path / f"{duration:g}"
        assert evenspin("run", drive(duration, 'aro_write = "hat"'), "--out", out).status == 0
        summary = json.loads((out / "summary.json").read_text())
        assert summary["memory"]["cells"] == 200
        unlearned[duration] = summary["observer_innovation"]

    assert 0.4 < unlearned[0.4] <= 1.0
    assert 0.005 < unlearned[8.0] < 0.3


@pytest.mark.parametrize("method", ["pi", "dob", "ro", "forc"])
def test_only_the_angle_observer_has_a_table(evenspin, drive, tmp_path, method):
    said = evenspin("run", drive(0.3), "--method", method, "--out", tmp_path / "out")
    saved = evenspin(
        "run", drive(0.3), "--method", method, "--out", tmp_path / "out", "--save-memory", tmp_path / "t.csv"
    )

    assert said.status == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["method"], summary["observer_innovation"], summary["memory"]) == (method, None, None)
    assert saved.status == 2
    assert saved.err.count("\n") == 1 and "--method aro" in saved.err


def test_a_table_with_another_number_of_cells_is_refused_with_what_to_do(evenspin, drive, tmp_path):
    write_table(tmp_path / "t.csv", AngleTable(np.zeros(720)))

    said = evenspin("run", drive(0.3), "--out", tmp_path / "out", "--memory", tmp_path / "t.csv")

    assert said.status == 2
    assert said.err.count("\n") == 1
    assert "cells = 720: must be 200" in said.err and "aro_cells = 720" in said.err


def test_a_table_beyond_the_limit_of_the_drive_is_refused(evenspin, drive, tmp_path):
    write_table(tmp_path / "t.csv", AngleTable(np.full(200, 11.0)))

    said = evenspin("run", drive(0.3), "--out", tmp_path / "out", "--memory", tmp_path / "t.csv")

    assert said.status == 2
    assert "observer_limit_a" in said.err


@pytest.mark.parametrize("name", ["folder/t.csv", "t.txt"])
def test_a_place_that_cannot_be_written_is_refused_before_the_work(evenspin, drive, tmp_path, name):
    said = evenspin("run", drive(0.3), "--out", tmp_path / "out", "--save-memory", tmp_path / name)

    assert said.status == 2
    assert said.err.startswith("--save-memory: ") and said.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


# ---- evenspin memory -----------------------------------------------------------------------------------------------


@pytest.fixture
def table_file(tmp_path):
    path = tmp_path / "t.csv"
    theta = 2.0 * np.pi * np.arange(200) / 200
    write_table(path, AngleTable(0.1 * np.sin(12.0 * theta), 0.5))
    return path


def test_show_names_the_orders_and_draws_them(evenspin, table_file, tmp_path):
    said = evenspin("memory", "show", table_file, "--plot", tmp_path / "t.svg", "--json", tmp_path / "t.json")

    assert said.status == 0
    assert "12" in said.out and "200 cells" in said.out
    assert "<svg" in (tmp_path / "t.svg").read_text()
    summary = json.loads((tmp_path / "t.json").read_text())
    assert summary["orders_a"]["12"] == pytest.approx(0.1, rel=1e-6)
    assert summary["orders_nm"]["12"] == pytest.approx(0.05, rel=1e-4)


def test_json_is_alone_on_stdout(evenspin, table_file):
    said = evenspin("memory", "show", table_file, "--json")

    assert json.loads(said.out)["cells"] == 200


def test_clear_forgets_everything_but_the_number_of_cells(evenspin, table_file):
    assert evenspin("memory", "clear", table_file).status == 0

    table = read_table(table_file)
    assert (table.cells, table.empty) == (200, True)
    assert "nothing learned" in evenspin("memory", "show", table_file).out


@pytest.mark.parametrize("command", ["show", "clear"])
def test_a_missing_file_is_one_line(evenspin, tmp_path, command):
    said = evenspin("memory", command, tmp_path / "none.csv")

    assert said.status == 2
    assert said.err.count("\n") == 1 and "existing file" in said.err
