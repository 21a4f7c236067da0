"""Two browsers at once on one server, each with a state of its own; and every menu by keys alone."""

import re
import time
from functools import partial

import pytest
from selenium import webdriver

from tests.workbench.browser.conftest import Shared
from tests.workbench.browser.waiting import TEXT, chord, keys, until, wait_for
from tests.workbench.chromium import chromium

pytestmark = pytest.mark.slow

MENUS = (
    "Image processing", "Observer", "Simulator", "Demonstrator", "Utilities", "Assess", "Live", "Echogram", "Missions",
)  # fmt: skip
SHOWN = "return document.querySelector('header .q-tab--active')?.innerText"
PATIENCE_S = 20.0
DARK = "return document.body.classList.contains('body--dark')"


def shows(window: webdriver.Chrome, key: str, menu: str) -> bool:
    """Press a key, and tell whether its menu is shown soon: on a busy computer the page may be drawn anew just then."""
    keys(window, key)
    ends_s = time.monotonic() + PATIENCE_S
    while menu not in str(window.execute_script(SHOWN)) and time.monotonic() < ends_s:
        time.sleep(0.05)
    return menu in str(window.execute_script(SHOWN))


def test_every_menu_is_opened_by_its_key(window: webdriver.Chrome) -> None:
    for number, menu in enumerate(MENUS, 1):
        until(partial(shows, window, str(number), menu))
    until(lambda: "opening " not in str(window.execute_script(TEXT)))
    assert "cannot be shown" not in str(window.execute_script(TEXT))


def test_what_one_browser_does_the_other_does_not_see(
    window: webdriver.Chrome, shared: Shared, tmp_path_factory: pytest.TempPathFactory
) -> None:
    with chromium(tmp_path_factory.mktemp("other"), logged=False) as other:
        other.get(shared.links.pop())
        found = until(lambda: re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", shared.server.line()))
        shared.links.append(found[0])
        wait_for(other, "Image processing")
        assert window.execute_script(DARK)
        keys(window, "d")
        until(lambda: not window.execute_script(DARK))
        keys(other, "1")
        until(lambda: "Image processing" in str(other.execute_script(SHOWN)))
        assert other.execute_script(DARK)
        assert "Image processing" not in str(window.execute_script(SHOWN))
        chord(window, "z")
        until(lambda: window.execute_script(DARK))
