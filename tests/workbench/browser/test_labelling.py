"""Labels drawn over a real recording: counted against, undone, saved, and read by `ods assess detect`."""

import re
from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from ods.assess.images.labels import Box, read_boxes
from ods.sonar_link.files.opening import open_pings
from tests.workbench.browser.conftest import Shared
from tests.workbench.browser.test_narrow import SIDEWAYS
from tests.workbench.browser.test_truth import VIEW, counts
from tests.workbench.browser.waiting import chord, field, keys, open_menu, press, resized, until, wait_for
from tests.workbench.serving import PROJECT

pytestmark = pytest.mark.slow

RECORDING = PROJECT / "tests" / "data" / "aris" / "sample.aris"
LABELS = f"{VIEW} return view?.frame?.labels ?? [];"
CANVAS = (
    VIEW
    + """
const { projection } = view.project(), at = view.$refs.over.getBoundingClientRect();
const { borders, first_m } = projection.geometry;
return arguments[0].map(([beam, sample]) => {
  const middle = 0.5 * (borders[beam] + borders[beam + 1]);
  const [x, y] = projection.toCanvas(first_m + (sample + 0.5) * view.frame.dr_m, middle);
  return [Math.round(at.left + x), Math.round(at.top + y)];
});
"""
)


def labels(window: webdriver.Chrome) -> list[Any]:
    found: list[Any] = window.execute_script(LABELS)
    return found


def draw(window: webdriver.Chrome, first: tuple[int, int], last: tuple[int, int]) -> None:
    """Drag from one beam and sample to another."""
    (x0, y0), (x1, y1) = window.execute_script(CANVAS, [first, last])
    mouse = ActionChains(window, duration=50)
    mouse.w3c_actions.pointer_action.move_to_location(x0, y0).pointer_down()
    mouse.w3c_actions.pointer_action.move_to_location((x0 + x1) // 2, (y0 + y1) // 2)
    mouse.w3c_actions.pointer_action.move_to_location(x1, y1).pointer_up()
    mouse.perform()


@pytest.fixture(scope="module", autouse=True)
def opened(window: webdriver.Chrome, shared: Shared) -> None:
    """Open a copy of a recording that the server may read."""
    (shared.folder / "dive.aris").write_bytes(RECORDING.read_bytes())
    open_menu(window, "Image processing")
    keys(window, "o")
    field(window, "path of a file").send_keys(str(shared.folder / "dive.aris"), Keys.ENTER)
    until(lambda: window.execute_script(f"{VIEW} return view?.frame?.beams === 48;"))
    until(lambda: window.execute_script("return document.querySelector('.q-dialog') === null"))


def test_what_is_drawn_is_a_label_and_detections_are_judged_by_it(window: webdriver.Chrome) -> None:
    assert counts(window) == {}
    keys(window, "l")
    field(window, "what it looks like").send_keys("wedge")
    draw(window, (9, 1380), (27, 1515))
    ((first, last, begin, end, shape, text),) = until(lambda: labels(window))
    assert (shape, text) == ("rectangle", "wedge")
    assert (abs(first - 9) <= 1, abs(last - 27) <= 1, abs(begin - 1380) < 10, abs(end - 1515) < 10) == (True,) * 4
    reported = until(lambda: counts(window))
    assert reported["right"] + reported["missed"] == 1
    wait_for(window, "against your labels: ")


def test_an_ellipse_in_beams_beside_each_other(window: webdriver.Chrome) -> None:
    press(window, "ellipse")
    press(window, "polar")
    until(lambda: window.execute_script(f"{VIEW} return view.presentation === 'polar';"))
    draw(window, (2, 1350), (6, 1410))
    until(lambda: [each[4] for each in labels(window)] == ["rectangle", "ellipse"])
    until(lambda: sum(counts(window).get(word, 0) for word in ("right", "missed")) == 2)


def test_undo_takes_it_back_and_its_button_too(window: webdriver.Chrome) -> None:
    window.execute_script("document.activeElement.blur()")
    chord(window, "z")
    until(lambda: len(labels(window)) == 1)
    chord(window, "y")
    until(lambda: len(labels(window)) == 2)
    chips = window.find_elements(By.XPATH, "//button[contains(., 'wedge')]")
    next(chip for chip in chips if chip.is_displayed() and chip.text.endswith("2 wedge")).click()
    until(lambda: [each[4] for each in labels(window)] == ["rectangle"])


def test_saved_they_are_what_assess_reads_and_are_loaded_again(window: webdriver.Chrome, shared: Shared) -> None:
    press(window, "Save")
    file = shared.folder / "dive-labels.txt"
    until(file.exists)
    wait_for(window, "written: ")
    ((first, last, begin, end, _, text),) = labels(window)
    assert list(read_boxes(file, open_pings(RECORDING).pings)) == [Box(0, first, last, begin, end, text)]
    file.write_text(file.read_text() + "3 8 40 1215 1395 line\n")
    press(window, "Load")
    wait_for(window, "labels: 2, frames with labels: 2")
    file.write_text("0 1 99 3 4\n")
    press(window, "Load")
    wait_for(window, "dive-labels.txt:1: not `frame beam beam sample sample` of the recording")
    assert re.search("labels: 2, frames", str(window.execute_script("return document.body.innerText")))


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1024, 700)])
def test_nothing_is_cut_off(window: webdriver.Chrome, width: int, height: int) -> None:
    resized(window, width, height)
    until(lambda: labels(window))
    assert window.execute_script(SIDEWAYS) == []

    until(lambda: "file of labels" in window.execute_script("return document.body.innerText"))
