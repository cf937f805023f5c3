"""An FMU (FMI 3.0, co-simulation) of a scenario: the very firmware on the machine, or the machine alone.

The library inside is libevenspin_fmu, the same for every FMU; resources/setup.txt says what it is (sim_host/fmu). The
number of a variable's line is the value reference that modelDescription.xml gives it; the next number is the time.
"""

from __future__ import annotations

import hashlib
import io
import platform
import sys
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from evenspin.build import build
from evenspin.errors import NativeError
from evenspin.model.setup import Setup
from evenspin.native import Field, tables
from evenspin.native.library import HEADER, REINSTALL, library_folder

DRIVE, PLANT = "drive", "plant"
KINDS = (DRIVE, PLANT)
IDENTIFIER = "evenspin_fmu"
STEP_S = 1e-3  # proposed; any will do
NOT_FAULTS = ("control_mode", "speed_ref_rad_s", "position_ref_rad", "home", "id_ref_a", "iq_ref_a", "load_torque_nm",
              "load_brake_nm", "dc_link_v")  # fmt: skip
CLOCK = "t_s"  # the environment has its own
SENSED = ("true_speed_rad_s", "true_theta_m_rad", "true_id_a", "true_iq_a", "true_ia_a", "true_ib_a", "true_ic_a",
          "true_torque_nm", "true_load_speed_rad_s", "ia_a", "ib_a", "theta_m_rad", "vdc_v")  # fmt: skip
DUTIES = {
    "duty_a": "Duty of phase a, 0 to 1: share of the period at the positive rail.",
    "duty_b": "Duty of phase b.",
    "duty_c": "Duty of phase c.",
    "gates": "1: the bridge is on; 0: the diodes carry the current down.",
}
LATE = "Of the last sample, which is one PWM period old. "


@dataclass(frozen=True, slots=True)
class Variable:
    """`line`: of setup.txt; `causality` and `variability` as FMI has them."""

    line: str
    name: str
    causality: str
    variability: str
    unit: str
    doc: str
    start: float | None = None
    minimum: float | None = None
    maximum: float | None = None


def fmu_bytes(setup: Setup, kind: str, command: str) -> bytes:
    """The FMU as a file. `command`: noted in it."""
    variables = list(_variables(setup, kind))
    text = "\n".join([f"kind {kind}", f"seed {setup.seed}", *(variable.line for variable in variables)]) + "\n"
    library = _library()
    token = hashlib.sha256(text.encode() + library.read_bytes()).hexdigest()
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in (
            ("modelDescription.xml", description(setup, kind, variables, token, command)),
            ("resources/setup.txt", text.encode()),
            (f"binaries/{_platform()}/{IDENTIFIER}{library.suffix}", library.read_bytes()),
        ):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
    return out.getvalue()


def description(setup: Setup, kind: str, variables: list[Variable], token: str, command: str) -> bytes:
    """modelDescription.xml."""
    root = ElementTree.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=f"{setup.name} ({'firmware and machine' if kind == DRIVE else 'machine'})",
        description=f"Made by `{command}`.",
        instantiationToken=token,
        version=str(build().version),
        generationTool=str(build()),
        variableNamingConvention="structured",
    )
    period_s = 1.0 / setup.pwm_hz
    ElementTree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=IDENTIFIER,
        canHandleVariableCommunicationStepSize="true",
        fixedInternalStepSize=f"{period_s:.12g}",
    )
    units = ElementTree.SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(variable.unit for variable in variables if variable.unit):
        ElementTree.SubElement(units, "Unit", name=unit)
    if len(units) == 0:
        root.remove(units)
    ElementTree.SubElement(
        root, "DefaultExperiment", startTime="0", stopTime=f"{setup.duration_s:.12g}", stepSize=f"{STEP_S:g}"
    )
    listed = ElementTree.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        _add(listed, reference, variable)
    time = {"name": "time", "valueReference": str(len(variables)), "causality": "independent"}
    ElementTree.SubElement(listed, "Float64", time | {"variability": "continuous", "description": "Simulated time, s."})
    structure = ElementTree.SubElement(root, "ModelStructure")
    outputs = [reference for reference, variable in enumerate(variables) if variable.causality == "output"]
    for tag in ("Output", "InitialUnknown"):
        for reference in outputs:
            ElementTree.SubElement(structure, tag, valueReference=str(reference))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)


