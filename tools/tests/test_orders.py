"""Orders of the electrical turn, on signals whose orders are known because they were put there."""

import numpy as np
import pytest
from evenspin.analysis import order_amplitudes, order_spectrum, whole_turns

TAU = 2.0 * np.pi


def turning(turns: float, samples: int = 4000) -> np.ndarray:
    """An angle that grows evenly."""
    return TAU * turns * np.arange(samples) / samples


@pytest.mark.parametrize("turns", [7.0, 25.7, 3.3])
def test_amplitudes_are_found_whatever_the_number_of_turns(turns):
    theta = turning(turns)
    value = 20.0 + 1.5 * np.cos(theta - 0.7) + 0.25 * np.sin(2 * theta + 0.2) + 0.01 * np.cos(5 * theta)

    found = order_amplitudes(value, theta, (1, 2, 3, 5))

    assert found == pytest.approx([1.5, 0.25, 0.0, 0.01], abs=1e-9)


def test_amplitudes_are_those_of_the_angle_when_the_speed_wanders():
    even = turning(20.0)
    theta = even + 0.4 * np.sin(even)  # a rotor that hurries and waits
    value = 10.0 + 2.0 * np.cos(theta)

    assert order_amplitudes(value, theta) == pytest.approx([2.0, 0.0], abs=1e-9)
    assert order_amplitudes(value, even)[1] > 0.2  # over time the same ripple has a second order


def test_a_wrapped_angle_gives_the_same_amplitudes():
    theta = turning(12.4)
    value = np.cos(theta) + 0.5 * np.cos(2 * theta)

    assert order_amplitudes(value, theta % TAU) == pytest.approx(order_amplitudes(value, theta), abs=1e-9)


def test_backward_rotation_gives_the_same_amplitudes():
    theta = -turning(12.4)
    value = -30.0 + 0.3 * np.cos(theta + 1.0)

    assert order_amplitudes(value, theta) == pytest.approx([0.3, 0.0], abs=1e-9)


def test_a_rotor_that_stands_has_no_orders():
    assert np.isnan(order_amplitudes(np.ones(100), np.linspace(0.0, 1.0, 100))).all()


def test_the_spectrum_has_its_lines_where_and_as_high_as_they_are():
    theta = turning(19.6, 8000)
    value = 5.0 + 0.8 * np.cos(theta) + 0.05 * np.sin(6 * theta)

    order, amplitude = order_spectrum(value, theta, max_order=8.0)

    at = [int(np.argmin(np.abs(order - k))) for k in (1, 6, 3)]
    assert amplitude[at] == pytest.approx([0.8, 0.05, 0.0], abs=2e-3)
    assert order[-1] <= 8.0


def test_the_spectrum_shows_lines_between_the_orders():
    theta = turning(20.0, 8000)
    value = np.cos(2.5 * theta)

    order, amplitude = order_spectrum(value, theta)

    assert order[np.argmax(amplitude)] == pytest.approx(2.5, abs=1 / 19)  # a line


def test_whole_turns_are_the_end_of_the_window():
    theta = turning(4.5, 9000)

    part = whole_turns(theta)

    assert part.stop == 9000
    assert theta[-1] - theta[part.start] == pytest.approx(4 * TAU, abs=TAU * 4.5 / 9000)


def test_less_than_a_turn_has_no_whole_turns():
    assert whole_turns(turning(0.8)) == slice(0, 0)
