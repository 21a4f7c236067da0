"""Simulated images of an obstacle-avoidance sonar, with truth: [SSIE]'s imperfections in every mixture.

Spheres of 0.3 to 6 m at 10 to 95 m over a flat or a rough bottom, signal to noise ratio -3 to 20 dB, with drop-outs,
belts where the gain is wrong, uneven beams and correlated speckle.
"""

import math

import numpy as np

from ods.assess.images.labelled import LabelledImage, Target, circle_target
from ods.base.files.shipped import shipped_file
from ods.base.frames import geometry
from ods.messages import TruthObject
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.receiver.settings import Belt, DropIn, Dropout, ImageLevels
from ods.sim_sonar.scene.settings import Cylinder, Plane, SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene, VehicleState
from ods.sim_sonar.sea_bed.settings import Roughness, SeaBed
from ods.sim_sonar.sonar.model import SonarModel, load_sonar

SEA_SONAR = "sonars/seabat6012.toml"
VEHICLE_DEPTH_M = 20.0
"""Of the vehicle; the bottom is 3 to 6 m below."""
OBJECTS = 6
RADII_M = (0.3, 6.0)
RANGES_M = (10.0, 95.0)
WITHIN_RAD = math.radians(40.0)
SNR_DB = (-3.0, 20.0)
"""Objects outside of that neither count as targets nor as false alarms."""
REFLECTION = (1e-3, 1.0)
"""Diffuse and specular share of the objects' surfaces, drawn evenly over their logarithm."""
MARGIN_M = 1.0
MARGIN_BEAMS = 1.0


def sea_images(count: int, seed: int) -> list[LabelledImage]:
    """Return `count` images of as many scenes; the same seed gives the same bytes. Raises ConfigError."""
    sonar = load_sonar(shipped_file(SEA_SONAR))
    return [_sea_image(sonar, np.random.default_rng([seed, index]), index) for index in range(count)]


def _sea_image(sonar: SonarModel, rng: np.random.Generator, index: int) -> LabelledImage:
    return labelled_image(ImageSimulator(sonar, Scene(_scene_file(rng))), 0.0, index)


def labelled_image(
    images: ImageSimulator, t_s: float, number: int, counts_db: tuple[float, float] = SNR_DB
) -> LabelledImage:
    """Return image `number` of a scene, taken at `t_s`, with the truth and without speckle, too.

    counts_db: signal to noise ratios of the objects that count as targets.
    """
    vehicle = images.scene.vehicle_at(t_s)
    seen = [item for item in images.truth(t_s, number) if item.in_sector]
    targets = [_target(images.sonar, vehicle, item, counts_db) for item in seen]
    return LabelledImage(images.ping(t_s, number, 0, 0), targets, images.mean_image(t_s, number))


def snr_db(peak_db: float, background_db: float) -> float:
    """Return the signal to noise ratio of an echo whose level, noise included, is `peak_db` over `background_db`."""
    return 10.0 * math.log10(max(10.0 ** ((peak_db - background_db) / 10.0) - 1.0, 1e-9))


def _target(sonar: SonarModel, vehicle: VehicleState, item: TruthObject, counts_db: tuple[float, float]) -> Target:
    place = np.array([item.position_ned])
    distance, bearing, _ = geometry.body_to_polar(
        geometry.global_to_body(place, vehicle.position_ned, vehicle.attitude)
    )
    counts = counts_db[0] <= snr_db(item.peak_db, item.background_db) <= counts_db[1]
    margin = MARGIN_BEAMS * sonar.beam_width_rad
    return circle_target(float(distance[0]), float(bearing[0]), item.radius_m, MARGIN_M, margin, counts=counts)


def _scene_file(rng: np.random.Generator) -> SceneFile:
    altitude = float(rng.uniform(3.0, 6.0))
    rough = Roughness(rms_height_m=0.15, correlation_m=2.0, facets=128) if rng.random() < 0.5 else None
    return SceneFile(
        seed=int(rng.integers(2**31)),
        duration_s=0.25,
        shadows=False,
        vehicle=VehiclePath(position_ned=(0.0, 0.0, VEHICLE_DEPTH_M)),
        objects=_objects(rng),
        sea_bed=SeaBed(
            depth_m=VEHICLE_DEPTH_M + altitude, rough=rough, surface=Surface(cd=float(rng.uniform(0.1, 0.5)), cs=0.2)
        ),
        image=_levels(rng),
    )


def _objects(rng: np.random.Generator) -> list[Sphere | Cylinder | Plane]:
    """Return spheres that do not touch, by rejection."""
    chosen: list[tuple[float, float, float]] = []
    spheres: list[Sphere | Cylinder | Plane] = []
    while len(spheres) < OBJECTS:
        radius = float(np.exp(rng.uniform(*np.log(RADII_M))))
        distance, bearing = float(rng.uniform(*RANGES_M)), float(rng.uniform(-WITHIN_RAD, WITHIN_RAD))
        x, y = distance * math.cos(bearing), distance * math.sin(bearing)
        if distance < radius + 5.0 or any(math.hypot(x - a, y - b) < radius + r + 4.0 for a, b, r in chosen):
            continue
        chosen.append((x, y, radius))
        share = float(np.exp(rng.uniform(*np.log(REFLECTION))))
        spheres.append(
            Sphere(
                name=str(len(spheres)),
                position_ned=(x, y, VEHICLE_DEPTH_M),
                radius_m=radius,
                surface=Surface(cd=share, cs=share),
            )
        )
    return spheres


def _levels(rng: np.random.Generator) -> ImageLevels:
    belts = [
        Belt(
            from_m=begin, to_m=begin + float(rng.uniform(5.0, 12.0)), gain_db=float(rng.uniform(-5.0, 5.0)), edge_m=2.0
        )
        for begin in rng.uniform(25.0, 80.0, 2).tolist()
    ]
    return ImageLevels(
        looks=1.0,
        range_correlation=0.2,
        beam_gain_rms_db=0.5,
        belts=belts,
        dropouts=[Dropout(width_m=0.6, gain_db=-20.0, chance=0.5), Dropout(width_m=0.5, gain_db=-12.0, chance=0.5)],
        drop_ins=[DropIn(width_m=0.4, gain_db=8.0, chance=0.2)],
    )
