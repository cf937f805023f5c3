"""What a recording does not tell is asked for, and what contradicts itself is said: never a confident wrong reading."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from evenspin.cli.main import main
from evenspin.errors import InputError
from evenspin.importer import Known, guess_map, import_table, read_map, read_table, write_map
from numpy.testing import assert_allclose
from recorded_drive import PAIRS, TURN, recorded, write_text

DRIVE = recorded()
Array = np.ndarray


def questions(path: Path, known: Known | None = None) -> str:
    return " | ".join(guess_map(read_table(path), known).questions)


def log_of(folder: Path, **columns: Array) -> Path:
    return write_text(folder / "log.csv", list(columns), list(columns.values()))


def refusal(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code in (1, 2)
    said = capsys.readouterr().err.strip()
    assert "Traceback" not in said and "\n" not in said
    return said


def test_rpm_under_rad_s_is_a_contradiction_that_names_what_it_looks_like(tmp_path: Path) -> None:
    asked = questions(log_of(tmp_path, t_s=DRIVE.t, iq_a=DRIVE.iq, speed_rad_s=DRIVE.rpm, angle_rad=DRIVE.theta))

    assert "rad/s and r/min exchanged" in asked


def test_degrees_under_rad_are_a_contradiction(tmp_path: Path) -> None:
    asked = questions(
        log_of(tmp_path, t_s=DRIVE.t, iq_a=DRIVE.iq, speed_rad_s=DRIVE.speed, angle_rad=np.degrees(DRIVE.theta))
    )

    assert "degrees and rad exchanged" in asked


def test_milliseconds_under_seconds_are_a_contradiction(tmp_path: Path) -> None:
    asked = questions(
        log_of(tmp_path, t_s=1e3 * DRIVE.t, iq_a=DRIVE.iq, speed_rad_s=DRIVE.speed, angle_rad=DRIVE.theta)
    )

    assert "ms and s exchanged" in asked


def test_an_angle_of_another_shaft_is_a_contradiction(tmp_path: Path) -> None:
    other = np.cumsum(np.cos(0.9 * DRIVE.t)) * 0.02

    asked = questions(log_of(tmp_path, t_s=DRIVE.t, iq_a=DRIVE.iq, speed_rad_s=DRIVE.speed, angle_rad=other))

    assert "not the rate of change" in asked


def test_all_that_is_open_is_asked_at_once(tmp_path: Path) -> None:
    asked = questions(log_of(tmp_path, speed=DRIVE.speed, force=DRIVE.iq * 0.0 + 1.0))

    assert "t_s" in asked and "iq_a" in asked and "speed_rad_s" in asked


def test_a_speed_without_unit_and_angle_is_asked_for(tmp_path: Path) -> None:
    assert "the unit of 'speed' is not printed" in questions(
        log_of(tmp_path, t_s=DRIVE.t, speed=DRIVE.rpm, iq=DRIVE.iq)
    )


def test_rad_and_degrees_with_their_own_speed_cannot_be_told_apart_without_a_name(tmp_path: Path) -> None:
    path = write_text(tmp_path / "log.csv", None, [DRIVE.t, DRIVE.iq, DRIVE.theta, DRIVE.speed])

    assert "may be in rad and rad/s; or deg and deg/s; or turn and turn/s" in questions(path)


def test_an_electrical_speed_without_pole_pairs_is_asked_for_and_taken_with_them(tmp_path: Path) -> None:
    path = log_of(tmp_path, time_s=DRIVE.t, erpm=PAIRS * DRIVE.rpm, iq=DRIVE.iq)

    assert "pole_pairs" in questions(path)
    known = Known(pole_pairs=PAIRS)
    assert questions(path, known) == ""
    table = read_table(path)
    assert_allclose(import_table(table, guess_map(table, known)).columns["speed_rad_s"], DRIVE.speed, atol=1e-4)


def test_two_columns_for_one_quantity_are_asked_for_unless_one_stands_still(tmp_path: Path) -> None:
    noise = DRIVE.iq + np.sin(31.0 * DRIVE.t)
    columns = {"t_s": DRIVE.t, "speed_rad_s": DRIVE.speed, "m1 Iq [A]": DRIVE.iq, "m2 Iq [A]": noise}

    assert "several columns" in questions(log_of(tmp_path, **columns))
    assert questions(log_of(tmp_path, **(columns | {"m2 Iq [A]": 0.0 * noise}))) == ""


def test_wrong_pole_pairs_are_contradicted_by_the_currents(tmp_path: Path) -> None:
    path = log_of(tmp_path, t_s=DRIVE.t, theta_m_rad=DRIVE.theta, speed_rad_s=DRIVE.speed, ia=DRIVE.ia, ib=DRIVE.ib)
    table = read_table(path)

    with pytest.raises(InputError, match=f"must be {PAIRS}, as often as the currents turn"):
        import_table(table, guess_map(table, Known(pole_pairs=PAIRS + 2)))


def test_exchanged_phases_are_contradicted_by_the_angle(tmp_path: Path) -> None:
    path = log_of(tmp_path, t_s=DRIVE.t, theta_m_rad=DRIVE.theta, speed_rad_s=DRIVE.speed, ia=DRIVE.ib, ib=DRIVE.ia)
    table = read_table(path)

    with pytest.raises(InputError, match="exchange two phases"):
        import_table(table, guess_map(table))


def test_a_current_of_the_wrong_sign_is_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = log_of(tmp_path, t=DRIVE.t, theta=DRIVE.theta, w=DRIVE.speed, iq=-DRIVE.iq)

    said = refusal(["log", "import", str(path), "--out", str(tmp_path / "out.csv")], capsys)

    assert "iq_a" in said and "opposite sign" in said
    assert not (tmp_path / "out.csv").exists()


def test_load_steps_that_brake_are_no_wrong_sign(tmp_path: Path) -> None:
    """A slow speed loop: the speed falls while the current rises."""
    rng = np.random.default_rng(5)
    load = np.repeat(rng.uniform(0.5, 3.0, 12), 500)
    speed, iq, history = 50.0, 0.0, []
    for torque in load:
        iq = 0.05 * (50.0 - speed) + 0.9995 * iq
        speed += 0.001 * (iq - torque) / 0.02
        history.append((speed, iq))
    w, i = np.array(history).T
    from evenspin.plausible.torque import current_is_reversed

    assert not current_is_reversed(DRIVE.t, w, i)
    assert not current_is_reversed(DRIVE.t, DRIVE.speed, DRIVE.iq)
    assert current_is_reversed(DRIVE.t, DRIVE.speed, -DRIVE.iq)


def test_a_map_that_was_written_reads_the_file_the_same_way(tmp_path: Path) -> None:
    path = log_of(tmp_path, time_us=1e6 * DRIVE.t, theta_e=np.mod(DRIVE.theta_e, TURN), rpm=DRIVE.rpm, iq=DRIVE.iq)
    table = read_table(path)
    guessed = guess_map(table)
    (tmp_path / "MAP.toml").write_text(write_map(guessed, path))

    again = import_table(table, read_map(tmp_path / "MAP.toml"))

    for name, values in import_table(table, guessed).columns.items():
        assert_allclose(again.columns[name], values, rtol=0.0, atol=0.0)


def test_a_corrected_map_is_obeyed(tmp_path: Path) -> None:
    path = log_of(tmp_path, t=DRIVE.t, theta=DRIVE.theta, w=DRIVE.speed, x=-2.0 * DRIVE.iq - 0.5)
    (tmp_path / "MAP.toml").write_text(
        '[columns]\nt_s = "t"\ntheta_m_rad = {from = 2, unit = "rad"}\n'
        'iq_a = {from = "x", unit = "A", offset = 0.5, scale = -0.5}\n'
    )

    found = import_table(read_table(path), read_map(tmp_path / "MAP.toml"))

    assert_allclose(found.columns["iq_a"], DRIVE.iq, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[columns]\niq_x = "a"\n', "iq_x"),
        ('[columns]\niq_a = {from = "x", unit = "furlong"}\n', "furlong"),
        ('[columns]\niq_a = {from = "x", unit = "rpm"}\n', "a unit of current"),
        ('[columns]\niq_a = {from = "x", scale = 0}\n', "scale"),
        ('pole_pairs = 2.5\n[columns]\niq_a = "x"\n', "pole_pairs"),
        ('speed = 3\n[columns]\niq_a = "x"\n', "speed"),
        ("[columns]\n", "columns"),
        ("columns = [", "TOML"),
    ],
)
def test_a_wrong_map_is_one_line_that_names_the_key(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "MAP.toml"
    path.write_text(text)

    with pytest.raises(InputError) as error:
        read_map(path)

    assert said in str(error.value)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("empty.csv", b""),
        ("words.csv", b"a,b\nc,d\ne,f\n"),
        ("one.csv", b"t\n1\n2\n3\n"),
        ("binary.bin", bytes(range(256)) * 20),
        ("broken.parquet", b"PAR1" + bytes(100)),
        ("broken.mat", b"MATLAB 5.0 MAT-file" + bytes(200)),
        ("broken.mf4", b"MDF     4.10" + bytes(300)),
        ("broken.tdms", b"TDSm" + bytes(60)),
        ("broken.mcap", b"\x89MCAP0\r\n" + bytes(60)),
        ("broken.npz", b"PK\x03\x04" + bytes(50)),
        ("cut.csv.gz", b"\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\x03abc"),
        ("bad_cell.csv", b"t,w,iq\n" + b"0,1,2\n" * 5 + b"0,x,2\n" + b"0,1,2\n" * 5),
        ("sheet.xlsx", b"PK\x03\x04"),
    ],
)
def test_a_file_that_is_no_table_is_one_line(
    name: str, content: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    path.write_bytes(content)

    said = refusal(["log", "import", str(path), "--out", str(tmp_path / "out.csv")], capsys)

    assert name in said
    assert not (tmp_path / "out.csv").exists()


def test_gap_reads_a_foreign_log_and_writes_how(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = log_of(
        tmp_path,
        **{
            "Time [ms]": 1e3 * DRIVE.t,
            "Speed [rpm]": DRIVE.rpm,
            "Iq [A]": DRIVE.iq,
            "Pos [deg]": np.degrees(DRIVE.theta),
        },
    )

    main_or_exit(["gap", str(path), "--out", str(tmp_path / "out"), "--json"])

    verdict = json.loads(capsys.readouterr().out)
    assert verdict["parameters"] is not None or verdict
    assert (tmp_path / "out/log.csv").is_file()
    assert read_map(tmp_path / "out/MAP.toml").columns["speed_rad_s"].unit == "rpm"


def test_log_map_writes_what_is_open_as_a_comment_and_exits_with_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = log_of(tmp_path, t_s=DRIVE.t, speed=DRIVE.rpm, iq=DRIVE.iq)

    said = refusal(["log", "map", str(path), "--out", str(tmp_path / "MAP.toml")], capsys)

    assert "speed_rad_s" in said
    assert "TO DECIDE: speed_rad_s" in (tmp_path / "MAP.toml").read_text()


def main_or_exit(words: list[str]) -> None:
    try:
        main(words)
    except SystemExit as ended:
        assert ended.code in (0, None)


def test_a_model_file_tells_the_pole_pairs_and_counts_that_a_recording_leaves_open(tmp_path: Path) -> None:
    path = log_of(
        tmp_path,
        **{
            "t_ms": 1e3 * DRIVE.t,
            "erpm": PAIRS * DRIVE.rpm,
            "iq": DRIVE.iq,
            "Position [counts]": DRIVE.theta * 4096 / TURN,
        },
    )
    model = tmp_path / "model.toml"
    plant = {"pole_pairs": PAIRS, "psi_wb": 0.02, "viscous_nms": 1e-5, "counts_per_rev": 4096}
    model.write_text('name = "m"\n[plant]\n' + "".join(f"{key} = {value}\n" for key, value in plant.items()))

    main_or_exit(["gap", str(path), "--model", str(model), "--out", str(tmp_path / "out")])

    read = read_map(tmp_path / "out/MAP.toml")
    assert (read.pole_pairs, read.counts_per_turn) == (PAIRS, 4096)
    log = np.genfromtxt(tmp_path / "out/log.csv", delimiter=",", names=True)
    assert_allclose(log["speed_rad_s"], DRIVE.speed, atol=1e-4)


def test_a_map_may_name_a_column_as_it_stands_in_the_header(tmp_path: Path) -> None:
    path = log_of(tmp_path, **{"Time [s]": DRIVE.t, "Torque current [A]": DRIVE.iq, "Velocity [rad/s]": DRIVE.speed})
    (tmp_path / "map.toml").write_text(
        '[columns]\nt_s = {from = "Time [s]", unit = "s"}\niq_a = {from = "Torque current [A]", unit = "A"}\n'
        'speed_rad_s = {from = "Velocity [rad/s]", unit = "rad/s"}\n'
    )

    assert_allclose(
        import_table(read_table(path), read_map(tmp_path / "map.toml")).columns["iq_a"], DRIVE.iq, atol=1e-6
    )


def test_an_angle_that_starts_again_after_the_range_of_a_protocol_is_no_count(tmp_path: Path) -> None:
    """A CAN protocol sends rad within +-12.5, which is no whole number of turns, and the number of the motor."""
    position = np.mod(DRIVE.theta + 12.5, 25.0) - 12.5
    path = log_of(
        tmp_path,
        **{
            "time [s]": DRIVE.t,
            "motor_id": np.full(len(DRIVE.t), 3.0),
            "position": position,
            "velocity [rad/s]": DRIVE.speed,
            "iq": DRIVE.iq,
        },
    )

    table = read_table(path)
    mapping = guess_map(table)

    assert mapping.questions == ()
    assert mapping.columns["theta_m_rad"].unit == "rad"
    assert "id_a" not in mapping.columns
    found = import_table(table, mapping).columns["theta_m_rad"]
    assert_allclose(found - found[0], DRIVE.theta - DRIVE.theta[0], atol=0.02)


@pytest.mark.parametrize("known", [None, Known(pole_pairs=7)], ids=["no model", "a model"])
def test_rows_between_which_the_electrical_angle_goes_round_more_than_half_are_followed_by_the_speed(
    known: Known | None, tmp_path: Path
) -> None:
    """200 rows per second, 240 Hz of the currents."""
    pairs, drive = 7, recorded(8000, 200.0)
    theta, speed = 5.0 * drive.theta, 5.0 * drive.speed  # up to 240 rad/s
    theta_e = np.angle(np.exp(1j * pairs * theta))
    log = {"time [s]": drive.t, "phase": theta_e, "velocity [rad/s]": speed, "iq": drive.iq, "id": 0.01 * drive.iq}
    table = read_table(log_of(tmp_path, **log))

    mapping = guess_map(table, known) if known else guess_map(table)

    assert mapping.questions == ()
    assert mapping.pole_pairs == pairs
    imported = import_table(table, mapping)
    found = imported.columns["theta_m_rad"]
    assert_allclose(found - found[0], theta - theta[0], atol=1e-3)  # five places in the file
    assert any("taken from the speed" in note for note in imported.notes)


def test_an_angle_of_another_shaft_is_not_made_to_follow_the_speed(tmp_path: Path) -> None:
    drive = recorded(8000, 200.0)
    other = np.angle(np.exp(1j * (300.0 * drive.t**1.1)))
    log = {"time [s]": drive.t, "phase": other, "velocity [rad/s]": 5.0 * drive.speed, "iq": drive.iq}

    assert "do they belong to one shaft?" in questions(log_of(tmp_path, **log))
