"""`ods assess sea`: share of the lists that objects are in, false obstacles and times, over many sea-beds."""

import multiprocessing
from argparse import Namespace
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import track as progress

from ods.assess.scene_files import SEA_BEDS, scene_files
from ods.assess.sea.judge import SceneScore, judge
from ods.assess.sea.kind_run import run_kinds
from ods.assess.sea.run import detected, images_of, listed, scene_with_seed
from ods.assess.sea.scene_objects import SceneObjects
from ods.assess.sea.table import condensed, margin_table, scene_table, target_table
from ods.assess.sea.trial import Draw, Trial
from ods.base.choices import none_of
from ods.base.errors import OdsError
from ods.base.files.shipped import shipped_file
from ods.base.settings_file import load_table
from ods.config import OnboardConfig
from ods.pipeline.settings import PipelineSettings
from ods.plots.style import drawn_in, refuse_undrawable
from ods.sim_sonar.by_name import find_sonar
from ods.tracker.settings import TrackerSettings


def run(args: Namespace) -> None:
    """Run the scenes, print the tables, draw the chart. Raises OdsError."""
    refuse_undrawable(args.out)
    pipeline, tracker = PipelineSettings(), TrackerSettings()
    if args.config:
        pipeline = load_table(args.config, "pipeline", PipelineSettings, OnboardConfig)
        tracker = load_table(args.config, "tracker", TrackerSettings, OnboardConfig)
    if args.images is not None and not args.images.is_dir():
        raise OdsError(f"--images {args.images}: no such folder")
    trial = Trial(
        find_sonar(args.sonar), args.seconds, args.clearance, args.images, pipeline, tracker, not args.no_altitude
    )
    if args.kinds is not None:
        run_kinds(args.kinds, trial, args.seeds, args.jobs)
        return
    files = list(scene_files(args.scene)) if args.scene else shipped_scenes(args.scenes)
    named = list(zip(names_of(files), files, strict=True))
    scores = scores_of([Draw(*each, seed) for each in named for seed in range(args.seeds)], trial, args.jobs)
    console = Console(width=120)
    console.print(scene_table(scores))
    console.print(target_table(scores))
    console.print(margin_table(scores))
    print(*condensed(scores), sep="\n")
    if args.out is not None:
        from ods.assess.sea.chart import chart
        from ods.plots.chart import save_figure

        with drawn_in(args.style):
            save_figure(chart(scores), args.out)
        console.print(f"drawn: {args.out}")


def names_of(files: Sequence[Path]) -> list[str]:
    """Return what tables call scenes: by their files, and by their folders, too, where several files have one name."""
    count = Counter(file.stem for file in files)
    return [file.stem if count[file.stem] == 1 else f"{file.parent.name}/{file.stem}" for file in files]


def shipped_scenes(names: Sequence[str] | None = None) -> list[Path]:
    """Return the files of the family of sea-beds, or of those named. Raises OdsError for an unknown name."""
    known = {file.stem: file for file in scene_files([shipped_folder()])}
    for name in names or ():
        if name not in known:
            raise OdsError(f"--scenes: {none_of(name, sorted(known))}")
    return [known[name] for name in names or known]


def shipped_folder() -> Path:
    """Return the folder of the family of sea-beds."""
    return shipped_file(f"{SEA_BEDS}/gentle.toml").parent


def scores_of(draws: Sequence[Draw], trial: Trial, jobs: int = 1) -> list[SceneScore]:
    """Return a score a draw, in order, `jobs` of them at a time. Raises OdsError."""
    score = partial(score_of, trial)
    if jobs == 1:
        return [score(draw) for draw in progress(draws, description="assessing", transient=True)]
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        found = pool.map(score, draws)
        return list(progress(found, total=len(draws), description="assessing", transient=True))


def score_of(trial: Trial, draw: Draw) -> SceneScore:
    """Return how a scene goes. Raises OdsError."""
    scene = scene_with_seed(draw.file, draw.seed)
    shots = images_of(scene, trial.sonar, trial.seconds, trial.kept)
    pings = detected(shots, scene, trial.pipeline, knows_altitude=trial.knows_altitude)
    lists = listed(pings, scene, trial.tracker, knows_altitude=trial.knows_altitude)
    return judge(draw.name, lists, SceneObjects(scene, trial.clearance_m), draw.seed)
