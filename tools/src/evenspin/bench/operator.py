"""The operator at the bench: load machine and rotor lock. A virtual drive has its own; at a real one it is a person."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from evenspin.bench.errors import LeftOutError
from evenspin.bench.ports import note_of
from evenspin.bench.transport import ControlClient, LocalTransport, Transport

LoadSteps = Sequence[tuple[int, float]]  # (PWM period of the drive from which it acts, N m)


class Operator(Protocol):
    """Actions on the shaft of the machine under test."""

    has_load_machine: bool

    def load(self, torque_nm: float) -> None:
        """Torque of the load machine; positive brakes positive rotation."""
        ...

    def lock(self, locked: bool) -> None: ...

    def loads(self, since: int) -> LoadSteps:
        """What the load machine did since this period, and what it did then."""
        ...

    def model_parameters(self) -> Mapping[str, float]:
        """Parameters that the model of a virtual drive gave it; a real drive has no model."""
        ...


class LocalOperator:
    """Operator of a virtual drive in this process."""

    has_load_machine = True

    def __init__(self, transport: LocalTransport) -> None:
        self._drive = transport.drive

    def load(self, torque_nm: float) -> None:
        self._drive.set_load_torque(torque_nm)

    def lock(self, locked: bool) -> None:
        self._drive.lock_rotor(locked)

    def loads(self, since: int) -> LoadSteps:
        steps = [(step.period, step.torque_nm) for step in self._drive.load_steps]
        return _since(steps, since)

    def model_parameters(self) -> Mapping[str, float]:
        return self._drive.model_parameters


class RemoteOperator:
    """Operator of a virtual drive in another process."""

    has_load_machine = True

    def __init__(self, control: str) -> None:
        self._control = ControlClient(control)

    def load(self, torque_nm: float) -> None:
        self._control.ask({"do": "load", "torque_nm": torque_nm})

    def lock(self, locked: bool) -> None:
        self._control.ask({"do": "lock", "on": locked})

    def loads(self, since: int) -> LoadSteps:
        answer = self._control.ask({"do": "loads", "since": since})
        return [(int(period), float(torque_nm)) for period, torque_nm in answer["loads"]]

    def model_parameters(self) -> Mapping[str, float]:
        answer = self._control.ask({"do": "parameters"})
        return {str(name): float(value) for name, value in answer["parameters"].items()}


class PersonOperator:
    """A person without a load machine, asked to lock and to release the rotor."""

    has_load_machine = False

    def __init__(self, ask: Callable[[str], bool]) -> None:
        """`ask` puts a request to the person and returns whether it was done."""
        self._ask = ask
        self._locked = False

    def load(self, torque_nm: float) -> None:
        if torque_nm != 0.0:
            raise LeftOutError("load machine: this bench has none; leave out the experiments that need it")

    def lock(self, locked: bool) -> None:
        if locked == self._locked:
            return
        request = "Lock the rotor mechanically" if locked else "Release the rotor; it is going to turn"
        if not self._ask(request):
            raise LeftOutError("rotor lock: it was not confirmed; the experiment is left out")
        self._locked = locked

    def loads(self, since: int) -> LoadSteps:
        return []

    def model_parameters(self) -> Mapping[str, float]:
        return {}


def operator_for(transport: Transport, ask: Callable[[str], bool]) -> Operator:
    if isinstance(transport, LocalTransport):
        return LocalOperator(transport)
    note = note_of(transport.name)
    return RemoteOperator(note.control) if note is not None else PersonOperator(ask)


def _since(steps: LoadSteps, period: int) -> LoadSteps:
    first = max((i for i, step in enumerate(steps) if step[0] <= period), default=0)
    return steps[first:]
