"""Identities over 44 minutes of a real harbour: `python -m benchmarks.tracker.harbour aracati_detections.npz`.

Detections of 665 key frames, 3.4 s apart in the median, of a BlueView P900-130 in a marina (Aracati 2017; data:
matheusbg8/aracati2017 and nathanrasami/sonar-SLAM, MIT). CFAR points of a key frame that lie within a metre of each
other are one detection here. A *place* is a spot where compact detections recur by the true pose (DGPS, compass); a
*visit* ends when it was out of the sector for a minute. Printed is at how many later visits a place has the id of an
earlier one, with the true pose and with dead reckoning, which drifts by 20 m in the median.
"""

import argparse
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ods.base.arrays import Floats, Ints, Mask
from ods.base.files.npz_file import load_npz
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.scenario import Meta, Scenario, scans, tracker_for
from ods.tracker.settings import TrackerSettings

ARRAYS = ("keyframe", "range_m", "bearing_deg", "kf_id", "kf_time", "kf_gt_xyh", "kf_dr_xyh")
TOGETHER_M, LEAST_POINTS = 1.0, 2
"""Points of one detection."""
RECURRING_M, LEAST_FRAMES, LARGEST_M = 0.5, 8, 2.0
"""Detections of one place: neighbours' distance, least number of key frames, largest distance from the middle."""
AWAY_S = 60.0
"""Out of the sector for so long, the next time is another visit."""
NEAR_M = 3.0
"""A track within this of a place is the place's."""
INSIDE = 0.9
"""Share of range and of half the opening within which a place is in the sector."""
SONAR = Meta(
    range_max=50.0, half_fov=np.deg2rad(65.0), half_vert=np.deg2rad(10.0), sigma_range=0.2,
    sigma_bearing=np.deg2rad(1.0), sigma_radius=0.5, pd=0.7, clutter_lambda=3.0,
)  # fmt: skip


class Harbour(NamedTuple):
    """K key frames with M detections."""

    t: Floats
    """(K,) s."""
    true: Floats
    """(K, 3) north, east, yaw by DGPS and compass."""
    drifting: Floats
    """(K, 3) the same by dead reckoning."""
    detections: Floats
    """(M, 5) as `Scenario.det`."""


class Visit(NamedTuple):
    """Of a place."""

    place: int
    frames: Ints
    """Key frames that have a detection of it."""


def read(path: Path) -> Harbour:
    """Return the recording; its x and y are taken as north and west."""
    arrays = load_npz(path, ARRAYS)
    bearing = -np.deg2rad(arrays["bearing_deg"].astype(np.float64))
    points = arrays["range_m"].astype(np.float64)[:, None] * np.column_stack([np.cos(bearing), np.sin(bearing)])
    frame = np.searchsorted(arrays["kf_id"], arrays["keyframe"])
    found = [_detections(k, points[frame == k]) for k in range(len(arrays["kf_id"]))]
    true, drifting = (pose[:, :3] * np.array([1.0, -1.0, -1.0]) for pose in (arrays["kf_gt_xyh"], arrays["kf_dr_xyh"]))
    return Harbour(arrays["kf_time"] - arrays["kf_time"][0], true, drifting, np.concatenate(found))


def _detections(frame: int, points: Floats) -> Floats:
    """Return the (m, 5) detections of the (n, 2) points of a key frame, metres ahead and to starboard."""
    label = groups(points, TOGETHER_M)
    rows = []
    for each in np.flatnonzero(np.bincount(label) >= LEAST_POINTS):
        own = points[label == each]
        ahead, side = middle = 0.5 * (own.min(axis=0) + own.max(axis=0))
        radius = max(0.1, float(np.hypot(*(own - middle).T).max()))
        rows.append((frame, np.hypot(ahead, side), np.arctan2(side, ahead), radius, 100.0))
    return np.array(rows, np.float64).reshape(-1, 5)


