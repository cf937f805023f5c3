"""A model and a goal in, parameters with margins and a verdict out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from evenspin.errors import InputError
from evenspin.model.machine import DRIVE_FILE, DRIVE_TABLE, Machine
from evenspin.motor.limits import Limits, limit_parameters
from evenspin.native import tables
from evenspin.tune.corners import corners
from evenspin.tune.gains import Gains, first_gains, rounded
from evenspin.tune.goals import GOALS, Goal
from evenspin.tune.methods import Verdict, choice, position_verdicts, speed_verdicts
from evenspin.tune.ripple import RepetitiveGains, repetitive_gains
from evenspin.tune.trial import Trial, speed_trial, top_speed, torque_per_a

Numbers = Mapping[str, float]
Progress = Callable[[str], None]

SLOWER = 0.7  # of the speed bandwidth, when the simulation shows more than the margins did
ATTEMPTS = 5
# What a model states and tuning leaves as it is, and what belongs to it wherever the drive is.
KEPT = ("encoder_offset_rad", "encoder_reversed", "voltage_limit_v", "rdc_coulomb_nm", "rdc_static_nm")
LIMITS = ("iq_limit_a", "id_limit_a", "over_current_a", "over_voltage_v", "under_voltage_v", "over_speed_rad_s",
          "align_current_a", "offset_limit_a", "observer_limit_a", "profile_speed_rad_s")  # fmt: skip


@dataclass(frozen=True)
class Tuning:
    """`drive` is what goes into the file; `trials`: of the model, then of its corners."""

    goal: Goal
    drive: dict[str, float]
    comments: dict[str, str]
    gains: Gains
    repetitive: RepetitiveGains
    trials: tuple[Trial, ...]
    methods: tuple[Verdict, ...]
    positions: tuple[Verdict, ...]
    top_rad_s: float

    @property
    def good(self) -> bool:
        """The loops are: start, load step, reversal and full speed, of the model and of its corners."""
        return all(trial.good for trial in self.trials)

    @property
    def problems(self) -> list[str]:
        return [f"{trial.name}: {problem}" for trial in self.trials for problem in trial.problems]


def tune(
    machine: Machine,
    goal: str,
    *,
    current_hz: float | None = None,
    speed_hz: float | None = None,
    methods: bool = True,
    progress: Progress | None = None,
) -> Tuning:
    """`current_hz`, `speed_hz`: largest bandwidths instead of the goal's; `methods`: whether each of them is tried."""
    if goal not in GOALS:
        raise InputError("tune", "--goal", goal, f"one of {', '.join(GOALS)}", "smooth is the default")
    wanted = GOALS[goal]
    wanted = replace(wanted, current_hz=current_hz or wanted.current_hz, speed_hz=speed_hz or wanted.speed_hz)
    say = progress or (lambda _: None)
    plant = machine.plant
    limits, comments = limits_of(machine)
    kept = {name: machine.drive[name] for name in KEPT if name in machine.drive}
    gains, trials = _loops(machine, limits | kept, wanted, say)
    say("repetitive control")
    rc = repetitive_gains(plant, gains.drive, wanted)
    drive = gains.drive | ({} if rc.reason else rc.drive)
    drive |= {name: choice(name, word) for name, word in (("current_controller", "pi"), ("method", "pi"))}
    drive["position_method"] = choice("position_method", "ppi")
    found: tuple[Verdict, ...] = ()
    positions: tuple[Verdict, ...] = ()
    if methods and trials[0].good:
        found = tuple(speed_verdicts(plant, drive, rc, corners(plant, machine.ranges), say))
        positions = tuple(position_verdicts(plant, drive, say))
        drive |= _chosen(found, positions, wanted)
    comments = comments | gains.comments
    top = top_speed(plant, drive)
    return Tuning(wanted, rounded(drive), comments, gains, rc, trials, found, positions, top)


