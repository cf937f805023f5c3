"""What is simulated with the tuned drive: start, load step, reversal, full speed; and a slow speed with ripple."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.model.setup import InputCurve, Setup
from evenspin.native import tables
from evenspin.run.outcome import Outcome, outcome_of
from evenspin.sim import simulate
from evenspin.sim.record import Record
from evenspin.tune.gains import complete

Numbers = Mapping[str, float]
Array = NDArray[np.float64]

SIGNALS = (
    "t_s", "fault", "state", "iq_ref_a", "true_speed_rad_s", "true_theta_m_rad", "true_iq_a", "true_ia_a", "true_ib_a",
    "true_ic_a", "position_error_rad",
)  # fmt: skip
SIMULATED = {"auto_run": 1.0, "align_periods": 0.0, "offset_calibration_periods": 0.0}
LOAD_PART, SPEED_PART = 0.3, 0.3  # of rated torque, of the top speed
VOLTAGE_PART = 0.92  # of the dc link over sqrt(3): what the current loop needs to act
LOG_HZ = 2000.0
MOST_S = 120.0


@dataclass(frozen=True, slots=True)
class Stretch:
    """From one change to the next."""

    name: str
    start_s: float
    end_s: float
    reference_rad_s: float
    load_nm: float
    ramp: bool = False


@dataclass(frozen=True, slots=True)
class Response:
    """What the drive did in a stretch. `overshoot`: rad/s; `dip`: after a load step, rad/s; `settled_s`: within 2 %."""

    stretch: Stretch
    mean_rad_s: float
    overshoot_rad_s: float
    dip_rad_s: float
    settled_s: float
    peak_a: float

    @property
    def reached(self) -> bool:
        return abs(self.mean_rad_s - self.stretch.reference_rad_s) <= 0.02 * abs(self.stretch.reference_rad_s) + 0.05


@dataclass(frozen=True, slots=True)
class Trial:
    """A run with its verdict: `problems` are empty when it is good."""

    name: str
    outcome: Outcome
    responses: tuple[Response, ...]
    problems: tuple[str, ...]
    peak_a: float

    @property
    def good(self) -> bool:
        return not self.problems


def torque_per_a(plant: Numbers) -> float:
    return 1.5 * plant["pole_pairs"] * plant["psi_wb"]


def rated_torque(plant: Numbers, drive: Numbers) -> float:
    """Of the plate, of the rated current, or half of the largest torque; never more than 0.6 of the largest."""
    largest = torque_per_a(plant) * drive["iq_limit_a"]
    known = plant["rated_torque_nm"] or torque_per_a(plant) * plant["rated_current_a"] or 0.5 * largest
    return min(known, 0.6 * largest)


def top_speed(plant: Numbers, drive: Numbers, load_nm: float = 0.0) -> float:
    """Fastest that the limits of the drive and its supply allow under this load, rad/s."""
    psi, p = plant["psi_wb"], plant["pole_pairs"]
    voltage = VOLTAGE_PART * plant["dc_link_v"] / math.sqrt(3.0)
    if drive.get("voltage_limit_v", 0.0) > 0.0:
        voltage = min(voltage, VOLTAGE_PART * drive["voltage_limit_v"])
    low, high = 0.0, voltage / (p * psi)
    for _ in range(40):
        w = 0.5 * (low + high)
        current = (load_nm + plant["viscous_nms"] * w) / torque_per_a(plant)
        need = math.hypot(p * w * psi + plant["resistance_ohm"] * current, p * w * plant["lq_h"] * current)
        low, high = (w, high) if need <= voltage else (low, w)
    return min(low, 0.8 * drive["over_speed_rad_s"])


def simulated(plant: Numbers, drive: Numbers, duration_s: float, **inputs: InputCurve) -> Setup:
    full = {name: each.default for name, each in tables().model.items()} | dict(plant)
    return Setup(
        name="trial", plant=full, drive=complete(drive) | SIMULATED, effects={}, inputs=inputs, tunes=(),
        duration_s=duration_s, log_rate_hz=LOG_HZ, seed=1,
    )  # fmt: skip


def speed_trial(plant: Numbers, drive: Numbers, overshoot_part: float, name: str, patience: float = 1.0) -> Trial:
    """The four of them, one after the other; `patience`: how much longer than the loop alone it may take to settle."""
    stretches = _stretches(plant, drive, patience)
    setup = simulated(
        plant, drive, stretches[-1].end_s,
        speed_ref_rad_s=_references(stretches),
        load_brake_nm=InputCurve(tuple(s.start_s for s in stretches), tuple(s.load_nm for s in stretches)),
    )  # fmt: skip
    record = simulate(_on_board(setup), SIGNALS)
    outcome = outcome_of(setup, record)
    problems = [said(outcome)] if not outcome.good else []
    responses = tuple(
        _response(record, before, s) for before, s in zip([None, *stretches[:-1]], stretches, strict=True)
    )
    peak = float(max(np.abs(record[f"true_i{phase}_a"]).max() for phase in "abc"))
    if outcome.good:
        for r in responses[1:]:
            if not r.reached:
                problems.append(
                    f"{r.stretch.name}: {r.mean_rad_s:.4g} instead of {r.stretch.reference_rad_s:.4g} rad/s at the end"
                )
            step = abs(r.stretch.reference_rad_s - _before(responses, r))
            if step > 0.0 and r.overshoot_rad_s > overshoot_part * step:
                problems.append(f"{r.stretch.name}: overshoot of {100.0 * r.overshoot_rad_s / step:.0f} % of the step")
    return Trial(name, outcome, responses, tuple(problems), peak)


def said(outcome: Outcome) -> str:
    """What happened, without the advice for a run of one's own."""
    return outcome.text.split(" Check first:")[0].split("; check the gains")[0]


