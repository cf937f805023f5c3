"""evenspin as a library: by name, with words, as arrays and frames; what cannot be is one line."""

import json
import re
import subprocess
import sys
from pathlib import Path

import evenspin as es
import numpy as np
import pytest
from evenspin.api.reference import EXAMPLE

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def short():
    return es.load("guo2024/first").change({"event.2.at_s": 0.25, "event.2.load_brake_a": 1.5}, log_rate_hz=1000.0)


@pytest.fixture(scope="module")
def own():
    events = [{"at_s": 0.0, "speed_rpm": 300.0, "load_brake_a": 1.0}]
    return es.load({"name": "own", "model": "guo2024", "duration_s": 0.5, "event": events})


def test_import_is_light():
    heavy = "('numpy', 'matplotlib', 'cffi', 'pydantic')"
    code = f"import sys, evenspin; print([name for name in sys.modules if name in {heavy}])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert said.stdout.strip() == "[]"


def test_the_package_says_that_it_is_typed():
    assert (Path(es.__file__).parent / "py.typed").is_file()


def test_every_name_on_offer_is_there_and_has_a_docstring():
    for name in es.__all__:
        assert getattr(es, name).__doc__, name


def test_a_run_is_the_one_that_the_command_makes(evenspin, scenario, tmp_path):
    run = es.load(scenario).change(method="fal-forc", seed=7).simulate()
    evenspin("run", scenario, "--method", "fal-forc", "--seed", 7, "--out", tmp_path / "out")

    log = np.loadtxt(tmp_path / "out" / "short.csv", delimiter=",", skiprows=1)
    names = (tmp_path / "out" / "short.csv").read_text().split("\n", 1)[0].split(",")
    assert log[:, names.index("speed_rad_s")] == pytest.approx(run["speed_rad_s"], rel=1e-8)
    assert json.loads((tmp_path / "out" / "summary.json").read_text()) == run.summary()


def test_arrays_have_the_shapes_that_are_promised(own):
    run = own.simulate()

    assert run["iq_a"].shape == run.t_s.shape == (len(run),) == (1000,)
    assert run.values.shape == (1000, len(run.names))
    assert (run.units["iq_a"], run.units["speed_rad_s"], run.names[0]) == ("A", "rad/s", "t_s")
    assert "iq_a" in run and list(run) == list(run.names)


def test_signals_can_be_chosen_and_time_is_always_there(own):
    assert own.simulate(["speed_rad_s"]).names == ("t_s", "speed_rad_s")


def test_a_change_is_as_if_it_stood_in_the_files(tmp_path, scenario_text):
    text = scenario_text.replace('"forc"', '"aro"').replace("seed = 3", "seed = 5")
    text += "[effects.cogging]\namplitude_nm = 0.02\norder = 12\n"
    (tmp_path / "a.toml").write_text(scenario_text)
    (tmp_path / "b.toml").write_text(text)

    changed = es.load(tmp_path / "a.toml").change(method="aro", seed=5, cogging={"amplitude_nm": 0.02, "order": 12})

    assert np.array_equal(changed.simulate().values, es.load(tmp_path / "b.toml").simulate().values)


def test_the_drive_follows_a_change_of_the_machine_unless_it_states_its_own(own):
    follows = own.change(inertia_kgm2=2e-4)
    states = own.change(inertia_kgm2=2e-4, rdc_inertia_kgm2=1e-4)

    assert follows.plant["inertia_kgm2"] == follows.drive["rdc_inertia_kgm2"] == 2e-4
    assert states.drive["rdc_inertia_kgm2"] == 1e-4


def test_a_load_in_amperes_follows_a_change_of_the_torque_constant(own):
    torque = {psi: own.change(psi_wb=psi).simulate(["load_torque_nm"])["load_torque_nm"].max() for psi in (6e-3, 12e-3)}

    assert torque[12e-3] == pytest.approx(2.0 * torque[6e-3])


def test_an_event_is_changed_by_its_key_or_by_its_number(short):
    assert short.checked.setup.inputs["load_brake_nm"].t_s[1] == 0.25
    assert es.load("guo2024/third").change(duration_s=7.5).duration_s == 7.5


def test_a_scenario_never_changes_itself(own):
    before = own.drive["method"]

    own.change(method="crc")

    assert own.drive["method"] == before


def test_numpy_numbers_will_do(own):
    changed = own.change(rc_gain=np.float32(0.5), seed=np.int64(4))

    assert changed.drive["rc_gain"] == pytest.approx(0.5)


