"""`ods assess track`: the table and charts of all observers, the paper's figures 6 and 7, scenario files."""

from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import track as progress

from ods.assess.scene_files import scene_files
from ods.assess.track import peers
from ods.assess.track.case import save_case
from ods.assess.track.figures.table import table_of
from ods.assess.track.measure import Row, contenders, rows
from ods.assess.track.scenarios import KINDS, Kind, make
from ods.assess.track.scene_world import scene_kind
from ods.base.choices import none_of
from ods.base.errors import OdsError
from ods.base.settings_file import load_table
from ods.config import OnboardConfig
from ods.plots.style import DARK, drawn_in, refuse_undrawable
from ods.tracker.settings import PLUGINS, TrackerSettings

QUICK = ("paper", "static 10", "50 false alarms")
SEEDS = 5


def run(args: Namespace) -> None:
    """Run the command. Raises OdsError."""
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
        if args.first_seed < 0:
            raise OdsError("--first-seed: must not be negative")
        count = args.seeds or (1 if args.quick else SEEDS)
        trackers = contenders(args.trackers, configured)
        seeds = range(args.first_seed, args.first_seed + count)
        found = assess(_kinds(args), trackers, seeds, with_peers=args.peers)
        if args.out is not None:
            draw(args.out, found, args.style)


def _kinds(args: Namespace) -> dict[str, Kind]:
    """Return the scenarios to run: the user's own scenes, where he gives some. Raises OdsError."""
    if args.scene:
        return {file.stem: scene_kind(file) for file in scene_files(args.scene)}
    unknown = [name for name in args.scenarios if name not in KINDS]
    if unknown:
        raise OdsError(f"--scenarios: {none_of(unknown[0], KINDS)}")
    return {name: KINDS[name] for name in (args.scenarios or (QUICK if args.quick else KINDS))}


def assess(
    kinds: Mapping[str, Kind], trackers: Mapping[str, TrackerSettings], seeds: Sequence[int], *, with_peers: bool
) -> list[Row]:
    """Run `trackers` over the scenarios with these seeds each and print the table. Raises OdsError."""
    if with_peers and not peers.available():
        raise OdsError("--peers: the library is not installed: pip install stonesoup")
    names = progress(tuple(kinds), description="assessing", transient=True)
    found = [row for name in names for row in rows({name: kinds[name]}, seeds, trackers, with_peers)]
    Console(width=224).print(table_of(found, len(seeds)))
    return found


def draw(out: Path, found: Sequence[Row], style: str = DARK) -> None:
    """Draw the chart. Raises OdsError."""
    from ods.assess.track.figures.chart import chart
    from ods.plots.chart import save_figure

    with drawn_in(style):
        save_figure(chart(found), out)
    print(f"drawn: {out}")


def draw_paper(path: Path, style: str = DARK) -> None:
    """Draw the paper's figures 6 and 7 again and print what happens in them. Raises OdsError."""
    from ods.assess.track.figures import paper_figures
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
