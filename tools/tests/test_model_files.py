"""Model and scenario files: what they mean, and one line for whatever is wrong with them."""

import math
import re
import tomllib

import pytest
from evenspin.bench.experiments import plan as bench_plan
from evenspin.drive import VirtualDrive
from evenspin.errors import InputError
from evenspin.gap.plan import plan as gap_plan
from evenspin.model import builtin_models, builtin_scenario, load_machine, load_scenario
from evenspin.model.machine import SIMULATED
from evenspin.model.scenario import builtin_scenarios
from evenspin.model.toml_lines import key_lines
from evenspin.native import tables
from hypothesis import given
from hypothesis import strategies as st

RPM = math.pi / 30.0
K_T = 1.5 * 4 * 6.4e-3  # N m/A


@pytest.fixture
def load(tmp_path):
    def load_text(text: str | bytes):
        path = tmp_path / "it.toml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_scenario(path)

    return load_text


def refusal(load, text) -> str:
    with pytest.raises(InputError) as caught:
        load(text)
    said = str(caught.value)
    assert "\n" not in said
    return said


# ---- what they mean --------------------------------------------------------------------------------------------------


def test_the_first_scenario_is_that_of_the_paper():
    setup = builtin_scenario("guo2024/first").setup

    speed, load = setup.inputs["speed_ref_rad_s"], setup.inputs["load_brake_nm"]
    assert (speed.t_s, load.t_s) == ((0.0, 8.0, 16.0, 24.0), (0.0, 4.0, 12.0, 20.0, 28.0))
    assert speed.value == pytest.approx([rpm * RPM for rpm in (150, 203, 255, 295)])
    assert load.value == pytest.approx([a * K_T for a in (1.0, 2.5, 3.5, 4.5, 5.5)])
    assert setup.duration_s == 32.0
    assert setup.effects == {
        "current_gain": {"gain_a": 1.1, "gain_b": 0.9},
        "current_offset": {"offset_a_a": 0.2, "offset_b_a": 0.05},
    }


def test_every_built_in_file_is_valid():
    assert {"guo2024/first", "guo2024/second", "guo2024/third"} <= set(builtin_scenarios())
    for name in builtin_scenarios():
        assert builtin_scenario(name).setup.periods > 0
    for path in builtin_models().values():
        assert load_machine(path).plant["inertia_kgm2"] > 0


def test_the_built_in_model_is_the_default_drive():
    """The file spells out what the firmware has as its defaults; if they part, one of them is wrong."""
    machine = load_machine(builtin_models()["guo2024"])
    switched_off = {"offset_calibration_periods": 0.0, "align_periods": 0.0, "auto_run": 1.0}

    assert machine.drive == pytest.approx(
        {name: tables().params[name].default for name in machine.drive} | switched_off
    )
    assert machine.plant == pytest.approx({name: field.default for name, field in tables().model.items()})


def test_a_scenario_goes_on_top_of_its_model(load, scenario_text):
    text = scenario_text.replace('method = "forc"', 'method = "fal-forc"\nrc_gain = 0.5')
    setup = load(f"{text}\n[effects.current_gain]\ngain_a = 1.2\n[effects.cogging]\namplitude_nm = 0.01\n").setup

    assert tables().params["method"].to_text(setup.drive["method"]) == "fal-forc"
    assert setup.drive["rc_gain"] == 0.5
    assert setup.effects["current_gain"] == {"gain_a": 1.2, "gain_b": 0.9}
    assert setup.effects["cogging"] == {"amplitude_nm": 0.01}


def test_a_model_beside_the_scenario_is_found(tmp_path, scenario_text):
    (tmp_path / "mine.toml").write_text(
        'name = "mine"\nbase = "guo2024"\n[plant]\npole_pairs = 3\ncounts_per_rev = 8192\n'
    )
    (tmp_path / "s.toml").write_text(scenario_text.replace('"guo2024"', '"mine.toml"'))

    setup = load_scenario(tmp_path / "s.toml").setup

    assert setup.plant["pole_pairs"] == 3
    assert (setup.drive["pole_pairs"], setup.drive["encoder_counts"]) == (3, 8192)  # the drive knows its motor


