"""Results of a tracked mission for display: every object's course as arrays, the truth, scores."""

import math
from bisect import bisect_right
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import msgspec
import numpy as np

from ods.assess.track.gospa import gospa, pair
from ods.base.arrays import Floats, Ints
from ods.base.clock import NS
from ods.base.frames.geometry import body_to_global, polar_to_body
from ods.base.frames.mounting import Mounting
from ods.messages import Obstacle, ObstacleList, Pose, Quaternion, Sector, Truth
from ods.offline.mission import Found
from ods.offline.run_record import RunRecord
from ods.offline.score import ObjectScore, score_objects
from ods.tracker.existence.lifecycle import ACTIVE, TENTATIVE
from ods.tracker.map.map_object import MapObject
from ods.tracker.output.obstacle_list import NAMES
from ods.workbench.engine.mission.ping_log import PingLog, log_of

SETTLE_S = 3.0
"""Time from the first observation of an object until it counts as missed, as `ods track` has it."""
BORDER = 25
"""Places on the arc of a sector's outline."""
STATES = {name: state for state, name in NAMES.items()}


@dataclass(frozen=True, eq=False)
class Course:
    """One object as the lists reported it, k times."""

    id: int
    place: Ints
    """(k,) of the ping in the data."""
    t_s: Floats
    """(k,) since the first ping."""
    state: Ints
    """(k,) of `lifecycle`."""
    position: Floats
    """(k, 3) NED, m."""
    velocity: Floats
    """(k, 3) NED, m/s."""
    radius: Floats
    """(k,) m."""
    sigma_position: Floats
    """(k, 3)."""
    sigma_velocity: Floats
    """(k, 3)."""
    sigma_radius: Floats
    """(k,)."""
    covariance_ne: Floats
    """(k,) of north and east, m^2."""
    existence: Floats
    """(k,) probability."""
    first_seen_s: float
    """When its first echo came; before the first ping for objects of the map."""

    def lives(self) -> list["Span"]:
        """Return its states as spans of time.

        Lists report an object once it is confirmed: from its first echo until then it was tentative.
        """
        begins = [0, *(np.flatnonzero(self._breaks()) + 1).tolist()]
        ends = [*begins[1:], len(self.t_s)]
        spans = []
        if self.state[0] == ACTIVE and 0.0 <= self.first_seen_s < self.t_s[0]:
            spans.append(Span(TENTATIVE, self.first_seen_s, float(self.t_s[0])))
        for begin, end in zip(begins, ends, strict=True):
            goes_on = end < len(self.t_s) and self.place[end] == self.place[end - 1] + 1
            until = self.t_s[end] if goes_on else self.t_s[end - 1]
            spans.append(Span(int(self.state[begin]), float(self.t_s[begin]), float(until)))
        return spans

    def _breaks(self) -> Ints:
        """Return where one span ends, (k - 1,): the state changes, or the lists left it out meanwhile."""
        return np.asarray((np.diff(self.state) != 0) | (np.diff(self.place) > 1), np.int64)


class Span(NamedTuple):
    """A state of an object."""

    state: int
    """Of `lifecycle`."""
    from_s: float
    to_s: float


@dataclass(frozen=True, eq=False)
class TrueCourse:
    """One object as it really went."""

    name: str
    t_s: Floats
    """(k,)."""
    position: Floats
    """(k, 3)."""
    velocity: Floats
    """(k, 3)."""
    radius_m: float


