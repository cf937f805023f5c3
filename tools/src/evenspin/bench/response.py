"""Frequency responses of the running drive, through the link.

The firmware adds a sine to a reference, point by point; rows of the stream say what it does to currents and shaft.

    at torque    a q current, held from one sample of the speed loop to the next as what that asks for
      plant      speed that the loop uses over the q current reference that it gives in the same sample
      loop       the loop gain L of whatever controls speed or position, cut open in front of the current loop
    at current   a q current in every PWM period
      current    q current over its reference: the closed current loop
    at speed     the speed reference
      closed     speed over reference: the closed speed loop

All are those of the sampled system, exact at its samples. With u = excitation + controller: L = excitation / u - 1. How
old the speed in a row is depends on the order of the interrupts (docs/protocol.md, Rows): on a board it is of the
sample before, in the simulator of this one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.analysis.frequency_response import Margins, Ratio, frequencies, margins, phasors, ratio
from evenspin.bench.client import Drive
from evenspin.bench.errors import DriveFaultError, RefusedError
from evenspin.bench.numbers import Excite, Mode, State
from evenspin.errors import InputError

Array = NDArray[np.float64]
Progress = Callable[[float], None]  # part that is done, 0 to 1

NAMES = ("speed_ref_rad_s", "speed_rad_s", "iq_ref_a", "iq_a", "excitation_a", "state")
REF, SPEED, IQ_REF, IQ, EXCITATION, STATE = range(6)
SIMULATOR = "simulator"  # name of the virtual drive in `hello`
UNITS = {"current": "A/A", "plant": "rad/s per A", "loop": "", "closed": ""}
PLACES = {"torque": Excite.TORQUE, "current": Excite.CURRENT, "speed": Excite.SPEED}
ROW_HZ = 1000.0
PARTS = 8
LEAST_S, PERIODS = 0.4, 8.0  # of a point that is measured
SETTLE_S, SETTLE_PERIODS = 0.1, 2.0
CALM_S, FLOOR_S = 1.0, 2.0  # before it, after a start or another set-point; without excitation
AMPLITUDE_PART = 0.05  # of the current limit, of the largest speed
GOOD_COHERENCE = 0.95
CUT_PART = 0.02  # of an amplitude that is missing
PWM_PART = 0.45  # of a sample rate: the firmware takes no more


@dataclass(frozen=True, slots=True)
class Plan:
    """What to measure. `amplitude` in A or rad/s."""

    place: str
    first_hz: float
    last_hz: float
    points: int
    amplitude: float

    @property
    def unit(self) -> str:
        return "rad/s" if self.place == "speed" else "A"


@dataclass(frozen=True, slots=True)
class Point:
    f_hz: float
    ratios: dict[str, Ratio]
    cut: bool  # a limit has cut the excitation: the responses are those of the limit, too

    @property
    def good(self) -> bool:
        return not self.cut and all(each.coherence >= GOOD_COHERENCE for each in self.ratios.values())


@dataclass(frozen=True, slots=True)
class Response:
    plan: Plan
    speed_rad_s: float  # mean, while nothing was excited
    points: list[Point]

    @property
    def names(self) -> list[str]:
        return list(self.points[0].ratios) if self.points else []

    @property
    def margins(self) -> Margins | None:
        """Of the loop gain, from the good points; None where the sine was in the speed reference."""
        known = [point for point in self.points if "loop" in point.ratios and point.good]
        if len(known) < 2:
            return None
        return margins([point.f_hz for point in known], [point.ratios["loop"].value for point in known])


def plan_of(
    drive: Drive, place: str, first_hz: float, last_hz: float | None, points: int, amplitude: float | None
) -> Plan:
    """Checked, with what the drive's limits make of what is not given."""
    if place not in PLACES:
        raise InputError("bench bode", "--at", place, "torque, current or speed", "the place where the sine is added")
    known = drive.get(["iq_limit_a", "over_speed_rad_s", "speed_divider"])
    speed_hz = drive.info.pwm_hz / known["speed_divider"]
    most = PWM_PART * (drive.info.pwm_hz if place == "current" else speed_hz)
    limit = known["over_speed_rad_s"] if place == "speed" else known["iq_limit_a"]
    last = most if last_hz is None else last_hz
    if not 0.01 <= first_hz < last <= most:
        must = f"0.01 Hz up to less than --to, and --to at most {most:g} Hz"
        raise InputError("bench bode", "--from, --to", f"{first_hz:g}, {last:g}", must, "choose a smaller range")
    if not 2 <= points <= 400:
        raise InputError("bench bode", "--points", points, "2 to 400", "a decade takes about 10")
    size = AMPLITUDE_PART * limit if amplitude is None else amplitude
    if not 0.0 < size <= limit:
        unit = "rad/s (over_speed_rad_s)" if place == "speed" else "A (iq_limit_a)"
        raise InputError("bench bode", "--amplitude", size, f"above 0, at most {limit:g} {unit}", "begin with a tenth")
    return Plan(place, first_hz, last, points, size)