# A servo motor of nobody's, and what the drive has to know of it: the same number under the drive's name.
OWN_PLANT = {
    "pole_pairs": 7,
    "resistance_ohm": 0.1,
    "ld_h": 4e-5,
    "lq_h": 5e-5,
    "psi_wb": 5e-3,
    "inertia_kgm2": 2e-3,
    "viscous_nms": 3e-5,
    "dc_link_v": 36.0,
    "counts_per_rev": 8192,
}
KNOWN = {
    "pole_pairs": 7,
    "encoder_counts": 8192,
    "motor_resistance_ohm": 0.1,
    "motor_ld_h": 4e-5,
    "motor_lq_h": 5e-5,
    "motor_psi_wb": 5e-3,
    "observer_inertia_kgm2": 2e-3,
    "observer_viscous_nms": 3e-5,
    "rdc_inertia_kgm2": 2e-3,
    "rdc_viscous_nms": 3e-5,
}


def model_file(folder, plant, head="", tail=""):
    path = folder / "own.toml"
    lines = [f"{name} = {value!r}" for name, value in plant.items()]
    path.write_text("\n".join(['name = "own"', head, "[plant]", *lines, tail, ""]))
    return path


def test_the_drive_is_told_the_motor_of_its_model(tmp_path):
    machine = load_machine(model_file(tmp_path, OWN_PLANT), SIMULATED)

    assert machine.drive == KNOWN
    assert machine.drive_from["motor_psi_wb"] == "[plant] psi_wb of the model"


def test_what_the_drive_assumes_may_differ_from_the_motor(tmp_path):
    machine = load_machine(model_file(tmp_path, OWN_PLANT, tail="[drive]\nmotor_psi_wb = 4e-3"))

    assert machine.drive == KNOWN | {"motor_psi_wb": 4e-3}
    assert machine.drive_from["motor_psi_wb"] == "[drive] of the model"


def test_a_model_with_missing_numbers_lists_all_of_them(tmp_path):
    with pytest.raises(InputError) as caught:
        load_machine(model_file(tmp_path, {"pole_pairs": 7}), SIMULATED)

    said = str(caught.value)
    for name in OWN_PLANT:
        assert (f" {name}," in said or f" {name} " in said) is (name != "pole_pairs")
    assert 'base = "guo2024"' in said and "\n" not in said


@pytest.mark.parametrize("left_out", sorted(OWN_PLANT))
def test_no_number_of_the_motor_is_taken_from_another_one(tmp_path, left_out):
    plant = {name: value for name, value in OWN_PLANT.items() if name != left_out}

    with pytest.raises(InputError, match=f"complete: {left_out} is missing"):
        load_machine(model_file(tmp_path, plant), SIMULATED)


def test_a_model_says_openly_what_it_stands_on(tmp_path):
    machine = load_machine(model_file(tmp_path, {"pole_pairs": 7}, 'base = "servo"'), SIMULATED)

    assert (machine.base, machine.plant["pole_pairs"], machine.plant["psi_wb"]) == ("servo", 7.0, 0.1)
    assert machine.drive_from["motor_psi_wb"] == "[plant] psi_wb of the base servo"
    assert "current_kp_v_per_a" not in machine.drive  # the base gives its plant, and nothing else
    with pytest.raises(InputError, match="did you mean servo"):
        load_machine(model_file(tmp_path, OWN_PLANT, 'base = "servos"'))


def test_ratings_that_are_not_given_are_not_known(tmp_path):
    machine = load_machine(model_file(tmp_path, OWN_PLANT))

    assert [machine.plant[name] for name in ("rated_current_a", "rated_torque_nm", "slots")] == [0.0, 0.0, 0.0]
    with pytest.raises(InputError, match="rated_current_a, rated_torque_nm are missing"):
        gap_plan(machine)
    with pytest.raises(InputError, match="rated_current_a, rated_torque_nm are missing"):
        bench_plan(machine)


