"""`ods map export`: the objects as geographic data."""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.geodesy import LocalFrame
from ods.map.commands.files import add_map_argument, add_within_argument, map_file, new_file, read_map
from ods.map.export import write_geojson, write_geopackage
from ods.tracker.map.map_object import MapObject

MapWriter = Callable[[Path, list[MapObject], LocalFrame], None]
FORMATS: dict[str, MapWriter] = {".geojson": write_geojson, ".json": write_geojson, ".gpkg": write_geopackage}


def add_arguments(parser: ArgumentParser) -> None:
    """Map, area and file."""
    add_map_argument(parser)
    add_within_argument(parser)
    parser.add_argument("--out", type=Path, metavar="FILE", required=True, help=".geojson or .gpkg (GeoPackage)")


def run(args: Namespace) -> None:
    """Write the file, in the format that its suffix names. Raises OdsError."""
    suffix = args.out.suffix.lower()
    if suffix not in FORMATS:
        raise OdsError(f"{args.out}: the suffix names the format: {', '.join(FORMATS)}")
    objects, frame = read_map(map_file(args.file, args.config), args.within)
    with new_file(args.out) as part:
        FORMATS[suffix](part, objects, frame)
    print(f"{len(objects)} objects in {args.out}")
