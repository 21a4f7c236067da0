"""The frame of the page, without a browser: menus, undo and redo, keys, errors."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest
import pytest_asyncio
from nicegui import ui
from nicegui.testing import User

from ods.workbench.model.actions import OpenData, SetView
from ods.workbench.model.state import DataReference, State, View
from ods.workbench.pages import frame
from ods.workbench.pages.frame import Menu
from ods.workbench.session import Session
from ods.workbench.web.follow import PICTURE_FIRST_S
from tests.workbench.pages import menu_counts
from tests.workbench.pages.visiting import simulated

pytestmark = pytest.mark.slow

HERE = "tests.workbench.pages."
MENUS = (
    Menu("Counts", f"{HERE}menu_counts", "tune"),
    Menu("Not there yet", f"{HERE}menu_nowhere", "tune"),
    Menu("Fails", f"{HERE}menu_fails", "tune"),
)


@pytest.fixture
def session(monkeypatch: pytest.MonkeyPatch) -> Session:
    monkeypatch.setattr(frame, "MENUS", MENUS)
    menu_counts.built.clear()
    return Session(State(data=DataReference("file", "/data/pings.npz")))


@pytest_asyncio.fixture
async def user(session: Session) -> AsyncIterator[User]:
    async with simulated(lambda: frame.build(session)) as visitor:
        await visitor.open("/")
        yield visitor


async def changed() -> None:
    """Let the loop do what a change asked it to."""
    await asyncio.sleep(2.0 * PICTURE_FIRST_S)


def button(user: User, marker: str) -> Any:
    (found,) = user.find(marker=marker).elements
    return found


async def test_menus_are_built_once_when_they_are_opened(user: User) -> None:
    await user.should_see("pings.npz")
    await user.should_see("built 1")
    await user.should_not_see("Not there yet")
    assert len(menu_counts.built) == 1
    user.find("Fails").click()
    await user.should_see("Fails cannot be shown: no such thing")
    await user.should_not_see("built 1")
    user.find("Counts").click()
    await user.should_see("built 1")
    assert len(menu_counts.built) == 1


async def test_a_page_that_is_built_again_shows_the_menu_that_was_open(user: User) -> None:
    user.find("Fails").click()
    await user.open("/")
    await user.should_see("Fails cannot be shown")


async def test_undo_and_redo_say_what_they_do(user: User, session: Session) -> None:
    assert not button(user, "undo").enabled
    session.do(SetView("palette", "gray"))
    session.do(SetView("dark", False))
    await changed()
    assert button(user, "undo").text == session.history.undoes
    user.find(marker="undo").click()
    await changed()
    assert session.state.view == View(palette="gray")
    assert button(user, "redo").text == session.history.redoes
    assert button(user, "redo").enabled
    user.find(marker="redo").click()
    await changed()
    assert session.state.view == View(palette="gray", dark=False)
    assert not button(user, "redo").enabled


async def test_a_long_name_leaves_the_header_as_high_as_it_is(user: User, session: Session) -> None:
    session.do(OpenData(DataReference("file", f"/data/{'n' * 200}.npz")))
    await changed()
    assert len(button(user, "data").text) == frame.LONGEST_NAME


async def test_dark_and_light_follow_the_session(user: User, session: Session) -> None:
    (dark,) = user.find(ui.dark_mode).elements
    assert dark.value
    session.do(SetView("dark", False))
    await changed()
    assert not dark.value


@pytest.mark.parametrize(
    ("key", "modifiers", "palette"),
    [
        ("z", {"ctrl"}, "viridis"), ("z", {"meta"}, "viridis"), ("y", {"ctrl"}, "gray"),
        ("Z", {"ctrl", "shift"}, "gray"), ("z", set(), "cividis"), ("q", {"ctrl"}, "cividis"),
    ],
)  # fmt: skip
async def test_keys_undo_and_redo(user: User, session: Session, key: str, modifiers: set[str], palette: str) -> None:
    session.do(SetView("palette", "cividis"))
    session.do(SetView("dark", False))  # between them, so that they are two steps
    session.do(SetView("palette", "gray"))
    session.undo()
    for _ in range(2 if palette == "viridis" else 1):
        press(user, key, modifiers)
    assert session.state.view.palette == palette


@pytest.mark.parametrize(
    ("key", "modifiers", "shown"), [("p", set(), "polar"), ("P", {"shift"}, "polar"), ("p", {"alt"}, "fan")]
)
async def test_a_key_changes_the_presentation(
    user: User, session: Session, key: str, modifiers: set[str], shown: str
) -> None:
    press(user, key, modifiers)
    assert session.state.view.presentation == shown
    press(user, key, modifiers)
    assert session.state.view.presentation == "fan"


def press(user: User, key: str, modifiers: set[str]) -> None:
    (keyboard,) = user.find(ui.keyboard).elements
    (listener,) = [received for received in keyboard._event_listeners.values() if received.type == "key"]
    event = {"action": "keydown", "repeat": False, "key": key, "code": "", "location": 0}
    pressed = {f"{name}Key": name in modifiers for name in ("alt", "ctrl", "meta", "shift")}
    keyboard._handle_event({"listener_id": listener.id, "args": {**event, **pressed}})


async def test_the_overlay_lists_the_keys_of_frame_and_menus(user: User) -> None:
    press(user, "?", {"shift"})
    await user.should_see("fan or beams beside each other")
    await user.should_see("what this menu's key does")


def luminance(colour: str) -> float:
    """Return the relative luminance of WCAG 2.2."""
    parts = (byte / 255 for byte in bytes.fromhex(colour[1:]))
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(colour: str, behind: str) -> float:
    """Return the contrast ratio of WCAG 2.2."""
    darker, brighter = sorted((luminance(colour), luminance(behind)))
    return (brighter + 0.05) / (darker + 0.05)


@pytest.mark.parametrize(("style", "page", "card"), [("dark", "#121212", "#1d1d1d"), ("light", "#ffffff", "#ffffff")])
def test_what_failed_or_is_absent_can_be_read(style: str, page: str, card: str) -> None:
    """On the pages and cards of Quasar, whose own red has 2.9:1 and 2.6:1 in the dark."""
    assert contrast("#ffffff", "#000000") == pytest.approx(21.0)
    assert contrast("#c10015", card) < 4.5 or style == "light"
    for colour in frame.TEXT_COLOURS[style].values():
        assert min(contrast(colour, page), contrast(colour, card)) >= 4.5


async def test_an_error_is_one_line_on_the_page(user: User) -> None:
    user.find("fail").click()
    await user.should_see("that cannot be done")
