"""One call renders one image: a scene seen by a sonar at one time."""

import math

import numpy as np
from numpy.typing import NDArray

from ods import geometry
from ods.messages import Ping, TruthObject, Vector3
from ods.sim_sonar import bodies
from ods.sim_sonar.fan import add_object
from ods.sim_sonar.grid import Grid, grid_of
from ods.sim_sonar.plan import fan_of, rivals_of
from ods.sim_sonar.scene import Scene
from ods.sim_sonar.scene_settings import SeaBed
from ods.sim_sonar.sea_bed import FlatBed, add_bed, reflectivity_profile
from ods.sim_sonar.sonar import SonarModel
from ods.sim_sonar.speckle import amplitude_table, speckled

Array = NDArray[np.float64]
Image = NDArray[np.float32]

LOG_FACTOR = 40.0
"""Default factor F of the 8-bit log rule of s7k record 7042."""


def mean_area(
    grid: Grid,
    objects: Array,
    sea_bed: SeaBed | None,
    position_ned: Array,
    attitude: Array,
    *,
    shadows: bool = True,
    max_error: float = 0.03,
) -> Array:
    """Return the mean image, (beams, samples) float64: the area, m2, that each sample hears, weighted by eq. 5.

    A sample hears the sum of gamma(alpha) S^2(beta) B(bearing) cos(alpha) dA over the lit surfaces in its range bin, B
    being the beam's horizontal pattern. Spreading and absorption are taken as undone by the sonar's gain. `objects` are
    (n, bodies.COLUMNS) rows in NED; `attitude` is body to global.
    """
    rotation = geometry.rotation_matrix(attitude)
    bed = _bed_of(grid, sea_bed, position_ned, rotation)
    image = np.zeros((len(grid.vertical) * len(grid.bearing_rad), grid.samples))
    if bed.height_m > 0.0:
        add_bed(bed, grid, image)
    seen = bodies.to_sonar_frame(objects, position_ned, rotation)
    nobody = np.empty(0, np.int64)
    for which, rivals in enumerate(rivals_of(seen)):
        fan = fan_of(seen[which], grid, max_error)
        if len(fan.bearing):
            hiders = rivals if shadows else nobody
            add_object(image, seen, which, hiders, fan.bearing, fan.elevation, grid, bed, shadows)
    return np.maximum(image, 0.0, out=image)


def _bed_of(grid: Grid, sea_bed: SeaBed | None, position_ned: Array, rotation: Array) -> FlatBed:
    down = np.ascontiguousarray(rotation[2])
    if sea_bed is None:
        return FlatBed(down, 0.0, np.zeros(grid.samples))
    height = float(sea_bed.depth_m - position_ned[2])
    surface = sea_bed.surface
    gamma = reflectivity_profile(grid, height, surface.cd, surface.cs, math.radians(surface.sigma_deg))
    return FlatBed(down, height, gamma)


