"""A recording replays bit for bit; what is damaged or of another firmware is refused; the first difference is named."""

from __future__ import annotations

import json
import re
import runpy
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
import evenspin as es
import replay_campaign
from evenspin.errors import EvenspinError
from evenspin.model.scenario import builtin_scenario
from evenspin.model.setup import InputCurve, Setup, Tune
from evenspin.recording import Part, RecordingFile
from evenspin.sim import Record, complete, prepare
from recordings import SIGNALS, play, record_run, rewritten, with_parameter
from said import Said

DEAD_AT_S = 0.52
KP = "speed_kp_a_per_unit"


def speed_run(duration_s: float = 0.6, **drive: float) -> Setup:
    """A short run of the paper's drive, every period in the log."""
    setup = builtin_scenario("guo2024/first").setup
    inputs = {
        "speed_ref_rad_s": InputCurve((0.0, 0.45), (15.0, 25.0), False),
        "load_brake_nm": InputCurve((0.0, 0.3), (0.02, 0.06), False),
    }
    return replace(
        setup, drive={**setup.drive, **drive}, inputs=inputs, tunes=(), duration_s=duration_s, log_rate_hz=setup.pwm_hz
    )


def with_dead_sensor(setup: Setup, at_s: float = DEAD_AT_S) -> Setup:
    return replace(setup, inputs={**setup.inputs, "current_a_gain": InputCurve((0.0, at_s), (1.0, 0.0), False)})


@pytest.fixture(scope="module")
def tripped(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Record]:
    """A drive whose current sensor dies."""
    path = tmp_path_factory.mktemp("replay") / "dead.replay"
    return path, record_run(with_dead_sensor(speed_run()), path)


def same(rows: np.ndarray, names: tuple[str, ...], log: Record) -> bool:
    return all(rows[:, k].tobytes() == log[name].tobytes() for k, name in enumerate(names))


def method(word: str) -> float:
    from evenspin.native import tables

    return float(tables().params["method"].choices.index(word))


@pytest.mark.parametrize("numeric", ["float", "fixed"])
@pytest.mark.parametrize("word", ["pi", "fal-forc", "aro"])
def test_every_signal_of_every_period_replays_bit_for_bit(word: str, numeric: str, tmp_path: Path) -> None:
    setup = speed_run(method=method(word))
    setup = replace(setup, tunes=(Tune(0.4, KP, 0.7 * setup.drive[KP]),))
    log = record_run(setup, tmp_path / "a.replay", numeric)
    player, rows = play(tmp_path / "a.replay")
    assert player.difference() is None
    assert len(rows) == len(log) == 6000
    assert same(rows, player.signals, log)
    assert np.ptp(log["speed_rad_s"]) > 10.0  # it did something


def test_a_recorded_run_is_the_run(tmp_path: Path) -> None:
    setup = speed_run(0.2)
    log = record_run(setup, tmp_path / "a.replay")
    assert complete(prepare(setup, SIGNALS), setup, SIGNALS).values.tobytes() == log.values.tobytes()


def test_what_the_observer_knew_and_a_search_for_the_index_replay(tmp_path: Path) -> None:
    setup = speed_run(0.5, method=method("aro"))
    cells = int(setup.drive["aro_cells"])
    table = [0.2 * np.sin(2.0 * np.pi * k / cells) for k in range(cells)]
    inputs = {
        **setup.inputs,
        "control_mode": InputCurve((0.0, 0.25), (1.0, 2.0), False),
        "position_ref_rad": InputCurve((0.0, 0.3), (0.0, 40.0), False),
        "home": InputCurve((0.0, 0.26), (0.0, 1.0), False),
    }
    log = record_run(replace(setup, inputs=inputs), tmp_path / "a.replay", memory=table)
    player, rows = play(tmp_path / "a.replay")
    assert player.difference() is None
    assert same(rows, player.signals, log)
    assert np.ptp(log["compensation_a"]) > 0.1


