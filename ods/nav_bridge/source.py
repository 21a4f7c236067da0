"""What every kind of navigation source is to the nav process. Without I/O: CAN frames in, poses and plain words out."""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

from ods.base.clock import NS
from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.can.frame import CanId, Frame

Send = Callable[[int, bytes], None]
"""Sends one data frame with a standard identifier."""


class SourceHost(NamedTuple):
    """What a source is given by its process."""

    frame: LocalFrame
    """Of the poses."""
    send: Send
    counters: Counter[str]
    now_ns: int
    """When it was made, CLOCK_MONOTONIC."""
    utc_of: Callable[[int], int]
    """UTC, ns, of an instant of CLOCK_MONOTONIC."""


class PoseSource(ABC):
    """One navigation system as its frames tell of it."""

    def __init__(self, stale_s: float, now_ns: int) -> None:
        self._stale_ns = round(stale_s * NS)
        self._pose_ns = now_ns

    @property
    @abstractmethod
    def ids(self) -> frozenset[CanId]:
        """CAN identifiers that `take` wants."""

    @abstractmethod
    def expects(self) -> dict[CanId, str]:
        """Return what must come for a pose, by identifier, with a word on what it carries."""

    def take(self, frame: Frame) -> Pose | None:
        """Take one frame; return the pose that it completes."""
        pose = self._take(frame)
        if pose is not None:
            self._pose_ns = frame.t_ns
        return pose

    def problems(self, now_ns: int) -> list[str]:
        """Say in plain words what is wrong with pose and source."""
        stale_ns = self.stale_ns(now_ns)
        stale = [f"no pose for {stale_ns / NS:.1f} s"] if stale_ns else []
        return stale + self._complaints(now_ns)

    def stale_ns(self, now_ns: int) -> int:
        """Return for how long there has been no pose, 0 while that is no problem."""
        silent_ns = now_ns - self._pose_ns
        return silent_ns if silent_ns > self._stale_ns else 0

    def opened(self) -> None:  # noqa: B027
        """Take note that the bus has been opened."""

    def tick(self, now_ns: int) -> None:  # noqa: B027
        """Send what is due; called often while the bus is open."""

    def waits_for_start(self, now_ns: int) -> bool:
        """Tell whether the source is there, as far as one can hear, but will send nothing until it is started."""
        return False

    def idle_ns(self, now_ns: int) -> int | None:
        """Return how long `tick` may wait; None: as long as everyone else's."""
        return None

    @abstractmethod
    def _take(self, frame: Frame) -> Pose | None: ...

    @abstractmethod
    def _complaints(self, now_ns: int) -> list[str]: ...
