"""What an effect spoils, as one number of a set of records: the same from a log, from a simulation, and after a change.

Each is measured from columns of the log format alone, so that a drive on a bench can be judged by it as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.sim.record import Record

Array = NDArray[np.float64]
Records = Mapping[str, Record]

RPM = math.pi / 30.0
SETTLE_S = 0.35  # after a step of reference or load: four time constants of a speed loop of 8 Hz with its integral part
LEAST_S = 0.3  # of a steady stretch
CYCLES = 1.5  # of the slowest line that is fitted
NYQUIST_SHARE = 0.8
CROSSING_S = 0.25  # after the reference has passed zero
STEP_S = 0.35  # after a step of the speed reference
CURRENT_STEP_S = 0.020  # after a step of a current reference
CURRENT_MEAN_S = 0.001  # over which noise of the sensors is averaged
OVERSHOOT_MEAN_S = 0.0003
LARGE_STEP = 0.5  # of the largest: noise is a small share of these
MOVED = 1e-6  # a reference or a load that stands changes by less
AT_LIMIT = 0.98  # of the current limit: from there on no gain matters
NEAR = np.linspace(0.75, 1.25, 11)  # of a resonance: where the closed loop may swing instead
SWINGS = 3.0  # periods of a resonance after a step that tell it from the step


@dataclass(frozen=True, slots=True)
class Drive:
    """What a quantity has to know of the drive beside its records."""

    pole_pairs: float
    resistance_ohm: float
    ld_h: float
    lq_h: float
    iq_limit_a: float
    designed: Records  # the nominal machine with the gains that it was designed for, from the same references

    @classmethod
    def of(cls, meta: Mapping[str, Any], designed: Records) -> Drive:
        motor = meta["motor"]
        return cls(
            float(motor["pole_pairs"]),
            float(motor["resistance_ohm"]),
            float(motor["ld_h"]),
            float(motor["lq_h"]),
            float(meta["speed_loop"]["iq_limit_a"]),
            designed,
        )


@dataclass(frozen=True, slots=True)
class Quantity:
    """`kind` is a key of KINDS, `orders` are cycles per turn of the shaft; `hz` has frequencies instead."""

    kind: str
    records: tuple[str, ...]
    orders: tuple[float, ...] = ()
    hz: tuple[float, ...] = ()

    @property
    def unit(self) -> str:
        return KINDS[self.kind].unit

    @property
    def what(self) -> str:
        orders, hz = (" and ".join(f"{value:.4g}" for value in values) for values in (self.orders, self.hz))
        return KINDS[self.kind].what.format(orders=orders, hz=hz)

    def measured(self, records: Records, drive: Drive) -> float:
        """nan where the records do not show it."""
        present = {name: records[name] for name in self.records if name in records}
        return KINDS[self.kind].measure(present, drive, self.hz or self.orders) if present else math.nan


@dataclass(frozen=True, slots=True)
class Kind:
    what: str  # for people; {orders} stands for the orders, {hz} for the frequencies
    unit: str
    measure: Callable[[Records, Drive, Sequence[float]], float]  # the last: orders or frequencies
    designed: bool = False  # whether it needs the designed records


def _edges(record: Record) -> list[int]:
    """The first row, rows in which reference or load moves, and the end."""
    moving = np.zeros(len(record), dtype=bool)
    load = np.nan_to_num(record["load_torque_nm"])
    noise = float(np.median(np.abs(np.diff(load)))) if len(load) > 1 else 0.0
    for column, least in ((record["speed_ref_rad_s"], MOVED), (load, MOVED + 12.0 * noise)):
        moving[1:] |= np.abs(np.diff(column)) > least
    return [0, *(int(i) for i in np.flatnonzero(moving)), len(record)]


def steady_stretches(record: Record) -> list[slice]:
    """Rows in which neither reference nor load moves, settled."""
    t_s, edges = record["t_s"], _edges(record)
    found = []
    for begin, end in zip(edges, edges[1:], strict=False):
        first = begin + int(np.searchsorted(t_s[begin:end] - t_s[begin], SETTLE_S)) if end > begin else end
        if end - first > 1 and t_s[end - 1] - t_s[first] >= LEAST_S and record["speed_ref_rad_s"][first] != 0.0:
            found.append(slice(first, end))
    return found


def lines(value: Array, theta_rad: Array, orders: Sequence[float]) -> Array:
    """Amplitude of each order of the angle, beside mean and trend."""
    theta = np.unwrap(theta_rad)
    phases = np.outer(theta, orders)
    ramp = np.linspace(-1.0, 1.0, len(value))
    columns = np.column_stack((np.ones(len(value)), ramp, np.cos(phases), np.sin(phases)))
    found = np.linalg.lstsq(columns.T @ columns, columns.T @ value, rcond=None)[0][2:]
    return np.hypot(found[: len(orders)], found[len(orders) :])


def _ripple(records: Records, orders: Sequence[float], signals: Sequence[str]) -> float:
    """rms over all steady stretches of the amplitude of these orders in these signals, together."""
    squares = []
    for record in records.values():
        rate_hz = 1.0 / float(np.median(np.diff(record["t_s"])))
        for part in steady_stretches(record):
            theta = np.unwrap(record["theta_m_rad"][part])
            turns = abs(theta[-1] - theta[0]) / math.tau
            hz = turns / max(float(record["t_s"][part][-1] - record["t_s"][part][0]), 1e-9)
            if turns * min(orders) < CYCLES or hz * max(orders) > 0.5 * NYQUIST_SHARE * rate_hz:
                continue
            squares.append(sum(float(np.sum(lines(record[s][part], theta, orders) ** 2)) for s in signals))
    return math.sqrt(float(np.mean(squares))) if squares else math.nan


def _speed_ripple(records: Records, drive: Drive, orders: Sequence[float]) -> float:
    return _ripple(records, orders, ("speed_rad_s",)) / RPM


def _current_ripple(records: Records, drive: Drive, orders: Sequence[float]) -> float:
    return _ripple(records, orders, ("id_a", "iq_a"))


def _unevenness(records: Records, drive: Drive, orders: Sequence[float]) -> float:
    """rms over all steady stretches of the speed about its mean."""
    squares = [
        float(np.var(record["speed_rad_s"][part])) for record in records.values() for part in steady_stretches(record)
    ]
    return math.sqrt(float(np.mean(squares))) / RPM if squares else math.nan


def _reversal(records: Records, drive: Drive, orders: Sequence[float]) -> float:
    """rms of speed less that of the designed drive after each change of direction, the first start among them."""
    squares: list[float] = []
    for name, record in records.items():
        if name not in drive.designed:
            continue
        t_s, sign = record["t_s"], np.sign(record["speed_ref_rad_s"])
        off = record["speed_rad_s"] - drive.designed[name]["speed_rad_s"]
        for at in np.flatnonzero((sign[1:] != 0.0) & (sign[1:] != sign[:-1])) + 1:
            squares += list(off[int(at) : int(np.searchsorted(t_s, t_s[at] + CROSSING_S))] ** 2)
    return math.sqrt(float(np.mean(squares))) / RPM if squares else math.nan


def _speed_design(records: Records, drive: Drive, orders: Sequence[float]) -> float:
    """rms of speed less that of the designed drive after steps that neither of them meets at its current limit."""
    squares: list[float] = []
    for name, record in records.items():
        if name not in drive.designed:
            continue
        design, t_s, wanted = drive.designed[name], record["t_s"], record["speed_ref_rad_s"]
        for at in [0, *(np.flatnonzero(np.abs(np.diff(wanted)) > MOVED) + 1)]:
            part = slice(int(at), int(np.searchsorted(t_s, t_s[at] + STEP_S)))
            asked = np.maximum(np.abs(record["iq_ref_a"][part]), np.abs(design["iq_ref_a"][part]))
            if wanted[at] == 0.0 or np.max(asked) > AT_LIMIT * drive.iq_limit_a:
                continue
            squares += list((record["speed_rad_s"][part] - design["speed_rad_s"][part]) ** 2)
    return math.sqrt(float(np.mean(squares))) / RPM if squares else math.nan


def _swing(records: Records, drive: Drive, hz: Sequence[float]) -> float:
    """rms over the steps of the largest sine near a resonance in the speed less that of the designed drive."""
    squares: list[float] = []
    for name, record in records.items():
        if name not in drive.designed:
            continue
        design, t_s, edges = drive.designed[name], record["t_s"], _edges(record)
        if max(hz) > 0.5 * NYQUIST_SHARE / float(np.median(np.diff(t_s))):
            continue
        for begin, end in zip(edges, edges[1:], strict=False):
            part = slice(begin, min(end, int(np.searchsorted(t_s, t_s[begin] + STEP_S)))) if begin < end else slice(0)
            asked = np.maximum(np.abs(record["iq_ref_a"][part]), np.abs(design["iq_ref_a"][part]))
            late_s = t_s[part] - t_s[begin]
            if not len(late_s) or late_s[-1] * min(hz) < SWINGS or np.max(asked) > AT_LIMIT * drive.iq_limit_a:
                continue
            off = record["speed_rad_s"][part] - design["speed_rad_s"][part]
            squares.append(sum(_largest_sine(late_s, off, each * NEAR) for each in hz) ** 2)
    return math.sqrt(float(np.mean(squares))) / RPM if squares else math.nan


def _largest_sine(t_s: Array, value: Array, hz: Array) -> float:
    """Its amplitude beside mean and trend, by least squares that count the middle most."""
    weight, found = np.hanning(len(t_s)), 0.0
    for each in hz:
        phase = math.tau * each * t_s
        columns = np.column_stack((np.ones(len(t_s)), t_s, np.cos(phase), np.sin(phase))) * weight[:, None]
        fit = np.linalg.lstsq(columns.T @ columns, columns.T @ (value * weight), rcond=None)[0]
        found = max(found, math.hypot(fit[2], fit[3]))
    return found


def _current_design(records: Records, drive: Drive, orders: Sequence[float]) -> float:
    """rms of both currents less those of the designed drive after steps of their references."""
    squares: list[float] = []
    for name, record in records.items():
        if name not in drive.designed:
            continue
        design, t_s = drive.designed[name], record["t_s"]
        moved = np.abs(np.diff(record["id_ref_a"])) + np.abs(np.diff(record["iq_ref_a"]))
        for at in np.flatnonzero(moved > MOVED) + 1:
            part = slice(int(at), int(np.searchsorted(t_s, t_s[at] + CURRENT_STEP_S)))
            rows = max(1, round(CURRENT_MEAN_S / float(np.median(np.diff(t_s)))))
            for signal in ("id_a", "iq_a"):
                off = record[signal][part] - design[signal][part]
                squares += list(np.convolve(off, np.full(rows, 1.0 / rows), "valid") ** 2)
    return math.sqrt(float(np.mean(squares))) if squares else math.nan


def _current_overshoot(records: Records, drive: Drive, orders: Sequence[float]) -> float:
    """rms over the large steps of a current reference of how far the current goes beyond it, over the step."""
    squares: list[float] = []
    for record in records.values():
        t_s = record["t_s"]
        rows = max(1, round(OVERSHOOT_MEAN_S / float(np.median(np.diff(t_s)))))
        for axis in ("d", "q"):
            wanted, current = record[f"i{axis}_ref_a"], record[f"i{axis}_a"]
            step = np.diff(wanted)
            for at in np.flatnonzero(np.abs(step) >= LARGE_STEP * np.max(np.abs(step), initial=MOVED)) + 1:
                part = slice(int(at), int(np.searchsorted(t_s, t_s[at] + CURRENT_STEP_S)))
                if part.stop - part.start <= rows:
                    continue
                share = np.convolve((current[part] - wanted[at]) / step[at - 1], np.full(rows, 1.0 / rows), "valid")
                squares.append(max(float(np.max(share)), 0.0) ** 2)
    return 100.0 * math.sqrt(float(np.mean(squares))) if squares else math.nan


def _commutation(records: Records, drive: Drive, orders: Sequence[float]) -> float:
    """Angle between the back-EMF and the q axis of the drive, from the mean voltages of both directions."""
    d_v = q_v = 0.0
    directions = set()
    for record in records.values():
        for part in steady_stretches(record):
            mean = {name: float(np.mean(record[name][part])) for name in ("vd_v", "vq_v", "id_a", "iq_a")}
            speed = float(np.mean(record["speed_rad_s"][part]))
            w = drive.pole_pairs * speed
            directions.add(speed > 0.0)
            side = math.copysign(1.0, w)
            d_v += side * (mean["vd_v"] - drive.resistance_ohm * mean["id_a"] + w * drive.lq_h * mean["iq_a"])
            q_v += side * (mean["vq_v"] - drive.resistance_ohm * mean["iq_a"] - w * drive.ld_h * mean["id_a"])
    return math.degrees(abs(math.atan2(d_v, q_v))) if len(directions) == 2 else math.nan


KINDS: Mapping[str, Kind] = {
    "speed_ripple": Kind("speed ripple at order {orders} of the shaft", "r/min", _speed_ripple),
    "unevenness": Kind("all ripple of the speed, rms", "r/min", _unevenness),
    "current_ripple": Kind("current ripple at order {orders} of the shaft", "A", _current_ripple),
    "reversal": Kind("speed after a reversal, off the designed one, rms", "r/min", _reversal, True),
    "speed_step": Kind("speed after a step, off the designed one, rms", "r/min", _speed_design, True),
    "swing": Kind("swing of the speed at {hz} Hz after steps, off the designed one", "r/min", _swing, True),
    "current_step": Kind("current after a step, off the designed one, rms", "A", _current_design, True),
    "current_overshoot": Kind("overshoot of large current steps, rms", "%", _current_overshoot),
    "commutation": Kind("angle of the back-EMF off the q axis, electrical", "degree", _commutation),
}
