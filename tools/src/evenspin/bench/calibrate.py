"""Guided calibration: one procedure per thing that a drive must know about its motor.

Each says beforehand what it is for, what will move, and what it changes in the drive; afterwards a verdict with number
and limit. What it changed is kept with what was there before, so that it can be undone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tomlkit
from numpy.typing import NDArray

from evenspin.bench.client import Drive, parse_value
from evenspin.bench.config import read_config, shortest
from evenspin.bench.errors import DriveFaultError
from evenspin.bench.numbers import Mode, State, Trigger
from evenspin.bench.operator import Operator
from evenspin.bench.origin import Number, check_known, rests_on
from evenspin.errors import InputError, did_you_mean
from evenspin.identify.estimate import linear
from evenspin.identify.friction import friction_points
from evenspin.identify.inertia import identify_inertia
from evenspin.identify.result import Identified, drive_parameters, identify
from evenspin.identify.source import Run

Array = NDArray[np.float64]
Progress = Callable[[float], None]  # part that is done, 0 to 1

TURN_RAD = 2.0 * math.pi
OBSERVE_S = 1.0
OFFSET_PART = 0.005  # of the current limit: an offset beyond this makes a first-order ripple worth the care
CALIBRATION_PERIODS = 4096
TEST_CURRENT = (0.15, 0.30)  # of the current limit
HOLD_S = 0.2
STEP_ROWS = 400
SWING_RAD = 0.3  # that shows a direction
SWING_S = 0.4
ENCODER_LIMIT_RAD = 0.035  # 2 degrees: a torque loss of 0.06 %
TOP_PART = 0.15  # of the speed at which the back-EMF fills the dc link
FRICTION_PARTS = (0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
RAMPS, RAMP_S = 24, 0.1  # steep: the encoder's steps blur the acceleration
RAMP_STEP_S = 0.004
SLOW_RAD_S, SLOW_TURNS = 3.0, 8.0
LEARNING = "learning"
LEARN_PART, LEARN_TURNS, LEARN_PARTS = 0.25, 60.0, 20  # speed, of the top; how far; reports of progress
LEARN_LIMIT = 0.7  # of the ripple without it
RIPPLE_TURNS = 4.0
SURE = 0.10
BELOW = 2.0  # halves of its 95 % interval by which a friction of 0 may come out below it: exceeded once in 20000 times
STILL_RAD_S = 0.5
POWER_UP_S, POWER_UP_POLL_S = 30.0, 0.05
NO_CURRENT_LOOP = (
    "rl: {fault} The current loop does not fit this motor: `evenspin commission --port PORT --max-current A` measures "
    "a motor whose gains nobody knows, `evenspin tune MODEL` makes gains of a name plate"
)
KEEPS_GAINS = "the gains of the current loop stay as they are: `evenspin tune` makes them of R and L"


@dataclass(frozen=True, slots=True)
class Verdict:
    """A number and the limits that it must keep."""

    what: str
    value: float
    unit: str
    low: float
    high: float

    @property
    def good(self) -> bool:
        return self.low <= self.value <= self.high

    @property
    def given(self) -> str:
        return f"{self.what}: {self.value:.4g} {self.unit}".rstrip()

    def __str__(self) -> str:
        word = "good" if self.good else "NOT GOOD"
        return f"{self.given}, {word} (limits {self.low:.4g} .. {self.high:.4g})"


@dataclass(frozen=True, slots=True)
class Found:
    """What a procedure measured, and what the drive should know from now on."""

    verdicts: Sequence[Verdict]
    parameters: Mapping[str, float]
    note: str = ""

    @property
    def good(self) -> bool:
        return all(verdict.good for verdict in self.verdicts)


@dataclass(frozen=True, slots=True)
class Procedure:
    """Shown to the operator before it begins."""

    name: str
    goal: str
    moves: str
    work: Callable[[Drive, Operator, Progress], Found]
    rests_on: tuple[str, ...] = ()  # motor data of the drive that the result is calculated with


@dataclass(frozen=True, slots=True)
class Calibration:
    """A procedure that was done. `before`: the parameters that it changed, as they were."""

    name: str
    found: Found
    before: Mapping[str, float]
    inputs: Sequence[Number] = ()

    @property
    def good(self) -> bool:
        """Nothing that rests on a number which nobody has measured is."""
        return self.found.good and all(number.sure for number in self.inputs)

    @property
    def lines(self) -> list[str]:
        """Shown to the operator afterwards: where the numbers come from, then each verdict."""
        unsure = [number for number in self.inputs if not number.sure]
        lines = [f"calculated with {number}" for number in self.inputs]
        for verdict in self.found.verdicts:
            assumed = ", ".join(number.name for number in unsure)
            lines.append(f"{verdict.given}; NOT GOOD: assumes the default of {assumed}" if unsure else str(verdict))
        return [*lines, *(f"{number.name}: {number.first}" for number in unsure)]


def procedure(name: str) -> Procedure:
    if name not in PROCEDURES:
        raise InputError("bench calibrate", "NAME", name, "a procedure", did_you_mean(name, PROCEDURES))
    return PROCEDURES[name]


def inputs_of(drive: Drive, operator: Operator, name: str, known: Collection[str] = ()) -> tuple[Number, ...]:
    """Motor data that the result of this procedure will rest on, and where they come from."""
    check_known(known)
    return rests_on(drive, procedure(name).rests_on, operator.model_parameters(), known)


def calibrate(
    drive: Drive, operator: Operator, name: str, progress: Progress, known: Collection[str] = ()
) -> Calibration:
    """Do it; what was found is stored in the drive when it is good, and the motor is stopped.

    `known`: parameters whose default is right for this motor.
    """
    wanted = procedure(name)
    drive.need_no_fault()
    inputs = inputs_of(drive, operator, name, known)
    all_before = drive.get()
    try:
        with _settings(drive, plausibility_share="0"):  # the numbers of the motor are what is looked for
            try:
                found = wanted.work(drive, operator, progress)
            finally:
                if not drive.link.lost:
                    _halt(drive)
    finally:
        if not drive.link.lost:
            operator.lock(False)
    before = {key: all_before[key] for key in found.parameters}
    done = Calibration(name, found, before, inputs)
    drive.set(found.parameters if done.good else before)
    return done


def keep(drive: Drive, done: Calibration) -> None:
    """Over a power cycle; what the angle observer has learned, too."""
    drive.save()
    if done.name == LEARNING:
        drive.command("learn_save")


# ---- the procedures


def _offsets(drive: Drive, operator: Operator, progress: Progress) -> Found:
    """The bridge is off: what the sensors show is their offset."""
    names = ("ia_a", "ib_a", "state")
    _need_bridge_off(drive)
    with drive.stream(names, rate_hz=1000.0) as stream:
        values = stream.read_rows(round(OBSERVE_S * 1000.0)).astype(float)
    progress(1.0)
    limit_a = OFFSET_PART * drive.get(["iq_limit_a"])["iq_limit_a"]
    offsets = values[:, :2].mean(axis=0)
    verdicts = [
        Verdict(f"offset that is left in phase {phase}", float(offset), "A", -limit_a, limit_a)
        for phase, offset in zip("ab", offsets, strict=True)
    ]
    note = ""
    if not all(verdict.good for verdict in verdicts):
        note = (
            f"set offset_calibration_periods = {CALIBRATION_PERIODS}, save, and switch the drive off and on: it then "
            "measures the offsets before the first start"
        )
    return Found(verdicts, {}, note)


def _need_bridge_off(drive: Drive) -> None:
    """A drive that was just switched on measures its own offsets first."""
    for _ in range(round(POWER_UP_S / POWER_UP_POLL_S)):
        state = drive.state().state
        if state == State.READY:
            return
        drive.need_no_fault()
        drive.sleep(POWER_UP_POLL_S)
    raise DriveFaultError(f"offsets: state = {state.name}: must be READY within {POWER_UP_S:g} s; see `bench info`")


def _encoder(drive: Drive, operator: Operator, progress: Progress) -> Found:
    """Direction from a push of torque, commutation angle from the direction of the back-EMF."""
    drive.find_zero()
    with _settings(drive, speed_source="pll", method="pi", disturbance_observer="none"):
        limit_a = drive.get(["iq_limit_a"])["iq_limit_a"]
        swing_rad, torque_a = _push(drive, limit_a)
        progress(0.3)
        forward = math.copysign(1.0, swing_rad)
        verdicts = [Verdict(f"travel of the rotor under {torque_a:.3g} A", swing_rad, "rad", 0.5 * SWING_RAD, 100.0)]
        if forward < 0.0:
            note = "set encoder_reversed to the opposite, and calibrate again"
            return Found(verdicts, {}, note)
        speed = _top_speed(drive)
        emf = []
        for number, sign in enumerate((1.0, -1.0)):
            emf.append(_emf(drive, sign * speed))
            progress(0.3 + 0.35 * (number + 1))
    angles = [float(np.angle(vector)) for vector in emf]
    error_rad = float(np.mean(angles))
    flux_wb = float(np.mean(np.abs(emf)))
    offset = drive.get(["encoder_offset_rad"])["encoder_offset_rad"]
    turned = math.remainder(offset - error_rad, TURN_RAD)
    # One direction is not enough: both must give the same angle.
    spread = abs(angles[0] - angles[1])
    verdicts += [
        Verdict("commutation error that was found", error_rad, "rad electrical", -1.0, 1.0),
        Verdict("difference of the two directions", spread, "rad electrical", 0.0, 2.0 * ENCODER_LIMIT_RAD),
        Verdict("flux linkage", flux_wb, "Wb", *_range(drive, "motor_psi_wb")),
    ]
    aligned = drive.get(["align_periods"])["align_periods"] > 0.0
    note = "the alignment in the first start finds the angle again: encoder_offset_rad acts when align_periods = 0"
    return Found(verdicts, {"encoder_offset_rad": turned, "motor_psi_wb": flux_wb}, note if aligned else "")


def _push(drive: Drive, limit_a: float) -> tuple[float, float]:
    """Rising torque until the rotor has turned far enough to show its direction."""
    _halt(drive)
    for part in (0.05, 0.1, 0.2, 0.4):
        torque_a = part * limit_a
        drive.setpoint(Mode.CURRENT, iq_a=torque_a)
        with drive.stream(("theta_m_rad",), rate_hz=1000.0) as stream:
            drive.start()
            theta: list[float] = []
            while len(theta) < SWING_S * 1000.0:
                block = stream.read(1.0)
                theta += block.values[:, 0].tolist() if block is not None else []
                travel = float(np.unwrap(theta)[-1] - theta[0]) if theta else 0.0
                if abs(travel) > SWING_RAD:
                    break
            _halt(drive)
        if abs(travel) > 0.5 * SWING_RAD:
            return travel, torque_a
    raise DriveFaultError(
        f"encoder: the rotor does not turn under {torque_a:.3g} A: is it locked, does a phase hang loose, does the "
        "encoder count backwards (try encoder_reversed), or is the electrical zero far off (try align_periods)?"
    )


def _emf(drive: Drive, speed_rad_s: float) -> complex:
    """Flux of the magnets; its angle is that by which the drive's q axis leads theirs."""
    names = ("speed_rad_s", "id_a", "iq_a", "vd_v", "vq_v")
    known = drive.get(["motor_resistance_ohm", "motor_ld_h", "motor_lq_h", "pole_pairs"])
    drive.run_speed(speed_rad_s)
    drive.sleep(1.0)
    with drive.stream(names, rate_hz=1000.0) as stream:
        values = stream.read_rows(1000).astype(float)
    speed, id_a, iq_a, vd, vq = values.mean(axis=0)
    if abs(speed - speed_rad_s) > 0.2 * abs(speed_rad_s):
        raise DriveFaultError(f"encoder: {speed:.3g} instead of {speed_rad_s:.3g} rad/s; tune the speed loop first")
    electrical = known["pole_pairs"] * speed
    emf_d = vd - known["motor_resistance_ohm"] * id_a + electrical * known["motor_lq_h"] * iq_a
    emf_q = vq - known["motor_resistance_ohm"] * iq_a - electrical * known["motor_ld_h"] * id_a
    return complex(emf_q, emf_d) / electrical


