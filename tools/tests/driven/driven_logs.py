"""Logs of the servo motor of 0.7 kW from the simulated drive, as another tool would have recorded them."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
from evenspin.log import write_csv
from evenspin.model.machine import find_model, load_machine
from evenspin.model.setup import InputCurve, Setup
from evenspin.native import tables
from evenspin.sim import simulate

COLUMNS = ("t_s", "theta_m_rad", "id_a", "iq_a", "vd_v", "vq_v", "vdc_v", "load_torque_nm")
SPEEDS_RAD_S = (4.0, 30.0, 70.0, 12.0, -6.0, -50.0, -20.0, -3.0, 60.0, -70.0)
STEP_S = 1.0
RAMP_S = 0.15
LOADS_NM = (0.0, 0.9, -0.7, 0.3, 0.0)
# Drives of other makes do not notice what is hidden in them.
QUIET = {"offset_calibration_periods": 0.0, "align_periods": 0.0, "auto_run": 1.0, "plausibility_share": 0.0}


@functools.cache
def columns_of(
    effects: tuple[tuple[str, tuple[tuple[str, float], ...]], ...] = (),
    seed: int = 1,
    speeds: tuple[float, ...] = SPEEDS_RAD_S,
) -> dict[str, np.ndarray]:
    """Seconds at speeds in both directions, under load steps; the effects are hidden. At one speed, without load."""
    machine = load_machine(find_model("servo", Path(), lambda must, hint: AssertionError(must)))
    drive = {name: field.default for name, field in tables().params.items()} | dict(machine.drive) | QUIET
    start = STEP_S * np.arange(len(speeds))
    times = np.column_stack((start, start + RAMP_S)).ravel()
    before = (speeds[0] if len(set(speeds)) == 1 else 0.0, *speeds[:-1])
    values = np.column_stack((before, speeds)).ravel()
    loads_s = 0.5 + 1.7 * np.arange(len(LOADS_NM) + 1)
    inputs = {
        "speed_ref_rad_s": InputCurve(tuple(times), tuple(values), linear=True),
        "load_torque_nm": InputCurve((0.0, *loads_s), (0.0, *LOADS_NM, 0.6), linear=False),
    }
    if len(set(speeds)) == 1:
        del inputs["load_torque_nm"]
    hidden = {name: dict(params) for name, params in effects}
    duration_s = STEP_S * len(speeds)
    setup = Setup("servo", machine.plant, drive, hidden, inputs, (), duration_s, 2000.0, seed)
    record = simulate(setup, (*COLUMNS, "fault"))
    assert not record["fault"].any()
    return {name: np.asarray(record[name]) for name in COLUMNS}


def hide(seed: int = 1, **effects: dict[str, float]) -> dict[str, np.ndarray]:
    return columns_of(tuple((name, tuple(params.items())) for name, params in effects.items()), seed)


def write_log(path: Path, columns: dict[str, np.ndarray]) -> Path:
    write_csv(path, list(columns), np.column_stack(list(columns.values())))
    return path
