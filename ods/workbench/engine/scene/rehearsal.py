"""A mission before it is run: its scene simulated, what pipeline and tracker make of it, and how well they do."""

import time
from typing import NamedTuple

import numpy as np

from ods.messages import Obstacle, TrackState, Truth
from ods.offline.mission import Mission, MissionSettings
from ods.offline.run_record import RunRecord
from ods.offline.score import ObjectScore, position_rms_m, score_objects
from ods.offline.source import simulated
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.model import SonarModel
from ods.workbench.engine.background.own_process import GoesOn, whole
from ods.workbench.engine.scene.view import SceneError, built

SETTLE_S = 3.0
"""From the first sight of an object until it counts as missed, as on the bench."""


class Course(NamedTuple):
    """A track as the lists told of it."""

    id: int
    state: TrackState
    """The last one."""
    radius_m: float
    """The last one."""
    places: list[tuple[float, float]]
    """North and east, m."""


class Rehearsal(NamedTuple):
    """What came of a mission."""

    record: RunRecord
    """Lists and truth of every ping, the last image."""
    objects: list[ObjectScore]
    false_tracks: int
    """Tracks that stood for no object, ever."""
    position_rms_m: float
    detections: int
    """Of all pings together."""
    chain_ms: float
    """Median of a ping."""
    tracker_ms: float
    """The same."""
    took_s: float
    """To simulate, detect, track and score."""

    def courses(self) -> list[Course]:
        """Return where each track went."""
        places: dict[int, list[tuple[float, float]]] = {}
        last: dict[int, Obstacle] = {}
        for _, told in self.record.lists:
            for item in told.obstacles:
                places.setdefault(item.id, []).append(item.position_ned[:2])
                last[item.id] = item
        return [Course(number, last[number].state, last[number].radius_m, ways) for number, ways in places.items()]

    @property
    def truths(self) -> list[Truth]:
        """In order of pings."""
        return [self.record.truths[number] for number in sorted(self.record.truths)]


def rehearse(scene: Scene, sonar: SonarModel, settings: MissionSettings, tell: GoesOn = whole) -> Rehearsal | None:
    """Rehearse a whole scene; None: `tell`, which is called after each ping, told to give up. Raises OdsError."""
    began = time.monotonic()
    try:
        source = simulated(scene, sonar)
    except ValueError as error:
        raise SceneError(str(error)) from error
    record, costs, mission = RunRecord(), list[tuple[float, float]](), Mission(settings)
    detections = 0
    for done, step in enumerate(mission.steps(source.pings, source.poses), 1):
        record.lists.append((step.list.made_ns, step.list))
        record.image = step.ping, step.detections
        detections += len(step.detections.detections)
        costs.append((step.chain_ms, step.tracker_ms))
        if not tell(done / len(source.pings)):
            return None
    record.truths = dict(source.truths)
    objects, false_ids = score_objects(record, SETTLE_S)
    chain_ms, tracker_ms = np.median(np.array(costs).reshape(-1, 2), axis=0).tolist() if costs else (0.0, 0.0)
    return Rehearsal(
        record, objects, len(false_ids), position_rms_m(objects), detections, chain_ms, tracker_ms,
        time.monotonic() - began,
    )  # fmt: skip


def rehearse_file(tell: GoesOn, file: SceneFile, sonar: str, settings: MissionSettings) -> Rehearsal | None:
    """Rehearse a scene as its file has it, seen by a sonar of that name. Raises OdsError."""
    return rehearse(built(file), find_sonar(sonar), settings, tell)
