"""The client against the very firmware, in lockstep: nothing here waits for a clock."""

from __future__ import annotations

import dataclasses
import random
import struct
from collections.abc import Iterator
from enum import IntEnum

import numpy as np
import pytest
from evenspin.bench import Drive, Info, Mode, State, Trigger, client
from evenspin.bench.errors import DriveFaultError, LinkLostError, NoDeviceError, ReadOnlyError, RefusedError
from evenspin.bench.messages import parse_list
from evenspin.bench.numbers import CaptureStatus
from evenspin.bench.schema import own_schema
from evenspin.drive import PERIODS_PER_MS, VirtualDrive
from evenspin.errors import InputError
from evenspin.native import load, tables

PORT = "sim:guo2024"
EIGHT = ("speed_ref_rad_s", "speed_rad_s", "theta_m_rad", "id_a", "iq_ref_a", "iq_a", "vd_v", "vq_v")
BOARD_BAUD = 625_000


@pytest.fixture
def drive() -> Iterator[Drive]:
    with Drive.connect(PORT) as connected:
        yield connected


def virtual(drive: Drive) -> VirtualDrive:
    return drive.link.transport.drive  # type: ignore[attr-defined]


def test_both_ends_make_the_same_hash_of_the_lists() -> None:
    assert own_schema().hash == load().lib.es_schema_hash()


def test_a_drive_says_what_it_is(drive: Drive) -> None:
    assert (drive.info.pwm_hz, drive.info.may_write, drive.info.numeric) == (10_000, True, "float")
    assert drive.state().state is State.READY
    assert drive.read(("vdc_v",))["vdc_v"] == pytest.approx(24.0, rel=1e-3)  # dc_link_v of the model


def test_every_parameter_reads_as_the_model_file_has_it(drive: Drive) -> None:
    values = drive.get()

    assert list(values) == list(tables().params)
    wanted = {name: field.default for name, field in tables().params.items()} | dict(virtual(drive).machine.drive)
    wanted["auto_run"] = 0.0  # a drive on a bench waits for the start command
    for name, value in wanted.items():
        assert values[name] == np.float32(value), name


def test_a_set_of_more_than_a_frame_is_taken_over_as_a_whole(drive: Drive) -> None:
    names = [name for name, field in drive.parameters.items() if name.startswith(("rdc_", "rc_", "aro_", "observer_"))]
    before = drive.get(names)
    assert len(before) > 40  # what a frame takes

    changed = {name: float(np.float32(0.9 * value)) for name, value in before.items() if 0.1 < value < 1.0}
    drive.set({**before, **changed})

    assert drive.get(names) == {**before, **changed}


def test_a_value_out_of_range_is_refused_with_its_limits_before_it_is_sent(drive: Drive) -> None:
    with pytest.raises(InputError, match=r"rc_gain = 40\.0: must be a number in 0 \.\. 10"):
        drive.set({"rc_lead": 3.0, "rc_gain": 40.0})
    with pytest.raises(InputError, match="rc_lead = 1.5: must be a whole number"):
        drive.set({"rc_lead": 1.5})

    assert drive.get(["rc_lead"]) == {"rc_lead": 5.0}


def test_the_drive_itself_refuses_too_and_names_the_parameter(drive: Drive, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "check_value", lambda field, value: None)

    with pytest.raises(RefusedError, match=r"rc_gain: the drive takes a number in 0 \.\. 10"):
        drive.set({"rc_lead": 3.0, "rc_gain": 40.0})

    assert drive.get(["rc_lead"]) == {"rc_lead": 5.0}  # none of the set


def test_a_misspelt_name_gets_a_suggestion(drive: Drive) -> None:
    with pytest.raises(InputError, match="did you mean rc_gain"):
        drive.set({"rc_gian": 0.4})
    with pytest.raises(InputError, match="did you mean speed_rad_s"):
        drive.read(("sped_rad_s",))


def test_the_motor_turns_at_the_speed_that_was_asked_for_and_stops(drive: Drive) -> None:
    drive.run_speed(30.0)
    drive.sleep(0.5)
    assert drive.state().state is State.RUN
    assert virtual(drive).read("true_speed_rad_s") == pytest.approx(30.0, abs=2.0)  # the model has a ripple of 5 %

    drive.stop()
    drive.sleep(0.01)
    assert drive.state().state is State.READY


