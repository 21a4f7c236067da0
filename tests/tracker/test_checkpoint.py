"""A tracker that was killed goes on with the same objects; what its predecessor left is not believed blindly."""

import contextlib
import os
import threading
import time
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.base.clock import NS
from ods.base.frames.geometry import quat_from_euler
from ods.base.geodesy import SiteSettings
from ods.messages import Detections, ObstacleList, Pose, Sector
from ods.pose.buffer import PoseSettings
from ods.pose.utc import VehicleUtc
from ods.runtime.state_files import state_file
from ods.runtime.state_files.state_file import HEAD, StateFile
from ods.tracker.map.link import OBJECTS_A_PACKET
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.scan import Scan, echoes_of, vehicle_at
from ods.tracker.mission import MissionTracker
from ods.tracker.output.validity import InputMonitor
from ods.tracker.restart.checkpoint import Checkpoint, Checkpoints, MissionState
from ods.tracker.restart.state import MapChanges
from ods.tracker.settings import OWN_OBSERVERS, LifeSettings, TrackerConfig, TrackerSettings
from ods.tracker.tracker import Tracker

SECTOR = Sector(0.0, 100.0, -0.8, 0.8, 0.2)
CONFIG = TrackerConfig(
    site=SiteSettings(latitude_deg=57.0, longitude_deg=10.0), pose=PoseSettings(), tracker=TrackerSettings()
)


def mission_of(tracker: Tracker) -> MissionState:
    return MissionState(tracker.state(), tracker.map_changes(), [], [4], [5], 6, 6, 7, 8, 9)


def scan(k: int, rng: np.random.Generator) -> Scan:
    """Two at rest, one that moves, and clutter; the vehicle looks away from pings 40 to 60, so some are hibernated."""
    away = np.pi if 40 <= k < 60 else 0.0
    places = [(40.0, 0.0), (70.0, -0.3), (30.0 + 0.15 * k, 0.4)] if not away else []
    places += [(rng.uniform(5.0, 95.0), rng.uniform(-0.7, 0.7))]
    table = [[r + rng.normal(0.0, 0.1), b + rng.normal(0.0, 0.005), 0.0, 1.0, 0.1, 0.01, 0.3] for r, b in places]
    vehicle = vehicle_at(np.zeros(3), quat_from_euler(0.0, 0.0, away), np.full(3, 0.05), np.full(3, 0.002))
    t_ns = k * NS // 7
    return Scan(t_ns, 10**18 + t_ns, vehicle, SECTOR, echoes_of(np.array(table))[0])


def started(observer: str) -> Tracker:
    rock = MapObject(1, (-160.0, 20.0, 0.0), (0.1, 0.1, 0.1), 1.0, 0.1, 0.99, 9, 0, 0, 0)
    return Tracker(TrackerSettings(observer=observer, life=LifeSettings(stand_by_s=1.0)), [rock], first_id=2)


@pytest.mark.parametrize("observer", sorted(OWN_OBSERVERS))
@pytest.mark.parametrize("killed_at", [1, 44, 50, 62])
def test_the_next_tracker_goes_on_to_the_bit(observer: str, killed_at: int) -> None:
    rng = np.random.default_rng(7)
    scans = [scan(k, rng) for k in range(90)]
    one = started(observer)
    for each in scans[: killed_at + 1]:
        one.step(each)
    left = msgspec.msgpack.decode(msgspec.msgpack.encode(mission_of(one)), type=MissionState)
    other = Tracker(one.settings)
    other.restore(left.tracker, left.map_changes.put, one.next_id)
    for each in scans[killed_at + 5 :]:  # the gap
        one.step(each)
        other.step(each)
    assert len(one.snapshot()) >= 4
    for name in type(one.snapshot()).__slots__:
        order = np.argsort(one.snapshot().id), np.argsort(other.snapshot().id)
        np.testing.assert_array_equal(
            getattr(one.snapshot(), name)[..., order[0]], getattr(other.snapshot(), name)[..., order[1]]
        )
    assert one.next_id == other.next_id
    assert sorted(o.id for o in one.whole_map()) == sorted(o.id for o in other.whole_map())


