"""Random driving, recorded and replayed at once: not one difference, that is the claim.

Every piece draws a model, a numeric and methods; then it starts, commands, changes parameters, streams, captures,
saves, loads the shaft and makes something fail, at random. Half of the pieces are driven over the link, with frames
that are none in between; the others by inputs. Each PWM period is replayed from what was recorded of it,
a second of drive time later. `python tools/tests/replay_campaign.py --seconds 86400`, or `make replay-day`.
"""

from __future__ import annotations

import argparse
import io
import random
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from evenspin.bench.client import Drive, Mode
from evenspin.bench.transport import LocalTransport
from evenspin.drive import VirtualDrive
from evenspin.drive.virtual import PWM_HZ
from evenspin.errors import EvenspinError
from evenspin.model.machine import builtin_models, load_machine
from evenspin.native import tables
from evenspin.native.simulation import Simulation
from evenspin.recording import Difference, Part, Player, Recorder

MODELS = ("guo2024", "servo", "tang2020-rig1", "tang2020-rig2", "yeh2024")
TELEMETRY = [name for name in tables().signals if not name.startswith("true_")]
PIECE_S = 60.0
ROWS_EVERY = 1000
STEP_PERIODS = 1000
MOMENT_S = (0.01, 0.8)  # between two actions over the link
AGAINST = 0.15  # share of the actions that make something fail
FAILURES: tuple[tuple[str, float, float], ...] = (
    ("sample_lost", 1.0, 0.0),
    ("current_nan", 1.0, 0.0),
    ("current_a_gain", 0.0, 1.0),
    ("current_b_stands", 1.0, 0.0),
    ("open_phase", 1.0, 0.0),
    ("encoder_stuck", 1.0, 0.0),
    ("encoder_error", 1.0, 0.0),
    ("encoder_slip_rad", 0.1, 0.1),
    ("inverter_fault", 2.0, 0.0),
    ("isr_load_cyc", 21000.0, 3000.0),
    ("speed_isr_load_cyc", 90000.0, 5000.0),
)


@dataclass(frozen=True)
class Outcome:
    seed: int
    text: str
    periods: int
    faults: Counter[str]
    difference: Difference | None


class AtOnce(Recorder):
    """A recorder that replays each part as soon as there is one."""

    def __init__(self, what: str, numeric: str, linked: bool) -> None:
        super().__init__(
            io.BytesIO(), numeric=numeric, what=what, seed=1, pwm_hz=PWM_HZ, linked=linked, rows_every=ROWS_EVERY
        )
        self.player = Player(Path(what), self.head)
        self.faults: Counter[str] = Counter()

    def _put(self) -> None:
        assert self._simulation is not None
        self.player.feed(Part(self.player.periods, self._waiting, tuple(self._simulation.take_trace())))
        left = self._waiting
        while left and not self.player.ended:
            rows = self.player.run(min(left, 2000))
            left -= len(rows)
            if len(rows) and rows[-1, self.player.signals.index("fault")] > 0.0:  # it stops behind each trip
                self.faults[tables().faults[int(rows[-1, self.player.signals.index("fault")])].name] += 1
            if not len(rows):
                break
        self._waiting = 0


def over_the_link(rng: random.Random, recorder: AtOnce, model: str, numeric: str, seconds: float) -> None:
    """A client that does what clients do, and what they should not."""
    virtual = VirtualDrive(
        load_machine(builtin_models()[model]), seed=rng.randrange(1000), numeric=numeric, recorder=recorder
    )
    drive = Drive(LocalTransport("campaign", virtual), "campaign", 0.0, None)
    broken: list[tuple[str, float]] = []

    def garbage() -> None:
        virtual.send(rng.randbytes(rng.randrange(1, 80)))

    def change() -> None:
        field = rng.choice(list(tables().params.values()))
        low, high = max(field.minimum, -1e4), min(field.maximum, 1e4)
        now = drive.get([field.name])[field.name]
        value = rng.choice((now, 1.05 * now, rng.uniform(low, high)))
        drive.set({field.name: round(value) if field.kind != "float" else value})

    def move() -> None:
        mode = rng.choice((Mode.SPEED, Mode.SPEED, Mode.CURRENT, Mode.POSITION))
        drive.setpoint(
            mode, speed_rad_s=rng.uniform(-40.0, 40.0), iq_a=rng.uniform(-1.0, 1.0), turns=rng.randrange(-5, 6)
        )

    def fail() -> None:
        name, value, healed = rng.choice(FAILURES)
        virtual.set_input(name, value)
        broken.append((name, healed))

    def heal() -> None:
        while broken:
            virtual.set_input(*broken.pop())
        drive.clear_fault()

    def look() -> None:
        names = rng.sample(TELEMETRY, 6)
        drive.arm_capture(names, rows=100)
        drive.read(names[:3])
        drive.fault(samples=rng.random() < 0.3)

    actions: list[Callable[[], object]] = [
        lambda: drive.start(wait=False), move, move, move, change, look, garbage,
        lambda: virtual.set_load_torque(rng.uniform(-0.1, 0.1)),
        lambda: drive.stream(rng.sample(TELEMETRY, 8)),
        drive.stop, drive.stop_at_once, drive.save, drive.restore, heal, heal,
        lambda: drive.command("home"),
    ]  # fmt: skip
    drive.set_timeout(0)
    while virtual.time_s < seconds and not recorder.player.ended:
        try:
            (fail if rng.random() < AGAINST else rng.choice(actions))()
            drive.sleep(rng.uniform(*MOMENT_S))
        except EvenspinError:
            heal_quietly(heal)
    drive.close()


