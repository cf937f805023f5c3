"""A pseudo-random torque on the simulated drive, as one would do it on a bench.

First the speed controller brings the drive to its mean speed and measures the current that keeps it there; then, in
current mode, a maximum-length sequence is added to that current. Amplitude and bit time come from what is known of the
machine: the speed may swing by SWING of its mean, the current stays within half of the rated one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError, NativeError
from evenspin.log import LOG_COLUMNS
from evenspin.model.machine import Machine
from evenspin.model.setup import InputCurve, Setup
from evenspin.native import tables
from evenspin.sim import Record, prepare

Array = NDArray[np.float64]

WHERE = "identify mechanics"
SWING = 0.3
MEAN = 1.0 / 6.0  # of the speed that trips the drive
SETTLE_S, AVERAGE_S = 3.0, 1.0
BIT_S = (0.02, 0.2)
BITS = (4, 12)
LOG_HZ = 2000.0


@dataclass(frozen=True, slots=True)
class Plan:
    """The experiment. `expected_swing_rad_s` is for the inertia and friction of the model."""

    speed_rad_s: float
    amplitude_a: float
    bit_s: float
    signs: Array
    expected_swing_rad_s: float

    @property
    def duration_s(self) -> float:
        return SETTLE_S + len(self.signs) * self.bit_s

    def as_json(self) -> dict[str, Any]:
        return {
            "speed_rpm": self.speed_rad_s * 30.0 / math.pi,
            "amplitude_a": self.amplitude_a,
            "bit_s": self.bit_s,
            "sequence_bits": len(self.signs),
            "duration_s": self.duration_s,
            "expected_swing_rpm": self.expected_swing_rad_s * 30.0 / math.pi,
        }


def plan(
    machine: Machine,
    drive: dict[str, float],
    *,
    speed_rpm: float | None = None,
    amplitude_a: float | None = None,
    bit_s: float | None = None,
    bits: int = 7,
) -> Plan:
    """What is safe for this drive, unless the user sets other values."""
    from scipy.signal import max_len_seq

    plant = machine.plant
    trip_rad_s, limit_a = drive["over_speed_rad_s"], min(drive["iq_limit_a"], 0.5 * drive["over_current_a"])
    speed = MEAN * trip_rad_s if speed_rpm is None else speed_rpm * math.pi / 30.0
    if not 0.0 < speed < 0.5 * trip_rad_s:
        most = 0.5 * trip_rad_s * 30.0 / math.pi
        must = f"above 0 and below {most:.0f} rpm, half of what trips the drive"
        raise InputError(WHERE, "--speed-rpm", speed_rpm, must, "lower it")
    if not BITS[0] <= bits <= BITS[1]:
        raise InputError(WHERE, "--bits", bits, f"within {BITS[0]} .. {BITS[1]}", "7 gives 127 bits")
    tau_s = plant["inertia_kgm2"] / max(plant["viscous_nms"], 1e-12)
    pwm_s = 1.0 / plant["pwm_hz"]
    bit = float(np.clip(tau_s / 5.0, *BIT_S)) if bit_s is None else bit_s
    if not 0.005 <= bit <= 5.0:
        raise InputError(WHERE, "--bit-s", bit_s, "within 0.005 .. 5 s", "a fifth of J / B is good")
    bit = round(bit / pwm_s) * pwm_s
    signs = 2.0 * max_len_seq(bits)[0] - 1.0
    per_a = float(machine.torque_per_a_nm / plant["inertia_kgm2"] * _peak_s(signs, bit, tau_s))
    most_a = min(0.5 * plant["rated_current_a"], limit_a) if plant["rated_current_a"] > 0.0 else limit_a
    amplitude = min(SWING * speed / per_a, most_a) if amplitude_a is None else amplitude_a
    if not 0.0 < amplitude <= limit_a:
        raise InputError(WHERE, "--amplitude-a", amplitude_a, f"above 0 and at most {limit_a:g} A", "lower it")
    return Plan(speed, float(amplitude), bit, signs, float(amplitude) * per_a)


def _peak_s(signs: Array, bit_s: float, tau_s: float) -> float:
    """Largest speed deviation for an acceleration of +-1: a first-order lag of tau_s."""
    keep = math.exp(-bit_s / tau_s)
    gain, value, peak = tau_s * -math.expm1(-bit_s / tau_s), 0.0, 0.0
    for sign in signs:
        value = keep * value + gain * float(sign)
        peak = max(peak, abs(value))
    return peak


def perform(machine: Machine, drive: dict[str, float], wanted: Plan, seed: int = 1, numeric: str = "float") -> Record:
    """The log of the experiment; its first SETTLE_S are under speed control."""
    setup = setup_of(machine, drive, wanted, seed)
    simulation = prepare(setup, (*LOG_COLUMNS, "fault"), numeric)
    settle = round(SETTLE_S * setup.pwm_hz / setup.decimate) * setup.decimate
    before = simulation.run(settle, setup.decimate)
    names = (*LOG_COLUMNS, "fault")
    last = before[-round(AVERAGE_S * setup.log_rate_hz) :]
    mean_a = float(last[:, names.index("iq_a")].mean())
    speed = float(np.unwrap(last[:, names.index("theta_m_rad")])[[0, -1]] @ [-1.0, 1.0]) / AVERAGE_S
    if not before[:, names.index("fault")].any() and abs(speed - wanted.speed_rad_s) > 0.05 * wanted.speed_rad_s:
        given = f"{speed * 30.0 / math.pi:.0f} rpm"
        must = f"near {wanted.speed_rad_s * 30.0 / math.pi:.0f} rpm after {SETTLE_S:g} s"
        raise InputError(WHERE, "speed", given, must, "check the speed controller of the model")
    edges_s = SETTLE_S + wanted.bit_s * np.arange(len(wanted.signs))
    simulation.set_input("iq_ref_a", edges_s, mean_a + wanted.amplitude_a * wanted.signs)
    simulation.set_input("control_mode", (0.0, SETTLE_S), (1.0, 0.0))
    after = simulation.run(setup.periods - settle, setup.decimate)
    values = np.concatenate((before, after))
    tripped = values[:, names.index("fault")]
    if tripped.any():
        fault = tables().faults[int(tripped.max())]
        raise NativeError(f"{machine.name}: the drive tripped: {fault.name}; lower --amplitude-a or --speed-rpm")
    record = Record(names, tuple(tables().signals[name].unit for name in names), values)
    return record.pick(LOG_COLUMNS)


def setup_of(machine: Machine, drive: dict[str, float], wanted: Plan, seed: int) -> Setup:
    """The speed-controlled part; perform() goes on from there."""
    plain = {"method": tables().params["method"].to_number("pi"), "auto_run": 1.0}
    return Setup(
        name=f"{machine.name}-prbs",
        plant=machine.plant,
        drive=drive | plain,
        effects=machine.effects,
        inputs={"speed_ref_rad_s": InputCurve((0.0,), (wanted.speed_rad_s,))},
        tunes=(),
        duration_s=wanted.duration_s,
        log_rate_hz=LOG_HZ,
        seed=seed,
    )
