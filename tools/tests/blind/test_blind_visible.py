"""How strongly an effect shows in a log: known answers of the measure, and how the page counts with it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from evenspin.blind import bench_drives, log_visible
from evenspin.blind.bench_profile import draw_inputs
from evenspin.blind.log_page import page
from evenspin.blind.log_score import LogScore, Run, score_log, summary_of
from evenspin.blind.log_visible import Bench, Tolerance, tolerances_of, visible
from evenspin.blind.logs import LogTruth
from evenspin.blind.referee import Parameters, with_effects

SIGNALS = ("t_s", "theta_rad", "speed_rad_s", "iq_a", "id_a")
RATE_HZ = 1000.0


def test_a_known_difference_in_white_noise_shows_by_the_root_of_its_energy() -> None:
    """A sine of amplitude 0.1 in noise of 1 over 20000 rows: root of 20000 * 0.1^2 / 2 = 10 standard deviations."""
    rng = np.random.default_rng(1)
    sine = 0.1 * np.sin(2.0 * np.pi * 0.053 * np.arange(20000))[None, :]

    white = log_visible._whitening(rng.standard_normal((1, 20000)), 500)(sine)

    assert np.linalg.norm(white) == pytest.approx(10.0, rel=0.1)  # the noise at this frequency is known to 10 %


def test_what_a_unit_may_do_is_taken_off_as_far_as_it_may_go() -> None:
    """The effect is 3 along the one way in which a unit differs, and 4 across it; the unit may go 2."""
    shape = np.array([[3.0, 4.0], [1.0, 0.0]])
    way = Tolerance("inertia", lambda p, share: p, -2.0, 2.0)

    assert log_visible._left(shape @ shape.T, [way])[0] == pytest.approx(math.hypot(1.0, 4.0), rel=1e-6)
    assert log_visible._left(shape @ shape.T, [way], "inertia")[0] == pytest.approx(4.0, rel=1e-6)


@pytest.fixture(scope="module")
def healthy() -> tuple[bench_drives.Drive, Parameters, Parameters]:
    rng = np.random.default_rng(7)
    drive = bench_drives.draw_drive(rng)
    nominal = bench_drives.nominal_of(drive) | {"run.seed": 3.0}
    return drive, nominal, bench_drives.draw_bench_unit(rng, drive, nominal)


def shown(healthy: tuple, effects: dict, voltages: bool) -> tuple[float, dict[str, float]]:
    drive, nominal, unit = healthy
    inputs = draw_inputs(np.random.default_rng(8), drive, 12.0, 0.0)
    bench = Bench(unit, drive.meta["pwm_hz"], round(drive.meta["pwm_hz"] / RATE_HZ), SIGNALS, voltages)
    hidden = with_effects(unit, effects)
    (name,) = effects
    sizes, alike = visible(
        bench, unit, (hidden, inputs), {name: (unit, inputs)}, tolerances_of(drive, nominal, unit), RATE_HZ
    )
    return sizes[name], alike[name]


def test_a_resistance_shows_with_voltages_alone_and_only_beyond_its_tolerance(healthy: tuple) -> None:
    size, _ = shown(healthy, {"winding_resistance": {"factor": 1.8}}, True)
    dark, _ = shown(healthy, {"winding_resistance": {"factor": 1.8}}, False)
    ratio = healthy[2]["motor.resistance_ohm"] / healthy[1]["motor.resistance_ohm"]
    within, _ = shown(healthy, {"winding_resistance": {"factor": 1.02 / ratio}}, True)

    assert size > 3.0 * log_visible.SEEN
    assert dark < 0.5 * log_visible.SEEN
    assert within < 0.5 * log_visible.SEEN


def test_without_voltages_a_wrong_zero_is_alike_to_a_weaker_magnet(healthy: tuple) -> None:
    wrong = {"encoder_offset": {"angle_el_rad": 0.4}}
    size, alike = shown(healthy, wrong, False)
    lit, apart = shown(healthy, wrong, True)

    assert min(size, lit) > 3.0 * log_visible.SEEN
    assert "torque_constant" in alike
    assert not apart


def score(kind: str, shown_by: dict[str, float], said: list[str], voltage: str = "dq") -> LogScore:
    effects = {"cogging": {"order": 24.0}} if kind == "single" else {}
    outside = {} if effects else {"fan_load": {"torque_nm_s2": 1e-3}}
    drive = {"other.angle_delay_s": 0.0, "other.most_torque_per_ampere": 0.0, "other.speed_by_difference": 1.0}
    truth = LogTruth("a", kind, "small", effects, outside, "vesc", 500.0, 60.0, 9, voltage, False, 0.5, drive)
    return score_log("log", replace(truth, shown=shown_by), Run(1.0, 0, ""), {"verdict": said})


def test_rows_of_the_logs_that_show_the_effect_stand_beside_those_of_all() -> None:
    scores = [
        score("single", {"cogging": 25.0}, ["cogging"]),
        score("single", {"cogging": 0.8}, []),
        score("single", {"cogging": 31.0}, [], ""),
        score("outside", {"fan_load": 9.0}, ["unknown"]),
        score("outside", {"fan_load": 2.0}, []),
    ]

    summary = summary_of(scores)
    text = page(scores, "1")

    assert (summary["exact_single"], summary["shown_single"]) == (0.5, 1.0)
    assert summary["shown_single_torque_only"] == 0.0
    assert (summary["unknown_on_outside"], summary["shown_outside"]) == (0.5, 1.0)
    assert "none (2 logs: 0.8, 31 sigma)" in text
    assert math.isnan(summary["shown_pair"])
