"""`evenspin commission`: a motor of which nothing is known but its limits is measured and driven, or left as it was."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from evenspin.bench import Drive
from evenspin.bench.numbers import State
from evenspin.commission import limits, steps
from evenspin.commission.fits import edges, flux, inductance, mechanics
from evenspin.commission.limits import Bounds
from evenspin.commission.windings import winding_roughly
from evenspin.commission.work import commission, drive_values
from evenspin.errors import InputError
from evenspin.model import load_machine
from motors_campaign import run
from random_machines import random_machine
from scipy.integrate import solve_ivp

T = 1e-4


def winding(r: float, inductance_h: float, volts: np.ndarray, emf=lambda t: 0.0) -> np.ndarray:
    """Current at the samples under voltages that are held for a period each: an ODE solver, no recursion."""
    current = [0.0]
    for k, volt in enumerate(volts):
        found = solve_ivp(lambda t, i, v=volt: (v - r * i - emf(t)) / inductance_h, (k * T, (k + 1) * T), [current[-1]],
                          rtol=1e-9, atol=1e-12)  # fmt: skip
        current.append(float(found.y[0, -1]))
    return np.array(current)


@pytest.mark.parametrize("tau_s", [2e-4, 5e-3])
def test_the_inductance_of_a_step_is_that_of_the_winding(tau_s: float) -> None:
    """Noise of 1 % of the step on the current; a controller that answers it with voltage."""
    rng = np.random.default_rng(1)
    r, count = 0.8, 400
    noise = 0.01 * rng.standard_normal(count + 2)
    current, volts, now = np.zeros(count + 2), np.zeros(count + 2), 0.0
    a = math.exp(-T / tau_s)
    waiting = 0.0
    for k in range(count + 2):
        current[k] = now + noise[k]
        volts[k] = r * 1.0 + 2.0 * r * (1.0 - current[k])
        now, waiting = a * now + (1.0 - a) * waiting / r, volts[k]  # a voltage acts one period later
    found = inductance(current, volts, r, T)
    assert found.inductance_h.value == pytest.approx(r * tau_s, rel=0.02)
    assert abs(found.inductance_h.value - r * tau_s) < 3.0 * found.inductance_h.half


@pytest.mark.parametrize("tau_s", [1.3e-4, 6e-3])
def test_a_switched_current_gives_the_inductance_although_the_rotor_moves(tau_s: float) -> None:
    """The back-EMF of a swinging rotor is the flux that passes: its angle is all that is needed."""
    r, emf_per_rad = 0.5, 0.05
    inductance_h = r * tau_s
    angle = lambda t: 0.3 * math.sin(2.0 * math.pi * 60.0 * t)  # noqa: E731
    speed = lambda t: 0.3 * 2.0 * math.pi * 60.0 * math.cos(2.0 * math.pi * 60.0 * t)  # noqa: E731
    volts = np.array([(1.0 if k // 40 % 2 == 0 else -1.0) for k in range(600)])
    current = winding(r, inductance_h, volts, lambda t: emf_per_rad * speed(t))
    theta = np.array([angle(k * T) for k in range(600)])
    # The voltage of row k acts from row k + 1 on.
    taken = np.column_stack((current[:600], np.append(volts[1:], 0.0), theta, np.append(volts[1:], 0.0)))
    window = 6 if tau_s < 1e-3 else 32
    found, _ = edges(taken, T, window, r, emf_per_rad)
    assert found.value == pytest.approx(inductance_h, rel=0.02)


def test_flux_zero_and_inertia_come_from_a_run_up_and_a_coast() -> None:
    """Equations of motion and of the voltages by hand; the drive's d axis leads by 0.02 rad."""
    psi, p, r, ld, lq, lead = 0.05, 4, 0.5, 2e-3, 3e-3, 0.02
    k_t, j, b, c = 1.5 * p * psi, 4e-4, 2e-4, 0.01
    time = np.arange(0.0, 6.0, 1e-3)
    iq = np.where((time % 2.0) < 0.6, 1.0, np.where((time % 2.0) < 1.0, 0.0, np.where((time % 2.0) < 1.6, -1.0, 0.0)))
    speed, theta = np.zeros(len(time)), np.zeros(len(time))
    for k in range(1, len(time)):
        torque = k_t * iq[k - 1] - b * speed[k - 1] - c * np.sign(speed[k - 1])
        speed[k] = speed[k - 1] + 1e-3 * torque / j
        theta[k] = theta[k - 1] + 0.5e-3 * (speed[k] + speed[k - 1])
    we = p * speed
    vd = -we * lq * iq - we * psi * math.sin(lead)
    vq = r * iq + we * psi * math.cos(lead)
    use = np.abs(np.diff(iq, prepend=0.0)) < 0.5
    found = flux(p * theta, np.zeros_like(iq), iq, vd, vq, use & (np.abs(speed) > 5.0), 1000.0, 16, ld)
    assert found.psi_wb.value == pytest.approx(psi, rel=2e-3)
    assert found.angle_rad.value == pytest.approx(lead, abs=1e-3)
    shaft = mechanics(theta, iq, 1000.0, 20, use)
    assert k_t * shaft.inertia.value == pytest.approx(j, rel=5e-3)
    assert k_t * shaft.coulomb.value == pytest.approx(c, rel=0.05)


