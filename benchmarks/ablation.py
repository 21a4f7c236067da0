"""What is each mechanism of the tracker worth? The tracker alone, with each of them switched off.

`python -m benchmarks.ablation --detections FOLDER`: scenes are simulated and gone through by the chain once; what it
found is kept in the folder. Then the tracker gets the same detections again and again, with one mechanism switched off
at a time. Sets: the family of sea-beds (two draws), sea-beds that nobody has chosen by
(`benchmarks.simulator.sea_scenes`), three other sonars, and calm water. Judged as `ods assess sea` does.
"""

import argparse
import hashlib
import math
import multiprocessing
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple
from unittest.mock import patch

import msgspec
import numpy as np

from benchmarks.simulator.sea_scenes import BEDS, scene_text
from ods.assess.sea.assessment import shipped_scenes
from ods.assess.sea.command import CLEARANCE_M, SECONDS
from ods.assess.sea.judge import SceneScore, judge
from ods.assess.sea.run import DetectedPing, detected, images_of, listed, scene_with_seed
from ods.assess.sea.scene_objects import SceneObjects
from ods.assess.sea.table import TRACKED_LIMIT
from ods.base.arrays import Indices
from ods.base.files.shipped import shipped_file
from ods.messages import Sector
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.by_name import find_sonar
from ods.tracker import tracker
from ods.tracker.association import match
from ods.tracker.association.hypotheses.clutter import RADII, Clutter, ClutterDensity
from ods.tracker.existence import evidence
from ods.tracker.existence.model import EXISTENCE, MODEL, ExistenceModel
from ods.tracker.life import judgement
from ods.tracker.measurement.scan import Echoes
from ods.tracker.output import surface
from ods.tracker.settings import TrackerSettings
from ods.tracker.track import stitching

RADIUS_STEP_M = 0.5
HELD_OUT_SEED = 11
ROUGH = ("gravel", "kelp", "ripples", "rocky", "trench", "wall")
"""Scenes that sonars other than the SeaBat see."""


class Run(NamedTuple):
    """A scene, a draw of it, and who sees it."""

    group: str
    sonar: str
    file: Path
    seed: int


def runs(folder: Path) -> list[Run]:
    """Return all runs; scenes drawn at random are written to the folder."""
    rng = np.random.default_rng(HELD_OUT_SEED)
    found = [Run("family", "seabat6012", file, seed) for file in shipped_scenes() for seed in (0, 1)]
    for name, bed in BEDS.items():
        for number in range(3):
            file = folder / f"{name}{number}.toml"
            file.write_text(scene_text(bed, rng), encoding="utf-8")
            found.append(Run("held out", "seabat6012", file, 0))
    for group, sonar in (("Oculus", "oculus_m750d"), ("512 beams", "multibeam512"), ("planes", "seabat6012_3plane")):
        found += [Run(group, sonar, file, 0) for file in shipped_scenes(ROUGH)]
    calm = [shipped_file(f"scenes/{name}.toml") for name in ("figure11", "figure11_imperfect")]
    return found + [Run("calm", "seabat6012", file, 0) for file in calm]


def detections_of(run: Run, folder: Path) -> list[DetectedPing]:
    """Return what the chain found in a run; from the folder, if it is there, else into it."""
    scene, sonar = scene_with_seed(run.file, run.seed), find_sonar(run.sonar)
    name = hashlib.sha256(msgspec.json.encode([scene.file, run.sonar, SECONDS])).hexdigest()
    path = folder / f"{name[:16]}.detections"
    if not path.is_file():
        found = list(detected(images_of(scene, sonar, SECONDS), scene, PipelineSettings()))
        path.write_bytes(msgspec.msgpack.encode(found))
    return msgspec.msgpack.decode(path.read_bytes(), type=list[DetectedPing])


Switch = Callable[[], AbstractContextManager[Any]]


