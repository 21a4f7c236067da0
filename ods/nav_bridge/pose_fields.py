"""The pose fields that a source of any kind fills, by name, and the pose made of them."""

import math
from collections import Counter
from collections.abc import Collection, Mapping
from typing import NamedTuple

from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.frames.quaternion import conjugate, from_euler, product, rotated
from ods.base.geodesy import LocalFrame
from ods.messages import Pose, Quaternion, Vector3
from ods.nav_bridge.altitude import AltitudeCheck, ReportedAltitude
from ods.nav_bridge.clocks.utc import Utc
from ods.nav_bridge.settings import LimitSettings, SigmaSettings

PLACES = ("north", "east", "down"), ("latitude", "longitude", "altitude")
"""From the site's origin; or on WGS 84, and above the site's datum."""
ATTITUDES = ("roll", "pitch", "yaw"), ("qw", "qx", "qy", "qz")
"""Body to north, east, down where the vehicle is: z-y-x; or a quaternion."""
VELOCITIES = ("u", "v", "w"), ("velocity_north", "velocity_east", "velocity_down")
"""Body (FRD), or north, east, down where the vehicle is."""
PLACE_SIGMAS = ("sigma_north", "sigma_east", "sigma_down"), ("sigma_horizontal", "sigma_down")
"""May be left out: then those of the settings hold."""
ATTITUDE_SIGMAS = ("sigma_roll", "sigma_pitch", "sigma_yaw"), ("sigma_tilt", "sigma_yaw")
"""May be left out."""
OVER_BOTTOM, SIGMA_OVER_BOTTOM = "over_bottom", "sigma_over_bottom"
"""Height over the bottom right below: the `altitude_m` of a pose."""
OPTIONAL = frozenset({OVER_BOTTOM, SIGMA_OVER_BOTTOM})
"""A pose is as good without them: they are left out of it when they are not there, too old or not believed."""
UNITS: dict[str, str] = {
    **{name: "m" for names in (*PLACES, *PLACE_SIGMAS) for name in names},
    **{name: "rad" for names in (ATTITUDES[0], *ATTITUDE_SIGMAS) for name in names},
    **{name: "m/s" for names in VELOCITIES for name in names},
    **dict.fromkeys(ATTITUDES[1], ""),
    **dict.fromkeys(("latitude", "longitude"), "deg"),
    **dict.fromkeys((OVER_BOTTOM, SIGMA_OVER_BOTTOM), "m"),
}
"""Every pose field and its unit."""
LARGEST_VALUE = 1e9
"""Larger than any field in any unit; computing with it is safe."""
LARGEST_SIGMA = {"m": 1e7, "rad": 1e3}
"""A `Pose` carries no more, by unit."""
ANGLE_SLACK_RAD = 1e-3
"""For a right angle that was rounded up."""
NORM_SLACK = 0.02
"""Largest deviation of a quaternion's length from 1."""


class Age(NamedTuple):
    """How old a field is at the pose's instant."""

    seconds: float
    growth: float
    """Of its standard deviation, a second: m or rad."""
    sigma: float = 0.0
    """Added to its standard deviation."""


NO_AGES: Mapping[str, Age] = {}


