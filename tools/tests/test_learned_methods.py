"""What any method has learned over the angle: kept in a file, given back, frozen, refused, and doing no harm."""

import json
import math

import numpy as np
import pytest
from evenspin.errors import InputError
from evenspin.memory import AngleTable, read_learned, read_table, write_table
from evenspin.model import load_scenario
from evenspin.model.machine import builtin_models, load_machine
from evenspin.sim import complete, prepare

FORC = """\
name = "angle"
model = "guo2024"
duration_s = {duration}
seed = 1
log_rate_hz = 1000.0

[drive]
method = "fal-forc"
rc_memory = "angle"
{extra}

[[event]]
at_s = 0.0
speed_rpm = 255.0
load_brake_a = 2.0
"""

POSITION = """\
name = "motion"
model = "yeh2024"
duration_s = {duration}
seed = 1
log_rate_hz = 1000.0

[drive]
position_method = "{method}"
profile_speed_rad_s = 2.094395102 # 20 rpm
rdc_learn_gain = 0.3
rdc_line1_cycles = {line}
rdc_line2_cycles = 4.0
rdc_line2_nm = 0.011 # half of what there is

[effects.torque_ripple]
order_1 = 24.0 # the paper's 24.0082 and 4.0592 drift against the rotor from turn to turn
order_2 = 4.0

[[event]]
at_s = 0.0
control = "position"
position_ref_turn = 10.0
"""


@pytest.fixture
def forc(tmp_path):
    def make(duration, extra=""):
        path = tmp_path / f"forc_{duration:g}_{len(extra)}.toml"
        path.write_text(FORC.format(duration=duration, extra=extra))
        return path

    return make


def first_order_pct(folder):
    return json.loads((folder / "summary.json").read_text())["segments"][-1]["n1_pct"]


def test_what_repetitive_control_learned_over_the_angle_acts_from_the_start_of_the_next_run(evenspin, forc, tmp_path):
    table = tmp_path / "learned.json"

    learned = evenspin("run", forc(4.0), "--out", tmp_path / "one", "--save-memory", table)
    cold = evenspin("run", forc(0.8), "--out", tmp_path / "cold", "--freeze-learning")
    warm = evenspin("run", forc(0.8), "--out", tmp_path / "warm", "--freeze-learning", "--memory", table)
    kept = evenspin(
        "run", forc(0.8), "--out", tmp_path / "kept", "--freeze-learning", "--memory", table, "--save-memory",
        tmp_path / "after.json",
    )  # fmt: skip

    assert (learned.status, cold.status, warm.status, kept.status) == (0, 0, 0, 0)
    assert first_order_pct(tmp_path / "cold") > 3.0
    assert first_order_pct(tmp_path / "warm") < 0.05 * first_order_pct(tmp_path / "cold")
    before, after = read_learned(table)[0], read_learned(tmp_path / "after.json")[0]
    assert after.values == pytest.approx(before.values, abs=1e-6)  # frozen; float has 24 bits of some 50 units
    shown = evenspin("memory", "show", table)
    assert "fal-forc" in shown.out and "electrical order" in shown.out


@pytest.mark.parametrize(("change", "reported"), [
    ("rc_cells = 128", "fal-forc: cells = 256: must be 128, the drive's rc_cells"),
    ("rc_limit_unit = 0.1", "rc_limit_unit"),
    ("speed_error_gain = 1.0", "fal-forc: speed_error_gain = 4.0: must be 1, the drive's speed_error_gain"),
    ("rc_order = 1", "fal-forc: rc_order = 2.0: must be 1"),
])  # fmt: skip
def test_a_table_of_another_drive_is_refused_with_both_numbers(evenspin, forc, tmp_path, change, reported):
    table = tmp_path / "learned.json"
    assert evenspin("run", forc(1.0), "--out", tmp_path / "one", "--save-memory", table).status == 0

    said = evenspin("run", forc(0.3, change), "--out", tmp_path / "two", "--memory", table)

    assert said.status == 2
    assert said.err.count("\n") == 1 and reported in said.err


