"""Exhibits of the gallery, opened in a browser; part of `python -m benchmarks.workbench`.

The clock of the page runs from the click on *Open*, with a click on the menu Image processing right behind it, to the
first image drawn. Each demo is opened twice: for the first time in the server's life, and again.
"""

import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from selenium import webdriver

from tests.workbench.chromium import chromium
from tests.workbench.serving import serving

SETTLE_S = 5.0
LONGEST_S = 60.0
CARDS = """
return [...document.querySelectorAll(".q-card")].filter((card) => card.querySelector("button"))
  .map((card) => card.querySelector("div.text-base").textContent);
"""
CHOOSE = """
[...document.querySelectorAll(".q-tab")].find((tab) => tab.textContent.includes(arguments[0])).click();
"""
OPEN = """
const [title, done] = arguments;
const card = [...document.querySelectorAll(".q-card")].find((item) => item.textContent.includes(title));
const seen = (item) => item.fanView && item.clientWidth;
const views = () => [...document.querySelectorAll("div")].filter(seen).map((item) => item.fanView);
const newest = () => Math.max(0, ...views().map((view) => (view.isNew ? 0 : view.have())));
const before = window.shownBefore ?? 0;
const began = performance.now();
card.querySelector("button").click();
[...document.querySelectorAll(".q-tab")].find((tab) => tab.textContent.includes("Image processing")).click();
(function look() {
  if (newest() > before) {
    window.shownBefore = newest();
    done(performance.now() - began);
  } else requestAnimationFrame(look);
})();
"""


def tell(folders: Sequence[Path]) -> None:
    """Print the table; folders: with recordings besides those of the source tree."""
    words = [word for folder in folders for word in ("--folder", str(folder))]
    with tempfile.TemporaryDirectory() as profile, serving(*words) as server, chromium(Path(profile), False) as window:
        window.set_script_timeout(LONGEST_S)
        window.get(server.link)
        time.sleep(SETTLE_S)
        window.execute_script(CHOOSE, "Image processing")
        time.sleep(SETTLE_S)
        window.execute_script(CHOOSE, "Demonstrator")
        time.sleep(SETTLE_S)
        titles: list[str] = window.execute_script(CARDS)
        first, again = ({title: _open(window, title) for title in titles} for _ in range(2))
        print("\n| demo | first, ms | again, ms |\n|---|---|---|")
        for title in titles:
            print(f"| {title} | {first[title]:.0f} | {again[title]:.0f} |", flush=True)


def _open(window: webdriver.Chrome, title: str) -> float:
    window.execute_script(CHOOSE, "Demonstrator")
    time.sleep(1.0)
    taken: float = window.execute_async_script(OPEN, title)
    time.sleep(1.0)  # what stands beside the picture
    return taken
