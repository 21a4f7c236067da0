"""When pings were, and where some are missing, as a timeline shows it: of open data, or of a tracked mission."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ods.workbench.engine.data import PERIOD_PINGS, Data
from ods.workbench.engine.mission.marks import Mark, gap_marks, gaps_between
from ods.workbench.engine.mission.tracked import Tracked

GiveUp = Callable[[], bool]


@dataclass(frozen=True, eq=False)
class Moments:
    """Of `count` pings."""

    count: int
    t_s: Callable[[int], float] | None
    """Since the first ping, by place; None: no times are known."""
    period_s: float | None
    """None: not known."""
    gaps: Callable[[GiveUp], list[Mark]]
    """Returns where pings are missing, which may last; what it is given says when to give up."""


def moments_of(data: Data) -> Moments:
    """Return those of data."""
    gaps: Callable[[GiveUp], list[Mark]] = partial(gap_marks, data)
    return Moments(
        len(data.pings),
        data.t_s if data.timed else None,
        data.period_s,
        gaps if data.reference.kind == "file" else lambda _: [],
    )


def moments_of_mission(result: Tracked) -> Moments:
    """Return those of a tracked mission."""
    steps = np.diff(result.t_s[:PERIOD_PINGS])
    return Moments(
        len(result.t_s),
        lambda place: float(result.t_s[place]),
        float(np.median(steps)) if len(steps) else None,
        lambda _: gaps_between(list(enumerate(result.log.number.tolist()))),
    )