def test_a_table_of_another_method_is_refused_with_both_names(evenspin, forc, tmp_path):
    table, other = tmp_path / "forc.json", tmp_path / "aro.json"
    assert evenspin("run", forc(0.3), "--out", tmp_path / "one", "--save-memory", table).status == 0
    assert evenspin("run", forc(0.3), "--method", "aro", "--out", tmp_path / "two", "--save-memory", other).status == 0

    said = evenspin("run", forc(0.3), "--method", "aro", "--out", tmp_path / "three", "--memory", table)
    back = evenspin("run", forc(0.3), "--out", tmp_path / "four", "--memory", other)
    crc = evenspin("run", forc(0.3), "--out", tmp_path / "five", "--method", "crc", "--memory", table)

    assert (said.status, back.status, crc.status) == (2, 2, 2)
    assert "method = 'fal-forc': must be aro" in said.err
    assert "evenspin angle memory 1" in back.err and "evenspin learned memory 1" in back.err
    assert "method = 'fal-forc': must be crc" in crc.err


@pytest.mark.parametrize(("method", "part"), [("silc", 0.6), ("src", 0.2), ("rdc", 0.4)])
def test_what_a_position_method_learned_acts_from_the_start_of_the_next_run(evenspin, tmp_path, method, part):
    """`part`: what may be left of the error of a frozen drive without a table; silc lags behind what it learned."""
    table, scenario = tmp_path / "learned.json", tmp_path / "motion.toml"

    def turn_2_mrad(name, duration, *options):
        scenario.write_text(POSITION.format(method=method, duration=duration, line=24.0))
        assert evenspin("run", scenario, "--out", tmp_path / name, *options).status == 0
        return json.loads((tmp_path / name / "summary.json").read_text())["motions"][1]["error_rms_mrad"]

    turn_2_mrad("learning", 30.0, "--save-memory", table)
    cold = turn_2_mrad("cold", 8.0, "--freeze-learning")
    warm = turn_2_mrad("warm", 8.0, "--freeze-learning", "--memory", table, "--save-memory", tmp_path / "after.json")

    assert warm < part * cold
    before, after = read_learned(table)[0], read_learned(tmp_path / "after.json")[0]
    assert after.method == method
    assert after.values == pytest.approx(before.values, abs=1e-6)


def test_a_table_beside_lines_that_drift_is_refused(evenspin, tmp_path):
    """What such lines leave is somewhere else in the next turn."""
    scenario = tmp_path / "motion.toml"
    scenario.write_text(POSITION.format(method="rdc", duration=1.0, line=24.0082))

    said = evenspin("run", scenario, "--out", tmp_path / "out", "--save-memory", tmp_path / "t.json")

    assert said.status == 2
    assert said.err.count("\n") == 1 and "rdc_line1_cycles = 24.0082: must be whole with --save-memory" in said.err


def test_two_methods_that_learn_are_in_one_file(evenspin, forc, tmp_path):
    table = tmp_path / "both.json"
    extra = 'disturbance_observer = "aro"\naro_cells = 100'

    first = evenspin("run", forc(1.0, extra), "--out", tmp_path / "one", "--save-memory", table)
    second = evenspin("run", forc(0.3, extra), "--out", tmp_path / "two", "--memory", table)

    assert (first.status, second.status) == (0, 0)
    assert [(each.method, len(each.values)) for each in read_learned(table)] == [("aro", 100), ("fal-forc", 256)]


@pytest.mark.parametrize(("method", "memory", "reported"), [
    ("fal-forc", "keep", "rc_memory = 'keep': must be angle with --save-memory and method = fal-forc"),
    ("crc", "clear", "rc_memory = 'clear'"),
    ("ro", "angle", "method = 'ro': must be one that learns over the angle"),
    ("pi", "angle", "method = 'pi'"),
])  # fmt: skip
def test_a_memory_over_time_is_not_saved_and_the_reason_is_given(evenspin, forc, tmp_path, method, memory, reported):
    path = forc(0.3)
    path.write_text(path.read_text().replace('rc_memory = "angle"', f'rc_memory = "{memory}"'))

    said = evenspin("run", path, "--method", method, "--out", tmp_path / "out", "--save-memory", tmp_path / "t.json")

    assert said.status == 2
    assert said.err.count("\n") == 1 and reported in said.err


def test_learning_over_time_cannot_be_frozen(evenspin, forc, tmp_path):
    path = forc(0.3)
    path.write_text(path.read_text().replace('rc_memory = "angle"', 'rc_memory = "keep"'))

    said = evenspin("run", path, "--out", tmp_path / "out", "--freeze-learning")

    assert said.status == 2
    assert "observer_hold" in said.err and "rc_memory" in said.err


