"""When two parts of a log have the same line over the angle, and how large a line has to be for a log to show it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy_drive as drive
import pytest
from evenspin.balance import run_balance
from evenspin.balance.line_agreement import DIFFERS, contradict, difference_p, in_one_only, part_of_line, same_line

ROWS = 2400
ANGLE = np.linspace(0.0, 120.0 * np.pi, ROWS)  # 60 turns
COLUMNS = np.column_stack((np.sin(3.0 * ANGLE), np.cos(3.0 * ANGLE)))
FIRST = np.arange(ROWS) < ROWS // 2
SIGMA_A = np.sqrt(2.0 / ROWS)  # of either coefficient of the whole, for white noise of 1 A


def line(amplitude: float, phase_rad: float = 0.0) -> np.ndarray:
    return amplitude * np.sin(3.0 * ANGLE + phase_rad)


def judged(y: np.ndarray) -> bool:
    joint = np.linalg.lstsq(COLUMNS, y, rcond=None)[0]
    return same_line(float(np.linalg.norm(joint)), *(part_of_line(COLUMNS, y, part) for part in (FIRST, ~FIRST)))


def accepted(rng: np.random.Generator, clean: np.ndarray, noise: np.ndarray | float = 1.0, runs: int = 200) -> float:
    return float(np.mean([judged(clean + noise * rng.normal(size=ROWS)) for _ in range(runs)]))


def test_a_difference_that_noise_explains_does_not_speak_against_a_line() -> None:
    """Six standard deviations, the least that is detected: one line in three has halves that differ by half of it."""
    assert accepted(np.random.default_rng(1), line(6.0 * SIGMA_A)) > 0.93


def test_a_line_that_changes_its_phase_is_not_the_same() -> None:
    moved = np.where(FIRST, line(15.0 * SIGMA_A), line(15.0 * SIGMA_A, 0.5 * np.pi))

    assert accepted(np.random.default_rng(2), moved) < 0.02


def test_a_line_that_ends_in_the_middle_is_not_the_same() -> None:
    assert accepted(np.random.default_rng(3), FIRST * line(15.0 * SIGMA_A)) < 0.02


def test_a_part_whose_noise_hides_the_line_does_not_confirm_it() -> None:
    """The parts do not contradict each other, and yet only one of them has seen it."""
    noise = np.where(FIRST, 1.0, 20.0)

    assert accepted(np.random.default_rng(4), FIRST * line(15.0 * SIGMA_A), noise) < 0.1


def test_a_small_difference_of_a_line_that_is_known_exactly_is_no_other_line() -> None:
    changed = np.where(FIRST, line(1.0), line(1.2))

    assert accepted(np.random.default_rng(5), changed, 1e-3, runs=20) == 1.0


def test_the_chance_of_a_difference_is_not_understated() -> None:
    """With white noise and one line, as many differences are below each chance as that says, or fewer."""
    rng = np.random.default_rng(6)
    chances = []
    for _ in range(400):
        y = line(0.5) + rng.normal(size=ROWS)
        chances.append(difference_p(*(part_of_line(COLUMNS, y, part) for part in (FIRST, ~FIRST))))

    assert np.mean(np.array(chances) < 0.1) < 0.13  # 400 draws of 0.1 scatter by 0.015
    assert np.mean(np.array(chances) < 0.1) > 0.02
    assert np.mean(np.array(chances) < DIFFERS) < 0.01


def contradicted(rng: np.random.Generator, clean: np.ndarray, noise_a: float = 0.0, runs: int = 100) -> float:
    """Share of draws in which the parts contradict each other about the line of the whole."""
    found = []
    for _ in range(runs):
        y = clean + rng.normal(size=ROWS)
        amplitude = float(np.linalg.norm(np.linalg.lstsq(COLUMNS, y, rcond=None)[0]))
        found.append(contradict(amplitude, *(part_of_line(COLUMNS, y, part, noise_a) for part in (FIRST, ~FIRST))))
    return float(np.mean(found))


def test_a_part_without_the_line_contradicts_the_one_that_has_it() -> None:
    assert contradicted(np.random.default_rng(7), FIRST * line(15.0 * SIGMA_A)) > 0.98
    assert contradicted(np.random.default_rng(8), line(15.0 * SIGMA_A)) == 0.0


def test_a_line_whose_phase_turns_with_the_speed_is_not_missing_anywhere() -> None:
    """By 45 degrees, as half a row of 0.5 ms does at order 60 and 50 rad/s.
    A part with a fifth of the line misses it.
    """
    turned, fifth = (np.where(FIRST, line(1.0), other) for other in (line(1.0, 0.25 * np.pi), line(0.2)))
    rng = np.random.default_rng(11)
    found = []
    for y in (turned, fifth):
        noisy = y + 0.1 * rng.normal(size=ROWS)
        parts = [part_of_line(COLUMNS, noisy, part) for part in (FIRST, ~FIRST)]
        found.append((contradict(1.0, *parts), in_one_only(1.0, *parts)))

    assert found == [(True, False), (True, True)]


def test_a_part_with_one_short_stretch_of_information_contradicts_nothing() -> None:
    """Ten rows decide what the first part says: the fit leaves almost nothing of them, so that the noise between the
    orders has to say how uncertain it is."""
    shown = np.where(~FIRST | (np.abs(np.arange(ROWS) - 600) < 5), 1.0, 1e-4)[:, None] * COLUMNS
    power = np.sum(shown**2)
    rng = np.random.default_rng(9)
    wrong = 0
    for _ in range(50):
        y = 15.0 * SIGMA_A * shown[:, 0] + rng.normal(size=ROWS)
        median_a = np.sqrt(2.0 / power) * np.sqrt(2.0 * np.log(2.0))  # of the amplitude that white noise makes
        wrong += contradict(15.0 * SIGMA_A, *(part_of_line(shown, y, part, median_a) for part in (FIRST, ~FIRST)))

    assert wrong <= 1


@pytest.mark.filterwarnings("error")
def test_a_part_without_rows_confirms_nothing_and_contradicts_nothing() -> None:
    y = line(1.0)
    parts = [part_of_line(COLUMNS, y, np.full(ROWS, value), SIGMA_A) for value in (False, True)]

    assert not same_line(1.0, *parts)
    assert not contradict(1.0, *parts)


def balance(folder: Path, machine: drive.Machine) -> dict[str, Any]:
    log = drive.write(folder / "log.csv", drive.run(machine))
    return run_balance(log, drive.model_file(folder / "model.toml", machine), None).verdict


def test_a_coarse_encoder_at_a_slow_level_shows_its_cogging(tmp_path: Path) -> None:
    """The beat of counts and rows makes the halves differ by half of the line; together it is known to 15 %."""
    machine = drive.drawn(1121)[1]

    verdict = balance(tmp_path, machine)

    assert drive.names_wrong(verdict, machine) == []
    assert verdict["parameters"]["cogging"]["amplitude_a_equiv"] == pytest.approx(machine.cogging_a, rel=0.2)


@pytest.mark.parametrize("cogging_a", [0.0, 0.04])
def test_a_frequency_at_one_speed_is_no_cogging_and_cogging_of_that_order_is(tmp_path: Path, cogging_a: float) -> None:
    """The second harmonic of the counts, sampled at 2 kHz, is 56 Hz at one of the six levels: order 66 there, and there
    only (2 x 8192 counts x 5.39 rad/s / (2 pi) = 14056 Hz)."""
    machine = replace(drive.drawn(1213)[1], order=66, cogging_a=cogging_a)

    verdict = balance(tmp_path, machine)

    assert drive.names_wrong(verdict, machine) == []
    if not cogging_a:
        why = next(row["why"] for row in verdict["evidence"] if row["effect"] == "cogging")
        assert "near one speed only" in why


def test_cogging_that_rocks_a_light_shaft_is_not_taken_for_a_smaller_inertia(tmp_path: Path) -> None:
    """The cogging accelerates this shaft, so that the acceleration alone takes up most of it."""
    machine = drive.drawn(1229)[1]
    log = drive.write(tmp_path / "log.csv", drive.run(machine))

    verdict = run_balance(log, None, None).verdict

    assert drive.names_wrong(verdict, machine) == []
    assert verdict["parameters"]["cogging"]["amplitude_a_equiv"] == pytest.approx(machine.cogging_a, rel=0.05)
    assert verdict["identified"]["inertia.inertia_as2_per_rad"]["value"] == pytest.approx(machine.inertia_as2, rel=0.05)


def test_a_line_is_named_beyond_the_detection_threshold_and_not_far_below_it(tmp_path: Path) -> None:
    plain = drive.Machine(duration_s=12.0, period_s=6.0, swing_rad_s=40.0, counts=2**12)
    bare = balance(tmp_path, plain)
    threshold = bare["line_detection_threshold"]
    order, least_a = threshold["largest_at_order"], threshold["largest_a_equiv"]
    assert least_a > 10.0 * threshold["smallest_a_equiv"]  # counts hide torque with the square of the frequency
    why = next(row["why"] for row in bare["evidence"] if row["effect"] == "cogging")
    assert f"to {1e3 * least_a:.1f} mA (order {order})" in why

    for share in (0.5, 2.0):
        machine = replace(plain, order=order, cogging_a=share * least_a)
        verdict = balance(tmp_path, machine)
        assert ("cogging" in verdict["verdict"]) is (share > 1.0)
        assert drive.names_wrong(verdict, machine) == ([] if share > 1.0 else ["missing: cogging"])
