"""`ods assess track`: the table and charts of all observers, the paper's figures 6 and 7, scenario files."""

from argparse import ArgumentParser, Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import track as progress

from ods.assess.scene_files import scene_files
from ods.assess.track import peers
from ods.assess.track.case import save_case
from ods.assess.track.measure import Row, contenders, rows
from ods.assess.track.scenarios import KINDS, Kind, make
from ods.assess.track.scene_world import scene_kind
from ods.assess.track.table import table_of
from ods.base.arguments import positive_int
from ods.base.errors import OdsError
from ods.base.out_file import refuse_unwritable
from ods.base.settings_file import load_table
from ods.config import OnboardConfig
from ods.plots.style import DARK, add_style, drawn_in, refuse_undrawable
from ods.tracker.settings import PLUGINS, TrackerSettings

QUICK = ("paper", "static 10", "50 false alarms")
SEEDS = 5


def add_arguments(parser: ArgumentParser) -> None:
    """The assessment, or one of the other figures and files instead."""
    parser.add_argument("--out", type=Path, metavar="CHART.png", help="draw the chart")
    add_style(parser)
    parser.add_argument("--seeds", type=positive_int, metavar="N", help="runs of each scenario (default: 5)")
    parser.add_argument(
        "--trackers", nargs="+", default=[], metavar='"OBSERVER, ASSOCIATION"',
        help="only these instead of every observer with every association",
    )  # fmt: skip
    parser.add_argument("--peers", action="store_true", help="run the library Stone Soup beside ours: minutes")
    parser.add_argument(
        "--scene", type=Path, action="append", default=[], metavar="SCENE.toml",
        help="objects and vehicle of this scene, or of all in a folder, instead of the scenarios; may be given again",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="a few scenarios, to see that it works")
    parser.add_argument("--figures", type=Path, metavar="OUT.png", help="draw figures 6 and 7 of [SSIE] instead")
    parser.add_argument("--save", type=Path, metavar="FOLDER", help="write the scenarios for `ods track` instead")


def run(args: Namespace) -> None:
    """Do what was asked for. Raises OdsError."""
    refuse_unwritable(args.out, args.figures, read=(args.config,))
    refuse_undrawable(args.out, args.figures)
    if args.figures:
        draw_paper(args.figures, args.style)
    if args.save:
        save_scenarios(args.save)
    if not (args.figures or args.save):
        configured = None
        if args.config:
            configured = load_table(args.config, "tracker", TrackerSettings, OnboardConfig)
            PLUGINS.load(configured.plugins)
        count = args.seeds or (1 if args.quick else SEEDS)
        trackers = contenders(args.trackers, configured)
        found = assess(_kinds(args), trackers, count, with_peers=args.peers)
        if args.out is not None:
            draw(args.out, found, args.style)


def _kinds(args: Namespace) -> dict[str, Kind]:
    """Return the scenarios to run: the user's own scenes, where he gives some. Raises OdsError."""
    if args.scene:
        return {file.stem: scene_kind(file) for file in scene_files(args.scene)}
    return {name: KINDS[name] for name in (QUICK if args.quick else KINDS)}


def assess(
    kinds: Mapping[str, Kind], trackers: Mapping[str, TrackerSettings], count: int, *, with_peers: bool
) -> list[Row]:
    """Run `trackers` over the scenarios with `count` seeds each and print the table. Raises OdsError."""
    if with_peers and not peers.available():
        raise OdsError("--peers: the library is not installed: pip install stonesoup")
    names = progress(tuple(kinds), description="assessing", transient=True)
    found = [row for name in names for row in rows({name: kinds[name]}, count, trackers, with_peers)]
    Console(width=200).print(table_of(found, count))
    return found


def draw(out: Path, found: Sequence[Row], style: str = DARK) -> None:
    """Draw the chart. Raises OdsError."""
    from ods.assess.track.chart import chart
    from ods.plots.chart import save_figure

    with drawn_in(style):
        save_figure(chart(found), out)
    print(f"drawn: {out}")


def draw_paper(path: Path, style: str = DARK) -> None:
    """Draw the paper's figures 6 and 7 anew and print what happens in them. Raises OdsError."""
    from ods.assess.track import paper_figures
    from ods.plots.chart import save_figure

    example = paper_figures.run_example()
    with drawn_in(style):
        save_figure(paper_figures.draw(example), path)
    for line in paper_figures.story(example):
        print(line)
    print(f"drawn: {path}")


def save_scenarios(folder: Path, seed: int = 0) -> None:
    """Write every scenario as a file for `ods track`. Raises OdsError."""
    if not folder.is_dir():
        raise OdsError(f"{folder}: no such folder")
    for name in KINDS:
        path = folder / f"{name.replace(',', '').replace(' ', '-')}.npz"
        save_case(make(name, seed), path)
        print(path)
