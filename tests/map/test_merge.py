"""Two missions' maps as one: duplicates recognised, knowledge fused, ids kept and never used twice."""

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.base.geodesy import LocalFrame
from ods.map.merge import Spread, merge, moved
from ods.tracker.map.map_object import MapObject

NO_SPREAD = Spread(0.0, 0.0)
SPREAD = Spread(0.5, 0.2)


def rock(object_id: int, north: float, east: float, sigma: float = 0.2, **changes: object) -> MapObject:
    made = MapObject(object_id, (north, east, 20.0), (sigma, sigma, 3.0), 1.5, 0.1, 0.9, 10, object_id, 200, 300)
    return msgspec.structs.replace(made, **changes)


def later(objects: list[MapObject]) -> list[MapObject]:
    """Return the same places as another mission would have them: first seen at other instants."""
    return [msgspec.structs.replace(o, first_seen_utc_ns=o.first_seen_utc_ns + 10_000) for o in objects]


def test_one_object_seen_twice_is_fused_by_information() -> None:
    """Closed forms: inverse-variance weighting by axis; existence of either; counts added; the first id."""
    a = rock(4, 10.0, 0.0, sigma=0.2, times_seen=10, last_seen_utc_ns=500)
    b = rock(9, 10.5, 0.0, sigma=0.4, times_seen=7, radius=1.6, sigma_radius=0.2, existence=0.8)
    result = merge([a], [b], first_free_id=50, spread=NO_SPREAD)
    (one,) = result.objects
    assert (one.id, one.times_seen, one.first_seen_utc_ns, one.last_seen_utc_ns) == (4, 17, 4, 500)
    assert one.position == pytest.approx((10.1, 0.0, 20.0), abs=1e-4)  # weights 0.8 and 0.2
    assert one.sigma == pytest.approx(((1 / 0.04 + 1 / 0.16) ** -0.5,) * 2 + (3.0 / 2**0.5,), rel=1e-4)
    assert one.radius == pytest.approx(1.52, abs=1e-4)
    assert one.existence == pytest.approx(0.98)
    assert (result.pairs, result.next_id) == ([(4, 9)], 50)


def test_an_error_ellipse_weighs_by_its_axes() -> None:
    """Each map knows one diagonal well; together they know the place: against the general formula."""
    a = rock(1, 0.0, 0.0, sigma=1.0, covariance_ne=0.99)
    b = rock(2, 1.0, 0.0, sigma=1.0, covariance_ne=-0.99)
    (one,) = merge([a], [b], 3, NO_SPREAD).objects
    p_a, p_b = np.array([[1.0, 0.99], [0.99, 1.0]]), np.array([[1.0, -0.99], [-0.99, 1.0]])
    gain = p_a @ np.linalg.inv(p_a + p_b)
    np.testing.assert_allclose(one.position[:2], gain @ [1.0, 0.0], atol=1e-3)
    assert one.sigma[0] == pytest.approx(np.sqrt((p_a - gain @ p_a)[0, 0]), rel=1e-3)
    assert one.sigma[0] < 0.15


def test_radius_tells_apart_what_place_does_not() -> None:
    a, b = rock(1, 0.0, 0.0), rock(2, 0.0, 0.0, radius=3.5)
    assert merge([a], [b], 3, NO_SPREAD).pairs == []
    assert merge([a], [b], 3, Spread(0.0, 1.0)).pairs == [(1, 2)]


def test_a_map_that_is_offset_pairs_each_with_itself_not_with_its_neighbour() -> None:
    """A row of objects 1.2 m apart, the second map 0.7 m off along it: the nearest ones are the neighbours."""
    row = [rock(i, 1.2 * i, 0.0) for i in range(1, 11)]
    off = later([msgspec.structs.replace(o, id=o.id + 30, position=(o.position[0] + 0.7, 0.0, 20.0)) for o in row])
    assert merge(row, off, 100, SPREAD).pairs == [(i, i + 30) for i in range(1, 11)]


def test_an_object_carried_on_from_one_map_into_the_next_is_not_counted_twice() -> None:
    older = rock(3, 0.0, 0.0, times_seen=10, last_seen_utc_ns=100)
    newer = rock(3, 0.1, 0.0, times_seen=25, last_seen_utc_ns=900)
    for first, second in (([older], [newer]), ([newer], [older])):
        result = merge(first, second, 4, SPREAD)
        assert (result.objects, result.pairs) == ([newer], [(3, 3)])


PLACES = st.lists(st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0)), max_size=25)


@given(first=PLACES, second=PLACES)
def test_whatever_the_maps(first: list[tuple[float, float]], second: list[tuple[float, float]]) -> None:
    """No id twice, the first map's all there, none lost or made, all below `next_id`; each is in one pair at most."""
    a = [rock(i + 1, *place) for i, place in enumerate(first)]
    b = later([rock(i + 1, *place) for i, place in enumerate(second)])
    result = merge(a, b, len(a) + 5, SPREAD)
    ids = [o.id for o in result.objects]
    assert len(set(ids)) == len(ids) == len(a) + len(b) - len(result.pairs)
    assert set(ids) >= {o.id for o in a}
    assert all(i < result.next_id for i in ids)
    assert all(i >= len(a) + 5 for i in set(ids) - {o.id for o in a})
    for side in zip(*result.pairs, strict=True):
        assert len(set(side)) == len(side)
    for o in result.objects:
        assert np.isfinite([*o.position, *o.sigma]).all()
        assert abs(o.covariance_ne) <= o.sigma[0] * o.sigma[1]


def test_another_origin_is_another_frame_not_another_place() -> None:
    """There and back over 300 km; at the other origin the error ellipse has turned with the meridians."""
    here, there = LocalFrame(70.0, 10.0), LocalFrame(70.0, 18.0)
    objects = [rock(1, 120.0, -40.0, sigma=1.0, covariance_ne=0.9), rock(2, -5.0, 3.0)]
    away = moved(objects, here, there)
    np.testing.assert_allclose(
        np.array(there.geodetic([o.position for o in away])), np.array(here.geodetic([o.position for o in objects]))
    )
    assert away[0].covariance_ne < 0.9
    for o, back in zip(objects, moved(away, there, here), strict=True):
        np.testing.assert_allclose(back.position, o.position, atol=1e-7)
    assert moved(objects, here, here) is objects


def test_a_thousand_objects_of_two_missions() -> None:
    """Truth known: 1000 rocks, each seen by both with pose error 0.3 m; 99 % gate, so 99 of 100 are recognised."""
    rng = np.random.default_rng(5)
    truth = rng.uniform(-2000.0, 2000.0, (1000, 2))
    drift = np.array([0.3, -0.3])
    a = [rock(i + 1, *map(float, p + rng.normal(0, 0.2, 2))) for i, p in enumerate(truth)]
    b = later([rock(i + 1, *map(float, p + drift + rng.normal(0, 0.2, 2))) for i, p in enumerate(truth)])
    pairs = merge(a, b, 1001, SPREAD).pairs
    assert len(pairs) >= 990
    assert sum(i != j for i, j in pairs) <= 2
