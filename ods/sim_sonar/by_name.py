"""Finds sonars and scenes that are given by name, whatever folder it runs in."""

from pathlib import Path

from ods.base.choices import none_of
from ods.base.errors import OdsError
from ods.base.files import shipped
from ods.base.files.shipped import shipped_file
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.sonar.model import SonarModel, load_sonar


def find_sonar(name: str, scene: Path | None = None) -> SonarModel:
    """Return the sonar of a name, or of a path that ends in .toml.

    Names are looked up in the folder `sonars` beside that of `scene`, then in config/sonars here, then among those that
    come with the package. Raises OdsError, which tells the known names.
    """
    if name.endswith(".toml"):
        return load_sonar(Path(name))
    beside = [] if scene is None else [scene.resolve().parent.parent / "sonars"]
    folders = [*beside, Path("config/sonars"), shipped.FOLDER / "sonars"]
    for folder in folders:
        if (folder / f"{name}.toml").is_file():
            return load_sonar(folder / f"{name}.toml")
    known = sorted({item.stem for folder in folders for item in folder.glob("*.toml")})
    raise OdsError(f"sonar: {none_of(name, known)}")


def find_scene(name: str) -> Scene:
    """Return the scene of that name in config/scenes, here or as it comes with the package. Raises OdsError."""
    return load_scene(shipped_file(f"scenes/{name}.toml"))
