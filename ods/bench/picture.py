"""scene.png: the last image with its detections beside the plan of vehicle, truth and tracks."""

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse

from ods.base import geometry
from ods.base.mounting import AT_ORIGIN, Mounting
from ods.bench.collector import RunRecord
from ods.messages import Detections, Obstacle, ObstacleList, Ping, Quaternion, Sector, Vector3
from ods.plots.fan import draw_detections, draw_fan, polar_image
from ods.plots.style import BAD, GOOD, MARK, QUIET, STRONG, WARN

STATE_COLOURS = {"active": GOOD, "stand_by": WARN, "hibernated": MARK, "terminated": QUIET}


def draw_run(record: RunRecord, file: Path, mounting: Mounting = AT_ORIGIN) -> None:
    """Draw a run's last image and its plan into `file`; `mounting`: the sonar's."""
    figure = Figure(figsize=(15, 7.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    if record.image is not None:
        _image(left, *record.image)
    if record.truths:
        _plan(right, record, mounting)
    figure.savefig(file, dpi=110)


def _image(axes: Axes, ping: Ping, detections: Detections) -> None:
    draw_fan(axes, polar_image(ping))
    draw_detections(axes, detections.detections)
    axes.set_title(f"ping {ping.ping_number} and its {len(detections.detections)} detections")


def _plan(axes: Axes, record: RunRecord, mounting: Mounting) -> None:
    truths = [record.truths[number] for number in sorted(record.truths)]
    path = np.array([truth.position_ned for truth in truths])
    axes.plot(path[:, 1], path[:, 0], color=STRONG, lw=2, label="vehicle path")
    newest = record.lists[-1][1] if record.lists else None
    truth = record.truths.get(newest.ping_number, truths[-1]) if newest else truths[-1]
    if record.image is not None:
        _sector(axes, record.image[1].sector, *mounting.head(truth.position_ned, truth.attitude)[:2])
    for index, target in enumerate(truth.objects):
        circle = Circle(_plane(target.position_ned), target.radius_m, fill=False, ls="--", color=BAD, lw=1.5)
        circle.set_label("truth" if index == 0 else "")
        axes.add_patch(circle)
    if newest is not None:
        _tracks(axes, newest, record)
    axes.set_aspect("equal")
    axes.set_xlabel("east, m")
    axes.set_ylabel("north, m")
    axes.grid()
    axes.set_title("plan: truth, tracks with two standard deviations, vehicle path")
    axes.autoscale_view()
    axes.legend(loc="lower left", fontsize="small")


def _plane(position_ned: tuple[float, float, float]) -> tuple[float, float]:
    return position_ned[1], position_ned[0]


def _sector(axes: Axes, sector: Sector, place: Vector3, attitude: Quaternion) -> None:
    bearings = np.linspace(sector.bearing_min_rad, sector.bearing_max_rad, 60)
    arc = geometry.polar_to_body(sector.range_max_m, bearings)
    edge = np.vstack([np.zeros((1, 3)), arc, np.zeros((1, 3))])
    world = geometry.body_to_global(edge, place, attitude)
    axes.fill(world[:, 1], world[:, 0], color=MARK, alpha=0.12, label="insonified sector")


def _tracks(axes: Axes, newest: ObstacleList, record: RunRecord) -> None:
    history: dict[int, list[tuple[float, float]]] = {}
    for _, item in record.lists:
        for obstacle in item.obstacles:
            history.setdefault(obstacle.id, []).append(_plane(obstacle.position_ned))
    named: set[str] = set()
    for obstacle in newest.obstacles:
        colour = STATE_COLOURS[obstacle.state]
        trail = np.array(history[obstacle.id])
        axes.plot(trail[:, 0], trail[:, 1], color=colour, lw=0.8, alpha=0.7)
        label = "" if obstacle.state in named else f"track, {obstacle.state.replace('_', '-')}"
        named.add(obstacle.state)
        _track(axes, obstacle, colour, label)


def _track(axes: Axes, obstacle: Obstacle, colour: str, label: str) -> None:
    centre = _plane(obstacle.position_ned)
    axes.add_patch(Circle(centre, obstacle.radius_m, fill=False, color=colour, lw=2, label=label))
    north, east, _ = obstacle.sigma_position
    axes.add_patch(Ellipse(centre, 4 * east, 4 * north, color=colour, alpha=0.25, lw=0))
    speed = math.hypot(*obstacle.velocity_ned[:2])
    axes.annotate(
        f"{obstacle.id}: r {obstacle.radius_m:.1f} m, {speed:.2f} m/s",
        centre,
        xytext=(8, 8),
        textcoords="offset points",
        fontsize=8,
        color=colour,
    )
