"""Does a method help on this drive? Simulated with and without it, under the same torque tied to the angle.

A learning gain that makes things worse is made smaller a few times. Where a method does not help whatever the gain, it
is asked with finer encoders, so that what would help can be said.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

from evenspin.errors import InputError
from evenspin.native import tables
from evenspin.tune.ripple import RepetitiveGains, slowest_of_ro
from evenspin.tune.trial import (
    Ripple,
    position_ripple,
    rated_torque,
    ripple_of,
    said,
    speed_trial,
    top_speed,
    torque_per_a,
)

Numbers = Mapping[str, float]

HELPS = 0.7  # of the ripple without it
NO_HARM = 1.05
TURNS = {"crc": 30.0, "forc": 30.0, "fal-forc": 30.0, "dob": 12.0, "ro": 60.0, "aro": 60.0}
# silc converges at first also where it diverges later
POSITION_TURNS = {"ppi": 16.0, "silc": 80.0, "src": 16.0, "rdc": 16.0}
GROWS = 1.1  # error of the last turns over that of the turns halfway
GAINS = (1.0, 0.4, 0.15)  # of the first learning gain
FIRST_OBSERVER_GAIN = 0.05
ELECTRICAL_HZ = 5.0  # of the first order of the ripple: the speed loop alone leaves some of it
FINER = (4.0, 16.0, 64.0)
MOST_COUNTS = 16_777_216.0
CELLS_PER_ORDER = 4
METHOD_OVERSHOOT = 0.6  # learning adds to the overshoot of a step...
METHOD_TIME = 5.0  # ...and takes longer to settle: what was learned at one speed is unlearned at another
SRC_CUTOFFS = (60.0, 25.0, 10.0)
ROBUST_PARTS = (0.33, 0.1, 0.03, 0.0)  # rho / sigma, of where it begins to chatter


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a method does on this drive. `without` and `with_it`: rms in `unit`; `changes`: parameters that it needs."""

    method: str
    word: str  # helps, no use, harms, cannot
    speed_rad_s: float
    without: float
    with_it: float
    unit: str
    changes: Mapping[str, float]
    text: str = ""

    @property
    def usable(self) -> bool:
        return self.word in ("helps", "no use", "reference")

    @property
    def ratio(self) -> float:
        return self.with_it / self.without if self.without > 0.0 else math.inf


def choice(param: str, word: str) -> float:
    return tables().params[param].to_number(word)


def speed_verdicts(
    plant: Numbers,
    drive: Numbers,
    rc: RepetitiveGains,
    others: Mapping[str, Numbers],
    progress: Callable[[str], None] | None = None,
) -> Iterator[Verdict]:
    """Every choice of `method` but pi. `others`: machines by name that the model may mean as well."""
    top = 0.6 * top_speed(plant, drive, 0.3 * rated_torque(plant, drive))
    electrical = 2.0 * math.pi * ELECTRICAL_HZ / plant["pole_pairs"]
    slowest = {"ro": 1.3 * slowest_of_ro(plant), "aro": 0.0, "dob": 0.0}
    base: dict[float, Ripple] = {}
    for method in tables().params["method"].choices[1:]:
        if progress is not None:
            progress(method)
        least = slowest.get(method, 1.2 * rc.slowest_rad_s)
        speed = max(electrical, least)
        if least > top or (method not in slowest and rc.reason):
            why = rc.reason if least <= top else (
                f"its memory holds a period only above {least * 30.0 / math.pi:.4g} r/min, this drive ends at "
                f"{top * 30.0 / math.pi:.4g} r/min with load; aro and rc_memory = angle have no such limit"
            )  # fmt: skip
            yield Verdict(method, "cannot", speed, 0.0, 0.0, "rad/s", {}, why)
            continue
        speed = min(speed, top)
        if speed not in base:
            base[speed] = ripple_of(plant, drive, speed, 12.0)
        yield speed_verdict(plant, drive, rc, others, method, speed, base[speed])


