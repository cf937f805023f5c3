"""The recorded drive in closed loop, on this project's simulator, in ampere equivalents.

The machine has a torque constant of 1 N m/A, so that torques in N m are amperes of q current. Its electrical side is a
stand-in, stiff enough that the back-EMF does not move the current. The speed controller is that of the recorded drive
(a gain, and the delays that the log shows), which acts through the current references of the simulated drive.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.controller import Controller, Part
from evenspin.balance.nominal_model import LINES, Line
from evenspin.balance.time_grid import Grid
from evenspin.native.simulation import Simulation
from evenspin.sim.progress import Bar

Array = NDArray[np.float64]

PWM_HZ = 10e3
POLE_PAIRS = 1
PSI_WB = 1.0 / (1.5 * POLE_PAIRS)  # 1.5 p psi = 1 N m/A
RESISTANCE_OHM, INDUCTANCE_H = 50.0, 50e-3
CURRENT_LOOP_RAD_S = 2.0 * np.pi * 800.0
CURRENT_LOOP_S = 0.2e-3  # from a current reference to the middle of its answer, with these gains (a test measures it)
DC_LINK_V = 900.0
ENCODER_COUNTS = 65536
STEP = 2  # PWM periods between two current references
ESTIMATE_S = 2e-3  # width of the mean by which the speed estimate is represented; the rest of its delay is plain delay
LONGEST_S = 20.0
SETTLE_S = 1.0  # start of a part that is not compared
LIMIT = 3.0  # times the largest recorded current


@dataclass(frozen=True, slots=True)
class Plant:
    """The shaft, in ampere equivalents."""

    inertia_as2: float
    viscous_as: float
    coulomb_a: float
    load_a: float
    lines: tuple[Line, ...]


@dataclass(frozen=True, slots=True)
class Ripple:
    """Speed of the drive's estimate, measured and simulated, over the same part; rms about the mean."""

    part: Part
    t_s: Array
    measured_rad_s: Array
    simulated_rad_s: Array
    without_rad_s: Array  # simulated without the lines
    theta_measured_rad: Array
    theta_simulated_rad: Array
    orders: tuple[tuple[int, float, float], ...]  # (order, measured, simulated) amplitude, rad/s

    @property
    def measured_rms(self) -> float:
        return float(np.std(self.measured_rad_s))

    @property
    def simulated_rms(self) -> float:
        return float(np.std(self.simulated_rad_s))

    @property
    def without_rms(self) -> float:
        return float(np.std(self.without_rad_s))


def compare_ripple(
    grid: Grid,
    controller: Controller,
    part: Part,
    plant: Plant,
    estimate_s: float,
    current_later_s: float,
    bar: Bar | None = None,
) -> Ripple:
    """`estimate_s`: how old the speed estimate is; `current_later_s`: how much the logged current lags the torque."""
    rows = np.flatnonzero((grid.t_s >= part.start_s) & (grid.t_s < min(part.end_s, part.start_s + LONGEST_S)))
    settled = np.searchsorted(grid.t_s[rows], part.start_s + SETTLE_S)
    bare = Plant(plant.inertia_as2, plant.viscous_as, plant.coulomb_a, plant.load_a, ())
    runs = []
    for each in (plant, bare):
        runs.append(_simulate(grid, controller, rows, each, estimate_s, current_later_s))
        if bar is not None:
            bar.update(0.6 + 0.15 * len(runs))
    kept = rows[settled:]
    theta = grid.column("theta_m_rad")[kept]
    measured = grid.column("speed_rad_s")[kept]
    (sim_theta, sim_speed), (_, without) = ((a[settled:], b[settled:]) for a, b in runs)
    orders = tuple(
        (int(line.order), _amplitude(measured, theta, line.order), _amplitude(sim_speed, sim_theta, line.order))
        for line in plant.lines
    )
    return Ripple(part, grid.t_s[kept], measured, sim_speed, without, theta, sim_theta, orders)


def _amplitude(speed: Array, theta: Array, order: float) -> float:
    columns = np.column_stack((np.ones_like(theta), np.sin(order * theta), np.cos(order * theta)))
    found = np.linalg.lstsq(columns, speed, rcond=None)[0]
    return float(np.hypot(found[1], found[2]))


