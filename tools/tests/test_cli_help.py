"""`-h` and `--version` are where everybody looks for them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
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
