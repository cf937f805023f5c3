"""Logs as they come: each fault is one clear line, or a repair that is said."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

import balance_recordings as recordings
import numpy as np
import pytest
from evenspin.balance.log_reader import read_log
from evenspin.errors import InputError

ROWS = 2000


def log(**changes: np.ndarray | None) -> dict[str, np.ndarray]:
    """Two seconds of a complete log, with these columns changed or left out."""
    t_s = 1e-3 * np.arange(ROWS)
    columns = {
        "t_s": t_s,
        "theta_m_rad": 6.0 * t_s,
        "speed_rad_s": 6.0 - 0.05 * np.cos(40.0 * t_s),  # one that stands in every row would be a dead channel
        "iq_a": 0.1 + 0.01 * np.sin(40.0 * t_s),
    }
    columns.update({name: value for name, value in changes.items() if value is not None})
    return {name: value for name, value in columns.items() if name not in changes or changes[name] is not None}


def renamed(old: str, new: str) -> dict[str, np.ndarray]:
    return {new if name == old else name: value for name, value in log().items()}


def refusal(path: Path, columns: dict[str, np.ndarray]) -> str:
    with pytest.raises(InputError) as error:
        read_log(recordings.write(path, columns))
    text = str(error.value)
    assert "\n" not in text
    return text


def test_a_sound_log_needs_no_repair(tmp_path: Path) -> None:
    found = read_log(recordings.write(tmp_path / "log.csv", log()))

    assert found.repairs == ()
    assert len(found.t_s) == ROWS
    assert found.period_s == pytest.approx(1e-3)


def test_compressed_and_plain_logs_read_alike(tmp_path: Path) -> None:
    plain = recordings.write(tmp_path / "log.csv", log())
    packed = tmp_path / "log.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))

    assert np.array_equal(read_log(plain).iq_a, read_log(packed).iq_a)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("speed_rad_s", "speed_rpm"),
        ("speed_rad_s", "speed"),
        ("theta_m_rad", "theta_deg"),
        ("theta_m_rad", "theta_rad"),
        ("t_s", "t_ms"),
        ("t_s", "time"),
        ("iq_a", "iq_ma"),
    ],
)
def test_a_column_of_another_unit_is_refused_with_the_expected_name(tmp_path: Path, old: str, new: str) -> None:
    text = refusal(tmp_path / "log.csv", renamed(old, new))

    assert f"'{new}'" in text
    assert old in text
    assert "convert" in text


@pytest.mark.parametrize("name", ["t_s", "iq_a"])
def test_a_missing_column_is_named(tmp_path: Path, name: str) -> None:
    assert f"with {name}" in refusal(tmp_path / "log.csv", log(**{name: None}))


def test_a_log_without_angle_and_speed_is_refused(tmp_path: Path) -> None:
    text = refusal(tmp_path / "log.csv", log(theta_m_rad=None, speed_rad_s=None))

    assert "theta_m_rad or speed_rad_s" in text


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("theta_m_rad", "what repeats with the angle is not identifiable"),
        ("speed_rad_s", "come from the angle alone"),
        ("speed_ref_rad_s", "no closed loop is simulated"),
    ],
)
def test_what_a_missing_column_costs_is_said(tmp_path: Path, name: str, said: str) -> None:
    found = read_log(recordings.write(tmp_path / "log.csv", log(**{name: None})))

    assert any(name in text and said in text for text in found.limits)


def test_three_samples_are_too_few(tmp_path: Path) -> None:
    text = refusal(tmp_path / "log.csv", {name: value[:3] for name, value in log().items()})

    assert "rows = 3" in text
    assert "at least" in text


def test_an_empty_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t_s,iq_a,speed_rad_s\n")

    with pytest.raises(InputError, match="rows = 0"):
        read_log(path)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="existing file"):
        read_log(tmp_path / "log.csv")


def test_a_last_line_that_is_cut_off_is_left_out_and_said(tmp_path: Path) -> None:
    path = recordings.write(tmp_path / "log.csv", log())
    path.write_text(path.read_text().rstrip("\n")[:-15])

    found = read_log(path)

    assert len(found.t_s) == ROWS - 1
    assert any("cut off" in text for text in found.repairs)


def test_a_compressed_file_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    plain = recordings.write(tmp_path / "log.csv", log())
    packed = tmp_path / "log.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes())[:-2000])

    with pytest.raises(InputError, match="complete .gz"):
        read_log(packed)


def test_a_line_that_is_too_short_in_the_middle_is_named(tmp_path: Path) -> None:
    path = recordings.write(tmp_path / "log.csv", log())
    lines = path.read_text().splitlines()
    lines[100] = lines[100].rsplit(",", 1)[0]
    path.write_text("\n".join(lines) + "\n")

    with pytest.raises(InputError, match=r"log.csv:101: columns = 3"):
        read_log(path)


def test_a_word_in_a_cell_is_named(tmp_path: Path) -> None:
    path = recordings.write(tmp_path / "log.csv", log())
    lines = path.read_text().splitlines()
    lines[7] = "0.006,oops,6.0,0.1"
    path.write_text("\n".join(lines) + "\n")

    with pytest.raises(InputError, match=r"log.csv:8: cell = 'oops'"):
        read_log(path)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_rows_that_are_not_numbers_are_left_out_and_said(tmp_path: Path, bad: float) -> None:
    iq_a = log()["iq_a"].copy()
    iq_a[500:510] = bad

    found = read_log(recordings.write(tmp_path / "log.csv", log(iq_a=iq_a)))

    assert len(found.t_s) == ROWS - 10
    assert any("10 of 2000" in text and "line 502" in text for text in found.repairs)
    assert len(found.gaps_s) == 1  # eleven milliseconds without a row are a gap


def test_empty_cells_are_not_numbers(tmp_path: Path) -> None:
    path = recordings.write(tmp_path / "log.csv", log())
    lines = path.read_text().splitlines()
    lines[10] = lines[10].rsplit(",", 1)[0] + ","
    path.write_text("\n".join(lines) + "\n")

    assert len(read_log(path).t_s) == ROWS - 1


def test_a_log_of_mostly_nan_is_refused(tmp_path: Path) -> None:
    iq_a = log()["iq_a"].copy()
    iq_a[: ROWS // 2] = np.nan

    assert "1000 of 2000" in refusal(tmp_path / "log.csv", log(iq_a=iq_a))


def test_repeated_rows_and_steps_back_in_time_are_left_out_and_said(tmp_path: Path) -> None:
    t_s = log()["t_s"].copy()
    t_s[300] = t_s[299]
    t_s[400] = t_s[390]

    found = read_log(recordings.write(tmp_path / "log.csv", log(t_s=t_s)))

    assert len(found.t_s) == ROWS - 2
    assert np.all(np.diff(found.t_s) > 0.0)
    assert any("repeats or goes back" in text for text in found.repairs)


def test_a_gap_in_time_is_said_and_kept_apart(tmp_path: Path) -> None:
    t_s = log()["t_s"].copy()
    t_s[1000:] += 0.05

    found = read_log(recordings.write(tmp_path / "log.csv", log(t_s=t_s)))

    assert found.gaps_s == pytest.approx(np.array([[0.999, 1.05]]))
    assert any("1 gaps in time" in text for text in found.repairs)


def test_a_time_in_milliseconds_is_suspected(tmp_path: Path) -> None:
    text = refusal(tmp_path / "log.csv", log(t_s=np.arange(ROWS, dtype=float)))

    assert "milliseconds" in text


def test_a_wrapped_angle_reads_like_an_unwrapped_one(tmp_path: Path) -> None:
    theta = log()["theta_m_rad"]

    found = read_log(recordings.write(tmp_path / "log.csv", log(theta_m_rad=np.remainder(theta, 2.0 * np.pi))))

    assert found.theta_m_rad == pytest.approx(theta, abs=1e-5)
    assert any("unwrapped" in text for text in found.repairs)


def test_turns_of_a_wrapped_angle_in_a_gap_are_counted_with_the_speed(tmp_path: Path) -> None:
    t_s = log()["t_s"].copy()
    t_s[1000:] += 3.0  # almost three turns
    theta = 6.0 * t_s

    columns = log(t_s=t_s, theta_m_rad=np.remainder(theta, 2.0 * np.pi))
    found = read_log(recordings.write(tmp_path / "log.csv", columns))

    assert found.theta_m_rad == pytest.approx(theta, abs=1e-5)


def test_a_column_twice_is_refused(tmp_path: Path) -> None:
    path = recordings.write(tmp_path / "log.csv", log())
    path.write_text(path.read_text().replace("theta_m_rad", "iq_a", 1))

    with pytest.raises(InputError, match="once"):
        read_log(path)


@pytest.mark.parametrize(
    "garble",
    [
        lambda text: text[: len(text) // 3],
        lambda text: text.replace(",", ";"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text + "\n\n",
        lambda text: "",
        lambda text: "\x00" * 100,
    ],
    ids=["third", "semicolons", "byte order mark", "crlf", "empty lines", "nothing", "zeros"],
)
def test_whatever_the_file_is_the_answer_is_a_log_or_one_line(tmp_path: Path, garble: Callable[[str], str]) -> None:
    path = recordings.write(tmp_path / "log.csv", log())
    path.write_text(garble(path.read_text()), encoding="utf-8")

    try:
        assert len(read_log(path).t_s) >= 500
    except InputError as error:
        assert "\n" not in str(error)
