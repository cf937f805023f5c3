"""The load behind a noisy torque sensor."""

import numpy as np
import pytest
from evenspin.compare.load import reading_noise, steady_load, steady_stretches

SIGMA_NM = 0.02


def steps(levels, rows=1000, rise=12, seed=3):
    """Levels that the load machine reaches within some samples, read with noise."""
    clean = np.concatenate([np.full(rows, float(level)) for level in levels])
    for k in range(1, len(levels)):
        clean[k * rows : k * rows + rise] = np.linspace(levels[k - 1], levels[k], rise)
    return clean, clean + np.random.default_rng(seed).normal(0.0, SIGMA_NM, len(clean))


def test_a_constant_load_comes_out_with_the_noise_of_its_mean():
    clean, reading = steps([0.7])

    load = steady_load(reading)

    assert np.ptp(load) == 0.0
    assert abs(load[0] - 0.7) < 4.0 * SIGMA_NM / np.sqrt(len(reading))
    assert len(clean) == len(load)


def test_levels_are_kept_apart_and_the_way_between_them_stays_as_read():
    clean, reading = steps([0.0, 1.1, -1.1, 0.0])

    load = steady_load(reading)

    on_the_way = slice(1000, 1012)
    assert np.array_equal(load[on_the_way], reading[on_the_way])
    for k, level in enumerate((0.0, 1.1, -1.1, 0.0)):
        middle = load[k * 1000 + 200 : k * 1000 + 900]
        assert np.ptp(middle) == 0.0
        assert abs(middle[0] - level) < 4.0 * SIGMA_NM / np.sqrt(700)


def test_a_load_that_never_stands_stays_as_read():
    t = np.linspace(0.0, 2.0, 4000)
    reading = np.sin(2.0 * np.pi * 3.0 * t) + np.random.default_rng(4).normal(0.0, SIGMA_NM, len(t))

    assert np.array_equal(steady_load(reading), reading)


def test_no_sensor_reads_as_no_load():
    assert np.array_equal(steady_load(np.full(500, np.nan)), np.zeros(500))


def test_a_load_without_noise_has_its_steps_found_all_the_same():
    clean, _ = steps([0.0, 1.0], rise=1)

    assert len(steady_stretches(clean)) == 2
    assert np.array_equal(steady_load(clean), clean)


def test_noise_stays_only_where_the_load_moves():
    _, reading = steps([0.0, 1.0])

    left = reading_noise(reading)

    assert left[500] == 0.0
    assert left[1005] == pytest.approx(SIGMA_NM, rel=0.1)  # a median of 2000 differences: 3 % one sigma


@pytest.mark.parametrize("rows", [0, 1, 3, 47])
def test_a_short_reading_is_returned_as_it_is(rows):
    reading = np.linspace(0.0, 1.0, rows)

    assert np.array_equal(steady_load(reading), reading)
