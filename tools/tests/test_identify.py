"""Identification: made-up logs whose answer is known, and experiments on the simulated drive."""

import json
import math

import numpy as np
import pytest
from evenspin.errors import InputError
from evenspin.identify.estimate import linear
from evenspin.identify.experiments import by_kind, perform, plan, torque_per_a
from evenspin.identify.friction import FrictionPoint, friction_points, identify_friction
from evenspin.identify.inertia import identify_inertia
from evenspin.identify.result import KINDS, drive_parameters, identify
from evenspin.identify.source import Run, run_of
from evenspin.identify.spectrum import identify_lines
from evenspin.model import load_machine
from evenspin.sim.many import run_all

B, COULOMB, STATIC, V_S, SHAPE, J = 0.02, 0.3, 0.4, 0.8, 1.5, 4e-3
TS = 1e-3
TURN = 2.0 * math.pi


def friction(v):
    return B * v + np.sign(v) * (COULOMB + (STATIC - COULOMB) * np.exp(-((np.abs(v) / V_S) ** SHAPE)))


def points(speeds, noise=1e-4, offset=0.05):
    rng = np.random.default_rng(1)
    return [FrictionPoint(v, float(friction(v)) + offset + noise * rng.standard_normal(), 1.0) for v in speeds]


BOTH = [sign * v for sign in (1, -1) for v in (0.05, 0.1, 0.2, 0.4, 0.6, 0.9, 1.3, 2.0, 4.0, 8.0)]


def slow_turns(lines, turns=9.0, speed=0.4, noise=0.0, mean=0.3):
    """A log of slow turns, with the torque that the lines ask for."""
    theta = speed * TS * np.arange(int(turns * TURN / speed / TS))
    torque = mean + sum(a * np.sin(w * theta + phi) for w, a, phi in lines)
    torque = torque + noise * np.random.default_rng(2).standard_normal(len(theta))
    return Run("slow", TS, theta, np.full(len(theta), speed), torque)


def test_friction_is_found_with_its_intervals():
    found = identify_friction(points(BOTH)).estimates

    true = {"viscous_nms": B, "coulomb_nm": COULOMB, "static_nm": STATIC, "stribeck_rad_s": V_S, "shape": SHAPE}
    for name, value in true.items():
        assert found[name].value == pytest.approx(value, rel=0.03)
        assert abs(found[name].value - value) < 2.0 * found[name].half  # 95 % is half of that
        assert 1e-5 < found[name].relative < 0.1
    assert found["offset_nm"].value == pytest.approx(0.05, abs=2e-4)


def test_friction_without_stribeck_part_needs_no_slow_runs():
    fast = [v for v in BOTH if abs(v) > 3 * V_S] + [3.0, -3.0, 5.0, -5.0]

    found = identify_friction(points(fast), stribeck=False).estimates

    assert found["viscous_nms"].value == pytest.approx(B, rel=0.03)
    assert found["coulomb_nm"].value == pytest.approx(COULOMB, rel=0.02)
    assert found["static_nm"] == found["coulomb_nm"]
    assert not {"stribeck_rad_s", "shape"} & set(found)


@pytest.mark.parametrize(("speeds", "said"), [
    ([v for v in BOTH if v > 0], "speeds in negative direction = 0: must be at least 4"),
    ([v for v in BOTH if v < 0], "speeds in positive direction = 0: must be at least 4"),
    ([v for v in BOTH if abs(v) > 4 * V_S] + [5.0, -5.0, 6.0, -6.0], "below the Stribeck speed"),
    ([v for v in BOTH if abs(v) < 1.0], "must be"),
    ([], "no constant speed"),
])  # fmt: skip
def test_friction_that_the_runs_do_not_determine_is_refused(speeds, said):
    with pytest.raises(InputError, match=said):
        identify_friction(points(speeds))


