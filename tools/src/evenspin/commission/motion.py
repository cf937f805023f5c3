"""The steps in which the shaft turns: flux, electrical zero, inertia, friction, encoder counts."""

from __future__ import annotations

import math

import numpy as np

from evenspin.bench.errors import DriveFaultError, RefusedError
from evenspin.commission.findings import Quality, Step, sure
from evenspin.commission.fits import edges, flux, mechanics
from evenspin.commission.signals import currents, need_rest, run_currents, until
from evenspin.commission.steps import SURE_J, SURE_L, SURE_PSI, Bench
from evenspin.commission.windings import scatter, window_of
from evenspin.identify.estimate import Estimate

RATE_HZ = 1000.0
SIGNALS = ("theta_m_rad", "iq_a", "id_a", "vd_v", "vq_v", "speed_rad_s", "ia_a", "ib_a")
THETA, IQ, ID, VD, VQ, SPEED, IA, IB = range(8)
VOLTAGE_PART = 0.35  # of the longest voltage vector: how fast it may get
ACCELERATE_S = 0.7  # that a run-up should take
MOST_PART = 0.6  # of the largest current
LEAST_PART = 0.025
COAST_S = 0.5
WINDOW_PART = 0.12
COUNTS_PART = 8e-3  # that a ratio of speeds is good for
ZERO_LIMIT_RAD = 0.035  # 2 degrees: a torque loss of 0.06 %
SETTLE_ROWS, BEND_ROWS, FLUX_ROWS = 10, 5, 16
CYCLES_S, MOST_CYCLES = 14.0, 30  # how long the shaft is moved to and fro


def spin(bench: Bench) -> Step:
    """Up, coast, down through standstill, coast, up again: at constant currents, both ways."""
    since, drive, known = bench.clock, bench.drive, bench.known
    bench.set(speed_source=float(drive.parameters["speed_source"].choices.index("mt")))
    taken, current = _motion(bench)
    taken, current = _counts(bench, taken, current)
    theta = np.unwrap(taken[:, THETA])
    speed = np.convolve(np.gradient(theta) * RATE_HZ, np.ones(5) / 5.0, "same")
    fast = (np.abs(speed) > 0.15 * np.abs(speed).max()) & _settled(taken[:, IQ], SETTLE_ROWS)
    found = flux(known.pole_pairs * theta, taken[:, ID], taken[:, IQ], taken[:, VD], taken[:, VQ], fast, RATE_HZ,
                 FLUX_ROWS, known.ld.value)  # fmt: skip
    known.psi = found.psi_wb
    turns_v = known.pole_pairs * known.psi.value
    known.lq = scatter(
        [edges(each, bench.period_s, window_of(known), known.resistance.value, turns_v)[0] for each in bench.switched]
    )
    runs = 2 * int(np.count_nonzero(np.diff(np.sign(speed[np.abs(speed) > 0.3 * np.abs(speed).max()])))) + 2
    window = int(
        max(8, min(60, WINDOW_PART * len(theta) / runs))
    )  # short beside a run-up: where the speed bends counts less
    shaft = mechanics(theta, taken[:, IQ], RATE_HZ, window, _settled(taken[:, IQ], BEND_ROWS))
    per_a = known.torque_per_a
    known.inertia = _scaled(shaft.inertia, per_a, known.psi)
    known.viscous = _scaled(shaft.viscous, per_a, known.psi)
    known.coulomb = _scaled(shaft.coulomb, per_a, known.psi)
    known.offset_rad = math.remainder(_zero(taken, theta, known.pole_pairs) - found.angle_rad.value, 2.0 * math.pi)
    accepted = bench.set(
        motor_psi_wb=known.psi.value, motor_lq_h=known.lq.value, observer_inertia_kgm2=max(known.inertia.value, 1e-9)
    )
    qualities = [
        *sure("flux linkage", known.psi, "Wb", SURE_PSI),
        Quality("electrical zero against the back-EMF", found.angle_rad.value, found.angle_rad.half, "rad electrical",
                -ZERO_LIMIT_RAD, ZERO_LIMIT_RAD),
        *sure("inductance of the q axis, with this flux", known.lq, "H", SURE_L),
        *sure("inertia", known.inertia, "kg m^2", SURE_J),
        Quality("Coulomb friction", known.coulomb.value, known.coulomb.half, "N m", -known.coulomb.half, 1e5),
        Quality("viscous friction", known.viscous.value, known.viscous.half, "N m s/rad", -known.viscous.half, 1e5),
        Quality("speed at which the back-EMF fills the dc link", known.base_rad_s, 0.0, "rad/s", 1.0, 1e5),
    ]  # fmt: skip
    notes = [f"{current:.3g} A up to {np.abs(speed).max():.4g} rad/s", f"encoder: {known.counts:g} counts per turn"]
    goal = "flux, electrical zero, inertia, friction, encoder counts"
    return bench.done("spin", goal, since, qualities, accepted, *notes)


