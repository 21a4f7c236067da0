"""Handles in the plan of a scene: where they are, and what dragging them sets."""

import pytest

from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.workbench.model.apply import apply
from ods.workbench.model.paths import PathError, value_at
from ods.workbench.model.scene.edits import scene_of
from ods.workbench.model.scene.handles import dragged, handles_of
from ods.workbench.model.state import State

WAY = [{"t_s": 0.0, "position_ned": [0.0, 0.0, 4.0]}, {"t_s": 40.0, "position_ned": [50.0, 9.0, 4.0]}]
SCENE = scene_of(
    {
        "seed": 1,
        "vehicle": {"waypoints": WAY},
        "objects": [
            {"shape": "sphere", "name": "moves", "position_ned": [60, 1, 5], "velocity_ned": [-1, 2, 0], "radius_m": 2},
            {
                "shape": "cylinder", "name": "lies", "position_ned": [40, -20, 5], "radius_m": 1, "length_m": 6,
                "axis_ned": [0.6, 0.0, 0.8],
            },
            {"shape": "cylinder", "name": "stands", "position_ned": [40, 20, 5], "radius_m": 1, "length_m": 6},
            {"shape": "plane", "name": "wall", "position_ned": [90, 0, 5], "normal_ned": [2.0, 0.0, 0.5]},
            {
                "shape": "plane", "name": "sheet", "position_ned": [70, 0, 5], "normal_ned": [0.0, 1.0, 0.0],
                "width_m": 8, "height_m": 3,
            },
        ],
    }
)  # fmt: skip
T_S = 10.0
ALL = handles_of(SCENE, T_S)


def after(path: str, north: float, east: float) -> SceneFile:
    made = apply(State(scene=SCENE), dragged(SCENE, path, (north, east), T_S)).scene
    assert made is not None
    return made


@pytest.mark.parametrize("handle", ALL, ids=lambda handle: handle.path)
def test_a_drag_brings_the_handle_where_it_was_dragged(handle: object) -> None:
    """Sizes and turns: as far as the object lets it, so along the handle's own direction."""
    path, kind, (north, east) = next(each for each in ALL if each is handle)
    if kind in ("place", "waypoint"):
        target = (north + 3.0, east - 2.0)
    else:
        centre = next(each.at for each in ALL if each.path == f"{path.partition('.')[0]}.position_ned")
        target = (2.0 * north - centre[0], 2.0 * east - centre[1])
        if kind == "turn":
            target = (north, east)
    moved = handles_of(after(path, *target), T_S)
    assert next(each.at for each in moved if each.path == path) == pytest.approx(target)


def test_an_object_on_its_way_is_dragged_with_its_way() -> None:
    state = Scene(after("objects[0].position_ned", 70.0, 0.0)).objects_at(T_S)
    assert state.position_ned[0] == pytest.approx([70.0, 0.0, 5.0])
    assert state.velocity_ned[0] == pytest.approx([-1.0, 2.0, 0.0])


def test_a_vehicle_on_way_points_is_dragged_with_all_of_them() -> None:
    moved = after("vehicle.waypoints", 0.0, 0.0)
    before, now = (Scene(file).vehicle_at(T_S).position_ned for file in (SCENE, moved))
    assert now == pytest.approx([0.0, 0.0, before[2]])
    old, new = (file.vehicle.waypoints for file in (SCENE, moved))
    assert [b.position_ned[0] - a.position_ned[0] for a, b in zip(old, new, strict=True)] == pytest.approx(
        [-before[0]] * 2
    )


def test_turning_keeps_an_axis_as_steep() -> None:
    lies = after("objects[1].axis_ned", 40.0, 0.0)
    assert value_at(lies, "objects[1].axis_ned") == pytest.approx([0.0, 0.6, 0.8])


def test_a_length_is_measured_along_a_leaning_axis() -> None:
    """Its level share is 0.6: an end 6 m away in the plan is 10 m away along the axis."""
    assert value_at(after("objects[1].length_m", 34.0, -20.0), "objects[1].length_m") == pytest.approx(20.0)


def test_upright_things_have_no_handle_to_turn() -> None:
    assert {each.path for each in ALL if each.path.startswith("objects[2]")} == {
        "objects[2].position_ned", "objects[2].radius_m",
    }  # fmt: skip


def test_no_drag_makes_a_size_of_nothing() -> None:
    assert 0.0 < value_at(after("objects[0].radius_m", 50.0, 21.0), "objects[0].radius_m") < 0.1
    assert value_at(after("objects[3].normal_ned", 90.0, 0.0), "objects[3].normal_ned") == [2.0, 0.0, 0.5]


@pytest.mark.parametrize("path", ["objects[9].radius_m", "seed", "vehicle.heading_deg", "objects[0].name", ""])
def test_what_is_no_handle_is_refused(path: str) -> None:
    with pytest.raises(PathError):
        apply(State(scene=SCENE), dragged(SCENE, path, (0.0, 0.0), 0.0))
