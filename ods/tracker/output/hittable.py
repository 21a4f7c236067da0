"""Selection of the reported objects: parts of the bottom and waves of the surface are left out."""

from typing import NamedTuple

from ods.tracker.output.bottom import Bottom, may_be_hit
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.output.surface import View, WaveFilter
from ods.tracker.settings import TrackerSettings


class Hittable(NamedTuple):
    """The objects that could be hit, and how many others there are."""

    snapshot: Snapshot
    left_out: int


class ReportableFilter:
    """Chooses, list by list."""

    def __init__(self, settings: TrackerSettings) -> None:
        self._bottom = settings.bottom
        self._waves = WaveFilter(settings.surface)

    def of(self, everything: Snapshot, bottom: Bottom | None, view: View | None) -> Hittable:
        """Return what the planner receives of `everything`; bottom: if it is known."""
        standing = everything.take(may_be_hit(everything, bottom, self._bottom))
        waves = self._waves.among(standing, view)
        hittable = standing.take(~waves)
        return Hittable(hittable, len(everything) - len(hittable))
