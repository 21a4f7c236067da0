"""Physical causes that are no bodies, from the simulator to the planner's list."""

from typing import Any

import msgspec
import numpy as np
import pytest

from benchmarks.circles.synthetic import ping_of
from benchmarks.detection.causes import CAUSES, SCENE, Cause, judged, until_a_body
from ods.base.clock import NS
from ods.base.settings_file import load
from ods.messages import ObstacleList
from ods.runtime.caution import cautions
from ods.sim_sonar.scene.motion import VehicleMotion
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene

TOLD = {
    "pulses each 0.1 s, 1000 counts": "another sonar's pulses",
    "continuous source, 1000 counts, from 0.0 s": "a continuous source is received",
    "9 beams saturated": "saturated",
    "a second way, open water": "",
}


@pytest.mark.parametrize("name", TOLD)
def test_a_cause_makes_no_false_obstacle_hides_no_body_and_is_reported(name: str) -> None:
    (cause,) = (each for each in CAUSES if each.name == name)
    result = judged(cause._replace(seconds=10.0))
    assert (result.false, result.seen, result.valid) == (0, 1.0, 1.0)
    assert any(TOLD[name] in text for text in result.said) or not TOLD[name]


def test_an_image_that_stands_still_is_a_caution_of_the_list() -> None:
    (cause,) = (each for each in CAUSES if each.name.endswith("at rest"))
    assert "the image has not changed for s" in judged(cause._replace(seconds=13.0)).said
    fields: dict[str, Any] = dict.fromkeys(("seq", "ping_number", "t_ns", "utc_ns", "t_rx_ns"), 0)
    text = "the image has not changed for 3.2 s"
    assert cautions(ObstacleList(**fields, valid=True, reasons=[], obstacles=[], caution=text)) == [text]


def test_without_a_cause_nothing_is_reported() -> None:
    assert not judged(Cause("nothing", {}, seconds=10.0)).said


def test_a_scene_that_a_planner_steers_through_ends_before_a_body_is_around_the_sonar() -> None:
    """In avoid.toml pile 1, of radius 1.8 m, lies 38.2 m ahead and 0.3 m aside of a way at 1 m/s."""
    file = load(SCENE.parent / "avoid.toml", SceneFile)
    ping = ping_of(np.ones((2, 4), np.float32))
    pings = [msgspec.structs.replace(ping, t_ns=second * NS) for second in range(60)]
    assert len(list(until_a_body(Scene(file, vehicle=VehicleMotion(file.vehicle)), pings))) == 36
