"""Real data beside synthetic ones, A and B told apart without colour, and a layout that stays, in a real browser."""

from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from tests.workbench.browser.conftest import Shared
from tests.workbench.browser.test_narrow import SIDEWAYS
from tests.workbench.browser.test_picture_first import VIEW, VIEWS
from tests.workbench.browser.waiting import chord, field, keys, open_menu, press, resized, until, wait_for
from tests.workbench.serving import PROJECT

pytestmark = pytest.mark.slow

FRAMES = f"{VIEWS}.map(({{fanView: view}}) => [view.frame?.beams, view.title]);"
DASHES = (
    VIEW
    + """
const done = arguments[0], context = view.$refs.over.getContext("2d"), { lineTo, stroke } = context, said = {};
import("ods-fan/marks.js").then(({ drawCircle }) => {
  for (const kind of ["detection", "only_a", "only_b"]) {
    let [dash, corners] = ["", 0];
    context.lineTo = function (...place) { corners += 1; lineTo.apply(this, place); };
    context.stroke = function () { dash = this.getLineDash().join(); stroke.call(this); };
    drawCircle(context, view.project().projection, [20, 0, 1, kind]);
    said[kind] = [dash, corners];
  }
  delete context.lineTo; delete context.stroke;
  done(said);
});
"""
)
SPLITTER = "return [...document.querySelectorAll('.q-splitter__before')].find((each) => each.clientWidth)?.clientWidth"


@pytest.fixture(scope="module", autouse=True)
def opened(window: webdriver.Chrome) -> None:
    open_menu(window, "Image processing")
    wait_for(window, "against the truth: ")


def frames(window: webdriver.Chrome) -> list[Any]:
    found: list[Any] = window.execute_script(FRAMES)
    return found


def choose(window: webdriver.Chrome, option: str) -> None:
    """Choose what is beside the picture."""
    label = next(
        each for each in window.find_elements(By.XPATH, "//label[.//*[text()='beside it']]") if each.is_displayed()
    )
    label.click()
    until(lambda: [each for each in window.find_elements(By.CSS_SELECTOR, ".q-menu .q-item") if option in each.text])
    press(window, option)
    window.execute_script("document.activeElement.blur()")


def test_a_recording_is_seen_beside_a_scene_by_the_same_chain(window: webdriver.Chrome, shared: Shared) -> None:
    (shared.folder / "beside.aris").write_bytes((PROJECT / "tests" / "data" / "aris" / "sample.aris").read_bytes())
    choose(window, "other data ...")
    field(window, "path of a file").send_keys(str(shared.folder / "beside.aris"), Keys.ENTER)
    until(lambda: [each[0] for each in frames(window)] == [60, 48])
    until(lambda: frames(window)[1][1].startswith("beside.aris: as recorded"))
    until(lambda: window.execute_script("return document.querySelector('.q-dialog') === null"))
    window.execute_script("document.activeElement.blur()")
    keys(window, Keys.ARROW_RIGHT)
    until(lambda: "ping 1," in str(window.execute_script(f"{VIEWS}[1].fanView.frame.caption")))


def test_the_value_under_the_pointer_is_told_in_both(window: webdriver.Chrome) -> None:
    views = window.execute_script(VIEWS)
    ActionChains(window).move_to_element(views[0]).perform()
    told = until(
        lambda: (
            (said := window.execute_script(f"{VIEWS}.map((item) => item.fanView.readout())"))
            and all("°" in each for each in said)
            and said
        )
    )
    assert all(" m" in each for each in told)


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1024, 700)])
def test_nothing_is_cut_off(window: webdriver.Chrome, width: int, height: int) -> None:
    resized(window, width, height)
    until(lambda: len(frames(window)) == 2)
    assert window.execute_script(SIDEWAYS) == []


def test_nothing_beside_it_again(window: webdriver.Chrome) -> None:
    resized(window, 1440, 900)
    choose(window, "nothing")
    until(lambda: [each[0] for each in frames(window)] == [60])
    chord(window, "z")
    until(lambda: [each[0] for each in frames(window)] == [60, 48])
    chord(window, "y")
    until(lambda: [each[0] for each in frames(window)] == [60])


def test_only_a_and_only_b_differ_in_dash_and_shape(window: webdriver.Chrome) -> None:
    said = window.execute_async_script(DASHES)
    assert said["detection"][0] == ""
    assert len({dash for dash, _ in said.values()}) == 3
    assert said["only_b"][1] < said["only_a"][1] == said["detection"][1]


def test_the_column_is_as_wide_as_one_drags_it_and_stays_so(window: webdriver.Chrome) -> None:
    before = window.execute_script(SPLITTER)
    bar = next(each for each in window.find_elements(By.CSS_SELECTOR, ".q-splitter__separator") if each.is_displayed())
    mouse = ActionChains(window).click_and_hold(bar)
    for _ in range(6):
        mouse.move_by_offset(20, 0)
    mouse.release().perform()
    until(lambda: window.execute_script(SPLITTER) == pytest.approx(before + 120, abs=3))
    window.execute_script("document.activeElement.blur()")
    keys(window, "f")
    until(lambda: not window.execute_script(SPLITTER))
    keys(window, "f")
    until(lambda: window.execute_script(SPLITTER) == pytest.approx(before + 120, abs=3))
    window.refresh()
    until(lambda: window.execute_script(SPLITTER) == pytest.approx(before + 120, abs=3))
