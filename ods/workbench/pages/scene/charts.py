"""The curves of the simulator's menu."""

from collections.abc import Sequence

import numpy as np

from ods.workbench.engine.scene.curves import Curve as Curved
from ods.workbench.engine.scene.plan import strip_of
from ods.workbench.engine.scene.view import Pictured
from ods.workbench.web.views.chart_view import Axis, ChartView, Colour, Curve, Panel

ROLES: tuple[Colour, ...] = ("first", "second", "third", "fourth")
DEPTH, SPEED = "depth, m", "speed, m/s"


def overlaid(view: ChartView, curves: Sequence[tuple[str, Curved]], x: Axis, y: Axis) -> None:
    """Show named curves in one panel."""
    shown = [Curve(role, name, *curve) for role, (name, curve) in zip(ROLES, curves, strict=False)]
    view.show(x, [Panel(y, shown)])


def show_profile(view: ChartView, shown: Pictured, beam: int) -> None:
    """Show the levels of one beam over range, figure 10."""
    names = ("as sent", "expected", "of a perfect sonar")
    curves = list(zip(names, shown.profile(beam), strict=True))
    overlaid(view, curves, Axis(f"range of beam {beam}, m", cursor="range"), Axis("dB over 1 count"))


def show_strip(view: ChartView, shown: Pictured, part: str) -> None:
    """Show depth and speed of the selected path, with its way-points, and when the ping is."""
    scene = shown.asked.file
    place = int(part[len("objects[") : -1]) if part.startswith("objects[") else -1
    if place >= len(scene.objects):
        return
    moving = scene.objects[place] if place >= 0 else scene.vehicle
    name = scene.objects[place].name if place >= 0 else "vehicle"
    depth, speed = strip_of(scene, part if place >= 0 else "vehicle")
    t_s, down_m = np.array([(point.t_s, point.position_ned[2]) for point in moving.waypoints]).reshape(-1, 2).T
    depths = [Curve("first", "", *depth), Curve("first", "", t_s, down_m, "points")]
    view.set_title(name)
    view.set_cursor(shown.t_s)
    panels = [
        Panel(Axis(DEPTH, inverse=True, span=1.0), depths, title=DEPTH),
        Panel(Axis(SPEED, span=0.5), [Curve("second", "", *speed)], title=SPEED),
    ]
    view.show(Axis("time, s"), panels, columns=2)
