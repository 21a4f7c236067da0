"""A tracked mission over time: the states of all objects' lives [SSIE figure 5], and one object's course [figure 7]."""

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.workbench.engine.mission.tracked import Course, Tracked, TrueCourse
from ods.workbench.pages.mission.plan import ROLES, SIGMAS
from ods.workbench.web.views.chart_view import Axis, Band, Curve, Panel, Strip

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
TRUE, WITHIN = "truth", "two standard deviations"
"""In the legend."""
LEAST_M = 0.5
"""Least span of an axis, m or m/s."""


def looked_at(result: Tracked, marked: int | None) -> Course | None:
    """Return the course of the marked object; where there is none, that of the one that was listed most often."""
    return result.course(marked) or max(result.courses, key=lambda course: len(course.t_s), default=None)


def strips(result: Tracked, marked: int | None) -> list[Strip]:
    """Return the lives of all objects, or of those that were listed most often, in the order of their ids."""
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
    curves = [_curve(course, chosen, values)]
    if truth is not None:
        some = _evenly(len(truth.t_s))
        curves.append(Curve("truth", TRUE, truth.t_s[some], getattr(truth, name)[some, axis]))
    return Panel(Axis(title, span=LEAST_M), curves, [_band(course, chosen, values, sigma)], title=title)


def _radius(result: Tracked, course: Course, truth: TrueCourse | None, chosen: Indices) -> Panel:
    curves = [_curve(course, chosen, course.radius)]
    if truth is not None and len(result.t_s):
        curves.append(Curve("truth", TRUE, result.t_s[[0, -1]], np.full(2, truth.radius_m)))
    bands = [_band(course, chosen, course.radius, course.sigma_radius)]
    return Panel(Axis("radius, m", span=LEAST_M), curves, bands, title="radius, m")


def _accuracy(result: Tracked) -> Panel:
    some = _evenly(len(result.t_s))
    curve = Curve("quiet", "all objects", result.t_s[some], result.gospa_m[some])
    return Panel(Axis("GOSPA, m", span=1.0), [curve], title="GOSPA, m")


def _existence(course: Course, chosen: Indices) -> Panel:
    title = "probability of existence"
    return Panel(Axis(title, span=1.0), [_curve(course, chosen, course.existence)], title=title)


def _curve(course: Course, chosen: Indices, values: Floats) -> Curve:
    return Curve("active", "tracked", course.t_s[chosen], _with_gaps(course, chosen, values))


def _band(course: Course, chosen: Indices, values: Floats, sigma: Floats) -> Band:
    low, high = values - SIGMAS * sigma, values + SIGMAS * sigma
    times = course.t_s[chosen]
    return Band("uncertainty", WITHIN, times, _with_gaps(course, chosen, low), _with_gaps(course, chosen, high))


def _chosen(course: Course) -> Indices:
    """Return evenly some of the rows, and those at the ends of gaps."""
    breaks = np.flatnonzero(np.diff(course.place) > 1)
    return np.unique(np.concatenate([_evenly(len(course.t_s)), breaks, breaks + 1]))


def _with_gaps(course: Course, chosen: Indices, values: Floats) -> Floats:
    """Return chosen values, NaN at the last one before the lists left the object out."""
    leaves = np.append(np.diff(course.place) > 1, False)[chosen]
    return np.where(leaves, np.nan, values[chosen])


def _evenly(count: int) -> Indices:
    return np.unique(np.linspace(0, max(0, count - 1), min(count, MOST_VALUES)).astype(np.int64))
