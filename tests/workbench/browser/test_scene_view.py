"""The mission in three dimensions, where the sonar tells heights, in a real browser."""

import re
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from ods.base.files.shipped import shipped_file
from tests.workbench.browser.test_narrow import SIDEWAYS
from tests.workbench.browser.waiting import TEXT, chord, keys, open_menu, press, resized, until, wait_for
from tests.workbench.serving import serving

pytestmark = pytest.mark.slow

BUTTON = "return [...document.querySelectorAll('button')].find((each) => each.innerText.includes('3-D'))"
CARD = "return [...document.querySelectorAll('.q-dialog .q-card')].find((card) => card.offsetParent !== null)"


def choose_sonar(window: webdriver.Chrome, sonar: str) -> None:
    open_menu(window, "Simulator")
    label = until(
        lambda: [
            each for each in window.find_elements(By.XPATH, "//label[.//*[text()='sonar']]") if each.is_displayed()
        ]
    )
    label[0].click()
    until(lambda: [each for each in window.find_elements(By.CSS_SELECTOR, ".q-menu .q-item") if each.text == sonar])
    press(window, sonar)


def test_a_sonar_that_tells_heights_has_a_view_of_them(window: webdriver.Chrome, tmp_path: Path) -> None:
    text = shipped_file("scenes/figure11.toml").read_text()
    (tmp_path / "high.toml").write_text(re.sub(r"duration_s = .*", "duration_s = 8.0", text))
    with serving(str(tmp_path / "high.toml"), folder=tmp_path) as server:
        window.get(server.link)
        wait_for(window, "open a scene of ODS")
        choose_sonar(window, "seabat6012_3plane")
        open_menu(window, "Observer")
        until(lambda: (button := window.execute_script(BUTTON)) and button.is_enabled())
        window.execute_script("document.activeElement.blur()")
        for _ in range(4):
            chord(window, Keys.ARROW_RIGHT, Keys.SHIFT)
        wait_for(window, "track 1 (")
        press(window, "3-D")
        canvas = until(lambda: window.find_elements(By.CSS_SELECTOR, ".q-dialog canvas"))[0]
        until(lambda: re.search(r"ping \d+\. Orange", str(window.execute_script(TEXT))))
        until(lambda: re.search(r"track \d \(", str(window.execute_script(CARD).text)))
        for width, height in ((1440, 900), (1024, 700)):
            resized(window, width, height)
            until(lambda: canvas.size["width"] == 900)
            assert window.execute_script(SIDEWAYS) == []
            assert window.execute_script(CARD).rect["y"] >= 0
        keys(window, Keys.ESCAPE)
        until(lambda: window.execute_script(CARD) is None)
        choose_sonar(window, "seabat6012")
        open_menu(window, "Observer")
        until(lambda: not window.execute_script(BUTTON).is_enabled())
