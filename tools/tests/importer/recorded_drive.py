"""A drive in closed form, and the ways in which others write it down. Shares nothing with the code under test."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PAIRS = 5
ZERO_RAD = 0.7  # of the electrical angle at mechanical angle 0
TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Recorded:
    """Both directions, two accelerations a second, friction; id is 0."""

    t: Array
    theta: Array
    speed: Array
    iq: Array
    ia: Array
    ib: Array

    @property
    def rpm(self) -> Array:
        return self.speed * 60.0 / TURN

    @property
    def theta_e(self) -> Array:
        return PAIRS * self.theta + ZERO_RAD


def recorded(rows: int = 6000, rate_hz: float = 1000.0) -> Recorded:
    t = np.arange(rows) / rate_hz
    speed = 40.0 * np.sin(2.0 * np.pi * 0.5 * t) + 9.0 * np.sin(2.0 * np.pi * 1.7 * t + 0.4)
    theta = -40.0 / (np.pi) * np.cos(np.pi * t) - 9.0 / (3.4 * np.pi) * np.cos(3.4 * np.pi * t + 0.4)
    accel = np.gradient(speed, t)
    iq = 0.004 * accel + 0.01 * speed + 0.2 * np.tanh(speed) + 0.01 * np.sin(TURN * 211.0 * t)
    theta_e = PAIRS * theta + ZERO_RAD
    ia = -iq * np.sin(theta_e)
    ib = -iq * np.sin(theta_e - TURN / 3.0)
    return Recorded(t, theta, speed, iq, ia, ib)


def write_text(
    path: Path,
    header: list[str] | None,
    columns: list[Array],
    *,
    delimiter: str = ",",
    comma: bool = False,
    units: list[str] | None = None,
    before: str = "",
    encoding: str = "utf-8",
) -> Path:
    lines = [delimiter.join(words) for words in (header, units) if words is not None]
    for row in zip(*columns, strict=True):
        line = delimiter.join(f"{value:.9g}" for value in row)
        lines.append(line.replace(".", ",") if comma else line)
    path.write_text(before + "\n".join(lines) + "\n", encoding=encoding)
    return path
