"""Columns of a log beyond those of the balance: a measured load, which is used with a torque constant; voltages."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from evenspin.balance.csv_rows import header_of, rows_of
from evenspin.balance.nominal_model import Nominal
from evenspin.log.textfile import read_text

Array = NDArray[np.float64]

LOAD = "load_torque_nm"
VOLTAGES = ("vd_v", "vq_v", "vdc_v", "va_v", "vb_v", "vc_v", "valpha_v", "vbeta_v")


@dataclass(frozen=True, slots=True)
class OtherColumns:
    """`load_a`: A of q current that carries the load, at `t_s`; None where there is none, or no torque constant."""

    t_s: Array
    load_a: Array | None
    remarks: tuple[str, ...]


def read_other_columns(path: Path, nominal: Nominal | None) -> OtherColumns:
    """What else the file has. It has been read before, and is in order."""
    text = read_text(path)
    header = header_of(text)
    remarks = []
    unused = [name for name in VOLTAGES if name in header]
    if unused:
        remarks.append(f"{', '.join(unused)}: not used; a torque balance has no voltages")
    if LOAD not in header:
        return OtherColumns(np.empty(0), None, tuple(remarks))
    if nominal is None:
        remarks.append(f"{LOAD}: not used; it takes the torque constant of --model to become a current")
        return OtherColumns(np.empty(0), None, tuple(remarks))
    table = rows_of(path, text, [header.index("t_s"), header.index(LOAD)], [])
    table = table[np.isfinite(table).all(axis=1)]
    if len(table) < 2:
        remarks.append(f"{LOAD}: not used; it has no values")
        return OtherColumns(np.empty(0), None, tuple(remarks))
    table = table[np.argsort(table[:, 0], kind="stable")]
    remarks.append(f"{LOAD}: taken off the current, with {nominal.kt_nm_per_a:.4g} N m/A of the model")
    return OtherColumns(table[:, 0], table[:, 1] / nominal.kt_nm_per_a, tuple(remarks))
