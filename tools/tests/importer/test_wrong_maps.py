"""Wrong signs, frames and units of a log: a short campaign, and the checks behind it on machines in closed form."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from evenspin.plausible.load import check_load_sign
from evenspin.plausible.scales import check_scales, remark_on_inertia
from evenspin.plausible.speed_changes import speed_changes
from evenspin.plausible.windings import check_windings, measured_windings
from wrong_maps import laas_bases, outcomes, simulated_bases, table_of

GIVEN = ("everything", "voltages, no angle, model", "iq, angle")


def test_at_least_nineteen_of_twenty_wrong_maps_are_seen_and_no_right_one_is_refused(tmp_path: Path) -> None:
    bases = [next(laas_bases()), *simulated_bases(1, tmp_path, seconds=12.0, rate_hz=500.0)]

    found = [o for base in bases for o in outcomes(base, tmp_path, lambda given, mistake: given in GIVEN)]

    shown = table_of(found)
    assert len(found) > 60
    assert not [o for o in found if not o.mistake and o.detected], shown
    assert np.mean([o.detected for o in found if o.mistake and o.trace]) >= 0.95, shown


def a_machine(turn: float = 0.0, dead_v: float = 0.0) -> dict[str, np.ndarray]:
    """Voltage equations of a text book; most of the voltage is the magnets'. @p turn: rad, of the drive's axes."""
    t = np.arange(0.0, 12.0, 0.002)
    w = 150.0 * np.sin(0.9 * t) + 30.0 * np.sin(3.1 * t)
    iq = 2.0 * np.sign(w) + 0.02 * np.gradient(w, t) + 0.05 * np.random.default_rng(1).normal(size=len(t))
    idd = 0.1 * np.sin(2.0 * t)
    r, p, l_h, flux = 0.5, 4, 1e-3, 0.2
    vd = r * idd - p * w * l_h * iq
    vq = r * iq + p * w * l_h * idd + flux * w + dead_v * np.sign(iq)
    c, s = math.cos(turn), math.sin(turn)
    rotated = {"id_a": c * idd - s * iq, "iq_a": c * iq + s * idd, "vd_v": c * vd - s * vq, "vq_v": c * vq + s * vd}
    return {"t_s": t, "speed_rad_s": w, **rotated}


@pytest.mark.parametrize("turn", [0.0, 0.25, -0.25])
@pytest.mark.parametrize("dead_v", [0.0, 0.6])
def test_a_machine_passes_whose_axes_and_dead_time_are_off_as_on_a_bench(turn: float, dead_v: float) -> None:
    assert check_windings(a_machine(turn, dead_v)) is None


@pytest.mark.parametrize("turn", [0.0, 0.25])
@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"id_a": -1.0, "iq_a": -1.0}, "id_a and iq_a have the opposite sign"),
        ({"vd_v": -1.0, "vq_v": -1.0}, "vd_v and vq_v have the opposite sign"),
        ({"speed_rad_s": -1.0}, "speed_rad_s (or the order of the phases) has the opposite sign"),
        ({"vq_v": -1.0}, "vq_v has the opposite sign"),
    ],
)
def test_a_sign_is_found_from_the_voltages_and_named(changes: dict[str, float], said: str, turn: float) -> None:
    right = a_machine(turn)

    found = check_windings(right | {name: factor * right[name] for name, factor in changes.items()})

    assert found is not None and said in found.data


def test_exchanged_voltages_are_found() -> None:
    right = a_machine()

    found = check_windings(right | {"vd_v": right["vq_v"], "vq_v": right["vd_v"]})

    assert found is not None and "vd_v and vq_v are exchanged" in found.data


def test_the_numbers_of_the_windings_are_those_of_the_equations() -> None:
    found = measured_windings(a_machine(0.1))

    assert found is not None
    assert found["flux"] == pytest.approx(0.2, rel=0.01)
    assert found["resistance"] == pytest.approx(0.5, rel=0.03)
    assert found.get("reactance", 4e-3) == pytest.approx(4e-3, rel=0.1)


def under_load_steps(gain: float = 0.004) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A speed loop under hard load steps: ramps of the reference, and dips that the current answers."""
    h, inertia, kp, ki = 0.001, gain, 0.3, 4.0
    t = np.arange(0.0, 20.0, h)
    ref = np.interp(
        t, [0, 1, 1.2, 4, 4.3, 8, 8.5, 12, 12.4, 16, 16.2, 20], [0, 0, 60, 60, -30, -30, 50, 50, 10, 10, -60, -60]
    )
    load = (
        4.0 * ((t > 2) & (t < 3))
        - 4.0 * ((t > 5.5) & (t < 7))
        + 4.0 * ((t > 9) & (t < 11))
        + 3.0 * ((t > 13) & (t < 15))
    )
    w, integral = np.zeros(len(t)), 0.0
    i = np.zeros(len(t))
    for n in range(len(t) - 1):
        integral += ki * h * (ref[n] - w[n])
        i[n] = kp * (ref[n] - w[n]) + integral
        w[n + 1] = w[n] + h * (i[n] - load[n] - 0.3 * np.tanh(w[n])) / inertia
    i[-1] = i[-2]
    return t, w, i


