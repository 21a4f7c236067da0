"""A tracked mission over time: the states of all objects' lives [SSIE figure 5], and one object's course [figure 7]."""

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.workbench.engine.mission.tracked import Course, Tracked, TrueCourse
from ods.workbench.pages.mission.plan import ROLES, SIGMAS
from ods.workbench.web.time_view import Band, Curve, Panel, Series, Strip

MOST_VALUES = 500
"""Of a curve."""
MOST_STRIPS = 12
QUANTITIES = (
    ("north, m", "position", 0),
    ("velocity north, m/s", "velocity", 0),
    ("east, m", "position", 1),
    ("velocity east, m/s", "velocity", 1),
    ("down, m", "position", 2),
    ("velocity down, m/s", "velocity", 2),
)
LEAST_M = 0.5
"""An axis spans so much at least, m or m/s."""


def looked_at(result: Tracked, marked: int | None) -> Course | None:
    """Return the course of the marked object; where there is none, that of the one that was told of most often."""
    return result.course(marked) or max(result.courses, key=lambda course: len(course.t_s), default=None)


def strips(result: Tracked, marked: int | None) -> list[Strip]:
    """Return the lives of all objects, or of those that were told of most often, in the order of their ids."""
    often = sorted(result.courses, key=lambda course: (course.id == marked, len(course.t_s)), reverse=True)
    return [
        Strip(
            str(course.id),
            result.name_of(course.id),
            [(ROLES[span.state], round(span.from_s, 3), round(span.to_s, 3)) for span in course.lives()],
            marked=course.id == marked,
        )
        for course in sorted(often[:MOST_STRIPS], key=lambda course: course.id)
    ]


def panels(result: Tracked, course: Course | None) -> list[Panel]:
    """Return the diagrams of one object's place, velocity and radius with the truth, and of the mission's accuracy."""
    if course is None:
        return []
    truth = result.truth_of(course.id)
    chosen = _chosen(course)
    shown = [_quantity(course, truth, chosen, *quantity) for quantity in QUANTITIES]
    shown.append(_radius(result, course, truth, chosen))
    shown.append(_accuracy(result) if truth is not None else _existence(course, chosen))
    return shown


def _quantity(
    course: Course, truth: TrueCourse | None, chosen: Indices, title: str, name: str, axis: int
) -> Panel:  # fmt: skip
    values, sigma = getattr(course, name)[:, axis], getattr(course, f"sigma_{name}")[:, axis]
    lines = [_curve(course, chosen, values)]
    if truth is not None:
        some = _evenly(len(truth.t_s))
        lines.append(Curve("truth", "truth", _times(truth.t_s[some]), _told(getattr(truth, name)[some, axis])))
    return Panel(title, lines, [_band(course, chosen, values, sigma)], LEAST_M)


def _radius(result: Tracked, course: Course, truth: TrueCourse | None, chosen: Indices) -> Panel:
    lines = [_curve(course, chosen, course.radius)]
    if truth is not None and len(result.t_s):
        lines.append(Curve("truth", "truth", _times(result.t_s[[0, -1]]), [truth.radius_m] * 2))
    return Panel("radius, m", lines, [_band(course, chosen, course.radius, course.sigma_radius)], LEAST_M)


def _accuracy(result: Tracked) -> Panel:
    some = _evenly(len(result.t_s))
    curve = Curve("quiet", "all objects", _times(result.t_s[some]), _told(result.gospa_m[some]))
    return Panel("GOSPA, m", [curve], least=1.0)


def _existence(course: Course, chosen: Indices) -> Panel:
    return Panel("probability to exist", [_curve(course, chosen, course.existence)], least=1.0)


def _curve(course: Course, chosen: Indices, values: Floats) -> Curve:
    return Curve("active", "tracked", _times(course.t_s[chosen]), _with_gaps(course, chosen, values))


def _band(course: Course, chosen: Indices, values: Floats, sigma: Floats) -> Band:
    low, high = values - SIGMAS * sigma, values + SIGMAS * sigma
    times = _times(course.t_s[chosen])
    return Band("uncertainty", times, _with_gaps(course, chosen, low), _with_gaps(course, chosen, high))


def _chosen(course: Course) -> Indices:
    """Return evenly some of the rows, and those at the ends of gaps."""
    breaks = np.flatnonzero(np.diff(course.place) > 1)
    return np.unique(np.concatenate([_evenly(len(course.t_s)), breaks, breaks + 1]))


def _with_gaps(course: Course, chosen: Indices, values: Floats) -> Series:
    """Return chosen values, None at the last one before the lists left the object out."""
    leaves = np.append(np.diff(course.place) > 1, False)[chosen]
    return [None if gone else value for gone, value in zip(leaves.tolist(), _told(values[chosen]), strict=True)]


def _evenly(count: int) -> Indices:
    return np.unique(np.linspace(0, max(0, count - 1), min(count, MOST_VALUES)).astype(np.int64))


def _times(t_s: Floats) -> list[float]:
    return [round(t, 4) for t in t_s.tolist()]


def _told(values: Floats) -> list[float | None]:
    return [round(value, 4) if value == value else None for value in values.tolist()]