@pytest.mark.parametrize(("supply_v", "fits"), [(560.0, "over_voltage_v = 700.0"), (8.0, "under_voltage_v = 5.0")])
def test_a_drive_that_trips_on_its_own_supply_is_refused(tmp_path, scenario_text, supply_v, fits):
    plant = OWN_PLANT | {"dc_link_v": supply_v}
    scenario = tmp_path / "s.toml"
    scenario.write_text(scenario_text.replace('"guo2024"', '"own.toml"'))
    machine = load_machine(model_file(tmp_path, plant))  # a design or a torque balance has no supply

    refused = f"drive.{fits.split()[0]} = .*the drive trips at once"
    with pytest.raises(InputError, match=refused):
        load_scenario(scenario)
    with pytest.raises(InputError, match=refused):
        VirtualDrive(machine)

    scenario.write_text(scenario.read_text().replace("[drive]", f"[drive]\n{fits}"))
    assert load_scenario(scenario).setup.plant["dc_link_v"] == supply_v
    model_file(tmp_path, plant, tail=f"[drive]\n{fits}")
    assert VirtualDrive(load_machine(tmp_path / "own.toml")).time_s == 0.0


def test_words_may_change_a_scenario_as_in_its_file(load, scenario_text):
    found = load(scenario_text)

    assert found.with_changes({"method": "fal-forc"}) == found.with_changes({"method": 3.0})
    with pytest.raises(InputError, match='method = .forced.: must be "pi"'):
        found.with_changes({"method": "forced"})
    with pytest.raises(InputError, match="did you mean rc_gain"):
        found.with_changes({"rc_gains": 0.3})


def test_a_ramp_is_a_straight_line_and_a_step_beside_it_stays_a_step(load, scenario_text):
    text = scenario_text.replace("speed_rpm = 300.0", "speed_rad_s = 10.0\nramp_s = 0.1")
    curve = load(f"{text}\n[[event]]\nat_s = 0.3\nspeed_rad_s = -5.0\n").setup.inputs["speed_ref_rad_s"]

    assert curve.linear
    assert curve.t_s == pytest.approx((0.0, 0.1, 0.3, 0.3), abs=1e-8)
    assert curve.value == (0.0, 10.0, 10.0, -5.0)


def test_a_ramp_that_is_overtaken_ends_where_it_was(load, scenario_text):
    text = scenario_text.replace("speed_rpm = 300.0", "speed_rad_s = 10.0\nramp_s = 0.2")
    curve = load(text.replace("load_brake_a = 2.0", "") + "\n[[event]]\nat_s = 0.3\nspeed_rad_s = 0.0\n").setup.inputs[
        "speed_ref_rad_s"
    ]
    early = load(text.replace("at_s = 0.25\nload_brake_a = 2.0", "at_s = 0.1\nspeed_rad_s = 0.0"))

    assert curve.value[1] == 10.0
    assert early.setup.inputs["speed_ref_rad_s"].value == pytest.approx((0.0, 5.0, 0.0))


def test_an_input_that_starts_later_has_its_default_before(load, scenario_text):
    setup = load(f"{scenario_text}\n[[event]]\nat_s = 0.4\nload_torque_nm = 0.1\ndc_link_v = 20.0\n").setup

    assert setup.inputs["load_torque_nm"].value == (0.0, 0.1)
    assert setup.inputs["dc_link_v"].value == (24.0, 20.0)


def test_events_may_switch_the_mode_and_tune_the_drive(load, scenario_text):
    event = 'at_s = 0.4\ncontrol = "current"\niq_ref_a = 1.0\ndrive = { rc_gain = 0.3, rc_limit_unit = 2.0 }'
    setup = load(f"{scenario_text}\n[[event]]\n{event}\n").setup

    assert setup.inputs["control_mode"].value == (1.0, 0.0)
    assert {(tune.param, tune.value) for tune in setup.tunes} == {("rc_gain", 0.3), ("rc_limit_unit", 2.0)}


# ---- what is wrong with them -----------------------------------------------------------------------------------------

