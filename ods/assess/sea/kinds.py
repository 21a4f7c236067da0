"""The kinds of scene beyond sea-beds: other sonars, hovering, other sonars' sound, second ways, many bodies, poses.

Each is a scene of the family with something changed, and what is wanted of the lists.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import msgspec
import numpy as np

from ods.base.choices import none_of
from ods.base.errors import OdsError
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.receiver.settings import ImageLevels, Interference, SecondWay
from ods.sim_sonar.scene.settings import Cylinder, Oscillation, Plane, SceneFile, Sphere, VehiclePath

Change = Callable[[SceneFile], SceneFile]

ON_TIME = "false <= 1; objects in 95 % of the lists, within 1 s"
NO_SOUND = "no false; interference is said"
UNSEEN = "no false; the bearing is unseen, said within 1 s"
MARKED = "no false that is not marked as multipath"
COVERED = "each object within 3 s"

SOURCES_NED = (120.0, 25.0, 20.0), (110.0, -40.0, 20.0)
"""Where other sonars are, m: ahead of the vehicle, to starboard and to port."""
PULSE_COUNTS, SPOKE_FROM_S, WAY_LONGER_M = 1000.0, 10.0, 6.0
ROWS, COLUMNS, APART_M, NEAREST_M = 5, 8, 5.0, 35.0
SPHERE_RADIUS_M, BODY = 0.5, Surface(cd=0.5, cs=0.25, sigma_deg=15.0)
BOULDERS, BOULDER_RADII_M, BOULDERS_FROM_TO_M, BOULDERS_ASIDE = 45, (0.2, 1.5), (15.0, 95.0), 0.75
"""How many, how large, how far ahead, and within which bearing, rad."""
STONE = Surface(cd=0.3, cs=0.1, sigma_deg=15.0)
QUAY_EAST_M, QUAY_LONG_M, QUAY_HIGH_M = 12.0, 110.0, 12.0
PILES, PILES_EAST_M, PILES_APART_M, FIRST_PILE_M, PILE_RADIUS_M = 12, 8.0, 7.0, 15.0, 0.35
DOWN_M, SPEED = 20.0, 0.5
"""Of vehicle and many spheres, and the vehicle's speed towards them, m/s."""


class PoseNoise(NamedTuple):
    """Standard deviations of the white noise of the reported poses; they are reported, too."""

    position_m: float = 0.0
    """North, east and down."""
    yaw_deg: float = 0.0
    tilt_deg: float = 0.0
    """Roll and pitch."""


def unchanged(file: SceneFile) -> SceneFile:
    """Return the scene as it is."""
    return file


class Kind(NamedTuple):
    """One row of the table."""

    name: str
    scene: str
    """Of the family."""
    wanted: str
    change: Change = unchanged
    sonar: str = ""
    """Empty: the one of the trial."""
    noise: PoseNoise | None = None
    """None: poses are true."""


def with_levels(file: SceneFile, **levels: object) -> SceneFile:
    """Return a scene with some of `image` changed."""
    return msgspec.structs.replace(file, image=msgspec.structs.replace(file.image, **levels))


def hovering(file: SceneFile) -> SceneFile:
    """Return a scene whose vehicle does not move at all: its speckle stands still."""
    rest = Oscillation()
    vehicle = msgspec.structs.replace(file.vehicle, velocity_ned=(0.0, 0.0, 0.0), roll=rest, pitch=rest, yaw=rest)
    return msgspec.structs.replace(file, vehicle=vehicle)


def pulses(file: SceneFile, periods_s: Sequence[float]) -> SceneFile:
    """Return a scene with other sonars that send at their own rates."""
    places = zip(SOURCES_NED, periods_s, strict=False)
    sources = [Interference(position_ned=place, level_counts=PULSE_COUNTS, period_s=s) for place, s in places]
    return with_levels(file, interference=sources)


def spoke(file: SceneFile, level_counts: float) -> SceneFile:
    """Return a scene with a source that sounds without end from `SPOKE_FROM_S` on."""
    source = Interference(position_ned=SOURCES_NED[0], level_counts=level_counts, from_s=SPOKE_FROM_S)
    return with_levels(file, interference=[source])


def second_way(file: SceneFile, gain_db: float) -> SceneFile:
    """Return a scene in which each echo arrives a second time, farther away."""
    return with_levels(file, second_ways=[SecondWay(longer_m=WAY_LONGER_M, gain_db=gain_db)])


