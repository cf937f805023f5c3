"""Lines where they were put: expected orders and amplitudes come from the signal that the test writes."""

from __future__ import annotations

import numpy as np
import pytest
from evenspin.scope.spectrum import lines_of

POLE_PAIRS = 4.0
SPEED_RAD_S = 30.0


@pytest.fixture
def record() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """5 s at 1 kHz: a speed of 30 rad/s with 0.5 rad/s in the 12th mechanical order."""
    t_s = np.arange(5000) / 1000.0
    angle = SPEED_RAD_S * t_s
    speed = SPEED_RAD_S + 0.5 * np.cos(12.0 * angle + 0.3)
    return t_s, {"theta_m_rad": (angle % (2.0 * np.pi)).astype(np.float32), "speed_rad_s": speed.astype(np.float32)}


@pytest.mark.parametrize(
    ("axis", "place"), [("electrical", 3.0), ("mechanical", 12.0), ("hz", 12.0 * SPEED_RAD_S / (2.0 * np.pi))]
)
def test_ripple_stands_at_its_order_with_its_amplitude(record, axis: str, place: float) -> None:
    lines = lines_of(*record, "speed_rad_s", axis, 24.0, POLE_PAIRS)

    top = int(np.argmax(lines.amplitude))
    assert lines.axis == axis
    assert lines.x[top] == pytest.approx(place, abs=0.2)  # a line of the resolution
    # Orders: whole turns, so only interpolation between samples is lost. Hertz: up to 1.4 dB between two lines of a
    # Hann window.
    assert 0.5 * 0.84 < lines.amplitude[top] < 0.505
    assert lines.mean == pytest.approx(SPEED_RAD_S, abs=0.01)
    far = np.abs(lines.x - lines.x[top]) > 2.0
    assert lines.amplitude[far].max() < 0.02 * 0.5


def test_without_the_angle_it_is_hertz_and_says_what_to_add(record) -> None:
    t_s, columns = record
    lines = lines_of(t_s, {"speed_rad_s": columns["speed_rad_s"]}, "speed_rad_s", "electrical", 24.0, POLE_PAIRS)

    assert lines.axis == "hz"
    assert "add theta_m_rad" in lines.note


def test_less_than_a_turn_has_no_lines_and_says_what_to_do(record) -> None:
    t_s, columns = record
    lines = lines_of(t_s, columns | {"theta_m_rad": 0.01 * t_s}, "speed_rad_s", "electrical", 24.0, POLE_PAIRS)

    assert len(lines.x) == 0
    assert "turn faster" in lines.note


def test_an_angle_that_is_sampled_too_slowly_is_not_believed(record) -> None:
    t_s, columns = record
    slow = {name: column[::40] for name, column in columns.items()}  # 1.2 rad mechanical, 4.8 electrical per row
    assert lines_of(t_s[::40], slow, "speed_rad_s", "electrical", 24.0, POLE_PAIRS).axis == "hz"
    assert lines_of(t_s[::40], slow, "speed_rad_s", "mechanical", 24.0, POLE_PAIRS).axis == "mechanical"


def test_a_gap_in_the_rows_spoils_no_line_in_hertz(record) -> None:
    t_s, columns = record
    keep = np.r_[0:1000, 1100:5000]
    cut = {name: column[keep] for name, column in columns.items()}
    lines = lines_of(t_s[keep], cut, "speed_rad_s", "hz", 24.0, POLE_PAIRS)
    assert len(lines.x) == 3900 // 2 + 1  # only what came after the gap
