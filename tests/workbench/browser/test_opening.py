"""The open dialog in a real browser: by keys alone, from a folder, from this computer, and again from the list."""

import os
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from tests.workbench.browser.test_narrow import SIDEWAYS
from tests.workbench.browser.waiting import keys, press, resized, until, wait_for
from tests.workbench.serving import PROJECT

pytestmark = pytest.mark.slow

DATA = "return document.querySelector('header').innerText"
DIALOG = "return [...document.querySelectorAll('.q-dialog .q-card')].find((card) => card.offsetParent !== null)"


def opened(window: webdriver.Chrome) -> None:
    """Open the dialog by its key."""
    until(lambda: window.execute_script(DIALOG) is None)
    keys(window, "o")
    until(lambda: window.execute_script(DIALOG) is not None)


def send(window: webdriver.Chrome, file: Path) -> None:
    """Choose a file of the browser's computer."""
    window.find_element(By.CSS_SELECTOR, ".q-dialog input[type=file]").send_keys(str(file))


def test_a_scene_is_opened_from_its_folder(window: webdriver.Chrome) -> None:
    opened(window)
    press(window, "scenes of ODS")
    wait_for(window, "worked_example.toml")
    press(window, "arrow_upward")
    wait_for(window, "config_files: ")
    press(window, "scenes of ODS")
    wait_for(window, "scenes: ")
    for item in window.find_elements(By.CSS_SELECTOR, ".q-dialog .q-item"):
        if "worked_example.toml" in item.text:
            item.send_keys(Keys.ENTER)
            break
    until(lambda: "worked_example.toml" in window.execute_script(DATA))


def test_a_file_of_this_computer_is_kept_in_the_users_folder(window: webdriver.Chrome) -> None:
    opened(window)
    send(window, PROJECT / "tests" / "data" / "aris" / "sample.aris")
    until(lambda: "sample.aris" in window.execute_script(DATA))
    kept = Path(os.environ["ODS_DATA_DIR"], "ods", "uploads", "sample.aris")
    assert kept.read_bytes() == (PROJECT / "tests" / "data" / "aris" / "sample.aris").read_bytes()


def test_what_is_none_of_ours_is_one_line_and_not_kept(window: webdriver.Chrome, tmp_path: Path) -> None:
    opened(window)
    (tmp_path / "bad.s7k").write_bytes(b"nonsense" * 100)
    send(window, tmp_path / "bad.s7k")
    wait_for(window, "not kept: bad.s7k")
    assert not Path(os.environ["ODS_DATA_DIR"], "ods", "uploads", "bad.s7k").exists()
    (tmp_path / "virus.exe").write_bytes(b"MZ")
    send(window, tmp_path / "virus.exe")
    wait_for(window, "not taken: one file")
    keys(window, Keys.ESCAPE)
    until(lambda: window.execute_script(DIALOG) is None)


def test_what_was_opened_last_is_offered_and_opened_again(window: webdriver.Chrome) -> None:
    opened(window)
    wait_for(window, "opened last")
    until(lambda: "sample.aris" in window.execute_script(DIALOG).text)
    row = next(row for row in window.find_elements(By.CSS_SELECTOR, ".q-dialog .q-item") if "worked_exa" in row.text)
    row.click()
    until(lambda: "worked_example.toml" in window.execute_script(DATA))


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1024, 700)])
def test_nothing_is_cut_off(window: webdriver.Chrome, width: int, height: int) -> None:
    resized(window, width, height)
    opened(window)
    card = window.execute_script(DIALOG)
    until(lambda: card.size["height"] > 300)
    assert card.size["height"] <= height - 40
    assert window.execute_script("return arguments[0].scrollHeight - arguments[0].clientHeight", card) <= 1
    assert window.execute_script(SIDEWAYS) == []
    keys(window, Keys.ESCAPE)
