"""The examples of observer and association, plugged into the tracker."""

import sys
from pathlib import Path

import numpy as np
import pytest

from ods.assess.track.scenarios import make
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTables
from ods.tracker.observer.horizontal import Heights, HorizontalFilter, NewPlaces
from ods.tracker.observer.kalman.independent import IndependentAxes
from ods.tracker.scenario import track_scenario
from ods.tracker.settings import PLUGINS, MotionSettings, TrackerSettings

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


@pytest.fixture(scope="module")
def plugins(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ...]:
    """The examples as files of whoever runs the tests, under names of their own."""
    folder = tmp_path_factory.mktemp("plugins")
    for name, registered in (("user_observer.py", '"plain"'), ("user_association.py", '"greedy"')):
        text = (EXAMPLES / name).read_text()
        (folder / name).write_text(text.replace(registered, registered.replace('"', '"test.', 1)))
    return folder / "user_observer.py", folder / "user_association.py"


def test_the_example_of_an_observer_filters_as_the_closed_form_does(plugins: tuple[Path, ...]) -> None:
    PLUGINS.load(plugins)
    settings = MotionSettings()
    plain: HorizontalFilter = sys.modules[f"ods_plugin:{plugins[0].resolve()}"].PlainAxes(settings)
    ours = IndependentAxes(settings)
    rng = np.random.default_rng(3)
    n = 5
    start = NewPlaces(
        rng.normal(50.0, 10.0, (2, n)), rng.uniform(0.1, 1.0, (2, n)), np.zeros(n), np.zeros((UNSEEN, 2, n))
    )
    rows = np.array([0, 2, 3])
    for each in (plain, ours):
        TrackTables(each.tables()).extend(n)
        each.start(start)
    for step in range(40):
        k = len(rows)
        noise = rng.uniform(0.05, 0.5, (2, k))
        one = np.ones(k)
        level = np.zeros((2, k)), np.zeros((UNSEEN, 2, k)), np.zeros(2)
        seen = PositionMeasurement(
            rng.normal(50.0, 1.0, (3, k)), noise[0], noise[1], np.zeros(k), one, one, one, one, *level
        )
        ones = np.ones((2, k))
        heights = Named(Heights, np.array([ones, ones, ones, ones, np.zeros((2, k))]))
        ratios = []
        for each in (plain, ours):
            each.predict(0.1 + 0.01 * step)
            ratios.append(np.subtract(*each.update(rows, seen, np.ones(k), heights).rows.log_likelihood))
            if step == 20:
                each.rest_there(np.array([0]))
                each.set_out(np.array([2]))
                each.join(np.array([3]), np.array([1]))
            if step == 30:
                TrackTables(each.tables()).keep(np.array([True, True, True, True, False]))
        np.testing.assert_allclose(ratios[0], ratios[1], rtol=1e-9, atol=1e-9)
        for mine, closed in zip((*plain.state(), *plain.velocity()), (*ours.state(), *ours.velocity()), strict=True):
            np.testing.assert_allclose(mine, closed, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("observer", "association"), [("test.plain", "nearest"), ("independent", "test.greedy")])
def test_the_tracker_finds_the_same_objects_with_them(
    plugins: tuple[Path, ...], observer: str, association: str
) -> None:
    scenario = make("static 10", 0).scenario
    built_in = track_scenario(scenario, TrackerSettings()).trk
    own = track_scenario(scenario, TrackerSettings(plugins=plugins, observer=observer, association=association)).trk
    last = [np.sort(trk[trk[:, 0] == trk[-1, 0], 2]) for trk in (built_in, own)]
    np.testing.assert_allclose(last[1], last[0], atol=0.1)
    assert len(last[0]) == 10
