"""`--record FILE.replay`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from evenspin.output.origin import Origin
    from evenspin.recording import Recorder

RecordOption = Annotated[
    Path | None,
    typer.Option(
        "--record", metavar="FILE.replay", help="Record everything that the firmware takes in, for `evenspin replay`."
    ),
]


def check_record(path: Path | None) -> None:
    from evenspin.errors import InputError
    from evenspin.recording import ENDING

    if path is not None and path.suffix != ENDING:
        raise InputError("evenspin", "--record", path, f"a file {ENDING}", "give it that ending")


@contextmanager
def recorder_to(
    path: Path | None,
    made: Origin,
    force: bool | None,
    numeric: str,
    what: str,
    seed: int,
    pwm_hz: float,
    linked: bool = False,
) -> Iterator[Recorder | None]:
    """A recorder whose file is there, whole, behind the block; None without a path. `force`: None where the command has
    no such option."""
    from evenspin.output import OutputFile
    from evenspin.recording import Recorder

    if path is None:
        yield None
        return
    target = OutputFile(path, made, option="--record", force=bool(force), can_force=force is not None)
    with target as place, place.open("wb") as file:
        recorder = Recorder(
            file, numeric=numeric, what=what, seed=seed, pwm_hz=pwm_hz, linked=linked, command=made.command
        )
        yield recorder
        recorder.close()
