"""Which obstacles a veto makes ignored: never more than it names."""

import math

import msgspec
import pytest
from hypothesis import given, strategies as st

from ods.base.clock import NS
from ods.messages import Obstacle, Veto, VetoRegion, VetoRequest
from ods.tracker.settings import REST
from ods.tracker.veto.region import lies_in
from ods.tracker.veto.vetoes import AROUND_M, MOST, RefusedError, Vetoes, VetoState

SQUARE = VetoRegion(corners_ne=[(0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 0.0)])


def obstacle(
    number: int, north: float, east: float = 0.0, radius_m: float = 1.0, moving: float = 0.0, sigma_down: float = 5.0
) -> Obstacle:
    return Obstacle(
        number, "active", (north, east, 8.0), (0.0, 0.0, 0.0), radius_m, (0.3, 0.3, sigma_down), (0.1, 0.1, 0.1), 0.2,
        0, 0, 9, 1.0, moving=moving,
    )  # fmt: skip


def by_id(number: int, for_s: float = 60.0) -> VetoRequest:
    return VetoRequest(do="ignore", id=number, reason="a buoy of ours", for_s=for_s)


def in_region(region: VetoRegion, for_s: float = 60.0) -> VetoRequest:
    return VetoRequest(do="ignore", region=region, reason="the pier", for_s=for_s)


def vetoed(each: Obstacle, author: str) -> list[Veto]:
    """Return what holds once an obstacle was vetoed by its id, for a minute."""
    vetoes = Vetoes()
    vetoes.ignore(by_id(each.id), author, [each], 0)
    return vetoes.held(0, lambda t_ns: t_ns)


def ignored(vetoes: Vetoes, *present: Obstacle, at_s: float = 0.0) -> list[int]:
    return [each.id for each in vetoes.marked(list(present), round(at_s * NS)) if each.ignored_by >= 0]


def test_an_obstacle_is_ignored_until_the_veto_expires_and_others_are_not() -> None:
    vetoes = Vetoes()
    present = obstacle(7, 20.0), obstacle(8, 20.5)
    vetoes.ignore(by_id(7, for_s=60.0), "anna", present, 0)
    assert ignored(vetoes, *present, at_s=59.9) == [7]
    (held,) = vetoes.held(59 * NS, lambda t_ns: t_ns + 5)
    assert (held.author, held.reason, held.until_ns, held.until_utc_ns) == (
        "anna", "a buoy of ours", 60 * NS, 60 * NS + 5,
    )  # fmt: skip
    assert ignored(vetoes, *present, at_s=60.0) == []
    assert vetoes.ended == ["veto 0 of obstacle 7, by anna, has ended: it expired"]


@pytest.mark.parametrize(
    "later",
    [obstacle(7, 20.0 + AROUND_M + 0.1), obstacle(7, 20.0, radius_m=1.0 + AROUND_M + 0.1)],
    ids=["moved", "grown"],
)
def test_what_moves_or_grows_beyond_what_was_named_is_no_longer_ignored(later: Obstacle) -> None:
    vetoes = Vetoes()
    vetoes.ignore(by_id(7), "anna", [obstacle(7, 20.0)], 0)
    assert ignored(vetoes, obstacle(7, 20.0 + AROUND_M - 0.1)) == [7]
    assert ignored(vetoes, later) == []
    assert ignored(vetoes, obstacle(7, 20.0)) == []  # nor when it is back


def test_a_veto_that_is_renewed_by_small_steps_is_renewed_by_an_operator_each_time() -> None:
    vetoes = Vetoes()
    vetoes.ignore(by_id(7), "anna", [obstacle(7, 20.0)], 0)
    vetoes.ignore(by_id(7), "ben", [obstacle(7, 21.5)], 0)
    assert [each.author for each in vetoes.held(0, lambda t_ns: t_ns)] == ["ben"]
    assert ignored(vetoes, obstacle(7, 23.0)) == [7]


def test_a_region_names_what_rests_whole_inside() -> None:
    vetoes = Vetoes()
    vetoes.ignore(in_region(SQUARE), "anna", [], 0)
    present = (
        obstacle(1, 5.0, 5.0), obstacle(2, 9.5, 5.0), obstacle(3, 5.0, 5.0, moving=1.1 - REST), obstacle(4, 30.0, 5.0),
        obstacle(5, 5.0, 5.0, radius_m=20.0),
    )  # fmt: skip
    assert ignored(vetoes, *present) == [1]


