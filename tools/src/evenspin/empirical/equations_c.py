"""The equation of each family of terms as a hook of the simulator, with its parameters and values for a test by hand.

Numbers of a machine are parameters; a speed at which a size holds is the same for every machine, AT_RAD_S.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

Term = Mapping[str, float]  # shape, size and phase of a term, with what it was measured over
AT_RAD_S = 100.0
SOFT_RAD_S = 0.1
MOST_NM = 10000.0
TORQUE, FRICTION, VOLTAGE, FLUX = "torque_nm", "friction_nm", "phase_voltage", "flux"
WARM = 1.0 - math.exp(-1.0)  # after one time constant


@dataclass(frozen=True, slots=True)
class Parameter:
    name: str
    unit: str
    doc: str
    off: float
    low: float
    high: float
    role: str
    example: float
    tested: float  # value in the test


@dataclass(frozen=True, slots=True)
class Check:
    """What the hook gives at an angle, a speed and a time, with the tested parameters."""

    theta_rad: float
    speed_rad_s: float
    time_s: float
    expected: float


@dataclass(frozen=True, slots=True)
class Equation:
    """`lines`: of the hook's body, `p[0]` and so on are the parameters in their order."""

    hook: str
    doc: str
    signature: str
    confused_with: tuple[str, ...]
    shown_by: Mapping[str, str]
    told_apart: str
    parameters: tuple[Parameter, ...]
    lines: tuple[str, ...]
    checks: tuple[Check, ...]
    constants: tuple[str, ...] = ()
    whole_order: int = 0  # mechanical, at which features of a log are taken; 0: none

    @property
    def acts_on(self) -> str:
        return {TORQUE: "torque", FRICTION: "friction", VOLTAGE: "voltage", FLUX: "flux"}[self.hook]


def _size(doc: str, example: float, tested: float = 0.1, low: float = -MOST_NM) -> Parameter:
    return Parameter("torque_nm", "N m", doc, 0.0, low, MOST_NM, "SIM_AMPLITUDE", example, tested)


def _detail(
    name: str, unit: str, doc: str, off: float, low: float, high: float, example: float, tested: float
) -> Parameter:
    return Parameter(name, unit, doc, off, low, high, "SIM_DETAIL", min(max(example, low), high), tested)


def _phase(term: Term) -> Parameter:
    return Parameter("phase_rad", "rad", "Phase.", 0.0, -100.0, 100.0, "SIM_PHASE", term["phase_rad"], 0.0)


def _clock(tau_s: float) -> tuple[Parameter, Parameter]:
    return (
        _detail("time_s", "s", "Time constant.", 1.0, 1e-3, 1e6, tau_s, 10.0),
        _detail("start_s", "s", "Time at which a run starts.", 0.0, 0.0, 1e7, 0.0, 4.0),
    )


WARM_LINE = "const double grown = 1.0 - exp(-({time} + p[2]) / p[1]);"
AT = (f"#define AT_RAD_S {AT_RAD_S:.1f} /* speed at which the size holds */",)
PI = ("#define TWO_PI 6.283185307179586",)
SPEEDS = {"staircase": "at many speeds", "coast_down": ""}


def _speed_odd(term: Term) -> Equation:
    n = term["exponent"]
    size = term["torque_nm"] * (AT_RAD_S / term["top_rad_s"]) ** n
    power = _detail("exponent", "", "Power of the speed.", 2.0, 0.1, 10.0, n, 2.0)
    made = Equation(
        FRICTION,
        f"Drag T (abs(w) / {AT_RAD_S:g} rad/s)^exponent against the motion.",
        "q current with a power of the speed, in both directions.",
        ("viscous_friction", "coulomb_friction"),
        SPEEDS,
        "Its share of the friction changes with the speed.",
        (_size(f"Drag T at {AT_RAD_S:g} rad/s.", size, low=0.0), power),
        ("return p[0] * pow(speed_abs_rad_s / AT_RAD_S, p[1]);",),
        (Check(0.0, 50.0, 0.0, 0.025), Check(0.0, 100.0, 0.0, 0.1), Check(0.0, 0.0, 0.0, 0.0)),
        AT,
    )
    if size >= 0.0:
        return made
    return replace(  # friction never drives
        made,
        hook=TORQUE,
        doc=made.doc.replace("against the motion", "against the motion, or with it where T is negative"),
        parameters=(_size(f"Drag T at {AT_RAD_S:g} rad/s.", size), power),
        lines=(
            "const double drag_nm = p[0] * pow(fabs(shaft->speed_rad_s) / AT_RAD_S, p[1]);",
            "return (shaft->speed_rad_s < 0.0) ? drag_nm : -drag_nm;",
        ),
        checks=(Check(0.0, 50.0, 0.0, -0.025), Check(0.0, -50.0, 0.0, 0.025), Check(0.0, 0.0, 0.0, 0.0)),
    )


