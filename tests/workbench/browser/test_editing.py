"""What the hand does in a real browser: way-points, thresholds and stages dragged, A against B, keys, a macro."""

import math
import re
import threading
import time
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from ods.base.files.shipped import shipped_file
from ods.workbench.engine.files.macro_run import MacroRun
from tests.workbench.browser.waiting import open_menu, press, until, wait_for
from tests.workbench.chromium import chromium, programs, requested
from tests.workbench.serving import Serving, serving

pytestmark = pytest.mark.slow

STANDS = "position_ned = [0.0, 0.0, 20.0]\nvelocity_ned = [0.3, 0.0, 0.0]\n"
SAILS = """waypoints = [
    { t_s = 0.0, position_ned = [0.0, 0.0, 20.0] },
    { t_s = 60.0, position_ned = [18.0, 0.0, 20.0] },
]
"""
WAYPOINT = "vehicle.waypoints[1].position_ned"
SHOWN = "return [...document.querySelectorAll('div')].filter((item) => item[arguments[0]] && item.clientWidth)"
HANDLE = """
const view = arguments[0].planView, handle = view.handles().find((shape) => shape.id === arguments[1]);
return handle ? [...view.toCanvas(handle.at), ...handle.at, view.view.scale] : null;
"""
LEVEL = """
const view = arguments[0].chartView, places = view.places, box = places?.laid.panels[0];
const line = view.about.panels[0]?.lines.find((each) => each.name === "high" && each.axis === "x");
if (!line || !box) return null;
const [low, high] = places.ends.x;
return [places.toX(box, line.value), line.value, (high - low) / box.width];
"""
KINDS = "return [...new Set((arguments[0].fanView.frame?.circles || []).map((circle) => circle[3]))]"
INK = """
const canvas = arguments[0].fanView.$refs.over;
const colour = arguments[1].match(/../g).map((digits) => parseInt(digits, 16));
const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
let count = 0;
for (let at = 0; at < data.length; at += 4) count += colour.every((part, k) => Math.abs(data[at + k] - part) < 12);
return count;
"""
TIMELINE = "[role=slider][aria-label=ping]"
CAPTION = "return arguments[0].fanView.frame?.caption"
ONLY_B = "37b6ff"
OPENS = """
const [address, done] = arguments, socket = new WebSocket(address);
socket.onopen = () => done("open");
socket.onerror = () => done("refused");
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("work")
    text = shipped_file("scenes/figure11.toml").read_text()
    assert STANDS in text
    (made / "scene.toml").write_text(text.replace(STANDS, SAILS).replace("duration_s = 60.0", "duration_s = 3.0"))
    return made


@pytest.fixture(scope="module")
def server(folder: Path) -> Iterator[Serving]:
    programs()
    with serving("scene.toml", folder=folder) as running:
        yield running


@pytest.fixture(scope="module")
def page(server: Serving, tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    with chromium(tmp_path_factory.mktemp("profile")) as window:
        window.get(server.link)
        yield window


def view(window: webdriver.Chrome, kind: str) -> WebElement:
    found: list[WebElement] = until(lambda: window.execute_script(SHOWN, kind))
    return found[0]


def drag(window: webdriver.Chrome, element: WebElement, start: tuple[float, float], by: tuple[int, int]) -> None:
    """Drag from a place in an element, px from its corner; the browser takes whole pixels from its middle."""
    size = element.size
    from_middle = round(start[0] - size["width"] / 2), round(start[1] - size["height"] / 2)
    chain = ActionChains(window).move_to_element_with_offset(element, *from_middle).click_and_hold()
    chain.move_by_offset(by[0] // 2, by[1] // 2).move_by_offset(by[0] - by[0] // 2, by[1] - by[1] // 2)
    chain.release().perform()


def done(window: webdriver.Chrome) -> str:
    """Return what the undo button would undo."""
    texts = [button.text.split("\n") for button in window.find_elements(By.CSS_SELECTOR, "header button")]
    return next(lines[-1] for lines in texts if lines[0] == "undo")


def test_the_ruler_measures_in_a_plan(page: webdriver.Chrome) -> None:
    wait_for(page, "ping 0 of")
    plan = view(page, "planView")
    scale = until(lambda: page.execute_script("return arguments[0].planView.view?.scale", plan))
    ActionChains(page).key_down(Keys.SHIFT).perform()
    drag(page, plan, (200.0, 160.0), (60, -40))
    ActionChains(page).key_up(Keys.SHIFT).perform()
    read = page.execute_script("return arguments[0].planView.reading()", plan)
    apart, bearing, north, east = (float(number) for number in re.findall(r"-?\d+\.\d+", " ".join(read)))
    assert north == pytest.approx(40 / scale, abs=0.01)
    assert east == pytest.approx(60 / scale, abs=0.01)
    assert apart == pytest.approx(math.hypot(40, 60) / scale, abs=0.01)
    assert bearing == pytest.approx(math.degrees(math.atan2(60, 40)), abs=0.1)
    ActionChains(page).send_keys("m").send_keys(Keys.ESCAPE).perform()
    assert page.execute_script("return arguments[0].planView.measured", plan) is None


def test_a_waypoint_is_dragged_in_the_path_editor(page: webdriver.Chrome) -> None:
    wait_for(page, "ping 0 of")  # the image of the scene: all is drawn
    plan = view(page, "planView")
    until(lambda: page.execute_script("return arguments[0].planView.now.fitted", plan))
    x, y, north, east, scale = until(lambda: page.execute_script(HANDLE, plan, WAYPOINT))
    drag(page, plan, (x, y), (60, -40))
    until(lambda: done(page).startswith("vehicle, way-point 2: place"))
    _, _, now_north, now_east, _ = page.execute_script(HANDLE, plan, WAYPOINT)
    assert now_north == pytest.approx(north + 40 / scale, abs=0.05 + 1.5 / scale)
    assert now_east == pytest.approx(east + 60 / scale, abs=0.05 + 1.5 / scale)
    wait_for(page, f"N {now_north:.1f}, E {now_east:.1f} m")  # the list of way-points says the same


def test_a_threshold_is_dragged_in_the_histogram(page: webdriver.Chrome) -> None:
    open_menu(page, "Image processing")
    histogram = until(lambda: [each for each in page.execute_script(SHOWN, "chartView") if level_in(page, each)])[0]
    settled(page)
    x, value, db_per_pixel = level_in(page, histogram)
    drag(page, histogram, (x, 110), (50, 0))
    until(lambda: re.match(r"detect\.two_level: high level 5\.5 → ", done(page)))
    settled(page)
    assert level_in(page, histogram)[1] == pytest.approx(value + 50 * db_per_pixel, abs=4 * db_per_pixel)


def settled(window: webdriver.Chrome) -> None:
    """Wait until no answer comes any more."""
    frames = "return arguments[0].fanView.frame?.version"
    fan = view(window, "fanView")
    before = None
    while before is None or window.execute_script(frames, fan) != before:
        before = window.execute_script(frames, fan)
        time.sleep(1.0)


def level_in(window: webdriver.Chrome, histogram: WebElement) -> Any:
    return window.execute_script(LEVEL, histogram)


def test_b_is_compared_by_the_difference_of_detections(page: webdriver.Chrome) -> None:
    press(page, "keep as B")
    histogram = next(each for each in page.execute_script(SHOWN, "chartView") if level_in(page, each))
    press(page, "difference")
    fan = view(page, "fanView")
    until(lambda: page.execute_script(KINDS, fan) == ["detection"])  # A is B
    assert page.execute_script(INK, fan, ONLY_B) == 0
    x, _, _ = level_in(page, histogram)
    drag(page, histogram, (x, 110), (round(histogram.size["width"] - x) - 16, 0))  # A's level above all echoes
    until(lambda: page.execute_script(KINDS, fan) == ["only_b"])
    until(lambda: page.execute_script(INK, fan, ONLY_B) > 20)
    until(lambda: "0 both, 0 only A" in page.execute_script("return arguments[0].fanView.heading()", fan))
    press(page, "drop B")


def test_a_stage_is_dragged_to_another_place(page: webdriver.Chrome) -> None:
    names = stages(page)
    assert names[-1] == "detect.two_level"
    handles = page.find_elements(By.CSS_SELECTOR, "[draggable=true]")
    ActionChains(page).drag_and_drop(handles[0], handles[2]).perform()
    until(lambda: done(page) == f"move {names[0]} to 3")
    moved = [names[1], names[2], names[0], *names[3:]]
    until(lambda: stages(page) == moved)


def stages(window: webdriver.Chrome) -> list[str]:
    """Return the names of the list's rows."""
    rows = window.find_elements(By.CSS_SELECTOR, "[draggable=true] .q-item")
    return [re.split(r"\s+", row.text.strip())[1] for row in rows]


