"""Charts drawn as SVG: every point where its number says, axes with round numbers, text that cannot break the file."""

import io
import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from evenspin.report.chart import BARS, POINTS, Chart, Line, Panel, chart_json
from evenspin.report.style import REFERENCE_COLOUR, drawing, subplots, to_svg
from evenspin.report.svg import BOTTOM, LEFT, LEGEND, RIGHT, TOP, WIDTH, svg_of
from evenspin.report.ticks import decade_ticks, linear_ticks, tick_texts

X, Y = np.array([0.0, 1.0, 2.0, 4.0]), np.array([-1.0, 3.0, np.nan, 1.0])
HEIGHT = 200.0


def panel(**changes):
    line = Line("speed <b>", X, Y, "#123456", **changes.pop("line", {}))
    return Panel(**({"lines": [line], "x_label": "time [s]", "y_label": "a & b", "y_range": (-1.0, 3.0)} | changes))


def drawn(**changes):
    return ElementTree.fromstring(svg_of(Chart([panel(**changes)], height_px=HEIGHT), "p"))


def paths(svg, kind):
    return [each.attrib["d"] for each in svg.iter() if each.attrib.get("class") == kind and "d" in each.attrib]


def test_a_point_is_where_the_axes_put_it():
    path = paths(drawn(), "es-line")[0]
    x, y = [[float(n) for n in pair.split()] for pair in re.findall(r"[\d.]+ [\d.]+", path)][0]

    # the frame: beside the labels, x from 0 to 4, y from -1 to 3
    assert (x, y) == (LEFT, TOP + LEGEND + HEIGHT - BOTTOM)
    last = [float(n) for n in re.findall(r"[\d.]+", path)[-2:]]
    top = TOP + LEGEND + 4.0
    assert last == pytest.approx([WIDTH - RIGHT, (y + top) / 2.0], abs=0.01)


def test_a_missing_number_interrupts_the_line():
    assert paths(drawn(), "es-line")[0].count("M") == 2


def test_a_logarithmic_axis_puts_decades_at_equal_distances():
    changes = {"y_range": (1e-3, 10.0), "log_y": True}
    svg = ElementTree.fromstring(
        svg_of(Chart([panel(lines=[Line("a", X, 10.0 ** (X - 3.0), "#000")], **changes)]), "p")
    )
    ys = [float(n) for n in re.findall(r"[\d.]+", paths(svg, "es-line")[0])[1::2]]

    assert ys[0] - ys[1] == pytest.approx(ys[1] - ys[2], abs=0.02)
    assert ys[2] - ys[3] == pytest.approx(2.0 * (ys[1] - ys[2]), abs=0.03)


def test_bars_and_points_are_drawn_one_by_one():
    bars = drawn(line={"kind": BARS, "bar_width": 0.5})
    points = drawn(line={"kind": POINTS})

    assert paths(bars, "es-bars")[0].count("Z") == 2  # one ends at the foot of the axis, one has no number
    assert paths(points, "es-line")[0].count("h0") == 3


def test_only_a_reference_takes_the_ink_of_the_page_and_a_dashed_line_of_a_method_keeps_its_colour():
    method = drawn(line={"dashed": True})
    reference = drawn(lines=[Line("reference", X, Y, REFERENCE_COLOUR)])

    assert (len(paths(method, "es-ref")), len(paths(method, "es-line"))) == (0, 1)
    assert len(paths(reference, "es-ref")) == 1


def test_points_have_a_point_in_the_legend():
    legend = [each for each in drawn(line={"kind": POINTS}).iter() if each.tag.endswith("circle")]

    assert [each.attrib["fill"] for each in legend] == ["#123456"]


def test_texts_are_escaped():
    texts = [each.text for each in drawn().iter() if each.tag.endswith("text")]

    assert "speed <b>" in texts and "a & b" in texts


def test_the_clips_of_two_charts_on_a_page_have_different_names():
    chart = Chart([panel(), panel()], 2)
    names = re.findall(r'clipPath id="([^"]+)"', svg_of(chart, "one") + svg_of(chart, "two"))

    assert len(names) == len(set(names)) == 4


@pytest.mark.parametrize("y", [[], [np.nan, np.nan], [2.0, 2.0], [0.0, 0.0], [1e300, -1e300]])
def test_any_numbers_can_be_drawn(y):
    line = Line("a", np.arange(float(len(y))), np.array(y), "#000")

    text = svg_of(Chart([Panel([line], "x", "y")]), "p")

    ElementTree.fromstring(text)
    assert "nan" not in text and "inf" not in text


def test_the_chart_for_the_page_is_json_that_cannot_end_its_element():
    text = chart_json(Chart([panel(title="</script><script>alert(1)")]))

    content = json.loads(text)["panels"][0]
    assert "<" not in text
    assert content["title"] == "</script><script>alert(1)"
    assert content["lines"][0]["y"] == [-1.0, 3.0, None, 1.0]


def test_a_step_stays_two_points():
    line = Line("a", np.array([0.0, 3599.999999, 3600.0]), np.array([1.0, 1.0, 2.0]), "#000")

    x = json.loads(chart_json(Chart([Panel([line], "x", "y")])))["panels"][0]["lines"][0]["x"]

    assert len(set(x)) == 3


@pytest.mark.parametrize(("low", "high", "expected"), [
    (0.0, 10.0, [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]), (-1.0, 1.0, [-1.0, -0.5, 0.0, 0.5, 1.0]),
    (0.3, 0.9, [0.4, 0.6, 0.8]), (5.0, 5.0, [5.0]),
])  # fmt: skip
def test_ticks_are_round_and_within_the_axis(low, high, expected):
    assert linear_ticks(low, high, 5) == pytest.approx(expected)


def test_decades_within_the_axis():
    assert decade_ticks(1e-3, 40.0) == pytest.approx([1e-3, 1e-2, 0.1, 1.0, 10.0])


def test_tick_texts_are_short():
    assert tick_texts([-0.2, -1e-17, 0.2]) == ["\u22120.2", "0", "0.2"]


def test_a_figure_is_drawn_once_and_as_matplotlib_saves_it():
    from matplotlib.lines import Line2D

    class Counted(Line2D):
        drawn = 0

        def draw(self, renderer):
            self.drawn += 1
            super().draw(renderer)

    def figure_with(line):
        figure, axes = subplots(1, 2)
        axes[0, 0].add_line(line)
        axes[0, 0].set(title="a", xlabel="time [s]", ylabel="speed [r/min]", xlim=(0.0, 4.0))
        axes[0, 1].plot(X, 1000.0 * X, label="of which the labels need room")
        figure.legend(loc="outside upper right")
        return figure

    saved = io.StringIO()
    with drawing():
        figure_with(Counted(X, Y)).savefig(saved, format="svg", metadata={"Date": None, "Creator": None})
        line = Counted(X, Y)
        text = to_svg(figure_with(line))

    assert saved.getvalue().endswith(text)
    assert line.drawn == 1
