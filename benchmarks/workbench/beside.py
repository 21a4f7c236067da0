"""The page beside a movie that is being recorded: slider to picture, a click's answer, CPU of the first page, memory.

Part of `python -m benchmarks.workbench`. Moves with and without the movie are made in one run, as only they compare.
"""

import tempfile
import time
from collections.abc import Iterable
from pathlib import Path

import msgspec
import numpy as np
import psutil
from selenium import webdriver

from benchmarks.workbench.sliders import SETTLE_S, slide, slider_that_shows
from tests.recording.mcap_samples import Sample, mission, write_segment
from tests.workbench.browser.waiting import open_menu, until
from tests.workbench.chromium import chromium
from tests.workbench.serving import serving

SAMPLES = 2000
SHAPES = ((60, 4200), (512, 300))
"""Beams, and pings: with 60 beams ten minutes."""
MENUS = ("Observer", "Echogram", "Simulator", "Assess", "Demonstrator", "Live", "Utilities")
ANSWER = """
const [menu, done] = arguments, began = performance.now();
const tab = [...document.querySelectorAll(".q-tab")].find((item) => item.innerText.includes(menu));
const panel = document.querySelector(`#menus > [data-menu="${menu}"]`);
let answered = null;
tab.click();
(function look() {
  if (panel.clientHeight) answered ??= performance.now() - began;
  if (answered !== null && !panel.innerText.includes(`opening ${menu}`))
    return done([answered, performance.now() - began]);
  requestAnimationFrame(look);
})();
"""
"""ms from a click at a tab to its place on the page, and to what is in it."""
PRESS = "[...document.querySelectorAll('button')].find((item) => item.innerText.trim() === arguments[0]).click()"
"""A notice may lie over it."""
GALLERY_S, LEFT_ALONE_S = 60.0, 20.0


def recording(file: Path, beams: int, pings: int) -> Path:
    """Write a recording of noise with poses."""

    def messages() -> Iterable[Sample]:
        noise = np.random.default_rng(1)
        images = [noise.integers(0, 256, beams * SAMPLES, np.uint8).tobytes() for _ in range(8)]
        bearing = np.radians(np.linspace(-59.0, 59.0, beams)).tolist()
        shape = {"beams": beams, "samples": SAMPLES, "bearing_rad": bearing, "dr_m": 0.025}
        for topic, log_ns, message in mission(pings, samples=4):
            if topic == "ping":
                number = getattr(message, "seq", 0)
                message = msgspec.structs.replace(message, data=images[number % len(images)], **shape)
            yield topic, log_ns, message

    return write_segment(file, messages())


def tell(moves: int) -> None:
    """Print the tables."""
    for beams, pings in SHAPES:
        with tempfile.TemporaryDirectory() as name:
            file = recording(Path(name) / "mission.mcap", beams, pings)
            words = str(file), "--folder", name
            with serving(*words, folder=Path(name)) as server, chromium(Path(name) / "profile", False) as window:
                _page(window, psutil.Process(server.process.pid), server.link, f"{beams} x {SAMPLES}", moves)


def _page(window: webdriver.Chrome, server: psutil.Process, link: str, shape: str, moves: int) -> None:
    started_s = _cpu_s(server)
    window.get(link)
    time.sleep(SETTLE_S)
    print(f"\n{shape}: first page {_cpu_s(server) - started_s:.1f} s of CPU, after {started_s:.1f} s to start")
    print("| samples | movie | p50 ms | p95 ms | shown nothing |\n|---|---|---|---|---|")
    slider = slider_that_shows(window)
    for beside in ("no", "recorded", "no", "recorded"):
        if beside == "recorded":
            _record(window)
        ms = slide(window, slider, moves)
        p50, p95 = np.percentile(ms, (50, 95)) if ms else (np.nan, np.nan)
        print(f"| {shape} | {beside} | {p50:.0f} | {p95:.0f} | {moves - len(ms)} |", flush=True)
        if beside == "recorded":
            _stop(window)
    _record(window)
    taken = {menu: window.execute_async_script(ANSWER, menu) for menu in MENUS}
    each = (f"{menu} {answered:.0f}, {built:.0f}" for menu, (answered, built) in taken.items())
    print(f"clicks beside a movie, ms to the answer and to what is in the menu: {'; '.join(each)}")
    time.sleep(GALLERY_S)
    print(f"server, all menus open, movie recorded: {_mb(server):.0f} MB,", end=" ")
    _stop(window)
    open_menu(window, "Utilities")
    time.sleep(LEFT_ALONE_S)
    print(f"left alone {_mb(server):.0f} MB, with the processes of its own {_all_mb(server):.0f} MB", flush=True)


def _record(window: webdriver.Chrome) -> None:
    open_menu(window, "Utilities")
    until(lambda: "Movie of the mission" in window.execute_script("return document.body.innerText"))
    window.execute_script(PRESS, "Record")
    open_menu(window, "Image processing")
    time.sleep(SETTLE_S)


def _stop(window: webdriver.Chrome) -> None:
    open_menu(window, "Utilities")
    window.execute_script(PRESS, "Stop")
    open_menu(window, "Image processing")
    time.sleep(SETTLE_S)


def _cpu_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _mb(process: psutil.Process) -> float:
    return float(process.memory_info().rss / 1e6)


def _all_mb(process: psutil.Process) -> float:
    return sum(_mb(each) for each in [process, *process.children(recursive=True)])
