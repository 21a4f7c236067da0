"""Numbers of the chain that no table says, as they follow from the smallest object: shown, and written out."""

import msgspec

from ods.pipeline.settings import Columns, StageTable, columns_of, leaves_numbers, with_numbers
from ods.workbench.model.chain.edits import Entry, edited
from ods.workbench.model.state import Tuning


def follows(tuning: Tuning) -> bool:
    """Return whether numbers of the chain that runs follow from the smallest object."""
    return leaves_numbers(tuning.pipeline().chain())


def columns(tuning: Tuning, dr_m: float) -> Columns:
    """Return what follows, for this spacing of range samples."""
    settings = tuning.config.pipeline
    return columns_of(settings.smallest_object_m, dr_m, settings.attention.subsample)


def numbered(tuning: Tuning, dr_m: float) -> tuple[StageTable, ...]:
    """Return all stages, those that are bypassed too, with the numbers that they run by."""
    chain = tuning.config.pipeline.chain()
    return with_numbers(chain, columns(tuning, dr_m)) if follows(tuning) else chain


def written(tuning: Tuning, dr_m: float) -> Tuning:
    """Return a tuning whose tables say these numbers, so that none of them changes with another. Raises PathError."""
    if not follows(tuning):
        return tuning
    pipeline, found = tuning.config.pipeline, columns(tuning, dr_m)
    attention = msgspec.structs.replace(pipeline.attention, subsample=found.subsample)
    plain = msgspec.structs.replace(pipeline, smallest_object_m=0.0, attention=attention)

    def write(entries: list[Entry]) -> None:
        stages = with_numbers([stage for stage, _ in entries], found)
        entries[:] = [(stage, bypassed) for stage, (_, bypassed) in zip(stages, entries, strict=True)]

    config = msgspec.structs.replace(tuning.config, pipeline=plain)
    return edited(msgspec.structs.replace(tuning, config=config), write)
