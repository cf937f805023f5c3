"""What the bench writes: configurations, raw recordings, captures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from evenspin.bench import Drive
from evenspin.bench.config import config_toml, differences, read_config, shortest
from evenspin.bench.raw import RawWriter, read_raw
from evenspin.bench.stream import Block
from evenspin.errors import InputError

PORT = "sim:guo2024"


def write_raw(path: Path, blocks: int) -> None:
    with RawWriter(path, ("a", "b"), ("A", "V"), 10, 10_000.0, "test") as raw:
        for number in range(blocks):
            values = np.full((5, 2), number, dtype=np.float32)
            raw.write(Block(50 * number, 10, 10_000.0, values, lost_before=2 if number == 3 else 0))


def test_a_raw_recording_reads_back(tmp_path: Path) -> None:
    path = tmp_path / "raw.mcap"
    write_raw(path, 10)

    found = read_raw(path)

    assert found.whole and found.lost_rows == 2 and found.source == "test"
    assert found.record.names == ("t_s", "a", "b") and found.record.units == ("s", "A", "V")
    np.testing.assert_allclose(found.record["t_s"], 0.001 * np.arange(50))
    np.testing.assert_array_equal(found.record["b"], np.repeat(np.arange(10.0), 5))


@pytest.mark.parametrize("part", [0.4, 0.6, 0.8, 0.95])
def test_a_recording_that_breaks_off_is_read_as_far_as_it_goes(tmp_path: Path, part: float) -> None:
    path = tmp_path / "raw.mcap"
    write_raw(path, 200)
    octets = path.read_bytes()
    path.write_bytes(octets[: int(part * len(octets))])

    found = read_raw(path)

    assert not found.whole
    blocks = len(found.record) // 5
    assert part * 200 - 12 < blocks <= 1.05 * part * 200  # behind the last block comes an index
    np.testing.assert_array_equal(found.record["a"], np.repeat(np.arange(float(blocks)), 5))


def test_what_is_no_recording_is_told(tmp_path: Path) -> None:
    path = tmp_path / "raw.mcap"
    path.write_bytes(b"not mcap at all, but long enough to be read as something")
    with pytest.raises(InputError, match="must be an MCAP file"):
        read_raw(path)
    with pytest.raises(InputError, match="must be an existing file"):
        read_raw(tmp_path / "nothing.mcap")


def test_a_configuration_goes_out_and_back_without_a_difference(tmp_path: Path) -> None:
    path = tmp_path / "drive.toml"
    with Drive.connect(PORT) as drive:
        path.write_text(config_toml(drive))
        assert differences(read_config(path, drive), drive) == []

        drive.set({"rc_gain": 0.4, "method": 2.0})
        found = {d.field.name: (d.file, d.drive) for d in differences(read_config(path, drive), drive)}
        assert found == {"rc_gain": (0.6, float(np.float32(0.4))), "method": (0.0, 2.0)}

        drive.set({name: values[0] for name, values in found.items()})
        assert differences(read_config(path, drive), drive) == []
    text = path.read_text()
    assert "current_kp_v_per_a = 0.6 # V/A" in text and 'method = "pi"' in text


@pytest.mark.parametrize("value", [0.1, 0.6, 1e-6, 142122.0, 7.06e-5, 0.0, -1.5])
def test_the_shortest_number_is_the_same_in_single_precision(value: float) -> None:
    assert shortest(float(np.float32(value))) == value


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("rc_gain = 0.6", "rc_gain = 60.0", r"drive\.toml:\d+: drive\.rc_gain = 60\.0: must be a number in 0 \.\. 10"),
        ("rc_gain = 0.6", "rc_gian = 0.6", "did you mean rc_gain"),
        ('method = "pi"', 'method = "pid"', 'must be "pi" or "crc"'),
        ("rc_lead = 5", "rc_lead = 5.5", "must be a whole number"),
        ("auto_run = false", "auto_run = 2", "must be true or false"),
    ],
)
def test_a_wrong_configuration_changes_nothing(evenspin, tmp_path: Path, old: str, new: str, said: str) -> None:
    path = tmp_path / "drive.toml"
    assert evenspin("bench", "config", "pull", path, "--port", PORT).status == 0
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))

    with Drive.connect(PORT) as drive, pytest.raises(InputError, match=said):
        read_config(path, drive)
    assert evenspin("bench", "config", "push", path, "--port", PORT).status == 2


def test_a_file_of_another_firmware_needs_force(evenspin, tmp_path: Path) -> None:
    path = tmp_path / "drive.toml"
    path.write_text('[schema]\nhash = "00000000"\n\n[drive]\nrc_gain = 0.4\n')

    refused = evenspin("bench", "config", "push", path, "--port", PORT)
    assert refused.status == 2 and "--force" in refused.err
    forced = evenspin("bench", "config", "push", path, "--port", PORT, "--force", "--json")
    assert forced.status == 0
    assert json.loads(forced.out) == {"rc_gain": {"file": 0.4, "drive": 0.6}}
    assert evenspin("bench", "config", "diff", path, "--port", PORT).status == 1


def test_a_capture_is_a_csv_around_its_trigger(evenspin, tmp_path: Path) -> None:
    path = tmp_path / "capture.csv"
    words = ("--signal", "iq_a", "--signal", "speed_rad_s", "--rows", 300, "--pre", 50, "--trigger", "iq_a>1")
    said = evenspin("bench", "capture", "--port", PORT, *words, "--speed", 30, "--out", path)

    assert said.status == 0
    rows = np.genfromtxt(path, delimiter=",", names=True)
    assert len(rows) == 300
    assert rows["t_s"][50] == 0.0 and rows["t_s"][0] == pytest.approx(-0.005)
    assert rows["iq_a"][49] < 1.0 <= rows["iq_a"][50]


def test_a_recording_is_a_folder_with_raw_and_csv(evenspin, tmp_path: Path) -> None:
    out = tmp_path / "recording"
    said = evenspin("bench", "record", "--port", PORT, "--speed", 30, "--seconds", 1, "--out", out, "--json")

    assert said.status == 0
    assert json.loads(said.out)["lost_rows"] == 0
    assert {path.name for path in out.iterdir()} == {"manifest.json", "raw.mcap", "recording.csv"}
    assert len(read_raw(out / "raw.mcap").record) >= 1000
    assert not list(tmp_path.glob("*.mcap"))


def test_a_recording_begins_behind_the_alignment_of_a_first_start(evenspin, tmp_path: Path) -> None:
    """The rotor that an alignment turns is another motion, of seconds; at first it rests, and then it follows."""
    model, out = tmp_path / "m.toml", tmp_path / "recording"
    model.write_text('name = "m"\nbase = "guo2024"\n[drive]\nalign_periods = 20000\n')
    said = evenspin("bench", "record", "--port", f"sim:{model}", "--speed", 30, "--seconds", 1, "--out", out)
    assert said.status == 0, said.err

    rows = np.genfromtxt(out / "recording.csv", delimiter=",", names=True)
    assert abs(rows["speed_rad_s"][0]) < 0.5
    assert (rows["speed_ref_rad_s"][100:] == 30.0).all()
    assert rows["speed_rad_s"][-300:].mean() == pytest.approx(30.0, abs=0.5)


def test_the_folder_of_a_recording_is_taken_as_its_log_or_said_to_be_no_case(evenspin, tmp_path: Path) -> None:
    out = tmp_path / "recording"
    assert evenspin("bench", "record", "--port", PORT, "--speed", 30, "--seconds", 3, "--out", out).status == 0

    assert "recording.csv: --torque-per-a-nm" in evenspin("identify", "friction", out).err
    assert "case = 'a recording'" in evenspin("compare", out).err
    assert "case = 'a file'" in evenspin("compare", out / "recording.csv").err
    assert evenspin("gap", out, "--model", "guo2024", "--out", tmp_path / "gap").status == 0


@pytest.mark.parametrize("words", [("info",), ("get", "rc_gain"), ("fault",), ("watch", "--seconds", 0.2)])
def test_json_is_alone_on_stdout(evenspin, words: tuple) -> None:
    said = evenspin("bench", *words, "--port", PORT, "--json")

    assert said.status == 0
    for line in said.out.splitlines() if words[0] == "watch" else [said.out]:
        json.loads(line)


def test_no_drive_is_exit_status_3(evenspin, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    said = evenspin("bench", "info", "--port", "socket://127.0.0.1:9")

    assert said.status == 3
    assert said.err.count("\n") == 1 and "evenspin drive" in said.err


def test_a_short_soak_loses_nothing_and_a_slow_line_fails(evenspin) -> None:
    good = evenspin("bench", "soak", "--port", f"{PORT}?baud=625000", "--seconds", 20, "--json")
    assert good.status == 0
    assert json.loads(good.out)["lost_rows"] == 0 and json.loads(good.out)["rows"] >= 20_000

    assert evenspin("bench", "soak", "--port", f"{PORT}?baud=115200", "--seconds", 2).status == 1
