"""Menu Missions in a real browser: the worst missions of a campaign, and one flown again by a click."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from ods.cli import main
from tests.workbench.browser.waiting import TEXT, open_menu, press, until, wait_for
from tests.workbench.chromium import chromium, programs
from tests.workbench.serving import serving

pytestmark = pytest.mark.slow

CAMPAIGN = """
seed = 3
missions = 2
arms = ["ods"]
[world]
length_m = 40.0
width_m = 40.0
obstacles_per_hectare = 60.0
free_start_m = 10.0
free_goal_m = 5.0
"""

ITEMS = """
const items = [...document.querySelectorAll(".q-item")].filter((item) => item.offsetParent);
return items.map((item) => item.innerText.trim());
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("missions")
    campaign = folder / "small.toml"
    campaign.write_text(CAMPAIGN)
    assert main(["missions", str(campaign), "--out", str(folder / "out")]) == 0
    return folder


@pytest.fixture(scope="module")
def window(results: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    programs()
    with serving(folder=results) as server, chromium(tmp_path_factory.mktemp("profile")) as window:
        window.get(server.link)
        wait_for(window, "Missions")
        open_menu(window, "Missions")
        wait_for(window, "Choose a mission")
        yield window


def offered(window: webdriver.Chrome) -> list[str]:
    """Return the lines of the missions that can be clicked at."""
    found: list[str] = window.execute_script(ITEMS)
    return [line for line in found if ", mission " in line]


def open_path(window: webdriver.Chrome, path: Path) -> None:
    field = window.find_element(By.CSS_SELECTOR, "input[aria-label^='folder of ods missions']")
    field.send_keys(Keys.CONTROL + "a")
    field.send_keys(str(path), Keys.ENTER)


def test_the_worst_come_first_and_a_click_flies_one_to_the_same_end(window: webdriver.Chrome, results: Path) -> None:
    open_path(window, results / "out")
    first, second = until(lambda: offered(window))
    worst, next_worst = (float(line.partition("clearance ")[2].partition(" m")[0]) for line in (first, second))
    assert worst <= next_worst
    press(window, first)
    until(lambda: window.execute_script(TEXT).count(first) == 2)  # in the list, and over the plan


def test_a_campaign_s_missions_can_be_flown_before_it_was(window: webdriver.Chrome, results: Path) -> None:
    open_path(window, results / "small.toml")
    until(lambda: offered(window) == [f"small, mission {number}: not run yet" for number in range(2)])


def test_what_is_no_campaign_is_said_in_a_line(window: webdriver.Chrome, results: Path) -> None:
    empty = results / "empty"
    empty.mkdir()
    open_path(window, empty)
    wait_for(window, "no missions.jsonl in it")
