"""way.png of a bench with a planner: the way of the vehicle through its obstacles, and how near it came to them."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from ods.base.arrays import Floats, Mask
from ods.bench.way.avoidance import Mission, clearance_of
from ods.offline.run_record import RunRecord
from ods.plots.style import ACCENT, BAD, GOOD, MARK, QUIET, STRONG, WARN
from ods.sim_sonar.scene.timeline import ObjectStates

STATES = (
    ("goes to the way-point", GOOD),
    ("avoids an obstacle", ACCENT),
    ("list not valid", BAD),
    ("stopped by its watchdog", WARN),
)
SHOWN_M = 20.0
"""Clearances above are not drawn."""
MOVES_M_S = 0.01
DEPTH_MARGIN_M = 2.0


def draw_path(mission: Mission, record: RunRecord, best: Floats | None, file: Path) -> None:
    """Draw it into `file`; `best`: (k, 2) the way of an all-knowing planner."""
    times = np.array([each.scene_s for each in record.way])
    places = np.array([each.position_ned for each in record.way])
    state = _states(record)
    figure = Figure(figsize=(15.0, 9.0), layout="constrained")
    plan, clear, depth = figure.subplots(3, 1, height_ratios=(4.0, 1.2, 1.0))
    _objects(plan, mission, times)
    if best is not None:
        plan.plot(best[:, 0], best[:, 1], color=STRONG, lw=1.2, ls=":", label="all-knowing planner")
    for number, (label, colour) in enumerate(STATES):
        _coloured(plan, places[:, 0], places[:, 1], state == number, colour, label)
        _coloured(depth, times, places[:, 2], state == number, colour, "")
    _plan_frame(plan, mission, places)
    least = np.array([clearance_of(mission, each).min(initial=SHOWN_M) for each in record.way])
    clear.plot(times, np.minimum(least, SHOWN_M), color=MARK)
    clear.axhline(0.0, color=BAD, lw=1.0)
    clear.set_ylabel("to the nearest\nobject, m")
    depth.set_ylim(places[:, 2].max() + DEPTH_MARGIN_M, places[:, 2].min() - DEPTH_MARGIN_M)
    depth.set_ylabel("depth, m")
    depth.set_xlabel("time, s")
    for axes in (clear, depth):
        axes.grid()
    figure.savefig(file, dpi=110)


def _states(record: RunRecord) -> Floats:
    """Return (n,) the number of the vehicle's state in STATES at each truth of its way."""
    sent_ns = np.array([each.t_ns for each in record.set_points])
    states = np.array([2 if not each.valid else int(each.avoiding) for each in record.set_points])
    seen_ns = np.array([each.t_ns for each in record.way])
    newest = np.searchsorted(sent_ns, seen_ns, side="right") - 1
    state = states[np.maximum(newest, 0)] if len(states) else np.zeros(len(seen_ns), int)
    stopped = np.array([each.stopped for each in record.way])
    return np.asarray(np.where(stopped, 3, np.where(newest < 0, 2, state)))


def _coloured(axes: Axes, x: Floats, y: Floats, chosen: Mask, colour: str, label: str) -> None:
    """Draw the parts of a line where `chosen` is true."""
    if chosen.any():
        joined = chosen.copy()
        joined[1:] |= chosen[:-1]  # to where the next part begins
        axes.plot(np.where(joined, x, np.nan), np.where(joined, y, np.nan), color=colour, lw=2.5, label=label or None)


def _objects(axes: Axes, mission: Mission, times: Floats) -> None:
    first, last = (mission.scene.objects_at(float(each)) for each in (times[0], times[-1]))
    moves = np.hypot(*first.velocity_ned[:, :2].T) > MOVES_M_S
    axes.add_patch(_circle(first, int(np.argmin(moves)), fill=True, color=QUIET, label="static object"))
    for which in np.flatnonzero(~moves).tolist():
        axes.add_patch(_circle(first, which, fill=True, color=QUIET))
    for count, which in enumerate(np.flatnonzero(moves).tolist()):
        label = "" if count else "moving object, from start to end"
        axes.add_patch(_circle(first, which, fill=False, ls=":", color=MARK))
        axes.add_patch(_circle(last, which, fill=False, color=MARK, label=label))
        way = np.stack([first.position_ned[which], last.position_ned[which]])
        axes.plot(way[:, 0], way[:, 1], color=MARK, lw=0.8)


def _circle(objects: ObjectStates, which: int, **style: object) -> Circle:
    north, east, _ = objects.position_ned[which].tolist()
    return Circle((north, east), float(objects.radius_m[which]), **style)


def _plan_frame(axes: Axes, mission: Mission, places: Floats) -> None:
    points = np.array([places[0], *mission.way_points])
    axes.plot(points[:, 0], points[:, 1], color=STRONG, lw=0.8, ls="--", label="straight way")
    axes.plot(points[1:, 0], points[1:, 1], color=STRONG, ls="", marker="x", label="way-points")
    axes.set_aspect("equal")
    axes.invert_yaxis()
    axes.set_xlabel("north, m")
    axes.set_ylabel("east, m")
    axes.grid()
    axes.legend(loc="upper left", fontsize="small", ncols=3)
