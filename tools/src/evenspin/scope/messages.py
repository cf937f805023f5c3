"""What a page and the server say to each other: requests as JSON, rows as binary frames.

Frame of rows, little endian: `kind u32 | layout u32 | rows u32 | signals u32`, then `t_s f64[rows]`, then for every
signal `f32[rows]`. `kind` 1: the next rows of the stream; 2: the same, reduced to minimum and maximum; 3: a capture.
`layout` is the number of the message that named the signals.
"""

from __future__ import annotations

import struct
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

LIVE, LIVE_REDUCED, CAPTURE = 1, 2, 3
MESSAGE_OCTETS = 1 << 16

Finite = Annotated[float, Field(allow_inf_nan=False)]
Name = Annotated[str, Field(max_length=100)]


class Request(BaseModel):
    """`id` comes back in the answer."""

    model_config = ConfigDict(extra="forbid", strict=False)
    id: int = 0


class TakeControl(Request):
    do: Literal["take_control"]


class Arm(Request):
    do: Literal["arm"]
    on: bool = True


class Setpoint(Request):
    do: Literal["setpoint", "start"]
    mode: Literal["speed", "current", "position", "torque"] = "speed"
    speed_rad_s: Finite = 0.0  # in torque mode the limit, in both directions
    id_a: Finite = 0.0
    iq_a: Finite = 0.0
    position_turns: Finite = 0.0


class Simple(Request):
    do: Literal["alive", "stop", "clear_fault", "save", "restore", "defaults", "undo", "read_values", "last_fault"]


class SetParameters(Request):
    do: Literal["set"]
    values: dict[Name, Finite]


class Watch(Request):
    """What is streamed, for all pages."""

    do: Literal["watch"]
    signals: list[Name]
    rate_hz: Finite = 1000.0


class ArmCapture(Request):
    do: Literal["capture"]
    signals: list[Name]
    trigger: Literal["immediate", "rising", "falling", "either", "fault", "manual"] = "immediate"
    signal: Name | None = None
    level: Finite = 0.0
    rows: Annotated[int, Field(ge=2, le=65535)] = 1000
    pre_pct: Annotated[float, Field(ge=0.0, le=95.0)] = 20.0
    decimation: Annotated[int, Field(ge=1, le=1000)] = 1
    repeat: bool = False


class CaptureControl(Request):
    do: Literal["capture_now", "capture_cancel"]


class Spectrum(Request):
    do: Literal["spectrum"]
    signal: Name
    source: Literal["live", "capture"] = "live"
    seconds: Annotated[float, Field(gt=0.0, le=120.0)] = 2.0
    max_order: Annotated[float, Field(gt=0.0, le=500.0)] = 24.0
    axis: Literal["electrical", "mechanical", "hz"] = "electrical"


class Config(Request):
    """A file with parameters: what it changes, or, with `apply`, the change."""

    do: Literal["config"]
    text: Annotated[str, Field(max_length=60_000)]
    name: Name = "drive.toml"
    apply: bool = False


class Record(Request):
    """What is streamed, into a new folder."""

    do: Literal["record"]
    on: bool = True


class Calibrate(Request):
    """`known`: parameters whose default is right for this motor."""

    do: Literal["calibrate"]
    name: Name
    known: Annotated[list[Name], Field(max_length=20)] = []


class CalibrateAnswer(Request):
    """Whether the rotor is locked, or released, as it was asked for."""

    do: Literal["calibrate_answer"]
    yes: bool


class Bode(Request):
    """Measure a frequency response of the drive that runs; `last_hz` and `amplitude` by its limits where left out."""

    do: Literal["bode"]
    place: Literal["torque", "current", "speed"] = "torque"
    first_hz: Finite = 2.0
    last_hz: Finite | None = None
    points: Annotated[int, Field(ge=2, le=400)] = 24
    amplitude: Finite | None = None


class BodeEnd(Request):
    """End it; the drive goes on as it runs."""

    do: Literal["bode_end"]


class Document(Request):
    do: Literal["document"]
    name: Name


AnyRequest = Annotated[
    TakeControl
    | Arm
    | Setpoint
    | Simple
    | SetParameters
    | Watch
    | ArmCapture
    | CaptureControl
    | Spectrum
    | Document
    | Config
    | Record
    | Calibrate
    | CalibrateAnswer
    | Bode
    | BodeEnd,
    Field(discriminator="do"),
]
_REQUESTS: TypeAdapter[Any] = TypeAdapter(AnyRequest)

# What changes what the drive does: only the page in control may. Stop is not here: every page may always stop.
NEEDS_CONTROL = frozenset(
    {"arm", "setpoint", "start", "clear_fault", "save", "restore", "defaults", "undo", "set", "watch", "capture",
     "capture_now", "capture_cancel", "config", "record", "calibrate", "calibrate_answer", "bode", "bode_end"}
)  # fmt: skip


class BadRequestError(ValueError):
    """What came is not a request; the text says why in one line."""


def parse(text: str) -> Any:
    try:
        return _REQUESTS.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        raise BadRequestError(f"{place or 'request'}: {first['msg']}") from None


def frame(kind: int, layout: int, t_s: NDArray[np.float64], values: NDArray[np.float32]) -> bytes:
    head = struct.pack("<IIII", kind, layout, *values.shape)
    columns = np.ascontiguousarray(values.T, dtype="<f4")
    return head + np.ascontiguousarray(t_s, dtype="<f8").tobytes() + columns.tobytes()
