"""What protects the motor on the page itself, in Chromium: keys, stop button, set-points, questions, at every width."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from browser import Browser, chromium, missing, scope_command
from busy import slowness
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from virtual_bench import Bench, running_bench

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing() or "-")

WIDTHS = (320, 400, 700, 920, 1000, 1400, 1920)
STOP_MS = 100.0  # from the key or the press to the message that leaves the page
PLOT_PX = 85  # the least height of a plot that one can read something from
RUN = 4

# When stops leave the page, and when the last key or press came from the hand.
WATCH = """
window.stops = []; window.hand = 0;
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (data) {
  if (typeof data === "string" && data.includes('"do":"stop"')) window.stops.push(performance.now() - window.hand);
  return send.call(this, data);
};
const note = (event) => { window.hand = event.timeStamp; };
for (const kind of ["keydown", "pointerdown"]) addEventListener(kind, note, { capture: true });
"""


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Browser, Bench]]:
    """One browser, one scope, one drive for all of them: each test leaves the motor at rest."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_RUNTIME_DIR", str(tmp_path_factory.mktemp("registry")))
        with running_bench() as bench, scope_command(bench.port) as address, chromium() as browser:
            browser.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
            browser.driver.get(address)
            browser.until_state("ready")
            yield browser, bench
            assert browser.complaints() == []


@pytest.fixture
def page(opened: tuple[Browser, Bench]) -> Iterator[Browser]:
    browser, _ = opened
    browser.resize(1280)
    browser.press("[data-view=live]")
    browser.press("[data-side=parameters]")
    yield browser
    browser.key(Keys.ESCAPE)
    browser.until_state("ready")
    browser.press("[data-mode=speed]")
    browser.driver.execute_script("document.querySelector('#speed').value = 30; document.activeElement.blur()")


@pytest.fixture
def bench(opened: tuple[Browser, Bench]) -> Bench:
    return opened[1]


def turn(page: Browser) -> None:
    page.press("#arm")
    page.press("#start")
    page.until_state("run")


def stops(page: Browser) -> list[float]:
    """Milliseconds from the hand to each stop that left since the last time."""
    return page.driver.execute_script("const all = window.stops; window.stops = []; return all")


def stopped_at_once(page: Browser) -> float:
    left = stops(page)
    assert left, "no stop left the page"
    assert left[0] < STOP_MS * slowness(), left
    return left[0]


LOOK = """
scrollTo(0, arguments[1]);
const stop = document.querySelector("#stop").getBoundingClientRect();
const root = document.documentElement;
const places = [[.02, .1], [.98, .1], [.5, .5], [.02, .9], [.98, .9]];
const covered = places.filter(([x, y]) =>
  !document.elementFromPoint(stop.left + x * stop.width, stop.top + y * stop.height)?.closest("#stop"));
const plots = [...document.querySelectorAll(`#view-${arguments[0]} .plot`)].filter((plot) => plot.offsetParent);
const heights = plots.map((plot) => Math.min(plot.clientHeight, plot.querySelector("canvas")?.clientHeight ?? 0));
// A row of the page that scrolls below STOP is covered on purpose.
const under = scrollY > 0 ? [] : [...document.querySelectorAll("main nav button")].filter((button) => {
  const at = button.getBoundingClientRect();
  return at.width > 0 && at.bottom <= innerHeight
    && [.1, .9].some((x) => !button.contains(document.elementFromPoint(at.left + x * at.width, at.bottom - 9)));
}).map((button) => button.textContent);
return {
  under, inside: stop.left >= 0 && stop.top >= 0 && stop.right <= root.clientWidth && stop.bottom <= innerHeight,
  covered, beyond: root.scrollWidth - root.clientWidth, finger: Math.min(stop.width / 2, stop.height), heights,
};
"""


