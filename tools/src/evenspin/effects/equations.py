"""What an effect does in the equations of the machine, as arrays over the rows of a log.

A module of this package may have any of these functions, with the parameters of the table of effects:

    numbers(params, plant) -> changed numbers of the machine model
    angle_error_rad(params, theta_m_rad, pole_pairs)          measured angle less the true one, mechanical
    current_error_a(params, ia_a, ib_a)                       measured phase currents less the true ones
    lost_v(params, i_a, dc_link_v, pwm_hz)                    what the bridge takes from the voltage of a phase
    linkage_wb(params, l_h, i_a, other_a)                     flux linkage of an axis by its own current
    flux_wb(params, psi_wb, theta_e_rad)                      flux of the magnets beside the mean, d and q
    brake_nm(params, theta_m_rad, speed_rad_s, direction)     torque against positive rotation
    twist_rad(params, theta_m_rad, period_s)                  angle of the rotor less that of the load, times the share
                                                              of the load in the inertia; of rows with an even period
    held_back_nm(params, load_nm, period_s)                   of a torque on the load, what has not reached the rotor

They stand for the hooks of sim_host/plant/effect.h; a test holds both against each other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from evenspin.effects.registry import module_of
from evenspin.native import tables

HOOKS = (
    "numbers",
    "angle_error_rad",
    "current_error_a",
    "lost_v",
    "linkage_wb",
    "flux_wb",
    "brake_nm",
    "twist_rad",
    "held_back_nm",
)
MECHANICAL = ("brake_nm", "twist_rad", "held_back_nm")  # effects with these alone do not show in the voltages

Acting = tuple[str, Mapping[str, float]]


def hook(effect: str, name: str) -> Callable[..., Any] | None:
    module = module_of(effect)
    return None if module is None else getattr(module, name, None)


def has_equation(effect: str) -> bool:
    return any(hook(effect, name) is not None for name in HOOKS)


def is_mechanical(effect: str) -> bool:
    """Whether only the torque balance changes with it."""
    return all(hook(effect, name) is None for name in HOOKS if name not in MECHANICAL)


def each(acting: Iterable[Acting], name: str) -> Iterator[tuple[Callable[..., Any], dict[str, float]]]:
    """The effects that have this hook, with all their parameters."""
    for effect, params in acting:
        function = hook(effect, name)
        if function is not None:
            off = {key: field.default for key, field in tables().effects[effect].params.items()}
            yield function, {**off, **params}
