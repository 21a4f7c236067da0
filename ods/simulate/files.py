"""Where `ods simulate` finds sonars and scenes that are given by name, whatever folder it runs in."""

from pathlib import Path

from ods.base.errors import OdsError
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.sonar.model import SonarModel, load_sonar

CHECKOUT = Path(__file__).parents[2] / "config"
"""The configuration beside this package, where it runs from its sources."""


def find_sonar(name: str, scene: Path | None = None) -> SonarModel:
    """Return the sonar of a name, or of a path that ends in .toml.

    Names are looked up in the folder `sonars` beside that of `scene`, then in config/sonars here, then in the sources.
    Raises OdsError, which tells the known names.
    """
    if name.endswith(".toml"):
        return load_sonar(Path(name))
    folders = _folders("sonars", scene)
    for folder in folders:
        if (folder / f"{name}.toml").is_file():
            return load_sonar(folder / f"{name}.toml")
    known = sorted({item.stem for folder in folders for item in folder.glob("*.toml")})
    raise OdsError(f"no sonar {name!r} (there are: {', '.join(known) or 'none'})")


def find_scene(name: str) -> Scene:
    """Return the scene of that name in config/scenes, here or in the sources. Raises OdsError."""
    folders = _folders("scenes", None)
    found = [folder / f"{name}.toml" for folder in folders if (folder / f"{name}.toml").is_file()]
    return load_scene(found[0] if found else folders[0] / f"{name}.toml")


def _folders(kind: str, scene: Path | None) -> list[Path]:
    beside = [] if scene is None else [scene.resolve().parent.parent / kind]
    return [*beside, Path("config") / kind, CHECKOUT / kind]
