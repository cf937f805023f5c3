"""The worst case over all inputs: the longest path against every run of small functions, bounds and exclusions."""

from __future__ import annotations

from pathlib import Path

import pytest
from evenspin.cycles import costs
from evenspin.cycles import measure as measuring
from evenspin.cycles.instrument import instrument
from evenspin.cycles.rows import CURRENT_INTERRUPT, SPEED_INTERRUPT, worst_rows
from evenspin.cycles.tools import call
from evenspin.cycles.worst import BOUNDS, MOVING, Bound, Limits, Never, Program, Setup, read_program, rounds_of
from evenspin.errors import InputError

ROOT = measuring.source_root()
MAIN = """#include <stdio.h>
unsigned long long evenspin_cycles;
int f(int a, int b);
int main(void) {
    unsigned long long most = 0;
    for (int a = -3; a <= 12; a++) {
        for (int b = -3; b <= 12; b++) {
            evenspin_cycles = 0;
            (void)f(a, b);
            most = (evenspin_cycles > most) ? evenspin_cycles : most;
        }
    }
    printf("%llu", most);
    return 0;
}
"""


def compiled(folder: Path, source: str) -> str:
    """LLVM's text of a C source, as the estimate compiles it."""
    (folder / "f.c").write_text(source)
    return call(measuring.find_clang(), *measuring.OPTIONS, "-S", "-emit-llvm", folder / "f.c", "-o", "-")


def dearest_run(folder: Path, text: str) -> int:
    """Largest count of all runs, tenths of a cycle: of the counter in the program, which knows nothing of paths."""
    (folder / "f.ll").write_text(instrument(text))
    (folder / "m.c").write_text(MAIN)
    call(measuring.find_clang(), "-O1", "-Wno-everything", folder / "f.ll", folder / "m.c", "-o", folder / "m")
    return int(call(folder / "m"))


def loops(**rounds: tuple[int, ...]) -> Limits:
    return Limits({name: tuple(Bound(each, each) for each in found) for name, found in rounds.items()})


# Each with inputs among those of MAIN that go its longest way.
BRANCH = "int f(int a, int b) { volatile int s = 0; if (a > 2) { s += b; s += a; s += 3; } else { s = 1; } return s; }"
EARLY = """int f(int a, int b) {
    volatile int s = a;
    if (a < 0) { return s; }
    s += b;
    if (b < 0) { s += 1; return s; }
    s += 2; s += 3; s += 4;
    return s;
}"""
COUNTED = """int f(int a, int b) {
    volatile int s = 0;
    for (int k = 0; k < 7; k++) {
        s += a;
        if (b > k) { s += b; }
    }
    return s;
}"""
NESTED = """int f(int a, int b) {
    volatile int s = 0;
    for (int k = 0; k < a; k++) {
        s += 1;
        for (int j = 0; j < b; j++) { s += j; }
    }
    return s;
}"""
WHILE = "int f(int a, int b) { volatile int s = 0; while (s < a) { if (s == 40) { break; } s += 1; } return s + b; }"
CALLS = """static __attribute__((noinline)) int g(volatile int *s, int n) {
    for (int k = 0; k < n; k++) { *s += k; }
    return *s;
}
int f(int a, int b) { volatile int s = 0; if (a > 3) { return g(&s, b); } s += g(&s, b) + a; return s; }"""


@pytest.mark.parametrize(
    ("source", "limits"),
    [
        (BRANCH, Limits()),
        (EARLY, Limits()),
        (COUNTED, Limits()),
        (NESTED, loops(f=(12, 12))),
        (WHILE, loops(f=(12,))),
        (CALLS, loops(g=(12,))),
    ],
    ids=["branch", "early return", "counted loop", "nested loops", "while with a break", "calls"],
)
def test_the_worst_case_is_the_dearest_of_all_runs(tmp_path: Path, source: str, limits: Limits) -> None:
    text = compiled(tmp_path, source)

    assert read_program({"f": text}, limits).worst("f").tenths == dearest_run(tmp_path, text)


def test_one_round_less_is_less_than_the_dearest_run(tmp_path: Path) -> None:
    text = compiled(tmp_path, NESTED)

    assert read_program({"f": text}, loops(f=(12, 11))).worst("f").tenths < dearest_run(tmp_path, text)
    assert read_program({"f": text}, loops(f=(11, 12))).worst("f").tenths < dearest_run(tmp_path, text)


# By hand: an addition 1.5, a comparison 1.5, a branch 4.2, a jump 1.0, a division 4.1, a phi 0.7.
DIAMOND = """define float @f(float %a, i1 %b) {
entry:
  br i1 %b, label %left, label %right

left:
  %l = fadd float %a, %a
  %m = fadd float %l, %a
  br label %end

right:
  %r = fdiv float %a, %a
  br label %end

end:
  %x = phi float [ %m, %left ], [ %r, %right ]
  ret float %x
}
"""


