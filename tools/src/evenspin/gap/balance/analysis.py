"""From a log to everything that a torque balance can tell of it, step by step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from evenspin.gap.balance.angle_orders import (
    HIGHEST,
    SIGMA_ROWS,
    SIGMA_S,
    TURN,
    AngleResult,
    OrderBank,
    current_lag,
    weigh_orders,
)
from evenspin.gap.balance.controller import Controller, find_controller
from evenspin.gap.balance.friction import SIGMA_S as FRICTION_SIGMA_S
from evenspin.gap.balance.friction import FrictionResult, weigh_friction
from evenspin.gap.balance.grid import Grid, Smoother, grid_of
from evenspin.gap.balance.motion import Lag, motion_of, speed_lag
from evenspin.gap.balance.nominal import Nominal
from evenspin.gap.balance.reading import Log
from evenspin.gap.balance.ripple import Plant, Ripple, compare_ripple
from evenspin.gap.balance.windings import Winding, suggest
from evenspin.sim.progress import Bar

SLOW_S = 0.05  # smoothing that leaves the course of the speed and takes its ripple
SWEEP = 0.5  # of the highest speed: a log whose speed covers more tells speed-dependent friction
SURE = 0.3  # of J/Kt: an inertia known worse is no inertia
ASSUMED_LAG_S = 2e-3  # of a speed estimate whose lag the log does not tell; 0 to twice this is allowed for
ALIGNMENT_ROWS = 0.5  # how far apart current and angle of one row may have been sampled


@dataclass(frozen=True, slots=True)
class Analysis:
    log: Log
    grid: Grid
    nominal: Nominal | None
    sweeps: bool
    lag: Lag
    current_later_s: float
    friction: FrictionResult | None
    alignment_half: dict[str, float]  # what half a row between current and angle does to the friction parameters
    angle: AngleResult | None
    inertia_known: bool
    lag_spread_a: dict[int, float]  # by order: what an unknown lag of the speed does to its amplitude
    windings: tuple[Winding, ...]
    controller: Controller | None
    ripple: Ripple | None


def analyse(log: Log, nominal: Nominal | None, bar: Bar | None = None) -> Analysis:
    def done(share: float) -> None:
        if bar is not None:
            bar.update(share)

    grid = grid_of(log)
    lag = speed_lag(log, grid)
    done(0.05)
    sweeps = _sweeps(grid)
    friction, alignment = _friction(grid, lag, nominal) if sweeps else (None, {})
    done(0.2)
    angle, later_s, spread = _angle(grid, lag, nominal, friction)
    done(0.55)
    controller = find_controller(grid)
    known = angle is not None and angle.inertia_known and angle.inertia_half_as2 < SURE * angle.inertia_as2
    windings: tuple[Winding, ...] = ()
    if angle is not None:
        lines = [(int(each.line.order), each.line.amplitude_a) for each in angle.lines if each.validated]
        windings = tuple(suggest(lines, angle.highest, nominal.pole_pairs if nominal is not None else None))
    ripple = None
    if controller is not None and controller.plain and angle is not None and known:
        part = max(controller.plain, key=lambda p: p.end_s - p.start_s)
        ripple = compare_ripple(grid, controller, part, plant_of(angle, friction, nominal), lag.delay_s, later_s, bar)
    done(0.9)
    return Analysis(
        log,
        grid,
        nominal,
        sweeps,
        lag,
        later_s,
        friction,
        alignment,
        angle,
        known,
        spread,
        windings,
        controller,
        ripple,
    )


def _sweeps(grid: Grid) -> bool:
    smooth = Smoother(SLOW_S, grid.period_s)
    if "speed_rad_s" in grid.columns:
        slow = smooth(grid.column("speed_rad_s"))
    else:
        slow = smooth.rate(grid.column("theta_m_rad"))
    slow = slow[grid.good(smooth.half * grid.period_s)]
    if len(slow) == 0:
        return False
    low, high = np.quantile(slow, (0.05, 0.95))
    return bool(high - low > SWEEP * max(abs(low), abs(high)))


def _friction(grid: Grid, lag: Lag, nominal: Nominal | None) -> tuple[FrictionResult, dict[str, float]]:
    shift_s = ALIGNMENT_ROWS * grid.period_s
    if "speed_rad_s" in grid.columns and not lag.known:
        lag, shift_s = replace(lag, delay_s=ASSUMED_LAG_S), ASSUMED_LAG_S
    found = weigh_friction(motion_of(grid, FRICTION_SIGMA_S, lag), nominal)
    half = dict.fromkeys(found.final.names, 0.0)
    for side in (-1.0, 1.0):
        moved = motion_of(grid, FRICTION_SIGMA_S, lag, side * shift_s)
        other = weigh_friction(moved, nominal)
        for name in half:
            if name in other.final.names:
                half[name] = max(half[name], abs(other.final[name] - found.final[name]))
    return found, half


def _angle(
    grid: Grid, lag: Lag, nominal: Nominal | None, friction: FrictionResult | None
) -> tuple[AngleResult | None, float, dict[int, float]]:
    if "theta_m_rad" not in grid.columns:
        return None, 0.0, {}
    used = lag
    guess = "speed_rad_s" in grid.columns and not lag.known
    if guess:
        used = replace(lag, delay_s=ASSUMED_LAG_S)
    sigma_s = _angle_sigma(grid, friction)
    inertia = None
    if friction is not None and nominal is None:
        name = "inertia.inertia_as2_per_rad"
        inertia = (friction.final[name], friction.final.half(name))
    motion = motion_of(grid, sigma_s, used)
    bank = OrderBank(motion)
    found = weigh_orders(motion, nominal, inertia, bank)
    if found is None:
        return None, 0.0, {}
    later_s = current_lag(grid, motion, nominal, found, bank)
    if later_s != 0.0:
        found = weigh_orders(motion_of(grid, sigma_s, used, later_s), nominal, inertia, bank)
    spread: dict[int, float] = {}
    if guess and found is not None:
        for delay_s in (0.0, 2.0 * ASSUMED_LAG_S):
            other = weigh_orders(motion_of(grid, sigma_s, replace(lag, delay_s=delay_s)), nominal, inertia, bank)
            amplitude = {int(each.line.order): each.line.amplitude_a for each in other.lines} if other else {}
            for each in found.lines:
                k, a = int(each.line.order), each.line.amplitude_a
                spread[k] = max(spread.get(k, 0.0), abs(amplitude.get(k, 0.0) - a))
    return found, later_s, spread


def _angle_sigma(grid: Grid, friction: FrictionResult | None) -> float:
    """Short enough for the highest order at the usual speed; a log that sweeps is judged where it is slow."""
    if friction is not None:
        return max(SIGMA_S, SIGMA_ROWS * grid.period_s)
    if "speed_rad_s" in grid.columns:
        speed = grid.column("speed_rad_s")
    else:
        speed = Smoother(SIGMA_S, grid.period_s).rate(grid.column("theta_m_rad"))
    usual = float(np.median(np.abs(speed)))
    highest_hz = 1.6 * HIGHEST * usual / TURN
    sigma_s = np.sqrt(7.0) / (TURN * max(highest_hz, 1e-6))
    return float(np.clip(sigma_s, SIGMA_ROWS * grid.period_s, SIGMA_S))


def plant_of(angle: AngleResult, friction: FrictionResult | None, nominal: Nominal | None) -> Plant:
    """What the simulation is made of: the model where there is one, otherwise what this log says."""
    lines = tuple(each.line for each in angle.lines if each.validated)
    if nominal is not None:
        return Plant(
            nominal.inertia_as2,
            nominal.viscous_as,
            nominal.coulomb_a + max(angle.drag_a, -nominal.coulomb_a),
            nominal.load_a,
            lines,
        )
    return Plant(angle.inertia_as2, 0.0, max(angle.drag_a, 0.0), 0.0, lines)
