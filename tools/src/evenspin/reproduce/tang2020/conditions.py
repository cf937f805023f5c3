"""The conditions of the paper: which scenario, which methods, what is detuned, and when it is measured.

Off is the drive without an observer (PI), on the drive with it. Both start at t = 0; the observer starts empty and is
measured 50 s later. Off has nothing to learn and is measured as soon as the start is over.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product

from evenspin.model import Setup, builtin_scenario
from evenspin.model.setup import InputCurve
from evenspin.native import tables

METHODS = ("aro", "aro-beyond", "ro", "dob")
OFF = "pi"
LITERAL = "aro-k21"  # printed equations 19 and 20 with their labels
ARO = ("aro", "aro-beyond")

# The printed label calls the torque sample k-21; it is 10.5 samples old. Taken literally, the torque is written at the
# angle of 21 samples ago, and T_ref(k-21) is subtracted, 8.5 samples older than the one that acted (k-12.5). In this
# drive the second is observer_actuation_samples + 8.5, which also reads out 8.5 samples further ahead; so 12.5 of age
# are left of the 21.
LITERAL_DRIVE = {"observer_actuation_samples": 10.5, "observer_age_samples": 12.5}


@dataclass(frozen=True, slots=True)
class Window:
    """Part of a run, s. `name` is added to the name of the condition."""

    start_s: float
    end_s: float
    name: str = ""


STEADY = (Window(50.0, 55.0),)
STEADY_OFF = (Window(2.0, 7.0),)


@dataclass(frozen=True, slots=True)
class Condition:
    """`factors` multiply drive parameters. Without `off_windows` both runs are measured in the same windows."""

    name: str
    scenario: str
    speed_rpm: float
    methods: tuple[str, ...] = ARO
    factors: Mapping[str, float] = field(default_factory=dict)
    windows: tuple[Window, ...] = STEADY
    off_windows: tuple[Window, ...] | None = STEADY_OFF

    def setup(self, method: str) -> Setup:
        """The run of this condition with this method."""
        scenario = builtin_scenario(f"tang2020/{self.scenario}")
        drive = drive_of(method)
        base = {**scenario.setup.drive, **drive}
        drive |= {name: factor * base[name] for name, factor in self.factors.items()}
        setup = scenario.with_changes(drive)
        if method == OFF:
            setup = replace(setup, duration_s=max(window.end_s for window in self.windows_of(OFF)))
        return setup

    def windows_of(self, method: str) -> tuple[Window, ...]:
        return self.off_windows if method == OFF and self.off_windows is not None else self.windows

    @property
    def off_key(self) -> tuple[object, ...]:
        """Conditions with the same key share their run without observer: that one has no observer to be detuned."""
        felt = {name: factor for name, factor in self.factors.items() if not name.startswith("observer_")}
        return (self.scenario, tuple(sorted(felt.items())))


def drive_of(method: str) -> dict[str, float]:
    """Drive parameters of a method, on top of the scenario's."""
    word = "aro" if method in (*ARO, LITERAL) else method
    drive = {"method": tables().params["method"].to_number(word)}
    if method == "aro-beyond":
        drive |= beyond_drive()
    if method == LITERAL:
        drive |= LITERAL_DRIVE
    return drive


@functools.cache
def beyond_drive() -> dict[str, float]:
    """What tang2020/beyond changes against the printed algorithm."""
    printed, beyond = (builtin_scenario(f"tang2020/{name}").setup.drive for name in ("rpm100", "beyond"))
    return {name: value for name, value in beyond.items() if value != printed[name]}


def at_speed(rpm: float, method: str, duration_s: float) -> Setup:
    """Any constant speed, no load, Rig 2."""
    setup = builtin_scenario("tang2020/rpm1000").with_changes(drive_of(method))
    speed = InputCurve((0.0,), (rpm * 3.141592653589793 / 30.0,))
    return replace(setup, inputs={**setup.inputs, "speed_ref_rad_s": speed}, duration_s=duration_s)


def _detuned() -> list[Condition]:
    """Wrong mechanics in the observer, wrong electrical data in the current controller; 100 rpm."""
    inertia = [
        Condition(f"100 rpm, J x {f:g}", "rpm100", 100.0, factors={"observer_inertia_kgm2": f}) for f in (0.5, 1.5, 2.0)
    ]
    viscous = [
        Condition(f"100 rpm, B x {f:g}", "rpm100", 100.0, factors={"observer_viscous_nms": f}) for f in (0.1, 10.0)
    ]
    electrical = {"R": ("motor_resistance_ohm",), "L": ("motor_ld_h", "motor_lq_h"), "psi": ("motor_psi_wb",)}
    deadbeat = [
        Condition(f"100 rpm, deadbeat {name} x {f:g}", "rpm100", 100.0, factors=dict.fromkeys(keys, f))
        for (name, keys), f in product(electrical.items(), (0.7, 1.3))
    ]
    return [*inertia, *viscous, *deadbeat]


LOAD_WINDOWS = (Window(51.0, 53.0, "1-3 s after"), Window(53.0, 65.0, "3-15 s after"))
SPEED_WINDOWS = (Window(50.5, 52.0, "0.5-2 s after"), Window(55.0, 60.0, "5-10 s after"))

CONDITIONS = (
    Condition("100 rpm", "rpm100", 100.0, METHODS),
    Condition("123 rpm", "rpm123", 123.0, METHODS),
    Condition("451 rpm", "rpm451", 451.0, (*METHODS, LITERAL)),
    Condition("1000 rpm", "rpm1000", 1000.0),
    Condition("1003 rpm", "rpm1003", 1003.0),
    Condition("misalignment, 1000 rpm", "misalignment", 1000.0),
    Condition("sensor errors, full load", "sensor_errors", 100.0),
    Condition("load step", "load_step", 100.0, windows=LOAD_WINDOWS, off_windows=None),
    Condition("speed step", "speed_step", 451.0, windows=SPEED_WINDOWS, off_windows=None),
    *_detuned(),
)
