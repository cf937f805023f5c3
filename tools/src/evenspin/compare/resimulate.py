"""Closed-loop re-simulation of a record: references, measured load and initial angle go in, nothing else."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import MISSING, InputError, NativeError
from evenspin.log.case import META
from evenspin.native.simulation import Simulation
from evenspin.sim.record import Record

VALIDATION = ("validation", "validation_steps")
LOCKED = ("standstill_steps", "validation_steps")  # rotor held, current mode
HINT = "docs/log-format.md describes meta.json"
NO_LIMIT = 1e3  # protection of a drive that is only re-simulated: out of the way


def resimulate(
    folder: Path,
    meta: Mapping[str, Any],
    name: str,
    record: Record,
    signals: tuple[str, ...],
    effects: Mapping[str, Mapping[str, float]] | None = None,
) -> NDArray[np.float64]:
    """One row per row of the record. `effects`: what the model adds to the nominal machine. `folder` names errors."""
    if len(record) < 2:
        raise InputError(folder, name, f"{len(record)} rows", "at least 2 rows", "record longer")
    simulation = Simulation("float")
    try:
        _configure(simulation, _Meta(folder, meta), name, record, effects or {})
        simulation.start()
        simulation.record(signals)
    except NativeError as error:
        raise InputError(folder, name, str(error), "a drive that can be simulated", HINT) from None
    rate_hz = 1.0 / float(np.median(np.diff(record["t_s"])))
    decimate = max(1, round(float(meta["pwm_hz"]) / rate_hz))
    return simulation.run(len(record) * decimate, decimate)


class _Meta:
    """meta.json with errors that name the key."""

    def __init__(self, folder: Path, content: Mapping[str, Any]) -> None:
        self.folder, self.content = folder, content

    def number(self, *path: str) -> float:
        value: Any = self.content
        for key in path:
            value = value.get(key, MISSING) if isinstance(value, Mapping) else MISSING
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise InputError(self.folder / META, ".".join(path), value, "a finite number", HINT)
        return float(value)


def _configure(
    simulation: Simulation, meta: _Meta, name: str, record: Record, effects: Mapping[str, Mapping[str, float]]
) -> None:
    locked = name in LOCKED
    counts = meta.number("encoder", "counts_per_rev")
    for key in ("pole_pairs", "resistance_ohm", "ld_h", "lq_h", "psi_wb", "inertia_kgm2", "viscous_nms"):
        simulation.set_model(key, meta.number("motor", key))
    for key in ("dc_link_v", "pwm_hz", "current_lsb_a"):
        simulation.set_model(key, meta.number(key))
    simulation.set_model("counts_per_rev", counts)
    simulation.set_model("current_range_a", NO_LIMIT)
    simulation.set_model("rotor_locked", float(locked))
    # the encoder cuts to whole counts: the true start angle is half a count larger on average
    start_rad = float(record["theta_m_rad"][0]) + (math.pi / counts if counts > 0.0 else 0.0)
    simulation.set_model("initial_angle_rad", start_rad)
    for key, value in _drive(meta, counts).items():
        simulation.set_param(key, value)
    for effect, params in effects.items():
        for param, value in params.items():
            simulation.set_effect(effect, param, value)
    t_s = record["t_s"] - record["t_s"][0]
    simulation.set_input("control_mode", (0.0,), (0.0 if locked else 1.0,))
    simulation.set_input("id_ref_a", t_s, record["id_ref_a"])
    if locked:
        simulation.set_input("iq_ref_a", t_s, record["iq_ref_a"])
    else:
        simulation.set_input("speed_ref_rad_s", t_s, record["speed_ref_rad_s"])
        simulation.set_input("load_torque_nm", t_s, np.nan_to_num(record["load_torque_nm"]))


def _drive(meta: _Meta, counts: float) -> dict[str, float]:
    """The controller that the format describes, with the numbers of this drive."""
    return {
        "pole_pairs": meta.number("motor", "pole_pairs"),
        "encoder_counts": counts if counts > 0.0 else 65536.0,
        "current_kp_v_per_a": meta.number("current_loop", "kp_v_per_a"),
        "current_ki_v_per_as": meta.number("current_loop", "ki_v_per_as"),
        "angle_advance_periods": meta.number("current_loop", "angle_advance_periods"),
        "speed_source": 0.0,
        "pll_kp_per_s": meta.number("speed_filter", "kp"),
        "pll_ki_per_s2": meta.number("speed_filter", "ki"),
        "speed_divider": round(meta.number("speed_loop", "ts_s") * meta.number("pwm_hz")),
        "speed_inline": 1.0,
        "speed_error_gain": 1.0,
        "speed_kp_a_per_unit": meta.number("speed_loop", "kp_a_per_rad_s"),
        "speed_ki_a_per_unit_s": meta.number("speed_loop", "ki_a_per_rad"),
        "iq_limit_a": meta.number("speed_loop", "iq_limit_a"),
        "id_limit_a": NO_LIMIT,
        "over_current_a": NO_LIMIT,
        "over_voltage_v": NO_LIMIT,
        "under_voltage_v": 0.0,
        "over_speed_rad_s": 2000.0,
        "offset_calibration_periods": 0.0,
        "align_periods": 0.0,
        "auto_run": 1.0,
    }
