"""What repeats with the angle: lines of the torque balance in mechanical orders.

Columns are sin and cos of order times angle, smoothed like everything else, so a wandering speed does no harm. A speed
controller that answers the ripple does none either: the measured current is part of the balance. Whether a line is real
is judged against the half orders between the whole ones: nothing on the shaft repeats there, so what is found there is
noise, whatever its colour.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.gap.balance.angle_zero import at_zero, find_zero
from evenspin.gap.balance.controller import vertex
from evenspin.gap.balance.friction import Flags, halves, known_part
from evenspin.gap.balance.grid import Grid, Smoother
from evenspin.gap.balance.motion import Motion
from evenspin.gap.balance.nominal import Line, Nominal
from evenspin.gap.balance.regression import Fit, fit, inflation, rms

Array = NDArray[np.float64]

TURN = 2.0 * np.pi
SIGMA_S = 2.5e-3  # smoothing: short, for lines of some ten hertz; at least SIGMA_ROWS rows
SIGMA_ROWS = 1.2
HIGHEST = 100  # order that is looked for
BAND = 0.4  # of the sampling rate: a line above it would fold
ATTENUATION = 0.03  # the smoothing may leave no less of a line that is judged
LEAST_TURNS = 4.0
REST_SHARE = 0.1  # of the median speed: a rotor slower than this on average over REST_S may stick
REST_S = 0.05
PIECE_S = 0.1  # stretches that are judged as a whole: one that is off by ODD times the median is left out, and told
ODD = 5.0
LAGS_S = np.arange(-1e-3, 2.01e-3, 0.25e-3)  # of the logged current behind the torque balance
LAG_GAIN = 0.1  # share of the residue that a lag must take away to be believed
MOST_ODD = 0.15  # of the log
ABOVE_NOISE = 5.0  # times the median of the half orders nearby: chance gives one such line in a few thousand logs
FAINT = 0.02  # of the strongest line: below it is modulation, not an effect
NEARBY = 8  # orders to each side, for the noise
MOST_LINES = 12
AGREE = 0.5  # the two halves of the log may differ by this share of a line
INFLATION = 25.0  # acceleration that the lines say as well as this is no measure of the inertia


@dataclass(frozen=True, slots=True)
class OrderSpectrum:
    """Amplitudes over whole and half orders, A."""

    order: Array
    amplitude_a: Array
    noise_a: Array


@dataclass(frozen=True, slots=True)
class FoundLine:
    """Braking torque A sin(order theta + phase) with the half width of the 95 % interval of A."""

    line: Line
    half_a: float
    noise_a: float
    agree: float  # difference of the two halves of the log, relative
    both: bool  # stands out in each of them, at whatever phase
    validated: bool


@dataclass(frozen=True, slots=True)
class AngleResult:
    """`inertia_known`: the log or the model tells J/Kt apart from the lines. Without it amplitudes are not torque."""

    motion: Motion
    rows: Flags
    fit_rows: Flags
    validation_rows: Flags
    highest: int
    spectrum: OrderSpectrum
    lines: tuple[FoundLine, ...]
    strange: tuple[tuple[float, float], ...]  # (order, A) of lines between the whole orders
    odd_s: tuple[tuple[float, float, float], ...]  # (from, to, A rms): stretches that do not follow and were left out
    inertia_as2: float
    inertia_half_as2: float
    inertia_known: bool
    drag_a: float
    drag_half_a: float
    before: Array
    after: Array
    before_rms_a: float
    after_rms_a: float
    current_share: float  # of the strongest line, per A of q current: flux harmonics would give about 1 / A of torque


def slow_rows(motion: Motion) -> tuple[Flags, int]:
    """The rows at which a high order still is below the band, and the highest order for which that holds."""
    assert motion.theta_rad is not None
    speed = np.abs(motion.speed_rad_s)
    rest = Smoother(REST_S, motion.smooth.period_s)(np.abs(motion.raw_speed_rad_s))
    turning = motion.good & (rest > REST_SHARE * np.median(np.abs(motion.raw_speed_rad_s)))
    rate_hz = 1.0 / motion.smooth.period_s
    reach_hz = min(BAND * rate_hz, np.sqrt(-2.0 * np.log(ATTENUATION)) / (TURN * motion.smooth.sigma_s))
    for highest in range(HIGHEST, 0, -1):
        rows = turning & (speed * highest / TURN < reach_hz)
        if travel(motion, rows) >= LEAST_TURNS and np.count_nonzero(rows) > 20 * highest:
            return rows, highest
    return np.zeros_like(motion.good), 0


def _thin(rows: Flags, motion: Motion) -> Flags:
    """Smoothed rows say the same twice: half the width of the smoothing apart they say everything."""
    stride = max(1, int(motion.smooth.sigma_s / motion.smooth.period_s))
    return rows & (np.arange(len(rows)) % stride == 0)


def current_lag(grid: Grid, motion: Motion, nominal: Nominal | None, found: AngleResult, bank: OrderBank) -> float:
    """How much later than the torque balance the logged current is, s: the lag with the smallest residue.

    0 when it makes little difference. Logs write the current of another instant than the angle, and at a ripple of tens
    of hertz a millisecond matters.
    """
    if not found.lines or not found.inertia_known:
        return 0.0
    given = nominal if nominal is None else _without_lines(nominal)
    rest = known_part(motion, given)
    base = _base(motion, free_inertia=nominal is None)
    orders = [int(each.line.order) for each in found.lines]

    def residue(lag_s: float) -> float:
        y = motion.smooth(grid.column("iq_a", lag_s)) - rest
        return rms(_fit(bank, base, orders, y, found.rows).residual)

    tried = np.array([residue(lag_s) for lag_s in LAGS_S])
    if np.min(tried) > (1.0 - LAG_GAIN) * residue(0.0):
        return 0.0
    return vertex(LAGS_S, tried)


def travel(motion: Motion, rows: Flags) -> float:
    """Turns in these rows."""
    return float(np.sum(np.abs(motion.speed_rad_s[rows]))) * motion.smooth.period_s / TURN


def weigh_orders(
    motion: Motion, nominal: Nominal | None, inertia: tuple[float, float] | None, bank: OrderBank | None = None
) -> AngleResult | None:
    """None: too little angle. `inertia`: J/Kt and its half width from elsewhere; None: from this log.

    `bank`: columns of an earlier call on the same angle, which need not be made again.
    """
    assert motion.theta_rad is not None
    rows, highest = slow_rows(motion)
    if highest < 2:
        return None
    rows = _thin(rows, motion)
    bank = bank if bank is not None else OrderBank(motion)
    given = nominal if nominal is None else _without_lines(nominal)
    y = motion.iq_a - known_part(motion, given)
    base = _base(motion, free_inertia=inertia is None and nominal is None)
    if inertia is not None and nominal is None:
        y = y - inertia[0] * motion.accel_rad_s2
    rows, odd = _without_odd(bank, base, y, rows, highest)
    first, second = halves(rows)
    all_orders = range(1, highest + 1)
    lump = (
        inflation(motion.accel_rad_s2[rows], [c[rows] for k in all_orders for c in bank(k)])
        if "inertia" in base
        else 1.0
    )
    known = lump < INFLATION
    spectrum = _spectrum(bank, base, y, rows, highest)
    orders = _stepwise(bank, base, y, rows, first, spectrum)
    found = _fit(bank, base, orders, y, rows)
    on_first, on_second = (_fit(bank, base, orders, y, part) for part in (first, second))
    lines = tuple(_line(k, found, on_first, on_second, spectrum) for k in orders)
    kept = [int(each.line.order) for each in lines if each.validated]
    fitted = _fit(bank, base, kept, y, first)
    unexplained = y - _known_lines(motion, nominal, y, first)  # before the drag: the lines bend it
    before = unexplained - _explained(bank, base, [], _fit(bank, base, [], unexplained, first))
    if "inertia" in base:  # the same inertia before and after: the one that the lines do not bend
        before = y - fitted["inertia"] * motion.accel_rad_s2
        drag = _fit(bank, {"drag": base["drag"]}, [], before, first)
        before = before - _explained(bank, {"drag": base["drag"]}, [], drag)
    after = y - _explained(bank, base, kept, fitted)
    strange = tuple(
        (float(o), float(a))
        for o, a, n in zip(spectrum.order, spectrum.amplitude_a, spectrum.noise_a, strict=True)
        if o % 1.0 and a > 2.0 * ABOVE_NOISE * n and a > _strongest(lines) * 0.1
    )
    j, j_half = (
        (found["inertia"], found.half("inertia")) if "inertia" in base else (inertia or (nominal.inertia_as2, 0.0))
    )
    return AngleResult(
        motion,
        rows,
        first,
        second,
        highest,
        spectrum,
        lines,
        strange,
        odd,
        j,
        j_half,
        known,
        found["drag"],
        found.half("drag"),
        before,
        after,
        rms(before[second]),
        rms(after[second]),
        _current_share(bank, base, kept, motion, y, rows, lines),
    )


def _without_odd(
    bank: OrderBank, base: dict[str, Array], y: Array, rows: Flags, highest: int
) -> tuple[Flags, tuple[tuple[float, float, float], ...]]:
    """Leave out stretches that follow no line at all, such as a start against a stop; they are told, not fitted."""
    t_s = bank.motion.t_s
    piece = np.floor((t_s - t_s[0]) / PIECE_S).astype(int)
    used = rows.copy()
    for _ in range(3):
        after = y - _explained(bank, base, range(1, highest + 1), _fit(bank, base, range(1, highest + 1), y, used))
        count = np.maximum(np.bincount(piece[rows], minlength=piece[-1] + 1), 1)
        level = np.sqrt(np.bincount(piece[rows], after[rows] ** 2, minlength=piece[-1] + 1) / count)
        limit = ODD * float(np.median(level[np.unique(piece[rows])]))
        odd = level > limit
        if np.count_nonzero(odd) > MOST_ODD * len(odd):
            return rows, ()
        now = rows & ~odd[piece]
        if np.array_equal(now, used):
            break
        used = now
    return used, _stretches(odd, level, float(t_s[0]))


def _stretches(odd: Flags, level: Array, start_s: float) -> tuple[tuple[float, float, float], ...]:
    """Neighbouring pieces as one."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], odd, [False])).astype(int)))
    pairs = zip(edges[::2], edges[1::2], strict=True)
    return tuple((start_s + PIECE_S * a, start_s + PIECE_S * b, float(np.max(level[a:b]))) for a, b in pairs)


