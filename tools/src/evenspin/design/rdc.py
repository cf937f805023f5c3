"""Robust driving control: the error equation, its Lyapunov matrix, and where the robust term begins to chatter.

    x = [integral of e, e, e'], e = angle less command;  x' = A x + b (...)                                 (1)
    A = [0 1 0; 0 0 1; -K k_pp / (T_i J), -K (k_pp + 1 / T_i) / J, -(B + K) / J],  K = K_t k_vp             (2)
    A^T P + P A = -q I                                                                                    (3)

Inside its boundary layer the robust term is a feedback -rho / sigma b^T P x. Its speed part adds damping that the
delay of the loop turns into an oscillation: the limit of rho / sigma is where a root of the sampled loop (held torque,
transport delay, interrupt, current loop as a lag, speed from the angle difference) leaves the unit circle. It scales
with 1 / q.

Source   Yeh and Liu 2024, equations 26 to 32. Measured on the simulated drive of that paper: docs/reference/yeh2024.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError

Array = NDArray[np.float64]

WHERE = "design rdc"
MARGIN = 0.8  # of the limit: more is worth a warning
MARGINAL = 1e-7  # two integrators of the same error give a root at 1 that never moves


@dataclass(frozen=True, slots=True)
class RdcLoop:
    """The position loop around a rigid machine. SI units."""

    kpp_per_s: float
    kvp_a_per_rad_s: float
    ti_s: float
    torque_per_a_nm: float
    inertia_kgm2: float
    viscous_nms: float
    ts_s: float = 1e-3
    current_bandwidth_rad_s: float = 3000.0
    interrupt_s: float = 1e-4
    delay_samples: int = 0

    def __post_init__(self) -> None:
        above = ("kpp_per_s", "kvp_a_per_rad_s", "ti_s", "torque_per_a_nm", "inertia_kgm2", "ts_s")
        for name in (*above, "current_bandwidth_rad_s"):
            if not 0.0 < getattr(self, name) < 1e9:
                raise InputError(WHERE, name, getattr(self, name), "above 0", "correct the model or the option")
        if not 0.0 <= self.viscous_nms < 1e9:
            raise InputError(WHERE, "viscous_nms", self.viscous_nms, "at least 0", "correct the model or the option")
        if not 0 <= self.delay_samples <= 7:
            raise InputError(WHERE, "delay_samples", self.delay_samples, "within 0 .. 7", "1 is a field bus")

    def matrix(self) -> Array:
        """A of (2)."""
        k = self.torque_per_a_nm * self.kvp_a_per_rad_s
        j = self.inertia_kgm2
        last = [-k * self.kpp_per_s / (self.ti_s * j), -k * (self.kpp_per_s + 1.0 / self.ti_s) / j]
        return np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [*last, -(self.viscous_nms + k) / j]])


@dataclass(frozen=True, slots=True)
class RdcDesign:
    """`limit`: largest rho / sigma; `limit_undelayed`: the same without transport delay."""

    loop: RdcLoop
    rho_nm: float
    sigma: float
    q: float
    eigenvalues: Array
    p: Array
    limit: float
    limit_undelayed: float

    @property
    def p_row(self) -> Array:
        return self.p[2]

    @property
    def ratio(self) -> float:
        return self.rho_nm / self.sigma

    @property
    def error_bound(self) -> float:
        """Theorem 1: the size of [integral of the angle error, angle error, speed error] at which it settles, while
        what the model gets wrong is smaller than rho: sqrt(rho sigma / (2 lambda_min(Q)))."""
        return float(np.sqrt(self.rho_nm * self.sigma / (2.0 * self.q)))

    @property
    def warning(self) -> str:
        if self.ratio > self.limit:
            return f"rho / sigma = {self.ratio:.3g} chatters: above {self.limit:.3g} with this delay"
        if self.ratio > MARGIN * self.limit:
            return f"rho / sigma = {self.ratio:.3g} is close to chatter, which begins at {self.limit:.3g}"
        return ""

    def as_json(self) -> dict[str, Any]:
        return {
            "eigenvalues": [{"real": float(v.real), "imag": float(v.imag)} for v in self.eigenvalues],
            "stable": bool(self.eigenvalues.real.max() < 0.0),
            "a": self.loop.matrix().tolist(),
            "p": self.p.tolist(),
            "p_row": self.p_row.tolist(),
            "q": self.q,
            "rho_nm": self.rho_nm,
            "sigma": self.sigma,
            "error_bound": self.error_bound,
            "rho_over_sigma": self.ratio,
            "rho_over_sigma_limit": self.limit,
            "rho_over_sigma_limit_undelayed": self.limit_undelayed,
            "warning": self.warning,
            "drive": self.drive(),
        }

    def drive(self) -> dict[str, float]:
        """Parameters of the drive."""
        names = ("rdc_p31", "rdc_p32", "rdc_p33")
        rows = dict(zip(names, map(float, self.p_row), strict=True))
        return rows | {"rdc_rho_nm": self.rho_nm, "rdc_sigma": self.sigma}


def design(loop: RdcLoop, rho_nm: float, sigma: float, q: float = 1.0) -> RdcDesign:
    """Solve, check; refuses a robust term that chatters even without transport delay."""
    from scipy.linalg import solve_continuous_lyapunov

    if not 0.0 <= rho_nm < 1e6:
        raise InputError(WHERE, "rho_nm", rho_nm, "at least 0 N m", "0 switches the robust term off")
    for name, value in (("sigma", sigma), ("q", q)):
        if not 0.0 < value < 1e9:
            raise InputError(WHERE, name, value, "above 0", "try 0.02" if name == "sigma" else "try 1")
    a = loop.matrix()
    eigenvalues = np.array(sorted(np.linalg.eigvals(a), key=lambda value: -value.real))
    if not eigenvalues.real.max() < 0.0:
        worst = f"{eigenvalues[0].real:.4g}"
        raise InputError(WHERE, "largest real part of A", worst, "below 0", "lower k_pp, raise k_vp or T_i")
    p = solve_continuous_lyapunov(a.T, -q * np.eye(3))
    limit = chatter_limit(loop, p[2], loop.delay_samples)
    undelayed = limit if loop.delay_samples == 0 else chatter_limit(loop, p[2], 0)
    if rho_nm / sigma > undelayed:
        must = f"at most {undelayed:.3g} at q = {q:g}: more chatters ({limit:.3g} with the delay of this drive)"
        raise InputError(WHERE, "rho_nm / sigma", f"{rho_nm / sigma:.4g}", must, "lower rho or raise sigma")
    return RdcDesign(loop, rho_nm, sigma, q, eigenvalues, p, limit, undelayed)


def chatter_limit(loop: RdcLoop, p_row: Array, delay_samples: int) -> float:
    """Largest rho / sigma without a root outside the unit circle; 0 when the loop is unstable alone."""
    parts = _Sampled(loop, p_row / loop.inertia_kgm2, delay_samples)
    if parts.radius(0.0) > 1.0 + MARGINAL:
        return 0.0
    high = 1.0
    while parts.radius(high) <= 1.0 + MARGINAL and high < 1e9:
        high *= 2.0
    low = high / 2.0 if high > 1.0 else 0.0
    for _ in range(50):
        middle = (low + high) / 2.0
        low, high = (middle, high) if parts.radius(middle) <= 1.0 + MARGINAL else (low, middle)
    return low


class _Sampled:
    """State: angle, speed, current, angle before, integral of the angle, integrator, commands of the last samples."""

    def __init__(self, loop: RdcLoop, weights: Array, delay: int) -> None:
        self.loop, self.weights, self.delay = loop, weights, delay
        self.size = 7 + delay
        self.before = self._held(loop.interrupt_s)
        self.after = self._held(loop.ts_s - loop.interrupt_s)

    def radius(self, ratio: float) -> float:
        return float(np.abs(np.linalg.eigvals(self.matrix(ratio))).max())

    def matrix(self, ratio: float) -> Array:
        loop, unit = self.loop, np.eye(self.size)
        angle, speed = unit[0], (unit[0] - unit[3]) / loop.ts_s
        integral = unit[4] + loop.ts_s * angle
        error = -(loop.kpp_per_s * angle + speed)
        integrator = unit[5] + loop.kvp_a_per_rad_s * loop.ts_s / loop.ti_s * error
        robust = self.weights[0] * integral + self.weights[1] * angle + self.weights[2] * speed
        command = loop.kvp_a_per_rad_s * error + integrator - ratio / loop.torque_per_a_nm * robust
        commands = [command, *unit[6:]]
        plant = self.before[0] @ unit[:3] + np.outer(self.before[1], commands[self.delay + 1])
        plant = self.after[0] @ plant + np.outer(self.after[1], commands[self.delay])
        return np.vstack((plant, angle, integral, integrator, commands[:-1]))

    def _held(self, time_s: float) -> tuple[Array, Array]:
        """Plant over a time with a held command."""
        from scipy.linalg import expm

        j, w = self.loop.inertia_kgm2, self.loop.current_bandwidth_rad_s
        a = np.zeros((4, 4))
        a[0, 1] = 1.0
        a[1, 1:3] = -self.loop.viscous_nms / j, self.loop.torque_per_a_nm / j
        a[2, 2:] = -w, w
        whole = expm(a * time_s)
        return whole[:3, :3], whole[:3, 3]