def test_depths_are_a_matter_of_lists_that_have_them() -> None:
    shallow = msgspec.structs.replace(SQUARE, down_m=(5.0, 11.0))
    assert lies_in(obstacle(1, 5.0, 5.0, sigma_down=0.5), shallow)
    assert not lies_in(obstacle(1, 5.0, 5.0, sigma_down=5.0), shallow)  # as a sonar of one plane tells it


def test_polygons_need_not_be_convex() -> None:
    corners = [(0.0, 0.0), (0.0, 30.0), (10.0, 30.0), (10.0, 10.0), (30.0, 10.0), (30.0, 0.0)]
    angle = VetoRegion(corners_ne=corners)
    assert lies_in(obstacle(1, 25.0, 5.0), angle)
    assert lies_in(obstacle(1, 5.0, 25.0), angle)
    assert not lies_in(obstacle(1, 20.0, 20.0), angle)


def test_an_obstacle_that_ends_takes_its_veto_with_it() -> None:
    vetoes = Vetoes()
    vetoes.ignore(by_id(7), "anna", [obstacle(7, 20.0)], 0)
    ended = msgspec.structs.replace(obstacle(7, 20.0), state="terminated")
    assert ignored(vetoes, ended) == []
    assert vetoes.held(0, lambda t_ns: t_ns) == []


def test_what_is_restored_is_as_before() -> None:
    vetoes = Vetoes()
    vetoes.ignore(by_id(7), "anna", [obstacle(7, 20.0)], 0)
    vetoes.ignore(in_region(SQUARE), "anna", [], 0)
    vetoes.restore(VetoRequest(do="restore", id=7, reason="it is no buoy"))
    assert ignored(vetoes, obstacle(7, 20.0), obstacle(1, 5.0, 5.0)) == [1]
    vetoes.restore(VetoRequest(do="restore", number=1, reason="all clear"))
    assert ignored(vetoes, obstacle(1, 5.0, 5.0)) == []
    with pytest.raises(RefusedError, match="no veto of obstacle 7"):
        vetoes.restore(VetoRequest(do="restore", id=7, reason="again"))


def test_vetoes_are_bounded_and_of_obstacles_that_are_there() -> None:
    vetoes = Vetoes()
    with pytest.raises(RefusedError, match="no obstacle 9"):
        vetoes.ignore(by_id(9), "anna", [obstacle(7, 20.0)], 0)
    for _ in range(MOST):
        vetoes.ignore(in_region(SQUARE), "anna", [], 0)
    with pytest.raises(RefusedError, match="32 vetoes"):
        vetoes.ignore(in_region(SQUARE), "anna", [], 0)


def test_a_next_tracker_goes_on_with_them() -> None:
    vetoes = Vetoes()
    vetoes.ignore(by_id(7, for_s=60.0), "anna", [obstacle(7, 20.0)], 0)
    left = msgspec.msgpack.decode(msgspec.msgpack.encode(vetoes.state()), type=VetoState)
    later = Vetoes(left)
    assert ignored(later, obstacle(7, 20.0), at_s=59.0) == [7]
    assert ignored(later, obstacle(7, 20.0), at_s=61.0) == []


@pytest.mark.parametrize(
    "wrong",
    [
        {"do": "ignore", "id": 7, "reason": "no end"},
        {"do": "ignore", "id": 7, "for_s": 60.0},
        {"do": "ignore", "id": 7, "reason": "two\nlines", "for_s": 60.0},
        {"do": "ignore", "id": 7, "reason": "too long", "for_s": 1e6},
        {"do": "ignore", "id": 7, "region": {"centre_ne": [0, 0], "radius_m": 5}, "reason": "both", "for_s": 1.0},
        {"do": "ignore", "reason": "neither", "for_s": 1.0},
        {"do": "ignore", "id": 7, "reason": "no time", "for_s": math.nan},
        {"do": "ignore", "region": {"centre_ne": [0, math.nan], "radius_m": 5}, "reason": "nowhere", "for_s": 1.0},
        {"do": "ignore", "region": {"centre_ne": [0, 0], "radius_m": 1e4}, "reason": "all", "for_s": 1.0},
        {"do": "ignore", "region": {"corners_ne": [[0, 0], [1, 1]]}, "reason": "a line", "for_s": 1.0},
        {"do": "ignore", "region": {"corners_ne": [[0, 0], [500, 0], [0, 9]]}, "reason": "large", "for_s": 1.0},
        {"do": "restore", "id": 7, "number": 1, "reason": "both"},
        {"do": "forget", "number": 7, "reason": "no id"},
        {"do": "forget", "id": 7, "reason": "why", "author": "somebody else"},
        {"do": "list", "id": 7},
    ],
)  # fmt: skip
def test_requests_that_make_no_sense_are_none(wrong: dict[str, object]) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.msgpack.decode(msgspec.msgpack.encode(wrong), type=VetoRequest)


