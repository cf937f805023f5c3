"""Currents, voltages, references and load against a drive whose data are known, within what any unit may differ by.

A relation is judged only where it is plain: where nearly all of a signal is some factor times what it should be, and
the factor is that of another unit, sign or column. A machine that is odd, or out of control, passes.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evenspin.plausible.dead import is_constant
from evenspin.plausible.finding import Array, Finding, rms
from evenspin.plausible.torque import SMOOTH_S, mean_of, partial_slope

FOLLOWS = 0.35  # share that a current or a speed may leave of its reference and still count as following it
ODD_REFERENCE = 0.7  # share left with which it does not
CLEAR = 0.8  # correlation that is beyond doubt
NONE = 0.3  # correlation that is none
FACTOR = 20.0  # that no unit is off by
EXPLAINED = 0.4  # of the torque, by acceleration
LOAD_SHARE = 0.15  # of the rated torque that moves where the load is stated to be none
RPM = 30.0 / math.pi

Columns = Mapping[str, Array]


@dataclass(frozen=True, slots=True)
class Drive:
    pole_pairs: int
    resistance_ohm: float
    ld_h: float
    lq_h: float
    psi_wb: float
    inertia_kgm2: float
    viscous_nms: float
    rated_current_a: float
    rated_torque_nm: float
    iq_limit_a: float
    counts_per_rev: float

    @property
    def nm_per_a(self) -> float:
        return 1.5 * self.pole_pairs * self.psi_wb


def check_references(c: Columns, drive: Drive, speed_mode: bool) -> Finding | None:
    """Currents and speed follow what they are asked for. `speed_mode`: the log is one of a speed loop."""
    asked = (c["id_ref_a"] != 0.0) | (c["iq_ref_a"] != 0.0)
    d, q, d_ref, q_ref = (c[name][asked] for name in ("id_a", "iq_a", "id_ref_a", "iq_ref_a"))
    size = math.hypot(rms(d), rms(q))
    top = max(float(np.max(np.abs(c["id_ref_a"]))), float(np.max(np.abs(c["iq_ref_a"]))))

    def left(d_said: Array, q_said: Array) -> float:
        return math.hypot(rms(d - d_said), rms(q - q_said)) / size if size > 0.0 else 0.0

    if left(d_ref, q_ref) > ODD_REFERENCE:
        tried = {
            "id_ref_a and iq_ref_a are exchanged": left(q_ref, d_ref),
            "iq_ref_a has the opposite sign": left(d_ref, -q_ref),
            "id_ref_a has the opposite sign": left(-d_ref, q_ref),
            "id_ref_a and iq_ref_a have the opposite sign": left(-d_ref, -q_ref),
            "iq_ref_a is in mA": left(d_ref, q_ref / 1e3),
            "id_ref_a and iq_ref_a are in mA": left(d_ref / 1e3, q_ref / 1e3),
            "id_ref_a is in mA": left(d_ref / 1e3, q_ref),
            "id_a, iq_a, ia_a and ib_a are in mA": left(1e3 * d_ref, 1e3 * q_ref),
        }
        what = min(tried, key=lambda name: tried[name])
        if tried[what] < FOLLOWS:
            data = f"not followed by the current, but it is when {what}"
            return Finding(what.split()[0].rstrip(","), data, "what its name says", "correct the columns")
    limit = max(drive.iq_limit_a, drive.rated_current_a)
    if top > FACTOR * limit:
        data = f"up to {top:.4g}"
        must = f"within the {limit:g} A of meta.json"
        return Finding("iq_ref_a", data, must, "the currents look like mA: convert all of them to A")
    return _check_speed_reference(c, drive) if speed_mode else None


def _check_speed_reference(c: Columns, drive: Drive) -> Finding | None:
    ref, speed = c["speed_ref_rad_s"], c["speed_rad_s"]
    square = float(ref @ ref)
    slope = float(speed @ ref) / square if square > 0.0 else 1.0
    if 0.7 < slope < 1.4 or rms(speed - slope * ref) > FOLLOWS * rms(speed):
        return None
    p = drive.pole_pairs
    units = {"r/min": 1.0 / RPM, "degrees per second": math.pi / 180.0, "turns per second": 2.0 * math.pi}
    if p > 1:
        units["electrical rad/s"] = 1.0 / p
    unit = min(units, key=lambda name: abs(math.log(abs(slope) / units[name])))
    if abs(abs(slope) / units[unit] - 1.0) < 0.05:
        hint = f"it looks like {unit}: convert it to mechanical rad/s"
    elif abs(slope + 1.0) < 0.3:
        hint = "it has the opposite sign of speed_rad_s: turn the sign of one of them"
    else:
        return None
    return Finding("speed_ref_rad_s", f"{1.0 / slope:.4g} times the speed that follows", "rad/s", hint)


def check_voltages(c: Columns, drive: Drive) -> Finding | None:
    """Resistance, flux and currents give most of the voltage."""
    electrical = drive.pole_pairs * c["speed_rad_s"]
    d = drive.resistance_ohm * c["id_a"] - electrical * drive.lq_h * c["iq_a"]
    q = drive.resistance_ohm * c["iq_a"] + electrical * (drive.ld_h * c["id_a"] + drive.psi_wb)
    size = math.hypot(rms(d), rms(q)) * math.hypot(rms(c["vd_v"]), rms(c["vq_v"]))
    if size == 0.0:
        return None

    def like(vd: Array, vq: Array) -> float:
        return float(np.mean(vd * d + vq * q)) / size

    own = like(c["vd_v"], c["vq_v"])
    tried = {
        "exchanged": like(c["vq_v"], c["vd_v"]),
        "exchanged, and one has the opposite sign": max(like(-c["vq_v"], c["vd_v"]), like(c["vq_v"], -c["vd_v"])),
        "of opposite sign": like(-c["vd_v"], -c["vq_v"]),
    }
    what = max(tried, key=lambda name: tried[name])
    must = "what resistance, flux and currents give"
    if own < NONE and tried[what] > CLEAR:
        hint = "correct the columns, or all currents have the opposite sign" if "sign" in what else "exchange the names"
        return Finding("vd_v, vq_v", f"in accord with currents and speed when {what}", must, hint)
    slope = own * math.hypot(rms(c["vd_v"]), rms(c["vq_v"])) / math.hypot(rms(d), rms(q))
    if own > CLEAR and not 1.0 / FACTOR < slope < FACTOR:
        in_mv = 500.0 < slope < 2000.0
        hint = "vd_v and vq_v look like mV: convert them" if in_mv else "which of them are not in V or A?"
        return Finding("vd_v, vq_v", f"{slope:.3g} times {must}", must, hint)
    return None


def check_torque(c: Columns, drive: Drive, loaded: bool, always: bool = False) -> Finding | None:
    """The current accelerates the shaft the way it says, and carries the load that is measured.

    `loaded`: the load was measured; `always`: and there was one all the time.
    """
    step_s = float(np.median(np.diff(c["t_s"])))
    n = max(1, round(SMOOTH_S / step_s))
    if len(c["t_s"]) < 20 * n:
        return None
    speed = mean_of(c["speed_rad_s"], n)
    accel = (speed[n:] - speed[:-n]) / (n * step_s)
    rows = slice(n // 2, n // 2 + len(accel))
    w = speed[rows]
    load = np.nan_to_num(c["load_torque_nm"]) if loaded else np.zeros(len(c["t_s"]))
    still = load[0] if is_constant(load) else None
    iq, load = mean_of(c["iq_a"], n)[rows], mean_of(load, n)[rows]
    load = load if still is None else np.full(len(load), still)  # without the rounding of the mean
    inertia, like = partial_slope(accel, drive.nm_per_a * iq, (w, np.sign(w), np.ones_like(w), load))
    factor = inertia / drive.inertia_kgm2
    turned = like < 0.0 and like**2 > EXPLAINED
    if loaded and not turned:
        shaft = drive.nm_per_a * iq - drive.inertia_kgm2 * accel - drive.viscous_nms * w
        found = _check_load(shaft, load, drive, always)
        if found is not None:
            return found
    if like**2 < EXPLAINED or 1.0 / FACTOR < factor < FACTOR:
        return None
    data = f"{factor:.3g} times what inertia_kgm2 needs for the acceleration of speed_rad_s"
    if factor < 0.0:
        hint = "it looks like the opposite sign of the currents, or of angle and speed: turn it"
    elif 500.0 < factor < 2000.0:
        hint = "the currents look like mA: convert all of them to A"
    else:
        hint = "are currents, speed and inertia_kgm2 in SI units?"
    return Finding("iq_a", data, "the current that accelerates the shaft", hint)


def _check_load(shaft: Array, load: Array, drive: Drive, always: bool) -> Finding | None:
    if is_constant(load):
        carried = rms(shaft - load) if always else float(np.std(shaft))
        if carried < LOAD_SHARE * drive.rated_torque_nm:
            return None
        data = f"{load[0] + 0.0:.3g} in every row, and the current carries {carried:.2g} N m rms beside it"
        hint = "a dead sensor: write nan where it was not measured"
        return Finding("load_torque_nm", data, "the load that acted", hint)
    slope = float(shaft @ load) / float(load @ load)
    like = slope * rms(load) / rms(shaft) if rms(shaft) > 0.0 else 0.0
    if like < -CLEAR:
        data = f"{slope:.3g} times the torque that the current carries"
        return Finding("load_torque_nm", data, "positive where it brakes positive rotation", "turn its sign")
    if like > CLEAR and not 1.0 / FACTOR < slope < FACTOR:
        hint = "it looks like mN m: convert it" if 5e-4 < slope < 2e-3 else "is it in N m?"
        return Finding("load_torque_nm", f"{1.0 / slope:.3g} times the torque that the current carries", "in N m", hint)
    return None
