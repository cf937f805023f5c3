"""A recording as other programs write it: names, units, delimiters, what is there and what is not. There is no map."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Signals = Mapping[str, Array]

DEG, RPM, MILLI, MICRO = 180.0 / math.pi, 30.0 / math.pi, 1e3, 1e6
TURN = 1.0 / math.tau


@dataclass(frozen=True, slots=True)
class Column:
    """What stands in the header, and which signal times what stands in the column."""

    name: str
    signal: str
    scale: float = 1.0
    unit: str = ""  # in a row of its own, where the style has one
    digits: int = 6


@dataclass(frozen=True, slots=True)
class Style:
    name: str
    suffix: str
    write: Callable[[Path, Sequence[Column], Signals], None]
    columns: tuple[Column, ...]
    voltage: str = ""  # dq, abc, alphabeta or duty; "": such a program logs none
    voltages: tuple[Column, ...] = ()
    load: tuple[Column, ...] = ()
    currents: str = "dq"
    angle: str = "mechanical"  # mechanical, electrical or none
    most_hz: float = 1e9
    means: bool = False  # dq quantities are means since the last row


def signals_of(log: Mapping[str, Array], pole_pairs: int, rate_hz: float, counts: int) -> dict[str, Array]:
    """Everything that a style can ask for, in SI units."""
    mechanical = np.unwrap(log["drive_theta_m_rad"])
    electrical = pole_pairs * mechanical
    found = {name: np.asarray(values) for name, values in log.items() if not name.startswith("true_")}
    found["t_s"] = np.arange(len(mechanical)) / rate_hz
    found["late_t_s"] = found["t_s"] + 1_723_456.0  # of a clock that did not start with the log
    found["turned_rad"] = mechanical
    found["theta_rad"] = np.mod(mechanical, math.tau)
    found["theta_e_rad"] = np.mod(electrical, math.tau)
    found["signed_theta_e_rad"] = np.mod(electrical + math.pi, math.tau) - math.pi
    found["counts"] = np.floor(found["theta_rad"] / math.tau * counts)
    found["speed_e_rad_s"] = pole_pairs * found["speed_rad_s"]
    found["ic_a"] = -found["ia_a"] - found["ib_a"]
    x, y = found["valpha_v"], found["vbeta_v"]
    phases = np.stack([x, -0.5 * x + 0.5 * math.sqrt(3.0) * y, -0.5 * x - 0.5 * math.sqrt(3.0) * y])
    found |= dict(zip(("va_v", "vb_v", "vc_v"), phases, strict=True))
    centred = phases - 0.5 * (phases.max(axis=0) + phases.min(axis=0))  # symmetric zero sequence
    duties = 0.5 + centred / found["vdc_v"]
    found |= dict(zip(("duty_a", "duty_b", "duty_c"), duties, strict=True))
    return found


def _table(columns: Sequence[Column], signals: Signals) -> list[Array]:
    return [np.asarray(signals[column.signal] * column.scale) for column in columns]


def _text(
    delimiter: str = ",", comma: bool = False, before: str = "", units: bool = False, end: str = ""
) -> Callable[[Path, Sequence[Column], Signals], None]:
    def write(path: Path, columns: Sequence[Column], signals: Signals) -> None:
        rows = np.column_stack(_table(columns, signals))
        lines = [before] if before else []
        lines.append(delimiter.join(column.name for column in columns) + end)
        if units:
            lines.append(delimiter.join(column.unit for column in columns) + end)
        row = delimiter.join(f"%.{column.digits}f" for column in columns) + end + "\n"
        text = (row * len(rows)) % tuple(rows.ravel().tolist())
        text = text.replace(".", ",") if comma else text
        path.write_text("\n".join(lines) + "\n" + text, encoding="utf-8")

    return write


def _parquet(path: Path, columns: Sequence[Column], signals: Signals) -> None:
    import pyarrow
    import pyarrow.parquet

    values = _table(columns, signals)
    pyarrow.parquet.write_table(pyarrow.table({c.name: v for c, v in zip(columns, values, strict=True)}), path)


def _mat(path: Path, columns: Sequence[Column], signals: Signals) -> None:
    import scipy.io

    scipy.io.savemat(path, {c.name: v for c, v in zip(columns, _table(columns, signals), strict=True)})


def _npz(path: Path, columns: Sequence[Column], signals: Signals) -> None:
    arrays: dict[str, Any] = {c.name: v for c, v in zip(columns, _table(columns, signals), strict=True)}
    np.savez(path, **arrays)


def _columns(*rows: tuple[str, str] | tuple[str, str, float] | tuple[str, str, float, str]) -> tuple[Column, ...]:
    return tuple(Column(*row) for row in rows)


ODRIVE = "axis0.motor.current_control."
STYLES = (
    Style(
        "odrive",
        ".csv",
        _text(),
        _columns(
            ("time", "t_s"),
            ("axis0.encoder.pos_estimate", "turned_rad", TURN),
            ("axis0.encoder.vel_estimate", "speed_rad_s", TURN),
            (f"{ODRIVE}Iq_measured", "iq_a"),
            (f"{ODRIVE}Id_measured", "id_a"),
            ("vbus_voltage", "vdc_v"),
        ),
        "alphabeta",
        _columns(
            ("axis0.encoder.phase", "signed_theta_e_rad"),
            (f"{ODRIVE}final_v_alpha", "valpha_v"),
            (f"{ODRIVE}final_v_beta", "vbeta_v"),
        ),
        most_hz=1000.0,
    ),
    Style(
        "vesc",
        ".csv",
        _text(";", end=";"),
        _columns(
            ("ms_today", "late_t_s", MILLI),
            ("input_voltage", "vdc_v"),
            ("d_axis_current", "id_a"),
            ("q_axis_current", "iq_a"),
            ("erpm", "speed_e_rad_s", RPM),
            ("encoder_position", "theta_rad", DEG),
        ),
        "dq",
        _columns(("d_axis_voltage", "vd_v"), ("q_axis_voltage", "vq_v")),
        most_hz=500.0,
        means=True,
    ),
    Style(
        "german",
        ".csv",
        _text(";", comma=True, units=True),
        _columns(
            ("Zeit", "t_s", MILLI, "ms"),
            ("Drehzahl", "speed_rad_s", RPM, "1/min"),
            ("Winkel", "theta_rad", DEG, "Grad"),
            ("Iq", "iq_a", 1.0, "A"),
            ("Id", "id_a", 1.0, "A"),
        ),
        "dq",
        _columns(("Ud", "vd_v", 1.0, "V"), ("Uq", "vq_v", 1.0, "V")),
        _columns(("Lastmoment", "load_torque_nm", 1.0, "Nm")),
    ),
    Style(
        "parquet",
        ".parquet",
        _parquet,
        _columns(
            ("timestamp_us", "t_s", MICRO),
            ("theta_elec", "theta_e_rad"),
            ("omega_m", "speed_rad_s"),
            ("iq", "iq_a"),
            ("id", "id_a"),
        ),
        "dq",
        _columns(("vd", "vd_v"), ("vq", "vq_v")),
        _columns(("load_torque", "load_torque_nm")),
        angle="electrical",
    ),
    Style(
        "matlab",
        ".mat",
        _mat,
        _columns(
            ("t", "t_s"), ("theta", "theta_rad"), ("w", "speed_rad_s"), ("ia", "ia_a"), ("ib", "ib_a"), ("ic", "ic_a")
        ),
        "abc",
        _columns(("va", "va_v"), ("vb", "vb_v"), ("vc", "vc_v")),
        _columns(("T_load", "load_torque_nm")),
        currents="abc",
    ),
    Style(
        "laboratory",
        ".csv",
        _text(before="Test bench 3\nRecorded with 16 bit, DC coupled\n"),
        _columns(
            ("Time [s]", "t_s"),
            ("I_A [A]", "ia_a"),
            ("I_B [A]", "ib_a"),
            ("I_C [A]", "ic_a"),
            ("Position [deg]", "theta_rad", DEG),
        ),
        "abc",
        _columns(("U_A [V]", "va_v"), ("U_B [V]", "vb_v"), ("U_C [V]", "vc_v")),
        _columns(("Load torque [Nm]", "load_torque_nm")),
        currents="abc",
    ),
    Style(
        "numpy",
        ".npz",
        _npz,
        _columns(
            ("t", "t_s"),
            ("speed_rpm", "speed_rad_s", RPM),
            ("position_deg", "turned_rad", DEG),
            ("i_q", "iq_a"),
            ("i_d", "id_a"),
        ),
        "dq",
        _columns(("u_q", "vq_v"), ("u_d", "vd_v")),
        _columns(("torque_load", "load_torque_nm")),
    ),
    Style(
        "counts",
        ".txt",
        _text("\t"),
        _columns(
            ("time [ms]", "t_s", MILLI),
            ("encoder [counts]", "counts"),
            ("speed [rpm]", "speed_rad_s", RPM),
            ("iq [mA]", "iq_a", MILLI),
            ("id [mA]", "id_a", MILLI),
        ),
        "dq",
        _columns(("vd [V]", "vd_v"), ("vq [V]", "vq_v")),
    ),
    Style(
        "duties",
        ".csv",
        _text(),
        _columns(
            ("t_us", "t_s", MICRO),
            ("ia", "ia_a"),
            ("ib", "ib_a"),
            ("theta_e", "signed_theta_e_rad"),
            ("speed_ref_rpm", "speed_ref_rad_s", RPM),
        ),
        "duty",
        _columns(("duty_a", "duty_a"), ("duty_b", "duty_b"), ("duty_c", "duty_c"), ("vbus", "vdc_v")),
        currents="abc",
        angle="electrical",
    ),
    Style(
        "moteus",
        ".csv",
        _text(),
        _columns(
            ("timestamp", "late_t_s"),
            ("position", "turned_rad", TURN),
            ("velocity", "speed_rad_s", TURN),
            ("q_current", "iq_a"),
            ("d_current", "id_a"),
        ),
        most_hz=1000.0,
    ),
    Style(
        "angle only",
        ".csv",
        _text(),
        _columns(("Time (s)", "t_s"), ("Angle (rad)", "theta_rad"), ("Iq (A)", "iq_a"), ("Id (A)", "id_a")),
        "dq",
        _columns(("Vd (V)", "vd_v"), ("Vq (V)", "vq_v")),
    ),
    Style(
        "speed only",
        ".csv",
        _text(";"),
        _columns(("time_s", "t_s"), ("n_rpm", "speed_rad_s", RPM), ("iq_A", "iq_a")),
        load=_columns(("T_load_Nm", "load_torque_nm")),
        angle="none",
    ),
    Style(
        "SI units",
        ".csv",
        _text(),
        _columns(
            ("t_s", "t_s"),
            ("speed_rad_s", "speed_rad_s"),
            ("theta_m_rad", "theta_rad"),
            ("id_a", "id_a"),
            ("iq_a", "iq_a"),
        ),
        "dq",
        _columns(("vd_v", "vd_v"), ("vq_v", "vq_v")),
        _columns(("load_torque_nm", "load_torque_nm")),
    ),
)


def columns_of(style: Style, voltages: bool, load: bool) -> tuple[Column, ...]:
    return style.columns + (style.voltages if voltages else ()) + (style.load if load else ())
