"""`ods nearest`: the obstacle that comes nearest."""

from argparse import ArgumentParser, Namespace

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.client import Obstacles
from ods.config import OnboardConfig


def add_arguments(parser: ArgumentParser) -> None:
    """Only what others have not."""
    parser.add_argument("--radius", action="store_true", help="print its radius, too")


def run(args: Namespace) -> None:
    """Print one line. Raises OdsError when the list is not to be relied on."""
    obstacles = Obstacles(load(args.config, OnboardConfig).bus.run_dir)
    try:
        obstacle_list = obstacles.next()
    finally:
        obstacles.close()
    if not obstacle_list.valid:
        raise OdsError("; ".join(obstacle_list.reasons))
    coming = [each for each in obstacle_list.obstacles if each.cpa]
    for each in sorted(coming, key=lambda obstacle: obstacle.cpa.distance_m if obstacle.cpa else 0.0)[:1]:
        print(f"obstacle {each.id}" + (f", radius {each.radius_m:.1f} m" if args.radius else ""))
