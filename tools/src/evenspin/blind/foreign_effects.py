"""What no table of effects lists, for logs of other drives: kinds that machines on benches really have.

Each kind has a draw of the referee's parameters, and what an analysis should find out about it: `Expected`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from evenspin.blind.bench_drives import Drive
from evenspin.blind.referee import Inputs

Values = dict[str, float]


@dataclass(frozen=True, slots=True)
class Expected:
    """`depends_on`: the quantity that the cause depends on, any of these. `key`: the number that names it, of the drawn
    values (an order, a frequency), with `within` relative; "" where there is none. `power`: of the speed; 0: any."""

    depends_on: tuple[str, ...]
    parity: str = ""
    power: float = 0.0
    key: str = ""
    within: float = 0.1
    known: tuple[str, ...] = ()  # names of the table that describe it as well


@dataclass(frozen=True, slots=True)
class Foreign:
    """`referee`: the group of its parameters. `voltages`, `angle`, `rows_hz`: what a log needs to show it."""

    referee: str
    draw: Callable[[np.random.Generator, Drive, int], Values]
    expected: Expected
    voltages: bool = False
    angle: bool = False
    rows_hz: float = 0.0


def _about(rng: np.random.Generator, size: int, *sizes: float) -> float:
    return sizes[size] * float(rng.uniform(0.85, 1.15))


def _rated_nm(drive: Drive) -> float:
    return float(drive.meta["motor"]["rated_torque_nm"])


def _phase(rng: np.random.Generator) -> float:
    return float(rng.uniform(0.0, math.tau))


def _fan(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"torque_nm_s2": _about(rng, size, 0.06, 0.12, 0.25) * _rated_nm(drive) / drive.full_speed_rad_s**2}


def _pump(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    # An odd number of pistons, which is no multiple that the motor has of itself.
    pairs = int(drive.meta["motor"]["pole_pairs"])
    order = float(rng.choice([n for n in (5, 7, 9, 11) if n not in (pairs, 2 * pairs, drive.meta["motor"]["slots"])]))
    return {
        "torque_nm_s2": _about(rng, size, 0.1, 0.18, 0.3) * _rated_nm(drive) / drive.full_speed_rad_s**2,
        "pulse_rel": float(rng.uniform(0.4, 0.8)),
        "order": order,
        "phase_rad": _phase(rng),
    }


def _line(least: float, most: float, second: float = 0.0) -> Callable[[np.random.Generator, Drive, int], Values]:
    def draw(rng: np.random.Generator, drive: Drive, size: int) -> Values:
        motor = drive.meta["motor"]
        while True:
            order = float(rng.uniform(least, most))
            whole = min(abs(order - round(order)), abs(2.0 * order - round(2.0 * order)))
            if whole > 0.06 and abs(order - motor["pole_pairs"]) > 0.06:
                break
        return {
            "amplitude_nm": _about(rng, size, 0.015, 0.03, 0.06) * _rated_nm(drive),
            "phase_rad": _phase(rng),
            "order": order,
            "second_rel": second,
        }

    return draw


def _gravity(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"amplitude_nm": _about(rng, size, 0.015, 0.03, 0.06) * _rated_nm(drive), "phase_rad": _phase(rng)}


def _warm_winding(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"rise_rel": _about(rng, size, 0.2, 0.3, 0.45), "time_s": float(rng.uniform(6.0, 20.0))}


def _warm_magnet(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {"fall_rel": _about(rng, size, 0.05, 0.08, 0.12), "time_s": float(rng.uniform(6.0, 20.0))}


def _cold_grease(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {
        "torque_nm": _about(rng, size, 0.03, 0.06, 0.12) * _rated_nm(drive),
        "time_s": float(rng.uniform(5.0, 15.0)),
    }


def _mains(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {
        "amplitude_rel": _about(rng, size, 0.03, 0.06, 0.1),
        "frequency_hz": float(rng.choice((50.0, 60.0, 100.0, 120.0))),
    }


def _beat(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {
        "amplitude_nm": _about(rng, size, 0.02, 0.04, 0.08) * _rated_nm(drive),
        "frequency_hz": float(rng.uniform(6.0, 30.0)),
        "phase_rad": _phase(rng),
    }


def _sag(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    motor = drive.meta["motor"]
    power_w = motor["rated_torque_nm"] * drive.full_speed_rad_s
    return {"resistance_ohm": _about(rng, size, 0.08, 0.14, 0.22) * drive.meta["dc_link_v"] ** 2 / power_w}


def _cross(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    motor = drive.meta["motor"]
    return {"wb_per_a2": _about(rng, size, 0.12, 0.2, 0.35) * motor["psi_wb"] / motor["rated_current_a"] ** 2}


def _position(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    # Shares of the range that the log travels; `placed` makes angles of them.
    return {
        "amplitude_nm": float(rng.choice((-1.0, 1.0))) * _about(rng, size, 0.06, 0.1, 0.18) * _rated_nm(drive),
        "centre_rad": float(rng.uniform(0.3, 0.7)),
        "width_rad": float(rng.uniform(0.1, 0.2)),
    }


def _presliding(rng: np.random.Generator, drive: Drive, size: int) -> Values:
    return {
        "torque_nm": _about(rng, size, 0.04, 0.07, 0.12) * _rated_nm(drive),
        "length_rad": float(np.exp(rng.uniform(math.log(0.15), math.log(0.8)))),
    }


ANGLE_LINE = ("angle",)
FOREIGN: dict[str, Foreign] = {
    "fan": Foreign("fan_load", _fan, Expected(("speed",), "odd", 2.0)),
    "pump": Foreign("pump_load", _pump, Expected(("speed", "angle"), key="order"), angle=True),
    "belt": Foreign("foreign_order_torque", _line(0.55, 4.8, 0.35), Expected(ANGLE_LINE, key="order"), angle=True),
    "gear_error": Foreign("foreign_order_torque", _line(5.1, 17.9), Expected(ANGLE_LINE, key="order"), angle=True),
    "bearing_cage": Foreign("foreign_order_torque", _line(0.36, 0.44), Expected(ANGLE_LINE, key="order"), angle=True),
    "gravity": Foreign("misalignment", _gravity, Expected(ANGLE_LINE, known=("misalignment",)), angle=True),
    "warm_winding": Foreign("resistance_drift", _warm_winding, Expected(("time",)), voltages=True),
    "warm_magnet": Foreign("magnet_drift", _warm_magnet, Expected(("time",)), voltages=True),
    "cold_grease": Foreign("friction_drift", _cold_grease, Expected(("time",))),
    "mains": Foreign(
        "supply_ripple", _mains, Expected(("frequency",), key="frequency_hz"), voltages=True, rows_hz=1000.0
    ),
    "beat": Foreign("fixed_frequency_torque", _beat, Expected(("frequency",), key="frequency_hz")),
    "sag": Foreign("supply_sag", _sag, Expected(("supply", "power")), voltages=True),
    "cross_saturation": Foreign("cross_saturation", _cross, Expected(("current",)), voltages=True),
    "position": Foreign("position_load", _position, Expected(("position",)), angle=True),
    "presliding": Foreign("presliding", _presliding, Expected(("reversal",)), angle=True),
}


def placed(values: Values, inputs: Inputs, pwm_hz: float) -> Values:
    """A load at a position, at angles that the log travels."""
    travel = np.cumsum(inputs.speed_ref_rad_s) / pwm_hz
    low, high = (float(x) for x in np.percentile(travel, (5.0, 95.0)))
    return values | {
        "centre_rad": low + values["centre_rad"] * (high - low),
        "width_rad": values["width_rad"] * (high - low),
    }
