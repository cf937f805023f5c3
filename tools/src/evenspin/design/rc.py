"""Stability and gain of a repetitive controller plugged into a speed loop.

    stable if   |Q (1 - k_rc z^m M)| < 1   for every frequency                                             (1)
    sufficient  k_rc < 2 min cos(phase) / max|M|, |phase| < 90 deg, where Q is close to 1                  (2)
    gain        |1 + G_RC|,  G_RC = k_rc z^m Q D / (1 - Q D),  D ~ z^-N                                    (3)

z^m in (3) has magnitude 1 and moves the phase only; the gain is stated at the frequency of the ripple.
fal multiplies k_rc by up to lambda_max = delta^(alpha-1) for small errors.

Source   Guo et al. 2024, equations 9, 18, 26, 31 and 32.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from evenspin.blocks import lagrange, lambda_
from evenspin.errors import InputError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

PHASE_BAND_HZ = 40.0  # (2) is evaluated up to here: the ripple of the paper's speeds
POINTS = 4000
LEADS = range(0, 11)
NEAR = 1.005  # leads whose contraction is within half a percent of the best are as good


class Loop(Protocol):
    """A speed loop: as the paper has it (design/loop.py), or as the drive runs it (design/sampled.py)."""

    @property
    def ts_s(self) -> float: ...

    def closed(self, f_hz: Array) -> Complex:
        """M: speed reference to speed."""
        ...

    def as_json(self) -> dict[str, float]: ...


@dataclass(frozen=True, slots=True)
class Repetitive:
    """Parameters of the controller."""

    gain: float = 0.6
    lead: int = 5
    q_side: float = 0.45
    q_centre: float = 0.10
    order: int = 2
    fal: tuple[float, float] | None = None
    q_side2: float = 0.0

    @property
    def q_taps(self) -> list[float]:
        """Of Q(z), three or five, newest first."""
        three = [self.q_side, self.q_centre, self.q_side]
        return [self.q_side2, *three, self.q_side2] if self.q_side2 else three

    @property
    def beyond(self) -> int:
        """Samples that five taps of Q read beyond three, on either side."""
        return 1 if self.q_side2 else 0

    @property
    def shortest(self) -> int:
        """Shortest period that the block takes, samples."""
        return self.lead + 2 + self.ahead + self.beyond

    @property
    def lambda_max(self) -> float:
        """Largest gain of fal, from the block itself; 1 without fal."""
        return lambda_(0.0, *self.fal) if self.fal is not None else 1.0

    @property
    def ahead(self) -> int:
        """Samples that the interpolation reads beside its place (repetitive.h)."""
        return 1 if self.order > 2 else 0

    def q(self, f_hz: Array, ts_s: float) -> Array:
        angle = 2.0 * np.pi * f_hz * ts_s
        return self.q_centre + 2.0 * self.q_side * np.cos(angle) + 2.0 * self.q_side2 * np.cos(2.0 * angle)

    @property
    def q_peak(self) -> float:
        """Largest |Q| of all frequencies: a parabola in the cosine, at its ends or its vertex."""
        cosines = [1.0, -1.0]
        if abs(self.q_side) < abs(4.0 * self.q_side2):
            cosines.append(-self.q_side / (4.0 * self.q_side2))
        values = (self.q_centre + 2.0 * self.q_side * x + 2.0 * self.q_side2 * (2.0 * x * x - 1.0) for x in cosines)
        return max(abs(value) for value in values)


@dataclass(frozen=True, slots=True)
class Margins:
    """What (1) and (2) say for one lead."""

    lead: int
    phase_deg: float  # largest |phase of z^m M| up to PHASE_BAND_HZ
    phase_90_hz: float  # up to here |phase| < 90 deg
    bound_sufficient: float  # on k_rc, (2)
    bound: float  # on k_rc, (1)
    bound_hz: float  # where it is reached
    contraction: float  # max |Q (1 - k_rc z^m M)|
    contraction_hz: float


@dataclass(frozen=True, slots=True)
class Design:
    """Everything `evenspin design rc` reports."""

    loop: Loop
    rc: Repetitive
    max_m: float
    max_m_hz: float
    lambda_max: float
    margins: Margins
    by_lead: tuple[Margins, ...]
    recommended_lead: int

    @property
    def stable(self) -> bool:
        return self.rc.gain * self.lambda_max < self.margins.bound


def frequencies(ts_s: float) -> Array:
    """From close to 0 to the Nyquist frequency."""
    return np.linspace(0.0, 0.5 / ts_s, POINTS + 1)[1:]


def design(loop: Loop, rc: Repetitive) -> Design:
    """Margins of this controller in this loop, and of other leads."""
    f_hz = frequencies(loop.ts_s)
    closed = loop.closed(f_hz)
    by_lead = tuple(margins(loop, rc, closed, f_hz, lead) for lead in LEADS)
    own = margins(loop, rc, closed, f_hz, rc.lead)
    peak = int(np.argmax(np.abs(closed)))
    return Design(
        loop=loop,
        rc=rc,
        max_m=float(np.abs(closed[peak])),
        max_m_hz=float(f_hz[peak]),
        lambda_max=rc.lambda_max,
        margins=own,
        by_lead=by_lead,
        recommended_lead=_recommend(by_lead, loop, rc, closed, f_hz),
    )


def margins(loop: Loop, rc: Repetitive, closed: Complex, f_hz: Array, lead: int) -> Margins:
    """(1) and (2) for one lead; `closed` is M at f_hz."""
    ahead = closed * np.exp(2j * np.pi * f_hz * loop.ts_s * lead)
    q = rc.q(f_hz, loop.ts_s)
    phase = np.unwrap(np.angle(ahead))
    band = f_hz <= PHASE_BAND_HZ
    worst_phase = float(np.abs(phase[band]).max())
    beyond = np.flatnonzero(np.abs(phase) > np.pi / 2)
    bounds = gain_bound(ahead, q)
    contraction = np.abs(q * (1.0 - rc.gain * rc.lambda_max * ahead))
    at, slow = int(np.argmin(bounds)), int(np.argmax(contraction))
    return Margins(
        lead=lead,
        phase_deg=float(np.degrees(worst_phase)),
        phase_90_hz=float(f_hz[beyond[0]] if len(beyond) else f_hz[-1]),
        bound_sufficient=float(max(0.0, 2.0 * np.cos(min(worst_phase, np.pi / 2)) / np.abs(closed).max())),
        bound=float(bounds[at]),
        bound_hz=float(f_hz[at]),
        contraction=float(contraction[slow]),
        contraction_hz=float(f_hz[slow]),
    )


def gain_bound(ahead: Complex, q: Array) -> Array:
    """Largest k for which |q (1 - k ahead)| stays below 1, for each frequency.

    |1 - k H|^2 < 1 / q^2 is quadratic in k: |H|^2 k^2 - 2 Re(H) k + 1 - 1/q^2 < 0.
    """
    square = np.abs(ahead) ** 2
    room = 1.0 - 1.0 / np.maximum(q**2, 1e-12)
    inside = ahead.real**2 - square * room
    with np.errstate(invalid="ignore"):
        bound = (ahead.real + np.sqrt(inside)) / square
    return np.where(inside < 0.0, 0.0, np.maximum(bound, 0.0))


def gain_db(rc: Repetitive, period_samples: float, f_hz: Array, ts_s: float, *, whole: bool = False) -> Array:
    """|1 + G_RC| in dB at these frequencies; `whole`: the period is cut to samples (CRC)."""
    ahead = 0 if whole else rc.ahead
    least = rc.lead + 2 + ahead + rc.beyond
    if not period_samples >= least:
        limit = f"at least lead + {least - rc.lead} = {least} samples"
        raise InputError("design rc", "period", period_samples, limit, "lower the speed or the lead")
    z = np.exp(2j * np.pi * np.asarray(f_hz, dtype=float) * ts_s)
    whole_part = np.floor(period_samples + 1e-9)
    delay = z**-whole_part
    if not whole:
        taps = lagrange(rc.order, float(max(period_samples - whole_part, 0.0)) + ahead)
        delay = delay * sum(a * z ** (ahead - k) for k, a in enumerate(taps))
    q_delay = rc.q(np.asarray(f_hz, dtype=float), ts_s) * delay
    response = 1.0 + rc.gain * z**rc.lead * q_delay / (1.0 - q_delay)
    return 20.0 * np.log10(np.abs(response))


def as_json(found: Design) -> dict[str, Any]:
    """The design as plain numbers."""
    from dataclasses import asdict

    return {
        "loop": found.loop.as_json(),
        "rc": asdict(found.rc),
        "max_m": found.max_m,
        "max_m_hz": found.max_m_hz,
        "lambda_max": found.lambda_max,
        "stable": found.stable,
        "k_rc_bound": found.margins.bound / found.lambda_max,
        "k_rc_bound_sufficient": found.margins.bound_sufficient / found.lambda_max,
        "recommended_lead": found.recommended_lead,
        "margins": asdict(found.margins),
        "by_lead": [asdict(each) for each in found.by_lead],
    }


def _recommend(by_lead: tuple[Margins, ...], loop: Loop, rc: Repetitive, closed: Complex, f_hz: Array) -> int:
    """The lead with the smallest contraction; among near equals the one that is best on average in the band."""
    best = min(each.contraction for each in by_lead)
    near = [each.lead for each in by_lead if each.contraction <= NEAR * best]
    band = f_hz <= PHASE_BAND_HZ

    def mean_contraction(lead: int) -> float:
        ahead = closed[band] * np.exp(2j * np.pi * f_hz[band] * loop.ts_s * lead)
        return float(np.abs(rc.q(f_hz[band], loop.ts_s) * (1.0 - rc.gain * rc.lambda_max * ahead)).mean())

    return min(near, key=mean_contraction)
