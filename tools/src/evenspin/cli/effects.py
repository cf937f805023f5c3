"""`evenspin effects`: what non-ideal effects the simulator knows, and a new one from what a verdict has described."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from evenspin.cli.completion import effect_names
from evenspin.cli.lists import FIELD_HEADER, effect_json, field_row
from evenspin.cli.options import JsonFlag
from evenspin.cli.output import STDOUT, console, write_json

if TYPE_CHECKING:
    from evenspin.native import Effect

SHOW = "show"  # the command that a name, or nothing, stands for


class NameFirst(TyperGroup):
    """A first word that is no sub-command is a name: `evenspin effects cogging` is `evenspin effects show cogging`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not args or (args[0] not in self.commands and args[0] not in ("--help", "-h")):
            args = [SHOW, *args]
        return super().parse_args(ctx, args)


app = typer.Typer(
    cls=NameFirst,
    help="Non-ideal effects of the simulated machine: list them, explain one, or draft a new one from a verdict.",
)


def register(parent: typer.Typer) -> None:
    parent.add_typer(app, name="effects")


@app.command(SHOW)
def show(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="Only this one, with all it says.", autocompletion=effect_names),
    ] = None,
    as_json: JsonFlag = False,
) -> None:
    """What they do, how they show, their parameters with unit and range.

    Example: `evenspin effects cogging`
    """
    from evenspin.errors import InputError, did_you_mean
    from evenspin.native import tables
    from evenspin.tableview import TableView, print_table

    known = tables().effects
    if name is not None and name not in known:
        raise InputError("effects", "NAME", name, "the name of an effect", did_you_mean(name, known))
    chosen = [known[name]] if name else list(known.values())
    if as_json:
        write_json([effect_json(effect) for effect in chosen], STDOUT)
        return
    screen = console()
    if name is None:
        rows = [(effect.name, effect.acts_on, ", ".join(effect.params), effect.doc) for effect in chosen]
        print_table(TableView("Effects", "", ("name", "acts on", "parameters", "what it is"), rows, left=4), screen)
        return
    _print_one(chosen[0])


def _print_one(effect: Effect) -> None:
    from evenspin.tableview import TableView, print_table

    screen = console()
    screen.print(f"{effect.name} (acts on {effect.acts_on})\n{effect.doc}\nShows as: {effect.signature}")
    params = [field_row(field) for field in effect.params.values()]
    print_table(TableView("Parameters", "", FIELD_HEADER, params, left=5), screen)
    if effect.told_apart:
        shown = ", ".join(f"{name} {condition}".strip() for name, condition in effect.shown_by.items())
        screen.print(
            f"Looks like: {', '.join(effect.confused_with)}\nShown by: {shown}\nSeparated by: {effect.told_apart}"
        )
    lines = [f"{p.name} = {p.example:g}" for p in effect.params.values() if p.reported]
    screen.print("\n".join(["In a model or scenario file, for example:", f"[effects.{effect.name}]", *lines]))


@app.command("new")
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="What the effect is to be called.")],
    verdict: Annotated[
        Path, typer.Option("--from", metavar="VERDICT", help="verdict.json of `evenspin gap`, or its folder.")
    ],
    term: Annotated[int, typer.Option(min=1, help="Which of its terms, as the report lists them.")] = 1,
    root: Annotated[Path, typer.Option(metavar="DIR", help="The checkout that the files are written into.")] = Path(),
) -> None:
    """Draft the files of an effect from what `evenspin gap` has described and no effect of the table explains.

    Written are sim_host/effects/NAME.c, with the equation, its parameters, and examples as they were found, and a test
    of the equation by hand; for a line over the angle at a whole order a module for the search, too. No file is
    replaced.

    Example: `evenspin effects new windage --from out/gap/verdict.json`
    """
    from evenspin.empirical.sketch import equation_of, files_of
    from evenspin.errors import InputError

    _check_name(name, root)
    path = verdict / "verdict.json" if verdict.is_dir() else verdict
    chosen = _term(path, term)
    try:
        equation = equation_of(chosen)
    except (KeyError, TypeError, ValueError, ZeroDivisionError, OverflowError):
        raise InputError(
            path, "parameters", chosen["family"], "the numbers of its family", "run `evenspin gap` again"
        ) from None
    if equation is None:
        hint = "write it by hand: CONTRIBUTING.md, 'Add an effect'"
        raise InputError(path, "family", chosen["family"], "one that a hook of the simulator can have", hint)
    files = files_of(name, equation, str(chosen["form"]))
    there = [place for place in files if (root / place).exists()]
    if there:
        raise InputError("effects new", "NAME", name, f"new, but there is {there[0]}", "choose another name")
    for place, text in files.items():
        (root / place).parent.mkdir(exist_ok=True)
        (root / place).write_text(text, encoding="utf-8")
    screen = console()
    screen.print("\n".join(files), style="bold")
    screen.print(
        "Read what is written, then: make format, make setup, evenspin docs, make host; a line in RULES of "
        "tools/src/evenspin/correct/rules.py says what counteracts it in the drive, or why nothing does."
    )


LONGEST_NAME = 40
C_WORDS = frozenset(
    "auto break case char const continue default do double else enum extern float for goto if inline int long register "
    "restrict return short signed sizeof static struct switch typedef union unsigned void volatile while".split()
)


def _check_name(name: str, root: Path) -> None:
    import keyword
    import re

    from evenspin.errors import InputError
    from evenspin.native import tables

    if not re.fullmatch(r"[a-z][a-z0-9_]*", name, re.ASCII) or len(name) > LONGEST_NAME or name in C_WORDS:
        must = f"an identifier of small letters, digits and _, at most {LONGEST_NAME}"
        raise InputError("effects new", "NAME", name, must, "such as windage")
    if keyword.iskeyword(name) or name in (SHOW, "new", "equations", "hypothesis", "registry"):
        raise InputError("effects new", "NAME", name, "no word of the command or of the package", "such as windage")
    if not (root / "sim_host/effects").is_dir():
        raise InputError(
            "effects new", "--root", str(root), "a checkout with sim_host/effects", "run it in the checkout"
        )
    if name in tables().effects or (root / f"sim_host/effects/{name}.c").exists():
        raise InputError("effects new", "NAME", name, "new: the table has this effect", "choose another name")


def _term(path: Path, number: int) -> dict[str, Any]:
    """One of the terms of a verdict."""
    import json

    from evenspin.errors import InputError
    from evenspin.log.textfile import HINT, META_BYTES, read_text

    try:
        content = json.loads(read_text(path, HINT, META_BYTES, "JSON"))
    except (ValueError, RecursionError):
        raise InputError(path, "file", "text", "JSON", "give verdict.json of `evenspin gap`") from None
    terms = content.get("empirical") if isinstance(content, dict) else None
    if not terms:
        must = "with at least one term that no known effect explains"
        raise InputError(path, "empirical", "none", must, "give the verdict of a case that says `unknown`")
    keys = {"family", "form", "parameters", "measured_over"}
    if not isinstance(terms, list) or not all(isinstance(each, dict) and keys <= set(each) for each in terms):
        raise InputError(path, "empirical", "terms", f"each with {', '.join(sorted(keys))}", "run `evenspin gap` again")
    if number > len(terms):
        raise InputError("effects new", "--term", number, f"1 .. {len(terms)}", "the report lists them in this order")
    return dict(terms[number - 1])
