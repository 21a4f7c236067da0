"""One server with figure 11 and one browser for all modules that ask for `window`; each gets a session of its own."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest
from selenium import webdriver

from tests.workbench.browser.waiting import until, wait_for
from tests.workbench.chromium import chromium, programs
from tests.workbench.serving import PROJECT, Serving, serving

SCENE = PROJECT / "config" / "scenes" / "figure11.toml"


class Shared(NamedTuple):
    server: Serving
    window: webdriver.Chrome
    links: list[str]
    """That nobody has used yet."""
    folder: Path
    """Files may be written there."""
    downloads: Path


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shared]:
    with running(tmp_path_factory, str(SCENE)) as made:
        yield made


@contextmanager
def running(folders: pytest.TempPathFactory, *words: str, folder: Path | None = None) -> Iterator[Shared]:
    """Run a workbench and a browser. folder: that it is started in."""
    programs()
    folder, downloads = folder or folders.mktemp("work"), folders.mktemp("downloads")
    with serving(*words, folder=folder) as server, chromium(folders.mktemp("profile")) as window:
        window.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(downloads)})
        yield Shared(server, window, [server.link], folder, downloads)


@pytest.fixture(scope="module")
def window(shared: Shared) -> webdriver.Chrome:
    """Return the browser with a page that nobody has touched, 1440 x 900 pixels."""
    return untouched(shared)


def untouched(shared: Shared) -> webdriver.Chrome:
    """Let the browser come as another that was never here."""
    window = shared.window
    window.get("about:blank")
    window.execute_cdp_cmd("Network.clearBrowserCookies", {})
    window.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    window.set_window_size(1440, 900)
    window.get_log("browser")
    window.get(shared.links.pop())
    found = until(lambda: re.search(r"http://127\.0\.0\.1:\d+/\?token=\S+", shared.server.line()))
    shared.links.append(found[0])
    wait_for(window, "Image processing")
    return window
