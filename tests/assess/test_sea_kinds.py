"""`ods assess sea --kinds`: the kinds of scene, and how their lists are judged."""

import math

import numpy as np
import pytest

from ods.assess.sea.kind_judge import TrackedList, judged
from ods.assess.sea.kind_run import reported_poses
from ods.assess.sea.kind_table import kind_table
from ods.assess.sea.kinds import KINDS, Kind, PoseNoise, kinds_named
from ods.assess.sea.run import scene_with_seed
from ods.assess.sea.scene_objects import SceneObjects
from ods.base.files.shipped import shipped_file
from ods.base.frames.geometry import euler_from_quat
from ods.cli import main
from ods.messages import Obstacle, ObstacleList, Truth, TruthObject
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.settings import SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene

BALL = TruthObject("ball", (50.0, 0.0, 20.0), (0.0, 0.0, 0.0), 1.0, True, 30.0, 0.0)
ONE = Kind("one", "gentle", "nothing")


def scene_of(kind: Kind) -> Scene:
    return Scene(kind.change(scene_with_seed(shipped_file(f"scenes/sea/{kind.scene}.toml"), 0).file))


def reported(number: int, *obstacles: Obstacle, reasons: tuple[str, ...] = (), unseen_why: str = "") -> TrackedList:
    """Return the list of a ping, a second after the one before."""
    t_ns = number * 10**9
    truth = Truth(number, t_ns, t_ns, (0.0, 0.0, 20.0), (1.0, 0.0, 0.0, 0.0), [BALL])
    said = ObstacleList(number, number, t_ns, t_ns, t_ns, not reasons, [*reasons], [*obstacles], unseen_why=unseen_why)
    return TrackedList(truth, said, 1, 2.0, 3.0)


def obstacle(number: int, north: float, east: float = 0.0, multipath_of: int = -1) -> Obstacle:
    return Obstacle(number, "active", (north, east, 20.0), (0.0, 0.0, 0.0), 1.0, (0.5, 1.0, 1.0), (0.1, 0.1, 0.1), 0.1,
                    0, 0, 9, 1.0, covariance_ne=0.0, multipath_of=multipath_of)  # fmt: skip


def bodies() -> SceneObjects:
    ball = Sphere(name="ball", position_ned=BALL.position_ned, radius_m=1.0)
    return SceneObjects(
        Scene(SceneFile(seed=1, vehicle=VehiclePath(position_ned=(0.0, 0.0, 20.0)), objects=[ball])), 1.0
    )


def test_every_kind_has_a_scene_a_sonar_and_bodies_that_have_to_be_tracked() -> None:
    assert len({kind.name for kind in KINDS}) == len(KINDS)
    for kind in KINDS:
        scene = scene_of(kind)
        assert SceneObjects(scene, 1.0).targets
        assert scene.file.duration_s == 35.0
        if kind.sonar:
            assert find_sonar(kind.sonar).name


def test_who_hovers_is_at_rest() -> None:
    for kind in kinds_named(["hovering gentle", "hovering rocky"]):
        before, after = (scene_of(kind).pose_at(t_s) for t_s in (0.0, 17.3))
        np.testing.assert_array_equal(before.position_ned, after.position_ned)
        np.testing.assert_array_equal(before.attitude, after.attitude)


def test_forty_spheres_are_five_metres_apart() -> None:
    for kind in kinds_named(["40 spheres", "40 spheres, rocky"]):
        places = np.array([item.position_ned for item in scene_of(kind).file.objects])
        distance = np.linalg.norm(places[:, None] - places[None], axis=2) + 100.0 * np.eye(40)
        np.testing.assert_allclose(distance.min(axis=1), 5.0)
    (open_water, rocks) = kinds_named(["40 spheres", "40 spheres, rocky"])
    assert scene_of(open_water).sea_bed is None
    assert scene_of(rocks).sea_bed is not None


def test_noise_of_the_poses_is_as_large_as_reported() -> None:
    scene, times = scene_of(ONE), [k * 10**7 for k in range(3000)]
    noise = PoseNoise(0.1, 0.5, 0.2)
    true, noisy = reported_poses(scene, times, None, 0), reported_poses(scene, times, noise, 0)
    place = np.array([pose.position_ned for pose in noisy]) - [pose.position_ned for pose in true]
    np.testing.assert_allclose(place.std(axis=0), 0.1, rtol=0.05)
    turned = np.degrees([np.subtract(euler_from_quat(a.attitude), euler_from_quat(b.attitude))
                         for a, b in zip(noisy, true, strict=True)])  # fmt: skip
    np.testing.assert_allclose(turned.std(axis=0), (0.2, 0.2, 0.5), rtol=0.05)
    assert noisy[0].sigma_position_ned == (0.1, 0.1, 0.1)
    np.testing.assert_allclose(np.degrees(noisy[0].sigma_attitude), (0.2, 0.2, 0.5))
    assert [pose.velocity_body for pose in noisy] == [pose.velocity_body for pose in true]


def test_what_is_marked_as_multipath_is_not_false_and_is_counted() -> None:
    lists = [reported(k, obstacle(1, 50.0), obstacle(2, 60.0, multipath_of=1), obstacle(3, 80.0)) for k in range(6)]
    score = judged(ONE, lists, bodies(), 0)
    assert (score.scene.false_ids, score.marked) == (1, 1)
    assert score.scene.targets[0].share == 1.0


def test_errors_are_of_the_nearest_active_obstacle() -> None:
    lists = [reported(k, obstacle(1, 50.4, -1.0), obstacle(2, 80.0)) for k in range(6)]
    score = judged(ONE, lists, bodies(), 0)
    assert score.error_m == pytest.approx(math.hypot(0.4, 1.0))
    assert score.nees == pytest.approx((0.4 / 0.5) ** 2 + 1.0)


def test_what_lists_say_counts_once_whatever_its_figures_and_from_a_second_on() -> None:
    lists = [
        reported(0, reasons=("the tracker has just started",)),
        reported(1),
        reported(2, unseen_why="a source in 12 % of the image"),
        reported(3, unseen_why="a source in 14 % of the image", reasons=("blind",)),
    ]
    score = judged(ONE, lists, bodies(), 0)
    assert score.said == [("a source in 12 % of the image", 2.0), ("blind", 3.0)]
    assert score.valid == 0.5
    assert math.isnan(score.error_m)
    row = kind_table([score])[-1]
    assert "a source in 12 % of the image (2.0); blind (3.0)" in row
    assert "| 50% |" in row


@pytest.mark.slow
def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["assess", "sea", "--kinds", "pose noise", "--seconds", "3"]) == 0
    heading, _, row = (line.strip("| ").split(" | ") for line in capsys.readouterr().out.strip().splitlines())
    cells = dict(zip(heading, row, strict=True))
    assert cells["kind"] == "pose noise"
    assert "mover 100%" in cells["objects: share of the lists"]
    assert cells["valid"] == "100%"


@pytest.mark.parametrize(
    ("asked", "named"),
    [(["hoovering gentle"], "hovering gentle"), (["--scenes", "gentle"], "--kinds: cannot be combined with")],
)
def test_what_cannot_be_is_one_line(asked: list[str], named: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["assess", "sea", "--kinds", *asked]) == 2
    assert named in capsys.readouterr().err
