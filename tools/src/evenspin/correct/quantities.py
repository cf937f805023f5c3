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
MOVED = 1e-6  # a reference or a load that stands changes by less
AT_LIMIT = 0.98  # of the current limit: from there on no gain matters


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
    """`kind` is a key of KINDS, `orders` are cycles per turn of the shaft."""

    kind: str
    records: tuple[str, ...]
    orders: tuple[float, ...] = ()

    @property
    def unit(self) -> str:
        return KINDS[self.kind].unit

    @property
    def what(self) -> str:
        orders = " and ".join(f"{order:g}" for order in self.orders)
        return KINDS[self.kind].what.format(orders=orders)

    def measured(self, records: Records, drive: Drive) -> float:
        """nan where the records do not show it."""
        present = {name: records[name] for name in self.records if name in records}
        return KINDS[self.kind].measure(present, drive, self.orders) if present else math.nan


@dataclass(frozen=True, slots=True)
class Kind:
    what: str  # for people; {orders} stands for the orders
    unit: str
    measure: Callable[[Records, Drive, Sequence[float]], float]
    designed: bool = False  # whether it needs the designed records


def steady_stretches(record: Record) -> list[slice]:
    """Rows in which neither reference nor load moves, settled."""
    t_s = record["t_s"]
    moving = np.zeros(len(record), dtype=bool)
    load = np.nan_to_num(record["load_torque_nm"])
    noise = float(np.median(np.abs(np.diff(load)))) if len(load) > 1 else 0.0
    for column, least in ((record["speed_ref_rad_s"], MOVED), (load, MOVED + 12.0 * noise)):
        moving[1:] |= np.abs(np.diff(column)) > least
    starts = np.flatnonzero(moving)
    edges = [0, *(int(i) for i in starts), len(record)]
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
    "current_step": Kind("current after a step, off the designed one, rms", "A", _current_design, True),
    "commutation": Kind("angle of the back-EMF off the q axis, electrical", "degree", _commutation),
}
