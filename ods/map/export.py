"""Maps as geographic data: GeoJSON (RFC 7946) and GeoPackage, positions on WGS 84.

Heights are above the ellipsoid, the origin of the local frame taken to lie on it: 0 is near the sea's surface only
where the geoid is near the ellipsoid. The depth in the local frame is an attribute of its own.
"""

import json
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from ods.base.geodesy import LocalFrame
from ods.map import geopackage
from ods.tracker.map.map_object import MapObject

LAYER = "obstacles"
FIELDS = {
    "id": "INTEGER",
    **dict.fromkeys(("north_m", "east_m", "down_m", "sigma_north_m", "sigma_east_m", "sigma_down_m"), "DOUBLE"),
    **dict.fromkeys(("covariance_ne_m2", "radius_m", "sigma_radius_m", "existence"), "DOUBLE"),
    "times_seen": "INTEGER",
    **dict.fromkeys(("first_seen_utc", "last_seen_utc", "hibernated_utc"), "DATETIME"),
}
"""Attributes of an object and their SQL types."""
DEGREE_DIGITS, METRE_DIGITS = 7, 3
"""Digits after the point: 1 cm and 1 mm."""

Point = tuple[float, float, float]


def utc_text(utc_ns: int) -> str:
    """Return an instant as ISO 8601, to the millisecond below."""
    instant = datetime(1970, 1, 1, tzinfo=UTC) + timedelta(milliseconds=utc_ns // 1_000_000)
    return instant.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def points_of(objects: list[MapObject], frame: LocalFrame) -> list[Point]:
    """Return longitude and latitude in deg and height in m of each object, rounded as they are written."""
    if not objects:
        return []
    latitude, longitude, height = frame.geodetic([o.position for o in objects])
    rounded = (longitude.round(DEGREE_DIGITS), latitude.round(DEGREE_DIGITS), height.round(METRE_DIGITS))
    return list(zip(*(column.tolist() for column in rounded), strict=True))


def write_geopackage(path: Path, objects: list[MapObject], frame: LocalFrame) -> None:
    """Write a new file with one layer. Raises sqlite3.Error."""
    geopackage.write_points(path, LAYER, FIELDS, points_of(objects, frame), [_attributes(o) for o in objects])


def write_geojson(path: Path, objects: list[MapObject], frame: LocalFrame) -> None:
    """Write one FeatureCollection. Raises OSError."""
    path.write_text(json.dumps(geojson(objects, frame), allow_nan=False, indent=1) + "\n", encoding="utf-8")


def geojson(objects: list[MapObject], frame: LocalFrame) -> dict[str, Any]:
    """Return the map as a GeoJSON FeatureCollection."""
    points = points_of(objects, frame)
    features = [_feature(o, point) for o, point in zip(objects, points, strict=True)]
    box = {"bbox": _bounding_box(points, frame.longitude_deg)} if points else {}
    return {"type": "FeatureCollection", **box, "features": features}


def _feature(o: MapObject, point: Point) -> dict[str, Any]:
    properties = dict(zip(FIELDS, _attributes(o), strict=True))
    geometry = {"type": "Point", "coordinates": list(point)}
    return {"type": "Feature", "id": o.id, "geometry": geometry, "properties": properties}


def _bounding_box(points: list[Point], middle_deg: float) -> list[float]:
    """Return west, south, lowest, east, north, highest; west > east across the date line (RFC 7946, 5.2)."""
    longitude, latitude, height = np.array(points).T
    from_middle = (longitude - middle_deg + 180.0) % 360.0 - 180.0
    west, east = longitude[from_middle.argmin()], longitude[from_middle.argmax()]
    corners = (west, latitude.min(), height.min(), east, latitude.max(), height.max())
    return [float(value) for value in corners]


def _attributes(o: MapObject) -> list[float | int | str]:
    """Return the values of `FIELDS`."""
    metres = (*o.position, *o.sigma, o.covariance_ne, o.radius, o.sigma_radius)
    times = (o.first_seen_utc_ns, o.last_seen_utc_ns, o.hibernated_utc_ns)
    return [o.id, *(round(v, 4) for v in metres), round(o.existence, 6), o.times_seen, *(utc_text(t) for t in times)]
