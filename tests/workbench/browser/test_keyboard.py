"""Every menu by keys alone, in a real browser: reached, seen to have the focus, done, and left again."""

import io
from typing import Any

import numpy as np
import pytest
from PIL import Image
from selenium import webdriver
from selenium.webdriver.common.keys import Keys

from tests.workbench.browser.hand import Hand
from tests.workbench.browser.waiting import TEXT, chord, keys, until, wait_for

pytestmark = pytest.mark.slow

FOCUS = "return document.activeElement"
SHOWN = "[...document.querySelectorAll('div')].find((item) => item[arguments[0]] && item.clientWidth)"
VIEW = f"return {SHOWN}?.[arguments[0]]"
IN_DIALOG = "return document.activeElement.matches('body, .q-dialog, .q-dialog *')"
MENUS = (
    "Image processing", "Observer", "Simulator", "Demonstrator", "Utilities", "Assess", "Live", "Echogram", "Missions",
)  # fmt: skip


@pytest.fixture
def hand(window: webdriver.Chrome) -> Hand:
    return Hand(window)


def of(window: webdriver.Chrome, kind: str, what: str) -> Any:
    return window.execute_script(VIEW + what, kind)


def ping(window: webdriver.Chrome) -> int:
    bar = "[...document.querySelectorAll('[aria-label=ping]')].find((each) => each.clientWidth)"
    return int(window.execute_script(f"return {bar}.getAttribute('aria-valuenow')"))


def walk(window: webdriver.Chrome, kind: str, place: str) -> None:
    """Move the cross of the view that has the focus, from its middle, to a place: "[x, y]", an expression of `view`."""
    words = f"const view = {SHOWN}[arguments[0]], canvas = view.$refs.over ?? view.$refs.canvas, at = {place};"
    words += "return [at[0] - Math.round(canvas.clientWidth / 2), at[1] - Math.round(canvas.clientHeight / 2)]"
    found = window.execute_script(words, kind)
    for away, (back, on) in zip(
        found, ((Keys.ARROW_LEFT, Keys.ARROW_RIGHT), (Keys.ARROW_UP, Keys.ARROW_DOWN)), strict=True
    ):
        far, near = divmod(round(abs(away) / 4), 10)
        for _ in range(far):
            chord(window, on if away > 0 else back, Keys.SHIFT)
        keys(window, *[on if away > 0 else back] * near)


def test_keys_are_listed_and_dialogs_closed_by_escape(window: webdriver.Chrome) -> None:
    keys(window, "?")
    wait_for(window, "focus on the next or previous picture, plan or chart")
    keys(window, Keys.ESCAPE)
    until(lambda: not window.execute_script("return document.querySelector('.q-dialog__backdrop')"))
    keys(window, "o")
    wait_for(window, "opened last")
    for _ in range(25):  # what is behind it is not reached
        keys(window, Keys.TAB)
        until(lambda: window.execute_script(IN_DIALOG))
    keys(window, Keys.ESCAPE)
    until(lambda: not window.execute_script("return document.querySelector('.q-dialog__backdrop')"))


def test_a_slider_takes_its_arrows_and_a_view_its_cross(hand: Hand) -> None:
    window = hand.window
    keys(window, "1")
    wait_for(window, "against the truth: 3 right")
    hand.tab_to("high level")
    keys(window, Keys.ARROW_RIGHT)
    wait_for(window, "high level 5.5 → ")
    assert ping(window) == 0  # arrows were the slider's
    keys(window, "v")
    before = of(window, "fanView", ".zoom.factor")
    keys(window, Keys.ARROW_LEFT, Keys.ENTER)
    until(lambda: of(window, "fanView", ".pinned") not in (None, -1))
    keys(window, "+", "+")
    until(lambda: of(window, "fanView", ".zoom.factor") > before)
    keys(window, "0")
    until(lambda: of(window, "fanView", ".zoom.factor") == 1)
    assert ping(window) == 0
    hand.tab_to("ping")
    keys(window, Keys.ARROW_RIGHT)
    until(lambda: ping(window) == 1)
    keys(window, Keys.END)
    until(lambda: ping(window) > 100)
    keys(window, Keys.HOME)
    until(lambda: ping(window) == 0)


def test_an_object_is_marked_in_the_observers_plan(hand: Hand) -> None:
    window = hand.window
    keys(window, "2")
    wait_for(window, "mean GOSPA")
    hand.tab_to("ping")
    keys(window, Keys.END)
    until(lambda: of(window, "planView", ".all().some((each) => each.id)"))
    window.execute_script("document.activeElement.blur()")
    keys(window, "v")
    walk(window, "planView", "view.toCanvas(view.all().filter((each) => each.id && each.at).pop().at)")
    wanted = of(window, "planView", ".all().filter((each) => each.id && each.at).pop().id")
    keys(window, Keys.ENTER)
    until(lambda: f"track {wanted}" in str(of(window, "chartView", ".now.title")))


