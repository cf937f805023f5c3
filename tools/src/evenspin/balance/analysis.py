"""From a log to everything that a torque balance can identify in it, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from evenspin.balance.angle_balance import Inertia, Setting
from evenspin.balance.angle_orders import (
    ALIGNMENT_ROWS,
    SIGMA_ROWS,
    SIGMA_S,
    AngleResult,
    best_sigma,
    current_lag,
    find_angle_orders,
)
from evenspin.balance.controller import Controller, find_controller
from evenspin.balance.friction import FrictionResult, select_friction
from evenspin.balance.line_search import HIGHEST, TURN, Views
from evenspin.balance.log_reader import Log
from evenspin.balance.motion import Lag, angle_jitters, motion_of, speed_lag
from evenspin.balance.nominal_model import Nominal
from evenspin.balance.other_columns import OtherColumns
from evenspin.balance.ripple_simulation import Plant, Ripple, compare_ripple
from evenspin.balance.shaft_regression import INERTIA, VISCOUS, Drive, drive_of
from evenspin.balance.stretches import Stretches, stretches_of
from evenspin.balance.time_grid import SHAFT, Grid, grid_of
from evenspin.balance.windings import Winding, suggest
from evenspin.sim.progress import Bar

FIRST_SIGMA_S = 10e-3
KNOWN = 0.3  # half width over J/Kt, above which an inertia counts as unknown
MODEL_TOLERANCE = 0.032  # of the model's inertia over its flux: the spread of healthy units
ASSUMED_LAG_S = 2e-3  # of a speed estimate whose lag the log does not show; intervals include 0 to twice this
ROUNDS = 3
WIDER_S = (1.25e-3, 2.5e-3, 5e-3, 10e-3)  # of the smoothing for lines


@dataclass(frozen=True, slots=True)
class Analysis:
    log: Log
    grid: Grid
    nominal: Nominal | None
    stretches: Stretches
    drive: Drive
    lag: Lag
    lag_assumed: bool  # the motion is that of the logged speed, whose delay the log does not show
    current_later_s: float
    friction: FrictionResult | None
    angle: AngleResult | None
    thresholds_a: Mapping[int, float]  # of each order that the log resolves: a smaller line is not detected
    inertia: Inertia | None  # None: neither the log nor a model gives it
    windings: tuple[Winding, ...]
    controller: Controller | None
    ripple: Ripple | None

    @property
    def sweeps(self) -> bool:
        return self.drive.sweeps

    @property
    def judges(self) -> bool:
        """Some effect could have been named. At one speed, without angle and model, none could."""
        friction = self.friction is not None and (self.nominal is not None or not self.drive.one_speed)
        return self.angle is not None or friction

    @property
    def inertia_known(self) -> bool:
        return self.inertia is not None


def analyse(
    log: Log, nominal: Nominal | None, bar: Bar | None = None, other_columns: OtherColumns | None = None
) -> Analysis:
    def done(share: float) -> None:
        if bar is not None:
            bar.update(share)

    grid = grid_of(log)
    if other_columns is not None and other_columns.load_a is not None:
        load_a = np.interp(grid.t_s, other_columns.t_s, other_columns.load_a)
        grid.columns[SHAFT] = grid.column("iq_a") - load_a
    lag = speed_lag(log, grid)
    alone = "theta_m_rad" not in grid.columns
    by_speed = angle_jitters(grid)
    assumed = by_speed and not lag.known
    used = replace(lag, delay_s=ASSUMED_LAG_S) if assumed else lag
    shift_s = ASSUMED_LAG_S if assumed else ALIGNMENT_ROWS * grid.period_s
    views = Views(lambda sigma_s, later_s: motion_of(grid, sigma_s, used, later_s, by_speed=by_speed))
    done(0.05)
    stretches = stretches_of(grid)
    drive = drive_of(views(FIRST_SIGMA_S, 0.0), stretches)
    # The inertia first, since a drive that hardly answers its cogging shows it in the acceleration alone; then the
    # lines, with which the inertia is found again.
    friction = select_friction(views, nominal, drive, [], stretches, shift_s)
    inertia = _inertia(friction, nominal)
    angle: AngleResult | None = None
    sigma_s = 0.0
    thresholds_a: dict[int, float] = {}
    done(0.1)
    if not alone:
        setting = Setting(nominal, drive, stretches, inertia, shift_s, friction)
        sigma_s, thresholds_a = best_sigma(views, _sigmas(grid, stretches), setting)
        angle = find_angle_orders(views, sigma_s, setting)
    orders: list[float] = []
    for number in range(ROUNDS):
        done(0.25 + 0.1 * number)
        found = _orders(angle)
        if set(found) == set(orders):
            break
        orders = found
        friction = select_friction(views, nominal, drive, orders, stretches, shift_s)
        inertia = _inertia(friction, nominal)
        angle = find_angle_orders(views, sigma_s, Setting(nominal, drive, stretches, inertia, shift_s, friction))
    later_s = 0.0
    setting = Setting(nominal, drive, stretches, inertia, shift_s, friction)
    if angle is not None:
        later_s = current_lag(grid, angle, setting)
        if later_s != 0.0:
            angle = find_angle_orders(views, sigma_s, setting, later_s)
    done(0.55)
    controller = find_controller(grid)
    windings: tuple[Winding, ...] = ()
    if angle is not None:
        lines = [(int(each.line.order), each.line.amplitude_a) for each in angle.lines if each.validated]
        windings = tuple(suggest(lines, angle.highest, nominal.pole_pairs if nominal is not None else None))
    ripple = None
    if controller is not None and controller.plain and angle is not None and inertia is not None:
        part = max(controller.plain, key=lambda p: p.end_s - p.start_s)
        ripple = compare_ripple(grid, controller, part, plant_of(angle, friction, nominal), lag.delay_s, later_s, bar)
    done(0.9)
    return Analysis(
        log,
        grid,
        nominal,
        stretches,
        drive,
        used,
        assumed,
        later_s,
        friction,
        angle,
        thresholds_a,
        inertia,
        windings,
        controller,
        ripple,
    )


def _orders(angle: AngleResult | None) -> list[float]:
    """Lines that the shaft is fitted with."""
    if angle is None:
        return []
    return [each.line.order for each in angle.lines] + [order for order, _ in angle.fractional]


def _inertia_of_model(nominal: Nominal | None) -> Inertia | None:
    if nominal is None or not nominal.inertia_as2 > 0.0:
        return None
    return Inertia(nominal.inertia_as2, MODEL_TOLERANCE * nominal.inertia_as2)


def _inertia(friction: FrictionResult | None, nominal: Nominal | None) -> Inertia | None:
    """That of the model, unless the log contradicts it; without a model, that of the log where it is identifiable."""
    of_model = _inertia_of_model(nominal)
    if friction is None:
        return of_model
    if of_model is not None and friction.drive.one_speed:  # nothing but ripple accelerates the shaft
        return of_model
    value = friction.final[INERTIA] + (of_model.value_as2 if of_model is not None else 0.0)
    found = Inertia(value, friction.half[INERTIA])
    if not found.half_as2 < KNOWN * value:
        return of_model
    if of_model is None or abs(value - of_model.value_as2) > found.half_as2 + of_model.half_as2:
        return found
    return of_model


def _sigmas(grid: Grid, stretches: Stretches) -> list[float]:
    """Widths of smoothing for lines; the first is short enough for the highest order at the median speed."""
    median = float(np.median(np.abs(stretches.slow_rad_s[~stretches.idle])))
    highest_hz = 1.6 * HIGHEST * median / TURN
    least_s = SIGMA_ROWS * grid.period_s
    short_s = float(np.clip(np.sqrt(7.0) / (TURN * max(highest_hz, 1e-6)), least_s, max(SIGMA_S, least_s)))
    return [short_s, *(each for each in WIDER_S if each > 1.2 * short_s)]


def plant_of(angle: AngleResult, friction: FrictionResult | None, nominal: Nominal | None) -> Plant:
    """What the simulation is made of: the model with what this log shows beyond it."""
    lines = tuple(each.line for each in angle.lines if each.validated)
    viscous, coulomb, load = (0.0, 0.0, 0.0)
    if nominal is not None:
        viscous, coulomb, load = nominal.viscous_as, nominal.coulomb_a, nominal.load_a
    values = dict(zip(friction.final.names, friction.final.value, strict=True)) if friction is not None else {}
    viscous += values.get(VISCOUS, 0.0)
    load += values.get("load_torque.torque_a_equiv", 0.0)
    dry = next((float(v) for name, v in values.items() if name.startswith("coulomb_friction")), 0.0)
    if friction is not None and friction.drive.one_speed:
        dry = angle.drag_a
    return Plant(angle.inertia_as2, max(float(viscous), 0.0), max(coulomb + dry, 0.0), float(load), lines)