def test_a_path_costs_the_sum_of_its_blocks() -> None:
    program = read_program({"f": DIAMOND}, Limits())

    assert program.worst("f").tenths == 42 + 41 + 10 + 7  # branch, division, jump, phi


def test_a_call_costs_what_it_calls_and_its_share_is_told() -> None:
    caller = "define float @g(float %a) {\nentry:\n  %x = call float @f(float %a, i1 true)\n  ret float %x\n}\n"
    declared = read_program({"f": DIAMOND, "g": caller}, Limits()).worst("g")

    own = round(10 * (costs.COSTS["call"] + costs.COSTS["frame"] - costs.CALLED_TWICE + 2 * costs.COSTS["args"]))
    assert declared.tenths == own + 100
    assert declared.shares == {"g": round(own / 10), "f": 10}


# ---- what it takes from people --------------------------------------------------------------------------------------


def test_a_loop_without_a_bound_is_an_error_with_its_function_and_line(tmp_path: Path) -> None:
    program = read_program({"f": compiled(tmp_path, NESTED)}, Limits())

    with pytest.raises(InputError, match=r"loop\.f .*each of the 2 loops of f, lines 3, 5"):
        program.worst("f")


def test_a_bound_too_many_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"2 bounds.*each of the 1 loops"):
        read_program({"f": compiled(tmp_path, WHILE)}, loops(f=(12, 3))).worst("f")


def test_a_loop_inlined_elsewhere_keeps_the_bound_of_where_it_is_written(tmp_path: Path) -> None:
    source = """static inline int sum(volatile int *s, int n) { for (int k = 0; k < n; k++) { *s += k; } return *s; }
    int f(int a, int b) { volatile int s = 0; return (a > 0) ? sum(&s, b) : 0; }"""
    text = compiled(tmp_path, source)

    assert read_program({"f": text}, loops(sum=(12,))).worst("f").tenths == dearest_run(tmp_path, text)


def test_recursion_and_what_nobody_knows_are_errors(tmp_path: Path) -> None:
    (tmp_path / "r").mkdir()
    text = compiled(
        tmp_path / "r",
        "int g(int); int f(int a, int b) { return (a > 0) ? g(b) : 1; } int g(int a) { return f(a, 1); }",
    )
    with pytest.raises(InputError, match="no recursion"):
        read_program({"f": text}, Limits()).worst("f")

    text = compiled(tmp_path, "int g(int); int f(int a, int b) { return (a > 0) ? g(b) + 1 : 1; }")
    with pytest.raises(InputError, match=r"worst case = 'g'.*called by f"):
        read_program({"f": text}, Limits()).worst("f")
    assert read_program({"f": text}, Limits(library={"g": 100})).worst("f").tenths > 1000


def test_a_pointer_is_an_unknown_call(tmp_path: Path) -> None:
    text = compiled(tmp_path, "int (*g)(int); int f(int a, int b) { return g(a) + b; }")

    with pytest.raises(InputError, match="a pointer"):
        read_program({"f": text}, Limits()).worst("f")


def test_a_set_up_leaves_out_what_it_never_runs_and_nothing_else(tmp_path: Path) -> None:
    source = """static inline int dear(volatile int *s) { *s += 1; *s += 2; *s += 3; return *s; }
    __attribute__((noinline)) int other(volatile int *s) { *s += 1; return *s; }
    int f(int a, int b) {
        volatile int s = b;
        if (a == 1) { return dear(&s); }
        if (a == 2) { return other(&s); }
        return s;
    }
    int g(int a) { volatile int s = a; return other(&s); }"""
    program = read_program({"f": compiled(tmp_path, source)}, Limits())

    def worst(*absent: str, function: str = "f") -> int:
        return program.worst(function, setup=Setup("some", frozenset(absent))).tenths

    everything = worst()
    assert (
        worst("dear", "other") < min(worst("dear"), worst("other")) <= max(worst("dear"), worst("other")) == everything
    )
    assert worst("f>other") == worst("other")
    assert worst("f>other", function="g") == worst(function="g")
    with pytest.raises(InputError, match="a function that returns"):
        worst("other", function="g")


def test_a_call_that_never_happens_is_left_out_where_it_is_named(tmp_path: Path) -> None:
    source = """__attribute__((noinline)) int g(volatile int *s) { *s += 1; return *s; }
    int f(int a, int b) { volatile int s = b; return (a > 0) ? g(&s) : s; }"""
    text = compiled(tmp_path, source)

    assert read_program({"f": text}, Limits(never=(Never("f", "g"),))).worst("f").tenths < dearest_run(tmp_path, text)
    assert read_program({"f": text}, Limits(never=(Never("h", "g"),))).worst("f").tenths == dearest_run(tmp_path, text)


