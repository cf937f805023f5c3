"""Which angle order the slots show: that of slots and poles together, or of the slots alone if one magnet is unlike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from evenspin.effects.cogging import slot_order
from evenspin.gap.features import FeatureKey
from evenspin.gap.thresholds_evidence import SLOT_ORDER_CAP, SLOT_ORDER_MEAN_SQUARE, SLOT_ORDER_RATIO


def slot_orders(motor: Mapping[str, float]) -> tuple[int, ...]:
    """Orders that cogging may have, that of slots and poles first; empty without a number of slots."""
    slots, pole_pairs = int(motor.get("slots", 0) or 0), int(motor["pole_pairs"])
    if slots <= 0:
        return ()
    common = slot_order(pole_pairs, slots)
    electrical = {pole_pairs * k for k in (1, 2, 6)} | {1, 2}  # orders at which other effects show
    return (common, slots) if slots != common and slots not in electrical else (common,)


def detected_order(motor: Mapping[str, float], keys: Sequence[FeatureKey], whitened: NDArray[np.float64]) -> int | None:
    """The order that stands out of what a healthy machine leaves unexplained (`whitened`, in sigmas, as `keys`)."""
    orders = slot_orders(motor)
    if len(orders) < 2:
        return orders[0] if orders else None
    common, alone = (_mean_square(order, keys, whitened) for order in orders)
    return orders[1] if alone > SLOT_ORDER_MEAN_SQUARE and alone > SLOT_ORDER_RATIO * common else orders[0]


def _mean_square(order: int, keys: Sequence[FeatureKey], whitened: NDArray[np.float64]) -> float:
    rows = [i for i, key in enumerate(keys) if key.signal == "speed_rad_s" and key.order == order]
    return float(np.mean(np.minimum(np.abs(whitened[rows]), SLOT_ORDER_CAP) ** 2)) if rows else 0.0
