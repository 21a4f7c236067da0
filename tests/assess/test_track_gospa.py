"""GOSPA against cases worked by hand, against all assignments, and against Stone Soup's."""

import itertools
import math
from datetime import datetime

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.assess.track.gospa import CUTOFF_M, gospa, pair
from ods.assess.track.scores import partial_gospa
from ods.base.arrays import Floats

pytestmark = pytest.mark.slow

NOW = datetime(2000, 1, 1)
Places = list[tuple[float, float]]
places = st.lists(st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0)), max_size=4)
CASES: list[tuple[Places, Places, float]] = [
    ([(0.0, 0.0)], [(3.0, 4.0)], 5.0),
    ([(0.0, 0.0)], [], math.sqrt(50.0)),
    ([], [(7.0, 1.0)], math.sqrt(50.0)),
    ([(0.0, 0.0)], [(30.0, 0.0)], 10.0),  # too far: one missed, one false
    ([(0.0, 0.0)], [(9.0, 0.0)], 9.0),
    ([(0.0, 0.0), (1.0, 0.0)], [(1.0, 0.0), (2.0, 0.0)], math.sqrt(2.0)),
    ([(0.0, 0.0), (100.0, 0.0)], [(1.0, 0.0), (50.0, 0.0), (50.0, 9.0)], math.sqrt(1.0 + 3 * 50.0)),
    ([(0.0, 0.0), (8.0, 0.0)], [(5.0, 0.0)], math.sqrt(9.0 + 50.0)),
    ([], [], 0.0),
]


def between(objects: Places, tracks: Places) -> Floats:
    one, other = np.array(objects).reshape(-1, 2), np.array(tracks).reshape(-1, 2)
    return np.asarray(np.linalg.norm(one[:, None] - other[None], axis=2))


def ours(objects: Places, tracks: Places) -> float:
    pairing = pair(between(objects, tracks))
    return gospa(pairing.distance, len(objects) - len(pairing.objects), len(tracks) - len(pairing.tracks))


@pytest.mark.parametrize(("objects", "tracks", "expected"), CASES)
def test_cases_worked_by_hand(objects: Places, tracks: Places, expected: float) -> None:
    assert ours(objects, tracks) == pytest.approx(expected, abs=1e-12)
    assert ours(tracks, objects) == pytest.approx(expected, abs=1e-12)


@settings(max_examples=100)
@given(places, places)
def test_it_is_the_least_over_all_assignments(objects: Places, tracks: Places) -> None:
    few, many = sorted((objects, tracks), key=len)
    distance = between(few, many)
    least = min(
        sum(min(distance[i, j], CUTOFF_M) ** 2 for i, j in enumerate(chosen))
        for chosen in itertools.permutations(range(len(many)), len(few))
    )
    expected = math.sqrt(least + 0.5 * CUTOFF_M**2 * (len(many) - len(few)))
    assert ours(objects, tracks) == pytest.approx(expected, abs=1e-9)


def test_the_library_agrees() -> None:
    metrics = pytest.importorskip("stonesoup.metricgenerator.ospametric")
    state = pytest.importorskip("stonesoup.types.state").State
    metric = metrics.GOSPAMetric(c=CUTOFF_M, p=2.0)
    rng = np.random.default_rng(2)
    cases = [(objects, tracks) for objects, tracks, _ in CASES if objects and tracks]
    cases += [
        (rng.uniform(0.0, 40.0, (n, 2)).tolist(), rng.uniform(0.0, 40.0, (m, 2)).tolist())
        for n, m in rng.integers(1, 30, (20, 2)).tolist()
    ]
    for objects, tracks in cases:
        theirs, _ = metric.compute_gospa_metric(
            [state(np.array([[x], [y]]), timestamp=NOW) for x, y in tracks],
            [state(np.array([[x], [y]]), timestamp=NOW) for x, y in objects],
        )
        assert ours(objects, tracks) == pytest.approx(float(theirs.value["distance"]), rel=1e-14, abs=1e-14)


def test_tracks_of_objects_that_do_not_count_do_not_count_either() -> None:
    distance = between([(0.0, 0.0), (20.0, 0.0)], [(1.0, 0.0), (21.0, 0.0), (50.0, 0.0)])
    first, second, none = np.array([True, False]), np.array([False, True]), np.zeros(2, bool)
    nobody = np.zeros(3, bool)
    assert partial_gospa(distance, first, second, nobody) == pytest.approx(math.sqrt(1.0 + 50.0))
    assert partial_gospa(distance, first, none, nobody) == pytest.approx(math.sqrt(1.0 + 100.0))
    assert partial_gospa(distance, first, second, np.array([False, False, True])) == pytest.approx(1.0)
    assert partial_gospa(distance, none, none, np.ones(3, bool)) == 0.0
