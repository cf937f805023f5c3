"""What may arrive at the ports of a virtual drive: it goes on for everybody else, and its clock does not stop."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from evenspin.bench import Drive
from evenspin.bench.ports import virtual_drive
from evenspin.bench.transport import ControlClient
from evenspin.drive.server import Server

WAIT_S = 5.0
DEEP = b"[" * 30_000 + b"]" * 30_000


@pytest.fixture(autouse=True)
def own_registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))


@pytest.fixture
def server() -> Iterator[Server]:
    made = Server(virtual_drive("sim:guo2024"), address=("127.0.0.1", 0), lockstep=False, say=lambda _: None)
    thread = threading.Thread(target=made.run, daemon=True)
    thread.start()
    yield made
    alive = thread.is_alive()
    made.stop()
    thread.join(WAIT_S)
    assert alive, "something ended the drive"


def connect(address: str) -> socket.socket:
    host, _, port = address.removeprefix("socket://").rpartition(":")
    made = socket.create_connection((host, int(port)), timeout=WAIT_S)
    return made


def goes_on(server: Server) -> dict[str, object]:
    """Another client is answered, and the time of the drive moves."""
    hand = ControlClient(server.control)
    hand._socket.settimeout(WAIT_S)
    before = hand.ask({"do": "status"})
    until_s = time.monotonic() + WAIT_S
    while (now := hand.ask({"do": "status"}))["t_s"] <= before["t_s"]:
        assert time.monotonic() < until_s, "the clock of the drive stands"
        time.sleep(0.01)
    hand.close()
    return now


@pytest.mark.parametrize(
    "line",
    [
        b'{"do":[]}', b'{"do":{}}', b'{"do":null}', b"{}", b'{"do":"unplug","seconds":"x"}',
        b'{"do":"unplug","seconds":1e999}',
        b'{"do":"unplug","seconds":-1}', b'{"do":"unplug","seconds":NaN}', b'{"do":"unplug","seconds":[]}',
        b'{"do":"load","torque_nm":1e999}', b'{"do":"load","torque_nm":true}', b'{"do":"load","torque_nm":"1"}',
        b'{"do":"lock","on":"no"}', b'{"do":"loads","since":1e999}', b'{"do":"loads","since":"x"}',
        b'{"do":"input","name":[],"value":1}', b'{"do":"input","name":"dc_link_v","value":1e999}',
        b'{"do":"advance","ms":1e999,"octets":0}', b'{"do":' + b"9" * 5000 + b"}", b'{"do":' + DEEP + b"}", b'{"do":',
        b'{"do":"load","torque_nm":' + b"9" * 400 + b"}", b'{"\xff\xfe":1}',
    ],
)  # fmt: skip
def test_a_line_that_means_nothing_is_answered_with_an_error_and_the_next_one_is_done(
    server: Server, line: bytes
) -> None:
    with connect(server.control) as hand, hand.makefile("rb") as answers:
        hand.sendall(line + b"\n")
        assert "error" in json.loads(answers.readline())
        hand.sendall(b'{"do":"load","torque_nm":0.125}\n')
        assert "error" not in json.loads(answers.readline())
    assert goes_on(server)["load_torque_nm"] == 0.125


@pytest.mark.parametrize(
    "octets",
    [
        b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 32\r\n\r\n", b"GET / HTTP/1.1\r\n\r\n",
        b"OPTIONS * HTTP/1.1\r\n",
        b"\x16\x03\x01\x02\x00", b"hello\n", DEEP + b"\n", b"\r\n\r\nPUT /x HTTP/1.0\n", b"null\n", b"\x00",
    ],
)  # fmt: skip
def test_what_does_not_begin_with_an_object_is_hung_up_before_anything_is_done(server: Server, octets: bytes) -> None:
    with connect(server.control) as hand:
        began_s = time.monotonic()
        try:
            hand.sendall(octets + b'\n{"do":"load","torque_nm":0.25}\n')
            while hand.recv(1 << 16):
                pass
        except ConnectionError:
            pass
        assert time.monotonic() - began_s < 1.0
    assert goes_on(server)["load_torque_nm"] == 0.0


def test_a_line_without_an_end_is_cut_off(server: Server) -> None:
    with connect(server.control) as hand:
        with pytest.raises(ConnectionError):
            for _ in range(200):
                hand.sendall(b'{"do":"' + b"x" * 10_000)
                time.sleep(0.001)
        goes_on(server)


def test_a_client_that_reads_no_answers_costs_no_time_and_is_hung_up(server: Server) -> None:
    with connect(server.control) as hand:
        hand.settimeout(0.05)
        until_s = time.monotonic() + 3.0
        hung_up = False
        while not hung_up and time.monotonic() < until_s:
            try:
                hand.sendall(b'{"do":"status"}\n' * 1000)
            except TimeoutError:
                pass
            except ConnectionError:
                hung_up = True
        assert hung_up
        goes_on(server)
    assert server.behind_s < 2.0  # a busy machine may drop some; a drive that waits for a client drops all 3 s


def test_a_client_that_leaves_with_questions_open_leaves_the_drive_alone(server: Server) -> None:
    for _ in range(10):
        hand = connect(server.control)
        hand.sendall(b'{"do":"status"}\n' * 500)
        hand.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\x00\x00\x00\x00\x00\x00\x00")  # a reset, not an end
        hand.close()
    goes_on(server)


def test_many_requests_at_once_are_all_answered_in_their_order(server: Server) -> None:
    with connect(server.control) as hand, hand.makefile("rb") as answers:
        hand.sendall(b"".join(b'{"do":"load","torque_nm":%g}\n' % (k / 1000.0) for k in range(200)))
        periods = [json.loads(answers.readline())["period"] for _ in range(200)]
    assert periods == sorted(periods)
    assert goes_on(server)["load_torque_nm"] == 0.199


def test_a_browser_at_the_link_is_hung_up_and_the_client_after_it_is_served(server: Server) -> None:
    with connect(server.port) as browser:
        browser.sendall(b"POST / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        try:
            while browser.recv(1 << 16):
                pass
        except ConnectionError:
            pass
        with Drive.connect(server.port) as drive:
            assert drive.state().frames_bad == 0
