"""Everything is compiled before the first ping: none may wait for a compiler."""

import importlib
import pkgutil

import numpy as np
import pytest

import ods.tracker
from ods.messages import Pose
from ods.runtime.pose_buffer import PoseBuffer
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement import motion_during_reception
from ods.tracker.observer.registry import OBSERVERS
from ods.tracker.settings import LifeSettings, TrackerSettings
from ods.tracker.tracker import Tracker
from ods.tracker.warm_up import warm_up
from tests.tracker.samples import Course, course, echoes, run, scan


def compiled() -> set[tuple[str, str, str]]:
    """Return (module, kernel, argument types) of all that is compiled so far."""
    modules = [
        importlib.import_module(part.name) for part in pkgutil.walk_packages(ods.tracker.__path__, "ods.tracker.")
    ]
    return {
        (item.__module__, name, str(types))
        for module in modules
        for name, item in vars(module).items()
        for types in getattr(item, "signatures", ())
    }


def _see_all_cut_off(path: Course, tracker: Tracker) -> None:
    """Show what is in view once more, as if the fan's edge cut it off."""
    distance, bearing, seen = path.polar(-1)
    rows = list(zip(distance[seen], bearing[seen], path.radius[seen], strict=True))
    more = scan(float(path.t[-1]) + 0.15, path.position[-1], float(path.yaw[-1]), rows)
    more.echoes.rows.cut[:] = 1.0
    tracker.step(more)


@pytest.mark.parametrize(
    ("observer", "association"), [*((name, "probabilistic") for name in OBSERVERS), ("independent", "nearest")]
)
def test_no_real_scan_compiles_anything_more(observer: str, association: str) -> None:
    """A mission with all there is: clutter, silence, large and moving objects, leaving, the map, and coming back."""
    settings = TrackerSettings(observer=observer, association=association, life=LifeSettings(stand_by_s=2.0))
    warm_up(TrackerSettings(observer=observer, association=association))
    before = compiled()
    rng = np.random.default_rng(12)
    starts = np.column_stack([rng.uniform(15.0, 90.0, 40), rng.uniform(-50.0, 50.0, 40), rng.uniform(2.0, 6.0, 40)])
    velocities = np.where(rng.random((40, 1)) < 0.3, rng.normal(0.0, 0.5, (40, 3)), 0.0)
    path = course(40.0, 0.6, starts, velocities, rng.uniform(0.5, 6.0, 40))
    path.yaw[(path.t > 15.0) & (path.t < 25.0)] = np.pi
    known = [MapObject(i, (30.0 + i, 0.0, 4.0), (0.5, 0.5, 1.0), 1.0, 0.2, 0.9, 9, 1, 2, 3) for i in (1, 2, 200)]
    tracker = Tracker(settings, known, first_id=300)
    result = run(path, tracker, seed=12, clutter=5.0, silent=(8.0, 9.0))
    _see_all_cut_off(path, tracker)
    Tracker(settings, [], first_id=300).restore(tracker.state(), known, next_id=1000)
    pose = PoseBuffer(2, 0.3)
    pose.insert(Pose(0, 0, 0, (0.0,) * 3, (1.0, 0.0, 0.0, 0.0), (0.0,) * 3, (0.1,) * 3, (0.1,) * 3))
    sent = pose.at(0)
    assert sent is not None
    listening = motion_during_reception.poses_of(sent, 100.0, 1500.0, pose.at)
    assert listening is not None
    motion_during_reception.at_transmission(echoes([(50.0, 0.0, 1.0)]), listening)
    assert len(result.ids()) > 20
    assert result.ended
    assert before
    assert compiled() == before
