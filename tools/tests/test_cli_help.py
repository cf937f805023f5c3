"""`-h` and `--version` are where everybody looks for them."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from evenspin.cli.commands import COMMANDS
from evenspin.cli.main import app


def commands(command: Any, words: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    yield words
    for name, inner in getattr(command, "commands", {}).items():
        yield from commands(inner, (*words, name))


ALL = list(commands(typer.main.get_command(app)))


@pytest.mark.parametrize("words", [(), *ALL[1::8]], ids=" ".join)
def test_a_command_answers_to_both_words_for_help(evenspin, words: tuple[str, ...]) -> None:
    """Every eighth: they all inherit it from the same place."""
    short, long = evenspin(*words, "-h"), evenspin(*words, "--help")
    assert (short.status, short.err) == (0, "")
    assert short.out == long.out
    assert " ".join(("evenspin", *words)) in " ".join(short.out.split())


def test_the_table_of_questions_in_the_readme_has_every_command() -> None:
    readme = (Path(__file__).parents[2] / "README.md").read_text()
    table = readme.split("| question | command |", 1)[1].split("\n\n", 1)[0]
    first = {words[0] for words in ALL if words}
    missing = [name for name in sorted(first) if not re.search(rf"`(evenspin )?{name}[ `]", table)]
    assert missing == []


def test_version_says_version_and_commit(evenspin) -> None:
    from importlib.metadata import version

    said = evenspin("--version")
    assert said.status == 0
    assert said.out.startswith(f"evenspin {version('evenspin')} (commit ")
    assert len(said.out.splitlines()) == 1


@pytest.mark.parametrize("name", COMMANDS)
def test_the_list_of_commands_says_of_each_what_its_own_help_says_first(name: str) -> None:
    help_text = typer.main.get_command(app).commands[name].help or ""
    assert help_text.partition("\n\n")[0].replace("\n", " ").replace("`", "") == COMMANDS[name].summary


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_a_question_about_evenspin_itself_loads_no_command(option: str) -> None:
    """Each module costs time, and numpy alone more than all the rest."""
    code = (
        "import sys\nfrom evenspin.cli import main\n"
        f"try: main([{option!r}])\nexcept SystemExit: pass\n"
        "print(sorted(name for name in sys.modules if name.startswith('evenspin.cli.') or name == 'numpy'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    allowed = ["evenspin.cli.commands", "evenspin.cli.main", "evenspin.cli.origin", "evenspin.cli.output"]
    assert done.stdout.splitlines()[-1] == str(allowed)


def test_a_command_is_registered_once_however_often_it_is_called() -> None:
    before = typer.main.get_command(app).commands["bench"]
    assert typer.main.get_command(app).commands["bench"] is before
