"""The library of terms: what each adds to the equations by an independent calculation, its lines, and its words."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from evenspin.empirical import words
from evenspin.empirical.effect import at_start, bounded, together
from evenspin.empirical.library import FAMILIES, can_show, family_of, sections, warm
from evenspin.empirical.lines import frequency_spectrum, order_spectra, peaks
from evenspin.empirical.rows import Rows
from evenspin.empirical.term import EmpiricalTerm, LookAlike
from evenspin.empirical.verdict import term_json
from evenspin.weakform.beyond_search import Candidate
from evenspin.weakform.evidence import _shape_halves


def rows_of(speed, period_s: float = 1e-3, **more) -> Rows:
    t = period_s * np.arange(len(speed))
    theta = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * period_s)))
    iq, one = np.sin(3.0 * t), np.ones(len(t))
    known = {"id_a": 0.3 * iq, "iq_a": iq, "torque_nm": 0.2 * iq, "vd_v": one, "vq_v": 2.0 * one, "vdc_v": 24.0 + iq}
    scales = {
        "pole_pairs": 4.0,
        "psi_wb": 0.01,
        "top_rad_s": 100.0,
        "rest_rad_s": 1.0,
        "rated_nm": 0.5,
        "rated_a": 2.0,
        "link_v": 24.0,
    }
    return Rows(t, theta, speed, **{**known, **scales, **more})


SWEEP = 80.0 * np.sin(2.0 * np.pi * np.arange(20000) / 10000.0)


def test_every_family_has_finite_columns_at_its_starts_and_stands_in_the_table_of_the_module() -> None:
    from evenspin.empirical import library

    rows = rows_of(SWEEP)
    for family in FAMILIES:
        assert family.name in (library.__doc__ or "")
        assert can_show(family, rows)
        shapes = family.starts(rows) or [(3.0, 1.0, 1.0)[: len(family.shape)]]
        for shape in shapes:
            for column in family.columns(rows, shape):
                parts = [column.torque, column.d, column.q, column.d_linkage, column.q_linkage]
                there = [x for x in parts if x is not None]
                assert there and all(np.all(np.isfinite(x)) and len(x) == len(rows.t_s) for x in there), family.name
    assert not can_show(family_of("supply_power"), replace(rows, vd_v=None))
    assert not can_show(family_of("angle_line"), replace(rows, has_angle=False))


def test_dahl_friction_is_that_of_its_differential_equation() -> None:
    """dz/dx = (1 - z sign(v)) / length, stepped row by row."""
    rows, length = rows_of(SWEEP), 0.7
    stepped, z = [], 0.0
    for moved in np.diff(rows.theta_rad, prepend=0.0):
        z = np.sign(moved) + (z - np.sign(moved)) * np.exp(-abs(moved) / length)
        stepped.append(z)
    (column,) = family_of("reversal").columns(rows, (length,))
    assert column.torque == pytest.approx(np.array(stepped), abs=0.02)  # rest has a width of half a rad/s
    assert [sign for _, _, sign in sections(rows)] == [1.0, -1.0, 1.0, -1.0]


def test_a_flux_that_falls_takes_the_same_power_from_shaft_and_winding() -> None:
    """Torque times speed lost at the shaft is voltage times current, 1.5 vq iq, that the winding does not induce."""
    rows = rows_of(SWEEP)
    lost, _ = family_of("time_magnet").columns(rows, (4.0,))
    assert lost.torque is not None and lost.q is not None
    assert lost.torque * rows.speed_rad_s == pytest.approx(-1.5 * lost.q * rows.iq_a)
    assert warm(rows, 4.0)[-1] == pytest.approx(1.0) and warm(rows, 4.0)[0] == 0.0


def test_cross_saturation_keeps_energy() -> None:
    """Power of the rotational voltages is that at the shaft: 1.5 (d id + q iq) = -torque w for an added linkage."""
    rows = rows_of(SWEEP)
    (cross,) = family_of("cross_saturation").columns(rows, ())
    assert cross.torque is not None and cross.d is not None and cross.q is not None
    assert 1.5 * (cross.d * rows.id_a + cross.q * rows.iq_a) == pytest.approx(-cross.torque * rows.speed_rad_s)
    # reciprocity: both linkages come from one co-energy, so that d(d)/d(iq) = d(q)/d(id)
    assert cross.d_linkage is not None and cross.q_linkage is not None
    assert np.gradient(cross.d_linkage[:400], rows.iq_a[:400])[1:-1] == pytest.approx(
        cross.q_linkage[1:399] / rows.id_a[1:399], rel=1e-3
    )


def test_a_line_over_the_angle_is_found_at_its_order_and_noise_has_none() -> None:
    rng = np.random.default_rng(3)
    rows = rows_of(SWEEP)
    at = slice(0, None, 10)
    theta, speed = rows.theta_rad[at], rows.speed_rad_s[at]
    noise = rng.normal(0.0, 1.0, len(theta))

    def passes(rad_s):
        return np.ones_like(rad_s)

    orders, (gain, _) = order_spectra(noise + 0.6 * np.sin(3.47 * theta), theta, speed, passes, (0.0, 2.0))
    ((order, strength),) = peaks(orders, gain, 0.5, 1, 45.0)
    resolution = 2.0 * np.pi / float(np.ptp(theta))
    assert order == pytest.approx(3.47, abs=resolution)
    # 2000 windows with amplitude 0.6 sigma: chi-square about n a^2 / 2, less what the clipping and the bins take
    assert strength == pytest.approx(0.5 * 0.36 * len(theta), rel=0.35)
    orders, gains = order_spectra(noise, theta, speed, passes, (0.0, 2.0))
    assert all(peaks(orders, g, 0.5, 1, 45.0) == [] for g in gains)


def test_a_frequency_is_found_to_a_fraction_of_the_resolution() -> None:
    t = np.arange(0.0, 20.0, 0.01)
    left = np.random.default_rng(5).normal(0.0, 1.0, len(t)) + 0.5 * np.sin(2.0 * np.pi * 19.23 * t)
    hz, gain = frequency_spectrum(left, t, lambda w: np.ones_like(w), np.ones(len(t)))
    ((found, _),) = peaks(hz, gain, 0.5, 1, 45.0)
    assert found == pytest.approx(19.23, abs=0.025)


def term_of(family: str, shape: tuple[float, ...], sizes: tuple[float, ...], **more) -> EmpiricalTerm:
    own = np.array(sizes)
    halves = tuple(0.01 * abs(x) for x in shape)
    facts = {"top_rad_s": 63.0, "rated_nm": 2.0, "rated_a": 4.0, "span_s": 40.0, "travel_rad": 300.0}
    return EmpiricalTerm(
        family,
        family_of(family),
        shape,
        own,
        1e-6 * np.eye(len(own)),
        halves,
        9.0,
        0.8,
        (20.0, 63.0),
        facts=facts,
        **more,
    )


def test_words_of_what_engineers_know() -> None:
    fan = words.sentence(term_of("speed_odd", (2.03,), (0.2,)))
    assert "depends on speed only, against the motion, grows with its square from 20 to 63 rad/s" in fan
    assert "fan, windage" in fan
    belt = words.sentence(term_of("angle_line", (3.47, 0.0, 0.0), (0.03, 0.04)))
    assert (
        "order 3.47 per turn, amplitude constant over speed" in belt and "phase not tied to the shaft: 0.05 N m" in belt
    )
    assert "belt" in belt
    warming = words.sentence(term_of("time_resistance", (18.0,), (0.4, 0.0)))
    assert "the resistance grows by 0.4 ohm over 40 s, time constant 18 s" in warming and "warms up" in warming
    cage = term_of("angle_line", (0.4, 0.0, 0.0), (0.03, 0.04))
    assert "cage of a ball bearing" in words.like(cage)


@pytest.mark.parametrize("family", [family.name for family in FAMILIES])
def test_every_family_has_words_a_cause_and_an_experiment_of_this_machine(family: str) -> None:
    shape = {3: (7.0, 2.0, 1.0), 2: (3.0, 0.4), 1: (2.0,), 0: ()}[len(family_of(family).shape)]
    term = term_of(family, shape, (0.2, 0.1), look_alikes=(LookAlike("time_load", 5.0),))
    said = term_json(term)
    assert said["depends_on"] and said["form"] and said["like"] and said["next_experiment"]
    assert any(ch.isdigit() for ch in said["next_experiment"])
    assert "a load that changes with time would look nearly the same" in words.sentence(term)
    for name, interval in said["intervals"].items():
        assert interval["low"] <= said["parameters"][name] <= interval["high"]


def test_a_line_that_grows_with_the_square_of_the_speed_may_be_an_error_of_the_angle_sensor() -> None:
    # A code wheel of 9 mrad at order 19: the measured angle accelerates by 0.009 (19 w)^2 although no torque acts.
    inertia, top = 4.2e-4, 68.0
    wheel_nm = inertia * 0.009 * (19.0 * top) ** 2
    facts = {"top_rad_s": top, "rated_nm": 1.0, "inertia_kgm2": inertia}

    def line(order: float, power: float, size: float, turns_over: float = 0.0) -> EmpiricalTerm:
        term = term_of("angle_line", (order, power, turns_over), (size, 0.0))
        return replace(term, facts=facts, shape_half=(1e-3, 0.0, 0.0))

    assert words.like(line(19.0, 2.0, wheel_nm)).startswith("an error of the angle sensor by 9 mrad")
    assert f"{wheel_nm:.2g} times the rated one" in words.like(line(19.0, 2.0, wheel_nm))
    assert "an error of the angle sensor stays" in words.experiment(line(19.0, 2.0, wheel_nm))
    small = words.like(line(6.0, 2.0, 0.1))
    assert small.startswith("pulses of a pump") and "or an error of the angle sensor by 1.43 mrad" in small
    assert "angle sensor" not in words.like(line(19.0, 2.0, wheel_nm, turns_over=1.0))
    assert "angle sensor" not in words.like(line(19.0, 0.0, wheel_nm))
    assert "angle sensor" not in words.like(line(19.37, 2.0, wheel_nm))
    assert "angle sensor" not in words.experiment(line(19.0, 0.0, wheel_nm))


def test_a_position_is_not_asked_for_where_records_count_their_angle_each_from_its_own_start() -> None:
    rows = rows_of(SWEEP)

    assert can_show(family_of("position_bump"), rows)
    assert not can_show(family_of("position_bump"), replace(rows, one_travel=False))
    assert can_show(family_of("angle_line"), replace(rows, one_travel=False))


def test_what_a_change_with_time_starts_from_is_an_effect_of_constant_size() -> None:
    def term(name: str, start: float) -> EmpiricalTerm:
        facts = {"top_rad_s": 50.0, "span_s": 40.0}
        return EmpiricalTerm(
            name, family_of(name), (8.0,), np.array([1.0, start]), np.eye(2), (0.1,), 5.0, 0.5, (1.0, 50.0), facts=facts
        )

    plant = {"viscous_nms": 2e-3, "resistance_ohm": 0.8}
    terms = [term("time_friction", 0.03), term("time_viscous", 0.02), term("time_resistance", -0.08)]

    assert at_start(terms, plant) == {
        "coulomb_friction": {"torque_nm": 0.03, "smooth_rad_s": 0.1},  # 0.002 of the top speed, as the term's own
        "viscous_friction": {"factor": 1.2},  # 0.02 N m beside 0.1 N m at 50 rad/s
        "winding_resistance": {"factor": 0.9},
    }
    assert at_start([replace(terms[0], family=family_of("time_load"))], plant) == {"load_torque": {"torque_nm": 0.03}}


def test_effects_at_once_add_torques_and_multiply_factors_within_the_ranges_of_the_table() -> None:
    one = {"inertia": {"factor": 1.2}, "coulomb_friction": {"torque_nm": 0.03}}
    two = {"inertia": {"factor": 1.1}, "coulomb_friction": {"torque_nm": -0.05}, "cogging": {"amplitude_nm": 0.1}}

    both = together(one, two)

    assert both["inertia"]["factor"] == pytest.approx(1.32)
    assert both["coulomb_friction"]["torque_nm"] == pytest.approx(-0.02)
    assert both["cogging"] == {"amplitude_nm": 0.1} and one["inertia"] == {"factor": 1.2}
    assert bounded(both)["coulomb_friction"]["torque_nm"] == 0.0


@pytest.mark.parametrize(
    ("family", "best", "gain", "expected"),
    [
        ("time_resistance", 16.0, 0.0, math.hypot(math.sqrt(2.0 * 3.84 * 2.0 / 12.0), 0.16)),
        # The same noise and a cause that stands out: 3 % of what it does are 0.0009 of the cost that it takes off.
        ("time_resistance", 16.0, 32000.0, math.hypot(math.sqrt(2.0 * (3.84 * 2.0 + 28.8) / 12.0), 0.16)),
        ("torque_frequency", 16.0, 32000.0, math.sqrt(2.0 * 3.84 * 2.0 / 12.0)),
    ],
)
def test_a_time_constant_is_no_surer_than_honest_models_agree_and_a_frequency_as_sure_as_its_noise(
    family: str, best: float, gain: float, expected: float
) -> None:
    def taken_off(columns: float) -> tuple[float, None]:
        return gain - 6.0 * (columns - best) ** 2, None  # a bend of 12

    log = SimpleNamespace(signals=SimpleNamespace(theta_m_rad=np.array([0.0, 300.0])))
    search = SimpleNamespace(
        logs=[log], rows=lambda e: SimpleNamespace(span_s=40.0), columns=lambda family, shape, log: shape[0]
    )
    candidate = Candidate(family_of(family), (best,), None, gain)
    (half,) = _shape_halves(search, SimpleNamespace(gain=taken_off), candidate)  # type: ignore[arg-type]
    assert half == pytest.approx(expected, rel=1e-4)  # a difference of large numbers
