"""Measured beside estimated: what a log says of the interrupts, and how that is judged."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from evenspin.cycles import measure as measuring
from evenspin.cycles.compare import UNITS, compare, read_measured, variant_of
from evenspin.cycles.evidence import LARGE_CYC, Listed
from evenspin.cycles.measure import Result
from evenspin.cycles.rows import Row, base_of
from evenspin.errors import InputError
from said import Said

# A tenth of these long functions is at 0.8 of the real count, a tenth at 1.25: 1000 cycles may be 800 .. 1250.
LONG = 10 * LARGE_CYC
LISTED = tuple(
    Listed("somebody/firmware", "f", True, LONG, {"mem": round(LONG * ratio / 1.1)})
    for ratio in (0.8, 0.8, 0.9, 0.95, 1.0, 1.0, 1.05, 1.1, 1.2, 1.25, 1.25)
)
FRAME = 65  # cycles of entry and exit, see docs/cycles.md


def estimate(**worst: int) -> Result:
    rows = [Row(name.replace("_isr_", "_isr "), "isr", w + FRAME - 50, w + FRAME, None, None, "model")
            for name, w in worst.items()]  # fmt: skip
    return Result(rows, LISTED)


def write_log(path: Path, **columns: list[float]) -> Path:
    rows = zip(*columns.values(), strict=True)
    path.write_text("\n".join([",".join(columns), *(",".join(f"{x:g}" for x in row) for row in rows)]) + "\n")
    return path


@pytest.mark.parametrize(
    ("longest", "verdict"), [(799, "below"), (800, "inside"), (1000, "inside"), (1250, "inside"), (1251, "above")]
)
def test_a_measurement_is_inside_when_the_error_of_the_estimate_explains_it(
    tmp_path: Path, longest: int, verdict: str
) -> None:
    log = write_log(tmp_path / "a.csv", isr_max_cycles=[longest])

    (row,) = compare(read_measured(log), estimate(current_isr_pi=1000), "pi")

    assert (row.estimated_mean, row.estimated_worst, row.expected) == (950, 1000, (800, 1250))
    assert row.verdict == verdict
    assert row.difference_pct == pytest.approx(100.0 * (longest - 1000) / 1000)


def test_a_log_tells_last_shortest_longest_of_both_interrupts(tmp_path: Path) -> None:
    log = write_log(
        tmp_path / "a.csv",
        t_s=[0, 1], isr_cycles=[900, 950], isr_min_cycles=[900, 880], isr_max_cycles=[910, 990],
        speed_isr_cycles=[300, 310], speed_isr_max_cycles=[300, 340],
    )  # fmt: skip

    measured = read_measured(log)

    current, speed = measured["current_isr"], measured["speed_isr"]
    assert (current.last, current.shortest, current.longest) == (950, 880, 990)
    assert (speed.last, speed.shortest, speed.longest) == (310, None, 340)
    assert current.bins is None


def test_each_bin_of_the_histogram_is_what_its_last_row_showed(tmp_path: Path) -> None:
    log = write_log(tmp_path / "a.csv", isr_max_cycles=[990, 990, 990], isr_bin=[1, 3, 1], isr_bin_count=[10, 5, 12])

    bins = read_measured(log)["current_isr"].bins

    assert bins == (0, 12, 0, 5) + 13 * (0,)


def test_a_log_without_durations_is_refused_with_what_to_log(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="isr_max_cycles.*must be in the header"):
        read_measured(write_log(tmp_path / "a.csv", t_s=[0], speed_rad_s=[1]))
    with pytest.raises(InputError, match="must be above 0; the clock stood still"):
        read_measured(write_log(tmp_path / "b.csv", isr_max_cycles=[0]))
    with pytest.raises(InputError, match="existing file"):
        read_measured(tmp_path / "c.csv")


def test_an_unknown_variant_is_refused_with_the_known_ones(tmp_path: Path) -> None:
    measured = read_measured(write_log(tmp_path / "a.csv", isr_max_cycles=[1000]))

    with pytest.raises(InputError, match="one of aro, pi"):
        compare(measured, estimate(current_isr_pi=1000, current_isr_aro=1500), "arro")


@pytest.mark.parametrize(
    ("changed", "position", "name"),
    [
        ({}, False, "pi"),
        ({"method": "fal-forc"}, False, "fal-forc"),
        ({"method": "fal-forc", "rc_memory": "angle"}, False, "fal-forc angle"),
        ({"method": "aro", "current_controller": "deadbeat"}, False, "aro deadbeat"),
        ({"method": "aro", "aro_read": "cubic"}, False, "aro extended"),
        ({"position_method": "rdc"}, True, "position rdc"),
    ],
)
def test_drive_parameters_name_their_row(changed: dict[str, str], position: bool, name: str) -> None:
    drive = {
        "method": "pi", "rc_memory": "keep", "aro_read": "linear", "current_controller": "pi", "position_method": "ppi",
    }  # fmt: skip

    assert variant_of({**drive, **changed}, position) == name


@pytest.mark.parametrize(("variant", "base"), [
    ("aro", "pi"), ("pi", "pi"), ("aro deadbeat", "pi deadbeat"), ("pi deadbeat", "pi deadbeat"),
    ("fal-forc angle", "pi"), ("position rdc", "position ppi"),
])  # fmt: skip
def test_a_method_costs_more_than_the_drive_without_one_under_the_same_current_controller(variant, base):
    assert base_of(variant) == base


@pytest.fixture
def no_estimating(monkeypatch: pytest.MonkeyPatch) -> None:
    known = estimate(current_isr_forc=2400, speed_isr_forc=1500)
    monkeypatch.setattr(measuring, "measure", lambda root, with_m4=True: known)


LOAD = "isr_load_cyc = 2400\nspeed_isr_load_cyc = 2000\n"


@pytest.mark.usefixtures("no_estimating")
def test_a_run_that_loads_its_interrupts_is_compared_from_simulation_to_verdict(
    evenspin: Callable[..., Said], scenario: Path, tmp_path: Path
) -> None:
    scenario.write_text(scenario.read_text().replace("speed_rpm = 300.0\n", f"speed_rpm = 300.0\n{LOAD}"))
    out = tmp_path / "out"
    assert evenspin("run", scenario, "--out", out).status == 0

    said = evenspin("cycles", "--compare", out, "--check", "--json")

    assert said.status == 1
    document = json.loads(said.out)
    assert document["variant"] == "forc"
    current, speed = document["rows"]
    assert (current["measured_max"], current["difference_pct"], current["verdict"]) == (2400, 0.0, "inside")
    assert (speed["measured_max"], speed["verdict"]) == (2000, "above")  # 1875 is the most that 1500 may be
    bins = document["histogram"]["current_isr"]
    # 0.5 s at 10 kHz, in the bin that 2400 / 512 falls into; the last row that shows it is at most 17 rows old
    assert 4900 <= bins[4] <= 5000
    assert sum(bins) == bins[4]
    assert evenspin("cycles", "--compare", out).status == 0


@pytest.mark.usefixtures("no_estimating")
def test_a_run_without_load_has_no_durations_and_says_how_to_get_them(
    evenspin: Callable[..., Said], scenario: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert evenspin("run", scenario, "--out", out).status == 0
    assert not (out / "timing.csv").exists()

    said = evenspin("cycles", "--compare", out)

    assert said.status == 2
    assert "isr_load_cyc" in said.err
    assert said.err.count("\n") == 1


@pytest.mark.usefixtures("no_estimating")
def test_a_log_without_its_summary_needs_the_variant(evenspin: Callable[..., Said], tmp_path: Path) -> None:
    log = write_log(tmp_path / "bench.csv", isr_max_cycles=[2500])

    said = evenspin("cycles", "--compare", log)
    assert said.status == 2
    assert "--variant" in said.err

    assert evenspin("cycles", "--compare", log, "--variant", "forc").status == 0
    drive = {"method": "forc", "rc_memory": "keep", "aro_read": "linear", "current_controller": "pi"}
    (tmp_path / "meta.json").write_text(json.dumps({"drive": drive}))
    assert evenspin("cycles", "--compare", log).status == 0
    assert evenspin("cycles", "--variant", "forc").status == 2
    assert evenspin("cycles", "--compare", log, "--record").status == 2
    assert evenspin("cycles", "--compare", log, "--no-m4").status == 2


@pytest.mark.parametrize("words", [(), ("--no-m4",)])
def test_the_instructions_of_a_cortex_are_counted_unless_they_are_left_out(
    evenspin: Callable[..., Said], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    from evenspin.cycles import measure

    monkeypatch.setattr(measure, "find_clang", lambda: "clang")
    monkeypatch.setattr(measure, "run_driver", lambda root, clang, work: ({}, {}))
    monkeypatch.setattr(measure, "worst_cases", lambda *_: ([], []))
    monkeypatch.setattr(measure, "m4_counts", lambda root, work: (None, "counted"))
    assert ("counted" in evenspin("cycles", *words).out) == (not words)


def test_the_columns_are_signals_of_the_drive() -> None:
    from evenspin.native import tables

    signals = tables().signals
    assert {name: signals[name].unit for name in UNITS} == UNITS
