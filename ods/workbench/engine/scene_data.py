"""Pings of a scene, simulated as they are looked at."""

from collections.abc import Sequence
from pathlib import Path

from ods.offline.source import simulated
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.workbench.engine.data import Data, DataError, KeptPings
from ods.workbench.engine.folders import readable
from ods.workbench.model.state import DataReference

LONGEST_S = 86_400.0
"""Of a scene: its whole path is laid out when it is opened."""


def simulated_data(reference: DataReference, scene: SceneFile | None, folders: Sequence[Path]) -> Data:
    """Return a scene's pings, as a sonar sees them that is given by name or by a file in `folders`. Raises OdsError."""
    if scene is None:
        raise DataError("scene: none is open")
    if scene.duration_s > LONGEST_S:
        raise DataError(f"scene: duration_s: {scene.duration_s:g} s is more than the {LONGEST_S:g} s shown here")
    if reference.sonar.endswith(".toml"):
        readable(reference.sonar, folders)
    elif "/" in reference.sonar:
        raise DataError(f"sonar: {reference.sonar} is not a name")
    model = find_sonar(reference.sonar, Path(reference.path) if reference.path else None)
    try:
        source = simulated(Scene(scene), model)
    except ValueError as error:
        raise DataError(f"scene: {error}") from error
    return Data(reference, KeptPings(source.pings), source.poses, truths=source.truths)