DRAWN = """
const plots = [...document.querySelectorAll(`#view-${arguments[0]} .plot`)].filter((plot) => plot.offsetParent);
const heights = plots.map((plot) => plot.querySelector("canvas")?.clientHeight ?? 0);
return heights.length > 0 && Math.min(...heights) >= arguments[1];
"""


@pytest.mark.parametrize("width", WIDTHS)
def test_at_every_width_stop_is_inside_the_window_and_plots_can_be_read(page: Browser, width: int) -> None:
    turn(page)
    page.resize(width)
    for view in ("capture", "xy", "spectrum", "live"):
        page.find(f"[data-view={view}]").click()
        if view != "capture":  # it has nothing to show yet
            page.until(lambda view=view: page.driver.execute_script(DRAWN, view, PLOT_PX), f"readable plots of {view}")
        for scrolled in (100_000, 0):
            found = page.driver.execute_script(LOOK, view, scrolled)
            assert found["inside"] and not found["covered"], (view, scrolled, found)
            assert found["beyond"] <= 0, (view, found)
            assert not found["under"], (view, found)
            assert found["finger"] >= 44, found
            assert view == "capture" or min(found["heights"]) >= PLOT_PX, (view, found)
    stops(page)
    page.find("#stop").click()
    print(f"{width} px: {stopped_at_once(page):.1f} ms from the press")
    page.until_state("ready")


# One of each kind: all of a page would be the same hundred fields over and over.
AROUND = """
const all = [...document.querySelectorAll("button, input, select, a, [tabindex]")];
const seen = new Map();
for (const e of all.filter((e) => e.offsetParent && !e.disabled)) {
  const kind = e.id || e.dataset.view || e.dataset.command || `${e.tagName} ${e.type} ${e.parentElement.className}`;
  if (!arguments[0].includes(kind) && !seen.has(kind)) seen.set(kind, e);
}
window.around = [...seen.values()];
return [...seen.keys()];
"""
VALUES = "[...document.querySelectorAll('input, select')].map((e) => e.value + e.checked).join()"
FOCUS = f"window.around[arguments[0]].focus(); window.stops = []; return {VALUES}"


def test_the_space_bar_stops_whatever_has_the_focus_and_changes_nothing(page: Browser) -> None:
    """Every kind of thing that can have the focus, in every view."""
    slowest, seen = 0.0, []
    space = {"key": " ", "code": "Space", "windowsVirtualKeyCode": 32, "text": " "}
    for view in ("live", "capture", "xy", "spectrum"):
        page.press(f"[data-view={view}]")
        page.press("[data-side=signals]" if view == "capture" else "[data-side=parameters]")
        kinds = page.driver.execute_script(AROUND, seen)
        for index, kind in enumerate(kinds):
            before = page.driver.execute_script(FOCUS, index)
            page.driver.execute_cdp_cmd("Input.dispatchKeyEvent", {"type": "keyDown", **space})
            page.driver.execute_cdp_cmd("Input.dispatchKeyEvent", {"type": "keyUp", **space})
            left, after = page.driver.execute_script(f"return [window.stops, {VALUES}]")
            assert left and left[0] < STOP_MS, (kind, left)
            assert after == before, kind
            slowest = max(slowest, left[0])
        seen += kinds
    print(f"{len(seen)} kinds, slowest {slowest:.1f} ms")
    assert len(seen) > 40


@pytest.mark.parametrize(
    "opens", ["#window", "[data-parameter=method]", "[data-command=defaults]", "[data-command=save]", "#help"]
)
def test_no_open_list_or_question_keeps_a_stop_from_the_motor(page: Browser, opens: str) -> None:
    chosen = "return document.querySelector('[data-parameter=method]').value + document.querySelector('#window').value"
    before = page.driver.execute_script(chosen)
    if opens == "#window":
        turn(page)
    for key in (" ", Keys.ESCAPE):
        page.driver.execute_script("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", opens)
        page.find(opens).click()
        page.until(lambda: page.find("dialog[open], select.choice").is_displayed(), "something is open")
        stops(page)
        page.key(key)
        stopped_at_once(page)
        assert page.text("dialog[open]") == "" and not page.driver.find_elements("css selector", "select.choice")
        assert page.driver.execute_script(chosen) == before
    page.until_state("ready")


