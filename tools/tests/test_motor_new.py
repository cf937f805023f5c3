"""`evenspin motor new`: a name plate, in its own units, becomes a model and a drive that run."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import pytest
from evenspin.errors import InputError
from evenspin.model import load_machine
from evenspin.motor.flux import flux_of
from evenspin.motor.plate import Plate
from evenspin.motor.questions import answers
from evenspin.motor.resolve import resolve

# Teknic M-2310P-LN-04K: 8 poles, 0.72 ohm, 0.4 mH and 4.64 V peak per 1000 r/min between terminals, 1000 lines.
TEKNIC = "--poles 8 --ohm-ll 0.72 --mh-ll 0.4 --ke 4.64 --ke-as ll-peak --lines 1000 --supply 24".split()
TEKNIC += "--rated-current 7.1 --peak-current 15 --currents peak --kgcm2 0.0706 --rated-torque 0.27".split()


def plate(**changes: Any) -> Plate:
    fields = {
        "pole_pairs": 4,
        "psi_wb": 6.4e-3,
        "counts": 4000,
        "supply": 24.0,
        "rated_current": 5.0,
        "currents": "rms",
    }
    return Plate(**{name: value for name, value in (fields | changes).items() if value is not None})


def test_the_data_sheet_of_a_motor_gives_the_model_that_its_maker_describes(evenspin, tmp_path: Path) -> None:
    """Against the model of the same motor that comes with the package; its numbers are those of a phase."""
    said = evenspin("motor", "new", "mine", *TEKNIC, "--out", tmp_path / "mine")
    assert said.status == 0, said.err
    found = load_machine(tmp_path / "mine" / "model.toml").plant
    known = load_machine(Path(load_machine.__code__.co_filename).parents[1] / "data/models/teknic2310p.toml").plant
    for name in (
        "pole_pairs",
        "resistance_ohm",
        "ld_h",
        "lq_h",
        "psi_wb",
        "inertia_kgm2",
        "counts_per_rev",
        "dc_link_v",
    ):
        assert found[name] == pytest.approx(known[name], rel=2e-3), name  # Ke is printed with three digits


@pytest.mark.parametrize(
    ("given", "psi_wb"),
    [
        # 1000 r/min = 104.72 rad/s; p = 4; phase peak = p psi w = 2.681 V
        ({"ke": 2.681, "ke_as": "phase-peak"}, 6.4e-3),
        ({"ke": 2.681 / math.sqrt(2.0), "ke_as": "phase-rms"}, 6.4e-3),
        ({"ke": 2.681 * math.sqrt(1.5), "ke_as": "ll-rms"}, 6.4e-3),
        ({"kt": 0.0384, "currents": "peak"}, 6.4e-3),  # 1.5 p psi
        ({"kt": 0.0384 * math.sqrt(2.0), "currents": "rms"}, 6.4e-3),
        ({"kv": 215.3}, 6.4e-3),  # Kt = 8.27 / Kv, the figure that drone motors are converted with
    ],
)
def test_every_constant_of_a_data_sheet_is_the_same_flux(given: dict[str, Any], psi_wb: float) -> None:
    found = flux_of(plate(psi_wb=None, **given), 4)
    assert found[0].psi_wb == pytest.approx(psi_wb, rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"kv": 215.3 * 1.3}, ("--psi-wb", "--kv", "factor")),
        ({"kt": 0.0384}, ("--kt", "rms against peak")),  # that is the number per peak ampere
        ({"poles": 4}, ("--poles", "--pole-pairs")),
        ({"peak_current": 4.0}, ("--peak-current 4 A is below --rated-current",)),
        ({"lines": 4000}, ("--counts 4000", "--lines 4000", "four counts")),
        ({"counts": 48}, ("48 counts per turn", "lines instead of counts")),
        ({"rated_torque": 1.0}, ("--rated-torque", "torque constant times")),
        ({"rated_speed": 9000.0}, ("--rated-speed", "--supply")),
        ({"ohm_ll": 0.36, "ohm_phase": 0.36}, ("--ohm-ll", "--ohm-phase", "in series")),
        ({"board_current": 5.0}, ("--board-current", "peak of --rated-current")),
        ({"gcm2": 70.6, "kgcm2": 0.706}, ("--gcm2", "--kgcm2")),
    ],
)
def test_numbers_that_contradict_each_other_are_both_named(changes: dict[str, Any], words: tuple[str, ...]) -> None:
    found = resolve(plate(**changes)).contradictions
    assert any(all(word in line for word in words) for line in found), found


def test_a_plate_without_contradiction_has_none() -> None:
    given = {"kv": 215.3, "kt": 0.0384 * math.sqrt(2.0), "ohm_ll": 0.72, "mh_ll": 0.4, "gcm2": 70.6, "kgcm2": 0.0706}
    assert resolve(plate(poles=8, lines=1000, rated_torque=0.27, peak_current=10.0, **given)).contradictions == ()


def test_a_contradiction_writes_nothing(evenspin, tmp_path: Path) -> None:
    said = evenspin("motor", "new", "x", *TEKNIC, "--kv", "100", "--out", tmp_path / "x")
    assert said.status == 2
    assert len(said.err.splitlines()) == 1 and "--kv" in said.err and "nothing was written" in said.err
    assert not (tmp_path / "x").exists()


def test_what_is_missing_is_listed_with_the_options_that_give_it(evenspin, tmp_path: Path) -> None:
    said = evenspin("motor", "new", "x", "--supply", "24", "--out", tmp_path / "x")
    assert said.status == 2
    for word in ("--pole-pairs", "--ke", "--lines", "--rated-current", "evenspin commission"):
        assert word in said.err
    assert "--supply," not in said.err


def test_estimates_hold_their_value_and_are_marked(evenspin, tmp_path: Path) -> None:
    said = evenspin("motor", "new", "x", *TEKNIC[:-4], "--out", tmp_path / "x", "--json")
    assert said.status == 0, said.err
    answer = json.loads(said.out)
    assert answer["estimated"] == ["inertia_kgm2", "viscous_nms"]
    inertia = answer["plant"]["inertia_kgm2"]
    assert inertia["low"] < 7.06e-6 < inertia["high"]  # the true one, which the plate did not say
    text = (tmp_path / "x" / "model.toml").read_text()
    assert "ESTIMATE" in next(line for line in text.splitlines() if line.startswith("inertia_kgm2"))
    assert "ESTIMATE" not in next(line for line in text.splitlines() if line.startswith("psi_wb"))


def test_the_files_run_as_they_are(evenspin, tmp_path: Path) -> None:
    """The review's motor: with the default gains it tripped within 3.5 ms."""
    words = "--pole-pairs 7 --psi-wb 5e-3 --ohm-phase 0.1 --mh-phase 0.05 --kgm2 5e-5 --counts 4096 --supply 24"
    made = evenspin("motor", "new", "m", *words.split(), "--rated-current", "5", "--out", tmp_path / "m")
    assert made.status == 0, made.err
    said = evenspin("run", tmp_path / "m" / "first.toml", "--out", tmp_path / "run", "--json")
    assert said.status == 0, said.err
    steady = json.loads(said.out)["segments"][-1]
    assert steady["speed_mean_rpm"] == pytest.approx(steady["speed_ref_rpm"], rel=2e-3)