def test_a_file_that_was_changed_is_refused(evenspin, forc, tmp_path):
    table = tmp_path / "learned.json"
    assert evenspin("run", forc(0.3), "--out", tmp_path / "one", "--save-memory", table).status == 0
    good = json.loads(table.read_text())

    def reported(**changes):
        table.write_text(json.dumps({**good, "tables": [{**good["tables"][0], **changes}]}))
        with pytest.raises(InputError) as refusal:
            read_learned(table)
        assert "\n" not in str(refusal.value)
        return str(refusal.value)

    values = good["tables"][0]["values"]
    assert "crc32" in reported(values=[values[0] + 0.01, *values[1:]])
    assert "values[0] = nan" in reported(values=[math.nan, *values[1:]])
    assert "cells" in reported(values=values[1:])
    assert "method" in reported(method=3)
    assert "learned_with" in reported(learned_with=[1.0])


def test_lines_of_what_was_learned_compensate_it(evenspin, tmp_path):
    theta = 2.0 * np.pi * np.arange(720) / 720
    forward_nm = 0.02 * np.sin(12.0 * theta + 0.4) + 0.01 * np.cos(24.0 * theta - 0.3)
    write_table(tmp_path / "t.csv", AngleTable(forward_nm / 0.5, 0.5))

    said = evenspin("memory", "lines", tmp_path / "t.csv", "--count", "2", "--json", tmp_path / "l.json")

    assert said.status == 0 and said.out.startswith("[drive]\nrdc_line1_cycles = 12")
    line = json.loads((tmp_path / "l.json").read_text())
    fed_nm = sum(
        line[f"rdc_line{n}_nm"] * np.sin(line[f"rdc_line{n}_cycles"] * theta + line[f"rdc_line{n}_rad"]) for n in (1, 2)
    )
    assert fed_nm == pytest.approx(-forward_nm, abs=1e-9)


def lines_file(path, *lines):
    """[drive] with (cycles, N m, rad) of each line."""
    words = ["[drive]"]
    for number, (cycles, amplitude_nm, phase_rad) in enumerate(lines, start=1):
        words += [f"rdc_line{number}_cycles = {cycles!r}", f"rdc_line{number}_nm = {amplitude_nm!r}"]
        words.append(f"rdc_line{number}_rad = {phase_rad!r}")
    path.write_text("\n".join(words) + "\n")
    return path


def test_a_table_made_of_lines_gives_these_lines_back(evenspin, tmp_path):
    given = lines_file(tmp_path / "lines.toml", (12.0, 0.06, 0.3), (5.0, 0.02, -2.9), (24.0, 0.01, 1.1))
    table = tmp_path / "t.csv"

    made = evenspin("memory", "from-lines", table, "--model", "tang2020-rig2", "--drive", given, "--cells", "64")
    back = evenspin("memory", "lines", table, "--count", "3")

    assert (made.status, back.status) == (0, 0)
    values = {line.split(" = ")[0]: float(line.split(" = ")[1]) for line in back.out.strip().splitlines()[1:]}
    rows = [[values[f"rdc_line{n}_{what}"] for what in ("cycles", "nm", "rad")] for n in (1, 2, 3)]
    assert rows == [pytest.approx(row, abs=1e-6) for row in ([12.0, 0.06, 0.3], [5.0, 0.02, -2.9], [24.0, 0.01, 1.1])]
    # by hand: the drive subtracts the table, so at angle 0 it holds -(sum of L sin phi) / (1.5 * 5 * 0.0594)
    first_a = read_table(table).disturbance_a[0]
    assert first_a == pytest.approx(-(0.06 * 0.2955202 - 0.02 * 0.2392493 + 0.01 * 0.8912074) / 0.4455, abs=1e-7)


def test_aro_starts_with_the_lines_of_a_model_as_if_it_had_learned_them(evenspin, tmp_path):
    """The lines are those of the machine itself, whose torque_ripple brakes with A sin(order theta + phase)."""
    machine = builtin_models()["tang2020-rig2"]
    effect = load_machine(machine).effects["torque_ripple"]
    lines = [(effect[f"order_{n}"], effect[f"amplitude_{n}_nm"], effect[f"phase_{n}_rad"]) for n in range(1, 7)]
    given, table, cells = lines_file(tmp_path / "lines.toml", *lines), tmp_path / "t.csv", "drive.aro_cells=720"
    made = ("--model", "tang2020-rig2", "--drive", given, "--cells", "720")
    assert evenspin("memory", "from-lines", table, *made).status == 0
    scenario = tmp_path / "s.toml"
    scenario.write_text(
        'name = "s"\nmodel = "tang2020-rig2"\nduration_s = 1.5\nseed = 1\nlog_rate_hz = 1000.0\n'
        '[drive]\nmethod = "aro"\naro_cells = 720\n[[event]]\nat_s = 0.0\nspeed_rpm = 123.0\n'
    )

    left = {}
    for name, more in (("cold", ()), ("warm", ("--memory", table))):
        out = tmp_path / name
        assert evenspin("run", scenario, "--set", cells, "--out", out, "--freeze-learning", *more).status == 0
        left[name] = json.loads((out / "summary.json").read_text())["segments"][-1]["n2_pct"]

    assert left["cold"] > 0.2
    assert left["warm"] < 0.02 * left["cold"]


