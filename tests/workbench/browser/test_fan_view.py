"""The fan view in a real browser: pixels of a known echo, pointer, keys of the mouse, and nothing off the host."""

import cmath
import math
import re
import time
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

import pytest
from selenium import webdriver
from selenium.common.exceptions import JavascriptException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from tests.workbench.chromium import chromium, programs, requested
from tests.workbench.serving import Serving, serving
from tests.workbench.web.demo import BEARING, DR_M, ECHO_BEAM, ECHO_SAMPLE

pytestmark = pytest.mark.slow

VIEWS = "return [...document.querySelectorAll('div')].filter((item) => item.fanView)"
WHERE_BRIGHT = """
const view = arguments[0].fanView, canvas = view.$refs.image;
const data = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
const levels = [...data].map((value) => (value >>> 24 ? value & 255 : -1));  // gray: red says it all
const highest = levels.reduce((most, level) => Math.max(most, level));
const places = levels.flatMap((level, at) => (level === highest ? [at] : []));
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
const x = mean(places.map((at) => at % canvas.width)), y = mean(places.map((at) => Math.floor(at / canvas.width)));
return [x + canvas.offsetLeft, y + canvas.offsetTop, highest];
"""


@pytest.fixture(scope="module")
def server() -> Iterator[Serving]:
    programs()
    with serving(module="tests.workbench.web.demo") as running:
        yield running


