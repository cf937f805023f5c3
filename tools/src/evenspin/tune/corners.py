"""The machines that a model may mean: its numbers, each within [range], or within what such a number is good for.

Not every combination is looked at: those corners that make a loop fastest and slowest, and a warm and a cold winding.
"""

from __future__ import annotations

from collections.abc import Mapping

Numbers = Mapping[str, float]
Ranges = Mapping[str, tuple[float, float]]

# Where a model says nothing of it: either way, of the value. Resistance: cold to warm by 75 K.
COMMON = {
    "resistance_ohm": (0.9, 1.3), "ld_h": (0.8, 1.1), "lq_h": (0.8, 1.1), "psi_wb": (0.92, 1.05),
    "inertia_kgm2": (0.9, 1.1),
}  # fmt: skip


def range_of(name: str, plant: Numbers, ranges: Ranges) -> tuple[float, float]:
    if name in ranges:
        return ranges[name]
    low, high = COMMON.get(name, (1.0, 1.0))
    return low * plant[name], high * plant[name]


def corners(plant: Numbers, ranges: Ranges) -> dict[str, dict[str, float]]:
    """Machines by what is extreme about them."""

    def machine(**ends: int) -> dict[str, float]:
        return {**plant, **{name: range_of(name, plant, ranges)[end] for name, end in ends.items()}}

    return {
        "light, strong": machine(inertia_kgm2=0, psi_wb=1, ld_h=1, lq_h=1, resistance_ohm=1),
        "light, strong, fast current": machine(inertia_kgm2=0, psi_wb=1, ld_h=0, lq_h=0, resistance_ohm=0),
        "heavy, weak": machine(inertia_kgm2=1, psi_wb=0, ld_h=1, lq_h=1, resistance_ohm=1),
    }
