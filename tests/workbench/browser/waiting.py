"""Waiting for what a page comes to."""

import time
from collections.abc import Callable
from typing import Any

from selenium import webdriver
from selenium.common.exceptions import ElementClickInterceptedException, StaleElementReferenceException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

LONGEST_S = 60.0
TEXT = "return document.body.innerText"
AT_REST = """
const [element, done] = arguments, frame = () => new Promise(requestAnimationFrame);
const at = () => JSON.stringify(element.getBoundingClientRect());
(async () => { await frame(); const before = at(); await frame(); await frame(); done(before === at()); })();
"""


def until(found: Callable[[], Any], what: str = "it") -> Any:
    """Wait until something is so, and return it. what: is waited for, for the message."""
    ends_s = time.monotonic() + LONGEST_S
    while time.monotonic() < ends_s:
        if value := found():
            return value
        time.sleep(0.05)
    raise AssertionError(f"{what} never came")


def wait_for(window: webdriver.Chrome, text: str) -> None:
    """Wait until the page shows a text."""
    ends_s = time.monotonic() + LONGEST_S
    while text not in (shown := str(window.execute_script(TEXT))):
        assert time.monotonic() < ends_s, f"{text!r} never came: {shown[:500]}"
        time.sleep(0.1)


def is_at_rest(window: webdriver.Chrome, element: WebElement) -> bool:
    """Return whether an element stays where it is: a dialog grows as it opens, and a click at where it was misses."""
    return bool(window.execute_async_script(AT_REST, element))


def click(window: webdriver.Chrome, selector: str, label: str = "") -> None:
    """Click at the element that is seen and whose text ends so, as soon as nothing that moves in covers it."""

    def clicked() -> bool:
        try:
            found = window.find_elements(By.CSS_SELECTOR, selector)
            seen = next(each for each in found if each.is_displayed() and each.text.strip().endswith(label))
            if not is_at_rest(window, seen):
                return False
            seen.click()
        except (ElementClickInterceptedException, StaleElementReferenceException, StopIteration):
            return False
        return True

    until(clicked)


def open_menu(window: webdriver.Chrome, name: str) -> None:
    """Click at a tab."""
    click(window, ".q-tab", name)


def press(window: webdriver.Chrome, label: str) -> None:
    """Click at the button of that name that is seen."""
    click(window, "button, .q-btn, .q-item", label)


def unfold(window: webdriver.Chrome, icon: str = "visibility") -> None:
    """Show the tools behind a button of a tool bar, where it is too narrow for them."""
    buttons = window.find_elements(By.CSS_SELECTOR, ".tool-fold-button")
    for button in buttons:
        if button.is_displayed() and button.text.strip() == icon:
            button.click()


def field(window: webdriver.Chrome, label: str) -> WebElement:
    """Wait for the field of that label, and return it."""

    def seen() -> WebElement | None:
        inputs = f"//label[.//*[starts-with(text(), '{label}')]]//input | //input[@aria-label='{label}']"
        found = window.find_elements(By.XPATH, inputs)
        return next((each for each in found if each.is_displayed()), None)

    found: WebElement = until(seen)
    return found


def keys(window: webdriver.Chrome, *pressed: str) -> None:
    """Press keys, wherever the focus is."""
    ActionChains(window).send_keys(*pressed).perform()


def chord(window: webdriver.Chrome, key: str, with_key: str = Keys.CONTROL) -> None:
    """Press a key while another is held."""
    ActionChains(window).key_down(with_key).send_keys(key).key_up(with_key).perform()


def resized(window: webdriver.Chrome, width: int, height: int) -> None:
    """Give the page so many pixels."""
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    window.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