def _speed_even(term: Term) -> Equation:
    n = term["exponent"]
    size = term["torque_nm"] * (AT_RAD_S / term["top_rad_s"]) ** n
    return Equation(
        TORQUE,
        f"Torque T (abs(w) / {AT_RAD_S:g} rad/s)^exponent against positive rotation, whatever the direction.",
        "Offset of the q current with a power of the speed that keeps its sign in both directions.",
        ("load_torque", "viscous_friction"),
        SPEEDS,
        "Keeps its sign when the shaft turns the other way, and is gone at rest.",
        (
            _size(f"Torque T at {AT_RAD_S:g} rad/s.", size),
            _detail("exponent", "", "Power of the speed.", 2.0, 0.1, 10.0, n, 2.0),
        ),
        ("return -p[0] * pow(fabs(shaft->speed_rad_s) / AT_RAD_S, p[1]);",),
        (Check(0.0, 50.0, 0.0, -0.025), Check(0.0, -50.0, 0.0, -0.025), Check(0.0, 0.0, 0.0, 0.0)),
        AT,
    )


def _angle_line(term: Term) -> Equation:
    growth, over = term["speed_exponent"], term["turns_over"] != 0.0
    size = term["torque_nm"] * (AT_RAD_S / term["top_rad_s"]) ** growth
    law, factor, lines = "", 1.0, []
    if growth:
        law, factor = f" (abs(w) / {AT_RAD_S:g} rad/s)^{growth:g}", 0.5**growth
        lines.append(f"const double size_nm = p[0] * pow(fabs(shaft->speed_rad_s) / AT_RAD_S, {growth:.1f});")
    else:
        lines.append("const double size_nm = p[0];")
    if over:
        law += " sign(w)"
        lines.append("const double turned_nm = (shaft->speed_rad_s < 0.0) ? -size_nm : size_nm;")
    name = "turned_nm" if over else "size_nm"
    lines.append(f"return -{name} * sin(p[2] * shaft->theta_m_rad + p[1]);")
    quarter = math.tau / 16.0  # of order 4
    back = -1.0 if over else 1.0
    whole = round(term["order"])
    return Equation(
        TORQUE,
        f"Braking torque A{law} sin(order theta_m + phase).",
        "Torque ripple at an order of its own.",
        ("cogging", "misalignment"),
        {"staircase": "slowly in both directions", "coast_down": ""},
        "Its order is none of the slots, the poles or the coupling.",
        (
            Parameter("amplitude_nm", "N m", "Amplitude A.", 0.0, -MOST_NM, MOST_NM, "SIM_AMPLITUDE", size, 0.1),
            _phase(term),
            Parameter("order", "1/turn", "Cycles per turn.", 0.0, 0.0, MOST_NM, "SIM_ORDER", term["order"], 4.0),
        ),
        tuple(lines),
        (
            Check(quarter, 50.0, 0.0, -0.1 * factor),
            Check(quarter, -50.0, 0.0, -0.1 * factor * back),
            Check(0.0, 50.0, 0.0, 0.0),
        ),
        AT if growth else (),
        whole if whole > 0 and abs(term["order"] - whole) < WHOLE else 0,
    )


WHOLE = 2e-3  # of an order


def _position_bump(term: Term) -> Equation:
    return Equation(
        TORQUE,
        "Load T exp(-((theta_m - centre) / width)^2) at a place of the travel.",
        "q current at one place of the travel, the same in both directions.",
        ("load_torque", "coulomb_friction"),
        {"staircase": "over the whole travel"},
        "Comes back at the same place of the travel, not at the same angle of every turn.",
        (
            _size("Load T.", term["torque_nm"]),
            _detail(
                "centre_rad", "rad", "Where, from the start of the angle.", 0.0, -1e7, 1e7, term["centre_rad"], 20.0
            ),
            _detail("width_rad", "rad", "It falls to 1 / e this far away.", 10.0, 1e-3, 1e7, term["width_rad"], 4.0),
        ),
        ("const double x = (shaft->theta_m_rad - p[1]) / p[2];", "return -p[0] * exp(-x * x);"),
        (Check(20.0, 5.0, 0.0, -0.1), Check(16.0, -5.0, 0.0, -0.1 * math.exp(-1.0))),
    )


