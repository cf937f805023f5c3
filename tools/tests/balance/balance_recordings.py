"""Logs to test with: real ones, and ones that the project's simulator writes in ampere equivalents (1 N m/A)."""

from __future__ import annotations

import gzip
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from evenspin.native.simulation import Simulation

REAL = Path(__file__).resolve().parents[3] / "tests" / "data" / "laas_servo"

INERTIA_AS2, VISCOUS_AS = 2e-4, 3e-4
NOISE_A, LSB_A = 5e-3, 1.0 / 1024.0
ROW_HZ, PWM_HZ = 1000, 10_000
Effects = Mapping[str, Mapping[str, float]]
COLUMNS = ("t_s", "theta_m_rad", "speed_rad_s", "iq_a")


def drive(effects: Effects, seed: int, speed_kp_as: float = 0.02) -> Simulation:
    simulation = Simulation("float")
    model = {
        "pole_pairs": 1, "resistance_ohm": 50.0, "ld_h": 0.05, "lq_h": 0.05, "psi_wb": 2.0 / 3.0,
        "inertia_kgm2": INERTIA_AS2, "viscous_nms": VISCOUS_AS, "dc_link_v": 900.0, "counts_per_rev": 20000,
        "current_noise_a": NOISE_A, "current_lsb_a": LSB_A, "current_range_a": 100.0, "initial_angle_rad": 1.0,
    }  # fmt: skip
    params = {
        "pole_pairs": 1, "encoder_counts": 20000, "current_kp_v_per_a": 250.0, "current_ki_v_per_as": 250e3,
        "speed_source": 0, "speed_error_gain": 1.0, "speed_kp_a_per_unit": speed_kp_as, "speed_ki_a_per_unit_s": 0.0,
        "iq_limit_a": 10.0, "id_limit_a": 100.0, "over_current_a": 100.0, "over_voltage_v": 1000.0,
        "under_voltage_v": 0.0, "over_speed_rad_s": 2000.0, "offset_calibration_periods": 0,
        "align_periods": 0, "auto_run": 1, "plausibility_share": 0.0,
    }  # fmt: skip
    for key, value in model.items():
        simulation.set_model(key, value)
    for key, value in params.items():
        simulation.set_param(key, value)
    for effect, values in effects.items():
        for key, value in values.items():
            simulation.set_effect(effect, key, value)
    simulation.set_seed(seed)
    return simulation


def rows_of(simulation: Simulation, names: tuple[str, ...], duration_s: float) -> dict[str, np.ndarray]:
    simulation.record(names)
    simulation.start()
    values = simulation.run(round(duration_s * PWM_HZ), PWM_HZ // ROW_HZ)
    return {name: values[:, i].copy() for i, name in enumerate(names)}


def sweep(effects: Effects, duration_s: float = 10.0, seed: int = 1) -> dict[str, np.ndarray]:
    """Free motor, current 0.4 A at 2 Hz, as in the real log acc_current."""
    simulation = drive(effects, seed)
    t_s = np.arange(0.0, duration_s, 1e-3)
    simulation.set_input("control_mode", (0.0,), (0.0,))
    simulation.set_input("iq_ref_a", t_s, 0.4 * np.sin(4.0 * np.pi * t_s), linear=True)
    return rows_of(simulation, COLUMNS, duration_s)


def level(
    effects: Effects, speed_rad_s: float = 6.28, duration_s: float = 10.0, seed: int = 1
) -> dict[str, np.ndarray]:
    """Proportional speed control at one speed."""
    simulation = drive(effects, seed)
    simulation.set_input("control_mode", (0.0,), (1.0,))
    simulation.set_input("speed_ref_rad_s", (0.0,), (speed_rad_s,))
    return rows_of(simulation, (*COLUMNS, "speed_ref_rad_s"), duration_s)


def write(path: Path, columns: Mapping[str, np.ndarray]) -> Path:
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, fmt="%.6f", delimiter=",", header=",".join(columns), comments="")
    return path


def read(path: Path) -> dict[str, np.ndarray]:
    """Columns of a real log."""
    with gzip.open(path, "rt") as file:
        names = file.readline().strip().split(",")
        values = np.loadtxt(file, delimiter=",")
    return {name: values[:, i] for i, name in enumerate(names)}
