"""A regression test from a recording: the recording, cut behind the fault, and a file that pytest runs."""

from __future__ import annotations

from pathlib import Path

from evenspin.errors import InputError
from evenspin.recording import ENDING, Player, RecordingFile, Writer
from evenspin.replay.replayed import Replayed

TEMPLATE = '''"""Made by `{command}` from {source}: {what}.

The firmware replays the recording beside this file bit for bit. Whoever changes on purpose what the drive does records
it again.
"""

from pathlib import Path

import evenspin as es

RECORDING = Path(__file__).with_suffix("{ending}")


def test_{name}_replays_without_a_difference() -> None:
    replayed = es.replay_recording(RECORDING, other_firmware=True)
    assert replayed.difference is None, replayed.difference
    assert replayed.periods == {periods}
    assert {fault}
'''


def check_name(name: str) -> str:
    """A word that may be the name of a function."""
    if not (name.isascii() and name.isidentifier() and name == name.lower()):
        raise InputError(
            "replay", "--test", name, "small letters, digits and _, as in a function's name", "for example sensor_a"
        )
    return name


def write_test(replayed: Replayed, recording: Path, script: Path, name: str, command: str) -> None:
    """`recording` gets what was replayed, up to its last period; `script` is the test of it."""
    _cut(replayed, recording)
    fault = replayed.fault
    expected = "replayed.fault is None" if fault is None else f'str(replayed.fault) == "{fault}"'
    what = f"{replayed.head.what}, {replayed.t_s:g} s, {fault if fault is not None else 'no fault'}"
    text = TEMPLATE.format(
        command=command,
        source=replayed.path.name,
        what=what,
        ending=ENDING,
        name=name,
        periods=replayed.periods,
        fault=expected,
    )
    script.write_text(text, encoding="utf-8")


def _cut(replayed: Replayed, target: Path) -> None:
    """The recording up to the last period that was replayed."""
    file = RecordingFile(replayed.path)
    player = Player(replayed.path, file.head, other_firmware=True)
    with target.open("wb") as out:
        writer = Writer(out, file.head)
        for part in file.parts():
            player.feed(part)
            done = player.skip(min(part.periods, replayed.periods - writer.periods))
            writer.part(done, part.streams if done == part.periods else player.taken())
            if writer.periods >= replayed.periods:
                break
        writer.close()
