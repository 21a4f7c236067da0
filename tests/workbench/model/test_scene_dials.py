"""The sliders of a scene set what is there."""

import pytest

from ods.sim_sonar.by_name import find_scene
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.paths import value_at
from ods.workbench.model.scene.dials import Group, image_groups, object_groups, sea_bed_groups, vehicle_groups
from ods.workbench.model.scene.edits import scene_of
from ods.workbench.model.short_tables import short_tables
from ods.workbench.model.sliders import Number
from ods.workbench.model.state import State

SCENE = scene_of(
    short_tables(find_scene("rough_figure11").file)
    | {
        "objects": [
            {"shape": "sphere", "name": "s", "position_ned": [60, 1, 20], "radius_m": 2},
            {"shape": "cylinder", "name": "c", "position_ned": [40, -20, 20], "radius_m": 1, "length_m": 6},
            {"shape": "plane", "name": "wall", "position_ned": [90, 0, 5], "normal_ned": [2.0, 0.0, 0.5]},
            {
                "shape": "plane", "name": "p", "position_ned": [70, 0, 5], "normal_ned": [0, 1, 0.5],
                "width_m": 8, "height_m": 3,
            },
        ]
    }
)  # fmt: skip
GROUPS = [*vehicle_groups(SCENE), *sea_bed_groups(SCENE), *image_groups(), *(
    group for place in range(4) for group in object_groups(SCENE, place)
)]  # fmt: skip


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: f"{group.title}-{group.dials[0].path}")
def test_every_slider_sets_its_value_over_its_whole_range(group: Group) -> None:
    for dial in group.dials:
        assert isinstance(dial.by, Number)
        assert dial.by.low <= value_at(SCENE, dial.path) <= dial.by.high or "normal" in dial.path
        for value in (dial.by.low, dial.by.high):
            made = apply(State(scene=SCENE), do.SetScene(dial.path, value)).scene
            assert made is not None
            assert value_at(made, dial.path) == value


def test_a_curve_has_way_points_instead_of_sliders() -> None:
    (path, *_) = vehicle_groups(find_scene("worked_example").file)
    assert [dial.path for dial in path.dials] == ["vehicle.heading_deg"]


def test_open_water_has_no_sliders_of_a_sea_bed() -> None:
    assert sea_bed_groups(find_scene("empty").file) == []
