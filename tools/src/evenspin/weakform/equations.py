"""The three equations of the machine, held against a log: what is left of each in every window.

    torque   1.5 p ((psi + hq) iq + hd id + reluctance) - load - J dw/dt - B w - brakes          N m
    d axis   vd - R id - d(linkage_d)/dt + we (linkage_q - hd)                                   V
    q axis   vq - R iq - d(linkage_q)/dt - we (linkage_d + psi + hq)                             V

The measured currents, angle and voltages are first brought back to the true ones by what acts on sensors and bridge.
Voltages are those of the log `late_s` later, and turned back by the angle of `turned_s`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from evenspin.effects.equations import Acting, each
from evenspin.weakform.signals import Signals
from evenspin.weakform.windows import Windows

Array = NDArray[np.float64]

ROOT3 = np.sqrt(3.0)
SMALL_RAD = 0.2
FLUX_ORDER = 6.0  # electrical, of the harmonics of the flux


@dataclass(frozen=True, slots=True)
class Timing:
    """Of this log: voltage later than its row, and the angle it is turned by, as a time at the electrical speed."""

    late_s: float = 0.0
    turned_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Residual:
    """What is left, per window; an equation that the log does not have is None."""

    torque_nm: Array
    fine_nm: Array  # the torque over shorter windows, for high orders of the angle
    d_v: Array | None = None
    q_v: Array | None = None

    def parts(self) -> list[Array]:
        return [each for each in (self.torque_nm, self.fine_nm, self.d_v, self.q_v) if each is not None]


@dataclass
class Equations:
    """A log, the numbers of a machine model, and the windows of both kinds of equation."""

    signals: Signals
    plant: Mapping[str, float]
    shaft: Windows
    fine: Windows
    winding: Windows | None
    soft_rad_s: float  # the direction of dry friction goes through zero within this
    _memory: dict[str, Array] = field(default_factory=dict)

    def residual(self, acting: Sequence[Acting], timing: Timing, shaft_only: bool = False) -> Residual:
        """What is left of the equations with these effects; `shaft_only`: of the torque alone."""
        s = self.signals
        plant = dict(self.plant)
        for function, params in each(acting, "numbers"):
            plant |= function(params, plant)
        p = plant["pole_pairs"]
        error = self._angle_error(acting, p)
        theta = s.theta_m_rad if error is None else s.theta_m_rad - error
        speed = s.speed_rad_s
        d_a, q_a = self._currents(acting, p)
        if error is not None:
            d_a, q_a = _turned(d_a, q_a, p * error)
        theta_e = self._theta_e(p) if error is None else p * theta
        h_d, h_q = np.zeros(1), np.zeros(1)
        for function, params in each(acting, "flux_wb"):
            d_wb, q_wb = function(params, plant["psi_wb"], theta_e)
            shown = self.shown(FLUX_ORDER * p)
            h_d, h_q = h_d + shown * d_wb, h_q + shown * q_wb
        f_d, f_q = plant["ld_h"] * d_a, plant["lq_h"] * q_a
        for function, params in each(acting, "linkage_wb"):
            f_d = f_d + function(params, plant["ld_h"], d_a, q_a) - plant["ld_h"] * d_a
            f_q = f_q + function(params, plant["lq_h"], q_a, d_a) - plant["lq_h"] * q_a
        made = 1.5 * p * ((plant["psi_wb"] + h_q + f_d) * q_a + (h_d - f_q) * d_a)
        made = made - s.load_nm - plant["viscous_nms"] * speed
        direction = self._direction()
        for function, params in each(acting, "brake_nm"):
            made = made - self.shown(params.get("order", 0.0)) * function(params, theta, speed, direction)
        rigid = theta  # where the shafts would be as one body
        for function, params in each(acting, "twist_rad"):
            rigid = rigid - function(params, theta, s.period_s)
        if s.has_load:
            for function, params in each(acting, "held_back_nm"):
                made = made + function(params, s.load_nm, s.period_s)
        torque, fine = (
            over.value(made) - plant["inertia_kgm2"] * self._acceleration(rigid, over)
            for over in (self.shaft, self.fine)
        )
        if shaft_only or self.winding is None:
            return Residual(torque, fine)
        return Residual(
            torque, fine, *self._winding(acting, timing, plant, theta, theta_e, error, (d_a, q_a, f_d, f_q), (h_d, h_q))
        )

    def _winding(self, acting, timing, plant, theta, theta_e, error, stator, flux):  # type: ignore[no-untyped-def]
        s, over = self.signals, self.winding
        assert over is not None and s.vd_v is not None and s.vq_v is not None
        d_a, q_a, f_d, f_q = stator
        p = plant["pole_pairs"]
        speed_e = p * s.speed_rad_s
        angle = -speed_e * timing.turned_s if error is None else p * error - speed_e * timing.turned_s
        vd, vq = _turned(s.vd_v, s.vq_v, angle)
        d_v = over.value(vd) - timing.late_s * over.slope(vd) + 0.5 * timing.late_s**2 * over.curve(vd)
        q_v = over.value(vq) - timing.late_s * over.slope(vq) + 0.5 * timing.late_s**2 * over.curve(vq)
        drop_d = plant["resistance_ohm"] * d_a - speed_e * (f_q - flux[0])
        drop_q = plant["resistance_ohm"] * q_a + speed_e * (f_d + flux[1])
        if any(True for _ in each(acting, "lost_v")):
            lost_d, lost_q = self._lost(acting, d_a, q_a, theta_e)
            drop_d, drop_q = drop_d + lost_d, drop_q + lost_q
        d_v = d_v - over.value(drop_d) - over.slope(f_d)
        q_v = q_v - over.value(drop_q) - over.slope(f_q) - plant["psi_wb"] * p * self._speed_of(theta, over)
        return d_v, q_v

    def acceleration(self, over: Windows) -> Array:
        """Of the measured angle."""
        return self._acceleration(self.signals.theta_m_rad, over)

    def _acceleration(self, theta: Array, over: Windows) -> Array:
        if self.signals.has_angle or theta is not self.signals.theta_m_rad:
            return over.curve(theta)
        return over.slope(self.signals.speed_rad_s)

    def windows(self) -> list[Windows]:
        """Of each part of a residual."""
        both = [self.shaft, self.fine]
        return both if self.winding is None else [*both, self.winding, self.winding]

    def _speed_of(self, theta: Array, over: Windows) -> Array:
        return over.slope(theta) if self.signals.has_angle else over.value(self.signals.speed_rad_s)

    def _lost(self, acting: Sequence[Acting], d_a: Array, q_a: Array, theta_e: Array) -> tuple[Array, Array]:
        own = theta_e is self._theta_e(self.plant["pole_pairs"])
        cos, sin = self._rotor(self.plant["pole_pairs"]) if own else (np.cos(theta_e), np.sin(theta_e))
        alpha, beta = d_a * cos - q_a * sin, d_a * sin + q_a * cos
        phases = (alpha, -0.5 * alpha + 0.5 * ROOT3 * beta, -0.5 * alpha - 0.5 * ROOT3 * beta)
        link = self.signals.vdc_v if self.signals.vdc_v is not None else np.full(len(alpha), self.plant["dc_link_v"])
        lost = [np.zeros(len(alpha)) for _ in phases]
        for function, params in each(acting, "lost_v"):
            lost = [
                so_far + function(params, i_a, link, self.plant["pwm_hz"])
                for so_far, i_a in zip(lost, phases, strict=True)
            ]
        a, b, c = lost
        l_alpha, l_beta = (2.0 * a - b - c) / 3.0, (b - c) / ROOT3
        return l_alpha * cos + l_beta * sin, l_beta * cos - l_alpha * sin

    def _currents(self, acting: Sequence[Acting], p: float) -> tuple[Array, Array]:
        """True currents in the drive's frame."""
        s = self.signals
        functions = list(each(acting, "current_error_a"))
        if not functions:
            return s.id_a, s.iq_a
        cos, sin = self._rotor(p)
        alpha, beta = s.id_a * cos - s.iq_a * sin, s.id_a * sin + s.iq_a * cos
        a, b = alpha, -0.5 * alpha + 0.5 * ROOT3 * beta
        for function, params in functions:
            wrong_a, wrong_b = function(params, a, b)
            a, b = a - wrong_a, b - wrong_b
        alpha, beta = a, (a + 2.0 * b) / ROOT3
        return alpha * cos + beta * sin, beta * cos - alpha * sin

    def shown(self, order: float) -> Array:
        """Share of a line over the angle that rows of this rate show: none above half the rate."""
        if order == 0.0:
            return np.ones(1)
        return self._kept(
            f"shown {order:g}",
            lambda: np.clip(
                2.0 - order * np.abs(self.signals.speed_rad_s) * self.signals.period_s / (0.5 * np.pi), 0.0, 1.0
            ),
        )

    def _angle_error(self, acting: Sequence[Acting], p: float) -> Array | None:
        total: Array | None = None
        for function, params in each(acting, "angle_error_rad"):
            error = function(params, self.signals.theta_m_rad, p)
            total = error if total is None else total + error
        return total

    def _theta_e(self, p: float) -> Array:
        return self._kept("theta_e", lambda: p * self.signals.theta_m_rad)

    def _rotor(self, p: float) -> tuple[Array, Array]:
        return self._kept("cos", lambda: np.cos(self._theta_e(p))), self._kept("sin", lambda: np.sin(self._theta_e(p)))

    def _direction(self) -> Array:
        return self._kept("direction", lambda: np.tanh(self.signals.speed_rad_s / self.soft_rad_s))

    def _kept(self, name: str, make) -> Array:  # type: ignore[no-untyped-def]
        if name not in self._memory:
            self._memory[name] = np.asarray(make())
        return self._memory[name]


def _turned(d: Array, q: Array, angle_rad: Array) -> tuple[Array, Array]:
    """The vector d + j q, turned forward."""
    if float(np.max(np.abs(angle_rad), initial=0.0)) < SMALL_RAD:  # the series is exact to 1e-9, and much faster
        square = angle_rad * angle_rad
        cos = 1.0 - 0.5 * square * (1.0 - square / 12.0 * (1.0 - square / 30.0))
        sin = angle_rad * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)))
    else:
        cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return d * cos - q * sin, d * sin + q * cos
