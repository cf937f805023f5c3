"""Whether corrections fit the drive as it is: what it corrects already, and what they would switch on beside.

Two that fight are refused, and both are named.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from evenspin.correct.changes import SET, Change, composed
from evenspin.correct.proposal import Correction
from evenspin.correct.rules import LINES
from evenspin.errors import InputError
from evenspin.native import Field, tables

Values = Mapping[str, float]

# A log of the drive is made without these.
OFF = dict.fromkeys((
    "current_correction", "dead_time_s", "speed_model_ff", "speed_notch_hz", "encoder_cos1_rad", "encoder_sin1_rad",
    "encoder_cos2_rad", "encoder_sin2_rad", "flux_cos6", "flux_sin6", "flux_cos12", "flux_sin12", "saturation_a",
), 0.0)  # fmt: skip
SENSORS = ("current_offset_a_a", "current_offset_b_a", "current_gain_a", "current_gain_b")
FED = ("rdc_coulomb_nm", "rdc_static_nm", *(f"rdc_line{n}_nm" for n in range(1, LINES + 1)))
CLOSE = 1e-6
RDC = tables().params["position_method"].choices.index("rdc")


def check_fitting(corrections: Sequence[Correction], held: Values, fields: Mapping[str, Field]) -> None:
    """Refuse what the drive has already, and what does not go with it."""
    changes = {correction.name: correction.changes for correction in corrections}
    wanted = composed(changes, held)  # refuses two that set one parameter differently
    for correction in corrections:
        owns = {change.parameter for change in correction.changes}
        for found in _fights(correction, owns, wanted, held, fields):
            raise found


def _fights(
    correction: Correction, owns: set[str], wanted: Values, held: Values, fields: Mapping[str, Field]
) -> Iterator[InputError]:
    where = f"correction of {correction.name}"
    if _has_already(correction.changes, held):
        names = ", ".join(change.parameter for change in correction.changes if change.how == SET)
        must = "not in the drive yet"
        yield InputError(where, names, "as proposed", must, "record a new log, and let `evenspin gap` judge that")
    for name, off in OFF.items():
        if name in owns and held[name] != off:
            must = f"{fields[name].to_text(off)}, as the log was made for a drive without it"
            hint = f"the correction of {correction.name} sets it: put it back first, and record again"
            yield InputError(where, name, fields[name].to_text(held[name]), must, hint)
    if owns & set(SENSORS) and held.get("current_sensors", 0.0) != 0.0:
        value = fields["current_sensors"].to_text(held["current_sensors"])
        hint = f"the correction of {correction.name} is for two sensors: use current_correction = learned"
        yield InputError(where, "current_sensors", value, "two", hint)
    if "encoder_offset_rad" in owns and held["align_periods"] > 0.0:
        must = "0: the alignment at the start replaces encoder_offset_rad"
        hint = "let the start align again, or set align_periods=0 where the encoder is absolute"
        yield InputError(where, "align_periods", held["align_periods"], must, hint)
    if "rdc_viscous_nms" in owns and held["position_method"] == float(RDC):
        value = fields["position_method"].to_text(held["position_method"])
        must = "another one: rdc feeds rdc_viscous_nms forward as a whole, the correction only what is beyond nominal"
        yield InputError(where, "position_method", value, must, "correct a drive that runs in speed mode")
    if "speed_model_ff" in owns:
        for name in FED:
            if name not in wanted and held[name] != 0.0:
                must = "0: speed_model_ff = true of the correction would feed it forward, too"
                yield InputError(where, name, held[name], must, f"`evenspin bench set {name}=0`, and record again")


def _has_already(changes: Sequence[Change], held: Values) -> bool:
    sets = [change for change in changes if change.how == SET]
    return bool(sets) and all(abs(held[c.parameter] - c.value) <= CLOSE * abs(c.value) for c in sets)