def speed_verdict(
    plant: Numbers,
    drive: Numbers,
    rc: RepetitiveGains,
    others: Mapping[str, Numbers],
    method: str,
    speed: float,
    without: Ripple,
) -> Verdict:
    """One of them, at this speed; `without`: what is left with pi alone."""
    best: Verdict | None = None
    for changes in _attempts(plant, rc, method):
        found = _driven(plant, drive, others, _attempt(plant, drive, method, changes, speed, without))
        if best is None or _rank(found) < _rank(best):
            best = found
        if found.word == "helps":
            break
    assert best is not None
    if best.word == "helps":
        return best
    return replace(best, text="; ".join(word for word in (best.text, _what_would(plant, drive, best, speed)) if word))


def _rank(verdict: Verdict) -> tuple[int, float]:
    return ("helps", "no use", "harms", "cannot").index(verdict.word), verdict.ratio


def _attempts(plant: Numbers, rc: RepetitiveGains, method: str) -> Iterator[dict[str, float]]:
    first = {"method": choice("method", method)}
    if method in ("crc", "forc", "fal-forc"):
        for part in GAINS:
            yield first | rc.drive | {"rc_gain": part * rc.drive["rc_gain"]}
        return
    if method == "aro":
        cells = max(200.0, CELLS_PER_ORDER * 6.0 * plant["pole_pairs"])
        first |= {"aro_cells": min(cells, 2048.0), "aro_write": choice("aro_write", "hat")}
    for part in GAINS:
        yield first | {"observer_gain": part * FIRST_OBSERVER_GAIN}


def _attempt(
    plant: Numbers, drive: Numbers, method: str, changes: dict[str, float], speed: float, without: Ripple
) -> Verdict:
    with_it = ripple_of(plant, {**drive, **changes}, speed, TURNS[method])
    text = ""
    ratio = with_it.rms / without.rms if without.rms > 0.0 else math.inf
    if not with_it.outcome.good and without.outcome.good:
        word, text = "harms", said(with_it.outcome)
    elif ratio < HELPS:
        word = "helps"
    else:
        word = "no use" if ratio <= NO_HARM else "harms"
    return Verdict(method, word, speed, without.rms, with_it.rms, "rad/s", changes, text)


def _driven(plant: Numbers, drive: Numbers, others: Mapping[str, Numbers], verdict: Verdict) -> Verdict:
    """A method that helps at one speed must also get through start, load step, reversal and full speed, on every
    machine that the model may mean: near the end of the voltage a part in a hundred decides."""
    if not verdict.usable:
        return verdict
    setup = {**drive, **verdict.changes}
    for name, machine in {"": plant, **others}.items():
        trial = speed_trial(machine, setup, METHOD_OVERSHOOT, verdict.method, METHOD_TIME)
        if not trial.good:
            where = f"{name}: " if name else ""
            return replace(verdict, word="harms", text=where + "; ".join(trial.problems))
    return verdict


def _what_would(plant: Numbers, drive: Numbers, verdict: Verdict, speed: float) -> str:
    """With a finer encoder?"""
    counts = plant["counts_per_rev"]
    if verdict.method not in ("dob", "ro", "aro") or counts <= 0.0:
        return ""
    for factor in FINER:
        finer = counts * factor
        if finer > MOST_COUNTS:
            break
        other = {**plant, "counts_per_rev": finer}
        setup = {**drive, **verdict.changes, "observer_gain": FIRST_OBSERVER_GAIN, "encoder_counts": finer}
        without = ripple_of(other, {**drive, "encoder_counts": finer}, speed, 12.0)
        found = ripple_of(other, setup, speed, TURNS[verdict.method])
        if found.outcome.good and found.rms < HELPS * without.rms:
            return (
                f"an encoder of {counts:g} counts is too coarse for the torque that it calculates from two differences "
                f"of the angle; one of {finer:g} counts would do"
            )
    return "a finer encoder alone would not change that"