def refuse_learning(drive: Drive) -> None:
    """What learns would keep the sine and play it back; named here, the drive only refuses."""
    words = ("method", "disturbance_observer", "position_method", "observer_hold")
    held = {name: drive.parameters[name].to_text(value) for name, value in drive.get(words).items()}
    learning = [f"method = {held['method']}"] if held["method"] in ("crc", "forc", "fal-forc", "ro", "aro") else []
    if held["disturbance_observer"] in ("ro", "aro"):
        learning.append(f"disturbance_observer = {held['disturbance_observer']}")
    if learning and drive.get(["observer_hold"])["observer_hold"] == 0.0:
        raise RefusedError(
            f"{learning[0]} would learn the sine and play it back; set observer_hold = 1 to measure with what is "
            "learned (over the angle only), or method = pi",
            "bode",
        )


def measure(
    drive: Drive, plan: Plan, progress: Progress = lambda part: None, each: Callable[[Point], None] = lambda point: None
) -> Response:
    """With the drive that runs, at the set-point that it has. The excitation ends with this, whatever the reason is.

    `each` is called with every point as it comes. DriveFaultError when the drive trips or is stopped meanwhile.
    """
    refuse_learning(drive)
    now = drive.state()
    if now.state != State.RUN:
        raise RefusedError(f"the drive does not run (its state is {now.state.name.lower()}); start it first", "bode")
    if plan.place != "current" and now.mode == Mode.CURRENT:
        raise RefusedError("current mode controls no speed; excite the current, or run in another mode", "bode")
    row_hz = _row_hz(drive, plan.place)
    lead_s = _speed_lead_s(drive)
    wanted = frequencies(plan.first_hz, plan.last_hz, plan.points, row_hz)
    total_s = CALM_S + FLOOR_S + float(sum(_seconds(f) for f in wanted))
    found: list[Point] = []
    try:
        with drive.stream(NAMES, rate_hz=row_hz) as stream:
            floor = _rows(drive, stream, CALM_S, FLOOR_S)
            done_s = CALM_S + FLOOR_S
            progress(done_s / total_s)
            for f_hz in wanted:
                made_hz = drive.excite(PLACES[plan.place], plan.amplitude, float(f_hz))
                settle_s = max(SETTLE_S, SETTLE_PERIODS / f_hz)
                rows = _rows(drive, stream, settle_s, _seconds(f_hz) - settle_s)
                found.append(_point(plan, made_hz, rows, floor, lead_s))
                each(found[-1])
                done_s += _seconds(f_hz)
                progress(done_s / total_s)
    finally:
        if not drive.link.lost:
            drive.excite(Excite.NONE)
    return Response(plan, float(floor[1][:, SPEED].mean()), found)


def _row_hz(drive: Drive, place: str) -> float:
    """In step with the speed loop, whose samples are then seen at always the same age. For the current loop out of
    step: what the speed loop holds has images, which would else fall onto the sine."""
    divider = round(drive.get(["speed_divider"])["speed_divider"])
    periods = max(1, round(drive.info.pwm_hz / ROW_HZ))
    if place != "current":
        return float(drive.info.pwm_hz / (divider * max(1, round(periods / divider))))
    while math.gcd(periods, divider) != 1:
        periods += 1
    return float(drive.info.pwm_hz / periods)


def _speed_lead_s(drive: Drive) -> float:
    """By how much the speed in a row is older than the sample that gave the q current reference in that row, less."""
    held = drive.get(["speed_inline", "speed_divider"])
    if held["speed_inline"] != 0.0:
        return 0.0  # both of this sample
    sample_s = held["speed_divider"] / drive.info.pwm_hz
    # what the loop gives acts a period after its sample: the reference in the row is of the sample before
    return -sample_s if drive.info.name == SIMULATOR else 0.0


def _seconds(f_hz: float) -> float:
    return max(SETTLE_S, SETTLE_PERIODS / f_hz) + max(LEAST_S, PERIODS / f_hz)


def _rows(drive: Drive, stream: object, skip_s: float, seconds: float) -> tuple[Array, Array]:
    """Time and rows, without a gap, from `skip_s` after now on."""
    from evenspin.bench.stream import Stream

    assert isinstance(stream, Stream)
    period_s = stream.decimation / stream.pwm_hz
    begin = drive.state().counter / stream.pwm_hz + skip_s
    times: list[Array] = []
    values: list[Array] = []
    have = 0
    while have * period_s < seconds:
        block = stream.read(1.0)
        if block is None:
            drive.need_no_fault()
            raise RefusedError("no rows come any more; is somebody else using the stream?", "bode")
        if block.lost_before and have:
            raise RefusedError(f"{block.lost_before} rows were lost on the line; measure again", "bode")
        inside = block.t_s >= begin
        if np.any(block.values[:, STATE] != State.RUN):
            drive.need_no_fault()
            raise DriveFaultError("bode: the drive was stopped; what was measured before is dropped")
        times.append(block.t_s[inside])
        values.append(block.values[inside].astype(float))
        have += int(np.count_nonzero(inside))
    return np.concatenate(times), np.concatenate(values)


