"""What a drive is tuned for. The margins are the contract; the bandwidths are where the search begins."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Goal:
    """The margins hold for the model as it is, `corner_distance` for every machine of its tolerances."""

    name: str
    text: str
    current_hz: float  # the largest bandwidth of the current loop
    current_margin_deg: float
    speed_hz: float  # the largest crossover of the speed loop
    speed_margin_deg: float
    integral_ratio: float  # crossover over the corner of the integral part
    count_current_part: float  # current of one encoder count in a speed sample, of the rated current
    overshoot_part: float  # of a speed step, at most
    learning_part: float  # of the largest stable learning gain

    @property
    def corner_distance(self) -> float:
        """Least distance of the speed loop from -1 in the worst corner: 1 / max |S|."""
        return 0.33


GOALS = {
    each.name: each
    for each in (
        Goal("stiff", "load steps and set points are followed as fast as the margins allow",
             600.0, 58.0, 80.0, 48.0, 4.0, 1.0, 0.35, 0.40),
        Goal("smooth", "even speed: margins first, ripple suppression on top",
             400.0, 62.0, 45.0, 58.0, 5.0, 0.4, 0.25, 0.30),
        Goal("quiet", "as little current noise as possible, for fine encoders as for coarse ones",
             200.0, 65.0, 20.0, 62.0, 6.0, 0.10, 0.25, 0.20),
    )
}  # fmt: skip
DEFAULT = "smooth"
CURRENT_WORST_DEG, CURRENT_WORST_GAIN = 40.0, 1.8  # in the worst corner
SPEED_GAIN = 2.2  # least gain margin of the speed loop, as it is
