"""All steps in order, then tuning and a proof. On any error the bridge is off and the drive is as before."""

from __future__ import annotations

import contextlib
import math
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from evenspin.bench.client import Drive
from evenspin.bench.numbers import Mode, State
from evenspin.bench.schema import own_schema
from evenspin.commission import motion, steps, windings
from evenspin.commission.findings import Known, Quality, Step
from evenspin.commission.limits import ASKED_PART, OVER_SPEED_PART, Bounds
from evenspin.commission.signals import need_rest, rows
from evenspin.errors import EvenspinError
from evenspin.model.machine import SIMULATED, Machine, load_machine
from evenspin.motor.files import model_toml
from evenspin.native import tables
from evenspin.tune.tuning import Tuning, tune

Progress = Callable[[float], None]
Say = Callable[[str], None]

PROOF_PART = 0.3  # of the top speed
RAMP_LEAST_S, RAMP_MOST_S, RAMP_STEP_S, MOST_STEPS = 0.3, 20.0, 0.004, 600
STEPS = ("limits", "offsets", "current", "winding", "alignment", "d axis", "q axis", "spin", "tune", "proof")


@dataclass
class Commissioned:
    """What was done. `error`: why it ended early; then the drive has its values from before."""

    bounds: Bounds
    goal: str
    before: Mapping[str, float]
    known: Known = field(default_factory=Known)
    steps: list[Step] = field(default_factory=list)
    tuning: Tuning | None = None
    machine: Machine | None = None
    error: str = ""
    seconds: float = 0.0

    @property
    def good(self) -> bool:
        return not self.error and self.tuning is not None and all(step.good for step in self.steps)


def commission(
    drive: Drive,
    bounds: Bounds,
    goal: str,
    *,
    methods: bool = True,
    progress: Progress | None = None,
    say: Say | None = None,
) -> Commissioned:
    """Measure, tune, prove. When everything is good the drive keeps the new parameters until power-off."""
    progress, say = progress or (lambda _: None), say or (lambda _: None)
    done = Commissioned(bounds, goal, drive.get())
    bench = steps.Bench(drive, bounds, done.known, say)
    began = bench.clock
    work = (
        steps.limits,
        steps.offsets,
        steps.resistance_roughly,
        windings.winding_roughly,
        steps.alignment,
        windings.d_axis,
        windings.q_axis,
        motion.spin,
    )
    try:
        for number, step in enumerate(work):
            found = step(bench)
            done.steps.append(found)
            say(f"{found.name}: {'good' if found.good else 'NOT GOOD'}")
            progress((number + 1) / len(STEPS))
            if not found.good:
                bad = "; ".join(str(quality) for quality in found.qualities if not quality.good)
                done.error = f"{found.name}: {bad}"
                break
        if not done.error:
            _tune(done, goal, methods)
            progress((len(work) + 1) / len(STEPS))
            done.steps.append(_proof(bench, done))
            if not done.steps[-1].good:
                done.error = f"proof: {'; '.join(str(q) for q in done.steps[-1].qualities if not q.good)}"
    except EvenspinError as error:
        done.error = str(error)
    finally:
        done.seconds = bench.clock - began
        if not drive.link.lost:
            drive.stop()
        if not done.good or len(done.steps) < len(work) + 1:  # Ctrl-C in the proof, too
            put_back(drive, done.before)
    progress(1.0)
    return done


def put_back(drive: Drive, before: Mapping[str, float]) -> None:
    """The values from before the first step."""
    if drive.link.lost:
        return
    with contextlib.suppress(EvenspinError):
        drive.stop()
        drive.set(before)


def _tune(done: Commissioned, goal: str, methods: bool) -> None:
    """From what was measured, with the intervals as tolerances."""
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "measured.toml"
        limits = {
            "iq_limit_a": ASKED_PART * done.bounds.max_current_a, "id_limit_a": ASKED_PART * done.bounds.max_current_a,
            "over_current_a": done.bounds.max_current_a,
        }  # fmt: skip
        if done.bounds.max_speed_rad_s:
            limits["over_speed_rad_s"] = min(OVER_SPEED_PART * done.bounds.max_speed_rad_s, done.known.over_speed_rad_s)
        if done.bounds.max_voltage_v:
            limits["over_voltage_v"] = done.bounds.max_voltage_v
        text = model_text(done, "measured").replace('drive_file = "drive.toml"\n', "")
        text += "\n[drive]\n" + "".join(f"{name} = {value!r}\n" for name, value in limits.items())
        path.write_text(text, encoding="utf-8")
        machine = load_machine(path, SIMULATED)
    found = tune(machine, goal, methods=methods)
    done.machine = machine
    if not found.good:
        done.error = "tune: " + "; ".join(found.problems)
    done.tuning = found


def drive_values(done: Commissioned) -> dict[str, float]:
    """What goes into the drive and into its file: tuned, with electrical zero and friction as measured."""
    assert done.tuning is not None
    known = done.known
    more = {
        "encoder_offset_rad": known.offset_rad, "encoder_reversed": float(known.reversed), "zero_check": 1.0,
        "plausibility_share": tables().params["plausibility_share"].default,
        "restart_limit": tables().params["restart_limit"].default,
        "rdc_coulomb_nm": max(known.coulomb.value, 0.0), "rdc_static_nm": max(known.coulomb.value, 0.0),
    }  # fmt: skip
    for step in done.steps:
        more |= {
            name: value
            for name, value in step.parameters.items()
            if name in ("align_periods", "align_turns", "align_rest_s")
        }
    return done.tuning.drive | more


