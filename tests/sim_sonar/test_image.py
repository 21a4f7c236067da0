from pathlib import Path

import msgspec
import numpy as np
import pytest
from scipy import integrate

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.sim_sonar.echo.bodies import bodies
from ods.sim_sonar.echo.bodies.bodies import BODY, Bodies
from ods.sim_sonar.echo.bodies.motion_during_reception import as_received
from ods.sim_sonar.echo.surface.reflection import reflectivity
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.image import ImageSimulator, render_image
from ods.sim_sonar.mean_area import Surroundings, mean_area
from ods.sim_sonar.pose import Transmission, VehiclePose
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.scene.settings import SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sea_bed.model import sea_bed_of
from ods.sim_sonar.sea_bed.settings import SeaBed
from ods.sim_sonar.sonar.grid import grid_of
from ods.sim_sonar.sonar.model import SonarModel, load_sonar, make_sonar
from ods.sim_sonar.sonar.patterns import horizontal_power
from ods.sim_sonar.sonar.settings import SonarFile, VerticalPattern

SEABAT = load_sonar(Path(__file__).parents[2] / "config/sonars/seabat6012.toml")
PATTERN = VerticalPattern()
Triple = tuple[float, float, float]
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
ORIGIN = np.zeros(3)
PATTERN_WIDTH = np.radians(1.5) * integrate.quad(lambda x: float(horizontal_power(x, -25.0)), -60, 60, limit=800)[0]


def two_way(elevation_rad: float | Floats) -> Floats:
    off_axis_deg = np.degrees(np.abs(elevation_rad))
    return np.asarray(10 ** (np.interp(off_axis_deg, PATTERN.angle_deg, PATTERN.level_db) / 10))


def body(kind: int, centre: Triple, half: Triple, axes: Floats | None = None,
         surface: Triple = (1.0, 0.0, 0.3)) -> Bodies:  # fmt: skip
    return np.array([(kind, centre, np.eye(3) if axes is None else axes, half, *surface)], BODY)


def sphere(north: float, east: float, radius: float, down: float = 0.0, cd: float = 1.0, cs: float = 0.0) -> Bodies:
    return body(bodies.SPHERE, (north, east, down), (radius,) * 3, surface=(cd, cs, 0.3))


def image_of(objects: Bodies | None = None, bed: SeaBed | None = None, attitude: Floats = LEVEL,
             sonar: SonarModel = SEABAT, shadows: bool = True, max_error: float = 0.01) -> Floats:  # fmt: skip
    seen = None if bed is None else sea_bed_of(bed, 0)
    surroundings = Surroundings(np.empty(0, BODY) if objects is None else objects, seen, shadows)
    return mean_area(grid_of(sonar), surroundings, VehiclePose(ORIGIN, attitude), max_error)


# --- the sea-bed


def test_level_sea_bed_is_the_integral_of_eq_5() -> None:
    height, surface = 3.1, Surface(cd=0.4, cs=0.7, sigma_deg=25.0)
    image = image_of(bed=SeaBed(depth_m=height, surface=surface))

    def density(distance: float) -> float:
        gamma = reflectivity(height / distance, surface.cd, surface.cs, np.radians(surface.sigma_deg))
        return gamma * float(two_way(np.arcsin(height / distance))) * height

    for j in (62, 63, 80, 100, 150, 200, 250, 300, 360, 500, 1000, 1999):
        low, high = max(height, (j + 0.5) * 0.05), (j + 1.5) * 0.05
        expected = PATTERN_WIDTH * integrate.quad(density, low, high, epsabs=1e-12)[0]
        assert image[7, j] == pytest.approx(expected, rel=0.02), f"sample {j}"
    assert not image[:, :60].any()


def test_tilted_sea_bed_is_the_sum_over_its_area() -> None:
    height, attitude = 4.0, geometry.quat_from_euler(0.12, -0.08, 0.5)
    short = make_sonar(SonarFile(name="short", frequency_hz=455e3, beams_per_plane=21, beam_spacing_deg=2.0,
                                 beam_width_deg=2.0, range0_m=0.5, dr_m=0.5, samples=70))  # fmt: skip
    image = image_of(bed=SeaBed(depth_m=height, surface=Surface(cd=0.5, cs=0.0)), attitude=attitude, sonar=short)
    step, turn = 0.02, np.radians(0.15)
    away, toward = np.meshgrid(np.arange(step / 2, 36.0, step), np.arange(-0.4, 1.4, turn), indexing="ij")
    ground = np.stack([away * np.cos(toward), away * np.sin(toward), np.full_like(away, height)], axis=-1)
    distance, bearing, elevation = geometry.body_to_polar(geometry.global_to_body(ground, ORIGIN, attitude))
    cosine = height / distance
    weight = 0.5 * cosine * two_way(elevation) * cosine * away * step * turn
    for beam in (0, 10, 20):
        offset = (bearing - short.bearing_rad[beam]) / short.beam_width_rad
        received = weight * np.where(np.abs(offset) < 8.0, horizontal_power(np.clip(offset, -8, 8), -25.0), 0.0)
        expected = np.histogram(distance, 0.25 + 0.5 * np.arange(71), weights=received)[0]
        np.testing.assert_allclose(image[beam, 10:], expected[10:], rtol=0.05, atol=2e-3 * expected.max())


