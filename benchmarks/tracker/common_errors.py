"""`benchmarks.tracker.common_errors`: what is wrong with poses, mounting and sound speed, how soon, and how well.

Simulated images go through the chain once; then the tracker gets their detections with a pose, or ranges, that are
wrong from 10 s on (a drift) or from the start. Printed is when what was first named, what at the end, and how many
places of bodies were beyond three standard deviations in the last 20 s, without and with what is known to be wrong in
the covariance. Last, scenes of the family with nothing wrong: all that is named there is false.
"""

import math
import re
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
import tomli_w

from ods.assess.sea.run import DetectedPing, detected, head_at, images_of, scene_with_seed
from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.files.shipped import shipped_file
from ods.base.frames.quaternion import product
from ods.messages import Detection, Truth
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseEstimate
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.timeline import Scene
from ods.tracker.common_error.monitor import CommonErrors
from ods.tracker.common_error.sightings import Motion
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.measurement.from_detections import received
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

SECONDS, FROM_S = 60.0, 10.0
ERRORS: dict[str, float] = {
    "none": 0.0, "turn 2 deg/s": 2.0, "turn 0.1 deg/s": 0.1, "yaw 2 deg": 2.0, "ranges 2 %": 0.02, "late 100 ms": 0.1,
    "drift 0.2 m/s": 0.2,
}  # fmt: skip
NOTHING_WRONG = ("gravel", "kelp", "rocky", "ripples", "slope", "gentle", "school", "wall")
SURFACE = {"cd": 0.1, "cs": 0.05, "sigma_deg": 15.0}
LATE_S, NEAR_M, BEYOND = 20, 6.0, 9.0
"""Places are judged in the last so many seconds, of bodies within so much of an object; square of three sigma."""
SHAPE_SIGMA = TrackerSettings().planner.shape_sigma
PosedAt = Callable[[int], PoseEstimate]


def scene_of(seed: int, weave_deg: float) -> dict[str, Any]:
    """Return a vehicle that passes among eight spheres over a rough bed."""
    rng = np.random.default_rng(seed)
    across = rng.uniform(7.0, 40.0, 8) * rng.choice([-1.0, 1.0], 8)
    places = np.column_stack([rng.uniform(30.0, 130.0, 8), across, rng.uniform(18.0, 23.0, 8)])
    spheres = [
        {"shape": "sphere", "name": f"sphere {k}", "radius_m": 1.2, "position_ned": place, "surface": SURFACE}
        for k, place in enumerate(places.tolist())
    ]
    path = {"position_ned": [0.0, 0.0, 20.0], "velocity_ned": [1.5, 0.0, 0.0]}
    bed = {"depth_m": 26.0, "rough": {"rms_height_m": 0.15, "correlation_m": 2.0}, "surface": {"cd": 0.5, "cs": 0.2}}
    yaw = {"yaw": {"amplitude_deg": weave_deg, "period_s": 20.0}}
    return {"seed": seed, "duration_s": SECONDS, "vehicle": path | yaw, "objects": spheres, "sea_bed": bed}


def wrong(scene: Scene, error: str) -> PosedAt:
    """Return the head's pose as an INS with the error reports it."""
    size = ERRORS[error]

    def posed(t_ns: int) -> PoseEstimate:
        since_s = max(0.0, t_ns / NS - FROM_S)
        if error.startswith("late"):
            return replace(head_at(scene, t_ns + round(size * NS)), t_ns=t_ns)
        true = head_at(scene, t_ns)
        if error.startswith("drift"):
            return replace(true, position_ned=true.position_ned + np.array([size * since_s, 0.0, 0.0]))
        angle = math.radians(size) * {"turn": since_s, "yaw": 1.0}.get(error.split()[0], 0.0)
        turn = (math.cos(angle / 2.0), 0.0, 0.0, math.sin(angle / 2.0))
        return replace(true, attitude=np.array(product(turn, tuple(true.attitude.tolist()))))

    return posed


