"""The steps of commissioning, each with what it needs of the ones before."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from evenspin.bench.client import Drive
from evenspin.bench.errors import DriveFaultError, RefusedError
from evenspin.bench.messages import fault_text
from evenspin.bench.numbers import State
from evenspin.commission.findings import Known, Quality, Step, sure
from evenspin.commission.limits import OVER_SPEED_PART, Bounds, blank
from evenspin.commission.signals import currents, rows
from evenspin.identify.estimate import Estimate

Say = Callable[[str], None]

OFFSET_PART = 0.01  # of the largest current, that may be left after the drive's own calibration
ROUGH_R, SURE_R, SURE_L, SURE_PSI, SURE_J = 0.5, 0.03, 0.03, 0.03, 0.03
FIRST_KI, GROWTH = 0.02, 1.35  # V/(A s) of the first moment, and its growth from step to step
SEEN_PART = 0.3  # of the current asked for: then the resistance is known roughly
SLOW = 6.0  # 1/s: integral gain over resistance, slower than any winding
ATTEMPTS = 8
FULL, HALF = 1.0, 0.5  # currents of the alignment
FASTEST_RAD_S = 20000.0
MOST = re.compile(r"at most ([0-9.e+]+) rad/s")  # what a board says of its limit
PHASE_FAULTS = (
    "align_direction",
    "align_pole_pairs",
    "align_unsettled",
    "align_blocked",
    "align_load",
    "align_turning",
)


@dataclass
class Bench:
    """What the steps share."""

    drive: Drive
    bounds: Bounds
    known: Known
    say: Say
    switched: list[np.ndarray] = field(default_factory=list)  # of the q axis: the flux is not known yet

    @property
    def clock(self) -> float:
        return self.drive.link.transport.clock()

    @property
    def period_s(self) -> float:
        return 1.0 / self.drive.info.pwm_hz

    def set(self, **values: float) -> dict[str, float]:
        """Parameters at rest or running."""
        return self.drive.set(values)

    def done(self, name: str, goal: str, since: float, qualities: list[Quality], parameters: dict[str, float],
             *notes: str) -> Step:  # fmt: skip
        return Step(name, goal, qualities, parameters, self.clock - since, notes)


# ---- limits and offsets


def limits(bench: Bench) -> Step:
    """Nothing of another motor is left in the drive."""
    since, drive = bench.clock, bench.drive
    drive.stop()
    supply = float(np.mean([drive.read(("vdc_v",))["vdc_v"] for _ in range(20)]))
    bench.known.supply_v = supply
    most = bench.bounds.max_voltage_v or 1e9
    qualities = [Quality("supply", supply, 0.0, "V", 5.0, most)]
    accepted = _accepted(bench, supply)
    bench.known.over_speed_rad_s = accepted["over_speed_rad_s"]
    if drive.state().state == State.FAULT:
        drive.clear_fault()
        drive.sleep(0.05)
    bench.known.counts = drive.get(["encoder_counts"])["encoder_counts"]
    return bench.done("limits", "limits of this motor, nothing of another one", since, qualities, accepted)


def _accepted(bench: Bench, supply: float) -> dict[str, float]:
    """As fast as the owner says, but no faster than the board can see."""
    speed = min(OVER_SPEED_PART * bench.bounds.max_speed_rad_s or FASTEST_RAD_S, FASTEST_RAD_S)
    try:
        return bench.drive.set(blank(bench.bounds, supply, speed))
    except RefusedError as refused:
        most = MOST.search(str(refused))
        if "over_speed_rad_s" not in str(refused) or most is None:
            raise
        return bench.drive.set(blank(bench.bounds, supply, 0.9999 * float(most[1])))


def offsets(bench: Bench) -> Step:
    """What the current sensors show while the bridge is off, after the drive's own calibration."""
    since, drive = bench.clock, bench.drive
    for _ in range(60):
        if drive.state().state == State.READY:
            break
        drive.need_no_fault()
        drive.sleep(0.05)
    with drive.stream(("ia_a", "ib_a"), rate_hz=1000.0) as stream:
        values = rows(stream, 0.5)
    limit = OFFSET_PART * bench.bounds.max_current_a
    half = 1.96 * values.std(axis=0) / math.sqrt(len(values))
    qualities = [
        Quality(f"offset that is left in phase {phase}", float(values[:, k].mean()), float(half[k]), "A", -limit, limit)
        for k, phase in enumerate("ab")
    ]
    noise = float(values.std())
    qualities.append(Quality("noise of a current sample, rms", noise, 0.0, "A", 0.0, limit))
    return bench.done("offsets", "offsets and noise of the current sensors", since, qualities, {})


