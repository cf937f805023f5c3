"""The commands, and what becomes of errors. Each command loads what it needs when it is called."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Annotated, Any

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


INTERRUPTED = 130
# What every error of a command line is; typer does not export it.
USAGE: type[Exception] = typer.BadParameter.__mro__[2]

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
        status = app(words, prog_name="evenspin", standalone_mode=False)
        if status == INTERRUPTED:
            fail("evenspin: interrupted", INTERRUPTED)
        sys.exit(status if isinstance(status, int) else 0)
    except EvenspinError as error:
        fail(str(error), error.exit_code)
    except typer.Abort:
        fail("evenspin: interrupted", INTERRUPTED)
    except USAGE as error:
        fail_usage(error, words)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # nobody reads any more: nothing to say
        sys.exit(0)
    except OSError as error:
        place = error.filename or "evenspin"
        fail(f"{place}: {error.strerror or error}", 2)
    except MemoryError:
        fail("evenspin: out of memory: shorten duration_s or lower log_rate_hz", 2)
    except KeyboardInterrupt:
        fail("evenspin: interrupted", INTERRUPTED)


def fail_usage(error: Any, words: Sequence[str] = ()) -> None:
    """A wrong word, option or number of them: one line as all others, or the help where there was no word at all."""
    if type(error).__name__ == "NoArgsIsHelpError":  # typer does not export it
        error.show()
        sys.exit(error.exit_code)
    where = error.ctx.command_path if getattr(error, "ctx", None) is not None else "evenspin"
    fail(f"{where}: {_what_is_wrong(error, words).rstrip('.')}; see `{where} --help`", error.exit_code)


def _what_is_wrong(error: Any, words: Sequence[str]) -> str:
    """Of an option its value and what it must be, as errors of the commands themselves say it."""
    options: Sequence[str] = getattr(getattr(error, "param", None), "opts", ())
    given = [
        value
        for word, after in zip(words, [*words[1:], ""], strict=True)
        for option in options
        for value in ([after] if word == option else [word[len(option) + 1 :]] if word.startswith(f"{option}=") else [])
    ]
    text = str(error.format_message()).replace("Value error, ", "")
    if not given or not error.message.startswith(("Input should be ", "Value error, ")):
        return text
    must = error.message.removeprefix("Input should be ").split(", unable to parse")[0].replace("a valid ", "a ")
    must = must.rpartition(" is not ")[2].replace("a integer", "a whole number")
    return f"{options[0]} = {given[-1]!r}: must be {must}"


def fail(text: str, status: int) -> None:
    print(one_line(text), file=sys.stderr)
    sys.exit(status)
