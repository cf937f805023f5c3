"""Machines drawn at random, as consistent as machines are: 10 W to 5 kW, 1 to 14 pole pairs, 12 to 400 V and beyond,
salient and not, inertias of 0.2 to 20 times that of a typical rotor of their torque."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

SUPPLIES_V = (12.0, 24.0, 36.0, 48.0, 60.0, 96.0, 150.0, 310.0, 400.0, 560.0)
COUNTS = (4000, 4096, 8192, 10000, 16384, 65536, 131072, 1048576)
MOST_RATED_A = 60.0
MOST_ELECTRICAL_HZ = 500.0  # at 10 kHz a period has 20 samples then


@dataclass(frozen=True)
class RandomMachine:
    """[plant] and [effects] of a model. `max_current_a`: peak of a phase, what its owner says that it bears."""

    seed: int
    power_w: float
    plant: dict[str, float]
    effects: dict[str, dict[str, float]]
    max_current_a: float
    max_speed_rad_s: float
    salient: bool

    def toml(self, name: str = "hidden") -> str:
        lines = [f'name = "{name}"', "", "[plant]", *(f"{key} = {value!r}" for key, value in self.plant.items())]
        for effect, params in self.effects.items():
            lines += ["", f"[effects.{effect}]", *(f"{key} = {value!r}" for key, value in params.items())]
        return "\n".join(lines) + "\n"


def random_machine(seed: int) -> RandomMachine:
    """The same for the same seed."""
    rng = np.random.default_rng([seed, 1709])
    while True:
        drawn = _draw(seed, rng)
        if (
            drawn.plant["lq_h"] < 0.5 and drawn.plant["resistance_ohm"] < 200.0
        ):  # a 30 W winding for 560 V exists on paper
            return drawn


def _draw(seed: int, rng: np.random.Generator) -> RandomMachine:

    def log_uniform(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(math.log(low), math.log(high))))

    power = log_uniform(10.0, 5000.0)
    pole_pairs = int(rng.integers(1, 15))
    fitting = [v for v in SUPPLIES_V if power / (1.1 * v) <= MOST_RATED_A and power >= 0.02 * v]
    supply = float(rng.choice(fitting))
    base = min(log_uniform(60.0, 700.0), 2.0 * math.pi * MOST_ELECTRICAL_HZ / pole_pairs)  # rad/s
    psi = rng.uniform(0.75, 1.0) * supply / math.sqrt(3.0) / (pole_pairs * base)
    rated_speed = 0.7 * base
    torque = power / rated_speed
    rated_a = torque / (1.5 * pole_pairs * psi)
    impedance = pole_pairs * base * psi / rated_a
    resistance = min(0.3, 0.1 * (power / 100.0) ** -0.3 * log_uniform(0.6, 1.7)) * impedance
    ld = rng.uniform(0.06, 0.45) * impedance / (pole_pairs * base)
    salient = bool(rng.random() < 0.5)
    lq = ld * (rng.uniform(1.2, 3.0) if salient else 1.0)
    inertia = 4e-5 * torque**1.5 * log_uniform(0.2, 20.0)
    counts = int(rng.choice([c for c in COUNTS if c >= 100 * pole_pairs]))
    peak_a = rng.uniform(2.0, 3.0) * rated_a
    clip = 1.6 * peak_a
    plant = {
        "pole_pairs": pole_pairs, "resistance_ohm": resistance, "ld_h": ld, "lq_h": lq, "psi_wb": psi,
        "inertia_kgm2": inertia, "viscous_nms": rng.uniform(0.005, 0.03) * torque / base, "dc_link_v": supply,
        "counts_per_rev": counts, "current_noise_a": 0.0008 * clip, "current_lsb_a": clip / 2048.0,
        "current_range_a": clip,
        "board_current_a": 1.5 * peak_a, "board_dc_link_v": 1.4 * supply, "board_speed_rad_s": 1.6 * base,
        "initial_angle_rad": rng.uniform(-3.0, 3.0),
    }  # fmt: skip

    def offset() -> float:
        return rng.uniform(-1.0, 1.0) * min(0.004 * clip, 0.3)

    effects = {
        "coulomb_friction": {"torque_nm": rng.uniform(0.003, 0.03) * torque},
        "encoder_offset": {"angle_el_rad": rng.uniform(-3.1, 3.1)},
        "current_offset": {
            "offset_a_a": offset(),
            "offset_b_a": offset(),
        },
    }
    plant = {key: float(f"{value:.6g}") if isinstance(value, float) else value for key, value in plant.items()}
    return RandomMachine(seed, power, plant, effects, float(f"{peak_a:.4g}"), float(f"{base:.4g}"), salient)
