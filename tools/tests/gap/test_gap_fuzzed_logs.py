"""Whatever happens to the files of a case or to a log, the answer is work that is done or one line; never a traceback.

FUZZ_TRIALS and FUZZ_SEED draw more of them: `make fuzz-logs`.
"""

from __future__ import annotations

import functools
import gzip
import json
import os
import random
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from evenspin.balance import run_balance
from evenspin.balance.log_reader import read_log
from evenspin.compare import case_gap
from evenspin.errors import EvenspinError
from evenspin.gap.check import checked_case
from evenspin.identify.source import read_runs

CASE = Path(__file__).parents[3] / "tests" / "data" / "foreign_drive" / "example_clean"
NAMES = ("load_step", "validation_steps")
ROWS = 1200
TRIALS, SEED = int(os.environ.get("FUZZ_TRIALS", "60")), int(os.environ.get("FUZZ_SEED", "1"))
MOST_S = 20.0  # of one trial, on a machine that is busy with others
WORDS = (
    "many", "", "nan", "inf", "-inf", "1e308", "-1e308", "1e400", "1e-320", "0", "-0.0", "1,2", "0x10", "1_000", "\x00",
    "\ufeff", "true", "null", "-1", "1e12", "9" * 400, "\u0661", " ", "--", "1e", "\r", ";",
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 0.5, 1e-300, 1e300, 1e9, 10**400, -(10**400), "many", "", [], {}, [1], {"a": 1},
    float("nan"), float("inf"), "3", "dc_link_v/sqrt(3)", 2.5, 7, 1e-3, 60,
)  # fmt: skip
Rows = list[list[str]]


@functools.cache
def rows_of(name: str) -> tuple[tuple[str, ...], ...]:
    with gzip.open(CASE / f"{name}.csv.gz", "rt") as file:
        return tuple(tuple(line.strip().split(",")) for _, line in zip(range(ROWS + 1), file, strict=False))


def mutated_table(rng: random.Random, table: Rows) -> Rows:
    """One thing done to the cells."""
    columns, at = len(table[0]), rng.randrange(len(table[0]))
    body = table[1:]
    what = rng.randrange(9)
    if what == 0:
        for row in rng.sample(body, rng.choice((1, 3, 100, len(body)))):
            row[at] = rng.choice(WORDS)
    elif what == 1:
        factor = rng.choice((0.0, -1.0, 1e3, 1e-3, 9.549, 57.3, 1e9, 1e30))
        for row in body:
            row[at] = f"{factor * float(row[at]):.9g}"
    elif what == 2:
        other = rng.randrange(columns)
        for row in body:
            row[at], row[other] = row[other], row[at]
    elif what == 3:
        start = rng.randrange(len(body))
        for row in body[start:]:
            row[at] = body[start][at]
    elif what == 4:
        rng.shuffle(body)
    elif what == 5:
        body = body[: rng.choice((0, 1, 2, 3, 30, 210, 600))]
    elif what == 6:
        table[0][at] = rng.choice((*table[0], *WORDS))
    elif what == 7:
        body = [row[:at] + row[at + 1 :] for row in body]
    else:
        del body[rng.randrange(len(body)) : rng.randrange(len(body) + 1)]
    return [table[0], *body]


def mutated_bytes(rng: random.Random, raw: bytes) -> bytes:
    """One thing done to the file."""
    at = rng.randrange(len(raw))
    what = rng.randrange(6)
    if what == 0:
        return raw[:at]
    if what == 1:
        return raw[:at] + bytes(rng.randrange(256) for _ in range(20)) + raw[at + 20 :]
    if what == 2:
        return raw[:at] + raw[at + 100 :]
    if what == 3:
        return raw[at:] + raw[:at]
    return raw


def mutated_meta(rng: random.Random, meta: dict[str, Any]) -> None:
    """One thing done to a value or a key, at any depth."""
    place: Any = meta
    while True:
        key = rng.choice(list(place))
        if not isinstance(place[key], dict) or not place[key] or rng.random() < 0.1:
            break
        place = place[key]
    if rng.random() < 0.2:
        del place[key]
    else:
        place[key] = rng.choice(VALUES)


def written(rng: random.Random, folder: Path) -> None:
    """A case with one to three things done to it."""
    meta = json.loads((CASE / "meta.json").read_text()) | {"experiments": list(NAMES)}
    tables = {name: [list(row) for row in rows_of(name)] for name in NAMES}
    raws: dict[str, Callable[[bytes], bytes]] = {}
    for _ in range(rng.randint(1, 3)):
        kind, name = rng.choice(("meta", "meta", "table", "table", "bytes")), rng.choice(NAMES)
        if kind == "meta" and meta:
            mutated_meta(rng, meta)
        elif kind == "table" and len(tables[name]) > 1 and len(tables[name][1]) == len(tables[name][0]):
            try:
                tables[name] = mutated_table(rng, tables[name])
            except ValueError:  # a cell that an earlier change has made a word
                continue
        else:
            raws[name] = functools.partial(mutated_bytes, rng)
    (folder / "meta.json").write_text(json.dumps(meta))
    for name, table in tables.items():
        raw = "\n".join(",".join(row) for row in table).encode() + b"\n"
        change = raws.get(name, lambda x: x)
        if rng.random() < 0.5:
            (folder / f"{name}.csv.gz").write_bytes(change(gzip.compress(raw, 1)))
        else:
            (folder / f"{name}.csv").write_bytes(change(raw))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("trial", range(TRIALS))
def test_every_way_of_reading_a_broken_log_ends_in_work_or_in_one_line(tmp_path: Path, trial: int) -> None:
    rng = random.Random(1000 * SEED + trial)
    written(rng, tmp_path)
    log = next((path for path in sorted(tmp_path.glob("*.csv*"))), tmp_path / "meta.json")
    ways: tuple[Callable[[], Any], ...] = (
        lambda: checked_case(tmp_path),
        lambda: case_gap(tmp_path),
        lambda: read_runs([tmp_path]),
        lambda: read_runs([log]),
        lambda: read_log(log),
    )
    for way in ways if trial % 12 else (*ways, lambda: run_balance(log, None, None)):
        start = time.monotonic()
        try:
            way()
        except EvenspinError as error:
            assert error.exit_code in (1, 2)
            assert len(str(error).splitlines()) == 1
        assert time.monotonic() - start < MOST_S
