"""A single log whose columns cannot be what their names say, and those that cannot be separated."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import balance_recordings as recordings
import numpy as np
import pytest
from evenspin.balance.log_reader import Log, read_log
from evenspin.balance.plausibility import check_against
from evenspin.errors import EvenspinError

INERTIA_AS2 = 1.9e-4  # of the free run of the real motor, by energy
MODEL = SimpleNamespace(inertia_as2=INERTIA_AS2, viscous_as=0.0, kt_nm_per_a=1.0, pole_pairs=12, windings=lambda: None)
FREE, SLOW, ROLLING = "acc_current.csv.gz", "speed_test.csv.gz", "rolling_1.csv.gz"
COLUMNS = ("t_s", "theta_m_rad", "speed_rad_s", "iq_a")


def changed(folder: Path, name: str, **changes: Any) -> Path:
    """A real log; a change is a factor, a function, or None for a column that is not there."""
    columns = {key: value for key, value in recordings.read(recordings.REAL / name).items() if key in COLUMNS}
    for key, change in changes.items():
        if change is None:
            del columns[key]
        else:
            columns[key] = change(columns[key]) if callable(change) else change * columns[key]
    path = folder / "log.csv"
    np.savetxt(path, np.column_stack(list(columns.values())), "%.9g", ",", header=",".join(columns), comments="")
    return path


def held_against_the_model(path: Path) -> Log:
    log = read_log(path)
    names = ("t_s", "iq_a", "theta_m_rad", "speed_rad_s")
    check_against(path, {name: getattr(log, name) for name in names}, MODEL)
    return log


@pytest.mark.parametrize("missing", ["", "theta_m_rad", "speed_rad_s"])
@pytest.mark.parametrize("name", [FREE, SLOW, ROLLING])
def test_real_logs_pass(tmp_path: Path, name: str, missing: str) -> None:
    log = held_against_the_model(changed(tmp_path, name, **({missing: None} if missing else {})))

    said = " ".join(log.limits)
    assert ("speed_rad_s is taken to be in rad/s" in said) == (missing == "theta_m_rad")
    assert ("theta_m_rad is taken to be mechanical" in said) == (missing == "speed_rad_s")


@pytest.mark.parametrize("name", [FREE, SLOW, ROLLING])
@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"iq_a": 0.0}, "iq_a is 0 in every row"),
        ({"iq_a": lambda x: np.full_like(x, 0.3)}, "iq_a is 0.3 in every row"),
        ({"iq_a": lambda x: np.random.default_rng(1).integers(0, 2, len(x)) / 1024}, "only the last digit of iq_a"),
        ({"iq_a": math.nan}, "iq_a has no number in any row"),
        ({"speed_rad_s": 0.0}, "speed_rad_s is 0 in every row: a dead channel"),
        ({"theta_m_rad": 0.0}, "theta_m_rad is 0 in every row: a dead channel"),
        ({"theta_m_rad": 0.0, "speed_rad_s": 0.0}, "the shaft never turned"),
        ({"theta_m_rad": None, "speed_rad_s": 0.0}, "the shaft never turned"),
        ({"theta_m_rad": 0.0, "speed_rad_s": None}, "the shaft never turned"),
        ({"t_s": 1e3}, "t_s in milliseconds"),
        ({"t_s": 1e6}, "t_s in microseconds"),
        ({"t_s": 1.0 / 60.0}, "t_s in minutes"),
        ({"speed_rad_s": 30.0 / math.pi}, "speed_rad_s in r/min"),
        ({"speed_rad_s": -1.0}, "opposite sign"),
        ({"theta_m_rad": 180.0 / math.pi}, "theta_m_rad in degrees"),
        ({"theta_m_rad": lambda x: np.degrees(x) % 360.0}, "theta_m_rad in degrees"),
        ({"theta_m_rad": lambda x: (7.0 * x) % math.tau}, "theta_m_rad in electrical rad .of 7 pole pairs"),
        ({"theta_m_rad": lambda x: np.degrees(x) % 360.0, "speed_rad_s": None}, "it looks like degrees"),
        ({"t_s": lambda x: np.random.default_rng(1).permutation(x)}, "whose time repeats or goes back"),
    ],
)
def test_a_column_that_cannot_be_so_is_one_line(tmp_path: Path, name: str, changes: dict[str, Any], said: str) -> None:
    with pytest.raises(EvenspinError, match=said) as error:
        read_log(changed(tmp_path, name, **changes))

    assert error.value.exit_code == 2
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("missing", ["", "theta_m_rad", "speed_rad_s"])
def test_a_current_of_wrong_sign_is_refused_where_it_accelerates(tmp_path: Path, missing: str) -> None:
    with pytest.raises(EvenspinError, match="opposite sign of iq_a"):
        read_log(changed(tmp_path, FREE, iq_a=-1.0, **({missing: None} if missing else {})))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"iq_a": 1e3}, "iq_a in mA"),
        ({"iq_a": 1e3, "theta_m_rad": None}, "iq_a in mA"),
        ({"speed_rad_s": 30.0 / math.pi, "theta_m_rad": None}, "speed_rad_s in r/min"),
        ({"theta_m_rad": 180.0 / math.pi, "speed_rad_s": None}, "theta_m_rad in degrees"),
    ],
)
def test_a_unit_that_only_a_model_shows_is_refused_with_one(tmp_path: Path, changes: dict[str, Any], said: str) -> None:
    path = changed(tmp_path, FREE, **changes)

    read_log(path)  # alone it cannot be noticed
    with pytest.raises(EvenspinError, match=said):
        held_against_the_model(path)


@pytest.mark.parametrize("factor", [1.0 / 3.0, 3.0])
def test_an_inertia_that_is_off_by_three_is_no_unit(tmp_path: Path, factor: float) -> None:
    held_against_the_model(changed(tmp_path, FREE, theta_m_rad=None, iq_a=factor))


def test_axes_that_are_exchanged_are_refused_where_the_phases_are_logged(tmp_path: Path) -> None:
    t_s = 1e-3 * np.arange(4000)
    theta, iq = 20.0 * t_s, 1.0 + 0.2 * np.sin(3.0 * t_s)
    a, b = -iq * np.sin(4.0 * theta), -iq * np.sin(4.0 * theta - math.tau / 3.0)  # of q alone, 4 pole pairs
    columns = {"t_s": t_s, "theta_m_rad": theta, "id_a": iq, "iq_a": 0.01 * np.cos(50.0 * t_s), "ia_a": a, "ib_a": b}

    with pytest.raises(EvenspinError, match="id_a and iq_a are exchanged"):
        read_log(recordings.write(tmp_path / "log.csv", columns))
    right = columns | {"id_a": columns["iq_a"], "iq_a": iq}
    assert len(read_log(recordings.write(tmp_path / "log.csv", right)).t_s) == 4000
