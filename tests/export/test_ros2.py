"""The bag as rosbags' own reader gives it back, against vectors computed by hand (mission.py says where things are)."""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from ods.export.ros2 import TOPICS, Ros2Bag
from ods.export.sink import UnfitMessageError
from ods.ros2.messages import UNKNOWN
from tests.export import mission
from tests.export.mission import UTC_NS, A


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    folder = tmp_path_factory.mktemp("bag") / "mission"
    sink = Ros2Bag(folder, mission.MOUNTED)
    for message in mission.ALL:
        sink.take(UTC_NS, message)
    sink.close()
    found: dict[str, list[Any]] = {}
    with AnyReader([folder]) as reader:  # no types given: they are those in the bag
        assert {c.topic: c.msgtype for c in reader.connections} == TOPICS
        for connection, stamp_ns, data in reader.messages():
            assert stamp_ns == UTC_NS
            found.setdefault(connection.topic, []).append(reader.deserialize(data, connection.msgtype))
    return found


def xyz(v: Any) -> tuple[float, float, float]:
    return v.x, v.y, v.z


def xyzw(q: Any) -> tuple[float, float, float, float]:
    return q.x, q.y, q.z, q.w


def same_turn(q: Any, by_hand: tuple[float, float, float, float]) -> bool:
    """A turn and its negative are the same."""
    return bool(abs(np.dot(xyzw(q), by_hand)) == pytest.approx(1.0, abs=1e-12))


def test_an_obstacle(bag: dict[str, list[Any]]) -> None:
    (array,) = bag["/obstacles"]
    (rock,) = array.obstacles
    assert (array.header.frame_id, array.header.stamp.sec, array.header.stamp.nanosec) == (
        "map", 1_700_000_005, 250_000_000,
    )  # fmt: skip
    assert xyz(rock.position) == (60.0, 110.0, -12.0)
    assert xyz(rock.velocity) == (0.2, 0.1, -0.3)
    assert xyz(rock.size) == (3.0, 3.0, 3.0)
    assert (bytes(rock.uuid.uuid), rock.score) == (bytes(15) + b"\x07", 0.5)
    assert rock.position_covariance == pytest.approx([0.16, 0.01, 0, 0.01, 0.04, 0, 0, 0, 9.0])
    assert rock.velocity_covariance == pytest.approx([4e-4, 0, 0, 0, 1e-4, 0, 0, 0, 9e-4])


def test_the_vehicle(bag: dict[str, list[Any]]) -> None:
    (odometry,) = bag["/odometry"]
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("map", "base_link")
    assert xyz(odometry.pose.pose.position) == (20.0, 100.0, -10.0)
    assert same_turn(odometry.pose.pose.orientation, (0.0, 0.0, 0.0, 1.0))  # heading east is along x
    assert xyz(odometry.twist.twist.linear) == (1.5, -0.2, 0.1)
    assert np.diag(odometry.pose.covariance.reshape(6, 6)) == pytest.approx([4.0, 1.0, 9.0, 0.01, 0.04, 0.09])
    assert odometry.twist.covariance.reshape(6, 6).tolist() == np.diag([UNKNOWN] * 6).tolist()  # 0 would be exact
    (moved,) = bag["/tf"][0].transforms
    assert (moved.header.frame_id, moved.child_frame_id) == ("map", "base_link")
    assert xyz(moved.transform.translation) == (20.0, 100.0, -10.0)


def test_the_sonar_looks_down_and_its_fan_says_so(bag: dict[str, list[Any]]) -> None:
    head, fan = bag["/tf_static"][0].transforms
    assert (head.header.frame_id, head.child_frame_id) == ("base_link", "sonar")
    assert (fan.header.frame_id, fan.child_frame_id) == ("sonar", "sonar_fan")
    assert xyz(head.transform.translation) == (2.0, -0.5, -1.0)
    assert same_turn(head.transform.rotation, (0.0, A, 0.0, A))  # about port by 90 deg: ahead goes down
    assert same_turn(fan.transform.rotation, (A, 0.0, A, 0.0))  # half a turn about the axis between up and ahead
    (image,) = bag["/sonar_image"]
    assert image.header.frame_id == "sonar_fan"
    assert xyz(image.beam_directions[0]) == pytest.approx((0.0, -0.5, 0.8660254), abs=1e-7)
    assert xyz(image.beam_directions[1]) == pytest.approx((0.0, 0.5, 0.8660254), abs=1e-7)


def test_the_image(bag: dict[str, list[Any]]) -> None:
    (image,) = bag["/sonar_image"]
    assert image.ranges.tolist() == [0.0, 0.5, 1.0]
    assert (image.image.dtype, image.image.beam_count, image.image.is_bigendian) == (2, 2, False)
    counts = image.image.data.view("<u2")
    assert counts.tolist() == [1, 4, 2, 5, 3, 262]  # beam by beam at each range
    assert (image.ping_info.frequency, image.ping_info.sound_speed) == (450e3, 1490.0)
    assert image.ping_info.rx_beamwidths == pytest.approx([0.02, 0.02])


def test_what_has_no_field_is_a_diagnostic(bag: dict[str, list[Any]]) -> None:
    statuses = [message.status[0] for message in bag["/diagnostics"]]
    assert [(s.level, s.name, s.message) for s in statuses] == [
        (1, "ods: sonar", "no data, for 3 s"),
        (2, "ods: obstacles", "no pose; sonar: silent"),
    ]
    assert [(pair.key, pair.value) for pair in statuses[0].values] == [("bad_record", "2")]


def test_a_ping_that_does_not_fit_its_shape_is_left_out(tmp_path: Path) -> None:
    sink = Ros2Bag(tmp_path / "bag", mission.MOUNTED)
    with pytest.raises(UnfitMessageError, match="do not fit"):
        sink.take(UTC_NS, msgspec.structs.replace(mission.PING, data=b"1"))
    sink.take(UTC_NS, mission.PING)
    sink.close()


def test_what_processes_say_is_in_order_of_time(tmp_path: Path) -> None:
    """A list holds for the time when it was made, not for that of its ping, and no word is earlier than the last."""
    made = msgspec.structs.replace(mission.LIST, made_ns=mission.LIST.t_ns + 160_000_000)
    sink = Ros2Bag(tmp_path / "bag", mission.MOUNTED)
    for message, late_ns in ((mission.HEALTH, 100_000_000), (made, 0), (mission.HEALTH, 150_000_000)):
        sink.take(UTC_NS + late_ns, message)
    sink.close()
    with AnyReader([tmp_path / "bag"]) as reader:
        said: list[tuple[int, Any]] = [
            (stamp_ns, reader.deserialize(data, connection.msgtype))
            for connection, stamp_ns, data in reader.messages()
            if connection.topic == "/diagnostics"
        ]
    assert [stamp_ns - UTC_NS for stamp_ns, _ in said] == [100_000_000, 160_000_000, 160_000_000]
    stamps = [(stamp_ns, array.header.stamp) for stamp_ns, array in said]
    assert all(stamp.sec * 10**9 + stamp.nanosec == stamp_ns for stamp_ns, stamp in stamps)