def test_a_torque_tied_to_the_angle_does_not_count_as_friction():
    """The speed ripples with the torque, so that a mean over time would be wrong."""
    theta = np.zeros(40_000)
    for k in range(1, len(theta)):
        theta[k] = theta[k - 1] + TS * (1.0 + 0.4 * math.sin(4 * theta[k - 1]))
    torque = 0.25 + 0.2 * np.sin(4 * theta)
    run = Run("ripple", TS, theta, np.ones(len(theta)), torque)

    (point,) = friction_points([run])

    assert abs(torque.mean() - 0.25) > 0.03
    assert point.torque_nm == pytest.approx(0.25, abs=5e-4)


def test_less_than_a_turn_is_refused():
    theta = 0.5 * TS * np.arange(8000)
    with pytest.raises(InputError, match="at least one turn"):
        friction_points([Run("short", TS, theta, np.full(8000, 0.5), np.zeros(8000))])


def accelerated(lines=(), seconds=6.0):
    t = TS * np.arange(int(seconds / TS))
    a = 60.0 * np.cos(2 * math.pi * t / 0.6)
    v = 20.0 + 60.0 * 0.6 / (2 * math.pi) * np.sin(2 * math.pi * t / 0.6)
    theta = 20.0 * t - 60.0 * (0.6 / (2 * math.pi)) ** 2 * (np.cos(2 * math.pi * t / 0.6) - 1)
    torque = J * a + friction(v) + sum(A * np.sin(w * theta + phi) for w, A, phi in lines)
    return Run("ramps", TS, theta, v, torque + 0.01 * np.random.default_rng(3).standard_normal(len(t)))


@pytest.mark.parametrize("lines", [(), ((24.0, 0.14, 1.0), (4.0, 0.02, 0.5))])
def test_inertia_is_found_beside_friction_and_a_torque_tied_to_the_angle(lines):
    found = identify_inertia([accelerated(lines)])

    assert found.inertia_kgm2.value == pytest.approx(J, rel=0.01)
    assert 1e-4 < found.inertia_kgm2.relative < 0.1


def test_inertia_needs_both_signs_of_acceleration():
    run = slow_turns([], speed=3.0)

    with pytest.raises(InputError, match="both speeding up and braking"):
        identify_inertia([run])


def test_lines_are_found_far_below_the_resolution():
    lines = [(24.008, 0.14, 1.275), (4.059, 0.022, 0.521)]

    found = identify_lines(slow_turns(lines, noise=0.01))

    assert found.resolution == pytest.approx(1.0 / 8.0, rel=0.01)
    for line, (cycles, amplitude, phase) in zip(found.lines, lines, strict=True):
        assert line.cycles.value == pytest.approx(cycles, abs=5e-4)
        assert line.amplitude_nm.value == pytest.approx(amplitude, rel=0.01)
        assert line.phase_rad.value == pytest.approx(phase, abs=0.02)
        assert abs(line.phase_rad.value - phase) < 2.0 * line.phase_rad.half


def test_turning_backwards_finds_the_same_lines():
    lines = [(10.0, 0.1, 0.7)]
    forward = slow_turns(lines)
    theta = -forward.theta_rad
    back = Run("back", TS, theta, -forward.speed_ref_rad_s, -0.3 + 0.1 * np.sin(10.0 * theta + 0.7))

    (line,) = identify_lines(back).lines

    assert (line.cycles.value, line.amplitude_nm.value) == pytest.approx((10.0, 0.1), rel=1e-3)
    assert line.phase_rad.value == pytest.approx(0.7, abs=5e-3)


@pytest.mark.parametrize(("cycles", "expected"), [(12.03, 12.0), (12.4, 12.4)])
def test_lines_snap_only_within_the_resolution(cycles, expected):
    (line,) = identify_lines(slow_turns([(cycles, 0.1, 0.0)], noise=1e-3), snap=True).lines[:1]

    assert line.cycles.value == pytest.approx(expected, abs=1e-3)
    assert line.snapped == (expected == 12.0)


@pytest.mark.parametrize(("run", "said"), [
    (slow_turns([(4.0, 0.1, 0.0)], turns=1.5), "turns = '1.50': must be at least 2"),
    (accelerated(), "must be constant"),
    (slow_turns([], noise=0.01), "above the noise"),
])  # fmt: skip
def test_turns_that_show_no_lines_are_refused(run, said):
    with pytest.raises(InputError, match=said):
        identify_lines(run)


