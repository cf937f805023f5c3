"""A simulation in the library's own terms: numbers by name, inputs over time. Made from a scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class InputCurve:
    """An input over time: held between the points, or straight lines.

    `at_s`: when it begins to change; None: at every point.
    """

    t_s: tuple[float, ...]
    value: tuple[float, ...]
    linear: bool = False
    at_s: tuple[float, ...] | None = None

    @property
    def changes_s(self) -> tuple[float, ...]:
        """Instants at which something begins."""
        return self.t_s if self.at_s is None else self.at_s


@dataclass(frozen=True, slots=True)
class Tune:
    """A drive parameter that changes while the drive runs."""

    t_s: float
    param: str
    value: float


@dataclass(frozen=True, slots=True)
class Setup:
    """Everything a run needs. `plant` and `drive` are complete."""

    name: str
    plant: Mapping[str, float]
    drive: Mapping[str, float]
    effects: Mapping[str, Mapping[str, float]]
    inputs: Mapping[str, InputCurve]
    tunes: tuple[Tune, ...]
    duration_s: float
    log_rate_hz: float
    seed: int
    drive_from: Mapping[str, str] = field(default_factory=dict)  # where it is stated; else it is a default
    base: str = ""  # model that [plant] was completed from

    @property
    def pwm_hz(self) -> float:
        return self.plant["pwm_hz"]

    @property
    def decimate(self) -> int:
        """PWM periods per row of the record."""
        return round(self.pwm_hz / self.log_rate_hz)

    @property
    def periods(self) -> int:
        return round(self.duration_s * self.pwm_hz)

    @property
    def event_times_s(self) -> tuple[float, ...]:
        """Every instant at which something changes, without 0."""
        times = {t for curve in self.inputs.values() for t in curve.changes_s} | {tune.t_s for tune in self.tunes}
        return tuple(sorted(t for t in times if 0.0 < t < self.duration_s))
