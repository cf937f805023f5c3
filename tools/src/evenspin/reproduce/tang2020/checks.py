"""Is the result what it should be? The bounds are those that were set; the other side of each band is far from ours."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from evenspin.reproduce.check import Check
from evenspin.reproduce.tang2020.printed import REFERENCES

Row = Mapping[str, Any]

RMS, PP, TWELFTH = "reduction_pct", "pp_reduction_pct", "order_12_db"
ON, TIME = "rms_on_rpm", "time_to_90_pct_s"
NAMES = {
    RMS: "rms reduction [%]",
    PP: "peak-to-peak reduction [%]",
    TWELFTH: "12th order [dB]",
    ON: "rms with observer [rpm]",
    TIME: "time to 90 % reduction [s]",
    "rms_off_rpm": "rms without observer [rpm]",
}

# Noise of the encoder ends in the memory of the printed algorithm; a residue far below the reference would say that the
# noise is missing. Reductions have 100 % as their natural other side where noise is averaged away. At exactly 1000 rpm
# every turn sees the same rounding of the encoder, which is learned (72 %); 0.002 % beside it, where the fixed-point
# build runs, it is not (94 %).
# (condition, method, key, low, high)
ACCEPTANCE = (
    ("100 rpm", "aro", RMS, 83.0, 95.0),
    ("123 rpm", "aro", RMS, 83.0, 95.0),
    ("451 rpm", "aro", RMS, 90.0, 97.0),
    ("1000 rpm", "aro", RMS, 68.0, 96.0),
    *((f"{rpm} rpm", "aro", PP, 70.0, 95.0) for rpm in (100, 123, 451, 1000)),
    *((f"{rpm} rpm", "aro", TWELFTH, -80.0, -20.0) for rpm in (100, 123, 451, 1000)),
    ("misalignment, 1000 rpm", "aro", PP, 95.0, 99.9),
    ("sensor errors, full load", "aro", RMS, 95.0, 99.9),
    *((f"100 rpm, J x {factor}", "aro", RMS, 75.0, 97.0) for factor in ("0.5", "1.5", "2")),
    *((f"100 rpm, B x {factor}", "aro", RMS, 75.0, 97.0) for factor in ("0.1", "10")),
    ("451 rpm", "aro-k21", RMS, -1e5, -100.0),  # worse than nothing: at least twice the ripple
    ("100 rpm", "aro-beyond", RMS, 98.0, 99.99),
    ("451 rpm", "aro-beyond", RMS, 96.0, 99.99),
    ("load step, 1-3 s after", "aro-beyond", ON, 0.005, 0.15),
    ("100 rpm", "aro-beyond", TIME, 0.5, 10.0),
)
# No bound was set for errors of the motor model; that of the mechanics is taken.
ELECTRICAL = tuple(
    (f"100 rpm, deadbeat {name} x {factor}", "aro", RMS, 75.0, 97.0)
    for name in ("R", "L", "psi")
    for factor in ("0.7", "1.3")
)

# The reference has its own noise, filters and start: its residues are compared within a third, what is there without an
# observer within a tenth (the sensor errors within a fifth: their ripple depends on how the speed loop is discretised).
OFF_BAND, ON_BAND = 0.1, 0.34
OFF_BAND_OF = {"sensor errors, full load": 0.2}


def check_rows(rows: Iterable[Row]) -> list[Check]:
    """Everything that can be checked with the rows there are."""
    found = {(row["condition"], row["method"]): row for row in rows}
    checks = [
        _check(found[condition, method], key, low, high, required=True)
        for condition, method, key, low, high in (*ACCEPTANCE, *ELECTRICAL)
        if (condition, method) in found
    ]
    return checks + list(_against_reference(found))


def value_of(row: Row, key: str) -> float:
    """The number that a check is about; nan where there is none."""
    value = row["orders"].get("12") if key == TWELFTH else row.get(key)
    return float("nan") if value is None else float(value)


def _check(row: Row, key: str, low: float, high: float, *, required: bool) -> Check:
    what = f"{row['method']}, {row['condition']}: {NAMES[key]}"
    return Check(what, key, value_of(row, key), low, high, required, row["method"], row["speed_rpm"])


def _against_reference(found: Mapping[tuple[str, str], Row]) -> Iterator[Check]:
    for (condition, method), reference in REFERENCES.items():
        row = found.get((condition, method))
        if row is None or method != "aro":
            continue
        off, on = reference.rms_off_rpm, reference.rms_on_rpm
        band = OFF_BAND_OF.get(condition, OFF_BAND)
        if off is not None:
            yield _check(row, "rms_off_rpm", (1 - band) * off, (1 + band) * off, required=False)
        if on is not None:
            yield _check(row, ON, (1 - ON_BAND) * on, (1 + ON_BAND) * on, required=False)
