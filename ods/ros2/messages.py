"""Messages of ODS as messages of ROS 2: the types and their CDR are those of the library rosbags; no ROS is needed.

Frames (REP 103, REP 105): `map`, ENU with its origin at the site; `base_link`, the vehicle, FLU; `sonar`, its head,
FLU; `sonar_fan`, the axes of marine_acoustic_msgs.
"""

from typing import Any, NamedTuple

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from ods.base.clock import NS
from ods.base.frames.mounting import Mounting
from ods.base.frames.quaternion import Quaternion, Vector3
from ods.messages import Obstacle, ObstacleList, Ping, Pose, frame_of, seen_from_above
from ods.ros2 import definitions as texts, enu

SAMPLE_TYPES = {"u1": 0, "u2": 2, "f4": 8}
"""Ping.dtype to SonarImageData.dtype."""
OK, WARN, ERROR, STALE = 0, 1, 2, 3
"""Levels of a DiagnosticStatus."""
UNKNOWN = 1e6
"""Variance of a velocity or turn rate, (m/s)^2 or (rad/s)^2: 0 would say that it is known exactly."""


class Frames(NamedTuple):
    """Names of the frames."""

    map: str = "map"
    vehicle: str = "base_link"
    head: str = "sonar"
    fan: str = "sonar_fan"


STANDARD_FRAMES = Frames()