def test_the_replay_stops_at_the_fault_and_shows_what_the_log_has_around_it(tripped: tuple[Path, Record]) -> None:
    path, log = tripped
    replayed = es.replay_recording(path, before_s=0.02, after_s=0.003)
    first = int((log["fault"] > 0.0).argmax())
    assert replayed.fault is not None
    assert (replayed.fault.name, replayed.fault.period) == ("current_implausible", first)
    assert replayed.periods == first + 1 + 30
    assert not replayed.whole
    assert same(
        replayed.record.values[:, 1:], replayed.record.names[1:], log.between((first - 200) / 1e4, (first + 31) / 1e4)
    )
    whole = es.replay_recording(path, past_fault=True)
    assert (whole.periods, whole.whole, whole.fault) == (len(log), True, replayed.fault)
    early = es.replay_recording(path, until_s=0.1)
    assert (early.periods, early.fault) == (1000, None)
    with pytest.raises(EvenspinError, match="at most 0.6 s"):
        es.replay_recording(path, until_s=0.7, past_fault=True)


def test_every_damaged_octet_and_every_cut_is_refused_in_one_line(tripped: tuple[Path, Record], tmp_path: Path) -> None:
    octets = tripped[0].read_bytes()
    bad = tmp_path / "bad.replay"
    rng = np.random.default_rng(5)
    for at in [*range(24), *rng.integers(24, len(octets), 60), len(octets) - 1]:
        changed = bytearray(octets)
        changed[at] ^= 1 << int(rng.integers(8))
        bad.write_bytes(changed)
        with pytest.raises(EvenspinError, match=r"bad\.replay: recording = '(none|damaged|truncated)'") as error:
            es.replay_recording(bad, past_fault=True)
        assert "\n" not in str(error.value)
    for end in [0, 5, 19, 25, *rng.integers(26, len(octets), 20), len(octets) - 1]:
        bad.write_bytes(octets[:end])
        with pytest.raises(EvenspinError, match=r"recording = '(none|truncated)'"):
            es.replay_recording(bad, past_fault=True)
    bad.write_bytes(octets + b"\0")
    with pytest.raises(EvenspinError, match="damaged"):
        es.replay_recording(bad, past_fault=True)


def test_recordings_of_another_firmware_are_refused_by_name(tripped: tuple[Path, Record], tmp_path: Path) -> None:
    other = rewritten(tripped[0], tmp_path / "a.replay", lambda head: replace(head, firmware="0123456789ab"))
    with pytest.raises(EvenspinError, match=r"firmware = '0123456789ab'.*--other-firmware"):
        es.replay_recording(other)
    assert es.replay_recording(other, other_firmware=True).difference is None
    schema = rewritten(tripped[0], tmp_path / "b.replay", lambda head: replace(head, schema=head.schema ^ 1))
    with pytest.raises(EvenspinError, match="schema = .* of another firmware"):
        es.replay_recording(schema, other_firmware=True)
    trace = rewritten(tripped[0], tmp_path / "c.replay", lambda head: replace(head, trace=99))
    with pytest.raises(EvenspinError, match="trace = 'version 99'"):
        es.replay_recording(trace)
    double = rewritten(tripped[0], tmp_path / "d.replay", lambda head: replace(head, numeric="double"))
    with pytest.raises(EvenspinError, match="numeric = 'double': must be float or fixed"):
        es.replay_recording(double)
    fixed = rewritten(tripped[0], tmp_path / "e.replay", lambda head: replace(head, numeric="fixed"))
    found = es.replay_recording(fixed).difference  # the arithmetic rounds otherwise: the first difference says where
    assert found is not None and found.period < 10


