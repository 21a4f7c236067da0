"""A headless Chromium, driven by Selenium."""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from selenium import webdriver

REQUIRED = "ODS_REQUIRE_BROWSER"
"""Set where a missing browser is a failure, as in CI."""
OPTIONS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--window-size=1400,900",
)  # fmt: skip


def programs() -> tuple[str, str]:
    """Return where chromium and its driver are; without them the test is skipped, or fails if REQUIRED is set."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if browser and driver:
        return browser, driver
    why = f"no {'chromedriver (of chromium-driver)' if browser else 'chromium'} on this machine"
    if os.environ.get(REQUIRED):
        pytest.fail(f"{REQUIRED} is set, and there is {why}")
    pytest.skip(why)


@contextmanager
def chromium(folder: Path, logged: bool = True) -> Iterator[webdriver.Chrome]:
    """Run a browser whose profile is in an empty folder. logged: what it asks for and gets is kept until it is read."""
    browser, driver = programs()
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for option in (*OPTIONS, f"--user-data-dir={folder}"):
        options.add_argument(option)
    if logged:
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    window = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    try:
        yield window
    finally:
        window.quit()


def requested(window: webdriver.Chrome) -> list[str]:
    """Return the addresses that the browser has asked for since the last call."""
    messages: list[dict[str, Any]] = [json.loads(row["message"])["message"] for row in window.get_log("performance")]
    asked = [row["params"]["request"]["url"] for row in messages if row["method"] == "Network.requestWillBeSent"]
    return asked + [row["params"]["url"] for row in messages if row["method"] == "Network.webSocketCreated"]