def test_the_interval_of_a_mean_is_that_of_the_book():
    values = np.array([1.0, 2.0, 3.0, 4.0, 5.0])

    (mean,), _ = linear(np.ones((5, 1)), values)

    assert mean.value == pytest.approx(3.0)
    assert mean.half == pytest.approx(2.776 * math.sqrt(2.0 / 5.0), rel=1e-3)  # t(0.975, 4) s / sqrt(n), s^2 = ssr / n


# ---- on the simulated drive ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def simulated():
    experiments = plan("yeh2024", KINDS)
    logs = run_all([lambda e=each: run_of(perform(e), e.name, torque_per_a(e)) for each in experiments], None)
    return by_kind(logs)


def test_the_noise_of_the_experiments_is_at_least_ten_millinewtonmetres(simulated):
    steps = np.diff(simulated["cogging"][0].torque_nm)

    assert 0.0095 <= steps.std() / math.sqrt(2.0) <= 0.0125  # the loop adds a little of its own


def test_the_machine_of_the_paper_is_found(simulated):
    found = identify(simulated)
    estimates = {name: each.value for name, each in found.estimates.items()}

    assert estimates["inertia_kgm2"] == pytest.approx(0.780e-2, rel=0.02)
    assert estimates["viscous_nms"] == pytest.approx(0.339e-1, rel=0.02)
    assert estimates["coulomb_nm"] == pytest.approx(0.387, rel=0.02)
    assert estimates["static_nm"] == pytest.approx(0.457, rel=0.02)
    assert estimates["stribeck_rad_s"] == pytest.approx(0.551, rel=0.08)
    assert estimates["shape"] == pytest.approx(1.957, rel=0.10)
    main, second = found.spectrum.lines
    assert main.cycles.value == pytest.approx(5.724e-6 * 2**22, abs=0.001)
    assert (main.amplitude_nm.value, second.amplitude_nm.value) == pytest.approx((0.140, 0.022), rel=0.02)
    assert main.phase_rad.value == pytest.approx(1.275, abs=0.03)
    assert second.phase_rad.value == pytest.approx(0.521, abs=0.05)
    assert drive_parameters(found)["rdc_line1_nm"] == main.amplitude_nm.value


def test_the_command_writes_a_model_that_loads_and_its_logs_give_the_same(evenspin, tmp_path):
    out, first, again = tmp_path / "out", tmp_path / "one.json", tmp_path / "two.json"

    said = evenspin("identify", "inertia", "--run", "sim", "yeh2024", "--out", out, "--json", first)
    from_log = evenspin("identify", "inertia", out / "log", "--json", again)

    assert (said.status, from_log.status) == (0, 0), said.err + from_log.err
    inertia = json.loads(first.read_text())["inertia_kgm2"]
    assert load_machine(out / "model.toml").plant["inertia_kgm2"] == pytest.approx(inertia, rel=1e-8)
    assert json.loads(again.read_text())["inertia_kgm2"] == pytest.approx(inertia, rel=1e-6)
    assert f"rdc_inertia_kgm2 = {inertia:.9g}" in (out / "drive.toml").read_text()
    assert {path.name for path in (out / "figures").iterdir()} == {"inertia.svg", "inertia.csv"}


@pytest.mark.parametrize(("words", "start"), [
    ((), "identify: --run"),
    (("friction",), "identify: LOG"),
    (("friction", "nowhere"), "nowhere: file"),
    (("--run", "bench"), "identify: --run = 'bench'"),
    (("--run", "sim", "yeh2042"), "identify: MODEL = 'yeh2042'"),
    (("cogging", "--run", "sim", "--noise", "-1"), "identify: --noise"),
    (("inertia", "--run", "sim", "--top-speed", "0"), "identify: --top-speed"),
    (("inertia", "--run", "sim", "--torque", "guessed"), "identify: --torque"),
])  # fmt: skip
def test_bad_usage_is_one_line(evenspin, words, start):
    words = words or ("--seed", "1")

    said = evenspin("identify", *words)

    assert (said.status, said.out) == (2, "")
    assert said.err.startswith(start) and said.err.count("\n") == 1