# ---- resistance, pole pairs, direction, electrical zero


def resistance_roughly(bench: Bench) -> Step:
    """An integral gain that grows from harmless to where the current is seen, on a vector that stands still."""
    since, drive = bench.clock, bench.drive
    wanted = drive.get(["align_current_a"])["align_current_a"]
    gain = FIRST_KI
    found = 0.0
    count, began = 0, since
    for _ in range(ATTEMPTS):
        bench.set(current_ki_v_per_as=gain)
        _begin(bench)
        count, began = 0, bench.clock
        while drive.state().state == State.ALIGN and found == 0.0:
            seen = drive.read(("id_a", "vd_v"))
            if seen["id_a"] > SEEN_PART * wanted:
                found = seen["vd_v"] / seen["id_a"]
                break
            if seen["vd_v"] > 0.5 * bench.known.supply_v / math.sqrt(3.0):
                break
            gain *= GROWTH
            count += 1
            bench.set(current_ki_v_per_as=min(gain, 1e6))
            drive.sleep(0.02)
        drive.stop()
        if found or drive.state().state == State.FAULT:
            break
    if not found:
        now = drive.state()
        why = fault_text(drive.schema, now.fault, now.detail) if now.state == State.FAULT else "no current flows"
        raise DriveFaultError(f"resistance: {why}; are the three phases connected, and is the supply on?")
    bench.known.resistance = Estimate(found, found)
    bench.known.growth_s = (bench.clock - began) / max(count, 1) / math.log(GROWTH)
    accepted = bench.set(current_ki_v_per_as=SLOW * found, current_kp_v_per_a=0.0)
    quality = [Quality("resistance, roughly", found, 0.0, "ohm", 1e-4, 1e3)]
    return bench.done("current", "the first current, slowly", since, quality, accepted)


def _begin(bench: Bench) -> None:
    """Start, without waiting: the drive aligns."""
    drive = bench.drive
    if drive.state().state == State.FAULT:
        drive.clear_fault()
        drive.sleep(0.02)
    currents(drive)
    drive.command("arm")
    drive.link.keep_alive = True
    drive.command("start")
    for _ in range(10_000):
        now = drive.state()
        moving = now.state == State.ALIGN and drive.read(("id_ref_a",))["id_ref_a"] > 0.0
        if moving or now.state in (State.RUN, State.FAULT):
            return
        drive.sleep(0.01)