@pytest.mark.parametrize("numeric", ["float", "fixed"])
def test_the_first_difference_is_where_two_drives_on_the_same_inputs_part(numeric: str, tmp_path: Path) -> None:
    """A drive with another gain: until its first other duty acts on the motor, its inputs are those of the recorded
    one, so two simulations say where the difference begins and how large it is."""
    setup = speed_run(0.3)
    was, gain = setup.drive[KP], 1.01 * setup.drive[KP]
    path = tmp_path / "a.replay"
    log = record_run(setup, path, numeric)
    other = replace(setup, drive={**setup.drive, KP: gain})
    now = complete(prepare(other, SIGNALS, numeric), other, SIGNALS)
    changed = rewritten(path, tmp_path / "b.replay", part=lambda part: with_parameter(part, KP, was, gain))
    found = es.replay_recording(changed).difference
    assert found is not None
    names = es.replay_recording(path).record.names[1:]
    differs = np.any([log[name] != now[name] for name in names], axis=0)
    first = int(differs.argmax())
    assert differs.any()
    assert found.period == first
    assert found.t_s == pytest.approx(first / 1e4)
    assert found.row_period is not None and 0 <= found.row_period - first < 10
    values = {name: (then, here) for name, then, here in found.values}
    assert values["iq_ref_a"][0] == log["iq_ref_a"][found.row_period]
    if found.row_period == first:
        assert values["iq_ref_a"][1] == now["iq_ref_a"][first]


def test_a_firmware_that_asks_for_something_else_is_named_with_what_it_asks_for(
    tripped: tuple[Path, Record], tmp_path: Path
) -> None:
    sample, clock = (_event(name) for name in ("hal_sample_read", "hal_clock_cyc"))

    def exchanged(part: Part) -> Part:
        order = bytearray(part.streams[0])
        at = order.index(bytes([sample]))
        order[at] = clock
        return replace(part, streams=(bytes(order), *part.streams[1:]))

    broken = rewritten(tripped[0], tmp_path / "a.replay", part=exchanged)
    found = es.replay_recording(broken).difference
    assert found is not None
    assert (found.kind, found.period) == ("ORDER", 0)
    assert found.text == "the firmware calls hal_sample_read, and calls hal_clock_cyc when it was recorded"


def test_an_interrupt_replays_inside_the_call_that_it_interrupted(tmp_path: Path) -> None:
    """A recording in which each pass of the main loop comes first and is interrupted where it asks for the fault of the
    hardware: in a steady run the pass and the interrupt do not touch each other, so nothing else may change."""
    path = tmp_path / "a.replay"
    record_run(speed_run(0.2), path)
    names = ("current_isr", "watch_isr", "speed_isr", "background", "hal_inverter_fault", "hal_sto", "period")
    isr, watch, speed, background, fault, sto, period = (re.escape(bytes([_event(name)])) for name in names)
    passes = re.compile(
        b"(%s[^%s]*?)(%s)(%s[^%s]*?)(%s)(%s.%s.)(?=%s)"
        % (isr, isr, watch, speed, background, background, fault, sto, period),
        re.DOTALL,
    )
    count = 0

    def nested(mark: bytes, part: Part) -> Part:
        nonlocal count
        order, count = passes.subn(lambda m: m[4] + mark + m[1] + mark + m[2] + mark + m[3] + m[5], part.streams[0])
        return replace(part, streams=(order, *part.streams[1:]))

    preempts = bytes([_event("preempts")])
    inside = rewritten(path, tmp_path / "b.replay", part=lambda part: nested(preempts, part))
    assert count > 100
    assert es.replay_recording(inside).difference is None
    without = es.replay_recording(rewritten(path, tmp_path / "c.replay", part=lambda part: nested(b"", part)))
    assert without.difference is not None
    assert without.difference.kind == "ORDER"


