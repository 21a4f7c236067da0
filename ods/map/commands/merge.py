"""`ods map merge`: merge the maps of two missions."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.geodesy import LocalFrame
from ods.base.settings_file import load_table
from ods.config import OnboardConfig
from ods.map.commands.files import new_file, opened
from ods.map.merge import Spread, merge, moved
from ods.tracker.map.store import copy_of_map, open_map
from ods.tracker.settings import TrackerSettings


def add_arguments(parser: ArgumentParser) -> None:
    """Two maps and a third."""
    parser.add_argument("first", type=Path, metavar="FIRST", help="its origin and ids are kept")
    parser.add_argument("second", type=Path, metavar="SECOND")
    parser.add_argument("--out", type=Path, metavar="MAP", required=True, help="a new file")


def run(args: Namespace) -> None:
    """Write the map that holds what both maps hold; neither of them is changed. Raises OdsError."""
    if args.out.exists():
        raise OdsError(f"{args.out}: already exists; a merged map needs a new file")
    settings = load_table(args.config, "tracker", TrackerSettings, OnboardConfig) if args.config else TrackerSettings()
    with opened(copy_of_map(args.first)) as one, opened(copy_of_map(args.second)) as two:
        origin = one.origin_deg()
        others = moved(two.load(), LocalFrame(*two.origin_deg()), LocalFrame(*origin))
        spread = Spread(settings.map.position_sigma_m, settings.planner.shape_sigma)
        count = len(one.load())
        result = merge(one.load(), others, one.first_free_id(), spread)
    with new_file(args.out) as part, opened(open_map(part, *origin)) as store:
        store.change(result.objects, [], result.next_id)
    for own, other in result.pairs:
        print(f"{own} is {other} of {args.second}")
    same = f"{len(result.pairs)} of them the same"
    print(f"{count} and {len(others)} objects, {same}: {len(result.objects)} in {args.out}")
