"""From a setup to a record."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from evenspin.errors import NativeError
from evenspin.model.setup import Setup
from evenspin.native import tables
from evenspin.native.simulation import Simulation, Values
from evenspin.recording import Recorder
from evenspin.sim.record import Record

TRUTH = "true_"  # signals of the plant that no drive can measure
CHUNK_S = 0.5  # simulated time between two reports of progress

Progress = Callable[[float], None]  # simulated seconds so far


def truth_signals() -> tuple[str, ...]:
    return tuple(name for name in tables().signals if name.startswith(TRUTH))


def prepare(
    setup: Setup,
    signals: Sequence[str],
    numeric: str = "float",
    memory: Values | None = None,
    recorder: Recorder | None = None,
) -> Simulation:
    """A simulation, started, at time 0; `memory`: what the angle observer knows already, A; `recorder`: takes down what
    the firmware takes in, from the start on."""
    simulation = Simulation(numeric)
    for name, value in setup.plant.items():
        simulation.set_model(name, value)
    for name, value in setup.drive.items():
        simulation.set_param(name, value)
    for effect, params in setup.effects.items():
        for name, value in params.items():
            simulation.set_effect(effect, name, value)
    simulation.set_seed(setup.seed)
    for name, curve in setup.inputs.items():
        simulation.set_input(name, curve.t_s, curve.value, linear=curve.linear)
    if memory is not None:
        simulation.set_memory(memory)
    simulation.record(signals)
    if recorder is not None:
        recorder.begin(simulation)
    simulation.start()
    return simulation


def simulate(
    setup: Setup,
    signals: Sequence[str] | None = None,
    numeric: str = "float",
    progress: Progress | None = None,
) -> Record:
    """Run it all and record these signals (default: every one), a row per `log_rate_hz`."""
    names = tuple(signals if signals is not None else tables().signals)
    return complete(prepare(setup, names, numeric), setup, names, progress)


def complete(
    simulation: Simulation,
    setup: Setup,
    names: Sequence[str],
    progress: Progress | None = None,
    recorder: Recorder | None = None,
) -> Record:
    """From time 0 to the end; `names` are the signals that it was prepared with. `recorder`: the one that it was
    prepared with."""
    names = tuple(names)
    rows = []
    for tune_list, periods in _stretches(setup):
        for param, value in tune_list:
            simulation.tune(param, value)
        chunk = max(1, round(CHUNK_S * setup.pwm_hz) // setup.decimate) * setup.decimate
        while periods > 0:
            piece = min(chunk, periods)
            rows.append(simulation.run(piece, setup.decimate))
            periods -= piece
            if recorder is not None:
                recorder.keep(piece)
            if progress is not None:
                progress(simulation.time_s())
    values = np.concatenate(rows)
    record = Record(names, tuple(tables().signals[name].unit for name in names), values)
    for name in names:
        if name.startswith(TRUTH) and not np.isfinite(record[name]).all():
            raise NativeError(f"{setup.name}: {name} is not finite; the simulated machine is unstable: check the model")
    return record


def _stretches(setup: Setup) -> list[tuple[list[tuple[str, float]], int]]:
    """The run, cut where a drive parameter changes: (changes, PWM periods that follow).

    A cut is moved to the next row of the record, so that rows stay evenly spaced.
    """
    row_hz = setup.pwm_hz / setup.decimate
    changes: dict[int, list[tuple[str, float]]] = {0: []}
    for tune in setup.tunes:
        row = -int(-(tune.t_s * row_hz - 1e-6) // 1)
        changes.setdefault(row * setup.decimate, []).append((tune.param, tune.value))
    cuts = sorted(cut for cut in changes if cut < setup.periods)
    ends = [*cuts[1:], setup.periods]
    return [(changes[cut], end - cut) for cut, end in zip(cuts, ends, strict=True)]
