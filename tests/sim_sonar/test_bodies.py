import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.sim_sonar.echo.bodies import bodies
from ods.sim_sonar.echo.bodies.bodies import BODY, FAR, Body, circle_radius, contains, hit

angle = st.floats(-3.0, 3.0)
unit = st.floats(-1.0, 1.0)
KINDS = (bodies.SPHERE, bodies.CYLINDER, bodies.PLANE)
Triple = tuple[float, float, float]


def make(kind: int, centre: Triple, rpy: Triple, half: Triple) -> Body:
    axes = geometry.rotation_matrix(geometry.quat_from_euler(*rpy)).T
    body: Body = np.array([(kind, centre, axes, half, 1.0, 0.0, 0.2)], BODY)[0]
    return body


def local(body: Body, point: Floats) -> Floats:
    return np.asarray((point - body["centre"]) @ body["axes"].T)


@settings(deadline=None)  # on a busy machine
@given(
    st.sampled_from([bodies.SPHERE, bodies.CYLINDER, bodies.PLANE]),
    st.tuples(angle, angle, angle),
    st.tuples(unit, unit, unit),
)
def test_rays_end_on_the_first_surface_with_its_normal(kind: int, rpy: Triple, off: Triple) -> None:
    half = {bodies.SPHERE: (2.0, 2.0, 2.0), bodies.CYLINDER: (1.0, 1.0, 3.0), bodies.PLANE: (2.0, 3.0, 0.0)}[kind]
    body = make(kind, (10.0, 1.0, -2.0), rpy, half)
    aim = np.array([10.0, 1.0, -2.0]) + 3.0 * np.array(off)
    ray = aim / np.linalg.norm(aim)
    distance, cosine = hit(body, *ray)
    depths = np.linspace(0.0, 30.0, 3001)
    where = local(body, depths[:, None] * ray)
    if kind == bodies.SPHERE:
        inside = np.linalg.norm(where, axis=1) < 2.0
    elif kind == bodies.CYLINDER:
        inside = (np.hypot(where[:, 0], where[:, 1]) < 1.0) & (np.abs(where[:, 2]) < 3.0)
    else:
        crossed = np.sign(where[1:, 2]) != np.sign(where[:-1, 2])
        bounded = (np.abs(where[1:, 0]) < 1.98) & (np.abs(where[1:, 1]) < 2.98)
        inside = np.append(False, crossed & bounded)
    if np.any(inside):
        assert distance == pytest.approx(depths[np.argmax(inside)], abs=0.011)
        assert 0.0 <= cosine <= 1.0 + 1e-9
        aside = [ray + step for step in 1e-6 * np.eye(3)]
        ranges = np.array([hit(body, *(other / np.linalg.norm(other)))[0] for other in aside])
        if ranges.max() < FAR and cosine > 0.2:
            slope = np.linalg.norm(ranges / distance - 1.0) / 1e-6  # gradient of ln R across the ray: tan(alpha)
            assert slope == pytest.approx(np.sqrt(1 / min(cosine, 1.0) ** 2 - 1), abs=0.02)
    elif kind != bodies.PLANE:
        assert distance == FAR or np.min(np.abs(depths - distance)) < 0.011


def test_nothing_is_met_behind_or_from_inside() -> None:
    for kind in KINDS:
        behind = make(kind, (-10.0, 0.0, 0.0), (0.0, 0.0, 0.0), (2.0, 2.0, 2.0))
        assert hit(behind, 1.0, 0.0, 0.0) == (FAR, 0.0)
    around = make(bodies.SPHERE, (0.5, 0.0, 0.0), (0.0, 0.0, 0.0), (2.0, 2.0, 2.0))
    assert hit(around, 1.0, 0.0, 0.0) == (FAR, 0.0)
    assert contains(around, np.zeros(3))


@given(st.sampled_from(KINDS), angle, angle, angle)
def test_circle_circumscribes_the_projection(kind: int, roll: float, pitch: float, yaw: float) -> None:
    half = {bodies.SPHERE: (2.0, 2.0, 2.0), bodies.CYLINDER: (1.5, 1.5, 2.0), bodies.PLANE: (2.0, 3.0, 0.0)}[kind]
    body = make(kind, (5.0, 6.0, 7.0), (roll, pitch, yaw), half)
    turn = np.linspace(0.0, 2 * np.pi, 20001)
    if kind == bodies.PLANE:
        corners = np.array([[x, y, 0.0] for x in (-2.0, 2.0) for y in (-3.0, 3.0)])
    else:
        up = np.array([0.0, 0.0, 2.0])
        rim = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1) * half[0]
        corners = rim if kind == bodies.SPHERE else np.concatenate([rim + up, rim - up])
    spread = np.hypot(*(corners @ body["axes"])[:, :2].T).max()
    expected = 2.0 if kind == bodies.SPHERE else spread
    assert circle_radius(body) == pytest.approx(expected, rel=1e-6)


def test_frame_change_keeps_distances_and_shapes() -> None:
    attitude = geometry.quat_from_euler(0.1, -0.2, 0.7)
    body = make(bodies.CYLINDER, (20.0, 3.0, 5.0), (0.4, 0.3, 0.2), (1.0, 1.0, 2.0))
    position = np.array([1.0, 2.0, 3.0])
    (seen,) = bodies.to_sonar_frame(np.array([body]), position, geometry.rotation_matrix(attitude))
    centre = geometry.global_to_body(body["centre"], position, attitude)
    np.testing.assert_allclose(seen["centre"], centre)
    axis = geometry.global_to_body(body["axes"][2], np.zeros(3), attitude)
    np.testing.assert_allclose(seen["axes"][2], axis)


@pytest.mark.parametrize(
    ("point", "sphere", "upright", "plane"),
    [
        ((0.0, 0.0, 0.0), -2.0, -1.0, 0.0),
        ((5.0, 0.0, 0.0), 3.0, 4.0, 3.0),
        ((0.0, 0.0, 7.0), 5.0, 4.0, 7.0),
        ((3.0, 4.0, 0.0), 3.0, 4.0, math.sqrt(2.0)),  # 1 beyond the plane's edge in x, 1 in y
        ((4.0, 0.0, 7.0), math.sqrt(65.0) - 2.0, 5.0, math.sqrt(53.0)),
        ((0.0, 0.5, 2.8), math.sqrt(8.09) - 2.0, -0.2, 2.8),  # inside, under the lid
    ],
)
def test_clearances_by_hand(point: Triple, sphere: float, upright: float, plane: float) -> None:
    all_ = np.array(
        [
            make(bodies.SPHERE, (10.0, 0.0, 0.0), (0.3, 0.2, 0.1), (2.0, 2.0, 2.0)),
            make(bodies.CYLINDER, (10.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1.0, 3.0)),
            make(bodies.PLANE, (10.0, 0.0, 0.0), (0.0, 0.0, 0.0), (2.0, 3.0, 0.0)),
        ]
    )
    found = bodies.clearances(all_, np.add(point, (10.0, 0.0, 0.0)))
    assert found == pytest.approx([sphere, upright, plane])