class Mechanism(NamedTuple):
    """How a part of the tracker is switched off."""

    switches: tuple[Switch, ...] = ()
    settings: Mapping[str, Any] = MappingProxyType({})
    """Of the tracker, those by the name of a table changed within it."""


def _model(**values: float) -> Switch:
    """Return a switch that sets numbers of the existence model."""

    class Changed:
        def __enter__(self) -> None:
            self.before = MODEL.copy()
            for name, value in values.items():
                MODEL[ExistenceModel._fields.index(name)] = value

        def __exit__(self, *_: object) -> None:
            MODEL[:] = self.before

    return Changed


def _no_pairs(*_: object) -> tuple[Indices, Indices]:
    return np.zeros(0, np.intp), np.zeros(0, np.intp)


def _unlimited(echoes: Echoes, *_: object) -> Echoes:
    return echoes


def _even(clutter: Clutter, echoes: Echoes, sector: Sector) -> ClutterDensity:
    """Return a density that is the same in all parts of the fan and of all radii."""
    area = 0.5 * (sector.bearing_max_rad - sector.bearing_min_rad) * (sector.range_max_m**2 - sector.range_min_m**2)
    even = np.full(len(echoes), clutter.per_scan)
    return ClutterDensity(even / area, even, np.full(len(echoes), 1.0 / (RADII * RADIUS_STEP_M)))


_ODDS = partial(patch.object, judgement, "EXISTENCE", EXISTENCE._replace(odds_factor=1.0))

MECHANISMS = {
    "crowding": Mechanism((_model(crowd_a_second=1e9),)),
    "lighter prior in crowds": Mechanism((_model(clutter_scans=8.0),)),
    "onset": Mechanism((_model(object_sharp=EXISTENCE.clutter_sharp, object_slow=EXISTENCE.clutter_slow), _ODDS)),
    "odds of onsets": Mechanism((_ODDS,)),
    "leading edge": Mechanism((_model(edge_variance=1e12),)),
    "motion": Mechanism((_model(motion_for=0.0),)),
    "hit rate": Mechanism((_model(object_scans=1e9, clutter_scans=1e9, crowded_scans=1e9),)),
    "scans of a sonar at rest": Mechanism((partial(patch.object, evidence, "WEIGHT_AT_REST", 1.0),)),
    "learned share": Mechanism((_model(many=1.0, share_tracks=1e9),)),
    "clutter by place and radius": Mechanism((partial(patch.object, Clutter, "density", _even),)),
    "limits of cut-off echoes": Mechanism((partial(patch.object, match, "limit_information", _unlimited),)),
    "stitching": Mechanism((partial(patch.object, stitching, "stitch", _no_pairs),)),
    "births at start": Mechanism((partial(patch.object, tracker, "FIRST_SCANS", 0),)),
    "bottom": Mechanism(settings={"bottom": {"list": "all"}}),
    "surface waves": Mechanism(settings={"surface": {"list": "all"}}),
    "grace of waves": Mechanism((partial(patch.object, surface, "GRACE_S", 0.2),)),
    "probabilistic association": Mechanism(settings={"association": "nearest"}),
    "kinds of motion": Mechanism(settings={"observer": "coupled"}),
    "north and east together": Mechanism(settings={"observer": "independent"}),
    "edge of view": Mechanism(settings={"life": {"edge_sigmas": 0.0}}),
}
"""What each name switches off. Hit rates that are not learned are those of most objects and of most clutter."""


class Variant(NamedTuple):
    """A tracker: what is switched off, and from which probability on it confirms."""

    name: str
    without: tuple[str, ...] = ()
    confirm_existence: float = 0.99

    def settings(self) -> TrackerSettings:
        """Return the settings of the tracker."""
        plain = msgspec.to_builtins(TrackerSettings())
        plain["life"]["confirm_existence"] = self.confirm_existence
        for name in self.without:
            for key, value in MECHANISMS[name].settings.items():
                plain[key] = plain[key] | value if isinstance(value, dict) else value
        return msgspec.convert(plain, TrackerSettings)


