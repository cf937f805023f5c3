"""Motion profile of the position drive."""

from __future__ import annotations

from dataclasses import dataclass

from evenspin.blocks.block import Block
from evenspin.errors import BlockError

FAR_RAD = 1e9


@dataclass(frozen=True, slots=True)
class Setpoint:
    """What a motion profile hands out; `done`: at the target and at rest."""

    position_rad: float
    speed_rad_s: float
    acceleration_rad_s2: float
    done: bool


class MotionProfile:
    """A motion to a target, which may move, with limited speed, acceleration and jerk.

    Args:
        speed_rad_s: largest speed, above 0.
        accel_rad_s2: largest acceleration; 0: the speed jumps, and no acceleration is handed out.
        smooth_samples: 1 to 64; the jerk is accel_rad_s2 / (smooth_samples ts_s), twice that where accelerating turns
            into braking at once. 1: not limited.
        ts_s: sampling time.
    """

    def __init__(
        self,
        speed_rad_s: float,
        accel_rad_s2: float,
        smooth_samples: int = 1,
        ts_s: float = 1e-3,
        *,
        numeric: str = "float",
    ) -> None:
        self._block = Block(
            "profile",
            numeric=numeric,
            speed_rad_s=speed_rad_s,
            accel_rad_s2=accel_rad_s2,
            smooth_samples=smooth_samples,
            ts_s=ts_s,
        )

    def step(self, target_rad: float) -> Setpoint:
        """Advance one sample towards the target."""
        if not abs(target_rad) < FAR_RAD:
            raise BlockError("target_rad", target_rad, f"must be within +-{FAR_RAD:g}")
        position, speed, acceleration, done = self._block.do("step", target_rad)
        return Setpoint(position, speed, acceleration, done != 0.0)

    def reset(self, position_rad: float = 0.0) -> None:
        """Stand there."""
        if not abs(position_rad) < FAR_RAD:
            raise BlockError("position_rad", position_rad, f"must be within +-{FAR_RAD:g}")
        self._block.do("reset", position_rad)
