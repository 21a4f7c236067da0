"""Two missions' maps made one: the objects that both have are recognised, and what both know of them is fused.

A pair is one object when the difference of place and radius is small against both covariances. These include what two
missions never share: the error of each pose (`position_sigma_m`) and the side an object was seen from (`shape_sigma`,
in units of its radius). All pairs are chosen together, so that maps that are offset against each other do not pair
each object with its neighbour.
"""

from dataclasses import dataclass

import msgspec
import numpy as np

from ods.base.arrays import Floats, Indices
from ods.base.geodesy import LocalFrame
from ods.messages import Vector3
from ods.tracker.map.hibernated import HibernatedObjects
from ods.tracker.map.map_object import MapObject

GATE = 13.28
"""Largest squared distance of a pair: 99 % of chi-square with 4 degrees of freedom. Two entries for one object do less
harm than one entry for two."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviations that an object's place has beyond its own, from one mission to another."""

    position_sigma_m: float
    shape_sigma: float


@dataclass(frozen=True, slots=True)
class Merged:
    """What two maps make together."""

    objects: list[MapObject]
    next_id: int
    """From here on no id was ever used."""
    pairs: list[tuple[int, int]]
    """Ids of the same object in the first map and in the second."""


def merge(first: list[MapObject], second: list[MapObject], first_free_id: int, spread: Spread) -> Merged:
    """Return both maps as one, in the first one's frame. The first one's ids stay; the second one's get new ones.

    An object of one map that was carried over into the other (same id, first seen at the same nanosecond) is in the
    second what it is in the first, later: of these the one seen last is taken, as fusing would count echoes twice.
    """
    common, twins = _common_ids(first, second)
    candidates = [o for o in first if o.id not in common]
    others = [o for o in second if o.id not in common]
    pairs = _pairs(candidates, others, spread)
    fused = {candidates[i].id: _fused(candidates[i], others[j], spread) for i, j in pairs}
    paired = {j for _, j in pairs}
    new = [o for j, o in enumerate(others) if j not in paired]
    renamed = [msgspec.structs.replace(o, id=first_free_id + k) for k, o in enumerate(new)]
    kept = [common.get(o.id) or fused.get(o.id) or o for o in first]
    same = sorted(twins + [(candidates[i].id, others[j].id) for i, j in pairs])
    return Merged(kept + renamed, first_free_id + len(new), same)


def moved(objects: list[MapObject], source: LocalFrame, target: LocalFrame) -> list[MapObject]:
    """Return the same objects in the local frame `target`."""
    if source == target or not objects:
        return objects
    places = target.ned(*source.geodetic([o.position for o in objects]))
    turn = target.rotation().T @ source.rotation()
    return [_placed(o, place, turn @ _covariance(o) @ turn.T) for o, place in zip(objects, places, strict=True)]


def _common_ids(first: list[MapObject], second: list[MapObject]) -> tuple[dict[int, MapObject], list[tuple[int, int]]]:
    """Return the objects that are in both maps under one id, as they were last, and their ids as pairs."""
    known = {(o.id, o.first_seen_utc_ns): o for o in first}
    twins = [(known[o.id, o.first_seen_utc_ns], o) for o in second if (o.id, o.first_seen_utc_ns) in known]
    latest = {a.id: b if b.last_seen_utc_ns > a.last_seen_utc_ns else a for a, b in twins}
    return latest, [(i, i) for i in latest]


def _pairs(first: list[MapObject], second: list[MapObject], spread: Spread) -> list[tuple[int, int]]:
    """Return the indices of objects that are the same: of all pairs inside the gate those with the least sum."""
    from scipy.sparse import coo_array  # an extra: on board no maps are merged
    from scipy.sparse.csgraph import min_weight_full_bipartite_matching

    rows, columns, distances = _gated(first, second, spread)
    if not len(rows):
        return []
    # Every object of the first map has a place of its own in the matching, at the cost of the gate: then it is alone.
    alone = np.arange(len(first))
    costs = np.concatenate([distances, np.full(len(first), GATE)]) + 1.0  # a cost of 0 would be no edge
    edges = (np.concatenate([rows, alone]), np.concatenate([columns, len(second) + alone]))
    graph = coo_array((costs, edges), shape=(len(first), len(second) + len(first))).tocsr()
    left, right = min_weight_full_bipartite_matching(graph)
    return [(int(i), int(j)) for i, j in zip(left, right, strict=True) if j < len(second)]


