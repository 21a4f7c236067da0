"""Range images to detections: places, heights and sizes of known bodies; the bottom; walls; a real hull."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.frames.geometry import body_to_global, polar_to_body
from ods.messages import Detection, Detections, Ping, Pose, RangeGrid, frame_of, seen_from_above
from ods.pipeline.chain import Chain
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.range_image import range_image
from ods.sim_sonar.scene.timeline import Scene
from ods.sonar_link.files.opening import open_pings
from tests.range_images import SONAR, ping_of, pose_at, scene_of, shipped_scene, sphere

HULL = Path(__file__).parents[2] / "data" / "sonar3d15" / "ship_short.sonar"


def looked_at(scene: Scene, t_s: float = 0.0, number: int = 0) -> tuple[Ping, Detections, Pose]:
    ping = ping_of(range_image(SONAR, scene, t_s, number), number, t_s)
    pose = pose_at(scene, t_s)
    return ping, Chain(PipelineSettings()).process(ping, pose=pose), pose


def place_of(found: Detection, pose: Pose) -> Floats:
    in_head = polar_to_body(found.range_m, found.bearing_rad, found.elevation_rad)
    return body_to_global(in_head, np.array(pose.position_ned), np.array(pose.attitude))


def test_bodies_at_three_heights_are_found_where_they_are_and_the_bottom_is_none() -> None:
    scene = shipped_scene()
    errors_m, sigmas = [], []
    for number in range(20):
        t_s = 2.5 * number
        _, seen, pose = looked_at(scene, t_s, number)
        assert len(seen.detections) == 3
        for item, radius in zip(scene.objects_at(t_s).position_ned, (0.5, 0.6, 0.4), strict=True):
            near = min(seen.detections, key=lambda found: math.dist(place_of(found, pose), item))
            off = place_of(near, pose) - item
            assert np.abs(off).max() < 0.25
            assert near.radius_m == pytest.approx(radius, rel=0.3)
            assert near.near_m == pytest.approx(math.dist(item, pose.position_ned) - radius, abs=0.1)
            errors_m.append(off)
            sigmas.append(near.sigma_elevation_rad * near.range_m)
    down = np.array(errors_m)[:, 2]
    assert abs(down.mean()) < 0.1
    assert np.mean(np.square(down / sigmas)) < 1.5


def test_the_height_reported_is_that_of_the_pose_and_not_of_the_head() -> None:
    body = sphere(9.0, 0.0, 20.0)
    scene = scene_of(body, bed_m=None)
    ping, _, level = looked_at(scene)
    pitched = msgspec.structs.replace(level, attitude=(math.cos(0.05), 0.0, math.sin(0.05), 0.0))
    seen = Chain(PipelineSettings()).process(ping, pose=pitched).detections
    assert place_of(seen[0], pitched)[2] == pytest.approx(20.0 - 9.0 * math.sin(0.1), abs=0.1)


def test_a_body_cut_off_above_and_below_does_not_claim_to_know_its_middle() -> None:
    pile = {"shape": "cylinder", "position_ned": [8.0, 0.0, 18.0], "radius_m": 0.3, "length_m": 30.0}
    _, seen, _ = looked_at(scene_of(pile | {"axis_ned": [0.0, 0.0, 1.0]}, bed_m=None))
    assert len(seen.detections) == 1
    reported = seen.detections[0]
    assert reported.elevation_extent_rad == pytest.approx(math.radians(40.0), rel=0.05)
    assert reported.sigma_elevation_rad * reported.range_m > 1.2
    assert reported.radius_m == pytest.approx(0.3, rel=0.3)
    assert not reported.cut


def test_a_wall_is_cut_into_pieces_that_stay_where_they_are() -> None:
    wall = {"shape": "plane", "position_ned": [9.0, 0.0, 20.0], "normal_ned": [-1.0, 0.0, 0.0], "width_m": 14.0,
            "height_m": 8.0}  # fmt: skip
    scene = scene_of(wall, bed_m=None, velocity=(0.0, 0.4, 0.0))
    places = []
    for number in range(2):
        _, seen, pose = looked_at(scene, 1.0 * number, number)
        assert len(seen.detections) >= 8
        assert max(found.radius_m for found in seen.detections) <= 1.0
        inner = [found for found in seen.detections if not found.cut and abs(found.bearing_rad) < 0.6]
        places.append(np.array([place_of(found, pose)[:2] for found in inner]))
    assert len(places[1]) >= 4
    for place in places[1][np.abs(places[1][:, 1]) < 5.0]:
        assert np.hypot(*(places[0] - place).T).min() < 0.15
        assert place[0] == pytest.approx(9.0, abs=0.1)


def test_pixels_are_numbered_and_a_lonely_one_is_no_body() -> None:
    ranges = np.zeros((64, 256), np.float32)
    ranges[20:30, 100:110] = 6.0
    ranges[50, 200] = 3.0
    mask = np.zeros((256, 64), np.int32)
    seen = Chain(PipelineSettings()).process(ping_of(ranges), mask)
    assert [found.cells for found in seen.detections] == [100]
    np.testing.assert_array_equal(mask, (ranges == 6.0).T)


def test_how_far_the_water_is_clear_is_the_nearest_echo_around_each_direction_but_for_lonely_pixels() -> None:
    rng = np.random.default_rng(3)
    ranges = np.zeros((64, 256), np.float32)
    ranges[10:40, 30:90] = 8.0 + rng.uniform(0.0, 0.05, (30, 60))
    ranges[50:53, 200:203] = 3.0
    alone = ranges.copy()
    alone[60, 250], alone[45, 20] = 2.0, 14.0
    seen = Chain(PipelineSettings()).process(ping_of(alone))
    assert seen.looked_volume is not None
    reported = np.frombuffer(seen.looked_volume.clear_m, "<f4").reshape(
        seen.looked_volume.bearings, seen.looked_volume.elevations
    )
    wanted = np.where(ranges > 0.0, ranges, 15.0).T
    np.testing.assert_allclose(reported, wanted.reshape(64, 4, 16, 4).min(axis=(1, 3)), atol=1e-3)
    assert seen.sector.half_vertical_rad == pytest.approx(math.radians(20.0))
    assert seen.usable


def test_a_sloping_bottom_is_no_body_and_a_hull_above_is() -> None:
    slope = {"shape": "plane", "position_ned": [8.0, 0.0, 21.5], "normal_ned": [-0.2, 0.0, -1.0]}
    _, seen, _ = looked_at(scene_of(slope, bed_m=None))
    assert seen.detections == []
    hull = {
        "shape": "plane",
        "position_ned": [8.0, 0.0, 18.5],
        "normal_ned": [0.2, 0.0, 1.0],
        "width_m": 6.0,
        "height_m": 6.0,
    }
    _, seen, _ = looked_at(scene_of(hull, bed_m=None))
    assert len(seen.detections) > 4


def test_a_real_hull() -> None:
    for ping in open_pings(HULL).pings:
        mask = np.zeros((ping.beams, ping.samples), np.int32)
        seen = Chain(PipelineSettings()).process(ping, mask)
        shown = frame_of(ping).astype(int) > 0
        assert np.count_nonzero(mask) > 0.85 * np.count_nonzero(shown)
        assert max(found.radius_m for found in seen.detections) <= 1.0
        nearest = min(found.near_m for found in seen.detections)
        assert nearest == pytest.approx(
            ping.dr_m * float(np.quantile(frame_of(ping).astype(float)[shown], 0.01)), abs=0.3
        )


@pytest.mark.parametrize(
    "spoilt",
    [{"range_grid": RangeGrid([0.0, 0.1], 15.0)}, {"range_grid": RangeGrid([0.1] * 64, 15.0)},
     {"range_grid": RangeGrid(SONAR.elevation_rad.tolist(), 0.05)}, {"bearing_rad": [0.0] * 256},
     {"bearing_rad": [0.0]}, {"range_grid": RangeGrid([math.nan] * 64, 15.0)}],
)  # fmt: skip
def test_what_makes_no_sense_is_refused(spoilt: dict[str, object]) -> None:
    ping = msgspec.structs.replace(ping_of(np.full((64, 256), 5.0, np.float32)), **spoilt)
    with pytest.raises(PingError):
        Chain(PipelineSettings()).process(ping)


def test_from_above_it_is_an_image_whose_levels_are_counts_of_echoes() -> None:
    ranges = np.zeros((64, 256), np.float32)
    ranges[20:30, 100:110] = 6.0
    ranges[40:45, 100] = 9.0
    above = seen_from_above(ping_of(ranges))
    frame = frame_of(above).astype(int)
    cells = np.argwhere(frame > 0)
    np.testing.assert_allclose(above.range0_m + above.dr_m * np.unique(cells[:, 1]), [6.0, 9.0], atol=above.dr_m)
    assert frame.sum() == np.count_nonzero(ranges)
    assert frame[100].max() == 10
    assert above.range_grid is None
    assert seen_from_above(above) is above


def test_of_too_many_bodies_the_nearest_ones_are_reported() -> None:
    ranges = np.zeros((64, 256), np.float32)
    for number in range(32 * 21):
        row, column = 3 * (number % 21), 8 * (number // 21)
        ranges[row : row + 2, column : column + 4] = 2.0 + 3.0 * (number % 5)
    seen = Chain(PipelineSettings()).process(ping_of(ranges)).detections
    assert len(seen) == 512
    assert max(found.near_m for found in seen) == pytest.approx(11.0, abs=0.01)


@pytest.mark.parametrize("bed_m", [None, 22.6])
def test_the_foot_of_a_near_wall_is_no_bottom(bed_m: float | None) -> None:
    wall = {"shape": "plane", "position_ned": [3.0, 0.0, 20.0], "normal_ned": [-1.0, 0.0, 0.0], "width_m": 2.0,
            "height_m": 8.0}  # fmt: skip
    _, seen, pose = looked_at(scene_of(wall, bed_m=bed_m))
    ahead = [found for found in seen.detections if abs(found.bearing_rad) < 0.3]
    assert ahead
    for found in ahead:
        assert found.elevation_extent_rad == pytest.approx(math.radians(40.0), rel=0.05)
        assert place_of(found, pose)[2] == pytest.approx(20.0, abs=0.15)
    assert all(place_of(found, pose)[0] < 3.5 for found in seen.detections)
