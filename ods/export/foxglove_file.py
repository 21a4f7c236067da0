"""An MCAP file of Foxglove's own messages (protobuf), for Foxglove and Lichtblick; schemas of the library foxglove-sdk.

Frames: `map`, ENU with its origin at the site; `base_link`, the vehicle, FLU; `sonar`, its head, FLU.
"""

import math
import re
from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
from foxglove import messages as fg
from mcap.writer import Writer

from ods.base.clock import NS
from ods.base.frames.mounting import Mounting
from ods.base.frames.quaternion import Quaternion, Vector3
from ods.base.geodesy import LocalFrame
from ods.export.fan_raster import FanRaster
from ods.export.sink import UnfitMessageError
from ods.messages import Detection, Detections, Health, Obstacle, ObstacleList, Ping, Pose
from ods.ros2 import enu
from ods.runtime.bus import TOPICS as BUS_TOPICS

MAP, VEHICLE, HEAD = "map", "base_link", "sonar"
TOPICS: dict[str, type[Any]] = {
    "/sonar/image": fg.RawImage,
    "/sonar/detections": fg.ImageAnnotations,
    "/obstacles": fg.SceneUpdate,
    "/tf": fg.FrameTransforms,
    "/location": fg.LocationFix,
    "/log": fg.Log,
}
COLOURS = {"active": (1.0, 0.45, 0.1), "stand_by": (0.95, 0.8, 0.2), "hibernated": (0.35, 0.6, 1.0)}
NOT_VALID = (0.5, 0.5, 0.5)
"""Of all objects of a list that is not to be relied on."""
SIGMAS = 2.0
"""Width of the halo around an object, standard deviations of its position."""
NUMBER = re.compile(r"\d+(\.\d+)?")
LIFETIME_S = BUS_TOPICS["obstacles"].stale_s
"""What is not reported again disappears after this."""


class FoxgloveFile:
    """Writes a new file."""

    def __init__(self, path: Path, mounting: Mounting, frame: LocalFrame) -> None:
        """Raises OSError."""
        self.losses: Counter[str] = Counter()
        self._messages = FoxgloveMessages(mounting, frame)
        self._file = path.open("xb")
        self._writer = Writer(self._file)
        self._writer.start(library="ods export")
        self._channels = {topic: self._channel(topic, kind) for topic, kind in TOPICS.items()}

    def _channel(self, topic: str, kind: type[Any]) -> int:
        schema = kind.get_schema()
        number = self._writer.register_schema(schema.name, schema.encoding, schema.data)
        return self._writer.register_channel(topic, schema.encoding, number)

    def take(self, stamp_ns: int, message: msgspec.Struct) -> None:
        """Write a converted message. Raises OSError, UnfitMessageError."""
        for topic, content in self._messages.of(stamp_ns, message):
            self._writer.add_message(self._channels[topic], stamp_ns, content.encode(), stamp_ns)

    def close(self) -> None:
        """Raises OSError."""
        with self._file:
            self._writer.finish()