def _proof(bench: steps.Bench, done: Commissioned) -> Step:
    """The tuned drive turns the motor both ways."""
    since, drive = bench.clock, bench.drive
    assert done.tuning is not None
    need_rest(drive)
    accepted = drive.set(drive_values(done))
    top = done.tuning.top_rad_s
    speed = PROOF_PART * top
    qualities = []
    names = ("speed_rad_s", "theta_m_rad", "iq_a", "id_a")
    for way in (1.0, -1.0):
        target = way * speed
        _ramp(bench, target)
        drive.sleep(0.5)
        with drive.stream(names, rate_hz=1000.0) as stream:
            values = rows(stream, max(1.0, min(4.0 * math.pi / speed, 10.0)))
        drive.need_no_fault()
        theta = np.unwrap(values[:, 1])
        mean = float((theta[-1] - theta[0]) / (len(theta) - 1) * 1000.0)
        uneven = float(values[:, 0].std())
        current = float(np.hypot(values[:, 2], values[:, 3]).max())
        what = f"at {target:.4g} rad/s"
        qualities += [
            Quality(f"speed {what}", mean, 0.0, "rad/s", *sorted((0.98 * target, 1.02 * target))),
            Quality(f"ripple {what}, rms of the speed that the drive sees", uneven, 0.0, "rad/s", 0.0, 0.1 * speed),
            Quality(f"current {what}, largest", current, 0.0, "A", 0.0, bench.bounds.max_current_a),
        ]
    _ramp(bench, 0.0)
    need_rest(drive)
    return bench.done("proof", "the tuned drive turns the motor both ways", since, qualities, accepted)


def _ramp(bench: steps.Bench, target: float) -> None:
    """To this speed with a tenth of the largest torque, in small steps."""
    drive, known = bench.drive, bench.known
    now = drive.read(("speed_rad_s",))["speed_rad_s"] if drive.state().state == State.RUN else 0.0
    slope = 0.1 * known.torque_per_a * bench.bounds.max_current_a / known.inertia.value
    seconds = min(max(abs(target - now) / slope, RAMP_LEAST_S), RAMP_MOST_S)
    count = max(1, min(MOST_STEPS, round(seconds / RAMP_STEP_S)))
    for k in range(1, count + 1):
        value = now + (target - now) * k / count
        if k == 1 and drive.state().state != State.RUN:
            drive.run_speed(value)
        else:
            drive.setpoint(Mode.SPEED, speed_rad_s=value)
        drive.sleep(seconds / count)
        if k % 20 == 0:
            drive.need_no_fault()


# ---- the model


def model_text(done: Commissioned, name: str) -> str:
    """What was measured as a model file, each number with its interval."""
    known = done.known

    def measured(step: str, value: float, half: float) -> tuple[float, str]:
        return value, f"measured ({step}), +- {half:.2g}"

    numbers = {
        "pole_pairs": (float(known.pole_pairs), "measured (alignment)"),
        "resistance_ohm": measured("alignment, d axis", known.resistance.value, known.resistance.half),
        "ld_h": measured("d axis", known.ld.value, known.ld.half),
        "lq_h": measured("q axis", known.lq.value, known.lq.half),
        "psi_wb": measured("spin", known.psi.value, known.psi.half),
        "inertia_kgm2": measured("spin", known.inertia.value, known.inertia.half),
        "viscous_nms": measured("spin", max(known.viscous.value, 0.0), known.viscous.half),
        "rated_current_a": (0.5 * done.bounds.max_current_a, "ESTIMATE, half of --max-current"),
        "dc_link_v": (known.supply_v, "measured"),
        "counts_per_rev": (known.counts, "measured (spin), or stated by the board"),
    }  # fmt: skip
    for field_name, value in _board(done).items():
        numbers[field_name] = (value, "a board on which the limits of the drive fit")
    ranges = {}
    for key, estimate in (
        ("resistance_ohm", known.resistance), ("ld_h", known.ld), ("lq_h", known.lq), ("psi_wb", known.psi),
        ("inertia_kgm2", known.inertia),
    ):  # fmt: skip
        half = max(estimate.half, 0.03 * estimate.value)
        low, high = estimate.value - half, estimate.value + half
        ranges[key] = (low, 1.3 * estimate.value if key == "resistance_ohm" else high)  # a warm winding
    effects = {"coulomb_friction": {"torque_nm": known.coulomb.value}} if known.coulomb.value > 0.0 else {}
    head = [
        f"Made by `evenspin commission`, firmware {own_schema().hash:08x}: measured on the motor, each number with",
        "half of its 95 % interval. [range]: at least 3 % either way, and a winding that gets warm.",
    ]
    return model_toml(name, numbers, ranges, head, effects)


def _board(done: Commissioned) -> dict[str, float]:
    from evenspin.motor.limits import beyond_board

    over_v = done.bounds.max_voltage_v or 1.25 * done.known.supply_v
    speed = done.bounds.max_speed_rad_s or done.known.base_rad_s
    limits = {
        "over_current_a": done.bounds.max_current_a, "over_voltage_v": over_v,
        "over_speed_rad_s": OVER_SPEED_PART * speed,
    }  # fmt: skip
    empty = {name: field.default for name, field in tables().model.items()}
    return beyond_board(limits, empty)
