"""The echogram in a real browser: the whole mission is drawn where it belongs, and a click goes to its ping."""

from collections.abc import Iterator
from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

from tests.workbench.browser.test_narrow import SIDEWAYS
from tests.workbench.browser.waiting import open_menu, until, wait_for
from tests.workbench.chromium import chromium, programs
from tests.workbench.serving import serving

pytestmark = pytest.mark.slow

SCENE = """
duration_s = 6.0
seed = 1

[vehicle]
position_ned = [0.0, 0.0, 0.0]
velocity_ned = [0.6, 0.0, 0.0]

[[objects]]
shape = "sphere"
name = "rock"
position_ned = [30.0, 4.0, 0.0]
radius_m = 1.5

[[objects]]
shape = "sphere"
name = "boat"
position_ned = [40.0, -9.0, 0.0]
velocity_ned = [-0.5, 0.4, 0.0]
radius_m = 2.0

[image]
gain = 20000.0
noise_counts = 30.0
"""
VIEW = "const view = [...document.querySelectorAll('div')].find((item) => item.echogramView)?.echogramView;"
BRIGHTEST = (
    VIEW
    + """
const canvas = view.$refs.image, context = canvas.getContext("2d");
const place = arguments[0], range = arguments[1], box = view.box();
const x = Math.floor(view.toX(place + 0.5) - box.x);
const of = (metres) => Math.floor(view.toY(metres) - box.y);
const column = context.getImageData(x, of(range[0]), 1, of(range[1]) - of(range[0])).data;
const green = Array.from({ length: column.length / 4 }, (_, k) => column[4 * k + 1]);
return range[0] + ((green.indexOf(Math.max(...green)) + 0.5) / green.length) * (range[1] - range[0]);
"""
)


@pytest.fixture(scope="module")
def window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    programs()
    scene = tmp_path_factory.mktemp("scene") / "short.toml"
    scene.write_text(SCENE)
    with serving(str(scene)) as server, chromium(tmp_path_factory.mktemp("profile")) as window:
        window.get(server.link)
        wait_for(window, "Echogram")
        open_menu(window, "Echogram")
        until(lambda: asked(window, "view.frame && view.over.tracks.length && view.now.busy === ''"))
        until(lambda: "read:" not in window.find_element(By.TAG_NAME, "body").text)
        yield window


def asked(window: webdriver.Chrome, what: str) -> Any:
    return window.execute_script(f"{VIEW} return view && ({what});")


def at(window: webdriver.Chrome, place: int, range_m: float) -> ActionChains:
    """Return actions that begin with the pointer at a ping and a range."""
    x, y = asked(window, f"[view.toX({place} + 0.5), view.toY({range_m})]")
    over = asked(window, "view.$refs.over")
    left, top = over.size["width"] / 2, over.size["height"] / 2
    return ActionChains(window).move_to_element_with_offset(over, round(x - left), round(y - top))


def test_levels_stand_at_the_ranges_of_the_objects(window: webdriver.Chrome) -> None:
    for place in (3, 37):
        away_m = 0.6 * place * 0.14933
        near_m = ((30.0 - away_m) ** 2 + 16.0) ** 0.5 - 1.5  # of the rock's face
        assert window.execute_script(BRIGHTEST, place, [20.0, 34.0]) == pytest.approx(near_m, abs=0.9)


def test_tracks_and_truth_lie_on_the_objects(window: webdriver.Chrome) -> None:
    ways = asked(window, "[...view.over.tracks, ...view.over.truths]")
    last = {way["label"]: way["range_m"][-1] for way in ways}
    for name in ("rock", "boat"):
        (track,) = (label for label in last if label.startswith("track ") and f"({name})" in label)
        assert last[track] == pytest.approx(last[name], abs=2.0)
    assert asked(window, "view.over.invalid[0].first") == 0  # the tracker has just started


def test_a_click_goes_to_the_ping_in_all_menus(window: webdriver.Chrome) -> None:
    at(window, 25, 60.0).click().perform()
    until(lambda: asked(window, "view.now.cursor") == 25)
    open_menu(window, "Image processing")
    wait_for(window, "ping 25 of 41")
    open_menu(window, "Echogram")


def test_layers_are_switched_and_that_is_undone(window: webdriver.Chrome) -> None:
    assert asked(window, "view.strips().length") == 2
    box = next(item for item in window.find_elements(By.CSS_SELECTOR, ".q-checkbox") if item.text == "validity")
    box.click()
    until(lambda: asked(window, "view.strips().length") == 1)
    ActionChains(window).key_down("\ue009").send_keys("z").key_up("\ue009").perform()
    until(lambda: asked(window, "view.strips().length") == 2)


def test_one_beam_shows_what_is_in_it(window: webdriver.Chrome) -> None:
    field = next(item for item in window.find_elements(By.CSS_SELECTOR, "input[type=number]") if item.is_displayed())
    field.send_keys("2\ue007")
    wait_title = "view.now.title.includes('beam 2 at')"
    until(lambda: asked(window, wait_title))
    until(lambda: asked(window, "view.over.truths.length === 0"))  # far to port: neither rock nor boat
    cross = (item for item in window.find_elements(By.CSS_SELECTOR, ".q-field__focusable-action"))
    next(item for item in cross if item.is_displayed()).click()
    until(lambda: asked(window, "view.now.title.includes('all beams')"))
    until(lambda: asked(window, "view.over.truths.length === 2"))


def test_wheel_and_drag_show_a_part_and_a_double_click_all(window: webdriver.Chrome) -> None:
    over = asked(window, "view.$refs.over")
    window.execute_script(
        "arguments[0].dispatchEvent(new WheelEvent('wheel', "
        "{deltaY: -100, clientX: 700, clientY: 400, bubbles: true, cancelable: true}))",
        over,
    )
    part = until(lambda: asked(window, "view.part && view.part.place"))
    assert part[1] - part[0] == pytest.approx(41 / 1.25)
    at(window, 20, 50.0).click_and_hold().move_by_offset(100, 0).release().perform()
    until(lambda: asked(window, "view.part.place[0]") < part[0])
    at(window, 20, 50.0).double_click().perform()
    until(lambda: asked(window, "view.part === null"))


@pytest.mark.parametrize("size", [(1440, 900), (1024, 700)])
def test_the_menu_fits_its_window(window: webdriver.Chrome, size: tuple[int, int]) -> None:
    width, height = size
    window.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False},
    )
    until(lambda: asked(window, "view.$el.clientHeight") > 300)
    assert window.execute_script(SIDEWAYS) == []
    bottom = asked(window, "view.$el.getBoundingClientRect().bottom")
    assert bottom <= height
    errors = [line for line in window.get_log("browser") if line["level"] == "SEVERE"]
    assert errors == []
