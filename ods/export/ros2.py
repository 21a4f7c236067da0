"""A ROS 2 bag (rosbag2 folder, MCAP, CDR), written without ROS by the library rosbags.

Frames (REP 103, REP 105): `map`, ENU with its origin at the site; `base_link`, the vehicle, FLU; `sonar`, its head,
FLU; `sonar_fan`, the axes of marine_acoustic_msgs.
"""

from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from ods.base.clock import NS
from ods.base.mounting import Mounting
from ods.base.quaternion import Quaternion, Vector3
from ods.export import enu
from ods.export import ros2_messages as texts
from ods.export.sink import UnfitMessageError
from ods.messages import Health, Obstacle, ObstacleList, Ping, Pose, frame_of, seen_from_above

MAP, VEHICLE, HEAD, FAN = "map", "base_link", "sonar", "sonar_fan"
TOPICS = {
    "/sonar_image": texts.PROJECTED_SONAR_IMAGE,
    "/odometry": "nav_msgs/msg/Odometry",
    "/obstacles": texts.OBSTACLE_ARRAY,
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
}
FOREVER = QosTime(2147483647, 4294967295)
FOR_LATECOMERS = Qos(
    QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL, FOREVER, FOREVER,
    QosLiveliness.AUTOMATIC, FOREVER, False,
)  # fmt: skip
"""Of /tf_static: who subscribes later gets it, too."""
SAMPLE_TYPES = {"u1": 0, "u2": 2, "f4": 8}
"""Ping.dtype to SonarImageData.dtype."""
OK, WARN, ERROR = 0, 1, 2
"""Levels of a DiagnosticStatus."""


class Ros2Bag:
    """Writes a bag into a new folder."""

    def __init__(self, folder: Path, mounting: Mounting) -> None:
        """Raises OSError."""
        self.losses: Counter[str] = Counter()
        self._messages = Ros2Messages(mounting)
        self._writer = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._writer.open()
        store = self._messages.store
        self._connections = {
            topic: self._writer.add_connection(
                topic, kind, typestore=store, offered_qos_profiles=[FOR_LATECOMERS] if topic == "/tf_static" else []
            )
            for topic, kind in TOPICS.items()
        }
        self._begun = False

    def take(self, stamp_ns: int, message: msgspec.Struct) -> None:
        """Write what a message becomes. Raises OSError, UnfitMessageError."""
        found = self._messages.of(stamp_ns, message)
        if not self._begun:
            self._begun = True
            found.insert(0, ("/tf_static", self._messages.mounting(stamp_ns)))
        for topic, content in found:
            data = self._messages.store.serialize_cdr(content, TOPICS[topic])
            at_ns = self._messages.diagnosed_ns if topic == "/diagnostics" else stamp_ns
            self._writer.write(self._connections[topic], at_ns, data)

    def close(self) -> None:
        """Raises OSError."""
        self._writer.close()


