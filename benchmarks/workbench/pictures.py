"""The docs' pictures of the workbench, taken anew from all of its menus in a real browser.

    python -m benchmarks.workbench.pictures                          # docs/workbench/pictures/*.png, 1440 x 900
    python -m benchmarks.workbench.pictures FOLDER --size 1024x700   # to look at

A bench runs for the menu Live: a minute or two in all. `--only observer live` takes these alone.
"""

import argparse
import io
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from selenium import webdriver

from tests.workbench.browser import waiting
from tests.workbench.browser.hand import Hand
from tests.workbench.browser.waiting import TEXT, keys, resized, until
from tests.workbench.chromium import chromium
from tests.workbench.serving import PROJECT, serving

FOLDER = Path(tempfile.gettempdir(), "survey")
"""That the workbench is started in: it is seen in pictures."""
RUN_DIR = "/tmp/ods-bench"
"""Of config/bench.toml."""
SETTLE_S = 3.0
"""Until charts and tables that follow a picture are drawn, and a notice is gone."""
BENCH_S = 25.0


def _processing(hand: Hand) -> None:
    hand.sees("ms once to prepare")


def _observer(hand: Hand) -> None:
    hand.sees("mean GOSPA")
    for _ in range(30):
        keys(hand.window, "n")  # to the end of the first track


def _simulator(hand: Hand) -> None:
    hand.sees("ping 0 of")


def _demonstrator(hand: Hand) -> None:
    hand.sees("DIDSON, real")
    until(lambda: "being made, once" not in hand.window.execute_script(TEXT))


def _utilities(hand: Hand) -> None:
    hand.press("Image processing")
    hand.write("high level", "6.5", enter=True)
    hand.press("Utilities")
    hand.sees("1 setting differs")


def _assess(hand: Hand) -> None:
    hand.sees("A: this chain:")
    hand.choose("setting", "detect.two_level: high level = 5.5")
    hand.press("Sweep")
    hand.sees("that the setting refuses")


def _echogram(hand: Hand) -> None:
    hand.sees("detections")
    until(
        lambda: not any(word in hand.window.execute_script(TEXT) for word in ("opening the data", "read:", "pings\n"))
    )


def _missions(hand: Hand) -> None:
    hand.choose("campaigns of ODS", "dense")
    hand.press("dense, mission 0: not run yet")
    hand.sees("least clearance")


def _live(hand: Hand) -> None:
    hand.sees("VALID: a planner may rely on the list")
    time.sleep(8.0)


PICTURES: dict[str, tuple[str, str, Callable[[Hand], None]]] = {
    "processing": ("Image processing", "figure11.toml", _processing),
    "observer": ("Observer", "worked_example.toml", _observer),
    "simulator": ("Simulator", "figure11.toml", _simulator),
    "demonstrator": ("Demonstrator", "figure11.toml", _demonstrator),
    "utilities": ("Utilities", "figure11.toml", _utilities),
    "assess": ("Assess", "figure11.toml", _assess),
    "echogram": ("Echogram", "figure11_imperfect.toml", _echogram),
    "missions": ("Missions", "figure11.toml", _missions),
    "live": ("Live", "", _live),
}
"""By name: the menu, the scene that is open, empty for a vehicle's bus, and what is done before the picture."""


def main() -> None:
    """Take them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=PROJECT / "docs" / "workbench" / "pictures")
    parser.add_argument("--size", default="1440x900")
    parser.add_argument("--only", nargs="+", choices=PICTURES, default=list(PICTURES))
    args = parser.parse_args()
    width, height = (int(pixels) for pixels in args.size.split("x"))
    args.folder.mkdir(parents=True, exist_ok=True)
    waiting.LONGEST_S = 300.0  # a mission, on a computer with other work
    shutil.copytree(PROJECT / "config", FOLDER / "config", dirs_exist_ok=True)
    with tempfile.TemporaryDirectory() as name, chromium(Path(name) / "profile", logged=False) as window:
        resized(window, width, height)
        for picture in args.only:
            place = args.folder / f"{picture}.png"
            _save(_taken(window, picture), place)
            print(place, flush=True)
    shutil.rmtree(FOLDER)


def _taken(window: webdriver.Chrome, picture: str) -> bytes:
    menu, scene, prepare = PICTURES[picture]
    with _data(scene) as words, serving(*words, "--config", "config/onboard.toml", folder=FOLDER) as server:
        window.execute_cdp_cmd("Network.clearBrowserCookies", {})
        window.get(server.link)
        hand = Hand(window)
        hand.press(menu)
        prepare(hand)
        time.sleep(SETTLE_S)
        return window.get_screenshot_as_png()


@contextmanager
def _data(scene: str) -> Iterator[tuple[str, ...]]:
    """Yield what the workbench is started with."""
    if scene:
        yield (f"config/scenes/{scene}",)
        return
    words = "-m", "ods", "bench", "--seconds", str(BENCH_S), "--out", str(FOLDER / "bench")
    bench = subprocess.Popen(
        [sys.executable, *words], cwd=PROJECT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield "--live", RUN_DIR
    finally:
        bench.terminate()
        bench.wait()


def _save(content: bytes, place: Path) -> None:
    """Write a picture, as small as it goes without another colour."""
    with Image.open(io.BytesIO(content)) as picture:
        picture.convert("RGB").save(place, optimize=True)


if __name__ == "__main__":
    main()
