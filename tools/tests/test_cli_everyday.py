"""What every command has: completion, --quiet, --json to stdout or to a file, lists that can be asked for one entry."""

import json
import os
import subprocess
import sys

import pytest
from evenspin.native import tables


def completed(line):
    """What a shell would offer behind this line."""
    words = {"COMP_WORDS": line, "COMP_CWORD": str(line.count(" ")), "_EVENSPIN_COMPLETE": "complete_bash"}
    code = "from evenspin.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | words, capture_output=True, text=True, timeout=60
    )
    return done.stdout.split()


@pytest.mark.parametrize(("line", "offered"), [
    ("evenspin swe", {"sweep"}), ("evenspin run guo2024/fi", {"guo2024/first"}),
    ("evenspin run guo2024/first --method fal-forc+", {"fal-forc+dob", "fal-forc+ro", "fal-forc+aro"}),
    ("evenspin sweep guo2024/first --vary cogging.o", {"cogging.order="}), ("evenspin models ser", {"servo"}),
])  # fmt: skip
def test_the_shell_completes_commands_names_and_values(line, offered):
    assert set(completed(line)) == offered


def test_quiet_prints_nothing_wherever_it_stands(evenspin, scenario, tmp_path):
    for words in (("--quiet", "run", scenario), ("run", scenario, "--quiet")):
        said = evenspin(*words, "--out", tmp_path / "out")
        assert (said.status, said.out, said.err) == (0, "", "")
    assert (tmp_path / "out" / "report.html").is_file()
    assert evenspin("run", scenario, "--out", tmp_path / "out").out != ""  # only that command was quiet


def test_quiet_leaves_json_and_errors(evenspin, scenario, tmp_path):
    assert json.loads(evenspin("run", scenario, "--quiet", "--json", "--out", tmp_path / "out").out)["outcome"]
    assert evenspin("run", "nonsense", "--quiet", "--out", tmp_path / "out").err.count("\n") == 1


def test_json_goes_to_a_file_where_one_follows(evenspin, scenario, tmp_path):
    said = evenspin("run", scenario, "--json", tmp_path / "a.json", "--out", tmp_path / "out")

    assert said.status == 0 and "mean rpm" in said.out and said.err == ""
    assert json.loads((tmp_path / "a.json").read_text())["outcome"]["result"] == "ran"
    assert json.loads(evenspin("effects", "--json").out)  # the next command has its own


def test_a_place_that_cannot_be_written_is_refused_before_the_work(evenspin, scenario, tmp_path):
    said = evenspin("run", scenario, "--json", "/nowhere/a.json", "--out", tmp_path / "out")

    assert said.status == 2 and "existing folder" in said.err and said.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_one_parameter_or_those_with_a_part_of_the_name(evenspin):
    one = json.loads(evenspin("parameters", "rc_gain", "--json").out)
    several = json.loads(evenspin("parameters", "rc_", "--json").out)

    assert [each["name"] for each in one] == ["rc_gain"]
    assert [each["name"] for each in several] == [name for name in tables().params if "rc_" in name]


def test_one_fault(evenspin):
    said = evenspin("faults", "over_current")

    assert "over_current" in said.out and "under_voltage" not in said.out


@pytest.mark.parametrize(("command", "name", "said"), [
    ("parameters", "rcgain", "did you mean rc_gain"), ("faults", "overcurrent", "did you mean over_current"),
    ("effects", "coging", "did you mean cogging"),
])  # fmt: skip
def test_a_name_that_is_none_is_suggested(evenspin, command, name, said):
    answer = evenspin(command, name)

    assert answer.status == 2 and said in answer.err and answer.err.count("\n") == 1
