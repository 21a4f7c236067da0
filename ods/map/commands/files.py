"""Common parts of the actions of `ods map`: the choice and opening of the map, and the writing of a new file."""

import os
import sqlite3
from argparse import Action, ArgumentParser, Namespace
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ods.base.command_line.arguments import number
from ods.base.errors import OdsError, reason_of
from ods.base.files.out_file import refuse_unwritable
from ods.base.geodesy import LocalFrame
from ods.base.settings_file import load_table
from ods.config import OnboardConfig
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.store import MapStore, copy_of_map
from ods.tracker.settings import TrackerSettings

Area = tuple[float, float, float]
"""North, east and distance, m."""
AREA_NAMES = "NORTH", "EAST", "METRES"
METRES = number(-1e7, 1e7, "metres")
"""Nothing on earth is farther from a site."""


def add_map_argument(parser: ArgumentParser) -> None:
    """The map's file, which need not be named."""
    parser.add_argument("file", type=Path, metavar="MAP", nargs="?", help="default: the configuration's")


def add_within_argument(parser: ArgumentParser) -> None:
    """The area that is wanted."""
    add_area_argument(parser, "--within", "only objects within this distance of a place")


def add_area_argument(parser: ArgumentParser, option: str, help_text: str) -> None:
    """An area: a place and the distance around it, m."""
    parser.add_argument(option, type=METRES, nargs=3, action=_AreaAction, metavar=AREA_NAMES, help=help_text)


class _AreaAction(Action):
    """Refuses an area that nothing is in."""

    def __call__(self, parser: ArgumentParser, namespace: Namespace, values: Any, _: str | None = None) -> None:
        if values[2] < 0.0:
            parser.error(f"argument {self.option_strings[0]}: METRES is {values[2]:g}: must not be negative")
        setattr(namespace, self.dest, values)


def map_file(file: Path | None, config: Path) -> Path:
    """Return the map that was named, or else the configuration's. Raises OdsError."""
    path = file or load_table(config, "tracker", TrackerSettings, OnboardConfig).map.path
    if path is None:
        raise OdsError(f"{config}: tracker.map.path is not set; name the map's file")
    return path


def read_map(path: Path, within: Area | None) -> tuple[list[MapObject], LocalFrame]:
    """Return the objects of a map, and the frame of their positions. Raises OdsError."""
    with opened(copy_of_map(path)) as store:
        return store.load(within), LocalFrame(*store.origin_deg())


@contextmanager
def opened(store: MapStore) -> Iterator[MapStore]:
    """Give a map, and close it at the end."""
    try:
        yield store
    finally:
        store.close()


@contextmanager
def new_file(out: Path) -> Iterator[Path]:
    """Give a file beside `out` to be written, which takes its name when it is whole. Raises OdsError."""
    refuse_unwritable(out)
    part = out.with_name(f"{out.name}.{os.getpid()}.part")
    try:
        yield part
        part.replace(out)
    except (OSError, sqlite3.Error) as error:
        raise OdsError(f"{out}: {reason_of(error)}") from error
    finally:
        with suppress(OSError):  # such as a name that is too long
            part.unlink(missing_ok=True)