@pytest.mark.parametrize(("changes", "said"), [
    ({"methd": 1}, "did you mean method?"),
    ({"method": "fal-frc"}, "did you mean fal-forc"),
    ({"method": "fal-forc+dbo"}, "fal-forc+dob"),
    ({"rc_gain": 1e9}, "a number in 0 .. 10"),
    ({"rc_gain": float("nan")}, "a number in 0 .. 10"),
    ({"rc_gain": "much"}, "a number in 0 .. 10"),
    ({"rc_gain": [1]}, "a number in 0 .. 10"),
    ({"speed_inline": 3}, "true or false"),
    ({"pole_pairs": 3}, "drive.pole_pairs or plant.pole_pairs"),
    ({"plant.counts_per_rev": 1000.5}, "a whole number"),
    ({"cogging.amplitude": 1}, "amplitude_nm"),
    ({"coging.amplitude_nm": 1}, "cogging"),
    ({"duration_s": -1.0}, "a time in"),
    ({"event.3.speed_rpm": 1.0}, "event.1"),
    ({"speed_rpm": 1e9}, "a number in"),
    ({3: 3}, "a parameter of the drive"),
])  # fmt: skip
def test_a_wrong_change_is_one_line_with_the_next_step(own, changes, said):
    with pytest.raises(es.EvenspinError) as error:
        own.change(changes)

    assert said in str(error.value)
    assert "\n" not in str(error.value) and ".toml" not in str(error.value)


def test_a_key_that_several_events_have_is_asked_for():
    with pytest.raises(es.EvenspinError, match=r"event\.1\.speed_rpm, event\.3\.speed_rpm"):
        es.load("guo2024/first").change(speed_rpm=100.0)


@pytest.mark.parametrize(("wrong", "said"), [
    (lambda: es.load("guo2024/frist"), "did you mean guo2024/first"),
    (lambda: es.load("nowhere.toml"), "an existing file"),
    (lambda: es.load(3), "a name, a file or a mapping"),
    (lambda: es.load({"model": "guo2024", "durtion_s": 3}), "did you mean duration_s"),
    (lambda: es.load({"model": {"plant": {"psi": 3}}, "duration_s": 3}), "did you mean psi_wb"),
    (lambda: es.load({"model": {"plant": {"psi_wb": 0.1}}, "duration_s": 3}), "are missing"),
    (lambda: es.load("guo2024/first").simulate(["speed"]), "did you mean speed_rad_s"),
    (lambda: es.load("guo2024/first").simulate("iq_a"), '["iq_a"]'),
    (lambda: es.load("guo2024/first").simulate(numeric="double"), "float or fixed"),
    (lambda: es.load("guo2024/first").tune("soft"), "stiff"),
    (lambda: es.find_gap("nowhere"), "an existing folder or file"),
    (lambda: es.find_gap(ROOT / "tests/data/foreign_drive/example_clean", model="guo2024"), "its meta.json says it"),
    (lambda: es.name_plate(kvv=3), "did you mean kv"),
    (lambda: es.name_plate(kv="270"), "a number"),
    (lambda: es.name_plate(kv=270), "name plate"),
])  # fmt: skip
def test_what_cannot_be_is_an_error_of_evenspin(wrong, said):
    with pytest.raises(es.EvenspinError) as error:
        wrong()

    assert said in str(error.value) and "\n" not in str(error.value)


def test_a_missing_name_of_the_package_is_suggested():
    with pytest.raises(AttributeError, match="did you mean load"):
        es.laod  # noqa: B018


def test_a_signal_that_was_not_recorded_is_suggested(own):
    with pytest.raises(es.EvenspinError, match="did you mean speed_rad_s"):
        own.simulate(["speed_rad_s"])["speed"]


@pytest.mark.parametrize("what", ["summary", "outcome"])
def test_what_needs_every_signal_says_so(own, what):
    run = own.simulate(["iq_a"])
    with pytest.raises(es.EvenspinError, match="without a list of signals"):
        run.summary() if what == "summary" else run.outcome


def test_a_drive_that_does_not_run_warns(own):
    with pytest.warns(UserWarning, match="never ran"):
        run = own.change(auto_run=False).simulate()

    assert (run.outcome.word, run.outcome.good) == ("stayed", False)


def test_a_run_becomes_a_pandas_frame(own):
    pandas = pytest.importorskip("pandas")
    run = own.simulate(["iq_a", "speed_rad_s"])

    frame = run.to_pandas()

    assert isinstance(frame, pandas.DataFrame)
    assert list(frame.columns) == ["iq_a", "speed_rad_s"] and frame.index.name == "t_s"
    assert np.array_equal(frame["iq_a"], run["iq_a"]) and frame.attrs["units"]["iq_a"] == "A"


@pytest.mark.parametrize("package", ["polars", "xarray"])
def test_a_frame_needs_its_package_and_says_which(own, monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)  # as if it were not installed
    with pytest.raises(es.EvenspinError, match=f"pip install {package}"):
        getattr(own.simulate(["iq_a"]), f"to_{package}")()


