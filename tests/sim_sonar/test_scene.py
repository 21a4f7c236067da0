import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ods.base.frames import geometry
from ods.base.settings_file import ConfigError
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.settings import Oscillation, SceneFile, VehiclePath, Waypoint
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.sonar.model import load_sonar

CONFIG = Path(__file__).parents[2] / "config"
SEABAT = load_sonar(CONFIG / "sonars/seabat6012.toml")

HEAD = """
seed = 1
[vehicle]
position_ned = [0.0, 0.0, 10.0]
velocity_ned = [1.0, 0.0, 0.0]
"""
BALL = '[[objects]]\nshape = "sphere"\nname = "ball"\nposition_ned = [30.0, 0.0, 10.0]\n'


def read(tmp_path: Path, text: str) -> Scene:
    path = tmp_path / "scene.toml"
    path.write_text(text)
    return load_scene(path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + BALL + "radius_m = 0.0", r"objects\[.*radius_m"),
        (HEAD + BALL + "radius_m = nan", r"objects\[0\]\.radius_m: must be a finite number"),
        (HEAD + BALL + "radius_m = 2.0\ncolour = 3", r"objects.*colour: unknown key"),
        (HEAD + BALL, r"objects.*radius_m: missing"),
        (HEAD + BALL + "radius_m = 40.0", r"objects: 'ball' encloses the sonar at t = 0.00 s"),
        (HEAD + BALL + "radius_m = 2.0", r"objects: 'ball' encloses the sonar at t = 28.00 s"),
        (HEAD + BALL.replace("sphere", "cube") + "radius_m = 2.0", r"objects.*shape"),
        (HEAD + 2 * (BALL + "radius_m = 0.1\n"), r"two objects have the name 'ball'"),
        (HEAD + BALL + "radius_m = 1.0\nwaypoints = [{t_s = 0.0, position_ned = [1, 2, 3]}]", r"position_ned: set"),
        (HEAD + "[sea_bed]\ndepth_m = 9.0", r"sea_bed.depth_m: the sonar is below the sea-bed at t = 0.00 s"),
        (HEAD + "[sea_bed]\ndepth_m = 19.0\nsurface = { sigma_deg = 0.0 }", r"sea_bed.surface.sigma_deg"),
        (HEAD + "[image]\nlooks = 0.0", r"image.looks"),
        ("seed = 1", r"vehicle: missing"),
        ("seed = ", r"not valid TOML"),
    ],
)
def test_bad_scenes_are_one_line_that_names_the_key(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said) as caught:
        read(tmp_path, text)
    assert "\n" not in str(caught.value)
    assert "scene.toml" in str(caught.value)


def test_bad_directions(tmp_path: Path) -> None:
    plane = HEAD + '[[objects]]\nshape = "plane"\nname = "quay"\nposition_ned = [90.0, 0.0, 0.0]\n'
    with pytest.raises(ConfigError, match=r"normal_ned: a direction of zero length"):
        read(tmp_path, plane + "normal_ned = [0.0, 0.0, 0.0]")
    with pytest.raises(ConfigError, match=r"width_m: give both"):
        read(tmp_path, plane + "normal_ned = [1.0, 0.0, 0.0]\nwidth_m = 3.0")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("samples = 0", "samples"),
        ("dr_m = -1.0", "dr_m"),
        ("beam_width_deg = nan", "beam_width_deg: must be a finite number"),
        ("beams = 60", "beams: unknown key"),
        ("bearing_deg = [1.0, 1.0]", "bearing_deg: must increase strictly"),
        ("vertical = { angle_deg = [0.0], level_db = [0.0] }", "vertical"),
        ("side_lobe_db = -10.0", "side_lobe_db"),
    ],
)
def test_bad_sonars(tmp_path: Path, line: str, said: str) -> None:
    good = {
        "name": '"x"',
        "frequency_hz": "1e5",
        "beam_width_deg": "1.0",
        "range0_m": "1.0",
        "dr_m": "0.1",
        "samples": "9",
    }
    key, value = line.split(" = ", 1)
    path = tmp_path / "sonar.toml"
    path.write_text("\n".join(f"{name} = {text}" for name, text in {**good, key: value}.items()))
    with pytest.raises(ConfigError, match=said):
        load_sonar(path)


