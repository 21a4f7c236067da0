"""The whole workbench in a real browser: every menu opens, a link shows what it says, and nothing leaves the host."""

import importlib.util
from functools import partial
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.common.by import By

from ods.workbench.model.actions import SetSetting
from ods.workbench.model.apply import apply
from ods.workbench.model.share import shared_text
from ods.workbench.pages.frame import MENUS, SERVER_GONE
from ods.workbench.start import first_state
from tests.workbench.browser.waiting import open_menu, until, wait_for
from tests.workbench.chromium import chromium, programs, requested
from tests.workbench.serving import serving
from tests.workbench.test_command import arguments, loaded_by

pytestmark = pytest.mark.slow

POPUP = """
const popup = document.getElementById("popup");
return popup.getAttribute("aria-hidden") === "false" ? getComputedStyle(popup, "::after").content : "";
"""
BUILT = """
const shown = [...document.getElementById("menus").children].filter((item) => item.clientHeight);
return shown.length === 1 && !shown[0].innerText.includes(`opening ${arguments[0]}`);
"""
SCENE = Path(__file__).parents[3] / "config" / "scenes" / "figure11.toml"


def opens(window: webdriver.Chrome, menu: str) -> bool:
    """Tell whether a click reached the tab."""
    try:
        open_menu(window, menu)
    except (StopIteration, StaleElementReferenceException):
        return False
    return True


def test_every_menu_opens_a_link_is_shown_and_nothing_leaves_the_host(tmp_path: Path) -> None:
    programs()
    words = arguments(str(SCENE))
    shared = apply(first_state(words, loaded_by(words)), SetSetting("tracker.observer", "independent"))
    with serving(str(SCENE)) as server, chromium(tmp_path / "profile") as window:
        window.get(f"{server.link}#state={shared_text(shared)}")
        wait_for(window, "what was shared")  # the undo button says what it would undo
        assert "#" not in window.current_url
        for menu in (menu for menu in MENUS if importlib.util.find_spec(menu.module)):
            # waited for each time: a page that was slow to come is drawn again when it is there
            until(partial(opens, window, menu.name))
            until(partial(window.execute_script, BUILT, menu.name))
            assert "cannot be shown" not in window.find_element(By.TAG_NAME, "body").text, menu.name
        hosts = {urlsplit(address).hostname for address in requested(window) if address.startswith(("http", "ws"))}
        assert hosts == {"127.0.0.1"}
        errors = [line for line in window.get_log("browser") if line["level"] == "SEVERE"]
        assert errors == []
        server.process.terminate()
        assert SERVER_GONE in until(lambda: window.execute_script(POPUP))