def test_keys_do_what_their_list_says(page: webdriver.Chrome) -> None:
    fan = view(page, "fanView")
    presentation = partial(page.execute_script, "return arguments[0].fanView.presentation", fan)
    is_dark = partial(page.execute_script, "return document.body.classList.contains('body--dark')")
    keys(page, "p")
    until(lambda: presentation() == "polar")
    keys(page, "d")
    until(lambda: not is_dark())
    ActionChains(page).key_down(Keys.CONTROL).send_keys("z").key_up(Keys.CONTROL).perform()
    until(is_dark)
    ActionChains(page).key_down(Keys.CONTROL).send_keys("y").key_up(Keys.CONTROL).perform()
    until(lambda: not is_dark())
    keys(page, Keys.ARROW_RIGHT)
    wait_for(page, "ping 1 of")
    ActionChains(page).key_down(Keys.SHIFT).send_keys(Keys.ARROW_RIGHT).key_up(Keys.SHIFT).perform()
    wait_for(page, "ping 11 of")
    keys(page, "?")
    wait_for(page, "measure from one place to another")
    keys(page, Keys.ESCAPE)
    until(lambda: not page.find_elements(By.CSS_SELECTOR, ".q-dialog__backdrop"))
    keys(page, "5")
    wait_for(page, "Configuration for the vehicle")


