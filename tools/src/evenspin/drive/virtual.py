"""Firmware on plant with a link, a load machine and a brake, advanced millisecond by millisecond.

It knows nothing of clocks and sockets: `advance` is what moves time, so that the same octets in the same milliseconds
always give the same drive. `drive.server` paces it by a clock, `bench.transport` steps it in lockstep.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evenspin.errors import InputError
from evenspin.model.machine import SIMULATED, Machine, check_supply
from evenspin.native import tables
from evenspin.native.simulation import Simulation
from evenspin.recording import Recorder

PERIODS_PER_MS = 10  # the firmware's PWM periods; one pass of its main loop
PWM_HZ = 1000.0 * PERIODS_PER_MS
BITS_PER_OCTET = 10  # start, 8 data, stop
LOCKING_BRAKE_NM = 1e5  # no motor turns against it: it stands for a locked rotor
RESETS = {"power_up": 1, "pin": 2, "watchdog": 3}  # hal_reset_t
BENCH_DRIVE = {"auto_run": 0.0}  # a drive on a bench waits for the start command


@dataclass(frozen=True, slots=True)
class LoadStep:
    """From this PWM period on, counted from the start of the drive, the load machine brakes with this torque."""

    period: int
    torque_nm: float


class VirtualDrive:
    """One drive. Not thread-safe."""

    def __init__(
        self,
        machine: Machine,
        effects: Mapping[str, Mapping[str, float]] | None = None,
        *,
        plant: Mapping[str, float] | None = None,
        seed: int = 1,
        numeric: str = "float",
        baud: float | None = None,
        fresh: bool = False,
        recorder: Recorder | None = None,
    ) -> None:
        """`effects`: beside those of the model; `baud`: octets pass no faster than over such a serial line; `fresh`:
        the drive holds the defaults of the firmware, as after flashing, whatever the model says of it; its board bears
        what the model needs; `recorder`: takes down what the firmware takes in."""
        if baud is not None and not 1200.0 <= baud <= 1e8:
            raise InputError("drive", "--baud", baud, "a number in 1200 .. 1e8 baud", "625000 is what the board has")
        machine.need(SIMULATED)
        if not fresh:
            check_supply(machine, machine.drive)
        self.fresh = fresh
        self.machine = machine
        self.seed = seed
        self.numeric = numeric
        self.effects = {name: dict(params) for name, params in machine.effects.items()}
        for name, params in (effects or {}).items():
            self.effects.setdefault(name, {}).update(params)
        self.plant = {**machine.plant, **(plant or {})}
        if fresh:
            self.plant |= _board_of(self.plant, machine.drive)
        self.octets_per_s = None if baud is None else baud / BITS_PER_OCTET
        self._octets_per_ms = None if self.octets_per_s is None else self.octets_per_s / 1000.0
        self._record: tuple[str, ...] = ()
        self._recorder = recorder
        self._power_on()

    @property
    def model_parameters(self) -> Mapping[str, float]:
        """Drive parameters that the model states or that follow from its [plant]."""
        stated = {} if self.fresh else self.machine.drive
        return {name: value for name, value in stated.items() if name not in BENCH_DRIVE}

    def _power_on(self) -> None:
        sim = Simulation(self.numeric)
        for name, value in self.plant.items():
            sim.set_model(name, value)
        defaults = {name: field.default for name, field in tables().params.items()}
        if self.fresh:
            defaults |= _within_board(defaults, self.plant)
        for name, value in {**defaults, **self.model_parameters, **BENCH_DRIVE}.items():
            sim.set_param(name, value)
        for effect, params in self.effects.items():
            for name, value in params.items():
                sim.set_effect(effect, name, value)
        sim.set_seed(self.seed)
        if self._record:
            sim.record(self._record)
        sim.open_link()
        if self._recorder is not None:
            self._recorder.begin(sim)
        sim.start()
        self._sim = sim
        self.periods = 0
        self.load_steps: list[LoadStep] = [LoadStep(0, 0.0)]
        self.locked = False
        self.octets_in = 0  # taken from the client...
        self.octets_out = 0  # ...and given to it, since the start
        self._to_drive = bytearray()
        self._from_drive = bytearray()
        self._way_in = self._way_out = 0.0  # octets that the line may still carry
        self._rows: list[NDArray[np.float64]] = []

    # ---- the link

    def send(self, octets: bytes) -> None:
        """Octets for the drive; it takes them in the milliseconds to come."""
        self.octets_in += len(octets)
        self._to_drive += octets

    def receive(self) -> bytes:
        """What the drive has sent so far."""
        octets = bytes(self._from_drive)
        self._from_drive.clear()
        return octets

    @property
    def has_octets(self) -> bool:
        return bool(self._from_drive)

    def forget_octets(self) -> None:
        """The cable is out: what was in transit is lost."""
        self._to_drive.clear()
        self._from_drive.clear()

    # ---- time

    @property
    def time_s(self) -> float:
        return self._sim.time_s()

    def advance(self, milliseconds: int) -> None:
        for _ in range(milliseconds):
            self._give()
            if self._record:
                self._rows.append(self._sim.run(PERIODS_PER_MS, 1))
            else:
                self._sim.skip(PERIODS_PER_MS)
            self.periods += PERIODS_PER_MS
            if self._recorder is not None:
                self._recorder.keep(PERIODS_PER_MS)
            self._take()

    def _give(self) -> None:
        room = len(self._to_drive)
        if self._octets_per_ms is not None:
            self._way_in = min(self._way_in, 1.0) + self._octets_per_ms
            room = min(room, int(self._way_in))
        if room:
            taken = self._sim.link_write(bytes(self._to_drive[:room]))
            del self._to_drive[:taken]
            self._way_in -= taken

    def _take(self) -> None:
        room = 1 << 16
        if self._octets_per_ms is not None:
            self._way_out = min(self._way_out, 1.0) + self._octets_per_ms
            room = int(self._way_out)
        octets = self._sim.link_read(room)
        self._way_out -= len(octets)
        self.octets_out += len(octets)
        self._from_drive += octets

    # ---- the operator of the bench

    def reset(self, cause: str) -> None:
        """The processor starts again: by its watchdog, its pin, or a loss of power: then memory holds anything."""
        if cause not in RESETS:
            raise ValueError(f"cause: must be one of {', '.join(RESETS)}")
        self._to_drive.clear()
        self._from_drive.clear()
        self._sim.reset(RESETS[cause])

    def set_load_torque(self, torque_nm: float) -> None:
        """Torque of the load machine, positive brakes positive rotation; acts from the next period."""
        self._sim.set_input("load_torque_nm", (0.0,), (torque_nm,))
        self.load_steps.append(LoadStep(self.periods, float(torque_nm)))

    def lock_rotor(self, locked: bool) -> None:
        """A holding brake that no motor overcomes."""
        self._sim.set_input("load_brake_nm", (0.0,), (LOCKING_BRAKE_NM if locked else 0.0,))
        self.locked = locked

    def set_input(self, name: str, value: float) -> None:
        """Any other input of the simulation: supply, disturbances of the electronics."""
        self._sim.set_input(name, (0.0,), (value,))

    # ---- what only a simulator knows

    def record(self, signals: Sequence[str]) -> None:
        """From now on keep every period of these signals."""
        self._record = tuple(signals)
        self._rows.clear()
        self._sim.record(self._record)

    def recorded(self) -> NDArray[np.float64]:
        """A row per PWM period since `record`."""
        return np.concatenate(self._rows) if self._rows else np.empty((0, len(self._record)))

    def read(self, signal: str) -> float:
        return self._sim.read(signal)


def _board_of(plant: Mapping[str, float], drive: Mapping[str, float]) -> dict[str, float]:
    """A board for this machine, where the model does not say which: its own limits, or what its converter sees."""
    wanted = {
        "board_current_a": max(drive.get("over_current_a", 0.0), plant["current_range_a"]),
        "board_dc_link_v": max(drive.get("over_voltage_v", 0.0), 1.4 * plant["dc_link_v"]),
        "board_speed_rad_s": max(drive.get("over_speed_rad_s", 0.0), 2000.0),
    }
    most = {name: tables().model[name].maximum for name in wanted}
    return {name: min(value, most[name]) for name, value in wanted.items() if not plant[name]}


def _within_board(drive: Mapping[str, float], plant: Mapping[str, float]) -> dict[str, float]:
    """The firmware of a board has defaults that its board bears."""
    current, voltage, speed = (plant[f"board_{name}"] for name in ("current_a", "dc_link_v", "speed_rad_s"))
    most = dict.fromkeys(("over_current_a", "iq_limit_a", "id_limit_a", "align_current_a"), current)
    most |= {"over_voltage_v": voltage, "under_voltage_v": 0.5 * voltage, "over_speed_rad_s": speed}
    most |= {"profile_speed_rad_s": speed}
    return {name: min(drive[name], value) for name, value in most.items()}
