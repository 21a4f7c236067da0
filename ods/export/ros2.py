"""A ROS 2 bag (rosbag2 folder, MCAP, CDR), written without ROS by the library rosbags.

Frames (REP 103, REP 105): `map`, ENU with its origin at the site; `base_link`, the vehicle, FLU; `sonar`, its head,
FLU; `sonar_fan`, the axes of marine_acoustic_msgs.
"""

from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from ods.base.frames.mounting import Mounting
from ods.export.sink import UnfitMessageError
from ods.messages import Health, ObstacleList, Ping, Pose
from ods.ros2 import definitions as texts, enu
from ods.ros2.messages import ERROR, OK, WARN, Messages

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


class Ros2Bag:
    """Writes a bag into a new folder."""

    def __init__(self, folder: Path, mounting: Mounting) -> None:
        """Raises OSError."""
        self.losses: Counter[str] = Counter()
        self._messages, self._mounting = BagMessages(), mounting
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
        """Write a converted message. Raises OSError, UnfitMessageError."""
        found = self._messages.of(stamp_ns, message)
        if not self._begun:
            self._begun = True
            found.insert(0, ("/tf_static", self._messages.mounting(stamp_ns, self._mounting)))
        for topic, content in found:
            data = self._messages.store.serialize_cdr(content, TOPICS[topic])
            at_ns = self._messages.diagnosed_ns if topic == "/diagnostics" else stamp_ns
            self._writer.write(self._connections[topic], at_ns, data)

    def close(self) -> None:
        """Raises OSError."""
        self._writer.close()


class BagMessages(Messages):
    """What a bag has of each message."""

    def __init__(self) -> None:
        super().__init__()
        self.diagnosed_ns = 0
        """Of the newest DiagnosticArray: of several processes, in the order in which they were received."""

    def of(self, stamp_ns: int, message: msgspec.Struct) -> list[tuple[str, Any]]:
        """Return topics and messages. Raises UnfitMessageError."""
        if isinstance(message, Ping):
            return [("/sonar_image", self._image(stamp_ns, message))]
        if isinstance(message, Pose):
            place, turn = enu.enu(message.position_ned), enu.attitude(message.attitude)
            vehicle = self.transform(stamp_ns, (self.frames.map, self.frames.vehicle), place, turn)
            return [
                ("/odometry", self.odometry(stamp_ns, message)),
                ("/tf", self.new("tf2_msgs/msg/TFMessage", [vehicle])),
            ]
        if isinstance(message, ObstacleList):
            return [
                ("/obstacles", self.obstacles(stamp_ns, message)),
                ("/diagnostics", self.verdict(stamp_ns, message)),
            ]
        if isinstance(message, Health):
            return [("/diagnostics", self.health(stamp_ns, message))]
        return []

    def _image(self, stamp_ns: int, ping: Ping) -> Any:
        try:
            return self.image(stamp_ns, ping)
        except ValueError as error:
            raise UnfitMessageError("pings whose samples do not fit their shape") from error

    def verdict(self, stamp_ns: int, obstacle_list: ObstacleList) -> Any:
        """Return whether the list is to be relied on: ObstacleArray has no field for that."""
        stamp_ns += (
            obstacle_list.made_ns - obstacle_list.t_ns if obstacle_list.made_ns else 0
        )  # the instant for which it holds
        said = "; ".join(obstacle_list.reasons) or ("valid" if obstacle_list.valid else "not valid")
        values = {
            "seq": obstacle_list.seq,
            "ping_number": obstacle_list.ping_number,
            "left_out": obstacle_list.left_out,
        }
        return self._diagnosed(stamp_ns, "ods: obstacles", OK if obstacle_list.valid else ERROR, said, values)

    def health(self, stamp_ns: int, health: Health) -> Any:
        """Return a process's state, with its counters."""
        said = "; ".join(health.problems) or ("all is well" if health.ready else "starting")
        level = WARN if health.problems or not health.ready else OK
        return self._diagnosed(stamp_ns, f"ods: {health.process}", level, said, health.counters)

    def _diagnosed(self, stamp_ns: int, name: str, level: int, said: str, values: dict[str, int]) -> Any:
        """Return a DiagnosticArray, of no earlier time than the last: what processes say comes in another order."""
        self.diagnosed_ns = max(self.diagnosed_ns, stamp_ns)
        return self.diagnostic(self.diagnosed_ns, name, level, said, values)
