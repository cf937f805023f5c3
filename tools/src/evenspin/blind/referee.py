"""The referee: sim_host/referee, loaded from evenspin/_lib. A run is a pure function of its parameters and inputs."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import NativeError, did_you_mean
from evenspin.native.library import REINSTALL, declarations, library_folder

HEADER = "evenspin_referee.h"
SUPPORTED_ABI = 2
# Factors on what the motor is; the machine itself has no such parameters. The referee's own list on purpose.
FACTORS = {
    "viscous_friction.factor": "motor.viscous_nms",
    "inertia.factor": "motor.inertia_kgm2",
    "torque_constant.factor": "motor.psi_wb",
    "winding_resistance.factor": "motor.resistance_ohm",
}
PWM_HZ = 10000.0  # of the format

Parameters = dict[str, float]


@dataclass(frozen=True, slots=True)
class Inputs:
    """One value per control period."""

    speed_ref_rad_s: NDArray[np.float64]
    id_ref_a: NDArray[np.float64]
    iq_ref_a: NDArray[np.float64]
    load_torque_nm: NDArray[np.float64]
    current_mode: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.speed_ref_rad_s)


@dataclass(frozen=True, slots=True)
class _Referee:
    ffi: Any
    lib: Any
    index: Mapping[str, int]
    defaults: NDArray[np.float64]
    signals: tuple[str, ...]


@functools.cache
def _load() -> _Referee:
    from cffi import FFI

    folder = library_folder(HEADER)
    ffi = FFI()
    found = [folder / name for name in _file_names() if (folder / name).is_file()]
    if not found:
        raise NativeError(f"{folder}/{_file_names()[0]} is not installed; {REINSTALL}")
    try:
        ffi.cdef(declarations((folder / HEADER).read_text()))
        lib = ffi.dlopen(str(found[0]))
    except OSError as error:
        raise NativeError(f"{found[0]}: cannot be loaded ({error}); {REINSTALL}") from None
    if lib.referee_abi_version() != SUPPORTED_ABI:
        raise NativeError(f"{found[0]}: another interface than {SUPPORTED_ABI}; {REINSTALL}")
    count = lib.referee_parameter_count()
    names = [ffi.string(lib.referee_parameter_name(k)).decode() for k in range(count)]
    defaults = np.array([lib.referee_parameter_default(k) for k in range(count)])
    signals = tuple(ffi.string(lib.referee_signal_name(k)).decode() for k in range(lib.referee_signal_count()))
    return _Referee(ffi, lib, {name: k for k, name in enumerate(names)}, defaults, signals)


def _file_names() -> list[str]:
    return [str(Path(f"libevenspin_referee{end}")) for end in (".so", ".dylib")] + ["evenspin_referee.dll"]


def parameter_names() -> tuple[str, ...]:
    return tuple(_load().index)


def simulate(parameters: Mapping[str, float], inputs: Inputs, decimate: int) -> dict[str, NDArray[np.float64]]:
    """Every `decimate`-th control period; signals of sim_host/referee/signals.def by name."""
    referee = _load()
    values = referee.defaults.copy()
    for name, value in parameters.items():
        if name not in referee.index:
            raise NativeError(f"referee: {name} is not known; {did_you_mean(name, referee.index)}")
        values[referee.index[name]] = value
    arrays = [
        np.ascontiguousarray(getattr(inputs, name), dtype=np.float64)
        for name in ("speed_ref_rad_s", "id_ref_a", "iq_ref_a", "load_torque_nm", "current_mode")
    ]
    if any(len(array) != len(inputs) for array in arrays):
        raise NativeError(f"referee: inputs of lengths {[len(array) for array in arrays]}")
    ffi = referee.ffi
    log = np.empty((-(-len(inputs) // decimate), len(referee.signals)))
    struct = ffi.new("referee_inputs_t *", [ffi.cast("double *", array.ctypes.data) for array in arrays])
    status = referee.lib.referee_run(
        ffi.cast("double *", values.ctypes.data),
        struct,
        len(inputs),
        decimate,
        ffi.cast("double *", log.ctypes.data),
    )
    if status != 0:
        name = list(referee.index)[status - 1] if status > 0 else "arguments"
        raise NativeError(f"referee: {name} is out of its domain")
    return dict(zip(referee.signals, log.T, strict=True))


def parameters_of(meta: Mapping[str, Any]) -> Parameters:
    """The drive that meta.json describes: nominal, without any effect. Noise of the sensors is in it."""
    motor, current, speed, pll = meta["motor"], meta["current_loop"], meta["speed_loop"], meta["speed_filter"]
    keys = (
        "pole_pairs",
        "resistance_ohm",
        "ld_h",
        "lq_h",
        "psi_wb",
        "inertia_kgm2",
        "viscous_nms",
        "rated_current_a",
    )
    return {f"motor.{key}": float(motor[key]) for key in keys} | {
        "bridge.dc_link_v": meta["dc_link_v"],
        "bridge.pwm_hz": meta["pwm_hz"],
        "sensor.counts_per_rev": meta["encoder"]["counts_per_rev"],
        "sensor.current_noise_a": meta["current_noise_a"],
        "sensor.current_lsb_a": meta["current_lsb_a"],
        "drive.current_kp_v_per_a": current["kp_v_per_a"],
        "drive.current_ki_v_per_as": current["ki_v_per_as"],
        "drive.angle_advance_periods": current["angle_advance_periods"],
        "drive.speed_periods": round(speed["ts_s"] * meta["pwm_hz"]),
        "drive.speed_kp_a_per_rad_s": speed["kp_a_per_rad_s"],
        "drive.speed_ki_a_per_rad": speed["ki_a_per_rad"],
        "drive.iq_limit_a": speed["iq_limit_a"],
        "drive.pll_kp": pll["kp"],
        "drive.pll_ki": pll["ki"],
    }


def with_effects(parameters: Parameters, effects: Mapping[str, Mapping[str, float]]) -> Parameters:
    """The drive with these effects, {name: {parameter: value}}."""
    result = dict(parameters)
    for effect, values in effects.items():
        for key, value in values.items():
            name = f"{effect}.{key}"
            if name in FACTORS:
                result[FACTORS[name]] *= value
            else:
                result[name] = value
    return result


def defaults() -> Parameters:
    """Every parameter at its default: a drive without any effect."""
    referee = _load()
    return {name: float(referee.defaults[k]) for name, k in referee.index.items()}
