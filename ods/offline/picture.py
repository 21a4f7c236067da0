"""The last image with its detections beside the plan of vehicle, truth and tracks: the picture of a run."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.base.frames.mounting import AT_ORIGIN, Mounting
from ods.messages import Detections, Obstacle, ObstacleList, Ping, Quaternion, Sector, TruthObject, Vector3
from ods.offline.run_record import RunRecord
from ods.plots.fan import PIXELS, draw_detections, draw_fan, polar_image
from ods.plots.style import BAD, GOOD, MARK, QUIET, STRONG, WARN

STATE_COLOURS = {"active": GOOD, "stand_by": WARN, "hibernated": MARK, "terminated": QUIET}


class View(NamedTuple):
    """Contents of a picture."""

    image: tuple[Ping, Detections] | None
    path: Floats
    """(n, 3) of the vehicle, m."""
    vehicle: tuple[Vector3, Quaternion] | None
    """Its pose at the image."""
    targets: Sequence[TruthObject]
    """What is true at the newest list."""
    lists: Sequence[ObstacleList]


def draw_run(record: RunRecord, file: Path, mounting: Mounting = AT_ORIGIN, width_in: float = 15.0) -> None:
    """Draw a run's last image and its plan into `file`; `mounting`: the sonar's; the narrower, the larger the text."""
    truths = [record.truths[number] for number in sorted(record.truths)]
    lists = [item for _, item in record.lists]
    newest = record.truths.get(lists[-1].ping_number) if lists else None
    path = np.array([each.position_ned for each in truths]).reshape(-1, 3)
    view = View(record.image, path, None, (), lists)
    if truths:
        truth = newest or truths[-1]
        view = view._replace(vehicle=(truth.position_ned, truth.attitude), targets=truth.objects)
    figure = Figure(figsize=(width_in, 0.5 * width_in), layout="constrained")
    draw_view(figure, view, mounting)
    figure.savefig(file, dpi=110)


def draw_view(figure: Figure, view: View, mounting: Mounting = AT_ORIGIN, pixels: int = PIXELS) -> None:
    """Draw an image and the plan; `pixels`: of the longer side of the fan."""
    left, right = figure.subplots(1, 2)
    if view.image is not None:
        ping, found = view.image
        draw_fan(left, polar_image(ping), pixels=pixels)
        draw_detections(left, found.detections)
        left.set_title(f"ping {ping.ping_number} and its {len(found.detections)} detections")
    if len(view.path):
        _plan(right, view, mounting)


def _plan(axes: Axes, view: View, mounting: Mounting) -> None:
    axes.plot(view.path[:, 1], view.path[:, 0], color=STRONG, lw=2, label="vehicle path")
    if view.image is not None and view.vehicle is not None:
        _sector(axes, view.image[1].sector, *mounting.head(*view.vehicle)[:2])
    for index, target in enumerate(view.targets):
        circle = Circle(_plane(target.position_ned), target.radius_m, fill=False, ls="--", color=BAD, lw=1.5)
        circle.set_label("truth" if index == 0 else "")
        axes.add_patch(circle)
    if view.lists:
        _tracks(axes, view.lists)
    axes.set_aspect("equal")
    axes.set_xlabel("east, m")
    axes.set_ylabel("north, m")
    axes.grid()
    axes.set_title("plan: truth, vehicle path,\ntracks with two standard deviations")
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


def _tracks(axes: Axes, lists: Sequence[ObstacleList]) -> None:
    newest = lists[-1]
    history: dict[int, list[tuple[float, float]]] = {}
    for item in lists:
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
