"""The electrical zero of a file with phase quantities alone: which way the magnets point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from evenspin.importer import ColumnMap, Mapping, import_table
from evenspin.importer.table import RawColumn, RawTable
from evenspin.plausible.windings import check_windings

PAIRS, OHM, HENRY, PSI = 4, 0.1, 0.25e-3, 0.036
UNITS = {"t_s": "s", "theta_m_rad": "rad", "ia_a": "A", "ib_a": "A", "va_v": "V", "vb_v": "V", "vc_v": "V"}


def phases(d: np.ndarray, q: np.ndarray, angle: np.ndarray) -> list[np.ndarray]:
    return [
        d * np.cos(angle - shift) - q * np.sin(angle - shift) for shift in (0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0)
    ]


def driven_by_a_load(tmp_path: Path, axes_off_rad: float = 0.0) -> RawTable:
    """A load turns the shaft to and fro, the motor brakes with id = 0 in its own axes; voltages by the equations."""
    t = np.arange(0.0, 20.0, 0.5e-3)
    w = 60.0 * np.sin(0.5 * t)
    theta = np.cumsum(w) * 0.5e-3
    iq = -5.0 * np.tanh(w)  # against the motion; the acceleration says nothing about it
    d, q = -iq * np.sin(axes_off_rad), iq * np.cos(axes_off_rad)  # in the axes of the magnets
    we = PAIRS * w
    vd, vq = OHM * d - we * HENRY * q, OHM * q + we * (HENRY * d + PSI)
    magnets = PAIRS * theta + axes_off_rad
    ia, ib, _ = phases(d, q, magnets)
    columns = dict(zip(UNITS, (t, theta, ia, ib, *phases(vd, vq, magnets)), strict=True))
    raw = tuple(RawColumn(name, "", values) for name, values in columns.items())
    return RawTable(tmp_path / "log.csv", "text", raw, None, ())


def imported(table: RawTable):
    return import_table(
        table, Mapping({name: ColumnMap(name, unit, 1.0, 0.0, "") for name, unit in UNITS.items()}, pole_pairs=PAIRS)
    )


def test_where_a_load_drives_the_shaft_the_back_emf_tells_which_way_the_magnets_point(tmp_path: Path) -> None:
    found = imported(driven_by_a_load(tmp_path))

    assert abs(found.electrical_zero_rad or 0.0) < 0.01  # and not half a turn
    assert np.mean(found.columns["vq_v"] * np.gradient(found.columns["theta_m_rad"])) > 0.0


def test_a_drive_whose_axes_are_24_degrees_off_is_no_wrong_sign(tmp_path: Path) -> None:
    found = imported(driven_by_a_load(tmp_path, axes_off_rad=0.42))
    columns = {**found.columns, "speed_rad_s": np.gradient(found.columns["theta_m_rad"], found.columns["t_s"])}

    assert check_windings(columns) is None
