"""The files of config/ that come with the package, from its sources and from a wheel alike."""

from pathlib import Path

FOLDER = Path(__file__).parents[2] / "config_files"
"""Scenes, sonars, and the configurations to start from."""


def shipped_file(name: str) -> Path:
    """Return config/`name` of the current folder if it exists, otherwise the one in the package.

    `name`: such as "sonars/seabat6012.toml". The path returned may not exist.
    """
    own = Path("config") / name
    return own if own.is_file() else FOLDER / name