def _on_board(setup: Setup) -> Setup:
    """On a board on which the limits of the drive fit: the trial is about the drive."""
    from evenspin.motor.limits import beyond_board

    return replace(setup, plant={**setup.plant, **beyond_board(setup.drive, setup.plant)})


def _before(responses: tuple[Response, ...], response: Response) -> float:
    return responses[responses.index(response) - 1].stretch.reference_rad_s


def _stretches(plant: Numbers, drive: Numbers, patience: float) -> list[Stretch]:
    load = LOAD_PART * rated_torque(plant, drive)
    slow = SPEED_PART * top_speed(plant, drive)
    full = top_speed(plant, drive)
    kp = drive["speed_kp_a_per_unit"] * drive["speed_error_gain"]
    rest_s = 12.0 * drive["speed_kp_a_per_unit"] / max(drive["speed_ki_a_per_unit_s"], 1e-9)
    rest_s = patience * max(rest_s, 12.0 * plant["inertia_kgm2"] / (kp * torque_per_a(plant)), 0.15)
    plan = [("rest", 0.0, 0.0), ("start", slow, 0.0), ("load step", slow, load), ("load off", slow, 0.0),
            ("reversal", -slow, 0.0), ("full speed", full, 0.0)]  # fmt: skip
    stretches, at_s, speed = [], 0.0, 0.0
    for name, reference, torque in plan:
        change_s = abs(reference - speed) * plant["inertia_kgm2"] / (0.7 * torque_per_a(plant) * drive["iq_limit_a"])
        ramp = name == "full speed"
        length = 0.05 if name == "rest" else min(4.0 * change_s + 2.0 * rest_s if ramp else change_s + rest_s, MOST_S)
        length = max(round(length * LOG_HZ), 100) / LOG_HZ
        stretches.append(Stretch(name, at_s, at_s + length, reference, torque, ramp))
        at_s, speed = at_s + length, reference
    return stretches


def _references(stretches: list[Stretch]) -> InputCurve:
    """Steps, and a ramp over half of its stretch where there is one."""
    points, value = [(0.0, 0.0)], 0.0
    for s in stretches[1:]:
        length = 0.5 * (s.end_s - s.start_s) if s.ramp else 1e-9
        points += [(s.start_s, value), (s.start_s + length, s.reference_rad_s)]
        value = s.reference_rad_s
    starts = tuple(s.start_s for s in stretches)
    return InputCurve(tuple(t for t, _ in points), tuple(v for _, v in points), linear=True, at_s=starts)


