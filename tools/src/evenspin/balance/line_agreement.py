"""Whether two parts of a log have the same line over the angle, judged with the uncertainty of each.

A line of the shaft has one amplitude and one phase throughout. Two estimates of it differ by noise as well, and a
difference that noise explains says nothing against the line; a part whose noise hides the line says nothing for it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from evenspin.balance.regression import fit
from evenspin.balance.time_grid import Flags

Array = NDArray[np.float64]

DIFFERS = 1e-3  # chance of such a difference between two parts that have the same line, below which they differ
CONFIRMS = 0.05  # chance of as much in the direction of the other part without a line: above it, nothing is confirmed
NEGLIGIBLE = 0.5  # of the line: a smaller difference changes its amplitude, and is no other line


RAYLEIGH_MEDIAN = np.sqrt(2.0 * np.log(2.0))  # of the amplitude of sine and cosine of standard deviation 1


@dataclass(frozen=True, slots=True)
class PartOfLine:
    """The line as one part of the log has it: sine and cosine, A, and their covariance with its degrees of freedom."""

    value: Array
    covariance: Array
    freedom: int

    @property
    def phasor(self) -> complex:
        return complex(*self.value)

    def variance(self, direction: Array) -> float:
        """Of the component along a unit vector."""
        return float(direction @ self.covariance @ direction)


def part_of_line(columns: Array, y: Array, rows: Flags, noise_a: float = 0.0) -> PartOfLine:
    """`columns`: sine and cosine; `y`: the balance with everything but this line taken away.

    `noise_a`: median amplitude of the noise between the orders. The covariance is at least what that noise gives for
    the information that this part has: where one short stretch decides, its residual understates the noise.
    """
    own = columns[rows]
    gram = own.T @ own
    if np.linalg.matrix_rank(gram) < len(gram):
        return PartOfLine(np.zeros(len(gram)), np.full_like(gram, np.nan), 1)
    found = fit(("sin", "cos"), list(own.T), y[rows])
    row_variance = noise_a**2 / RAYLEIGH_MEDIAN**2 * 0.5 * float(np.sum(columns**2))
    floor = row_variance * np.linalg.inv(gram)
    return PartOfLine(found.value, _at_least(found.covariance, floor), found.blocks - 1)


def _at_least(covariance: Array, floor: Array) -> Array:
    """The covariance, with no variance in any direction below that of the floor."""
    if not np.any(floor):
        return covariance
    root = np.linalg.cholesky(floor)
    inverse = np.linalg.inv(root)
    ratio, direction = np.linalg.eigh(inverse @ covariance @ inverse.T)
    spread = root @ direction
    return (spread * np.maximum(ratio, 1.0)) @ spread.T


def same_line(amplitude_a: float, first: PartOfLine, second: PartOfLine) -> bool:
    """Each part confirms the other, and noise explains their difference, or it is small beside the line.

    `amplitude_a`: of the joint estimate, whose significance is tested where lines are found.
    """
    if not (_confirms(first, second.value) and _confirms(second, first.value)):
        return False
    apart_a = float(np.linalg.norm(first.value - second.value))
    return apart_a < NEGLIGIBLE * amplitude_a or difference_p(first, second) > DIFFERS


def contradict(amplitude_a: float, first: PartOfLine, second: PartOfLine) -> bool:
    """The parts differ by more than noise and by much of the line; a part without information contradicts nothing."""
    if not (_is_regular(first.covariance) and _is_regular(second.covariance)):
        return False
    apart_a = float(np.linalg.norm(first.value - second.value))
    return apart_a >= NEGLIGIBLE * amplitude_a and difference_p(first, second) <= DIFFERS


def in_one_only(amplitude_a: float, first: PartOfLine, second: PartOfLine) -> bool:
    """One part has the line and the other has not: they contradict each other, and the smaller one has less than
    half of it in the same direction. A late row or a wrong inertia turns the phase with the speed, and leaves more.
    """
    small, large = sorted((first.value, second.value), key=lambda value: float(np.linalg.norm(value)))
    missing = float(_unit(large) @ small) < NEGLIGIBLE * float(np.linalg.norm(large))
    return missing and contradict(amplitude_a, first, second)


def difference_p(first: PartOfLine, second: PartOfLine) -> float:
    """Chance of a difference this large if both parts have the same line.

    Hotelling's T squared of the difference, with the degrees of freedom that Welch and Satterthwaite give for two parts
    of unequal noise.
    """
    apart, covariance = first.value - second.value, first.covariance + second.covariance
    if not _is_regular(covariance):
        return 0.0
    direction = _unit(apart)
    variances = [(part.variance(direction), part.freedom) for part in (first, second)]
    freedom = sum(v for v, _ in variances) ** 2 / sum(v**2 / free for v, free in variances)
    size = len(apart)
    t2 = float(apart @ np.linalg.solve(covariance, apart))
    return float(special.fdtrc(size, freedom - size + 1, max(t2, 0.0) * (freedom - size + 1) / (freedom * size)))


def _confirms(part: PartOfLine, other: Array) -> bool:
    """Has this part alone something significant in the direction that the other one gives?"""
    if not _is_regular(part.covariance):
        return False
    direction = _unit(other)
    t = float(direction @ part.value) / float(np.sqrt(part.variance(direction)))
    return float(special.stdtr(part.freedom, -t)) < CONFIRMS


def _unit(vector: Array) -> Array:
    size = float(np.linalg.norm(vector))
    return vector / size if size > 0.0 else np.eye(len(vector))[0]


def _is_regular(covariance: Array) -> bool:
    return bool(np.all(np.isfinite(covariance))) and np.linalg.matrix_rank(covariance) == len(covariance)
