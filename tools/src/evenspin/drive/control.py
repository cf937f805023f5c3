"""The second connection of a virtual drive: load machine, brake, clock. One JSON object a line, one answer each.

    {"do": "status"}                          {"t_s": ..., "periods": ..., "model": ..., "speed": ..., "locked": ...}
    {"do": "load", "torque_nm": 0.1}          positive brakes positive rotation
    {"do": "lock", "on": true}                a holding brake
    {"do": "loads", "since": 0}               what the load machine did, [[period, torque_nm], ...]
    {"do": "parameters"}                      {"parameters": {name: value}} that the model gave the drive
    {"do": "input", "name": ..., "value": 1}  any input of the simulation
    {"do": "reset", "cause": "watchdog"}      the processor starts again; or pin, or power_up with a loss of power
    {"do": "unplug", "seconds": 0.5}          the link breaks, and may be opened again after so long
    {"do": "advance", "ms": 5, "octets": 17}  --speed max: wait for so many octets, then run; {"octets": sent so far}

An answer with the key "error" says what was wrong. The connection is closed when its first line is no JSON object, when
a line has more than 65536 octets, and when answers are not read. A real drive has no such connection.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from evenspin.drive.control_connections import number_of
from evenspin.drive.virtual import VirtualDrive
from evenspin.errors import EvenspinError


class Control:
    """Answers requests for one virtual drive. Time and plug belong to the server: it handles `advance` and `unplug`."""

    def __init__(self, drive: VirtualDrive, speed: str) -> None:
        self.drive = drive
        self.speed = speed
        self._work: Mapping[str, Callable[[Mapping[str, Any]], dict[str, Any]]] = {
            "status": self._status,
            "load": self._load,
            "lock": self._lock,
            "loads": self._loads,
            "parameters": self._parameters,
            "input": self._input,
            "reset": self._reset,
        }

    def answer(self, request: object) -> dict[str, Any]:
        """Whatever the request is, the answer is an object."""
        if not isinstance(request, dict):
            return {"error": "a line must be a JSON object"}
        kind = request.get("do")
        if not isinstance(kind, str) or kind not in self._work:
            return {"error": f"do must be one of {', '.join(self._work)}"}
        try:
            return self._work[kind](request)
        except KeyError as error:
            return {"error": f"{error.args[0]} is missing"}
        except (EvenspinError, TypeError, ValueError) as error:
            return {"error": str(error)}

    def _status(self, _: Mapping[str, Any]) -> dict[str, Any]:
        drive = self.drive
        return {
            "t_s": drive.time_s,
            "periods": drive.periods,
            "model": drive.machine.name,
            "speed": self.speed,
            "locked": drive.locked,
            "load_torque_nm": drive.load_steps[-1].torque_nm,
            "true_speed_rad_s": drive.read("true_speed_rad_s"),
        }

    def _load(self, request: Mapping[str, Any]) -> dict[str, Any]:
        self.drive.set_load_torque(number_of(request, "torque_nm"))
        return {"period": self.drive.periods}

    def _lock(self, request: Mapping[str, Any]) -> dict[str, Any]:
        if not isinstance(request["on"], bool):
            raise ValueError("on: must be true or false")
        self.drive.lock_rotor(request["on"])
        return {"period": self.drive.periods}

    def _loads(self, request: Mapping[str, Any]) -> dict[str, Any]:
        since = number_of({"since": 0, **request}, "since")
        steps = self.drive.load_steps
        first = max((i for i, step in enumerate(steps) if step.period <= since), default=0)
        return {"loads": [[step.period, step.torque_nm] for step in steps[first:]]}

    def _parameters(self, _: Mapping[str, Any]) -> dict[str, Any]:
        return {"parameters": dict(self.drive.model_parameters)}

    def _reset(self, request: Mapping[str, Any]) -> dict[str, Any]:
        self.drive.reset(str(request["cause"])[:20])
        return {"period": self.drive.periods}

    def _input(self, request: Mapping[str, Any]) -> dict[str, Any]:
        self.drive.set_input(str(request["name"])[:100], number_of(request, "value"))
        return {"period": self.drive.periods}
