"""The machine and the drive that a meta.json describes: what is simulated before any effect is added."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from evenspin.log.controller import controller_of
from evenspin.log.meta_numbers import MetaNumbers

MACHINE = ("pole_pairs", "resistance_ohm", "ld_h", "lq_h", "psi_wb", "inertia_kgm2", "viscous_nms")


@dataclass(frozen=True, slots=True)
class Nominal:
    """Numbers by the names of the machine model and of the drive's parameters."""

    counts_per_rev: float
    current_noise_a: float
    machine: Mapping[str, float]
    supply: Mapping[str, float]  # dc link, PWM, and the step of the current measurement
    drive: Mapping[str, float]

    @classmethod
    def of(cls, meta: MetaNumbers) -> Nominal:
        return cls(
            meta.number("encoder", "counts_per_rev"),
            meta.number("current_noise_a"),
            {key: meta.number("motor", key) for key in MACHINE},
            {key: meta.number(key) for key in ("dc_link_v", "pwm_hz", "current_lsb_a")},
            controller_of(meta),
        )
