"""Noise of the sensors: how much of it a log has, and that too much of it in a column turns no effect round."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evenspin.effects import Scale
from evenspin.model.machine import find_model, load_machine
from evenspin.weakform import analysis
from evenspin.weakform.analysis import explain
from evenspin.weakform.fit import Piece
from evenspin.weakform.noise import scatter
from evenspin.weakform.screen import left_of
from evenspin.weakform.signals import Signals, signals_of
from evenspin.weakform.tolerances import tolerances_of


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


def _unloaded(noise_a: float) -> tuple[Signals, dict[str, float]]:
    """Speeds both ways without a load, so that the current is hardly more than its noise: the equations, exactly."""
    plant = dict(load_machine(find_model("servo", Path(), lambda must, hint: AssertionError(must))).plant)
    rng = np.random.default_rng(4)
    t_s = np.arange(30000) / 500.0
    levels = rng.uniform(20.0, 70.0, 41) * np.where(np.arange(41) % 2, -1.0, 1.0)
    knots = np.cumsum(np.r_[0.0, np.tile([0.5, 1.0], 40)])
    speed = np.interp(t_s, knots, np.repeat(levels, 2)[1:])
    theta = np.cumsum(speed) / 500.0
    faster = np.gradient(speed, t_s)
    iq = (plant["inertia_kgm2"] * faster + plant["viscous_nms"] * speed) / (1.5 * plant["pole_pairs"] * plant["psi_wb"])
    electrical = plant["pole_pairs"] * speed
    plant["current_noise_a"], plant["current_lsb_a"] = noise_a * np.sqrt(0.75), 0.0
    noise_d, noise_q = noise_a * rng.standard_normal((2, len(t_s)))
    columns = {
        "t_s": t_s,
        "theta_m_rad": theta,
        "id_a": noise_d,
        "iq_a": iq + noise_q,
        "vd_v": -electrical * plant["lq_h"] * iq,
        "vq_v": plant["resistance_ohm"] * iq + plant["lq_h"] * np.gradient(iq, t_s) + electrical * plant["psi_wb"],
    }
    columns["vd_v"] = columns["vd_v"] - 30.0 * noise_d  # what a controller answers
    columns["vq_v"] = columns["vq_v"] - 30.0 * noise_q
    return signals_of("log", columns), plant


def test_noise_of_the_current_makes_no_magnet_weaker():
    """A flux that is too small makes the whole balance of torque smaller, noise of the current above all."""
    signals, plant = _unloaded(0.05)
    scale = Scale(plant["rated_current_a"], plant["rated_torque_nm"], int(plant["pole_pairs"]), 0, 0.0)

    found = explain([signals], plant, [], scale, tolerances_of("bench"))

    assert found.named == ()
    assert abs(found.point["torque_constant"][0]) < 0.004  # a standard deviation of its tolerance is 0.0075


@pytest.mark.parametrize("seen", [True, False])
def test_a_cause_that_unseen_stretches_do_not_show_is_left_out(seen, monkeypatch):
    """A voltage with the square of the speed is there; the stretches are once said to deny it."""
    signals, plant = _unloaded(0.01)
    electrical = plant["pole_pairs"] * signals.speed_rad_s
    more = 1.5 * np.sign(electrical) * (electrical / np.max(np.abs(electrical))) ** 2
    signals = replace(signals, vq_v=signals.vq_v + more)
    scale = Scale(plant["rated_current_a"], plant["rated_torque_nm"], int(plant["pole_pairs"]), 0, 0.0)
    if not seen:
        monkeypatch.setattr(analysis, "foreign_is_seen", lambda *_: False)

    found = explain([signals], plant, [], scale, tolerances_of("bench"))

    assert found.foreign == (["foreign: a voltage with the speed squared"] if seen else [])
