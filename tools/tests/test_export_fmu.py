"""The FMU, run by FMPy: valid by the schema of FMI 3.0, the drive as our own run, the machine as its equations."""

import zipfile
from contextlib import contextmanager

import evenspin as es
import numpy as np
import pytest
from evenspin.export import fmu_bytes

fmpy = pytest.importorskip("fmpy")
from fmpy.fmi3 import FMU3Slave  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

CLOSE = 1e-6
STEP_S = 1e-3
PERIOD_S = 1e-4  # of the PWM


@pytest.fixture(scope="module")
def scenario():
    events = [
        {"at_s": 0.0, "speed_rpm": 300.0, "load_brake_a": 1.0},
        {"at_s": 0.1, "speed_rpm": 450.0},
        {"at_s": 0.2, "load_brake_a": 2.0, "drive": {"rc_gain": 0.3}},
    ]
    setup = {"name": "e", "model": "guo2024-board", "duration_s": 0.3, "seed": 7, "log_rate_hz": 1e4, "event": events}
    return es.load(setup).change(method="forc", cogging={"amplitude_nm": 0.01, "order": 12})


@pytest.fixture(scope="module")
def own(scenario):
    return scenario.simulate()


@pytest.fixture(scope="module")
def files(scenario, tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmu")
    for kind in ("drive", "plant"):
        (folder / f"{kind}.fmu").write_bytes(fmu_bytes(scenario.checked.setup, kind, "a test"))
    return {kind: folder / f"{kind}.fmu" for kind in ("drive", "plant")}


class Unit:
    """An instance, its variables by name."""

    def __init__(self, path):
        self.description = fmpy.read_model_description(str(path))
        self.references = {each.name: each.valueReference for each in self.description.modelVariables}
        self.said: list[str] = []
        self.slave = FMU3Slave(
            guid=self.description.guid, unzipDirectory=fmpy.extract(str(path)),
            modelIdentifier=self.description.coSimulation.modelIdentifier, instanceName="u",
        )  # fmt: skip
        self.slave.instantiate(logMessage=self._log)
        self.time_s = 0.0

    def _log(self, environment, status, category, message):
        self.said.append(message.decode() if isinstance(message, bytes) else str(message))

    def start(self, **values):
        self.set(**values)
        self.slave.enterInitializationMode(startTime=0.0)
        self.slave.exitInitializationMode()
        self.time_s = 0.0

    def set(self, values=None, **named):
        for name, value in {**(values or {}), **named}.items():
            self.slave.setFloat64([self.references[name]], [value])

    def get(self, *names):
        return self.slave.getFloat64([self.references[name] for name in names])

    def step(self, step_s=STEP_S):
        self.slave.doStep(self.time_s, step_s)
        self.time_s += step_s


@contextmanager
def running(path, **start):
    unit = Unit(path)
    try:
        unit.start(**start)
        yield unit
    finally:
        unit.slave.freeInstance()


@pytest.mark.parametrize("kind", ["drive", "plant"])
def test_the_description_is_what_the_standard_wants(files, kind):
    assert validate_fmu(str(files[kind])) == []


SIGNALS = ("speed_rad_s", "iq_a", "vq_v", "rc_out_unit", "true_speed_rad_s", "true_iq_a", "true_theta_m_rad", "state")


def test_the_drive_does_what_our_own_run_does_to_1e_6(files, scenario, own):
    """Inputs and a parameter change at the communication points at which the scenario changes them."""
    plan = {name: scenario.checked.setup.inputs[name] for name in ("speed_ref_rad_s", "load_brake_nm")}
    rows = []
    with running(files["drive"]) as unit:
        for number in range(300):
            for name, curve in plan.items():
                for at_s, value in zip(curve.t_s, curve.value, strict=True):
                    if abs(at_s - number * STEP_S) < 1e-9:
                        unit.set({name: value})
            if number == 200:
                unit.set({"drive.rc_gain": 0.3})
            unit.step()
            rows.append(unit.get(*(f"signals.{name}" for name in SIGNALS)))

    now = np.round(np.arange(1, 300) * STEP_S / PERIOD_S).astype(int)
    for name, column in zip(SIGNALS, np.array(rows[:-1]).T, strict=True):
        expected = own[name][now if name.startswith("true_") else now - 1]  # what the drive shows is a period old
        assert np.abs(column - expected).max() <= CLOSE * max(1.0, np.abs(expected).max()), name


def test_the_importers_own_loop_gives_the_same(files, scenario, own):
    """simulate_fmu of FMPy, which steps and feeds its inputs by itself."""
    speed = scenario.checked.setup.inputs["speed_ref_rad_s"]
    load = scenario.checked.setup.inputs["load_brake_nm"]
    times = np.array([0.0, 0.1, 0.2])
    fed = np.array(
        [(t, v, b) for t, v, b in zip(times, (speed.value[0], speed.value[1], speed.value[1]),
                                      (load.value[0], load.value[0], load.value[1]), strict=True)],
        dtype=[("time", float), ("speed_ref_rad_s", float), ("load_brake_nm", float)],
    )  # fmt: skip
    name = "signals.true_speed_rad_s"

    found = fmpy.simulate_fmu(
        str(files["drive"]), stop_time=0.19, step_size=STEP_S, output_interval=STEP_S, input=fed, output=[name]
    )

    expected = own["true_speed_rad_s"][np.round(found["time"][1:] / PERIOD_S).astype(int)]
    assert np.abs(found[name][1:] - expected).max() <= CLOSE * np.abs(expected).max()


def test_the_machine_alone_follows_its_differential_equations_to_1e_6(tmp_path):
    """The equations of sim_host/plant/plant.h, integrated by SciPy in the rotor frame with the phase voltages of the
    duties. The machine has a saliency, no effects, no noise and no friction that jumps."""
    from scipy.integrate import solve_ivp

    scenario = es.load({
        "name": "p", "duration_s": 1.0,
        "model": {"plant": {"pole_pairs": 4, "resistance_ohm": 0.36, "ld_h": 2e-4, "lq_h": 3e-4, "psi_wb": 6.4e-3,
                            "inertia_kgm2": 7e-5, "viscous_nms": 2e-4, "dc_link_v": 24.0, "counts_per_rev": 0,
                            "initial_speed_rad_s": 60.0, "initial_angle_rad": 0.3, "substeps": 20}},
    })  # fmt: skip
    path = tmp_path / "plant.fmu"
    path.write_bytes(fmu_bytes(scenario.checked.setup, "plant", "a test"))
    duty, load_nm, vdc, p = (0.56, 0.47, 0.52), 0.02, 24.0, scenario.plant

    def rates(t, x):
        i_d, i_q, w, theta = x
        phase = np.array(duty) * vdc
        alpha = (2.0 * phase[0] - phase[1] - phase[2]) / 3.0
        beta = (phase[1] - phase[2]) / np.sqrt(3.0)
        e, we = 4.0 * theta, 4.0 * w
        v_d, v_q = alpha * np.cos(e) + beta * np.sin(e), beta * np.cos(e) - alpha * np.sin(e)
        torque = 1.5 * 4.0 * (p["psi_wb"] * i_q + (p["ld_h"] - p["lq_h"]) * i_d * i_q)
        return [
            (v_d - p["resistance_ohm"] * i_d + we * p["lq_h"] * i_q) / p["ld_h"],
            (v_q - p["resistance_ohm"] * i_q - we * (p["ld_h"] * i_d + p["psi_wb"])) / p["lq_h"],
            (torque - p["viscous_nms"] * w - load_nm) / p["inertia_kgm2"],
            w,
        ]

    exact = solve_ivp(rates, (0.0, 0.02), [0.0, 0.0, 60.0, 0.3], rtol=1e-10, atol=1e-12, t_eval=[0.01, 0.02]).y
    found = []
    with running(path, duty_a=duty[0], duty_b=duty[1], duty_c=duty[2], load_torque_nm=load_nm) as unit:
        for number in range(20):
            unit.step()
            if number in (9, 19):
                names = ("true_id_a", "true_iq_a", "true_speed_rad_s", "true_theta_m_rad")
                found.append(unit.get(*(f"signals.{name}" for name in names)))

    assert np.array(found).T == pytest.approx(exact, rel=CLOSE, abs=CLOSE)


def test_the_size_of_the_steps_changes_nothing(files):
    ends = []
    for step_s, count in ((1e-4, 120), (4e-3, 3), (3e-4, 40)):
        with running(files["drive"]) as unit:
            for _ in range(count):
                unit.step(step_s)
            ends.append(unit.get("signals.true_speed_rad_s", "signals.iq_a", "time"))

    assert ends[0] == ends[1] == ends[2]


def test_a_step_that_is_no_whole_number_of_periods_is_caught_up(files):
    with running(files["drive"]) as unit:
        for _ in range(8):
            unit.step(0.37e-4)
        assert unit.get("time")[0] == pytest.approx(2e-4)  # 0.296 ms: two periods are over


def test_two_units_in_one_process_do_not_know_each_other(files):
    with running(files["drive"]) as alone:
        for _ in range(50):
            alone.step()
        expected = alone.get("signals.true_speed_rad_s", "signals.iq_a")
    with running(files["drive"]) as one, running(files["drive"], speed_ref_rad_s=-20.0) as other:
        for _ in range(50):
            one.step()
            other.step()
        assert one.get("signals.true_speed_rad_s", "signals.iq_a") == expected
        assert other.get("signals.true_speed_rad_s")[0] < 0.0


def test_a_reset_begins_again_with_the_first_values(files):
    with running(files["drive"]) as unit:
        for _ in range(30):
            unit.step()
        first = unit.get("signals.true_speed_rad_s", "signals.iq_a")
        unit.set(speed_ref_rad_s=5.0)
        unit.slave.reset()
        unit.start()
        for _ in range(30):
            unit.step()

        assert unit.get("signals.true_speed_rad_s", "signals.iq_a") == first


def test_several_parameters_changed_at_once_are_all_taken(files):
    with running(files["drive"]) as unit:
        unit.step()
        unit.set({"drive.rc_gain": 0.2, "drive.speed_kp_a_per_unit": 0.01, "drive.speed_ki_a_per_unit_s": 0.2})
        unit.step(0.1)

        assert unit.said == []
        assert unit.get("drive.rc_gain", "drive.speed_kp_a_per_unit") == [0.2, 0.01]


@pytest.mark.parametrize(("name", "value", "said"), [
    ("speed_ref_rad_s", float("nan"), "is not finite"), ("speed_ref_rad_s", 1e9, "must be within"),
    ("plant.inertia_kgm2", 1e-4, "is fixed"), ("effects.cogging.amplitude_nm", 0.1, "is fixed"),
    ("signals.iq_a", 1.0, "cannot be set"), ("time", 1.0, "cannot be set"),
])  # fmt: skip
def test_what_cannot_be_set_is_refused_and_the_unit_goes_on(files, name, value, said):
    with running(files["drive"]) as unit:
        unit.step()
        with pytest.raises(Exception, match="(?i)error|fail|status"):
            unit.set({name: value})
        assert any(said in each for each in unit.said)
        unit.step()


def test_a_parameter_out_of_range_is_refused_at_the_next_step(files):
    with running(files["drive"]) as unit:
        unit.set({"drive.rc_gain": 99.0})
        with pytest.raises(Exception, match="(?i)error|fail|status"):
            unit.step()
        assert any("rc_gain = 99: must be within 0 .. 10" in each for each in unit.said)


@pytest.mark.parametrize(("start", "said"), [
    ({"plant.psi_wb": -1.0}, "psi_wb = -1: must be within"), ({"drive.rc_gain": 99.0}, "rc_gain"),
    ({"drive.iq_limit_a": 1000.0}, "iq_limit_a"),
])  # fmt: skip
def test_start_values_that_do_not_fit_are_named(files, start, said):
    unit = Unit(files["drive"])
    unit.set(start)
    with pytest.raises(Exception, match="(?i)error|fail|status"):
        unit.start()
    unit.slave.freeInstance()

    assert any(said in each for each in unit.said)


def test_a_duty_beyond_the_rails_is_refused(files):
    with running(files["plant"], duty_a=1.2) as unit:
        with pytest.raises(Exception, match="(?i)error|fail|status"):
            unit.step()
        assert any("duty_a = 1.2" in each for each in unit.said)


def test_a_step_back_in_time_is_refused(files):
    with running(files["drive"]) as unit:
        unit.step()
        unit.time_s = 0.0
        with pytest.raises(Exception, match="(?i)error|fail|status"):
            unit.step(1e-4)


def test_an_fmu_without_its_setup_says_so(files, tmp_path):
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(files["drive"]) as whole, zipfile.ZipFile(broken, "w") as part:
        for name in whole.namelist():
            part.writestr(name, b"nonsense line here\n" if name.endswith("setup.txt") else whole.read(name))
    with pytest.raises(Exception, match="(?i)instantiate"):
        Unit(broken)


def test_the_same_scenario_gives_the_same_bytes(scenario, files):
    assert fmu_bytes(scenario.checked.setup, "drive", "a test") == files["drive"].read_bytes()


def test_the_command_writes_it_and_names_what_is_not_in_it(evenspin, tmp_path):
    said = evenspin("export", "fmu", "guo2024/first", "--set", "method=aro", "--out", tmp_path / "a.fmu")

    assert said.status == 0 and "7 times" in said.out
    with zipfile.ZipFile(tmp_path / "a.fmu") as archive:
        assert f"param method {float(6)!r}" in archive.read("resources/setup.txt").decode()
    assert validate_fmu(str(tmp_path / "a.fmu")) == []


@pytest.mark.parametrize(("words", "said"), [
    (("guo2024/frist", "--out", "a.fmu"), "did you mean guo2024/first"),
    (("guo2024/first", "--out", "a.zip"), "a file .fmu"),
    (("guo2024/first", "--set", "rcgain=1", "--out", "a.fmu"), "did you mean rc_gain"),
    (("guo2024/first", "--out", "/nowhere/a.fmu"), "existing folder"),
])  # fmt: skip
def test_a_wrong_word_is_one_line(evenspin, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    answer = evenspin("export", "fmu", *words)

    assert answer.status == 2 and said in answer.err and answer.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