class Folder:
    """A run folder, and who complained of what is in it."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "tracker.checkpoint"
        self.folder = folder
        self.complaints: list[str] = []

    def files(self, config: TrackerConfig = CONFIG) -> Checkpoints:
        return Checkpoints(self.folder, config, lambda key, _: self.complaints.append(key))


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    made, tracker = Folder(tmp_path), started("coupled")
    rng = np.random.default_rng(7)
    for k in range(55):
        tracker.step(scan(k, rng))
    made.files().write(100 * NS, tracker.next_id, mission_of(tracker))
    return made


def test_what_was_left_is_found(folder: Folder) -> None:
    left = folder.files().read(103 * NS, within_s=10.0)
    assert left.mission is not None
    assert (left.same, left.lost, left.mission.unwritten, left.mission.undeleted) == (True, False, [4], [5])
    assert 1 in [o.id for o in left.known]
    assert left.next_id is not None
    assert left.next_id > max(o.id for o in left.known)
    assert folder.complaints == []


@pytest.mark.parametrize(("now_s", "within_s"), [(103, 2.0), (99, 10.0), (100.001, 0.0)])
def test_only_one_young_enough_goes_on(folder: Folder, now_s: float, within_s: float) -> None:
    left = folder.files().read(round(now_s * NS), within_s)
    assert (left.mission, left.same) == (None, True)
    assert left.next_id is not None  # ids are not given again all the same


def test_another_configuration_or_site_begins_anew(folder: Folder) -> None:
    other = msgspec.structs.replace(CONFIG, site=SiteSettings(latitude_deg=57.0, longitude_deg=10.5))
    left = folder.files(other).read(101 * NS, 10.0)
    assert (left.mission, left.same, left.lost) == (None, False, False)
    assert left.next_id is not None


def test_another_boot_begins_anew(folder: Folder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "boot_id").write_text("01234567-89ab-cdef-0123-456789abcdef\n")
    monkeypatch.setattr(state_file, "BOOT_ID", tmp_path / "boot_id")
    left = folder.files().read(101 * NS, 10.0)
    assert (left.next_id, left.lost, left.mission, folder.complaints) == (None, False, None, [])


def test_where_the_boot_cannot_be_reported_it_begins_anew(folder: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a sandbox without /proc/sys: the tracker could not start there."""
    monkeypatch.setattr(state_file, "BOOT_ID", folder.folder / "hidden")
    for _ in range(2):
        left = folder.files().read(101 * NS, 10.0)
        assert (left.next_id, left.lost, left.mission, folder.complaints) == (None, False, None, [])
        folder.files().write(100 * NS, 77, None)


def test_damaged_files_are_dropped_and_said(folder: Folder) -> None:
    whole = folder.path.read_bytes()
    damaged = [whole[:-1], whole[:20], b"", whole + b"x", bytes([whole[0] ^ 1]) + whole[1:]]
    damaged += [whole[:i] + bytes([whole[i] ^ 1]) + whole[i + 1 :] for i in range(HEAD.size, len(whole), 97)]
    for content in damaged:
        folder.path.write_bytes(content)
        left = folder.files().read(101 * NS, 10.0)
        assert (left.next_id, left.lost, left.mission) == (None, True, None)
    assert folder.complaints == ["checkpoint_unusable"] * len(damaged)


def test_files_of_somebody_else_are_not_opened_or_not_believed(folder: Folder, tmp_path: Path) -> None:
    own = tmp_path / "own"
    folder.path.rename(own)
    folder.path.symlink_to(own)
    assert folder.files().read(101 * NS, 10.0).lost
    folder.path.unlink()
    os.link(own, folder.path)
    assert folder.files().read(101 * NS, 10.0).lost
    own.unlink()
    assert not folder.files().read(101 * NS, 10.0).lost
    if os.geteuid() == 0:
        os.chown(folder.path, 65534, 65534)
        assert folder.files().read(101 * NS, 10.0).lost
    folder.path.unlink()
    os.mkfifo(folder.path)
    assert folder.files().read(101 * NS, 10.0).lost
    assert set(folder.complaints) == {"checkpoint_unusable"}


def test_objects_of_the_map_have_files_of_their_own(tmp_path: Path) -> None:
    """Killed at any moment between the files: what the newest whole checkpoint goes with is there."""
    folder, tracker = Folder(tmp_path), started("independent")
    many = [MapObject(i, (500.0 + i, 0.0, 0.0), (0.1, 0.1, 0.1), 1.0, 0.1, 0.9, 9, 0, 0, 0) for i in range(10, 400)]
    files = folder.files()
    tracker.join(many, 400)
    assert len(many) > OBJECTS_A_PACKET
    for round_ in range(3):
        assert files.base_due(tracker.map_changes()) == (round_ == 0)
        files.write_base(tracker.whole_map())
        assert tracker.map_changes() == MapChanges([], [])
        if round_:
            assert len(folder.files().read(100 * NS, 10.0).known) == 391 + round_  # the file before, still whole
        tracker.join([MapObject(500 + round_, (0.0, 900.0, 0.0), (1, 1, 1), 1.0, 1.0, 0.9, 9, 0, 0, 0)], None)
        files.write(100 * NS, 600, mission_of(tracker))
        known = folder.files().read(100 * NS, 10.0).known
        assert sorted(o.id for o in known) == sorted(o.id for o in tracker._manager.asleep._objects.values())
    next(tmp_path.glob("tracker.map-objects-*")).unlink()
    next(tmp_path.glob("tracker.map-objects-*")).unlink()
    assert [o.id for o in folder.files().read(100 * NS, 10.0).known] == [502]