def test_figure_10_side_lobe_echoes_then_the_main_lobe() -> None:
    profile = image_of(bed=SeaBed(depth_m=3.1, surface=Surface(cd=0.5, cs=0.2, sigma_deg=20.0)))[30]
    metres = {name: profile[round(a / 0.05) : round(b / 0.05)] for name, a, b in
              (("side", 4, 10), ("gap", 11, 13), ("main", 18, 60), ("start", 0, 3))}  # fmt: skip
    assert metres["start"].max() == 0.0
    assert metres["gap"].min() < 0.3 * metres["side"].min()
    assert metres["side"].max() < 0.03 * metres["main"].max()
    assert metres["main"][0] > 0.5 * metres["main"].max() > 5.0 * profile[round(15 / 0.05)]


# --- objects


FLAT = VerticalPattern(angle_deg=[0.0, 90.0], level_db=[0.0, 0.0])
CLOSE_BEAMS = make_sonar(SonarFile(name="beams that add up evenly", frequency_hz=455e3, beams_per_plane=180,
                                   beam_spacing_deg=0.5, beam_width_deg=1.5, vertical=FLAT, range0_m=0.05, dr_m=0.05,
                                   samples=2000))  # fmt: skip


def received(objects: Bodies) -> float:
    """Return the area, weighted by gamma cos(alpha), that all beams receive together."""
    return float(image_of(objects, sonar=CLOSE_BEAMS).sum() * np.radians(0.5) / PATTERN_WIDTH)


def sphere_area(distance: float, radius: float, cd: float, cs: float) -> float:
    """Integrate gamma cos(alpha) over the lit cap of a sphere, by the cosine of the polar angle at its centre."""

    def ring(cosine: float) -> float:
        slant = np.sqrt(distance**2 + radius**2 - 2 * distance * radius * cosine)
        incidence = (distance * cosine - radius) / slant
        return float(reflectivity(incidence, cd, cs, 0.3) * incidence * 2 * np.pi * radius**2)

    return float(integrate.quad(ring, radius / distance, 1.0)[0])


def test_sphere_returns_the_integral_of_eq_3_wherever_it_is() -> None:
    for north, east, cs in ((30.0, 0.0, 0.0), (80.0, 0.0, 0.9), (50.0, 25.0, 0.3), (50.0, -25.0, 0.3)):
        expected = sphere_area(np.hypot(north, east), 0.8, 1.0, cs)
        assert received(sphere(north, east, 0.8, cs=cs)) == pytest.approx(expected, rel=5e-3)
    assert sphere_area(1e6, 0.8, 1.0, 0.0) == pytest.approx(2 * np.pi * 0.64 / 3, rel=1e-4)


def test_upright_cylinder_and_facing_plane() -> None:
    assert received(body(bodies.CYLINDER, (80.0, 0.0, 0.0), (0.2, 0.2, 1.0))) == pytest.approx(0.2 * np.pi, rel=0.01)
    facing = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    plate = body(bodies.PLANE, (70.0, 0.0, 0.0), (2.0, 1.0, 0.0), facing, (0.3, 0.4, 0.3))
    assert received(plate) == pytest.approx(0.7 * 8.0, rel=0.01)
    image = image_of(plate)
    assert image[:, 1398:1401].sum() > 0.95 * image.sum()


def test_sphere_echo_fills_its_near_half() -> None:
    north, radius = 60.0, 2.0
    profile = image_of(sphere(north, 0.0, radius)).sum(axis=0)
    edges = (np.arange(2000) + 1.5) * 0.05
    depth = np.clip((edges - (north - radius)) / radius, 0.0, 1.0)
    # Lambert: the share returned from depth d of the cap is 1 - (1 - d / r)^3, far from the sonar
    np.testing.assert_allclose(np.cumsum(profile) / profile.sum(), 1.0 - (1.0 - depth) ** 3, atol=0.03)


@pytest.mark.parametrize(("distance", "beam"), [(20.0, 5), (40.0, 29), (55.0, 44), (90.0, 59)])
def test_echo_is_at_its_range_and_bearing(distance: float, beam: int) -> None:
    bearing = SEABAT.bearing_rad[beam]
    image = image_of(sphere(distance * np.cos(bearing), distance * np.sin(bearing), 0.3, cs=1.0))
    where = np.unravel_index(np.argmax(image), image.shape)
    assert where[0] == beam
    first = np.argmax(image[beam] > 0.0)
    assert SEABAT.range0_m + first * SEABAT.dr_m == pytest.approx(distance - 0.3, abs=0.05)