class OrderBank:
    """Smoothed sin and cos of the orders, made once."""

    def __init__(self, motion: Motion) -> None:
        self.motion = motion
        self.made: dict[float, tuple[Array, Array]] = {}

    def __call__(self, order: float) -> tuple[Array, Array]:
        if order not in self.made:
            theta = self.motion.theta_rad
            self.made[order] = (self.motion.smooth(np.sin(order * theta)), self.motion.smooth(np.cos(order * theta)))
        return self.made[order]


def _without_lines(nominal: Nominal) -> Nominal:
    """Lines of the model are found again, not subtracted: their phase is right for one zero of the angle only."""
    from dataclasses import replace

    return replace(nominal, lines=())


def _known_lines(motion: Motion, nominal: Nominal | None, rest: Array, first: Flags) -> Array:
    """What the model's own lines explain, at the zero of the angle that fits."""
    zero_rad = find_zero(motion, nominal.lines, rest, first) if nominal is not None else None
    if nominal is None or zero_rad is None:
        return np.zeros_like(rest)
    return motion.smooth(sum(line(motion.theta_rad) for line in at_zero(nominal.lines, zero_rad)))


def _base(motion: Motion, *, free_inertia: bool) -> dict[str, Array]:
    """Drag: what has the sign of the speed, at the one speed or the few speeds of these rows."""
    base = {"drag": motion.smooth(np.sign(motion.raw_speed_rad_s))}
    if free_inertia:
        base["inertia"] = motion.accel_rad_s2
    return base


