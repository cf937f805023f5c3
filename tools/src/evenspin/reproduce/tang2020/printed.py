"""What the paper prints and what an independent double-precision simulation gives (docs/reference/tang2020.md)."""

from __future__ import annotations

from dataclasses import dataclass

Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Reference:
    """Speed ripple of the independent simulation, rpm, its reductions in %; what the paper says."""

    rms_off_rpm: float | None = None
    rms_on_rpm: float | None = None
    rms_pct: Range | None = None
    pp_pct: Range | None = None
    paper: str = "-"


SPECTRUM = "spectrum"
SMALL = "no change"

REFERENCES: dict[tuple[str, str], Reference] = {
    ("100 rpm", "aro"): Reference(2.53, 0.36, (84, 87), (75, 78), SPECTRUM),
    ("123 rpm", "aro"): Reference(2.40, 0.36, (84, 86), (72, 76), SPECTRUM),
    ("451 rpm", "aro"): Reference(0.96, 0.075, (92, 92), (83, 86)),
    ("1000 rpm", "aro"): Reference(0.44, 0.12, (72, 72), (73, 73)),
    ("1003 rpm", "aro"): Reference(0.44, 0.069, (84, 84), (78, 78)),
    ("misalignment, 1000 rpm", "aro"): Reference(9.69, 0.12, (98.7, 98.7), (98, 98), "pp -76 %"),
    ("sensor errors, full load", "aro"): Reference(8.5, 0.32, (96, 96), (93, 93), "effective"),
    ("load step, 1-3 s after", "aro"): Reference(2.5, 1.07, (57, 57), None, "stays low"),
    ("load step, 3-15 s after", "aro"): Reference(2.5, 0.73, (71, 71), None, "stays low"),
    ("speed step, 0.5-2 s after", "aro"): Reference(0.96, 0.145, (85, 85), None, "no ripple"),
    ("speed step, 5-10 s after", "aro"): Reference(0.96, 0.075, (92, 92), None, "no ripple"),
    ("100 rpm, J x 0.5", "aro"): Reference(2.53, 0.19, (93, 93), None, SMALL),
    ("100 rpm, J x 1.5", "aro"): Reference(2.53, 0.46, (82, 82), None, SMALL),
    ("100 rpm, J x 2", "aro"): Reference(2.53, 0.53, (79, 79), None, SMALL),
    ("100 rpm, B x 0.1", "aro"): Reference(2.53, 0.37, (85, 85), None, SMALL),
    ("100 rpm, B x 10", "aro"): Reference(2.53, 0.36, (86, 86), None, SMALL),
    ("100 rpm", "ro"): Reference(None, None, (98, 98)),
    ("123 rpm", "ro"): Reference(None, None, (99, 99)),
    ("451 rpm", "ro"): Reference(None, None, (63, 63)),
    ("451 rpm", "aro-k21"): Reference(0.96, 30.0),
    ("100 rpm", "aro-beyond"): Reference(None, None, (99.0, 99.0)),
    ("451 rpm", "aro-beyond"): Reference(None, None, (96.3, 96.3)),
    ("1000 rpm", "aro-beyond"): Reference(None, None, (67, 67)),
    ("load step, 1-3 s after", "aro-beyond"): Reference(None, 0.13),
}
