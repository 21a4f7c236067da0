"""Detections and poses of a vehicle near a fixed object, by geometry of this file's own."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ods.base.clock import NS
from ods.messages import Detection, Detections, Sector

Array = NDArray[np.float64]
Course = Callable[[float], tuple[Array, Rotation]]
"""Place and attitude of the vehicle at a time in s."""
OBJECT = np.array([40.0, 10.0, 14.0])
SOUND = 1480.0
SECTOR = Sector(1.0, 100.0, -math.pi / 4, math.pi / 4, 0.175)
PING_S, SECONDS = 0.2, 60.0
SIGMA_RANGE, SIGMA_BEARING = 0.05, math.radians(0.3)
NEARER_M = 0.2


class Sonar(NamedTuple):
    """As it really is."""

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw_deg: float = 2.0
    pitch_deg: float = -3.0
    late_s: float = 0.04
    """Its pings are said to be sent so much too late."""

    def head(self, t_s: float, course: Course) -> tuple[Array, Rotation]:
        place, body = course(t_s)
        turn = Rotation.from_euler("ZYX", [self.yaw_deg, self.pitch_deg, 0.0], degrees=True)
        return place + body.apply(self.position), body * turn


def around(t_s: float) -> tuple[Array, Rotation]:
    """Go once round the object, bow near to it, swinging on all axes, higher and lower."""
    round_rad = 2.0 * math.pi * t_s / SECONDS
    away = 30.0 + 10.0 * math.sin(0.21 * t_s)
    way = np.array([-away * math.cos(round_rad), -away * math.sin(round_rad), -1.0 + 5.0 * math.sin(0.13 * t_s)])
    yaw = round_rad + math.radians(30.0) * math.sin(0.5 * t_s)
    pitch, roll = math.radians(4.0) * math.sin(0.9 * t_s), math.radians(4.0) * math.sin(0.7 * t_s)
    return OBJECT + way, Rotation.from_euler("ZYX", [yaw, pitch, roll])


def level_around(t_s: float) -> tuple[Array, Rotation]:
    """Go round it level, and at its depth."""
    place, turn = around(t_s)
    return np.array([place[0], place[1], OBJECT[2]]), Rotation.from_euler("Z", turn.as_euler("ZYX")[0])


def past(t_s: float) -> tuple[Array, Rotation]:
    """Pass it straight on one heading."""
    return OBJECT + np.array([-35.0 + 0.3 * t_s, -8.0, -3.0]), Rotation.from_euler("Z", 0.1)


def poses(course: Course) -> tuple[Array, Array, Rotation]:
    """Return times, places and attitudes, 20 times a second."""
    t_s = np.arange(0.0, SECONDS + 1.0, 0.05)
    reported = [course(t) for t in t_s.tolist()]
    return t_s, np.array([place for place, _ in reported]), Rotation.concatenate([turn for _, turn in reported])


def detections(sonar: Sonar, seed: int, course: Course = around) -> list[Detections]:
    """Return those of all pings: the object in most of them, and false alarms."""
    rng = np.random.default_rng(seed)
    return [_ping(sonar, index, rng, course) for index in range(int(SECONDS / PING_S))]


def _ping(sonar: Sonar, index: int, rng: np.random.Generator, course: Course) -> Detections:
    sent_s = index * PING_S
    found = [_detection(rng.uniform(3.0, 90.0), rng.uniform(-0.75, 0.75), 12.0) for _ in range(rng.poisson(2.0))]
    range_m, bearing = _measured(sonar, sent_s, course)
    if abs(bearing) < 0.75 and rng.random() < 0.85:
        noise = rng.normal(size=2) * (SIGMA_RANGE, SIGMA_BEARING)
        found.append(_detection(range_m - NEARER_M + float(noise[0]), bearing + float(noise[1]), 20.0))
    t_ns = round((sent_s + sonar.late_s) * NS)
    return Detections(index, index, t_ns, t_ns, t_ns, SOUND, SECTOR, found)


def _measured(sonar: Sonar, sent_s: float, course: Course) -> tuple[float, float]:
    """Return range and bearing, the instant of reception found by repetition."""
    there, _ = sonar.head(sent_s, course)
    way = 2.0 * float(np.linalg.norm(OBJECT - there))
    for _ in range(3):
        back, turn = sonar.head(sent_s + way / SOUND, course)
        way = float(np.linalg.norm(OBJECT - there) + np.linalg.norm(OBJECT - back))
    ahead, right, _ = turn.inv().apply(OBJECT - back).tolist()
    return 0.5 * way, math.atan2(right, ahead)


def _detection(range_m: float, bearing: float, snr_db: float) -> Detection:
    return Detection(range_m, bearing, 0.5, 9.0, 5.0, snr_db, 20, 0.5, 0.02, SIGMA_RANGE, SIGMA_BEARING, 0.2)
