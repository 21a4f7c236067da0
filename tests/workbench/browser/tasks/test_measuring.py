"""Tasks that measure and watch: a chain among others, a setting swept, a vehicle's bus, and all of it by keys."""

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium.webdriver.common.keys import Keys

from ods.base.settings_file import load
from ods.config import OnboardConfig
from tests.workbench.browser.conftest import Shared
from tests.workbench.browser.hand import Hand
from tests.workbench.browser.tasks.conftest import counted
from tests.workbench.browser.test_live_tables import speaking
from tests.workbench.serving import serving

pytestmark = pytest.mark.slow


def test_a_chain_is_measured_and_a_setting_swept(hand: Hand) -> None:
    hand.press("Assess")
    hand.sees("A: this chain:")
    hand.choose("setting", "detect.two_level: high level = 5.5")
    hand.press("Sweep")
    hand.sees("detect.two_level: high level: 8 values, and 1 that the setting refuses")
    counted(hand, "A chain assessed, a setting swept")


@pytest.fixture
def vehicle(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A run folder in which a vehicle's processes publish."""
    run_dir, ends = tmp_path_factory.mktemp("run"), threading.Event()
    speaker = threading.Thread(target=speaking, args=(run_dir, ends), daemon=True)
    speaker.start()
    try:
        yield run_dir
    finally:
        ends.set()
        speaker.join()


def test_a_vehicle_is_watched(workbench: Shared, vehicle: Path, tmp_path: Path) -> None:
    hand = Hand(workbench.window)
    with serving("--live", str(vehicle), folder=tmp_path) as server:
        hand.window.get(server.link)
        hand.sees("VALID: a planner may rely on the list")
        hand.press("Examine")
        hand.sees("wrong of ")
        counted(hand, "A vehicle watched live")


def test_a_threshold_is_set_and_saved_by_keys_alone(hand: Hand, folder: Path) -> None:
    hand.key("o")
    hand.sees(f"{folder}: ")  # listed: Tab goes through what is there
    hand.tab_to("scenes of ODS")
    hand.key(Keys.ENTER)
    hand.sees("figure11.toml")
    hand.tab_to("figure11.toml")
    hand.key(Keys.ENTER)
    hand.sees("against the truth: 3 right")
    hand.tab_to("high level")
    hand.key(*[Keys.ARROW_RIGHT] * 5)
    hand.key("5")
    hand.sees("1 setting differs")
    hand.tab_to("file to write")
    hand.type(str(folder / "by-keys.toml"))
    hand.tab_to("Save")
    hand.key(Keys.ENTER)
    hand.sees(f"written: {folder / 'by-keys.toml'}")
    assert hand.clicks == 0
    chain = load(folder / "by-keys.toml", OnboardConfig).pipeline.chain()
    assert 5.5 < chain[-1]["high"] < 7.0
    counted(hand, "By keys alone: a threshold set and saved")
