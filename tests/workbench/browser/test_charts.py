"""The charts in a real browser: zoom, one pointer for all that share an axis, downloads, dragged levels, clicks."""

import csv
import io
import re
import xml.etree.ElementTree as ElementTree
from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from tests.workbench.browser.conftest import Shared
from tests.workbench.browser.test_downloads import came
from tests.workbench.browser.waiting import TEXT, chord, open_menu, until, wait_for

pytestmark = pytest.mark.slow

PROFILE, HISTOGRAM, TIMES = "slant range, m", "dB over the image's median", "time, s"
CHART = """
return [...document.querySelectorAll("div")].find((item) => item.chartView?.places && item.clientWidth
  && item.chartView.about.x.label === arguments[0]);
"""
ENDS = "const { x, y } = arguments[0].chartView.places.ends; return [x, y[arguments[1] ?? 0]]"
DRAWN = """
const chart = arguments[0].chartView.chart, place = arguments[1], ends = arguments[0].chartView.places.ends;
const box = arguments[0].chartView.places.laid.panels[place];
const [left, right] = ends.x.map((value) => chart.convertToPixel({ xAxisIndex: place }, value));
const [bottom, top] = ends.y[place].map((value) => chart.convertToPixel({ yAxisIndex: place }, value));
return [[left, right, top, bottom], [box.x, box.x + box.width, box.y, box.y + box.height]];
"""
"""Where ECharts has the ends of the axes, and where we have them."""
BOX = """
const { x, y, width, height } = arguments[0].chartView.places.laid.panels[arguments[1]];
return [x, y, width, height];
"""
MARKS = """
const lines = arguments[0].chartView.marks.filter((mark) => mark.style.lineDash);
return lines.map(({ shape: { x1, y1, x2, y2 } }) => [x1, y1, x2, y2]);
"""
"""Lines of the pointer."""
READOUT = "return arguments[0].chartView.$refs.readout.innerText"
BUTTON = "[...arguments[0].querySelectorAll('button')].find((each) => each.innerText === arguments[1]).click()"
FAN = "return [...document.querySelectorAll('div')].find((item) => item.fanView && item.clientWidth)"
BEARING = "const { pointed } = arguments[0].fanView; return pointed.bearing === undefined ? null : pointed"
RECORDED = """
const levels = arguments[0].chartView.about.panels[0].curves[0].y.filter((level) => !Number.isNaN(level));
return [levels.length, Math.max(...levels)];
"""
HIGH = "return arguments[0].chartView.about.panels[0].lines.find((line) => line.name === 'high').value"
COUNT = """
const view = [...document.querySelectorAll('div')].find((item) => item.fanView && item.clientWidth);
return Number(/(\\d+) detection/.exec(view.fanView.frame?.caption)?.[1]);
"""


def chart(window: webdriver.Chrome, axis: str) -> WebElement:
    """Wait for the chart over that axis."""
    found: WebElement = until(lambda: window.execute_script(CHART, axis))
    window.execute_script("arguments[0].scrollIntoView({ block: 'center' })", found)
    return found


def box_of(window: webdriver.Chrome, view: WebElement, panel: int = 0) -> Any:
    return window.execute_script(BOX, view, panel)


def ends(window: webdriver.Chrome, view: WebElement, panel: int = 0) -> Any:
    return window.execute_script(ENDS, view, panel)


def to(window: webdriver.Chrome, view: WebElement, at: tuple[float, float], panel: int = 0) -> ActionChains:
    """Return a hand that goes to a place of a panel, shares of its width and height."""
    left, top, width, height = box_of(window, view, panel)
    x, y = left + at[0] * width - view.size["width"] / 2, top + at[1] * height - view.size["height"] / 2
    return ActionChains(window).move_to_element_with_offset(view, round(x), round(y))


def wheel(window: webdriver.Chrome, view: WebElement, by: int, panel: int = 0) -> None:
    """Turn the wheel over the middle of a panel."""
    left, top, width, height = box_of(window, view, panel)
    x, y = left + 0.5 * width - view.size["width"] / 2, top + 0.5 * height - view.size["height"] / 2
    ActionChains(window).scroll_from_origin(ScrollOrigin.from_element(view, round(x), round(y)), 0, by).perform()


def done(window: webdriver.Chrome) -> str:
    """Return what the undo button would undo."""
    texts = [button.text.split("\n") for button in window.find_elements(By.CSS_SELECTOR, "header button")]
    return next(lines[-1] for lines in texts if lines[0] == "undo")


def ping(window: webdriver.Chrome) -> int:
    """Return the ping that the page shows."""
    found = re.search(r"ping (\d+) of", str(window.execute_script(TEXT)))
    return int(found[1]) if found else -1


def test_echarts_has_the_axes_where_the_pointer_looks_for_them(window: webdriver.Chrome) -> None:
    open_menu(window, "Image processing")
    for axis in (PROFILE, HISTOGRAM):  # one of them has a logarithmic axis
        drawn, wanted = window.execute_script(DRAWN, chart(window, axis), 0)
        assert drawn == pytest.approx(wanted, abs=0.6)