VARIANTS = (
    Variant("as it is"),
    *(Variant(f"without {name}", (name,)) for name in MECHANISMS),
    Variant("at 0.98", (), 0.98),
)


def scores_of(run: Run, folder: Path, names: Sequence[str]) -> list[tuple[str, SceneScore]]:
    """Return how a run goes with each tracker."""
    pings, scene = detections_of(run, folder), scene_with_seed(run.file, run.seed)
    bodies, scores = SceneObjects(scene, CLEARANCE_M), []
    for variant in chosen(names):
        with ExitStack() as stack:
            for name in variant.without:
                for switch in MECHANISMS[name].switches:
                    stack.enter_context(switch())
            lists = listed(pings, scene, variant.settings())
        scores.append((variant.name, judge(run.file.stem, lists, bodies, run.seed)))
    return scores


def chosen(names: Sequence[str]) -> list[Variant]:
    """Return the trackers of these names."""
    return [each for each in VARIANTS if each.name in names]


def cell(scores: Sequence[SceneScore]) -> str:
    """Return false obstacles a minute; sum of tracked shares; bodies tracked; sum of delays, s."""
    targets = [target for score in scores for target in score.targets if target.expected]
    shares = [target.share for target in targets]
    late = sum(SECONDS if math.isnan(target.confirmed_s) else target.confirmed_s for target in targets)
    false = sum(score.false_ids for score in scores) / sum(score.minutes for score in scores)
    tracked = sum(share >= TRACKED_LIMIT for share in shares)
    return f"{false:.2f}; {sum(shares):.2f}; {tracked}/{len(shares)}; {late:.0f}"


def main() -> None:
    """Print one table of all trackers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--detections", type=Path, required=True, metavar="FOLDER", help="kept there, taken from there")
    parser.add_argument("--only", nargs="+", metavar="GROUP", help="these sets")
    parser.add_argument("--variants", nargs="+", metavar="NAME", help="these trackers")
    parser.add_argument("--list", action="store_true", help="tell the runs with false obstacles and lost bodies, too")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="runs at a time")
    args = parser.parse_args()
    args.detections.mkdir(parents=True, exist_ok=True)
    names = args.variants or [each.name for each in VARIANTS]
    scores: dict[tuple[str, str], list[SceneScore]] = {}
    all_runs = [run for run in runs(args.detections) if args.only is None or run.group in args.only]
    with ProcessPoolExecutor(args.jobs, multiprocessing.get_context("spawn")) as pool:
        every_run = pool.map(partial(scores_of, folder=args.detections, names=names), all_runs)
        for run, of_run in zip(all_runs, every_run, strict=True):
            for name, score in of_run:
                scores.setdefault((name, run.group), []).append(score)
    groups = list(dict.fromkeys(run.group for run in all_runs))
    print("each cell: false obstacles a minute; sum of tracked shares; bodies in 95 % of the lists; sum of delays, s\n")
    print(f"| tracker | {' | '.join(groups)} | all | ms a step |\n|{'---|' * (len(groups) + 3)}")
    for name, *_ in chosen(names):
        of_groups = [scores[name, group] for group in groups]
        every = [score for of_group in of_groups for score in of_group]
        spent = float(np.mean([score.tracker_ms for score in every]))
        print(f"| {name} | {' | '.join(cell(each) for each in (*of_groups, every))} | {spent:.2f} |")
    if args.list:
        for (name, group), of_group in scores.items():
            for score in of_group:
                lost = [f"{t.name} {t.share:.0%}" for t in score.targets if t.share < TRACKED_LIMIT]
                if score.false_ids or lost:
                    print(f"{name}, {group}, {score.name}: {score.false_ids} false; {', '.join(lost)}")


if __name__ == "__main__":
    main()
