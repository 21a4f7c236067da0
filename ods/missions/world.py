"""One random world of a campaign: obstacles, current, and how near the vehicle comes to them."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.missions.failing.dead_ends import POST_M, dead_ends
from ods.missions.settings import WorldSettings
from ods.sim_sonar.scene.settings import Cylinder, SceneFile, VehiclePath
from ods.sim_sonar.steered import VehicleState

SQUARE_M_A_HECTARE = 1e4
FIRST_TO_FIT = 10_000_000
"""Worlds from this number on are beyond any campaign's: laws of detections are fitted to them."""


class World(NamedTuple):
    """A world; n obstacles."""

    settings: WorldSettings
    start_m: Floats
    """(n, 2) north, east at time 0, m."""
    velocity: Floats
    """(n, 2) m/s over ground."""
    radius_m: Floats
    """(n,)"""
    current_m_s: tuple[float, float]
    """North, east."""
    seed: int
    """Of its images and its sea-bed."""

    def places(self, t_s: float) -> Floats:
        """Return (n, 2) where the obstacles are, north, east, m."""
        return self.start_m + t_s * self.velocity

    def clearances(self, t_s: float, north_m: float, east_m: float, down_m: float) -> Floats:
        """Return (n,) the distance from a place to each obstacle's surface, m; inside of it none is below 0."""
        away = np.hypot(*(self.places(t_s) - (north_m, east_m)).T) - self.radius_m
        above = abs(down_m - self.settings.down_m) - self.settings.height_m
        if above <= 0.0:
            return np.asarray(away)
        return np.asarray(np.hypot(np.maximum(away, 0.0), above))

    def until_contact_s(self, now: VehicleState, radius_m: float) -> Floats:
        """Return (n,) the time until a vehicle's circle touches each obstacle if both go straight on; inf: never."""
        offset = self.places(now.t_s) - (now.north_m, now.east_m)
        closing = self.velocity - now.velocity_m_s
        reach = self.radius_m + radius_m
        gap = np.maximum((offset**2).sum(axis=1) - reach**2, 0.0)
        toward = -(offset * closing).sum(axis=1)
        square = toward**2 - (closing**2).sum(axis=1) * gap
        touches = (toward > 0.0) & (square >= 0.0)
        return np.where(touches, gap / np.where(touches, toward + np.sqrt(np.maximum(square, 0.0)), 1.0), math.inf)

    def scene(self, duration_s: float) -> SceneFile:
        """Return it as a scene; the vehicle in it stands at the start."""
        settings = self.settings
        down = settings.down_m
        rows = zip(self.start_m.tolist(), self.velocity.tolist(), self.radius_m.tolist(), strict=True)
        objects = [
            Cylinder(
                name=f"{number}",
                position_ned=(north, east, down),
                velocity_ned=(v_north, v_east, 0.0),
                radius_m=radius,
                length_m=2.0 * settings.height_m,
                surface=settings.surface,
            )
            for number, ((north, east), (v_north, v_east), radius) in enumerate(rows)
        ]
        return SceneFile(
            seed=self.seed,
            duration_s=duration_s,
            vehicle=VehiclePath(position_ned=(0.0, 0.0, down)),
            objects=list(objects),
            sea_bed=settings.sea_bed,
            image=settings.image,
        )


def make_world(settings: WorldSettings, seed: int, number: int) -> World:
    """Return the world of that number; by spawn keys, so that no two campaigns or numbers share one."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    area = settings.length_m * settings.width_m / SQUARE_M_A_HECTARE
    count = int(rng.poisson(settings.obstacles_per_hectare * area))
    half = 0.5 * settings.width_m
    start = np.stack([rng.uniform(0.0, settings.length_m, count), rng.uniform(-half, half, count)], axis=1)
    radius = rng.uniform(*settings.radius_m, count)
    speed = rng.uniform(*settings.speed_m_s, count) * (rng.random(count) < settings.moving_share)
    course = rng.uniform(0.0, 2.0 * math.pi, count)
    velocity = speed[:, None] * np.stack([np.cos(course), np.sin(course)], axis=1)
    flow, toward = settings.current_m_s * math.sqrt(rng.random()), rng.uniform(0.0, 2.0 * math.pi)
    image_seed = int(rng.integers(2**31))
    goal = np.array([settings.length_m, 0.0])
    free = np.hypot(*start.T) - radius >= settings.free_start_m
    free &= np.hypot(*(start - goal).T) - radius >= settings.free_goal_m
    start, velocity, radius = start[free], velocity[free], radius[free]
    if settings.dead_ends:
        walls = dead_ends(settings, rng)
        start = np.concatenate([start, walls])
        velocity = np.concatenate([velocity, np.zeros_like(walls)])
        radius = np.concatenate([radius, np.full(len(walls), POST_M)])
    current = (flow * math.cos(toward), flow * math.sin(toward))
    return World(settings, start, velocity, radius, current, image_seed)
