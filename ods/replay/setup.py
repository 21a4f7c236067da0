"""Start of a recorded mission: its configuration, its map, the lives of its processes."""

import tempfile
from bisect import bisect_left
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.messages import Health, ObstacleList
from ods.recording.mcap.reader import Recording
from ods.replay.streams import messages_of
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.store import copy_of_map

CONFIG, MAP = "config.toml", "map.sqlite"
"""Attachments of a recording."""


class TrackerLife(NamedTuple):
    """One tracker process."""

    lists: int
    first_id: int
    """Of the objects that it found itself."""


def recorded_config(recording: Recording) -> OnboardConfig:
    """Return the configuration that was recorded with. Raises OdsError."""
    text = recording.attachments.get(CONFIG)
    if text is None:
        raise OdsError("the recording has no configuration: give one with --config")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / CONFIG
        file.write_bytes(text)
        return load(file, OnboardConfig)


def recorded_map(recording: Recording) -> list[MapObject]:
    """Return the objects of the map at the start of the recording; none where it had none. Raises OdsError."""
    image = recording.attachments.get(MAP)
    if not image:
        return []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / MAP
        file.write_bytes(image)
        store = copy_of_map(file)
        try:
            return store.load()
        finally:
            store.close()


def tracker_lives(recording: Recording, known: Sequence[MapObject]) -> list[TrackerLife]:
    """Return the tracker processes of a recording, one after the other: their lists each count from 0."""
    lives: list[TrackerLife] = []
    old, last_seq = {o.id for o in known}, -1
    first_id, lists = 0, 0
    for _, recorded_list in messages_of(recording, "obstacles", ObstacleList):
        if recorded_list.seq <= last_seq:
            lives.append(TrackerLife(lists, first_id or 1))
            first_id, lists = 0, 0
        new = {o.id for o in recorded_list.obstacles} - old
        if new and not first_id:
            first_id = min(new)
        old |= new
        last_seq = recorded_list.seq
        lists += 1
    return [*lives, TrackerLife(lists, first_id or 1)]


def pipeline_starts(recording: Recording) -> list[int]:
    """Return from which log times on detections are of another pipeline process than those before.

    A new process shows in its health; what it published first is what came after the longest silence in between.
    """
    found_ns = [recorded.log_ns for recorded in recording.messages(["detections"])]
    reports = [
        (log_ns, report.pid)
        for log_ns, report in messages_of(recording, "health", Health)
        if report.process == "pipeline" and report.pid
    ]
    starts = []
    for (before_ns, old), (after_ns, new) in pairwise(reports):
        if old == new:
            continue
        near = found_ns[max(0, bisect_left(found_ns, before_ns) - 1) : bisect_left(found_ns, after_ns) + 1]
        if len(near) > 1:
            starts.append(max(pairwise(near), key=lambda pair: pair[1] - pair[0])[1])
    return starts
