"""From a slider's move to the picture, in `ods workbench` as people run it; part of `python -m benchmarks.workbench`.

A key moves the slider by one step; the clock of the page runs from that key to the first image drawn afterwards.
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from tests.workbench.chromium import chromium
from tests.workbench.serving import serving

SCENE = "config/scenes/figure11.toml"
SHAPES = (("60 x 2000", "seabat6012"), ("512 x 2000", "multibeam512"))
"""What it is called, and the simulated sonar that sends it."""
WATCH = """
const isView = (item) => item.fanView && item.clientWidth;
const views = [...document.querySelectorAll("div")].filter(isView).map((item) => item.fanView);
const newest = () => Math.max(...views.map((view) => (view.isNew ? 0 : view.have())));
let began = null, before = 0;
window.moves = [];
document.addEventListener("keydown", () => { began = performance.now(); before = newest(); }, true);
(function look() {
  if (began !== null && newest() > before) {
    window.moves.push(performance.now() - began);
    began = null;
  }
  requestAnimationFrame(look);
})();
"""
"""The pictures' versions rise; `have` is that of the one drawn last."""
LONGEST_S = 3.0
"""A move that shows nothing for so long shows nothing."""
SETTLE_S = 6.0


class Moved(NamedTuple):
    """What moves of a slider came to."""

    ms: list[float]
    """From key to picture, of those that showed one."""
    moves: int
    server_mb: tuple[float, float]
    """After a tenth of the moves, and at the end."""


def moved(sonar: str, moves: int) -> Moved:
    """Move the first slider that changes the image to and fro."""
    with tempfile.TemporaryDirectory() as name:
        pings = Path(name) / "pings.npz"
        words = [SCENE, "--sonar", sonar, "--pings", "5", "--out", str(pings)]
        subprocess.run([sys.executable, "-P", "-m", "ods", "simulate", *words], check=True, capture_output=True)
        with _page(pings, Path(name) / "profile") as (window, server):
            slider = slider_that_shows(window)
            memory = []
            taken = []
            for part in (moves // 10, moves - moves // 10):
                taken += slide(window, slider, part)
                memory.append(float(server.memory_info().rss / 1e6))
            return Moved(taken, moves, (memory[0], memory[-1]))


def slide(window: webdriver.Chrome, slider: WebElement, moves: int) -> list[float]:
    """Move a slider to and fro; return the ms from key to picture of those moves that showed one."""
    window.execute_script("window.moves = []")
    for number in range(moves):
        _move(window, slider, Keys.ARROW_RIGHT if number // 5 % 2 else Keys.ARROW_LEFT)
    taken: list[float] = window.execute_script("return window.moves")
    return taken


def tell(moves: int) -> None:
    """Print the table."""
    print(
        "\n| default chain, samples | moves | p50 ms | p95 ms | shown nothing | server MB |\n|---|---|---|---|---|---|"
    )
    for shape, sonar in SHAPES:
        found = moved(sonar, moves)
        p50, p95 = np.percentile(found.ms, (50, 95))
        first, last = found.server_mb
        lost = found.moves - len(found.ms)
        print(f"| {shape} | {found.moves} | {p50:.0f} | {p95:.0f} | {lost} | {first:.0f}, {last:.0f} |", flush=True)


@contextmanager
def _page(pings: Path, profile: Path) -> Iterator[tuple[webdriver.Chrome, psutil.Process]]:
    with serving(str(pings)) as server, chromium(profile, logged=False) as window:
        window.get(server.link)
        time.sleep(SETTLE_S)
        yield window, psutil.Process(server.process.pid)


def slider_that_shows(window: webdriver.Chrome) -> WebElement:
    """Return the first slider that changes the image."""
    found = window.find_elements("css selector", ".q-slider [tabindex]")
    sliders = [slider for slider in found if slider.is_displayed()]
    window.execute_script(WATCH)
    for slider in sliders:
        if _move(window, slider, Keys.ARROW_RIGHT):
            return slider
    raise SystemExit(f"none of {len(sliders)} sliders changes the image")


def _move(window: webdriver.Chrome, slider: WebElement, key: str) -> bool:
    """Tell whether a move showed another image."""
    before = window.execute_script("return window.moves.length")
    window.execute_script("arguments[0].focus()", slider)
    ActionChains(window).send_keys(key).perform()
    until = time.monotonic() + LONGEST_S
    while time.monotonic() < until:
        if window.execute_script("return window.moves.length") > before:
            return True
        time.sleep(0.02)
    return False
