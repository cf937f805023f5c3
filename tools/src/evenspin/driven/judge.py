"""From the choice of terms to names: parameters with intervals, what else they may be, and when it is `unknown`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.verdict import OR
from evenspin.driven.ambiguous import Recorded, called
from evenspin.driven.bursts import bursts_of
from evenspin.effects.equations import Acting
from evenspin.gap.intervals import EXACT, Z95, Interval, of_effect, with_model_share
from evenspin.log.tolerance import TOLERANCES
from evenspin.weakform.analysis import Explained
from evenspin.weakform.fit import prior_of
from evenspin.weakform.noise import floors, noise_of
from evenspin.weakform.search import SHAFT_PARTS, Choice
from evenspin.weakform.terms import SHAFT, Kind

Array = NDArray[np.float64]

UNKNOWN = "unknown"
MOST = 0.98  # confidence: the table of effects is not all there is
TEMPER = 4.0  # cost that counts as one: what is left is not white
RIVAL = 12.0  # cost within which another choice explains the log as well
UNSURE = 7.0  # cost by which a choice without a name has to be worse: 7 to 3 for the name
MENTIONED = 40.0  # cost within which it is mentioned
LEFT_TIMES = 4.0  # of what noise leaves, from which something is left
LEFT_SHARE = 0.02  # of the rated torque, or of the largest voltage
SCALED = ("inertia", "viscous_friction", "winding_resistance")  # factors, of numbers in which the current is
FLUX = 0.0075  # of a model file, one standard deviation
BETWEEN_ROWS = 0.03
AT_LOW_SPEEDS = 0.16  # where nothing else shows it: five logs of another simulator were 6, 9, 10, 23 and 23 % too low
# Of a shaft: noise of the angle, as far as it is not known, looks like more damping and less load.
MODEL_SHARES = {"f_res_hz": 0.015, "load_ratio": 0.05, "damping_ratio": 0.5}
MOST_OF_A_SHAFT = 0.85  # confidence: a gap that is not seen looks the same
PWM_UNKNOWN = 1.0  # of a dead time: 10 kHz were assumed, and 5 to 20 kHz are common


@dataclass(frozen=True, slots=True)
class Gap:
    """rms of an equation on stretches that no fit saw."""

    log: str
    equation: str
    unit: str
    before: float
    after: float
    floor: float
    doubt: float = 0.0  # what the way of a dead time through zero current may make, which no log tells well


@dataclass
class Verdict:
    names: list[str] = field(default_factory=list)
    effects: list[Acting] = field(default_factory=list)  # those named; none where it is unknown
    at_start: list[Acting] = field(default_factory=list)  # in the model without a name: gone with time, or too little
    called: dict[str, str] = field(default_factory=dict)  # an effect with those that the log does not separate from it
    nearest: list[str] = field(default_factory=list)  # what came nearest where it is unknown
    confidence: dict[str, float] = field(default_factory=dict)
    intervals: dict[str, list[Interval]] = field(default_factory=dict)
    alternatives: list[tuple[str, float]] = field(default_factory=list)
    cannot_separate: dict[str, list[str]] = field(default_factory=dict)
    unexplained: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    gaps: list[Gap] = field(default_factory=list)

    @property
    def unknown(self) -> bool:
        return UNKNOWN in self.names

    def name(self, effect: str) -> str:
        return self.called.get(effect, effect)


EQUATIONS = (("torque_nm", "N m"), ("torque_fine_nm", "N m"), ("vd_v", "V"), ("vq_v", "V"))


def judge(found: Explained, pwm_known: bool = True, confirmed: bool = False, bounces: bool = False) -> Verdict:
    """`pwm_known`: else a dead time is known as lost voltage only, and its interval has all common PWM frequencies.
    `confirmed`: the causes that the table does not have are terms that unseen stretches confirm; the effects beside
    them keep their names where little else is left and no other choice is near. `bounces`: the load does, between the
    flanks of a gap, and no equation has the torque of that."""
    verdict = Verdict()
    verdict.gaps = gaps_of(found)
    weights = _weights(found.rivals)
    for name in found.named:
        if found.term(name).kind is Kind.EFFECT:
            _name(found, name, weights, verdict)
    if not pwm_known and "dead_time" in verdict.intervals:
        verdict.intervals["dead_time"] = [
            replace(i, half=max(i.half, PWM_UNKNOWN * i.value)) if i.parameter == "dead_time_s" else i
            for i in verdict.intervals["dead_time"]
        ]
    without_unsure(found, verdict)
    without_size(found, verdict)
    doubtful = [name for name in verdict.names if verdict.cannot_separate.get(name)]
    left = _left(found, verdict, bounces)
    if found.foreign and not confirmed:
        verdict.unexplained += [name.removeprefix("foreign: ") for name in found.foreign]
    if confirmed and not left:
        _beside(found, verdict)
    elif found.foreign or left:
        _none(verdict, verdict.names)
    elif doubtful:
        together = [f"{name} or {' or '.join(verdict.cannot_separate[name])}" for name in doubtful]
        verdict.warnings += [f"{text}: the log does not separate them" for text in together]
    near = {
        n
        for c in found.rivals
        if c.cost < found.rivals[0].cost + RIVAL
        for n in c.names
        if found.term(n).kind is Kind.FOREIGN
    }
    _together(found, verdict)
    if near and not verdict.unknown and verdict.names:
        verdict.warnings.append(
            f"{', '.join(sorted(n.removeprefix('foreign: ') for n in near))} would explain the log nearly as well"
        )
    return verdict


def without_unsure(found: Explained, verdict: Verdict) -> None:
    """A name that could be left out at nearly the same cost has none. It stays in the model that is written."""
    best = found.rivals[0]
    less = {choice.names for choice in found.rivals if choice.cost < best.cost + UNSURE}
    for name in found.named:
        effect = found.term(name).effect
        if effect in verdict.names and best.names - {name} in less:
            _without(verdict, effect, "would explain a little more, too little for a name")


def without_size(found: Explained, verdict: Verdict) -> None:
    """A name whose size the log does not tell from none has none: what it explains lies beyond what was driven, as
    with a friction that falls off below the lowest speed. It stays in the model that is written."""
    for name in found.named:
        term = found.term(name)
        if term.effect not in verdict.names:
            continue
        main = ~term.details
        size = (found.point[name] - term.off)[main]
        spread = _covariance(found, name)[np.ix_(main, main)]
        if float(size @ np.linalg.solve(spread, size)) < Z95**2:
            _without(verdict, term.effect, "the log does not tell its size from none")


def _without(verdict: Verdict, effect: str, why: str) -> None:
    verdict.names.remove(effect)
    verdict.at_start += [each for each in verdict.effects if each[0] == effect]
    verdict.effects = [each for each in verdict.effects if each[0] != effect]
    share = verdict.confidence.pop(effect)
    del verdict.intervals[effect]
    verdict.cannot_separate.pop(effect, None)
    verdict.alternatives.append((effect, share))
    verdict.warnings.append(f"{effect}: {why}")


def _together(found: Explained, verdict: Verdict) -> None:
    """Names with `or`, where the signals of the logs are the same for several effects; each is there once."""
    recorded = Recorded.of(found)
    for effect, params in list(verdict.effects):
        name, by = called(effect, params, recorded)
        alike = next(term.alike for term in map(found.term, found.named) if term.effect == effect)
        if alike:
            name, by = OR.join((effect, *alike)), "the angle of the load, or the log with a load that never lets go,"
        if name == effect:
            continue
        if name in verdict.called.values():
            verdict.effects.remove((effect, params))
            verdict.names.remove(effect)
            del verdict.confidence[effect], verdict.intervals[effect]
            continue
        verdict.called[effect] = name
        known = verdict.cannot_separate.setdefault(effect, [])
        known += [other for other in name.split(OR) if other != effect and other not in known]
        verdict.warnings.append(f"{name}: this log does not separate them; {by} would")


BESIDE = 0.9  # confidence of a name beside a term of no table


def _beside(found: Explained, verdict: Verdict) -> None:
    """`unknown` last; an effect that another choice could replace has no name."""
    unsure = [n for n in verdict.names if verdict.confidence[n] < BESIDE or verdict.cannot_separate.get(n)]
    verdict.nearest = unsure
    verdict.effects = [(name, params) for name, params in verdict.effects if name not in unsure]
    for name in unsure:
        del verdict.confidence[name], verdict.intervals[name]
        verdict.cannot_separate.pop(name, None)
    verdict.names = [*(n for n in verdict.names if n not in unsure), UNKNOWN]


def _none(verdict: Verdict, nearest: Sequence[str]) -> None:
    verdict.nearest = list(nearest)
    verdict.names = [UNKNOWN]
    verdict.effects = []
    verdict.confidence = {}
    verdict.intervals = {}
    verdict.cannot_separate = {}


def _weights(rivals: Sequence[Choice]) -> list[float]:
    cost = np.array([each.cost for each in rivals])
    weight = np.exp(-0.5 * (cost - cost.min()) / TEMPER)
    return list(weight / weight.sum())


def _effects_of(found: Explained, names: frozenset[str]) -> set[str]:
    return {found.term(name).effect or name for name in names}


def _name(found: Explained, name: str, weights: Sequence[float], verdict: Verdict) -> None:
    term = found.term(name)
    assert term.hypothesis is not None
    effect, z = term.effect, found.point[name]
    verdict.names.append(effect)
    verdict.effects.append((effect, term.hypothesis.to_params(z)))
    has = [effect in _effects_of(found, choice.names) for choice in found.rivals]
    share = sum(w for w, h in zip(weights, has, strict=True) if h)
    verdict.confidence[effect] = round(min(MOST_OF_A_SHAFT if effect == SHAFT else MOST, share), 3)
    verdict.intervals[effect] = _intervals(found, name)
    best = found.rivals[0]
    for choice, with_it in zip(found.rivals, has, strict=True):
        behind = choice.cost - best.cost
        if with_it or behind > MENTIONED:
            continue
        others = sorted(_effects_of(found, choice.names) - _effects_of(found, best.names))
        others = [other for other in others if not other.startswith("foreign")]
        if not others:
            continue
        text = " + ".join(others)
        if text not in [known for known, _ in verdict.alternatives]:
            verdict.alternatives.append((text, round(math.exp(-0.5 * behind / TEMPER), 4)))
        if behind < RIVAL:
            known = verdict.cannot_separate.setdefault(effect, [])
            known += [other for other in others if other not in known]


def _intervals(found: Explained, name: str) -> list[Interval]:
    """From the covariance of the fit, with what a healthy unit of the type may differ by itself."""
    term = found.term(name)
    assert term.hypothesis is not None
    part = _covariance(found, name)
    factor = term.hypothesis.to_params(found.point[name]).get("factor", 1.0)  # a tolerance of which is a share of it
    for tolerance in TOLERANCES:
        if tolerance.effect == term.effect and tolerance.sensor is None:
            part += np.diag(np.full(len(term), (factor * tolerance.sigma) ** 2))
    for k, tolerance in enumerate(t for t in TOLERANCES if t.effect == term.effect and t.sensor is not None):
        part[k, k] += max(tolerance.sigma, found.tolerances.gain if term.effect == "current_gain" else 0.0) ** 2
    return [_scaled(found, i) for i in with_model_share(of_effect(term.hypothesis, found.point[name], part))]


def _covariance(found: Explained, name: str) -> Array:
    """Of the coordinates of a named term, by the fit."""
    whole = np.linalg.inv(found.normal.h + prior_of(found.model.terms, found.named))
    own = _place(found, name)
    return np.array(whole[own, own], dtype=np.float64)


def _place(found: Explained, name: str) -> slice:
    """Of the coordinates of a term, among those of all."""
    at = 0
    for each in found.model.terms:
        if each.name == name:
            break
        at += len(each)
    return slice(at, at + len(found.term(name)))


def over_all(found: Explained, effect: str) -> bool:
    """Whether a named term changes an equation over all windows by as much as has to be seen, rms."""
    name = next(name for name in found.named if found.term(name).effect == effect)
    own = _place(found, name)
    size = found.point[name] - found.term(name).off
    torque_nm = found.tolerances.torque * found.scale.rated_torque_nm
    volts = found.tolerances.volts * found.model.logs[0].plant["dc_link_v"]
    return any(
        float(size @ gram[own, own] @ size) > (torque_nm if kind < SHAFT_PARTS else volts) ** 2
        for gram, kind in zip(found.normal.grams, found.normal.kinds, strict=True)
    )


def _scaled(found: Explained, i: Interval) -> Interval:
    """Wider by what no log tells: the gain of both current sensors together, which is a scale of all torque and of the
    resistance, half as much where a load sensor has one of its own; without voltages the flux, too. A line of high
    order hangs on when, between two rows, each column was taken."""
    share = MODEL_SHARES.get(i.parameter, 0.0) if i.effect == SHAFT else 0.0
    if i.field.unit == "N m" or i.effect in SCALED:
        loaded = any(each.signals.loaded(found.scale.rated_torque_nm) for each in found.recordings)
        share = (0.5 if loaded else 1.0) * found.tolerances.gain
        if not any(each.signals.has_voltages for each in found.recordings):
            flux = next((t.held[0] for t in found.model.terms if t.name == "torque_constant"), FLUX)
            share = math.hypot(share, float(flux))
    if i.effect == "flux_harmonics":
        share = BETWEEN_ROWS if over_all(found, i.effect) else AT_LOW_SPEEDS
    return i if i.field.role in EXACT else replace(i, half=math.hypot(i.half, Z95 * share * abs(i.value)))


def gaps_of(found: Explained) -> list[Gap]:
    gaps = []
    for log, recording in enumerate(found.recordings):
        floor = floors(recording.equations, noise_of(recording.signals))
        doubt = _doubt(found, log)
        for k in range(len(found.after[log])):
            if k == 1:  # the torque again, over shorter windows
                continue
            rows = recording.unseen[k]
            before, after = (_rms(parts[log][k][rows]) for parts in (found.before, found.after))
            unsure = _rms(doubt[k][rows]) if doubt is not None else 0.0
            gaps.append(Gap(recording.signals.name, *EQUATIONS[k], before, after, floor[k], unsure))
    return gaps


def _doubt(found: Explained, log: int) -> list[Array] | None:
    """What changes where the loss of a named dead time goes through zero current over all that the loss moves it."""
    name = next((each for each in found.named if found.term(each).effect == "dead_time"), None)
    if name is None:
        return None
    plant = found.recordings[log].equations.plant
    z = found.point[name].copy()
    z[1] += z[0] * plant["dc_link_v"] / min(plant["ld_h"], plant["lq_h"])
    other = found.model.residual({**found.point, name: z}, log)
    return [a - b for a, b in zip(other, found.after[log], strict=True)]


def _left(found: Explained, verdict: Verdict, bounces: bool) -> bool:
    """Is more left than noise and the tolerances of the equations themselves, on the whole or now and then?"""
    much = []
    for gap in verdict.gaps:
        if bounces and gap.unit == "N m":
            continue
        recording = next(each for each in found.recordings if each.signals.name == gap.log)
        s = recording.signals
        scale = found.scale.rated_torque_nm
        if gap.unit == "V" and s.vq_v is not None and s.vd_v is not None:
            scale = float(np.percentile(np.hypot(s.vd_v, s.vq_v), 99.0))
        if gap.after > LEFT_TIMES * math.hypot(gap.floor, gap.doubt) and gap.after > LEFT_SHARE * scale:
            much.append(
                f"{gap.log}: {gap.after:.3g} {gap.unit} rms of {gap.equation} are left where noise leaves "
                f"{gap.floor:.3g}"
            )
    if not bounces:
        much += [str(bursts) for bursts in bursts_of(found)]
    verdict.unexplained += much
    return bool(much)


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x * x))) if len(x) else math.nan
