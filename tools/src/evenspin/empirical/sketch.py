"""A term of a verdict as the files of a new effect: the effect, a test of its equation, a module for an order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from evenspin.empirical.equations_c import EQUATIONS, FLUX, FRICTION, TORQUE, VOLTAGE, Equation, Parameter

ARGUMENTS = {
    TORQUE: ("double", "const sim_shaft_t *shaft"),
    FRICTION: ("double", "double speed_abs_rad_s"),
    VOLTAGE: ("void", "const sim_bridge_t *bridge, double v_abc_v[3]"),
    FLUX: ("void", "const sim_model_t *m, double theta_e_rad, double time_s, sim_flux_t *flux"),
}


def equation_of(term: Mapping[str, Any]) -> Equation | None:
    """`term`: one of `empirical` in verdict.json. None: the simulator has no hook for its family."""
    made = EQUATIONS.get(str(term["family"]))
    return made({**term["measured_over"], **term["parameters"]}) if made else None


def files_of(name: str, equation: Equation, form: str) -> dict[str, str]:
    """Paths within the checkout, and what they hold. `form`: the term in words, for a comment."""
    found = {
        f"sim_host/effects/{name}.c": _effect(name, equation, form),
        f"tests/sim_host/effects/test_effect_{name}.c": _test(name, equation),
    }
    if equation.whole_order:
        found[f"tools/src/evenspin/effects/{name}.py"] = _module(name, equation.whole_order)
    return found


def _effect(name: str, e: Equation, form: str) -> str:
    kind, arguments = ARGUMENTS[e.hook]
    neighbours = ", ".join(f'"{each}"' for each in e.confused_with)
    shown = ", ".join(f'{{"{each}", "{condition}"}}' for each, condition in e.shown_by.items())
    lines = [
        "#include <math.h>",
        "",
        '#include "sim_host/plant/effect.h"',
        "",
        *_comment(f"First seen in a log: {form}."),
        *e.constants,
        *([""] if e.constants else []),
        f"static {kind} {e.hook}(const double *p, {arguments})",
        "{",
        *(f"    {line}" for line in e.lines),
        "}",
        "",
        f"const sim_effect_t effect_{name} = {{",
        f'    .name = "{name}",',
        f'    .acts_on = "{e.acts_on}",',
        f'    .doc = "{e.doc}",',
        f'    .signature = "{e.signature}",',
        f"    .confused_with = {{{neighbours}}},",
        f"    .shown_by = {{{shown}}},",
        f'    .told_apart = "{e.told_apart}",',
        f"    .param_count = {len(e.parameters)},",
        "    .param =",
        "        {",
        *(f"            {_row(parameter)}," for parameter in e.parameters),
        "        },",
        f"    .{e.hook} = {e.hook},",
        "};",
    ]
    return "\n".join(lines) + "\n"


def _row(p: Parameter) -> str:
    numbers = ", ".join(c_number(x) for x in (p.off, p.low, p.high))
    return f'{{"{p.name}", "{p.unit}", "{p.doc}", {numbers}, {p.role}, {c_number(p.example)}}}'


def _test(name: str, e: Equation) -> str:
    calls = {
        TORQUE: (
            "const sim_shaft_t shaft = {theta_rad, speed_rad_s, time_s};",
            "return x->torque_nm(p, &shaft);",
        ),
        FRICTION: ("(void)theta_rad;", "(void)time_s;", "return x->friction_nm(p, fabs(speed_rad_s));"),
        VOLTAGE: (
            "(void)theta_rad;",
            "(void)speed_rad_s;",
            "const sim_bridge_t bridge = {.time_s = time_s, .begin_a = {3.0, -1.0, -2.0}, .end_a = {3.0, -1.0, -2.0}};",
            "double             v_abc_v[3] = {10.0, -4.0, -6.0};",
            "x->phase_voltage(p, &bridge, v_abc_v);",
            "return v_abc_v[0];",
        ),
        FLUX: (
            "(void)theta_rad;",
            "(void)speed_rad_s;",
            "sim_flux_t flux = {0.0, 0.0};",
            "x->flux(p, &model, 0.3, time_s, &flux);",
            "return flux.q_wb / model.psi_wb;",
        ),
    }[e.hook]
    values = ", ".join(c_number(p.tested) for p in e.parameters)
    lines = [
        f"/* sim_host/effects/{name}.c: its equation, by hand. */",
        '#include "tests/sim_host/support/machine.h"',
        "",
        "void setUp(void) { machine_defaults(); }",
        "void tearDown(void) {}",
        "",
        *_comment("In the order of its parameters: " + ", ".join(p.name for p in e.parameters) + "."),
        f"static const double p[] = {{{values}}};",
        "",
        "static double acts(double theta_rad, double speed_rad_s, double time_s)",
        "{",
        f'    const sim_effect_t *const x = sim_effects[machine_effect("{name}")];',
        *(f"    {line}" for line in calls),
        "}",
        "",
        f"void test_effect_{name}_follows_its_equation(void)",
        "{",
    ]
    for check in e.checks:
        where = ", ".join(c_number(x) for x in (check.theta_rad, check.speed_rad_s, check.time_s))
        # exp(-100) of a change with time is left after so long
        lines.append(f"    TEST_ASSERT_DOUBLE_WITHIN(1e-9, {c_number(check.expected, 12)}, acts({where}));")
    return "\n".join([*lines, "}"]) + "\n"


def _module(name: str, order: int) -> str:
    return f'''"""A line over the angle at order {order}; `{name}` in the table."""

from __future__ import annotations

from evenspin.effects.hypothesis import Hypothesis, Scale, by_roles


def hypothesis(scale: Scale) -> Hypothesis:
    return by_roles("{name}", scale)


def orders(scale: Scale) -> tuple[int, ...]:
    return ({order},)
'''


def _comment(text: str) -> list[str]:
    """A C comment of lines that are no longer than the format allows."""
    lines: list[str] = []
    line = "/*"
    for word in text.replace("*/", "").split():
        if len(line) + len(word) > WIDTH:
            lines, line = [*lines, line], " *"
        line = f"{line} {word}"
    return [*lines, f"{line} */"]


WIDTH = 120


def c_number(value: float, digits: int = 6) -> str:
    """A double constant of C."""
    text = f"{value:.{digits}g}"
    return text if any(c in text for c in ".en") else f"{text}.0"
