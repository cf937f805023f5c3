"""Every style of file holds the drive that it was written from, read again by the importer: the two share nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evenspin.blind.styles import STYLES, Style, columns_of, signals_of
from evenspin.importer import Known, guess_map, import_table, read_table

PAIRS, COUNTS, RATE_HZ = 5, 4096, 500.0


def a_drive(rows: int = 6000) -> dict[str, np.ndarray]:
    """In closed form: id = 0, id and iq regular, voltages with their drops, a load that comes and goes."""
    t = np.arange(rows) / RATE_HZ
    speed = 12.0 * np.sin(2.0 * np.pi * 0.5 * t) + 5.0 * np.sin(2.0 * np.pi * 1.3 * t)
    theta = -12.0 / np.pi * np.cos(np.pi * t) - 5.0 / (2.6 * np.pi) * np.cos(2.6 * np.pi * t)
    load = 0.3 * (np.floor(t) % 2)
    iq = 0.02 * np.gradient(speed, t) + 0.2 * np.tanh(speed) + 0.01 * speed + 4.0 * load
    theta_e = PAIRS * theta
    vd, vq = -0.01 * PAIRS * speed * iq, 0.6 * iq + 0.05 * PAIRS * speed
    c, s = np.cos(theta_e), np.sin(theta_e)
    return {
        "drive_theta_m_rad": theta,
        "speed_rad_s": speed,
        "speed_ref_rad_s": speed,
        "id_a": 0.0 * t,
        "iq_a": iq,
        "ia_a": -iq * s,
        "ib_a": -iq * np.sin(theta_e - 2.0 * np.pi / 3.0),
        "vd_v": vd,
        "vq_v": vq,
        "valpha_v": vd * c - vq * s,
        "vbeta_v": vd * s + vq * c,
        "vdc_v": np.full(rows, 24.0) + 0.01 * np.sin(300.0 * t),
        "load_torque_nm": load,
    }


@pytest.mark.parametrize("style", STYLES, ids=lambda style: style.name)
def test_a_file_of_every_style_is_read_as_the_drive_that_it_was_written_from(style: Style, tmp_path: Path) -> None:
    drive = a_drive()
    file = tmp_path / f"recording{style.suffix}"

    style.write(file, columns_of(style, True, True), signals_of(drive, PAIRS, RATE_HZ, COUNTS))

    table = read_table(file)
    mapping = guess_map(table, Known(pole_pairs=PAIRS, counts_per_turn=COUNTS if style.name == "counts" else None))
    assert not mapping.questions
    found = import_table(table, mapping).columns
    assert np.ptp(found["t_s"]) == pytest.approx(5999 / RATE_HZ, rel=1e-6)
    assert found["iq_a"] == pytest.approx(drive["iq_a"], abs=0.02 * np.max(np.abs(drive["iq_a"])))
    if "speed_rad_s" in found:
        assert found["speed_rad_s"] == pytest.approx(drive["speed_rad_s"], abs=1e-3)
    if style.angle != "none":
        turned = np.unwrap(found["theta_m_rad"])
        if style.angle == "electrical":  # of which turn of the electrical angle is not known
            assert np.ptp(turned) == pytest.approx(np.ptp(drive["drive_theta_m_rad"]), rel=1e-3)
        assert np.diff(turned) == pytest.approx(np.diff(drive["drive_theta_m_rad"]), abs=2.0 * np.pi / COUNTS)
    assert ("vq_v" in found) == bool(style.voltages)
    if style.voltages:
        assert found["vq_v"] == pytest.approx(drive["vq_v"], abs=0.02 * np.max(np.abs(drive["vq_v"])))
    if style.load:
        assert found["load_torque_nm"] == pytest.approx(drive["load_torque_nm"], abs=1e-6)