class PoseMaker:
    """Makes a `Pose` of each believable set of fields. Counts `epoch_absurd` (out of range), `epoch_late`, and what
    `AltitudeCheck` counts (left out of a pose that is good otherwise)."""

    def __init__(
        self,
        fields: Collection[str],
        frame: LocalFrame,
        limits: LimitSettings,
        sigmas: SigmaSettings,
        utc: Utc,
        counters: Counter[str],
    ) -> None:
        """Choose by the names that will come. Raises OdsError when they do not make a pose, or one is left over."""
        self._frame, self._limits, self._sigmas = frame, limits, sigmas
        self._utc, self._counters = utc, counters
        self._altitudes = AltitudeCheck(limits.altitude_m, counters)
        self._poses = 0
        self._place = _needed(PLACES, fields)
        self._attitude = _needed(ATTITUDES, fields)
        self._velocity = _needed(VELOCITIES, fields)
        self._place_sigmas = _choice(PLACE_SIGMAS, fields)
        self._attitude_sigmas = _choice(ATTITUDE_SIGMAS, fields)
        self._reported_sigmas = (*self._place_sigmas, *self._attitude_sigmas)
        self._used = (*self._place, *self._attitude, *self._velocity, *self._reported_sigmas)
        for name in sorted(fields):
            if name == SIGMA_OVER_BOTTOM and OVER_BOTTOM not in fields:
                raise OdsError(f"{name}: needs {OVER_BOTTOM} too")
            if name in UNITS.keys() - OPTIONAL and name not in self._used:
                raise OdsError(f"{name}: {_lacking(name, fields) or 'not used beside ' + ', '.join(self._used)}")
        self.disbelief = ""
        """Why the newest pose was dropped, in plain words; "" while it was not."""

    def make(
        self, values: Mapping[str, float], t_ns: int, arrival_ns: int, ages: Mapping[str, Age] = NO_AGES
    ) -> Pose | None:
        """Return the pose of the instant `t_ns`, None when it is not believable or too old.

        `ages`: of fields older than that. A position is extrapolated by the velocity; standard deviations grow.
        """
        found = self._believable(values)
        if isinstance(found, str):
            self._counters["epoch_absurd"] += 1
            self.disbelief = f"poses are dropped: {found}"
            return None
        age_s = (arrival_ns - t_ns) / NS
        if age_s > self._limits.age_s:
            self._counters["epoch_late"] += 1
            self.disbelief = f"poses are dropped: {age_s:.2f} s old, nav.limits.age_s is {self._limits.age_s:g}"
            return None
        self.disbelief = ""
        place, attitude, velocity = found
        utc_ns, utc_source = self._utc.at(t_ns)
        attitude = product(self._turn_at(values, place), attitude)
        position = self._carried(place, velocity, attitude, ages) if ages else place
        altitude, sigma_altitude = self._altitude(values, t_ns, position[2], rotated(attitude, velocity)[2], ages)
        pose = Pose(
            seq=self._poses,
            t_ns=t_ns,
            utc_ns=utc_ns,
            position_ned=position,
            attitude=attitude,
            velocity_body=velocity,
            sigma_position_ned=_grown(_spread(values, self._place_sigmas, self._sigmas.position_m), self._place, ages),
            sigma_attitude=_grown(
                _spread(values, self._attitude_sigmas, self._sigmas.attitude_rad), self._attitude, ages
            ),
            utc_source=utc_source,
            altitude_m=altitude,
            sigma_altitude_m=sigma_altitude,
        )
        self._poses += 1
        return pose

    def _altitude(
        self, values: Mapping[str, float], t_ns: int, down: float, sinking: float, ages: Mapping[str, Age]
    ) -> tuple[float | None, float]:
        """Return the altitude over the bottom at the pose's instant, None when there is none, and its deviation."""
        reported, sigma = values.get(OVER_BOTTOM), values.get(SIGMA_OVER_BOTTOM, self._sigmas.altitude_m)
        if reported is None:
            return None, 0.0
        age = ages.get(OVER_BOTTOM, Age(0.0, 0.0))
        sunk = age.seconds * sinking
        then = ReportedAltitude(reported, t_ns - round(age.seconds * NS), down - sunk)
        if not self._altitudes.is_plausible(reported - sunk, sigma, then):
            return None, 0.0
        return reported - sunk, math.hypot(sigma, _added(age))

    def _carried(self, place: Vector3, velocity: Vector3, attitude: Quaternion, ages: Mapping[str, Age]) -> Vector3:
        """Return the place at the pose's instant, each coordinate from its own."""
        seconds = (ages[name].seconds if name in ages else 0.0 for name in self._place)
        ways = zip(place, seconds, rotated(attitude, velocity), strict=True)
        north, east, down = (start + time_s * speed for start, time_s, speed in ways)
        return north, east, down

    def _believable(self, values: Mapping[str, float]) -> tuple[Vector3, Quaternion, Vector3] | str:
        """Return position, attitude as reported and body velocity, or why no vehicle has them."""
        for name in self._used:
            if not abs(values[name]) < LARGEST_VALUE:  # written so that NaN fails
                return f"{name} is {values[name]:g}"
        negative = [name for name in self._reported_sigmas if values[name] < 0.0]
        if negative:
            return f"{negative[0]} is {values[negative[0]]:g}, below 0"
        for name in self._reported_sigmas:
            unit = UNITS[name]
            if values[name] > LARGEST_SIGMA[unit]:
                return f"{name} is {values[name]:g} {unit}, more than {LARGEST_SIGMA[unit]:g}"
        attitude, place = self._attitude_of(values), self._place_of(values)
        if attitude is None:
            angles = ", ".join(f"{name} {values[name]:.4g}" for name in self._attitude)
            return f"{angles} is not an attitude: angles must be in rad, a quaternion must have length 1"
        if place is None:
            return f"latitude {values['latitude']:.6g}, longitude {values['longitude']:.6g} deg are not a position"
        velocity = self._velocity_of(values, attitude)
        return self._beyond(place, velocity) or (place, attitude, velocity)

    def _beyond(self, place: Vector3, velocity: Vector3) -> str:
        """Return which limit position or velocity is beyond, "" where none."""
        limits, (north, east, down) = self._limits, place
        for name, value, key, limit in (
            ("north", abs(north), "horizontal_m", limits.horizontal_m),
            ("east", abs(east), "horizontal_m", limits.horizontal_m),
            ("height", -down, "height_m", limits.height_m),
            ("depth", down, "depth_m", limits.depth_m),
        ):
            if value > limit:
                return f"{name} is {value:.1f} m from the site's origin, nav.limits.{key} is {limit:g}"
        fastest = max(map(abs, velocity))
        if fastest > limits.speed:
            return f"the speed along a body axis is {fastest:.1f} m/s, nav.limits.speed is {limits.speed:g}"
        return ""

    def _place_of(self, values: Mapping[str, float]) -> Vector3 | None:
        first, second, third = (values[name] for name in self._place)
        if self._place == PLACES[0]:
            return first, second, third
        if abs(first) > 90.0 or abs(second) > 360.0:
            return None
        north, east, down = self._frame.ned(first, second, third).tolist()
        return north, east, down

    def _turn_at(self, values: Mapping[str, float], place: Vector3) -> Quaternion:
        """Return the turn from north, east, down where the vehicle is to those of the site: meridians converge."""
        if self._place == PLACES[0]:
            return self._frame.turn_at(place)
        return self._frame.turn(values["latitude"], values["longitude"])

    def _attitude_of(self, values: Mapping[str, float]) -> Quaternion | None:
        parts = [values[name] for name in self._attitude]
        if self._attitude == ATTITUDES[1]:
            norm = math.hypot(*parts)
            if abs(norm - 1.0) > NORM_SLACK:
                return None
            w, x, y, z = (part / norm for part in parts)
        else:
            turns = math.pi, 0.5 * math.pi, 2.0 * math.pi
            if any(abs(angle) > turn + ANGLE_SLACK_RAD for angle, turn in zip(parts, turns, strict=True)):
                return None
            w, x, y, z = from_euler(*parts)
        return w, x, y, z

    def _velocity_of(self, values: Mapping[str, float], attitude: Quaternion) -> Vector3:
        first, second, third = (values[name] for name in self._velocity)
        if self._velocity == VELOCITIES[0]:
            return first, second, third
        return rotated(conjugate(attitude), (first, second, third))


