"""A scene as the TOML text that is its file."""

import tomlkit

from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.model.short_tables import short_tables


def scene_text(scene: SceneFile) -> str:
    """Return the file's text: what is as by default is left out."""
    return tomlkit.dumps(short_tables(scene))