def groups(points: Floats, apart_m: float) -> Ints:
    """Return (n,) the number of the group of each of the (n, 2) points: neighbours are within `apart_m`."""
    if len(points) == 0:
        return np.zeros(0, np.intp)
    pairs = cKDTree(points).query_pairs(apart_m, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    return np.asarray(connected_components(graph, directed=False)[1])


def placed(pose: Floats, polar: Floats) -> Floats:
    """Return (n, 2) north and east of (n, 2) range and bearing, seen from (n, 3) poses."""
    course = pose[:, 2] + polar[:, 1]
    return np.asarray(pose[:, :2] + polar[:, :1] * np.column_stack([np.cos(course), np.sin(course)]))


def visits_of(harbour: Harbour) -> tuple[Floats, list[Visit]]:
    """Return the (P, 2) places, north and east, and their visits in the order of time."""
    frame = harbour.detections[:, 0].astype(np.intp)
    spots = placed(harbour.true[frame], harbour.detections[:, 1:3])
    label = groups(spots, RECURRING_M)
    places, visits = list[Floats](), list[Visit]()
    for each in range(label.max() + 1):
        own = spots[label == each]
        frames = np.unique(frame[label == each])
        middle = np.median(own, axis=0)
        if len(frames) < LEAST_FRAMES or np.hypot(*(own - middle).T).max() > LARGEST_M:
            continue
        inside = np.flatnonzero(_in_sector(harbour.true, middle))
        ends = np.flatnonzero(np.diff(harbour.t[inside]) > AWAY_S) + 1
        for stay in np.split(inside, ends):
            seen = frames[np.isin(frames, stay)]
            if len(seen):
                visits.append(Visit(len(places), seen))
        places.append(middle)
    return np.array(places).reshape(-1, 2), visits


def _in_sector(pose: Floats, place: Floats) -> Mask:
    offset = place - pose[:, :2]
    bearing = np.arctan2(offset[:, 1], offset[:, 0]) - pose[:, 2]
    turned = np.abs(np.arctan2(np.sin(bearing), np.cos(bearing)))
    inside = (np.hypot(*offset.T) < INSIDE * SONAR.range_max) & (turned < INSIDE * SONAR.half_fov)
    return np.asarray(inside)


def tracked(harbour: Harbour, pose: Floats, sigma_m: float, settings: TrackerSettings) -> Iterator[tuple[Ints, Floats]]:
    """Yield, scan by scan, the ids of the active objects and their (n, 2) places as the true pose has them."""
    level = np.zeros(len(pose))
    meta = msgspec.structs.replace(SONAR, pose_sigma_xy=sigma_m, pose_sigma_yaw=np.deg2rad(1.0))
    position, attitude = np.column_stack([pose[:, :2], level]), np.column_stack([level, level, pose[:, 2]])
    scenario = Scenario(harbour.t, position, attitude, harbour.detections, meta)
    tracker = tracker_for(scenario, settings)
    for k, scan in enumerate(scans(scenario)):
        tracker.step(scan)
        snapshot = tracker.snapshot()
        active = snapshot.state == ACTIVE
        offset = snapshot.position[:2, active].T - pose[k, :2]
        polar = np.column_stack([np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0]) - pose[k, 2]])
        yield snapshot.id[active], placed(np.repeat(harbour.true[k : k + 1], len(polar), axis=0), polar)


class Figures(NamedTuple):
    """How well the places kept their ids."""

    listed: float
    """Share of a place's detections at which it was listed."""
    again: int
    """Visits of a place that was listed at the one before, too;"""
    same: int
    """and of these with the same id."""
    ids_a_place: float
    ids: int
    """In all."""
    most: int
    """Objects at a time."""


def figures(lists: list[tuple[Ints, Floats]], places: Floats, visits: list[Visit]) -> Figures:
    """Return the figures of the lists of `tracked`."""
    held: dict[int, list[set[int]]] = {}
    listed = 0
    for visit in visits:
        nearest = [_nearest(lists[frame], places[visit.place]) for frame in visit.frames]
        ids = {each for each in nearest if each is not None}
        listed += sum(each is not None for each in nearest)
        held.setdefault(visit.place, []).append(ids)
    again = [(before, now) for each in held.values() for before, now in pairwise(each) if before and now]
    return Figures(
        listed=listed / sum(len(visit.frames) for visit in visits),
        again=len(again),
        same=sum(bool(before & now) for before, now in again),
        ids_a_place=float(np.mean([len(set().union(*each)) for each in held.values()])),
        ids=len({int(each) for who, _ in lists for each in who}),
        most=max(len(who) for who, _ in lists),
    )


def _nearest(listed: tuple[Ints, Floats], place: Floats) -> int | None:
    """Return the id of the object nearest to a place, if there is one within `NEAR_M`."""
    ids, spots = listed
    if len(ids) == 0:
        return None
    apart = np.hypot(*(spots - place).T)
    nearest = int(np.argmin(apart))
    return int(ids[nearest]) if apart[nearest] < NEAR_M else None


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=Path, help="aracati_detections.npz")
    harbour = read(parser.parse_args().recording)
    places, visits = visits_of(harbour)
    print(
        f"{len(harbour.t)} key frames, {len(harbour.detections)} detections, {len(places)} places, {len(visits)} visits"
    )
    print("| pose | listed | same id at the next visit | ids a place | ids in all | most at a time |")
    print("|---|---|---|---|---|---|")
    for name, pose, sigma_m in (
        ("true, sigma 0.5 m", harbour.true, 0.5), ("drifting, sigma 0.5 m", harbour.drifting, 0.5),
        ("drifting, sigma 10 m", harbour.drifting, 10.0),
    ):  # fmt: skip
        f = figures(list(tracked(harbour, pose, sigma_m, TrackerSettings())), places, visits)
        print(f"| {name} | {f.listed:.0%} | {f.same} of {f.again} | {f.ids_a_place:.2f} | {f.ids} | {f.most} |")


if __name__ == "__main__":
    main()
