"""The tables of `ods assess sea`."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ods.assess.sea.judge import LOUD_DB, NEAR_M, SETTLE_S, SceneScore, TargetScore

FALSE_LIMIT = 2.0
"""False obstacles a minute that may be."""
TRACKED_LIMIT = 0.95
"""Share of the lists that an object must be in."""
LATE_S = 1.0
"""Time in which an object is to be confirmed."""
MARGINS_DB = (2.0, 4.0, 6.0, 8.0, 10.0)
"""Between the spans of margins that are distinguished."""


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
            score.name,
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
    table = _table("scene", "object", "lists", "tracked", "confirmed at m", "after s", "margin dB")
    table.caption = "margin: median level over the surroundings, less the detection threshold"
    for score in scores:
        for target in score.targets:
            table.add_row(
                score.name if target is score.targets[0] else "",
                target.name,
                str(target.expected),
                _share(target.share),
                _number(target.confirmed_m, 1),
                _number(target.confirmed_s, 2),
                "" if math.isnan(target.margin_db) else f"{target.margin_db:.0f}",
            )
    return table


def margin_table(scores: Sequence[SceneScore]) -> Table:
    """Return how many objects of each margin are tracked as they should be."""
    table = _table("margin dB", "objects", f"tracked in {TRACKED_LIMIT:.0%} of the lists", "tracked, mean")
    targets = [target for score in scores for target in score.targets if not math.isnan(target.margin_db)]
    for low, high in pairwise((-math.inf, *MARGINS_DB, math.inf)):
        shares = [target.share for target in targets if low <= target.margin_db < high]
        if shares:
            name = f"{low:.0f} to {high:.0f}" if math.isfinite(low + high) else _open_span(low, high)
            enough = sum(share >= TRACKED_LIMIT for share in shares)
            table.add_row(name, str(len(shares)), str(enough), f"{sum(shares) / len(shares):.0%}")
    return table


def condensed(scores: Sequence[SceneScore]) -> list[str]:
    """Return the lines of one Markdown table of what is not as it should be: a line a scene, a column a seed."""
    seeds = sorted({score.seed for score in scores})
    drawn = {(score.scene, score.seed): score for score in scores}
    said: list[tuple[str, Callable[[SceneScore], str]]] = [
        ("false a minute", lambda score: f"{score.false_a_minute:.1f}"),
        (f"tracked in less than {TRACKED_LIMIT:.0%} of the lists", lambda score: _listed(_lost(score))),
        (f"confirmed later than {LATE_S:g} s, s", lambda score: _listed(_late(score))),
    ]
    rows = [["scene", *(f"{heading}, seed {seed}" for heading, _ in said for seed in seeds)]]
    rows.append(["---"] * len(rows[0]))
    for scene in dict.fromkeys(score.scene for score in scores):
        of_scene = [drawn[scene, seed] for seed in seeds]
        rows.append([scene, *(say(score) for _, say in said for score in of_scene)])
    sums = [sum(score.false_a_minute for score in scores if score.seed == seed) for seed in seeds]
    rows.append(["sum", *(f"{false:.1f}" for false in sums), *[""] * (2 * len(seeds))])
    return [f"| {' | '.join(row)} |" for row in rows]


def _lost(score: SceneScore) -> list[tuple[TargetScore, str]]:
    return [(each, f"{each.share:.0%}") for each in score.targets if each.share < TRACKED_LIMIT]


def _late(score: SceneScore) -> list[tuple[TargetScore, str]]:
    return [(each, f"{each.confirmed_s:.2f}") for each in score.targets if each.confirmed_s > LATE_S]


def _listed(found: Sequence[tuple[TargetScore, str]]) -> str:
    return ", ".join(f"{target.name} {figure}" for target, figure in found)


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


def _open_span(low: float, high: float) -> str:
    return f"from {low:.0f} on" if math.isfinite(low) else f"under {high:.0f}"


def _share(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.1%}"


def _number(value: float, digits: int) -> str:
    return "never" if math.isnan(value) else f"{value:.{digits}f}"
