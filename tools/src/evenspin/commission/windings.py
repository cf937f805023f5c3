"""The steps that look at the winding: its resistance and inductances, and the current loop that follows from them."""

from __future__ import annotations

import math

import numpy as np

from evenspin.bench.errors import DriveFaultError
from evenspin.commission.findings import Known, Quality, Step, sure
from evenspin.commission.fits import edges, inductance
from evenspin.commission.signals import currents, need_rest, rows, run_currents, step_capture, switched
from evenspin.commission.steps import ROUGH_R, SLOW, SURE_L, SURE_R, Bench
from evenspin.identify.estimate import Estimate, linear

ROUGH_PART, ROUGH_TIMES, ROUGH_HZ = 0.06, 8, 120.0  # current of the first look at the winding, of the largest
HALF_WAVE_S, HALF_WAVES, WINDOW = 0.004, 20, 32  # of a current that is switched to and fro; rows that are summed up
SWITCHED_PART = 0.3  # of the largest current...
SWITCHED_SPEED = 0.03  # ...and of the largest speed: the voltage is turned by what the rotor moves in 1.5 periods
REPEATS, Q_REPEATS = 6, 10  # of every step
HELD_PARTS, HELD_S, HELD_TIMES = (0.15, 0.5), 0.25, 4  # of the largest current
STEP_LEVELS = ((0.1, 0.4), (0.4, 0.7))  # of the largest current


def winding_roughly(bench: Bench) -> Step:
    """A current that is switched to and fro faster than a rotor follows; the loop gets faster from time to time."""
    since, drive, known = bench.clock, bench.drive, bench.known
    most, r = bench.bounds.max_current_a, known.resistance.value
    periods = bench.drive.get(["align_periods"])["align_periods"]
    bench.set(align_periods=0.0)
    kp, inductance_h, first_r = 0.4 * r, 0.0, r
    for _ in range(ROUGH_TIMES):
        bench.set(current_kp_v_per_a=min(kp, 1e3), current_ki_v_per_as=SLOW * r)
        run_currents(drive)
        taken = switched(drive, "d", ROUGH_PART * most, HALF_WAVE_S, HALF_WAVES)
        need_rest(drive)
        found, _ = edges(taken, bench.period_s, WINDOW)
        if not found.value > 0.0:
            kp *= 2.0
            continue
        inductance_h = found.value
        # The current that showed R grew with the voltage: a part of the voltage was that of the inductance.
        r = max(first_r - inductance_h / known.growth_s, 0.2 * first_r)
        wanted = 2.0 * math.pi * ROUGH_HZ * inductance_h
        if kp > 0.7 * wanted and found.relative < 0.2:
            break
        kp = min(wanted, 8.0 * kp)
    else:
        if not inductance_h:
            raise DriveFaultError("winding: no inductance was found; are the three phases connected?")
    known.ld = known.lq = Estimate(inductance_h, 0.3 * inductance_h)
    known.resistance = Estimate(r, 0.3 * r)
    accepted = _current_gains(bench, inductance_h, ROUGH_HZ)
    accepted |= bench.set(align_periods=periods)
    quality = [Quality("inductance, roughly", inductance_h, 0.0, "H", 1e-6, 1.0)]
    quality.append(Quality("resistance, roughly", r, 0.0, "ohm", 1e-4, 1e3))
    return bench.done(
        "winding", "resistance and inductance, roughly: a current loop for any winding", since, quality, accepted
    )


# ---- inductances and current loop


