"""Pictures and pages: complete in themselves, true to their numbers, the same every time."""

import re

import numpy as np
import pytest
from evenspin.model import load_scenario
from evenspin.report.curves import envelope
from evenspin.report.figures import Curve, pictures
from evenspin.report.page import Page, write_page
from evenspin.report.reference import pages
from evenspin.run import run_signals
from evenspin.sim import simulate
from evenspin.tableview import TableView, number


@pytest.fixture
def drawn(scenario):
    setup = load_scenario(scenario).setup
    record = simulate(setup, run_signals())
    return setup, record, pictures(setup, [Curve("forc", record)])


def test_a_thinned_curve_keeps_its_peaks():
    t_s = np.arange(100_000) / 1e4
    value = np.sin(t_s)
    value[12_345], value[77_777] = 9.0, -9.0

    thin_t, thin = envelope(t_s, value, 500)

    assert len(thin) <= 500
    assert (thin.max(), thin.min()) == (9.0, -9.0)
    assert (np.diff(thin_t) > 0).all()


def test_a_short_curve_stays_as_it_is():
    t_s = np.arange(10.0)

    assert envelope(t_s, t_s**2)[1].tolist() == (t_s**2).tolist()


def test_pictures_have_axes_with_units(drawn):
    for picture in drawn[2]:
        assert re.search(r"\[(s|-)\]", picture.svg), picture.name
        assert re.search(r"\[(rpm|A|% of mean)\]", picture.svg), picture.name


def test_the_numbers_beside_a_picture_are_those_of_the_run(drawn):
    _, record, made = drawn
    speed = next(picture for picture in made if picture.name == "speed")

    assert speed.data["forc_rpm"].max() == pytest.approx(record["true_speed_rad_s"].max() * 30 / np.pi)


def test_a_picture_is_the_same_every_time(drawn):
    setup, record, made = drawn

    assert [p.svg for p in pictures(setup, [Curve("forc", record)])] == [p.svg for p in made]


def test_a_page_needs_nothing_from_elsewhere(drawn, tmp_path):
    table = TableView("Table <1>", "a & b", ("x", "y"), [("1", "2")], ["bad"])
    write_page(tmp_path, Page("Title <b>", "summary", [("k", "v")], [table], drawn[2], "evenspin run x"))

    page = (tmp_path / "report.html").read_text()

    assert not re.search(r"<(link|img)|\bsrc=|@import|url\(http|\bfetch\(|XMLHttpRequest", page)
    assert "Title &lt;b&gt;" in page and "Table &lt;1&gt;" in page and "a &amp; b" in page
    assert page.count("<svg") == len(drawn[2])
    for picture in drawn[2]:
        assert (tmp_path / "figures" / f"{picture.name}.svg").is_file()
        assert (tmp_path / "figures" / f"{picture.name}.csv").read_text().count("\n") > 5


def test_a_page_carries_the_licence_of_the_plotting_library_that_is_in_it(drawn, tmp_path):
    write_page(tmp_path, Page("T", "s", (), (), drawn[2], "evenspin run x"))

    page = (tmp_path / "report.html").read_text()

    assert page.index("MIT License") < page.index("var uPlot")


def test_a_page_without_pictures_carries_no_plotting_library(tmp_path):
    write_page(tmp_path, Page("T", "s", (), (), (), "evenspin run x"))

    assert "uPlot" not in (tmp_path / "report.html").read_text()


def test_the_contents_list_leads_to_every_picture_and_table(drawn, tmp_path):
    table = TableView("Table <1>", "a", ("x", "y"), [("1", "2")])
    write_page(tmp_path, Page("T", "s", (), [table], drawn[2], "evenspin run x"))

    page = (tmp_path / "report.html").read_text()
    places = re.findall(r'<a href="#([^"]+)">', page)

    assert len(places) == len(drawn[2]) + 1
    assert all(f'id="{place}"' in page for place in places)


@pytest.mark.parametrize(("value", "text"), [
    (0.0301, "0.0301"), (14.81, "14.8"), (150.0, "150"), (12345.0, "12345"), (-4.567, "-4.57"),
    (0.0, "0"), (None, "-"), (float("nan"), "-"),
])  # fmt: skip
def test_numbers_have_three_digits(value, text):
    assert number(value) == text


def test_reference_pages_hold_the_whole_tables():
    from evenspin.native import tables

    made = pages()

    assert set(made) == {"parameters.md", "model.md", "effects.md", "faults.md"}
    assert all(f"`{name}`" in made["parameters.md"] for name in tables().params)
    assert all(f"## {name}" in made["effects.md"] for name in tables().effects)
    assert all(f"`{name}`" in made["model.md"] for name in tables().model)
    assert "`none`" not in made["faults.md"]