class Messages:
    """Makes messages of ROS: new objects of its types, and of what ODS says."""

    def __init__(self, frames: Frames = STANDARD_FRAMES) -> None:
        self.store = get_typestore(Stores.ROS2_JAZZY)
        for name, text in texts.DEFINITIONS.items():
            self.store.register(get_types_from_msg(text, name))
        self.frames = frames
        self._types: dict[str, Any] = {}
        self._fan: tuple[list[float], list[float]] = [], []
        self._directions: list[Any] = []

    def image(self, stamp_ns: int, ping: Ping) -> Any:
        """Return the ProjectedSonarImage: samples as recorded, those of one range side by side. Raises ValueError.

        A range image is shown from above.
        """
        ping = seen_from_above(ping)
        samples = frame_of(ping)
        data = np.frombuffer(np.ascontiguousarray(samples.T).tobytes(), np.uint8)
        ranges = ping.range0_m + ping.dr_m * np.arange(ping.samples)
        widths = np.array(ping.beam_width_rad, np.float32)
        heights = np.zeros(0, np.float32)
        return self.new(
            texts.PROJECTED_SONAR_IMAGE,
            self.header(stamp_ns, self.frames.fan),
            self.new(texts.PING_INFO, ping.frequency_hz, ping.sound_speed, heights, widths),
            self._beams(ping),
            ranges.astype(np.float32),
            self.new(texts.SONAR_IMAGE_DATA, False, SAMPLE_TYPES[ping.dtype], ping.beams, data),
        )

    def odometry(self, stamp_ns: int, pose: Pose) -> Any:
        """Return the vehicle's pose and velocity. Turn rates, and how sure the velocity is, are not known."""
        place = self.place(enu.enu(pose.position_ned), enu.attitude(pose.attitude))
        spread = np.zeros((6, 6))
        spread[:3, :3] = np.reshape(enu.covariance(pose.sigma_position_ned), (3, 3))
        spread[3:, 3:] = np.diag(np.square(pose.sigma_attitude))
        speed = self.new(
            "geometry_msgs/msg/Twist", self.vector(enu.flu(pose.velocity_body)), self.vector((0.0, 0.0, 0.0))
        )
        return self.new(
            "nav_msgs/msg/Odometry",
            self.header(stamp_ns, self.frames.map),
            self.frames.vehicle,
            self.new("geometry_msgs/msg/PoseWithCovariance", place, spread.ravel()),
            self.new("geometry_msgs/msg/TwistWithCovariance", speed, UNKNOWN * np.eye(6).ravel()),
        )

    def place(self, position: Vector3, turn: Quaternion) -> Any:
        """Return a Pose; turn: (w, x, y, z)."""
        w, x, y, z = turn
        return self.new(
            "geometry_msgs/msg/Pose", self.point(position), self.new("geometry_msgs/msg/Quaternion", x, y, z, w)
        )

    def point(self, v: Vector3) -> Any:
        """Return a Point."""
        return self.new("geometry_msgs/msg/Point", *v)

    def uuid(self, id_: int) -> Any:
        """Return the UUID of an obstacle: its id, big endian."""
        return self.new("unique_identifier_msgs/msg/UUID", np.frombuffer((id_ % 2**64).to_bytes(16, "big"), np.uint8))

    def obstacles(self, stamp_ns: int, obstacle_list: ObstacleList) -> Any:
        """Return the ObstacleArray of those that are still there."""
        there = [self._obstacle(o) for o in obstacle_list.obstacles if o.state != "terminated"]
        return self.new(texts.OBSTACLE_ARRAY, self.header(stamp_ns, self.frames.map), there)

    def _obstacle(self, o: Obstacle) -> Any:
        across = 2.0 * o.radius_m
        return self.new(
            texts.OBSTACLE,
            self.uuid(o.id),
            o.existence,
            self.point(enu.enu(o.position_ned)),
            self.vector(enu.enu(o.velocity_ned)),
            self.vector((across, across, across)),
            np.array(enu.covariance(o.sigma_position, o.covariance_ne)),
            np.array(enu.covariance(o.sigma_velocity)),
        )

    def mounting(self, stamp_ns: int, mounting: Mounting) -> Any:
        """Return where the sonar's head is on the vehicle, and the fan's axes in it."""
        on_vehicle = self.frames.vehicle, self.frames.head
        head = self.transform(stamp_ns, on_vehicle, enu.flu(mounting.lever), enu.mounting(mounting.turn))
        return self.new("tf2_msgs/msg/TFMessage", [head, self.fan(stamp_ns)])

    def fan(self, stamp_ns: int) -> Any:
        """Return the fan's axes in the head."""
        return self.transform(stamp_ns, (self.frames.head, self.frames.fan), (0.0, 0.0, 0.0), enu.FAN_TO_HEAD)

    def _beams(self, ping: Ping) -> list[Any]:
        if (ping.bearing_rad, ping.elevation_rad) != self._fan:
            self._fan = ping.bearing_rad, ping.elevation_rad
            elevation = ping.elevation_rad or [0.0] * len(ping.bearing_rad)
            beams = zip(ping.bearing_rad, elevation, strict=False)
            self._directions = [self.vector(enu.fan(bearing, up)) for bearing, up in beams]
        return self._directions

    def diagnostic(self, stamp_ns: int, name: str, level: int, said: str, values: dict[str, Any]) -> Any:
        """Return a DiagnosticArray with one status."""
        pairs = [self.new("diagnostic_msgs/msg/KeyValue", key, str(value)) for key, value in values.items()]
        status = self.new("diagnostic_msgs/msg/DiagnosticStatus", level, name, said, "", pairs)
        return self.new("diagnostic_msgs/msg/DiagnosticArray", self.header(stamp_ns, ""), [status])

    def transform(self, stamp_ns: int, frames: tuple[str, str], place: Vector3, turn: Quaternion) -> Any:
        """Return a TransformStamped; `frames`: parent and child; place and turn of the child."""
        w, x, y, z = turn
        moved = self.new(
            "geometry_msgs/msg/Transform", self.vector(place), self.new("geometry_msgs/msg/Quaternion", x, y, z, w)
        )
        return self.new("geometry_msgs/msg/TransformStamped", self.header(stamp_ns, frames[0]), frames[1], moved)

    def header(self, stamp_ns: int, frame: str) -> Any:
        """Return a Header of an instant, UTC, and a frame."""
        return self.new("std_msgs/msg/Header", self.new("builtin_interfaces/msg/Time", *divmod(stamp_ns, NS)), frame)

    def vector(self, v: Vector3) -> Any:
        """Return a Vector3."""
        return self.new("geometry_msgs/msg/Vector3", *v)

    def new(self, kind: str, *values: Any) -> Any:
        """Return a message of a type, of all its fields in their order."""
        made = self._types.get(kind)
        if made is None:
            made = self._types[kind] = self.store.types[kind]
        return made(*values)

    def cdr(self, message: Any, kind: str) -> bytes:
        """Return a message's bytes on the wire, little endian."""
        return bytes(self.store.serialize_cdr(message, kind))
