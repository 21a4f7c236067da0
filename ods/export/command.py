"""`ods export`: a recording as a file of another format."""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path

from ods.export.place import Place, place_of
from ods.export.pour import TOPICS, export
from ods.export.sink import Sink
from ods.recording.mcap.reader import open_recording

FORMATS = {
    "foxglove": "MCAP file of Foxglove's messages, for Foxglove and Lichtblick",
    "ros2": "ROS 2 bag, a folder, for ros2 bag play and everything that reads bags",
    "csv": "tables, a folder, for pandas and spreadsheets",
    "s7k": "pings, contacts and poses for 7k software",
    "geojson": "tracks for geographic software",
}


def add_arguments(parser: ArgumentParser) -> None:
    """Recording and format."""
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="file or folder that `ods record` wrote")
    formats = parser.add_mutually_exclusive_group(required=True)
    for name, text in FORMATS.items():
        formats.add_argument(f"--{name}", type=Path, metavar="OUT", help=text)


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
    """Return what makes a file of one of FORMATS; other people's libraries are imported only if it needs them."""
    if name == "foxglove":
        from ods.export.foxglove_file import FoxgloveFile

        return lambda path: FoxgloveFile(path, place.mounting, place.frame)
    if name == "ros2":
        from ods.export.ros2 import Ros2Bag

        return lambda path: Ros2Bag(path, place.mounting)
    if name == "csv":
        from ods.export.csv_tables import CsvTables

        return CsvTables
    if name == "s7k":
        from ods.export.s7k import S7kFile

        return lambda path: S7kFile(path, place.frame)
    from ods.export.geojson import GeoJsonFile

    return lambda path: GeoJsonFile(path, place.frame)


def _size(out: Path) -> int:
    return sum(path.stat().st_size for path in (out.iterdir() if out.is_dir() else [out]))