class FoxgloveMessages:
    """Turns messages into Foxglove's."""

    def __init__(self, mounting: Mounting, frame: LocalFrame) -> None:
        self._mounting, self._frame = mounting, frame
        self._raster = FanRaster()
        self._said: dict[str, list[str]] = {}

    def of(self, stamp_ns: int, message: msgspec.Struct) -> list[tuple[str, Any]]:
        """Return topics and messages. Raises UnfitMessageError."""
        stamp = fg.Timestamp(*divmod(stamp_ns, NS))
        if isinstance(message, Ping):
            return [("/sonar/image", self._image(stamp, message))]
        if isinstance(message, Detections):
            return [("/sonar/detections", self._circles(stamp, message))] if self._raster.metres_a_pixel else []
        if isinstance(message, Pose):
            return [("/tf", self._frames(stamp, message)), ("/location", self._location(stamp, message))]
        if isinstance(message, ObstacleList):
            verdict = message.reasons or ([] if message.valid else ["not valid"])
            verdict = [*verdict, message.caution] if message.caution else verdict
            return [("/obstacles", scene(stamp, message)), *self._news(stamp, "obstacles", verdict)]
        if isinstance(message, Health):
            return self._news(stamp, message.process, message.problems)
        return []

    def _image(self, stamp: fg.Timestamp, ping: Ping) -> fg.RawImage:
        try:
            picture = self._raster.image(ping)
        except (ValueError, ArithmeticError) as error:
            raise UnfitMessageError("pings that are not images") from error
        height, width = picture.shape
        return fg.RawImage(
            timestamp=stamp, frame_id=HEAD, width=width, height=height, encoding="mono8", step=width,
            data=picture.tobytes(),
        )  # fmt: skip

    def _circles(self, stamp: fg.Timestamp, found: Detections) -> fg.ImageAnnotations:
        """Return the detections as circles on the last image, which is that of their ping or the one before."""
        circles = [self._circle(stamp, detection) for detection in found.detections]
        return fg.ImageAnnotations(timestamp=stamp, circles=circles)

    def _circle(self, stamp: fg.Timestamp, d: Detection) -> fg.CircleAnnotation:
        x, y = self._raster.pixel(d.range_m, d.bearing_rad)
        return fg.CircleAnnotation(
            timestamp=stamp, position=fg.Point2(x=x, y=y), diameter=2.0 * d.radius_m / self._raster.metres_a_pixel,
            thickness=1.5, outline_color=_colour(COLOURS["active"], 1.0),
            metadata=_pairs({"range_m": d.range_m, "radius_m": d.radius_m, "snr_db": d.snr_db}),
        )  # fmt: skip

    def _frames(self, stamp: fg.Timestamp, pose: Pose) -> fg.FrameTransforms:
        """Return vehicle and head: both each time, so that any part of the file has them."""
        place, turn = enu.enu(pose.position_ned), enu.attitude(pose.attitude)
        lever, mounted = enu.flu(self._mounting.lever), enu.mounting(self._mounting.turn)
        return fg.FrameTransforms(
            transforms=[
                _transform(stamp, (MAP, VEHICLE), place, turn),
                _transform(stamp, (VEHICLE, HEAD), lever, mounted),
            ]
        )

    def _location(self, stamp: fg.Timestamp, pose: Pose) -> fg.LocationFix:
        latitude, longitude, height = self._frame.geodetic(pose.position_ned)
        return fg.LocationFix(
            timestamp=stamp, frame_id=VEHICLE, latitude=float(latitude), longitude=float(longitude),
            altitude=float(height), position_covariance=list(enu.covariance(pose.sigma_position_ned)),
            position_covariance_type=fg.LocationFixPositionCovarianceType.DiagonalKnown,
        )  # fmt: skip

    def _news(self, stamp: fg.Timestamp, who: str, problems: list[str]) -> list[tuple[str, Any]]:
        """Return a line of the log where what is wrong is not what was wrong before, whatever its numbers are now."""
        what = [NUMBER.sub("#", problem) for problem in problems]
        before, self._said[who] = self._said.get(who, []), what
        if what == before:
            return []
        level = fg.LogLevel.Warning if problems else fg.LogLevel.Info
        return [("/log", fg.Log(timestamp=stamp, level=level, message="; ".join(problems) or "all is well", name=who))]


def scene(stamp: fg.Timestamp, obstacle_list: ObstacleList) -> fg.SceneUpdate:
    """Return all obstacles of a list, in place of all that were there."""
    everything = fg.SceneEntityDeletion(timestamp=stamp, type=fg.SceneEntityDeletionType.All)
    there = [_entity(stamp, o, obstacle_list.valid) for o in obstacle_list.obstacles if o.state != "terminated"]
    return fg.SceneUpdate(deletions=[everything], entities=there)