def alignment(bench: Bench) -> Step:
    """Pole pairs and direction from how the shaft follows a slow vector; resistance from its two currents."""
    since, drive = bench.clock, bench.drive
    accepted: dict[str, float] = {}
    notes: list[str] = []
    current = drive.get(["align_current_a"])["align_current_a"]
    tries = [(part, turns) for turns in (1, 2) for part in (1.0, 1.6, 0.5)]
    for _ in range(ATTEMPTS):
        taken = _aligned(bench)
        now = drive.state()
        if now.state == State.RUN:
            drive.stop()
            break
        fault = drive.schema.fault(now.fault).name
        notes.append(fault_text(drive.schema, now.fault, now.detail).split(":")[0])
        drive.clear_fault()
        drive.sleep(0.05)
        if fault == "align_direction":
            bench.known.reversed = not bench.known.reversed
            accepted |= bench.set(encoder_reversed=float(bench.known.reversed))
        elif fault == "align_pole_pairs":
            bench.known.pole_pairs = int(now.detail)
            accepted |= bench.set(pole_pairs=float(now.detail))
        elif fault in PHASE_FAULTS and tries:
            # More current stiffens the swing of a light rotor, up to its trip: less first.
            less = next((k for k, (part, _) in enumerate(tries) if part < 1.0), 0)
            part, turns = tries.pop(less if fault == "align_unsettled" else 0)
            most = bench.bounds.max_current_a
            accepted |= bench.set(align_current_a=min(part * current, most), align_turns=float(turns))
        else:
            raise DriveFaultError(f"alignment: {fault_text(drive.schema, now.fault, now.detail)}")
    else:
        raise DriveFaultError(f"alignment: not after {ATTEMPTS} attempts: {'; '.join(notes)}")
    bench.known.resistance = _two_currents(taken)
    bench.known.offset_rad = _zero(taken, bench.known)
    accepted |= bench.set(motor_resistance_ohm=bench.known.resistance.value)
    qualities = [Quality("pole pairs", bench.known.pole_pairs, 0.0, "", 1.0, 50.0)]
    qualities += sure("resistance", bench.known.resistance, "ohm", ROUGH_R)
    goal = "pole pairs, direction and electrical zero from a slow vector; resistance"
    return bench.done("alignment", goal, since, qualities, accepted, *notes)


def _aligned(bench: Bench) -> np.ndarray:
    drive = bench.drive
    parts = []
    with drive.stream(("id_ref_a", "id_a", "vd_v", "ia_a", "ib_a", "theta_m_rad"), rate_hz=500.0) as stream:
        _begin(bench)
        while True:
            parts.append(rows(stream, 0.1))
            if drive.state().state in (State.RUN, State.FAULT):
                return np.concatenate(parts)


def _zero(taken: np.ndarray, known: Known) -> float:
    """Electrical angle at encoder angle zero, from the phase currents while the vector turns: both ways, so that
    friction drops out."""
    reference = taken[:, 0]
    turning = reference > 0.95 * reference.max()
    alpha, beta = taken[turning, 3], (taken[turning, 3] + 2.0 * taken[turning, 4]) / math.sqrt(3.0)
    vector = np.unwrap(np.arctan2(beta, alpha))
    shaft = known.pole_pairs * np.unwrap(taken[turning, 5])
    pace = np.convolve(np.gradient(vector), np.ones(25) / 25.0, "same")
    best = (math.inf, 0.0)
    for sign in (1.0, -1.0):  # of an encoder that counts the other way
        apart = np.exp(1j * (vector - sign * shaft))
        forward, back = apart[pace > 0.8 * pace.max()].mean(), apart[pace < 0.8 * pace.min()].mean()
        both = forward / abs(forward) + back / abs(back)
        best = min(best, (2.0 - abs(both), float(np.angle(both))))
    return best[1]


def _two_currents(taken: np.ndarray) -> Estimate:
    """Voltage over current between the whole and the half of it: what a dead time adds to both drops out."""
    reference = taken[:, 0]
    top = float(reference.max())
    settled = 150  # rows
    means = []
    for level in (HALF * top, FULL * top):
        at = np.abs(reference - level) < 1e-3 * top
        since = np.cumsum(at) * at
        starts = np.flatnonzero(at & (since > 0))
        use = np.array([row for row in starts if row >= settled and at[row - settled : row + 1].all()], dtype=int)
        if len(use) < 50:
            raise DriveFaultError("resistance: the alignment did not hold both of its currents; raise align_periods")
        means.append(
            (taken[use, 1:3].mean(axis=0), taken[use, 1:3].std(axis=0) / math.sqrt(max(len(use) / 100.0, 1.0)))
        )
    (low, low_std), (high, high_std) = means
    di, dv = float(high[0] - low[0]), float(high[1] - low[1])
    value = dv / di
    spread = 1.96 * math.hypot(math.hypot(low_std[1], high_std[1]) / dv, math.hypot(low_std[0], high_std[0]) / di)
    return Estimate(value, abs(value) * spread)
