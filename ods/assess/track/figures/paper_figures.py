"""[SSIE] figures 6 and 7 drawn again: the worked example with a burst of noise on object 1.

The paper's observer ends an object by its uncertainty alone and does not ask whether it exists, so here existence plays
no part (`drop_existence`), and the limit of the uncertainty is set so that the old object ends when the paper's does.
Everything else is the default.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ods.assess.track.case import RADIUS, VX, VZ, Case, X, Z, observe
from ods.assess.track.scenarios import paper
from ods.base.arrays import Floats, Indices, Ints, Mask
from ods.plots.chart import label_points, style_axes
from ods.plots.style import BAD, QUIET, SERIES, STRONG
from ods.tracker import scenario
from ods.tracker.existence import lifecycle
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import TrackerSettings

SEED = 7
BURST_S = (1.5, 4.0)
BURST_M_S, BURST_RAD_S = 0.8, 0.01
"""The error of object 1's range and bearing grows so fast during the burst: the filter follows it away."""
LOST_SIGMA_M = 7.2
DROP_EXISTENCE = 1e-6
STARTED_S = 1.0
STYLES = {lifecycle.ACTIVE: "-", lifecycle.STAND_BY: ":", lifecycle.HIBERNATED: "--"}
TITLES = (
    *("figure 7: north, m", "down, m: not resolved by the sonar", "radius, m"),
    *("velocity north, m/s", "velocity down, m/s; band: reported standard deviation"),
)


@dataclass(frozen=True)
class Example:
    """The run."""

    case: Case
    snapshots: list[Snapshot]


@dataclass(frozen=True)
class Life:
    """One object's course through its states."""

    id: int
    began: float
    ended: float | None
    """None: it was there to the end."""
    stand_by: float | None
    """When it last went to stand-by."""


def example() -> Case:
    """Return the worked example with its burst of noise."""
    rng = np.random.default_rng(SEED)
    case = observe("paper", paper(rng), rng)
    det = case.scenario.det.copy()
    t = case.scenario.t[det[:, 0].astype(int)]
    burst = _in_burst(case.source, t)
    det[burst, 1:3] += np.outer(t[burst] - BURST_S[0], (BURST_M_S, BURST_RAD_S))
    return replace(case, scenario=replace(case.scenario, det=det))


def run_example() -> Example:
    """Track the example by the paper's own observer."""
    case, default = example(), TrackerSettings(observer="independent")
    rules = msgspec.structs.replace(default.life, lost_sigma_m=LOST_SIGMA_M, drop_existence=DROP_EXISTENCE)
    tracker = scenario.tracker_for(case.scenario, msgspec.structs.replace(default, life=rules))
    snapshots = []
    for scan in scenario.scans(case.scenario):
        tracker.step(scan)
        snapshots.append(tracker.snapshot())
    return Example(case, snapshots)


def lives(run: Example) -> list[Life]:
    """Return every object's course, in the order of their ids."""
    t = run.case.scenario.t
    found = []
    for identity in sorted({i for snapshot in run.snapshots for i in snapshot.id.tolist()}):
        states = np.array([next(iter(p.state[p.id == identity]), lifecycle.TENTATIVE) for p in run.snapshots])
        there = np.flatnonzero(states != lifecycle.TENTATIVE)
        waits = np.flatnonzero((states[1:] == lifecycle.STAND_BY) & (states[:-1] == lifecycle.ACTIVE)) + 1
        last = int(there[-1])
        found.append(
            Life(
                identity,
                float(t[there[0]]),
                float(t[last + 1]) if last + 1 < len(t) else None,
                float(t[waits[-1]]) if len(waits) else None,
            )
        )
    return found


def story(run: Example) -> list[str]:
    """Return one line for each object."""
    lines = []
    for one in lives(run):
        column = _course(run, one.id)
        line = f"object {one.id}: from t = {one.began:.1f} s"
        line += f", stand-by at {one.stand_by:.1f} s" if one.stand_by is not None else ""
        line += f", discarded at {one.ended:.1f} s" if one.ended is not None else ""
        active = column.state == lifecycle.ACTIVE
        lines.append(f"{line}; radius {column.radius[active][-1]:.2f} m")
    return lines


@dataclass(frozen=True)
class _Course:
    """One object's estimates over its life."""

    t: Floats
    state: Ints
    position: Floats
    """(k, 3)."""
    velocity: Floats
    radius: Floats
    sigma_velocity: Floats
    """(k, 3)."""


def _course(run: Example, identity: int) -> _Course:
    rows = [(k, int(np.flatnonzero(p.id == identity)[0])) for k, p in enumerate(run.snapshots) if identity in p.id]
    snapshots = [(run.snapshots[k], i) for k, i in rows]
    return _Course(
        run.case.scenario.t[[k for k, _ in rows]],
        np.array([p.state[i] for p, i in snapshots]),
        np.array([p.position[:, i] for p, i in snapshots]),
        np.array([p.velocity[:, i] for p, i in snapshots]),
        np.array([p.radius[i] for p, i in snapshots]),
        np.array([p.sigma_velocity[:, i] for p, i in snapshots]),
    )


