"""Every figure of the three papers: its number, its picture with the printed numbers in it, and an honest verdict."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from evenspin.errors import InputError
from evenspin.report.figures import Picture
from evenspin.reproduce.guo2024.figures import GALLERY as GUO
from evenspin.reproduce.paper import Figure, Gallery, Statement, at_most, printed_number, printed_reduction
from evenspin.reproduce.paper_page import table_of, write_markdown
from evenspin.reproduce.tang2020.figure_pictures import transfer
from evenspin.reproduce.tang2020.figures import GALLERY as TANG
from evenspin.reproduce.yeh2024 import figures as yeh
from evenspin.reproduce.yeh2024.figures import GALLERY as YEH

DOCS = Path(__file__).parents[2] / "docs" / "reference"
# Counted in the papers: figures without a letter, those of which the parts are asked for, and how many there are.
ALL_NUMBERS = {
    "guo2024": {str(n) for n in range(1, 32)},
    "tang2020": {str(n) for n in range(1, 15) if n != 9} | {"9a", "9b", "9c", "9d", "9e", "9f"},
    "yeh2024": {str(n) for n in range(1, 17)},
}
GALLERIES = [GUO, TANG, YEH]


@pytest.mark.parametrize("gallery", GALLERIES, ids=lambda gallery: gallery.paper)
def test_every_figure_of_a_paper_is_drawn_once_or_said_to_show_no_data(gallery: Gallery) -> None:
    drawn = [number for figure in gallery.figures for number in figure.numbers]

    assert len(drawn) == len(set(drawn))
    assert set(drawn) | set(gallery.no_data) == ALL_NUMBERS[gallery.paper]
    assert not set(drawn) & set(gallery.no_data)


@pytest.mark.parametrize("gallery", GALLERIES, ids=lambda gallery: gallery.paper)
@pytest.mark.parametrize("number", ["99", "1", "", "a", "9z"])
def test_an_unknown_figure_is_refused_with_those_that_exist_and_those_without_data(
    gallery: Gallery, number: str
) -> None:
    with pytest.raises(InputError) as caught:
        gallery.find(number)

    text = str(caught.value)
    assert len(text.splitlines()) == 1
    assert "block diagram: 1, 2" in text and "photograph: " in text
    shown = re.search(r"one of ([^;]*);", text)
    assert shown is not None
    numbers = shown[1].split(", ")
    assert set(numbers) == {n for figure in gallery.figures for n in figure.numbers}
    assert [int(re.sub(r"\D", "", n)) for n in numbers] == sorted(int(re.sub(r"\D", "", n)) for n in numbers)


def test_a_figure_with_parts_is_found_by_its_number_and_by_its_letters() -> None:
    assert [figure.numbers for figure in TANG.find("9")] == [("9a", "9c", "9d", "9e"), ("9b",), ("9f",)]
    assert [figure.numbers for figure in TANG.find("9d")] == [("9a", "9c", "9d", "9e")]
    assert [figure.numbers for figure in GUO.find("18")] == [("17", "18", "23")]


# ---- verdicts


@pytest.mark.parametrize(("ours", "holds"), [(3.99, False), (4.01, True), (5.99, True), (6.01, False)])
def test_a_number_holds_within_a_fifth_of_the_printed_one(ours: float, holds: bool) -> None:
    assert printed_number("x", ours, 5.0).holds is holds


@pytest.mark.parametrize(("ours", "holds"), [(0.75, False), (0.81, True), (1.5, True), (2.39, True), (2.41, False)])
def test_between_a_printed_simulation_and_an_experiment_everything_holds(ours: float, holds: bool) -> None:
    assert printed_number("x", ours, 2.0, 1.0).holds is holds


@pytest.mark.parametrize(("ours", "holds"), [(84.9, False), (85.1, True), (94.9, True), (95.1, False)])
def test_a_reduction_holds_within_five_points(ours: float, holds: bool) -> None:
    assert printed_reduction("x", ours, 90.0).holds is holds


def test_a_limit_holds_up_to_it_and_a_number_that_is_none_holds_nowhere() -> None:
    assert at_most("x", 1.0, 1.0).holds and not at_most("x", 1.01, 1.0).holds
    assert not any(
        each.holds
        for each in (printed_number("x", np.nan, 1.0), printed_reduction("x", np.nan, 1.0), at_most("x", np.nan, 1.0))
    )


def every_statement(figures, result) -> list[Statement]:
    return [each for figure in figures for each in figure.says(result)]


def test_table_3_is_in_the_figures_and_what_differs_has_a_reason(float_result) -> None:
    found = {each.what: each for each in every_statement(GUO.figures, float_result.runs)}

    assert [each.what for each in found.values() if not each.holds and not each.reason] == []
    assert found["pi at 255 rpm: speed, 1st order [%]"].theirs == "4.89 / 4.34"
    assert found["forc at 255 rpm: q current, 2nd order [%]"].theirs == "0.130 / 0.500"
    assert found["fal-forc at 150 rpm: overshoot at the start [rpm]"].theirs == "35.0 / 29.0"
    known = {what: each.holds for what, each in found.items()}
    assert known["pi at 255 rpm: speed, 1st order [%]"]
    assert not known["forc at 150 rpm: overshoot at the start [rpm]"]  # 40, paper 71 and 95
    assert not known["1200 rpm: 2nd order of the q current, PI / FORC [%]"]  # the printed Q does not reach it


def test_what_a_figure_says_is_what_was_run(float_result) -> None:
    slower = [run for run in float_result.runs if run.set_name == "second"]

    assert every_statement(GUO.find("24"), slower) == []
    assert GUO.find("24")[0].draw(slower) is None
    assert len(every_statement(GUO.find("28"), slower)) == 5


# ---- pictures


def test_the_spectra_of_guo_have_the_printed_numbers_at_their_bars(float_result) -> None:
    picture = GUO.find("26")[0].draw(float_result.runs)
    panels = json.loads(picture.chart)["panels"]
    marks = {
        (panel["title"][:3], line["label"]): line
        for panel in panels
        for line in panel["lines"]
        if line["kind"] == "points"
    }

    assert marks["150", "paper, experiment"]["y"] == [11.8, 5.8]
    assert marks["255", "paper, simulation"]["y"] == [4.89, 3.1, 0.51, 0.71, 0.03, 0.09]
    assert marks["203", "paper, experiment"]["y"] == [1.12, 0.74, 0.17, 0.16]
    bars = {line["label"]: line["x"] for line in panels[0]["lines"] if line["kind"] == "bars"}
    assert marks["150", "paper, experiment"]["x"] == bars["PI"][:2]


def test_the_overshoots_of_guo_have_the_printed_peaks(float_result) -> None:
    panels = json.loads(GUO.find("30")[0].draw(float_result.runs).chart)["panels"]

    levels = [[line["y"][0] for line in panel["lines"] if line["label"].startswith("paper")] for panel in panels]
    assert levels == [[], [221.0, 245.0, 185.0, 179.0], [196.0, 176.0]]


@pytest.fixture(scope="module")
def silc():
    return yeh.gather(YEH.find("10"), "float", lambda _: None)


def test_a_polar_picture_shows_the_whole_of_turn_1_and_the_printed_largest_errors(silc) -> None:
    picture = YEH.find("10")[0].draw(silc)
    shown = picture.data["20rpm_turn1_error_mrad"]

    assert np.abs(shown).max() == pytest.approx(1e3 * silc.run("silc", 20.0).row["max_turn1"], rel=0.01)
    assert picture.data["20rpm_paper_max_turn1_mrad"] == pytest.approx(65.64)
    assert picture.data["10rpm_paper_max_turn10_mrad"] == pytest.approx(1.011)
    assert "paper: MAX of the turn" in picture.svg


def test_only_what_a_figure_needs_is_run(silc) -> None:
    assert {run.method for run in silc.runs} == {"silc"}
    assert YEH.find("12")[0].draw(silc) is None and YEH.find("6")[0].draw(silc) is None


def test_turns_by_rms_have_the_printed_reductions_in_their_titles(silc) -> None:
    svg = YEH.find("9")[0].draw(silc).svg

    assert "paper -43 %" in svg and "paper -97 %" in svg


def test_the_largest_error_of_turn_1_is_counted_from_both_starts(silc) -> None:
    row = silc.run("silc", 10.0).row

    assert row["max_turn1_from_0"] > 3.0 * row["max_turn1"]  # the whole lag of 105 mrad, and its rest after 0.1 s
    assert row["max_turn1"] == pytest.approx(105e-3 * np.exp(-10.0 * 0.12), rel=0.25)  # k_pp = 10 1/s
    assert row["max_reduction_pct"] == pytest.approx(100.0 * (1.0 - row["max_turn10"] / row["max_turn1_from_0"]))


def test_a_wrong_inertia_scales_the_torque_that_is_seen_and_the_right_one_only_delays_it() -> None:
    """J s / (J s) far above the corner B / J = 0.7 Hz: the factor itself; with the right J one sample of delay."""
    f_hz = np.array([20.0, 40.0])

    assert np.abs(transfer(2.0, f_hz)) == pytest.approx([2.0, 2.0], rel=2e-3)
    assert np.abs(transfer(0.5, f_hz)) == pytest.approx([0.5, 0.5], rel=2e-3)
    assert transfer(1.0, f_hz) == pytest.approx(np.exp(-2j * np.pi * f_hz * 1e-4), rel=1e-9)


# ---- pages


@pytest.mark.parametrize("gallery", GALLERIES, ids=lambda gallery: gallery.paper)
def test_the_page_has_every_figure_its_picture_and_a_reason_where_it_differs(gallery: Gallery) -> None:
    page = (DOCS / f"{gallery.paper}-figures.md").read_text(encoding="utf-8")

    for figure in gallery.figures:
        assert f"## {figure.label}: " in page
        assert f"evenspin reproduce {gallery.paper} --figure {figure.numbers[0]} " in page
        assert f"({gallery.paper}-figures/{figure.name}.svg)" in page
    for number, what in gallery.no_data.items():
        assert f"| {number} | {what} |" in page
    verdicts = re.findall(r"\| (holds|differs: .+) \|$", page, re.MULTILINE)
    assert len(verdicts) == len(re.findall(r"^\| (?!what|figure|-|\d+ \|)", page, re.MULTILINE)) > 10
    files = {path.name for path in (DOCS / f"{gallery.paper}-figures").iterdir()}
    assert files == {f"{figure.name}.svg" for figure in gallery.figures}


@pytest.mark.parametrize("gallery", GALLERIES, ids=lambda gallery: gallery.paper)
def test_every_picture_of_a_page_is_svg_with_a_background_and_not_large(gallery: Gallery) -> None:
    for path in (DOCS / f"{gallery.paper}-figures").iterdir():
        svg = path.read_text(encoding="utf-8")
        assert ElementTree.fromstring(svg).tag.endswith("svg")
        assert re.search(r"(?:fill: ?|fill=\")#ffffff", svg), f"{path.name} would be dark on dark"
        assert len(svg) < 250_000


def made_up(reason: str = "it is made up") -> Gallery:
    svg = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0.123456 1.98765"/><text>0.00123</text></svg>'
    picture = Picture("p", "P", "A picture.", svg, {"x": [1.0]})
    says = [Statement("a | b", "1", "2", False, reason), Statement("c", "1", "1", True)]
    return Gallery("made-up", (Figure(("1", "2"), "something", lambda _: picture, lambda _: says),), {"3": "diagram"})


def test_a_page_is_written_over_itself_and_over_nothing_else(tmp_path: Path) -> None:
    page = tmp_path / "made-up-figures.md"
    write_markdown(page, made_up(), None, "Made up", "Text.")
    write_markdown(page, made_up(), None, "Made up", "Text.")

    text = page.read_text(encoding="utf-8")
    assert "| a \\| b | 1 | 2 | differs: it is made up |" in text and "Of 2 1 hold" in text
    svg = (tmp_path / "made-up-figures" / "figure_1_2.svg").read_text(encoding="utf-8")
    assert 'd="M0.1 1.9"' in svg and "0.00123" in svg

    page.write_text("mine", encoding="utf-8")
    for place in (page, tmp_path / "none" / "x.md", tmp_path / "x.txt"):
        with pytest.raises(InputError):
            write_markdown(place, made_up(), None, "Made up", "Text.")
    assert page.read_text(encoding="utf-8") == "mine"


def test_the_table_marks_what_differs() -> None:
    view = table_of(made_up(), made_up().figures, None)

    assert [row[0] for row in view.rows] == ["1, 2", "1, 2"]
    assert list(view.marks) == ["bad", "good"]


# ---- the command


def test_one_figure_is_drawn_into_its_folder(evenspin, tmp_path: Path) -> None:
    said = evenspin("reproduce", "tang2020", "--figure", "14", "--out", tmp_path / "out")

    assert said.status == 0, said.err
    assert [path.name for path in (tmp_path / "out" / "figures").glob("*.svg")] == ["figure_14.svg"]
    assert "12th order [dB]" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        (("guo2024", "--figure", "5", "--out", "x"), "block diagram"),
        (("guo2024", "--figure", "4"), "--out"),
        (("yeh2024", "--figure", "9", "--out", "x", "--method", "silc"), "--method"),
        (("tang2020", "--figure", "14", "--out", "x", "--numeric", "both"), "--numeric"),
        (("tang2020", "--page", "x.md", "--out", "x"), "--out"),
        (("tang2020", "--page", "x.html"), "--page"),
        (("tang2020", "--page", "x.md", "--figure", "14"), "--page"),
    ],
)
def test_figures_with_what_they_do_not_use_are_refused_in_one_line(
    evenspin, tmp_path, monkeypatch, words, reported
) -> None:
    monkeypatch.chdir(tmp_path)
    said = evenspin("reproduce", *words)

    assert (said.status, said.out, said.err.count("\n")) == (2, "", 1)
    assert reported in said.err
    assert list(tmp_path.iterdir()) == []
