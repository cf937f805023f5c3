"""A log file that is too large, damaged or no table is one line, and costs neither memory nor time."""

from __future__ import annotations

import gzip
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest
from evenspin.balance.log_reader import read_log
from evenspin.errors import InputError
from evenspin.log import read_csv
from evenspin.log.textfile import MOST_BYTES, line_blocks, read_text
from said import Said

NAMES, UNITS = ("t_s", "iq_a"), ("s", "A")
Evenspin = Callable[..., Said]


def test_a_small_file_that_unpacks_to_a_large_one_is_refused_at_the_limit(tmp_path: Path) -> None:
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(b"t_s,iq_a\n" + b"0,0\n" * 10_000_000))  # 40 MB of 39 kB
    tracemalloc.start()

    with pytest.raises(InputError, match="size = 'more than 2 MB unpacked': must be at most 2 MB"):
        read_text(path, most_bytes=2_000_000)

    assert tracemalloc.get_traced_memory()[1] < 12_000_000  # the limit, one block more, and the text while it grows
    tracemalloc.stop()


def test_the_limit_is_that_of_the_documentation_and_an_honest_log_is_below_it(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "log-format.md").read_text()
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(b"t_s,iq_a\n" + b"0.001,0.5\n" * 300_000, 1))

    assert f"A log may have {MOST_BYTES / 1e6:g} MB" in page
    assert MOST_BYTES > 100e6  # a log of an hour
    assert len(read_csv(path, NAMES, UNITS)) == 300_000


@pytest.mark.parametrize("read", [lambda path: read_csv(path, NAMES, UNITS), read_log])
def test_a_damaged_block_of_a_compressed_file_is_one_line(tmp_path: Path, read: Callable[[Path], object]) -> None:
    raw = bytearray(gzip.compress(b"t_s,iq_a\n" + b"".join(b"%d,%d\n" % (i, i * i) for i in range(20_000))))
    raw[10] |= 0b110  # behind the header of ten bytes: a first block of type 3, which there is not
    with pytest.raises(zlib.error):
        gzip.decompress(bytes(raw))  # what it is that is damaged
    path = tmp_path / "log.csv.gz"
    path.write_bytes(raw)

    with pytest.raises(InputError, match="must be an undamaged .gz file; copy it again"):
        read(path)


def test_lines_come_in_blocks_with_their_numbers_and_none_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("evenspin.log.textfile.LINES_BLOCK", 10)
    text = "header\n" + "\n".join(f"line {i}" for i in range(2, 30))

    found = [(first + i, line) for first, block in line_blocks(text, 7, 2) for i, line in enumerate(block)]

    assert found == [(i, f"line {i}") for i in range(2, 30)]


def test_a_wrong_cell_far_down_is_named_with_its_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("evenspin.log.textfile.LINES_BLOCK", 100)
    path = tmp_path / "log.csv"
    path.write_text("t_s,iq_a\n" + "".join(f"{i},0.5\n" for i in range(500)) + "500,x\n")

    with pytest.raises(InputError, match=r"log.csv:502: iq_a = 'x'"):
        read_csv(path, NAMES, UNITS)


def test_a_column_twice_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t_s,iq_a,iq_a\n0,1,2\n")

    with pytest.raises(InputError, match="in the header once"):
        read_csv(path, NAMES, UNITS)


@pytest.mark.parametrize("word", ["case", "loop", "batch"])
def test_a_folder_that_is_called_like_a_command_is_given_with_a_dot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, evenspin: Evenspin, word: str
) -> None:
    (tmp_path / word).mkdir()
    monkeypatch.chdir(tmp_path)

    said = evenspin("gap", word, "--out", "out")

    assert said.status == 2
    assert f"./{word}" in said.err
    assert len(said.err.strip().splitlines()) == 1


def test_a_path_that_is_not_there_is_told_as_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, evenspin: Evenspin
) -> None:
    monkeypatch.chdir(tmp_path)

    said = evenspin("gap", "lop", "--out", "out")

    assert said.status == 2
    assert said.err.strip() == "gap: CASE_DIR|LOG = 'lop': must be an existing folder or file; did you mean loop?"