def test_leaving_stops_the_motor_whatever_the_reason() -> None:
    with pytest.raises(KeyboardInterrupt):
        with Drive.connect(PORT) as drive:
            board = virtual(drive)
            drive.run_speed(30.0)
            raise KeyboardInterrupt

    board.advance(5)
    assert board.read("state") == State.READY


def test_a_client_that_dies_stops_the_motor_after_the_timeout(drive: Drive) -> None:
    drive.run_speed(30.0)
    board = virtual(drive)
    drive.sleep(2.0)
    assert board.read("state") == State.RUN  # signs of life go on while a program only waits

    board.advance(390)  # the last sign of life is 100 ms old at most
    assert board.read("state") == State.RUN
    board.advance(115)  # the 500 ms of docs/protocol.md, and some passes of the main loop

    assert board.read("state") == State.READY


def test_a_stop_is_not_followed_by_an_own_start(drive: Drive) -> None:
    drive.run_speed(30.0)
    virtual(drive).advance(600)  # the link was silent: the drive has stopped

    drive.sleep(0.5)

    assert drive.state().state is State.READY


def test_a_stream_shows_what_the_simulator_records(drive: Drive) -> None:
    virtual(drive).record(("t_s", *EIGHT))
    with drive.stream(EIGHT, rate_hz=2000.0) as stream:
        drive.run_speed(60.0)
        blocks = []
        while sum(len(block) for block in blocks) < 1000:
            block = stream.read()
            assert block is not None
            blocks.append(block)

    truth = virtual(drive).recorded()
    counters = np.concatenate([block.counters for block in blocks])
    rows = np.searchsorted(np.round(truth[:, 0] * 10_000).astype(int), counters)
    assert (np.diff(counters) == 5).all() and (counters % 5 == 0).all()
    np.testing.assert_array_equal(np.concatenate([block.values for block in blocks]), truth[rows, 1:])


def test_a_capture_of_8_signals_at_10_khz_is_what_the_simulator_records(drive: Drive) -> None:
    virtual(drive).record(("t_s", *EIGHT))
    rows = drive.capture_rows(8)
    assert rows >= 700
    drive.setpoint(Mode.SPEED, speed_rad_s=60.0)
    drive.arm_capture(EIGHT, rows=rows, pre=200, trigger=Trigger.RISING, signal_name="speed_rad_s", level=20.0)
    drive.start()
    taken = drive.read_capture()

    truth = virtual(drive).recorded()
    first = int(np.searchsorted(np.round(truth[:, 0] * 10_000).astype(int), taken.first))
    np.testing.assert_array_equal(taken.values, truth[first : first + rows, 1:])
    crossing = taken["speed_rad_s"]
    assert crossing[199] < 20.0 <= crossing[200]
    assert taken.t_s[200] == 0.0


@pytest.mark.parametrize(("signals", "rate_hz"), [(8, 1000.0), (12, 1000.0)])
def test_a_serial_line_carries_the_stream_without_a_loss_while_parameters_change(signals: int, rate_hz: float) -> None:
    names = (*EIGHT, "ia_a", "ib_a", "vdc_v", "id_ref_a")[:signals]
    with Drive.connect(f"{PORT}?baud={BOARD_BAUD}") as drive:
        drive.run_speed(30.0)
        with drive.stream(names, rate_hz=rate_hz) as stream:
            rows = 0
            for number in range(100):
                drive.set({"rc_gain": 0.5 + 0.001 * number})
                drive.sleep(0.1)
                while (block := stream.read(0.0)) is not None:
                    rows += len(block)
            now = drive.state()
        assert rows > 9900
        assert (stream.lost_rows, stream.lost_frames, now.stream_lost, now.octets_lost) == (0, 0, 0, 0)
        assert drive.link.bad_frames == now.frames_bad == 0


def test_a_line_that_is_too_slow_loses_rows_and_says_how_many() -> None:
    with Drive.connect(f"{PORT}?baud=115200") as drive, drive.stream(EIGHT, rate_hz=1000.0) as stream:
        for _ in range(200):
            stream.read()
        now = drive.state()

    assert stream.lost_rows > 0
    assert stream.lost_frames == 0  # dropped in the drive, not on the way
    assert now.stream_lost >= stream.lost_rows