def test_what_is_typed_after_a_start_is_no_part_of_the_setpoint(page: Browser, bench: Bench) -> None:
    page.key("a")
    page.until(lambda: page.text("#arm") == "Armed", "armed")
    page.key("s")
    page.key("30")
    ActionChains(page.driver).key_down(Keys.SHIFT).send_keys(Keys.ENTER).key_up(Keys.SHIFT).perform()
    page.until_state("run")
    page.key("4")
    assert page.find("#view-spectrum").is_displayed()
    page.key(Keys.ENTER)
    assert page.find("#speed").get_attribute("value") == "30"
    page.key("s")
    page.key("45")
    page.key(Keys.ENTER)
    page.until(lambda: page.text("#drive-said") == "Taken over.", "taken over")
    page.key("1")
    assert page.find("#speed").get_attribute("value") == "45"
    assert page.find("#view-live").is_displayed()
    page.until(lambda: abs(bench.server.drive.read("true_speed_rad_s") - 45.0) < 2.0, "the speed arrives")
    stops(page)
    page.key(" ")
    stopped_at_once(page)
    page.until_state("ready")
    assert page.find("#speed").get_attribute("value") == "45"


def test_s_goes_to_the_setpoint_of_the_mode_in_force(page: Browser) -> None:
    for mode, field in (("current", "#iq-ref"), ("position", "#turns"), ("torque", "#torque"), ("speed", "#speed")):
        page.press(f"[data-mode={mode}]")
        page.key("s")
        assert page.driver.execute_script("return '#' + document.activeElement.id") == field
        page.key("0.25")
        assert page.find(field).get_attribute("value") == "0.25"
        page.key(Keys.ENTER)
        assert page.driver.execute_script("return document.activeElement.tagName") == "BODY"


def test_a_torque_turns_the_motor_no_faster_than_the_limit_beside_it(page: Browser, bench: Bench) -> None:
    page.press("[data-mode=torque]")
    page.type("#torque", "0.5")
    page.type("#speed-limit", "-20")
    turn_refused = "speed_rad_s = -20: must be 0 or more"
    page.press("#arm")
    page.press("#start")
    page.until(lambda: turn_refused in page.text("#drive-said").replace(".0", ""), "a limit acts in both directions")
    page.type("#speed-limit", "20")
    page.press("#start")
    page.until_state("run")
    page.until(lambda: abs(bench.server.drive.read("true_speed_rad_s") - 20.0) < 1.0, "the limit is reached")
    page.type("#torque", "-0.5")
    page.until(lambda: abs(bench.server.drive.read("true_speed_rad_s") + 20.0) < 1.0, "the other one, too")


def test_a_setpoint_that_is_no_number_is_refused_also_at_rest(page: Browser) -> None:
    fill = "const field = document.querySelector('#speed'); field.value = arguments[0]; field.oninput(); field.focus()"
    for typed in ("foo", "NaN", "1e999", "0x10", "3 0", "", "1,2,3"):
        page.type("#speed", "30")
        page.until(lambda: page.text("#drive-said") == "Kept for the start.", "a number is kept")
        page.driver.execute_script(fill, typed)
        page.key(Keys.ENTER)
        page.until(lambda typed=typed: f"“{typed}”: must be a number" in page.text("#drive-said"), typed)


def test_a_comma_is_a_decimal_point_in_both_fields_of_the_speed(page: Browser) -> None:
    page.type("#speed", "30,5")
    assert page.text("#drive-said") == "Kept for the start."
    assert float(page.find("#rpm").get_attribute("value")) == pytest.approx(30.5 * 60.0 / 6.283185307179586, abs=0.01)


