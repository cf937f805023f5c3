"""A drive of another maker, in numpy alone: PI speed control on torque, cogging, friction that sticks, a counted angle.

Nothing of the package is in here: what it says about a log of this drive is held against what was put in.
Torque is in amperes of q current: J/Kt, B/Kt, Coulomb and cogging in A.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

STEP_HZ, CONTROL, ROW = 8000, 2, 4  # integration; steps per period of the controller; steps per row of the log
KT = 0.0525  # N m/A of the machine, for its model file
PAIRS = 7


@dataclass(frozen=True)
class Machine:
    """What is in the drive, and how it is driven."""

    inertia_as2: float = 9.52e-4
    coulomb_a: float = 0.076
    viscous_as: float = 3.8e-4
    cogging_a: float = 0.0
    order: int = 42
    load_a: float = 0.0
    counts: int = 2**14
    noise_a: float = 0.01
    bandwidth_hz: float = 8.0  # of the speed loop
    knots: tuple[tuple[float, float], ...] = field(default=())  # (s, rad/s) of the reference; () is a sine
    swing_rad_s: float = 20.0
    period_s: float = 15.0
    duration_s: float = 30.0
    seed: int = 1


def reference(machine: Machine, t_s: np.ndarray) -> np.ndarray:
    if machine.knots:
        at, value = zip(*machine.knots, strict=True)
        return np.interp(t_s, at, value)
    return machine.swing_rad_s * np.sin(2.0 * np.pi * t_s / machine.period_s)


def steps(*levels: tuple[float, float], ramp_s: float = 0.3) -> tuple[tuple[float, float], ...]:
    """Constant speeds (rad/s, s) with short ramps between; from rest."""
    at, last, knots = 0.0, 0.0, [(0.0, 0.0)]
    for speed, lasting_s in levels:
        knots += [(at, last), (at + ramp_s, speed)]
        at, last = at + lasting_s, speed
    return (*knots, (at, last))


def run(machine: Machine) -> dict[str, np.ndarray]:
    """Columns of a log."""
    rng = np.random.default_rng(machine.seed)
    count = round(machine.duration_s * STEP_HZ)
    dt = 1.0 / STEP_HZ
    ref = reference(machine, dt * np.arange(count)).tolist()
    noise = rng.normal(0.0, machine.noise_a, count // ROW + 1)
    j, b, tc, load, a, k = (
        machine.inertia_as2, machine.viscous_as, machine.coulomb_a, machine.load_a, machine.cogging_a, machine.order,
    )  # fmt: skip
    quantum = 2.0 * math.pi / machine.counts
    kp = j * 2.0 * math.pi * machine.bandwidth_hz
    ki = kp * 2.0 * math.pi * machine.bandwidth_hz / 5.0
    period = CONTROL * dt
    keep, mix = math.exp(-period / 1.5e-3), 1.0 - math.exp(-dt / 0.5e-3)  # speed filter; current loop
    theta, w, iq, iq_ref, total = float(rng.uniform(0.0, 6.0)), ref[0], 0.0, 0.0, 0.0
    phase = float(rng.uniform(0.0, 6.0))
    seen, estimate = math.floor(theta / quantum), w
    rows = []
    sin, floor, stick = math.sin, math.floor, tc * dt / j
    for n in range(count):
        if n % CONTROL == 0:
            now = floor(theta / quantum)
            estimate = keep * estimate + (1.0 - keep) * (now - seen) * quantum / period
            seen = now
            error = ref[n] - estimate
            total += ki * period * error
            iq_ref = kp * error + total
        if n % ROW == 0:
            rows.append((n * dt, now * quantum, estimate, ref[n], iq + noise[n // ROW]))
        iq += mix * (iq_ref - iq)
        free = w + dt / j * (iq - a * sin(k * theta + phase) - load - b * w)
        w = 0.0 if abs(free) <= stick else free - math.copysign(stick, free)
        theta += dt * w
    table = np.array(rows)
    return dict(zip(("t_s", "theta_m_rad", "speed_rad_s", "speed_ref_rad_s", "iq_a"), table.T, strict=True))


def write(path: Path, columns: dict[str, np.ndarray]) -> Path:
    np.savetxt(
        path, np.column_stack(list(columns.values())), fmt="%.6f", delimiter=",", header=",".join(columns), comments=""
    )
    return path


def model_file(path: Path, machine: Machine, *, inertia: bool = True) -> Path:
    """The machine as its data sheet has it: without Coulomb friction, cogging and load."""
    lines = [
        'name = "own"', "[plant]", f"pole_pairs = {PAIRS}", "resistance_ohm = 0.3", "ld_h = 2e-4", "lq_h = 2e-4",
        f"psi_wb = {KT / 1.5 / PAIRS!r}", f"viscous_nms = {machine.viscous_as * KT!r}", "dc_link_v = 48.0",
    ]  # fmt: skip
    lines += [f"inertia_kgm2 = {machine.inertia_as2 * KT!r}"] if inertia else []
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


PROFILES = ("sweep", "step", "ramps", "levels", "both ways")


def drawn(seed: int) -> tuple[str, Machine]:
    """A machine and a profile at random, around the one above."""
    rng = np.random.default_rng([77, seed])
    profile = PROFILES[seed % len(PROFILES)]
    top = float(rng.uniform(12.0, 60.0))
    machine = Machine(
        inertia_as2=9.52e-4 * float(np.exp(rng.uniform(-1.0, 1.0))),
        coulomb_a=0.076 * float(np.exp(rng.uniform(-1.2, 1.0))),
        viscous_as=3.8e-4 * float(np.exp(rng.uniform(-1.0, 1.0))),
        cogging_a=float(rng.choice([0.0, 0.02, 0.06, 0.23])) * float(rng.uniform(0.8, 1.2)),
        order=int(rng.choice([12, 18, 24, 36, 42, 60, 72, 84])),
        counts=2 ** int(rng.integers(10, 18)),
        noise_a=float(np.exp(rng.uniform(np.log(0.002), np.log(0.02)))),
        bandwidth_hz=float(rng.uniform(3.0, 15.0)),
        swing_rad_s=top,
        period_s=float(rng.uniform(5.0, 15.0)),
        seed=1000 + seed,
    )
    share = rng.uniform(0.15, 1.0, 6)
    if profile == "step":
        knots = steps((top * share[0] / 2.0, 15.0), (top, 15.0))
    elif profile == "ramps":
        at = np.linspace(0.0, 30.0, 7)
        knots = tuple((float(s), float(v)) for s, v in zip(at, [0.0, top, 5.0, top, -top, -5.0, -top], strict=True))
    elif profile == "levels":
        knots = steps(*((float(top * each), 5.0) for each in np.sort(share)))
    elif profile == "both ways":
        knots = steps(*((float(top * each * (-1.0) ** i), 5.0) for i, each in enumerate(np.sort(share))))
    else:
        knots = ()
    return profile, replace(machine, knots=knots)


TRUTH = {
    "inertia.inertia_as2_per_rad": "inertia_as2",
    "viscous_friction.viscous_as_per_rad": "viscous_as",
    "coulomb_friction.torque_a_equiv": "coulomb_a",
    "load_torque.torque_a_equiv": "load_a",
}


def names_wrong(verdict: dict[str, Any], machine: Machine) -> list[str]:
    """Names that are not in the drive, and those of the drive that are not named; a group holds each of its names."""
    there = {"coulomb_friction"} | ({"cogging"} if machine.cogging_a else set())
    there |= {"load_torque"} if machine.load_a else set()
    groups = [set(name.split(" or ")) for name in verdict["verdict"]]
    wrong = [name for name, group in zip(verdict["verdict"], groups, strict=True) if not group & there]
    wrong += [f"missing: {name}" for name in sorted(there) if not any(name in group for group in groups)]
    if "cogging" in verdict["parameters"] and verdict["parameters"]["cogging"]["order"] != machine.order:
        wrong.append("order of the cogging")
    return wrong


def intervals(verdict: dict[str, Any], machine: Machine) -> list[tuple[str, float, float, float]]:
    """(what, truth, value, half width) of everything that is given with an interval."""
    identified = verdict["identified"]
    found = [
        (name, float(getattr(machine, field_)), identified[name]["value"], identified[name]["half"])
        for name, field_ in TRUTH.items()
        if name in identified
    ]
    for line in verdict["orders"]:
        if line["in_both_halves"] and line["amplitude_a_equiv"] is not None:
            truth = machine.cogging_a if line["order"] == machine.order else 0.0
            found.append((f"order {line['order']}", truth, line["amplitude_a_equiv"], line["half_a_equiv"]))
    return found
