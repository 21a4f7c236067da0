"""Warm-up before the first ping, so that a failing plug-in fails at start-up."""

import numpy as np

from ods.base.clock import NS
from ods.base.frames.geometry import quat_from_euler
from ods.messages import Sector
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.scan import Scan, echoes_of, vehicle_at
from ods.tracker.named import TrackTables
from ods.tracker.observer.registry import make_observer
from ods.tracker.settings import MotionSettings, TrackerSettings
from ods.tracker.tracker import Tracker


def warm_up(settings: TrackerSettings) -> None:
    """Track a made-up mission: two objects that contend for their echoes, a large one and one of the map; then none.

    `settings`: of plug-ins, observer and association; the others make no difference. Raises PluginError.
    """
    chosen = TrackerSettings(plugins=settings.plugins, observer=settings.observer, association=settings.association)
    rock = MapObject(1, (60.0, 20.0, 0.0), (0.1, 0.1, 0.1), 1.0, 0.1, 0.99, 9, 0, 0, 0)
    tracker = Tracker(chosen, [rock], first_id=2)
    whole = [_echo(40.0, 0.0, 0.5), _echo(40.5, 0.01, 0.5), _echo(70.0, -0.3, 6.0)]
    for k in range(9):
        tracker.step(_scan(k, whole, looks_back=False))
    tracker.step(_scan(9, [_echo(73.0, -0.3, 1.0)], looks_back=False))
    tracker.step(_scan(10, [], looks_back=True))
    again = Tracker(chosen, [rock], first_id=2)
    again.restore(tracker.state(), [rock], next_id=100)
    again.step(_scan(11, [], looks_back=True))
    _find_again(settings.observer)


def _find_again(name: str) -> None:
    """Let an observer do what the mission does not come to: what was settled is taken up again, and inherited."""
    observer, one, row = make_observer(name, MotionSettings()), np.ones(1), np.zeros(1, np.intp)
    TrackTables(observer.tables()).extend(1)
    observer.recall(np.ones((3, 1)), np.ones((3, 1)), np.zeros(1), one, one)
    observer.settle(row)
    observer.inherit(row, row)
    observer.reopen(row)


def _echo(range_m: float, bearing: float, radius: float) -> tuple[float, ...]:
    return range_m, bearing, 0.0, radius, 0.2, 0.02, 0.3


def _scan(k: int, echoes: list[tuple[float, ...]], looks_back: bool) -> Scan:
    t_ns, table = k * NS // 7, np.array(echoes).reshape(-1, 7)
    vehicle = vehicle_at(np.zeros(3), quat_from_euler(0.0, 0.0, np.pi if looks_back else 0.0), np.zeros(3), np.zeros(3))
    return Scan(t_ns, t_ns, vehicle, Sector(0.0, 100.0, -0.8, 0.8, 0.2), echoes_of(table)[0])