def position_verdicts(
    plant: Numbers, drive: Numbers, progress: Callable[[str], None] | None = None
) -> Iterator[Verdict]:
    """Every choice of `position_method`; ppi is the reference."""
    speed = min(2.0 * math.pi * ELECTRICAL_HZ / plant["pole_pairs"], 0.5 * top_speed(plant, drive))
    without: Ripple | None = None
    for method in tables().params["position_method"].choices:
        if progress is not None:
            progress(method)
        first = {"position_method": choice("position_method", method)}
        if without is None:
            without = position_ripple(plant, {**drive, **first}, speed, POSITION_TURNS[method])
            word = "reference" if without.outcome.good else "harms"
            yield Verdict(method, word, speed, without.rms, without.rms, "rad", first, said(without.outcome))
            continue
        best: Verdict | None = None
        for changes, text in _position_attempts(plant, drive, method):
            found = position_ripple(plant, {**drive, **first, **changes}, speed, POSITION_TURNS[method])
            ratio = found.rms / without.rms if without.rms > 0.0 else math.inf
            word = "helps" if ratio < HELPS else "no use" if ratio <= NO_HARM else "harms"
            if not found.outcome.good:
                word, text = "harms", said(found.outcome)
            elif found.growth > GROWS:
                word, text = "harms", f"what it learns grows: {found.growth:.2g} times in the second half of its turns"
            verdict = Verdict(method, word, speed, without.rms, found.rms, "rad", first | changes, text)
            if best is None or _rank(verdict) < _rank(best):
                best = verdict
            if word == "helps":
                break
        assert best is not None
        yield best


def _position_attempts(plant: Numbers, drive: Numbers, method: str) -> Iterator[tuple[dict[str, float], str]]:
    if method == "silc":
        lead = drive["ilc_lead"]
        for lead_part, gain in ((1.0, 0.2), (0.6, 0.2), (1.5, 0.2), (1.0, 0.05)):
            yield {"ilc_lead": min(max(round(lead * lead_part), 1), 31), "ilc_gain": gain}, ""
    elif method == "rdc":
        for part in ROBUST_PARTS:
            yield rdc_parameters(plant, drive, part)
    else:
        for cutoff in SRC_CUTOFFS:
            period = 1.0 - math.sqrt(2.0) / cutoff / (2.0 * math.pi)
            yield {"src_cutoff_per_rad": cutoff, "src_period_turn": period}, ""


def rdc_parameters(plant: Numbers, drive: Numbers, part: float) -> tuple[dict[str, float], str]:
    """Model, Lyapunov row, and a robust term at this part of where it begins to chatter; 0: none."""
    from evenspin.design.rdc import RdcLoop, design
    from evenspin.tune.gains import complete

    full = complete(drive)
    loop = RdcLoop(
        kpp_per_s=full["position_kp_per_s"],
        kvp_a_per_rad_s=full["position_kv_a_per_rad_s"],
        ti_s=full["position_ti_s"],
        torque_per_a_nm=torque_per_a(plant),
        inertia_kgm2=plant["inertia_kgm2"],
        viscous_nms=plant["viscous_nms"],
        ts_s=full["speed_divider"] / plant["pwm_hz"],
        current_bandwidth_rad_s=full["current_kp_v_per_a"] / plant["lq_h"],
        interrupt_s=0.0 if full["speed_inline"] else 1.0 / plant["pwm_hz"],
        delay_samples=int(full["torque_delay_samples"]),
    )
    model = {"rdc_inertia_kgm2": plant["inertia_kgm2"], "rdc_viscous_nms": plant["viscous_nms"], "rdc_rho_nm": 0.0}
    try:
        found = design(loop, 0.0, 1.0)
    except InputError as error:
        return model, f"no robust term: {error}"
    if part == 0.0:
        return model, "without its robust term: the encoder is too coarse for it"
    rho = 0.1 * rated_torque(plant, drive)
    if not found.limit > 0.0:
        return model, "no robust term: the position loop is not stable by itself"
    sigma = rho / (part * found.limit)
    rows = [float(value) for value in found.p_row]
    if not 1e-6 <= sigma <= 1e6 or max(map(abs, rows)) > 1e6:
        return model, "no robust term: sigma is out of its range"
    names = ("rdc_p31", "rdc_p32", "rdc_p33")
    return model | dict(zip(names, rows, strict=True)) | {"rdc_rho_nm": rho, "rdc_sigma": sigma}, ""
