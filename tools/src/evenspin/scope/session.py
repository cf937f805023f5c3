"""What a page may ask for, done with the drive. Everything here blocks and is called from worker threads.

One page is in control, the others watch: two hands at one drive surprise each other. Stop is for all of them.
"""

from __future__ import annotations

import contextlib
import math
import tempfile
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from evenspin.bench import Capture, Drive, Mode, State
from evenspin.bench.config import config_toml
from evenspin.bench.errors import RefusedError
from evenspin.bench.messages import fault_text
from evenspin.bench.numbers import Flag
from evenspin.errors import EvenspinError, InputError
from evenspin.log import write_csv
from evenspin.native import Field
from evenspin.output.origin import Origin
from evenspin.scope import messages
from evenspin.scope.bode import Bode
from evenspin.scope.calibrating import Calibrating, procedures
from evenspin.scope.capturing import Capturing
from evenspin.scope.configuring import changes_of, shown
from evenspin.scope.feed import Feed
from evenspin.scope.recording import Recording
from evenspin.scope.spectrum import lines_of

Message = dict[str, Any]
# What would disturb a calibration: everything that changes the drive or its stream.
MOVES = messages.NEEDS_CONTROL - {"calibrate_answer", "calibrate", "bode", "bode_end"}
MODES = {"speed": Mode.SPEED, "current": Mode.CURRENT, "position": Mode.POSITION, "torque": Mode.TORQUE}