def _response(record: Record, before: Stretch | None, stretch: Stretch) -> Response:
    part = record.between(stretch.start_s, stretch.end_s)
    speed, t_s = part["true_speed_rad_s"], part["t_s"]
    last = speed[-max(len(speed) // 5, 2) :]
    came_from = before.reference_rad_s if before is not None else 0.0
    way = math.copysign(1.0, stretch.reference_rad_s - came_from)
    beyond = float((way * (speed - stretch.reference_rad_s)).max(initial=0.0)) if before else 0.0
    loaded = before is not None and stretch.reference_rad_s == before.reference_rad_s
    dip = float(np.abs(speed - stretch.reference_rad_s).max()) if loaded else 0.0
    outside = np.flatnonzero(np.abs(speed - stretch.reference_rad_s) > 0.02 * abs(stretch.reference_rad_s) + 0.05)
    settled = float(t_s[outside[-1]] - stretch.start_s) if len(outside) else 0.0
    peak = float(max(np.abs(part[f"true_i{phase}_a"]).max() for phase in "abc"))
    return Response(stretch, float(last.mean()), 0.0 if loaded else beyond, dip, settled, peak)


# ---- ripple


@dataclass(frozen=True, slots=True)
class Ripple:
    """At a slow speed with a torque tied to the angle. `rms`: rad/s of speed, or rad of position; `growth`: that over
    the same of the turns halfway."""

    outcome: Outcome
    rms: float
    learned_s: float
    growth: float = 1.0


def ripple_of(plant: Numbers, drive: Numbers, speed_rad_s: float, turns: float) -> Ripple:
    """rms of the speed about its mean over the last whole turns."""
    turn_s = 2.0 * math.pi / speed_rad_s
    lead_in = 0.5 + 2.0 * speed_rad_s * plant["inertia_kgm2"] / (0.5 * torque_per_a(plant) * drive["iq_limit_a"])
    duration = round((lead_in + min(turns * turn_s, MOST_S)) * LOG_HZ) / LOG_HZ
    setup = simulated(plant, drive, duration, speed_ref_rad_s=InputCurve((0.0,), (speed_rad_s,)))
    setup = _on_board(replace(setup, effects=test_ripple(plant, drive)))
    record = simulate(setup, SIGNALS)
    outcome = outcome_of(setup, record)
    tail = record.between(duration - 4.0 * turn_s, duration)
    return Ripple(outcome, float(tail["true_speed_rad_s"].std()), duration)


def position_ripple(plant: Numbers, drive: Numbers, speed_rad_s: float, turns: float) -> Ripple:
    """rms of the position error over the last turns of a motion at constant speed."""
    turn_s = 2.0 * math.pi / speed_rad_s
    accel_s = speed_rad_s / max(drive["profile_accel_rad_s2"], 1e-9)
    moves_s = min(turns * turn_s, MOST_S)
    duration = round((moves_s + accel_s + 0.2) * LOG_HZ) / LOG_HZ
    setup = simulated(
        plant, {**drive, "profile_speed_rad_s": speed_rad_s}, duration,
        control_mode=InputCurve((0.0,), (2.0,)), position_ref_rad=InputCurve((0.0,), (1.5 * speed_rad_s * duration,)),
    )  # fmt: skip
    setup = _on_board(replace(setup, effects=test_ripple(plant, drive)))
    record = simulate(setup, SIGNALS)
    outcome = outcome_of(setup, record)
    length = min(4.0 * turn_s, 0.5 * moves_s)
    rms, halfway = (
        float(record.between(end - length, end)["position_error_rad"].std())
        for end in (duration, duration - 0.5 * (moves_s - length))
    )
    return Ripple(outcome, rms, duration, rms / halfway if halfway > 0.0 else 1.0)


def test_ripple(plant: Numbers, drive: Numbers) -> dict[str, dict[str, float]]:
    """What drives have: a first electrical order from current offsets, and cogging; 2 and 1 % of the rated torque."""
    rated = rated_torque(plant, drive)
    return {
        "torque_ripple": {
            "order_1": plant["pole_pairs"], "amplitude_1_nm": 0.02 * rated, "phase_1_rad": 0.3,
            "order_2": 6.0 * plant["pole_pairs"], "amplitude_2_nm": 0.01 * rated, "phase_2_rad": 1.1,
        }
    }  # fmt: skip