@pytest.fixture(scope="module")
def page(server: Serving, tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    with chromium(tmp_path_factory.mktemp("profile")) as window:
        window.get(server.link)
        until(lambda: [view for view in views(window) if drawn(window, view)], 2)
        click(window, "palette")
        yield window


def until(found: Callable[[], Any], wanted: object = True) -> Any:
    """Wait until something is `wanted`, or of that length."""
    for _ in range(600):
        value = found()
        if value == wanted or (isinstance(value, list) and len(value) == wanted):
            return value
        time.sleep(0.05)
    raise AssertionError(f"{value!r}, not {wanted!r}")


def views(window: webdriver.Chrome) -> list[WebElement]:
    found: list[WebElement] = window.execute_script(VIEWS)
    return found


def drawn(window: webdriver.Chrome, view: WebElement) -> int:
    return int(window.execute_script("return arguments[0].fanView.drawn.frames", view))


def prop(window: webdriver.Chrome, view: WebElement, name: str) -> Any:
    return window.execute_script("return arguments[0].fanView[arguments[1]]", view, name)


def click(window: webdriver.Chrome, name: str) -> None:
    window.find_element(By.ID, name).click()


def text(window: webdriver.Chrome, name: str) -> str:
    return window.find_element(By.ID, name).text


def place_of_echo(window: webdriver.Chrome, view: WebElement) -> tuple[float, float]:
    """Return where the echo has to be, px in the view: projected anew from the view's documented layout."""
    size = view.size
    width, height = size["width"] - 14 - 74, size["height"] - 26 - 24
    range_m, bearing = (ECHO_SAMPLE + 0.5) * DR_M, BEARING[ECHO_BEAM]
    edge, far = BEARING[-1] + 0.5 * (BEARING[1] - BEARING[0]), (2000 - 0.5) * DR_M
    if prop(window, view, "presentation") == "polar":
        return 14 + width * (0.5 + bearing / (2 * edge)), 26 + height * (1.0 - range_m / far)
    scale = 0.97 * min(width / (2 * far * math.sin(edge)), height / far)
    return 14 + 0.5 * width + scale * range_m * math.sin(bearing), 26 + 0.5 * height + scale * (
        0.5 * far - range_m * math.cos(bearing)
    )


def shown(window: webdriver.Chrome) -> list[tuple[Any, str]]:
    """Return presentation and session in each window of a browser."""
    reported = []
    for handle in window.window_handles:
        window.switch_to.window(handle)
        until(lambda: len(views(window)), 2)
        reported.append((prop(window, views(window)[0], "presentation"), text(window, "session")))
    return reported


@pytest.mark.parametrize("presentation", ["fan", "polar"])
def test_an_echo_is_drawn_where_it_belongs(page: webdriver.Chrome, presentation: str) -> None:
    if presentation == "polar":
        click(page, "presentation")
    view = views(page)[0]
    until(lambda: prop(page, view, "presentation"), presentation)
    until(lambda: prop(page, view, "palette"), "gray")
    time.sleep(0.3)
    x, y, level = page.execute_script(WHERE_BRIGHT, view)
    wanted_x, wanted_y = place_of_echo(page, view)
    assert (x, y) == (pytest.approx(wanted_x, abs=2.0), pytest.approx(wanted_y, abs=2.0))
    assert level == pytest.approx(255 * 40 / 51, abs=2)  # 30 dB on a scale of -10 to 41


def test_the_pointer_reads_place_and_level_and_a_click_pins(page: webdriver.Chrome) -> None:
    first, second = views(page)
    x, y = place_of_echo(page, first)
    size = first.size
    ActionChains(page).move_to_element_with_offset(
        first, round(x - size["width"] / 2), round(y - size["height"] / 2)
    ).click().perform()
    until(lambda: text(page, "picked"), str(ECHO_BEAM))
    range_m, bearing, level, beam, sample = (float(word) for word in text(page, "hovered").split())
    assert range_m == pytest.approx(ECHO_SAMPLE * DR_M, abs=0.3)
    assert bearing == pytest.approx(BEARING[ECHO_BEAM], abs=0.02)
    assert level == pytest.approx(30.0, abs=0.2)
    assert beam == ECHO_BEAM
    assert sample == pytest.approx(ECHO_SAMPLE, abs=6)
    until(lambda: prop(page, second, "pinned"), ECHO_BEAM)
    assert "30.0 dB" in page.execute_script("return arguments[0].fanView.readout()", second)  # the same place there


def test_zoom_brings_finer_cells_and_a_double_click_all_of_it(page: webdriver.Chrome) -> None:
    view = views(page)[0]
    coarse = page.execute_script("return arguments[0].fanView.frame.pool", view)
    assert coarse > 1
    for _ in range(12):
        ActionChains(page).scroll_from_origin(ScrollOrigin.from_element(view), 0, -100).perform()
    until(lambda: page.execute_script("return arguments[0].fanView.frame.pool", view), 1)
    ActionChains(page).double_click(view).perform()
    until(lambda: page.execute_script("return arguments[0].fanView.zoom.factor", view), 1)
    time.sleep(0.4)
    assert text(page, "picked") == str(ECHO_BEAM)  # neither of its clicks pinned another


def test_the_ruler_measures_between_two_places(page: webdriver.Chrome) -> None:
    view = views(page)[0]
    x, y = place_of_echo(page, view)
    size = view.size
    drag = ActionChains(page).key_down(Keys.SHIFT)
    drag.move_to_element_with_offset(view, round(x - size["width"] / 2), round(y - size["height"] / 2))
    drag.click_and_hold().move_by_offset(-60, 40).release().key_up(Keys.SHIFT).perform()
    read = page.execute_script("return arguments[0].fanView.reading()", view)
    apart, first, second, left, right = (float(number) for number in re.findall(r"-?\d+\.\d+", " ".join(read)))
    assert first == pytest.approx(ECHO_SAMPLE * DR_M, abs=0.3)
    assert left == pytest.approx(math.degrees(BEARING[ECHO_BEAM]), abs=0.5)
    width, height = size["width"] - 14 - 74, size["height"] - 26 - 24  # beams beside each other
    edge, far = BEARING[-1] + 0.5 * (BEARING[1] - BEARING[0]), (2000 - 0.5) * DR_M
    assert second == pytest.approx(first - 40 * far / height, abs=0.3)
    assert right == pytest.approx(left - math.degrees(60 * 2 * edge / width), abs=0.5)
    one, other = (cmath.rect(*place) for place in ((first, math.radians(left)), (second, math.radians(right))))
    assert apart == pytest.approx(abs(one - other), abs=0.1)
    assert page.execute_script("return arguments[0].fanView.reading()", views(page)[1]) == read  # in all views
    ActionChains(page).send_keys("m").send_keys(Keys.ESCAPE).perform()
    with pytest.raises(JavascriptException):
        page.execute_script("return arguments[0].fanView.reading()", view)


def test_a_new_frame_comes_by_itself(page: webdriver.Chrome) -> None:
    click(page, "next")
    view = views(page)[0]
    until(lambda: page.execute_script("return arguments[0].fanView.frame.caption", view), "ping 3")


def test_a_connection_that_breaks_comes_back_with_the_page_as_it_was(page: webdriver.Chrome) -> None:
    own = text(page, "session")
    page.execute_script("document.body.before = true; window.socket.io.engine.close()")
    until(lambda: page.execute_script("return window.socket.connected"), False)
    until(lambda: page.execute_script("return window.socket.connected"))
    click(page, "attention")
    until(lambda: prop(page, views(page)[0], "attention"))
    assert page.execute_script("return document.body.before")  # no reload
    assert text(page, "session") == own


def test_a_reload_keeps_the_state_and_another_browser_has_its_own_for_all_its_windows(
    page: webdriver.Chrome, server: Serving, tmp_path: Any
) -> None:
    until(lambda: prop(page, views(page)[0], "presentation"), "polar")
    own = text(page, "session")
    page.refresh()
    until(lambda: len(views(page)), 2)
    assert prop(page, views(page)[0], "presentation") == "polar"
    assert prop(page, views(page)[0], "pinned") == ECHO_BEAM
    assert text(page, "session") == own
    with chromium(tmp_path) as other:
        other.get(server.line().strip())
        for window in (page, other):
            window.switch_to.new_window("tab")
            window.get(server.origin)
        (_, theirs) = shown(other)[0]
        assert theirs != own
        assert shown(page) == [("polar", own)] * 2
        assert shown(other) == [("fan", theirs)] * 2
        click(other, "presentation")  # in its second window
        until(lambda: shown(other), [("polar", theirs)] * 2)
    page.close()
    page.switch_to.window(page.window_handles[0])


def test_nothing_is_asked_of_another_host(page: webdriver.Chrome, server: Serving) -> None:
    asked = requested(page)
    hosts = {urlsplit(url).netloc for url in asked if not url.startswith(("data:", "blob:", "chrome", "about:"))}
    assert any(url.endswith("/frames") for url in asked)
    assert hosts == {urlsplit(server.origin).netloc}
    assert [row["message"] for row in page.get_log("browser") if row["level"] == "SEVERE"] == []
