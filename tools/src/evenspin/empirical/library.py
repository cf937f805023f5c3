"""The families of terms: what a torque or a voltage may depend on beyond the effects of the table.

A family has shape numbers that it is not linear in (an exponent, an order, a time constant) and coefficients that it
is linear in. Coefficients are torques in N m, ohms or shares, as `unit` says, at the top of the range of the log.

| family | torque or voltage | shape |
|---|---|---|
| speed_odd | sign(w) abs(w / w_top)^n | exponent |
| speed_even | abs(w / w_top)^n | exponent |
| angle_line | sin, cos of k theta, times abs(w / w_top)^m, and sign(w) if it turns over | k, m = 0, 1, 2, turns over |
| position_bump | exp(-((theta - c) / s)^2) over the unwrapped angle | centre, width |
| position_spring | theta - middle | - |
| time_load, time_friction, time_viscous | 1 - exp(-t / tau), times 1, sign(w), w / w_top | time constant |
| time_magnet | that times the flux of the magnets, in torque and voltage | time constant |
| time_resistance | that times the current, in the voltage | time constant |
| torque_frequency | sin, cos of 2 pi f t | frequency |
| supply_frequency | that times the voltage | frequency |
| supply_link | voltage times (measured dc link / nominal - 1) | - |
| supply_power | voltage times electrical power over the rated one | - |
| current_friction | sign(w) abs(torque) | - |
| cross_saturation | d flux - iq^2 / 2, q flux - id iq | - |
| reversal | friction that follows the shaft over a length after each reversal (Dahl) | length |
| speed_history | w less its first-order lag, over w_top | time constant |
| speed_voltage | q voltage with w abs(w) | - |
| voltage_offset | a constant voltage in the stationary frame | - |
| phase_resistance | more resistance in phases a and b | - |
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.empirical.rows import Column, Rows

Array = NDArray[np.float64]
Shape = tuple[float, ...]

EXPONENTS = (0.4, 0.6, 0.8, 1.4, 1.7, 2.0, 2.5, 3.0, 4.0)
NEAR_LINEAR = (0.75, 1.35)  # an exponent between is viscous friction with another name
AGES = 9
WIDTHS = (0.06, 0.12, 0.25)  # of the range of the angle
CENTRES = 13
TURNS = 3.0  # of the shaft, from which a position is more than an angle
LENGTHS_RAD = (0.02, 0.05, 0.12, 0.3, 0.7, 1.6)
LAGS_S = (0.1, 0.25, 0.6, 1.5)


@dataclass(frozen=True, slots=True)
class Family:
    """`starts`: shapes to try; `reach`: from which to which a shape number may go, and whether its steps are ratios."""

    name: str
    depends_on: str
    unit: str
    columns: Callable[[Rows, Shape], list[Column]]
    starts: Callable[[Rows], Sequence[Shape]]
    shape: tuple[str, ...] = ()
    needs: frozenset[str] = frozenset()
    odd: bool | None = None
    least: float = 1.0  # coefficient that counts, in units of the least one
    main: int = 0  # coefficients that are the cause; the others say where it starts from; 0: all

    @property
    def electrical(self) -> bool:
        return "voltage" in self.needs


def _once(rows: Rows) -> Sequence[Shape]:
    return [()]


def _speed(sign: bool) -> Callable[[Rows, Shape], list[Column]]:
    def columns(rows: Rows, shape: Shape) -> list[Column]:
        x = np.abs(rows.speed_rad_s / rows.top_rad_s) ** shape[0]
        return [Column(torque=x * (rows.direction() if sign else 1.0))]

    return columns


def _exponents(rows: Rows) -> Sequence[Shape]:
    return [(n,) for n in EXPONENTS]


def _even_exponents(rows: Rows) -> Sequence[Shape]:
    both = min(float(np.max(rows.speed_rad_s)), -float(np.min(rows.speed_rad_s))) > 0.2 * rows.top_rad_s
    return [(n,) for n in (1.0, *EXPONENTS)] if both else []


def line_columns(rows: Rows, shape: Shape) -> list[Column]:
    order, power, turns_over = shape
    size = rows.shown(order) * (np.abs(rows.speed_rad_s) / rows.top_rad_s) ** power
    if turns_over:
        size = size * rows.direction()
    return [Column(torque=size * np.sin(order * rows.theta_rad)), Column(torque=size * np.cos(order * rows.theta_rad))]


def travel_of(rows: Rows) -> tuple[float, float]:
    """Lowest and highest angle, but for the last hundredths."""
    low, high = np.percentile(rows.theta_rad, (1.0, 99.0))
    return float(low), float(high)


def _bump(rows: Rows, shape: Shape) -> list[Column]:
    return [Column(torque=np.exp(-(((rows.theta_rad - shape[0]) / shape[1]) ** 2)))]


def _bumps(rows: Rows) -> Sequence[Shape]:
    low, high = travel_of(rows)
    if high - low < TURNS * 2.0 * np.pi:
        return []
    return [(c, s * (high - low)) for s in WIDTHS for c in np.linspace(low, high, CENTRES)]


def _spring(rows: Rows, shape: Shape) -> list[Column]:
    low, high = travel_of(rows)
    return [Column(torque=(rows.theta_rad - 0.5 * (low + high)) / max(high - low, 1e-9))]


def _springs(rows: Rows) -> Sequence[Shape]:
    low, high = travel_of(rows)
    return [()] if high - low > TURNS * 2.0 * np.pi else []


def warm(rows: Rows, tau_s: float) -> Array:
    """From 0 at the start towards 1 after the span of the log."""
    t = rows.t_s - rows.start_s
    return np.asarray(-np.expm1(-t / tau_s) / -np.expm1(-rows.span_s / tau_s))


def _ages(rows: Rows) -> Sequence[Shape]:
    return [(float(x),) for x in rows.span_s * np.geomspace(0.05, 3.0, AGES)]


def _time(kind: str) -> Callable[[Rows, Shape], list[Column]]:
    def columns(rows: Rows, shape: Shape) -> list[Column]:
        return [_grown(rows, kind, warm(rows, shape[0])), _grown(rows, kind, np.ones(len(rows.t_s)))]

    return columns


def _grown(rows: Rows, kind: str, w: Array) -> Column:
    if kind == "load":
        return Column(torque=w)
    if kind == "friction":
        return Column(torque=w * rows.direction())
    if kind == "viscous":
        return Column(torque=w * rows.speed_rad_s / rows.top_rad_s)
    if kind == "magnet":  # share of the flux that is lost
        lost_wb = w * rows.psi_wb
        return Column(
            torque=1.5 * rows.pole_pairs * lost_wb * rows.iq_a, q=-rows.pole_pairs * rows.speed_rad_s * lost_wb
        )
    return Column(d=w * rows.id_a, q=w * rows.iq_a)


def _torque_frequency(rows: Rows, shape: Shape) -> list[Column]:
    phase = 2.0 * np.pi * shape[0] * rows.t_s
    return [Column(torque=np.sin(phase)), Column(torque=np.cos(phase))]


def _lost_share(rows: Rows, share: Array) -> Column:
    assert rows.vd_v is not None and rows.vq_v is not None
    return Column(d=share * rows.vd_v, q=share * rows.vq_v)


def _supply_frequency(rows: Rows, shape: Shape) -> list[Column]:
    phase = 2.0 * np.pi * shape[0] * rows.t_s
    return [_lost_share(rows, np.sin(phase)), _lost_share(rows, np.cos(phase))]


def _supply_link(rows: Rows, shape: Shape) -> list[Column]:
    assert rows.vdc_v is not None
    return [_lost_share(rows, 1.0 - rows.vdc_v / rows.link_v)]


def _supply_power(rows: Rows, shape: Shape) -> list[Column]:
    assert rows.vd_v is not None and rows.vq_v is not None
    power = 1.5 * (rows.vd_v * rows.id_a + rows.vq_v * rows.iq_a)
    return [_lost_share(rows, power / (rows.rated_nm * rows.top_rad_s))]


def _current_friction(rows: Rows, shape: Shape) -> list[Column]:
    return [Column(torque=rows.direction() * np.abs(rows.torque_nm))]


def _cross(rows: Rows, shape: Shape) -> list[Column]:
    d_wb = -0.5 * rows.iq_a**2 / rows.rated_a**2 * rows.psi_wb
    q_wb = -rows.id_a * rows.iq_a / rows.rated_a**2 * rows.psi_wb
    speed_e = rows.pole_pairs * rows.speed_rad_s
    torque = -1.5 * rows.pole_pairs * (d_wb * rows.iq_a - q_wb * rows.id_a)
    return [Column(torque=torque, d=-speed_e * q_wb, q=speed_e * d_wb, d_linkage=d_wb, q_linkage=q_wb)]


def sections(rows: Rows) -> list[tuple[int, int, float]]:
    """First row, end and direction of every way between two reversals; noise around rest is no reversal."""
    far = REST_SHARE * rows.rest_rad_s
    sign = np.where(rows.speed_rad_s > far, 1.0, np.where(rows.speed_rad_s < -far, -1.0, 0.0))
    moving = np.flatnonzero(sign)
    if len(moving) == 0:
        return []
    held = sign[moving]
    turns = np.flatnonzero(np.diff(held) != 0.0)
    starts = [0, *(int(moving[k]) for k in turns + 1)]
    ends = [*starts[1:], len(sign)]
    signs = [float(held[0]), *(float(held[k + 1]) for k in turns)]
    return list(zip(starts, ends, signs, strict=True))


REST_SHARE = 0.5


def _bristle(rows: Rows, shape: Shape) -> list[Column]:
    out = np.zeros(len(rows.t_s))
    state = 0.0
    for first, end, sign in sections(rows):
        way = np.abs(rows.theta_rad[first:end] - rows.theta_rad[first])
        out[first:end] = sign + (state - sign) * np.exp(-way / shape[0])
        state = float(out[end - 1])
    return [Column(torque=out)]


def _lengths(rows: Rows) -> Sequence[Shape]:
    return [(x,) for x in LENGTHS_RAD] if len(sections(rows)) > 2 and rows.has_angle else []


def _history(rows: Rows, shape: Shape) -> list[Column]:
    from scipy.signal import lfilter

    share = rows.period_s / (shape[0] + rows.period_s)
    start = rows.speed_rad_s[0]
    late, _ = lfilter([share], [1.0, share - 1.0], rows.speed_rad_s, zi=[(1.0 - share) * start])
    return [Column(torque=(rows.speed_rad_s - late) / rows.top_rad_s)]


def _speed_voltage(rows: Rows, shape: Shape) -> list[Column]:
    w = rows.speed_rad_s / rows.top_rad_s
    return [Column(q=w * np.abs(w))]


def _phases(rows: Rows, shape: Shape) -> list[Column]:
    out = []
    for turn in (0.0, 2.0 * np.pi / 3.0):
        cos, sin = (f(rows.pole_pairs * rows.theta_rad - turn) for f in (np.cos, np.sin))
        phase = rows.id_a * cos - rows.iq_a * sin
        out.append(Column(d=2.0 / 3.0 * phase * cos, q=-2.0 / 3.0 * phase * sin))
    return out


def _voltage_offset(rows: Rows, shape: Shape) -> list[Column]:
    cos, sin = np.cos(rows.pole_pairs * rows.theta_rad), np.sin(rows.pole_pairs * rows.theta_rad)
    return [Column(d=cos, q=-sin), Column(d=sin, q=cos)]


V, ANGLE, LINK, TRAVEL = "voltage", "angle", "link", "travel"
NONE: frozenset[str] = frozenset()
FAMILIES: tuple[Family, ...] = (
    Family("speed_odd", "speed", "N m", _speed(True), _exponents, ("exponent",), odd=True),
    Family("speed_even", "speed", "N m", _speed(False), _even_exponents, ("exponent",), odd=False),
    Family(
        "angle_line",
        "angle",
        "N m",
        line_columns,
        lambda rows: [],
        ("order", "speed_exponent", "turns_over"),
        frozenset({ANGLE}),
    ),
    Family("position_bump", "position", "N m", _bump, _bumps, ("centre_rad", "width_rad"), frozenset({ANGLE, TRAVEL})),
    Family("position_spring", "position", "N m", _spring, _springs, (), frozenset({ANGLE, TRAVEL})),
    Family("time_load", "time", "N m", _time("load"), _ages, ("time_constant_s",), main=1),
    Family("time_friction", "time", "N m", _time("friction"), _ages, ("time_constant_s",), main=1),
    Family("time_viscous", "time", "N m", _time("viscous"), _ages, ("time_constant_s",), main=1),
    Family("time_magnet", "time", "1", _time("magnet"), _ages, ("time_constant_s",), frozenset({V}), main=1),
    Family("time_resistance", "time", "ohm", _time("resistance"), _ages, ("time_constant_s",), frozenset({V}), main=1),
    Family("torque_frequency", "frequency", "N m", _torque_frequency, lambda rows: [], ("frequency_hz",)),
    Family("supply_frequency", "frequency", "1", _supply_frequency, lambda rows: [], ("frequency_hz",), frozenset({V})),
    Family("supply_link", "supply", "1", _supply_link, _once, (), frozenset({V, LINK})),
    Family("supply_power", "power", "1", _supply_power, _once, (), frozenset({V})),
    Family("current_friction", "current", "1", _current_friction, _once),
    Family("cross_saturation", "current", "1", _cross, _once, (), frozenset({V})),
    Family("reversal", "reversal", "N m", _bristle, _lengths, ("length_rad",), frozenset({ANGLE})),
    Family("speed_history", "history", "N m", _history, lambda rows: [(x,) for x in LAGS_S], ("time_constant_s",)),
    Family("speed_voltage", "speed", "V", _speed_voltage, _once, (), frozenset({V}), odd=True),
    Family("voltage_offset", "phase", "V", _voltage_offset, _once, (), frozenset({V, ANGLE})),
    Family("phase_resistance", "phase", "ohm", _phases, _once, (), frozenset({V, ANGLE})),
)
_BY_NAME = {family.name: family for family in FAMILIES}


def family_of(name: str) -> Family:
    return _BY_NAME[name]


def can_show(family: Family, rows: Rows) -> bool:
    """Whether the log has the columns that the family needs."""
    if V in family.needs and (rows.vd_v is None or rows.vq_v is None):
        return False
    if LINK in family.needs and (rows.vdc_v is None or float(np.ptp(rows.vdc_v)) <= 0.0):
        return False
    if TRAVEL in family.needs and not rows.one_travel:
        return False
    return not (ANGLE in family.needs and not rows.has_angle)
