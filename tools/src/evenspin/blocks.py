"""The control blocks of the firmware, called one by one. Nothing is computed here: every number comes from the C code.

    >>> from evenspin import blocks
    >>> rc = blocks.RepetitiveController(gain=0.6, lead=5, q=(0.45, 0.10), order=2, fal=(0.6, 0.4))
    >>> correction = rc.step(error, period_samples=58.82)

Every function and class takes `numeric="float"` (default) or `"fixed"`.
"""

from __future__ import annotations

from typing import Any

from evenspin.errors import BlockError, did_you_mean
from evenspin.native.library import Library, load

__all__ = [
    "BlockError",
    "MtSpeed",
    "Pi",
    "Pll",
    "RepetitiveController",
    "clarke",
    "fal",
    "inverse_clarke",
    "inverse_park",
    "lagrange",
    "lambda_",
    "park",
    "power",
    "sincos",
    "svm",
    "vector_limit",
]

_FAL_AT = {"input": 1, "output": 2}
_ANTI_WINDUP = {"hold": 0, "hold-outward": 1}
_MEMORY = {"keep": 0, "clear": 1, "angle": 2}


# ---- functions -----------------------------------------------------------------------------------------------------


def lagrange(order: int, frac: float, *, numeric: str = "float") -> list[float]:
    """Coefficients A_0 .. A_order of z^-frac: order 0 to 3, frac in 0 .. order."""
    library = load(numeric)
    out = library.ffi.new("double[4]")
    count = library.lib.es_lagrange(order, frac, out)
    if count == 0:
        raise _refused(library, "order, frac", f"{order}, {frac}", "order 0 .. 3, frac within 0 .. order")
    return list(out[0:count])


def fal(e: float, alpha: float, delta: float, *, numeric: str = "float") -> float:
    """|e|^alpha sgn(e), linear within +-delta."""
    _check_fal(alpha, delta)
    return load(numeric).lib.es_fal(e, alpha, delta)


def lambda_(e: float, alpha: float, delta: float, *, numeric: str = "float") -> float:
    """fal(e) / e; delta^(alpha-1) at e = 0."""
    _check_fal(alpha, delta)
    return load(numeric).lib.es_fal_lambda(e, alpha, delta)


def sincos(angle_rad: float, *, numeric: str = "float") -> tuple[float, float]:
    """Sine and cosine."""
    library = load(numeric)
    sine, cosine = library.ffi.new("double *"), library.ffi.new("double *")
    library.lib.es_sincos(angle_rad, sine, cosine)
    return sine[0], cosine[0]


def power(base: float, exponent: float, *, numeric: str = "float") -> float:
    """base^exponent without libm, for base >= 0."""
    return load(numeric).lib.es_pow(base, exponent)


def clarke(a: float, b: float, c: float, *, numeric: str = "float") -> tuple[float, float]:
    """Phases to alpha, beta (amplitude-invariant)."""
    return _vector(load(numeric), "es_clarke", 2, a, b, c)


def inverse_clarke(alpha: float, beta: float, *, numeric: str = "float") -> tuple[float, float, float]:
    """alpha, beta to phases a, b, c."""
    return _vector(load(numeric), "es_inverse_clarke", 3, alpha, beta)


def park(alpha: float, beta: float, angle_rad: float, *, numeric: str = "float") -> tuple[float, float]:
    """alpha, beta to d, q at this electrical angle."""
    return _vector(load(numeric), "es_park", 2, alpha, beta, angle_rad)


def inverse_park(d: float, q: float, angle_rad: float, *, numeric: str = "float") -> tuple[float, float]:
    """d, q to alpha, beta at this electrical angle."""
    return _vector(load(numeric), "es_inverse_park", 2, d, q, angle_rad)


def vector_limit(d: float, q: float, limit: float, *, numeric: str = "float") -> tuple[float, float]:
    """The vector, shortened to `limit` in its own direction."""
    return _vector(load(numeric), "es_vector_limit", 2, d, q, limit)


def svm(v_alpha: float, v_beta: float, v_dc: float, *, numeric: str = "float") -> tuple[float, float, float]:
    """Duty cycles of the three half bridges, each in [0, 1]; voltages in V."""
    return _vector(load(numeric), "es_svm", 3, v_alpha, v_beta, v_dc)


# ---- blocks with a memory ------------------------------------------------------------------------------------------