def _simulate(
    grid: Grid, controller: Controller, rows: NDArray[np.int64], plant: Plant, estimate_s: float, current_later_s: float
) -> tuple[Array, Array]:
    """Angle and speed estimate on the rows of the grid."""
    dt = STEP / PWM_HZ
    count = int(np.ceil(len(rows) * grid.period_s / dt)) + 1
    start = rows[0]
    reference = np.interp(grid.t_s[start] + dt * np.arange(count), grid.t_s, grid.column("speed_ref_rad_s"))
    speed0 = float(np.mean(grid.column("speed_rad_s")[start : start + 20]))
    theta0 = float(grid.column("theta_m_rad")[start])
    limit_a = LIMIT * float(np.max(np.abs(grid.column("iq_a"))))
    simulation = _prepare(plant, theta0, speed0)
    width = max(1, round(min(ESTIMATE_S, max(2.0 * estimate_s, dt)) / dt))
    plain_s = max(estimate_s - 0.5 * width * dt, 0.0)  # of the estimate, beyond what its mean delays
    # Beyond the estimate: what the log shows from speed to torque, less what the simulated drive has anyway. A
    # reference
    # is set one period after its sample and is held for a step.
    transport_s = max(controller.lag_s - current_later_s - CURRENT_LOOP_S - 1.0 / PWM_HZ - 0.5 * dt, 0.0)
    behind = (plain_s + transport_s) / dt
    whole, share = int(behind), behind - int(behind)
    theta = np.empty(count)
    estimate = np.full(count + whole + 2, speed0)  # shifted by whole + 1, so that the past of the start is there
    for k in range(count):
        simulation.run(STEP, STEP)
        theta[k] = simulation.read("true_theta_m_rad")
        now = k + whole + 1
        estimate[now] = (theta[k] - theta[k - width]) / (width * dt) if k >= width else speed0
        seen = (1.0 - share) * estimate[now - whole] + share * estimate[now - whole - 1]
        iq_ref = controller.gain_as_per_rad * (reference[k] - seen) + controller.offset_a
        simulation.set_input("iq_ref_a", (0.0,), (float(np.clip(iq_ref, -limit_a, limit_a)),))
    made_s = dt * (1.0 + np.arange(count)) - 1.0 / PWM_HZ
    wanted_s = grid.period_s * np.arange(len(rows))
    speed = np.interp(wanted_s - plain_s, made_s, estimate[whole + 1 : whole + 1 + count])
    return np.interp(wanted_s, made_s, theta), speed


def _prepare(plant: Plant, theta0_rad: float, speed0_rad_s: float) -> Simulation:
    simulation = Simulation("float")
    # The simulated angle starts within a turn; whole turns make no difference to lines of whole order.
    model = {
        "pole_pairs": POLE_PAIRS,
        "resistance_ohm": RESISTANCE_OHM,
        "ld_h": INDUCTANCE_H,
        "lq_h": INDUCTANCE_H,
        "psi_wb": PSI_WB,
        "inertia_kgm2": plant.inertia_as2,
        "viscous_nms": max(plant.viscous_as, 0.0),
        "dc_link_v": DC_LINK_V,
        "pwm_hz": PWM_HZ,
        "counts_per_rev": ENCODER_COUNTS,
        "current_range_a": 1e3,
        "initial_angle_rad": float(np.remainder(theta0_rad, 2.0 * np.pi)),
        "initial_speed_rad_s": speed0_rad_s,
    }
    drive = {
        "pole_pairs": POLE_PAIRS,
        "encoder_counts": ENCODER_COUNTS,
        "current_kp_v_per_a": CURRENT_LOOP_RAD_S * INDUCTANCE_H,
        "current_ki_v_per_as": CURRENT_LOOP_RAD_S * RESISTANCE_OHM,
        "iq_limit_a": 1e3,
        "id_limit_a": 1e3,
        "over_current_a": 1e3,
        "over_voltage_v": 1e3,
        "under_voltage_v": 0.0,
        "over_speed_rad_s": 2e3,
        "offset_calibration_periods": 0,
        "align_periods": 0,
        "plausibility_share": 0.0,  # this current loop stands for any, and its motor for none
        "auto_run": 1,
    }
    for name, value in model.items():
        simulation.set_model(name, value)
    for name, value in drive.items():
        simulation.set_param(name, value)
    if plant.coulomb_a > 0.0:
        simulation.set_effect("coulomb_friction", "torque_nm", plant.coulomb_a)
    if plant.load_a != 0.0:
        simulation.set_effect("load_torque", "torque_nm", plant.load_a)
    for i, line in enumerate(_six(plant.lines), 1):
        simulation.set_effect("torque_ripple", f"order_{i}", line.order)
        simulation.set_effect("torque_ripple", f"amplitude_{i}_nm", line.amplitude_a)
        simulation.set_effect("torque_ripple", f"phase_{i}_rad", line.phase_rad)
    simulation.set_input("control_mode", (0.0,), (0.0,))
    simulation.record(("t_s",))
    simulation.start()
    return simulation


def _six(lines: Sequence[Line]) -> list[Line]:
    """The strongest, as many as the effect has room for."""
    return sorted(lines, key=lambda line: -line.amplitude_a)[:LINES]
