"""Functions without a memory: frames, modulation, interpolation, fal, friction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from evenspin.blocks.block import block_error
from evenspin.errors import BlockError
from evenspin.native.library import Library, load
from evenspin.native.refusal import read_refusal

TAPS_MAX = 4


def lagrange(order: int, frac: float, *, numeric: str = "float") -> list[float]:
    """Coefficients A_0 .. A_order of z^-frac: order 0 to 3, frac in 0 .. order."""
    library = load(numeric)
    if not isinstance(order, int) or not 0 <= order < TAPS_MAX:
        raise BlockError("order", order, f"must be a whole number within 0 .. {TAPS_MAX - 1}")
    return list(_call(library, "es_lagrange", order + 1, order, frac))


def fal(e: float, alpha: float, delta: float, *, numeric: str = "float") -> float:
    """|e|^alpha sgn(e), linear within +-delta."""
    return _call(load(numeric), "es_fal", 1, e, alpha, delta)[0]


def lambda_(e: float, alpha: float, delta: float, *, numeric: str = "float") -> float:
    """fal(e) / e; delta^(alpha-1) at e = 0."""
    return _call(load(numeric), "es_fal_lambda", 1, e, alpha, delta)[0]


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


def stribeck(v: float, coulomb: float, static: float, v_s: float, shape: float, *, numeric: str = "float") -> float:
    """Dry friction [coulomb + (static - coulomb) exp(-(|v| / v_s)^shape)] sgn(v), N m; 0 at v = 0.

    Args:
        v, v_s: speed and Stribeck speed, rad/s.
        coulomb, static: N m; static is the whole of it, at least coulomb.
        shape: within 0.1 .. 10.
    """
    return _call(load(numeric), "es_stribeck", 1, v, coulomb, static, v_s, shape)[0]


def rdc_robust_term(
    e: Sequence[float], p_row: Sequence[float], inertia: float, rho: float, sigma: float, *, numeric: str = "float"
) -> float:
    """Torque of the robust term: -rho sgn(s), inside |s| <= sigma the line -rho s / sigma; s = p_row . e / inertia.

    Args:
        e: integral of the angle error (rad s), angle error (rad), speed error (rad/s), each actual less command.
        p_row: third row of the Lyapunov matrix (`evenspin design rdc`).
        inertia: kg m^2, above 0.
        rho: largest torque, N m, at least 0.
        sigma: half width of the line, above 0.
    """
    library = load(numeric)
    for name, row in (("e", e), ("p_row", p_row)):
        if len(row) != 3:
            raise BlockError(name, len(row), "must be three numbers")
    rows = (library.ffi.new("double[3]", list(map(float, row))) for row in (e, p_row))
    return _call(library, "es_rdc_robust_term", 1, *rows, inertia, rho, sigma)[0]


def spatial_lowpass(
    cutoff_per_rad: float, speed: float, ts: float, *, numeric: str = "float"
) -> dict[str, list[float]]:
    """Coefficients of the spatial low-pass at one speed: y = (b0 x + b1 x1 + b2 x2 - a1 y1 - a2 y2) / a0, a0 = 1.

    W^2 / (s^2 + sqrt(2) W s + W^2), W = cutoff_per_rad |speed|, made discrete with the bilinear transform
    s = 2 (z - 1) / (ts (z + 1)) without prewarping. W ts / 2 must be at most 1.

    Args:
        cutoff_per_rad: corner over the angle, rad of phase per rad of motion, above 0.
        speed: rad/s.
        ts: sampling time, s, above 0.
    """
    library = load(numeric)
    b = library.ffi.new("double[3]")
    a = _call(library, "es_spatial_lowpass", 3, cutoff_per_rad, speed, ts, b)
    return {"b": list(b), "a": list(a)}


def _vector(library: Library, function: str, size: int, *arguments: float) -> Any:
    out = library.ffi.new(f"double[{size}]")
    getattr(library.lib, function)(*arguments, out)  # what it returns (limited, not finite) shows in the numbers, too
    return tuple(out[0:size])


def _call(library: Library, function: str, size: int, *arguments: Any) -> tuple[float, ...]:
    """A function that may refuse: `size` numbers, then why not."""
    out, error = library.ffi.new(f"double[{size}]"), library.ffi.new("es_error_t *")
    if not getattr(library.lib, function)(*arguments, out, error):
        raise block_error(read_refusal(library, error))
    return tuple(out)
