"""A disturbance with a frequency or an order that no effect of the table has: found, and taken off the log.

Such a line hides what is known: it leaks into the means of stretches that do not hold a whole number of its periods,
and it lies over every transient. The records less the line are searched as any other log is; the verdict reports the
line beside the names that were found so.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.compare import Replay
from evenspin.gap.features import SIGNALS
from evenspin.gap.forward import READ, Forward
from evenspin.gap.layout import Layout, Stretch, layout_of
from evenspin.gap.leftover import Line
from evenspin.gap.thresholds_effects import LINE_RATIO
from evenspin.gap.thresholds_evidence import PERIODIC_SHARE, PERIODIC_STRETCHES
from evenspin.log.case import Case
from evenspin.log.unit import Unit
from evenspin.sim.record import Record

WITHIN_BINS = 1.5  # of the spectrum: peaks of the same line in two stretches
LINES_MOST = 4
KNOWN_TURNS = 0.25  # cycles over a stretch by which an order differs from one that is the same
HARMONICS = (1, 2, 3)
SLOW_SHARE = 0.9  # of the slowest stretch that shows an order
CYCLES_LEAST = 3.0  # of an order within a stretch: below, it cannot be separated from the mean and the trend
NYQUIST_SHARE = 0.9
ZOOM = 1001  # points over the width of two bins
ORDERS_PER_BIN, ORDERS_MOST = 20, 2001  # that are tried; a stretch that holds a part of a turn has wide bins
BAND_BINS = 6  # on each side of a line: wider than the window, narrower than a resonance

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PeriodicLine:
    """Something that repeats with the time (`hz`), or with the angle of the rotor (`order` per turn)."""

    hz: float | None
    order: float | None
    stretches: int  # steady stretches that show it
    amplitude_rad_s: float  # of the speed, where that is largest

    @property
    def text(self) -> str:
        where = f"in {self.stretches} stretches, up to {self.amplitude_rad_s:.3g} rad/s"
        return f"{self.hz:.2f} Hz at all speeds, {where}" if self.hz is not None else f"order {self.order:.4g}, {where}"


def periodic_lines(
    forward: Forward, found: Sequence[Line], unit: Unit, least_ratio: float = LINE_RATIO
) -> tuple[PeriodicLine, ...]:
    """What the lines that a model leaves have in common, strongest first; `unit`: the machine that leaves them.

    Of a shaft that turns: at rest a frequency has no order, and nothing is taken off.
    """
    left = [line for line in found if line.ratio > LINE_RATIO and 0.0 < line.hz and line.speed_rad_s != 0.0]
    out: list[PeriodicLine] = []
    logs: list[_Log] = []
    while left and len(out) < LINES_MOST:
        first = max(left, key=lambda line: line.ratio)
        if first.ratio < least_ratio:
            break
        logs = logs or _logs_of(forward, unit)
        same_hz = [x for x in left if abs(x.hz - first.hz) * x.seconds <= WITHIN_BINS]
        same_order = [x for x in left if abs(x.order - first.order) * _turns(x) <= WITHIN_BINS]
        by_order = _evidence(same_order) >= _evidence(same_hz)
        members = same_order if by_order else same_hz
        left = [x for x in left if x not in members]
        stretches = len({(x.record, x.speed_rad_s) for x in members})
        if stretches < PERIODIC_STRETCHES:
            continue
        value = _order(logs, members) if by_order else _frequency(logs, first)
        turns = max(_turns(x) for x in members)
        if by_order and any(abs(value - k) * turns <= KNOWN_TURNS for k in forward.orders):
            continue
        line = PeriodicLine(
            None if by_order else value,
            value if by_order else None,
            stretches,
            max((x.amplitude for x in members if x.signal == "speed_rad_s"), default=0.0),
        )
        if _share_taken(logs, _wave_of(line, forward.orders, (1,)), first) > PERIODIC_SHARE:
            out.append(line)
    return tuple(out)


@dataclass(frozen=True, slots=True)
class Cleaned:
    """A case less lines, and the rows of each record in which they are not known: slower than any stretch shows."""

    case: Case
    uncertain: Mapping[str, NDArray[np.bool_]]


def without(case: Case, forward: Forward, lines: Sequence[PeriodicLine], unit: Unit) -> Cleaned:
    """The case less the lines and two harmonics of each, as far as they show in what `unit` leaves of each record."""
    logs = []
    for name, record in case.experiments.items():
        replay = Replay(case.path, case.meta, name, record)
        if not replay.locked:
            layout = layout_of(replay, record)
            logs.append(_Log(name, record, layout, replay.run(READ, unit, layout.end)))
    for line in lines:
        _take_off(logs, _wave_of(line, forward.orders, HARMONICS))
    records = {**case.experiments, **{log.name: log.cleaned() for log in logs}}
    rows = {log.name: log.uncertain for log in logs if log.uncertain is not None}
    return Cleaned(replace(case, experiments=records), rows)


@dataclass(slots=True)
class _Log:
    """A record while lines are taken off it."""

    name: str
    record: Record
    layout: Layout
    simulated: Array  # columns as READ
    taken: Array | None = None  # columns as SIGNALS
    uncertain: NDArray[np.bool_] | None = None

    @property
    def left(self) -> Array:
        """What was measured less what was simulated and taken off, as far as it is compared."""
        measured = self.record.pick(SIGNALS).values[: self.layout.end]
        return measured - self.simulated[:, 1:] - (0.0 if self.taken is None else self.taken[: self.layout.end])

    @property
    def rate_hz(self) -> float:
        return 1.0 / float(np.median(np.diff(self.record["t_s"])))

    @property
    def speed(self) -> Array:
        """Of the simulation, which has no line in it."""
        speed = self.simulated[:, 1]
        return np.concatenate((speed, np.full(len(self.record) - len(speed), speed[-1] if len(speed) else 0.0)))

    @property
    def turning(self) -> list[Stretch]:
        return [s for s in self.layout.steady if s.speed_rad_s != 0.0]

    def cleaned(self) -> Record:
        values = np.array(self.record.values)
        if self.taken is not None:
            values[:, [self.record.names.index(name) for name in SIGNALS]] -= self.taken
        return Record(self.record.names, self.record.units, values)


@dataclass(frozen=True, slots=True)
class _Wave:
    hz: float | None
    order: float
    harmonics: tuple[int, ...]

    def columns(self, phase: Array) -> Array:
        return np.stack([f(n * phase) for n in self.harmonics for f in (np.cos, np.sin)], axis=1)

    def phase(self, log: _Log) -> Array:
        if self.hz is not None:
            return math.tau * self.hz * log.record["t_s"]
        return self.order * np.unwrap(log.record["theta_m_rad"])

    @property
    def is_tied(self) -> bool:
        """To a place of the rotor, so that all records have it at the same phase."""
        return self.hz is None and self.order == round(self.order)


def _wave_of(line: PeriodicLine, known: Sequence[float], harmonics: Sequence[int]) -> _Wave:
    """The line with the harmonics that are no order of a known effect."""
    if line.hz is not None:
        return _Wave(line.hz, 0.0, tuple(harmonics))
    order = line.order or 0.0
    return _Wave(None, order, tuple(n for n in harmonics if n * order not in known))


def _take_off(logs: Sequence[_Log], wave: _Wave) -> None:
    """The wave as the stretches show it; between them by the speed, of all records where it is tied to the rotor."""
    phases = [wave.phase(log) for log in logs]
    found = [_in_stretches(log, wave, phase) for log, phase in zip(logs, phases, strict=True)]
    pooled = [item for each in found for item in each]
    for log, phase, own in zip(logs, phases, found, strict=True):
        points = pooled if wave.is_tied else own
        if not points:
            continue
        amount = _by_speed(points, log.speed) if wave.is_tied or wave.hz is None else _by_time(own, log)
        for stretch, amounts in own:
            amount[stretch.start : stretch.end] = amounts
        taken = np.einsum("nk,nks->ns", wave.columns(phase), amount)
        log.taken = taken if log.taken is None else log.taken + taken
        if wave.hz is None:
            slow = np.abs(log.speed) < SLOW_SHARE * min(abs(s.speed_rad_s) for s, _ in points)
            log.uncertain = slow if log.uncertain is None else log.uncertain | slow


def _in_stretches(log: _Log, wave: _Wave, phase: Array) -> list[tuple[Stretch, Array]]:
    """Amounts in each stretch; those of a slow frequency common to the stretches of a loop that is closed, or open."""
    left, out = log.left, []
    for s in log.turning:
        amounts = _amounts(wave, [s], phase, left)
        if amounts is None and wave.hz is not None:
            amounts = _amounts(wave, [x for x in log.turning if x.coasting == s.coasting], phase, left)
        if amounts is not None:
            out.append((s, amounts))
    return out


def _by_speed(points: Sequence[tuple[Stretch, Array]], speed: Array) -> Array:
    """Linear between the speeds that are known, and constant beyond."""
    at = np.array([s.speed_rad_s for s, _ in points])
    unique = np.unique(np.round(at, 3))
    mean = np.array(
        [np.mean([a for (_, a), w in zip(points, at, strict=True) if round(w, 3) == u], axis=0) for u in unique]
    )
    flat = mean.reshape(len(unique), -1)
    columns = [np.interp(speed, unique, flat[:, i]) for i in range(flat.shape[1])]
    return np.stack(columns, axis=1).reshape(len(speed), *mean.shape[1:])


def _by_time(own: Sequence[tuple[Stretch, Array]], log: _Log) -> Array:
    """From the stretch before to the next one, as the speed goes from one to the other."""
    out = np.empty((len(log.record), *own[0][1].shape))
    at, before = 0, own[0]
    for stretch, amounts in own:
        rest = slice(at, max(at, stretch.start))
        change = stretch.speed_rad_s - before[0].speed_rad_s
        share = np.ones(rest.stop - rest.start)
        if abs(change) > 0.0:
            share = np.clip((log.speed[rest] - before[0].speed_rad_s) / change, 0.0, 1.0)
        out[rest] = before[1] + share[:, None, None] * (amounts - before[1])
        at, before = stretch.end, (stretch, amounts)
        out[stretch.start : at] = amounts
    out[at:] = before[1]
    return out


def _amounts(wave: _Wave, group: Sequence[Stretch], phase: Array, left: Array) -> Array | None:
    """Cosine and sine of each signal, common to some stretches, beside a mean and a trend of each of them."""
    turned = sum(abs(float(phase[s.end - 1] - phase[s.start])) for s in group) / math.tau
    if turned < CYCLES_LEAST:
        return None
    columns, values = [], []
    for s in group:
        ramp = np.linspace(-1.0, 1.0, s.end - s.start)
        base = np.stack((np.ones_like(ramp), ramp), axis=1)
        waves = wave.columns(phase[s.start : s.end])
        data = np.hstack((waves, left[s.start : s.end]))
        data = data - base @ np.linalg.lstsq(base, data, rcond=None)[0]
        columns.append(data[:, : waves.shape[1]])
        values.append(data[:, waves.shape[1] :])
    return np.asarray(np.linalg.lstsq(np.concatenate(columns), np.concatenate(values), rcond=None)[0], dtype=np.float64)


def _logs_of(forward: Forward, unit: Unit) -> list[_Log]:
    simulated = forward.simulate(unit)
    return [
        _Log(features.layout.record, forward.case.experiments[features.layout.record], features.layout, run)
        for features, run in zip(forward.sets, simulated, strict=True)
    ]


def _share_taken(logs: Sequence[_Log], wave: _Wave, line: Line) -> float:
    log = next(each for each in logs if each.name == line.record)
    s = next(each for each in log.turning if each.speed_rad_s == line.speed_rad_s and not each.coasting)
    phase, left = wave.phase(log), log.left
    amounts = _amounts(wave, [s], phase, left)
    if amounts is None:
        return 0.0
    signal = SIGNALS.index(line.signal)
    taken = wave.columns(phase[s.start : s.end]) @ amounts[:, signal]
    return tone_share(left[s.start : s.end, signal], taken, round(line.hz * line.seconds))


def tone_share(x: Array, wave: Array, peak: int) -> float:
    """Of the power around a bin of the spectrum, the part that goes with a wave.

    All of a tone; of a resonance that noise excites, little: that is wider than a bin.
    """
    window, band = np.hanning(len(x)), slice(max(1, peak - BAND_BINS), peak + BAND_BINS + 1)
    before, after = (float(np.sum(np.abs(np.fft.rfft(window * (y - np.mean(y)))[band]) ** 2)) for y in (x, x - wave))
    return 1.0 - after / before if before > 0.0 else 0.0


def _turns(line: Line) -> float:
    return abs(line.speed_rad_s) / math.tau * line.seconds


def _evidence(lines: Sequence[Line]) -> tuple[int, float]:
    """Different speeds first: lines at one speed have the frequency and the order in common."""
    return len({round(abs(x.speed_rad_s), 3) for x in lines}), sum(math.log(x.ratio) for x in lines)


def _frequency(logs: Sequence[_Log], line: Line) -> float:
    """The frequency that carries most power over whole records, which hold many more periods than a stretch."""
    from scipy.signal import zoom_fft  # six tenths of a second, which a log without such a line does not need

    signal = SIGNALS.index(line.signal)
    low, high = max(0.0, line.hz - 1.0 / line.seconds), line.hz + 1.0 / line.seconds
    power = np.zeros(ZOOM)
    for log in logs:
        settled = np.zeros(log.layout.end)
        left = log.left
        for s in log.turning:
            if not s.coasting:
                x = left[s.start : s.end, signal]
                settled[s.start : s.end] = x - np.mean(x)
        if settled.any() and high < NYQUIST_SHARE * log.rate_hz / 2.0:
            power += np.abs(zoom_fft(settled, [low, high], m=ZOOM, fs=log.rate_hz, endpoint=True)) ** 2
    return float(np.linspace(low, high, ZOOM)[int(np.argmax(power))])


def _order(logs: Sequence[_Log], members: Sequence[Line]) -> float:
    """The order that carries most power over the stretches; a whole one where they cannot tell it from that."""
    first = max(members, key=lambda line: line.ratio)
    signal, turns = SIGNALS.index(first.signal), max(_turns(line) for line in members)
    low, high = (edge(x.order + side / _turns(x) for x in members) for edge, side in ((min, -1.0), (max, 1.0)))
    trial = np.linspace(low, high, min(ORDERS_MOST, 1 + math.ceil((high - low) * turns * ORDERS_PER_BIN)))
    power = np.zeros(len(trial))
    for log in logs:
        angle, left = np.unwrap(log.record["theta_m_rad"]), log.left
        for s in log.turning:
            if not s.coasting:
                x = left[s.start : s.end, signal]
                window = np.hanning(len(x)) * (x - np.mean(x))
                power += np.abs(np.exp(-1j * trial[:, None] * angle[None, s.start : s.end]) @ window) ** 2
    best = float(trial[int(np.argmax(power))])
    whole = round(best)
    return float(whole) if whole > 0 and abs(best - whole) * turns < KNOWN_TURNS else best


def as_json(lines: Sequence[PeriodicLine]) -> list[Mapping[str, object]]:
    """For verdict.json."""
    return [
        {
            "hz": line.hz,
            "order": line.order,
            "stretches": line.stretches,
            "speed_amplitude_rad_s": line.amplitude_rad_s,
            "text": line.text,
        }
        for line in lines
    ]
