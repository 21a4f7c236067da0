"""`ods export`: a recording as a file of another format."""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from ods.export.conversion import TOPICS, export
from ods.export.place import Place, place_of
from ods.export.sink import Sink
from ods.recording.mcap.reader import open_recording


class Format(NamedTuple):
    """One row of the table of formats."""

    text: str
    """What the file is for."""
    sink: str
    """MODULE:CLASS; imported only when the format is chosen, as it may need other people's libraries."""
    needs: tuple[str, ...] = ()
    """Fields of `Place` that the class takes behind the path."""


FORMATS = {
    "foxglove": Format(
        "MCAP file of Foxglove's messages, for Foxglove and Lichtblick",
        "ods.export.foxglove_file:FoxgloveFile", ("mounting", "frame"),
    ),
    "ros2": Format(
        "ROS 2 bag, a folder, for ros2 bag play and all readers of bags", "ods.export.ros2:Ros2Bag",
        ("mounting",),
    ),
    "csv": Format("folder of tables, for pandas and spreadsheets", "ods.export.csv_tables:CsvTables"),
    "s7k": Format("pings, contacts and poses for 7k software", "ods.export.s7k:S7kFile", ("frame",)),
    "geojson": Format("tracks for geographic software", "ods.export.geojson:GeoJsonFile", ("frame",)),
}  # fmt: skip


def add_arguments(parser: ArgumentParser) -> None:
    """Recording and format."""
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="file or folder that `ods record` wrote")
    formats = parser.add_mutually_exclusive_group(required=True)
    for name, row in FORMATS.items():
        formats.add_argument(f"--{name}", type=Path, metavar="OUT", help=row.text)


def run(args: Namespace) -> None:
    """Export, and print what became of it. Raises OdsError, ModuleNotFoundError without the extra `export`."""
    (name,) = (name for name in FORMATS if getattr(args, name) is not None)
    out: Path = getattr(args, name)
    recording = open_recording(args.recording)
    make = maker(name, place_of(recording.attachments, args.config))
    done = export(recording.messages(TOPICS), out, make)
    lost = [f"{what} {count}" for what, count in sorted((done.losses + recording.losses).items())]
    print(", ".join([f"{out}: {done.taken} messages, {_size(out) / 1e6:.1f} MB", *lost]))


def maker(name: str, place: Place) -> Callable[[Path], Sink]:
    """Return what makes a file of one of FORMATS. Raises ModuleNotFoundError without the libraries that it needs."""
    row = FORMATS[name]
    module, _, kind = row.sink.partition(":")
    sink: Callable[..., Sink] = getattr(import_module(module), kind)
    return lambda path: sink(path, *(getattr(place, field) for field in row.needs))


def _size(out: Path) -> int:
    return sum(path.stat().st_size for path in (out.iterdir() if out.is_dir() else [out]))
