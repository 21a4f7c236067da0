"""A scene from nothing in a real browser: clicked, typed, copied, saved; what is typed belongs to its field."""

import re
from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from tests.workbench.browser.conftest import SCENE, Shared
from tests.workbench.browser.test_narrow import SIDEWAYS
from tests.workbench.browser.waiting import click, open_menu, press, unfold, until, wait_for

pytestmark = pytest.mark.slow

PLAN = "const view = [...document.querySelectorAll('div')].find((item) => item.planView && item.clientWidth)?.planView;"
HANDLES = PLAN + "return view.handles().map((each) => [each.id, ...each.at.map((m) => Math.round(100 * m) / 100)])"
SAVE = "return [...document.querySelectorAll('button')].find((each) => each.innerText.includes('Save ...'))?.id"
DIALOG = "return document.querySelector('.q-dialog')?.innerText ?? ''"
COVERED = "return [...document.querySelectorAll('.tool-fold')].filter((each) => each.clientHeight > 60)"
AT = PLAN + "return view.toCanvas(arguments[0])"


@pytest.fixture(scope="module", autouse=True)
def begun(window: webdriver.Chrome) -> None:
    open_menu(window, "Simulator")
    wait_for(window, "New scene")
    until(lambda: window.execute_script(f"{PLAN} return view?.view"))
    press(window, "New scene")
    wait_for(window, "not saved yet")
    until(lambda: [each[0] for each in handles(window)] == ["vehicle.position_ned"])
    wait_for(window, "ping 0 of")  # the first image: by it the plan is fitted


def handles(window: webdriver.Chrome) -> list[Any]:
    found: list[Any] = window.execute_script(f"{PLAN} if (!view) return []; {HANDLES.removeprefix(PLAN)}")
    return found


def of(window: webdriver.Chrome, place: int) -> list[float]:
    """Return north and east of an object."""
    return next((each[1:] for each in handles(window) if each[0] == f"objects[{place}].position_ned"), [])


def fields(window: webdriver.Chrome) -> list[WebElement]:
    """Return the numbers of the table, row by row: north, east, down, speed, course."""
    return window.find_elements(By.CSS_SELECTOR, ".q-dialog input[type=number]")


def values(window: webdriver.Chrome) -> list[str]:
    """Return what they show; the table is built anew at each change."""
    found: list[str] = window.execute_script(
        "return [...document.querySelectorAll('.q-dialog input[type=number]')].map((field) => field.value)"
    )
    return found


def write(window: webdriver.Chrome, field: WebElement, text: str) -> None:
    field.send_keys(Keys.CONTROL + "a")
    field.send_keys(text, Keys.TAB)


def test_an_object_is_put_where_the_plan_is_clicked(window: webdriver.Chrome) -> None:
    press(window, "sphere")
    wait_for_title = "return [...document.querySelectorAll('div')].find((item) => item.planView).planView.now.title"
    until(lambda: "click where" in window.execute_script(wait_for_title))
    canvas = window.execute_script(f"{PLAN} return view.$refs.canvas")
    x, y = window.execute_script(AT, [12.0, 3.0])
    size = canvas.size
    chain = ActionChains(window).move_to_element_with_offset(canvas, x - size["width"] / 2, y - size["height"] / 2)
    chain.click().perform()
    north, east = until(lambda: of(window, 0))
    assert (north, east) == pytest.approx((12.0, 3.0), abs=0.6)  # a pixel or two
    assert [round(10 * value, 6) % 1 for value in (north, east)] == [0.0, 0.0]  # snapped to 0.1 m


def test_numbers_are_typed_in_the_table_and_objects_copied(window: webdriver.Chrome) -> None:
    unfold(window, "more_horiz")
    press(window, "table_rows")
    until(lambda: len(fields(window)) == 5)
    write(window, fields(window)[0], "42.5")
    until(lambda: of(window, 0)[0] == 42.5)
    until(lambda: values(window)[:1] == ["42.5"])
    write(window, fields(window)[3], "1.5")
    until(lambda: values(window)[3:4] == ["1.5"])
    window.execute_script("document.querySelector('.q-dialog button').click()")
    until(lambda: len(values(window)) == 10)
    assert of(window, 1) == pytest.approx([42.5, of(window, 0)[1] + 5.0])
    assert values(window)[8] == "1.5"
    ActionChains(window).send_keys(Keys.ESCAPE).perform()
    until(lambda: not values(window))


def test_undo_in_a_text_field_is_the_fields_own(window: webdriver.Chrome) -> None:
    until(lambda: len(handles(window)) >= 3)
    field = next(item for item in window.find_elements(By.CSS_SELECTOR, "input[type=number]") if item.is_displayed())
    before = field.get_attribute("value")
    field.send_keys("7")
    field.send_keys(Keys.CONTROL + "z")
    until(lambda: field.get_attribute("value") == before)
    field.send_keys(Keys.TAB)
    assert len([each for each in handles(window) if each[0].endswith(".position_ned")]) == 3  # nothing was undone
    window.execute_script("document.activeElement.blur()")
    ActionChains(window).key_down(Keys.CONTROL).send_keys("z").key_up(Keys.CONTROL).perform()
    until(lambda: not of(window, 1))


def test_saving_proposes_a_free_name_and_follows(window: webdriver.Chrome, shared: Shared) -> None:
    button = window.execute_script(SAVE)
    press(window, "Save ...")
    named = "return document.querySelector('.q-dialog input')?.value"
    until(lambda: window.execute_script(named) == str(shared.folder / "scene.toml"))
    click(window, ".q-dialog button", "Save")
    wait_for(window, "scene scene.toml")
    text = (shared.folder / "scene.toml").read_text()
    assert re.search(r"position_ned = \[42.5, ", text)
    until(lambda: window.execute_script(SAVE) not in (None, button))  # the menu is built anew
    press(window, "Save ...")
    until(lambda: "no difference" in window.execute_script(DIALOG))
    assert window.execute_script(named) == str(shared.folder / "scene.toml")
    ActionChains(window).send_keys(Keys.ESCAPE).perform()
    assert SCENE.is_file()


@pytest.mark.parametrize("size", [(1440, 900), (1024, 700)])
def test_the_menu_fits_its_window(window: webdriver.Chrome, size: tuple[int, int]) -> None:
    window.set_window_size(*size)
    until(lambda: window.execute_script(f"{PLAN} return view?.$el.clientWidth"))
    assert window.execute_script(SIDEWAYS) == []
    bars = [item for item in window.find_elements(By.CSS_SELECTOR, ".tool-bar") if item.is_displayed()]
    assert all(bar.size["height"] < 60 for bar in bars)
    assert window.execute_script(COVERED) == []