def _add(listed: ElementTree.Element, reference: int, variable: Variable) -> None:
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "causality": variable.causality,
        "variability": variable.variability,
        "description": variable.doc,
    }
    attributes |= {"unit": variable.unit} if variable.unit else {}
    for key, value in (("start", variable.start), ("min", variable.minimum), ("max", variable.maximum)):
        attributes |= {key: repr(float(value))} if value is not None else {}
    ElementTree.SubElement(listed, "Float64", attributes)


# ---- what it has ---------------------------------------------------------------------------------------------------


def _variables(setup: Setup, kind: str) -> Iterator[Variable]:
    for field in tables().model.values():
        yield _parameter("model", f"plant.{field.name}", field, setup.plant[field.name], fixed=True)
    if kind == DRIVE:
        for field in tables().params.values():
            yield _parameter("param", f"drive.{field.name}", field, setup.drive[field.name], fixed=field.at_rest)
    for effect in tables().effects.values():
        for param in effect.params.values():
            value = setup.effects.get(effect.name, {}).get(param.name, param.default)
            name = f"effects.{effect.name}.{param.name}"
            yield _parameter(f"effect {effect.name}", name, param, value, fixed=True)
    yield from _inputs(setup, kind)
    for name in [name for name in tables().signals if name != CLOCK] if kind == DRIVE else SENSED:
        signal = tables().signals[name]
        late = LATE if kind == DRIVE and not name.startswith("true_") else ""
        yield Variable(
            f"output {name}", f"signals.{name}", "output", "discrete", signal.unit, _one_line(late + signal.doc)
        )


def _parameter(role: str, name: str, field: Field, value: float, *, fixed: bool) -> Variable:
    words = "".join(f" {number}: {word}." for number, word in enumerate(field.choices))
    return Variable(
        f"{role} {field.name} {value!r}",
        name,
        "parameter",
        "fixed" if fixed else "tunable",
        field.unit,
        _one_line(field.doc + words),
        value,
        field.minimum,
        field.maximum,
    )


def _inputs(setup: Setup, kind: str) -> Iterator[Variable]:
    """As they are at time 0 of the scenario; what comes later is for whoever gives them."""
    if kind == PLANT:
        for name, doc in DUTIES.items():
            start = 1.0 if name == "gates" else 0.5
            yield Variable(f"input {name} {start!r}", name, "input", "discrete", "", doc, start, 0.0, 1.0)
    chosen = NOT_FAULTS if kind == DRIVE else ("load_torque_nm", "load_brake_nm", "dc_link_v")
    for name in chosen:
        field = tables().inputs[name]
        curve = setup.inputs.get(name)
        start = float(curve.value[0]) if curve is not None else setup.plant.get(name, field.default)
        limits = (field.minimum, field.maximum)
        yield Variable(f"input {name} {start!r}", name, "input", "discrete", field.unit, field.doc, start, *limits)


def _one_line(text: str) -> str:
    return " ".join(text.split())


# ---- the library ---------------------------------------------------------------------------------------------------


def _library() -> Path:
    folder = library_folder(HEADER)
    for suffix in (".so", ".dylib", ".dll"):
        if (path := folder / f"lib{IDENTIFIER}{suffix}").is_file():
            return path
    raise NativeError(f"{folder}/lib{IDENTIFIER}.so is not installed; {REINSTALL}")


def _platform() -> str:
    """As FMI 3.0 calls it: x86_64-linux, aarch64-linux, ..."""
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    return f"{machine}-{system}"
