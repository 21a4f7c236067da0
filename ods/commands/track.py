"""`ods track`: the tracker as on board, on a recorded scenario."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.mounting import AT_ORIGIN, Mounting, mounting_in
from ods.base.settings_file import load_table
from ods.config import OnboardConfig
from ods.tracker import scenario
from ods.tracker.settings import TrackerSettings


def add_arguments(parser: ArgumentParser) -> None:
    """Scenario and tracks."""
    parser.add_argument("file", type=Path, metavar="SCENARIO.npz")
    parser.add_argument("--out", type=Path, metavar="TRACKS.npz", required=True)


def run(args: Namespace) -> None:
    """Run the tracker over a scenario; without a configuration with its default settings. Raises OdsError."""
    settings = load_table(args.config, "tracker", TrackerSettings, OnboardConfig) if args.config else TrackerSettings()
    mounting = Mounting(mounting_in(args.config)) if args.config else AT_ORIGIN
    print(scenario.track_file(args.file, args.out, settings, mounting))