def _scaled(per_ampere: Estimate, torque_per_a: float, psi: Estimate) -> Estimate:
    value = per_ampere.value * torque_per_a
    return Estimate(value, math.hypot(per_ampere.half * torque_per_a, value * psi.relative))


def _settled(iq_a: np.ndarray, apart: int) -> np.ndarray:
    """Rows that are so far from a change of the current."""
    keep = np.zeros(len(iq_a), dtype=bool)
    smooth = np.convolve(iq_a, np.ones(3) / 3.0, "same")
    near = np.abs(smooth[2 * apart :] - smooth[: -2 * apart]) < 0.2 * np.abs(smooth).max()
    keep[apart:-apart] = near
    return keep


def _motion(bench: Bench) -> tuple[np.ndarray, float]:
    """Rows of the whole motion, and the current that it was made with."""
    drive, known = bench.drive, bench.known
    limit_v = VOLTAGE_PART * known.supply_v / math.sqrt(3.0)
    top = 0.4 * known.over_speed_rad_s
    most = bench.bounds.max_current_a
    current, turned = 0.1 * most, 0.0
    need_rest(drive)
    for attempt in range(8):
        run_currents(drive)
        parts: list[np.ndarray] = []
        with drive.stream(SIGNALS, rate_hz=RATE_HZ) as stream:
            began = drive.link.transport.clock()

            def speed_of(recent: np.ndarray) -> float:
                theta = np.unwrap(recent[:, THETA])
                return float((theta[-1] - theta[0]) / (len(theta) - 1) * RATE_HZ)

            def fast(recent: np.ndarray, way: float) -> bool:
                emf = float(np.abs(recent[:, VQ] - known.resistance.value * recent[:, IQ]).mean())
                w = way * speed_of(recent)
                return w > top or (w > 0.0 and emf > limit_v)

            currents(drive, iq_a=current)
            reached = until(
                drive, stream, parts, lambda recent: fast(recent, 1.0), 1.5 if current < MOST_PART * most else 60.0
            )
            took = drive.link.transport.clock() - began
            slow = took >= 0.15 * ACCELERATE_S or current <= LEAST_PART * most or current == turned or attempt > 5
            if reached and slow:
                for _ in range(max(1, min(MOST_CYCLES, math.ceil(CYCLES_S / (4.0 * took + COAST_S))))):
                    _coast(bench, stream, parts)
                    currents(drive, iq_a=-current)
                    until(drive, stream, parts, lambda recent: fast(recent, -1.0))
                    _coast(bench, stream, parts)
                    currents(drive, iq_a=current)
                    until(drive, stream, parts, lambda recent: fast(recent, 1.0))
                currents(drive)
                lost = stream.lost_rows
                need_rest(drive)
                if lost:
                    raise DriveFaultError(f"spin: {lost} rows of the stream were lost; use a quieter machine")
                return np.concatenate(parts), current
        need_rest(drive)
        if reached:
            turned = current
            current = max(LEAST_PART * most, current * max(took / ACCELERATE_S, 0.1))
        elif turned:
            current = turned  # less does not overcome the friction
        else:
            taken = np.concatenate(parts)
            way = abs(np.unwrap(taken[:, THETA])[-1] - taken[0, THETA])
            if current >= MOST_PART * most:
                raise DriveFaultError(
                    f"spin: {current:.3g} A turned the shaft by {way:.3g} rad only: is it blocked or loaded?"
                )
            current = min(MOST_PART * most, 2.5 * current)
    raise DriveFaultError("spin: no current was found that turns the shaft evenly")


