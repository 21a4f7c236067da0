"""A recording scrubbed in a browser: its timeline is dragged, pictures are counted; part of
`python -m benchmarks.workbench`."""

import tempfile
import time
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from selenium import webdriver

from tests.workbench.chromium import chromium
from tests.workbench.serving import serving

SETTLE_S = 8.0
MOVES_HZ, LASTS_S = 60.0, 10.0
"""Of the pointer."""
TRACK = """
const box = document.querySelector("[role=slider][aria-label=ping]").getBoundingClientRect();
return [box.left, box.right, box.top + box.height / 2];
"""
COUNT = """
const view = [...document.querySelectorAll("div")].find((item) => item.fanView && item.clientWidth).fanView;
window.pictures = [];
let last = view.have();
(function look() {
  if (!view.isNew && view.have() !== last) {
    last = view.have();
    window.pictures.push([performance.now(), view.frame.caption]);
  }
  requestAnimationFrame(look);
})();
"""


class Scrubbed(NamedTuple):
    """What a drag along the timeline showed."""

    pictures_hz: float
    pings: int
    """Different ones among them."""
    longest_ms: float
    """Between two pictures."""


def scrubbed(recording: Path) -> Scrubbed:
    """Drag the timeline from end to end."""
    with (
        tempfile.TemporaryDirectory() as name,
        serving(str(recording)) as server,
        chromium(Path(name), False) as window,
    ):
        window.get(server.link)
        time.sleep(SETTLE_S)
        left, right, height = window.execute_script(TRACK)
        window.execute_script(COUNT)
        _drag(window, left + 1.0, right - 1.0, height)
        reported: list[tuple[float, str]] = window.execute_script("return window.pictures")
    times = [at for at, _ in reported]
    gaps = [later - sooner for sooner, later in pairwise(times)]
    return Scrubbed(len(gaps) / (times[-1] - times[0]) * 1e3, len({text for _, text in reported}), max(gaps))


def _drag(window: webdriver.Chrome, left: float, right: float, height: float) -> None:
    def mouse(kind: str, x: float) -> None:
        window.execute_cdp_cmd(
            "Input.dispatchMouseEvent",
            {"type": kind, "x": x, "y": height, "button": "left", "buttons": 1, "clickCount": 1},
        )

    mouse("mousePressed", left)
    began = time.monotonic()
    while (share := (time.monotonic() - began) / LASTS_S) < 1.0:
        mouse("mouseMoved", left + (right - left) * share)
        time.sleep(1.0 / MOVES_HZ)
    mouse("mouseReleased", right)


def tell(recording: Path) -> None:
    """Print the table."""
    found = scrubbed(recording)
    print("\n| timeline dragged for 10 s: pictures/s | pings shown | longest without a new one, ms |\n|---|---|---|")
    print(f"| {found.pictures_hz:.1f} | {found.pings} | {found.longest_ms:.0f} |", flush=True)
