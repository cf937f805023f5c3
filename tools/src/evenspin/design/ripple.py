"""What errors of the current sensors do to the speed: size over speed, and the speed at which it is worst.

    G(s) = k_T G_c / (J s + B) / (1 + (k_sp + k_si / s) k_T G_c / (J s + B))                          (1)
    first order   2 / sqrt 3 |G(j w_e)| sqrt(A^2 + A B + B^2)       offsets A, B of phases a, b         (4)
    second order  |k_b - k_a| / sqrt 3 I |G(j 2 w_e)|               gains k_a, k_b; I the q current     (8)

G_c = 1 here: with the lag of the current loop in it the first order of this drive comes out 1.4 to 2.3 % larger, and
farther from the simulated one. The largest |G| is k_T / (k_T k_sp + B), at w = sqrt(k_T k_si / J), where the integral
part and the inertia cancel. The printed (6) keeps them in the denominator as 2 sqrt(k_T k_si J): too small by a
factor of 2 here.

Source: Guo et al. 2024, equations 1 to 8. Orders over the time; counted over the angle of the rotor, as `run` does, a
ripple of 10 % moves some of the first order into the second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from evenspin.design.loop import SpeedLoop
from evenspin.design.source import loop_of
from evenspin.errors import InputError
from evenspin.model.machine import find_model, load_machine
from evenspin.native import tables
from evenspin.tableview import TableView, number

RPM = math.pi / 30.0
SPEEDS_RPM = (150.0, 203.0, 255.0, 295.0)


@dataclass(frozen=True, slots=True)
class SensorErrors:
    """Offsets, A, and gains of two phases."""

    offset_a_a: float = 0.0
    offset_b_a: float = 0.0
    gain_a: float = 1.0
    gain_b: float = 1.0

    @property
    def first_a(self) -> float:
        """Amplitude of the error of the q current at the electrical frequency, (2)."""
        a, b = self.offset_a_a, self.offset_b_a
        return 2.0 / math.sqrt(3.0) * math.sqrt(a * a + a * b + b * b)

    def second_a(self, iq_a: float) -> float:
        """The same at twice the frequency, (7)."""
        return abs(self.gain_b - self.gain_a) / math.sqrt(3.0) * abs(iq_a)


def gain(loop: SpeedLoop, w_rad_s: float) -> float:
    """|G(j w)| of (1) with G_c = 1, rad/s per A; w electrical."""
    s = 1j * w_rad_s
    plant = loop.torque_per_a_nm / (loop.inertia_kgm2 * s + loop.viscous_nms)
    control = loop.error_gain * (loop.kp_a_per_unit + loop.ki_a_per_unit_s / s)
    return abs(plant / (1.0 + control * plant))


@dataclass(frozen=True, slots=True)
class Ripple:
    """Amplitudes at one speed, rpm."""

    speed_rpm: float
    first_rpm: float
    second_rpm: float


@dataclass(frozen=True, slots=True)
class RippleDesign:
    """What `evenspin design ripple` found. Worst: of the first order; the second has it at half that speed."""

    errors: SensorErrors
    iq_a: float
    at: Sequence[Ripple]
    worst: Ripple
    worst_half: Ripple
    printed_worst_first_rpm: float  # by the printed equation 6

    def as_json(self) -> dict[str, Any]:
        from dataclasses import asdict

        return asdict(self)


def design(
    loop: SpeedLoop, pole_pairs: float, errors: SensorErrors, iq_a: float, speeds_rpm: Sequence[float]
) -> RippleDesign:
    def at(speed_rpm: float) -> Ripple:
        w = pole_pairs * speed_rpm * RPM
        first, second = errors.first_a * gain(loop, w), errors.second_a(iq_a) * gain(loop, 2.0 * w)
        return Ripple(speed_rpm, first / RPM, second / RPM)

    k_t, kp = loop.torque_per_a_nm, loop.error_gain * loop.kp_a_per_unit
    ki = loop.error_gain * loop.ki_a_per_unit_s
    worst_rpm = math.sqrt(k_t * ki / loop.inertia_kgm2) / pole_pairs / RPM
    printed = k_t / (2.0 * math.sqrt(k_t * ki * loop.inertia_kgm2) + k_t * kp + loop.viscous_nms)
    return RippleDesign(
        errors,
        iq_a,
        [at(speed) for speed in speeds_rpm],
        at(worst_rpm),
        at(0.5 * worst_rpm),
        errors.first_a * printed / RPM,
    )


def prepare(model: str, iq_a: float, speeds_rpm: Sequence[float], given: dict[str, float | None]) -> RippleDesign:
    """`given`: fields of SensorErrors; None as the model's effects have them."""

    def refuse(must: str, hint: str) -> InputError:
        return InputError("--model", "model", model, must, hint)

    machine = load_machine(find_model(model, Path(), refuse))
    drive = {name: field.default for name, field in tables().params.items()} | dict(machine.drive)
    offset, scale = machine.effects.get("current_offset", {}), machine.effects.get("current_gain", {})
    found = {
        "offset_a_a": offset.get("offset_a_a", 0.0),
        "offset_b_a": offset.get("offset_b_a", 0.0),
        "gain_a": scale.get("gain_a", 1.0),
        "gain_b": scale.get("gain_b", 1.0),
    }
    errors = SensorErrors(**(found | {name: value for name, value in given.items() if value is not None}))
    if not errors.first_a and errors.gain_a == errors.gain_b:
        raise InputError(
            "design ripple", "--offset-a", 0.0, "an error of a sensor", "give offsets or gains, or a model with them"
        )
    for speed in speeds_rpm:
        if not 0.0 < speed <= 1e5:
            raise InputError("design ripple", "--speed-rpm", speed, "above 0, at most 100000 rpm", "give another speed")
    return design(loop_of(machine.plant, drive), machine.plant["pole_pairs"], errors, iq_a, speeds_rpm)


def tables_of(found: RippleDesign) -> list[TableView]:
    rows = [
        (
            f"{each.speed_rpm:.4g}",
            number(each.first_rpm),
            number(100.0 * each.first_rpm / each.speed_rpm),
            number(each.second_rpm),
            number(100.0 * each.second_rpm / each.speed_rpm),
            why,
        )
        for each, why in [
            *((each, "") for each in found.at),
            (found.worst_half, "2nd order worst"),
            (found.worst, f"1st order worst; the printed equation 6 gives {found.printed_worst_first_rpm:.3g} rpm"),
        ]
    ]
    e = found.errors
    text = (
        f"PI alone. Offsets {e.offset_a_a:g} and {e.offset_b_a:g} A, gains {e.gain_a:g} and {e.gain_b:g}, "
        f"q current {found.iq_a:g} A."
    )
    header = ("speed rpm", "1st rpm", "1st %", "2nd rpm", "2nd %", "")
    return [TableView("Speed ripple of errors of the current sensors", text, header, rows, left=0)]
