"""The table of topics: names, types, and how reliably each is sent."""

from typing import Literal, NamedTuple

from ods.bridge.settings import Ros2Settings, Ros2Topic
from ods.ros2 import definitions as texts
from ods.ros2.clearance import POINT_CLOUD
from ods.ros2.markers import MARKERS

Quality = Literal["list", "stream", "image"]
"""list: reliable, kept for who comes later, for `LIFESPAN_S` only; stream: reliable; image: best effort."""
LIFESPAN_S = 1
"""Who comes later gets no list that is older: silence must mean that there is none."""


class TopicRow(NamedTuple):
    """One row."""

    key: Ros2Topic
    """In `bridge.ros2.send`."""
    name: str
    """Beginning with "/": it has no namespace in front."""
    kind: str
    quality: Quality


TOPICS = (
    TopicRow("obstacles", "obstacles", texts.OBSTACLE_ARRAY, "list"),
    TopicRow("markers", "markers", MARKERS, "list"),
    TopicRow("tracks", "tracks", texts.RADAR_TRACKS, "list"),
    TopicRow("clearance", "clearance", POINT_CLOUD, "list"),
    TopicRow("odometry", "odometry", "nav_msgs/msg/Odometry", "list"),
    TopicRow("diagnostics", "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", "stream"),
    TopicRow("tf", "/tf", "tf2_msgs/msg/TFMessage", "stream"),
    TopicRow("image", "sonar_image", texts.PROJECTED_SONAR_IMAGE, "image"),
)


def wanted(settings: Ros2Settings) -> list[TopicRow]:
    """Return the rows of what is to be sent, with their whole names."""
    rows = [row for row in TOPICS if row.key in settings.send]
    return [row if row.name[0] == "/" else row._replace(name=f"{settings.namespace}/{row.name}") for row in rows]
