"""MAVLink: sectors and points computed by hand, read by pymavlink; what is not known is never free."""

import math
import random
from typing import Any

import msgspec
import pytest

from ods.base.frames.quaternion import from_euler
from ods.bridge.encoder import Encoded
from ods.bridge.extrapolated_list import ExtrapolatedList
from ods.bridge.settings import MavlinkSettings
from ods.messages import Clearance, Obstacle
from tests.bridge.samples import ENDED, ROCK, clearance, moment, obstacle

dialect = pytest.importorskip("pymavlink.dialects.v20.ardupilotmega")
mavlink = pytest.importorskip("ods.bridge.mavlink")

NORTH, EAST, SOUTH, WEST = 0, 18, 36, 54
"""The sectors of 72 that begin there."""
FREE = 3001
"""max_distance + 1."""


def settings(**more: Any) -> MavlinkSettings:
    return MavlinkSettings(to="udp://127.0.0.1:14551", **more)


def reported(encoded: Encoded) -> list[Any]:
    """Return the messages as who is not ODS reads them."""
    peer = dialect.MAVLink(None)
    messages = [message for data in encoded.datagrams for message in peer.parse_buffer(data)]
    assert all(data[0] == 0xFD for data in encoded.datagrams)  # version 2
    assert [(each.get_srcSystem(), each.get_srcComponent()) for each in messages] == [(1, 196)] * len(messages)
    return messages


def encoded(at: ExtrapolatedList, known: Clearance, **more: Any) -> Encoded:
    encoder = mavlink.MavlinkEncoder(settings(**more))
    encoder.take(known)
    sent: Encoded = encoder.encode(at)
    return sent


def by_hand() -> Clearance:
    """Return what is known at t_ns; the list is sent a second later, and the vehicle goes 2 m/s to the east."""
    clear_from, clear_to, nearest = [0.0] * 72, [100.0] * 72, [None] * 72
    near: list[float | None] = [*nearest]
    near[EAST], clear_to[EAST] = 20.0, 18.0  # a rock at the bow: 20 - 2 m, and two standard deviations before it
    clear_from[NORTH], clear_to[NORTH] = 2.0, 12.0  # to port
    clear_from[SOUTH] = 5.0  # to starboard: unknown next to the vehicle
    clear_to[WEST] = 0.0  # astern nothing is known
    near[WEST + 9] = 5.0  # on the port quarter: an echo, known water before it
    clear_to[WEST + 9] = 4.5
    return clearance(moment().obstacle_list, clear_from_m=clear_from, clear_to_m=clear_to, nearest_m=near)


def test_sectors_are_clockwise_from_the_bow_in_centimetres_of_the_instant_of_sending() -> None:
    (message,) = reported(encoded(moment(ROCK), by_hand()))
    assert message.get_type() == "OBSTACLE_DISTANCE"
    assert (message.increment, message.increment_f, message.angle_offset) == (5, 5.0, 0.0)
    assert (message.min_distance, message.max_distance, message.frame) == (10, 3000, dialect.MAV_FRAME_BODY_FRD)
    assert message.time_usec == moment().now_ns // 1000
    wanted = [FREE] * 72
    wanted[0] = wanted[1] = 1600  # 18 - 2 m: both touch the sector from 90 to 95 deg
    wanted[18] = wanted[19] = 100  # starboard: nothing is known to be empty
    wanted[36] = wanted[37] = 100
    wanted[45] = wanted[46] = 250  # 4.5 - 2 m
    wanted[54] = wanted[55] = 1000  # port: 12 - 2 m
    assert list(message.distances) == wanted


def test_unknown_water_is_unknown_only_where_that_is_wanted() -> None:
    (message,) = reported(encoded(moment(), by_hand(), unknown="unknown"))
    distances = message.distances
    assert (distances[0], distances[18], distances[36], distances[54]) == (1600, 65535, 65535, 65535)
    assert distances[27] == FREE


def test_what_may_have_come_in_since_is_counted() -> None:
    known = msgspec.structs.replace(by_hand(), fastest_m_s=1.5)
    (message,) = reported(encoded(moment(), known))
    assert message.distances[0] == 1450
    assert message.distances[45] == 100


