"""The order of cogging: from the winding, unless the log says that one magnet is unlike the others."""

from __future__ import annotations

import numpy as np
import pytest
from evenspin.gap.features import FeatureKey
from evenspin.gap.slotting import detected_order, slot_orders

MOTOR = {"pole_pairs": 5, "slots": 12}  # 60 periods per turn from slots and poles, 12 from the slots alone
STRETCHES = 8


def _log(lines: dict[int, float], motor: dict[str, int] = MOTOR, signal: str = "speed_rad_s"):
    keys = [
        FeatureKey("staircase", signal, "order", i, order=float(order), part=part)
        for i in range(STRETCHES)
        for order in (1, *slot_orders(motor))
        for part in ("cos", "sin")
    ]
    level = {order: lines.get(order, 1.0) for order in (1, *slot_orders(motor))}
    return keys, np.array([level[key.order] for key in keys])


def test_a_quiet_log_and_a_line_of_slots_and_poles_leave_the_order_of_slots_and_poles():
    for lines in ({}, {60: 20.0}, {1: 50.0}, {60: 8.0, 12: 8.0}):
        assert detected_order(MOTOR, *_log(lines)) == 60, lines


def test_a_line_at_the_slots_alone_is_detected_where_that_of_slots_and_poles_is_not():
    assert detected_order(MOTOR, *_log({12: 5.0})) == 12


def test_what_is_within_the_noise_is_not_detected():
    assert detected_order(MOTOR, *_log({12: 3.0, 60: 0.1})) == 60


def test_one_strong_stretch_alone_decides_nothing():
    keys, whitened = _log({60: 12.0})
    whitened[[i for i, key in enumerate(keys) if (key.block, key.part, key.order) == (0, "cos", 12.0)]] = 1e6
    assert detected_order(MOTOR, keys, whitened) == 60


def test_only_the_speed_counts():
    assert detected_order(MOTOR, *_log({12: 5.0}, signal="vd_v")) == 60


@pytest.mark.parametrize(
    ("pole_pairs", "slots", "orders"),
    [
        (4, 12, (24, 12)),
        (3, 36, (36,)),  # slots divide into the poles: one order
        (2, 12, (12,)),
        (6, 9, (36, 9)),
        (9, 18, (18,)),  # one order again, and it is the second electrical
        (9, 9, (18,)),  # the slots' own order 9 is the first electrical
        (7, 42, (42,)),
        (5, 0, ()),
    ],
)
def test_orders_at_which_other_effects_show_are_not_taken_for_slots(pole_pairs, slots, orders):
    assert slot_orders({"pole_pairs": pole_pairs, "slots": slots}) == orders
