"""Which angle order the slots show: that of slots and poles together, or of the slots alone if one magnet is unlike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.effects.cogging import slot_order
from evenspin.gap.features import FeatureKey

HEARD = 10.0  # mean square, in sigmas, that an unusual order needs
LOUDER = 3.0  # and so many times what the usual one has
CAP = 30.0  # sigmas: one stretch alone decides nothing


def slot_orders(motor: Mapping[str, float]) -> tuple[int, ...]:
    """Orders that cogging may have, the usual one first; empty without a number of slots."""
    slots, pole_pairs = int(motor.get("slots", 0) or 0), int(motor["pole_pairs"])
    if slots <= 0:
        return ()
    usual = slot_order(pole_pairs, slots)
    electrical = {pole_pairs * k for k in (1, 2, 6)} | {1, 2}  # orders at which other effects show
    return (usual, slots) if slots != usual and slots not in electrical else (usual,)


def heard_order(motor: Mapping[str, float], keys: Sequence[FeatureKey], whitened: NDArray[np.float64]) -> int | None:
    """The order that stands out of what a sound machine leaves unexplained (`whitened`, in sigmas, as `keys`)."""
    orders = slot_orders(motor)
    if len(orders) < 2:
        return orders[0] if orders else None
    usual, unusual = (_loudness(order, keys, whitened) for order in orders)
    return orders[1] if unusual > HEARD and unusual > LOUDER * usual else orders[0]


def _loudness(order: int, keys: Sequence[FeatureKey], whitened: NDArray[np.float64]) -> float:
    rows = [i for i, key in enumerate(keys) if key.signal == "speed_rad_s" and key.order == order]
    return float(np.mean(np.minimum(np.abs(whitened[rows]), CAP) ** 2)) if rows else 0.0
