"""What goes with what, beside the methods: corrections of sensors, dead time and model in every loop, and everything
that the drive refuses because of a second parameter."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from evenspin.analysis.segments import SIGNALS as SPEED_SIGNALS
from evenspin.analysis.segments import segments
from evenspin.errors import EvenspinError
from evenspin.model import Setup, builtin_scenario
from evenspin.native import tables
from evenspin.reproduce.combinations import ACTS, HARM, IN_POSITION, IN_SPEED, Pair, need_no_fault
from evenspin.reproduce.guo2024.measure import SPEED_INPUT, rows_of
from evenspin.reproduce.yeh2024.measure import SIGNALS as POSITION_SIGNALS
from evenspin.reproduce.yeh2024.measure import turn_rms
from evenspin.sim import prepare, simulate
from evenspin.sim.many import Progress, run_all
from evenspin.sim.record import Record
from evenspin.tableview import TableView

Words = Mapping[str, str | float]
Effects = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, slots=True)
class Option:
    """`drive` switches it on; `effects`: what it is against, instead of those of the scenario; `measure`: by speed."""

    name: str
    drive: Words
    effects: Effects
    figure: str
    measure: Callable[[Setup, Record], float]
    position: bool = True  # acts in position mode, too


def _ripple(setup: Setup, record: Record) -> float:
    """Largest first and second electrical order after a load step, % of the mean speed."""
    rows = rows_of(setup, record, "first", "", "float")
    return max(math.hypot(row["n1_after_load_pct"], row["n2_after_load_pct"]) for row in rows)


def _distortion(setup: Setup, record: Record) -> float:
    """Largest share of everything but the fundamental in the stator current after a load step, %."""
    return max(float(row["distortion_after_load_pct"]) for row in rows_of(setup, record, "first", "", "float"))


def _whole_ripple(setup: Setup, record: Record) -> float:
    """Largest rms of the speed around its mean after a load step, %."""
    found = []
    for piece in segments(setup):
        if SPEED_INPUT not in piece.changed:
            speed = record.between(piece.steady_s, piece.end_s)["true_speed_rad_s"]
            found.append(100.0 * float(np.std(speed) / speed.mean()))
    return max(found)


OPTIONS = (
    Option(
        "current_correction = learned",
        {"current_correction": "learned"},
        {"current_gain": {"gain_a": 1.1, "gain_b": 0.9}, "current_offset": {"offset_a_a": 0.2, "offset_b_a": 0.05}},
        "1st and 2nd electrical order [%]",
        _ripple,
    ),
    Option(
        "dead_time_s = 1.5e-06",
        {"dead_time_s": 1.5e-6},
        {"dead_time": {"dead_time_s": 1.5e-6, "soft_a": 0.0}},
        "distortion of the stator current [%]",
        _distortion,
    ),
    Option(
        "speed_model_ff = 1",
        {"speed_model_ff": 1.0, "rdc_line1_cycles": 24.0, "rdc_line1_nm": 0.01, "rdc_line1_rad": 0.7},
        {"cogging": {"amplitude_nm": 0.01, "order": 24.0, "phase_rad": 0.7}},
        "speed, rms around its mean [%]",
        _whole_ripple,
        position=False,
    ),
    Option(
        "encoder_sin1_rad = 0.01",
        {"encoder_sin1_rad": 0.01, "encoder_sin2_rad": -5e-5},
        {"encoder_eccentricity": {"amplitude_rad": 0.01, "phase_rad": 0.0}},
        "speed, rms around its mean [%]",
        _whole_ripple,
    ),
    Option(
        "flux_cos6 = 0.05",
        {"flux_cos6": 0.05},
        {"flux_harmonics": {"torque_ripple_rel": 0.05, "sign": 1.0, "fifth_share": 0.5}},
        "speed, rms around its mean [%]",
        _whole_ripple,
    ),
)


@dataclass(frozen=True, slots=True)
class Trial:
    """An option in one loop."""

    option: str
    mode: str
    loop: str
    observer: str


@dataclass(frozen=True, slots=True)
class Found:
    """What is left without and with the option, and where there is nothing that it is against."""

    trial: Trial
    ideal: float
    off: float
    on: float

    @property
    def verdict(self) -> str:
        if abs(self.on - self.off) <= ACTS * abs(self.off):
            return "FAILED: does nothing"
        return "works" if self.on <= HARM * max(self.off, self.ideal) else "FAILED: harms"

    @property
    def good(self) -> bool:
        return self.verdict == "works"


def trials() -> list[Trial]:
    """Every option in every loop, alone and beside the observer that learns over the angle."""
    found = [
        Trial(o.name, "speed", loop, observer) for o in OPTIONS for loop in IN_SPEED for observer in ("none", "aro")
    ]
    return found + [Trial(o.name, "position", loop, "none") for o in OPTIONS if o.position for loop in IN_POSITION]


def run(chosen: Sequence[Trial], progress: Progress | None = None) -> list[Found]:
    """Run them, in this order."""
    return run_all([_later(trial) for trial in chosen], progress)


def _later(trial: Trial) -> Callable[[], Found]:
    return lambda: Found(trial, _figure(trial, False, False), _figure(trial, True, False), _figure(trial, True, True))


def _figure(trial: Trial, disturbed: bool, on: bool) -> float:
    option = next(each for each in OPTIONS if each.name == trial.option)
    params = tables().params
    drive = Pair(trial.mode, trial.loop, trial.observer, "pi").drive()
    drive |= {name: params[name].to_number(value) for name, value in (option.drive if on else {}).items()}
    if trial.mode == "position":
        setup = builtin_scenario("yeh2024/rpm20").with_changes(drive)
        setup = replace(setup, effects={**setup.effects, **(option.effects if disturbed else {})})
        record = simulate(setup, POSITION_SIGNALS, "float")
        need_no_fault(setup, record["fault"].max())
        return 1e3 * turn_rms(record)[-1]
    counts = 131072.0  # an observer of the torque differentiates the angle
    setup = builtin_scenario("guo2024/first").with_changes({**drive, "encoder_counts": counts})
    setup = replace(setup, effects=option.effects if disturbed else {}, plant={**setup.plant, "counts_per_rev": counts})
    record = simulate(setup, (*SPEED_SIGNALS, "fault"), "float")
    need_no_fault(setup, record["fault"].max())
    return option.measure(setup, record)


def option_tables(found: Sequence[Found]) -> list[TableView]:
    """One for each option."""
    views = []
    for option in OPTIONS:
        mine = [each for each in found if each.trial.option == option.name]
        against = ", ".join(option.effects)
        rows = [(each.trial.mode, each.trial.loop, each.trial.observer, *_three(each), each.verdict) for each in mine]
        position = "; position mode: rms of the error in turn 10 [mrad]" if option.position else ""
        text = f"Against {against}. Speed mode: {option.figure}{position}."
        if not option.position:
            text += " Without an effect in position mode, where the model acts with `position_method = rdc`."
        text += " What stays beside aro is the noise of the encoder that it learns."
        header = ("mode", "loop", "observer", "nothing to correct", "without", "with", "verdict")
        marks = ["" if each.good else "bad" for each in mine]
        views.append(TableView(option.name, text, header, rows, marks, left=3))
    return views


def _three(found: Found) -> tuple[str, str, str]:
    return f"{found.ideal:.3g}", f"{found.off:.3g}", f"{found.on:.3g}"


# ---- what is refused

# Rule of firmware/app/combinations.def: parameters with which it refuses.
REFUSED: Mapping[str, Words] = {
    "two_observers": {"method": "dob", "disturbance_observer": "aro"},
    "freeze_in_time": {"method": "forc", "rc_freeze_above_unit": 9.0},
    "hold_in_time": {"method": "forc", "observer_hold": 1.0},
    "weight_without_integral": {"speed_setpoint_weight": 0.5, "speed_ki_a_per_unit_s": 0.0},
    "short_at_stop": {"stop_action": "short", "over_current_a": 20.0},
    "short_at_timeout": {"timeout_action": "short", "over_current_a": 20.0},
    "notch_above_rate": {"speed_notch_hz": 450.0, "speed_divider": 10.0},
    "notch_in_loop": {"speed_notch_hz": 20.0, "speed_ki_a_per_unit_s": 0.92},
    "notch_repetitive": {"speed_notch_hz": 60.0, "method": "forc"},
    "jerk_without_ramp": {"speed_jerk_rad_s3": 20000.0, "speed_ramp_rad_s2": 0.0},
    "silc_observer": {"position_method": "silc", "method": "dob"},
    "silc_observer_beside": {"position_method": "silc", "disturbance_observer": "dob"},
    "ro_src": {"position_method": "src", "method": "ro"},
    "ro_src_beside": {"position_method": "src", "disturbance_observer": "ro"},
    "learners": {"position_method": "rdc", "rdc_learn_gain": 0.3, "method": "aro"},
    "learners_beside": {"position_method": "rdc", "rdc_learn_gain": 0.3, "disturbance_observer": "aro"},
    "third_offset": {"current_correction": "fixed", "current_offset_c_a": 0.1},
    "third_gain": {"current_correction": "fixed", "current_gain_c": 1.1},
    "no_resistance": {"current_correction": "learned", "motor_resistance_ohm": 0.0},
    "dead_time_deadbeat": {"dead_time_s": 1e-6, "current_controller": "deadbeat"},
    "flux_deadbeat": {"flux_cos6": 0.05, "current_controller": "deadbeat"},
    "flux_mtpa": {"flux_cos6": 0.05, "mtpa": 1.0},
    "flux_weakening": {"flux_cos6": 0.05, "field_weakening": 1.0},
    "saturation_deadbeat": {"saturation_a": 8.0, "current_controller": "deadbeat"},
    "cross_without_saturation": {"saturation_cross": 0.5, "saturation_a": 0.0},
    "weakening_without_current": {"field_weakening": 1.0, "id_limit_a": 0.0},
    "emf_at_fault": {"field_weakening": 1.0, "over_voltage_v": 25.0},
    "room": {},  # a build for a board with less memory
    "room_alone": {},
}


def refusal(rule: str) -> str:
    """What the drive says to the example of this rule; empty when it takes it."""
    params = tables().params
    numbers = {name: params[name].to_number(value) for name, value in REFUSED[rule].items()}
    scenario = "yeh2024/rpm20" if "position_method" in REFUSED[rule] else "guo2024/first"
    try:
        prepare(builtin_scenario(scenario).with_changes(numbers), ("speed_rad_s",))
    except EvenspinError as error:
        return str(error)
    return ""


def refused_table() -> TableView:
    """Every rule with the values of an example."""
    rows = []
    for rule in tables().combinations:
        if not REFUSED[rule.name]:
            rows.append((rule.param, rule.other, f"{rule.why} (a board with less memory than this build)"))
            continue
        said = refusal(rule.name)
        first, _, rest = said.partition(": does not go with ")
        second, _, why = rest.partition(": ")
        rows.append((first, second, why) if why else (rule.param, rule.other, "FAILED: is not refused"))
    text = "What the drive refuses because of a second parameter, with the values of an example."
    marks = ["bad" if row[2].startswith("FAILED") else "" for row in rows]
    return TableView("Refused", text, ("parameter", "does not go with", "why, and what to do"), rows, marks)