def test_an_object_is_put_into_a_scene_and_dragged(hand: Hand) -> None:
    window = hand.window
    keys(window, "3")
    wait_for(window, " of 401, ")
    hand.tab_to("New scene")
    keys(window, Keys.ENTER)
    wait_for(window, "not saved yet")
    until(lambda: of(window, "planView", ".handles().length") == 1)
    until(lambda: of(window, "planView", ".showsAll() ? 1 : 0") and of(window, "planView", ".extent()[1]") > 60)
    hand.tab_to("sphere")
    keys(window, Keys.ENTER)
    keys(window, "v")
    walk(window, "planView", "view.toCanvas([60, 8])")
    keys(window, Keys.ENTER)
    until(lambda: of(window, "planView", ".handles().some((each) => each.id.startsWith('objects[0]'))"))
    before = until(lambda: north(window))
    keys(window, " ", *[Keys.ARROW_UP] * 10, " ")
    until(lambda: north(window) > before + 1.0)


def north(window: webdriver.Chrome) -> float:
    place = of(window, "planView", ".handles().find((each) => each.id === 'objects[0].position_ned')?.at[0]")
    return float(place or 0.0)


def test_an_example_is_opened(hand: Hand) -> None:
    keys(hand.window, "4")
    wait_for(hand.window, "Worked example")
    hand.tab_to("Open", within=".q-card")
    keys(hand.window, Keys.ENTER)
    wait_for(hand.window, "gallery: Figure 11")


def test_a_ping_is_marked_in_utilities(hand: Hand) -> None:
    keys(hand.window, "5")
    wait_for(hand.window, "Bookmarks")
    hand.tab_to("mark the ping that is shown as")
    keys(hand.window, "first")
    hand.tab_to("Mark")
    keys(hand.window, Keys.ENTER)
    wait_for(hand.window, ": first")


def test_a_setting_is_swept(hand: Hand) -> None:
    keys(hand.window, "6")
    wait_for(hand.window, "Sweep of one setting")
    hand.tab_to("setting")
    keys(hand.window, "high level")
    until(lambda: len(hand.window.execute_script("return document.querySelectorAll('.q-menu .q-item')")) == 1)
    keys(hand.window, Keys.ARROW_DOWN, Keys.ENTER)
    hand.tab_to("Sweep")
    keys(hand.window, Keys.ENTER)
    wait_for(hand.window, "detect.two_level: high level: 8 values")


def test_a_ping_is_chosen_in_the_echogram(hand: Hand) -> None:
    window = hand.window
    keys(window, "8")
    until(lambda: of(window, "echogramView", "?.frame"))
    until(lambda: "read:" not in window.execute_script(TEXT))
    window.execute_script("document.activeElement.blur()")
    keys(window, "v", Keys.ENTER)
    until(lambda: of(window, "echogramView", ".now.cursor") > 50)


def test_a_mission_is_chosen(hand: Hand) -> None:
    window = hand.window
    keys(window, "9")
    wait_for(window, "campaigns of ODS")
    hand.tab_to("campaigns of ODS")
    keys(window, Keys.ARROW_DOWN, Keys.ARROW_DOWN, Keys.ENTER)
    wait_for(window, "mission 0")
    keys(window, Keys.TAB, Keys.TAB)
    until(lambda: "mission" in window.execute_script(FOCUS).text)
    keys(window, Keys.ENTER)
    wait_for(window, "stop")
    hand.tab_to("stop")
    keys(window, Keys.ENTER)


@pytest.mark.parametrize("menu", MENUS)
def test_tab_goes_round_the_menu(window: webdriver.Chrome, menu: str) -> None:
    keys(window, Keys.ESCAPE)
    window.execute_script("document.activeElement.blur()")
    keys(window, str(MENUS.index(menu) + 1))
    until(lambda: window.execute_script("return document.getElementById('menus').dataset.shown") == menu)
    until(lambda: f"opening {menu}" not in window.execute_script(TEXT))
    visited: list[Any] = []
    for _ in range(200):
        keys(window, Keys.TAB)
        now = window.execute_script(FOCUS)
        if visited and now == visited[0]:
            break
        visited.append(now)
    assert now == visited[0]
    missed = window.execute_script(MISSED, visited)
    assert missed == []


MISSED = """
const visited = new Set(arguments[0]);
const all = [...document.querySelectorAll("button, [tabindex='0'], input, textarea")];
const isSeen = (one) => one.offsetParent && one.clientWidth && getComputedStyle(one).visibility === "visible";
return all.filter((one) => isSeen(one) && !one.disabled && one.tabIndex >= 0 && !visited.has(one))
  .map((one) => one.outerHTML.slice(0, 120));
"""


def test_the_focus_is_seen(hand: Hand) -> None:
    window = hand.window
    keys(window, "1")
    wait_for(window, "Cost of one ping")
    for label in ("all steps", "runs; off: bypassed", "high level", "fan", "sonar image", "ping"):
        hand.tab_to(label)
        with_focus = shown(window)
        window.execute_script("document.activeElement.blur()")
        assert np.abs(with_focus - shown(window)).max() > 20, label


def shown(window: webdriver.Chrome) -> Any:
    moves = "return document.getAnimations().some((each) => each.playState === 'running')"
    until(lambda: not window.execute_script(moves))
    return np.asarray(Image.open(io.BytesIO(window.get_screenshot_as_png())).convert("L"), np.int16)
