"""Where the tracker takes the echoes of a moving, turning vehicle to be, against travel times solved numerically."""

import math
from collections.abc import Callable
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.messages import Pose
from ods.pose.buffer import PoseBuffer, PoseEstimate
from ods.tracker.measurement.coverage.field_of_view import coverage_of, field_of_view
from ods.tracker.measurement.model import PredictedMeasurement
from ods.tracker.measurement.pose import motion_during_reception
from ods.tracker.measurement.pose.motion_during_reception import Listening
from ods.tracker.measurement.scan import Echoes, echoes_of
from ods.tracker.named import Named
from tests.tracker.samples import SECTOR

SOUND = 1480.0
T_TX = 1.234
RANGE_MAX_M = 100.0

Motion = Callable[[float], tuple[Floats, Rotation]]


def steady(t: float) -> tuple[Floats, Rotation]:
    """Turning at 20 deg/s about an axis that leans, while speeding up and sinking."""
    place = np.array([3.0 * t + 0.3 * t**2, -1.0 * t, 4.0 + 0.5 * t])
    start = Rotation.from_euler("ZYX", [179.0, 5.0, -8.0], degrees=True)
    return place, start * Rotation.from_rotvec(math.radians(20.0) * t * np.array([0.2, 0.1, math.sqrt(0.95)]))


def swinging(t: float) -> tuple[Floats, Rotation]:
    """Yaw up to 20 deg/s, roll and pitch too."""
    yaw = math.radians(20.0) * 4.0 / math.tau * math.sin(math.tau * t / 4.0)
    roll, pitch = math.radians(3.0) * math.sin(math.tau * t / 3.0), math.radians(3.0) * math.sin(math.tau * t / 5.0)
    return np.array([2.0 * t, 0.2 * t, 4.0]), Rotation.from_euler("ZYX", [yaw, pitch, roll])


def measured(motion: Motion, place: Floats) -> tuple[float, float, float]:
    """Return range, bearing and elevation that a sonar measures of a point: travel time and arrival, by bisection."""
    sent, _ = motion(T_TX)
    out = float(np.linalg.norm(place - sent))

    def late(travel: float) -> float:
        return travel * SOUND - out - float(np.linalg.norm(place - motion(T_TX + travel)[0]))

    travel = brentq(late, 0.0, 1.0, xtol=1e-14)
    here, attitude = motion(T_TX + travel)
    x, y, z = attitude.inv().apply(place - here)
    return 0.5 * SOUND * travel, math.atan2(y, x), math.asin(-z / math.sqrt(x * x + y * y + z * z))