def test_after_a_drag_of_the_timeline_all_of_the_page_shows_its_ping(page: webdriver.Chrome) -> None:
    open_menu(page, "Image processing")
    bar = until(lambda: [one for one in page.find_elements(By.CSS_SELECTOR, TIMELINE) if one.is_displayed()])[0]
    fan = view(page, "fanView")
    last = int(bar.get_attribute("aria-valuemax") or 0)
    drag(page, bar, (0.2 * bar.size["width"], 9), (bar.size["width"] // 2, 0))
    place = int(bar.get_attribute("aria-valuenow") or 0)
    assert place == pytest.approx(0.7 * last, abs=1)
    wait_for(page, f"ping {place} of {last + 1}")
    until(lambda: str(page.execute_script(CAPTION, fan)).startswith(f"ping {place},"))
    keys(page, Keys.ARROW_RIGHT)  # keys are the page's still
    wait_for(page, f"ping {place + 1} of {last + 1}")
    assert bar.get_attribute("aria-valuenow") == str(place + 1)


def keys(window: webdriver.Chrome, *pressed: str) -> None:
    ActionChains(window).send_keys(*pressed).perform()


def test_a_macro_does_all_of_it_again(page: webdriver.Chrome, folder: Path) -> None:
    open_menu(page, "Utilities")
    wait_for(page, "folder to write script")
    press(page, "Write")
    script = until(lambda: (folder / "macro" / "macro.py").exists() and (folder / "macro" / "macro.py").read_text())
    names: dict[str, Any] = {"__file__": str(folder / "macro" / "macro.py")}
    exec(re.sub(r"(?m)^run\.write_results.*$", "", script), names)
    run = names["run"]
    assert isinstance(run, MacroRun)
    assert run.state.scene is not None
    assert run.state.scene.vehicle.waypoints[1].position_ned[1] > 1.0
    chain = run.state.tuning.config.pipeline.chain()
    assert chain[-1]["high"] > 5.5
    assert run.state.view.presentation == "polar"
    shown = MacroRun({}).state.tuning.config.pipeline.chain()
    assert [stage["use"] for stage in chain] == [shown[place]["use"] for place in (1, 2, 0, 3, 4)]


def test_nothing_leaves_the_host_and_no_script_complains(page: webdriver.Chrome) -> None:
    hosts = {urlsplit(address).hostname for address in requested(page) if address.startswith(("http", "ws"))}
    assert hosts == {"127.0.0.1"}
    assert [row["message"] for row in page.get_log("browser") if row["level"] == "SEVERE"] == []


def test_a_page_of_another_origin_gets_no_socket(page: webdriver.Chrome, server: Serving, tmp_path: Path) -> None:
    """Another port of this machine is the same site: the browser sends our cookie along, and only the Origin tells."""
    place = urlsplit(server.origin).netloc
    sockets = [f"ws://{place}/frames", f"ws://{place}/_nicegui_ws/socket.io/?EIO=4&transport=websocket"]
    assert [page.execute_async_script(OPENS, address) for address in sockets[:1]] == ["open"]
    (tmp_path / "index.html").write_text("<title>foreign</title>")
    handler = partial(SimpleHTTPRequestHandler, directory=str(tmp_path))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as foreign:
        threading.Thread(target=foreign.serve_forever, daemon=True).start()
        try:
            page.get(f"http://127.0.0.1:{foreign.server_port}/index.html")
            assert [page.execute_async_script(OPENS, address) for address in sockets] == ["refused", "refused"]
        finally:
            foreign.shutdown()
