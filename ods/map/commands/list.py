"""`ods map list`: a table of the objects."""

from argparse import ArgumentParser, Namespace

from ods.map.commands.files import add_map_argument, add_within_argument, map_file, read_map
from ods.map.export import points_of, utc_text


def add_arguments(parser: ArgumentParser) -> None:
    """Map and area."""
    add_map_argument(parser)
    add_within_argument(parser)


def run(args: Namespace) -> None:
    """Print the table. Raises OdsError."""
    objects, frame = read_map(map_file(args.file, args.config), args.within)
    print(
        f"{'id':>6} {'north m':>9} {'east m':>9} {'down m':>7} {'latitude':>12} {'longitude':>12} {'sigma N/E/D m':>16}"
        f" {'radius m':>13} {'exists':>6} {'seen':>5}  last seen (UTC)"
    )
    for o, (longitude, latitude, _) in zip(objects, points_of(objects, frame), strict=True):
        north, east, down = o.position
        sigma = "/".join(f"{value:.2f}" for value in o.sigma)
        radius = f"{o.radius:.2f} +-{o.sigma_radius:.2f}"
        print(
            f"{o.id:6d} {north:9.2f} {east:9.2f} {down:7.2f} {latitude:12.7f} {longitude:12.7f} {sigma:>16}"
            f" {radius:>13} {o.existence:6.3f} {o.times_seen:5d}  {utc_text(o.last_seen_utc_ns)}"
        )
    print(f"{len(objects)} objects; origin {frame.latitude_deg}, {frame.longitude_deg}")