TABLES = 2 + 3
"""History, existence, and what `coupled` has."""


@given(st.integers(0, TABLES - 1), st.integers(0), st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1.0, -1e9, 0.0]))
def test_objects_that_cannot_be_are_refused_or_harmless(which: int, place: int, value: float) -> None:
    tracker, rng = started("coupled"), np.random.default_rng(7)
    for k in range(12):
        tracker.step(scan(k, rng))
    state = tracker.state()
    numbers = np.frombuffer(state.tracks.tables[which], np.float64 if which else np.int64).copy()
    numbers[place % len(numbers)] = value if which else int(np.clip(np.nan_to_num(value), -(2.0**60), 2.0**60))
    tables = [*state.tracks.tables[:which], numbers.tobytes(), *state.tracks.tables[which + 1 :]]
    changed = msgspec.structs.replace(state, tracks=msgspec.structs.replace(state.tracks, tables=tables))
    other = Tracker(tracker.settings)
    try:
        other.restore(changed, [], 9)
    except ValueError:
        return
    for k in range(13, 20):
        other.step(scan(k, rng))
    reported = other.snapshot()
    for name in ("position", "velocity", "radius", "sigma_position", "sigma_velocity", "existence", "covariance_ne"):
        assert np.isfinite(getattr(reported, name)).all()


def test_a_folder_that_is_gone_or_full_is_an_error_and_leaves_the_old_file(folder: Folder, tmp_path: Path) -> None:
    file, before = StateFile(folder.path), folder.path.read_bytes()
    folder.path.with_name("tracker.checkpoint.new").mkdir()
    with pytest.raises(OSError):  # noqa: PT011
        file.write(b"new")
    assert folder.path.read_bytes() == before
    with pytest.raises(FileNotFoundError):
        StateFile(tmp_path / "gone" / "file").write(b"new")


def test_an_ended_mission_leaves_its_ids_only(folder: Folder) -> None:
    folder.files().write(100 * NS, 77, None)
    left = folder.files().read(101 * NS, 10.0)
    assert (left.next_id, left.mission, left.known) == (77, None, [])
    assert msgspec.msgpack.decode(StateFile(folder.path).read() or b"", type=Checkpoint).mission is None


def test_a_disk_that_stalls_holds_up_no_list(folder: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run folder is on a disk where there is no /run of one's own: the tracker stood while the disk did."""
    files, answers, written = folder.files(), threading.Event(), StateFile.write

    def stalled(self: StateFile, content: bytes) -> None:
        answers.wait(20.0)
        written(self, content)

    monkeypatch.setattr(StateFile, "write", stalled)
    begun_s = time.monotonic()
    for number in range(1, 6):
        with pytest.raises(OSError, match="the disk of the run folder does not respond"):
            files.write((100 + number) * NS, 70 + number, None)
    assert time.monotonic() - begun_s < 5.0
    answers.set()
    while folder.files().read(101 * NS, 10.0).next_id != 71:
        time.sleep(0.01)
    while True:  # the thread takes the next one as soon as it has reported of the last one
        with contextlib.suppress(OSError):
            files.write(107 * NS, 77, None)
            break
    assert folder.files().read(107 * NS, 10.0).next_id == 77


def flown(tracker: MissionTracker, t_s: float) -> ObstacleList:
    """Let it track a ping that shows nothing; return the list."""
    t_ns, zeros = round(t_s * NS), (0.0, 0.0, 0.0)
    tracker.add_pose(Pose(round(10 * t_s), t_ns, t_ns, zeros, (1.0, *zeros), zeros, zeros, zeros))
    reported = tracker.track(Detections(round(10 * t_s), round(10 * t_s), t_ns, t_ns, t_ns, 1480.0, SECTOR, []), t_ns)
    assert reported is not None
    return reported.message


@pytest.mark.parametrize(
    ("away_s", "reasons"), [(2.5, []), (3.5, ["coverage has just returned: objects are still being confirmed"])]
)
def test_what_came_into_view_while_the_tracker_was_away_for_long_is_not_in_its_first_lists(
    away_s: float, reasons: list[str]
) -> None:
    one, other = (
        MissionTracker(CONFIG, InputMonitor(0, (), lambda _: ""), VehicleUtc(0, 0, "clock")) for _ in range(2)
    )
    assert [flown(one, 0.1 * k).valid for k in range(30)][10:] == [True] * 20
    other.restore(one.state([], []), [], 1)
    back = [flown(other, 2.9 + away_s + 0.1 * k) for k in range(12)]
    assert back[0].reasons == reasons
    assert back[-1].valid
