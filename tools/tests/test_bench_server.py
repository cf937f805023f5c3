"""Virtual drives of other processes and threads: TCP, pseudo terminal, lockstep, a cable that is pulled, Ctrl-C."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evenspin.bench import Drive, State, find_ports
from evenspin.bench.errors import LinkLostError, NoDeviceError
from evenspin.bench.ports import choose_port
from evenspin.bench.transport import ControlClient
from evenspin.drive import VirtualDrive
from evenspin.drive.registry import Note, announced, running
from evenspin.drive.server import Server
from evenspin.log import read_case
from evenspin.model.machine import builtin_models, load_machine

SIGNALS = ("speed_ref_rad_s", "speed_rad_s", "theta_m_rad", "id_a", "iq_ref_a", "iq_a", "vd_v", "vq_v")


@pytest.fixture(autouse=True)
def own_registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


@contextmanager
def served(*, tcp: bool = True, lockstep: bool = False, baud: float | None = None) -> Iterator[tuple[Server, Note]]:
    drive = VirtualDrive(load_machine(builtin_models()["guo2024"]), baud=baud)
    said: list[str] = []
    server = Server(drive, address=("127.0.0.1", 0) if tcp else None, lockstep=lockstep, say=said.append)
    speed = "max" if lockstep else "real"
    note = Note(os.getpid(), server.port, server.control, drive.machine.name, speed, drive.octets_per_s)
    thread = threading.Thread(target=server.run, daemon=True)
    with announced(note):
        thread.start()
        try:
            yield server, note
        finally:
            server.stop()
            thread.join(5.0)
    assert not thread.is_alive()


def test_lockstep_over_tcp_is_the_same_run_as_in_this_process() -> None:
    def run(port: str) -> tuple[bytes, float]:
        with Drive.connect(port) as drive:
            drive.run_speed(30.0)
            with drive.stream(SIGNALS, rate_hz=2000.0) as stream:
                return stream.read_rows(400).tobytes(), drive.link.transport.clock()

    with served(lockstep=True) as (_, note):
        assert run(note.port) == run("sim:guo2024")


def test_an_experiment_list_over_lockstep_tcp_leaves_the_same_bytes_as_in_process(evenspin, tmp_path: Path) -> None:
    plan = tmp_path / "experiments.toml"
    assert evenspin("bench", "plan", "guo2024", "--out", plan).status == 0
    words = ("bench", "run", plan, "--only", "load_step", "--only", "validation_steps")
    with served(lockstep=True) as (_, note):
        assert evenspin(*words, "--port", note.port, "--out", tmp_path / "tcp").status == 0
    assert evenspin(*words, "--port", "sim:guo2024", "--out", tmp_path / "here").status == 0

    for name in ("load_step.csv", "validation_steps.csv", "meta.json"):
        assert (tmp_path / "tcp" / name).read_bytes() == (tmp_path / "here" / name).read_bytes(), name
    record = read_case(tmp_path / "tcp").experiments["load_step"]
    assert set(np.unique(record["load_torque_nm"]).round(3)) == {-0.135, 0.0, 0.135}  # half of the rated 0.27 N m


def test_lockstep_time_stands_still_unless_it_is_asked_for() -> None:
    with served(lockstep=True) as (_, note):
        with Drive.connect(note.port) as drive:
            before = drive.state().counter
            time.sleep(0.3)
            assert drive.state().counter - before < 200  # some passes for the answers, not 3000


def test_lockstep_waits_for_the_octets_that_were_sent_before() -> None:
    with served(lockstep=True) as (server, note):
        host, _, port = note.port.removeprefix("socket://").rpartition(":")
        with socket.create_connection((host, int(port))) as link:
            hand = ControlClient(note.control)
            asked = threading.Thread(target=hand.ask, args=({"do": "advance", "ms": 5, "octets": 3},))
            asked.start()
            asked.join(0.3)
            assert asked.is_alive() and server.drive.periods == 0

            link.sendall(b"\x00\x00\x00")
            asked.join(5.0)

            assert not asked.is_alive() and server.drive.periods == 50


@pytest.mark.parametrize("tcp", [True, False], ids=["tcp", "pty"])
def test_by_the_clock_a_motor_turns_and_a_stream_is_complete(tcp: bool) -> None:
    with served(tcp=tcp) as (server, note), Drive.connect(note.port) as drive:
        drive.run_speed(30.0)
        began_s = time.monotonic()
        with drive.stream(SIGNALS) as stream:
            values = stream.read_rows(1500)
        took_s = time.monotonic() - began_s

        assert stream.lost_rows == 0
        assert abs(values[-200:, 1].mean() - 30.0) < 1.0
        # 1500 rows at 1 kHz; a busy machine may take longer, never less
        assert 1.4 < took_s < 6.0 + server.behind_s


def test_capture_over_a_pseudo_terminal_is_complete() -> None:
    with served(tcp=False) as (_, note), Drive.connect(note.port) as drive:
        taken = drive.capture(SIGNALS, rows=drive.capture_rows(8))

        assert taken.values.shape == (drive.capture_rows(8), 8)
        assert np.isfinite(taken.values).all()


def test_a_pulled_cable_is_told_and_the_motor_stops() -> None:
    with served() as (server, note), Drive.connect(note.port) as drive:
        drive.run_speed(30.0)
        ControlClient(note.control).ask({"do": "unplug", "seconds": 30.0})

        with pytest.raises(LinkLostError, match="the link is lost"):
            for _ in range(100):
                drive.state()
                time.sleep(0.02)
        until_s = time.monotonic() + 5.0
        while server.drive.read("state") == State.RUN and time.monotonic() < until_s:
            time.sleep(0.02)
        assert server.drive.read("state") == State.READY


def test_a_stream_goes_on_after_the_cable_is_back_and_the_motor_stays_stopped() -> None:
    with served() as (_, note), Drive.connect(note.port, reconnect_s=20.0) as drive:
        drive.run_speed(30.0)
        with drive.stream(SIGNALS) as stream:
            stream.read_rows(100)
            ControlClient(note.control).ask({"do": "unplug", "seconds": 1.0})  # longer than the drive's timeout
            until_s = time.monotonic() + 20.0
            while not stream.reconnects and time.monotonic() < until_s:
                stream.read()

            assert stream.reconnects == 1
            assert len(stream.read_rows(50)) >= 50
        assert drive.state().state is State.READY


def test_several_threads_may_ask_at_once() -> None:
    with served() as (_, note), Drive.connect(note.port) as drive:
        wrong: list[object] = []

        def ask(name: str) -> None:
            for _ in range(20):
                if set(drive.get([name])) != {name} or drive.read((SIGNALS[1],)).keys() != {SIGNALS[1]}:
                    wrong.append(name)

        threads = [threading.Thread(target=ask, args=(name,)) for name in ("rc_gain", "pole_pairs", "iq_limit_a")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(20.0)

        assert not wrong
        assert not any(thread.is_alive() for thread in threads)


def test_the_only_drive_is_found_and_two_are_listed() -> None:
    with pytest.raises(NoDeviceError, match="evenspin drive --pty"):
        choose_port(None)
    with served() as (_, note):
        assert choose_port(None) == note.port
        with announced(replace(note, pid=os.getppid(), port="socket://127.0.0.1:1")):
            assert len(find_ports()) == 2
            with pytest.raises(NoDeviceError, match=r"2 drives were found, say which: .*127\.0\.0\.1:1"):
                choose_port(None)


def test_a_note_of_a_dead_drive_is_cleared_away() -> None:
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    with announced(Note(dead.pid, "/dev/pts/99", "127.0.0.1:1", "guo2024", "real")):
        assert running() == []


def test_a_second_client_does_not_disturb_the_first() -> None:
    with served() as (_, note), Drive.connect(note.port) as drive:
        with pytest.raises((NoDeviceError, LinkLostError)):
            Drive.connect(note.port)
        assert drive.state().state is State.READY


def test_the_bench_hand_refuses_what_it_does_not_know() -> None:
    with served() as (_, note):
        hand = ControlClient(note.control)
        for request, said in [
            ({"do": "dance"}, "do must be one of"),
            ({"do": "load"}, "torque_nm is missing"),
            ({"do": "load", "torque_nm": 1e9}, "load_torque_nm = 1e"),
            ({"do": "input", "name": "no_such", "value": 1}, "no such input"),
        ]:
            with pytest.raises(NoDeviceError, match=said):
                hand.ask(request)
        assert hand.ask({"do": "status"})["model"] == "guo2024"


def test_ctrl_c_stops_the_motor_and_keeps_the_recording(tmp_path: Path) -> None:
    with served() as (server, note):
        out = tmp_path / "recording"
        code = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        code += "from evenspin.cli import main; main(sys.argv[1:])"
        words = ["bench", "record", "--port", note.port, "--speed", "30", "--out", str(out)]
        command = subprocess.Popen([sys.executable, "-c", code, *words], stdout=subprocess.PIPE, text=True)
        until_s = time.monotonic() + 30.0
        while server.drive.read("state") != State.RUN and time.monotonic() < until_s:
            time.sleep(0.02)
        assert server.drive.read("state") == State.RUN
        time.sleep(0.3)

        command.send_signal(signal.SIGINT)

        assert command.wait(20.0) == 0
        assert server.drive.read("state") == State.READY
        assert (out / "recording.csv").stat().st_size > 1000
