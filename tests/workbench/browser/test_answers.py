"""A click is answered whatever the server does, and long work is done in processes that end with it."""

import os
import signal
from functools import partial
from pathlib import Path

import psutil
import pytest
from selenium import webdriver

from tests.workbench.browser.conftest import SCENE
from tests.workbench.browser.waiting import open_menu, until, wait_for
from tests.workbench.chromium import chromium, programs
from tests.workbench.serving import serving

pytestmark = pytest.mark.slow

SEEN = """
return [...document.querySelectorAll("#menus > *")].filter((item) => item.clientHeight).map((item) => item.innerText)
"""
CHOSEN = "return document.querySelector('header .q-tab--active').innerText"


def seen(window: webdriver.Chrome) -> str:
    """Return the text of the one menu that is shown."""
    (text,) = window.execute_script(SEEN)
    return str(text)


def is_opening(window: webdriver.Chrome, menu: str) -> bool:
    """Return whether nothing but the place of a menu is shown."""
    return seen(window).strip() == f"opening {menu} ..."


def test_a_click_is_answered_while_the_server_does_nothing_and_the_menu_comes_afterwards(tmp_path: Path) -> None:
    programs()
    with serving(str(SCENE)) as server, chromium(tmp_path / "profile") as window:
        window.get(server.link)
        wait_for(window, "New scene")
        os.kill(server.process.pid, signal.SIGSTOP)
        try:
            for menu in ("Echogram", "Live"):
                open_menu(window, menu)
                until(partial(is_opening, window, menu))
                assert menu in window.execute_script(CHOSEN)
        finally:
            os.kill(server.process.pid, signal.SIGCONT)
        wait_for(window, "No vehicle's bus is shown")
        open_menu(window, "Echogram")
        wait_for(window, "colours, dB")
        assert "opening Echogram" not in seen(window)


def test_simulator_and_tracking_have_processes_of_their_own_that_end_with_the_server(tmp_path: Path) -> None:
    programs()
    with serving(str(SCENE)) as server, chromium(tmp_path / "profile") as window:
        window.get(server.link)
        wait_for(window, "ping 0 of")  # the simulator's image
        process = psutil.Process(server.process.pid)
        assert process.children(recursive=True)
        open_menu(window, "Observer")
        wait_for(window, "detecting and tracking")
        children = process.children(recursive=True)
        assert len(children) >= 2
        libraries = {Path(each.path).name for each in process.memory_maps() if "/scipy/" in each.path}
        assert not {name for name in libraries if name.startswith(("_zeros", "_qhull"))}
    psutil.wait_procs(children, timeout=20.0)
    assert not any(each.is_running() and each.status() != psutil.STATUS_ZOMBIE for each in children)
