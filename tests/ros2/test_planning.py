"""Obstacles, clear water and images in ROS's frames, against numbers computed by hand, read back from their CDR."""

import math
from typing import Any

import numpy as np
import pytest

from ods.base.clock import NS
from ods.messages import Clearance, Ping
from ods.ros2 import clearance, definitions, markers, tracks
from ods.ros2.messages import Frames, Messages
from ods.ros2.pictures import within
from tests.bridge.samples import POSE, ROCK, SWIMMER, T_NS, UTC_NS, obstacle, obstacle_list
from tests.range_images import ping_of

MAKE = Messages(Frames(map="world"))


def read(message: Any, kind: str) -> Any:
    return MAKE.store.deserialize_cdr(MAKE.cdr(message, kind), kind)


def xyz(v: Any) -> tuple[float, float, float]:
    return v.x, v.y, v.z


def test_a_marker_is_a_cylinder_where_the_obstacle_is() -> None:
    # the rock: 100 m north, 50 m east, 5 m down, radius 2 m; the swimmer goes to the west at 2 m/s
    reported = read(markers.markers(MAKE, UTC_NS, obstacle_list(ROCK, SWIMMER)), markers.MARKERS)
    first, rock, swimmer, line = reported.markers
    assert (first.action, rock.action) == (markers.DELETE_ALL, markers.ADD)
    assert (rock.header.frame_id, rock.header.stamp.sec, rock.header.stamp.nanosec) == ("world", *divmod(UTC_NS, NS))
    assert (rock.type, rock.ns, rock.id, rock.lifetime.sec) == (markers.CYLINDER, "obstacles", 7, 1)
    assert xyz(rock.pose.position) == (50.0, 100.0, -5.0)
    assert xyz(rock.scale) == (4.0, 4.0, 4.0)
    assert rock.pose.orientation.w == 1.0
    assert xyz(swimmer.pose.position) == (90.0, 110.0, -5.0)
    assert (line.type, line.ns, line.scale.x) == (markers.LINE_LIST, "velocities", 0.2)
    assert [xyz(point) for point in line.points] == [(90.0, 110.0, -5.0), (80.0, 110.0, -5.0)]  # in 5 s


def test_an_id_beyond_31_bits_is_still_a_marker() -> None:
    reported = read(markers.markers(MAKE, 0, obstacle_list(obstacle(2**40 + 9, 1.0, 1.0))), markers.MARKERS)
    assert reported.markers[1].id == 9


def test_a_track() -> None:
    odd = obstacle(
        7, 100.0, 50.0, velocity_ned=(1.0, 2.0, 0.5), sigma_position=(0.5, 0.25, 3.0), covariance_ne=0.0625,
        sigma_velocity=(0.5, 1.0, 2.0), sigma_radius=0.25,
    )  # fmt: skip
    reported = read(tracks.tracks(MAKE, UTC_NS, obstacle_list(odd)), definitions.RADAR_TRACKS)
    (track,) = reported.tracks
    assert reported.header.frame_id == "world"
    assert bytes(track.uuid.uuid) == bytes(15) + b"\x07"
    assert xyz(track.position) == (50.0, 100.0, -5.0)
    assert xyz(track.velocity) == (2.0, 1.0, -0.5)
    assert xyz(track.size) == (4.0, 4.0, 4.0)
    # xx is east's, yy north's
    assert track.position_covariance.tolist() == [0.0625, 0.0625, 0.0, 0.25, 0.0, 9.0]
    assert track.velocity_covariance.tolist() == [1.0, 0.0, 0.0, 0.25, 0.0, 4.0]
    assert track.size_covariance.tolist() == [0.25, 0.0, 0.0, 0.25, 0.0, 0.25]
    assert track.classification == tracks.NO_CLASSIFICATION


def test_clear_water_by_sectors() -> None:
    # four sectors, with their middles to the north-east, south-east, south-west, north-west of (19 east, 100 north)
    water = Clearance(
        seq=3, ping_number=5, t_ns=T_NS, utc_ns=UTC_NS, valid=True, clear_from_m=[1.0, 2.0, 0.0, 0.0],
        clear_to_m=[9.0, 30.0, 0.0, 0.0], nearest_m=[10.0 * math.sqrt(2.0), None, None, math.sqrt(2.0)], pose=POSE,
        half_height_m=2.5,
    )  # fmt: skip
    reported = read(clearance.cloud(MAKE, UTC_NS, water, POSE), clearance.POINT_CLOUD)
    assert [field.name for field in reported.fields] == list(clearance.FIELDS)
    assert [(field.offset, field.datatype) for field in reported.fields][:3] == [(0, 7), (4, 7), (8, 7)]
    assert (reported.height, reported.width, reported.point_step, reported.row_step) == (1, 4, 32, 128)
    assert (reported.is_dense, reported.is_bigendian) == (False, False)
    points = np.frombuffer(reported.data.tobytes(), "<f4").reshape(4, 8)
    assert points[0] == pytest.approx([29.0, 110.0, -5.0, math.pi / 4.0, 1.0, 9.0, 10.0 * math.sqrt(2.0), 2.5])
    assert points[3] == pytest.approx([18.0, 101.0, -5.0, 3.0 * math.pi / 4.0, 0.0, 0.0, math.sqrt(2.0), 2.5])
    assert np.isnan(points[1, [0, 1, 2, 6]]).all()
    assert points[1, 3:6] == pytest.approx([-math.pi / 4.0, 2.0, 30.0])
    assert points[2, 3:6] == pytest.approx([-3.0 * math.pi / 4.0, 0.0, 0.0])


def ping(samples: "np.ndarray[Any, Any]", dtype: Any) -> Ping:
    beams, count = samples.shape
    return Ping(
        seq=0, ping_number=1, t_ns=0, t_rx_ns=0, utc_ns=UTC_NS, beams=beams, samples=count, dtype=dtype,
        data=samples.tobytes(), bearing_rad=[0.01 * beam for beam in range(beams)], range0_m=1.0, dr_m=0.1,
        sound_speed=1500.0,
    )  # fmt: skip


def test_an_image_becomes_small_and_keeps_its_echoes() -> None:
    samples = np.arange(2 * 11, dtype=np.uint16).reshape(2, 11)
    made = within(ping(samples, "u2"), 2 * 2 * 4)  # four samples a beam have room: three neighbours become one
    assert (made.beams, made.samples, made.dtype) == (2, 3, "u2")
    assert np.frombuffer(made.data, "<u2").tolist() == [2, 5, 8, 13, 16, 19]
    assert [made.range0_m, made.dr_m] == pytest.approx([1.1, 0.3])


def test_a_small_image_stays_as_it_is() -> None:
    reported = ping(np.zeros((2, 3), np.uint8), "u1")
    assert within(reported, 6) is reported
    assert within(reported, 1).samples == 1


def test_a_range_image_is_sent_from_above_whatever_room_there_is() -> None:
    ranges = np.zeros((64, 256), np.float32)
    ranges[20:30, 100] = 6.0
    seen = ping_of(ranges)
    for made in (within(seen, 10**9), within(seen, 256 * 64)):
        image = MAKE.image(0, made)
        levels = np.asarray(image.image.data).reshape(made.samples, 256)
        (at,), beams = np.nonzero(levels.any(axis=1))[0], np.nonzero(levels.any(axis=0))[0]
        assert image.ranges[at] == pytest.approx(6.0, abs=made.dr_m)
        assert (beams.tolist(), levels.max()) == ([100], 10)