@pytest.mark.parametrize("seed", [5, 24, 35])
def test_a_hidden_machine_is_measured_within_three_percent_and_runs(seed: int) -> None:
    """Three of the campaign's machines (`make motors`): 11 W at 24 V, 50 W at 310 V, and 47 W at 60 V, whose rotor
    swings about the vector of the alignment at the frequency of the current loop; within a minute."""
    row = run(random_machine(seed), methods=False)
    assert row.done.good, row.done.error
    assert row.misses == []


def test_nothing_of_another_motor_is_left_in_the_way(tmp_path: Path) -> None:
    """The drive holds the gains, limits and motor data of a machine a hundred times larger."""
    machine = random_machine(5)
    path = tmp_path / "m.toml"
    path.write_text(machine.toml())
    with Drive.connect(f"sim:{path}?fresh=1") as drive:
        drive.set({
            "current_kp_v_per_a": 300.0, "current_ki_v_per_as": 3e5, "speed_kp_a_per_unit": 50.0, "pole_pairs": 4,
            "motor_psi_wb": 0.4, "motor_lq_h": 0.1, "observer_inertia_kgm2": 0.5, "over_voltage_v": 12.0,
            "under_voltage_v": 1.0, "encoder_counts": 1e6, "iq_limit_a": 0.1, "method": 6, "stall_s": 0.001,
        })  # fmt: skip
        done = commission(drive, Bounds(machine.max_current_a), "smooth", methods=False)
        assert done.good, done.error
        assert done.known.inertia.value == pytest.approx(machine.plant["inertia_kgm2"], rel=0.03)
        assert drive.get(["motor_psi_wb"])["motor_psi_wb"] == pytest.approx(machine.plant["psi_wb"], rel=0.03)


def test_a_locked_shaft_ends_it_with_the_bridge_off_and_the_values_from_before(tmp_path: Path) -> None:
    machine = random_machine(5)
    path = tmp_path / "m.toml"
    path.write_text(machine.toml())
    with Drive.connect(f"sim:{path}?fresh=1") as drive:
        before = drive.get()
        drive.link.transport.drive.lock_rotor(True)
        done = commission(drive, Bounds(machine.max_current_a), "smooth", methods=False)
        assert not done.good and "align" in done.error
        assert drive.get() == before
        assert drive.state().state in (State.READY, State.FAULT)
        assert drive.link.transport.drive.read("true_iq_a") == pytest.approx(0.0, abs=1e-6)