def _position_spring(term: Term) -> Equation:
    return Equation(
        TORQUE,
        "Load that grows evenly by T over the travel.",
        "q current that grows with the position, the same in both directions.",
        ("load_torque", "coulomb_friction"),
        {"staircase": "over the whole travel"},
        "Follows the position and keeps its sign when the shaft turns the other way.",
        (
            _size("Load T over the travel.", term["torque_nm"]),
            _detail("middle_rad", "rad", "Middle of the travel.", 0.0, -1e7, 1e7, term["middle_rad"], 10.0),
            _detail("travel_rad", "rad", "Length of the travel.", 1.0, 1e-3, 1e7, term["travel_rad"], 40.0),
        ),
        (
            "const double x = (shaft->theta_m_rad - p[1]) / p[2];",
            "return -p[0] * ((x > 0.5) ? 0.5 : ((x < -0.5) ? -0.5 : x));",
        ),
        (Check(20.0, 5.0, 0.0, -0.025), Check(500.0, 5.0, 0.0, -0.05), Check(-500.0, 5.0, 0.0, 0.05)),
    )


def _time(kind: str) -> Callable[[Term], Equation]:
    def made(term: Term) -> Equation:
        tau = term["time_constant_s"]
        size = term["torque_nm"] / -math.expm1(-term["span_s"] / tau)
        if kind == "viscous":
            size *= AT_RAD_S / term["top_rad_s"]
        what, factor, at, constants = {
            "load": ("Load", "", 1.0, ()),
            "friction": (
                "Dry friction",
                " * tanh(shaft->speed_rad_s / SOFT_RAD_S)",
                1.0,
                (f"#define SOFT_RAD_S {SOFT_RAD_S} /* friction goes through zero within this */",),
            ),
            "viscous": ("Viscous friction", " * shaft->speed_rad_s / AT_RAD_S", 0.5, AT),
        }[kind]
        back = 1.0 if kind == "load" else -1.0
        where = f" at {AT_RAD_S:g} rad/s" if kind == "viscous" else ""
        return Equation(
            TORQUE,
            f"{what} T (1 - exp(-t / time constant)) that builds up with time.",
            "q current that changes with the time at the same speed.",
            {
                "load": ("load_torque", "coulomb_friction"),
                "friction": ("coulomb_friction", "load_torque"),
                "viscous": ("viscous_friction", "coulomb_friction"),
            }[kind],
            {"staircase": "the same speed early and late"},
            "Is another one when the same speed is held again.",
            (_size(f"{what} T{where}, after a long time.", size), *_clock(tau)),
            (WARM_LINE.format(time="shaft->time_s"), f"return -p[0] * grown{factor};"),
            (
                Check(0.0, 50.0, 6.0, -0.1 * at * WARM),
                Check(0.0, -50.0, 6.0, -0.1 * at * WARM * back),
                Check(0.0, 50.0, 996.0, -0.1 * at),
            ),
            constants,
        )

    return made


def _torque_frequency(term: Term) -> Equation:
    start = math.remainder(math.tau * term["frequency_hz"] * term["start_s"] + term["phase_rad"], math.tau)
    return Equation(
        TORQUE,
        "Braking torque A sin(2 pi f t + phase), whatever the speed.",
        "Ripple of one frequency at all speeds.",
        ("cogging", "misalignment"),
        {"staircase": "at many speeds"},
        "Keeps its frequency when the speed changes.",
        (
            Parameter(
                "amplitude_nm", "N m", "Amplitude A.", 0.0, -MOST_NM, MOST_NM, "SIM_AMPLITUDE", term["torque_nm"], 0.1
            ),
            replace(_phase(term), example=start),
            _detail("frequency_hz", "Hz", "Frequency f.", 0.0, 0.0, 2000.0, term["frequency_hz"], 5.0),
            _detail("start_s", "s", "Time at which a run starts.", 0.0, 0.0, 1e7, 0.0, 0.02),
        ),
        ("return -p[0] * sin(TWO_PI * p[2] * (shaft->time_s + p[3]) + p[1]);",),
        (Check(0.0, 30.0, 0.03, -0.1), Check(0.0, 30.0, 0.08, 0.0), Check(0.0, -30.0, 0.13, 0.1)),
        PI,
    )


