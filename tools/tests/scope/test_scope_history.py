"""The rows of the last minutes: nothing is lost without being seen, and nobody waits."""

from __future__ import annotations

import numpy as np
from evenspin.scope.history import History, Rows, reduce_rows


def rows(first: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    t_s = np.arange(first, first + count) / 1000.0
    return t_s, np.column_stack((t_s, -t_s)).astype(np.float32)


def test_a_reader_gets_every_row_once_however_they_came() -> None:
    history, cursor, seen = History(("a", "b"), capacity=100), 0, []
    for first in range(0, 300, 30):
        history.append(*rows(first, 30))
        cursor, new = history.since(cursor)
        seen.append(new)

    t_s = np.concatenate([part.t_s for part in seen])
    np.testing.assert_array_equal(t_s, np.arange(300) / 1000.0)
    np.testing.assert_array_equal(np.concatenate([part.values for part in seen])[:, 1], -t_s.astype(np.float32))


def test_a_reader_that_was_away_gets_what_the_ring_still_holds() -> None:
    history = History(("a", "b"), capacity=100)
    history.append(*rows(0, 70))
    history.append(*rows(70, 80))

    cursor, found = history.since(10)

    assert (cursor, len(found)) == (150, 100)
    np.testing.assert_array_equal(found.t_s, np.arange(50, 150) / 1000.0)


def test_lost_rows_are_a_row_of_nan_for_the_plot_and_left_out_of_the_last_seconds() -> None:
    history = History(("a", "b"), capacity=100)
    history.append(*rows(0, 10))
    history.append(*rows(20, 10), gap_before=True)

    _, found = history.since(0)
    assert len(found) == 21
    assert np.flatnonzero(np.isnan(found.values[:, 0])).tolist() == [10]
    np.testing.assert_array_equal(history.last(0.012).t_s * 1000.0, [17 + k for k in range(3, 13)])


def test_reducing_keeps_every_peak_and_bounds_the_rows() -> None:
    t_s = np.arange(10_000) / 1000.0
    values = np.random.default_rng(1).normal(size=(10_000, 2)).astype(np.float32)
    values[1234, 0], values[8765, 1] = 50.0, -60.0

    found = reduce_rows(Rows(t_s, values), 100)

    assert (len(found), found.reduced) == (200, True)
    assert found.values.max() == 50.0
    assert found.values.min() == -60.0
    assert abs(found.t_s[np.argmax(found.values[:, 0])] - 1.234) <= 0.1  # one stretch of 10 s / 100
    assert (np.diff(found.t_s) > 0.0).all()


def test_few_rows_stay_as_they_are() -> None:
    few = Rows(*rows(0, 200))
    assert reduce_rows(few, 100) is few
    assert reduce_rows(Rows(*rows(0, 201)), 100).reduced
