"""Tracks as geographic data: a GeoJSON FeatureCollection (RFC 7946), positions on WGS 84.

A line for the way of the vehicle and of each object that moved, a point for where each object was last. Heights as in
the map's files: above the ellipsoid, the site taken to lie on it.
"""

import json
import math
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec

from ods.base.frames.quaternion import Vector3
from ods.base.geodesy import LocalFrame
from ods.map.export import DEGREE_DIGITS, METRE_DIGITS, utc_text
from ods.messages import Obstacle, ObstacleList, Pose

STEP_M = 0.5
"""A line has a node where it has gone on by this much: a day's poses would be 9 million."""


class Tracks:
    """Collects tracks and gives them as GeoJSON."""

    def __init__(self, frame: LocalFrame) -> None:
        self._frame = frame
        self._vehicle = _Way()
        self._ways: dict[int, _Way] = {}
        self._last: dict[int, Obstacle] = {}

    def add(self, stamp_ns: int, message: msgspec.Struct) -> None:
        """Take what a pose or a list of obstacles tells; anything else is passed over."""
        if isinstance(message, Pose):
            self._vehicle.go_on(message.position_ned, stamp_ns)
        elif isinstance(message, ObstacleList):
            for obstacle in message.obstacles:
                before = self._last.get(obstacle.id)
                if before is None or obstacle.last_seen_utc_ns > before.last_seen_utc_ns:
                    self._ways.setdefault(obstacle.id, _Way()).go_on(obstacle.position_ned, stamp_ns)
                self._last[obstacle.id] = obstacle

    def collection(self) -> dict[str, Any]:
        """Return the FeatureCollection."""
        features = [self._line("vehicle", {"what": "vehicle"}, self._vehicle)] if self._vehicle.nodes else []
        for number, obstacle in sorted(self._last.items()):
            about = attributes(obstacle)
            point = {"type": "Point", "coordinates": self._coordinates([obstacle.position_ned])[0]}
            features.append({"type": "Feature", "id": number, "geometry": point, "properties": about})
            if len(self._ways[number].nodes) > 1:
                about = {"what": "track", "object": number, "state": obstacle.state}
                features.append(self._line(f"track-{number}", about, self._ways[number]))
        return {"type": "FeatureCollection", "features": [f for f in features if _finite(f["geometry"])]}

    def _line(self, name: str, about: dict[str, Any], way: "_Way") -> dict[str, Any]:
        about = {**about, "begin_utc": _utc(way.begin_ns), "end_utc": _utc(way.end_ns)}
        return {"type": "Feature", "id": name, "geometry": _way_in(self._coordinates(way.nodes)), "properties": about}

    def _coordinates(self, nodes: list[Vector3]) -> list[list[float]]:
        """Return longitude, latitude, deg, and height, m."""
        latitude, longitude, height = self._frame.geodetic(nodes)
        rounded = (longitude.round(DEGREE_DIGITS), latitude.round(DEGREE_DIGITS), height.round(METRE_DIGITS))
        return [list(node) for node in zip(*(column.tolist() for column in rounded), strict=True)]


class GeoJsonFile:
    """Writes tracks into a new file when it is closed."""

    def __init__(self, path: Path, frame: LocalFrame) -> None:
        """Raises OSError."""
        self.losses: Counter[str] = Counter()
        self._tracks = Tracks(frame)
        self._file = path.open("x", encoding="utf-8")

    def take(self, stamp_ns: int, message: msgspec.Struct) -> None:
        """Take a message's part of the tracks."""
        self._tracks.add(stamp_ns, message)

    def close(self) -> None:
        """Raises OSError."""
        with self._file:
            json.dump(self._tracks.collection(), self._file, allow_nan=False)
            self._file.write("\n")


class _Way:
    """Where something was, a node each STEP_M."""

    def __init__(self) -> None:
        self.nodes: list[Vector3] = []
        self.begin_ns = self.end_ns = 0

    def go_on(self, place: Vector3, stamp_ns: int) -> None:
        if not all(map(math.isfinite, place)):
            return
        if not self.nodes:
            self.begin_ns = stamp_ns
        if not self.nodes or math.dist(self.nodes[-1], place) >= STEP_M:
            self.nodes.append(place)
        self.end_ns = stamp_ns


def attributes(o: Obstacle) -> dict[str, Any]:
    """Return what is told of an object beside its place, by the names of the map's files."""
    numbers = {
        **dict(zip(("north_m", "east_m", "down_m"), o.position_ned, strict=True)),
        **dict(zip(("sigma_north_m", "sigma_east_m", "sigma_down_m"), o.sigma_position, strict=True)),
        **dict(zip(("v_north_mps", "v_east_mps", "v_down_mps"), o.velocity_ned, strict=True)),
        "covariance_ne_m2": o.covariance_ne, "radius_m": o.radius_m, "sigma_radius_m": o.sigma_radius,
        "existence": o.existence,
    }  # fmt: skip
    return {
        "what": "object", "object": o.id, "state": o.state,
        **{name: round(value, 4) if math.isfinite(value) else None for name, value in numbers.items()},
        "times_seen": o.times_seen, "first_seen_utc": _utc(o.first_seen_utc_ns),
        "last_seen_utc": _utc(o.last_seen_utc_ns),
    }  # fmt: skip


def _utc(utc_ns: int) -> str | None:
    """Return an instant as text; None where no calendar has it."""
    try:
        return utc_text(utc_ns)
    except OverflowError:
        return None


def _way_in(nodes: list[list[float]]) -> dict[str, Any]:
    """Return a way as a line, in parts at the date line; as a point where it has one node: a line needs two.

    A part of one node is left out: its end is within STEP_M of the other part's.
    """
    lines = [part for part in _parts(nodes) if len(part) > 1]
    if not lines:
        return {"type": "Point", "coordinates": nodes[0]}
    if len(lines) == 1:
        return {"type": "LineString", "coordinates": lines[0]}
    return {"type": "MultiLineString", "coordinates": lines}


def _parts(nodes: list[list[float]]) -> list[list[list[float]]]:
    """Return a line in parts of which none crosses the date line (RFC 7946, 3.1.9)."""
    parts = [nodes[:1]]
    for before, node in pairwise(nodes):
        if abs(node[0] - before[0]) > 180.0:
            parts.append([])
        parts[-1].append(node)
    return parts


def _finite(geometry: dict[str, Any]) -> bool:
    """Return whether a geometry has numbers that JSON knows."""
    return "nan" not in (text := str(geometry["coordinates"])) and "inf" not in text
