"""`evenspin bench bode`: the frequency response of the running drive against the sampled loops, worked out here from
the differential equations of the machine and the documented timing, with python-control; and what ends or refuses
it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evenspin.bench import Drive, Excite, Mode, State
from evenspin.bench.errors import DriveFaultError, RefusedError
from evenspin.bench.operator import operator_for
from evenspin.bench.response import Plan, measure, plan_of
from evenspin.errors import InputError
from numpy.typing import NDArray
from said import Said

import control

PORT = "sim:servo"
SPEED_RAD_S = 50.0
PWM_S, SAMPLE_S = 1e-4, 1e-3


@pytest.fixture(scope="module")
def drive() -> Iterator[Drive]:
    with Drive.connect(PORT) as drive:
        drive.run_speed(SPEED_RAD_S)
        drive.sleep(1.0)
        yield drive


# data/models/servo.toml
OHM, HENRY, FLUX_WB, POLE_PAIRS, INERTIA, VISCOUS = 0.9, 0.0024, 0.1, 3, 8e-4, 2e-3


def _current_loop(kp: float, ki: float) -> control.StateSpace:
    """q axis at the PWM rate, d current 0: from the reference to the current, the speed, and the angle. The voltage
    acts one period after the sample and is held; the speed brakes by its back-EMF. PI: kp e + x, x += ki T e."""
    flux = POLE_PAIRS * FLUX_WB
    a = [[-OHM / HENRY, -flux / HENRY, 0.0], [1.5 * flux / INERTIA, -VISCOUS / INERTIA, 0.0], [0.0, 1.0, 0.0]]
    shaft = control.c2d(control.ss(a, [[1.0 / HENRY], [0.0], [0.0]], np.eye(3), np.zeros((3, 1))), PWM_S, "zoh")
    late = control.ss([[0.0]], [[1.0]], [[1.0]], [[0.0]], PWM_S)
    pi = control.ss([[1.0]], [[ki * PWM_S]], [[1.0]], [[kp]], PWM_S)
    ahead = control.series(pi, late, shaft)
    return control.feedback(ahead, control.ss([], [], [], [[-1.0, 0.0, 0.0]], PWM_S), sign=1)


def _sampled(system: control.StateSpace, f_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    """From a q current that a sample of the speed loop gives, in force from the next PWM period on for ten, to the mean
    speed between the samples."""
    a, b, c = (np.asarray(x) for x in (system.A, system.B, system.C))
    size, steps = len(a), 10
    power = [np.linalg.matrix_power(a, k) for k in range(steps + 1)]
    new = sum((power[k] for k in range(steps - 1)), np.zeros_like(a)) @ b  # nine periods of this sample's
    old = power[steps - 1] @ b  # one of the one before
    found = np.empty(len(f_hz), dtype=complex)
    for number, f in enumerate(f_hz):
        z = np.exp(2j * np.pi * f * SAMPLE_S)
        state = np.linalg.solve(z * np.eye(size) - power[steps], new + old / z)
        found[number] = (c[2] @ state)[0] * (1.0 - 1.0 / z) / SAMPLE_S
    return found


def _expected(drive: Drive, f_hz: NDArray[np.float64]) -> dict[str, NDArray[np.complex128]]:
    p = drive.get()
    inner = _current_loop(p["current_kp_v_per_a"], p["current_ki_v_per_as"])
    plant = _sampled(inner, f_hz)
    z = np.exp(2j * np.pi * f_hz * SAMPLE_S)
    pi = p["speed_error_gain"] * (p["speed_kp_a_per_unit"] + p["speed_ki_a_per_unit_s"] * SAMPLE_S / (z - 1.0))
    # the speed is the mean between edges of the encoder, the last of which came half a count before the sample, on
    # average
    edge_s = 0.5 * 2.0 * np.pi / 4000.0 / SPEED_RAD_S
    plant = plant * np.exp(-2j * np.pi * f_hz * edge_s)
    loop = pi * plant
    current = np.array([inner(np.exp(2j * np.pi * f * PWM_S))[0, 0] for f in f_hz])
    return {"current": current, "plant": plant, "loop": loop, "closed": loop / (1.0 + loop)}


@pytest.mark.parametrize(
    ("place", "last_hz", "amplitude"), [("torque", 300.0, 0.4), ("current", 4400.0, 1.0), ("speed", 300.0, 2.0)]
)
def test_bode_agrees_with_the_sampled_loops(drive: Drive, place: str, last_hz: float, amplitude: float) -> None:
    found = measure(drive, plan_of(drive, place, 5.0, last_hz, 7, amplitude))
    f_hz = np.array([point.f_hz for point in found.points])
    expected = _expected(drive, f_hz)
    assert found.speed_rad_s == pytest.approx(SPEED_RAD_S, rel=1e-3)
    assert all(point.good for point in found.points)
    for name in found.names:
        assert np.min(np.abs(expected[name])) < 0.5 * np.max(np.abs(expected[name]))  # there is something to see
        for k, point in enumerate(found.points):
            each = point.ratios[name]
            # its own 95 % interval, half as much again, and 1 % for what is not linear: encoder, friction, the d axis
            assert abs(each.value / expected[name][k] - 1.0) < 1.5 * each.error + 0.01, (name, point.f_hz)


def test_bode_margins_are_those_of_the_sampled_loop(drive: Drive) -> None:
    found = measure(drive, plan_of(drive, "torque", 6.0, 300.0, 14, 0.4)).margins
    assert found is not None
    f_hz = np.geomspace(6.0, 300.0, 4000)
    loop = _expected(drive, f_hz)["loop"]
    margin = control.margin(control.FRD(loop, 2.0 * np.pi * f_hz))
    assert found.gain_db == pytest.approx(
        20.0 * np.log10(margin[0]), abs=0.4
    )  # straight lines between 8 points a decade
    assert found.phase_deg == pytest.approx(margin[1], abs=1.0)
    assert found.crossover_hz == pytest.approx(margin[3] / (2.0 * np.pi), rel=0.02)


@pytest.mark.parametrize("words", [("speed_inline", "1"), ("speed_divider", "4")])
def test_bode_of_another_sample_rate_is_the_loop_gain_that_closes_the_loop(words: tuple[str, str]) -> None:
    """L / (1 + L) of one measurement is the closed loop of the other: each shows an error of time in the other."""
    with Drive.connect("sim:servo") as drive:
        drive.set({words[0]: float(words[1])})
        drive.run_speed(SPEED_RAD_S)
        drive.sleep(1.0)
        loop = measure(drive, plan_of(drive, "torque", 8.0, 120.0, 3, 0.4))
        closed = measure(drive, plan_of(drive, "speed", 8.0, 120.0, 3, 2.0))
    for one, other in zip(loop.points, closed.points, strict=True):
        gain = one.ratios["loop"].value
        assert abs(gain / (1.0 + gain) / other.ratios["closed"].value - 1.0) < 0.015


def test_bode_marks_a_sine_that_a_limit_cuts_and_one_that_is_lost_in_the_noise(drive: Drive) -> None:
    operator = operator_for(drive.link.transport, lambda request: True)
    operator.load(0.9)  # 2 A of the 8 A that there are
    cut = measure(drive, Plan("torque", 250.0, 300.0, 2, 7.9))
    operator.load(0.0)
    assert [point.cut for point in cut.points] == [True, True]
    assert not any(point.good for point in cut.points)
    lost = measure(drive, Plan("current", 3000.0, 4000.0, 2, 0.002))  # the noise of the sensors is 0.015 A
    assert not any(point.good for point in lost.points)
    assert max(point.ratios["current"].coherence for point in lost.points) < 0.9


def test_bode_ends_its_excitation_and_says_when_something_else_has(
    drive: Drive, monkeypatch: pytest.MonkeyPatch
) -> None:
    measure(drive, Plan("torque", 100.0, 200.0, 2, 0.4))
    assert drive.read(("excitation_a",)) == {"excitation_a": 0.0}

    excite = drive.excite

    def interfered(*words: Any) -> float:
        made = excite(*words)
        drive.setpoint(Mode.SPEED, speed_rad_s=SPEED_RAD_S)
        return made

    monkeypatch.setattr(drive, "excite", interfered)
    with pytest.raises(DriveFaultError, match="excitation has ended"):
        measure(drive, Plan("torque", 100.0, 200.0, 2, 0.4))


def test_bode_refuses_at_rest_with_learning_and_beyond_the_limits() -> None:
    with Drive.connect("sim:servo") as drive:
        with pytest.raises(RefusedError, match="its state is"):
            measure(drive, Plan("torque", 100.0, 200.0, 2, 0.4))
        with pytest.raises(RefusedError, match="state is"):
            drive.excite(Excite.TORQUE, 0.4, 100.0)
        for words, match in (
            (("engine", 2.0, None, 9, None), "torque, current or speed"),
            (("torque", 2.0, 451.0, 9, None), "at most 450 Hz"),
            (("current", 2.0, 4501.0, 9, None), "at most 4500 Hz"),
            (("torque", 2.0, None, 1, None), "2 to 400"),
            (("torque", 2.0, None, 9, 8.1), "at most 8 A"),
        ):
            with pytest.raises(InputError, match=match):
                plan_of(drive, *words)
        drive.set({"method": 6.0})
        drive.run_speed(SPEED_RAD_S)
        with pytest.raises(RefusedError, match="method = aro would learn the sine"):
            measure(drive, Plan("torque", 100.0, 200.0, 2, 0.4))
        with pytest.raises(RefusedError, match="observer_hold = 1"):
            drive.excite(Excite.TORQUE, 0.4, 100.0)
        drive.set({"observer_hold": 1.0})
        assert drive.excite(Excite.TORQUE, 0.4, 100.0) == pytest.approx(100.0, rel=1e-6)
        drive.stop()
        drive.sleep(0.01)
        assert drive.state().state == State.READY
        drive.start()  # without it
        assert drive.read(("excitation_a",)) == {"excitation_a": 0.0}
        with pytest.raises(RefusedError, match="place"):
            drive.setpoint(Mode.CURRENT)
            drive.excite(Excite.SPEED, 1.0, 100.0)


def test_bode_prints_writes_and_ends_with_1_when_nothing_is_good(evenspin: Callable[..., Said], tmp_path: Path) -> None:
    table, picture, found = tmp_path / "a.csv", tmp_path / "a.svg", tmp_path / "a.json"
    words = ("bench", "bode", "--port", "sim:servo", "--speed", 50, "--from", 5, "--to", 100, "--points", 4)
    said = evenspin(*words, "--out", table, "--plot", picture, "--json", found)
    assert said.status == 0, said.err
    content: dict[str, Any] = json.loads(found.read_text())
    assert [each["good"] for each in content["points"]] == [True] * 4
    assert content["margins"]["gain_db"] is None  # the phase does not reach -180 degrees below 100 Hz
    assert f"{content['margins']['crossover_hz']:.4g} Hz" in said.out
    rows = np.genfromtxt(table, delimiter=",", names=True)
    assert rows["loop_gain"][1] == pytest.approx(content["points"][1]["loop"]["gain"], rel=1e-6)
    assert "plant [dB, 1 rad/s per A]" in picture.read_text()
    nothing = evenspin(*words, "--at", "current", "--amplitude", 0.001)
    assert nothing.status == 1 and "No point is good" in nothing.out
    both = evenspin(*words, "--iq", 1)
    assert both.status == 2 and "one of the two" in both.err
