"""`evenspin diff`: two runs side by side, settings and numbers."""

import json

import pytest


@pytest.fixture
def runs(evenspin, scenario, tmp_path):
    for name, words in (("a", ("--method", "pi")), ("b", ("--method", "forc", "--set", "cogging.amplitude_nm=0.01"))):
        assert evenspin("run", scenario, *words, "--out", tmp_path / name).status == 0
    return tmp_path / "a", tmp_path / "b"


def test_what_was_set_differently_and_every_number_of_both(evenspin, runs):
    a, b = runs
    found = json.loads(evenspin("diff", a, b, "--json").out)
    summary = json.loads((b / "summary.json").read_text())

    assert found["settings"]["drive.method"] == {"a": "pi", "b": "forc"}
    assert found["settings"]["effects.cogging.amplitude_nm"] == {"a": None, "b": 0.01}
    assert set(found["settings"]) == {"drive.method", "effects.cogging.amplitude_nm"}
    assert [each["start_s"] for each in found["measures"]] == [0.0, 0.25]
    assert found["measures"][1]["speed_rms_rpm"]["b"] == summary["segments"][1]["speed_rms_rpm"]


def test_a_run_beside_itself_differs_in_nothing(evenspin, runs):
    said = evenspin("diff", runs[0], runs[0])

    assert said.status == 0 and "the same settings" in said.out
    assert {line.split()[-1] for line in said.out.splitlines() if "rms rpm" in line} == {"1.00"}


def test_the_report_has_the_curves_over_each_other(evenspin, runs, tmp_path):
    evenspin("diff", *runs, "--out", tmp_path / "diff")

    header = (tmp_path / "diff" / "figures" / "speed.csv").read_text().split("\n", 1)[0]
    assert header == "A_t_s,A_true_speed_rad_s,B_t_s,B_true_speed_rad_s"
    assert "B less A" in (tmp_path / "diff" / "report.html").read_text()


def test_position_runs_are_compared_by_their_motions(evenspin, tmp_path):
    for name, method in (("a", "ppi"), ("b", "rdc")):
        evenspin("run", "yeh2024/rpm20", "--set", f"position_method={method}", "--out", tmp_path / name)
    found = json.loads(evenspin("diff", tmp_path / "a", tmp_path / "b", "--json").out)

    last = [each for each in found["measures"] if each["kind"] == "motions" and each["speed_ref_rpm"] > 1.0][-1]
    assert last["error_rms_mrad"]["b"] < 0.2 * last["error_rms_mrad"]["a"]


def test_runs_without_anything_in_common_say_so(evenspin, runs, tmp_path):
    evenspin("run", "guo2024/third", "--out", tmp_path / "c")

    assert "nothing in common" in evenspin("diff", runs[0], tmp_path / "c").out


@pytest.mark.parametrize(("break_it", "said"), [
    (lambda run: (run / "truth.csv").unlink(), "truth.csv is not in it"),
    (lambda run: (run / "summary.json").write_text("{"), "the summary of a run"),
    (lambda run: (run / "summary.json").write_text("{}"), "make the run again"),
    (lambda run: (run / "summary.json").write_bytes(b"\xff\xfe"), "the summary of a run"),
    (lambda run: (run / "truth.csv").write_text("a,b\n1,2\n"), "t_s"),
])  # fmt: skip
def test_a_broken_run_is_one_line(evenspin, runs, tmp_path, break_it, said):
    break_it(runs[1])
    answer = evenspin("diff", *runs, "--out", tmp_path / "diff")

    assert answer.status == 2 and said in answer.err and answer.err.count("\n") == 1
    assert not (tmp_path / "diff").exists()


def test_a_folder_that_is_no_run_and_an_output_over_an_input_are_one_line(evenspin, runs, tmp_path):
    for words in ((runs[0], tmp_path), (runs[0], tmp_path / "none"), (*runs, "--out", runs[0])):
        answer = evenspin("diff", *words)
        assert answer.status == 2 and answer.err.count("\n") == 1
