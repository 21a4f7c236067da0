"""A small screen in a real browser, 1024 pixels wide: nothing is cut off sideways, no text lies on another."""

import pytest
from selenium import webdriver

from tests.workbench.browser.waiting import open_menu, until, wait_for

pytestmark = pytest.mark.slow

SIDEWAYS = """
const wider = (item) => item.scrollWidth > item.clientWidth + 1 && getComputedStyle(item).overflowX !== "visible";
const shown = [...document.querySelectorAll("html, .q-panel, .q-tabs__content")].filter((item) => item.clientWidth);
return shown.filter(wider).map((item) => item.className);
"""
CARD = """
const cards = [...document.querySelectorAll(".q-card")];
return cards.find((card) => card.innerText.includes("Speed against accuracy"))?.clientWidth;
"""
TEXTS = """
const shown = [...document.querySelectorAll("div")].find((item) => item.chartView?.chart && item.clientWidth);
const view = shown.chartView, all = view.chart.getZr().storage.getDisplayList(true);
const texts = all.filter((shape) => shape.type === "tspan" && !shape.ignore);
return [view.$el.clientWidth, texts.map((shape) => {
  const box = shape.getBoundingRect().clone();
  if (shape.transform) box.applyTransform(shape.transform);
  return [shape.style.text, box.x, box.y + box.height / 2, box.x + box.width];
})];
"""

LABELS = """
const done = arguments[0];
import("ods-charts").then(({ Labels }) => {
  const context = document.createElement("canvas").getContext("2d"), said = {};
  context.fillText = (text, x) => (said[text] = [x, x + context.measureText(text).width]);
  const labels = new Labels(context, { x: 50, y: 20, width: 250, height: 200 });
  labels.write("closest to 1: -1.3 m in 100 s", 180, 100, "red");
  labels.write("out of sight", 20, 100, "red");
  done(said);
});
"""


@pytest.fixture(scope="module", autouse=True)
def small(window: webdriver.Chrome) -> None:
    window.set_window_size(1024, 800)


def test_the_simulators_sliders_and_tabs_are_whole(window: webdriver.Chrome) -> None:
    open_menu(window, "Simulator")
    wait_for(window, "ping 0 of")
    assert window.execute_script(SIDEWAYS) == []


def test_the_observers_texts_are_apart_and_whole(window: webdriver.Chrome) -> None:
    open_menu(window, "Observer")
    wait_for(window, "mean GOSPA")
    until(lambda: "GOSPA, m" in [text for text, *_ in window.execute_script(TEXTS)[1]])
    width, said = window.execute_script(TEXTS)
    assert {"tentative", "two standard deviations", "time, s"} <= {text for text, *_ in said}
    for at, (text, left, y, right) in enumerate(said):
        assert left >= 0, text
        assert right <= width, text
        for other, its_left, its_y, its_right in said[at + 1 :]:
            assert abs(y - its_y) > 6 or right <= its_left or its_right <= left, (text, other)


def test_the_chart_of_assess_has_room_and_makes_room(window: webdriver.Chrome) -> None:
    open_menu(window, "Assess")
    assert until(lambda: window.execute_script(CARD)) > 600
    window.set_window_size(1440, 800)
    until(lambda: window.execute_script(SIDEWAYS) == [])


def test_a_long_label_in_a_narrow_plan_is_whole(window: webdriver.Chrome) -> None:
    ((text, (left, right)),) = window.execute_async_script(LABELS).items()
    assert text.startswith("closest")
    assert left >= 50
    assert right <= 300