def limits_of(machine: Machine) -> tuple[dict[str, float], dict[str, str]]:
    """What the model states of the limits, the rest from rating, supply and board."""
    stated = {n: machine.drive[n] for n in LIMITS if machine.drive_from.get(n) in (DRIVE_TABLE, DRIVE_FILE)}
    plant = machine.plant
    peak = stated.get("iq_limit_a", 2.0 * plant["rated_current_a"])
    if not peak > 0.0:
        where = machine.document.line_of(["plant"])
        hint = "give it in [plant], or iq_limit_a in [drive]"
        raise InputError(machine.document.path, "plant.rated_current_a", "(missing)", "known", hint, where)
    if not plant["dc_link_v"] > 0.0:
        line = machine.document.line_of(["plant"])
        raise InputError(machine.document.path, "plant.dc_link_v", plant["dc_link_v"], "above 0", "give it", line)
    free = {**plant, "viscous_nms": 0.0}
    supply_speed = top_speed(free, {"iq_limit_a": peak, "over_speed_rad_s": 1e5})
    speed = stated["over_speed_rad_s"] / 1.25 if "over_speed_rad_s" in stated else supply_speed
    derived = limit_parameters(
        Limits(
            peak, plant["rated_current_a"] or 0.5 * peak, plant["dc_link_v"], speed,
            plant["board_current_a"], plant["board_dc_link_v"],
        )
    )  # fmt: skip
    comments = dict.fromkeys(stated, "stated by the model")
    return derived | stated, comments


def _loops(machine: Machine, limits: Numbers, goal: Goal, say: Progress) -> tuple[Gains, tuple[Trial, ...]]:
    """Margins first; where the simulation shows more than they do, slower."""
    best: tuple[int, Gains, list[Trial]] | None = None
    for _ in range(ATTEMPTS):
        say("current and speed loop")
        gains = first_gains(machine.plant, limits, machine.ranges, goal)
        say("start, load step, reversal, full speed")
        trials = [speed_trial(machine.plant, gains.drive, goal.overshoot_part, "as the model has it")]
        if trials[0].good:
            for name, plant in corners(machine.plant, machine.ranges).items():
                trials.append(speed_trial(plant, gains.drive, 1.6 * goal.overshoot_part, name))
        bad = sum(len(trial.problems) for trial in trials) + 10 * (not trials[0].good)
        if best is None or bad < best[0]:
            best = bad, gains, trials
        if bad == 0:
            break
        goal = replace(goal, speed_hz=SLOWER * min(goal.speed_hz, gains.speed.crossover_hz or goal.speed_hz))
    assert best is not None
    return best[1], tuple(best[2])


def _chosen(found: tuple[Verdict, ...], positions: tuple[Verdict, ...], goal: Goal) -> dict[str, float]:
    """Parameters of every method that can be used; for an even speed the best one is switched on, too."""
    drive: dict[str, float] = {}
    gains: dict[str, list[float]] = {}
    for verdict in (*found, *positions):
        if verdict.usable:
            for name, value in verdict.changes.items():
                if name in ("rc_gain", "observer_gain"):
                    gains.setdefault(name, []).append(value)
                elif name not in ("method", "position_method"):
                    drive[name] = value
    drive |= {name: min(values) for name, values in gains.items()}  # one parameter for several methods
    helping = [verdict for verdict in found if verdict.word == "helps"]
    if goal.name == "smooth" and helping:
        drive["method"] = choice("method", min(helping, key=lambda verdict: verdict.ratio).method)
    return drive


def shown(name: str, value: float) -> str:
    return tables().params[name].to_text(value) if tables().params[name].kind != "float" else f"{value:.5g}"


def bandwidths(plant: Numbers, drive: Numbers) -> dict[str, float]:
    """What the gains mean, Hz."""
    two_pi = 6.283185307179586
    unit = drive["speed_error_gain"]
    return {
        "current": drive["current_kp_v_per_a"] / min(plant["ld_h"], plant["lq_h"]) / two_pi,
        "speed": drive["speed_kp_a_per_unit"] * unit * torque_per_a(plant) / plant["inertia_kgm2"] / two_pi,
        "position": drive["position_kp_per_s"] / two_pi,
    }
