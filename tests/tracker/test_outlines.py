"""Outlines and near edges: strips made up by hand, seen from a head under way."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.base.clock import NS
from ods.messages import Detection, Obstacle
from ods.pose.buffer import PoseEstimate
from ods.tracker.outline.outlines import EDGE_KEPT_S, Outlines
from ods.tracker.outline.owners import GATE, GATE_M, Extents, owners_of
from ods.tracker.outline.seen import GlobalEchoes, seen_from
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import MARGIN_SIGMAS

PERIOD_NS = NS // 5
EAST = math.pi / 2.0


def head_at(t_ns: int, yaw_rad: float = 0.0, speed: float = 1.0) -> PoseEstimate:
    """A head that is at the origin at 0 s and goes north."""
    attitude = np.array([math.cos(yaw_rad / 2.0), 0.0, 0.0, math.sin(yaw_rad / 2.0)])
    place = np.array([speed * t_ns / NS, 0.0, 10.0])
    return PoseEstimate(t_ns, place, attitude, np.array([speed, 0.0, 0.0]), np.zeros(3), np.zeros(3), 0.0)


def echo(
    head: PoseEstimate, north: float, east: float, azimuth: float = 0.0, length: float = 0.5, near: float | None = None
) -> Detection:
    """A strip at a place, `azimuth` its direction, as the head (level, yaw 0) receives it."""
    bearing = math.atan2(east - head.position_ned[1], north - head.position_ned[0])
    distance = math.hypot(north - head.position_ned[0], east - head.position_ned[1])
    return Detection(
        distance, bearing, length, 5.0, 3.0, 14.0, 40, 1.0, 0.1, 0.1, 0.005, 0.2,
        near_m=distance - 0.5 if near is None else near, sigma_near_m=0.1,
        half_length_m=length, half_width_m=0.2, axis_rad=azimuth - bearing,
    )  # fmt: skip


def snapshot(*objects: tuple[int, float, float, float], velocity: tuple[float, float] = (0.0, 0.0)) -> Snapshot:
    """Objects: id, north, east, radius."""
    id_, north, east, radius = (np.array(column) for column in zip(*objects, strict=True))
    n, zero = len(id_), np.zeros(len(id_))
    whole = np.zeros(n, np.int64)
    moves = np.array([[velocity[0]], [velocity[1]], [0.0]]) + np.zeros((3, n))
    sigma = np.full((3, n), 0.1)
    return Snapshot(
        id_, whole + 1, np.stack([north, east, zero + 10.0]), moves, radius, sigma, zero, sigma,
        zero + 0.2, zero + 1.0, zero + 1.0, whole, whole, whole, zero, zero,
    )  # fmt: skip


def listed(outlines: Outlines, t_ns: int, *objects: tuple[int, float, float, float]) -> list[Obstacle]:
    plain = [
        Obstacle(i, "active", (n, e, 10.0), (0.0,) * 3, r, (0.1,) * 3, (0.1,) * 3, 0.2, 0, 0, 9, 1.0)
        for i, n, e, r in objects
    ]  # fmt: skip
    return outlines.outlined(plain, t_ns)


Thing = tuple[int, float, float, float]
"""Id, north, east, radius."""
EchoesAt = Callable[[PoseEstimate], list[Detection]]


def looks(outlines: Outlines, echoes_at: EchoesAt, *objects: Thing, count: int = 10) -> int:
    """Take images in; return the time of the last one."""
    for k in range(count):
        head = head_at(k * PERIOD_NS)
        outlines.look(snapshot(*objects), seen_from(head, echoes_at(head), 0.0, 0.0), head, 0)
    return (count - 1) * PERIOD_NS


def test_a_wall_received_in_two_parts_is_one_strip() -> None:
    wall, outlines = (7, 50.0, 5.0, 10.0), Outlines()
    azimuth = math.radians(60.0)
    step = np.array([math.cos(azimuth), math.sin(azimuth)])

    def parts(head: PoseEstimate) -> list[Detection]:
        places = [np.array([50.0, 5.0]) + s * step for s in (-5.0, 5.0)]
        return [echo(head, float(n), float(e), azimuth, length=5.0, near=44.0) for n, e in places]

    (seen,) = listed(outlines, looks(outlines, parts, wall), wall)
    assert seen.outline is not None
    assert seen.outline.half_length_m == pytest.approx(10.0, rel=0.01)
    assert seen.outline.half_width_m == pytest.approx(0.2, rel=0.05)
    assert seen.outline.azimuth_rad == pytest.approx(azimuth, abs=0.01)
    assert seen.outline.middle_ne == pytest.approx((50.0, 5.0), abs=0.05)
    assert seen.elongated > 0.99


def test_the_circle_of_a_wall_seen_aslant_covers_it() -> None:
    wall, rock, outlines = (7, 50.0, 5.0, 6.0), (8, 30.0, -10.0, 0.5), Outlines()
    looks(outlines, lambda head: [echo(head, 50.0, 5.0, 0.8, length=8.0), echo(head, 30.0, -10.0)], wall, rock)
    assert outlines.covering(snapshot(wall, rock)).radius == pytest.approx([8.0, 0.5], abs=0.1)


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
def test_extents_turn_with_the_head_and_with_the_fan(yaw: float) -> None:
    ahead = Detection(
        20.0, 0.3, 1.0, 5.0, 3.0, 14.0, 40, 1.0, 0.1, 0.1, 0.005, 0.2,
        near_m=19.0, sigma_near_m=0.1, half_length_m=3.0, half_width_m=1.0, axis_rad=0.5,
    )  # fmt: skip
    seen = seen_from(head_at(0, yaw, speed=0.0), [ahead], fan_turn=0.01, sound_speed=1500.0)
    bearing = yaw + 0.3 + 20.0 * 0.01
    axis = bearing + 0.5
    turn = np.array([[math.cos(axis), -math.sin(axis)], [math.sin(axis), math.cos(axis)]])
    assert seen.extent[0] == pytest.approx(turn @ np.diag([3.0, 1.0 / 3.0]) @ turn.T)
    assert seen.place[0] == pytest.approx([20.0 * math.cos(bearing), 20.0 * math.sin(bearing)])


def test_an_echo_comes_back_to_a_head_that_has_gone_on() -> None:
    """Ahead at 30 m from where the ping was sent, received at 2 m/s: 2 * 30 m / 1500 m/s later, 0.04 m nearer."""
    head = head_at(0, speed=2.0)
    seen = seen_from(head, [echo(head, 30.0 - 0.04, 0.0, near=28.0)], 0.0, 1500.0)
    assert seen.place[0] == pytest.approx([30.0, 0.0], abs=1e-3)
    assert seen.near[0] == pytest.approx(28.04, abs=1e-3)


def test_the_near_edge_follows_the_head_and_is_forgotten_when_unseen() -> None:
    rock, outlines = (3, 40.0, 0.0, 0.5), Outlines()
    newest = looks(outlines, lambda head: [echo(head, 40.0, 0.0)], rock, count=30)
    (seen,) = listed(outlines, newest, rock)
    assert seen.near_m == pytest.approx(39.5 - newest / NS, abs=0.01)
    assert seen.sigma_near_m is not None
    assert 0.03 < seen.sigma_near_m < 0.1
    assert seen.outline is None
    assert seen.elongated < 1e-3
    (later,) = listed(outlines, newest + NS // 10, rock)  # of no image: nobody knows how the head has moved since
    assert (later.near_m, later.sigma_near_m) == (None, None)
    head = head_at(newest + round((EDGE_KEPT_S + 0.1) * NS))
    outlines.look(snapshot(rock), seen_from(head, [], 0.0, 0.0), head, 0)
    (gone,) = listed(outlines, head.t_ns, rock)
    assert (gone.near_m, gone.sigma_near_m) == (None, None)


def test_an_object_that_was_not_seen_takes_no_echo() -> None:
    rock, outlines, head = (3, 40.0, 0.0, 0.5), Outlines(), head_at(0)
    outlines.look(snapshot(rock), seen_from(head, [echo(head, 40.2, 0.0)], 0.0, 0.0), head, utc_ns=1)
    (seen,) = listed(outlines, 0, rock)
    assert seen.near_m is None


def test_nobody_takes_the_echo_of_another() -> None:
    """A body before a long wall, each seen in other images only."""
    body, wall, outlines = (1, 40.0, 0.0, 0.5), (2, 45.0, 0.0, 15.0), Outlines()

    def by_turns(head: PoseEstimate) -> list[Detection]:
        of_wall = echo(head, 45.0, 0.0, azimuth=EAST, length=15.0, near=45.0 - head.position_ned[0])
        return [echo(head, 40.0, 0.0)] if head.t_ns // PERIOD_NS % 2 else [of_wall]

    newest = looks(outlines, by_turns, body, wall)
    near = {each.id: each.near_m for each in listed(outlines, newest, body, wall)}
    assert near == {1: pytest.approx(39.5 - newest / NS, abs=0.05), 2: pytest.approx(45.0 - newest / NS, abs=0.05)}


def test_a_strip_that_was_wrong_is_learned_anew() -> None:
    """What looked long at first, as two bodies were one echo, is a body of its own later."""
    body, outlines = (4, 30.0, 0.0, 3.0), Outlines()
    looks(outlines, lambda head: [echo(head, 30.0, 0.0, azimuth=EAST, length=3.0)], body)
    newest = looks(outlines, lambda head: [echo(head, 30.0, 0.0, length=0.5)], body, count=60)
    (seen,) = listed(outlines, newest, body)
    assert seen.outline is None
    assert seen.elongated < 0.1


def test_echoes_of_older_recordings_and_empty_lists_say_nothing() -> None:
    rock, outlines, head = (3, 40.0, 0.0, 0.5), Outlines(), head_at(0)
    old = Detection(40.0, 0.0, 0.5, 5.0, 3.0, 14.0, 40, 1.0, 0.1, 0.1, 0.005, 0.2)
    outlines.look(snapshot(rock), seen_from(head, [old], 0.0, 1500.0), head, 0)
    (seen,) = listed(outlines, 0, rock)
    assert (seen.near_m, seen.outline) == (None, None)
    assert listed(outlines, 0) == []


@pytest.mark.parametrize("cut", [False, True])
def test_half_of_what_echoes_claim_no_number_of_them_takes_away(cut: bool) -> None:
    """Due east of the head: along the line of sight and of the radius; of what the fan cuts off the tracker knows."""
    outlines, thing = Outlines(), (7, 1.8, 50.0, 2.0)
    claims = {"sigma_range_m": 2.0, "sigma_radius_m": 1.0, "cut": cut}
    looks(outlines, lambda head: [msgspec.structs.replace(echo(head, *thing[1:3]), **claims)], thing)
    reported = outlines.covering(snapshot(thing))
    along, radius = (0.1, 0.2) if cut else (math.hypot(0.1, 1.0), math.hypot(0.2, 0.5))
    np.testing.assert_allclose(reported.sigma_position[:, 0], (0.1, along, 0.1), atol=1e-3)
    assert reported.sigma_radius[0] == pytest.approx(radius)
    assert reported.covariance_ne[0] == pytest.approx(0.0, abs=1e-3)


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=50)
def test_an_echo_is_of_the_object_whose_ellipse_it_fits_best(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m = 6, 12
    head = head_at(0)
    objects = snapshot(*((k, *rng.uniform(20.0, 35.0, 2).tolist(), float(rng.uniform(0.5, 6.0))) for k in range(n)))
    objects.last_seen_utc_ns[:] = rng.random(n) < 0.3
    spots = rng.uniform((15.0, 15.0, 0.2), (40.0, 40.0, 9.0), (m, 3)).tolist()
    seen = seen_from(head, [echo(head, north, east, 0.0, length) for north, east, length in spots], 0.0, 0.0)
    nn, ee = rng.uniform(0.5, 9.0, (2, n))
    north, east = rng.uniform(-1.0, 1.0, (2, n))
    extents = Extents(rng.random(n) < 0.5, north, east, nn, 0.4 * np.sqrt(nn * ee), ee)
    owner = owners_of(objects, seen, extents, 0)
    for k in range(m):
        fits = [_fit_of(objects, extents, i, seen, k) for i in range(n)]
        best = int(np.argmin([score for score, _ in fits]))
        assert owner[k] == (best if fits[best][1] <= GATE**2 else -1)


def _fit_of(objects: Snapshot, extents: Extents, i: int, seen: GlobalEchoes, k: int) -> tuple[float, float]:
    """Return the misfit and the squared distance in axes of echo `k` to object `i`, infinite where it is not of it."""
    off, radius = seen.place[k] - objects.position[:2, i], objects.radius[i]
    sigma = math.hypot(objects.sigma_position[:2, i].max(), seen.sigma[k])
    blur = math.hypot(MARGIN_SIGMAS * sigma, GATE_M)
    largest = 2.0 * (radius + MARGIN_SIGMAS * objects.sigma_radius[i]) + GATE_M
    if objects.last_seen_utc_ns[i] != 0 or np.hypot(*off) > radius + GATE * blur or seen.radius[k] > largest:
        return math.inf, math.inf
    shape = radius**2 * np.eye(2)
    if extents.extended[i]:
        middle = np.array([extents.north[i], extents.east[i]])
        nn, ne, ee = extents.north_north[i], extents.north_east[i], extents.east_east[i]
        about = np.array([[nn, ne], [ne, ee]])
        shape = 3.0 * (about + np.outer(middle, middle))
    shape = shape + blur**2 * np.eye(2)
    away = float(off @ np.linalg.solve(shape, off))
    return away + math.log(np.linalg.det(shape)), away


def test_the_echoes_of_an_image_are_weighted_by_their_lengths() -> None:
    """Two parts of a wall: middle and second moments of the mixture, by numpy's weighted covariance of drawn points."""
    wall, head, outlines = (7, 50.0, 5.0, 10.0), head_at(0), Outlines()
    parts = [echo(head, 50.0, 1.0, 0.4, length=2.0), echo(head, 52.0, 8.0, 1.1, length=6.0)]
    seen = seen_from(head, parts, 0.0, 0.0)
    outlines.look(snapshot(wall), seen, head, 0)
    known = outlines._known
    weight = seen.length / seen.length.sum()
    middle = weight @ seen.place
    apart = seen.place - middle
    moments = np.einsum("k,kij->ij", weight, seen.extent + apart[:, :, None] * apart[:, None, :])
    assert (known.north[0], known.east[0]) == pytest.approx(middle - (50.0, 5.0))
    assert (known.north_north[0], known.north_east[0], known.east_east[0]) == pytest.approx(moments.ravel()[[0, 1, 3]])
    assert known.length[0] == pytest.approx(math.sqrt(3.0 * np.linalg.eigvalsh(moments)[1]))
    assert known.near[0] == pytest.approx(seen.near.min())
