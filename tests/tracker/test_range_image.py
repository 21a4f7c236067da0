"""A 3-D sonar's detections in tracker, list and clearance: heights, what is hidden, what is clear at which height."""

import math

import numpy as np
import pytest

from ods.base.clock import NS
from ods.messages import Clearance, ObstacleList, PoseAt
from ods.offline.mission import Mission, MissionSettings, Step
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.scene.timeline import Scene
from ods.tracker.clearance.clearance import ClearanceKeeper
from ods.tracker.measurement.coverage.looked import ObservedRanges
from ods.tracker.settings import ClearanceSettings
from tests.range_images import PERIOD_S, pings_of, poses_of, scene_of, shipped_scene, sphere

SETTINGS = ClearanceSettings(sectors=72, half_height_m=0.3, fastest_m_s=1.0, fastest_vertical_m_s=0.5)


def flown(scene: Scene, count: int) -> list[Step]:
    return [*Mission(MissionSettings()).steps(pings_of(scene, count), poses_of(scene, count * PERIOD_S + 1.0))]


def test_the_list_tells_how_high_each_object_is() -> None:
    scene = shipped_scene()
    steps = flown(scene, 30)
    reported = steps[-1].list
    assert len(reported.obstacles) == 3
    for item in scene.objects_at(29 * PERIOD_S).position_ned:
        near = min(reported.obstacles, key=lambda each: math.dist(each.position_ned, item))
        assert math.dist(near.position_ned, item) < 0.3
        assert near.position_ned[2] == pytest.approx(item[2], abs=max(0.1, 2.5 * near.sigma_position[2]))
        assert near.sigma_position[2] < 0.4
        assert near.times_seen >= 25
    assert len({each.id for step in steps for each in step.list.obstacles}) == 3


def test_an_object_that_another_one_hides_is_not_missed() -> None:
    screen = {"shape": "plane", "position_ned": [5.0, -5.0, 20.0], "velocity_ned": [0.0, 1.5, 0.0],
              "normal_ned": [-1.0, 0.0, 0.0], "width_m": 3.0, "height_m": 6.0}  # fmt: skip
    steps = flown(scene_of(screen, sphere(10.0, 0.0, 20.0), bed_m=None), 40)
    before = [each for each in steps[8].list.obstacles if each.position_ned[0] > 9.0]
    assert len(before) == 1
    behind = [each for step in steps for each in step.list.obstacles if each.id == before[0].id]
    assert max(each.unseen_s for each in behind) > 0.5
    assert [each.id for each in steps[-1].list.obstacles if each.position_ned[0] > 9.0] == [before[0].id]


def test_what_hides_and_what_does_not() -> None:
    clear = np.full((4, 2), 15.0)
    clear[1, 0] = 5.0
    looked = ObservedRanges(clear, (-0.8, 0.8), (-0.4, 0.4))
    bearing, elevation = np.array([-0.3, -0.3, 0.3, -0.3, -0.3, 2.0]), np.array([-0.2, 0.2, -0.2, -0.2, -0.2, -0.2])
    range_m = np.array([8.0, 8.0, 8.0, 5.2, math.nan, 8.0])
    hidden = looked.hides(range_m, bearing, elevation, np.full(6, 0.5))
    assert hidden.tolist() == [True, False, False, False, False, False]


def clearance_of(scene: Scene) -> Clearance:
    """What is known after two pings at rest."""
    keeper, chain = ClearanceKeeper(SETTINGS), Chain(PipelineSettings())
    state = scene.vehicle_at(0.0)
    pose = PoseAt(
        tuple(state.position_ned.tolist()), tuple(state.attitude.tolist()), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3
    )
    for number, ping in enumerate(pings_of(scene, 3)):
        t_ns = round(number * PERIOD_S * NS)
        reported = ObstacleList(
            number, number, t_ns, t_ns, t_ns, valid=True, reasons=[], obstacles=[], pose=pose, head=pose
        )
        made = keeper.after(reported, chain.process(ping))
    return made


def test_water_is_clear_over_an_even_bottom_up_to_the_range_of_the_sonar() -> None:
    made = clearance_of(scene_of(bed_m=22.6))
    assert made.clear_to_m[2] > 12.0
    assert made.clear_to_m[-5] > 12.0
    assert made.clear_to_m[14] == 0.0  # azimuth 72: beside the fan
    assert made.clear_from_m[2] < 2.5


def test_it_ends_where_a_bottom_rises_into_the_layer() -> None:
    slope = {"shape": "plane", "position_ned": [8.0, 0.0, 20.0], "normal_ned": [-0.3, 0.0, -1.0]}
    made = clearance_of(scene_of(slope, bed_m=None))
    assert 4.5 < made.clear_to_m[0] < 7.3  # 0.3 m under the layer's middle it is 1 m nearer than at it


def test_a_body_beside_the_layer_leaves_the_water_at_its_height_clear_and_one_in_it_does_not() -> None:
    above = clearance_of(scene_of(sphere(8.0, 0.4, 18.3, 0.5), bed_m=None))
    within = clearance_of(scene_of(sphere(8.0, 0.4, 20.0, 0.5), bed_m=None))
    assert within.clear_to_m[0] < 7.6
    assert above.clear_to_m[3] > 12.0
    assert above.nearest_m[0] == pytest.approx(7.5, abs=0.5)  # a planner receives of it all the same