def _rl(drive: Drive, operator: Operator, progress: Progress) -> Found:
    """What a current loop that does not fit the motor makes of it is said with what does without one."""
    try:
        return _resistance_and_inductances(drive, operator, progress)
    except DriveFaultError as error:
        if not str(error).startswith("over_current"):
            raise
        raise DriveFaultError(NO_CURRENT_LOOP.format(fault=error)) from None


def _resistance_and_inductances(drive: Drive, operator: Operator, progress: Progress) -> Found:
    """Resistance and inductances from current steps with the rotor locked; two levels, so that dead time drops out."""
    drive.find_zero()
    operator.lock(True)
    with _settings(drive, current_controller="pi"):
        limit_a = drive.get(["iq_limit_a"])["iq_limit_a"]
        low, high = (part * limit_a for part in TEST_CURRENT)
        axes = {}
        for number, axis in enumerate("dq"):
            axes[axis] = _axis(drive, axis, low, high)
            progress(0.5 * (number + 1))
    resistance = 0.5 * (axes["d"][0] + axes["q"][0])
    found = {"motor_resistance_ohm": resistance, "motor_ld_h": axes["d"][1], "motor_lq_h": axes["q"][1]}
    spread = abs(axes["d"][0] - axes["q"][0]) / resistance
    verdicts = [Verdict("resistance", resistance, "ohm", *_range(drive, "motor_resistance_ohm"))]
    verdicts += [
        Verdict(f"inductance of the {axis} axis", axes[axis][1], "H", *_range(drive, f"motor_l{axis}_h"))
        for axis in "dq"
    ]
    verdicts.append(Verdict("resistances of the axes, difference over mean", spread, "", 0.0, SURE))
    note = "the axes differ: the gains of the current sensors are unequal" if spread > SURE else KEEPS_GAINS
    return Found(verdicts, found, note)


