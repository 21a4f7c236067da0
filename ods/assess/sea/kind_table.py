"""The table of `ods assess sea --kinds`, in Markdown."""

import math
from collections.abc import Sequence

from ods.assess.sea.judge import SceneScore, TargetScore
from ods.assess.sea.kind_judge import KindScore
from ods.assess.sea.table import TRACKED_LIMIT

HEADINGS = (
    *("kind", "wanted", "false", "at a time", "objects: share of the lists", "first reported after, s", "marked"),
    *("valid", "said, first at s", "error m", "NEES"),
)
FEW = 5
"""Objects that are named one by one."""


def kind_table(scores: Sequence[KindScore]) -> list[str]:
    """Return the lines."""
    rows = [list(HEADINGS), ["---"] * len(HEADINGS), *(_cells(score) for score in scores)]
    return [f"| {' | '.join(row)} |" for row in rows]


def _cells(score: KindScore) -> list[str]:
    scene = score.scene
    return [
        scene.name,
        score.kind.wanted,
        str(scene.false_ids),
        f"{scene.false_at_a_time:.1f}",
        shares(scene),
        times(scene),
        str(score.marked),
        f"{score.valid:.0%}",
        "; ".join(f"{text} ({t_s:.1f})" for text, t_s in score.said),
        _number(score.error_m),
        _number(score.nees),
    ]


def shares(score: SceneScore) -> str:
    """Return each object's share of the lists; of many, how many are in enough and which are in fewest."""
    wanted = [target for target in score.targets if target.expected]
    if len(wanted) <= FEW:
        return ", ".join(f"{target.name} {target.share:.0%}" for target in wanted)
    enough = sum(target.share >= TRACKED_LIMIT for target in wanted)
    least = sorted(wanted, key=lambda target: target.share)[:FEW]
    return f"{enough} of {len(wanted)} in {TRACKED_LIMIT:.0%}; least: " + ", ".join(
        f"{target.name} {target.share:.0%}" for target in least
    )


def times(score: SceneScore) -> str:
    """Return how long after it is loud each object is first listed; of many, the latest."""
    wanted = [target for target in score.targets if target.expected]
    if len(wanted) <= FEW:
        return ", ".join(f"{target.name} {_after(target)}" for target in wanted)
    found = [target for target in wanted if not math.isnan(target.confirmed_s)]
    latest = sorted(found, key=lambda target: -target.confirmed_s)[:FEW]
    never = len(wanted) - len(found)
    named = ", ".join(f"{target.name} {_after(target)}" for target in latest)
    return f"{never} never; latest: {named}"


def _after(target: TargetScore) -> str:
    return "never" if math.isnan(target.confirmed_s) else f"{target.confirmed_s:.1f}"


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.2f}"
