"""Values that the library refuses become one sentence, in one place."""

import inspect
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from evenspin import blocks
from evenspin.bench.errors import NoDeviceError, RefusedError
from evenspin.errors import InputError, NativeError
from evenspin.model import builtin_scenario
from evenspin.native import RefusedValueError, load, tables
from evenspin.native.refusal import CODES, LISTS, Refusal
from evenspin.native.simulation import Simulation
from evenspin.sim import simulate


def refused(what) -> Refusal:
    with pytest.raises(RefusedValueError) as error:
        what(Simulation())
    assert isinstance(error.value, NativeError)
    assert "\n" not in str(error.value)
    return error.value.refusal


def test_every_code_of_the_header_has_its_sentence():
    codes = load().ffi.typeof("es_code_t").relements

    assert {code.removeprefix("ES_") for code in codes} == CODES


@pytest.mark.parametrize("code", sorted(CODES))
def test_no_refusal_fails_to_become_a_sentence(code):
    refusal = Refusal(code, "param", "rc_gain", "iq_limit_a", 3.0, 0.0, 2.0, False, False, "A", "such that it fits")

    assert refusal.reason
    starts = {"TWO_SHAFTS": "effects.rc_gain and effects.", "UNKNOWN": "rc_gain: "}
    assert str(refusal).startswith(starts.get(code, "rc_gain = 3: "))


@pytest.mark.parametrize(("change", "said"), [
    ({}, "within 1 .. 3 A"),
    ({"above": True}, "above 1 and at most 3 A"),
    ({"below": True}, "at least 1 and below 3 A"),
    ({"maximum": math.inf}, "at least 1 A"),
    ({"maximum": math.inf, "above": True}, "above 1 A"),
    ({"minimum": -math.inf}, "at most 3 A"),
    ({"minimum": 3.0}, "3 A"),
    ({"code": "NOT_WHOLE", "unit": ""}, "a whole number within 1 .. 3"),
])  # fmt: skip
def test_a_range_is_said_with_the_ends_that_belong_to_it(change, said):
    values = {"code": "OUT_OF_RANGE", "list": "param", "name": "x", "other": "", "given": 5.0, "minimum": 1.0}
    values |= {"maximum": 3.0, "above": False, "below": False, "unit": "A", "rule": ""}

    assert Refusal(**(values | change)).must == said


@pytest.mark.parametrize(("call", "said"), [
    (lambda s: s.set_param("rc_gian", 1.0), r"^rc_gian: no such drive parameter; did you mean rc_gain"),
    (lambda s: s.set_model("resistance", 1.0), r"no such model field; did you mean resistance_ohm"),
    (lambda s: s.set_effect("coging", "order", 1.0), r"no such effect; did you mean cogging"),
    (lambda s: s.set_effect("cogging", "phase", 1.0), r"no such parameter of this effect; did you mean phase_rad"),
    (lambda s: s.set_input("load_torque", [0.0], [1.0]), r"no such input; did you mean load_torque_nm"),
    (lambda s: s.record(["speed"]), r"no such signal"),
    (lambda s: s.set_param("pole_pairs", 2.5), r"pole_pairs = 2.5: must be a whole number within 1 .. 50$"),
    (lambda s: s.set_model("resistance_ohm", math.nan), r"resistance_ohm = nan: must be within .* ohm$"),
    (lambda s: s.set_input("load_torque_nm", [1.0, 0.0], [1.0, 1.0]), r"times that are finite and rise$"),
])  # fmt: skip
def test_what_is_refused_says_name_value_limit_and_next_step(call, said):
    assert re.search(said, str(refused(call)))


def test_every_list_of_names_that_c_speaks_of_is_known():
    assert set(LISTS) == {"model", "param", "effect", "effect_param", "input", "signal", "block", "block_param"}


def test_two_effects_that_want_the_shaft_are_both_named():
    setup = builtin_scenario("guo2024/first").setup
    simulation = Simulation()
    for name, value in setup.plant.items():
        simulation.set_model(name, value)
    for effect in ("two_mass", "backlash"):
        for param in tables().effects[effect].params.values():
            simulation.set_effect(effect, param.name, param.example)

    with pytest.raises(RefusedValueError, match=r"effects\.backlash and effects\.two_mass are both on"):
        simulation.start()


