"""Make the golden vectors of the tests of control/, or check that the committed ones are up to date.

    python3 tests/control/golden/make_golden.py            write the headers beside this file
    python3 tests/control/golden/make_golden.py --check    compare, write nothing; exit status 1 when one is stale

Nothing here is a translation of the C: every vector comes from the equation of the paper by another road (moment
equations, complex numbers, sector times, transfer functions, exact fractions, decimals of 40 digits), in double
precision or better. Only the standard library is used, so the check runs everywhere.

Inputs are whole multiples of 2^-16 wherever possible: exact in float and in fixed point, so that a difference in the
result is the block's own. Noise comes from the generator that tests/support/numeric.h has, too.
"""

from __future__ import annotations

import cmath
import itertools
import math
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal, getcontext
from fractions import Fraction
from pathlib import Path

HERE = Path(__file__).resolve().parent
COMMAND = "python3 tests/control/golden/make_golden.py"
SAME = 1e-10  # two machines' sin and cos may differ in the last bit of a double, not in the tenth digit
TURN = 1 << 32  # steps of an angle_t

getcontext().prec = 40


# ---- tools ----------------------------------------------------------------------------------------------------------


def noise(seed: int) -> Iterator[float]:
    """Multiples of 2^-16 in [-1/2, 1/2); the generator of Numerical Recipes, its upper half."""
    while True:
        seed = (seed * 1664525 + 1013904223) % (1 << 32)
        yield ((seed >> 16) - 32768) / 65536.0


def integers(seed: int) -> Iterator[int]:
    while True:
        seed = (seed * 1664525 + 1013904223) % (1 << 32)
        yield seed


def solve(matrix: list[list[Fraction]], right: list[Fraction]) -> list[Fraction]:
    """Exact solution of a linear system by elimination."""
    n = len(right)
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for i in range(n):
        pivot = next(r for r in range(i, n) if rows[r][i] != 0)
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for r in range(n):
            if r != i:
                factor = rows[r][i] / rows[i][i]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[i], strict=True)]
    return [rows[i][n] / rows[i][i] for i in range(n)]


def lagrange(order: int, f: Fraction) -> list[Fraction]:
    """Taps of a delay by f: the moments of the taps are those of the delay, sum_k A_k k^i = f^i for i = 0..order."""
    matrix = [[Fraction(k) ** i for k in range(order + 1)] for i in range(order + 1)]
    return solve(matrix, [f**i for i in range(order + 1)])


def power(base: Decimal, exponent: Decimal) -> Decimal:
    return (base.ln() * exponent).exp() if base > 0 else Decimal(0)


def fal(e: float, alpha: float, delta: float) -> float:
    a, d, size = Decimal(repr(alpha)), Decimal(repr(delta)), Decimal(abs(e))
    y = size * power(d, a - 1) if size <= d else power(size, a)
    return math.copysign(float(y), e)


def fal_slope(e: float, alpha: float, delta: float) -> float:
    a, d = Decimal(repr(alpha)), Decimal(repr(delta))
    return float(power(max(Decimal(abs(e)), d), a - 1))


# ---- headers --------------------------------------------------------------------------------------------------------


def number(x: float | int | Fraction | Decimal) -> str:
    if isinstance(x, bool):
        return "true" if x else "false"
    if isinstance(x, int):
        return f"{x}U" if x >= 0 else str(x)
    value = float(x)
    return repr(value) if len(repr(value)) <= 12 else f"{value:.13e}"


def table(name: str, what: str, fields: str, rows: Sequence[Sequence[float | int | Fraction | Decimal]]) -> str:
    """A C array of structures; `fields` is the body of the structure."""
    lines = [f"/* {what} */", f"typedef struct {{ {fields} }} {name.lower()}_t;"]
    lines.append(f"static const {name.lower()}_t {name}[{len(rows)}] = {{")
    lines += [f"    {{{', '.join(number(x) for x in row)}}}," for row in rows]
    return "\n".join([*lines, "};"])


def vector(name: str, what: str, values: Sequence[float]) -> str:
    lines = [f"/* {what} */", f"static const double {name}[{len(values)}] = {{"]
    for i in range(0, len(values), 5):
        lines.append("    " + " ".join(f"{number(x)}," for x in values[i : i + 5]))
    return "\n".join([*lines, "};"])


def header(name: str, parts: Sequence[str]) -> str:
    guard = f"TESTS_CONTROL_GOLDEN_{name.upper()}_H"
    body = "\n\n".join(parts)
    return f"/* Made by `{COMMAND}`; do not edit. */\n#ifndef {guard}\n#define {guard}\n\n{body}\n\n#endif\n"


# ---- numeric/ -------------------------------------------------------------------------------------------------------


def make_num_math() -> list[str]:
    two = Decimal(2)
    positive = [Fraction(n, 65536) for n in (1, 2, 3, 100, 655, 4096, 20000, 46340, 46341, 65535, 65536, 65537)]
    positive += [Fraction(n, 4) for n in (5, 6, 7, 8, 11, 17, 40, 63, 101, 255, 256, 257, 400, 511)]
    logs = [(x, (Decimal(x.numerator) / x.denominator).ln() / two.ln()) for x in positive]
    roots = [(x, (Decimal(x.numerator) / x.denominator).sqrt()) for x in positive]
    exponents = [Fraction(n, 64) for n in (-1537, -1023, -640, -333, -97, -64, -33, -32, -31, -1, 0, 1, 31, 32, 33)]
    exponents += [Fraction(n, 64) for n in (63, 64, 65, 127, 200, 287, 300, 383, 416, 440)]
    exps = [(x, power(two, Decimal(x.numerator) / x.denominator)) for x in exponents]
    pows = []
    for base in positive[::2] + positive[1::4]:
        for exponent in (Fraction(-1, 2), Fraction(-3, 8), Fraction(1, 16), Fraction(5, 8), Fraction(1)):
            value = power(Decimal(base.numerator) / base.denominator, Decimal(float(exponent)))
            if value < 120:
                pows.append((base, exponent, value))
    wide = []
    for base in ("1e-9", "3.7e-7", "0.00012", "0.9", "1.1", "7777.0", "250000.0", "8.1e7", "1e9"):
        for exponent in (-1.0, -0.75, -0.375, 0.0625, 0.625, 1.0):
            wide.append((float(base), exponent, power(Decimal(base), Decimal(exponent))))
    pair = "double x, y;"
    triple = "double base, exponent, y;"
    return [
        table("GOLDEN_LOG2", "y = log2(x): decimals", pair, logs),
        table("GOLDEN_EXP2", "y = 2^x: decimals", pair, exps),
        table("GOLDEN_SQRT", "y = sqrt(x): decimals", pair, roots),
        table("GOLDEN_POW", "y = base^exponent where both numerics reach: decimals", triple, pows),
        table("GOLDEN_POW_WIDE", "the same where only float reaches", triple, wide),
    ]


