"""Distortion of the stator current against what was added to a clean one."""

import numpy as np
import pytest
from evenspin.analysis import distortion_pct, space_vector

TAU = 2.0 * np.pi


@pytest.fixture
def theta() -> np.ndarray:
    return TAU * 11.3 * np.arange(20000) / 20000


def phases(theta: np.ndarray, amplitude: float = 4.0) -> list[np.ndarray]:
    return [amplitude * np.cos(theta - k * TAU / 3.0) for k in range(3)]


def test_balanced_phases_make_a_vector_of_their_amplitude(theta):
    assert np.abs(space_vector(*phases(theta))) == pytest.approx(4.0)


def test_a_clean_current_has_no_distortion(theta):
    assert distortion_pct(space_vector(*phases(theta)), theta) == pytest.approx(0.0, abs=1e-9)


def test_dc_counts_by_its_size(theta):
    assert distortion_pct(space_vector(*phases(theta)) + 0.2, theta) == pytest.approx(100 * 0.2 / 4.0, rel=2e-3)


def test_negative_sequence_counts_by_its_size(theta):
    current = space_vector(*phases(theta)) + 0.4 * np.exp(-1j * theta)

    assert distortion_pct(current, theta) == pytest.approx(10.0, rel=2e-3)


def test_parts_add_as_the_root_of_their_squares(theta):
    current = space_vector(*phases(theta)) + 0.3 * np.exp(-1j * theta) + 0.4j

    assert distortion_pct(current, theta) == pytest.approx(100 * 0.5 / 4.0, rel=2e-3)


def test_unequal_sensor_gains_leave_what_the_paper_derives(theta):
    """Sensors k_a = 1.1, k_b = 0.9 that read clean: the true negative sequence is |k_b - k_a| / sqrt(3) or so."""
    a, b, _ = phases(theta)
    true_a, true_b = a / 1.1, b / 0.9
    current = space_vector(true_a, true_b, -true_a - true_b)

    assert distortion_pct(current, theta) == pytest.approx(100 * 0.2 / np.sqrt(3.0), rel=0.05)


def test_no_current_has_no_distortion_to_state(theta):
    assert np.isnan(distortion_pct(np.zeros(len(theta), dtype=complex), theta))