@pytest.mark.parametrize("sectors", [8, 71, 72, 90, 360])
def test_nothing_is_sent_as_free_that_is_not_known_to_be(sectors: int) -> None:
    dice = random.Random(sectors)
    for _ in range(50):
        to_m = [dice.choice([0.0, dice.uniform(0.0, 60.0)]) for _ in range(sectors)]
        near = [dice.choice([None, dice.uniform(0.0, 60.0)]) for _ in range(sectors)]
        yaw = dice.uniform(-math.pi, math.pi)
        at = moment()
        pose = msgspec.structs.replace(at.pose, attitude=from_euler(0.0, 0.0, yaw), velocity_ned=(0.0, 0.0, 0.0))
        at = ExtrapolatedList(at.obstacle_list, pose, at.obstacle_list.t_ns)
        known = clearance(at.obstacle_list, clear_from_m=[0.0] * sectors, clear_to_m=to_m, nearest_m=near, pose=pose)
        (message,) = reported(encoded(at, known))
        for step in range(3600):
            bearing = math.radians(step / 10.0 + 0.05)
            there = int(((bearing + yaw) % (2.0 * math.pi)) / (2.0 * math.pi) * sectors)
            distance_m = message.distances[round(math.degrees(bearing) / 5.0) % 72] / 100.0
            assert distance_m <= max(to_m[there], 1.0) or (distance_m > 30.0 and to_m[there] > 30.0)
            body = near[there]
            assert body is None or distance_m <= max(body, 0.1) or (distance_m > 30.0 and body > 30.0)


def points(*obstacles: Obstacle, **more: Any) -> tuple[list[Any], Encoded]:
    at = moment(*obstacles)
    sent = encoded(at, clearance(at.obstacle_list), form="3d", **more)
    return reported(sent), sent


def test_points_are_forward_starboard_down() -> None:
    shallow = obstacle(70_000, 110.0, 21.0, position_ned=(110.0, 21.0, 15.0))
    far = obstacle(9, 100.0, 90.0)
    messages, sent = points(ROCK, ENDED, shallow, far)
    assert [each.get_type() for each in messages] == ["OBSTACLE_DISTANCE_3D"] * 2
    port, ahead = messages
    # the bow is to the east: 50 - 21 m, less the radius of 2 m and twice hypot(0.3, 0.4) m
    assert (ahead.x, ahead.y, ahead.z) == pytest.approx((26.0, 0.0, 0.0), abs=1e-5)
    # 10 m to the north, which is to port; 10 m deeper, less twice 3 m
    assert (port.x, port.y, port.z) == pytest.approx((0.0, -7.0, 4.0), abs=1e-5)
    assert (ahead.obstacle_id, port.obstacle_id) == (7, 70_000 & 0x7FFF)
    assert ahead.time_boot_ms == port.time_boot_ms == moment().now_ns // 1_000_000
    assert (ahead.frame, ahead.min_distance, ahead.max_distance) == (12, pytest.approx(0.1), 30.0)
    assert sent.left_out == 1


def test_points_are_in_the_frame_of_a_vehicle_that_pitches() -> None:
    at = moment(ROCK)
    pose = msgspec.structs.replace(at.pose, attitude=from_euler(0.0, math.radians(30.0), math.radians(90.0)))
    at = ExtrapolatedList(at.obstacle_list, pose, at.now_ns)
    (ahead,) = reported(encoded(at, clearance(at.obstacle_list), form="3d"))
    # the bow points up: what is level lies under its axis
    assert (ahead.x, ahead.y, ahead.z) == pytest.approx((26.0 * math.sqrt(0.75), 0.0, 13.0), abs=1e-4)


def test_points_stand_for_what_is_not_known_to_be_empty() -> None:
    messages = reported(encoded(moment(), by_hand(), form="3d"))
    places = {(round(each.x, 2), round(each.y, 2), round(each.z, 2)) for each in messages}
    assert len(messages) == 10
    assert len(encoded(moment(), clearance(moment().obstacle_list, clear_to_m=[0.0] * 72), form="3d").datagrams) == 3
    assert {(16.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -10.0, 0.0)} <= {
        (x + 0.0, y + 0.0, z + 0.0) for x, y, z in places
    }
    assert all(each.obstacle_id == 65535 for each in messages)


def test_a_vehicle_inside_an_obstacle_is_reported_so() -> None:
    (inside,), _ = points(obstacle(5, 100.0, 21.0))
    assert math.hypot(inside.x, inside.y, inside.z) == pytest.approx(0.101, abs=1e-3)
    assert math.hypot(inside.x, inside.y, inside.z) >= inside.min_distance


def test_messages_are_numbered() -> None:
    encoder = mavlink.MavlinkEncoder(settings())
    encoder.take(by_hand())
    sent = [encoder.encode(moment()).datagrams[0] for _ in range(300)]
    assert [data[4] for data in sent] == [number % 256 for number in range(300)]