CASES = {
    "a misspelt key": ("duration_s", "duration_ss", "3: duration_ss = 0.5: must be", "did you mean duration_s?"),
    "a wrong unit": ("duration_s", "duration_ms", "3: duration_ms = 0.5: must be a known", "mean duration_s?"),
    "a wrong unit in an event": ("speed_rpm", "speed_rps", "12: event.speed_rps = 300.0:", "did you mean speed_rpm"),
    "a wrong type": ("seed = 3", 'seed = "3"', "4: seed = '3': must be a whole number", ""),
    "a switch for a number": ("seed = 3", "seed = true", "4: seed = true: must be a whole number", ""),
    "out of range": ("duration_s = 0.5", "duration_s = -1", "3: duration_s = -1: must be a time in 0.001 ..", ""),
    "not a number": ("speed_rpm = 300.0", "speed_rpm = nan", "12: event.speed_rpm = nan: must be a finite number", ""),
    "infinite": ("load_brake_a = 1.0", "load_brake_a = inf", "13: event.load_brake_a = inf: must be a finite", ""),
    "astronomical": ("speed_rpm = 300.0", f"speed_rpm = 1{'0' * 400}", "12: event.speed_rpm = 1000", ""),
    "an impossible speed": ("speed_rpm = 300.0", "speed_rpm = 1e9", "12: event.speed_rpm = 1000000000.0: must", "rpm"),
    "a change at rest only": (
        "at_s = 0.25", 'at_s = 0.25\ndrive = { method = "pi" }', "17: event.drive.method = 'pi': must be a parameter",
        "set it in [drive]",
    ),
    "a negative brake": ("load_brake_a = 1.0", "load_brake_a = -1.0", "13: event.load_brake_a = -1.0: must", "0 .. "),
    "an unknown choice": ('"forc"', '"ford"', "8: drive.method = 'ford': must be \"pi\" or", ""),
    "an unknown model": ('"guo2024"', '"guo2025"', "2: model = 'guo2025': must be", "mean guo2024 or guo2024-board?"),
    "a model that is not there": ('"guo2024"', '"g.toml"', "2: model = 'g.toml': must be an existing file", ""),
    "a rate that does not divide": ("2000.0", "3000.0", "5: log_rate_hz = 3000.0: must be", "nearest: 3333.3"),
    "events out of order": ("at_s = 0.25", "at_s = 0.0", "16: event.at_s = 0.0: must be later", ""),
    "an event after the end": ("at_s = 0.25", "at_s = 0.5", "16: event.at_s = 0.5: must be over before", ""),
    "a missing time": ("at_s = 0.25\n", "", "15: event.at_s = (missing): must be a time", "give it"),
    "one input twice": ("speed_rpm = 300.0", "speed_rpm = 300.0\nspeed_rad_s = 30", "13: event.speed_rad_s", "keep"),
    "a ramp of nothing": ("load_brake_a = 2.0", "load_brake_a = 2.0\nramp_s = 0.1", "18: event.ramp_s = 0.1: must", ""),
    "no TOML": ("seed = 3", "seed = = 3", "4: text = 'seed = = 3': must be TOML", ""),
    "a key twice": ("seed = 3", "seed = 3\nseed = 4", "5: text = ", ""),
    "a table for a number": ("seed = 3", "seed = { a = 1 }", "4: seed = {'a': 1}: must be a whole number", ""),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_one_line_says_where_what_and_what_next(load, scenario_text, case):
    old, new, start, hint = CASES[case]

    said = refusal(load, scenario_text.replace(old, new, 1))

    assert re.match(r".*/it\.toml:", said)
    assert said.partition("it.toml:")[2].startswith(start)
    assert hint in said
    assert ": must be " in said and "; " in said


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"", "(empty)"),
        (b"  \n\n", "(empty)"),
        (b"\x7fELF\x02\x01\x01\xff\xfe", "UTF-8"),
        (b"\x00" * 100, "TOML"),
        (b"# x\n" * 300_000, "at most 1000000 bytes"),
        (b"x = " + b"[" * 50_000, "TOML"),
        (b"x = 1" + b"0" * 9_000, "TOML"),
        ("name = 'ü".encode("latin-1"), "UTF-8"),
        (b'name = "only a name"', "must be"),
    ],
)
def test_whatever_the_file_is_there_is_an_answer(load, content, word):
    assert word in refusal(load, content)


