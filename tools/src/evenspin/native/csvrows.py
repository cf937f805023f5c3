"""Numbers as rows of a CSV file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.native.library import load


def csv_rows(values: NDArray[np.floating[Any]]) -> bytes:
    """A table, a row per line, each number as `"%.9g"` writes it, and 0 without a sign."""
    library = load()
    table = np.ascontiguousarray(values, dtype=np.float64)
    room = table.size * library.lib.ES_CSV_CELL
    out = library.ffi.new("char[]", max(1, room))
    numbers = library.ffi.from_buffer("double[]", table)
    written = library.lib.es_csv_rows(numbers, len(table), table.shape[1], out, room)
    return bytes(library.ffi.buffer(out, written))
