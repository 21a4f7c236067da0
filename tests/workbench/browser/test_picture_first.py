"""The picture fills the window in a real browser: folded columns, full screen, a narrow fan on its side, colours."""

import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

from tests.workbench.browser.test_narrow import SIDEWAYS
from tests.workbench.browser.waiting import open_menu, press, unfold, until, wait_for

pytestmark = pytest.mark.slow

VIEW = "const view = [...document.querySelectorAll('div')].find((item) => item.fanView && item.clientWidth).fanView;"
VIEWS = "return [...document.querySelectorAll('div')].filter((item) => item.fanView && item.clientWidth)"
SHARE = f"{VIEW} return view.$el.clientWidth * view.$el.clientHeight / (innerWidth * innerHeight);"
TOOLS = "return document.getElementById('processing-pictures').parentElement.firstElementChild.clientHeight"
BOTTOM = "return document.documentElement.scrollHeight - innerHeight"
NARROW = f"""{VIEW}
const Projection = view.project().projection.constructor;
const half = arguments[0] / 2, box = {{ x: 0, y: 0, width: 900, height: 300 }};
const geometry = {{ left: -half, right: half, near_m: 0, far_m: 10 }};
const seen = new Projection(geometry, "fan", box, {{ factor: 1, x: 0, y: 0 }});
const back = seen.toPlace(...seen.toCanvas(7, half / 2));
return [seen.toCanvas(0, 0), seen.toCanvas(10, 0), seen.toCanvas(10, half), back];
"""


@pytest.fixture(scope="module", autouse=True)
def opened(window: webdriver.Chrome) -> None:
    open_menu(window, "Image processing")
    wait_for(window, "keep as B")
    until(lambda: window.execute_script(f"{VIEW} return view.frame !== null"))


@pytest.mark.parametrize("size", [(1440, 900), (1024, 700)])
def test_f_gives_the_picture_the_window_and_back(window: webdriver.Chrome, size: tuple[int, int]) -> None:
    window.set_window_size(*size)
    small = window.execute_script(SHARE)
    ActionChains(window).send_keys("f").perform()
    until(lambda: window.execute_script(SHARE) > 1.3 * small)
    assert window.execute_script(BOTTOM) <= 0
    assert window.execute_script(TOOLS) < 60  # one row
    ActionChains(window).send_keys("f").perform()
    until(lambda: window.execute_script(SHARE) == pytest.approx(small, abs=0.01))


def test_a_picture_goes_full_screen(window: webdriver.Chrome) -> None:
    buttons = window.find_elements(By.CSS_SELECTOR, "button")
    next(button for button in buttons if button.is_displayed() and button.text.strip() == "fullscreen").click()
    until(lambda: window.execute_script("return document.fullscreenElement !== null"))
    until(lambda: window.execute_script(SHARE) > 0.95)
    window.execute_script("document.exitFullscreen()")
    until(lambda: window.execute_script("return document.fullscreenElement === null"))


def test_a_narrow_fan_lies_on_its_side_with_starboard_below(window: webdriver.Chrome) -> None:
    apex, ahead, starboard, place = window.execute_script(NARROW, 0.5)
    assert ahead[0] - apex[0] > 500  # upright it is at most 300 pixels long
    assert ahead[1] == pytest.approx(apex[1])
    assert starboard[1] > ahead[1]
    assert place == pytest.approx([7, 0.125])
    apex, ahead, starboard, _ = window.execute_script(NARROW, 2.0)
    assert ahead[0] == pytest.approx(apex[0])
    assert starboard[0] > ahead[0]


@pytest.mark.parametrize("size", [(1440, 900), (1024, 700)])
def test_the_tools_are_one_row_with_two_chains_as_well(window: webdriver.Chrome, size: tuple[int, int]) -> None:
    window.set_window_size(*size)
    press(window, "keep as B")
    until(lambda: len(window.execute_script(VIEWS)) == 2)
    assert window.execute_script(TOOLS) < 60
    assert window.execute_script(SIDEWAYS) == []
    if size[0] < 1200:
        unfold(window, "compare")
    press(window, "drop B")
    until(lambda: len(window.execute_script(VIEWS)) == 1)


def test_colours_are_chosen_on_the_page(window: webdriver.Chrome) -> None:
    unfold(window)
    assert window.execute_script(f"{VIEW} return view.palette") == "viridis"
    next(item for item in window.find_elements(By.CSS_SELECTOR, ".q-select") if "viridis" in item.text).click()
    until(lambda: [item for item in window.find_elements(By.CSS_SELECTOR, ".q-item") if item.text == "cividis"])
    press(window, "cividis")
    until(lambda: window.execute_script(f"{VIEW} return view.palette") == "cividis")