@given(content=st.binary(max_size=300))
def test_random_bytes_are_refused_in_one_line(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("fuzz") / "f.toml"
    path.write_bytes(content)

    with pytest.raises(InputError) as caught:
        load_scenario(path)

    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: file = \(missing\)"):
        load_scenario(tmp_path / "none.toml")
    with pytest.raises(InputError, match="a TOML file"):
        load_scenario(tmp_path)


def test_a_wrong_model_is_reported_in_the_model(tmp_path, scenario_text):
    (tmp_path / "m.toml").write_text('name = "m"\n\n[plant]\nresistance_ohm = -1.0\n')
    (tmp_path / "s.toml").write_text(scenario_text.replace('"guo2024"', '"m.toml"'))

    with pytest.raises(InputError) as caught:
        load_scenario(tmp_path / "s.toml")

    field = tables().model["resistance_ohm"]
    expected = f"plant.resistance_ohm = -1.0: must be a number in {field.minimum:g} .. {field.maximum:g} ohm"
    assert f"m.toml:4: {expected}" in str(caught.value)


@pytest.mark.parametrize("name", list(tables().params))
def test_every_drive_parameter_is_limited_to_its_range(load, scenario_text, name):
    field = tables().params[name]
    if field.kind in ("choice", "flag"):
        wrong = '"none of these"'
    else:
        wrong = f"{field.maximum * 2 + 1:.0f}" if field.kind == "integer" else repr(field.maximum * 2 + 1)

    said = refusal(load, scenario_text.replace('method = "forc"', f"{name} = {wrong}"))

    assert f"it.toml:8: drive.{name} = " in said
    assert field.allowed() in said


# ---- lines -----------------------------------------------------------------------------------------------------------


def test_every_key_is_found_on_its_line():
    text = (
        "# a comment = 1\n"
        'a = "x # no comment" # comment\n'
        "b.c = [1,\n"
        "  { d = 2, e = [\n"
        "    3] },\n"
        "]\n"
        "[t.'u v']\n"
        '"k = 1" = """\n'
        "z = 9\n"
        '"""\n'
        "[[w]]\n"
        "x = 1\n"
        "[[w]]\n"
        "[w.y]\n"
        "x = 2\n"
    )

    lines = key_lines(text)

    tomllib.loads(text)
    assert lines["a",] == 2
    assert lines["b", "c"] == 3
    assert lines["b", "c", 1, "d"] == 4
    assert lines["b", "c", 1, "e", 0] == 5
    assert lines["t", "u v", "k = 1"] == 8
    assert lines["w", 0, "x"] == 12
    assert lines["w", 1, "y", "x"] == 15
    assert ("z",) not in lines


@given(values=st.lists(st.tuples(st.text("abc", min_size=1, max_size=3), st.text(max_size=8)), max_size=6))
def test_no_string_confuses_the_lines(values):
    lines = []
    for number, (key, value) in enumerate(values):
        escaped = "".join(f"\\U{ord(c):08x}" for c in value if not 0xD800 <= ord(c) < 0xE000)
        lines.append(f'k{number}{key} = "{escaped}"')
    text = "\n".join(lines)

    assert key_lines(text) == {(line.split(" ")[0],): number for number, line in enumerate(lines, start=1)}


def test_a_position_scenario_is_in_turns_or_radians(scenario, scenario_text):
    for key, value in (("position_ref_turn", 2.5), ("position_ref_rad", 2.5 * 2.0 * math.pi)):
        text = scenario_text.replace("speed_rpm = 300.0", f'control = "position"\n{key} = {value!r}\nhome = 1')
        scenario.write_text(text)

        inputs = load_scenario(scenario).setup.inputs

        assert inputs["control_mode"].value == (2.0,)
        assert inputs["position_ref_rad"].value == pytest.approx((5.0 * math.pi,))
        assert inputs["home"].value == (1.0,)


@pytest.mark.parametrize("target", ["position_ref_turn = 3.5", "position_ref_rad = -19.0"])
def test_a_target_beyond_the_soft_limits_names_the_line(scenario, scenario_text, target):
    text = scenario_text.replace('method = "forc"', "position_min_turn = -3.0\nposition_max_turn = 3.0")
    scenario.write_text(text.replace("speed_rpm = 300.0", target))

    with pytest.raises(InputError, match="must be within the soft limits") as refused:
        load_scenario(scenario)

    assert refused.value.line == text.split("\n").index("speed_rpm = 300.0") + 1
