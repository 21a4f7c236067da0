"""Checkpoints in the run folder, written at every list: a restarted tracker continues with the same objects."""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple, TypeVar

import msgspec

import ods
from ods.base.clock import NS
from ods.base.settings import Settings
from ods.runtime.bus import UNDECODABLE
from ods.runtime.state_files.state_file import StateFile, StateFileError
from ods.runtime.state_files.state_file_writer import StateFileWriter
from ods.tracker.map.link import OBJECTS_A_PACKET
from ods.tracker.map.map_object import MapObject
from ods.tracker.restart.state import Announced, MapChanges, TrackerState
from ods.tracker.veto.vetoes import VetoState

KindT = TypeVar("KindT")

SHARE = 20
"""A checkpoint carries so many changes to the map's objects as go into a packet; with more, or a share of 1 / SHARE of
all, these are written again, to a file of their own."""


class MissionState(msgspec.Struct, frozen=True):
    """State of a tracker at work."""

    tracker: TrackerState
    map_changes: MapChanges
    announced: list[Announced]
    unwritten: list[int]
    """Objects that the map's file does not have yet, as they are now,"""
    undeleted: list[int]
    """and that it shall not have any more."""
    first_ping_ns: int | None
    looked_ns: int | None
    """Both: see `InputMonitor`."""
    ping_seq: int | None
    started_ns: int
    """When the first of these trackers was started,"""
    utc_ahead_ns: int
    """and how far UTC was ahead of CLOCK_MONOTONIC at last: see `VehicleUtc`."""
    vetoes: VetoState = VetoState()


class Checkpoint(msgspec.Struct, frozen=True):
    """The content of one file."""

    digest: str
    """Of version and settings."""
    t_ns: int
    """CLOCK_MONOTONIC."""
    next_id: int
    base: int
    """Which file of the map's objects `MissionState.map_changes` go with; 0: none."""
    mission: MissionState | None
    """None: it has ended."""


class MapSnapshot(msgspec.Struct, frozen=True):
    """The content of the other: the objects that belonged in the map when it was written."""

    number: int
    objects: list[MapObject]


class PreviousState(NamedTuple):
    """State left by a former tracker."""

    next_id: int | None = None
    """First unused id; None: no tracker has run since the computer was started."""
    lost: bool = False
    """There was a former tracker, and the ids that it used are unknown."""
    same: bool = False
    """It had the same version and settings."""
    mission: MissionState | None = None
    """State to restore; None: it had other settings, or is too old."""
    known: list[MapObject] = []  # noqa: RUF012
    """Its objects that belong in the map."""


class Checkpoints:
    """The files in the run folder.

    The map's objects change little, so they have files of their own: two, taken in turn, so that the one that the
    newest checkpoint goes with is whole whenever the tracker is killed.
    """

    def __init__(self, run_dir: Path, settings: Settings, complain: Callable[[str, str], None]) -> None:
        """`settings`: those of the tracker; `complain` takes a counter's name and a line."""
        self._file = StateFile(run_dir / "tracker.checkpoint")
        self._base_files = [StateFile(run_dir / f"tracker.map-objects-{turn}") for turn in (0, 1)]
        self._writer = StateFileWriter()
        configured = msgspec.json.encode((ods.__version__, settings), enc_hook=str)
        self._digest = hashlib.sha256(configured).hexdigest()
        self._complain = complain
        self._encoder = msgspec.msgpack.Encoder()
        self._base = self._newest_base = 0
        self._base_size = 0

    def read(self, now_ns: int, within_s: float) -> PreviousState:
        """Return what a former tracker left; where to go on only if it was at work within the last `within_s`."""
        try:
            checkpoint = _decoded(self._file, Checkpoint)
        except (StateFileError, *UNDECODABLE) as error:
            self._complain("checkpoint_unusable", f"starting without a checkpoint: {error}")
            return PreviousState(lost=True)
        if checkpoint is None:
            return PreviousState()
        self._newest_base = checkpoint.base
        same = checkpoint.digest == self._digest
        age_s = (now_ns - checkpoint.t_ns) / NS
        if not same or checkpoint.mission is None or not 0.0 <= age_s <= within_s:
            return PreviousState(checkpoint.next_id, same=same)
        changes = checkpoint.mission.map_changes
        known = {o.id: o for o in self._base_objects(checkpoint.base)} | {o.id: o for o in changes.put}
        for number in changes.remove:
            known.pop(number, None)
        return PreviousState(checkpoint.next_id, same=True, mission=checkpoint.mission, known=list(known.values()))

    def _base_objects(self, number: int) -> list[MapObject]:
        if not number:
            return []
        try:
            base = _decoded(self._base_files[number % 2], MapSnapshot)
        except (StateFileError, *UNDECODABLE) as error:
            self._complain("checkpoint_unusable", f"objects of the map are those of its file: {error}")
            return []
        return base.objects if base is not None and base.number == number else []

    def write(self, t_ns: int, next_id: int, mission: MissionState | None) -> None:
        """Leave this to the next tracker. Raises OSError."""
        checkpoint = Checkpoint(self._digest, t_ns, next_id, self._base, mission)
        self._writer.write(self._file, self._encoder.encode(checkpoint))

    def base_due(self, changes: MapChanges) -> bool:
        """Return whether the changes are too many for each checkpoint to carry."""
        return len(changes.put) + len(changes.remove) > max(OBJECTS_A_PACKET, self._base_size // SHARE)

    def write_base(self, objects: list[MapObject]) -> None:
        """Leave the map's objects; later checkpoints carry the changes to them. Raises OSError."""
        number = self._newest_base + 1
        self._writer.write(self._base_files[number % 2], self._encoder.encode(MapSnapshot(number, objects)))
        self._base = self._newest_base = number
        self._base_size = len(objects)


def _decoded(file: StateFile, kind: type[KindT]) -> KindT | None:
    """Raises StateFileError and what is in UNDECODABLE."""
    content = file.read()
    return None if content is None else msgspec.msgpack.decode(content, type=kind)