def _coast(bench: Bench, stream, parts: list[np.ndarray]) -> None:  # type: ignore[no-untyped-def]
    """Without torque for a while, or until a quarter of the speed has gone."""
    drive = bench.drive
    currents(drive)
    began = drive.link.transport.clock()
    first: list[float] = []

    def over(recent: np.ndarray) -> bool:
        theta = np.unwrap(recent[:, THETA])
        speed = abs(float(theta[-1] - theta[0]))
        first.append(speed)
        return speed < 0.75 * first[0] or drive.link.transport.clock() - began > COAST_S

    until(drive, stream, parts, over, 2.0 * COAST_S)


def _zero(taken: np.ndarray, theta: np.ndarray, pole_pairs: int) -> float:
    """Electrical angle that the drive uses at encoder angle zero: the phase currents tell where its d axis is."""
    flows = np.hypot(taken[:, ID], taken[:, IQ]) > 0.5 * np.abs(taken[:, IQ]).max()
    stator = np.arctan2((taken[:, IA] + 2.0 * taken[:, IB]) / math.sqrt(3.0), taken[:, IA])
    frame = stator - np.arctan2(taken[:, IQ], taken[:, ID])
    best = (0.0, 0.0)
    for sign in (1.0, -1.0):  # of an encoder that counts the other way
        mean = np.exp(1j * (frame - sign * pole_pairs * theta))[flows].mean()
        best = max(best, (float(abs(mean)), float(np.angle(mean))))
    return best[1]


def _counts(bench: Bench, taken: np.ndarray, current: float) -> tuple[np.ndarray, float]:
    """M/T counts edges, the angle does not: their ratio is that of the true counts to those in the drive."""
    drive, known = bench.drive, bench.known
    for _ in range(6):
        theta = np.unwrap(taken[:, THETA])
        true = np.gradient(theta) * RATE_HZ
        seen = taken[:, SPEED]
        share = np.abs(true) / (np.abs(true).max() or 1.0)
        most = 3.5 * known.over_speed_rad_s  # M/T is cut at four times
        rows = (share > 0.02) & (np.abs(seen) < most) & (np.sign(seen) == np.sign(true))
        if rows.sum() < 30:
            ratio = 16.0
            counts = min(ratio * known.counts, drive.parameters["encoder_counts"].maximum)
        else:
            ratio = float(np.abs(seen[rows]).sum() / np.abs(true[rows]).sum())
            counts = _likely(known.counts * ratio)
        if abs(counts / known.counts - 1.0) < 2e-3:
            break
        try:
            bench.set(encoder_counts=counts)
        except RefusedError:
            break  # the board states them
        known.counts = counts
        taken, current = _motion(bench)
    return taken, current


def _likely(counts: float) -> float:
    """A power of two or a round multiple of 4 (a line has four counts) where one is near, else the number itself."""
    power = 2.0 ** round(math.log2(counts))
    if abs(counts / power - 1.0) < COUNTS_PART:
        return power
    for step in (1000.0, 100.0, 4.0):
        near = step * round(counts / step)
        if near > 0.0 and abs(counts / near - 1.0) < 0.3 * COUNTS_PART:
            return near
    return float(round(counts))