def test_orders_are_those_of_the_machine_that_has_them():
    """A torque T cos(12 theta) on the inertia J at the speed w gives a ripple T / (12 w J): the loop is slow there."""
    torque_nm, speed = 0.01, 2.0 * np.pi * 20.0
    events = [{"at_s": 0.0, "speed_rad_s": speed}]
    scenario = es.load({"name": "o", "model": "guo2024", "duration_s": 2.0, "event": events})
    rough = scenario.change({"cogging.amplitude_nm": torque_nm, "cogging.order": 12})
    gained = (
        rough.simulate().between(1.0, 2.0).orders(orders=(12,))[0]
        - scenario.simulate().between(1.0, 2.0).orders(orders=(12,))[0]
    )

    assert gained == pytest.approx(torque_nm / (12.0 * speed * scenario.plant["inertia_kgm2"]), rel=0.1)


@pytest.mark.parametrize("orders", [(), (0,), (1.5,)])
def test_an_order_is_a_whole_number(own, orders):
    with pytest.raises(es.EvenspinError, match="whole numbers from 1"):
        own.simulate().orders(orders=orders)


def test_a_plot_has_a_panel_per_signal_with_its_unit(own):
    figure = own.simulate().plot("iq_a", "speed_rad_s")

    assert [panel.get_ylabel() for panel in figure.axes] == ["iq_a [A]", "speed_rad_s [rad/s]"]


def test_what_is_saved_is_a_run_folder_that_is_not_overwritten(own, tmp_path):
    run = own.simulate()

    run.save(tmp_path / "out")
    run.save(tmp_path / "out")  # untouched since: replaced

    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"own.csv", "truth.csv", "report.html"}
    (tmp_path / "out" / "own.csv").write_text("mine")
    with pytest.raises(es.EvenspinError, match="was changed since"):
        run.save(tmp_path / "out")


def test_the_lists_have_what_the_tables_have():
    assert "guo2024/first" in es.list_scenarios() and "servo" in es.list_models()
    assert es.list_parameters()["rc_gain"].maximum == 10.0
    assert es.list_effects()["cogging"].params["amplitude_nm"].unit == "N m"
    assert es.list_signals()["iq_a"].unit == "A"


def test_a_name_plate_becomes_a_drive_that_runs():
    """Ke of a motor of 270 r/min per V: psi = 60 / (2 pi sqrt(3) p Kv)."""
    motor = es.name_plate(pole_pairs=7, kv=270, ohm_ll=0.11, mh_ll=0.06, lines=2048, supply=24, rated_current=12)
    events = [{"at_s": 0.0, "speed_rpm": 600.0}]
    run = es.load({"model": motor, "duration_s": 1.0, "event": events}).simulate()

    assert motor["plant"]["psi_wb"] == pytest.approx(60.0 / (2.0 * np.pi * np.sqrt(3.0) * 7 * 270), rel=1e-4)
    assert run.outcome.good
    assert run["true_speed_rad_s"][-1] == pytest.approx(600.0 * np.pi / 30.0, rel=0.01)


@pytest.mark.parametrize("name", ["papers", "hidden_effect", "own_motor"])
def test_an_example_runs_and_finds_what_it_is_about(name):
    """Each in this process, so that nothing is imported again."""
    found: dict = {}
    exec(compile((ROOT / "examples" / f"{name}.py").read_text(), name, "exec"), found)

    if name == "papers":
        assert found["ripple"]["forc"][0] < 0.05 * found["ripple"]["pi"][0]
        assert found["overshoot_rpm"]["fal-forc"] < 0.5 * found["overshoot_rpm"]["forc"]
        assert found["rms_rpm"]["aro"] < 0.2 * found["rms_rpm"]["pi"]
    elif name == "hidden_effect":
        hidden = found["hidden"]["cogging.amplitude_nm"]
        assert found["gap"].names == ("cogging",)
        assert found["gap"].parameters["cogging"]["amplitude_nm"] == pytest.approx(hidden, rel=0.05)
        assert found["gap"].parameters["cogging"]["order"] == 12
        machine = found["ripple_rad_s"]["machine"]
        assert found["ripple_rad_s"]["model with what was found"] == pytest.approx(machine, rel=0.05)
    else:
        assert found["tuning"].good
        assert list(found["frame"].columns) == ["speed_rad_s", "iq_a"]


def test_the_example_of_the_manual_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    found: dict = {}

    exec(compile(EXAMPLE, "docs/api.md", "exec"), found)

    assert (tmp_path / "run.svg").is_file() and "cogging" in found["gap"].names


def test_the_python_of_the_readme_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for code in re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL):
        exec(compile(code, "README.md", "exec"), {})
