"""`ods map prune`: takes objects out of a map that no tracker is using."""

import os
from argparse import ArgumentParser, Namespace

from ods.base import clock
from ods.base.command_line.arguments import number, positive_int
from ods.base.errors import OdsError
from ods.map.commands.files import add_area_argument, add_map_argument, map_file, opened
from ods.map.prune import Criteria, why_not
from ods.tracker.map.rights import missing_permission
from ods.tracker.map.store import copy_of_map, sole_access


def add_arguments(parser: ArgumentParser) -> None:
    """Map and criteria."""
    add_map_argument(parser)
    parser.add_argument("--existence-below", type=number(0.0, 1.0), metavar="P", help="existence probability, 0 to 1")
    parser.add_argument("--older-than", type=number(0.0, 1e6, "days"), metavar="DAYS", help="days since last seen")
    parser.add_argument("--seen-fewer", type=positive_int, metavar="N", help="times seen")
    add_area_argument(parser, "--outside", "farther than this from a place")
    parser.add_argument("--dry-run", action="store_true", help="only report what would be removed")


def run(args: Namespace) -> None:
    """Remove objects that meet a criterion, and print which and why. Raises OdsError."""
    criteria = Criteria(args.existence_below, args.older_than, args.seen_fewer, args.outside)
    if not criteria:
        raise OdsError("say what to remove: --existence-below, --older-than, --seen-fewer or --outside")
    path = map_file(args.file, args.config)
    if not args.dry_run and os.path.isfile(path) and (reason := missing_permission(path)):  # noqa: PTH113  which never raises
        raise OdsError(f"map {path}: {reason}")
    now_ns = clock.utc_ns()
    with opened(copy_of_map(path) if args.dry_run else sole_access(path)) as store:
        objects = store.load()
        reasons = {o.id: why for o in objects if (why := why_not(o, criteria, now_ns))}
        store.change([], reasons)
    for object_id, why in reasons.items():
        print(f"{object_id}: {', '.join(why)}")
    print(f"{len(reasons)} of {len(objects)} objects {'would be removed' if args.dry_run else 'removed'} from {path}")
