"""Spheres over sea-beds of the simulator, drawn at random, and what the default chain finds of them.

Over a rough bed the levels of detection rise with its crests, so less of a body shows than over speckle. No bed is one
of config/scenes/sea.
"""

from collections.abc import Iterator

import msgspec
import numpy as np

from benchmarks.circles.heard_echoes import Seen, received
from benchmarks.circles.synthetic import Case, Look
from ods.assess.sea.run import head_at
from ods.base.arrays import Floats
from ods.base.frames.geometry import body_to_polar, global_to_body
from ods.messages import Detections, Truth
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseEstimate
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.shots import shot_at

SONAR_NAME = "seabat6012"
DOWN_M = 20.0
"""Of the sonar."""
RADII_M, RANGES_M, ALTITUDES_M = (0.5, 3.0), (12.0, 92.0), (2.0, 10.0)
"""Radii are drawn by their logarithms."""
SHARES_BACK = (0.02, 0.4)
"""`cd` of the spheres, by its logarithm; `cs` is half of it."""
CORRELATION_M, HEIGHT_M, MOST_SLOPE = (0.5, 4.0), (0.04, 0.3), 0.17
"""Of the beds' heights, by their logarithms; rms height over correlation length is at most the last one."""
WIDEST, BELOW, ABOVE, APART = np.radians(38.0), np.radians(8.0), np.radians(6.0), np.radians(5.0)
"""Bearings and elevations of spheres from the fan's middle, and bearings between two of them."""
SPHERES, TRIES = 6, 60
PINGS, SECONDS = 8, 20.0
"""Of a scene, anywhere in so many seconds."""
BEFORE_M, BESIDE_M = 1.0, 3.0
"""An echo is of a sphere when its near edge is so near to the sphere's, and its middle so near to its circle."""


def _by_logarithm(rng: np.random.Generator, limits: tuple[float, float]) -> float:
    return float(np.exp(rng.uniform(*np.log(limits))))


def scene_drawn(rng: np.random.Generator) -> Scene:
    """Return a bed, plain or on a slope, with spheres on it and over it."""
    altitude, slope, heading = rng.uniform(*ALTITUDES_M), max(rng.uniform(-4.0, 4.0), 0.0), rng.uniform(0.0, 360.0)
    correlation = _by_logarithm(rng, CORRELATION_M)
    height = min(_by_logarithm(rng, HEIGHT_M), MOST_SLOPE * correlation)
    falls = np.tan(np.radians(slope)) * np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading))])
    table = {
        "seed": int(rng.integers(1 << 30)),
        "duration_s": SECONDS,
        "vehicle": {
            "position_ned": [0.0, 0.0, DOWN_M],
            "velocity_ned": [rng.uniform(0.0, 0.1), 0.0, 0.0],
            "yaw": {"amplitude_deg": 3.0, "period_s": SECONDS},
            "pitch": {"amplitude_deg": float(rng.choice([0.0, 1.5])), "period_s": 7.0},
        },
        "objects": _spheres(rng, DOWN_M + altitude, falls),
        "sea_bed": {
            "depth_m": DOWN_M + altitude,
            "slope_deg": slope,
            "slope_heading_deg": heading,
            "rough": {"rms_height_m": height, "correlation_m": correlation},
            "surface": {"cd": 0.5, "cs": 0.2, "sigma_deg": 20.0},
        },
        "image": {"range_correlation": 0.2, "beam_gain_rms_db": 0.5},
    }
    return Scene(msgspec.convert(table, SceneFile))


def _spheres(rng: np.random.Generator, depth_m: float, falls: Floats) -> list[dict[str, object]]:
    """Draw spheres that the fan sees, each in other beams; falls: how much deeper the bed is a metre north, east."""
    spheres: list[dict[str, object]] = []
    bearings: list[float] = []
    for _ in range(TRIES):
        range_m, bearing, radius = rng.uniform(*RANGES_M), rng.uniform(-WIDEST, WIDEST), _by_logarithm(rng, RADII_M)
        place = range_m * np.array([np.cos(bearing), np.sin(bearing)])
        bottom, share = depth_m + falls @ place, _by_logarithm(rng, SHARES_BACK)
        lowest = min(bottom + 0.5 * radius, DOWN_M + range_m * np.tan(BELOW))
        down = rng.uniform(min(DOWN_M - range_m * np.tan(ABOVE), lowest), lowest)
        if bottom < DOWN_M + 1.0 or any(abs(bearing - other) < APART for other in bearings):
            continue
        bearings.append(bearing)
        surface = {"cd": share, "cs": 0.5 * share, "sigma_deg": 15.0}
        at = {"position_ned": [*place.tolist(), down], "radius_m": radius, "surface": surface}
        spheres.append({"shape": "sphere", "name": f"sphere {len(spheres)}", **at})
        if len(spheres) == SPHERES:
            break
    return spheres


def seen_over_beds(rng: np.random.Generator, scenes: int) -> Iterator[Seen]:
    """Look at spheres over so many beds, PINGS times each; those that are not found are left out."""
    sonar = find_sonar(SONAR_NAME)
    with received() as reported:
        for _ in range(scenes):
            scene, chain = scene_drawn(rng), Chain(PipelineSettings())
            images = ImageSimulator(sonar, scene)
            for number in np.sort(rng.choice(int(SECONDS / sonar.ping_period_s), PINGS, replace=False)):
                reported.forget()
                ping, truth = shot_at(images, int(number))
                head = head_at(scene, ping.t_ns)
                for look in looks_at(truth, head, chain.process(ping, pose=head)):
                    assert look.found
                    yield reported.seen(look, look.found)


def looks_at(truth: Truth, head: PoseEstimate, found: Detections) -> Iterator[Look]:
    """Yield the spheres of which there are echoes that the fan's edge does not cut off, with the loudest of each."""
    for body in truth.objects:
        offset = global_to_body(np.array([body.position_ned]), head.position_ned, head.attitude)
        range_m, bearing = (float(value[0]) for value in body_to_polar(offset)[:2])
        near_m, beside = range_m - body.radius_m, body.radius_m + BESIDE_M
        its = [
            d for d in found.detections
            if not d.cut and abs(d.near_m - near_m) < BEFORE_M and abs(d.bearing_rad - bearing) * range_m < beside
        ]  # fmt: skip
        if its:
            case = Case("front", body.radius_m, range_m, float("nan"))
            yield Look(case, bearing, near_m, max(its, key=lambda d: d.snr_db))