PLACES = st.floats(-30.0, 30.0)
OBSTACLES = st.lists(
    st.builds(obstacle, st.integers(1, 4), PLACES, PLACES, st.floats(0.0, 8.0), st.floats(0.0, 1.0)),
    max_size=4, unique_by=lambda each: each.id,
)  # fmt: skip
CIRCLES = st.builds(
    lambda north, east, radius_m: VetoRegion(centre_ne=(north, east), radius_m=radius_m),
    PLACES, PLACES, st.floats(0.1, 40.0),
)  # fmt: skip
POLYGONS = st.builds(
    lambda corners: VetoRegion(corners_ne=corners), st.lists(st.tuples(PLACES, PLACES), min_size=3, max_size=6)
)
TIMES = st.floats(0.1, 20.0)
REQUESTS = st.one_of(
    st.builds(by_id, st.integers(1, 4), TIMES),
    st.builds(in_region, st.one_of(CIRCLES, POLYGONS), TIMES),
    st.builds(lambda number: VetoRequest(do="restore", id=number, reason="r"), st.integers(1, 4)),
    st.builds(lambda number: VetoRequest(do="restore", number=number, reason="r"), st.integers(0, 4)),
)


@given(st.lists(st.tuples(OBSTACLES, st.lists(REQUESTS, max_size=3), st.floats(0.0, 10.0)), max_size=8))
def test_whatever_comes_what_is_ignored_was_named(steps: list[tuple[list[Obstacle], list[VetoRequest], float]]) -> None:
    """Named: by a request that was not refused and did not expire, here noted anew and judged by another way."""
    vetoes, now_ns = Vetoes(), 0
    named: list[tuple[int, VetoRequest, Obstacle | None]] = []
    for present, requests, step_s in steps:
        now_ns += round(step_s * NS)
        reported = vetoes.marked(present, now_ns)
        assert [msgspec.structs.replace(each, ignored_by=-1) for each in reported] == present  # none is missing
        for each in reported:
            assert each.ignored_by < 0 or any(_names(*item, each, now_ns) for item in named)
        for request in requests:
            try:
                if request.do == "ignore":
                    vetoes.ignore(request, "anna", reported, now_ns)
                    was = next((each for each in reported if each.id == request.id), None)
                    named.append((now_ns, request, was))
                else:
                    vetoes.restore(request)
            except RefusedError:
                continue


def _names(since_ns: int, request: VetoRequest, was: Obstacle | None, each: Obstacle, now_ns: int) -> bool:
    if request.for_s is None or now_ns >= since_ns + round(request.for_s * NS):
        return False
    if was is not None:
        apart = math.dist(was.position_ned[:2], each.position_ned[:2])
        return was.id == each.id and apart <= AROUND_M + was.radius_m and each.radius_m <= was.radius_m + AROUND_M
    return request.region is not None and 1.0 - each.moving >= REST and _rim_is_inside(each, request.region)


def _rim_is_inside(each: Obstacle, region: VetoRegion) -> bool:
    """Look at points on the rim, by winding numbers: another way than that of `lies_in`."""
    north, east, _ = each.position_ned
    angles = [2.0 * math.pi * k / 24 for k in range(24)]
    radius_m = each.radius_m * (1.0 - 1e-6) - 1e-6
    return all(_is_inside(north + radius_m * math.cos(a), east + radius_m * math.sin(a), region) for a in angles)


def _is_inside(north: float, east: float, region: VetoRegion) -> bool:
    if region.centre_ne is not None:
        return math.dist((north, east), region.centre_ne) <= region.radius_m + 1e-6
    turned = 0.0
    for first, second in zip(region.corners_ne, [*region.corners_ne[1:], region.corners_ne[0]], strict=True):
        one, other = (math.atan2(corner[1] - east, corner[0] - north) for corner in (first, second))
        turned += math.remainder(other - one, 2.0 * math.pi)
    return abs(turned) > math.pi