def test_the_limits_are_of_this_motor_and_its_board(evenspin, tmp_path: Path) -> None:
    said = evenspin(
        "motor", "new", "x", *TEKNIC, "--board-current", "18", "--board-voltage", "32", "--out", tmp_path / "x"
    )
    assert said.status == 0, said.err
    drive = tomllib.loads((tmp_path / "x" / "drive.toml").read_text())["drive"]
    assert 15.0 / 1.35 <= drive["iq_limit_a"] < drive["over_current_a"] <= 18.0
    assert 24.0 < drive["over_voltage_v"] <= 32.0
    assert drive["under_voltage_v"] < 24.0


def test_questions_take_number_and_unit_in_one_answer() -> None:
    replies = iter(["8 poles", "24", "5", "", "", "", "", "", "4,64 V/krpm", "0.36 phase", "", "x", "70.6 g cm^2", "",
                    "1000 lines", "", "", "peak", "ll-peak"])  # fmt: skip
    messages: list[str] = []
    found = answers(lambda text: next(replies), messages.append)
    assert found == {
        "poles": 8.0, "supply": 24.0, "rated_current": 5.0, "ke": 4.64, "ohm_phase": 0.36, "gcm2": 70.6,
        "lines": 1000.0, "currents": "peak", "ke_as": "ll-peak",
    }  # fmt: skip
    assert len(messages) == 1 and "kgcm2" in messages[0]  # what was wrong with "x"


@pytest.mark.parametrize(("field", "value"), [("kt", float("nan")), ("supply", -24.0), ("bits", 17.5), ("ohm_ll", 0.0)])
def test_impossible_numbers_are_refused_with_their_option(field: str, value: float) -> None:
    with pytest.raises(InputError) as refused:
        plate(**{field: value})
    assert f"--{field.replace('_', '-')}" in str(refused.value)


def test_a_model_says_in_which_range_a_number_is_known(tmp_path: Path) -> None:
    text = (Path(load_machine.__code__.co_filename).parents[1] / "data/models/guo2024.toml").read_text()
    path = tmp_path / "m.toml"
    path.write_text(text + "\n[range]\npsi_wb = [6e-3, 7e-3]\n")
    assert load_machine(path).ranges == {"psi_wb": (6e-3, 7e-3)}
    path.write_text(text + "\n[range]\npsi_wb = [7e-3, 8e-3]\n")
    with pytest.raises(InputError, match=r"range.psi_wb.*between"):
        load_machine(path)


def test_a_drive_file_comes_below_the_model_and_above_the_defaults(tmp_path: Path) -> None:
    source = Path(load_machine.__code__.co_filename).parents[1] / "data/models/servo.toml"
    (tmp_path / "d.toml").write_text("[schema]\nhash = '1'\n[drive]\nrc_gain = 0.25\niq_limit_a = 3.0\n")
    path = tmp_path / "m.toml"
    path.write_text('drive_file = "d.toml"\n' + source.read_text())
    drive = load_machine(path).drive
    assert (drive["rc_gain"], drive["iq_limit_a"]) == (0.25, 8.0)
    path.write_text('drive_file = "gone.toml"\n' + source.read_text())
    with pytest.raises(InputError, match="drive_file"):
        load_machine(path)
