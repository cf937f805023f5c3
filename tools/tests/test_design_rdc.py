"""Robust driving control: P and eigenvalues against the paper's drive, chatter against the simulated drive."""

import json

import numpy as np
import pytest
from evenspin.design.rdc import RdcLoop, design
from evenspin.design.rdc_command import prepare
from evenspin.model import builtin_scenario
from evenspin.sim import simulate

PAPER = RdcLoop(10.0, 1.5, 0.05, 0.868, 0.780e-2, 0.339e-1)


def test_eigenvalues_and_p_row_are_those_of_the_paper():
    found = design(PAPER, 0.15, 0.02)

    assert [value.real for value in found.eigenvalues] == pytest.approx([-9.7, -25.2, -136.3], abs=0.05)
    assert found.p_row == pytest.approx([1.4977e-5, 2.03552e-2, 3.03823e-3], rel=1e-5)


def test_p_solves_the_lyapunov_equation_and_is_positive():
    found = design(PAPER, 0.05, 0.02, q=3.0)
    a = PAPER.matrix()

    assert a.T @ found.p + found.p @ a == pytest.approx(-3.0 * np.eye(3), abs=1e-9)
    assert np.linalg.eigvalsh(found.p).min() > 0.0
    assert found.limit == pytest.approx(design(PAPER, 0.15, 0.02).limit / 3.0, rel=1e-6)


def torque_step_nm(ratio, delay):
    """Step of the torque command from row to row at constant speed, on the simulated drive."""
    changes = {"rdc_rho_nm": 0.02 * ratio, "torque_delay_samples": float(delay), "profile_accel_rad_s2": 20.0}
    record = simulate(builtin_scenario("yeh2024/rpm20").with_changes(changes), ("t_s", "iq_ref_a"))
    return 0.868 * np.diff(record.between(20.0, 29.0)["iq_ref_a"]).std()


@pytest.mark.parametrize("delay", [0, 1])
def test_the_limit_is_where_the_simulated_drive_begins_to_chatter(delay):
    from dataclasses import replace

    limit = design(replace(PAPER, delay_samples=delay), 0.1, 0.02).limit

    assert torque_step_nm(0.9 * limit, delay) < 0.03
    assert torque_step_nm(1.1 * limit, delay) > 0.1


def test_a_delay_lowers_the_limit():
    limits = [
        design(RdcLoop(10.0, 1.5, 0.05, 0.868, 0.780e-2, 0.339e-1, delay_samples=d), 0.0, 0.02).limit for d in (0, 1, 2)
    ]

    assert limits == pytest.approx([22.4, 10.2, 5.9], abs=0.1)


@pytest.mark.parametrize(("words", "start"), [
    (("--rho", "0.5"), "design rdc: rho_nm / sigma = '25': must be at most 22.4"),
    (("--q", "10"), "design rdc: rho_nm / sigma = '7.5': must be at most 2.24"),
    (("--inertia-kgm2", "-0.01"), "design rdc: inertia_kgm2 = -0.01: must be above 0"),
    (("--sigma", "0"), "design rdc: sigma = 0.0: must be above 0"),
    (("--rho", "-1"), "design rdc: rho_nm = -1.0: must be at least 0"),
    (("--viscous-nms", "nan"), "design rdc: viscous_nms = nan: must be at least 0"),
    (("--kpp", "500", "--ti", "0.001"), "design rdc: largest real part of A"),
    (("--model", "yeh2042"), "--model: model = 'yeh2042'"),
])  # fmt: skip
def test_a_design_that_cannot_be_is_one_line(evenspin, words, start):
    said = evenspin("design", "rdc", *words)

    assert (said.status, said.out) == (2, "")
    assert said.err.startswith(start) and said.err.count("\n") == 1, said.err


def test_a_ratio_that_only_the_delay_makes_chatter_is_warned_of(evenspin):
    said, calm = evenspin("design", "rdc", "--rho", "0.3"), evenspin("design", "rdc")

    assert said.status == calm.status == 0
    assert "chatters: above 10.2" in said.out
    assert "chatters: above" not in calm.out and "close to" not in calm.out


def test_the_command_prints_lines_for_the_drive(evenspin):
    said = evenspin("design", "rdc", "--json")

    content = json.loads(said.out)
    assert content["stable"]
    assert content["drive"]["rdc_p32"] == pytest.approx(2.03552e-2, rel=1e-5)
    assert "rdc_p33 = 0.00303823" in said.err


def test_error_bound_of_theorem_1_is_that_of_the_paper():
    """sqrt(rho sigma / (2 lambda_min(Q))), equation 40; Q = q I."""
    found = prepare("yeh2024", {"rho_nm": 0.15, "sigma": 0.02, "q": 1.0})

    assert found.error_bound == pytest.approx(0.0387, rel=1e-3)
    assert prepare("yeh2024", {"rho_nm": 0.15, "sigma": 0.08, "q": 4.0}).error_bound == pytest.approx(0.0387, rel=1e-3)
