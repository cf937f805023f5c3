"""What a step found, how good it is, and what is known so far."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from evenspin.identify.estimate import Estimate


@dataclass(frozen=True, slots=True)
class Quality:
    """A number, half of its 95 % interval and the limits that it must keep.

    `half` is 0 where no interval is known: a first, rough value has a bias that its scatter does not show.
    """

    what: str
    value: float
    half: float
    unit: str
    low: float
    high: float

    @property
    def good(self) -> bool:
        return self.low <= self.value <= self.high

    def __str__(self) -> str:
        interval = f" +- {self.half:.2g}" if self.half > 0.0 else ""
        word = "good" if self.good else "NOT GOOD"
        return (
            f"{self.what}: {self.value:.5g}{interval} {self.unit}".rstrip()
            + f", {word} ({self.low:.4g} .. {self.high:.4g})"
        )


def sure(what: str, found: Estimate, unit: str, relative: float) -> list[Quality]:
    """A number above 0, and its interval, which must be narrow enough."""
    return [
        Quality(what, found.value, found.half, unit, 1e-12, 1e12),
        Quality(f"{what}: half of its 95 % interval", 100.0 * found.relative, 0.0, "%", 0.0, 100.0 * relative),
    ]


@dataclass(frozen=True, slots=True)
class Step:
    """One step, done. `parameters`: what the drive was given."""

    name: str
    goal: str
    qualities: Sequence[Quality]
    parameters: dict[str, float]
    seconds: float
    notes: Sequence[str] = ()

    @property
    def good(self) -> bool:
        return all(quality.good for quality in self.qualities)


@dataclass
class Known:
    """Numbers of the motor, filled in from step to step."""

    supply_v: float = 0.0
    over_speed_rad_s: float = 0.0
    counts: float = 0.0
    pole_pairs: int = 1
    reversed: bool = False
    resistance: Estimate = field(default_factory=lambda: Estimate(0.0, 0.0))
    ld: Estimate = field(default_factory=lambda: Estimate(0.0, 0.0))
    lq: Estimate = field(default_factory=lambda: Estimate(0.0, 0.0))
    psi: Estimate = field(default_factory=lambda: Estimate(0.0, 0.0))
    offset_rad: float = 0.0
    inertia: Estimate = field(default_factory=lambda: Estimate(0.0, 0.0))
    viscous: Estimate = field(default_factory=lambda: Estimate(0.0, 0.0))
    coulomb: Estimate = field(default_factory=lambda: Estimate(0.0, 0.0))
    saturation: list[tuple[float, float]] = field(default_factory=list)  # (A, H) of the d axis
    growth_s: float = 0.08  # time in which the voltage of the first current grew e-fold
    per_a_rad_s2: float = 0.0  # acceleration per ampere, roughly

    @property
    def torque_per_a(self) -> float:
        return 1.5 * self.pole_pairs * self.psi.value

    @property
    def base_rad_s(self) -> float:
        """Speed at which the back-EMF fills the dc link."""
        return self.supply_v / 3.0**0.5 / (self.pole_pairs * self.psi.value)