def make_angle() -> list[str]:
    source = integers(7)
    angles = [0, 1, TURN // 8 - 1, TURN // 8, TURN // 4, TURN // 2 - 1, TURN // 2, 3 * (TURN // 4), TURN - 1]
    angles += [next(source) for _ in range(40)]
    rows = []
    for a in angles:
        z = cmath.rect(1.0, 2.0 * math.pi * a / TURN)
        signed = a - TURN if a >= TURN // 2 else a
        rows.append((a, z.imag, z.real, 2.0 * math.pi * a / TURN, 2.0 * math.pi * signed / TURN))
    pi = Decimal("3.14159265358979323846264338327950288419717")
    back = []
    for rad in (0.0, 0.5, -0.5, 3.0, -3.25, 6.25, 6.5, -50.25, 99.75, -100.0, 0.0625, -0.0009765625, 0.0009765625):
        turns = Decimal(rad) / (2 * pi)
        back.append((rad, int(((turns - turns.to_integral_value(rounding="ROUND_FLOOR")) * TURN).to_integral_value())))
    return [
        table(
            "GOLDEN_SINCOS",
            "a complex number turned by angle / 2^32 of a turn; radians in [0, 2 pi) and in [-pi, pi)",
            "uint32_t angle; double sine, cosine, rad, rad_signed;",
            rows,
        ),
        table("GOLDEN_FROM_RAD", "rad as steps of 2^-32 turn: decimals", "double rad; uint32_t angle;", back),
    ]


def make_lagrange() -> list[str]:
    rows = []
    for order in range(4):
        for n in range(0, 64 * order + 1, 13) if order else [0]:
            taps = lagrange(order, Fraction(n, 64))
            rows.append((order, Fraction(n, 64), *taps, *[0.0] * (3 - order)))
    return [
        table(
            "GOLDEN_LAGRANGE",
            "taps of order `order` for the fraction f: exact solution of the moment equations",
            "uint16_t order; double f, a0, a1, a2, a3;",
            rows,
        )
    ]


# ---- memory/ --------------------------------------------------------------------------------------------------------


def newton(xs: Sequence[int], ys: Sequence[Fraction], x: Fraction) -> Fraction:
    """Interpolation by divided differences."""
    coefficients = list(ys)
    for level in range(1, len(xs)):
        for i in range(len(xs) - 1, level - 1, -1):
            coefficients[i] = (coefficients[i] - coefficients[i - 1]) / (xs[i] - xs[i - level])
    value = coefficients[-1]
    for i in range(len(xs) - 2, -1, -1):
        value = value * (x - xs[i]) + coefficients[i]
    return value


def make_angle_grid() -> list[str]:
    cells = 12
    values = noise(11)
    content = [Fraction(next(values) * 8.0) for _ in range(cells)]
    source = integers(12)
    angles = [0, 1, TURN - 1, TURN // 2, TURN // 3 + 1, TURN // 24] + [next(source) for _ in range(34)]
    rows = []
    for a in angles:
        position = Fraction(a * cells, TURN)
        i = math.floor(position)
        around = {n: range(i - n + 1, i + n + 1) for n in (1, 2)}
        read = [newton(around[n], [content[j % cells] for j in around[n]], position) for n in (1, 2)]
        rows.append((a, *read))
    return [
        vector("GOLDEN_GRID_CELLS", "content of the cells", [float(x) for x in content]),
        table(
            "GOLDEN_GRID_READ",
            "read-out through two and four neighbours: divided differences, exact",
            "uint32_t angle; double linear, cubic;",
            rows,
        ),
    ]


# ---- motor/ ---------------------------------------------------------------------------------------------------------


def make_frames() -> list[str]:
    values = noise(21)
    source = integers(22)
    rows = []
    for i in range(24):
        a, b, c = (next(values) * 16.0 for _ in range(3))
        if i < 4:  # a three-phase set by hand: only a, only b, only c, all alike
            a, b, c = [(4.0, 0.0, 0.0), (0.0, 4.0, 0.0), (0.0, 0.0, 4.0), (4.0, 4.0, 4.0)][i]
        angle = next(source)
        space = 2.0 / 3.0 * sum(x * cmath.exp(2j * math.pi * n / 3) for n, x in enumerate((a, b, c)))
        turned = space * cmath.exp(-2j * math.pi * angle / TURN)
        phases = [(space * cmath.exp(-2j * math.pi * n / 3)).real for n in range(3)]
        rows.append((a, b, c, angle, space.real, space.imag, turned.real, turned.imag, *phases))
    fields = "double a, b, c; uint32_t angle; double alpha, beta, d, q, back_a, back_b, back_c;"
    what = "space vector 2/3 (a + b e^j120 + c e^j240), turned by -angle, and projected back on the phase axes"
    return [table("GOLDEN_FRAMES", what, fields, rows)]


def sector_duties(alpha: float, beta: float, v_dc: float) -> tuple[float, float, float]:
    """Duty cycles from sector, T1, T2 and T0, zero time split in two halves."""
    length, phi = abs(complex(alpha, beta)), cmath.phase(complex(alpha, beta)) % (2.0 * math.pi)
    sector = min(int(phi / (math.pi / 3.0)), 5)
    rest = phi - sector * math.pi / 3.0
    reach = math.sqrt(3.0) * length / v_dc
    t1, t2 = reach * math.sin(math.pi / 3.0 - rest), reach * math.sin(rest)
    # the six active vectors in order, as the switches of phases a, b, c
    active = [(1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), (1, 0, 1)]
    first, second = active[sector], active[(sector + 1) % 6]
    t0 = 1.0 - t1 - t2
    a, b, c = (t1 * first[x] + t2 * second[x] + t0 / 2.0 for x in range(3))
    return a, b, c


def make_svm() -> list[str]:
    rows = []
    for v_dc in (1.0, 0.75):
        for n in range(24):
            angle = 2.0 * math.pi * (n + 0.03) / 24
            length = (0.1, 0.4, 0.577)[n % 3] * v_dc
            v = cmath.rect(length, angle)
            alpha, beta = round(v.real * 65536) / 65536, round(v.imag * 65536) / 65536
            rows.append((alpha, beta, v_dc, *sector_duties(alpha, beta, v_dc)))
    rows.append((0.0, 0.0, 1.0, 0.5, 0.5, 0.5))
    return [
        table("GOLDEN_SVM", "duties from the times of sector vectors", "double alpha, beta, v_dc, a, b, c;", rows),
        table(
            "GOLDEN_VECTOR_LIMIT",
            "a complex number cut to a length",
            "double d, q, limit, out_d, out_q;",
            [
                (z.real, z.imag, limit, cut.real, cut.imag)
                for z, limit in [
                    (complex(x / 16.0, y / 16.0), lim)
                    for x, y in ((0, 0), (3, 4), (-30, 40), (700, -2), (-1, -900), (50, 50), (-71, 71), (16, 0))
                    for lim in (0.5, 1.0, 6.0)
                ]
                for cut in [z if abs(z) <= limit else z * (limit / abs(z))]
            ],
        ),
    ]


def make_pi() -> list[str]:
    """Outputs as k_p e + k_i sum(e over the samples that were integrated); which ones is decided by the limits."""
    kp, ki = Fraction(5, 4), Fraction(1, 8)
    parts = []
    for name, outward in (("HOLD", False), ("OUTWARD", True)):
        values = noise(31)
        integrated: list[Fraction] = []
        out = []
        for k in range(200):
            drift = Fraction(3, 4) if (k // 50) % 2 == 0 else Fraction(-3, 4)
            e = Fraction(next(values)) * 2 + drift
            able = Fraction(2) if (k // 20) % 3 else Fraction(1)  # what the actuator can do: less than the limit of 3
            wanted = ki * sum(integrated) + kp * e
            proposed = max(Fraction(-3), min(Fraction(3), wanted))
            done = max(-able, min(able, proposed))
            out.append(float(proposed))
            limited = done != wanted
            inward = (wanted - done) * e < 0
            if not limited or (outward and inward):
                integrated.append(e)
        parts.append(vector(f"GOLDEN_PI_{name}", "proposals in exact fractions; see make_pi for the input", out))
    return parts


def make_notch() -> list[str]:
    """Equation (1) of notch.h, s = (z - 1) / (z + 1) / tan(w / 2) in its polynomials, run as a difference equation."""
    rows = []
    for cycles, damping, depth in (
        (0.01, 0.3, 0.1),
        (0.06, 0.3, 0.0),
        (0.06, 0.05, 0.5),
        (0.15, 1.0, 0.05),
        (0.37, 0.6, 0.9),
    ):
        k = math.tan(math.pi * cycles)
        over, under = (
            [1.0 + 2.0 * d * k + k * k, 2.0 * k * k - 2.0, 1.0 - 2.0 * d * k + k * k]
            for d in (damping * depth, damping)
        )
        values, x, y = noise(53), [0.0, 0.0], [0.0, 0.0]
        for row in range(120):
            new = next(values) + (0.25 if row >= 60 else 0.0)
            out = (over[0] * new + over[1] * x[0] + over[2] * x[1] - under[1] * y[0] - under[2] * y[1]) / under[0]
            x, y = [new, x[0]], [out, y[0]]
            if row % 4 == 0:
                rows.append((cycles, damping, depth, row, out))
    fields = "double cycles, damping, depth; uint32_t row; double out;"
    return [table("GOLDEN_NOTCH", "output of every fourth row; see make_notch for the input", fields, rows)]


def make_fourier() -> list[str]:
    """Real parts of powers of e^(ix), and of their derivatives i n e^(inx)."""
    values, source = noise(59), integers(61)
    rows = []
    for k in range(40):
        size = [next(values) for _ in range(4)]
        x = (k * (TURN // 8)) % TURN if k < 8 else next(source)
        z = cmath.exp(2j * math.pi * x / TURN)
        first, second = complex(size[0], -size[1]) * z, complex(size[2], -size[3]) * z * z
        rows.append((*size, x, (first + second).real, (1j * first + 2j * second).real))
    fields = "double cos1, sin1, cos2, sin2; uint32_t x; double value, slope;"
    return [table("GOLDEN_FOURIER", "value and slope at x / 2^32 of a turn", fields, rows)]


def make_current_error() -> list[str]:
    """What one turn shows of known sensor errors: phase currents through the sensors, then a discrete Fourier transform
    of the vector that the drive sees. True currents and voltages are balanced."""
    rows = []
    amplitude, angle, samples = 3.0, 0.3, 500
    cases = (
        (0, (0.2, 0.05, 0.0), (1.1, 0.9, 1.0)),
        (0, (-0.3, 0.1, 0.0), (0.95, 1.02, 1.0)),
        (1, (0.1, -0.2, 0.25), (1.03, 0.92, 1.05)),
        (1, (0.0, 0.0, 0.3), (1.0, 1.0, 0.9)),
    )
    for three, offset, gain in cases:
        seen = []
        for k in range(samples):
            theta = 2.0 * math.pi * k / samples
            true = [amplitude * math.cos(theta + angle - phase * 2.0 * math.pi / 3.0) for phase in range(3)]
            read = [gain[x] * true[x] + offset[x] for x in range(3)]
            if not three:
                read[2] = -read[0] - read[1]
            seen.append(2.0 / 3.0 * sum(read[x] * cmath.exp(2j * math.pi * x / 3.0) for x in range(3)))
        turning = [cmath.exp(-2j * math.pi * k / samples) for k in range(samples)]
        dc = sum(seen) / samples
        forwards = sum(x * w for x, w in zip(seen, turning, strict=True)) / samples
        backwards = sum(x / w for x, w in zip(seen, turning, strict=True)) / samples
        n = backwards / forwards.conjugate()
        # half of it is taken away: phases by projection on their axes, gains so that they make this negative sequence
        phases = [0.5 * (dc * cmath.exp(-2j * math.pi * x / 3.0)).real for x in range(3)]
        if three:
            gains = [1.0 + 0.5 * 2.0 * (n * cmath.exp(2j * math.pi * x / 3.0)).real for x in range(3)]
        else:
            phases[2] = 0.0
            apart = (n * math.sqrt(3.0) * cmath.exp(-1j * math.pi / 6.0)).real
            gains = [1.0 + 0.25 * apart, 1.0 - 0.25 * apart, 1.0]
        rows.append((three, *offset, *gain, *phases, *gains))
    learned = ", ".join(f"learned_{x}" for x in ("oa", "ob", "oc", "ga", "gb", "gc"))
    fields = f"int three; double oa, ob, oc, ga, gb, gc, {learned};"
    what = "sensor errors in A and as gains, and what half of them looks like after one turn of 3 A at 0.3 rad"
    return [table("GOLDEN_CURRENT_ERROR", what, fields, rows)]


def make_pll() -> list[str]:
    """w / theta = ki (1 - q) / ((1 - q)^2 + q kp (1 - q) + q K),  q = z^-1, K = ki_ts rad_per_speed_ts."""
    kp, ki, unit = 0.125, 4.0, 0.0078125
    k_loop = ki * unit
    numerator = [ki, -ki]
    denominator = [1.0, kp + k_loop - 2.0, 1.0 - kp]
    position = 0
    steps = []
    for k in range(240):
        rate = 0.01 if k < 80 else (-0.02 if k < 160 else 0.004)  # turns per sample
        position += round((rate + 0.002 * math.sin(0.3 * k)) * TURN)
        steps.append(position)
    theta = [2.0 * math.pi * p / TURN for p in steps]
    w: list[float] = []
    for k in range(len(theta)):
        value = sum(b * theta[k - i] for i, b in enumerate(numerator) if k >= i)
        value -= sum(a * w[k - i] for i, a in enumerate(denominator) if 0 < i <= k)
        w.append(value)
    rows = [(p % TURN, speed) for p, speed in zip(steps, w, strict=True)]
    what = "answer of the transfer function from angle to speed; 1/8, 4, 1/128 are kp_ts, ki_ts, rad_per_speed_ts"
    return [table("GOLDEN_PLL", what, "uint32_t theta; double w;", rows)]


Vector = list[Fraction]


def machine(r: Fraction, ld: Fraction, lq: Fraction, psi: Fraction, w: Fraction) -> tuple[list[Vector], Vector]:
    """Voltage beside L di/dt as M i + e."""
    return [[r, -w * lq], [w * ld, r]], [Fraction(0), w * psi]


def make_deadbeat() -> list[str]:
    """Steady current without correction: what the model asks for is what the machine takes at that current.

    Affine in (i_d, i_q), so two columns and the rest follow from three evaluations; then a 2 x 2 system.
    """
    r, ld, lq, psi = Fraction(1, 2), Fraction(9, 10000), Fraction(12, 10000), Fraction(594, 10000)
    ts = Fraction(1, 10000)
    ref = [Fraction(-1), Fraction(5)]

    def law(i: Vector, v: Vector, scale: tuple[Fraction, ...], w: Fraction) -> Vector:
        m, e = machine(r * scale[0], ld * scale[1], lq * scale[1], psi * scale[2], w)
        t = [ts / (ld * scale[1]), ts / (lq * scale[1])]

        def drop(x: Vector) -> Vector:
            return [m[n][0] * x[0] + m[n][1] * x[1] + e[n] for n in (0, 1)]

        def after(part: Fraction, at: Vector) -> Vector:
            return [i[n] + part * t[n] * (v[n] - drop(at)[n]) for n in (0, 1)]

        there = after(Fraction(1), after(Fraction(1, 2), i))
        middle = [(there[n] + ref[n]) / 2 for n in (0, 1)]
        return [drop(middle)[n] + (ref[n] - there[n]) / t[n] for n in (0, 1)]

    rows = []
    for rpm in (0, 1000, -451):
        w = Fraction(5 * rpm) * Fraction(math.pi) / 30
        m, e = machine(r, ld, lq, psi, w)
        for scale in ("1 1 1", "13/10 1 1", "7/10 1 1", "1 13/10 1", "1 7/10 1", "1 1 13/10", "1 1 7/10"):
            factors = tuple(Fraction(x) for x in scale.split())

            def gap(
                i: Vector, w: Fraction = w, m: list[Vector] = m, e: Vector = e, f: tuple[Fraction, ...] = factors
            ) -> Vector:
                v = [m[n][0] * i[0] + m[n][1] * i[1] + e[n] for n in (0, 1)]
                wanted = law(i, v, f, w)
                return [wanted[n] - v[n] for n in (0, 1)]

            zero = gap([Fraction(0), Fraction(0)])
            columns = [gap([Fraction(1), Fraction(0)]), gap([Fraction(0), Fraction(1)])]
            matrix = [[columns[c][n] - zero[n] for c in (0, 1)] for n in (0, 1)]
            rows.append((float(rpm), *[float(x) for x in factors], *solve(matrix, [-zero[0], -zero[1]])))
    what = "steady current in A for references -1 and 5 A, with a model whose R, L, psi are off: exact fractions"
    return [table("GOLDEN_DEADBEAT", what, "double rpm, r, l, psi, id_a, iq_a;", rows)]


def make_mt_speed() -> list[str]:
    """Edges of a motion of constant speeds, solved backwards for their times; speeds in counts per sample."""
    sample = 10_000
    pieces = [(12, "3.7"), (30, "0.3"), (6, "0"), (12, "-2.625"), (10, "5")]  # samples, speed
    knots: list[tuple[int, Fraction]] = [(0, Fraction(1, 3))]
    for samples, speed in pieces:
        knots.append((knots[-1][0] + samples * sample, knots[-1][1] + samples * Fraction(speed)))

    def crossings() -> Iterator[tuple[int, int]]:
        """(time in whole cycles, count) of every passing of a whole count, in order."""
        for (t0, p0), (t1, p1) in zip(knots, knots[1:], strict=False):
            rising = p1 > p0
            low, high = (p0, p1) if rising else (p1, p0)
            inside = [n for n in range(math.ceil(low), math.floor(high) + 1) if n != p0]
            for n in inside if rising else reversed(inside):
                yield round(t0 + (t1 - t0) * (n - p0) / (p1 - p0)), n

    edges = list(crossings())
    rows = []
    last, shown, idle = None, Fraction(0), 0
    for now in range(2 * sample, knots[-1][0] + 1, sample):
        time, count = [edge for edge in edges if edge[0] <= now][-1]
        if last is not None and time != last[0]:
            # after a standstill the time of the last edge may be more than a turn of the clock ago
            shown = Fraction((count - last[1]) * sample, time - last[0]) if idle < 4 else shown
            idle = 0
        elif last is not None:
            idle += 1
            most = Fraction(sample, now - time) if idle <= 4 else Fraction(0)
            shown = max(-most, min(most, shown))
        last = (time, count)
        rows.append((count, time, now, shown))
    fields = "int32_t count; uint32_t edge_cyc, now_cyc; double speed;"
    what = "counts over time between edges of a known motion, exact; 10000 cycles a sample, standstill after 4 samples"
    return [table("GOLDEN_MT", what, fields, rows)]


# ---- repetitive/ ----------------------------------------------------------------------------------------------------


def make_fal() -> list[str]:
    rows = []
    for alpha, delta in ((0.6, 0.4), (0.3, 0.05), (0.5, 2.0), (0.875, 0.125), (1.0, 0.5)):
        for n in (0, 1, 50, 3000, 8192, 26214, 26215, 65536, 131072, 131073, 655360, 3276800, 7864320):
            for e in (n / 65536.0, -n / 65536.0):
                rows.append((alpha, delta, e, fal(e, alpha, delta), fal_slope(e, alpha, delta)))
    wide = [(e, fal(e, 0.6, 0.4)) for e in (1e-9, -2.5e-5, 640.0, -1.25e4, 3.3e6, -1e9)]
    return [
        table("GOLDEN_FAL", "decimals of 40 digits", "double alpha, delta, e, y, lambda;", rows),
        table("GOLDEN_FAL_WIDE", "alpha 0.6, delta 0.4 where only float reaches", "double e, y;", wide),
    ]


@dataclass(frozen=True)
class Case:
    """One run of a repetitive controller on noise; periods as (first sample, N), N in 1/64 sample."""

    name: str
    order: int
    lead: int
    gain: float
    side: float
    centre: float
    periods: tuple[tuple[int, Fraction], ...]
    samples: int
    stride: int
    truncate: bool = True
    fal_at: int = 0  # ctl_rc_fal_at_t: none, input, output
    alpha: float = 0.6
    delta: float = 0.4
    side2: float = 0.0


PAPER_N = Fraction(48 * 64 + 55, 64)  # 60 / (4 * 307 * 1 ms) = 48.86
CASES = (
    Case("CRC_TRUNCATED", 0, 5, 0.6, 0.45, 0.10, ((0, PAPER_N),), 600, 5),
    Case("CRC_NEAREST", 0, 5, 0.6, 0.45, 0.10, ((0, PAPER_N),), 600, 5, truncate=False),
    Case("FORC1", 1, 0, 0.5, 0.25, 0.5, ((0, Fraction(81, 4)),), 600, 5),
    Case("FORC2", 2, 5, 0.6, 0.45, 0.10, ((0, PAPER_N),), 600, 5),
    Case("FORC3", 3, 15, 0.9, 0.05, 0.9, ((0, Fraction(67, 2)),), 600, 5),
    Case("FORC2_SHORTEST", 2, 5, 0.6, 0.25, 0.5, ((0, Fraction(29, 4)),), 300, 3),
    Case("FAL_INPUT", 2, 5, 0.6, 0.45, 0.10, ((0, PAPER_N),), 600, 5, fal_at=1),
    Case("FAL_OUTPUT", 2, 5, 0.6, 0.45, 0.10, ((0, PAPER_N),), 600, 5, fal_at=2),
    Case("KEEP", 2, 5, 0.6, 0.45, 0.10, ((0, PAPER_N), (211, Fraction(161, 4)), (403, Fraction(123, 2))), 600, 5),
    Case("FIVE_TAPS", 2, 5, 0.6, 0.2, 0.7, ((0, PAPER_N),), 600, 5, side2=-0.05),
    Case("FIVE_TAPS_SHORTEST", 3, 5, 0.6, 0.22, 0.63, ((0, Fraction(37, 4)),), 300, 3, side2=-0.055),
    Case("CRC_FIVE_TAPS", 0, 2, 0.6, 0.1, 0.6, ((0, Fraction(33, 2)),), 300, 3, fal_at=1, side2=0.05),
    Case("HUNDRED_PERIODS", 2, 5, 0.6, 0.45, 0.10, ((0, PAPER_N),), 4900, 49),
)


def run(case: Case) -> list[float]:
    """y(k) = sum_j h_j [ y(k - j) + s(k - j) ] with s(k) = k_rc f(e(k + m)): the error array shifted, nothing causal.

    h is the product of the polynomials Q(z) and z^-Ni sum A_k z^-k. Before the first sample e and y are zero.
    """
    values = noise(41)
    e = [next(values) * 4.0 for _ in range(case.samples)]
    learned = [fal(x, case.alpha, case.delta) for x in e] if case.fal_at == 1 else e
    shifted = {k - case.lead: case.gain * x for k, x in enumerate(learned)}
    y: dict[int, float] = {}
    u = []
    for k in range(case.samples):
        n = [period for first, period in case.periods if first <= k][-1]
        if case.order == 0:
            n = Fraction(math.floor(n) if case.truncate else round(n))
        whole = math.floor(n)
        h: dict[int, float] = {}
        if case.order == 3:
            whole -= 1  # two points on either side of the place
        for tap, a in enumerate(lagrange(case.order, n - whole)):
            for shift, q in zip(
                (-2, -1, 0, 1, 2), (case.side2, case.side, case.centre, case.side, case.side2), strict=True
            ):
                h[whole + tap + shift] = h.get(whole + tap + shift, 0.0) + float(a) * q
        y[k] = sum(c * (y.get(k - j, 0.0) + shifted.get(k - j, 0.0)) for j, c in h.items())
        u.append(y[k] * (fal_slope(e[k], case.alpha, case.delta) if case.fal_at == 2 else 1.0))
    return u


def make_repetitive() -> list[str]:
    parts = [
        "/* Input of every case: 4 times the noise with seed 41; output u every `stride` samples. */\n"
        "typedef struct { uint16_t first, whole; double fraction; } golden_rc_period_t;\n"
        "typedef struct {\n"
        "    const char *name;\n"
        "    uint16_t order, lead;\n"
        "    double gain, side, centre, side2;\n"
        "    bool truncate;\n"
        "    uint16_t fal_at;\n"
        "    double alpha, delta;\n"
        "    uint16_t samples, stride;\n"
        "    golden_rc_period_t period[3]; /* from sample `first` on */\n"
        "    const double *u;\n"
        "} golden_rc_t;"
    ]
    rows = []
    for case in CASES:
        u = run(case)[:: case.stride]
        parts.append(vector(f"GOLDEN_RC_{case.name}", "u", u))
        periods = [(first, math.floor(n), float(n - math.floor(n))) for first, n in case.periods]
        periods += [(65535, *periods[-1][1:])] * (3 - len(periods))
        listed = ", ".join(f"{{{number(f)}, {number(w)}, {number(x)}}}" for f, w, x in periods)
        plain = [case.order, case.lead, case.gain, case.side, case.centre, case.side2, case.truncate, case.fal_at]
        plain += [case.alpha, case.delta, case.samples, case.stride]
        numbers = ", ".join(number(x) for x in plain)
        rows.append(f'    {{"{case.name}", {numbers}, {{{listed}}}, GOLDEN_RC_{case.name}}},')
    parts.append("\n".join([f"static const golden_rc_t GOLDEN_RC[{len(rows)}] = {{", *rows, "};"]))
    return parts


# ---- observer/ ------------------------------------------------------------------------------------------------------


def low_pass(order: int, cutoff: float) -> list[float]:
    """Taps of the ideal low-pass by integrating its spectrum (Simpson), under a Hamming window, with unity gain."""
    steps = 2000
    taps = []
    for i in range(order + 1):
        away = i - order / 2.0
        weights = [1.0 if n in (0, steps) else (4.0 if n % 2 else 2.0) for n in range(steps + 1)]
        waves = (w * math.cos(2.0 * math.pi * cutoff * n / steps * away) for n, w in enumerate(weights))
        window = 0.54 + 0.46 * math.cos(2.0 * math.pi * away / order) if order else 1.0
        taps.append(window * math.fsum(waves) * 2.0 * cutoff / (3.0 * steps))
    gain = math.fsum(taps)
    return [tap / gain for tap in taps]


def make_fir() -> list[str]:
    rows = []
    for order in (0, 1, 2, 3, 5, 8, 9, 10, 14, 15):
        for cutoff in (0.001, 0.02, 0.075, 0.1, 0.25, 0.45):
            taps = low_pass(order, cutoff)
            rows.append(f"    {{{order}U, {cutoff!r}, {{{', '.join(number(x) for x in taps)}}}}},")
    lines = [
        "/* taps from the integral of the spectrum */",
        "typedef struct { uint16_t order; double cutoff, tap[16]; } golden_fir_t;",
    ]
    return ["\n".join([*lines, f"static const golden_fir_t GOLDEN_FIR[{len(rows)}] = {{", *rows, "};"])]


@dataclass(frozen=True)
class Sample:
    """One sample on the unwrapped grid: where, in cells, and what was seen."""

    at: Fraction
    value: float

    @property
    def cell(self) -> int:
        return math.floor(self.at)


def on_line(a: Sample, b: Sample, point: int) -> float:
    return a.value + (b.value - a.value) * float((point - a.at) / (b.at - a.at))


def passings(path: Sequence[Sample], newest_only: bool) -> list[tuple[int, int, float]]:
    """(sample, point, value): every point in (from, to] of each pair of samples, or the one nearest to its end."""
    events = []
    for k, (a, b) in enumerate(itertools.pairwise(path), 1):
        up = range(a.cell + 1, b.cell + 1)
        down = range(math.ceil(a.at) - 1, math.ceil(b.at) - 1, -1)
        points = list(up if b.at >= a.at else down)
        events += [(k, n, on_line(a, b, n)) for n in (points[-1:] if newest_only else points)]
    return events


def visits(path: Sequence[Sample]) -> list[tuple[int, int, float]]:
    """(sample, point, average): point by point, what the samples within a cell of it say; it must have been passed.

    A point that is passed before a weight of 1/4 has come together takes the straight line as a sample of that weight.
    """
    cells = [s.cell for s in path]
    events = []
    for n in range(min(cells), max(cells) + 2):
        total = weight = 0.0
        passed = False
        for k, s in enumerate(path):
            near = cells[k] in (n - 1, n)
            if k > 0:
                if min(cells[k - 1], cells[k]) < n <= max(cells[k - 1], cells[k]):
                    passed = True
                    if weight < 0.25:
                        total += on_line(path[k - 1], s, n) / 4.0
                        weight += 0.25
                left = cells[k - 1] in (n - 1, n) and not near
                jumped = passed and not near
                if left or jumped:
                    events += [(k, n, total / weight)] if passed else []
                    total = weight = 0.0
                    passed = False
            if near:
                nearness = 1.0 - abs(float(s.at - n))
                total += nearness * s.value
                weight += nearness
    return sorted(events)


# (samples, steps of the angle per sample, size of the noise on top as a power of two)
PATHS = {
    "ROUGH": (
        60,
        [(700, TURN // 1500, 21), (300, -TURN // 200, 26), (250, TURN // 60, 25), (200, -TURN // 45, 28), (400, 0, 22)],
    ),
    "EXACT": (  # lands on the points
        64,
        [(40, TURN // 64, 0), (60, -TURN // 128, 0), (50, 0, 0), (90, TURN // 32, 0), (33, TURN // 256, 0)]
        + [(90, -TURN // 32, 0), (31, TURN // 256, 0), (80, -3 * TURN // 128, 0), (80, 5 * TURN // 256, 0)]
        + [(70, -TURN // 64, 0)],
    ),
}


def make_angle_memory() -> list[str]:
    gain, forgetting = 0.375, 0.9375
    parts = []
    rows: list[tuple[int, int, int, int]] = []
    for name, (cells, segments) in PATHS.items():
        values, steps = noise(61), integers(62)
        angle, path = 0, []
        for count, step, jitter in segments:
            for _ in range(count):
                shake = (next(steps) >> (32 - jitter)) - (1 << jitter >> 1) if jitter else 0
                angle += step + shake
                path.append(Sample(Fraction(angle * cells, TURN), 4.0 * next(values)))
        rows += [(cells, count, step % TURN, jitter) for count, step, jitter in segments]
        for write, events in (("ONE", passings(path, True)), ("ALL", passings(path, False)), ("HAT", visits(path))):
            memory = [0.0] * cells
            for _, n, value in events:
                memory[n % cells] = forgetting * memory[n % cells] + gain * (value - memory[n % cells])
            count = f"#define GOLDEN_AM_{name}_{write}_WRITES {len(events)}U\n"
            parts.append(
                count + vector(f"GOLDEN_AM_{name}_{write}", "what it leaves, gain 3/8, forgetting 15/16", memory)
            )
    what = "the motions, distinguished by their number of cells; noise of 2^jitter steps of the angle"
    return [table("GOLDEN_AM_PATH", what, "uint16_t cells, samples; uint32_t step; uint16_t jitter;", rows), *parts]


# ---- position/ ------------------------------------------------------------------------------------------------------


def make_friction() -> list[str]:
    """The torque of Yeh and Liu, equations 1 and 2, with decimals of 40 digits."""
    sets = [  # viscous, Coulomb, static, Stribeck speed, shape: the paper's, none, and the extremes of the shape
        (0.0339, 0.387, 0.457, 0.551, 1.957),
        (0.0, 0.5, 0.5, 1.0, 2.0),
        (0.25, 0.0, 2.0, 0.5, 0.1),
        (0.125, 1.0, 1.5, 4.0, 10.0),
        (0.0, 3.0, 7.0, 0.0625, 1.0),
        (0.5, 0.0, 0.0, 1.0, 1.0),
    ]
    rows = []
    for b, tc, ts, vs, shape in sets:
        for n in (1, 40, 655, 6554, 21845, 36110, 65536, 137259, 400000, 3000000):
            v = Fraction(n, 65536)
            given = [Decimal(repr(x)) for x in (b, tc, ts, vs, shape)]
            speed = Decimal(v.numerator) / v.denominator
            rise = (given[2] - given[1]) * (-power(speed / given[3], given[4])).exp()
            rows.append((b, tc, ts, vs, shape, v, given[0] * speed + given[1] + rise))
    fields = "double viscous, coulomb, stat, stribeck, shape, speed, torque;"
    return [table("GOLDEN_FRICTION", "torque at a positive speed: decimals", fields, rows)]


def make_harmonics() -> list[str]:
    """Phases in exact fractions of a cycle, the sine as the height of a complex number."""
    lines = [
        (24.0, 0.14, 1.275),
        (4.0, 0.022, 0.521),
        (24.008, 0.14, 1.275),
        (4.059, 0.022, 0.521),
        (0.3125, 3.0, -2.0),
    ]
    source = integers(71)
    turns = [0, 0, 0, 1, -1, -1, 3, -7, 1000, -1000, 99991, -99991, 2000000, -2000000, (1 << 31) - 1, -(1 << 31)]
    rows = []
    for cycles, amplitude, phase in lines:
        q20 = math.floor(Fraction(cycles) * (1 << 20) + Fraction(1, 2))
        angle = round(phase / (2.0 * math.pi) * TURN) % TURN
        for k, turn in enumerate(turns):
            part = 0 if k == 0 else next(source)
            along = Fraction(q20, 1 << 20) * (turn + Fraction(part, TURN)) + Fraction(angle, TURN)
            z = cmath.rect(amplitude, 2.0 * math.pi * float(along - math.floor(along)))
            rows.append((q20, angle, amplitude, turn, part, z.imag))
    fields = "uint32_t cycles_q20, phase; double amplitude; int64_t turn; uint32_t part; double torque;"
    return [table("GOLDEN_HARMONICS", "one line at turn + part / 2^32", fields, rows)]


def bilinear(k: Fraction) -> list[float]:
    """b0, a1, a2 of W^2 / (s^2 + sqrt(2) W s + W^2) at s = 2/T (1 - q)/(1 + q), k = W T / 2.

    Three unknowns from three points: at a real q the filter b0 (1 + q)^2 / (1 + a1 q + a2 q^2) has to be H(s(q)).
    """
    root = Fraction(Decimal(2).sqrt())
    matrix, right = [], []
    for q in (Fraction(1, 3), Fraction(-1, 2), Fraction(3, 4)):
        s = (1 - q) / (1 + q) / k  # over W
        h = 1 / (s * s + root * s + 1)
        matrix.append([(1 + q) ** 2, -h * q, -h * q * q])
        right.append(h)
    return [float(x) for x in solve(matrix, right)]


def make_src() -> list[str]:
    ks = (1, 16, 655, 4096, 8192, 20000, 32768, 50000, 65536)
    rows = [(Fraction(n, 65536), *bilinear(Fraction(n, 65536))) for n in ks]
    parts = [table("GOLDEN_SRC_FILTER", "the bilinear transform by three of its values", "double k, b0, a1, a2;", rows)]
    # one cell per sample: the delay is `delay` samples, and y / e = B D / (A - B D) with D = q^delay, as one fraction
    b0, a1, a2 = bilinear(Fraction(1, 4))
    delay, count = 11, 160
    top = [0.0] * delay + [b0, 2.0 * b0, b0]
    bottom = [1.0, a1, a2, *[0.0] * delay]
    bottom = [x - y for x, y in zip(bottom, [*top, 0.0][: len(bottom)], strict=True)]
    values = noise(81)
    e = [next(values) for _ in range(count)]
    y: list[float] = []
    for n in range(count):
        value = sum(c * e[n - i] for i, c in enumerate(top) if n >= i)
        y.append(value - sum(c * y[n - i] for i, c in enumerate(bottom) if 0 < i <= n))
    return [*parts, vector("GOLDEN_SRC_Y", "y for the noise with seed 81, k = 1/4, a delay of 11 samples", y)]


def lyapunov(a: list[list[Fraction]], q: Fraction) -> list[list[Fraction]]:
    """P of A^T P + P A = -q I: six unknowns of a symmetric matrix, six equations, exact."""
    pairs = [(i, j) for i in range(3) for j in range(i, 3)]
    matrix, right = [], []
    for i, j in pairs:
        row = dict.fromkeys(pairs, Fraction(0))
        for k in range(3):
            row[min(k, j), max(k, j)] += a[k][i]
            row[min(i, k), max(i, k)] += a[k][j]
        matrix.append([row[pair] for pair in pairs])
        right.append(-q if i == j else Fraction(0))
    found = dict(zip(pairs, solve(matrix, right), strict=True))
    return [[found[min(i, j), max(i, j)] for j in range(3)] for i in range(3)]


def make_rdc() -> list[str]:
    """Error equation of the P-PI cascade with the paper's machine; k_pp 10, k_vp 1.5, T_i 0.05, q 1."""
    j, b, k_t, k_pp, k_vp, t_i = (Fraction(x) for x in ("0.0078", "0.0339", "0.868", "10", "1.5", "0.05"))
    drive = k_t * k_vp / j
    zero, one = Fraction(0), Fraction(1)
    a = [[zero, one, zero], [zero, zero, one], [-drive * k_pp / t_i, -drive * (k_pp + 1 / t_i), -drive - b / j]]
    p = lyapunov(a, one)
    values = noise(91)
    rows = []
    for k in range(24):
        x2, x3 = next(values) / 64.0, next(values) / 8.0
        x1 = 0.0078125 * x2  # after one sample of 2^-7 s from rest
        s = float(sum(f * Fraction(x) for f, x in zip(p[2], (x1, x2, x3), strict=True)) / j)
        rho, sigma = (0.15, 0.02) if k % 2 else (0.3, 0.0625)
        rows.append((x2, x3, rho, sigma, s, max(-rho, min(rho, -rho * s / sigma))))
    fields = "double error, speed_error, rho, sigma, s, robust;"
    return [
        vector("GOLDEN_RDC_A", "error equation x' = A x, row by row", [float(x) for row in a for x in row]),
        vector("GOLDEN_RDC_P", "P of A^T P + P A = -I, row by row", [float(x) for row in p for x in row]),
        table("GOLDEN_RDC_ROBUST", "first sample from rest, T_s = 2^-7 s; J = 0.0078 kg m^2", fields, rows),
    ]


# ---- the rest -------------------------------------------------------------------------------------------------------

HEADERS: dict[str, Callable[[], list[str]]] = {
    "num_math": make_num_math,
    "angle": make_angle,
    "lagrange": make_lagrange,
    "angle_grid": make_angle_grid,
    "frames": make_frames,
    "svm": make_svm,
    "pi": make_pi,
    "notch": make_notch,
    "fourier": make_fourier,
    "current_error": make_current_error,
    "pll": make_pll,
    "mt_speed": make_mt_speed,
    "deadbeat": make_deadbeat,
    "fal": make_fal,
    "repetitive": make_repetitive,
    "fir": make_fir,
    "angle_memory": make_angle_memory,
    "friction": make_friction,
    "harmonics": make_harmonics,
    "src": make_src,
    "rdc": make_rdc,
}
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


def same(old: str, new: str) -> bool:
    """Equal apart from what the last bits of a double do to a printed number."""
    if NUMBER.sub("#", old) != NUMBER.sub("#", new):
        return False
    pairs = zip(NUMBER.findall(old), NUMBER.findall(new), strict=True)
    return all(a == b or abs(float(a) - float(b)) <= SAME * max(1.0, abs(float(b))) for a, b in pairs)


def main(arguments: list[str]) -> int:
    if arguments not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 2
    stale = []
    for name, make in HEADERS.items():
        path = HERE / f"{name}.h"
        text = header(name, make())
        if not arguments:
            path.write_text(text)
        elif not path.exists() or not same(path.read_text(), text):
            stale.append(path.name)
    if stale:
        print(f"stale: {', '.join(stale)}; run `{COMMAND}`")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