def test_a_number_of_rounds_names_parameters() -> None:
    names = {"cells": 2048.0, "default.speed": 650.0}

    assert rounds_of("cells // 2 + 1", names) == 1025
    assert rounds_of("cells * default.speed // 62831 + 2", names) == 23
    assert rounds_of(8, names) == 8
    with pytest.raises(InputError, match="cell: unknown"):
        rounds_of("cell + 1", names)
    with pytest.raises(InputError, match="unknown"):
        rounds_of("__import__('os')", names)


@pytest.mark.parametrize(
    "entry",
    ["[[loop.f]]\nrounds = 3\n", '[[never]]\ninside = "f"\ncalls = "g"\n', '[[setup]]\nname = "x"\nabsent = ["g"]\n'],
)
def test_every_bound_and_exclusion_has_its_reason(tmp_path: Path, entry: str) -> None:
    (tmp_path / "worst.toml").write_text(entry)
    with pytest.raises(InputError, match="why"):
        Limits.read(tmp_path / "worst.toml", {})

    (tmp_path / "worst.toml").write_text(f'{entry}why = "counted"\n')
    Limits.read(tmp_path / "worst.toml", {})


# ---- rows and gate --------------------------------------------------------------------------------------------------


def interrupts(limits: Limits, rounds: str = "n") -> Program:
    """A program with the functions of both interrupts, one of them with a loop."""
    simple = {
        name: f"define void @{name}() {{\nentry:\n  ret void\n}}\n" for name in (*CURRENT_INTERRUPT, *SPEED_INTERRUPT)
    }
    simple["drive_current_isr"] = f"""define void @drive_current_isr(ptr %p, i32 %n) {{
entry:
  br label %body

body:
  %k = phi i32 [ 0, %entry ], [ %next, %body ]
  %next = add i32 %k, 1
  %x = load volatile i32, ptr %p
  %c = icmp eq i32 %next, {rounds}
  br i1 %c, label %end, label %body

end:
  ret void
}}
"""
    return read_program(simple, limits)


def test_a_loop_of_constants_needs_no_bound() -> None:
    once, five = (interrupts(Limits(), rounds).worst("drive_current_isr").tenths for rounds in ("1", "5"))

    body = 7 + 10 + 12 + 13 + 42  # phi, addition, volatile load, comparison, branch
    assert five - once == 4 * body
    with pytest.raises(InputError, match="0 bounds"):
        interrupts(Limits(), "%n").worst("drive_current_isr")


def test_rows_have_entry_and_calls_and_a_row_of_motion_where_it_differs() -> None:
    limits = Limits({"": (Bound(5, 2),)}, setups=(Setup("pi", frozenset()),))
    rows = {row.name: row for row in worst_rows(interrupts(limits, "%n"), {"worst case occupation pi": 20000})}

    assert set(rows) == {
        f"{which} {name}{kind}"
        for which in ("current_isr", "occupation")
        for name in ("any", "pi")
        for kind in ("", f", {MOVING}")
    } | {"speed_isr any", "speed_isr pi"}
    body, frame, isr = 8.4, costs.COSTS["frame"], costs.COSTS["isr"]
    assert rows["current_isr any"].cycles_worst == pytest.approx(isr + 1.0 + 5 * body, abs=1)
    assert rows["current_isr any, moving"].cycles_worst == pytest.approx(isr + 1.0 + 2 * body, abs=1)
    # five functions in the current interrupt, three in the speed interrupt of every tenth period
    whole = isr + 5 * frame + 1.0 + 5 * body + (isr + 3 * frame) / 10
    assert rows["occupation pi"].cycles_worst == pytest.approx(whole, abs=2)
    assert (rows["occupation pi"].budget, rows["occupation pi"].key) == (20000, "worst case occupation pi")


def test_what_was_measured_and_is_more_than_the_worst_case_is_said() -> None:
    program = interrupts(Limits({"": (Bound(5, 5),)}, setups=(Setup("pi", frozenset()),)), "%n")
    most = program.worst("drive_current_isr").tenths

    def said(row: str, tenths: int) -> list[str]:
        return measuring.contradictions({row: (0, tenths)}, program)

    assert said("current_isr pi", most) == []
    assert [line.split(" (")[1] for line in said("current_isr pi", most + 1)] == ["any)", "pi)"]
    assert len(said("current_isr crc", most + 1)) == 1
    assert said("services_pass idle", 10 * most) == []  # not in an interrupt


def test_the_bounds_of_the_firmware_are_read_with_the_maxima_of_its_parameters() -> None:
    from evenspin.cycles.worst import parameter_names
    from evenspin.native import tables

    names = parameter_names()
    limits = Limits.read(ROOT / BOUNDS, names)

    assert names["aro_cells"] == tables().params["aro_cells"].maximum
    # half a turn of cells, and a 97th of it, are what a sample can pass
    assert limits.loops["change_cell"][0].any == tables().params["aro_cells"].maximum / 2 + 1
    assert limits.loops["change_cell"][0].moving < 30
    assert {"pi", "fal-forc", "aro", "position silc"} <= {setup.name for setup in limits.setups}
