"""The control blocks of the firmware, called one by one. Nothing is computed here: every number comes from the C code.

    >>> from evenspin import blocks
    >>> rc = blocks.RepetitiveController(gain=0.6, lead=5, q=(0.45, 0.10), order=2, fal=(0.6, 0.4))
    >>> correction = rc.step(error, period_samples=58.82)

Every function and class takes `numeric="float"` (default) or `"fixed"`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from evenspin.errors import BlockError, did_you_mean
from evenspin.native.library import Library, load

__all__ = [
    "AngleMemory",
    "BlockError",
    "Deadbeat",
    "Fir",
    "MotionProfile",
    "MtSpeed",
    "Pi",
    "Pll",
    "Setpoint",
    "RepetitiveController",
    "TorqueObserver",
    "clarke",
    "fal",
    "inverse_clarke",
    "inverse_park",
    "lagrange",
    "lambda_",
    "park",
    "power",
    "rdc_robust_term",
    "sincos",
    "spatial_lowpass",
    "stribeck",
    "svm",
    "vector_limit",
]

_FAL_AT = {"input": 1, "output": 2}
_ANTI_WINDUP = {"hold": 0, "hold-outward": 1}
_MEMORY = {"keep": 0, "clear": 1, "angle": 2}
_WRITE = {"one": 0, "all": 1, "hat": 2}
_READ = {"linear": 0, "cubic": 1}
_OBSERVER = {"dob": 0, "ro": 1, "aro": 2}
_FIR_ORDER_MAX = 15
_FAR_RAD = 1e9
_LIMIT = 100.0  # inside what the fixed-point numeric holds


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


# ---- observers of the disturbance torque, deadbeat control ----------------------------------------------------------


class AngleMemory:
    """Learns a waveform over the angle: every grid point that the motion passes moves towards what was seen there.

    Args:
        cells: grid points per turn, 4 to 4096.
        gain: learning gain g of m <- q m + g (v - m), in (0, 1].
        forgetting: q, 0 to 1; 1 forgets nothing.
        write: of the points passed since the last sample "one" (the newest), "all", or "hat" (all, each with the
            average of the samples around it).
        read: "linear" between two points or "cubic" through four.
        limit: largest size of a stored value.
    """

    def __init__(
        self,
        cells: int,
        gain: float,
        forgetting: float = 1.0,
        write: str = "one",
        read: str = "linear",
        *,
        limit: float = _LIMIT,
        numeric: str = "float",
    ) -> None:
        self._library = library = load(numeric)
        handle = library.lib.es_angle_memory_new(
            _whole("cells", cells),
            gain,
            forgetting,
            _word("write", write, _WRITE),
            _word("read", read, _READ),
            limit,
        )
        self._handle = _owned(library, handle, library.lib.es_angle_memory_free)
        self._cells = int(cells)

    def write(self, theta: float, value: float) -> None:
        """One sample: `value` seen at the angle `theta`, rad; it may run on beyond a turn."""
        self._library.lib.es_angle_memory_write(self._handle, theta, value)

    def read(self, theta: float) -> float:
        """What was learned for the angle `theta`, rad."""
        return self._library.lib.es_angle_memory_read(self._handle, theta)

    @property
    def memory(self) -> list[float]:
        """The grid points; number i stands for the angle 2 pi i / cells."""
        out = self._library.ffi.new("double[]", self._cells)
        self._library.lib.es_angle_memory_cells(self._handle, out, self._cells)
        return list(out)

    @property
    def rejected(self) -> int:
        """Samples that were not finite, and jumps of the angle, since it was made."""
        return self._library.lib.es_angle_memory_rejected(self._handle)


class Fir:
    """Symmetric low-pass (Hamming window): linear phase, so its delay is the same at every frequency.

    Args:
        order: 0 to 15; it has order + 1 taps.
        cutoff_over_rate: corner over sampling rate, above 0 and below 0.5.
    """

    def __init__(self, order: int, cutoff_over_rate: float, *, numeric: str = "float") -> None:
        self._library = library = load(numeric)
        taps = library.ffi.new("double[]", _FIR_ORDER_MAX + 1)
        handle = library.lib.es_fir_new(_fir_order("order", order), cutoff_over_rate, taps)
        self._handle = _owned(library, handle, library.lib.es_fir_free)
        self.taps: list[float] = list(taps[0 : int(order) + 1])

    def step(self, x: float) -> float:
        """Advance one sample; returns the filtered value."""
        return self._library.lib.es_fir_step(self._handle, x)

    @property
    def delay_samples(self) -> float:
        """Half the order; it need not be a whole number."""
        return self._library.lib.es_fir_delay_samples(self._handle)


class TorqueObserver:
    """Measures the disturbance torque from the encoder and predicts it for the moment when a reference of now acts.

    Args:
        kind: "dob" (one state), "ro" (memory over time) or "aro" (memory over the angle).
        inertia_kgm2, viscous_nms: what it assumes of the mechanics.
        ts_s: sampling time.
        fir1, fir2: order and corner in Hz of the filters of speed and torque.
        actuation_samples: from a torque reference to the middle of its action.
        age_samples: age that it takes the measured torque to have; 0: the true one, from its filters.
        gain: learning gain a23 L_N, in (0, 1].
        forgetting: Q, 0 to 1.
        cells, write, read: as in AngleMemory.
    """

    def __init__(
        self,
        kind: str,
        inertia_kgm2: float,
        viscous_nms: float = 0.0,
        *,
        ts_s: float = 1e-4,
        fir1: tuple[int, float] = (9, 1000.0),
        fir2: tuple[int, float] = (10, 1000.0),
        actuation_samples: float = 2.0,
        age_samples: float = 0.0,
        gain: float = 0.05,
        forgetting: float = 1.0,
        cells: int = 200,
        write: str = "one",
        read: str = "linear",
        numeric: str = "float",
    ) -> None:
        self._library = library = load(numeric)
        handle = library.lib.es_observer_new(
            _word("kind", kind, _OBSERVER),
            inertia_kgm2,
            viscous_nms,
            ts_s,
            _fir_order("fir1 order", fir1[0]),
            fir1[1],
            _fir_order("fir2 order", fir2[0]),
            fir2[1],
            actuation_samples,
            age_samples,
            gain,
            forgetting,
            _whole("cells", cells),
            _word("write", write, _WRITE),
            _word("read", read, _READ),
        )
        self._handle = _owned(library, handle, library.lib.es_observer_free)
        self._seen = library.ffi.new("double[2]")

    def step(self, theta_m_rad: float, ref_last_nm: float = 0.0) -> float:
        """Angle now and torque reference of the last sample; returns the expected disturbance torque, N m."""
        return self._library.lib.es_observer_step(self._handle, theta_m_rad, ref_last_nm, self._seen)

    @property
    def speed_rad_s(self) -> float:
        """Filtered speed of the last step."""
        return self._seen[0]

    @property
    def torque_nm(self) -> float:
        """Disturbance torque measured in the last step; it acted `age_samples` ago. Positive drives forward."""
        return self._seen[1]

    @property
    def age_samples(self) -> float:
        """Age of the measured torque as the observer counts it."""
        return self._library.lib.es_observer_age_samples(self._handle)


class Deadbeat:
    """Deadbeat control of the dq currents: the reference is reached two samples later. SI units.

    Args:
        correction: gain with which what the model does not explain is learned, 0 to 0.5.
    """

    def __init__(
        self,
        r_ohm: float,
        ld_h: float,
        lq_h: float,
        psi_wb: float,
        pole_pairs: int,
        ts_s: float = 1e-4,
        correction: float = 0.1,
        *,
        numeric: str = "float",
    ) -> None:
        for name, value in (("ld_h", ld_h), ("lq_h", lq_h), ("ts_s", ts_s)):
            if not value > 0.0:
                raise BlockError(name, value, "must be above 0 and finite")
        if _whole("pole_pairs", pole_pairs) < 1:
            raise BlockError("pole_pairs", pole_pairs, "must be at least 1")
        self._library = library = load(numeric)
        handle = library.lib.es_deadbeat_new(r_ohm, ld_h, lq_h, psi_wb, int(pole_pairs), ts_s, correction)
        self._handle = _owned(library, handle, library.lib.es_deadbeat_free)
        self._in, self._out = library.ffi.new("double[7]"), library.ffi.new("double[2]")

    def step(
        self,
        current_a: tuple[float, float],
        reference_a: tuple[float, float],
        speed_m_rad_s: float,
        last_v: tuple[float, float],
    ) -> tuple[float, float]:
        """dq currents now and wanted, mechanical speed, dq voltage that acts now; returns the voltage for the next."""
        self._in[0:7] = [*current_a, *reference_a, speed_m_rad_s, *last_v]
        self._library.lib.es_deadbeat_step(self._handle, self._in, self._out)
        return self._out[0], self._out[1]


# ---- position drive ------------------------------------------------------------------------------------------------


def stribeck(v: float, coulomb: float, static: float, v_s: float, shape: float, *, numeric: str = "float") -> float:
    """Dry friction [coulomb + (static - coulomb) exp(-(|v| / v_s)^shape)] sgn(v), N m; 0 at v = 0.

    Args:
        v, v_s: speed and Stribeck speed, rad/s.
        coulomb, static: N m; static is the whole of it, at least coulomb.
        shape: within 0.1 .. 10.
    """
    library = load(numeric)
    out = library.ffi.new("double *")
    if not library.lib.es_stribeck(v, coulomb, static, v_s, shape, out):
        raise _refused(library, "coulomb, static", f"{coulomb}, {static}", "static at least coulomb")
    return out[0]


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
    out = library.ffi.new("double *")
    arguments = (library.ffi.new("double[3]", list(map(float, row))) for row in (e, p_row))
    if not library.lib.es_rdc_robust_term(*arguments, inertia, rho, sigma, out):
        raise _refused(library, "rho, sigma", f"{rho}, {sigma}", "rho at least 0, sigma above 0")
    return out[0]


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
    b, a = library.ffi.new("double[3]"), library.ffi.new("double[3]")
    if not library.lib.es_spatial_lowpass(cutoff_per_rad, speed, ts, b, a):
        raise _refused(library, "cutoff_per_rad, ts", f"{cutoff_per_rad}, {ts}", "above 0")
    return {"b": list(b), "a": list(a)}


@dataclass(frozen=True, slots=True)
class Setpoint:
    """What a motion profile hands out; `done`: at the target and at rest."""

    position_rad: float
    speed_rad_s: float
    acceleration_rad_s2: float
    done: bool


class MotionProfile:
    """A motion to a target, which may move, with limited speed, acceleration and jerk.

    Args:
        speed_rad_s: largest speed, above 0.
        accel_rad_s2: largest acceleration; 0: the speed jumps, and no acceleration is handed out.
        smooth_samples: 1 to 64; the jerk is accel_rad_s2 / (smooth_samples ts_s), twice that where accelerating turns
            into braking at once. 1: not limited.
        ts_s: sampling time.
    """

    def __init__(
        self,
        speed_rad_s: float,
        accel_rad_s2: float,
        smooth_samples: int = 1,
        ts_s: float = 1e-3,
        *,
        numeric: str = "float",
    ) -> None:
        self._library = library = load(numeric)
        handle = library.lib.es_profile_new(speed_rad_s, accel_rad_s2, _whole("smooth_samples", smooth_samples), ts_s)
        self._handle = _owned(library, handle, library.lib.es_profile_free)
        self._out = library.ffi.new("double[3]")

    def step(self, target_rad: float) -> Setpoint:
        """Advance one sample towards the target."""
        if not abs(target_rad) < _FAR_RAD:
            raise BlockError("target_rad", target_rad, f"must be within +-{_FAR_RAD:g}")
        done = self._library.lib.es_profile_step(self._handle, target_rad, self._out)
        position, speed, acceleration = self._out
        return Setpoint(position, speed, acceleration, done)

    def reset(self, position_rad: float = 0.0) -> None:
        """Stand there."""
        if not abs(position_rad) < _FAR_RAD:
            raise BlockError("position_rad", position_rad, f"must be within +-{_FAR_RAD:g}")
        self._library.lib.es_profile_reset(self._handle, position_rad)


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


def _fir_order(field: str, order: int) -> int:
    if not 0 <= _whole(field, order) <= _FIR_ORDER_MAX:
        raise BlockError(field, order, f"must be within 0 .. {_FIR_ORDER_MAX}")
    return int(order)


def _word(field: str, value: str, words: dict[str, int]) -> int:
    if value not in words:
        raise BlockError(field, value, f"must be {' or '.join(words)}; {did_you_mean(str(value), words)}")
    return words[value]


def _check_fal(alpha: float, delta: float) -> None:
    if not 0.0 < alpha <= 1.0:
        raise BlockError("alpha", alpha, "must be in (0, 1]")
    if not delta > 0.0:
        raise BlockError("delta", delta, "must be above 0")
