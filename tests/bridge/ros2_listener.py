"""A node of another make: a process that prints what cyclonedds, by types written by hand, receives of the bridge.

`python -m tests.bridge.ros2_listener DOMAIN`: a JSON object a line, as it comes; types are not ODS's.
"""

import json
import sys
import time
from dataclasses import dataclass

from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int32, sequence, uint8, uint32
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

CONFIG = """<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>99</MaxAutoParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>"""


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Point(IdlStruct, typename="geometry_msgs.msg.dds_.Point_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs.msg.dds_.Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Uuid(IdlStruct, typename="unique_identifier_msgs.msg.dds_.UUID_"):
    uuid: array[uint8, 16]


@dataclass
class Obstacle(IdlStruct, typename="nav2_dynamic_msgs.msg.dds_.Obstacle_"):
    uuid: Uuid
    score: float32
    position: Point
    velocity: Vector3
    size: Vector3
    position_covariance: array[float64, 9]
    velocity_covariance: array[float64, 9]


@dataclass
class ObstacleArray(IdlStruct, typename="nav2_dynamic_msgs.msg.dds_.ObstacleArray_"):
    header: Header
    obstacles: sequence[Obstacle]


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs.msg.dds_.KeyValue_"):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs.msg.dds_.DiagnosticStatus_"):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs.msg.dds_.DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs.msg.dds_.Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Transform(IdlStruct, typename="geometry_msgs.msg.dds_.Transform_"):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename="geometry_msgs.msg.dds_.TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TfMessage(IdlStruct, typename="tf2_msgs.msg.dds_.TFMessage_"):
    transforms: sequence[TransformStamped]


@dataclass
class PingInfo(IdlStruct, typename="marine_acoustic_msgs.msg.dds_.PingInfo_"):
    frequency: float32
    sound_speed: float32
    tx_beamwidths: sequence[float32]
    rx_beamwidths: sequence[float32]


@dataclass
class SonarImageData(IdlStruct, typename="marine_acoustic_msgs.msg.dds_.SonarImageData_"):
    is_bigendian: bool
    dtype: uint32
    beam_count: uint32
    data: sequence[uint8]


@dataclass
class SonarImage(IdlStruct, typename="marine_acoustic_msgs.msg.dds_.ProjectedSonarImage_"):
    header: Header
    ping_info: PingInfo
    beam_directions: sequence[Vector3]
    ranges: sequence[float32]
    image: SonarImageData


def main(domain: int) -> None:
    """Print what comes until the input is closed."""
    keep = [Domain(domain, CONFIG), DomainParticipant(domain)]
    participant = keep[1]
    reliable = Policy.Reliability.Reliable(duration(milliseconds=100))
    late = Qos(reliable, Policy.Durability.TransientLocal, Policy.History.KeepLast(50))
    loose = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(50))
    readers = [
        DataReader(participant, Topic(participant, name, kind), qos=qos)
        for name, kind, qos in (
            ("rt/ods/obstacles", ObstacleArray, late), ("rt/diagnostics", DiagnosticArray, Qos(reliable)),
            ("rt/tf", TfMessage, Qos(reliable)), ("rt/ods/sonar_image", SonarImage, loose),
        )
    ]  # fmt: skip
    print(json.dumps({"ready": True}), flush=True)
    while True:
        for reader in readers:
            for sample in reader.take(50):
                print(json.dumps(reported(sample)), flush=True)
        time.sleep(0.005)


def reported(sample: object) -> dict[str, object]:
    """Return what a test wants to know of a message."""
    if isinstance(sample, ObstacleArray):
        stamp_ns = sample.header.stamp.sec * 1_000_000_000 + sample.header.stamp.nanosec
        obstacles = [
            {"id": o.uuid.uuid[15] + 256 * o.uuid.uuid[14], "enu": [o.position.x, o.position.y, o.position.z]}
            for o in sample.obstacles
        ]
        return {"topic": "obstacles", "frame": sample.header.frame_id, "stamp_ns": stamp_ns, "obstacles": obstacles}
    if isinstance(sample, DiagnosticArray):
        (status,) = sample.status
        values = {pair.key: pair.value for pair in status.values}
        return {"topic": "diagnostics", "level": status.level, "message": status.message, "values": values}
    if isinstance(sample, TfMessage):
        return {"topic": "tf", "frames": [[t.header.frame_id, t.child_frame_id] for t in sample.transforms]}
    assert isinstance(sample, SonarImage)
    return {
        "topic": "image", "frame": sample.header.frame_id, "beams": sample.image.beam_count,
        "ranges": len(sample.ranges), "bytes": len(sample.image.data), "dtype": sample.image.dtype,
    }  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]))
