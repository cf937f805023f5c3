"""`evenspin scenarios` and `models`: listed, printed, and copied to begin with."""

import json

import pytest


@pytest.mark.parametrize(("command", "name"), [("scenarios", "guo2024/first"), ("models", "servo")])
def test_what_comes_with_the_package_is_listed_printed_and_copied(evenspin, tmp_path, command, name):
    copy = tmp_path / "mine.toml"

    listed, printed, copied = evenspin(command), evenspin(command, name), evenspin(command, name, "--copy", copy)

    assert name in listed.out and (listed.status, printed.status, copied.status) == (0, 0, 0)
    assert copy.read_text() == printed.out
    assert [each["name"] for each in json.loads(evenspin(command, name, "--json").out)] == [name]


def test_a_copied_scenario_runs(evenspin, tmp_path):
    evenspin("scenarios", "guo2024/third", "--copy", tmp_path / "mine.toml")

    assert evenspin("run", tmp_path / "mine.toml", "--out", tmp_path / "out").status == 0


def test_every_scenario_and_model_says_what_it_is(evenspin):
    for command in ("scenarios", "models"):
        for each in json.loads(evenspin(command, "--json").out):
            assert each["description"], each["name"]


@pytest.mark.parametrize(("words", "said"), [
    (("scenarios", "guo2024/frist"), "did you mean guo2024/first"),
    (("models", "--copy", "x.toml"), "given with --copy"),
    (("models", "servo", "--copy", "/nowhere/x.toml"), "existing folder"),
])  # fmt: skip
def test_a_wrong_word_is_one_line(evenspin, words, said):
    answer = evenspin(*words)

    assert answer.status == 2 and said in answer.err and answer.err.count("\n") == 1


def test_a_file_that_is_there_is_not_replaced_by_a_copy(evenspin, tmp_path):
    (tmp_path / "mine.toml").write_text("mine")

    assert evenspin("models", "servo", "--copy", tmp_path / "mine.toml").status == 2
    assert (tmp_path / "mine.toml").read_text() == "mine"
