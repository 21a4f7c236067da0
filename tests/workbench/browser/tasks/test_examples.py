"""Tasks with scenes and files: the worked example, a scene from nothing, a macro, a print and a movie."""

import io
import re
from pathlib import Path
from typing import Any

import pytest
from PIL import Image
from selenium.webdriver.remote.webelement import WebElement

from ods.sim_sonar.scene.timeline import load_scene
from ods.workbench.engine.files.macro_run import MacroRun
from tests.workbench.browser.conftest import Shared
from tests.workbench.browser.hand import Hand
from tests.workbench.browser.tasks.conftest import counted, run_on_the_bench
from tests.workbench.browser.test_downloads import came
from tests.workbench.browser.waiting import until

pytestmark = pytest.mark.slow

PLAN = "return [...document.querySelectorAll('div')].find((item) => item.planView && item.clientWidth)"
SEES = "return arguments[0].planView.view !== null"
AT = "return arguments[0].planView.toCanvas(arguments[1])"
EXAMPLE = "Worked example, figures 6 and 7"


def plan(hand: Hand) -> WebElement:
    found: WebElement = until(lambda: hand.window.execute_script(PLAN))
    until(lambda: hand.window.execute_script(SEES, found))
    return found


def test_the_worked_example_is_opened_and_its_tracks_judged(hand: Hand) -> None:
    hand.press("Demonstrator")
    hand.press("Open", EXAMPLE)
    hand.press("Observer")
    hand.sees("536 pings, 2 tracks")
    hand.sees("0 false tracks, 0 identity switches")
    counted(hand, "The worked example")


def test_a_scene_from_nothing_is_rehearsed_and_run_on_the_bench(hand: Hand, folder: Path) -> None:
    hand.press("Simulator")
    hand.press("New scene")
    hand.sees("ping 0 of")
    hand.press("sphere")
    shown = plan(hand)
    place = until(lambda: min(at := hand.window.execute_script(AT, shown, [40.0, 5.0])) > 0 and at)
    hand.click_at(shown, *place)
    hand.sees("add sphere")
    hand.press("Run")
    hand.press("Rehearse")
    hand.sees("0 false tracks, position rms")
    hand.press("Save ...")
    hand.sees('+shape = "sphere"')
    hand.press("Save")
    scene = folder / "scene.toml"
    hand.sees(f"on the bench: ods bench --scene {scene}")
    counted(hand, "A scene from nothing, rehearsed, run on the bench")
    north, east, _ = load_scene(scene).objects_at(0.0).position_ned[0]
    assert (north, east) == pytest.approx((40.0, 5.0), abs=1.0)
    assert run_on_the_bench("--scene", scene, 10) == 0


def test_a_macro_does_all_of_it_again(hand: Hand, folder: Path) -> None:
    hand.press("Open")
    hand.press("short.toml")
    hand.sees("against the truth:")
    hand.write("low level", "3", enter=True)
    hand.press("Utilities")
    hand.press("Write", "Macro")
    hand.sees(f"written: {folder / 'macro'}")
    counted(hand, "A macro")
    script = (folder / "macro" / "macro.py").read_text()
    names: dict[str, Any] = {"__file__": str(folder / "macro" / "macro.py")}
    exec(re.sub(r"(?m)^run\.write_results.*$", "", script), names)
    run = names["run"]
    assert isinstance(run, MacroRun)
    assert Path(run.state.data.path).name == "short.toml"
    assert run.state.tuning.config.pipeline.chain()[-1]["low"] == 3.0


def test_a_ping_is_printed_and_a_movie_recorded(hand: Hand, workbench: Shared) -> None:
    hand.press("Open")
    hand.press("short.toml")
    hand.sees("against the truth:")
    hand.press("Utilities")
    hand.press("Download", "Print")
    with Image.open(io.BytesIO(came(workbench, ".png"))) as picture:
        assert picture.info["Title"].startswith("short.toml, ping 0: ")
    hand.press("Download", "Movie of the mission")
    with Image.open(io.BytesIO(came(workbench, ".webp"))) as movie:
        assert getattr(movie, "n_frames", 1) > 3
    counted(hand, "A print and a movie")
