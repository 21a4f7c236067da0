"""Pose fields to poses: every way to tell a pose, against scipy's rotations and the ellipsoid's own equations."""

import itertools
import math
from collections import Counter
from collections.abc import Iterable

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.pose_fields import (
    ATTITUDE_SIGMAS,
    ATTITUDES,
    PLACE_SIGMAS,
    PLACES,
    UNITS,
    VELOCITIES,
    PoseMaker,
)
from ods.nav_bridge.settings import LimitSettings, SigmaSettings
from tests.nav_bridge.made_up_clock import utc_ahead

LATITUDE, LONGITUDE = 57.048, 9.9187
FRAME = LocalFrame(LATITUDE, LONGITUDE)
SIGMAS = SigmaSettings(position_m=0.7, attitude_rad=0.01)
TURN = Rotation.from_euler("ZYX", [2.9, -0.2, 0.1])
NED = TURN.apply([1.5, -0.1, 0.2])
PLACE = (1234.5, -678.9, 20.0)
GEODETIC = (57.05908512010964, 10.03881099803017 - 10.05 + LONGITUDE, -19.844527606852353)
"""PROJ 9.5.1, +proj=cart +step +proj=topocentric, inverse, of PLACE seen from 57.048, 10.05, turned about the axis."""
VALUES: dict[str, float] = {
    "roll": 0.1, "pitch": -0.2, "yaw": 2.9, "u": 1.5, "v": -0.1, "w": 0.2,
    **dict(zip(PLACES[0], PLACE, strict=True)),
    **dict(zip(PLACES[1], GEODETIC, strict=True)),
    **dict(zip(ATTITUDES[1], TURN.as_quat(scalar_first=True).tolist(), strict=True)),
    **dict(zip(VELOCITIES[1], NED.tolist(), strict=True)),
    "sigma_north": 0.3, "sigma_east": 0.4, "sigma_down": 0.5, "sigma_horizontal": 0.6,
    "sigma_roll": 0.01, "sigma_pitch": 0.02, "sigma_yaw": 0.03, "sigma_tilt": 0.04,
    "over_bottom": 20.0, "sigma_over_bottom": 0.08,
}  # fmt: skip
"""One vehicle, reported in every way."""
SPREADS = {
    PLACE_SIGMAS[0]: (0.3, 0.4, 0.5), PLACE_SIGMAS[1]: (0.6, 0.6, 0.5),
    ATTITUDE_SIGMAS[0]: (0.01, 0.02, 0.03), ATTITUDE_SIGMAS[1]: (0.04, 0.04, 0.03),
}  # fmt: skip


class Bench:
    """A maker of the named fields, and its counters."""

    def __init__(self, fields: Iterable[str], limits: LimitSettings | None = None) -> None:
        self.counters: Counter[str] = Counter()
        self.fields = list(fields)
        self.maker = PoseMaker(self.fields, FRAME, limits or LimitSettings(), SIGMAS, utc_ahead(7), self.counters)

    def make(self, **changes: float) -> Pose | None:
        """Make a pose of VALUES and changes."""
        return self.make_at(NS, **changes)

    def make_at(self, t_ns: int, **changes: float) -> Pose | None:
        """Make a pose of the instant `t_ns` that arrives at 1 s."""
        return self.maker.make({name: VALUES[name] for name in self.fields} | changes, t_ns, NS)


def axes_at(latitude_deg: float, longitude_deg: float) -> NDArray[np.float64]:
    """Return north, east and down at a place as columns: from the earth's axes, turned twice."""
    turns = Rotation.from_euler("ZY", [longitude_deg, -90.0 - latitude_deg], degrees=True)
    return np.asarray(turns.as_matrix(), np.float64)


def test_every_field_has_values_here() -> None:
    assert set(VALUES) == set(UNITS)


