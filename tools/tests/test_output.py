"""Outputs replace only what the same command made of the same inputs; everything else is refused, whole, and named."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from evenspin.build import Build, build
from evenspin.errors import InputError
from evenspin.output import Origin, OutputFile, OutputFolder
from evenspin.output import staging as staging_module
from evenspin.output.staging import leftovers
from said import Said

Call = Callable[..., Said]
ROOT = Path(__file__).resolve().parents[2]
PORT = "sim:guo2024"


X = Origin("evenspin x")


def make(out: Path, origin: Origin = X, text: str = "a", **how: bool) -> None:
    with OutputFolder(out, origin, **how) as folder:
        (folder / "a.txt").write_text(text)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


# ---- folders


def test_the_same_command_replaces_its_own_output(tmp_path: Path) -> None:
    make(tmp_path / "out")
    make(tmp_path / "out", text="b")

    assert (tmp_path / "out" / "a.txt").read_text() == "b"
    assert names(tmp_path) == ["out"]


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (Origin("evenspin y"), "`evenspin x` made it"),
        (Origin("evenspin x", (Path("/etc/hostname"),)), "other inputs"),
    ],
)
def test_another_command_or_input_does_not_replace_it(tmp_path: Path, other: Origin, said: str) -> None:
    make(tmp_path / "out")

    with pytest.raises(InputError, match=said) as refusal:
        make(tmp_path / "out", other, "b")

    assert "--force" in str(refusal.value) and (tmp_path / "out" / "a.txt").read_text() == "a"
    make(tmp_path / "out", other, "b", force=True)
    assert (tmp_path / "out" / "a.txt").read_text() == "b"


def change(out: Path) -> None:
    (out / "a.txt").write_text("mine")


def add(out: Path) -> None:
    (out / "deep").mkdir()
    (out / "deep" / "notes.txt").write_text("mine")


def add_folder(out: Path) -> None:
    (out / "photos").mkdir()


def add_link(out: Path) -> None:
    (out / "there").symlink_to("/etc")


def take_away(out: Path) -> None:
    (out / "a.txt").rename(out.parent / "kept.txt")


def old_manifest(out: Path) -> None:
    (out / "manifest.json").write_text(json.dumps({"command": "evenspin x", "files": ["a.txt"]}))


@pytest.mark.parametrize(
    ("touch", "named"),
    [
        (change, "a.txt was changed since"),
        (add, "deep/notes.txt was added since"),
        (add_folder, "photos/ was added since"),
        (add_link, "there was added since"),
        (take_away, "a.txt was removed since"),
        (old_manifest, "an early version"),
    ],
)
def test_what_a_hand_has_touched_is_not_replaced(tmp_path: Path, touch: Callable[[Path], None], named: str) -> None:
    out = tmp_path / "out"
    make(out)
    touch(out)
    before = tree(tmp_path)

    with pytest.raises(InputError, match=named):
        make(out)

    assert tree(tmp_path) == before
    make(out, force=True)
    assert names(out) == ["a.txt", "manifest.json"]


def test_what_was_touched_while_the_command_ran_is_not_replaced_either(tmp_path: Path) -> None:
    make(tmp_path / "out")

    with pytest.raises(InputError, match="a.txt was changed"), OutputFolder(tmp_path / "out", Origin("evenspin x")):
        change(tmp_path / "out")

    assert (tmp_path / "out" / "a.txt").read_text() == "mine"


def test_a_folder_of_somebody_else_is_not_replaced_with_force_either(tmp_path: Path) -> None:
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "thesis.txt").write_text("three years")

    for force in (False, True):
        with pytest.raises(InputError, match="thesis.txt"):
            OutputFolder(tmp_path / "thesis", Origin("evenspin x"), force=force)


def test_a_recording_is_never_replaced_without_force(tmp_path: Path) -> None:
    make(tmp_path / "out", recording=True)

    for recording in (True, False):
        with pytest.raises(InputError, match="recording of `evenspin x`"):
            make(tmp_path / "out", recording=recording)
    make(tmp_path / "out", text="b", recording=True, force=True)
    assert (tmp_path / "out" / "a.txt").read_text() == "b"


@pytest.mark.parametrize("out", ["case", "case/inside", "case/deep/inside", ".", "./case/../case", "link", "link/in"])
@pytest.mark.parametrize("force", [False, True])
def test_an_output_is_never_its_input_nor_in_it_nor_around_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, out: str, force: bool
) -> None:
    monkeypatch.chdir(tmp_path)
    make(tmp_path / "case")
    (tmp_path / "link").symlink_to("case")
    before = tree(tmp_path)

    with pytest.raises(InputError, match="input|a folder"):
        make(Path(out), Origin("evenspin x", (tmp_path / "case",)), force=force)

    assert tree(tmp_path) == before and names(tmp_path) == ["case", "link"]


def test_a_folder_around_an_input_file_is_refused_and_one_beside_it_is_not(tmp_path: Path) -> None:
    log = tmp_path / "logs" / "log.csv"
    log.parent.mkdir()
    log.write_text("t_s\n")
    reads_it = Origin("evenspin x", (log,))

    with pytest.raises(InputError, match="log.csv"):
        make(log.parent, reads_it, force=True)
    make(log.parent / "out", reads_it)


def test_the_manifest_says_who_made_it_when_of_what(tmp_path: Path) -> None:
    (tmp_path / "in.txt").write_text("input")
    before_s = time.time()
    make(tmp_path / "out", Origin("evenspin x --y 1", (tmp_path / "in.txt",)))

    content = json.loads((tmp_path / "out" / "manifest.json").read_text())

    assert content["command"] == "evenspin x --y 1"
    assert content["version"] == build().version
    made_s = time.mktime(time.strptime(content["made_at"], "%Y-%m-%dT%H:%M:%SZ")) - time.timezone
    assert before_s - 1.0 <= made_s <= time.time()
    assert content["files"] == {"a.txt": hashlib.sha256(b"a").hexdigest()}
    assert content["inputs"] == {str(tmp_path / "in.txt"): hashlib.sha256(b"input").hexdigest()}
    git = subprocess.run(["git", "-C", str(ROOT), "rev-parse", "HEAD"], capture_output=True, text=True)
    if git.returncode == 0 and (ROOT / ".git").exists():
        assert git.stdout.startswith(content["commit"].removesuffix("+changes"))
        assert re.fullmatch(r"\d{4}-\d\d-\d\dT.*", content["commit_date"])


def test_version_says_version_and_commit(evenspin: Call) -> None:
    said = evenspin("version", "--json")

    content = json.loads(said.out)
    assert (content["version"], content["commit"]) == (build().version, build().commit)
    assert str(Build("1.2", None, None)) == "evenspin 1.2 (commit not known)"
    assert str(build()) in evenspin("version").out


# ---- writers that are killed, and writers at the same time


def write_slowly(out: Path, ready: str, go: str) -> None:
    """A writer in a process of its own, which waits until it is allowed to go on."""
    try:
        with OutputFolder(out, Origin("evenspin x")) as folder:
            (folder / "a.txt").write_text(str(os.getpid()))
            Path(ready).touch()
            until = time.monotonic() + 60.0
            while not Path(go).exists() and time.monotonic() < until:
                time.sleep(0.01)
    except InputError as error:
        Path(f"{ready}.refused").write_text(str(error))
        sys.exit(2)


def started(out: Path, ready: Path, go: Path) -> multiprocessing.Process:
    words = (out, str(ready), str(go))
    process = multiprocessing.get_context("fork").Process(target=write_slowly, args=words, daemon=True)
    process.start()
    until = time.monotonic() + 20.0
    while not ready.exists() and process.is_alive() and time.monotonic() < until:
        time.sleep(0.01)
    return process


def test_a_killed_writer_leaves_a_folder_that_is_found_named_and_removed(
    evenspin: Call, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "place"
    writer = started(place / "out", tmp_path / "ready", tmp_path / "go")
    (alive,) = leftovers(place)
    assert alive.alive and "being written" in evenspin("clean", place).out  # a living writer's is no leftover
    assert writer.is_alive() and alive.path.exists()
    os.kill(writer.pid, signal.SIGKILL)
    writer.join()
    (left,) = leftovers(place)
    assert not left.alive and not (place / "out").exists()

    make(place / "out")  # the next run goes on, and names it
    reported = capsys.readouterr().err
    assert str(left.path) in reported and f"evenspin clean {place}" in reported
    assert left.path.exists()
    assert str(left.path) in evenspin("clean", place, "--dry-run").out and left.path.exists()
    said = evenspin("clean", place)
    assert said.status == 0 and str(left.path) in said.out and "removed" in said.out
    assert names(place) == ["out"]
    assert "nothing" in evenspin("clean", place).out


def test_of_three_writers_at_once_two_are_told(tmp_path: Path) -> None:
    out, go = tmp_path / "place" / "out", tmp_path / "go"
    writers = [started(out, tmp_path / f"ready{number}", go) for number in range(3)]
    go.touch()
    for writer in writers:
        writer.join()

    assert [writer.exitcode for writer in writers] == [0, 2, 2]
    assert (out / "a.txt").read_text() == str(writers[0].pid)
    for number in (1, 2):
        text = (tmp_path / f"ready{number}.refused").read_text()
        assert f"process {writers[0].pid}" in text and str(out) in text
    assert names(out.parent) == ["out"]


def test_a_command_that_fails_before_it_writes_leaves_no_lock_and_no_folder(tmp_path: Path) -> None:
    output = OutputFolder(tmp_path / "deep" / "out", Origin("evenspin x"))
    assert names(tmp_path / "deep") == [".out.evenspin-lock"]
    del output

    assert names(tmp_path) == []


def test_without_an_exchange_of_names_the_earlier_output_is_not_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, evenspin: Call
) -> None:
    """Killed between the two renames that stand for an exchange: the earlier output is named, and never removed."""
    make(tmp_path / "out", text="old")
    monkeypatch.setattr(staging_module, "_exchange", lambda one, other: False)
    make(tmp_path / "out", text="new")
    assert (tmp_path / "out" / "a.txt").read_text() == "new" and names(tmp_path) == ["out"]
    left = tmp_path / ".out.evenspin-12345678"
    left.mkdir()
    (tmp_path / "out").rename(left / "old")

    said = evenspin("clean", tmp_path)

    assert f"{left}/old" in said.out and (left / "old" / "a.txt").read_text() == "new"


# ---- files


def test_a_file_is_replaced_by_the_command_that_made_it_and_by_no_other(tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    OutputFile(path, Origin("evenspin x")).write("1")
    OutputFile(path, Origin("evenspin x")).write("2")
    assert path.read_text() == "2"

    with pytest.raises(InputError, match="`evenspin x` made it"):
        OutputFile(path, Origin("evenspin y"))
    path.write_text("mine")
    with pytest.raises(InputError, match="changed since"):
        OutputFile(path, Origin("evenspin x"))
    OutputFile(path, Origin("evenspin y"), force=True).write("3")
    assert path.read_text() == "3"
    assert names(tmp_path) == [".evenspin-files.json", "x.json"]


def test_a_file_that_was_there_before_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "package.json"
    path.write_text("{}")
    (tmp_path / ".evenspin-files.json").write_text('{"files": []')  # a note that is none

    with pytest.raises(InputError, match="no command of evenspin is known") as refusal:
        OutputFile(path, Origin("evenspin x"), option="--json", can_force=False)

    assert "--force" not in str(refusal.value) and path.read_text() == "{}"
    with pytest.raises(InputError, match="another one than the input"):
        OutputFile(path, Origin("evenspin x", (path,)), force=True)


def test_a_measured_file_is_not_replaced_by_its_own_command(tmp_path: Path) -> None:
    path = tmp_path / "step.csv"
    OutputFile(path, Origin("evenspin x"), recording=True).write("1")

    with pytest.raises(InputError, match="measured"):
        OutputFile(path, Origin("evenspin x"), recording=True)
    OutputFile(path, Origin("evenspin x"), recording=True, force=True).write("2")
    assert path.read_text() == "2" and names(tmp_path) == ["step.csv"]


def test_a_pipe_and_a_device_are_written_into(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    OutputFile(pipe, Origin("evenspin x")).write("through")
    assert os.read(reader, 100) == b"through"
    os.close(reader)

    OutputFile(Path("/dev/null"), Origin("evenspin x")).write("gone")
    assert Path("/dev/null").is_char_device() and names(tmp_path) == ["pipe"]


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "x.json").symlink_to(tmp_path / "there" / "y.json")
    with pytest.raises(InputError, match="file in an existing folder"):
        OutputFile(tmp_path / "x.json", Origin("evenspin x"))
    (tmp_path / "there" / "y.json").touch()
    OutputFile(tmp_path / "x.json", Origin("evenspin x"), force=True).write("1")

    assert (tmp_path / "x.json").is_symlink() and (tmp_path / "there" / "y.json").read_text() == "1"


# ---- commands


def test_a_run_repeats_but_does_not_replace_another_run(
    evenspin: Call, scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("evenspin.run.write_run", lambda folder, *_: (folder / "log.csv").write_text("t_s\n"))
    out = tmp_path / "out"
    assert evenspin("run", scenario, "--out", out).status == 0
    assert evenspin("run", scenario, "--json", "--out", out).status == 0  # where the JSON goes is not part of it
    before = tree(out)

    other = evenspin("run", scenario, "--method", "pi", "--out", out)
    assert other.status == 2 and f"`evenspin run {scenario}` made it" in other.err and other.err.count("\n") == 1
    copy = scenario.with_name("copy.toml")
    copy.write_text(scenario.read_text())
    assert evenspin("run", copy, "--out", out).status == 2
    assert evenspin("gap", out, "--out", out, "--force").status == 2
    assert tree(out) == before
    assert evenspin("run", scenario, "--method", "pi", "--out", out, "--force").status == 0


def test_a_recording_is_refused_before_anything_moves(evenspin: Call, tmp_path: Path, scenario: Path) -> None:
    out = tmp_path / "rec"
    words = ("bench", "record", "--port", PORT, "--seconds", 0.1, "--out", out)
    assert evenspin(*words).status == 0
    before = tree(out)

    for command in (words, ("run", scenario, "--out", out), ("gap", "plan", "--model", "servo", "--out", out)):
        said = evenspin(*command)
        assert said.status == 2 and said.err.count("\n") == 1 and "recording" in said.err, command
    gone = evenspin("bench", "record", "--port", "socket://127.0.0.1:9", "--out", out)
    assert gone.status == 2  # the output is looked at before the drive
    assert tree(out) == before
    assert evenspin(*words, "--force").status == 0


def test_a_model_that_a_scenario_names_is_an_input(evenspin: Call, tmp_path: Path, scenario: Path) -> None:
    from evenspin.model.machine import builtin_models

    place = tmp_path / "motor"
    place.mkdir()
    (place / "own.toml").write_text(builtin_models()["guo2024"].read_text())
    scenario.write_text(scenario.read_text().replace('"guo2024"', '"motor/own.toml"'))

    said = evenspin("run", scenario, "--out", place, "--force")

    assert said.status == 2 and "own.toml" in said.err and names(place) == ["own.toml"]


@pytest.mark.parametrize(
    ("words", "option"),
    [
        (("design", "rc", "--json"), ""),
        (("design", "rc", "--plot"), ".svg"),
        (("design", "aro", "--plot"), ".svg"),
        (("bench", "plan", "servo", "--out"), ".toml"),
        (("bench", "config", "pull"), ".toml"),
        (("bench", "capture", "--rows", 10, "--out"), ".csv"),
        (("run", "guo2024/first", "--method", "aro", "--out", "OUT", "--save-memory"), ".csv"),
    ],
)
def test_no_command_writes_over_a_file_of_mine(evenspin: Call, tmp_path: Path, words: tuple, option: str) -> None:
    path = tmp_path / f"mine{option}"
    path.write_text("mine")
    port = ("--port", PORT) if words[0] == "bench" and words[1] != "plan" else ()
    words = tuple(tmp_path / "out" if word == "OUT" else word for word in words)

    said = evenspin(*words, path, *port)

    assert said.status == 2 and str(path) in said.err and said.err.count("\n") == 1, said
    assert path.read_text() == "mine" and names(tmp_path) == [path.name]


def test_a_plan_that_was_changed_is_kept_and_one_that_was_not_is_made_again(evenspin: Call, tmp_path: Path) -> None:
    path = tmp_path / "list.toml"
    words = ("bench", "plan", "servo", "--out", path)
    assert (evenspin(*words).status, evenspin(*words).status) == (0, 0)

    path.write_text(path.read_text().replace("duration_s = ", "duration_s = 1", 1))
    mine = path.read_text()

    assert evenspin(*words).status == 2 and path.read_text() == mine
    assert evenspin(*words, "--force").status == 0 and path.read_text() != mine


def test_a_configuration_is_pulled_again_only_as_it_was(evenspin: Call, tmp_path: Path) -> None:
    path = tmp_path / "drive.toml"
    words = ("bench", "config", "pull", path, "--port")
    assert (evenspin(*words, PORT).status, evenspin(*words, PORT).status) == (0, 0)
    before = path.read_text()

    said = evenspin(*words, "sim:servo")  # other values: those in the file would be lost

    assert said.status == 2 and "--force" in said.err and path.read_text() == before


def test_each_calibration_keeps_its_way_back(evenspin: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("bench", "calibrate", "rl", "--port", PORT, "--yes")
    evenspin(*words)
    first = (tmp_path / "calibration-rl.toml").read_text()
    evenspin(*words)

    assert names(tmp_path) == ["calibration-rl-2.toml", "calibration-rl.toml"]
    assert (tmp_path / "calibration-rl.toml").read_text() == first
    assert evenspin(*words, "--out", "calibration-rl.toml").status == 2


def test_a_batch_refuses_before_the_first_case(evenspin: Call, tmp_path: Path) -> None:
    case = tmp_path / "cases" / "one"
    case.mkdir(parents=True)
    (case / "meta.json").write_text("{}")

    inside = evenspin("gap", "batch", tmp_path / "cases", "--out", tmp_path / "cases" / "out")
    assert inside.status == 2 and "outside of the input" in inside.err
    assert evenspin("gap", "batch", case, "--out", tmp_path / "out").status == 1  # no verdict, reported
    assert evenspin("gap", "batch", case, "--out", tmp_path / "out").status == 1  # the same again
    (tmp_path / "out" / "summary.json").write_text("mine")
    changed = evenspin("gap", "batch", case, "--out", tmp_path / "out")
    assert changed.status == 2 and "summary.json" in changed.err
    assert (tmp_path / "out" / "summary.json").read_text() == "mine"