def d_axis(bench: Bench) -> Step:
    """Steps along the magnets, which make no torque: first a cautious one, then with what it showed."""
    since, drive, known = bench.clock, bench.drive, bench.known
    most, r = bench.bounds.max_current_a, known.resistance.value
    run_currents(drive)
    length = int(min(max(8.0 * known.ld.value / r / bench.period_s, 60), 1500))
    rough = _step(bench, "d", 0.05 * most, 0.25 * most, length, 0.1)[0].value
    known.ld = Estimate(rough, 0.2 * rough)
    known.resistance = _held(bench)
    _current_gains(bench, rough, 250.0)
    r = known.resistance.value
    found = []
    for low, high in STEP_LEVELS:
        length = int(min(max(8.0 * rough / r / bench.period_s, 60), 1500))
        every = [_step(bench, "d", low * most, high * most, length, 0.1)[0] for _ in range(REPEATS)]
        winding = scatter(every)
        found.append((winding, (low * most, high * most)))
        rough = winding.value
    need_rest(drive)
    known.ld = found[0][0]
    known.saturation = [(0.5 * (low + high), winding.value) for winding, (low, high) in found]
    accepted = _current_gains(bench, known.ld.value, 300.0)
    accepted |= bench.set(
        motor_ld_h=known.ld.value, motor_lq_h=known.ld.value, motor_resistance_ohm=known.resistance.value
    )
    qualities = sure("resistance", known.resistance, "ohm", SURE_R) + sure(
        "inductance of the d axis", known.ld, "H", SURE_L
    )
    ratio = found[-1][0].value / known.ld.value
    qualities.append(Quality("inductance at 0.55 of the largest current, over that at 0.25", ratio, 0.0, "", 0.3, 1.2))
    return bench.done("d axis", "inductance of the d axis, saturation, current loop", since, qualities, accepted)


