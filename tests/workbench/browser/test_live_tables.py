"""Vetoes, bridges and the doctor's findings in the menu Live, of processes on a real bus, in a real browser."""

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import msgspec
import pytest
from selenium import webdriver
from selenium.webdriver.common.by import By

from ods.base import clock
from ods.base.clock import NS
from ods.messages import Health, Veto, VetoRegion
from tests.export import mission
from tests.workbench.browser.test_narrow import SIDEWAYS
from tests.workbench.browser.waiting import press, resized, until, wait_for
from tests.workbench.engine.test_live import Vehicle
from tests.workbench.serving import serving

pytestmark = pytest.mark.slow

replace = msgspec.structs.replace
BRIDGE = Health("", 7, 0, 0, 0, True, [], {"sent_lists": 41}, {}, {}, {}, 1.0, 9.0)
AROUND = VetoRegion(centre_ne=(mission.POSE.position_ned[0] + 12.0, mission.POSE.position_ned[1] + 4.0), radius_m=6.0)


def speaking(run_dir: Path, ends: threading.Event) -> None:
    """Publish a list with a veto, and the health of two bridges, until reported to end."""
    began_ns, began_utc_ns = clock.monotonic_ns(), clock.utc_ns()
    with ExitStack() as stack:
        vehicle = Vehicle(run_dir, stack, "bridge_json", "bridge_ttm")
        first, *others = mission.LIST.obstacles
        ignored = [replace(first, ignored_by=3), *others]
        veto = Veto(number=3, author="anna", reason="our buoy", until_ns=began_ns + 600 * NS,
                    until_utc_ns=began_utc_ns + 600 * NS, region=AROUND, id=first.id)  # fmt: skip
        while not ends.wait(0.1):
            vehicle.tell(valid=True, reasons=[], obstacles=ignored, vetoes=[veto])
            vehicle.say("pose", replace(mission.POSE, t_ns=clock.monotonic_ns()))
            vehicle.report(replace(BRIDGE, process="bridge_json"))
            vehicle.report(replace(BRIDGE, process="bridge_ttm", problems=["nobody takes what is sent"]))


@pytest.fixture(scope="module")
def live(window: webdriver.Chrome, tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    run_dir, ends = tmp_path_factory.mktemp("run"), threading.Event()
    speaker = threading.Thread(target=speaking, args=(run_dir, ends), daemon=True)
    speaker.start()
    try:
        with serving("--live", str(run_dir), folder=tmp_path_factory.mktemp("live")) as server:
            window.get(server.link)
            wait_for(window, "VALID: a planner may rely on the list")
            yield window
    finally:
        ends.set()
        speaker.join()


def table(window: webdriver.Chrome, title: str) -> str:
    return next(
        str(each.text) for each in window.find_elements(By.CSS_SELECTOR, ".q-table__container") if title in each.text
    )


def test_a_veto_is_reported_with_who_why_and_until_when(live: webdriver.Chrome) -> None:
    number = str(mission.LIST.obstacles[0].id)
    reported = until(lambda: "our buoy" in (text := table(live, "Operators' vetoes")) and text)
    assert f"obstacle {number}, while it is within 6.0 m around" in reported
    assert "anna" in reported
    assert "UTC, 9 min" in reported
    assert f"{number} ignored by anna" in live.execute_script("return document.body.innerText")


def test_bridges_are_reported_with_what_is_wrong(live: webdriver.Chrome) -> None:
    reported = until(lambda: "json" in (text := table(live, "Bridges")) and text)
    assert "✓ ready" in reported
    assert "✗ nobody takes what is sent" in reported
    assert "bridge_json" not in table(live, "Processes")


def test_the_doctor_says_what_is_wrong_first(live: webdriver.Chrome) -> None:
    press(live, "Examine")
    reported = until(
        lambda: "wrong of " in (text := str(live.execute_script("return document.body.innerText"))) and text
    )
    assert "ods doctor, " in reported
    rows = [row.text for row in live.find_elements(By.CSS_SELECTOR, "tbody tr") if "✗ wrong" in row.text]
    assert any("serial port" in row or "sonar" in row for row in rows)
    levels = [row.text.split()[0] for row in live.find_elements(By.CSS_SELECTOR, "tbody tr") if row.text[:1] in "✗!✓"]
    shown = [each for each in levels if each in ("✗", "!", "✓")]
    assert shown == sorted(shown, key="✗!✓".index)


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (1024, 700)])
def test_nothing_is_cut_off(live: webdriver.Chrome, width: int, height: int) -> None:
    resized(live, width, height)
    time.sleep(0.5)
    assert live.execute_script(SIDEWAYS) == []