class RepetitiveController:
    """Repetitive controller: CRC (order 0), FORC (order 1 to 3), fal-FORC (with `fal`).

    Args:
        gain: learning gain k_rc.
        lead: phase lead m, samples.
        q: outer and middle tap of Q(z) = side z + centre + side z^-1.
        order: Lagrange order of the fractional delay; 0 takes whole samples.
        fal: (alpha, delta), or None.
        fal_at: "input" of the memory (A) or "output" of the controller, as lambda (B).
        truncate: order 0: cut the period to whole samples; False rounds to the nearest.
        capacity: samples that the memory holds (memory="angle": cells per electrical turn).
        memory: on a change of the period "keep" or "clear" the samples, or index them by "angle".
        limit: largest correction, unit of the error.
        freeze_above: learning stops while the error was larger within the last `freeze_samples`; 0: never.
    """

    def __init__(
        self,
        gain: float,
        lead: int,
        q: tuple[float, float] = (0.45, 0.10),
        order: int = 2,
        fal: tuple[float, float] | None = None,
        fal_at: str = "input",
        truncate: bool = True,
        capacity: int = 512,
        *,
        memory: str = "keep",
        limit: float = 1000.0,
        freeze_above: float = 0.0,
        freeze_samples: int = 80,
        numeric: str = "float",
    ) -> None:
        side, centre = q
        alpha, delta = (1.0, 1.0) if fal is None else fal
        where = _word("fal_at", fal_at, _FAL_AT)
        self._library = library = load(numeric)
        handle = library.lib.es_rc_new(
            gain,
            _whole("lead", lead),
            side,
            centre,
            _whole("order", order),
            0 if fal is None else where,
            alpha,
            delta,
            truncate,
            _word("memory", memory, _MEMORY),
            _whole("capacity", capacity),
            limit,
            freeze_above,
            _whole("freeze_samples", freeze_samples),
        )
        self._handle = _owned(library, handle, library.lib.es_rc_free)

    def step(self, error: float, period_samples: float, theta_e_rad: float = 0.0) -> float:
        """Advance one sample; returns the correction to add to the error."""
        return self._library.lib.es_rc_step(self._handle, error, period_samples, theta_e_rad)

    def reset(self) -> None:
        """Forget what was learned."""
        self._library.lib.es_rc_reset(self._handle)

    @property
    def rejected(self) -> int:
        """Errors that were not finite, since it was made."""
        return self._library.lib.es_rc_rejected(self._handle)


class Pi:
    """PI controller: `output` proposes, `commit` tells it what was realised.

    While limited the integrator rests ("hold"), or only if the error pushes further out ("hold-outward").
    """

    def __init__(
        self,
        kp: float,
        ki_ts: float,
        out_min: float,
        out_max: float,
        *,
        anti_windup: str = "hold",
        numeric: str = "float",
    ) -> None:
        self._library = library = load(numeric)
        mode = _word("anti_windup", anti_windup, _ANTI_WINDUP)
        handle = library.lib.es_pi_new(kp, ki_ts, out_min, out_max, mode)
        self._handle = _owned(library, handle, library.lib.es_pi_free)

    def output(self, error: float) -> float:
        return self._library.lib.es_pi_output(self._handle, error)

    def commit(self, realised: float) -> None:
        self._library.lib.es_pi_commit(self._handle, realised)

    def step(self, error: float) -> float:
        """Propose and realise at once."""
        out = self.output(error)
        self.commit(out)
        return out

    def reset(self, integrator: float = 0.0) -> None:
        self._library.lib.es_pi_reset(self._handle, integrator)


class Pll:
    """Tracking filter: angle in, speed out. Gains in 1/s and 1/s^2."""

    def __init__(self, kp: float, ki: float, ts_s: float, *, numeric: str = "float") -> None:
        self._library = library = load(numeric)
        self._handle = _owned(library, library.lib.es_pll_new(kp, ki, ts_s), library.lib.es_pll_free)

    def step(self, angle_rad: float) -> float:
        """Advance one sample; returns the speed, rad/s."""
        return self._library.lib.es_pll_step(self._handle, angle_rad)

    def reset(self, angle_rad: float = 0.0) -> None:
        self._library.lib.es_pll_reset(self._handle, angle_rad)


class MtSpeed:
    """Speed from encoder counts over the time between edges."""

    def __init__(self, counts_per_rev: int, clock_hz: float, ts_s: float, *, numeric: str = "float") -> None:
        self._library = library = load(numeric)
        handle = library.lib.es_mt_new(_whole("counts_per_rev", counts_per_rev), clock_hz, ts_s)
        self._handle = _owned(library, handle, library.lib.es_mt_free)

    def step(self, edge_count: int, edge_cyc: int, now_cyc: int) -> float:
        """Counter at the last edge, its time and the time now in clock cycles; returns the speed, rad/s."""
        return self._library.lib.es_mt_step(self._handle, edge_count, edge_cyc % 2**32, now_cyc % 2**32)


# ---- helpers -------------------------------------------------------------------------------------------------------


def _vector(library: Library, function: str, size: int, *arguments: float) -> Any:
    out = library.ffi.new(f"double[{size}]")
    getattr(library.lib, function)(*arguments, out)  # what it returns (limited, not finite) shows in the numbers, too
    return tuple(out[0:size])


def _owned(library: Library, handle: Any, free: Any) -> Any:
    if handle == library.ffi.NULL:
        raise _refused(library, "parameters", "given", "refused")
    return library.ffi.gc(handle, free)


def _refused(library: Library, field: str, value: str, limit: str) -> BlockError:
    """What the block says ("field = value: limit"), or else what the caller knows."""
    said = library.text(library.lib.es_block_error())
    if " = " in said and ": " in said:
        field, _, rest = said.partition(" = ")
        text, _, limit = rest.partition(": ")
        try:
            return BlockError(field, float(text), limit)
        except ValueError:
            return BlockError(field, text, limit)
    return BlockError(field, value, limit)


def _whole(field: str, value: int) -> int:
    if isinstance(value, bool) or not -(2**31) <= value < 2**31 or int(value) != value:
        raise BlockError(field, value, "must be a whole number of 32 bits")
    return int(value)


def _word(field: str, value: str, words: dict[str, int]) -> int:
    if value not in words:
        raise BlockError(field, value, f"must be {' or '.join(words)}; {did_you_mean(str(value), words)}")
    return words[value]


def _check_fal(alpha: float, delta: float) -> None:
    if not 0.0 < alpha <= 1.0:
        raise BlockError("alpha", alpha, "must be in (0, 1]")
    if not delta > 0.0:
        raise BlockError("delta", delta, "must be above 0")
