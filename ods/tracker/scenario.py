"""`ods track`: runs the tracker over a recorded scenario and writes the tracks. Formats: docs/recordings/tracks.md."""

import math
import time
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.files.npz_file import load_npz
from ods.base.files.out_file import opened_to_seek
from ods.base.frames.geometry import quat_from_euler
from ods.base.frames.mounting import AT_ORIGIN, Mounting, spread_at
from ods.base.settings import Fraction, NonNegative, Positive
from ods.messages import Sector
from ods.tracker.map.trust import FARTHEST_M
from ods.tracker.measurement.scan import Scan, echoes_of, vehicle_at
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

ARRAYS = ("t", "auv_pos", "auv_rpy", "det")


class ScenarioError(OdsError):
    """A scenario file cannot be used; the text is one line."""


class Meta(msgspec.Struct, frozen=True):
    """What a scenario's `meta` says of the sonar and the pose."""

    range_max: Positive = 100.0
    """m."""
    half_fov: Positive = math.radians(45.0)
    """rad."""
    half_vert: Positive = math.radians(10.0)
    """rad."""
    sigma_range: Positive = 0.1
    """m."""
    sigma_bearing: Positive = math.radians(0.5)
    """rad."""
    sigma_radius: Positive = 0.3
    """m."""
    pd: Fraction = 0.9
    """Probability that an object in view is detected."""
    clutter_lambda: NonNegative | None = None
    """False alarms a scan."""
    pose_sigma_xy: NonNegative = 0.0
    """m."""
    pose_sigma_yaw: NonNegative = 0.0
    """rad."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """K scans with M detections."""

    t: Floats
    """(K,) s, never falling."""
    auv_pos: Floats
    """(K, 3) NED."""
    auv_rpy: Floats
    """(K, 3) roll, pitch, yaw, rad."""
    det: Floats
    """(M, 5) scan index, range_m, bearing_rad, radius_m, amplitude."""
    meta: Meta


@dataclass(frozen=True, slots=True)
class TrackedScenario:
    """The result of a run."""

    trk: Floats
    """(P, 8) scan index, track id, x, y, vx, vy, radius, status."""
    wall_ms: Floats
    """(K,) time of each step."""


def is_scenario(path: Path) -> bool:
    """Return whether a file is a scenario, by the names of its arrays: no recording of pings has echoes."""
    try:
        if not path.is_file():  # to open a pipe would wait for ever
            return False
        with zipfile.ZipFile(path) as file:
            return "det.npy" in file.namelist()
    except (OSError, zipfile.BadZipFile):
        return False


def load_scenario(path: Path) -> Scenario:
    """Read a scenario file. Raises ScenarioError."""
    try:
        arrays = load_npz(path, (*ARRAYS, "meta"))
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror or 'not a NumPy .npz file'}") from error
    except ValueError as error:
        raise ScenarioError(f"{path}: {error}") from error
    text = str(arrays.pop("meta", "{}"))
    if missing := [name for name in ARRAYS if name not in arrays]:
        raise ScenarioError(f"{path}: array {missing[0]} is missing")
    try:
        return _checked({name: arrays[name] for name in ARRAYS}, text)
    except (ValueError, TypeError) as error:
        raise ScenarioError(f"{path}: {error}") from error


def _checked(arrays: dict[str, Any], text: str) -> Scenario:
    """Return the scenario of raw arrays. Raises ValueError that names what is wrong."""
    for name, array in arrays.items():
        if array.dtype.kind not in "fiu":
            raise ValueError(f"{name}: expected numbers, got {array.dtype}")
    t, position, attitude, det = (np.asarray(array, np.float64) for array in arrays.values())
    if t.ndim != 1:
        raise ValueError(f"t: expected shape (K,), got {t.shape}")
    for name, array in (("auv_pos", position), ("auv_rpy", attitude)):
        if array.shape != (len(t), 3):
            raise ValueError(f"{name}: expected shape ({len(t)}, 3), got {array.shape}")
    if det.ndim != 2 or det.shape[1] != 5:
        raise ValueError(f"det: expected shape (M, 5), got {det.shape}")
    if not np.isfinite(t).all() or (np.abs(t) > 1e9).any() or (np.diff(t) < 0.0).any():
        raise ValueError("t: times must be finite and must not decrease, s")
    index = det[:, 0]
    if not (np.isfinite(index).all() and (index == np.floor(index)).all() and ((index >= 0) & (index < len(t))).all()):
        raise ValueError(f"det: scan indices must be whole numbers from 0 to {len(t) - 1}")
    try:
        meta = msgspec.json.decode(text.encode(), type=Meta)
    except msgspec.DecodeError as error:
        raise ValueError(f"meta: {error}") from error
    _refuse_absurd({"auv_pos": position, "auv_rpy": attitude, **msgspec.structs.asdict(meta)})
    return Scenario(t, position, attitude, det, meta)


def _refuse_absurd(numbers: dict[str, Any]) -> None:
    """Raise ValueError where one is beyond all bounds; a pose that is not a number is none."""
    for name, value in numbers.items():
        if value is not None and (np.abs(value) > FARTHEST_M).any():
            raise ValueError(f"{name}: a number is larger than {FARTHEST_M:g}")


def scans(scenario: Scenario, mounting: Mounting = AT_ORIGIN) -> Iterator[Scan]:
    """Yield the scenario's scans, seen by a sonar that is mounted like that.

    A scan whose pose is not finite has no vehicle; echoes of no use are left out.
    """
    meta = scenario.meta
    sector = Sector(0.0, meta.range_max, -meta.half_fov, meta.half_fov, meta.half_vert)
    sigma_xy, sigma_yaw = meta.pose_sigma_xy, meta.pose_sigma_yaw
    order = np.argsort(scenario.det[:, 0], kind="stable")
    det = scenario.det[order]
    table = np.empty((len(det), 7))
    table[:, :4] = np.column_stack([det[:, 1], det[:, 2], np.zeros(len(det)), det[:, 3]])
    table[:, 4:] = meta.sigma_range, meta.sigma_bearing, meta.sigma_radius
    border = np.searchsorted(det[:, 0], np.arange(len(scenario.t) + 1))
    attitudes = quat_from_euler(*scenario.auv_rpy.T)
    places, turns = mounting.heads(scenario.auv_pos, attitudes)
    levers = (places - scenario.auv_pos).tolist()
    for k, t in enumerate(scenario.t.tolist()):
        t_ns = round(t * NS)
        north, east, down = levers[k]
        spread = np.array(spread_at((north, east, down), (sigma_xy, sigma_xy, 0.0), (0.0, 0.0, sigma_yaw)))
        vehicle = vehicle_at(places[k], turns[k], spread, np.array([0.0, 0.0, sigma_yaw]))
        echoes, _ = echoes_of(table[border[k] : border[k + 1]])
        yield Scan(t_ns, t_ns, vehicle, sector, echoes)


def tracker_for(scenario: Scenario, settings: TrackerSettings) -> Tracker:
    """Return a new tracker; what the meta says of the sonar goes before the settings."""
    meta = scenario.meta
    echo = msgspec.structs.replace(settings.echo, detection_probability=min(max(meta.pd, 0.01), 0.99))
    if meta.clutter_lambda is not None:
        echo = msgspec.structs.replace(echo, clutter_per_scan=max(meta.clutter_lambda, 0.1))
    return Tracker(msgspec.structs.replace(settings, echo=echo))


def track_scenario(scenario: Scenario, settings: TrackerSettings, mounting: Mounting = AT_ORIGIN) -> TrackedScenario:
    """Track a scenario, seen by a sonar that is mounted like that."""
    tracker = tracker_for(scenario, settings)
    rows, wall_ms = [np.zeros((0, 8))], []
    for k, scan in enumerate(scans(scenario, mounting)):
        start = time.perf_counter()
        tracker.step(scan)
        wall_ms.append(1e3 * (time.perf_counter() - start))
        rows.append(rows_of(k, tracker.snapshot()))
    return TrackedScenario(np.concatenate(rows), np.array(wall_ms))


def rows_of(scan: int, snapshot: Snapshot) -> Floats:
    """Return the rows of `TrackedScenario.trk` for the objects of a snapshot."""
    columns = [
        np.full(len(snapshot), scan),
        snapshot.id,
        *snapshot.position[:2],
        *snapshot.velocity[:2],
        snapshot.radius,
    ]
    return np.column_stack([*columns, snapshot.state]).astype(np.float64)


def track_file(source: Path, out: Path, settings: TrackerSettings, mounting: Mounting = AT_ORIGIN) -> str:
    """Track the scenario file `source`, write `out` (.npz) and return a line that sums it up. Raises ScenarioError."""
    scenario = load_scenario(source)
    tracks = track_scenario(scenario, settings, mounting)
    try:
        with opened_to_seek(out) as file:
            np.savez_compressed(file, trk=tracks.trk, wall_ms=tracks.wall_ms)
    except OSError as error:
        raise ScenarioError(f"{out}: {error.strerror}") from error
    objects = len(np.unique(tracks.trk[:, 1]))
    pace = f", {np.median(tracks.wall_ms):.2f} ms a scan (median)" if len(tracks.wall_ms) else ""
    return f"{len(scenario.t)} scans, {len(scenario.det)} detections, {objects} objects{pace}"
