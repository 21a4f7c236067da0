"""Record of a run, on the bench or from a file."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

from ods.messages import Detections, Health, ObstacleList, Ping, Truth, VehicleSetPoint, VehicleTruth

ItemT = TypeVar("ItemT")


class Log(Protocol[ItemT]):
    """A list that grows at its end, in memory or not."""

    def append(self, item: ItemT, /) -> None:
        """Add one."""

    def __len__(self) -> int: ...

    def __getitem__(self, place: int, /) -> ItemT: ...

    def __iter__(self) -> Iterator[ItemT]: ...

    def __reversed__(self) -> Iterator[ItemT]: ...


def _reports() -> Mapping[str, Log[Health]]:
    return defaultdict(list)


@dataclass
class RunRecord:
    """Results of a run."""

    lists: Log[tuple[int, ObstacleList]] = field(default_factory=list)
    """(arrival, list) in order of arrival; arrival in CLOCK_MONOTONIC ns."""
    truths: Mapping[int, Truth] = field(default_factory=dict)
    """By ping number."""
    received: set[int] = field(default_factory=set)
    """Numbers of the pings that the sonar process has published."""
    unread_lists: int = 0
    """Obstacle lists that came, but faster than they were read here."""
    health: Mapping[str, Log[Health]] = field(default_factory=_reports)
    """By process."""
    kills: list[tuple[str, int]] = field(default_factory=list)
    """(process, monotonic ns)."""
    way: Log[VehicleTruth] = field(default_factory=list)
    """Path of the bench's vehicle, if it follows set points."""
    set_points: Log[VehicleSetPoint] = field(default_factory=list)
    """Set points of the planner."""
    image: tuple[Ping, Detections] | None = None
    """The newest ping and its detections."""
