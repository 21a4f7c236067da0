"""Types as DDS gets them: names, hashes, CDR, against others' own."""

import pytest

pytest.importorskip("cyclonedds", reason="pip install 'ods[ros2]'")

from cyclonedds.idl import IdlStruct

from ods.bridge.ros2.dds_types import DdsTypes, type_hash
from ods.bridge.ros2.topics import TOPICS
from ods.ros2 import definitions
from ods.ros2.messages import Messages
from tests.bridge import ros2_listener
from tests.bridge.samples import ROCK, SWIMMER, UTC_NS, obstacle_list

MAKE = Messages()


def test_hashes_are_those_of_ros() -> None:
    # as `ros2 topic info --verbose` prints it
    assert type_hash(MAKE.store, "std_msgs/msg/String") == (
        "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    )


def test_each_topic_has_a_type() -> None:
    types = DdsTypes(MAKE.store)
    for row in TOPICS:
        package, _, name = row.kind.split("/")
        kind = types.of(row.kind)
        assert issubclass(kind, IdlStruct)
        assert kind.__idl__.idl_transformed_typename == f"{package}::msg::dds_::{name}_"


def test_types_and_bytes_are_those_of_a_type_written_by_hand() -> None:
    made, by_hand = DdsTypes(MAKE.store).of(definitions.OBSTACLE_ARRAY), ros2_listener.ObstacleArray
    assert made.__idl__.get_type_id() == by_hand.__idl__.get_type_id()
    cdr = MAKE.cdr(MAKE.obstacles(UTC_NS, obstacle_list(ROCK, SWIMMER)), definitions.OBSTACLE_ARRAY)
    assert made(cdr).serialize() == cdr
    read = by_hand.deserialize(cdr)
    assert [each.position.x for each in read.obstacles] == [50.0, 90.0]
    assert read.serialize() == cdr