def _gated(first: list[MapObject], second: list[MapObject], spread: Spread) -> tuple[Indices, Indices, Floats]:
    """Return indices into both maps of the pairs inside the gate, and their squared statistical distances."""
    known = HibernatedObjects(first)
    row_of = {o.id: row for row, o in enumerate(first)}
    covariances = np.array([_covariance(o, spread) for o in first]).reshape(-1, 3, 3)
    places = np.array([o.position for o in first]).reshape(-1, 3)
    radii = np.array([o.radius for o in first])
    radius_variances = np.array([_radius_variance(o, spread) for o in first])
    widest = max((float(np.trace(c[:2, :2])) for c in covariances), default=0.0)
    found: list[tuple[Indices, Indices, Floats]] = []
    for column, o in enumerate(second):
        own = _covariance(o, spread)
        reach = float(np.sqrt(GATE * (widest + np.trace(own[:2, :2]))))
        near = np.array([row_of[i] for i in known.places(np.array(o.position[:2]), reach)[0].tolist()], np.intp)
        offset = places[near] - o.position
        apart = (offset * np.linalg.solve(covariances[near] + own, offset[..., None])[..., 0]).sum(axis=1)
        apart += (radii[near] - o.radius) ** 2 / (radius_variances[near] + _radius_variance(o, spread))
        inside = apart <= GATE
        found.append((near[inside], np.full(np.count_nonzero(inside), column), apart[inside]))
    if not found:
        return np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0)
    rows, columns, distances = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return rows, columns, distances


def _fused(a: MapObject, b: MapObject, spread: Spread) -> MapObject:
    """Return what two missions know of one object together, under the id of `a`; each weighs by its information."""
    weight_a, weight_b = np.linalg.inv(_covariance(a, spread)), np.linalg.inv(_covariance(b, spread))
    covariance = np.linalg.inv(weight_a + weight_b)
    place = covariance @ (weight_a @ np.array(a.position) + weight_b @ np.array(b.position))
    radius_a, radius_b = 1.0 / _radius_variance(a, spread), 1.0 / _radius_variance(b, spread)
    return msgspec.structs.replace(
        _placed(a, place, covariance),
        radius=(radius_a * a.radius + radius_b * b.radius) / (radius_a + radius_b),
        sigma_radius=(radius_a + radius_b) ** -0.5,
        existence=1.0 - (1.0 - a.existence) * (1.0 - b.existence),
        times_seen=a.times_seen + b.times_seen,
        first_seen_utc_ns=min(a.first_seen_utc_ns, b.first_seen_utc_ns),
        last_seen_utc_ns=max(a.last_seen_utc_ns, b.last_seen_utc_ns),
        hibernated_utc_ns=max(a.hibernated_utc_ns, b.hibernated_utc_ns),
    )


LEAST_PLACE_VARIANCE = 1e-6
"""No place is known better than to 1 mm (m^2)."""


def _covariance(o: MapObject, spread: Spread | None = None) -> Floats:
    """Return the (3, 3) covariance of an object's place."""
    matrix = np.diag(np.square(o.sigma))
    matrix[0, 1] = matrix[1, 0] = o.covariance_ne
    if spread is not None:
        more = spread.position_sigma_m**2 + (spread.shape_sigma * o.radius) ** 2
        matrix += np.diag([more, more, 0.0]) + LEAST_PLACE_VARIANCE * np.eye(3)
    return matrix


def _radius_variance(o: MapObject, spread: Spread) -> float:
    return o.sigma_radius**2 + (spread.shape_sigma * o.radius) ** 2 + LEAST_PLACE_VARIANCE


def _placed(o: MapObject, place: Floats, covariance: Floats) -> MapObject:
    position: Vector3 = tuple(place.tolist())
    sigma: Vector3 = tuple(np.sqrt(np.diag(covariance)).tolist())
    return msgspec.structs.replace(o, position=position, sigma=sigma, covariance_ne=float(covariance[0, 1]))