def _choice(group: tuple[tuple[str, ...], ...], fields: Collection[str]) -> tuple[str, ...]:
    """Return the first alternative of which all names are there; () when there is none."""
    return next((names for names in group if all(name in fields for name in names)), ())


def _lacking(name: str, fields: Collection[str]) -> str:
    """Return what a field without a choice also needs, "" when an alternative is there already."""
    for group in (PLACES, ATTITUDES, VELOCITIES, PLACE_SIGMAS, ATTITUDE_SIGMAS):
        ways = [way for way in group if name in way]
        if ways and not _choice(group, fields):
            missing = (", ".join(other for other in way if other not in fields) for way in ways)
            return f"needs {' or '.join(missing)} beside it"
    return ""


def _needed(group: tuple[tuple[str, ...], ...], fields: Collection[str]) -> tuple[str, ...]:
    found = _choice(group, fields)
    if not found:
        raise OdsError("a pose needs " + " or ".join(", ".join(names) for names in group))
    return found


def _spread(values: Mapping[str, float], names: tuple[str, ...], default: float) -> Vector3:
    """Return three standard deviations of three, two (the first counts twice) or no fields."""
    sigmas = [values[name] for name in names] or [default]
    return sigmas[0], sigmas[-2] if len(sigmas) > 1 else sigmas[0], sigmas[-1]


def _added(age: Age) -> float:
    return math.hypot(age.seconds * age.growth, age.sigma)


def _grown(sigmas: Vector3, names: tuple[str, ...], ages: Mapping[str, Age]) -> Vector3:
    """Return standard deviations of three fields, or of the angles of a quaternion's four, grown with their ages."""
    if not ages:
        return sigmas
    added = [_added(ages[name]) if name in ages else 0.0 for name in names]
    if len(added) > len(sigmas):
        added = [max(added)] * len(sigmas)
    first, second, third = (math.hypot(sigma, more) for sigma, more in zip(sigmas, added, strict=True))
    return first, second, third
