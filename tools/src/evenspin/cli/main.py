"""The commands, and what becomes of errors. Each command loads what it needs when it is called."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Annotated

import typer

from evenspin.cli.commands import CONTEXT, Commands
from evenspin.cli.origin import remember
from evenspin.cli.output import (
    JSON_WITH_FILE,
    check_json_of_flag,
    name_the_identification,
    split_json_option,
    take_quiet,
)
from evenspin.errors import EvenspinError, one_line


def _say_version(wanted: bool) -> None:
    if wanted:
        from evenspin.build import build

        print(build())
        raise typer.Exit


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings=CONTEXT,
    help="Makes a permanent-magnet synchronous motor turn evenly.\n\n"
    "Exit status: 0 done, 1 the check failed, 2 wrong usage or input, 3 no device. With --quiet, anywhere, nothing is "
    "printed but JSON and errors; --json FILE.json writes it to a file.",
)


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", help="Version and commit.", is_eager=True, callback=_say_version)
    ] = False,
) -> None:
    pass


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point of the command. A user error is one line on stderr, never a traceback."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: threads that wait for each other cost seconds
    try:
        words = split_json_option(name_the_identification(take_quiet(words)))
        remember(words, words[:1] != [] and words[0] in JSON_WITH_FILE)
        check_json_of_flag()
        app(words, prog_name="evenspin")
    except EvenspinError as error:
        fail(str(error), error.exit_code)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # nobody reads any more: nothing to say
        sys.exit(0)
    except OSError as error:
        place = error.filename or "evenspin"
        fail(f"{place}: {error.strerror or error}", 2)
    except MemoryError:
        fail("evenspin: out of memory: shorten duration_s or lower log_rate_hz", 2)
    except KeyboardInterrupt:
        fail("evenspin: interrupted", 130)


def fail(text: str, status: int) -> None:
    print(one_line(text), file=sys.stderr)
    sys.exit(status)
