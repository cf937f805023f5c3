"""Noise of the sensors: how much of it a log has, and that too much of it in a column turns no effect round."""

import numpy as np
import pytest
from evenspin.weakform.fit import Piece
from evenspin.weakform.noise import scatter
from evenspin.weakform.screen import left_of


@pytest.mark.parametrize("counts_per_row", [0.31, 1.31, 2.73, 7.19, 40.57])
def test_a_rounded_angle_scatters_by_no_more_than_a_count_over_root_twelve(counts_per_row):
    rows = np.arange(20000)
    theta = np.round(counts_per_row * rows + 1000.0 * np.sin(2.0 * np.pi * rows / 6000.0))
    # Even over a count; where a row moves by nearly a simple fraction of a count, errors of rounding repeat, and fourth
    # differences have up to a fifth more of them. The median of the rows alone is up to 1.9 times as much.
    assert 0.4 / np.sqrt(12.0) < scatter(theta) < 1.2 / np.sqrt(12.0)


def test_noise_is_measured_beside_disturbances_and_none_at_rest():
    rng = np.random.default_rng(1)
    signal = 0.2 * rng.standard_normal(20000)
    signal[9000:9200] += 50.0 * rng.standard_normal(200)
    # The rms of a block of 64 fourth differences scatters by some 15 %, its median over 312 blocks by 2 %.
    assert scatter(signal) == pytest.approx(0.2, rel=0.05)
    assert scatter(np.ones(1000)) == 0.0
    assert scatter(np.r_[np.zeros(15000), signal[:5000]]) < 0.01  # what creeps in a standing record is no white noise


@pytest.mark.parametrize("thought", [1.0, 1.5, 4.0])
def test_more_noise_than_a_column_has_turns_no_size_round(thought):
    rng = np.random.default_rng(2)
    true, other = rng.standard_normal((2, 4000))
    column = true + 0.8 * other + 0.7 * rng.standard_normal(4000)
    r = -0.4 * true + 0.05 * rng.standard_normal(4000)
    one = np.ones(4000, dtype=bool)
    piece = Piece(r, other[:, None], np.arange(4000) // 40, np.zeros(1), np.zeros(1), 0.05, 0)
    left = left_of([piece], [one], [1.0], 1e-6 * np.eye(1), np.zeros(1))
    gain, size = left.gain([column[:, None]], [(thought * 0.49, 0.0)])
    assert gain > 0.0
    assert 0.2 < size[0]
    if thought == 1.0:  # the noise that is there: without it, 1 / 1.49 of the size is found
        assert size[0] == pytest.approx(0.4, rel=0.05)
