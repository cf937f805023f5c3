"""Backlash in a log of any drive: two bodies with a gap between them, integrated here, under a speed controller."""

from __future__ import annotations

import functools
from types import SimpleNamespace

import numpy as np
import pytest
from driven_logs import write_log
from evenspin.driven import open_gap, run_driven
from evenspin.driven.judge import Verdict
from evenspin.driven.open_gap import OpenGap, name_backlash
from evenspin.weakform.windows import Bump

INERTIA_KGM2, NM_PER_A = 1.9e-3, 1.5 * 3 * 0.11  # as in MODEL
MODEL = f"""
name = "two bodies"
[plant]
pole_pairs = 3
psi_wb = 0.11
inertia_kgm2 = {INERTIA_KGM2}
viscous_nms = 4e-4
resistance_ohm = 1.0
ld_h = 3e-3
lq_h = 3e-3
dc_link_v = 300.0
counts_per_rev = 16384
rated_current_a = 6.0
rated_torque_nm = 2.9
"""
STEP_S, ROWS_S, SECONDS = 1e-4, 1e-3, 40.0


@functools.cache
def log_of(gap_rad: float, load_ratio: float = 0.5, f_res_hz: float = 120.0, bursts: bool = False):
    """Speeds up and down in both directions. The gap is 0: one body. `bursts`: torque on the rotor for 20 ms each."""
    rng = np.random.default_rng(5)
    knots = np.cumsum(rng.uniform(0.7, 1.3, 60))
    levels = np.where(np.arange(60) % 2, -1.0, 1.0) * rng.uniform(20.0, 90.0, 60)
    t_s = np.arange(round(SECONDS / STEP_S)) * STEP_S
    corners = np.column_stack((knots[:-1] + 0.2, knots[1:])).ravel()  # each level is reached within 0.2 s
    wanted = np.interp(t_s, [0.0, *corners], [0.0, *np.repeat(levels[:-1], 2)])
    extra = np.where(bursts & (t_s % 0.37 < 0.02), 0.6, 0.0)
    rotor_j, load_j = INERTIA_KGM2 * (1.0 - load_ratio), INERTIA_KGM2 * load_ratio
    if gap_rad == 0.0:
        rotor_j, load_j = INERTIA_KGM2, 1.0
    rate = 2.0 * np.pi * f_res_hz
    spring = rate * rate * rotor_j * load_j / (rotor_j + load_j) if gap_rad > 0.0 else 0.0
    damper = 0.15 * spring / rate if gap_rad > 0.0 else 0.0
    half, kp, ki = 0.5 * gap_rad, 0.15, 1.5
    rotor = load = rotor_speed = load_speed = summed = 0.0
    out = []
    for k, (speed, more) in enumerate(zip(wanted.tolist(), extra.tolist(), strict=True)):
        off = speed - rotor_speed
        summed += ki * off * STEP_S
        torque = kp * off + summed
        twist = rotor - load
        pressed = twist - half if twist > half else twist + half if twist < -half else 0.0
        passed = spring * pressed + damper * (rotor_speed - load_speed) if pressed else 0.0
        if passed * pressed < 0.0:  # a flank pushes and never pulls
            passed = 0.0
        if k % round(ROWS_S / STEP_S) == 0:
            out.append((rotor, torque))
        rotor_speed += STEP_S * (torque + more - passed - 4e-4 * rotor_speed) / rotor_j
        load_speed += STEP_S * passed / load_j
        rotor += STEP_S * rotor_speed
        load += STEP_S * load_speed
    rotor_rad, torque_nm = np.array(out).T
    count_rad = 2.0 * np.pi / 16384
    return {
        "t_s": ROWS_S * np.arange(len(rotor_rad)),
        "theta_m_rad": np.round(rotor_rad / count_rad) * count_rad,
        "iq_a": torque_nm / NM_PER_A + 0.01 * rng.standard_normal(len(rotor_rad)),
        "id_a": 0.01 * rng.standard_normal(len(rotor_rad)),
    }


def verdict_of(folder, columns):
    model = folder / "model.toml"
    model.write_text(MODEL, encoding="utf-8")
    return run_driven([write_log(folder / "log.csv", columns)], model, "bench", None).verdict


@pytest.mark.usefixtures("by_the_table")
@pytest.mark.parametrize(("gap_rad", "load_ratio"), [(0.03, 0.65)])
def test_a_load_that_is_missing_time_and_again_is_behind_backlash(gap_rad, load_ratio, tmp_path):
    verdict = verdict_of(tmp_path, log_of(gap_rad, load_ratio))
    assert verdict["verdict"] == ["backlash"]
    assert verdict["can_be_found"]["backlash"]["times_least_size"] == 1.0
    for name, true in (("load_ratio", load_ratio), ("gap_rad", gap_rad)):
        interval = verdict["intervals"]["backlash"][name]
        assert interval["low"] <= true <= interval["high"], name


@pytest.mark.usefixtures("by_the_table")
@pytest.mark.parametrize("bursts", [True])
def test_one_body_has_no_backlash_also_where_something_pushes_it(bursts, tmp_path):
    verdict = verdict_of(tmp_path, log_of(0.0, bursts=bursts))
    assert verdict["verdict"] == ["unknown"]
    assert "times in 40 s the torque is off for a moment" in " ".join(verdict["unexplained"])
    assert verdict["can_be_found"]["backlash"]["times_least_size"] != 1.0