def test_changes_of_the_speed_show_sign_and_inertia_under_hard_load_steps() -> None:
    t, w, i = under_load_steps()

    found = speed_changes(t, w, i)

    assert found.decide and found.vote > 0.9
    assert found.slope == pytest.approx(0.004, rel=0.15)  # one load step falls into a ramp
    assert speed_changes(t, w, -i).vote == -found.vote


def test_one_speed_without_a_change_decides_nothing() -> None:
    """Torque ripple that a controller answers: the current falls where the shaft speeds up."""
    t = np.arange(0.0, 10.0, 0.001)
    ripple = np.sin(2.0 * np.pi * 12.0 * t)
    w = 6.0 + 0.3 * ripple

    assert not speed_changes(t, w, 0.1 - 0.05 * np.gradient(w, t) / 20.0).decide


def test_a_load_of_the_wrong_sign_falls_where_the_current_rises() -> None:
    t, w, i = under_load_steps()
    load = i - 0.004 * np.gradient(w, t)
    columns = {"t_s": t, "speed_rad_s": w, "iq_a": i, "load_torque_nm": load}

    assert check_load_sign(columns) is None
    found = check_load_sign(columns | {"load_torque_nm": -load})
    assert found is not None and "falls where iq_a rises" in found.data
    found = check_load_sign(columns | {"load_torque_nm": 1e3 * load}, nm_per_a=1.0)
    assert found is not None and "mN m" in found.hint


NONE: dict[str, float] = {}


@pytest.mark.parametrize(
    ("ratios", "said"),
    [
        ({"flux": 0.105, "resistance": 1.0, "reactance": 0.105, "inertia": 0.105}, "speed_rad_s in r/min"),
        ({"flux": 0.25, "resistance": 1.05, "reactance": 0.25, "inertia": 0.26}, "speed_rad_s in electrical rad/s"),
        ({"flux": 1.0, "resistance": 1.41, "reactance": 1.41, "inertia": 0.71}, "iq_a in A rms"),
        ({"flux": 0.707, "resistance": 0.71, "reactance": 0.7, "inertia": 1.0}, "vq_v in V rms"),
        ({"flux": 1e3, "resistance": 1e3, "inertia": 1.1}, "vq_v in mV"),
        ({"flux": 1.0, "resistance": 1e-3, "reactance": 1e-3, "inertia": 1e3}, "iq_a in mA"),
    ],
)
def test_a_unit_is_what_explains_several_numbers_at_once(ratios: dict[str, float], said: str) -> None:
    found = check_scales(ratios, NONE, 4, has_angle=False, has_speed=True)

    assert found is not None and said in found.hint


@pytest.mark.parametrize(
    "ratios",
    [
        {"flux": 1.0, "resistance": 1.0, "reactance": 1.0, "inertia": 1.0},
        {"flux": 0.86, "resistance": 1.0, "reactance": 1.0, "inertia": 1.16},  # weak magnets
        {"flux": 1.0, "resistance": 1.8, "reactance": 1.0, "inertia": 1.0},  # a bad contact
        {"flux": 1.0, "resistance": 1.41, "reactance": 1.0, "inertia": 0.71},  # two faults
        {"flux": 1.0, "resistance": 1.1, "reactance": 0.9, "inertia": 9.55},  # a flywheel
    ],
)
def test_a_fault_of_the_machine_is_no_unit(ratios: dict[str, float]) -> None:
    assert check_scales(ratios, NONE, 4, has_angle=False, has_speed=True) is None


def test_an_inertia_alone_is_a_remark_where_it_is_a_unit() -> None:
    said = remark_on_inertia(0.25, 4, has_angle=False, has_speed=True)

    assert said is not None and "electrical rad/s" in said
    assert remark_on_inertia(0.25, 4, has_angle=True, has_speed=True) is None
    assert remark_on_inertia(0.3, 4, has_angle=False, has_speed=True) is None
    assert remark_on_inertia(1.2, 4, has_angle=False, has_speed=True) is None