def test_side_lobes_leave_mirror_objects_25_db_down() -> None:
    image = image_of(sphere(50.0, 0.0, 0.05, cs=1.0)).sum(axis=1)
    level = 10 * np.log10(image / image.max())
    away = np.abs(np.degrees(SEABAT.bearing_rad)) > 3.0
    assert -32.0 < level[away].max() < -24.0
    assert np.all(level[away] > -80.0)


def test_left_and_right_are_alike() -> None:
    right = np.concatenate([sphere(40.0, 12.0, 2.0, 1.0, cs=0.5), sphere(60.0, -20.0, 3.0)])
    left = right.copy()
    left["centre"][:, 1] *= -1.0
    bed = SeaBed(depth_m=5.0)
    starboard = image_of(right, bed, geometry.quat_from_euler(0.05, 0.03, 0.1))
    port = image_of(left, bed, geometry.quat_from_euler(-0.05, 0.03, -0.1))
    np.testing.assert_allclose(port[::-1], starboard, rtol=1e-6, atol=1e-9 * starboard.max())


def test_energy_does_not_depend_on_the_number_of_cells() -> None:
    objects = np.concatenate([sphere(40.0, 12.0, 2.0, 1.0, cs=0.5), body(bodies.CYLINDER, (60, -9, 0), (1, 1, 4))])
    coarse, fine = image_of(objects, max_error=0.03), image_of(objects, max_error=0.0005)
    assert coarse.sum() == pytest.approx(fine.sum(), rel=0.02)
    assert np.linalg.norm(coarse - fine) < 0.06 * np.linalg.norm(fine)


# --- hiding


def test_near_object_hides_the_far_one() -> None:
    near, far = sphere(20.0, 0.0, 2.0), sphere(60.0, 0.0, 3.0)
    both = np.concatenate([far, near])
    seen, alone = image_of(both, max_error=0.003), image_of(near, max_error=0.003)
    assert np.linalg.norm(seen - alone) < 0.02 * np.linalg.norm(alone)
    assert not seen[:, round(25 / 0.05) :].any()
    apart = alone + image_of(far)
    assert np.linalg.norm(image_of(both, shadows=False) - apart) < 0.02 * np.linalg.norm(apart)


def test_a_small_body_hides_of_a_wall_what_lies_behind_it_and_no_more() -> None:
    facing = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    wall = body(bodies.PLANE, (40.0, 0.0, 0.0), (8.0, 8.0, 0.0), facing)
    dark = body(bodies.SPHERE, (10.0, 0.0, 0.0), (0.2,) * 3, surface=(0.0, 0.0, 0.3))
    hidden = received(wall) - received(np.concatenate([wall, dark]))
    assert hidden == pytest.approx(np.pi * (4 * 0.2) ** 2, rel=0.2)


def test_shadow_lies_behind_the_object_and_only_there() -> None:
    bed = SeaBed(depth_m=4.0)
    rock = sphere(30.0, 0.0, 1.0, down=3.0)
    open_bed, shadowed = image_of(bed=bed), image_of(rock, bed)
    lit = image_of(rock, bed, shadows=False)
    top = np.arctan2(3.0, 30.0) - np.arcsin(1.0 / np.hypot(30.0, 3.0))  # the ray that grazes the rock from above
    end = round(4.0 / np.sin(top) / 0.05)
    assert shadowed[29:31, 640:900].max() < 0.4 * open_bed[29, 900]
    np.testing.assert_allclose(shadowed[29, end + 20 :], open_bed[29, end + 20 :])
    assert shadowed[29, end - 60] < 0.97 * open_bed[29, end - 60]
    np.testing.assert_allclose(shadowed[5, 100:], lit[5, 100:])
    assert np.all(shadowed <= lit + 1e-12)


def test_what_lies_under_the_sea_bed_is_not_seen() -> None:
    bed = SeaBed(depth_m=4.0)
    np.testing.assert_allclose(image_of(sphere(30.0, 0.0, 2.0, down=7.0), bed), image_of(bed=bed))


def test_walls_stop_the_view() -> None:
    facing = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    wall = body(bodies.PLANE, (40.0, 0.0, 0.0), (bodies.UNBOUNDED, bodies.UNBOUNDED, 0.0), facing)
    image = image_of(np.concatenate([wall, sphere(70.0, 0.0, 3.0)]), SeaBed(depth_m=4.0))
    along = 40.0 / np.cos(SEABAT.bearing_rad[[0, 15, 30]])
    peaks = SEABAT.range0_m + SEABAT.dr_m * np.argmax(image[[0, 15, 30]], axis=1)
    np.testing.assert_allclose(peaks, along, atol=0.8)
    assert image[30, 900:].max() < 1e-3 * image[30].max()