def _step(
    bench: Bench, axis: str, low: float, high: float, length: int, hold_s: float
) -> tuple[Estimate, tuple[float, float]]:
    """(L, currents) from one step; the mean of the rows before it is what it is measured from."""
    pre = 100
    decimation = 1
    while length / decimation > bench.drive.capture_rows(2) - pre - 1:
        decimation += 1
    signals = (f"i{axis}_a", f"v{axis}_v")
    taken = step_capture(bench.drive, signals, axis, low, high, length // decimation, pre, hold_s, decimation)
    before = taken[:pre].mean(axis=0)
    change = taken[pre - 2 :] - before
    period = bench.period_s * decimation
    winding = inductance(change[:, 0], change[:, 1], bench.known.resistance.value, period)
    return winding.inductance_h, (low, high)


def scatter(found: list[Estimate]) -> Estimate:
    """The mean of repeated measurements, with the interval that their scatter makes (Student's t)."""
    from scipy.special import stdtrit

    values = np.array([each.value for each in found])
    half = float(stdtrit(len(values) - 1, 0.975) * values.std(ddof=1) / math.sqrt(len(values)))
    return Estimate(float(values.mean()), half)


def _held(bench: Bench) -> Estimate:
    """Resistance from two currents that are held along the magnets: what a dead time adds to both drops out.

    An electrical zero that is off by a degree lets the current turn a free shaft slowly, and a part of the back-EMF,
    which is on the q axis, shows on the d axis, too: vd = R id + c vq + constant.
    """
    drive, most = bench.drive, bench.bounds.max_current_a
    values = []
    tau = bench.known.ld.value / bench.known.resistance.value
    seconds = max(HELD_S, 15.0 * tau)
    _current_gains(bench, bench.known.ld.value, 80.0)  # a fast loop answers the noise of the current with voltage
    for _ in range(HELD_TIMES):
        for part in HELD_PARTS:
            currents(drive, id_a=part * most)
            drive.sleep(max(0.1, 3.0 * tau))
            with drive.stream(("id_a", "vd_v", "vq_v"), rate_hz=1000.0) as stream:
                values.append(rows(stream, seconds))
            drive.need_no_fault()
        need_rest(drive)
        run_currents(drive)
    taken = np.concatenate(values)
    level = np.concatenate([np.full(len(part), part[:, 0].mean()) for part in values])
    columns = np.column_stack((level, taken[:, 2], np.ones(len(taken))))
    (resistance, _, _), _ = linear(columns, taken[:, 1], 0.2)
    return resistance


def _current_gains(bench: Bench, inductance_h: float, hz: float) -> dict[str, float]:
    w, r = 2.0 * math.pi * hz, bench.known.resistance.value
    kp = min(w * inductance_h, 1e3)
    return bench.set(current_kp_v_per_a=kp, current_ki_v_per_as=min(max(w * r, kp * w / 20.0), 1e6))


def q_axis(bench: Bench) -> Step:
    """A step of torque, as large as the speed allows that it makes; the back-EMF is part of the fit."""
    since, drive, known = bench.clock, bench.drive, bench.known
    most = bench.bounds.max_current_a
    run_currents(drive)
    per_a, motion = _acceleration(bench)
    known.per_a_rad_s2 = per_a
    room = SWITCHED_SPEED * (bench.bounds.max_speed_rad_s or known.over_speed_rad_s)
    high = min(SWITCHED_PART * most, room / (per_a * HALF_WAVE_S)) if per_a > 0.0 else SWITCHED_PART * most
    high = max(high, 0.02 * most)
    found = []
    for number in range(Q_REPEATS + 1):
        need_rest(drive)
        run_currents(drive)
        taken = switched(drive, "q", high if number % 2 else -high, HALF_WAVE_S, HALF_WAVES)
        found.append(edges(taken, bench.period_s, window_of(known), known.resistance.value)[0])
        bench.switched.append(taken)
        currents(drive)
        if number == 0:  # it shows how fast the loop of this axis may be
            rough = found.pop().value
            bench.switched.clear()
            _current_gains(bench, min(max(rough, 0.5 * known.ld.value), 4.0 * known.ld.value), 250.0)
    need_rest(drive)
    known.lq = scatter(found)
    low = min(known.ld.value, known.lq.value)
    accepted = _current_gains(bench, low, 300.0) | bench.set(motor_lq_h=known.lq.value)
    qualities = [Quality("inductance of the q axis, roughly", known.lq.value, 0.0, "H", 0.0, 1e6)]
    qualities.append(Quality("scatter of its repetitions", 100.0 * known.lq.relative, 0.0, "%", 0.0, 100.0 * ROUGH_R))
    qualities.append(Quality("saliency Lq / Ld", known.lq.value / known.ld.value, 0.0, "", 0.5, 8.0))
    return bench.done("q axis", "inductance of the q axis", since, qualities, accepted, motion)


def window_of(known: Known) -> int:
    """Rows over which a switched current is summed up: some time constants of the winding; beyond, only R counts."""
    return int(min(max(4.0 * known.ld.value / known.resistance.value * 1e4, 6), WINDOW))


def _acceleration(bench: Bench) -> tuple[float, str]:
    """rad/s^2 per A from short pushes, more and more current until the shaft moves; 0: it did not."""
    drive, most = bench.drive, bench.bounds.max_current_a
    for part in (0.02, 0.05, 0.1, 0.2, 0.4):
        pushed = part * most
        with drive.stream(("theta_m_rad", "iq_a"), rate_hz=1000.0) as stream:
            rows(stream, 0.01)
            currents(drive, iq_a=pushed)
            taken = [rows(stream, 0.006)]
            currents(drive)
            taken.append(rows(stream, 0.06))
        values = np.concatenate(taken)
        theta = np.unwrap(values[:, 0])
        impulse = float(values[:, 1].sum()) / 1000.0
        speed = (
            float(np.gradient(theta).max() * 1000.0)
            if theta[-1] > theta[0]
            else float(-np.gradient(theta).min() * 1000.0)
        )
        if abs(theta[-1] - theta[0]) > 5.0 * 2.0 * math.pi / max(bench.known.counts, 1000.0) and impulse > 0.0:
            return abs(
                speed
            ) / impulse, f"{pushed:.3g} A for some milliseconds moved the shaft by {abs(theta[-1] - theta[0]):.3g} rad"
        need_rest(drive)
        run_currents(drive)
    return 0.0, "40 % of the largest current for some milliseconds did not move the shaft"
