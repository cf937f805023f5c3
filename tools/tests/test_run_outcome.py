"""Whether a run ran: stayed, tripped, oscillates, and ripple that is none of these."""

import json

import pytest
from evenspin.model import builtin_scenario, load_scenario
from evenspin.run import summary_of
from evenspin.run.outcome import OWN_PART, outcome_of, own_current
from evenspin.sim import simulate

MODEL = """\
name = "own"
[plant]
pole_pairs = 4
resistance_ohm = 0.36
ld_h = 0.2e-3
lq_h = 0.2e-3
psi_wb = 6.4e-3
inertia_kgm2 = 7.06e-5
viscous_nms = 2e-5
dc_link_v = 24.0
counts_per_rev = 4000
"""
SCENARIO = """\
name = "own"
model = "own.toml"
duration_s = 1.0
[[event]]
at_s = 0.0
speed_rpm = 300.0
"""
QUICK = "offset_calibration_periods = 0\nalign_periods = 0\n"


def own_scenario(folder, drive="", effects="", scenario=SCENARIO):
    (folder / "own.toml").write_text(f"{MODEL}[drive]\n{drive}\n{effects}")
    path = folder / "s.toml"
    path.write_text(scenario)
    return path


def result(setup):
    return outcome_of(setup, simulate(setup))


def test_a_drive_that_nobody_starts_is_told(evenspin, tmp_path):
    path = own_scenario(tmp_path, f"{QUICK}auto_run = false\n")

    said = evenspin("run", path, "--out", tmp_path / "out")
    as_json = evenspin("run", path, "--out", tmp_path / "out", "--json")

    assert (said.status, as_json.status) == (1, 1)
    assert "stayed in READY" in said.out and "auto_run = true" in said.out
    assert json.loads(as_json.out)["outcome"]["result"] == "stayed"
    assert "stayed in READY" in (tmp_path / "out" / "report.html").read_text()


def test_a_trip_is_the_result_of_the_run(evenspin, tmp_path):
    path = own_scenario(tmp_path, f"{QUICK}auto_run = true\nover_speed_rad_s = 31.6\n")

    said = evenspin("run", path, "--out", tmp_path / "out", "--json")

    outcome = json.loads(said.out)["outcome"]
    assert said.status == 1 and outcome["result"] == "tripped"
    assert 0.0 < outcome["t_s"] < 1.0 and "over_speed" in outcome["text"]


def test_a_run_that_ran_says_nothing(evenspin, tmp_path):
    path = own_scenario(tmp_path, f"{QUICK}auto_run = true\n")

    said = evenspin("run", path, "--out", tmp_path / "out", "--json")

    assert said.status == 0
    assert json.loads(said.out)["outcome"] == {"result": "ran", "text": "", "t_s": None}


# gains of the drive of the paper at 255 r/min; `evenspin design rc` calls the same ones unstable
UNSTABLE = {
    "speed loop, from limit to limit": {"method": "pi", "speed_kp_a_per_unit": 1.0},
    "speed loop, far beyond": {"method": "pi", "speed_kp_a_per_unit": 1000.0},
    "integral gain": {"method": "pi", "speed_ki_a_per_unit_s": 500.0},
    "current loop": {"method": "pi", "current_kp_v_per_a": 3.0},
    "learning gain, just": {"method": "forc", "rc_gain": 1.65},
    "learning gain": {"method": "forc", "rc_gain": 1.8},
}


@pytest.mark.parametrize("name", UNSTABLE)
def test_an_unstable_loop_oscillates(name):
    outcome = result(builtin_scenario("guo2024/stability").with_changes(UNSTABLE[name]))

    assert outcome.word == "oscillates"
    assert "The drive oscillates: from 2.1 to 4 s" in outcome.text and "design rc" in outcome.text


def test_a_drive_that_swings_on_the_spot_oscillates(tmp_path):
    """Too few turns to tell an order from a frequency; the reference goes from limit to limit."""
    slow = SCENARIO.replace("300.0", "1.0")
    setup = load_scenario(own_scenario(tmp_path, f"{QUICK}auto_run = true\nspeed_kp_a_per_unit = 5.0", "", slow)).setup
    record = simulate(setup)

    assert own_current(record.between(0.5, 1.0)) is None
    assert outcome_of(setup, record).word == "oscillates"


STABLE = {
    "PI with the sensor errors of the paper": ("guo2024/stability", {"method": "pi"}),
    "close to the limit of the speed loop": ("guo2024/stability", {"method": "pi", "speed_kp_a_per_unit": 0.45}),
    "close to the limit of learning": ("guo2024/stability", {"method": "forc", "rc_gain": 1.5}),
    "a speed that beats with the encoder": ("tang2020/rpm1003", {"method": "pi"}),
    "stick and slip": ("yeh2024/rpm20", {"position_method": "ppi"}),
}


@pytest.mark.parametrize("name", STABLE)
def test_ripple_is_no_oscillation(name):
    scenario, changes = STABLE[name]

    assert result(builtin_scenario(scenario).with_changes(changes)).good


@pytest.mark.parametrize(("order", "amplitude"), [(1, 0.15), (7, 0.1), (36, 0.1)])
def test_torque_tied_to_the_angle_is_no_oscillation(tmp_path, order, amplitude):
    """A cogging of up to half of the rated torque; the current follows as far as the speed loop sees it."""
    cogging = f"[effects.cogging]\namplitude_nm = {amplitude}\norder = {order}\n"
    longer = SCENARIO.replace("1.0", "2.0")
    setup = load_scenario(own_scenario(tmp_path, f"{QUICK}auto_run = true\n", cogging, longer)).setup
    record = simulate(setup)

    assert outcome_of(setup, record).good
    left = own_current(record.between(1.0, 2.0))  # five turns
    assert left is not None and left < 0.2 * OWN_PART * setup.drive["iq_limit_a"]


def test_a_turn_longer_than_the_memory_of_ro_is_told(scenario, scenario_text):
    reported = []
    for rpm in (90.0, 110.0):  # 6144 samples at 10 kHz are one turn at 97.66 r/min
        text = scenario_text.replace('"forc"', '"ro"').replace("speed_rpm = 300.0", f"speed_rpm = {rpm}")
        text = text.replace("duration_s = 0.5", "duration_s = 2.5")
        scenario.write_text(text)
        setup = load_scenario(scenario).setup
        record = simulate(setup)
        reported.append((summary_of(setup, record, "float")["notice"], abs(record["compensation_a"]).max() > 0.0))

    assert reported[0][0].startswith("ro is off: a turn at 90 r/min") and reported[1][0] == ""
    assert [learned for _, learned in reported] == [False, True]


def test_motor_data_in_use_come_with_their_origin(tmp_path):
    path = own_scenario(tmp_path, f"{QUICK}auto_run = true\nmethod = 'dob'\nobserver_viscous_nms = 1e-5\n")
    setup = load_scenario(path).setup

    data = summary_of(setup, simulate(setup), "float")["motor_data"]

    assert {name: each["from"] for name, each in data.items()} == {
        "motor_psi_wb": "[plant] psi_wb of the model",
        "observer_inertia_kgm2": "[plant] inertia_kgm2 of the model",
        "observer_viscous_nms": "[drive] of the model",
    }
