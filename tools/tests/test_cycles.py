"""The cycle model: costs, the counter in the code, budgets."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from evenspin.cycles import costs, m4
from evenspin.cycles import measure as measuring
from evenspin.cycles.instrument import instrument
from evenspin.cycles.measure import Row, m4_counts, make_rows, violations, write_recorded


def row(name: str, worst: int) -> Row:
    return Row(name, "step", worst, worst, None, None, "model")


@pytest.mark.parametrize(
    ("line", "tenths"),
    [
        ("  %a = fadd float %b, %c", 20),
        ("  %a = fadd float %b, 1.000000e+00", 20),
        ("  %a = fmul float %b, 0x3FC45F3060000000", 35),
        ("  %a = add nsw i64 %b, %c", 50),
        ("  %a = sdiv i64 %b, %c", 6000),
        ("  %a = mul nuw nsw i64 %b, %c", 100),
        ("  %a = lshr i64 %b, 32", 3),
        ("  %a = lshr i64 %b, 31", 75),
        ("  %a = and i64 %b, 4294967295", 3),
        ("  %a = call float @tmu_sin_turns(float %b)", 40),
        ("  %a = tail call float @tmu_sqrt(float %b)", 50),
        ("  ret void", 0),
        ("  %a = tail call float @fpu_max(float %b, float %c)", 10),
        ("  %a = tail call float @fpu_max(float %b, float 0x40091EB860000000)", 25),
        ("  %a = call zeroext i16 @ADC_readResult(i32 2816, i32 0)", 70),
        ("  call void @EPWM_setCounterCompareValue(i32 16384, i32 0, i16 zeroext %b)", 50),
        ("  %a = fptoui float %b to i16", 40),
        ("  %a = sitofp i32 %b to float", 60),
        ("  tail call void @hal_inverter_disarm()", 160),
        ("  call void @llvm.memcpy.p0.p0.i64(ptr align 4 %a, ptr align 4 %b, i64 24, i1 false)", 180),
    ],
)
def test_an_instruction_costs_what_the_table_says(line: str, tenths: int) -> None:
    assert costs.cost(line) == tenths


def test_a_product_of_two_values_of_32_bits_costs_two_products_and_not_one_of_64_bits() -> None:
    wide = "define i64 @f(i32 %a, i16 %b, i64 %c) {\n  %x = zext i32 %a to i64\n  %y = zext i16 %b to i64\n"

    def added(product: str) -> int:
        text = instrument(f"{wide}  %p = mul i64 {product}\n  ret i64 %p\n}}\n")
        return int(re.search(r"add i64 %evs.a0, (\d+)", text)[1])  # type: ignore[index]

    assert added("%x, %y") == 3 + 3 + 20
    assert added("%x, %c") == 3 + 3 + 100


def conversion_cost(lines: str, conversion: str) -> int:
    """Of a conversion among these lines of one function."""
    known = costs.names_in_memory(lines.splitlines())
    return costs.cost(conversion, (), known)


@pytest.mark.parametrize("made", ["load i16, ptr %p", "call zeroext i16 @ADC_readResult(i32 2816, i32 0)"])
def test_a_whole_number_from_memory_or_a_register_is_converted_without_a_move(made: str) -> None:
    conversion = "  %f = uitofp i16 %n to float"

    assert conversion_cost(f"  %n = {made}\n{conversion}\n", conversion) == 20
    assert conversion_cost(f"  %m = {made}\n  %n = add i16 %m, 1\n{conversion}\n", conversion) == 60


def test_a_whole_number_that_is_only_stored_or_written_is_converted_without_a_move() -> None:
    conversion = "  %n = fptoui float %f to i16"
    write = "  call void @EPWM_setCounterCompareValue(i32 16384, i32 0, i16 zeroext %n)\n"
    store = "  store i16 %n, ptr %p\n"

    assert conversion_cost(f"{conversion}\n{write}{store}", conversion) == 20
    assert conversion_cost(f"{conversion}\n{store}  %m = add i16 %n, 1\n", conversion) == 40


def test_every_block_adds_its_cost_before_its_end() -> None:
    text = "define float @f(float %0) {\n  %2 = fadd float %0, %0\n  br label %3\n\n3:\n  ret float %2\n}\n"

    lines = instrument(text).splitlines()

    end = lines.index("  br label %3")
    assert lines[end - 2] == "  %evs.b0 = add i64 %evs.a0, 45"
    assert sum("@evenspin_cycles" in line for line in lines) == 3  # load, store, declaration


def test_the_extra_of_a_method_is_what_both_interrupts_take_longer() -> None:
    measured = {
        "current_isr pi": (1000, 2000), "speed_isr pi": (500, 600),
        "current_isr crc": (1000, 2100), "speed_isr crc": (900, 1600),
    }  # fmt: skip

    extra = [r for r in make_rows(measured, {"extra crc": 7}) if r.kind == "extra"]

    assert [(r.name, r.cycles_est, r.cycles_worst, r.budget) for r in extra] == [("crc", 40, 110, 7)]


def test_a_budget_that_is_exceeded_is_named_with_both_numbers() -> None:
    assert violations([row("a", 101)], {"step a": 100}, {}) == ["step a: 101 cycles, budget 100"]
    assert violations([row("a", 100)], {"step a": 100}, {}) == []


def test_growth_beyond_three_per_cent_is_named_with_both_numbers() -> None:
    assert violations([row("a", 103)], {}, {"step a": 100}) == []
    found = violations([row("a", 104)], {}, {"step a": 100})
    assert found == ["step a: 104 cycles, recorded 100: grew by more than 3 %"]


def test_an_open_budget_must_not_grow_and_leaves_the_list_when_met() -> None:
    assert violations([row("a", 200)], {"step a": 100}, {"step a": 200}, ["step a"]) == []
    assert "grew" in violations([row("a", 210)], {"step a": 100}, {"step a": 200}, ["step a"])[0]
    assert "met" in violations([row("a", 90)], {"step a": 100}, {"step a": 200}, ["step a"])[0]


def test_recording_leaves_the_budgets_alone(tmp_path: Path) -> None:
    file = tmp_path / "budgets.toml"
    file.write_text('open = []\n\n[budget]\n"step a" = 5\n\n[recorded]\n"step a" = 1\n')

    write_recorded(file, [row("a", 3)])

    assert file.read_text() == 'open = []\n\n[budget]\n"step a" = 5\n\n[recorded]\n"step a" = 3\n'


def test_instructions_of_the_m4_go_beside_the_cycles() -> None:
    measured = {
        "ctl_x": (10, 20), "current_isr pi": (1000, 2000), "speed_isr pi": (500, 600),
        "current_isr crc": (1000, 2100), "speed_isr crc": (900, 1600),
    }  # fmt: skip
    m4 = {"ctl_x": 7, "current_isr pi": 100, "speed_isr pi": 41, "current_isr crc": 110, "speed_isr crc": 90}

    rows = {f"{r.kind} {r.name}": r.m4_instructions for r in make_rows(measured, {}, m4)}

    assert rows == {
        "step ctl_x": 7, "isr current_isr pi": 100, "isr speed_isr pi": 41, "isr current_isr crc": 110,
        "isr speed_isr crc": 90, "isr both pi": 105, "isr both crc": 119, "extra crc": 59,
    }  # fmt: skip
    assert all(r.m4_instructions is None for r in make_rows(measured, {}))


def test_without_the_tools_for_the_m4_its_column_is_empty_and_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))

    counts, note = m4_counts(tmp_path, tmp_path)

    assert counts is None
    assert "left out: arm-none-eabi-gcc, qemu-system-arm, gcc not installed: sudo apt-get install" in note


def test_an_emulator_that_refuses_the_plugin_is_said_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(root: Path, work: Path) -> dict[str, int]:
        raise RuntimeError("qemu-system-arm does not take the plugin\n(version)")

    monkeypatch.setattr("evenspin.cycles.measure.missing", lambda: "")
    monkeypatch.setattr("evenspin.cycles.measure.count_instructions", refuse)

    assert m4_counts(tmp_path, tmp_path) == (
        None, "Cortex-M4F instructions left out: qemu-system-arm does not take the plugin (version)",
    )  # fmt: skip


@pytest.mark.skipif(bool(m4.missing()), reason=m4.missing())
def test_instructions_counted_are_those_that_stand_in_the_program(tmp_path: Path) -> None:
    counts = m4.count_instructions(measuring.source_root(), tmp_path)

    def code(name: str) -> list[list[str]]:
        words = ["arm-none-eabi-objdump", "-d", f"--disassemble={name}", tmp_path / "driver.elf"]
        listing = subprocess.run(words, capture_output=True, text=True, check=True).stdout
        return [line.split("\t")[2:] for line in listing.splitlines() if re.match(r"\s+[0-9a-f]+:\t", line)]

    # a jump to the portable function, which has no branches: each instruction once, and nothing behind the return
    assert [words[0] for words in code("inlined_sincos")] == ["b.w"]
    body = code("angle_sincos_portable")
    returns = [k for k, words in enumerate(body) if re.match(r"bx lr|(ldr|ldr.w) pc,|pop {.*pc}", " ".join(words))]
    jumps = [words for words in body[: returns[0]] if re.match(r"(b|bl|blx|cbz|cbnz|b[a-z]{2})(\.n|\.w)?$", words[0])]
    assert (len(returns), jumps) == (1, [])
    assert counts["angle_sincos"] == 1 + returns[0] + 1
    assert counts["current_isr aro"] > counts["current_isr pi"] > counts["speed_isr pi"] > counts["ctl_pi_output"]
