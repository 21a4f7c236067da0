from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from ods.messages import TruthObject
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.scene.settings import Cylinder, Plane, SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sea_bed.settings import SeaBed
from ods.sim_sonar.sonar.model import SonarModel, load_sonar, make_sonar
from ods.sim_sonar.sonar.settings import SonarFile

SEABAT = load_sonar(Path(__file__).parents[2] / "config/sonars/seabat6012.toml")


def ball(name: str, north: float, east: float = 0.0, down: float = 0.0, radius: float = 2.0) -> Sphere:
    return Sphere(name=name, position_ned=(north, east, down), velocity_ned=(0.5, -0.25, 0.0), radius_m=radius)


def simulator(*objects: Sphere | Cylinder | Plane, sea_bed: SeaBed | None = None, sonar: SonarModel = SEABAT,
              **image: object) -> ImageSimulator:  # fmt: skip
    vehicle = VehiclePath(position_ned=(0.0, 0.0, 0.0))
    levels = msgspec.convert(image, ImageLevels)
    file = SceneFile(seed=1, vehicle=vehicle, objects=list(objects), sea_bed=sea_bed, image=levels, duration_s=5.0)
    return ImageSimulator(sonar, Scene(file))


def truth_of(images: ImageSimulator, t_s: float = 0.0, ping: int = 0) -> dict[str, TruthObject]:
    return {item.name: item for item in images.truth(t_s, ping)}


def test_truth_tells_what_is_in_the_sector() -> None:
    objects = ball("ahead", 50), ball("edge", 50, 52), ball("far", 110), ball("deep", 30, 0, 12)
    truth = truth_of(simulator(*objects))
    assert {name: item.in_sector for name, item in truth.items()} == {
        "ahead": True, "edge": False, "far": False, "deep": False
    }  # fmt: skip
    assert not truth_of(simulator(*objects, sonar=replace(SEABAT, samples=500)))["ahead"].in_sector
    assert (truth["far"].peak_db, truth["far"].background_db) == (0.0, 0.0)


def test_truth_moves_and_leaves_walls_out() -> None:
    wall = Plane(name="quay", position_ned=(90.0, 0.0, 0.0), normal_ned=(1.0, 0.0, 0.0))
    truth = truth_of(simulator(ball("a", 50), wall), t_s=4.0)
    assert list(truth) == ["a"]
    assert truth["a"].position_ned == (52.0, -1.0, 0.0)
    assert truth["a"].velocity_ned == (0.5, -0.25, 0.0)
    assert truth["a"].radius_m == 2.0


@pytest.mark.parametrize(("north", "east"), [(50.0, 0.0), (40.0, 37.0), (60.0, -50.0), (99.0, 0.0)])
def test_peak_is_the_highest_level_of_the_object(north: float, east: float) -> None:
    images = simulator(ball("a", north, east), noise_counts=30.0)
    truth = truth_of(images)["a"]
    assert truth.peak_db == pytest.approx(20.0 * np.log10(images.mean_image(0.0).max()), abs=0.01)
    assert 20.0 * np.log10(30.0) <= truth.background_db < 20.0 * np.log10(30.0) + 8.0


def test_background_is_the_level_of_the_sea_bed_around() -> None:
    bed = SeaBed(depth_m=4.0)
    images, bare = simulator(ball("a", 40, radius=1.0), sea_bed=bed), simulator(sea_bed=bed)
    around = np.square(bare.mean_image(0.0)[20:40, 770:830].astype(np.float64))
    truth = truth_of(images)["a"]
    assert truth.background_db == pytest.approx(10.0 * np.log10(np.median(around)), abs=1.0)
    assert 8.0 < truth.peak_db - truth.background_db < 60.0


def test_levels_have_the_gain_that_the_image_has() -> None:
    bed = SeaBed(depth_m=4.0)
    plain = truth_of(simulator(ball("a", 40), sea_bed=bed))["a"]
    belt = {"from_m": 30.0, "to_m": 50.0, "gain_db": -7.0}
    dark = truth_of(simulator(ball("a", 40), sea_bed=bed, belts=[belt], beam_gain_db=[2.0] * 60))["a"]
    assert dark.peak_db == pytest.approx(plain.peak_db - 5.0, abs=1e-3)
    assert dark.background_db == pytest.approx(plain.background_db - 5.0, abs=1e-3)
    lost = {"range_m": 40.0, "width_m": 30.0, "gain_db": -25.0, "pings": [6]}
    images = simulator(ball("a", 40), sea_bed=bed, dropouts=[lost])
    assert truth_of(images, ping=6)["a"].peak_db == pytest.approx(plain.peak_db - 25.0, abs=1e-3)
    assert truth_of(images, ping=7)["a"].peak_db == pytest.approx(plain.peak_db, abs=1e-3)


def test_levels_come_from_the_plane_that_hears_it_best() -> None:
    three = make_sonar(SonarFile(name="three", frequency_hz=455e3, beams_per_plane=60, beam_spacing_deg=1.5,
                                 beam_width_deg=1.5, plane_elevation_deg=[-15.0, 0.0, 15.0], range0_m=0.05, dr_m=0.05,
                                 samples=1000))  # fmt: skip
    images = simulator(ball("high", 30.0 * np.cos(0.26), 0.0, -30.0 * np.sin(0.26), 1.0), sonar=three)
    image = images.mean_image(0.0)
    assert truth_of(images)["high"].peak_db == pytest.approx(20.0 * np.log10(image[120:].max()), abs=0.01)


def test_an_object_that_fills_the_fan_has_a_background_too() -> None:
    for sonar in (SEABAT, make_sonar(SonarFile(name="one beam", frequency_hz=1e6, beam_width_deg=3.0, range0_m=0.05,
                                               dr_m=0.05, samples=1000))):  # fmt: skip
        truth = truth_of(simulator(ball("huge", 25, radius=20.0), sonar=sonar))["huge"]
        assert np.isfinite([truth.peak_db, truth.background_db]).all()
        assert truth.peak_db >= truth.background_db
