"""The command as a person and as a script see it: exit status, streams, files."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from evenspin.log import read_case
from evenspin.native import tables

ROOT = Path(__file__).resolve().parents[2]


def test_a_run_leaves_log_truth_summary_and_pictures(evenspin, scenario, tmp_path):
    out = tmp_path / "out"

    said = evenspin("run", scenario, "--method", "fal-forc", "--out", out)

    assert said.status == 0
    assert f"{out}/report.html" in said.out
    assert {path.name for path in out.iterdir()} == {
        "manifest.json", "meta.json", "short.csv", "truth.csv", "summary.json", "report.html", "figures",
    }  # fmt: skip
    case = read_case(out)
    assert len(case.experiments["short"]) == 1000
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["method"], summary["fault"], len(summary["segments"])) == ("fal-forc", None, 2)
    assert summary["drive"]["method"] == "fal-forc"


def test_the_same_command_gives_the_same_bytes(evenspin, scenario, tmp_path):
    scenario.write_text(scenario.read_text() + "\n[effects.dead_time]\ndead_time_s = 1e-6\n")
    for out in ("one", "two"):
        assert evenspin("run", scenario, "--out", tmp_path / out).status == 0

    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*") if path.is_file())
    assert len(files) > 8
    for file in files:
        if file.name != "manifest.json":  # it has the time
            assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes(), file
    reported = [json.loads((tmp_path / out / "manifest.json").read_text()) for out in ("one", "two")]
    assert reported[0] | {"made_at": ""} == reported[1] | {"made_at": ""}


def test_json_is_alone_on_stdout(evenspin, scenario, tmp_path):
    said = evenspin("run", scenario, "--json", "--numeric", "fixed", "--seed", 8, "--out", tmp_path / "out")

    content = json.loads(said.out)
    assert (content["numeric"], content["seed"], content["method"]) == ("fixed", 8, "forc")
    assert "report.html" in said.err


def test_a_fault_is_told_with_what_to_check(evenspin, scenario, tmp_path):
    scenario.write_text(scenario.read_text().replace("[drive]", "[drive]\nover_speed_rad_s = 31.5"))

    said = evenspin("run", scenario, "--out", tmp_path / "out")

    fault = next(fault for fault in tables().faults if fault.name == "over_speed")
    assert said.status == 1
    assert "over_speed" in said.out and fault.check[:20] in said.out
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["fault"]["name"] == "over_speed"


@pytest.mark.parametrize("change", ["seed = x", "duration_s = -3", "nonsense = 1"])
def test_a_bad_scenario_is_one_line_and_no_folder(evenspin, scenario, tmp_path, change):
    scenario.write_text(f"{change}\n{scenario.read_text()}")

    said = evenspin("run", scenario, "--out", tmp_path / "out")

    assert said.status == 2
    assert said.out == ""
    assert said.err.count("\n") == 1 and said.err.startswith(f"{scenario}:")
    assert [path.name for path in tmp_path.iterdir()] == ["short.toml"]


def test_a_folder_with_something_else_in_it_is_not_replaced(evenspin, scenario, tmp_path):
    said = evenspin("run", scenario, "--out", tmp_path)

    assert said.status == 2
    assert said.err.startswith("--out: folder = ")
    assert [path.name for path in tmp_path.iterdir()] == ["short.toml"]


@pytest.mark.parametrize("words", [
    ["run"],
    ["run", "guo2024/first"],
    ["run", "guo2024/frist", "--out", "x"],
    ["run", "guo2024/first", "--method", "magic", "--out", "x"],
    ["run", "guo2024/first", "--seed", "-1", "--out", "x"],
    ["reproduce", "guo2025"],
    ["reproduce", "guo2024", "--json", "/nonexistent/folder/x.json"],
    ["design", "rc", "--k-rc", "-1"],
    ["design", "rc", "--model", "nothing"],
    ["design", "rc", "--q-centre", "0.9"],
    ["design", "rc", "--speed-rpm", "20000"],
    ["design", "rc", "--plot", "x.docx"],
    ["design", "rc", "--inertia-kgm2", "0"],
    ["effects", "coging"],
    ["docs", "--out", "/nonexistent"],
    ["benchmark", "cpu"],
    ["dance"],
])  # fmt: skip
def test_wrong_usage_ends_with_2_and_without_a_traceback(evenspin, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    said = evenspin(*words)

    assert said.status == 2
    assert said.err and "Traceback" not in said.err
    assert list(tmp_path.iterdir()) == []


def test_effects_are_listed_and_explained(evenspin):
    listed, one = evenspin("effects"), evenspin("effects", "current_gain")
    content = json.loads(evenspin("effects", "--json").out)

    assert {effect["name"] for effect in content} == set(tables().effects)
    assert all(effect["name"] in listed.out for effect in content)
    assert "gain_a" in one.out and "gain_b" in one.out
    assert json.loads(evenspin("effects", "current_gain", "--json").out)[0]["parameters"][0]["default"] == 1.0


@pytest.mark.parametrize(
    ("command", "count"), [("parameters", len(tables().params)), ("faults", len(tables().faults) - 1)]
)
def test_lists_are_complete(evenspin, command, count):
    content = json.loads(evenspin(command, "--json").out)

    assert len(content) == count
    shown = evenspin(command).out
    assert all(each["name"] in shown for each in content)


def test_the_design_is_printed_and_written(evenspin, tmp_path):
    said = evenspin("design", "rc", "--k-rc", 0.525, "--plot", tmp_path / "b.svg", "--json", tmp_path / "d.json")

    content = json.loads((tmp_path / "d.json").read_text())
    assert said.status == 0
    assert "1.38" in said.out and "36.7" in said.out
    assert content["stable"] and content["recommended_lead"] == 5
    assert content["gains_db"]["crc"]["20.83_hz"] == pytest.approx(36.7, abs=0.1)
    assert (tmp_path / "b.svg").read_text().startswith("<?xml")
    assert json.loads(evenspin("design", "rc", "--json").out)["rc"]["gain"] == 0.6


def test_a_design_that_is_not_stable_says_so(evenspin):
    refused = evenspin("design", "rc", "--kp", 1, "--k-rc", 0.1, "--json")

    assert refused.status == 1 and json.loads(refused.out)["stable"] is False
    assert json.loads(refused.out)["stability"]["reason"].startswith("the speed loop itself")
    assert "NOT stable" in evenspin("design", "rc", "--k-rc", 1.7).out
    assert "NOT stable" in evenspin("design", "rc", "--k-rc", 1.2, "--fal").out


def test_reproduce_writes_its_json_and_prints_its_tables(evenspin, tmp_path):
    said = evenspin("reproduce", "guo2024", "--set", "third", "--method", "pi", "--json", tmp_path / "r.json")

    content = json.loads((tmp_path / "r.json").read_text())
    assert said.status == 0
    assert [row["speed_rpm"] for row in content["rows"]] == [900.0, 1200.0]
    assert "1200" in said.out
    both = json.loads(
        evenspin("reproduce", "guo2024", "--set", "third", "--method", "pi", "--numeric", "both", "--json").out
    )
    assert (both["numeric"], both["fixed"]["numeric"]) == ("float", "fixed")


def test_a_missed_band_ends_with_1(evenspin, monkeypatch):
    from evenspin.reproduce.guo2024 import checks

    monkeypatch.setattr(checks, "ACCEPTANCE", (("pi", 150.0, "n1_pct", 0.0, 1.0),))

    said = evenspin("reproduce", "guo2024", "--set", "first", "--method", "pi")

    assert said.status == 1
    assert "FAILED" in said.out
    assert said.err.count("\n") == 1 and "n1_pct" in said.err


def test_the_benchmark_gives_a_number_that_can_be(evenspin, tmp_path):
    said = evenspin("benchmark", "sim", "--runs", 1, "--json", tmp_path / "b.json")

    factor = json.loads((tmp_path / "b.json").read_text())["sim_seconds_per_second"]
    assert said.status == 0
    assert 20.0 < factor < 1e5  # any machine, also a busy one


def test_every_command_has_an_example_in_its_help(evenspin):
    for words in ("run", "reproduce", "design rc", "effects", "parameters", "faults", "demo", "benchmark", "docs"):
        said = evenspin(*words.split(), "--help")
        assert said.status == 0
        assert f"evenspin {words}" in said.out, words


def test_the_installed_command_works_and_starts_quickly():
    """No numpy, no scipy, no matplotlib before they are needed."""
    code = (
        "import sys; from evenspin.cli import main\n"
        "try: main(['version'])\n"
        "except SystemExit: pass\n"
        "print(sorted({'numpy', 'scipy', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.startswith("evenspin ")
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_closed_pipe_is_no_error():
    command = f"{sys.executable} -c 'from evenspin.cli import main; main()' parameters | head -1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False, env=os.environ)

    assert "Traceback" not in done.stderr and "Exception" not in done.stderr


def unread(*words):
    """The command, with a pipe that nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    words = [sys.executable, "-c", "from evenspin.cli import main; main()", *words]
    done = subprocess.run(words, stdout=writer, stderr=subprocess.PIPE, text=True, check=False, timeout=60.0)
    os.close(writer)
    return done


def test_where_nobody_reads_what_is_printed_the_folder_is_written_all_the_same(scenario, tmp_path):
    done = unread("run", scenario, "--out", tmp_path / "out")

    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out" / "report.html").is_file()


def test_where_nobody_reads_a_drive_is_watched_no_longer(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))

    done = unread("bench", "watch", "--port", "sim:guo2024")

    assert (done.returncode, done.stderr) == (1, "")


def test_the_reference_pages_are_current(evenspin):
    said = evenspin("docs", "--check", "--out", ROOT / "docs")

    assert said.status == 0, said.err


def test_a_method_is_a_choice_of_the_drive_and_a_misspelt_one_gets_a_hint(evenspin, tmp_path):
    said = evenspin("run", "guo2024/first", "--method", "fal-frc", "--out", tmp_path / "x")

    assert said.status == 2
    assert said.err.startswith('run: --method = \'fal-frc\': must be "pi" or "crc" or')
    assert said.err.rstrip().endswith("did you mean fal-forc or fal-forc+ro?")