def test_defaults_ask_first_and_can_be_undone(page: Browser) -> None:
    page.type("[data-parameter=rc_gain]", "0.25")
    row = ".parameter:has([data-parameter=rc_gain])"
    page.until(lambda: "changed" in page.find(row).get_attribute("class"), "changed")
    page.press("[data-command=defaults]")
    assert "rc_gain: 0.25, default" in page.text("#ask")
    assert page.driver.execute_script("return document.activeElement.id") == "ask-cancel"
    page.press("#ask-cancel")
    assert page.find("[data-parameter=rc_gain]").get_attribute("value") == "0.25"
    page.press("[data-command=defaults]")
    page.press("#ask-do")
    page.until(lambda: page.find("[data-parameter=rc_gain]").get_attribute("value") != "0.25", "the default is there")
    page.until(lambda: page.find("[data-command=undo]").is_displayed(), "it can be undone")
    page.press("[data-command=undo]")
    page.until(lambda: page.find("[data-parameter=rc_gain]").get_attribute("value") == "0.25", "it is undone")
    page.until(lambda: not page.find("[data-command=undo]").is_displayed(), "once")


def test_when_the_page_in_control_is_closed_the_motor_stops_and_a_watcher_can_take_over(
    page: Browser, bench: Bench
) -> None:
    turn(page)
    control, address = page.driver.current_window_handle, page.driver.current_url
    page.driver.switch_to.new_window("tab")
    page.driver.get(address)
    page.until_state("run")
    page.until(lambda: "2 pages are open" in page.text("[data-banner=watch]"), "two pages")
    watcher = page.driver.current_window_handle
    page.driver.switch_to.window(control)
    page.driver.close()
    page.driver.switch_to.window(watcher)
    page.until(lambda: bench.server.drive.read("state") != RUN, "the motor stops", wait_s=1.0)
    page.until(lambda: "Nobody is in control" in page.text("#banners"), "the watcher sees that nobody is in control")
    assert "This is the only open page" in page.text("#banners")
    page.press("#take-control")
    page.until(lambda: page.text("#banners") == "", "in control")
    page.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
    page.driver.refresh()
    page.until_state("ready")
    turn(page)


def test_a_list_is_chosen_from_with_mouse_or_keys_and_digits_choose_nothing(page: Browser) -> None:
    value = "return document.querySelector('#window').value"
    page.choose("#window", "10 s")
    assert page.driver.execute_script(value) == "10"
    page.driver.execute_script("document.querySelector('#window').focus()")
    page.key("2")  # a view, not "2 s"
    assert page.driver.execute_script(value) == "10"
    assert page.find("#view-capture").is_displayed()
    page.key("1")
    page.driver.execute_script("document.querySelector('#window').focus()")
    for key in (Keys.ARROW_DOWN, Keys.ARROW_UP, Keys.ENTER):  # opens, chooses the one above, takes it
        page.key(key)
    assert page.driver.execute_script(value) == "5"


def test_a_refused_value_stays_with_its_reason_until_the_drive_holds_another(page: Browser) -> None:
    field, refusal = "[data-parameter=over_current_a]", ".parameter:has([data-parameter=over_current_a]) .refusal"
    page.type(field, "5")
    page.until(lambda: "over_current_a = 5 A: does not fit iq_limit_a = 10 A" in page.text(refusal), "the reason")
    page.type("[data-parameter=rc_gain]", "0.5")  # the drive tells all its values
    page.until(lambda: "edited" not in page.find("[data-parameter=rc_gain]").get_attribute("class"), "taken")
    assert page.find(field).get_attribute("value") == "5"
    assert page.text(refusal) != ""
    page.type(field, "15")
    page.until(lambda: page.text(refusal) == "", "taken over")
    page.type(field, "20")
    page.until(lambda: "changed" not in page.find(".parameter:has(" + field + ")").get_attribute("class"), "as before")
