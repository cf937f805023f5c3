"""Loop and controller of a drive, from the parameters that the drive itself runs with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from evenspin.design.loop import SpeedLoop
from evenspin.design.rc import Repetitive
from evenspin.errors import InputError
from evenspin.model.machine import find_model, load_machine
from evenspin.native import tables

Numbers = Mapping[str, float]


def loop_of(plant: Numbers, drive: Numbers, delay_s: float = 0.0) -> SpeedLoop:
    """The speed loop; the current loop counts as a first-order lag of k_cp / L."""
    return SpeedLoop(
        kp_a_per_unit=drive["speed_kp_a_per_unit"],
        ki_a_per_unit_s=drive["speed_ki_a_per_unit_s"],
        error_gain=drive["speed_error_gain"],
        ts_s=drive["speed_divider"] / plant["pwm_hz"],
        torque_per_a_nm=1.5 * plant["pole_pairs"] * plant["psi_wb"],
        inertia_kgm2=plant["inertia_kgm2"],
        viscous_nms=plant["viscous_nms"],
        current_bandwidth_rad_s=drive["current_kp_v_per_a"] / plant["lq_h"],
        delay_s=delay_s,
    )


def calculated_with(model: str, names: Sequence[str], given: Mapping[str, object | None]) -> str:
    """One line about the numbers of a design; `given`: options by the name of the number, None when not given."""

    def refuse(must: str, hint: str) -> InputError:
        return InputError("--model", "model", model, must, hint)

    machine = load_machine(find_model(model, Path(), refuse))
    options = {name: f"{value:g}, given" for name, value in given.items() if value is not None}
    return machine.calculated_with(names, options)


def repetitive_of(drive: Numbers, fal: bool | None = None) -> Repetitive:
    """The repetitive controller; `fal` None: as the method of the drive has it."""
    if fal is None:
        fal = tables().params["method"].to_text(drive["method"]) == "fal-forc"
    return Repetitive(
        gain=drive["rc_gain"],
        lead=int(drive["rc_lead"]),
        q_side=drive["rc_q_side"],
        q_centre=drive["rc_q_centre"],
        order=int(drive["rc_order"]),
        q_side2=drive["rc_q_side2"],
        fal=(drive["rc_fal_alpha"], drive["rc_fal_delta"]) if fal else None,
    )