def test_random_octets_with_good_check_sums_end_in_a_difference(tripped: tuple[Path, Record], tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    for trial in range(40):

        def scrambled(part: Part, trial: int = trial) -> Part:
            streams = [bytearray(stream) for stream in part.streams]
            stream = streams[0 if trial % 2 else int(rng.integers(5))]
            # some words nobody reads: a third current, the angle of an index that is not passed again
            for at in rng.integers(0, len(stream), 8 + trial):
                stream[at] = int(rng.integers(256))
            return replace(part, streams=tuple(bytes(stream) for stream in streams))

        replayed = es.replay_recording(rewritten(tripped[0], tmp_path / "a.replay", part=scrambled), past_fault=True)
        assert replayed.difference is not None
        assert replayed.periods <= 6000


def _event(name: str) -> int:
    text = (Path(__file__).parents[2] / "sim_host" / "trace" / "events.def").read_text()
    names = [
        line.partition("(")[2].partition(",")[0]
        for line in text.splitlines()
        if line.startswith(("MARK", "ENTRY", "ASKED"))
    ]
    return names.index(name)


# ---- the command


SCENARIO = """
name = "dead"
model = "guo2024"
duration_s = 0.7
log_rate_hz = 1000.0
[[event]]
at_s = 0.0
speed_rpm = 200.0
[[event]]
at_s = 0.5
current_a_gain = 0.0
"""


def run_test(script: Path) -> None:
    """The tests of a file, as pytest calls them."""
    for name, function in runpy.run_path(str(script)).items():
        if name.startswith("test_"):
            function()


def test_run_replay_and_the_regression_test_that_it_writes(
    evenspin: Callable[..., Said], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("dead.toml").write_text(SCENARIO)
    ran = evenspin("run", "dead.toml", "--out", "out", "--record", "dead.replay")
    assert ran.status == 1, ran.err  # it trips
    reported = json.loads(Path("out", "summary.json").read_text())["fault"]
    replayed = evenspin("replay", "dead.replay", "--out", "fault", "--test", "dead", "--json")
    assert replayed.status == 0, replayed.err
    value = json.loads(replayed.out)
    assert value["fault"]["name"] == reported["name"]
    assert 0.0 <= reported["t_s"] - value["fault"]["t_s"] < 1e-3  # the log has a row per ms
    assert value["same"] is True
    assert Path("fault", "report.html").is_file()
    rows = np.genfromtxt("fault/signals.csv", delimiter=",", names=True)
    assert rows["fault"][-1] > 0.0
    assert rows["t_s"][-1] == pytest.approx(value["fault"]["t_s"] + 0.01)
    run_test(Path("test_dead.py"))
    assert Path("test_dead.replay").stat().st_size < Path("dead.replay").stat().st_size
    assert RecordingFile(Path("test_dead.replay")).length_s() == pytest.approx(value["t_s"])
    changed = rewritten(
        Path("test_dead.replay"), Path("other.replay"), part=lambda part: with_parameter(part, KP, 1.0, 1.5)
    )
    assert evenspin("replay", changed).status == 1
    changed.replace("test_dead.replay")
    with pytest.raises(AssertionError):
        run_test(Path("test_dead.py"))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["replay", "none.replay"], "none.replay: No such file or directory"),
        (["replay", "text.replay"], "text.replay: recording = 'none': must be a file .replay"),
        (["run", "guo2024/first", "--out", "out", "--record", "a.bin"], "--record = 'a.bin'"),
        (["drive", "--pty", "--record", "a.bin"], "--record = 'a.bin'"),
        (["replay", "text.replay", "--test", "No Name"], "--test = 'No Name'"),
    ],
)
def test_what_cannot_be_is_one_line_and_status_2(
    words: list[str], said: str, evenspin: Callable[..., Said], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("text.replay").write_text("speed,current\n")
    done = evenspin(*words)
    assert done.status == 2
    assert said in done.err
    assert done.err.count("\n") == 1


def test_random_driving_over_the_link_and_by_inputs_replays_without_a_difference() -> None:
    """The short version of `make replay-day`: some faults, both numerics, link and inputs."""
    outcomes = [replay_campaign.piece(seed, 6.0) for seed in range(1, 9)]
    assert [outcome.difference for outcome in outcomes] == [None] * len(outcomes)
    assert sum(outcome.periods for outcome in outcomes) > 200_000
    assert sum(sum(outcome.faults.values()) for outcome in outcomes) > 20
    kinds = {word for outcome in outcomes for word in outcome.text.split(", ")[1:]}
    assert kinds == {"float", "fixed", "link", "inputs"}
