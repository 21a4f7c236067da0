"""Scenes to assess: the family of sea-beds, and the user's own, as `--scene` names them."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from ods.base.errors import OdsError

SEA_BEDS = "scenes/sea"
"""Where the family is in config/."""


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