# --- other sonars


def test_planes_hear_what_is_at_their_elevation() -> None:
    three = make_sonar(SonarFile(name="three", frequency_hz=455e3, beams_per_plane=60, beam_spacing_deg=1.5,
                                 beam_width_deg=1.5, plane_elevation_deg=[-15.0, 0.0, 15.0], range0_m=0.05, dr_m=0.05,
                                 samples=1000))  # fmt: skip
    assert (three.beams, three.planes) == (180, 3)
    high = sphere(30.0 * np.cos(0.26), 0.0, 1.0, down=-30.0 * np.sin(0.26))
    energy = image_of(high, sonar=three).reshape(3, 60, 1000).sum(axis=(1, 2))
    assert energy[2] > 100 * energy[:2].max()


def test_uneven_beams() -> None:
    uneven = make_sonar(SonarFile(name="uneven", frequency_hz=1e6, bearing_deg=[-20.0, -5.0, 0.0, 1.0, 7.0],
                                  beam_width_deg=1.0, range0_m=2.0, dr_m=0.1, samples=300))  # fmt: skip
    image = image_of(sphere(20.0 * np.cos(np.radians(7)), 20.0 * np.sin(np.radians(7)), 0.5), sonar=uneven)
    assert image.sum(axis=1).argmax() == 4


def test_seabat_6012_as_the_paper_has_it() -> None:
    assert (SEABAT.beams, SEABAT.samples, SEABAT.planes) == (60, 2000, 1)
    assert np.degrees(np.ptp(SEABAT.bearing_rad)) + 1.5 == pytest.approx(90.0)
    assert SEABAT.range_max_m == pytest.approx(100.0)
    assert 1.0 / SEABAT.ping_period_s == pytest.approx(6.7, abs=0.05)


# --- the whole image


def scene_of(**image: object) -> Scene:
    return Scene(
        SceneFile(
            seed=5,
            vehicle=VehiclePath(position_ned=(0.0, 0.0, 0.0), velocity_ned=(1.0, 0.0, 0.0)),
            objects=[Sphere(name="a", position_ned=(40.0, 3.0, 1.0), radius_m=2.0)],
            sea_bed=SeaBed(depth_m=5.0),
            image=msgspec.convert(image, ImageLevels),
        )
    )


def test_same_seed_same_bytes_in_any_order() -> None:
    scene = scene_of(dropouts=[{"chance": 0.5}], beam_gain_rms_db=1.0, range_correlation=0.3)
    one, two = ImageSimulator(SEABAT, scene), ImageSimulator(SEABAT, scene)
    first = [one.render(0.15 * k, k).tobytes() for k in range(3)]
    assert [two.render(0.15 * k, k).tobytes() for k in (2, 1, 0)] == first[::-1]
    assert len({*first, ImageSimulator(SEABAT, scene, seed=6).render(0.0, 0).tobytes()}) == 4


def test_mean_image_is_what_speckle_averages_to() -> None:
    simulator = ImageSimulator(SEABAT, scene_of(noise_counts=200.0))
    mean = np.square(simulator.mean_image(0.0).astype(np.float64))
    receiver, area = simulator.receiver, simulator.mean_area(0.0)
    power = np.zeros_like(mean)
    for k in range(200):
        sent = Transmission(VehiclePose(np.array([3.7 * k, 0.0, 0.0]), LEVEL), 0.0, k)
        power += np.square(receiver.receive(area, sent).astype(np.float64))
    ratio = power / 200.0 / mean
    assert ratio.mean() == pytest.approx(1.0, abs=0.003)
    assert ratio.std() == pytest.approx(1.0 / np.sqrt(200.0), rel=0.05)


def test_without_speckle_the_mean_image_is_rendered() -> None:
    simulator = ImageSimulator(SEABAT, scene_of(speckle=False))
    np.testing.assert_array_equal(simulator.render(1.0, 3), simulator.mean_image(1.0, 3))
    area = simulator.mean_area(1.0)
    np.testing.assert_allclose(simulator.mean_image(1.0), np.sqrt(area * 20000.0**2 + 30.0**2), rtol=1e-6)


def test_one_call_renders_the_same_from_arrays() -> None:
    scene = scene_of(range_correlation=0.2)
    received = as_received(scene.bodies_at(3.0), 3.0, scene.pose_at(3.0), SEABAT.sound_speed, scene.pose_at)
    sent = Transmission(scene.pose_at(3.0), 3.0, 20)
    image = render_image(SEABAT, Surroundings(received, scene.sea_bed), sent, scene.file.image, seed=5)
    np.testing.assert_array_equal(image, ImageSimulator(SEABAT, scene).render(3.0, 20))