def _time_resistance(term: Term) -> Equation:
    tau = term["time_constant_s"]
    size = term["resistance_ohm"] / -math.expm1(-term["span_s"] / tau)
    return Equation(
        VOLTAGE,
        "Resistance R (1 - exp(-t / time constant)) of every phase that builds up with time.",
        "Voltage per current that changes with the time.",
        ("winding_resistance", "dead_time"),
        {"staircase_load": "the same load early and late"},
        "Is another one when the same current flows again.",
        (
            Parameter(
                "resistance_ohm",
                "ohm",
                "Resistance R after a long time.",
                0.0,
                -1000.0,
                1000.0,
                "SIM_AMPLITUDE",
                size,
                0.5,
            ),
            *_clock(tau),
        ),
        (
            WARM_LINE.format(time="bridge->time_s"),
            "for (int k = 0; k < 3; k++) {",
            "    v_abc_v[k] -= p[0] * grown * 0.5 * (bridge->begin_a[k] + bridge->end_a[k]);",
            "}",
        ),
        (Check(0.0, 0.0, 6.0, 10.0 - 3.0 * 0.5 * WARM), Check(0.0, 0.0, 996.0, 8.5)),
    )


def _time_magnet(term: Term) -> Equation:
    tau = term["time_constant_s"]
    size = term["share"] / -math.expm1(-term["span_s"] / tau)
    return Equation(
        FLUX,
        "Share of the magnets' flux that is lost with time, s (1 - exp(-t / time constant)).",
        "Voltage per speed and current per torque that change with the time.",
        ("torque_constant", "load_torque"),
        {"staircase": "the same speed early and late"},
        "Is another one when the same speed is held again.",
        (
            Parameter(
                "lost_rel",
                "",
                "Share s that is lost after a long time.",
                0.0,
                -0.9,
                0.9,
                "SIM_AMPLITUDE",
                min(max(size, -0.9), 0.9),
                0.2,
            ),
            *_clock(tau),
        ),
        (
            "(void)theta_e_rad;",
            WARM_LINE.format(time="time_s"),
            "flux->q_wb -= p[0] * grown * m->psi_wb;",
        ),
        (Check(0.0, 0.0, 6.0, -0.2 * WARM), Check(0.0, 0.0, 996.0, -0.2)),
    )


def _supply_frequency(term: Term) -> Equation:
    start = math.remainder(math.tau * term["frequency_hz"] * term["start_s"] + term["phase_rad"], math.tau)
    return Equation(
        VOLTAGE,
        "All voltages swing by the share a sin(2 pi f t + phase).",
        "Ripple of one frequency at all speeds that grows with the voltage.",
        ("dead_time", "winding_resistance"),
        {"staircase": "at many speeds"},
        "Keeps its frequency when the speed changes, and goes with the voltage.",
        (
            Parameter("swing_rel", "", "Share a.", 0.0, -0.5, 0.5, "SIM_AMPLITUDE", min(term["share"], 0.5), 0.1),
            replace(_phase(term), example=start),
            _detail("frequency_hz", "Hz", "Frequency f.", 0.0, 0.0, 2000.0, term["frequency_hz"], 5.0),
            _detail("start_s", "s", "Time at which a run starts.", 0.0, 0.0, 1e7, 0.0, 0.02),
        ),
        (
            "const double share = p[0] * sin(TWO_PI * p[2] * (bridge->time_s + p[3]) + p[1]);",
            "for (int k = 0; k < 3; k++) {",
            "    v_abc_v[k] -= share * v_abc_v[k];",
            "}",
        ),
        (Check(0.0, 0.0, 0.03, 9.0), Check(0.0, 0.0, 0.08, 10.0), Check(0.0, 0.0, 0.13, 11.0)),
        PI,
    )


EQUATIONS: dict[str, Callable[[Term], Equation]] = {
    "speed_odd": _speed_odd,
    "speed_even": _speed_even,
    "angle_line": _angle_line,
    "position_bump": _position_bump,
    "position_spring": _position_spring,
    "time_load": _time("load"),
    "time_friction": _time("friction"),
    "time_viscous": _time("viscous"),
    "time_magnet": _time_magnet,
    "time_resistance": _time_resistance,
    "torque_frequency": _torque_frequency,
    "supply_frequency": _supply_frequency,
}
