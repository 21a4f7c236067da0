"""Runs kinds of scene through chain, tracker and list as on board, with validity and cautions."""

import multiprocessing
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import msgspec
import numpy as np
from rich.progress import track as progress

from ods.assess.sea.kind_judge import KindScore, TrackedList, judged
from ods.assess.sea.kind_table import kind_table
from ods.assess.sea.kinds import Kind, PoseNoise, kinds_named
from ods.assess.sea.run import images_of, scene_with_seed
from ods.assess.sea.scene_objects import SceneObjects
from ods.assess.sea.trial import Trial
from ods.base.clock import NS
from ods.base.files.shipped import shipped_file
from ods.base.frames.quaternion import from_euler, product
from ods.messages import Ping, Pose, Truth
from ods.offline.mission import Mission, MissionSettings
from ods.offline.poses import poses_along
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.shots import START_UTC_NS


def run_kinds(names: Sequence[str], trial: Trial, seeds: int, jobs: int) -> None:
    """Run the kinds of these names, all for none, and print the table. Raises OdsError."""
    draws = [(kind, seed) for kind in kinds_named(names) for seed in range(seeds)]
    print(*kind_table(list(_scores(draws, trial, jobs))), sep="\n")


def _scores(draws: Sequence[tuple[Kind, int]], trial: Trial, jobs: int) -> Iterator[KindScore]:
    score, said = partial(kind_score, trial), "assessing"
    if jobs == 1:
        yield from (score(draw) for draw in progress(draws, description=said, transient=True))
        return
    named = [(kind.name, seed) for kind, seed in draws]
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        found = pool.map(partial(_score_named, trial), named)
        yield from progress(found, total=len(draws), description=said, transient=True)


def _score_named(trial: Trial, named: tuple[str, int]) -> KindScore:
    (kind,) = kinds_named([named[0]])
    return kind_score(trial, (kind, named[1]))


def kind_score(trial: Trial, draw: tuple[Kind, int]) -> KindScore:
    """Return how a kind goes with the bed and the speckle of a seed. Raises OdsError."""
    kind, seed = draw
    drawn = scene_with_seed(shipped_file(f"scenes/sea/{kind.scene}.toml"), seed)
    scene = Scene(kind.change(drawn.file))
    sonar = find_sonar(kind.sonar) if kind.sonar else trial.sonar
    truths: list[Truth] = []

    def pings() -> Iterator[Ping]:
        for ping, truth in images_of(scene, sonar, trial.seconds, trial.kept):
            truths.append(truth)
            yield ping

    count = int(min(trial.seconds, scene.file.duration_s) / sonar.ping_period_s) + 2
    poses = reported_poses(scene, [round(k * sonar.ping_period_s * NS) for k in range(count)], kind.noise, seed)
    lists = tracked_lists(pings(), poses, MissionSettings(pipeline=trial.pipeline, tracker=trial.tracker), truths)
    return judged(kind, lists, SceneObjects(scene, trial.clearance_m), seed)


def reported_poses(scene: Scene, t_ns: Sequence[int], noise: PoseNoise | None, seed: int) -> list[Pose]:
    """Return the sonar's poses at times (n,), true, or with white noise of their standard deviations."""
    way = scene.head_at(np.array(t_ns) / NS)
    attitudes = [(w, x, y, z) for w, x, y, z in way.attitude.tolist()]
    poses = poses_along(t_ns, way.position_ned, attitudes, START_UTC_NS)
    if noise is None:
        return poses
    rng = np.random.default_rng([seed, 7])
    attitude_rad = np.radians((noise.tilt_deg, noise.tilt_deg, noise.yaw_deg))
    place, turn = rng.normal(0.0, noise.position_m, (len(poses), 3)), rng.normal(0.0, 1.0, (len(poses), 3))
    return [
        msgspec.structs.replace(
            pose,
            position_ned=tuple((np.array(pose.position_ned) + place[k]).tolist()),
            attitude=product(pose.attitude, from_euler(*(turn[k] * attitude_rad).tolist())),
            sigma_position_ned=(noise.position_m,) * 3,
            sigma_attitude=tuple(attitude_rad.tolist()),
        )
        for k, pose in enumerate(poses)
    ]


def tracked_lists(
    pings: Iterable[Ping], poses: Iterable[Pose], settings: MissionSettings, truths: Sequence[Truth]
) -> list[TrackedList]:
    """Return the lists of pings; truths: those of the pings so far. Raises StageError, PluginError."""
    steps = Mission(settings).steps(pings, poses)
    return [
        TrackedList(truths[-1], step.list, len(step.detections.detections), step.chain_ms, step.tracker_ms)
        for step in steps
    ]