def spheres(file: SceneFile, *, over_bed: bool) -> SceneFile:
    """Return a scene with 40 spheres, 5 m apart, at the vehicle's depth and nothing else, over its bed or over none."""
    middle = 0.5 * (COLUMNS - 1)
    bodies = [
        Sphere(
            name=f"{row}{column}",
            position_ned=(NEAREST_M + APART_M * row, APART_M * (column - middle), DOWN_M),
            radius_m=SPHERE_RADIUS_M,
            surface=BODY,
        )
        for row in range(ROWS)
        for column in range(COLUMNS)
    ]
    vehicle = VehiclePath(position_ned=(0.0, 0.0, DOWN_M), velocity_ned=(SPEED, 0.0, 0.0))
    bed = file.sea_bed if over_bed else None
    image = file.image if over_bed else ImageLevels()
    return msgspec.structs.replace(file, vehicle=vehicle, objects=bodies, sea_bed=bed, image=image)


def boulders(file: SceneFile) -> SceneFile:
    """Return a scene with boulders of many sizes, half sunk, and nothing else; the same in all seeds."""
    rng, bottom_m = np.random.default_rng(1), DOWN_M if file.sea_bed is None else file.sea_bed.depth_m
    bodies = []
    for number in range(BOULDERS):
        radius_m = float(np.exp(rng.uniform(*np.log(BOULDER_RADII_M))))
        bearing, away_m = rng.uniform(-BOULDERS_ASIDE, BOULDERS_ASIDE), rng.uniform(*BOULDERS_FROM_TO_M)
        place = float(away_m * np.cos(bearing)), float(away_m * np.sin(bearing)), bottom_m - 0.5 * radius_m
        bodies.append(Sphere(name=f"boulder {number}", position_ned=place, radius_m=radius_m, surface=STONE))
    return msgspec.structs.replace(file, objects=bodies)


def quay(file: SceneFile) -> SceneFile:
    """Return a scene with a wall along the course, to starboard, and a row of piles before it."""
    middle = 0.5 * QUAY_LONG_M, QUAY_EAST_M, DOWN_M
    wall = Plane(name="quay", position_ned=middle, normal_ned=(0.0, -1.0, 0.0), width_m=QUAY_LONG_M,
                 height_m=QUAY_HIGH_M, surface=STONE)  # fmt: skip
    piles = [
        Cylinder(
            name=f"pile {number}",
            position_ned=(FIRST_PILE_M + PILES_APART_M * number, PILES_EAST_M, DOWN_M),
            radius_m=PILE_RADIUS_M,
            length_m=QUAY_HIGH_M,
            surface=STONE,
        )
        for number in range(PILES)
    ]
    return msgspec.structs.replace(file, objects=[wall, *piles])


def _sonar(name: str, *scenes: str) -> list[Kind]:
    return [Kind(f"{name} {scene}", scene, ON_TIME, sonar=name) for scene in scenes]


KINDS = [
    *_sonar("oculus_m750d", "rocky", "ripples"),
    *_sonar("multibeam512", "rocky", "ripples"),
    *_sonar("seabat6012_3plane", "rocky", "ripples", "slope"),
    *[Kind(f"hovering {scene}", scene, "no false; NEES <= 2.5", hovering) for scene in ("gentle", "rocky")],
    *[Kind(f"pulses {s:g} s", "gentle", NO_SOUND, partial(pulses, periods_s=(s,))) for s in (0.0371, 0.1, 0.149)],
    Kind("pulses of two", "gentle", NO_SOUND, partial(pulses, periods_s=(0.0371, 0.1))),
    *[Kind(f"spoke {c:g}", "gentle", UNSEEN, partial(spoke, level_counts=c)) for c in (1000.0, 3000.0)],
    *[Kind(f"second way {g:g} dB", "gentle", MARKED, partial(second_way, gain_db=g)) for g in (-12.0, -20.0)],
    Kind("40 spheres", "gentle", COVERED, partial(spheres, over_bed=False)),
    Kind("40 spheres, rocky", "rocky", COVERED, partial(spheres, over_bed=True)),
    Kind("boulders", "gentle", ON_TIME, boulders),
    Kind("boulders, 3 planes", "gentle", ON_TIME, boulders, sonar="seabat6012_3plane"),
    Kind("quay", "gentle", ON_TIME, quay),
    Kind("pose noise", "gentle", "NEES 0.5 to 2", noise=PoseNoise(0.1, 0.5, 0.2)),
]


def kinds_named(names: Sequence[str]) -> list[Kind]:
    """Return the kinds of these names, or all for none. Raises OdsError for an unknown name."""
    known = {kind.name: kind for kind in KINDS}
    for name in names:
        if name not in known:
            raise OdsError(f"--kinds: {none_of(name, sorted(known))}")
    return [known[name] for name in names or known]