@pytest.mark.parametrize(
    "groups",
    list(itertools.product(PLACES, ATTITUDES, VELOCITIES, (*PLACE_SIGMAS, ()), (*ATTITUDE_SIGMAS, ()))),
    ids=lambda groups: "+".join(names[0] if names else "none" for names in groups),
)
def test_every_way_to_tell_it_gives_the_same_pose(groups: tuple[tuple[str, ...], ...]) -> None:
    bench = Bench([name for names in groups for name in names])
    pose = bench.make()
    assert pose is not None
    np.testing.assert_allclose(pose.position_ned, PLACE, atol=1e-6)
    np.testing.assert_allclose(pose.velocity_body, (1.5, -0.1, 0.2), atol=1e-12)
    there = Rotation.from_matrix(axes_at(LATITUDE, 0.0).T @ axes_at(GEODETIC[0], GEODETIC[1] - LONGITUDE)) * TURN
    assert abs(float(np.dot(pose.attitude, there.as_quat(scalar_first=True)))) == pytest.approx(1.0, abs=1e-14)
    assert pose.sigma_position_ned == SPREADS.get(groups[3], (0.7, 0.7, 0.7))
    assert pose.sigma_attitude == SPREADS.get(groups[4], (0.01, 0.01, 0.01))
    assert (pose.seq, pose.t_ns, pose.utc_ns) == (0, NS, NS + 7)
    assert not bench.counters


@pytest.mark.parametrize("place", PLACES, ids=["metres", "degrees"])
@pytest.mark.parametrize("velocity", VELOCITIES, ids=["body", "global"])
@pytest.mark.parametrize(("east_m", "turn_deg"), [(0.0, 0.0), (10_000.0, -0.138), (-50_000.0, 0.69)])
def test_a_vehicle_far_east_that_heads_north_moves_as_its_pose_says(
    place: tuple[str, ...], velocity: tuple[str, ...], east_m: float, turn_deg: float
) -> None:
    """Along its meridian at 2 m/s; the poses' places against their attitude and velocity."""
    bench = Bench((*place, *ATTITUDES[0], *velocity))
    latitude, longitude, altitude = (float(reported) for reported in FRAME.geodetic([0.0, east_m, 10.0]))
    degrees_a_metre = 180.0 / math.pi / (6_380_490.0 + altitude)  # by the meridian's radius of curvature there
    poses = []
    for seconds in (0.0, 1.0):
        reported = latitude + 2.0 * seconds * degrees_a_metre
        changes = dict(zip(PLACES[0], FRAME.ned(reported, longitude, altitude).tolist(), strict=True))
        changes |= dict(zip(PLACES[1], (reported, longitude, altitude), strict=True)) | {"roll": 0.0, "pitch": 0.0}
        changes |= {"yaw": 0.0, "u": 2.0, "v": 0.0, "w": 0.0}
        changes |= {"velocity_north": 2.0, "velocity_east": 0.0, "velocity_down": 0.0}
        pose = bench.make(**{name: changes[name] for name in bench.fields})
        assert pose is not None
        poses.append(pose)
    turn = Rotation.from_quat(poses[0].attitude, scalar_first=True)
    moved = np.subtract(poses[1].position_ned, poses[0].position_ned)
    np.testing.assert_allclose(turn.apply(poses[0].velocity_body), moved, atol=2e-5)
    assert turn.as_euler("ZYX", degrees=True)[0] == pytest.approx(turn_deg, abs=0.01)


def east_of_meridian(latitude_deg: float, longitude_deg: float, height_m: float) -> tuple[float, float, float]:
    """Return N, E, D by the ellipsoid's equations, turned by hand: rotate the earth, then tilt."""
    a, f = 6378137.0, 1.0 / 298.257223563
    e2 = 2.0 * f - f * f

    def meridian(latitude_deg: float, height_m: float) -> tuple[float, float]:
        sine, cosine = math.sin(math.radians(latitude_deg)), math.cos(math.radians(latitude_deg))
        n = a / math.sqrt(1.0 - e2 * sine * sine)
        return (n + height_m) * cosine, (n * (1.0 - e2) + height_m) * sine

    radius, z = meridian(latitude_deg, height_m)
    turned = math.radians(longitude_deg - LONGITUDE)
    outward, east = radius * math.cos(turned), radius * math.sin(turned)
    outward_0, z_0 = meridian(LATITUDE, 0.0)
    tilt = math.radians(LATITUDE)
    outward, z = outward - outward_0, z - z_0
    return (
        z * math.cos(tilt) - outward * math.sin(tilt),
        east,
        -(outward * math.cos(tilt) + z * math.sin(tilt)),
    )


