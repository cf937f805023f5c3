"""Voltages, currents and speed of one drive: every winding takes voltage with its current, every magnet with its speed.

    vd = R id - w Xq iq            all four numbers are positive, whatever the machine
    vq = R iq + w (Xd id + F)      X: pole pairs times inductance, F: pole pairs times flux

An exchange or a sign that makes one of them negative leaves voltage that no machine explains.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from evenspin.plausible.dead import is_constant
from evenspin.plausible.finding import Array, Finding, rms

NEEDED = ("t_s", "speed_rad_s", "id_a", "iq_a", "vd_v", "vq_v")
BLOCK_S = 0.02  # means of so long: the voltage of changing currents and noise are gone
BLOCK_ROWS = 4
LEAST_BLOCKS = 30
EXPLAINED = 0.25  # share of the voltage that a right reading may leave
ODD = 0.02  # share that a wrong one leaves at least
LEAST_PART = 0.02  # of the voltage that a number has to make to be known...
SEEN = 3.0  # ...and times what is not explained
MOST_OFF = 1.0  # tangent of the angle of the drive's axes against the magnets: electrical zero and late angle together
PLAIN = 2.5  # times that the right reading leaves less

Columns = Mapping[str, Array]


@dataclass(frozen=True, slots=True)
class Windings:
    """`left`: share of the voltage that is not explained. The rest as in the equations above, never negative."""

    left: float
    resistance_ohm: float
    xd_vs_per_a: float
    xq_vs_per_a: float
    flux_vs: float


def blocks_of(columns: Columns) -> dict[str, Array]:
    """Means of short stretches, where the log is in order."""
    t_s = columns["t_s"]
    step_s = float(np.median(np.diff(t_s))) if len(t_s) > 1 else 0.0
    n = max(BLOCK_ROWS, round(BLOCK_S / step_s)) if step_s > 0.0 else len(t_s) + 1
    count = len(t_s) // n
    means = {name: np.asarray(values[: count * n]).reshape(count, n).mean(axis=1) for name, values in columns.items()}
    good = np.all([np.isfinite(values) for values in means.values()], axis=0)
    return {name: values[good] for name, values in means.items()}


def windings_of(b: Columns) -> Windings:
    """Of block means. The drive's axes may be off by an angle, and by one that grows with the speed."""
    d, q, w = b["id_a"], b["iq_a"], b["speed_rad_s"]
    zero = np.zeros(len(d))
    volts = np.concatenate([b["vd_v"], b["vq_v"]])
    size, fastest = rms(volts), float(np.max(np.abs(w), initial=0.0))
    if not size > 0.0:
        return Windings(0.0, 0.0, 0.0, 0.0, 0.0)
    machine = [(d, q), (zero, w * d), (-w * q, zero), (zero, w)]
    turned = [(w, zero), (-w, zero), (w * w, zero), (-w * w, zero)]
    found, rest = _fitted([*machine, *turned], volts)
    flux = float(found[3])
    off = abs(found[4] - found[5]) + fastest * abs(found[6] - found[7])
    if off > MOST_OFF * flux:
        found, rest = _fitted(machine, volts)
    r, xd, xq, flux = (float(value) for value in found[:4])
    return Windings(rest / math.sqrt(len(volts)) / size, r, xd, xq, flux)


def _fitted(terms: list[tuple[Array, Array]], volts: Array) -> tuple[Array, float]:
    columns = np.column_stack([np.concatenate(pair) for pair in terms])
    scale = np.sqrt(np.mean(columns**2, axis=0))
    scale[scale == 0.0] = 1.0
    found, rest = nnls(columns / scale, volts)
    return np.asarray(found / scale), float(rest)


Change = Callable[[Columns], dict[str, Array]]


def _turned(*names: str) -> Change:
    return lambda b: {**b, **{name: -b[name] for name in names}}


def _exchanged(one: str, other: str, turned: str = "") -> Change:
    def change(b: Columns) -> dict[str, Array]:
        new = {**b, one: b[other], other: b[one]}
        return {**new, turned: -new[turned]} if turned else new

    return change


# The likeliest first: of two that explain as much, the first is said.
READINGS: dict[str, tuple[str, Change]] = {
    "id_a and iq_a have the opposite sign": ("iq_a", _turned("id_a", "iq_a")),
    "vd_v and vq_v have the opposite sign": ("vq_v", _turned("vd_v", "vq_v")),
    "speed_rad_s (or the order of the phases) has the opposite sign": ("speed_rad_s", _turned("speed_rad_s")),
    "iq_a has the opposite sign": ("iq_a", _turned("iq_a")),
    "vq_v has the opposite sign": ("vq_v", _turned("vq_v")),
    "vd_v has the opposite sign": ("vd_v", _turned("vd_v")),
    "vd_v and vq_v are exchanged": ("vd_v", _exchanged("vd_v", "vq_v")),
    "id_a and iq_a are exchanged": ("id_a", _exchanged("id_a", "iq_a")),
    "vd_v and vq_v are exchanged and one has the opposite sign": ("vd_v", _exchanged("vd_v", "vq_v", "vd_v")),
    "id_a and iq_a are exchanged and one has the opposite sign": ("id_a", _exchanged("id_a", "iq_a", "id_a")),
}


def measured_windings(columns: Columns) -> dict[str, float] | None:
    """Flux, resistance and reactance of the q axis as the log has them; None where it explains too little."""
    if any(is_constant(columns[name]) for name in NEEDED):
        return None
    blocks = blocks_of({name: columns[name] for name in NEEDED})
    if len(blocks["t_s"]) < LEAST_BLOCKS:
        return None
    found = windings_of(blocks)
    if found.left > EXPLAINED:
        return None
    volts = math.hypot(rms(blocks["vd_v"]), rms(blocks["vq_v"]))
    parts = {
        "flux": (found.flux_vs, blocks["speed_rad_s"]),
        "resistance": (found.resistance_ohm, blocks["iq_a"]),
        "reactance": (found.xq_vs_per_a, blocks["speed_rad_s"] * blocks["iq_a"]),
    }
    least = max(LEAST_PART, SEEN * found.left) * volts
    return {name: value for name, (value, factor) in parts.items() if value * rms(factor) > least}


def check_windings(columns: Columns) -> Finding | None:
    """A sign or an exchange that no machine allows, where another reading explains the voltages plainly better."""
    blocks = blocks_of({name: columns[name] for name in NEEDED})
    if len(blocks["t_s"]) < LEAST_BLOCKS:
        return None
    own = windings_of(blocks).left
    if own < ODD:
        return None
    left = {what: windings_of(change(blocks)).left for what, (_, change) in READINGS.items()}
    best = min(left, key=lambda what: left[what])
    if left[best] > EXPLAINED or own < PLAIN * left[best]:
        return None
    alike = [what for what in left if left[what] < 1.2 * left[best]][:3]
    data = f"{100.0 * min(own, 1.0):.0f} % of the voltage is what no machine takes, {100.0 * left[best]:.0f} % when "
    return Finding(
        READINGS[alike[0]][0],
        data + ", or when ".join(alike),
        "voltages, currents and speed of one motor",
        "correct the column, or its scale in MAP.toml",
    )
