"""A log as the library of terms takes it, and what one coefficient of a term adds to the equations of the machine."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

REVERSED = 0.25  # of the speed that counts as rest, by which the shaft has to turn the other way


@dataclass(frozen=True, slots=True)
class Rows:
    """Even rows. `rated_nm` and `top_rad_s` scale the columns: a coefficient is a torque at the top of the range."""

    t_s: Array
    theta_rad: Array  # unwrapped
    speed_rad_s: Array
    id_a: Array
    iq_a: Array
    torque_nm: Array  # of the air gap
    vd_v: Array | None
    vq_v: Array | None
    vdc_v: Array | None
    pole_pairs: float
    psi_wb: float
    top_rad_s: float
    rest_rad_s: float
    rated_nm: float
    rated_a: float
    link_v: float
    has_angle: bool = True
    one_travel: bool = True  # the angle counts from the same place in all rows
    memory: dict[str, Array] = field(default_factory=dict)

    @property
    def start_s(self) -> float:
        return float(self.t_s[0])

    @property
    def span_s(self) -> float:
        return float(self.t_s[-1] - self.t_s[0])

    @property
    def period_s(self) -> float:
        return float(np.median(np.diff(self.t_s)))  # records of one clock have gaps between them

    def direction(self) -> Array:
        """-1 to 1, through zero within a fraction of what counts as rest."""
        if "direction" not in self.memory:
            self.memory["direction"] = np.tanh(self.speed_rad_s / (REVERSED * self.rest_rad_s))
        return self.memory["direction"]

    def shown(self, order: float) -> Array:
        """Share of a line over the angle that rows of this rate show: none above half the rate."""
        return np.clip(2.0 - order * np.abs(self.speed_rad_s) * self.period_s / (0.5 * np.pi), 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Column:
    """What one unit of a coefficient adds, in every row: a torque against positive rotation, voltages that are lost on
    the axes, and flux linkages of the axes, whose derivative is a voltage. None: nothing there."""

    torque: Array | None = None
    d: Array | None = None
    q: Array | None = None
    d_linkage: Array | None = None
    q_linkage: Array | None = None

    @property
    def on_shaft_only(self) -> bool:
        return self.d is None and self.q is None and self.d_linkage is None and self.q_linkage is None
