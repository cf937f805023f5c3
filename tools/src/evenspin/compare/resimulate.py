"""Closed-loop re-simulation of a record: references, measured load and initial angle go in, nothing else."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evenspin.compare.load import reading_noise, steady_load
from evenspin.errors import InputError, NativeError
from evenspin.log.case import META
from evenspin.log.controller import NO_LIMIT
from evenspin.log.experiments import LOCKED
from evenspin.log.meta_numbers import HINT, MetaNumbers
from evenspin.log.nominal import Nominal
from evenspin.log.unit import Effects, Unit
from evenspin.native import tables
from evenspin.native.simulation import Simulation, noise_of
from evenspin.sim.record import Record

START = "start_s"  # of an effect that knows the time: where within the log a run begins
START_PASSES = 3  # an eccentricity of 0.1 rad is inverted to 1e-4 rad, a third of a count of 20000
NOISE_KEPT = 16  # seeds; 2 MB each for records of 13 s
RELEASED_ROWS = 20  # so many rows of zero current references to the end: the drive has gone to current mode

_Inputs = dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]


_noise_drawn: OrderedDict[int, NDArray[np.float64]] = OrderedDict()


def _noise(seed: int, periods: int) -> NDArray[np.float64]:
    """Noise of a seed, drawn once for all records of a machine, and for machines that differ in other things."""
    drawn = _noise_drawn.get(seed)
    if drawn is None or len(drawn) < periods:
        drawn = _noise_drawn[seed] = noise_of(seed, periods)
        while len(_noise_drawn) > NOISE_KEPT:
            _noise_drawn.popitem(last=False)
    return drawn


class Replay:
    """A record made ready to be simulated often."""

    def __init__(self, folder: Path, meta: Mapping[str, Any], name: str, record: Record, start_s: float = 0.0) -> None:
        """`start_s`: when the record begins, for effects that change with the time of all records."""
        if len(record) < 2:
            raise InputError(folder, name, f"{len(record)} rows", "at least 2 rows", "record longer")
        numbers = MetaNumbers(folder / META, meta)
        self.folder, self.name, self.rows, self.start_s = folder, name, len(record), start_s
        self.locked = name in LOCKED
        self.t_s = record["t_s"] - record["t_s"][0]
        pwm_hz = numbers.number("pwm_hz")
        self.decimate = max(1, round(pwm_hz * float(np.median(np.diff(record["t_s"])))))
        self._start_rad = float(record["theta_m_rad"][0])
        self.nominal = Nominal.of(numbers)
        self._inputs = self._references(record)

    def run(
        self,
        signals: tuple[str, ...],
        unit: Unit = Unit(),  # noqa: B008 (frozen)
        rows: int | None = None,
        drive: Mapping[str, float] = MappingProxyType({}),
    ) -> NDArray[np.float64]:
        """One row per row of the record, or of its first `rows`. `drive`: parameters that are not those of the log."""
        simulation = Simulation("float")
        try:
            self._configure(simulation, unit)
            for key, value in drive.items():
                simulation.set_param(key, value)
            simulation.start()
            simulation.record(signals)
        except NativeError as error:
            raise InputError(self.folder, self.name, str(error), "a drive that can be simulated", HINT) from None
        return simulation.run((self.rows if rows is None else rows) * self.decimate, self.decimate)

    def released_at(self) -> int | None:
        """Row from which the drive controls no speed any more."""
        times, modes = self._inputs["control_mode"]
        return None if self.locked or len(modes) < 2 else int(np.searchsorted(self.t_s, times[1] - 1e-9))

    def _references(self, record: Record) -> _Inputs:
        inputs: _Inputs = {"id_ref_a": (self.t_s, record["id_ref_a"])}
        if self.locked:
            inputs["control_mode"] = (np.zeros(1), np.zeros(1))
            inputs["iq_ref_a"] = (self.t_s, record["iq_ref_a"])
            return inputs
        driven = np.flatnonzero((record["iq_ref_a"] != 0.0) | (record["id_ref_a"] != 0.0))
        last = int(driven[-1]) + 1 if len(driven) else self.rows
        if self.rows - last >= RELEASED_ROWS:
            inputs["control_mode"] = (np.array([0.0, self.t_s[last]]), np.array([1.0, 0.0]))
        else:
            inputs["control_mode"] = (np.zeros(1), np.ones(1))
        inputs["speed_ref_rad_s"] = (self.t_s, record["speed_ref_rad_s"])
        inputs["load_torque_nm"] = (self.t_s, steady_load(record["load_torque_nm"]))
        self._load_noise_nm = reading_noise(record["load_torque_nm"])
        return inputs

    def _configure(self, simulation: Simulation, unit: Unit) -> None:
        for key, value in self.nominal.machine.items():
            simulation.set_model(key, value * unit.factors.get(key, 1.0))
        for key, value in self.nominal.supply.items():
            simulation.set_model(key, value)
        counts_per_rev = self.nominal.counts_per_rev
        simulation.set_model("counts_per_rev", counts_per_rev)
        simulation.set_model("current_range_a", NO_LIMIT)
        simulation.set_model("rotor_locked", float(self.locked))
        # the encoder cuts to whole counts: the true start angle is half a count larger on average
        part = unit.count_part * 2.0 * math.pi / counts_per_rev if counts_per_rev > 0.0 else 0.0
        simulation.set_model("initial_angle_rad", self._true_start_rad(self._start_rad + part, unit.effects))
        inputs = self._inputs
        if unit.noise_seed is not None:
            simulation.set_model("current_noise_a", self.nominal.current_noise_a)
            simulation.set_noise(unit.noise_seed, _noise(unit.noise_seed, self.rows * self.decimate))
            inputs = self._with_load_noise(unit.noise_seed)
        for key, value in self.nominal.drive.items():
            simulation.set_param(key, value)
        for effect, params in unit.effects.items():
            for param, value in params.items():
                simulation.set_effect(effect, param, value)
            if START in tables().effects[effect].params:
                simulation.set_effect(effect, START, params.get(START, 0.0) + self.start_s)
        for key, (times, values) in inputs.items():
            simulation.set_input(key, times, values)

    def _true_start_rad(self, reading_rad: float, effects: Effects) -> float:
        """Angle of the rotor when the encoder, with its errors, reads this: asked from the simulator's encoder."""
        known = tables().effects
        errors = {name: params for name, params in effects.items() if known[name].acts_on == "angle_sensor"}
        true = reading_rad
        for _ in range(START_PASSES if errors else 0):
            probe = Simulation("float")
            probe.set_model("counts_per_rev", 0.0)
            probe.set_model("pole_pairs", self.nominal.machine["pole_pairs"])
            probe.set_model("rotor_locked", 1.0)
            probe.set_model("initial_angle_rad", true)
            for effect, params in errors.items():
                for param, value in params.items():
                    probe.set_effect(effect, param, value)
            probe.start()
            probe.record(("theta_m_rad",))
            true += math.remainder(reading_rad - float(probe.run(1)[0, 0]), math.tau)
        return true

    def _with_load_noise(self, seed: int) -> _Inputs:
        """The sensor read another noise: what of it got into the input differs from repeat to repeat."""
        if self.locked or not self._load_noise_nm.any():
            return self._inputs
        times, values = self._inputs["load_torque_nm"]
        noise = np.random.default_rng(seed).normal(0.0, 1.0, len(values)) * self._load_noise_nm
        return {**self._inputs, "load_torque_nm": (times, values + noise)}


def resimulate(
    folder: Path,
    meta: Mapping[str, Any],
    name: str,
    record: Record,
    signals: tuple[str, ...],
    effects: Effects | None = None,
) -> NDArray[np.float64]:
    """One row per row of the record. `effects`: what the model adds to the nominal machine. `folder` names errors."""
    return Replay(folder, meta, name, record).run(signals, Unit(effects or {}))