def test_a_fault_comes_with_its_advice_and_the_last_samples(drive: Drive) -> None:
    drive.set({"over_speed_rad_s": 40.0})
    drive.setpoint(Mode.SPEED, speed_rad_s=40.0)
    drive.start()
    drive.sleep(1.0)  # overshoots

    advice = next(fault for fault in tables().faults if fault.name == "over_speed")
    with pytest.raises(DriveFaultError, match="over_speed"):
        drive.need_no_fault()
    report = drive.fault()
    assert (report.name, report.cause, report.check) == ("over_speed", advice.cause, advice.check)
    assert report.last_samples is not None
    speed = report.last_samples["speed_rad_s"]
    assert speed.max() > 40.0 > speed[0]
    assert report.last_samples.counters[-1] == pytest.approx(report.period, abs=len(speed))

    drive.set({"over_speed_rad_s": 650.0})
    drive.clear_fault()
    drive.sleep(0.01)
    assert drive.state().state is State.READY


def test_a_start_after_too_many_trips_says_when_it_is_allowed_again(drive: Drive) -> None:
    drive.set({"restart_limit": 1.0, "restart_window_s": 30.0})
    for _ in range(2):
        virtual(drive).set_input("encoder_error", 1.0)
        drive.sleep(0.01)
        virtual(drive).set_input("encoder_error", 0.0)
        drive.clear_fault()
        drive.sleep(0.01)
        try:
            drive.start()
        except DriveFaultError as error:
            said = str(error)
    assert said.startswith("restart_lockout (again in 30 s): More than restart_limit"), said
    assert drive.read(("restart_wait_s",))["restart_wait_s"] == pytest.approx(30.0, abs=5.0)


def test_a_start_into_a_fault_is_an_error_and_not_a_wait(drive: Drive) -> None:
    virtual(drive).set_input("dc_link_v", 5.0)
    drive.sleep(0.1)

    with pytest.raises((DriveFaultError, RefusedError)):
        drive.start()

    assert drive.fault(samples=False).name == "under_voltage"


def test_a_drive_of_another_schema_is_read_and_not_written(monkeypatch: pytest.MonkeyPatch) -> None:
    own = own_schema()
    fewer = {name: field for name, field in own.parameters.items() if name != "rc_gain"}
    other = dataclasses.replace(own, parameters=fewer)
    monkeypatch.setattr(client, "own_schema", lambda: other)

    with Drive.connect(PORT) as drive:
        assert not drive.info.may_write
        assert drive.get(["rc_gain"])["rc_gain"] == np.float32(0.6)
        assert drive.schema.hash == own.hash  # the lists came from the drive
        assert drive.schema.faults[1].check == own.faults[1].check
        with pytest.raises(ReadOnlyError, match=r"can only be read: .*other lists.*install the package"):
            drive.set({"rc_gain": 0.4})
        with pytest.raises(ReadOnlyError):
            drive.start()


def test_a_stop_at_once_also_disarms(drive: Drive) -> None:
    drive.run_speed(30.0)
    drive.stop_at_once()

    assert drive.state().state is State.READY
    with pytest.raises(RefusedError, match="not_armed"):
        drive.command("start")


def test_silence_is_no_device() -> None:
    drive = Drive.connect(PORT)
    transport = drive.link.transport
    transport.write = lambda octets: None  # type: ignore[method-assign]

    with pytest.raises(NoDeviceError, match="no answer to state, asked 4 times"):
        drive.state()
    assert NoDeviceError.exit_code == LinkLostError.exit_code == 3


