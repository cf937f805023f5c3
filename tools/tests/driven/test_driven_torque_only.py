"""Logs without voltages, with a model: the torque equation names what it can, with the tolerances of the other logs."""

import numpy as np
import pytest
from driven_logs import columns_of, hide, write_log
from evenspin.balance.verdict import OR
from evenspin.driven import run_driven, serves

TORQUE_ONLY = ("t_s", "theta_m_rad", "id_a", "iq_a", "load_torque_nm")
WITHOUT_LOAD = TORQUE_ONLY[:-1]
PLANT = "pole_pairs = 3\npsi_wb = 0.1\ninertia_kgm2 = 8e-4\nviscous_nms = 4e-4\n"


def verdict_of(path, columns, names=TORQUE_ONLY):
    log = write_log(path, {name: columns[name] for name in names})
    return run_driven([log], "servo", "bench", None).verdict


# Sizes about twice what a bench leaves open; tolerances as for logs with voltages.
@pytest.mark.usefixtures("by_the_table")
@pytest.mark.parametrize(
    ("effect", "params", "key"),
    [
        ("coulomb_friction", {"torque_nm": 0.06}, "torque_nm"),
        ("cogging", {"amplitude_nm": 0.06, "phase_rad": 1.0, "order": 18.0}, "amplitude_nm"),
        ("encoder_eccentricity", {"amplitude_rad": 0.01, "phase_rad": 0.7}, "amplitude_rad"),
    ],
)
def test_a_torque_effect_is_named_with_its_size_where_no_voltage_was_recorded(effect, params, key, tmp_path):
    verdict = verdict_of(tmp_path / "log.csv", hide(**{effect: params}))
    assert verdict["verdict"] == [effect]
    assert verdict["parameters"][effect][key] == pytest.approx(params[key], rel=0.05)


@pytest.mark.parametrize(
    ("effect", "params"), [("winding_resistance", {"factor": 1.6}), ("dead_time", {"dead_time_s": 1.5e-6})]
)
def test_what_only_voltages_show_leaves_no_other_name(effect, params, tmp_path):
    assert verdict_of(tmp_path / "log.csv", hide(**{effect: params}))["verdict"] == []


def test_a_healthy_machine_without_a_measured_load_has_no_name(tmp_path):
    columns = columns_of(speeds=(4.0, 30.0, 70.0, -6.0, -50.0, 12.0))
    still = {**columns, "iq_a": columns["iq_a"] - columns["load_torque_nm"] / (1.5 * 3 * 0.1)}
    assert verdict_of(tmp_path / "log.csv", still, WITHOUT_LOAD)["verdict"] == []


@pytest.mark.usefixtures("by_the_table")
@pytest.mark.parametrize("effect", ["encoder_offset", "torque_constant", "inertia"])
def test_less_torque_per_ampere_and_more_inertia_are_one_name_without_voltages_and_load(effect, tmp_path):
    params = {"encoder_offset": {"angle_el_rad": 0.55}, "torque_constant": {"factor": 0.85}, "inertia": {"factor": 1.2}}
    columns = hide(**{effect: params[effect]})
    scale = {"encoder_offset": np.cos(0.55), "torque_constant": 0.85, "inertia": 1.0}[effect]
    free = {**columns, "iq_a": columns["iq_a"] - columns["load_torque_nm"] / (1.5 * 3 * 0.1 * scale)}
    verdict = verdict_of(tmp_path / "log.csv", free, WITHOUT_LOAD)
    assert verdict["verdict"] == ["inertia or torque_constant or encoder_offset"]
    assert set(verdict["cannot_separate"]["inertia"]) == {"torque_constant", "encoder_offset"}
    assert any("measured load" in text for text in verdict["warnings"])


@pytest.mark.usefixtures("by_the_table")
def test_a_measured_load_separates_the_torque_constant_from_the_inertia(tmp_path):
    verdict = verdict_of(tmp_path / "log.csv", hide(torque_constant={"factor": 1.15}))
    assert verdict["verdict"] == ["torque_constant"]
    assert verdict["parameters"]["torque_constant"]["factor"] == pytest.approx(1.15, abs=0.02)


@pytest.mark.usefixtures("by_the_table")
def test_a_measured_load_that_never_moves_fixes_no_torque_per_ampere(tmp_path):
    """A column of noise: flux, inertia and friction could all be a third larger, and explain the log as well."""
    columns = hide(viscous_friction={"factor": 4.0})
    free = {**columns, "iq_a": columns["iq_a"] - columns["load_torque_nm"] / (1.5 * 3 * 0.1)}
    free["load_torque_nm"] = 0.01 * np.random.default_rng(3).standard_normal(len(free["t_s"]))
    verdict = verdict_of(tmp_path / "log.csv", free)
    assert verdict["verdict"] == ["viscous_friction"]
    assert verdict["can_be_found"]["torque_constant"]["times_least_size"] is None  # no candidate
    assert verdict["parameters"]["viscous_friction"]["factor"] == pytest.approx(4.0, rel=0.05)


@pytest.mark.usefixtures("by_the_table")
def test_an_offset_of_a_current_sensor_may_be_torque_of_the_shaft_without_voltages(tmp_path):
    verdict = verdict_of(tmp_path / "log.csv", hide(current_offset={"offset_a_a": 0.2, "offset_b_a": -0.1}))
    assert verdict["verdict"] == ["cogging or current_offset"]


@pytest.mark.usefixtures("by_the_table")
def test_in_one_direction_friction_and_load_are_one_name(tmp_path):
    columns = columns_of((("coulomb_friction", (("torque_nm", 0.1),)),), 1, (4.0, 30.0, 70.0, 12.0, 50.0, 20.0))
    moving = {name: values[200:] for name, values in columns.items()}
    assert verdict_of(tmp_path / "log.csv", moving)["verdict"] == [OR.join(("coulomb_friction", "load_torque"))]


def test_the_torque_equation_serves_where_the_model_states_what_it_is_made_of(tmp_path):
    log = write_log(tmp_path / "log.csv", {name: hide()[name] for name in TORQUE_ONLY})
    model = tmp_path / "model.toml"
    model.write_text(f'name = "m"\n[plant]\n{PLANT}')
    assert serves([log], model)
    model.write_text('name = "m"\n[plant]\n' + PLANT.replace("inertia_kgm2 = 8e-4\n", ""))
    assert not serves([log], model)
    amperes = PLANT.replace("psi_wb = 0.1", f"psi_wb = {1.0 / 4.5!r}")
    model.write_text(f'name = "m"\n[plant]\n{amperes}')
    assert not serves([log], model)  # what a torque balance without a model writes