@dataclass(frozen=True, eq=False)
class Tracked:
    """What came of a mission of n pings."""

    t_s: Floats
    """(n,) since the first ping."""
    path: Floats
    """(n, 3) of the vehicle at the pings, NED, m."""
    attitude: tuple[Quaternion, ...]
    """(n,) body to global."""
    sector: Sector | None
    """Of the newest ping."""
    tells_heights: bool
    """The sonar has several planes, or measures elevations."""
    mounting: Mounting
    courses: tuple[Course, ...]
    """By id."""
    truths: tuple[TrueCourse, ...]
    """Empty: not known."""
    at_rest: tuple[MapObject, ...]
    """What the map would have after the mission."""
    gospa_m: Floats
    """(n,) of active objects against what is really in the sector; NaN where that is not known."""
    scores: tuple[ObjectScore, ...]
    false_ids: frozenset[int]
    """Of objects that never stood for a true one; empty also where the truth is not known."""
    counters: Mapping[str, int]
    log: PingLog
    """(n,) echoes, faults and validity."""
    _lists: tuple[bytes, ...]

    def list_at(self, place: int) -> ObstacleList | None:
        """Return the list that the planner received for a ping; None: none."""
        packed = self._lists[place] if 0 <= place < len(self._lists) else b""
        return msgspec.msgpack.decode(packed, type=ObstacleList) if packed else None

    def heading(self, place: int) -> float:
        """Return where the vehicle heads at a ping, rad."""
        return heading_of(self.attitude[place])

    def outline(self, place: int) -> Floats:
        """Return the border of what the sonar sees at a ping in its plane, (m, 3) NED; empty: not known."""
        if self.sector is None:
            return np.zeros((0, 3))
        head, turn = self.mounting.head(tuple(self.path[place].tolist()), self.attitude[place])[:2]
        bearings = np.linspace(self.sector.bearing_min_rad, self.sector.bearing_max_rad, BORDER)
        far = polar_to_body(self.sector.range_max_m, bearings)
        return body_to_global(np.vstack([np.zeros((1, 3)), far]), head, turn)

    def truth_of(self, identity: int) -> "TrueCourse | None":
        """Return the true object that an object stood for."""
        name = next((score.name for score in self.scores if identity in score.ids), None)
        return next((truth for truth in self.truths if truth.name == name), None)

    def name_of(self, identity: int) -> str:
        """Return what a track is called: with the true object that it stood for, so that numbers of tracks and names of
        objects are not taken for each other."""
        truth = self.truth_of(identity)
        stood_for = truth.name if truth is not None else "false" if identity in self.false_ids and self.truths else ""
        return f"{track_name(identity)} ({stood_for})" if stood_for else track_name(identity)

    def course(self, identity: int | None) -> Course | None:
        """Return an object's course."""
        return next((course for course in self.courses if course.id == identity), None)


def track_name(identity: int) -> str:
    """Return what a track is called of which nothing else is known."""
    return f"track {identity}"


def heading_of(attitude: Quaternion) -> float:
    """Return where something of an attitude heads, rad from north to east."""
    w, x, y, z = attitude
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


class Beside(NamedTuple):
    """What is known beside the lists."""

    poses: Sequence[Pose]
    truths: Mapping[int, Truth]
    """By ping number."""
    mounting: Mounting
    at_rest: Sequence[MapObject]


class Collecting:
    """Takes the lists of a mission as they come."""

    def __init__(self) -> None:
        self._found: list[Found] = []
        self._lists: list[ObstacleList | None] = []
        self._sector: Sector | None = None

    def __len__(self) -> int:
        return len(self._found)

    def add(self, found: Found, list_: ObstacleList | None) -> None:
        """Take in what came of one ping."""
        self._found.append(found)
        self._lists.append(list_)
        self._sector = self._sector if found.detections is None else found.detections.sector

    def result(self, beside: "Beside", counters: "Counter[str]") -> Tracked:
        """Return what came of it all."""
        truths = beside.truths
        numbers = [found.ping_number for found in self._found]
        t_ns = np.array([found.t_ns for found in self._found], np.int64)
        known = [truths.get(number) for number in numbers]
        t_s = (t_ns - t_ns[0]) / NS if len(t_ns) else np.zeros(0)
        way = _way(beside.poses, t_ns)
        scores, false_ids = self._scored({number: truths[number] for number in numbers if number in truths})
        return Tracked(
            t_s=t_s,
            path=np.array([pose.position_ned for pose in way], np.float64).reshape(-1, 3),
            attitude=tuple(pose.attitude for pose in way),
            sector=self._sector,
            tells_heights=any(map(_tells_heights, self._found)),
            mounting=beside.mounting,
            courses=_courses(self._lists, t_s),
            truths=_true_courses(known, t_s),
            at_rest=tuple(sorted(beside.at_rest, key=lambda item: item.id)),
            gospa_m=np.array([_gospa(truth, list_) for truth, list_ in zip(known, self._lists, strict=True)]),
            scores=tuple(scores),
            false_ids=frozenset(false_ids),
            counters={name: count for name, count in counters.items() if count},
            log=log_of(self._found, self._lists),
            _lists=tuple(b"" if list_ is None else msgspec.msgpack.encode(list_) for list_ in self._lists),
        )

    def _scored(self, truths: dict[int, Truth]) -> tuple[list[ObjectScore], set[int]]:
        if not truths:
            return [], set()
        lists = [(list_.made_ns, list_) for list_ in self._lists if list_ is not None]
        return score_objects(RunRecord(lists=lists, truths=truths), SETTLE_S)