class Ros2Messages:
    """Turns messages into those of ROS."""

    def __init__(self, mounting: Mounting) -> None:
        self.store = get_typestore(Stores.ROS2_JAZZY)
        for name, text in texts.DEFINITIONS.items():
            self.store.register(get_types_from_msg(text, name))
        self.diagnosed_ns = 0
        """Of the newest DiagnosticArray: of several processes, in the order in which they were heard."""
        self._mounting = mounting
        self._fan: tuple[list[float], list[float]] = [], []
        self._directions: list[Any] = []

    def of(self, stamp_ns: int, message: msgspec.Struct) -> list[tuple[str, Any]]:
        """Return topics and messages. Raises UnfitMessageError."""
        if isinstance(message, Ping):
            return [("/sonar_image", self.image(stamp_ns, message))]
        if isinstance(message, Pose):
            place, turn = enu.enu(message.position_ned), enu.attitude(message.attitude)
            vehicle = self._transform(stamp_ns, (MAP, VEHICLE), place, turn)
            return [
                ("/odometry", self.odometry(stamp_ns, message)),
                ("/tf", self._new("tf2_msgs/msg/TFMessage", [vehicle])),
            ]
        if isinstance(message, ObstacleList):
            return [
                ("/obstacles", self.obstacles(stamp_ns, message)),
                ("/diagnostics", self.verdict(stamp_ns, message)),
            ]
        if isinstance(message, Health):
            return [("/diagnostics", self.health(stamp_ns, message))]
        return []

    def image(self, stamp_ns: int, ping: Ping) -> Any:
        """Return the ProjectedSonarImage: samples as recorded, those of one range side by side."""
        try:
            ping = seen_from_above(ping)
            samples = frame_of(ping)
        except ValueError as error:
            raise UnfitMessageError("pings whose samples do not fit their shape") from error
        data = np.frombuffer(np.ascontiguousarray(samples.T).tobytes(), np.uint8)
        ranges = ping.range0_m + ping.dr_m * np.arange(ping.samples)
        widths = np.array(ping.beam_width_rad, np.float32)
        heights = np.zeros(0, np.float32)
        return self._new(
            texts.PROJECTED_SONAR_IMAGE,
            self._header(stamp_ns, FAN),
            self._new(texts.PING_INFO, ping.frequency_hz, ping.sound_speed, heights, widths),
            self._beams(ping),
            ranges.astype(np.float32),
            self._new(texts.SONAR_IMAGE_DATA, False, SAMPLE_TYPES[ping.dtype], ping.beams, data),
        )

    def odometry(self, stamp_ns: int, pose: Pose) -> Any:
        """Return the vehicle's pose and velocity; how sure the velocity is and turn rates are not known: all 0."""
        w, x, y, z = enu.attitude(pose.attitude)
        spread = np.zeros((6, 6))
        spread[:3, :3] = np.reshape(enu.covariance(pose.sigma_position_ned), (3, 3))
        spread[3:, 3:] = np.diag(np.square(pose.sigma_attitude))
        place = self._new(
            "geometry_msgs/msg/Pose",
            self._new("geometry_msgs/msg/Point", *enu.enu(pose.position_ned)),
            self._new("geometry_msgs/msg/Quaternion", x, y, z, w),
        )
        speed = self._new(
            "geometry_msgs/msg/Twist", self._vector(enu.flu(pose.velocity_body)), self._vector((0.0, 0.0, 0.0))
        )
        return self._new(
            "nav_msgs/msg/Odometry",
            self._header(stamp_ns, MAP),
            VEHICLE,
            self._new("geometry_msgs/msg/PoseWithCovariance", place, spread.ravel()),
            self._new("geometry_msgs/msg/TwistWithCovariance", speed, np.zeros(36)),
        )

    def obstacles(self, stamp_ns: int, picture: ObstacleList) -> Any:
        """Return the ObstacleArray of those that are still there."""
        there = [self._obstacle(o) for o in picture.obstacles if o.state != "terminated"]
        return self._new(texts.OBSTACLE_ARRAY, self._header(stamp_ns, MAP), there)

    def _obstacle(self, o: Obstacle) -> Any:
        uuid = np.frombuffer((o.id % 2**64).to_bytes(16, "big"), np.uint8)
        across = 2.0 * o.radius_m
        return self._new(
            texts.OBSTACLE,
            self._new("unique_identifier_msgs/msg/UUID", uuid),
            o.existence,
            self._new("geometry_msgs/msg/Point", *enu.enu(o.position_ned)),
            self._vector(enu.enu(o.velocity_ned)),
            self._vector((across, across, across)),
            np.array(enu.covariance(o.sigma_position, o.covariance_ne)),
            np.array(enu.covariance(o.sigma_velocity)),
        )

    def verdict(self, stamp_ns: int, picture: ObstacleList) -> Any:
        """Return whether the list is to be relied on: ObstacleArray cannot tell."""
        stamp_ns += picture.made_ns - picture.t_ns if picture.made_ns else 0  # the instant for which it holds
        said = "; ".join(picture.reasons) or ("valid" if picture.valid else "not valid")
        values = {"seq": picture.seq, "ping_number": picture.ping_number, "left_out": picture.left_out}
        return self._diagnostic(stamp_ns, "ods: obstacles", OK if picture.valid else ERROR, said, values)

    def health(self, stamp_ns: int, health: Health) -> Any:
        """Return a process's state, with its counters."""
        said = "; ".join(health.problems) or ("all is well" if health.ready else "starting")
        level = WARN if health.problems or not health.ready else OK
        return self._diagnostic(stamp_ns, f"ods: {health.process}", level, said, health.counters)

    def mounting(self, stamp_ns: int) -> Any:
        """Return where the sonar's head is on the vehicle, and the fan's axes in it."""
        head = self._transform(
            stamp_ns, (VEHICLE, HEAD), enu.flu(self._mounting.lever), enu.mounting(self._mounting.turn)
        )
        fan = self._transform(stamp_ns, (HEAD, FAN), (0.0, 0.0, 0.0), enu.FAN_TO_HEAD)
        return self._new("tf2_msgs/msg/TFMessage", [head, fan])

    def _beams(self, ping: Ping) -> list[Any]:
        if (ping.bearing_rad, ping.elevation_rad) != self._fan:
            self._fan = ping.bearing_rad, ping.elevation_rad
            elevation = ping.elevation_rad or [0.0] * len(ping.bearing_rad)
            beams = zip(ping.bearing_rad, elevation, strict=False)
            self._directions = [self._vector(enu.fan(bearing, up)) for bearing, up in beams]
        return self._directions

    def _diagnostic(self, stamp_ns: int, name: str, level: int, said: str, values: dict[str, int]) -> Any:
        """Return a DiagnosticArray, of no earlier time than the last: what processes say comes in another order."""
        self.diagnosed_ns = max(self.diagnosed_ns, stamp_ns)
        pairs = [self._new("diagnostic_msgs/msg/KeyValue", key, str(value)) for key, value in values.items()]
        status = self._new("diagnostic_msgs/msg/DiagnosticStatus", level, name, said, "", pairs)
        return self._new("diagnostic_msgs/msg/DiagnosticArray", self._header(self.diagnosed_ns, ""), [status])

    def _transform(self, stamp_ns: int, frames: tuple[str, str], place: Vector3, turn: Quaternion) -> Any:
        """`frames`: parent and child; place and turn of the child."""
        w, x, y, z = turn
        moved = self._new(
            "geometry_msgs/msg/Transform", self._vector(place), self._new("geometry_msgs/msg/Quaternion", x, y, z, w)
        )
        return self._new("geometry_msgs/msg/TransformStamped", self._header(stamp_ns, frames[0]), frames[1], moved)

    def _header(self, stamp_ns: int, frame: str) -> Any:
        return self._new("std_msgs/msg/Header", self._new("builtin_interfaces/msg/Time", *divmod(stamp_ns, NS)), frame)

    def _vector(self, v: Vector3) -> Any:
        return self._new("geometry_msgs/msg/Vector3", *v)

    def _new(self, kind: str, *values: Any) -> Any:
        return self.store.types[kind](*values)