def test_figure_11_has_the_papers_objects() -> None:
    scene = load_scene(CONFIG / "scenes/figure11.toml")
    start = scene.vehicle_at(0.0).position_ned
    ahead_across = (scene.objects_at(0.0).position_ned - start)[:, :2]
    np.testing.assert_allclose(ahead_across, [[35.0, 0.0], [75.0, 0.0], [60.0, -30.0]])
    simulator = ImageSimulator(SEABAT, scene)
    for t_s in np.arange(0.0, 60.0, 1.0):
        assert all(item.in_sector for item in simulator.truth(float(t_s)))
        gap = np.linalg.norm(scene.objects_at(t_s).position_ned - scene.vehicle_at(t_s).position_ned, axis=1)
        assert np.all(gap - scene.objects_at(t_s).radius_m > 8.0)
    image = simulator.render(0.0, 0)
    assert np.median(image) > 1.0
    assert image.max() < 65535.0


def test_worked_example_is_the_papers() -> None:
    scene = load_scene(CONFIG / "scenes/worked_example.toml")
    np.testing.assert_allclose(scene.vehicle_at(0.0).position_ned, [0.0, 0.0, 4.0])
    np.testing.assert_allclose(scene.vehicle_at(80.0).position_ned, [50.0, 0.0, 4.0])
    np.testing.assert_allclose(scene.vehicle_at(33.0).attitude, [1.0, 0.0, 0.0, 0.0])
    states = scene.objects_at(10.0)
    np.testing.assert_allclose(states.velocity_ned, [[-0.7, 0.4, 0.1], [0.5, 0.7, 0.1]])
    np.testing.assert_allclose(states.radius_m, [3.0, 6.0])
    simulator = ImageSimulator(SEABAT, scene)
    seen = [[item.in_sector for item in simulator.truth(float(t))] for t in range(81)]
    assert [row[0] for row in seen] == [t < 41 for t in range(81)]
    assert all(row[1] for row in seen)


finite = st.floats(-50.0, 50.0)
swings = st.builds(Oscillation, amplitude_deg=st.floats(0.0, 20.0), period_s=st.floats(2.0, 60.0), phase_deg=finite)


@settings(max_examples=40)
@given(
    places=st.lists(st.tuples(finite, finite, finite), min_size=2, max_size=6),
    roll=swings,
    pitch=swings,
    yaw=swings,
    follow=st.booleans(),
    t_s=st.floats(-5.0, 70.0),
)
def test_velocity_is_the_derivative_of_position(
    places: list[tuple[float, float, float]],
    roll: Oscillation,
    pitch: Oscillation,
    yaw: Oscillation,
    follow: bool,
    t_s: float,
) -> None:
    points = [Waypoint(t_s=10.0 * k, position_ned=place) for k, place in enumerate(places)]
    path = VehiclePath(waypoints=points, roll=roll, pitch=pitch, yaw=yaw, follow_path=follow)
    scene = Scene(SceneFile(seed=0, vehicle=path))
    step = 1e-3
    before, after = (scene.vehicle_at(t_s + sign * step).position_ned for sign in (-1, 1))
    state = scene.vehicle_at(t_s)
    velocity = geometry.rotation_matrix(state.attitude) @ state.velocity_body
    np.testing.assert_allclose(velocity, (after - before) / (2 * step), atol=2e-3)
    assert np.linalg.norm(state.attitude) == pytest.approx(1.0)
    for point in points:
        np.testing.assert_allclose(scene.vehicle_at(point.t_s).position_ned, point.position_ned, atol=1e-9)


def test_following_the_path_turns_the_bow_along_it() -> None:
    path = VehiclePath(position_ned=(0.0, 0.0, 0.0), velocity_ned=(1.0, 1.0, 0.0), follow_path=True)
    _, _, yaw = geometry.euler_from_quat(Scene(SceneFile(seed=0, vehicle=path)).vehicle_at(1.0).attitude)
    assert float(yaw) == pytest.approx(math.pi / 4)


def test_walls_have_no_circle(tmp_path: Path) -> None:
    quay = (
        '[[objects]]\nshape = "plane"\nname = "quay"\nposition_ned = [90.0, 0.0, 0.0]\nnormal_ned = [1.0, 0.0, 0.0]\n'
    )
    scene = read(tmp_path, HEAD + quay)
    assert scene.objects_at(0.0).names == ()
    assert scene.objects_at(0.0).position_ned.shape == (0, 3)
    assert len(scene.bodies_at(0.0)) == 1
