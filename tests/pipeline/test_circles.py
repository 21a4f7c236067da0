from itertools import combinations

import numpy as np
from hypothesis import given, settings, strategies as st

from ods.base.arrays import Floats
from ods.pipeline.measure.circle.enclosing_circle import smallest_circle

coordinate = st.integers(-20, 20).map(lambda n: n / 4.0)
point_lists = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=9)


def brute_force_radius(points: Floats) -> float:
    """Smallest of all circles over a diameter and through three points that hold every point."""
    candidates = [((a + b) / 2.0, np.linalg.norm(a - b) / 2.0) for a, b in combinations(points, 2)]
    for a, b, c in combinations(points, 3):
        matrix = 2.0 * np.array([b - a, c - a])
        if abs(np.linalg.det(matrix)) > 1e-9:
            centre = np.linalg.solve(matrix, [b @ b - a @ a, c @ c - a @ a])
            candidates.append((centre, np.linalg.norm(centre - a)))
    holding = [r for centre, r in candidates if np.all(np.linalg.norm(points - centre, axis=1) <= r + 1e-9)]
    return float(min(holding, default=0.0))


@settings(max_examples=200, deadline=None)
@given(point_lists)
def test_circle_is_the_smallest_that_holds_all(coordinates: list[tuple[float, float]]) -> None:
    points = np.array(coordinates)
    x, y, radius = smallest_circle(points)
    assert np.all(np.hypot(points[:, 0] - x, points[:, 1] - y) <= radius + 1e-6)
    assert abs(radius - brute_force_radius(points)) < 1e-6


def test_many_points_on_one_circle() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 500)
    x, y, radius = smallest_circle(np.column_stack([80.0 + 3.0 * np.cos(angle), -20.0 + 3.0 * np.sin(angle)]))
    np.testing.assert_allclose([x, y, radius], [80.0, -20.0, 3.0], atol=1e-6)


def test_points_in_line() -> None:
    points = np.column_stack([np.linspace(0.0, 8.0, 50), np.linspace(0.0, 6.0, 50)])
    np.testing.assert_allclose(smallest_circle(points), (4.0, 3.0, 5.0), atol=1e-9)