def _range(drive: Drive, name: str) -> tuple[float, float]:
    field = drive.parameters[name]
    return field.minimum, field.maximum


def _hold(drive: Drive, axis: str, current_a: float) -> None:
    """This current in one axis, none in the other."""
    drive.setpoint(Mode.CURRENT, id_a=current_a if axis == "d" else 0.0, iq_a=current_a if axis == "q" else 0.0)


def _axis(drive: Drive, axis: str, low_a: float, high_a: float) -> tuple[float, float]:
    """(R, L) of an axis: the step from low to high."""
    current, voltage, reference = f"i{axis}_a", f"v{axis}_v", f"i{axis}_ref_a"
    _hold(drive, axis, low_a)
    drive.start()
    drive.sleep(HOLD_S)
    drive.arm_capture((current, voltage), rows=STEP_ROWS, pre=STEP_ROWS // 4, trigger=Trigger.RISING,
                      signal_name=reference, level=0.5 * (low_a + high_a))  # fmt: skip
    _hold(drive, axis, high_a)
    taken = drive.read_capture()
    with drive.stream((current, voltage), rate_hz=1000.0) as stream:
        after = stream.read_rows(200).astype(float).mean(axis=0)
    drive.stop()
    drive.sleep(0.1)
    before = taken.values[: STEP_ROWS // 4].astype(float).mean(axis=0)
    resistance = float((after[1] - before[1]) / (after[0] - before[0]))
    # i[k+2] = a i[k+1] + (1 - a) / R v[k], about the mean before the step: a voltage acts in the next period
    i, v = (taken.values.astype(float) - before).T
    x, y = i[1:-1] - v[:-2] / resistance, i[2:] - v[:-2] / resistance
    a = float(x @ y / (x @ x))
    if not 0.0 < a < 1.0:
        hint = "is the rotor locked, the current loop stable?"
        raise InputError("bench calibrate rl", f"decay of i{axis} per period", a, "between 0 and 1", hint)
    return resistance, -resistance / drive.info.pwm_hz / math.log(a)


def _mechanics(drive: Drive, operator: Operator, progress: Progress) -> Found:
    """Friction from constant speeds in both directions, inertia from ramps."""
    drive.find_zero()
    with _settings(drive, method="pi", disturbance_observer="none", speed_source="pll"):
        top = _top_speed(drive)
        speeds = [part * top for part in FRICTION_PARTS]
        stretches = [(sign * v, 1.2 * TURN_RAD / v + 0.6) for sign in (1.0, -1.0) for v in speeds]
        total = sum(seconds for _, seconds in stretches) + RAMPS * RAMP_S + 1.0
        stairs = _record(drive, "friction", stretches, lambda s: progress(s / total))
        earlier_s = total - RAMPS * RAMP_S - 1.0
        ramps = [(part * top, 0.0) for _ in range(RAMPS // 2) for part in (1.0, 0.25)]
        run = _record_ramps(drive, "inertia", 0.25 * top, ramps, lambda s: progress((earlier_s + s) / total))
    points = friction_points([stairs])
    speed = np.array([point.speed_rad_s for point in points])
    torque = np.array([point.torque_nm for point in points])
    (coulomb, viscous), _ = linear(np.column_stack((np.sign(speed), speed)), torque)
    inertia = identify_inertia([run]).inertia_kgm2
    known = drive.parameters
    sides = {"inertia_kgm2": inertia.value, "viscous_nms": max(viscous.value, 0.0)}
    parameters = {f"{user}_{name}": value for user in ("observer", "rdc") for name, value in sides.items()}
    parameters["rdc_coulomb_nm"] = max(coulomb.value, 0.0)
    parameters["rdc_static_nm"] = max(parameters["rdc_coulomb_nm"], drive.get(["rdc_static_nm"])["rdc_static_nm"])
    least = known["observer_inertia_kgm2"].minimum
    verdicts = [
        Verdict("inertia", inertia.value, "kg m^2", least, 1e3),
        Verdict("inertia, half of its 95 % interval over it", inertia.relative, "", 0.0, SURE),
        Verdict("viscous friction", viscous.value, "N m s/rad", -BELOW * viscous.half, 1e3),
        Verdict("Coulomb friction", coulomb.value, "N m", -BELOW * coulomb.half, 1e3),
    ]
    return Found(verdicts, parameters)


def _cogging(drive: Drive, operator: Operator, progress: Progress) -> Found:
    """Torque over the angle from slow turns: the lines that robust driving control feeds forward.

    What the speed loop lets through as ripple of the speed is added as torque of the known inertia.
    """
    with _settings(drive, method="pi", disturbance_observer="none", speed_source="pll"):
        inertia = drive.get(["observer_inertia_kgm2"])["observer_inertia_kgm2"]
        seconds = SLOW_TURNS * TURN_RAD / SLOW_RAD_S + 1.0
        run = _record(drive, "cogging", [(SLOW_RAD_S, seconds)], lambda s: progress(s / seconds), inertia)
    found: Identified = identify({"cogging": [run]}, snap=True)
    assert found.spectrum is not None
    rated_nm = _torque_per_a(drive) * drive.get(["iq_limit_a"])["iq_limit_a"]
    verdicts = [
        Verdict(f"torque at {line.cycles.value:.4g} cycles per turn", line.amplitude_nm.value, "N m", 0.0, rated_nm)
        for line in found.spectrum.lines
    ]
    cleared = {name: 0.0 for name in drive.parameters if name.startswith("rdc_line")}
    lines = {name: float(value) for name, value in drive_parameters(found).items()}
    return Found(verdicts, cleared | lines, "acts with position_method = rdc")


def _learning(drive: Drive, operator: Operator, progress: Progress) -> Found:
    """The angle observer learns the torque ripple; how even the speed is without it and with it."""
    pi, aro = (parse_value(drive.parameters["method"], word) for word in ("pi", "aro"))
    before = drive.get(["method", "disturbance_observer"])
    speed = LEARN_PART * _top_speed(drive)
    seconds = LEARN_TURNS * TURN_RAD / speed
    try:
        drive.set({"method": pi, "disturbance_observer": 0.0})
        drive.run_speed(speed)
        drive.sleep(1.0)
        uneven = _ripple(drive, speed)
        drive.stop()
        drive.set({"method": aro})  # changes at rest only
        drive.run_speed(speed)
        for part in range(LEARN_PARTS):
            drive.sleep(seconds / LEARN_PARTS)
            drive.need_no_fault()
            progress((part + 1) / LEARN_PARTS)
        even = _ripple(drive, speed)
    except BaseException:
        if not drive.link.lost:
            drive.stop()
            drive.set(before)
        raise
    verdicts = [
        Verdict("speed ripple before, rms", uneven, "rad/s", 0.0, abs(speed)),
        Verdict("speed ripple with what was learned, rms", even, "rad/s", 0.0, LEARN_LIMIT * uneven),
    ]
    note = "" if verdicts[1].good else "does observer_actuation_samples fit the current controller, is mechanics done?"
    return Found(verdicts, {"method": aro}, note)


def _ripple(drive: Drive, speed_rad_s: float) -> float:
    """rms about the mean, over whole turns."""
    with drive.stream(("speed_rad_s",), rate_hz=1000.0) as stream:
        rows = round(RIPPLE_TURNS * TURN_RAD / speed_rad_s * 1000.0)
        return float(stream.read_rows(rows)[:rows].astype(float).std())


PROCEDURES = {
    each.name: each
    for each in (
        Procedure("offsets", "What the current sensors show when no current flows.", "Nothing moves.", _offsets),
        Procedure(
            "encoder", "Direction of the encoder, where the magnets are, and their flux. After rl.",
            "The rotor turns: a push, then some seconds in both directions. The shaft must be free.", _encoder,
            ("motor_resistance_ohm", "motor_ld_h", "motor_lq_h"),
        ),
        Procedure(
            "rl", "Resistance and inductances, for current control.",
            "Nothing turns: the rotor must be locked. Currents up to 30 % of iq_limit_a flow.", _rl,
        ),
        Procedure(
            "mechanics", "Inertia and friction, for observers and position control. After encoder.",
            "The rotor turns in both directions and accelerates. The shaft must be free.", _mechanics,
            ("motor_psi_wb",),
        ),
        Procedure(
            "cogging", "Torque tied to the angle of the rotor. After mechanics.",
            "The rotor turns slowly for some turns. The shaft must be free.", _cogging,
            ("motor_psi_wb", "observer_inertia_kgm2"),
        ),
        Procedure(
            LEARNING, "Torque ripple over the angle, learned by the angle observer (method = aro). After mechanics.",
            "The rotor turns for some ten turns. The shaft must be free.", _learning,
            ("motor_psi_wb", "observer_inertia_kgm2", "observer_viscous_nms"),
        ),
    )
}  # fmt: skip


# ---- what they share


@contextmanager
def _settings(drive: Drive, **words: str) -> Iterator[None]:
    """Parameters that hold while a procedure works."""
    wanted = {name: parse_value(drive.parameters[name], word) for name, word in words.items()}
    before = drive.get(list(wanted))
    drive.set(wanted)
    try:
        yield
    finally:
        if not drive.link.lost:
            drive.stop()
            drive.set(before)


def _torque_per_a(drive: Drive) -> float:
    known = drive.get(["pole_pairs", "motor_psi_wb"])
    return 1.5 * known["pole_pairs"] * known["motor_psi_wb"]


def _top_speed(drive: Drive) -> float:
    """A speed that this supply and this drive allow with room to spare."""
    known = drive.get(["pole_pairs", "motor_psi_wb", "over_speed_rad_s"])
    base = drive.read(("vdc_v",))["vdc_v"] / math.sqrt(3.0) / (known["pole_pairs"] * known["motor_psi_wb"])
    return min(TOP_PART * base, 0.5 * known["over_speed_rad_s"])


def _halt(drive: Drive) -> None:
    """Brake when it runs, else wait until it has coasted; then the bridge is off and the rotor stands, or nearly."""
    if drive.state().state == State.RUN:
        drive.setpoint(Mode.SPEED)
    for _ in range(250):
        if abs(drive.read(("speed_rad_s",))["speed_rad_s"]) < STILL_RAD_S:
            break
        drive.sleep(0.04)
    drive.stop()


def _record(
    drive: Drive,
    name: str,
    stretches: Sequence[tuple[float, float]],
    progress: Progress,
    inertia_kgm2: float = 0.0,
) -> Run:
    """Constant speeds, one after the other: (rad/s, s). `inertia_kgm2`: its torque is taken off."""
    return _record_ramps(drive, name, stretches[0][0], stretches, progress, inertia_kgm2)


def _record_ramps(
    drive: Drive,
    name: str,
    start: float,
    stretches: Sequence[tuple[float, float]],
    progress: Progress,
    inertia_kgm2: float = 0.0,
) -> Run:
    """A stretch of 0 s is a ramp of RAMP_S to its speed."""
    signals = ("theta_m_rad", "speed_ref_rad_s", "iq_a", "speed_rad_s")
    parts: list[NDArray[np.float32]] = []
    done_s = 0.0
    drive.run_speed(start)
    drive.sleep(0.5)
    with drive.stream(signals, rate_hz=1000.0) as stream:
        clock = drive.link.transport.clock
        speed, due_s = start, clock()
        for target, seconds in stretches:
            steps = max(1, round(RAMP_S / RAMP_STEP_S)) if seconds == 0.0 else 1
            for step in range(1, steps + 1):
                drive.setpoint(Mode.SPEED, speed_rad_s=speed + (target - speed) * step / steps)
                due_s += (seconds or RAMP_S) / steps
                while (wait_s := due_s - clock()) > 0.0:
                    drive.sleep(min(wait_s, 0.2))
                    while (block := stream.read(0.0)) is not None:
                        parts.append(block.values)
            speed = target
            done_s += seconds or RAMP_S
            drive.need_no_fault()
            progress(done_s)
        lost = stream.lost_rows
    _halt(drive)
    if lost:
        raise DriveFaultError(f"{name}: {lost} rows of the stream were lost; use a quieter machine")
    values = np.concatenate(parts).astype(float)
    torque = _torque_per_a(drive) * values[:, 2]
    if inertia_kgm2 > 0.0:
        torque = torque - inertia_kgm2 * np.gradient(values[:, 3], 1e-3)
    return Run(name, 1e-3, np.unwrap(values[:, 0]), values[:, 1], torque)


# ---- keeping and undoing


def calibration_toml(done: Calibration, drive: Drive) -> str:
    """What was done, with the values from before: `[drive]` of it is what `undo` writes back."""
    document = tomlkit.document()
    document.add(tomlkit.comment(f"Calibration {done.name}. `evenspin bench calibrate --undo FILE` puts [drive] back."))
    schema = tomlkit.table()
    schema["hash"] = f"{drive.info.schema:08x}"
    document["schema"] = schema
    document["calibration"] = done.name
    document["good"] = done.good
    document["verdict"] = done.lines
    for title, values in (("found", done.found.parameters), ("drive", done.before)):
        table = tomlkit.table()
        for name, value in values.items():
            field = drive.parameters[name]
            table[name] = int(value) if field.kind == "integer" else shortest(value)
        document[title] = table
    return tomlkit.dumps(document)


def free_file(name: str) -> Path:
    """Each calibration has a file of its own: the first one says what was there before all of them."""
    names = (Path(f"calibration-{name}{number}.toml") for number in ("", *(f"-{n}" for n in range(2, 10_000))))
    return next(path for path in names if not path.exists())


def undo(path: Path, drive: Drive) -> dict[str, float]:
    """Put back what a calibration has changed."""
    values = read_config(path, drive)
    return drive.set(values)
