"""What every command has: completion, --quiet, --json to stdout or to a file, lists that can be asked for one entry."""

import json
import os
import subprocess
import sys

import numpy as np
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


@pytest.mark.parametrize(("words", "said"), [
    (("rnu",), "Did you mean 'run'"), (("run",), "Missing argument 'SCENARIO'"),
    (("run", "guo2024/first"), "Missing option '--out'"), (("run", "guo2024/first", "--outt", "x"), "--out"),
    (("run", "guo2024/first", "--seed", "-1", "--out", "x"), "--seed"), (("effects", "a", "b"), "unexpected"),
    (("bench", "watch", "--signal", "x"), "evenspin bench watch --help"),
])  # fmt: skip
def test_a_wrong_command_line_is_one_line_that_names_the_help(evenspin, words, said):
    answer = evenspin(*words)

    assert (answer.status, answer.out) == (2, "")
    assert said in answer.err and answer.err.count("\n") == 1 and "--help`" in answer.err


@pytest.mark.parametrize(("words", "said"), [
    (("tune", "servo", "--current-hz", "nan"), "--current-hz = 'nan': must be less than or equal to 2000"),
    (("tune", "servo", "--current-hz=0"), "--current-hz = '0': must be greater than or equal to 1"),
    (("motor", "new", "m", "--kv", "270rpm"), "--kv = '270rpm': must be a number"),
    (("run", "x", "--out", "o", "--seed", "1.5"), "--seed = '1.5': must be a whole number"),
    (("run", "x", "--out", "o", "--numeric", "flot"), "--numeric = 'flot': must be one of 'float', 'fixed'"),
])  # fmt: skip
def test_a_wrong_value_of_an_option_is_named_with_what_it_must_be(evenspin, words, said):
    answer = evenspin(*words)

    assert answer.status == 2 and answer.err.count("\n") == 1
    assert f": {said}; see `" in answer.err


def test_an_interrupt_is_said(evenspin, monkeypatch):
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("evenspin.tableview.print_table", interrupted)
    answer = evenspin("faults")

    assert (answer.status, answer.err) == (130, "evenspin: interrupted\n")


def test_the_bench_answers_in_words(evenspin):
    """A choice, a state and a fault by name, and what was done."""
    assert evenspin("bench", "set", "--port", "sim:servo", "method=forc", "rc_gain=0.4").out.splitlines() == [
        "method = forc", "rc_gain = 0.4",
    ]  # fmt: skip
    assert evenspin("bench", "stop", "--port", "sim:servo").out == "The bridge is off.\n"
    assert evenspin("bench", "save", "--port", "sim:servo").out == "Kept over a power cycle.\n"
    watched = evenspin("bench", "watch", "state", "fault", "--port", "sim:servo", "--seconds", "0.3").out
    assert watched.split()[-2:] == ["ready", "none"]


@pytest.mark.parametrize(("words", "said"), [
    (("bench", "set", "--port", "sim:servo", "rc_gain=0.4", "rc_gain=0.5"), "the only one of its name"),
    (("drive", "--pty", "--tcp", "127.0.0.1:0"), "'both'"), (("drive",), "'neither'"),
])  # fmt: skip
def test_what_contradicts_itself_is_refused(evenspin, words, said):
    answer = evenspin(*words)

    assert answer.status == 2 and said in answer.err and "None" not in answer.err


def test_identification_takes_the_columns_that_a_recording_has(evenspin, tmp_path):
    """`bench record` keeps no id_ref_a, vdc_v and phase currents unless it is asked for them; friction needs none."""
    from evenspin.cli.bench_capture import SIGNALS
    from evenspin.identify.source import read_runs
    from evenspin.log import write_csv

    turn = np.linspace(0.0, 40.0, 4001)
    columns = {
        "t_s": 1e-2 * np.arange(4001), "speed_ref_rad_s": np.full(4001, 6.28), "speed_rad_s": np.full(4001, 6.28),
        "theta_m_rad": (2.0 * np.pi * turn) % (2.0 * np.pi), "id_a": np.cos(turn), "iq_ref_a": 2.0 + np.sin(turn),
        "iq_a": 2.0 + np.sin(turn), "vd_v": np.cos(3 * turn), "vq_v": 5.0 + np.cos(turn),
    }  # fmt: skip
    assert set(columns) == {"t_s", *SIGNALS}
    write_csv(tmp_path / "recording.csv", list(columns), np.column_stack(list(columns.values())))

    found = read_runs([tmp_path / "recording.csv"], torque_per_a_nm=0.5)

    assert found[0].torque_nm == pytest.approx(0.5 * columns["iq_a"], rel=1e-8)
    write_csv(tmp_path / "less.csv", ["t_s", "iq_a"], np.zeros((5, 2)))
    assert "in the header" in evenspin("identify", "friction", tmp_path / "less.csv", "--torque-per-a-nm", "0.5").err


def test_a_port_that_another_program_uses_is_said_to_be_in_use(evenspin):
    """Not its cable: `bench stop` beside a recording is what somebody tries."""
    import pty

    import serial

    ours, theirs = pty.openpty()
    name = os.ttyname(theirs)
    with serial.Serial(name, exclusive=True):
        said = evenspin("bench", "stop", "--port", name)
    os.close(ours)
    os.close(theirs)

    assert said.status == 3 and "another program uses it" in said.err and "Errno" not in said.err
