"""The speed loop without repetitive control, as a frequency response.

    error [unit] -> PI -> current loop w/(s + w) -> torque constant -> 1/(J s + B) -> speed [unit]

The PI runs at T_s and its output is held; what is behind it is discretised exactly (zero-order hold). A delay may be
any number of seconds. `unit` is the unit of the speed error: mechanical rad/s times `error_gain`.

Source   Guo et al. 2024, figure 5, equations 11 and 25.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from evenspin.errors import InputError

Complex = NDArray[np.complex128]
Array = NDArray[np.float64]

POSITIVE = ("kp_a_per_unit", "error_gain", "ts_s", "torque_per_a_nm", "inertia_kgm2", "current_bandwidth_rad_s")
NOT_NEGATIVE = ("ki_a_per_unit_s", "viscous_nms", "delay_s")


@dataclass(frozen=True, slots=True)
class SpeedLoop:
    """Everything between the speed error and the speed. SI units."""

    kp_a_per_unit: float
    ki_a_per_unit_s: float
    error_gain: float
    ts_s: float
    torque_per_a_nm: float
    inertia_kgm2: float
    viscous_nms: float
    current_bandwidth_rad_s: float
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        for name in POSITIVE:
            if not 0.0 < getattr(self, name) < float("inf"):
                raise InputError("design rc", name, getattr(self, name), "finite and above 0", "correct the model")
        for name in NOT_NEGATIVE:
            if not 0.0 <= getattr(self, name) < float("inf"):
                raise InputError("design rc", name, getattr(self, name), "finite and from 0", "correct the model")

    def as_json(self) -> dict[str, float]:
        return asdict(self)

    def plant(self, f_hz: Array) -> Complex:
        """G: current reference, held for T_s, to the sampled speed in units."""
        w, j, b = self.current_bandwidth_rad_s, self.inertia_kgm2, self.viscous_nms
        a = np.array([[-w, 0.0], [self.torque_per_a_nm / j, -b / j]])
        gain = np.array([w, 0.0])
        whole, part_s = divmod(self.delay_s, self.ts_s)
        # Within a period the old value acts for part_s, then the new one.
        new = _held(a, gain, self.ts_s - part_s)
        old = expm(a * (self.ts_s - part_s)) @ _held(a, gain, part_s)
        step = expm(a * self.ts_s)
        z = np.exp(2j * np.pi * np.asarray(f_hz) * self.ts_s)
        left = z[:, None, None] * np.eye(2) - step
        right = new + old / z[:, None]
        state = np.linalg.solve(left, right[:, :, None])[:, :, 0]
        return self.error_gain * state[:, 1] * z**-whole

    def controller(self, f_hz: Array) -> Complex:
        """PI as the firmware computes it: the integrator takes the error of this sample for the next."""
        z = np.exp(2j * np.pi * np.asarray(f_hz) * self.ts_s)
        return self.kp_a_per_unit + self.ki_a_per_unit_s * self.ts_s / (z - 1.0)

    def closed(self, f_hz: Array) -> Complex:
        """M: speed reference to speed."""
        loop = self.controller(f_hz) * self.plant(f_hz)
        return loop / (1.0 + loop)


def _held(a: Array, b: Array, t_s: float) -> Array:
    """What an input of 1, held for t_s, adds to the state."""
    size = len(b)
    block = np.zeros((size + 1, size + 1))
    block[:size, :size], block[:size, size] = a, b
    return expm(block * t_s)[:size, size]
