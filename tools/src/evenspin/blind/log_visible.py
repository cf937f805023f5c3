"""How strongly a hidden effect shows in what was recorded: what no method can see is silent by physics.

The same drive runs the same speeds once more without the effect, and without noise. The recorded columns are put into
the equations of the machine, which need no controller: torque, and with voltages both axes. What these leave with the
effect and without it is compared, whitened by what the noise of the log leaves there, all equations together, at each
frequency. What a unit within the tolerances of BENCH could do as well is taken off. The root of the sum of squares that
is left, in standard deviations, is a bound: it knows every other parameter within its tolerance, and what rows and
delays leave in the equations.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from evenspin.blind.bench_drives import BENCH, Drive
from evenspin.blind.referee import Inputs, Parameters, simulate

Array = NDArray[np.float64]
SEEN = math.sqrt(10.0)  # standard deviations from which on a log shows an effect
SEGMENT_S = 2.0
NEIGHBOURS = 2  # frequencies on either side that the noise is averaged over
LEAST_SHARE = 1e-6  # of a column's own noise, that no combination of columns is quieter than
STEP = 0.5  # of the tolerance
WORTH, ROUNDS = 0.5, 3  # of what an effect shows by, that another one has to take off at first sight; then it is fitted


@dataclass(frozen=True, slots=True)
class Tolerance:
    """One way in which a unit may differ: what of it the parameters have, and how far they may go from there."""

    effect: str
    moved: Callable[[Parameters, float], Parameters]  # by a share of the bound
    low: float  # in bounds, from the unit on
    high: float


def tolerances_of(drive: Drive, nominal: Parameters, unit: Parameters) -> list[Tolerance]:
    """Every bound of BENCH, from where the unit is."""
    motor = drive.meta["motor"]
    rated_a, rated_nm = motor["rated_current_a"], motor["rated_torque_nm"]
    found = []

    def factor(effect: str, key: str, *names: str) -> None:
        at = (unit[names[0]] / nominal[names[0]] - 1.0) / BENCH[key]
        found.append(
            Tolerance(
                effect,
                lambda p, share: p | {n: p[n] + share * BENCH[key] * nominal[n] for n in names},
                -1.0 - at,
                1.0 - at,
            )
        )

    def added(effect: str, name: str, bound: float, least: float = -1.0, middle: float = 0.0) -> None:
        at = (unit[name] - middle) / bound
        found.append(Tolerance(effect, lambda p, share: p | {name: p[name] + share * bound}, least - at, 1.0 - at))

    def wave(effect: str, bound: float, key: str) -> None:
        size, phase = f"{effect}.{key}", f"{effect}.phase_rad"
        for turned in (1.0, 1.0j):

            def moved(p: Parameters, share: float, turned: complex = turned) -> Parameters:
                z = p[size] * complex(math.cos(p[phase]), math.sin(p[phase])) + share * bound * turned
                return p | {size: abs(z), phase: math.atan2(z.imag, z.real)}

            at = unit[size] / bound * (math.cos(unit[phase]) if turned == 1.0 else math.sin(unit[phase]))
            found.append(Tolerance(effect, moved, -1.0 - at, 1.0 - at))

    factor("winding_resistance", "resistance", "motor.resistance_ohm")
    factor("inductance", "inductance", "motor.ld_h", "motor.lq_h")
    factor("torque_constant", "flux", "motor.psi_wb")
    factor("inertia", "inertia", "motor.inertia_kgm2")
    factor("viscous_friction", "viscous", "motor.viscous_nms")
    for sensor in "ab":
        added("current_offset", f"sensor.offset_{sensor}_a", BENCH["offset_of_rated"] * rated_a)
        added("current_gain", f"sensor.gain_{sensor}", BENCH["gain"], middle=1.0)
    added("encoder_offset", "encoder_offset.angle_el_rad", BENCH["electrical_zero_rad"])
    added("dead_time", "dead_time.dead_time_s", BENCH["dead_time_of_link"] / drive.meta["pwm_hz"], 0.0)
    added("coulomb_friction", "coulomb_friction.torque_nm", BENCH["coulomb_of_rated"] * rated_nm, 0.0)
    added("load_torque", "load_torque.torque_nm", BENCH["load_of_rated"] * rated_nm)
    wave("cogging", BENCH["cogging_of_rated"] * rated_nm, "amplitude_nm")
    wave("encoder_eccentricity", BENCH["eccentricity_rad"], "amplitude_rad")
    return found


@dataclass(frozen=True, slots=True)
class Bench:
    """What is recorded of a drive."""

    machine: Parameters  # of the equations
    pwm_hz: float
    decimate: int
    signals: tuple[str, ...]  # of the columns
    voltages: bool

    def run(self, parameters: Parameters, inputs: Inputs, noise: bool = False) -> Array:
        """What each equation of the machine leaves, row by row."""
        quiet = {
            "sensor.current_noise_a": 0.0,
            "sensor.current_lsb_a": 0.0,
            "sensor.vdc_noise_v": 0.0,
            "sensor.load_noise_nm": 0.0,
            "sensor.counts_per_rev": 1e9,
        }
        step = {"run.step_s": 1.0 / self.pwm_hz}
        return self._left(simulate(parameters | step | ({} if noise else quiet), inputs, self.decimate))

    def _left(self, log: Mapping[str, Array]) -> Array:
        p, row_s = self.machine, self.decimate / self.pwm_hz
        pairs, psi_wb, ld_h, lq_h = (p[f"motor.{key}"] for key in ("pole_pairs", "psi_wb", "ld_h", "lq_h"))
        iq, id_a = log["iq_a"], log["id_a"] if {"id_a", "ia_a"} & set(self.signals) else np.zeros(len(log["iq_a"]))
        if any("theta" in s or s in ("turned_rad", "counts") for s in self.signals):
            speed = np.gradient(np.unwrap(log["drive_theta_m_rad"]), row_s)
        else:
            speed = log["speed_rad_s"]
        load = log["load_torque_nm"] if "load_torque_nm" in self.signals else 0.0
        torque = 1.5 * pairs * (psi_wb + (ld_h - lq_h) * id_a) * iq - load
        found = [torque - p["motor.inertia_kgm2"] * np.gradient(speed, row_s) - p["motor.viscous_nms"] * speed]
        if self.voltages:
            electrical, ohm = pairs * speed, p["motor.resistance_ohm"]
            found += [
                log["vd_v"] - ohm * id_a - ld_h * np.gradient(id_a, row_s) + electrical * lq_h * iq,
                log["vq_v"] - ohm * iq - lq_h * np.gradient(iq, row_s) - electrical * (ld_h * id_a + psi_wb),
            ]
        return np.stack(found)


def visible(
    bench: Bench,
    unit: Parameters,
    hidden: tuple[Parameters, Inputs],
    without: Mapping[str, tuple[Parameters, Inputs]],
    tolerances: Sequence[Tolerance],
    rate_hz: float,
) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
    """Standard deviations by which each effect shows, {effect: twin without it}; and by which it still shows where
    another effect of the table may have any size, of those that leave less than SEEN."""
    clean = bench.run(*hidden)
    white = _whitening(bench.run(*hidden, noise=True) - clean, max(16, round(SEGMENT_S * rate_hz)))
    healthy = bench.run(unit, hidden[1])
    ways = []
    for way in tolerances:
        step = STEP if way.high >= -way.low else -STEP
        ways.append(white((bench.run(way.moved(unit, step), hidden[1]) - healthy) / step))
    grams = _products(ways, ways)
    others = sorted({way.effect for way in tolerances} - {"inductance"})
    shown: dict[str, float] = {}
    alike: dict[str, dict[str, float]] = {}
    for name, (twin, inputs) in without.items():

        def left_at(shares: Array, free: str, twin: Parameters = twin, inputs: Inputs = inputs) -> tuple[float, Array]:
            """What a unit that differs by these shares leaves, and the shares at which it would leave least."""
            for way, share in zip(tolerances, shares, strict=True):
                twin = way.moved(twin, float(share)) if share else twin
            rest = white(clean - bench.run(twin, inputs))
            return _left(_bordered(rest, ways, grams), tolerances, free, shares)

        shown[name], nearest = left_at(np.zeros(len(tolerances)), "")
        alike[name] = {}
        for other in others if shown[name] >= SEEN else ():
            size, shares = left_at(np.zeros(len(tolerances)), other) if other != name else (math.inf, nearest)
            if size > WORTH * shown[name]:
                continue
            for _ in range(ROUNDS):  # far off, the equations bend
                size, shares = left_at(shares, other)
                if size < SEEN:
                    alike[name][other] = size
                    break
    return shown, alike


def _left(
    gram: Array, tolerances: Sequence[Tolerance], free: str = "", shares: Array | None = None
) -> tuple[float, Array]:
    """Root of the least sum of squares that units within their tolerances, from these shares on, leave of the first of
    `gram`, and where; those of `free` without a bound."""
    values, vectors = np.linalg.eigh(gram)
    root = (np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T).astype(np.float64)
    at = np.zeros(len(tolerances)) if shares is None else shares
    low = np.array([-np.inf if way.effect == free else min(way.low, -1e-9) for way in tolerances]) - at - 1e-9
    high = np.array([np.inf if way.effect == free else max(way.high, 1e-9) for way in tolerances]) - at + 1e-9
    size = np.maximum(np.linalg.norm(root[:, 1:], axis=0), 1e-12)
    fit = scipy.optimize.lsq_linear(root[:, 1:] / size, root[:, 0], (low * size, high * size))
    return float(math.sqrt(2.0 * fit.cost)), at + fit.x / size


Spectra = NDArray[np.complex64]


def _whitening(noise: Array, length: int) -> Callable[[Array], Spectra]:
    """Spectra in which noise of all rows together has a variance of 1 at each frequency."""
    scale = np.maximum(noise.std(axis=1), 1e-12)[:, None]
    power = _spectra(noise / scale, length)  # frequency, segment, channel
    cross = np.einsum("fsc,fsd->fcd", power, power.conj()) / power.shape[1]
    around = np.cumsum(np.concatenate([np.zeros_like(cross[:1]), cross]), axis=0)
    at = np.arange(len(cross))
    low, high = np.maximum(at - NEIGHBOURS, 0), np.minimum(at + NEIGHBOURS + 1, len(cross))
    cross = (around[high] - around[low]) / (high - low)[:, None, None]
    least = LEAST_SHARE * np.mean(np.einsum("fcc->fc", cross).real, axis=0)
    whiten = np.linalg.inv(np.linalg.cholesky(cross + np.eye(cross.shape[1]) * least))
    return lambda rows: np.einsum("fcd,fsd->fsc", whiten, _spectra(rows / scale, length)).astype(np.complex64)


def _products(first: Sequence[Spectra], second: Sequence[Spectra]) -> Array:
    return np.array([[float(np.vdot(a, b).real) for b in second] for a in first])


def _bordered(rest: Spectra, ways: Sequence[Spectra], grams: Array) -> Array:
    """The inner products of what is left and of the ways in which a unit differs."""
    edge = _products([rest], [rest, *ways])
    return np.block([[edge], [edge[:, 1:].T, grams]]) if ways else edge


def _spectra(signals: Array, length: int) -> NDArray[np.complex128]:
    """Half overlapping segments under a sine, whose squares add up to 1: every row counts once."""
    window = np.sin(np.pi * (np.arange(length) + 0.5) / length)
    count = (signals.shape[1] - length) // (length // 2) + 1
    starts = (length // 2) * np.arange(count)
    parts = signals[:, starts[:, None] + np.arange(length)] * window
    return np.asarray(np.fft.rfft(parts, axis=2).transpose(2, 1, 0))