def _tells_heights(found: Found) -> bool:
    message = found.detections
    if message is None:
        return False
    return message.sector.plane_half_rad > 0.0 or any(each.sigma_elevation_rad > 0.0 for each in message.detections)


def _way(poses: Sequence[Pose], t_ns: Ints) -> list[Pose]:
    """Return the newest pose at each of these instants."""
    times = [pose.t_ns for pose in poses]
    return [poses[max(0, bisect_right(times, t) - 1)] for t in t_ns.tolist()]


def _courses(lists: Sequence[ObstacleList | None], t_s: Floats) -> tuple[Course, ...]:
    reported: dict[int, list[tuple[int, Obstacle]]] = defaultdict(list)
    start_utc_ns = 0
    for place, item in enumerate(lists):
        if item is None:
            continue
        start_utc_ns = start_utc_ns or item.utc_ns - round(t_s[place] * NS)
        for obstacle in item.obstacles:
            reported[obstacle.id].append((place, obstacle))
    return tuple(_course(rows, t_s, start_utc_ns) for _, rows in sorted(reported.items()))


def _course(rows: list[tuple[int, Obstacle]], t_s: Floats, start_utc_ns: int) -> Course:
    place = np.array([place for place, _ in rows], np.int64)
    obstacles = [obstacle for _, obstacle in rows]

    def column(name: str) -> Floats:
        return np.array([getattr(obstacle, name) for obstacle in obstacles], np.float64)

    return Course(
        id=obstacles[0].id,
        place=place,
        t_s=t_s[place],
        state=np.array([STATES[obstacle.state] for obstacle in obstacles], np.int64),
        position=column("position_ned"),
        velocity=column("velocity_ned"),
        radius=column("radius_m"),
        sigma_position=column("sigma_position"),
        sigma_velocity=column("sigma_velocity"),
        sigma_radius=column("sigma_radius"),
        covariance_ne=column("covariance_ne"),
        existence=column("existence"),
        first_seen_s=(obstacles[0].first_seen_utc_ns - start_utc_ns) / NS,
    )


def _true_courses(truths: Sequence[Truth | None], t_s: Floats) -> tuple[TrueCourse, ...]:
    rows_by_name = defaultdict(list)
    for place, truth in enumerate(truths):
        for item in () if truth is None else truth.objects:
            rows_by_name[item.name].append((place, item))
    return tuple(
        TrueCourse(
            name,
            t_s[[place for place, _ in rows]],
            np.array([item.position_ned for _, item in rows]),
            np.array([item.velocity_ned for _, item in rows]),
            rows[0][1].radius_m,
        )
        for name, rows in rows_by_name.items()
    )


def _gospa(truth: Truth | None, list_: ObstacleList | None) -> float:
    if truth is None or list_ is None:
        return math.nan
    objects = np.array([item.position_ned[:2] for item in truth.objects if item.in_sector]).reshape(-1, 2)
    tracks = np.array([item.position_ned[:2] for item in list_.obstacles if item.state == "active"]).reshape(-1, 2)
    if not len(objects) or not len(tracks):
        return gospa(np.zeros(0), len(objects), len(tracks))
    pairs = pair(np.hypot(*(objects[:, None] - tracks[None]).transpose(2, 0, 1)))
    return gospa(pairs.distance, len(objects) - len(pairs.objects), len(tracks) - len(pairs.tracks))
