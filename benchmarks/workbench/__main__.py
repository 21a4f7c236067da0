"""`python -m benchmarks.workbench`: what images in the browser cost, and whether memory grows.

A server of its own shows noise of 60 x 2000 samples at a fixed rate in one view of 900 x 640 pixels; headless Chromium,
driven by Selenium, pulls and draws it. CPU is that of all processes of a side, in % of one core.
"""

import argparse
import itertools
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import psutil
from nicegui import ui
from selenium import webdriver

from benchmarks.workbench import beside, gallery, recording, sliders
from ods.workbench.session import Session
from ods.workbench.web import server
from ods.workbench.web.frames import Frame, FrameBoard
from ods.workbench.web.views.fan_view import FanView
from tests.workbench.chromium import chromium

BEAMS, SAMPLES, DR_M = 60, 2000, 0.05
WIDTH, HEIGHT = 900, 640
SETTLE_S = 3.0
FAST_HZ = 100.0
"""More than a browser draws: as many frames as it can."""
VIEW = "[...document.querySelectorAll('div')].find((item) => item.fanView).fanView"


class Used(NamedTuple):
    """What was used in a time."""

    images_hz: float
    """Drawn."""
    draw_ms: float
    """Of one image, in the page."""
    browser_percent: float
    server_percent: float


class Running(NamedTuple):
    """A server and a browser that shows its page."""

    server: psutil.Process
    browser: psutil.Process
    window: webdriver.Chrome


def main() -> None:
    """Print the tables of docs/workbench/README.md."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--serve", type=float, metavar="HZ", help=argparse.SUPPRESS)
    parser.add_argument("--seconds", type=float, default=20.0, help="for which CPU is measured; 0: not at all")
    parser.add_argument(
        "--frames", type=int, default=10_000, help="after which memory is looked at again; 0: not at all"
    )
    parser.add_argument("--moves", type=int, default=1000, help="of a slider; 0: none")
    parser.add_argument(
        "--recording", action=argparse.BooleanOptionalAction, default=True, help="one of ten minutes, opened"
    )
    parser.add_argument(
        "--gallery", action=argparse.BooleanOptionalAction, default=True, help="its demos, each opened twice"
    )
    parser.add_argument("--folder", type=Path, action="append", default=[], help="with recordings for the gallery")
    parser.add_argument("--beside", type=int, default=100, help="moves of a slider beside a movie; 0: none")
    args = parser.parse_args()
    if args.serve is not None:
        _serve(args.serve)
        return
    if args.seconds:
        _tell_cpu(args.seconds)
    if args.frames:
        _tell_memory(args.frames)
    if args.moves:
        sliders.tell(args.moves)
    if args.recording:
        recording.tell()
    if args.beside:
        beside.tell(args.beside)
    if args.gallery:
        gallery.tell(args.folder)


def _tell_cpu(seconds: float) -> None:
    print(
        "| images/s sent | drawn | ms to draw | browser CPU % | server CPU % | server MB |\n|---|---|---|---|---|---|"
    )
    for rate_hz in (7.0, 20.0):
        with _running(rate_hz) as running:
            used = _used(running, seconds)
            print(
                f"| {rate_hz:g} | {used.images_hz:.1f} | {used.draw_ms:.1f} | {used.browser_percent:.0f} | "
                f"{used.server_percent:.1f} | {_mb(running.server):.0f} |", flush=True,
            )  # fmt: skip


def _tell_memory(frames: int) -> None:
    print("\n| images | server MB | browser MB | its script's heap MB, collected |\n|---|---|---|---|")
    with _running(FAST_HZ) as running:
        for count in (frames // 10, frames // 2, frames):
            while _drawn(running.window)[0] < count:
                time.sleep(0.2)
            running.window.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
            heap = running.window.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"] / 1e6
            browser = sum(_mb(process) for process in _tree(running.browser))
            print(f"| {count} | {_mb(running.server):.0f} | {browser:.0f} | {heap:.1f} |", flush=True)


def _used(running: Running, seconds: float) -> Used:
    time.sleep(SETTLE_S)
    before, (frames, draw_ms), began = _cpu_s(running), _drawn(running.window), time.perf_counter()
    time.sleep(seconds)
    after, (frames_after, draw_after_ms) = _cpu_s(running), _drawn(running.window)
    taken = time.perf_counter() - began
    browser, own = (100.0 * (now - then) / taken for then, now in zip(before, after, strict=True))
    count = frames_after - frames
    return Used(count / taken, (draw_after_ms - draw_ms) / max(1, count), browser, own)


def _drawn(window: webdriver.Chrome) -> tuple[int, float]:
    reported: dict[str, Any] = window.execute_script(f"return {VIEW}.drawn")
    return int(reported["frames"]), float(reported["ms"])


def _cpu_s(running: Running) -> tuple[float, float]:
    """Return CPU seconds of browser and server so far."""
    return sum(_own_cpu_s(process) for process in _tree(running.browser)), _own_cpu_s(running.server)


def _own_cpu_s(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _tree(process: psutil.Process) -> list[psutil.Process]:
    return [process, *process.children(recursive=True)]


def _mb(process: psutil.Process) -> float:
    return float(process.memory_info().rss / 1e6)


def _wait(done: Callable[[], bool]) -> None:
    while not done():
        time.sleep(0.2)


@contextmanager
def _running(rate_hz: float) -> Iterator[Running]:
    command = [sys.executable, "-m", "benchmarks.workbench", "--serve", str(rate_hz)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    with tempfile.TemporaryDirectory() as profile, chromium(Path(profile), logged=False) as window:
        try:
            window.get(process.stdout.readline().strip())
            _wait(lambda: bool(window.execute_script(f"return !!{VIEW.removesuffix('.fanView')}")))
            _wait(lambda: _drawn(window)[0] > 0)
            yield Running(psutil.Process(process.pid), psutil.Process(window.service.process.pid), window)
        finally:
            process.terminate()
            process.wait()


def _serve(rate_hz: float) -> None:
    board = FrameBoard()
    threading.Thread(target=_show_forever, args=(board, rate_hz), daemon=True).start()

    def build(session: Session) -> None:
        with ui.element().style(f"width: {WIDTH}px"):
            FanView(session, board, "fan", height=f"{HEIGHT}px")

    bound = server.listening(0)
    server.serve(server.Site(build, Session), bound, lambda link: print(link, flush=True))


def _show_forever(board: FrameBoard, rate_hz: float) -> None:
    noise = np.random.default_rng(1)
    images = [noise.integers(0, 256, (BEAMS, SAMPLES), np.uint8) for _ in range(16)]
    bearing = np.radians(np.linspace(-59.0, 59.0, BEAMS))
    for image in itertools.cycle(images):
        board.show("fan", Frame(image, bearing, 0.0, DR_M, (0.0, 51.0)))
        time.sleep(1.0 / rate_hz)


if __name__ == "__main__":
    main()
