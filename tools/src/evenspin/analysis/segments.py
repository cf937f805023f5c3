"""A run in pieces: from one change to the next, and what the drive did in each."""

from __future__ import annotations

import bisect
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from evenspin.analysis.distortion import distortion_pct, space_vector
from evenspin.analysis.orders import order_amplitudes
from evenspin.analysis.transients import dip, overshoot
from evenspin.model.setup import InputCurve, Setup
from evenspin.sim.record import Record

RAD_S = np.pi / 30.0  # one rpm
WINDOW_S = 1.9  # steady state: the last 1.9 s before the next change

# What `measure_segment` needs.
SIGNALS = (
    "t_s",
    "true_speed_rad_s",
    "true_theta_m_rad",
    "true_iq_a",
    "true_ia_a",
    "true_ib_a",
    "true_ic_a",
)


@dataclass(frozen=True, slots=True)
class Segment:
    """From `start_s` to the next change at `end_s`; `changed` are the inputs that changed at its start."""

    start_s: float
    end_s: float
    changed: tuple[str, ...]
    speed_ref_rad_s: float

    @property
    def steady_s(self) -> float:
        """Start of the window of the steady state: at most the last WINDOW_S, at least the second half."""
        return max(self.end_s - WINDOW_S, (self.start_s + self.end_s) / 2.0)


def segments(setup: Setup) -> list[Segment]:
    """The pieces of a run."""
    cuts = [0.0, *_merged(setup.event_times_s), setup.duration_s]
    found = []
    for start_s, end_s in zip(cuts[:-1], cuts[1:], strict=True):
        curves = setup.inputs.items()
        changed = [name for name, curve in curves if any(abs(t - start_s) < 1e-6 for t in curve.changes_s)]
        changed += [tune.param for tune in setup.tunes if abs(tune.t_s - start_s) < 1e-6]
        reference = setup.inputs.get("speed_ref_rad_s")
        ref_rad_s = value_at(reference, start_s + 1e-6) if reference is not None else 0.0
        found.append(Segment(start_s, end_s, tuple(changed), ref_rad_s))
    return found


def value_at(curve: InputCurve, t_s: float) -> float:
    """An input at one instant."""
    if curve.linear:
        return float(np.interp(t_s, curve.t_s, curve.value))
    return curve.value[max(bisect.bisect_right(curve.t_s, t_s) - 1, 0)]


def measure_segment(record: Record, segment: Segment, pole_pairs: float) -> dict[str, float]:
    """Ripple of the steady state and what happened since the change. Speeds in rpm, from the true rotor."""
    whole = record.between(segment.start_s, segment.end_s)
    steady = whole.between(segment.steady_s, segment.end_s)
    if len(steady) < 2:
        return {}
    speed, iq_a = steady["true_speed_rad_s"], steady["true_iq_a"]
    theta = pole_pairs * np.unwrap(steady["true_theta_m_rad"])
    n1, n2 = percent(order_amplitudes(speed, theta), speed.mean())
    q1, q2 = percent(order_amplitudes(iq_a, theta), iq_a.mean())
    stator = space_vector(steady["true_ia_a"], steady["true_ib_a"], steady["true_ic_a"])
    return {
        "start_s": segment.start_s,
        "end_s": segment.end_s,
        "speed_ref_rpm": segment.speed_ref_rad_s / RAD_S,
        "speed_mean_rpm": float(speed.mean() / RAD_S),
        "iq_mean_a": float(iq_a.mean()),
        "n1_pct": n1,
        "n2_pct": n2,
        "q1_pct": q1,
        "q2_pct": q2,
        "distortion_pct": distortion_pct(stator, theta),
        "overshoot_rpm": overshoot(whole["true_speed_rad_s"], segment.speed_ref_rad_s) / RAD_S,
        "dip_rpm": dip(whole["true_speed_rad_s"], segment.speed_ref_rad_s) / RAD_S,
    }


def percent(amplitudes: Iterable[float], mean: float) -> list[float]:
    """In % of the mean; nan where there is no mean."""
    return [100.0 * float(a) / abs(float(mean)) if abs(mean) > 1e-6 else float("nan") for a in amplitudes]


def _merged(times_s: Sequence[float]) -> list[float]:
    """Instants closer than a microsecond are one: a step between straight lines takes a nanosecond."""
    kept: list[float] = []
    for t in times_s:
        if kept and t - kept[-1] < 1e-6:
            kept.pop()
        kept.append(t)
    return kept