def test_a_direction_that_is_wrong_is_turned_round(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The simulated encoder counts the right way: a drive that takes it for reversed is one with a reversed encoder."""
    whole = limits.blank
    monkeypatch.setattr(steps, "blank", lambda *given: whole(*given) | {"encoder_reversed": 1.0})
    machine = random_machine(5)
    path = tmp_path / "m.toml"
    path.write_text(machine.toml())
    with Drive.connect(f"sim:{path}?fresh=1") as drive:
        bench = steps.Bench(drive, Bounds(machine.max_current_a), steps.Known(reversed=True), lambda _: None)
        for step in (steps.limits, steps.offsets, steps.resistance_roughly, winding_roughly):
            step(bench)
        found = steps.alignment(bench)
    assert found.parameters["encoder_reversed"] == 0.0
    assert bench.known.pole_pairs == machine.plant["pole_pairs"]


def test_the_command_writes_what_it_found_and_keeps_the_way_back(evenspin, tmp_path: Path) -> None:
    machine = random_machine(5)
    path, out = tmp_path / "m.toml", tmp_path / "out"
    path.write_text(machine.toml())
    words = ("commission", "--port", f"sim:{path}", "--max-current", machine.max_current_a, "--yes", "--no-methods")
    said = evenspin(*words, "--out", out, "--json")
    assert said.status == 0, said.err
    given = json.loads(said.out)
    assert given["good"] and given["pole_pairs"] == machine.plant["pole_pairs"]
    found = load_machine(out / "model.toml")
    assert found.plant["resistance_ohm"] == pytest.approx(machine.plant["resistance_ohm"], rel=0.03)
    low, high = found.ranges["lq_h"]
    assert low <= machine.plant["lq_h"] <= high
    assert found.drive["pole_pairs"] == machine.plant["pole_pairs"]  # of drive.toml beside it
    report = (out / "report.md").read_text()
    assert "**GOOD**" in report and "Performed by" in report and "NOT GOOD" not in report
    rough = [line for line in report.splitlines() if line.startswith("|") and "roughly" in line]
    assert len(rough) >= 4 and not any("+-" in line for line in rough)  # their bias is larger than their scatter
    back = evenspin("commission", "--port", f"sim:{path}?fresh=1", "--undo", out)
    assert (back.status, back.out.splitlines()[-1]) == (0, "0 parameters put back")  # a new drive is as it was before
    again = evenspin(*words, "--out", out)
    assert again.status == 2 and "recording" in again.err


def test_a_bad_step_is_exit_status_1_with_a_report(evenspin, tmp_path: Path) -> None:
    """A brake that no current overcomes."""
    machine = random_machine(5)
    path, out = tmp_path / "m.toml", tmp_path / "out"
    path.write_text(machine.toml().replace("torque_nm = ", "torque_nm = 100"))
    said = evenspin(
        "commission", "--port", f"sim:{path}", "--max-current", machine.max_current_a, "--yes", "--out", out
    )
    assert said.status == 1
    assert "NOT GOOD" in (out / "report.md").read_text()
    assert (out / "before.toml").exists() and not (out / "model.toml").exists()


@pytest.mark.parametrize(
    ("words", "about"),
    [
        ((), "--max-current"),
        (("--max-current", "5"), "--out"),
        (("--max-current", "-5", "--out", "x"), "--max-current"),
        (("--max-current", "5", "--out", "x", "--goal", "quick"), "--goal"),
    ],
)
def test_what_is_missing_or_wrong_is_one_line(evenspin, tmp_path: Path, words: tuple[str, ...], about: str) -> None:
    words = tuple(str(tmp_path / word) if word == "x" else word for word in words)
    said = evenspin("commission", "--port", "sim:servo", *words)
    assert (said.status, len(said.err.splitlines())) == (2, 1)
    assert about in said.err


def test_limits_below_the_supply_are_refused() -> None:
    with pytest.raises(InputError, match="--max-voltage"):
        limits.blank(Bounds(5.0, max_voltage_v=20.0), 24.0, 300.0)


def test_the_drive_of_a_commissioning_checks_its_zero_and_never_starts_by_itself() -> None:
    row = run(random_machine(5), methods=False)
    values = drive_values(row.done)
    assert values["zero_check"] == 1.0 and "auto_run" not in values
