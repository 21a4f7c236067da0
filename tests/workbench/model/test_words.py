"""Settings in words: each name on the page can be read, and none of them has a unit twice."""

import pytest

from ods.base.settings import Settings
from ods.pipeline.stage.configured import find_stage, stage_names
from ods.tracker.settings import TrackerSettings
from ods.workbench.model import actions as do
from ods.workbench.model.history import History
from ods.workbench.model.sliders import controls_of
from ods.workbench.model.words import called, sentence
from tests.workbench.model.test_history import START


def test_a_name_is_words_and_a_unit() -> None:
    assert called("max_extent_m") == ("largest extent", "m")
    assert called("heading_deg") == ("heading", "°")
    assert called("levels") == ("levels", "")


def test_every_setting_that_is_shown_has_words_and_a_sentence() -> None:
    kinds: list[type[Settings]] = [TrackerSettings, *(find_stage(name).params for name in stage_names())]
    for control in (each for kind in kinds for each in controls_of(kind)):
        assert "_" not in control.name, control.path
        assert sentence(control.meaning).strip(), control.path


@pytest.mark.parametrize(
    ("action", "name"),
    [
        (do.SetScene("objects[0].radius_m", 2.0), "rock: radius 1 → 2 m"),
        (do.SetScene("objects[0].position_ned[1]", 3.5), "rock: place east 0 → 3.5"),
        (do.SetScene("duration_s", 30.0), "scene: duration 60 → 30 s"),
        (do.SetSetting("tracker.life.silent_s", 5.0), "tracker lives: silent 3 → 5 s"),
    ],
)
def test_the_history_is_in_words(action: do.Action, name: str) -> None:
    assert History.of(START).after(action).undoes == name


def test_a_way_point_is_called_by_its_number() -> None:
    history = History.of(START).after(do.AddWaypoint("vehicle", 10.0, (5.0, 0.0, 5.0)))
    name = history.after(do.SetScene("vehicle.waypoints[1].t_s", 12.0)).undoes
    assert name == "vehicle, way-point 2: t 10 → 12 s"