@pytest.mark.parametrize(
    ("port", "said"),
    [
        ("sim:guo2025", "did you mean guo2024"),
        ("sim:guo2024?coging.order=3", "did you mean cogging"),
        ("sim:guo2024?cogging.order=x", "must be a number"),
        ("socket://here", "must be socket://HOST:PORT"),
        ("tcp://127.0.0.1:1", "must be a serial device, socket://HOST:PORT or sim:MODEL"),
    ],
)
def test_a_port_that_cannot_be_is_told(port: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        Drive.connect(port)


@pytest.mark.parametrize("port", ["socket://127.0.0.1:9", "/dev/no-such-port"])
def test_a_port_without_a_drive_is_no_device(port: str) -> None:
    with pytest.raises(NoDeviceError):
        Drive.connect(port)


def test_the_virtual_drive_is_the_same_again() -> None:
    def run() -> bytes:
        with Drive.connect(f"{PORT}?plant.current_noise_a=0.02&seed=7") as drive:
            drive.run_speed(30.0)
            with drive.stream(EIGHT) as stream:
                return stream.read_rows(300).tobytes()

    assert run() == run()


def test_time_passes_in_whole_passes_of_the_main_loop(drive: Drive) -> None:
    board = virtual(drive)
    before = board.periods
    drive.sleep(0.05)

    assert board.periods - before == pytest.approx(50 * PERIODS_PER_MS, abs=PERIODS_PER_MS)
    assert board.time_s == pytest.approx(board.periods / 10_000)


class NoisyLine:
    """Between the client and its transport: one octet in so many is damaged, both ways."""

    def __init__(self, drive: Drive, one_in: int) -> None:
        self.dice, self.one_in = random.Random(5), one_in
        inner = drive.link.transport
        write, read = inner.write, inner.read
        inner.write = lambda octets: write(self.damaged(octets))  # type: ignore[method-assign]
        inner.read = lambda timeout_s: self.damaged(read(timeout_s))  # type: ignore[method-assign]

    def damaged(self, octets: bytes) -> bytes:
        flips = (self.dice.randrange(1, 256) if self.dice.randrange(self.one_in) == 0 else 0 for _ in octets)
        return bytes(octet ^ flip for octet, flip in zip(octets, flips, strict=True))


def test_on_a_noisy_line_requests_are_asked_again_and_captures_are_right(drive: Drive) -> None:
    virtual(drive).record(("t_s", *EIGHT))
    drive.run_speed(30.0)
    NoisyLine(drive, one_in=4000)  # some of the longest frames, 1 in 16, are damaged

    for number in range(50):
        drive.set({"rc_gain": 0.01 * number})
        assert drive.get(["rc_gain"])["rc_gain"] == np.float32(0.01 * number)
    taken = drive.capture(EIGHT, rows=700)

    truth = virtual(drive).recorded()
    first = int(np.searchsorted(np.round(truth[:, 0] * 10_000).astype(int), taken.first))
    np.testing.assert_array_equal(taken.values, truth[first : first + 700, 1:])
    assert drive.link.bad_frames > 0
    assert drive.state().state is State.RUN


def test_on_a_noisy_line_a_stream_knows_its_gaps_and_shows_nothing_wrong(drive: Drive) -> None:
    virtual(drive).record(("t_s", *EIGHT))
    drive.run_speed(30.0)
    NoisyLine(drive, one_in=4000)
    with drive.stream(EIGHT, rate_hz=1000.0) as stream:
        blocks = [block for _ in range(300) if (block := stream.read()) is not None]

    assert stream.lost_frames > 0 and stream.lost_rows > 0
    counters = np.concatenate([block.counters for block in blocks])
    expected = (counters[-1] - counters[0]) // 10 + 1
    assert len(counters) == expected - sum(block.lost_before for block in blocks)
    truth = virtual(drive).recorded()
    rows = np.searchsorted(np.round(truth[:, 0] * 10_000).astype(int), counters)
    np.testing.assert_array_equal(np.concatenate([block.values for block in blocks]), truth[rows, 1:])


def test_the_fixed_point_drive_talks_the_same_and_turns_as_fast() -> None:
    with Drive.connect(f"{PORT}?numeric=fixed") as drive:
        assert drive.info.numeric == "fixed" and drive.info.may_write
        drive.run_speed(30.0)
        drive.sleep(0.5)
        assert virtual(drive).read("true_speed_rad_s") == pytest.approx(30.0, abs=2.0)


@pytest.mark.parametrize("length", range(0, 30))
def test_an_answer_that_is_cut_short_is_told(length: int) -> None:
    with pytest.raises(NoDeviceError, match="ends early"):
        Info.parse(bytes(length))


def test_a_limit_beyond_the_board_is_refused_with_value_and_maximum() -> None:
    with Drive.connect(PORT) as drive, pytest.raises(RefusedError) as refused:
        drive.set({"over_current_a": 1000.0})
    assert "over_current_a = 1000 A: the board allows at most 20 A" in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("name", "value", "reported"),
    [
        ("method", 2.0, "method = forc: cannot change from pi while the bridge is on; stop first"),
        ("encoder_counts", 16.0, "encoder_counts = 16: cannot change from 4000 while the bridge is on; stop first"),
        ("stall_s", 0.0, "stall_s = 0: cannot change from 0.08 while the bridge is on; stop first"),
    ],
)
def test_what_changes_at_rest_only_is_refused_while_it_runs_and_taken_after_a_stop(
    drive: Drive, name: str, value: float, reported: str
) -> None:
    before = drive.get([name])
    drive.run_speed(20.0)
    with pytest.raises(RefusedError) as refused:
        drive.set({name: value})
    assert reported in str(refused.value)
    assert drive.parameters[name].at_rest
    assert drive.state().state is State.RUN
    drive.stop()
    assert drive.set({name: value}) == {name: value}
    drive.set(before)