def _columns(bank: OrderBank, base: dict[str, Array], orders: Sequence[float]) -> tuple[list[str], list[Array]]:
    names, columns = list(base), list(base.values())
    for k in orders:
        names += [f"sin_{k:g}", f"cos_{k:g}"]
        columns += bank(k)
    return names, columns


def _fit(bank: OrderBank, base: dict[str, Array], orders: Sequence[float], y: Array, rows: Flags) -> Fit:
    names, columns = _columns(bank, base, orders)
    return fit(names, [column[rows] for column in columns], y[rows])


def _explained(bank: OrderBank, base: dict[str, Array], orders: Sequence[float], found: Fit) -> Array:
    return np.column_stack(_columns(bank, base, orders)[1]) @ found.value


def _spectrum(bank: OrderBank, base: dict[str, Array], y: Array, rows: Flags, highest: int) -> OrderSpectrum:
    """All whole orders at once, then each half order against what they leave."""
    whole = np.arange(1, highest + 1)
    found = _fit(bank, base, whole.tolist(), y, rows)
    left = y - _explained(bank, base, whole.tolist(), found)
    amplitude = {float(k): float(np.hypot(found[f"sin_{k}"], found[f"cos_{k}"])) for k in whole}
    halves_at = whole - 0.5
    for k in halves_at:
        s, c = (column[rows] for column in bank(k))
        gram = np.array([[s @ s, s @ c], [s @ c, c @ c]])
        amplitude[float(k)] = float(
            np.hypot(*np.linalg.lstsq(gram, np.array([s @ left[rows], c @ left[rows]]), rcond=None)[0])
        )
    order = np.array(sorted(amplitude))
    at_halves = np.array([amplitude[float(k)] for k in halves_at])
    noise = [float(np.median(at_halves[np.abs(halves_at - o) <= NEARBY])) for o in order]
    return OrderSpectrum(order, np.array([amplitude[o] for o in order]), np.array(noise))


