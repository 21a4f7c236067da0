"""The scene of a world, for images: obstacles that echo from near only are not observed until then."""

import numpy as np

from ods.base.frames.mounting import MountingSettings
from ods.missions.world import World
from ods.sim_sonar.echo.bodies.bodies import Bodies
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.steered import SteeredVehicle

FAR_M = 1e5
"""Beyond any sonar's reach."""


class FaintScene(Scene):
    """A scene whose bodies are received within a distance of the vehicle only."""

    def __init__(self, world: World, vehicle: SteeredVehicle, mounting: MountingSettings, within_m: float) -> None:
        super().__init__(world.scene(1.0), mounting, vehicle)
        self._world, self._way, self._within_m = world, vehicle, within_m

    def bodies_at(self, t_s: float) -> Bodies:
        """Return all objects at `t_s`, in NED, those that are not received far below."""
        bodies = super().bodies_at(t_s)
        north, east, down = self._way.position(np.array(t_s)).tolist()
        bodies["centre"][self._world.clearances(t_s, north, east, down) > self._within_m, 2] += FAR_M
        return bodies


def scene_of(world: World, vehicle: SteeredVehicle, mounting: MountingSettings) -> Scene:
    """Return a world as sonar and INS on the vehicle find it. Raises ValueError."""
    within_m = world.settings.heard_within_m
    if within_m is None:
        return Scene(world.scene(1.0), mounting, vehicle)
    return FaintScene(world, vehicle, mounting, within_m)