class Report(NamedTuple):
    """What came of one error."""

    first: dict[str, float]
    """When each was first named, s, by its words without numbers."""
    last: str
    """What was named at the end."""
    beyond: tuple[float, float]
    """Shares of the places beyond three standard deviations, without and with the known error in the covariance."""


def report(pings: Sequence[DetectedPing], posed: PosedAt, scale: float) -> Report:
    """Track with an error."""
    tracker, errors, first = Tracker(TrackerSettings()), CommonErrors(), dict[str, float]()
    squares: list[tuple[list[float], list[float]]] = []
    late_ns = pings[-1].found.t_ns - LATE_S * NS
    for truth, found, _ in pings:
        longer = msgspec.structs.replace(
            found, detections=_scaled(found.detections, scale), faint=_scaled(found.faint, scale)
        )
        head = posed(found.t_ns)
        scan = received(longer, head, posed, found.utc_ns).scan
        tracker.step(scan)
        yaw_rate = 0.5 * scan.fan_turn * found.sound_speed
        snapshot = tracker.snapshot()
        errors.look(snapshot, scan, Motion(head.velocity_ned[:2], yaw_rate))
        if found.t_ns > late_ns:
            squares.append((_squares(snapshot, truth), _squares(errors.widened(snapshot), truth)))
        for each in errors.problem().split("; or "):
            if each:
                first.setdefault(re.sub(r"[-+. ]*[0-9][-+.0-9 ]*", " ... ", each), found.t_ns / NS)
    shares = [_share_beyond(np.concatenate(each)) for each in zip(*squares, strict=True)]
    return Report(first, errors.problem(), (shares[0], shares[1]))


def _share_beyond(squares: Floats) -> float:
    return float(np.mean(squares > BEYOND)) if squares.size else math.nan


def _squares(snapshot: Snapshot, truth: Truth) -> list[float]:
    """Return the squared errors of bodies' places over their covariance: of the nearest active object, if near."""
    active = snapshot.take(snapshot.state == ACTIVE)
    found = []
    for body in truth.objects:
        off = active.position[:2] - np.array(body.position_ned[:2])[:, None]
        if not len(active) or (away := np.hypot(*off)).min() > NEAR_M:
            continue
        k = int(away.argmin())
        shape = (SHAPE_SIGMA * active.radius[k]) ** 2
        north, east = active.sigma_position[:2, k] ** 2 + shape
        both = np.array([[north, active.covariance_ne[k]], [active.covariance_ne[k], east]])
        found.append(float(off[:, k] @ np.linalg.solve(both, off[:, k])))
    return found


def _scaled(detections: list[Detection], scale: float) -> list[Detection]:
    return [msgspec.structs.replace(each, range_m=each.range_m * (1.0 + scale)) for each in detections]


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        for name, weave_deg in (("straight", 1.5), ("weaving", 25.0)):
            file = Path(folder) / f"{name}.toml"
            file.write_text(tomli_w.dumps(scene_of(5, weave_deg)), encoding="utf-8")
            _show(name, file, tuple(ERRORS))
    _show("figure 11", shipped_file("scenes/figure11.toml"), tuple(ERRORS))
    for name in NOTHING_WRONG:
        _show(name, shipped_file(f"scenes/sea/{name}.toml"), ("none",))


def _show(name: str, file: Path, errors: tuple[str, ...]) -> None:
    scene = scene_with_seed(file, 0)
    pings = list(detected(images_of(scene, find_sonar("seabat6012"), SECONDS), scene, PipelineSettings()))
    for error in errors:
        found = report(pings, wrong(scene, error), ERRORS[error] if "ranges" in error else 0.0)
        named = "; ".join(f"{at_s:.1f} s: {words}" for words, at_s in found.first.items())
        beyond = "beyond 3 sigma {:.0%} -> {:.0%}".format(*found.beyond)
        beyond = "no body is near an object" if math.isnan(found.beyond[0]) else beyond
        said = f"first named at {named or 'no time'}; at the end: {found.last or 'nothing'}"
        print(f"{name}, {error}: {beyond}; {said}", flush=True)


if __name__ == "__main__":
    main()