def test_an_effect_parameter_is_found_under_its_own_effect(scenario):
    """cogging and misalignment both have amplitude_nm: only the refused one is blamed."""
    from evenspin.model import load_scenario

    both = "\n[effects.misalignment]\namplitude_nm = 0.01\n[effects.cogging]\namplitude_nm = 0.01\n"
    text = scenario.read_text() + both
    scenario.write_text(text)
    loaded = load_scenario(scenario)
    line = text.splitlines().index("[effects.cogging]") + 2
    wrong = replace(loaded.setup, effects={"cogging": {"amplitude_nm": 1e9}})

    with pytest.raises(NativeError) as refusal:
        simulate(wrong, ("t_s",))

    assert str(loaded.locate(refusal.value)).startswith(f"{scenario}:{line}: effects.cogging.amplitude_nm")


@pytest.mark.parametrize("go_on", [lambda s: s.run(10), lambda s: s.skip(10)])
def test_a_simulation_that_was_not_started_says_so_instead_of_giving_no_rows(go_on):
    with pytest.raises(NativeError, match="start it first"):
        go_on(Simulation())


@pytest.mark.parametrize(("error", "text", "bare"), [
    (InputError("bench", "--port", "x", "a device", "try y"), "bench: --port = 'x': must be", "--port = 'x': must be"),
    (InputError(Path("a.toml"), "k", 1, "0", "try 0", 3), "a.toml:3: k = 1: must be 0", "a.toml:3: k = 1: must be 0"),
    (RefusedError("the drive refuses that", "set"), "set: the drive refuses that", "the drive refuses that"),
    (NoDeviceError("none: there", "--port"), "--port: none: there", "none: there"),
    (RefusedError("start: arm first"), "start: arm first", "start: arm first"),
    (NativeError("a: b"), "a: b", "a: b"),
])  # fmt: skip
def test_a_page_leaves_out_the_command_or_option_in_front_and_nothing_else(error, text, bare):
    assert str(error).startswith(text)
    assert error.bare.startswith(bare)


# ---- blocks by name --------------------------------------------------------------------------------------------------


def test_any_block_can_be_called_by_its_name():
    pi = blocks.Block("pi", kp=0.5, ki_ts=0.25, out_min=-10.0, out_max=10.0)

    assert pi.do("output", 2.0) == (1.0,)
    pi.do("commit", 1.0)
    assert pi.do("output", 2.0) == (1.5,)  # k_p e + the integrator k_i T_s e of the sample before


@pytest.mark.parametrize(("call", "said"), [
    (lambda: blocks.Block("pid"), r"block = 'pid': no such block; did you mean pi"),
    (lambda: blocks.Block("pi", kq=1.0), r"kq = 1.0: no such parameter of this block"),
    (lambda: blocks.Block("pi", kp=-1.0), r"kp = -1.0: must be at least 0$"),
    (lambda: blocks.Block("pi", anti_windup="never"), r"anti_windup = 'never': must be hold or hold-outward"),
    (lambda: blocks.Block("pi", kp="much"), r"kp = 'much': must be a number"),
    (lambda: blocks.Block("pi").do("step", 1.0), r"action = 'step': must be one of the block; .*output"),
    (lambda: blocks.Block("pi").do("output"), r"output = 0: must have 1 inputs: error"),
])  # fmt: skip
def test_a_block_by_its_name_refuses_what_its_list_does_not_have(call, said):
    with pytest.raises(blocks.BlockError, match=said):
        call()


# Which list the parameters of a class come from; those that are given in pairs.
CLASSES = {
    blocks.RepetitiveController: ("rc", {"q": ("q_side", "q_centre")}),
    blocks.Pi: ("pi", {}),
    blocks.Pll: ("pll", {}),
    blocks.MtSpeed: ("mt", {}),
    blocks.AngleMemory: ("angle_memory", {}),
    blocks.Fir: ("fir", {}),
    blocks.TorqueObserver: ("observer", {"fir1": ("fir1_order", "fir1_hz"), "fir2": ("fir2_order", "fir2_hz")}),
    blocks.Deadbeat: ("deadbeat", {}),
    blocks.MotionProfile: ("profile", {}),
}


@pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.__name__)
def test_a_class_has_the_defaults_of_the_list(kind):
    name, pairs = CLASSES[kind]
    params = tables().blocks[name].params
    own = {"fal", "fal_at", "numeric"}  # fal = None switches fal_at off
    for given in inspect.signature(kind).parameters.values():
        if given.default is inspect.Parameter.empty or given.name in own:
            continue
        names = pairs.get(given.name, (given.name,))
        values = given.default if given.name in pairs else (given.default,)
        expected = [params[each].choices[int(params[each].default)] if params[each].choices else params[each].default
                    for each in names]  # fmt: skip
        assert list(values) == expected, given.name
