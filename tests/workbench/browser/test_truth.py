"""Right, false and missed in a real browser: counted beside the sliders, and drawn with signs of their own."""

import re
from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from tests.workbench.browser.test_narrow import SIDEWAYS
from tests.workbench.browser.waiting import TEXT, open_menu, unfold, until, wait_for

pytestmark = pytest.mark.slow

VIEW = "const view = [...document.querySelectorAll('div')].find((item) => item.fanView?.isShown())?.fanView;"
SIGNS = (
    VIEW
    + """
const context = view.$refs.over.getContext("2d"), write = context.fillText, said = [];
context.fillText = function (text, ...rest) {
  if (["✓", "✕", "?"].includes(text)) said.push(text);
  write.call(this, text, ...rest);
};
view.drawOver();
context.fillText = write;
return said.sort();
"""
)


@pytest.fixture(scope="module", autouse=True)
def opened(window: webdriver.Chrome) -> None:
    open_menu(window, "Image processing")
    wait_for(window, "against the truth: ")


def kinds(window: webdriver.Chrome) -> list[Any]:
    found: list[Any] = window.execute_script(f"{VIEW} return view.frame.circles.map((circle) => circle[3]).sort();")
    return found


def counts(window: webdriver.Chrome) -> dict[str, int]:
    """Return what is said beside the sliders: how many are right, false, missed."""
    said = re.search(r"against (?:the truth|your labels): (.*)", str(window.execute_script(TEXT)))
    return {word: int(count) for count, word in re.findall(r"(\d+) (right|false|missed)", said[1])} if said else {}


def test_what_is_there_is_right(window: webdriver.Chrome) -> None:
    reported = counts(window)
    assert (reported["right"], reported["missed"]) == (3, 0)
    assert kinds(window) == ["false"] * reported["false"] + ["right"] * 3
    assert window.execute_script(SIGNS) == ["✓"] * 3 + ["✕"] * reported["false"]


def test_a_level_that_is_raised_misses_them_at_once(window: webdriver.Chrome) -> None:
    label = next(each for each in window.find_elements(By.XPATH, "//*[text()='high level']") if each.is_displayed())
    row = label.find_element(By.XPATH, "./ancestor::*[descendant::input][1]")
    field = row.find_element(By.CSS_SELECTOR, "input")
    field.send_keys(Keys.CONTROL + "a")
    field.send_keys("100", Keys.ENTER)
    until(lambda: counts(window) == {"right": 0, "false": 0, "missed": 3})
    until(lambda: kinds(window) == ["missed"] * 3)
    assert window.execute_script(SIGNS) == ["?"] * 3


def test_without_truth_they_are_only_detections(window: webdriver.Chrome) -> None:
    window.find_element(By.CSS_SELECTOR, "body").send_keys(Keys.CONTROL + "z")
    until(lambda: counts(window).get("right") == 3)
    unfold(window)
    box = next(item for item in window.find_elements(By.CSS_SELECTOR, ".q-checkbox") if item.text == "truth")
    box.click()
    until(lambda: set(kinds(window)) == {"detection"})
    until(lambda: counts(window) == {})
    box.click()
    until(lambda: counts(window).get("right") == 3)


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1024, 700)])
def test_nothing_is_cut_off(window: webdriver.Chrome, width: int, height: int) -> None:
    window.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
    )
    assert window.execute_script(SIDEWAYS) == []
    assert counts(window)["right"] == 3