@given(st.floats(56.3, 57.8), st.floats(8.6, 11.2), st.floats(-3000.0, 50.0))
def test_places_by_the_equations_of_the_ellipsoid(latitude: float, longitude: float, altitude: float) -> None:
    bench = Bench([*PLACES[1], *ATTITUDES[0], *VELOCITIES[0]])
    pose = bench.make(latitude=latitude, longitude=longitude, altitude=altitude)
    assert pose is not None
    np.testing.assert_allclose(pose.position_ned, east_of_meridian(latitude, longitude, altitude), atol=1e-7)


@given(st.floats(-math.pi, math.pi), st.floats(-math.pi / 2, math.pi / 2), st.floats(-math.pi, 2.0 * math.pi))
def test_any_attitude_as_angles_or_quaternion_turns_the_velocity_as_scipy_does(
    roll: float, pitch: float, yaw: float
) -> None:
    turn = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    w, x, y, z = turn.as_quat(scalar_first=True).tolist()
    expected = turn.inv().apply([VALUES[name] for name in VELOCITIES[1]])
    by_angles = Bench([*PLACES[0], *ATTITUDES[0], *VELOCITIES[1]]).make(roll=roll, pitch=pitch, yaw=yaw)
    by_quaternion = Bench([*PLACES[0], *ATTITUDES[1], *VELOCITIES[1]]).make(qw=w, qx=x, qy=y, qz=z)
    for pose in (by_angles, by_quaternion):
        assert pose is not None
        np.testing.assert_allclose(pose.velocity_body, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("fields", "wrong", "said"),
    [
        (
            PLACES[0],
            {"north": -250_000.0},
            "north is 250000.0 m from the site's origin, nav.limits.horizontal_m is 100000",
        ),
        (PLACES[0], {"down": -150.0}, "height is 150.0 m from the site's origin, nav.limits.height_m is 100"),
        (PLACES[1], {"latitude": 570.0}, "latitude 570, longitude 9.9"),
        (PLACES[0], {"roll": 12.0}, "roll 12, pitch -0.2, yaw 2.9 is not an attitude: angles must be in rad"),
        (PLACES[0], {"v": 50.0}, "the speed along a body axis is 50.0 m/s, nav.limits.speed is 30"),
        (PLACES[0], {"u": math.nan}, "u is nan"),
    ],
)
def test_what_is_dropped_is_said_with_its_value_until_a_pose_is_good(
    fields: tuple[str, ...], wrong: dict[str, float], said: str
) -> None:
    bench = Bench((*fields, *ATTITUDES[0], *VELOCITIES[0]))
    assert bench.make(**wrong) is None
    assert bench.maker.disbelief.startswith(f"poses are dropped: {said}")
    assert bench.make() is not None
    assert not bench.maker.disbelief


ALL_GLOBAL = (*PLACES[1], *ATTITUDES[1], *VELOCITIES[1], *PLACE_SIGMAS[0], *ATTITUDE_SIGMAS[0])
ALL_LOCAL = (*PLACES[0], *ATTITUDES[0], *VELOCITIES[0], *PLACE_SIGMAS[1], *ATTITUDE_SIGMAS[1])


@pytest.mark.parametrize("fields", [ALL_GLOBAL, ALL_LOCAL])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e308, -1e308])
def test_no_field_lets_through_what_is_no_number(fields: tuple[str, ...], bad: float) -> None:
    bench = Bench(fields)
    assert all(bench.make(**{name: bad}) is None for name in fields)
    assert bench.counters == {"epoch_absurd": len(fields)}


