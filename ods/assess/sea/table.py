"""The tables of `ods assess sea`."""

import math
from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ods.assess.sea.judge import LOUD_DB, NEAR_M, SETTLE_S, SceneScore

FALSE_LIMIT = 2.0
"""False obstacles a minute that may be."""
TRACKED_LIMIT = 0.95
"""Share of the lists that an object must be in."""


def scene_table(scores: Sequence[SceneScore]) -> Table:
    """Return one line a scene."""
    table = _table("scene", "false a minute", "false at a time", "least tracked", "detections a ping", "chain ms",
                   "tracker ms", "reached")  # fmt: skip
    table.caption = (
        f"false: active obstacles over {NEAR_M:g} m from all there is, in most lists; "
        f"tracked: share of the lists from {SETTLE_S:g} s after an object is {LOUD_DB:g} dB over its surroundings"
    )
    for score in scores:
        table.add_row(
            score.scene,
            f"{score.false_a_minute:.1f}",
            f"{score.false_at_a_time:.2f}",
            _share(score.least_share),
            f"{score.detections:.1f}",
            f"{score.chain_ms:.2f}",
            f"{score.tracker_ms:.2f}",
            _reached(score),
        )
    return table


def target_table(scores: Sequence[SceneScore]) -> Table:
    """Return one line an object."""
    table = _table("scene", "object", "lists", "tracked", "confirmed at m", "after s")
    for score in scores:
        for target in score.targets:
            table.add_row(
                score.scene if target is score.targets[0] else "",
                target.name,
                str(target.expected),
                _share(target.share),
                _number(target.confirmed_m, 1),
                _number(target.confirmed_s, 2),
            )
    return table


def _table(*headings: str) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=(0, 0, 0, 1))
    for heading in headings:
        table.add_column(heading, justify="left" if heading in ("scene", "object", "reached") else "right")
    return table


def _reached(score: SceneScore) -> str:
    missed = []
    if score.false_a_minute > FALSE_LIMIT:
        missed.append("false")
    if score.least_share < TRACKED_LIMIT:
        missed.append("tracked")
    return f"[red]not: {', '.join(missed)}" if missed else "[green]yes"


def _share(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.1%}"


def _number(value: float, digits: int) -> str:
    return "never" if math.isnan(value) else f"{value:.{digits}f}"
