"""The recordings of other drives are read as they are: names, units, frames and file formats of many programs."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from evenspin.importer import Imported, Known, guess_map, import_table, read_table
from numpy.testing import assert_allclose
from recorded_drive import PAIRS, TURN, ZERO_RAD, Recorded, recorded, write_text

DRIVE = recorded()
DIGITS = 1e-6  # nine digits are written


def imported(path: Path, known: Known | None = None) -> Imported:
    table = read_table(path)
    mapping = guess_map(table, known)
    assert mapping.questions == ()
    return import_table(table, mapping)


def assert_is_the_drive(found: Imported, *, angle_step: float = 0.0, current: float = 1.0) -> None:
    """@p angle_step: the angle is known up to a shift, and to half a count of this many rad."""
    columns = found.columns
    assert_allclose(columns["t_s"], DRIVE.t, atol=DIGITS)
    assert_allclose(columns["iq_a"], current * DRIVE.iq, atol=2e-4)
    if "speed_rad_s" in columns:
        assert_allclose(columns["speed_rad_s"], DRIVE.speed, atol=1e-4)
    if "theta_m_rad" in columns:
        off = columns["theta_m_rad"] - DRIVE.theta
        assert np.ptp(off) <= angle_step + 1e-4


Write = Callable[[Path, Recorded], Path]


STYLES: dict[str, Write] = {
    "units in brackets": lambda p, d: write_text(
        p, ["Time [ms]", "Speed [rpm]", "Iq [A]", "Angle [deg]"], [1e3 * d.t, d.rpm, d.iq, np.degrees(d.theta)]
    ),
    "semicolon, decimal comma, row of units, German": lambda p, d: write_text(
        p, ["Zeit", "Drehzahl", "Iq", "Winkel"], [d.t, d.rpm, d.iq, np.degrees(d.theta)],
        delimiter=";", comma=True, units=["s", "1/min", "A", "°"], encoding="cp1252",
    ),
    "bare symbols, wrapped angle": lambda p, d: write_text(
        p, ["t", "w", "iq", "theta"], [d.t, d.speed, d.iq, np.mod(d.theta, TURN)]
    ),
    "no header at all": lambda p, d: write_text(p, None, [d.t, d.iq, d.theta, d.rpm], delimiter="\t"),
    "blanks, other order": lambda p, d: write_text(
        p, ["iq", "omega", "time", "theta"], [d.iq, d.speed, d.t, d.theta], delimiter="  "
    ),
    "microseconds and an electrical angle": lambda p, d: write_text(
        p, ["timestamp_us", "theta_e", "rpm", "i_q", "i_d"],
        [1e6 * d.t, np.mod(d.theta_e, TURN), d.rpm, d.iq, 0.0 * d.iq + 0.001 * np.sin(9.0 * d.t)],
    ),
    "electrical angle that does not say so": lambda p, d: write_text(
        p, ["time_s", "angle_deg", "speed_rpm", "iq_a"], [d.t, np.mod(np.degrees(d.theta_e), 360.0), d.rpm, d.iq]
    ),
    "electrical speed beside a mechanical angle": lambda p, d: write_text(
        p, ["time_s", "angle_rad", "speed_rpm", "iq_a"], [d.t, d.theta, PAIRS * d.rpm, d.iq]
    ),
    "electrical speed that says so": lambda p, d: write_text(
        p, ["ms_today", "erpm", "q_current", "theta_m_deg"], [1e3 * d.t, PAIRS * d.rpm, d.iq, np.degrees(d.theta)]
    ),
    "milliamperes, turns, lines before the header": lambda p, d: write_text(
        p, ["Time (s)", "Position (turns)", "Velocity (turns/s)", "Iq (mA)"],
        [d.t, d.theta / TURN, d.speed / TURN, 1e3 * d.iq], before="# recorder 2.1\n# started by hand\n\n",
    ),
    "rms amperes": lambda p, d: write_text(
        p, ["Time_s", "Iq_Arms", "n_rpm", "theta_mech_deg"], [d.t, d.iq / np.sqrt(2.0), d.rpm, np.degrees(d.theta)]
    ),
    "dotted paths": lambda p, d: write_text(
        p,
        ["time", "axis0.encoder.pos_estimate", "axis0.encoder.vel_estimate", "axis0.motor.current_control.Iq_measured"],
        [d.t, d.theta / TURN, d.speed / TURN, d.iq],
    ),
    "angle turned round": lambda p, d: write_text(
        p, ["t_s", "speed_rad_s", "iq_a", "position_rad"], [d.t, d.speed, d.iq, -d.theta]
    ),
    "speed only": lambda p, d: write_text(p, ["Time [s]", "n [1/min]", "Iq [A]"], [d.t, d.rpm, d.iq]),
}  # fmt: skip


@pytest.mark.parametrize("style", STYLES)
def test_a_text_log_is_read_without_a_map(style: str, tmp_path: Path) -> None:
    found = imported(STYLES[style](tmp_path / "log.csv", DRIVE))

    assert_is_the_drive(found)


def test_counts_that_start_again_give_the_counts_of_a_turn(tmp_path: Path) -> None:
    counts = np.mod(np.round(DRIVE.theta / TURN * 4096.0), 4096.0)
    path = write_text(
        tmp_path / "log.csv", ["time", "pos", "vel", "iq"], [DRIVE.t, counts, DRIVE.speed / TURN, DRIVE.iq]
    )

    assert_is_the_drive(imported(path), angle_step=TURN / 4096.0)


def test_phase_currents_and_a_shaft_angle_give_dq_currents_and_the_electrical_zero(tmp_path: Path) -> None:
    columns = [DRIVE.t, DRIVE.theta, DRIVE.speed, DRIVE.ia, DRIVE.ib]
    path = write_text(tmp_path / "log.csv", ["t_s", "theta_m_rad", "speed_rad_s", "ia", "ib"], columns)

    found = imported(path)

    assert found.pole_pairs == PAIRS
    assert_is_the_drive(found)
    shift = found.columns["theta_m_rad"][0] - DRIVE.theta[0]  # brings the electrical zero to zero
    assert_allclose(shift * PAIRS, ZERO_RAD, atol=0.01)


def test_rms_and_power_invariant_dq_currents_are_seen_beside_phase_currents(tmp_path: Path) -> None:
    for factor in (1.0 / np.sqrt(2.0), np.sqrt(1.5)):
        names = ["t_s", "theta_m_rad", "speed_rad_s", "iq_a", "id_a", "ia_a", "ib_a"]
        small = 1e-4 * np.cos(7.0 * DRIVE.t)
        columns = [DRIVE.t, DRIVE.theta, DRIVE.speed, factor * DRIVE.iq, small, DRIVE.ia, DRIVE.ib]

        assert_is_the_drive(imported(write_text(tmp_path / "log.csv", names, columns)))


def test_a_rate_stands_in_for_a_column_of_time(tmp_path: Path) -> None:
    path = write_text(
        tmp_path / "log.csv", ["iq [A]", "speed [rad/s]", "theta [rad]"], [DRIVE.iq, DRIVE.speed, DRIVE.theta]
    )

    assert_is_the_drive(imported(path, Known(rate_hz=1000.0)))


def test_compressed_text_in_utf16_is_read(tmp_path: Path) -> None:
    plain = write_text(
        tmp_path / "log.txt", ["t [s]", "ω [rad/s]", "Iq [A]"], [DRIVE.t, DRIVE.speed, DRIVE.iq], encoding="utf-16"
    )
    packed = tmp_path / "log.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))

    assert_is_the_drive(imported(packed))


def test_times_of_day_and_a_cut_off_last_line_are_read(tmp_path: Path) -> None:
    lines = [
        f"2024-05-01 10:00:{t:06.3f},{w:.9g},{i:.9g}" for t, w, i in zip(DRIVE.t, DRIVE.speed, DRIVE.iq, strict=True)
    ]
    path = tmp_path / "log.csv"
    path.write_text("time,speed_rad_s,iq_a\n" + "\n".join(lines) + "\n2024-05-01 10:0")

    assert_is_the_drive(imported(path))


def _mdf(path: Path, d: Recorded) -> Path:
    from asammdf import MDF, Signal

    file = MDF()
    units = {"Iq": (d.iq, "A"), "Speed": (d.rpm, "rpm"), "Angle": (np.degrees(d.theta), "deg")}
    file.append([Signal(values, d.t, name=name, unit=unit) for name, (values, unit) in units.items()])
    return Path(file.save(path.with_suffix(".mf4")))


def _tdms(path: Path, d: Recorded) -> Path:
    from nptdms import ChannelObject, TdmsWriter

    path = path.with_suffix(".tdms")
    with TdmsWriter(path) as file:
        for name, values, unit in (("Iq", d.iq, "A"), ("Speed", d.rpm, "rpm"), ("Angle", np.degrees(d.theta), "deg")):
            properties = {"wf_increment": 0.001, "unit_string": unit}
            file.write_segment([ChannelObject("bench", name, values, properties=properties)])
    return path


def _parquet(path: Path, d: Recorded) -> Path:
    import pyarrow
    from pyarrow import parquet

    path = path.with_suffix(".parquet")
    columns = {"time_us": 1e6 * d.t, "theta_el_rad": np.mod(d.theta_e, TURN), "speed_rpm": d.rpm, "iq_a": d.iq}
    parquet.write_table(pyarrow.table(columns), path)
    return path


def _matlab(path: Path, d: Recorded) -> Path:
    from scipy.io import savemat

    path = path.with_suffix(".mat")
    savemat(
        path,
        {"log": {"time": d.t, "Iq": d.iq, "omega_m": d.speed, "theta_e": np.mod(d.theta_e, TURN), "note": "bench"}},
    )
    return path


def _matlab73(path: Path, d: Recorded) -> Path:
    import h5py

    path = path.with_suffix(".mat")
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"t": d.t, "iq": d.iq, "w": d.speed, "theta": d.theta}.items():
            file.create_dataset(name, data=values.reshape(1, -1)).attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124, b" ") + b"\x00\x02IM")
    return path


def _numpy(path: Path, d: Recorded) -> Path:
    path = path.with_suffix(".npz")
    np.savez(path, time=d.t, speed_rpm=d.rpm, iq=d.iq, angle=d.theta)
    return path


def _mcap(path: Path, d: Recorded) -> Path:
    import json

    from mcap.writer import Writer as McapWriter

    path = path.with_suffix(".mcap")
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        schema = writer.register_schema("drive", "jsonschema", b"{}")
        channel = writer.register_channel("/drive", "json", schema)
        for t, theta, speed, iq in zip(d.t, d.theta, d.speed, d.iq, strict=True):
            data = json.dumps({"shaft": {"angle_rad": theta, "speed_rad_s": speed}, "iq_a": iq}).encode()
            at_ns = round(1e9 * t)
            writer.add_message(channel, at_ns, data, at_ns)
        writer.finish()
    return path


FORMATS: dict[str, Write] = {
    "MDF 4": _mdf,
    "TDMS": _tdms,
    "Parquet": _parquet,
    "MATLAB 5": _matlab,
    "MATLAB 7.3": _matlab73,
    "NumPy": _numpy,
    "MCAP": _mcap,
}


@pytest.mark.parametrize("kind", FORMATS)
def test_a_file_of_a_measuring_program_is_read(kind: str, tmp_path: Path) -> None:
    assert_is_the_drive(imported(FORMATS[kind](tmp_path / "log", DRIVE)))