@given(st.sampled_from([ALL_GLOBAL, ALL_LOCAL]), st.data())
def test_whatever_is_reported_a_pose_is_finite_and_within_the_limits(
    fields: tuple[str, ...], data: st.DataObject
) -> None:
    bench = Bench(fields)
    values = {name: data.draw(st.floats() | st.just(VALUES[name])) for name in fields}
    pose = bench.make(**values)
    assert (pose is None) == bool(bench.counters)
    if pose is not None:
        north, east, down = pose.position_ned
        assert max(abs(north), abs(east)) <= 1e5
        assert -100.0 <= down <= 12_000.0
        assert max(map(abs, pose.velocity_body)) <= 30.0
        assert math.hypot(*pose.attitude) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("changes", "good"),
    [
        ({"north": 999.0, "east": -999.0}, True),
        ({"north": 1001.0}, False),
        ({"east": -1001.0}, False),
        ({"down": -9.0}, True),
        ({"down": -11.0}, False),
        ({"down": 501.0}, False),
        ({"u": 4.9}, True),
        ({"w": -5.1}, False),
        ({"roll": math.pi + 5e-4}, True),
        ({"roll": math.pi + 5e-3}, False),
        ({"pitch": math.pi / 2 + 5e-4}, True),
        ({"pitch": -math.pi / 2 - 5e-3}, False),
        ({"yaw": 2 * math.pi}, True),
        ({"yaw": -6.3}, False),
        ({"sigma_tilt": 0.0}, True),
        ({"sigma_yaw": -1e-6}, False),
        ({"sigma_horizontal": -1e-6}, False),
        ({"sigma_yaw": 999.0}, True),
        ({"sigma_tilt": 1001.0}, False),
        ({"sigma_horizontal": 4294967.295}, True),  # 32 bits of mm: "unknown"
        ({"sigma_down": 1.1e7}, False),
    ],
)
def test_limits(changes: dict[str, float], good: bool) -> None:
    limits = LimitSettings(horizontal_m=1000.0, height_m=10.0, depth_m=500.0, speed=5.0)
    pose = Bench(ALL_LOCAL, limits).make(**({"north": 0.0, "east": 0.0} | changes))
    assert (pose is not None) == good
    if pose is not None:
        assert msgspec.msgpack.decode(msgspec.msgpack.encode(pose), type=Pose) == pose  # readers take it, too


@pytest.mark.parametrize(
    ("changes", "good"),
    [
        ({"latitude": 90.1}, False),
        ({"longitude": 360.1}, False),
        ({"longitude": LONGITUDE + 360.0 - 360.0}, True),
        ({"longitude": LONGITUDE - 360.0}, True),
        ({"latitude": 0.0}, False),
        ({"qw": 0.0, "qx": 0.0, "qy": 0.0, "qz": 0.0}, False),
        ({"qw": 1.019, "qx": 0.0, "qy": 0.0, "qz": 0.0}, True),
        ({"qw": 1.021, "qx": 0.0, "qy": 0.0, "qz": 0.0}, False),
        ({"qw": 0.5, "qx": 0.0, "qy": 0.0, "qz": 0.0}, False),
    ],
)
def test_places_and_quaternions_that_are_none(changes: dict[str, float], good: bool) -> None:
    pose = Bench(ALL_GLOBAL).make(**changes)
    assert (pose is not None) == good
    if pose is not None:
        assert math.hypot(*pose.attitude) == pytest.approx(1.0)


def test_a_deviation_that_no_pose_can_carry_is_said() -> None:
    bench = Bench(ALL_LOCAL)
    assert bench.make(sigma_yaw=1e8) is None
    assert bench.maker.disbelief == "poses are dropped: sigma_yaw is 1e+08 rad, more than 1000"


def test_poses_are_numbered_and_old_ones_dropped() -> None:
    bench = Bench(ALL_LOCAL, LimitSettings(age_s=0.5))
    found = [bench.make_at(t_ns) for t_ns in (NS, NS // 2, NS // 2 - 1, NS)]
    assert [pose.seq for pose in found if pose is not None] == [0, 1, 2]
    assert bench.counters == {"epoch_late": 1}


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({*ALL_LOCAL} - {"down"}, "a pose needs north, east, down or latitude, longitude, altitude"),
        ({*ALL_LOCAL} - {"u"}, "a pose needs u, v, w or velocity_north"),
        ({*ALL_GLOBAL} - {"qz"}, "a pose needs roll, pitch, yaw or qw"),
        ({*ALL_LOCAL} | {"latitude"}, "latitude: not used beside north"),
        ({*ALL_LOCAL} - {"sigma_down"}, "sigma_horizontal: needs sigma_down beside it"),
        (
            {*ALL_LOCAL} - {"sigma_horizontal"},
            "sigma_down: needs sigma_north, sigma_east or sigma_horizontal beside it",
        ),
    ],
)
def test_fields_that_make_no_pose_are_one_line(fields: set[str], said: str) -> None:
    with pytest.raises(OdsError) as error:
        Bench(fields)
    assert said in str(error.value)
    assert "\n" not in str(error.value)
