"""Selection of the reported objects: parts of the bottom and waves of the surface are left out."""

from ods.tracker.output.bottom import Bottom, is_reportable
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.output.surface import View, WaveFilter
from ods.tracker.settings import TrackerSettings


class ReportableFilter:
    """Chooses, list by list."""

    def __init__(self, settings: TrackerSettings) -> None:
        self._bottom = settings.bottom
        self._waves = WaveFilter(settings.surface)

    def of(self, everything: Snapshot, bottom: Bottom | None, view: View | None) -> Snapshot:
        """Return those of `everything` that could be hit, which the planner receives; bottom: if it is known."""
        standing = everything.take(is_reportable(everything, bottom, self._bottom))
        return standing.take(~self._waves.among(standing, view))
