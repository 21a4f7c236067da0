"""What a run leaves, on the bench or from a file."""

from collections import defaultdict
from dataclasses import dataclass, field

from ods.messages import Detections, Health, ObstacleList, Ping, Truth


@dataclass
class RunRecord:
    """What a run leaves."""

    lists: list[tuple[int, ObstacleList]] = field(default_factory=list)
    """(arrival, list) in order of arrival; arrival in CLOCK_MONOTONIC ns."""
    truths: dict[int, Truth] = field(default_factory=dict)
    """By ping number."""
    received: set[int] = field(default_factory=set)
    """Numbers of the pings that the sonar process has published."""
    health: dict[str, list[Health]] = field(default_factory=lambda: defaultdict(list))
    """By process."""
    kills: list[tuple[str, int]] = field(default_factory=list)
    """(process, monotonic ns)."""
    image: tuple[Ping, Detections] | None = None
    """The newest ping and its detections."""