def draw(run: Example) -> Figure:
    """Return the picture: paths, positions, depth, radii and velocities; dotted: stand-by; thin: the truth."""
    figure = Figure(figsize=(15.0, 9.0), dpi=100, layout="constrained")
    axes = figure.subplots(2, 3)
    plan, quantities = axes[0, 0], (axes[0, 1], axes[0, 2], axes[1, 0], axes[1, 1], axes[1, 2])
    _draw_truth(run, plan, quantities)
    events = []
    for place, one in enumerate(lives(run)):
        course, colour = _course(run, one.id), SERIES[place]
        _line(plan, course.position[:, 1], course.position[:, 0], course.state, colour, f"object {one.id}")
        for panel, values in zip(quantities, _quantities(course), strict=True):
            _line(panel, course.t, values, course.state, colour, "")
        height = course.sigma_velocity[:, 2]
        quantities[4].fill_between(course.t, -height, height, color=colour, alpha=0.12, lw=0.0)
        events += _mark(quantities[0], one, course, colour)
    _draw_burst(run.case, plan, quantities)
    for panel, title in zip(quantities, TITLES, strict=True):
        style_axes(panel, title, "t, s", "")
    quantities[1].invert_yaxis()
    style_axes(plan, "figure 6: paths", "east, m", "north, m")
    plan.set_aspect("equal", adjustable="datalim")
    plan.legend(loc="lower left")
    quantities[2].set_ylim(0.0, 7.5)
    figure.suptitle(
        "[SSIE] figures 6 and 7 redrawn. Thin grey: truth; full: active; dotted: stand-by; red: the noise burst",
        fontsize=13,
    )
    courses = np.vstack([np.column_stack([run.case.scenario.t, path]) for path in run.case.truth[:, :, X].T])
    label_points(figure, quantities[0], events, courses)
    return figure


def _draw_truth(run: Example, plan: Axes, quantities: Sequence[Axes]) -> None:
    """Draw where the vehicle and the objects really are."""
    truth, t = run.case.truth, run.case.scenario.t
    plan.plot(run.case.position[:, 1], run.case.position[:, 0], color=STRONG, lw=2.0, label="vehicle")
    for thing in range(truth.shape[1]):
        plan.plot(truth[:, thing, 1], truth[:, thing, 0], color=QUIET, lw=1.0)
        for panel, column in zip(quantities, (X, Z, RADIUS, VX, VZ), strict=True):
            panel.plot(t, truth[:, thing, column], color=QUIET, lw=1.0)


def _draw_burst(case: Case, plan: Axes, quantities: Sequence[Axes]) -> None:
    """Draw when echoes of object 1 are wrong, and where they are then."""
    for panel in quantities:
        panel.axvspan(*BURST_S, color=BAD, alpha=0.25, lw=0.0)
    scan, slant, bearing = case.scenario.det[:, 0].astype(int), case.scenario.det[:, 1], case.scenario.det[:, 2]
    t = case.scenario.t[scan]
    wrong = _in_burst(case.source, t)
    ahead = case.position[scan[wrong]] + np.column_stack(
        [slant[wrong] * np.cos(bearing[wrong]), slant[wrong] * np.sin(bearing[wrong]), 0.0 * slant[wrong]]
    )
    plan.plot(ahead[:, 1], ahead[:, 0], "x", color=BAD, ms=3.5, mew=0.8, label="echoes in the burst")
    quantities[0].plot(t[wrong], ahead[:, 0], "x", color=BAD, ms=3.5, mew=0.8)


def _in_burst(source: Indices, t: Floats) -> Mask:
    """Return which detections are object 1's while its echoes are wrong; t: of each."""
    return np.asarray((source == 0) & (t >= BURST_S[0]) & (t < BURST_S[1]))


def _quantities(course: _Course) -> tuple[Floats, ...]:
    return (course.position[:, 0], course.position[:, 2], course.radius, course.velocity[:, 0], course.velocity[:, 2])


def _line(axes: Axes, x: Floats, y: Floats, state: Ints, colour: str, label: str) -> None:
    """Draw a course, each state in its own style."""
    for value, style in STYLES.items():
        there = np.where(state == value, y, np.nan)
        if np.isfinite(there).any():
            axes.plot(
                x, there, style, color=colour, lw=1.8, label=label if value == lifecycle.ACTIVE and label else None
            )


def _mark(axes: Axes, one: Life, course: _Course, colour: str) -> list[tuple[str, float, float, str]]:
    """Mark when an object began (unless it was there from the start), went to stand-by and was discarded.

    Return the labels: text, t, north, colour.
    """
    began = one.began if one.began > STARTED_S else None
    labels = []
    for when, what, marker in ((began, "new", "^"), (one.stand_by, "stand-by", "o"), (one.ended, "gone", "x")):
        if when is not None:
            row = min(int(np.searchsorted(course.t, when)), len(course.t) - 1)
            north = float(course.position[row, 0])
            axes.plot(when, north, marker, color=colour, ms=8, mfc="none")
            labels.append((f"{one.id} {what}, {when:.0f} s", when, north, colour))
    return labels