def _noise_at(spectrum: OrderSpectrum, order: float) -> float:
    return float(spectrum.noise_a[np.searchsorted(spectrum.order, order)])


def _stepwise(
    bank: OrderBank, base: dict[str, Array], y: Array, rows: Flags, first: Flags, spectrum: OrderSpectrum
) -> list[int]:
    """The strongest of the whole orders that stand out of their noise, strongest first."""
    whole = spectrum.order % 1.0 == 0.0
    ranked = sorted(zip(spectrum.amplitude_a[whole], spectrum.order[whole], strict=True), reverse=True)
    strongest = ranked[0][0]
    stands = [int(k) for a, k in ranked if a > ABOVE_NOISE * _noise_at(spectrum, k) and a > FAINT * strongest]
    orders = stands[:MOST_LINES]
    if not orders:
        return []
    found = _fit(bank, base, orders, y, rows)  # together, and without the orders that are nothing
    amplitude = {k: float(np.hypot(found[f"sin_{k}"], found[f"cos_{k}"])) for k in orders}
    return sorted(
        (k for k in orders if amplitude[k] > ABOVE_NOISE * _noise_at(spectrum, k)), key=lambda k: -amplitude[k]
    )


def _line(k: int, found: Fit, on_first: Fit, on_second: Fit, spectrum: OrderSpectrum) -> FoundLine:
    s, c = found[f"sin_{k}"], found[f"cos_{k}"]
    amplitude = float(np.hypot(s, c))
    half = max(found.half(f"sin_{k}"), found.half(f"cos_{k}"))
    parts = [complex(f[f"sin_{k}"], f[f"cos_{k}"]) for f in (on_first, on_second)]
    noise_a = _noise_at(spectrum, k)
    agree = abs(parts[0] - parts[1]) / amplitude
    both = min(map(abs, parts)) > ABOVE_NOISE * noise_a
    line = Line(float(k), amplitude, float(np.arctan2(c, s)))
    return FoundLine(line, half, noise_a, agree, both, agree < AGREE)


def _strongest(lines: Sequence[FoundLine]) -> float:
    return max((each.line.amplitude_a for each in lines), default=0.0)


def _current_share(
    bank: OrderBank,
    base: dict[str, Array],
    kept: list[int],
    motion: Motion,
    y: Array,
    rows: Flags,
    lines: Sequence[FoundLine],
) -> float:
    """Change of the strongest line per ampere of q current, relative to the line: 0 for cogging."""
    if not kept:
        return 0.0
    k = kept[0]
    iq = motion.iq_a - np.mean(motion.iq_a[rows])
    more = dict(base) | {f"iq_{i}": motion.smooth(iq * f(k * motion.theta_rad)) for i, f in enumerate((np.sin, np.cos))}
    found = _fit(bank, more, kept, y, rows)
    return float(np.hypot(found["iq_0"], found["iq_1"])) / max(_strongest(lines), 1e-12)
