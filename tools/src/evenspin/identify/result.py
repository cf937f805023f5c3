"""What identification found, as numbers, tables, a model file and drive parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from evenspin.identify.estimate import Estimate
from evenspin.identify.friction import Friction, friction_points, identify_friction
from evenspin.identify.inertia import Inertia, identify_inertia
from evenspin.identify.source import Run
from evenspin.identify.spectrum import MAX_LINES, Spectrum, identify_lines
from evenspin.model.machine import SIMULATED, Machine
from evenspin.native import tables
from evenspin.tableview import TableView, number

KINDS = ("friction", "inertia", "cogging")
UNITS = {
    "inertia_kgm2": "kg m^2",
    "viscous_nms": "N m s/rad",
    "coulomb_nm": "N m",
    "static_nm": "N m",
    "stribeck_rad_s": "rad/s",
    "shape": "",
    "offset_nm": "N m",
}


@dataclass(frozen=True, slots=True)
class Identified:
    """The parameters for which there was data; None for the others."""

    friction: Friction | None = None
    inertia: Inertia | None = None
    spectrum: Spectrum | None = None

    @property
    def estimates(self) -> dict[str, Estimate]:
        found = {} if self.inertia is None else {"inertia_kgm2": self.inertia.inertia_kgm2}
        return found | (dict(self.friction.estimates) if self.friction is not None else {})

    def as_json(self) -> dict[str, Any]:
        """Values by name, and the 95 % confidence interval of each."""
        content: dict[str, Any] = {name: estimate.value for name, estimate in self.estimates.items()}
        intervals: dict[str, Any] = {
            name: [estimate.value - estimate.half, estimate.value + estimate.half]
            for name, estimate in self.estimates.items()
        }
        if self.spectrum is not None:
            content["lines"] = [
                {
                    "cycles": line.cycles.value,
                    "amplitude_nm": line.amplitude_nm.value,
                    "phase_rad": line.phase_rad.value,
                    "snapped": line.snapped,
                    "half_interval_95": {
                        "cycles": line.cycles.half,
                        "amplitude_nm": float(line.amplitude_nm.half),
                        "phase_rad": line.phase_rad.half,
                    },
                }
                for line in self.spectrum.lines
            ]
            content["turns"] = self.spectrum.turns
        return content | {"interval_95": intervals}


def identify(runs: Mapping[str, Sequence[Run]], *, snap: bool = False, stribeck: bool = True) -> Identified:
    """`runs`: of each kind of experiment. The slow turns of one log at a time: the longest counts."""
    slow = max(runs.get("cogging", ()), key=lambda run: run.turns, default=None)
    return Identified(
        identify_friction(friction_points(runs["friction"]), stribeck=stribeck) if "friction" in runs else None,
        identify_inertia(runs["inertia"]) if "inertia" in runs else None,
        identify_lines(slow, snap=snap) if slow is not None else None,
    )


def drive_parameters(found: Identified) -> dict[str, float]:
    """Parameters of robust driving control; their names are those of docs/parameters.md."""
    known = tables().params
    values = {f"rdc_{name}": estimate.value for name, estimate in found.estimates.items()}
    params = {name: value for name, value in values.items() if name in known}
    if found.spectrum is not None:
        for index, line in enumerate(found.spectrum.lines[:MAX_LINES], start=1):
            params[f"rdc_line{index}_cycles"] = line.cycles.value
            params[f"rdc_line{index}_nm"] = line.amplitude_nm.value
            params[f"rdc_line{index}_rad"] = line.phase_rad.value
    return params


def drive_text(found: Identified, comment: str = "# drive parameters of robust driving control") -> str:
    lines = [f"{name} = {value:.9g}" for name, value in drive_parameters(found).items()]
    return "\n".join([comment, "[drive]", *lines, ""])


def model_text(found: Identified, name: str, plant: Mapping[str, float], base: Machine | None) -> str:
    """A model file: the machine as it was, with what was found in place of what was assumed."""
    estimates, fields = found.estimates, tables().model
    values = {key: value for key, value in plant.items() if key in SIMULATED or value != fields[key].default}
    for key in ("inertia_kgm2", "viscous_nms"):
        if key in estimates:
            values[key] = estimates[key].value
    effects = {key: dict(params) for key, params in base.effects.items()} if base is not None else {}
    for key, replaced in (("inertia_kgm2", "inertia"), ("viscous_nms", "viscous_friction")):
        if key in estimates:
            effects.pop(replaced, None)  # a factor on the value that has been replaced
    if "coulomb_nm" in estimates:
        effects["coulomb_friction"] = {"torque_nm": estimates["coulomb_nm"].value}
        effects.pop("stribeck_friction", None)
    if "stribeck_rad_s" in estimates:
        effects["stribeck_friction"] = {
            "torque_nm": estimates["static_nm"].value - estimates["coulomb_nm"].value,
            "speed_rad_s": estimates["stribeck_rad_s"].value,
            "shape": estimates["shape"].value,
        }
    if found.spectrum is not None:
        effects.pop("cogging", None)
        effects["torque_ripple"] = {
            f"{key}_{index}{unit}": value
            for index, line in enumerate(found.spectrum.lines[:MAX_LINES], start=1)
            for key, unit, value in (
                ("order", "", line.cycles.value),
                ("amplitude", "_nm", line.amplitude_nm.value),
                ("phase", "_rad", line.phase_rad.value),
            )
        }
    drive = dict(base.drive) if base is not None else {}
    drive |= drive_parameters(found)
    parts = [f'name = "{name}"', 'description = "as identified"', "", "[plant]"]
    parts += [f"{key} = {_value(fields[key], value)}" for key, value in values.items()]
    parts += ["", "[drive]", *(f"{key} = {_value(tables().params[key], value)}" for key, value in drive.items())]
    for key, params in effects.items():
        parts += ["", f"[effects.{key}]", *(f"{param} = {float(value):.9g}" for param, value in params.items())]
    return "\n".join(parts) + "\n"


def tables_of(found: Identified) -> list[TableView]:
    views = []
    if found.estimates:
        rows = [
            (name, UNITS[name], f"{e.value:.5g}", f"{e.half:.2g}", f"{100.0 * e.relative:.2g} %")
            for name, e in found.estimates.items()
        ]
        header = ("parameter", "unit", "value", "+-", "")
        views.append(TableView("Identified", "+-: 95 % confidence interval.", header, rows))
    if found.spectrum is not None:
        lines = [
            (
                f"{line.cycles.value:.5f}" + (" (snapped)" if line.snapped else ""),
                f"{line.cycles.half:.2g}",
                f"{line.amplitude_nm.value:.5f}",
                number(float(line.amplitude_nm.half), 2),
                f"{line.phase_rad.value:.4f}",
                number(line.phase_rad.half, 2),
            )
            for line in found.spectrum.lines
        ]
        of_lines = ("cycles per turn", "+-", "amplitude N m", "+-", "phase rad", "+-")
        text = (
            f"From {found.spectrum.turns} turns: resolution {found.spectrum.resolution:.3g} cycles per turn; refined."
        )
        views.append(TableView("Torque tied to the angle: L sin(cycles theta + phase)", text, of_lines, lines, left=0))
    return views


def _value(field: Any, value: float) -> str:
    if field.kind == "choice":
        return f'"{field.to_text(value)}"'
    if field.kind == "flag":
        return field.to_text(value)
    return str(int(value)) if field.kind == "integer" else f"{value:.9g}"