def poses(motion: Motion, until: float = 5.0) -> PoseBuffer:
    """Return what the INS sends at 100 Hz, exact."""
    buffer = PoseBuffer(1000, 0.3)
    for k in range(round(until * 100)):
        place, attitude = motion(0.01 * k)
        w, x, y, z = attitude.as_quat(scalar_first=True).tolist()
        velocity = attitude.inv().apply((motion(0.01 * k + 1e-4)[0] - place) / 1e-4).tolist()
        sigma = (0.1, 0.1, 0.1)
        buffer.insert(Pose(k, k * NS // 100, 0, tuple(place.tolist()), (w, x, y, z), tuple(velocity), sigma, sigma))
    return buffer


def table(rows: list[tuple[float, float, float]]) -> Echoes:
    return echoes_of(np.array([(*row, 0.5, 0.1, 0.01, 0.3) for row in rows]).reshape(-1, 7))[0]


def listening(buffer: PoseBuffer, t_s: float = T_TX) -> tuple[PoseEstimate, Listening]:
    sent = buffer.at(round(t_s * NS))
    assert sent is not None
    found = motion_during_reception.poses_of(sent, RANGE_MAX_M, SOUND, buffer.at)
    assert found is not None
    return sent, found


def placed(echoes: Echoes, sent: PoseEstimate) -> Floats:
    """Eq. 1 with the pose at transmission: (m, 3)."""
    level = echoes.rows.range_m * np.cos(echoes.rows.elevation)
    body = (
        level * np.cos(echoes.rows.bearing),
        level * np.sin(echoes.rows.bearing),
        -echoes.rows.range_m * np.sin(echoes.rows.elevation),
    )
    return Rotation.from_quat(sent.attitude, scalar_first=True).apply(np.column_stack(body)) + sent.position_ned


@pytest.mark.parametrize(("motion", "within_m"), [(steady, 1e-3), (swinging, 5e-3)])
def test_echoes_are_placed_where_the_objects_are(motion: Motion, within_m: float) -> None:
    rng = np.random.default_rng(3)
    here, attitude = motion(T_TX)
    distance, bearing, elevation = rng.uniform(2.0, 97.0, 60), rng.uniform(-0.7, 0.7, 60), rng.uniform(-0.17, 0.17, 60)
    level = distance * np.cos(elevation)
    body = np.column_stack([level * np.cos(bearing), level * np.sin(bearing), -distance * np.sin(elevation)])
    objects = attitude.apply(body) + here
    raw = table([measured(motion, place) for place in objects])
    sent, while_listening = listening(poses(motion))
    mapped, _ = motion_during_reception.at_transmission(raw, while_listening)
    errors = np.linalg.norm(placed(mapped, sent) - objects, axis=1)
    assert errors.max() < within_m
    np.testing.assert_array_equal(mapped.table[3:], raw.table[3:])  # radius and standard deviations
    without = np.linalg.norm(placed(raw, sent) - objects, axis=1)
    far = distance > 80.0
    assert without[far].mean() > (3.0 if motion is steady else 1.0)


def test_at_20_deg_a_second_and_100_m_the_fan_has_turned_by_2_7_deg() -> None:
    def turning(t: float) -> tuple[Floats, Rotation]:
        return np.zeros(3), Rotation.from_euler("ZYX", [math.radians(20.0) * t, 0.0, 0.0])

    _, found = listening(poses(turning))
    echoes, turn = motion_during_reception.at_transmission(table([(100.0, 0.3, 0.0), (50.0, -0.3, 0.0)]), found)
    whole = math.radians(20.0) * 200.0 / SOUND
    assert math.degrees(whole) == pytest.approx(2.7, abs=0.01)
    assert turn * 100.0 == pytest.approx(whole, abs=1e-5)
    np.testing.assert_allclose(echoes.rows.bearing, [0.3 + whole, -0.3 + 0.5 * whole], atol=1e-5)
    np.testing.assert_allclose(echoes.rows.range_m, [100.0, 50.0], atol=1e-9)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_an_object_at_the_edge_is_expected_when_the_fan_at_reception_covers_it(sign: float) -> None:
    """1 deg inside at 100 m and turning away, it is not; 1 deg outside and turning towards it, it is; near, neither."""
    edge, degree, turn = SECTOR.bearing_max_rad, math.radians(1.0), sign * math.radians(2.7) / 100.0
    bearing = np.array([edge - degree, edge + degree] * 2)
    n, thin = np.ones(4), np.full(4, 1e-6)
    distance = np.array([99.0, 99.0, 10.0, 10.0])
    rows = PredictedMeasurement(distance, bearing, 0.0 * n, 99.0 * n, thin, thin, 0.0 * n, n)
    predicted = Named(PredictedMeasurement, np.stack(rows))
    away = [False, False, True, False]
    toward = [True, True, True, False]
    seen = field_of_view(predicted, 0.0 * n, coverage_of(SECTOR, turn), (), 2.0)
    assert seen.inside.tolist() == (toward if sign > 0.0 else away)
    assert (seen.watched > 0.0).tolist() == seen.inside.tolist()


def test_a_quaternion_may_change_its_sign_on_the_way() -> None:
    sent, found = listening(poses(steady))
    raw = table([(90.0, 0.4, 0.0), (30.0, -0.4, 0.1), (60.0, 0.0, 0.0)])
    expected, turn = motion_during_reception.at_transmission(raw, found)
    for signs in ((1, -1, 1), (-1, 1, 1), (1, 1, -1)):
        a, b, c = (
            replace(pose, attitude=s * pose.attitude)
            for pose, s in zip((sent, found.halfway, found.end), signs, strict=True)
        )
        again, turn_again = motion_during_reception.at_transmission(raw, Listening(a, b, c, RANGE_MAX_M))
        np.testing.assert_allclose(again.table, expected.table, atol=1e-12)
        assert turn_again == pytest.approx(turn)


def test_without_a_pose_or_a_sound_speed_there_is_no_reception() -> None:
    buffer = poses(steady, until=T_TX)
    sent = buffer.at(round((T_TX + 0.25) * NS))
    assert sent is not None
    assert motion_during_reception.poses_of(sent, RANGE_MAX_M, SOUND, buffer.at) is None
    assert motion_during_reception.poses_of(sent, 10.0, SOUND, buffer.at) is not None
    for range_m, speed in ((100.0, 0.0), (100.0, math.nan), (100.0, -1500.0), (math.nan, 1500.0), (math.inf, 1500.0),
                           (1e9, 1500.0), (0.0, 1500.0), (100.0, 1e-300)):  # fmt: skip
        assert motion_during_reception.poses_of(sent, range_m, speed, buffer.at) is None


def test_what_no_vehicle_does_moves_no_echo() -> None:
    """The position jumps by a kilometre while the ping is under way; and echoes from farther than the sonar hears."""
    place, _ = steady(0.0)
    buffer = PoseBuffer(10, 0.3)
    first = Pose(0, 0, 0, tuple(place.tolist()), (1.0, 0.0, 0.0, 0.0), (0.0,) * 3, (0.1,) * 3, (0.1,) * 3)
    buffer.insert(first)
    buffer.insert(msgspec.structs.replace(first, t_ns=NS // 20, position_ned=(1e3, 0.0, 0.0)))
    buffer.insert(msgspec.structs.replace(first, t_ns=NS // 5, position_ned=(1e3, 0.0, 0.0)))
    _, found = listening(buffer, 0.0)
    raw = table([(90.0, 0.4, 0.0), (1e-6, 0.0, 0.0)])
    np.testing.assert_array_equal(motion_during_reception.at_transmission(raw, found)[0].table, raw.table)
    _, found = listening(poses(swinging))
    far, _ = motion_during_reception.at_transmission(table([(100.0, 0.4, 0.0), (9e4, 0.4, 0.0)]), found)
    assert np.isfinite(far.table).all()
    assert far.rows.bearing[1] == pytest.approx(far.rows.bearing[0], abs=1e-2)
    none, _ = motion_during_reception.at_transmission(table([]), found)
    assert len(none) == 0