def test_wheel_and_box_zoom_and_a_double_click_shows_all(window: webdriver.Chrome) -> None:
    profile = chart(window, PROFILE)
    (first, last), levels = ends(window, profile)
    wheel(window, profile, -400)
    (low, high), _ = until(lambda: ends(window, profile) if ends(window, profile)[0] != [first, last] else None)
    assert first < low < high < last
    assert (low + high) / 2 == pytest.approx((first + last) / 2, abs=0.02 * (last - first))
    to(window, profile, (0.3, 0.1)).double_click().perform()
    until(lambda: ends(window, profile) == [[first, last], levels])
    to(window, profile, (0.5, 0.02)).click_and_hold().move_by_offset(60, 30).move_by_offset(20, 0).release().perform()
    (low, high), (bottom, top) = until(lambda: ends(window, profile) if ends(window, profile)[1] != levels else None)
    *_, width, height = box_of(window, profile)
    assert high - low == pytest.approx(80 * (last - first) / width, rel=0.05)
    assert top - bottom == pytest.approx(30 * (levels[1] - levels[0]) / height, rel=0.1)
    drawn, wanted = window.execute_script(DRAWN, profile, 0)
    assert drawn == pytest.approx(wanted, abs=0.6)
    to(window, profile, (0.3, 0.5)).double_click().perform()
    until(lambda: ends(window, profile) == [[first, last], levels])


def test_what_is_zoomed_into_stays_when_an_answer_comes(window: webdriver.Chrome) -> None:
    profile = chart(window, PROFILE)
    before = window.execute_script("return arguments[0].chartView.now.shown", profile)
    whole, _ = ends(window, profile)
    wheel(window, profile, -300)
    part = until(lambda: ends(window, profile)[0] if ends(window, profile)[0] != whole else None)
    window.find_element(By.CSS_SELECTOR, "body").click()
    ActionChains(window).send_keys(Keys.ARROW_RIGHT).perform()
    until(lambda: window.execute_script("return arguments[0].chartView.now.shown", profile) != before)
    assert ends(window, profile)[0] == part
    window.execute_script("arguments[0].chartView.showAll()", profile)
    until(lambda: ends(window, profile)[0] == whole)


def test_a_level_that_is_pointed_at_shows_in_profile_and_histogram(window: webdriver.Chrome) -> None:
    profile, histogram = chart(window, PROFILE), chart(window, HISTOGRAM)
    to(window, histogram, (0.5, 0.3)).perform()
    level = 0.5 * sum(ends(window, histogram)[0])
    (lines,) = until(lambda: window.execute_script(MARKS, profile) or None)
    low, high = ends(window, profile)[1]
    _, top, _, height = box_of(window, profile)
    assert lines[1] == lines[3] == pytest.approx(top + (high - level) / (high - low) * height, abs=1.5)
    to(window, profile, (0.25, 0.3)).perform()
    across = until(lambda: window.execute_script(MARKS, histogram) or None)
    assert across[0][0] == across[0][2]
    first, last = ends(window, profile)[0]
    read = str(window.execute_script(READOUT, profile))
    at_m = float(read.partition("slant range, m: ")[2].partition("\n")[0])
    assert at_m == pytest.approx(first + 0.25 * (last - first), abs=0.01 * (last - first))
    assert re.search(r"as recorded: -?\d", read)


def test_the_range_that_is_pointed_at_shows_in_profile_and_image(window: webdriver.Chrome) -> None:
    profile = chart(window, PROFILE)
    fan = window.execute_script(FAN)
    first, last = ends(window, profile)[0]
    to(window, profile, (0.25, 0.3)).perform()
    pointed = until(lambda: window.execute_script("return arguments[0].fanView.pointed", fan))
    assert pointed["range"] == pytest.approx(first + 0.25 * (last - first), abs=0.01 * (last - first))
    assert "bearing" not in pointed  # an arc
    window.execute_script("arguments[0].scrollIntoView({ block: 'center' })", fan)
    ActionChains(window).move_to_element_with_offset(fan, 0, -20).perform()
    pointed = until(lambda: window.execute_script(BEARING, fan))
    (line,) = window.execute_script(MARKS, profile)
    left, _, width, _ = box_of(window, profile)
    assert line[0] == line[2] == pytest.approx(left + (pointed["range"] - first) / (last - first) * width, abs=1.5)


