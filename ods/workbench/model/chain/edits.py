"""The chain of stages changed: stages put in, taken out, moved and bypassed."""

from collections.abc import Callable

import msgspec

from ods.pipeline.settings import StageTable
from ods.workbench.model.paths import PathError, tables_of, typed
from ods.workbench.model.state import Tuning

Entry = tuple[StageTable, bool]
"""A stage, and whether it is bypassed."""


def edited(tuning: Tuning, change: Callable[[list[Entry]], None]) -> Tuning:
    """Return a tuning whose chain `change` has edited; the chain is checked. Raises PathError."""
    entries = [(dict(stage), place in tuning.bypassed) for place, stage in enumerate(tuning.config.pipeline.chain())]
    change(entries)
    if not entries:
        raise PathError("pipeline.stage: the last stage cannot be removed")
    tables = tables_of(tuning.config)
    tables["pipeline"]["stage"] = [stage for stage, _ in entries]
    bypassed = tuple(place for place, (_, bypass) in enumerate(entries) if bypass)
    return Tuning(config=typed(tables, type(tuning.config)), bypassed=bypassed)


def with_stage(tuning: Tuning, use: str, at: int) -> Tuning:
    """Put a stage at a place, with default parameters. Raises PathError."""
    return edited(tuning, lambda entries: entries.insert(_place(at, len(entries) + 1), ({"use": use}, False)))


def without_stage(tuning: Tuning, at: int) -> Tuning:
    """Take a stage out. Raises PathError."""
    return edited(tuning, lambda entries: entries.__delitem__(_place(at, len(entries))))


def with_stage_moved(tuning: Tuning, at: int, to: int) -> Tuning:
    """Take a stage to another place; the others close up. Raises PathError."""

    def move(entries: list[Entry]) -> None:
        entry = entries.pop(_place(at, len(entries)))
        entries.insert(_place(to, len(entries) + 1), entry)

    return edited(tuning, move)


def with_bypass(tuning: Tuning, at: int, on: bool) -> Tuning:
    """Bypass a stage, or no more; the last one, which detects, has to run. Raises PathError."""
    count = len(tuning.config.pipeline.chain())
    if on and _place(at, count) == count - 1:
        raise PathError("pipeline.stage: the stage that detects cannot be bypassed")
    kept = {place for place in tuning.bypassed if place != _place(at, count)}
    return msgspec.structs.replace(tuning, bypassed=tuple(sorted(kept | {at} if on else kept)))


def _place(at: int, count: int) -> int:
    if not 0 <= at < count:
        raise PathError(f"pipeline.stage[{at}]: no such place in the chain")
    return at