def test_beside_a_cause_that_no_table_has_backlash_is_a_remark():
    opened = OpenGap(0.4, 0.02, 0.01, 0.6, 50, 20)
    verdict = Verdict(["inertia", "unknown"], [("inertia", {"factor": 0.4})])  # without its load, now and then
    verdict.confidence["inertia"] = 0.95
    name_backlash(verdict, opened)
    assert verdict.names == ["unknown"] and verdict.nearest == ["backlash"]
    assert not verdict.effects and not verdict.confidence
    assert "share of about 0.40 of the inertia" in verdict.unexplained[0]


def test_backlash_takes_the_place_of_a_shaft_that_twists():
    verdict = Verdict(["two_mass", "cogging"], [("two_mass", {"f_res_hz": 80.0}), ("cogging", {"order": 18.0})])
    verdict.called["two_mass"] = "two_mass or backlash"
    verdict.confidence |= {"two_mass": 0.8, "cogging": 0.9}
    name_backlash(verdict, OpenGap(0.4, 0.02, 0.01, 0.6, 50, 20))
    assert verdict.names == ["cogging", "backlash"]
    assert [name for name, _ in verdict.effects] == ["cogging", "backlash"]
    assert set(verdict.confidence) == {"cogging", "backlash"} and "two_mass" not in verdict.called


def test_crossings_that_no_gap_explains_are_a_remark_and_no_name():
    verdict = Verdict(["two_mass"], [("two_mass", {"f_res_hz": 80.0})])
    name_backlash(verdict, OpenGap(0.4, 0.02, 0.01, 1.05, 50, 20))
    assert verdict.names == ["two_mass"]
    assert "or a shaft that twists" in verdict.warnings[0]


@pytest.mark.parametrize(("counts_per_row", "doubted"), [(2.0, True), (2.003, True), (2.31, False), (7.618, False)])
def test_where_a_row_has_a_whole_number_of_counts_rounding_looks_like_a_torque(counts_per_row, doubted):
    """Shafts that run evenly or speed up slowly, rounded: what that leaves of a torque, and what is doubted."""
    bump, rng, scale = Bump.of(3e-3, 1.25e-4), np.random.default_rng(6), 0.0046 * 2.0 * np.pi / 4096
    row = np.arange(-bump.rows, bump.rows + 1)
    within = slice(bump.rows - bump.half, bump.rows + bump.half + 1)
    left, least = [], []
    for _ in range(300):
        counts = rng.uniform(0.0, 1.0) + counts_per_row * row + rng.uniform(0.0, 5e-4) * row**2
        left.append(scale * abs(float((np.round(counts) - counts)[within] @ bump.curve)))
        signals = SimpleNamespace(theta_m_rad=np.round(counts) * 2.0 * np.pi / 4096)
        log = SimpleNamespace(fine=SimpleNamespace(bump=bump), signals=signals, plant={"counts_per_rev": 4096.0})
        rounding = open_gap._rounding(log, 0.0046, np.array([bump.rows]))[0]
        least.append(open_gap.BY_ROUNDING * rounding)
    if doubted:
        assert np.mean(np.array(left) > np.array(least)) < 0.15
        assert max(left) > 2.0
    else:
        assert max(left) < 0.45 and max(least) < 0.25


def test_an_angle_without_counts_is_not_rounded():
    log = SimpleNamespace(
        fine=SimpleNamespace(bump=Bump.of(3e-3, 1.25e-4)),
        signals=SimpleNamespace(theta_m_rad=np.arange(100.0)),
        plant={"counts_per_rev": 0.0},
    )
    assert open_gap._rounding(log, 0.0046, np.array([50]))[0] == 0.0


@pytest.mark.parametrize(("others", "found"), [(0, True), (1, True), (8, False)])
def test_few_crossings_are_enough_where_all_of_them_show_one_share(others, found, monkeypatch):
    """14 windows with a share of about 0.6 of the inertia, and others with any share."""
    rng = np.random.default_rng(3)
    share = np.r_[0.6 + 0.03 * rng.standard_normal(14), rng.uniform(0.05, 0.4, others), np.full(6, 1.5)]
    seen = SimpleNamespace(share=share, crossings=lambda ratio: 10)
    monkeypatch.setattr(open_gap, "_opened", lambda _, log: seen)
    monkeypatch.setattr(open_gap, "_width", lambda *_: (0.02, 0.01, 0.6))

    opened = open_gap.open_gap(SimpleNamespace(recordings=[None]))

    assert (opened is not None) == found
    if opened is not None:
        assert opened.load_ratio == pytest.approx(0.6, abs=0.03)


@pytest.mark.parametrize(("left", "found"), [(0.6, True), (1.08, True), (1.23, False)])
def test_pushes_that_every_gap_describes_worse_than_none_are_no_crossings(left, found, monkeypatch):
    seen = SimpleNamespace(share=np.full(30, 0.6), crossings=lambda ratio: 30)
    monkeypatch.setattr(open_gap, "_opened", lambda _, log: seen)
    monkeypatch.setattr(open_gap, "_width", lambda *_: (0.02, 0.01, left))

    assert (open_gap.open_gap(SimpleNamespace(recordings=[None])) is not None) == found
