"""A method that tuning calls usable is usable: beyond its first turns, and on the machines that a model may mean."""

from __future__ import annotations

import math
from pathlib import Path

from evenspin.model import load_machine
from evenspin.model.machine import Machine
from evenspin.tune.corners import corners
from evenspin.tune.gains import first_gains
from evenspin.tune.goals import GOALS
from evenspin.tune.methods import ELECTRICAL_HZ, METHOD_OVERSHOOT, METHOD_TIME, position_verdicts, speed_verdict
from evenspin.tune.ripple import repetitive_gains
from evenspin.tune.trial import position_ripple, ripple_of, speed_trial
from evenspin.tune.tuning import limits_of
from random_machines import random_machine

NOISE = ("current_noise_a", "current_lsb_a", "current_range_a", "initial_angle_rad")
WITHIN = 0.03
SMOOTH = GOALS["smooth"]


def hidden(seed: int, place: Path) -> tuple[Machine, dict[str, float], dict[str, tuple[float, float]]]:
    """A machine of `make motors`, the loops that it gets, and what three percent either way is."""
    drawn = random_machine(seed)
    plant = {name: value for name, value in drawn.plant.items() if name not in NOISE}
    limits = {"iq_limit_a": 0.8 * drawn.max_current_a, "over_current_a": drawn.max_current_a}
    text = 'name = "drawn"\n[plant]\n' + "".join(f"{name} = {value!r}\n" for name, value in plant.items())
    text += "[drive]\n" + "".join(f"{name} = {value!r}\n" for name, value in limits.items())
    path = place / "drawn.toml"
    path.write_text(text)
    machine = load_machine(path)
    names = ("resistance_ohm", "ld_h", "lq_h", "psi_wb", "inertia_kgm2")
    ranges = {name: ((1.0 - WITHIN) * plant[name], (1.0 + WITHIN) * plant[name]) for name in names}
    return machine, first_gains(machine.plant, limits_of(machine)[0], ranges, SMOOTH).drive, ranges


def test_learning_that_grows_again_after_its_first_turns_is_not_recommended(tmp_path: Path) -> None:
    """112 W, one pole pair: a gain of 0.2 leaves 0.4 of the error after 16 turns, and 12 times of it after 80."""
    machine, drive, _ = hidden(25, tmp_path)
    silc = next(v for v in position_verdicts(machine.plant, drive) if v.method == "silc")
    ripple = {
        method: position_ripple(machine.plant, {**drive, **changes}, silc.speed_rad_s, 120.0).rms
        for method, changes in (("ppi", {"position_method": 0.0}), ("silc", silc.changes))
    }
    assert silc.usable and ripple["silc"] < 0.5 * ripple["ppi"], ripple


def test_a_method_that_fails_on_a_machine_three_percent_off_is_not_recommended(tmp_path: Path) -> None:
    """4 kW at 310 V: the disturbance observer with a gain of 0.02 trips at full speed with stronger magnets."""
    machine, drive, ranges = hidden(17, tmp_path)
    others = corners(machine.plant, ranges)
    rc = repetitive_gains(machine.plant, drive, SMOOTH)
    speed = 2.0 * math.pi * ELECTRICAL_HZ / machine.plant["pole_pairs"]
    without = ripple_of(machine.plant, drive, speed, 12.0)
    dob = speed_verdict(machine.plant, drive, rc, others, "dob", speed, without)
    assert dob.usable, dob
    for name, plant in others.items():
        trial = speed_trial(plant, {**drive, **dob.changes}, METHOD_OVERSHOOT, name, METHOD_TIME)
        assert trial.good, (name, trial.problems)