class ImageSimulator:
    """Renders the images of one scene with one sonar; the same seed gives the same bytes, in any order of calls."""

    def __init__(self, sonar: SonarModel, scene: Scene, seed: int | None = None) -> None:
        """Prepare tables; `seed` replaces the scene's own."""
        self.sonar = sonar
        self.scene = scene
        self._seed = scene.file.seed if seed is None else seed
        self._grid = grid_of(sonar)
        self._table = amplitude_table(scene.file.image.looks)

    def mean_intensity(self, t_s: float) -> Array:
        """Return the mean image at scene time `t_s`: (beams, samples) float64, counts^2, without the noise floor."""
        file = self.scene.file
        vehicle = self.scene.vehicle_at(t_s)
        area = mean_area(
            self._grid,
            self.scene.bodies_at(t_s),
            file.sea_bed,
            vehicle.position_ned,
            vehicle.attitude,
            shadows=file.shadows,
            max_error=file.image.max_error,
        )
        return np.multiply(area, file.image.gain**2, out=area)

    def mean_image(self, t_s: float) -> Image:
        """Return the image without speckle: (beams, samples) float32 root mean square amplitude, counts."""
        return np.sqrt(self.mean_intensity(t_s) + self.scene.file.image.noise_counts**2).astype(np.float32)

    def render(self, t_s: float, ping_number: int) -> Image:
        """Return the image at scene time `t_s`: (beams, samples) float32 amplitude, linear counts.

        Intensity is Gamma distributed about the mean with the scene's looks; the noise is that of (seed, ping_number).
        """
        if not self.scene.file.image.speckle:
            return self.mean_image(t_s)
        rng = np.random.Generator(np.random.SFC64([self._seed, ping_number]))
        intensity = self.mean_intensity(t_s)
        image = rng.standard_normal(intensity.shape, np.float32)
        speckled(intensity, image, self._table, self.scene.file.image.noise_counts**2, image)
        return image

    def truth(self, t_s: float) -> list[TruthObject]:
        """Return the bounded objects at scene time `t_s`."""
        states, vehicle = self.scene.objects_at(t_s), self.scene.vehicle_at(t_s)
        inside = in_sector(self.sonar, states.position_ned, states.radius_m, vehicle.position_ned, vehicle.attitude)
        return [
            TruthObject(name, _triple(place), _triple(velocity), float(radius), bool(seen))
            for name, place, velocity, radius, seen in zip(
                states.names, states.position_ned, states.velocity_ned, states.radius_m, inside, strict=True
            )
        ]


def in_sector(
    sonar: SonarModel, position_ned: Array, radius_m: Array, vehicle_ned: Array, attitude: Array
) -> NDArray[np.bool_]:
    """Tell which of (n, 3) objects are in the fan: centre in range and bearing, some of it in a main lobe."""
    distance, bearing, elevation = geometry.body_to_polar(geometry.global_to_body(position_ned, vehicle_ned, attitude))
    half_beam = 0.5 * sonar.beam_width_rad
    reach = np.arcsin(np.clip(radius_m / np.maximum(distance, 1e-9), 0.0, 1.0)) + sonar.half_vertical_rad
    return np.asarray(
        (distance >= sonar.range0_m)
        & (distance <= sonar.range_max_m)
        & (bearing >= sonar.bearing_rad.min() - half_beam)
        & (bearing <= sonar.bearing_rad.max() + half_beam)
        & (elevation <= sonar.elevation_rad.max() + reach)
        & (elevation >= sonar.elevation_rad.min() - reach)
    )


def quantize_log8(amplitude: Image, factor: float = LOG_FACTOR) -> NDArray[np.uint8]:
    """Return a = factor * log10(amplitude), rounded, 0 under 1 count, at most 255: record 7042's rule, uint8."""
    levels = np.log10(np.maximum(amplitude, np.float32(1.0)))
    levels *= np.float32(factor)
    return np.minimum(np.rint(levels, out=levels), 255.0, out=levels).astype(np.uint8)


def make_ping(image: Image, sonar: SonarModel, ping_number: int, t_ns: int, utc_ns: int) -> Ping:
    """Return `image`, linear counts (beams, samples), as a ping of 8-bit log samples; t_ns is its transmit time."""
    return Ping(
        seq=ping_number,
        ping_number=ping_number,
        t_ns=t_ns,
        t_rx_ns=t_ns,
        utc_ns=utc_ns,
        beams=sonar.beams,
        samples=sonar.samples,
        dtype="u1",
        data=quantize_log8(image).tobytes(),
        bearing_rad=sonar.bearing_rad.tolist(),
        range0_m=sonar.range0_m,
        dr_m=sonar.dr_m,
        sound_speed=sonar.sound_speed,
        elevation_rad=sonar.elevation_rad.tolist(),
        beam_width_rad=[sonar.beam_width_rad] * sonar.beams,
        planes=sonar.planes,
        frequency_hz=sonar.frequency_hz,
        scale="log8",
        scale_factor=LOG_FACTOR,
    )


def _triple(vector: Array) -> Vector3:
    return float(vector[0]), float(vector[1]), float(vector[2])