def test_a_setpoint_beyond_the_limits_in_force_is_refused_with_them(drive: Drive) -> None:
    with pytest.raises(RefusedError, match=r"speed_ref_rad_s: must be within -650 \.\. 650"):
        drive.setpoint(Mode.SPEED, speed_rad_s=700.0)
    with pytest.raises(RefusedError, match=r"iq_ref_a: must be within -8 \.\. 8"):
        drive.setpoint(Mode.CURRENT, id_a=6.0, iq_a=9.0)


def greeting(numeric: int) -> bytes:
    """An answer to hello as docs/protocol.md lays it out, of a drive without recorders and names."""
    return struct.pack("<HIBBIIH4H3BBHIBB", 1, 0, 0, numeric, 10_000, 200_000_000, 0, *[0] * 4, *[0] * 3, 0, 0, 0, 0, 0)


def test_a_number_format_that_only_a_later_firmware_knows_is_told_and_no_traceback() -> None:
    assert [Info.parse(greeting(numeric)).numeric for numeric in (0, 1)] == ["float", "fixed"]

    with pytest.raises(NoDeviceError, match=r"Numeric 2.*0 to 1.*install the package"):
        Info.parse(greeting(2))


@pytest.mark.parametrize("kind", [State, Mode, Trigger, CaptureStatus])
def test_a_state_that_only_a_later_firmware_knows_is_told_and_no_traceback(kind: type[IntEnum]) -> None:
    most = len(kind) - 1
    assert [int(kind(number)) for number in range(most + 1)] == list(range(most + 1))

    with pytest.raises(NoDeviceError, match=rf"{kind.__name__} {most + 1}.*0 to {most}.*install the package"):
        kind(most + 1)


def test_a_kind_of_parameter_that_only_a_later_firmware_knows_is_told_and_no_traceback() -> None:
    record = struct.pack("<BBfff", 4, 0, 0.0, 1.0, 0.5) + b"\x01a\x00\x00"

    with pytest.raises(NoDeviceError, match=r"Kind 4.*0 to 3.*install the package"):
        parse_list(0, 1, record)


@pytest.mark.parametrize("cause", ["watchdog", "pin"])
def test_after_a_reset_the_drive_says_what_was_before_it(drive: Drive, cause: str) -> None:
    drive.setpoint(Mode.SPEED, speed_rad_s=30.0)
    drive.start()
    drive.sleep(0.5)

    virtual(drive).reset(cause)
    drive.sleep(0.01)

    report = drive.fault()
    assert report.number == 0
    assert report.before_reset.startswith(f"before the last reset ({cause}): the drive was in run ")
    assert report.before_reset.endswith("no fault; the samples are its last ones")
    assert report.last_samples is not None
    np.testing.assert_allclose(report.last_samples["speed_ref_rad_s"], 30.0)
    np.testing.assert_allclose(report.last_samples["speed_rad_s"], 30.0, rtol=0.05)


def test_after_power_up_nothing_of_before_is_shown(drive: Drive) -> None:
    drive.setpoint(Mode.SPEED, speed_rad_s=30.0)
    drive.start()
    drive.sleep(0.5)

    virtual(drive).reset("power_up")
    drive.sleep(0.01)

    report = drive.fault()
    assert (report.number, report.before_reset, report.last_samples) == (0, "", None)