def heal_quietly(heal: Callable[[], None]) -> None:
    try:
        heal()
    except EvenspinError:
        return


def by_inputs(rng: random.Random, recorder: AtOnce, model: str, numeric: str, seconds: float) -> None:
    """A run of the library: no link, inputs that change, parameters that change."""
    machine = load_machine(builtin_models()[model])
    sim = Simulation(numeric)
    for name, value in machine.plant.items():
        sim.set_model(name, value)
    params = tables().params
    method = rng.choice(params["method"].choices)
    drive = {**machine.drive, "auto_run": 1.0, "method": float(params["method"].choices.index(method))}
    for name, value in drive.items():
        sim.set_param(name, value)
    for effect, values in machine.effects.items():
        for name, value in values.items():
            sim.set_effect(effect, name, value)
    recorder.begin(sim)
    sim.start()
    while sim.time_s() < seconds and not recorder.player.ended:
        act = rng.random()
        if act < AGAINST / 4.0:
            name, value, healed = rng.choice(FAILURES)
            sim.set_input(name, (0.0, sim.time_s() + 0.002), (value, healed))
        elif act < 0.5:
            sim.set_input("speed_ref_rad_s", (0.0,), (rng.uniform(-40.0, 40.0),))
        elif act < 0.7:
            sim.set_input("load_torque_nm", (0.0,), (rng.uniform(-0.1, 0.1),))
        elif act < 0.8:
            try:
                sim.tune("speed_kp_a_per_unit", rng.uniform(0.5, 1.5) * drive.get("speed_kp_a_per_unit", 0.0368))
            except EvenspinError:
                pass  # an earlier change still waits
        sim.skip(STEP_PERIODS)
        recorder.keep(STEP_PERIODS)


def piece(seed: int, seconds: float) -> Outcome:
    """A piece of a day; the same for the same seed."""
    rng = random.Random(seed)
    model, numeric, linked = rng.choice(MODELS), rng.choice(("float", "fixed")), rng.random() < 0.5
    recorder = AtOnce(model, numeric, linked)
    try:
        (over_the_link if linked else by_inputs)(rng, recorder, model, numeric, seconds if linked else seconds / 6.0)
    except EvenspinError as error:  # a drive that cannot be drawn like this is none
        return Outcome(
            seed, f"{model}: {error}", recorder.player.periods, recorder.faults, recorder.player.difference()
        )
    recorder.close()
    text = f"{model}, {numeric}, {'link' if linked else 'inputs'}"
    return Outcome(seed, text, recorder.player.periods, recorder.faults, recorder.player.difference())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=86400.0, help="of drive time (default: a day)")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    began, periods, seed = time.monotonic(), 0, options.seed
    faults: Counter[str] = Counter()
    while periods / PWM_HZ < options.seconds:
        outcome = piece(seed, PIECE_S)
        periods += outcome.periods
        faults += outcome.faults
        if outcome.difference is not None:
            print(f"seed {seed} ({outcome.text}): {outcome.difference}")
            return 1
        if seed % 20 == 0:
            took_s = time.monotonic() - began
            print(f"{periods / PWM_HZ:.0f} s, {sum(faults.values())} trips, {took_s:.0f} s of work", flush=True)
        seed += 1
    pieces = seed - options.seed
    print(f"{periods / PWM_HZ:.0f} s of driving in {pieces} pieces, no difference; {sum(faults.values())} trips:")
    print(", ".join(f"{name} {count}" for name, count in faults.most_common()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