@pytest.mark.parametrize(("line", "cells", "reported"), [
    ((24.0082, 0.14, 1.0), 200, "rdc_line1_cycles = 24.0082: must be a whole number"),
    ((0.0, 0.14, 1.0), 200, "rdc_line1_cycles = 0.0: must be a whole number"),
    ((24.0, 0.14, 1.0), 48, "rdc_line1_cycles = 24.0: must be below half of the 48 cells; use --cells 49 or more"),
    ((24.0, 0.0, 1.0), 200, "rdc_line1_nm = 0.0: must be above 0"),
])  # fmt: skip
def test_lines_that_no_table_holds_are_refused_with_what_to_do(evenspin, tmp_path, line, cells, reported):
    given = lines_file(tmp_path / "lines.toml", line)

    said = evenspin(
        "memory", "from-lines", tmp_path / "t.csv", "--model", "yeh2024", "--drive", given, "--cells", str(cells)
    )

    assert said.status == 2
    assert reported in said.err and said.err.count("\n") == 1
    assert not (tmp_path / "t.csv").exists()


# ---- starting, reversing, standing still ---------------------------------------------------------------------------

REVERSAL = """\

[[event]]
at_s = 2.0
speed_rpm = -{rpm:g}

[[event]]
at_s = 4.0
speed_rpm = 0.0
"""


@pytest.mark.parametrize(("model", "rpm", "words"), [
    ("tang2020-rig2", 100.0, 'method = "aro"\naro_write = "hat"\naro_fast_s = 20.0'),
    ("guo2024", 255.0, 'method = "fal-forc"\nrc_memory = "angle"'),
])  # fmt: skip
@pytest.mark.parametrize("frozen", [False, True])
def test_starting_reversing_and_standing_with_a_learned_table_does_no_harm(tmp_path, model, rpm, words, frozen):
    """Against the drive without it: overshoots at most 3 rpm larger, ripple smaller in both directions, and at rest
    not more than the encoder's count."""

    def motion(name, drive, duration, memory=None):
        path = tmp_path / f"{name}.toml"
        head = (
            f'name = "{name}"\nmodel = "{model}"\nduration_s = {duration}\nseed = 1\nlog_rate_hz = 2000.0\n\n[drive]\n'
        )
        events = f"{drive}\n\n[[event]]\nat_s = 0.0\nspeed_rpm = {rpm}\n"
        path.write_text(head + events + (REVERSAL.format(rpm=rpm) if duration == 6.0 else ""))
        setup, signals = load_scenario(path).setup, ("t_s", "true_speed_rad_s")
        simulation = prepare(setup, signals, "float", memory)
        record = complete(simulation, setup, signals)
        t_s, speed_rpm = record["t_s"], record["true_speed_rad_s"] * 30.0 / math.pi

        def within(start_s, end_s):
            return speed_rpm[(t_s >= start_s) & (t_s < end_s)]

        figures = (
            within(0.0, 2.0).max() - rpm,
            -rpm - within(2.0, 4.0).min(),
            within(1.5, 2.0).std(),
            within(3.5, 4.0).std(),
            float(np.abs(within(4.5, 6.0)).max(initial=0.0)),
        )
        return figures, simulation.memory()

    _, table = motion("learning", words, 8.0)
    off, _ = motion("off", 'method = "pi"', 6.0)
    on, _ = motion("on", words + ("\nobserver_hold = true" if frozen else ""), 6.0, table)

    assert on[0] < off[0] + 3.0 and on[1] < off[1] + 3.0
    assert on[2] < 0.1 * off[2] and on[3] < 0.8 * off[3]
    assert on[4] < off[4] + 0.1
