"""`evenspin scope` on the command line: what is wrong is one line, and an end stops everything."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys

import pytest
from evenspin.drive.registry import Note, announced


def test_a_busy_port_is_wrong_usage_with_the_next_step(evenspin) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number = taken.getsockname()[1]
        said = evenspin("scope", "--port", "sim:guo2024", "--http-port", number)

    assert said.status == 2
    assert f"127.0.0.1:{number}" in said.err
    assert "--http-port 0 takes a free one" in said.err


@pytest.mark.parametrize(
    "port", ["sim:nobody", "http://127.0.0.1", "socket://nowhere", "sim:guo2024?cogging.amplitude=1"]
)
def test_a_port_that_can_never_be_one_is_wrong_usage(evenspin, port: str) -> None:
    said = evenspin("scope", "--port", port, "--http-port", 0)
    assert (said.status, said.out) == (2, "")
    assert said.err.splitlines()[-1].count("\n") == 0
    assert "Traceback" not in said.err


def test_a_drive_in_lockstep_is_refused_with_the_reason(evenspin) -> None:
    with announced(Note(os.getpid(), "socket://127.0.0.1:9", "127.0.0.1:9", "guo2024", "max")):
        said = evenspin("scope", "--port", "socket://127.0.0.1:9")
    assert said.status == 2
    assert "without --speed max" in said.err


def test_it_says_where_it_serves_and_ends_when_it_is_told() -> None:
    command = [sys.executable, "-c", "from evenspin.cli import main; main()", "scope"]
    words = ("--port", "sim:guo2024", "--http-port", "0")
    process = subprocess.Popen([*command, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    url = process.stdout.readline().strip()
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=10.0)

    assert url.startswith("http://127.0.0.1:")
    assert process.returncode == 0
    assert "Traceback" not in err