def _entity(stamp: fg.Timestamp, o: Obstacle, valid: bool) -> fg.SceneEntity:
    place = enu.enu(o.position_ned)
    colour = COLOURS[o.state] if valid else NOT_VALID
    across, along, turn = _ellipse(o)
    body = fg.CylinderPrimitive(
        pose=_pose(place), size=fg.Vector3(x=2.0 * o.radius_m, y=2.0 * o.radius_m, z=2.0 * o.radius_m),
        bottom_scale=1.0, top_scale=1.0, color=_colour(colour, 0.9),
    )  # fmt: skip
    halo = fg.CylinderPrimitive(
        pose=_pose(place, (math.cos(0.5 * turn), 0.0, 0.0, math.sin(0.5 * turn))),
        size=fg.Vector3(x=2.0 * (o.radius_m + across), y=2.0 * (o.radius_m + along), z=0.2),
        bottom_scale=1.0, top_scale=1.0, color=_colour(colour, 0.25),
    )  # fmt: skip
    said = f"{o.id} \u00b1{max(across, along) / SIGMAS:.1f} m"
    label = fg.TextPrimitive(
        pose=_pose((place[0], place[1], place[2] + 2.0 * o.radius_m)), billboard=True, font_size=14.0,
        scale_invariant=True, color=_colour((1.0, 1.0, 1.0), 1.0), text=said,
    )  # fmt: skip
    return fg.SceneEntity(
        timestamp=stamp, frame_id=MAP, id=f"obstacle-{o.id}", lifetime=fg.Duration(*divmod(round(LIFETIME_S * NS), NS)),
        metadata=_pairs(_fields(o)), cylinders=[body, halo], texts=[label],
    )  # fmt: skip


def _fields(o: Obstacle) -> dict[str, object]:
    """Return what a click on an obstacle shows."""
    return {
        "id": o.id, "state": o.state, "existence": o.existence, "radius_m": o.radius_m,
        "sigma_radius_m": o.sigma_radius, "velocity_ned_mps": o.velocity_ned, "sigma_ned_m": o.sigma_position,
        "times_seen": o.times_seen, "unseen_s": o.unseen_s,
        "closest_approach_m": o.cpa.distance_m if o.cpa else None,
        "closest_approach_in_s": o.cpa.time_s if o.cpa else None, "multipath_of": o.multipath_of,
        "ignored_by": o.ignored_by,
    }  # fmt: skip


def _ellipse(o: Obstacle) -> tuple[float, float, float]:
    """Return SIGMAS standard deviations along the principal axes, m, and the first one's angle from east, rad."""
    (east, shared, _, _, north, *_) = enu.covariance(o.sigma_position, o.covariance_ne)
    mean, half = 0.5 * (east + north), 0.5 * (east - north)
    spread = math.hypot(half, shared)
    first, second = math.sqrt(max(0.0, mean + spread)), math.sqrt(max(0.0, mean - spread))
    return SIGMAS * first, SIGMAS * second, 0.5 * math.atan2(shared, half)


def _transform(stamp: fg.Timestamp, frames: tuple[str, str], place: Vector3, turn: Quaternion) -> fg.FrameTransform:
    """`frames`: parent and child; place and turn of the child."""
    return fg.FrameTransform(
        timestamp=stamp, parent_frame_id=frames[0], child_frame_id=frames[1], translation=_vector(place),
        rotation=_quaternion(turn),
    )  # fmt: skip


def _pose(place: Vector3, turn: Quaternion = (1.0, 0.0, 0.0, 0.0)) -> fg.Pose:
    return fg.Pose(position=_vector(place), orientation=_quaternion(turn))


def _vector(v: Vector3) -> fg.Vector3:
    return fg.Vector3(x=v[0], y=v[1], z=v[2])


def _quaternion(q: Quaternion) -> fg.Quaternion:
    return fg.Quaternion(x=q[1], y=q[2], z=q[3], w=q[0])


def _colour(rgb: tuple[float, float, float], opacity: float) -> fg.Color:
    return fg.Color(r=rgb[0], g=rgb[1], b=rgb[2], a=opacity)


def _pairs(values: dict[str, Any]) -> list[fg.KeyValuePair]:
    return [fg.KeyValuePair(key=key, value=_text(value)) for key, value in values.items()]


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(map(_text, value))
    return f"{value:.4g}" if isinstance(value, float) else str(value)