def _point(plan: Plan, f_hz: float, rows: tuple[Array, Array], floor: tuple[Array, Array], lead_s: float) -> Point:
    found = phasors(rows[0], rows[1][:, :STATE], f_hz, PARTS)
    rest = np.abs(phasors(floor[0], floor[1][:, :STATE], f_hz, 1)[0])
    reference = found[:, REF if plan.place == "speed" else EXCITATION]
    if not np.all(np.abs(reference) > 0.0):
        raise DriveFaultError("bode: the excitation has ended; a set-point, a stop or another client ends it")
    cut = abs(float(np.abs(reference.mean())) - plan.amplitude) > CUT_PART * plan.amplitude
    ratios: dict[str, Ratio] = {}
    if plan.place == "speed":
        ratios["closed"] = ratio(found[:, SPEED], reference, reference, (rest[SPEED], 0.0))
        return Point(f_hz, ratios, cut)
    whole = found[:, IQ_REF]
    if plan.place == "current":
        ratios["current"] = ratio(found[:, IQ], whole, reference, (rest[IQ], rest[IQ_REF]))
        return Point(f_hz, ratios, cut)
    speed = found[:, SPEED] * np.exp(2j * np.pi * f_hz * lead_s)
    ratios["plant"] = ratio(speed, whole, reference, (rest[SPEED], rest[IQ_REF]))
    ratios["loop"] = ratio(reference - whole, whole, reference, (rest[IQ_REF], rest[IQ_REF]))
    return Point(f_hz, ratios, cut)


def top_speed_rad_s(drive: Drive) -> float:
    """A speed that supply and drive allow with room to spare: a quarter of the base speed, half of the limit."""
    known = drive.get(["pole_pairs", "motor_psi_wb", "over_speed_rad_s"])
    base = drive.read(("vdc_v",))["vdc_v"] / math.sqrt(3.0) / (known["pole_pairs"] * known["motor_psi_wb"])
    return min(0.25 * base, 0.5 * known["over_speed_rad_s"])


def table(response: Response) -> tuple[list[str], list[list[float]]]:
    """Columns and rows: frequency, then gain, phase, coherence and half width of each response."""
    columns = ["f_hz"]
    for name in response.names:
        columns += [f"{name}_gain", f"{name}_phase_deg", f"{name}_coherence", f"{name}_error"]
    rows = []
    for point in response.points:
        row = [point.f_hz]
        for name in response.names:
            each = point.ratios[name]
            row += [abs(each.value), each.phase_deg, each.coherence, each.error]
        rows.append(row)
    return columns, rows


def lines_of(found: Response) -> list[str]:
    """Margins, and how many points are to be trusted."""
    good = sum(point.good for point in found.points)
    lines = [f"{good} of {len(found.points)} points are good (coherence 0.95 or more, sine not cut)."]
    margin = found.margins
    if margin is not None:
        crossover = (
            "No crossover of the loop gain in this range"
            if math.isnan(margin.crossover_hz)
            else f"Crossover {margin.crossover_hz:.4g} Hz, phase margin {margin.phase_deg:.3g} degrees"
        )
        gain = "" if math.isnan(margin.gain_db) else f"; gain margin {margin.gain_db:.3g} dB at {margin.gain_hz:.4g} Hz"
        lines.append(f"{crossover}{gain}.")
    return lines


def content_of(found: Response) -> dict[str, Any]:
    """For --json and for a page: plan, margins, and every point."""
    margin = found.margins
    return {
        "plan": asdict(found.plan) | {"unit": found.plan.unit},
        "speed_rad_s": found.speed_rad_s,
        "margins": None if margin is None else {key: known(value) for key, value in asdict(margin).items()},
        "units": {name: UNITS[name] for name in found.names},
        "points": [
            {"f_hz": point.f_hz, "good": point.good, "cut": point.cut}
            | {
                name: {"gain": abs(each.value), "gain_db": known(each.gain_db), "phase_deg": each.phase_deg,
                       "coherence": each.coherence, "error": known(each.error)}
                for name, each in point.ratios.items()
            }
            for point in found.points
        ],
    }  # fmt: skip


def known(value: float) -> float | None:
    """JSON has no NaN."""
    return value if math.isfinite(value) else None


def decibel(name: str) -> str:
    """Unit of a gain as a level."""
    return "dB, 1 rad/s per A" if UNITS[name].startswith("rad") else "dB"