class Session:
    """`send` takes a message for all pages; it is called from any thread. `made`: the command, for what it writes."""

    def __init__(self, feed: Feed, send: Callable[[Message], None], made: Origin | None = None) -> None:
        self.feed = feed
        self.send = send
        self.captured: Capture | None = None
        self.captured_number = 0
        self._title = ""
        self._before: tuple[Drive, str, dict[str, float]] | None = None  # what a reset of many parameters replaced
        self._changing = threading.Lock()  # one change of the drive at a time; a stop does not wait for it
        self._capturing = Capturing(send, self._take_capture)
        made = made or Origin("evenspin scope")
        self.recording = Recording(feed, made, send)
        self.calibrating = Calibrating(made, send, self._calibrated)
        self.bode = Bode(send, self._measured)
        feed.on_lost = self._lost
        self._work: Mapping[str, Callable[[Any], Message | None]] = {
            "stop": self._stop,
            "arm": self._arm,
            "start": self._start,
            "setpoint": self._setpoint,
            "clear_fault": lambda _: self.feed.need_drive().clear_fault(),
            "set": self._set,
            "save": lambda _: self.feed.need_drive().save(),
            "restore": self._restore,
            "defaults": self._restore,
            "undo": self._undo,
            "read_values": self._read_values,
            "watch": self._watch,
            "capture": self._capture,
            "capture_now": lambda _: self.feed.need_drive().trigger_capture(),
            "capture_cancel": lambda _: self._capturing.cancel(),
            "last_fault": self._last_fault,
            "spectrum": self._spectrum,
            "config": self._config,
            "record": lambda request: self.recording.start() if request.on else self.recording.end(),
            "calibrate": self._calibrate,
            "calibrate_answer": lambda request: self.calibrating.answer(request.yes),
            "bode": self._bode,
            "bode_end": lambda _: self.bode.end(),
            "document": lambda request: {"text": self.feed.need_drive().document(request.name)},
        }
        self._free = frozenset(
            {"stop", "spectrum", "document", "capture_now", "capture_cancel", "calibrate_answer", "bode_end"}
        )

    def do(self, request: Any) -> Message:
        """The answer; a refusal is {"error": text}."""
        try:
            if self.calibrating.busy and request.do in MOVES:
                raise RefusedError(f"{request.do}: a calibration is running; stop it first")
            if self.bode.busy and request.do in MOVES:
                raise RefusedError(f"{request.do}: a frequency response is being measured; end it first")
            if request.do in self._free:
                result = self._work[request.do](request)
            else:
                with self._changing:
                    result = self._work[request.do](request)
            return result or {}
        except EvenspinError as error:
            return {"error": error.bare}
        except OSError as error:
            return {"error": str(error)}
        except Exception as error:  # a mistake of ours: the page must show it, and the next stop must work
            return {"error": f"{request.do} failed: {error!r}"}
        finally:
            self.feed.ask_state_soon()

    def close(self) -> None:
        self._capturing.cancel()
        self.calibrating.stop()
        self.bode.stop()
        self.calibrating.join(5.0)
        self.bode.join(5.0)
        self.recording.close()

    def _lost(self) -> None:
        self.calibrating.stop()
        self.bode.stop()
        self.recording.lost()

    # ---- moving

    def _stop(self, _: Any) -> None:
        self.calibrating.stop()
        self.bode.stop()
        self.feed.need_drive().stop_at_once()

    def _arm(self, request: messages.Arm) -> None:
        self.feed.need_drive().command("arm" if request.on else "disarm")

    def _start(self, request: messages.Setpoint) -> None:
        """Unlike the start of the client this does not arm: after a stop somebody has to arm again."""
        drive = self.feed.need_drive()
        if not drive.state().flags & Flag.ARMED:
            raise RefusedError("start: arm first")
        self._setpoint(request)
        drive.link.keep_alive = True  # before the start: the timeout runs from it on
        try:
            drive.command("start")
        except BaseException:
            drive.link.keep_alive = False
            raise

    def _setpoint(self, request: messages.Setpoint) -> None:
        turns = math.floor(request.position_turns)
        if abs(turns) >= 2**31:
            raise InputError("scope", "position_turns", request.position_turns, "within 2e9", "fewer turns")
        angle_rad = 2.0 * math.pi * (request.position_turns - turns)
        if request.mode == "torque" and request.speed_rad_s < 0.0:
            raise InputError("scope", "speed_rad_s", request.speed_rad_s, "0 or more", "it limits both directions")
        self.feed.need_drive().setpoint(
            MODES[request.mode], speed_rad_s=request.speed_rad_s, id_a=request.id_a, iq_a=request.iq_a, turns=turns,
            angle_rad=angle_rad,
        )  # fmt: skip

    # ---- parameters

    def _set(self, request: messages.SetParameters) -> Message:
        held = self.feed.need_drive().set(request.values)
        self.feed.values = {**self.feed.values, **held}
        self.send(self.values_message())
        return {"values": held}

    def _restore(self, request: messages.Simple) -> None:
        """Take the saved parameters, or the defaults; what was in force before is kept for `undo`."""
        drive = self.feed.need_drive()
        before = drive.get()
        drive.command(request.do)
        after = self.feed.refresh_values()
        changed = {name: value for name, value in before.items() if after.get(name) != value}
        self._before = (drive, request.do, changed) if changed else None
        self.send(self.values_message())

    def _undo(self, _: Any) -> None:
        drive, before = self.feed.need_drive(), self._before
        if before is None or before[0] is not drive:
            raise RefusedError("undo: there is nothing to undo since the drive was connected")
        drive.set(before[2])
        self._before = None
        self.feed.refresh_values()
        self.send(self.values_message())

    def _config(self, request: messages.Config) -> Message:
        drive = self.feed.need_drive()
        changes = changes_of(request.text, request.name, drive)
        listed = shown(changes, drive)
        if request.apply and changes:
            before = drive.get(list(changes))
            drive.set(changes)
            self._before = (drive, "load", before)
            self.feed.refresh_values()
            self.send(self.values_message())
        return {"changes": listed}

    def config_file(self) -> str:
        return config_toml(self.feed.need_drive())

    def _calibrate(self, request: messages.Calibrate) -> Message:
        if self.recording.on:
            raise RefusedError("calibrate: it streams signals of its own; end the recording first")
        if self.bode.busy:
            raise RefusedError("calibrate: a frequency response is being measured; end it first")
        return self.calibrating.start(self.feed.need_drive(), request.name, request.known)

    def _calibrated(self, drive: Drive, name: str, before: dict[str, float]) -> None:
        """A calibration has ended: the signals of the pages come again. `name`: of one that changed parameters."""
        if drive.link.lost or self.feed.drive is not drive:
            return
        try:
            self.feed.watch(self.feed.signals, self.feed.rate_hz)
            after = self.feed.refresh_values()
            changed = {key: value for key, value in before.items() if after.get(key) != value}
            if name and changed:
                self._before = (drive, name, changed)
            self.send(self.values_message())
        except EvenspinError:
            return  # the drive was lost just now, and the feed says so

    def _bode(self, request: messages.Bode) -> None:
        if self.recording.on:
            raise RefusedError("bode: it streams signals of its own; end the recording first")
        if self.calibrating.busy:
            raise RefusedError("bode: a calibration is running; stop it first")
        self.bode.start(
            self.feed.need_drive(), request.place, request.first_hz, request.last_hz, request.points, request.amplitude
        )

    def _measured(self, drive: Drive) -> None:
        """A frequency response has ended: the signals of the pages come again."""
        if drive.link.lost or self.feed.drive is not drive:
            return
        with contextlib.suppress(EvenspinError):  # the drive was lost just now, and the feed says so
            self.feed.watch(self.feed.signals, self.feed.rate_hz)

    def _read_values(self, _: Any) -> None:
        self.feed.refresh_values()
        self.send(self.values_message())

    # ---- reading

    def _watch(self, request: messages.Watch) -> None:
        self.feed.watch(request.signals, request.rate_hz)

    def _capture(self, request: messages.ArmCapture) -> Message:
        return {"rows": self._capturing.start(self.feed.need_drive(), request)}

    def _take_capture(self, taken: Capture, title: str) -> None:
        self.captured, self._title = taken, title
        self.captured_number += 1  # each page notices and gets it

    def _last_fault(self, _: Any) -> Message:
        report = self.feed.need_drive().fault()
        if report.last_samples is None:
            raise RefusedError("last samples: the drive has recorded no fault since it was switched on")
        self._take_capture(report.last_samples, f"last samples before {report.name if report.number else 'the reset'}")
        return {}

    def _spectrum(self, request: messages.Spectrum) -> Message:
        columns, t_s = self._columns(request.source, request.seconds)
        if request.signal not in columns:
            return {"axis": request.axis, "x": [], "y": [], "note": f"{request.signal} is not among these signals."}
        pole_pairs = self.feed.values.get("pole_pairs", 1.0)
        lines = lines_of(t_s, columns, request.signal, request.axis, request.max_order, pole_pairs)
        return {
            "axis": lines.axis, "x": lines.x.round(6).tolist(), "y": [float(f"{y:.6g}") for y in lines.amplitude],
            "mean": lines.mean, "note": lines.note,
        }  # fmt: skip

    def _columns(self, source: str, seconds: float) -> tuple[dict[str, np.ndarray], np.ndarray]:
        if source == "capture":
            taken = self.captured
            if taken is None:
                return {}, np.empty(0)
            return {name: taken[name] for name in taken.names}, taken.t_s
        live = self.feed.live
        if live is None:
            return {}, np.empty(0)
        rows = live.history.last(seconds)
        return {name: rows.values[:, i] for i, name in enumerate(live.names)}, rows.t_s

    def csv(self, source: str, seconds: float) -> bytes:
        """Rows in the log format: t_s, then the signals by their names."""
        columns, t_s = self._columns(source, seconds)
        if not columns:
            raise RefusedError("export: there are no rows yet")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "export.csv"
            write_csv(path, ("t_s", *columns), np.column_stack((t_s, *(c.astype(float) for c in columns.values()))))
            return path.read_bytes()

    # ---- messages for all pages

    def link_message(self) -> Message:
        connection = self.feed.connection
        return {"type": "link", "status": connection.status, "text": connection.text}

    def drive_message(self) -> Message | None:
        drive = self.feed.drive
        if drive is None:
            return None
        info = drive.info
        return {
            "type": "drive", "name": info.name, "firmware": info.firmware, "numeric": info.numeric,
            "port": drive.port, "pwm_hz": info.pwm_hz, "read_only": drive.read_only_reason,
            "stream_signals": info.stream_signals, "capture_signals": info.recorder_signals,
            "capture_values": info.recorder_values[0] if info.recorder_values else 0,
            "procedures": procedures(), "has_storage": info.has_storage, "timeout_ms": info.timeout_ms,
            "signals": [{"name": f.name, "unit": f.unit, "doc": f.doc} for f in drive.signals.values()],
            "parameters": [_parameter(f) for f in drive.parameters.values()],
        }  # fmt: skip

    def values_message(self) -> Message:
        kept = self._before
        undo = {"what": kept[1], "count": len(kept[2])} if kept is not None and kept[0] is self.feed.drive else None
        return {"type": "values", "values": dict(self.feed.values), "undo": undo}

    def layout_message(self) -> Message | None:
        live, drive = self.feed.live, self.feed.drive
        if live is None or drive is None:
            return None
        units = [drive.signals[name].unit for name in live.names]
        rate_hz = drive.info.pwm_hz / live.stream.decimation
        return {"type": "layout", "id": live.number, "names": list(live.names), "units": units, "rate_hz": rate_hz}

    def state_message(self) -> Message | None:
        drive, state, live = self.feed.drive, self.feed.state, self.feed.live
        if drive is None or state is None:
            return None
        message: Message = {
            "type": "state", "state": state.state.name.lower(), "mode": state.mode.name.lower(),
            "armed": bool(state.flags & Flag.ARMED), "timed_out": bool(state.flags & Flag.TIMED_OUT),
            "uptime_s": state.counter / drive.info.pwm_hz, "rejected": state.rejected, "fault": None,
            "lost_rows": live.stream.lost_rows if live else 0,
            "frames_bad": state.frames_bad + drive.link.bad_frames,
        }  # fmt: skip
        if state.state == State.FAULT:
            fault = drive.schema.fault(state.fault)
            message["fault"] = {
                "name": fault.name, "cause": fault.cause, "check": fault.check,
                "text": fault_text(drive.schema, state.fault, state.detail),
            }  # fmt: skip
        return message

    def capture_message(self) -> Message | None:
        """Names of the last capture; its rows travel as a frame with the same number."""
        taken = self.captured
        if taken is None:
            return None
        return {
            "type": "capture_layout", "id": self.captured_number, "names": list(taken.names),
            "units": list(taken.units), "title": self._title, "rows": len(taken.values),
            "rate_hz": taken.pwm_hz / taken.decimation,
        }  # fmt: skip

    def capture_frame(self) -> bytes | None:
        taken = self.captured
        return (
            None if taken is None else messages.frame(messages.CAPTURE, self.captured_number, taken.t_s, taken.values)
        )


def _parameter(field: Field) -> Message:
    return {
        "name": field.name, "unit": field.unit, "kind": field.kind, "doc": field.doc, "choices": list(field.choices),
        "minimum": field.minimum, "maximum": field.maximum, "default": field.default, "allowed": field.allowed(),
        "at_rest": field.at_rest,
    }  # fmt: skip
