"""Scenes and sonars of the user's own, as `--scene` and `--sonar` name them."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.shipped import shipped_file
from ods.sim_sonar.sonar.model import SonarModel, load_sonar


def scene_files(places: Sequence[Path]) -> Iterator[Path]:
    """Yield files as they are, and those of folders by name. Raises OdsError for a folder without a scene."""
    for place in places:
        if not place.is_dir():
            yield place
            continue
        found = sorted(place.glob("*.toml"))
        if not found:
            raise OdsError(f"--scene {place}: no .toml file in this folder")
        yield from found


def sonar_named(name: str) -> SonarModel:
    """Return the sonar of a name, or of a path that ends in .toml. Raises OdsError."""
    return load_sonar(Path(name) if name.endswith(".toml") else shipped_file(f"sonars/{name}.toml"))