def test_a_dragged_level_changes_what_is_detected_and_undo_brings_it_back(window: webdriver.Chrome) -> None:
    histogram = chart(window, HISTOGRAM)
    before, value = window.execute_script(COUNT), window.execute_script(HIGH, histogram)
    (low, high), _ = ends(window, histogram)
    hand = to(window, histogram, ((value - low) / (high - low), 0.3)).click_and_hold()
    hand.move_by_offset(40, 0).move_by_offset(60, 0).release().perform()
    until(lambda: re.match(r"detect\.two_level: high level", done(window)))
    until(lambda: window.execute_script(COUNT) < before)
    *_, width, _ = box_of(window, histogram)
    moved = until(lambda: window.execute_script(HIGH, histogram))
    assert moved == pytest.approx(value + 100 * (high - low) / width, abs=1.0)
    chord(window, "z")
    until(lambda: window.execute_script(COUNT) == before)


def test_a_chart_and_its_numbers_are_downloaded(window: webdriver.Chrome, shared: Shared) -> None:
    profile = chart(window, PROFILE)
    window.execute_script(BUTTON, profile, "print")
    picture = ElementTree.fromstring(came(shared, ".svg"))
    assert picture.get("width") == str(profile.size["width"])
    assert "slant range, m" in "".join(picture.itertext())
    window.execute_script(BUTTON, profile, "table_view")
    head, *rows = csv.reader(io.StringIO(came(shared, ".csv").decode()))
    assert head[:2] == ["slant range, m", "dB over median: as recorded"]
    ranges = [float(row[0]) for row in rows]
    assert ranges == sorted(ranges)
    assert max(ranges) == pytest.approx(ends(window, profile)[0][1], abs=0.2)
    levels = [float(row[1]) for row in rows if row[1]]
    assert [len(levels), max(levels)] == pytest.approx(window.execute_script(RECORDED, profile))


def test_a_click_at_a_time_goes_to_its_ping_and_one_pointer_is_in_all_panels(window: webdriver.Chrome) -> None:
    open_menu(window, "Observer")
    wait_for(window, "mean GOSPA")
    times = chart(window, TIMES)
    until(lambda: window.execute_script("return arguments[0].chartView.about.panels.length", times) == 8)
    to(window, times, (0.5, 0.5), 3).click().perform()
    until(lambda: 198 <= ping(window) <= 203)  # of 402
    first, last = ends(window, times)[0]
    middle = 0.5 * (first + last)
    cursor = until(lambda: window.execute_script("return arguments[0].chartView.now.cursor", times))
    assert cursor == pytest.approx(middle, abs=0.01 * (last - first))
    assert len(window.execute_script(MARKS, times)) == 9  # eight panels, and the strips
    assert "velocity east, m/s" in window.execute_script("return arguments[0].chartView.about.panels[3].title", times)
    assert re.search(r"tracked: -?\d.*\n.*truth: ", window.execute_script(READOUT, times))


def test_a_panel_that_is_zoomed_takes_the_others_along_and_fits_its_height(window: webdriver.Chrome) -> None:
    times = chart(window, TIMES)
    whole, heights = ends(window, times, 1)
    hand = to(window, times, (0.5, 0.5), 1)
    hand.key_down(Keys.SHIFT).click_and_hold().move_by_offset(20, 0).move_by_offset(20, 0).release()
    hand.key_up(Keys.SHIFT).perform()
    (low, high), fitted = until(lambda: ends(window, times, 1) if ends(window, times, 1)[0] != whole else None)
    assert whole[0] < low < high < whole[1]
    assert fitted[1] - fitted[0] < heights[1] - heights[0]  # the velocity of the first seconds is known worst
    for panel in (0, 7):
        drawn, wanted = window.execute_script(DRAWN, times, panel)
        assert drawn == pytest.approx(wanted, abs=0.6)
    to(window, times, (0.5, 0.5), 1).double_click().perform()
    until(lambda: ends(window, times, 1)[0] == whole)


def test_a_strip_that_is_clicked_marks_its_object(window: webdriver.Chrome) -> None:
    times = chart(window, TIMES)
    x, y, width, high = window.execute_script(
        "const { x, y, width, height } = arguments[0].chartView.places.laid.strips; return [x, y, width, height]", times
    )
    place = round(x + 0.8 * width - times.size["width"] / 2), round(y + high - 6 - times.size["height"] / 2)
    ActionChains(window).move_to_element_with_offset(times, *place).click().perform()
    until(lambda: "course of track 3" in window.execute_script("return arguments[0].chartView.now.title", times))


def test_the_axes_are_right_in_the_simulator_too(window: webdriver.Chrome) -> None:
    open_menu(window, "Simulator")
    wait_for(window, "of 401")
    strip = chart(window, TIMES)
    for panel in (0, 1):
        drawn, wanted = window.execute_script(DRAWN, strip, panel)
        drawn[2:] = sorted(drawn[2:])  # depth grows downwards
        assert drawn == pytest.approx(wanted, abs=0.6)


def test_a_chart_in_a_tab_that_is_opened_late_has_its_curve(window: webdriver.Chrome) -> None:
    open_menu(window, "Curves")
    for axis in ("elevation beta, °", "off the beam's axis, °", "incidence alpha, °"):
        assert window.execute_script("return arguments[0].chartView.about.panels[0].curves.length", chart(window, axis))
