"""Interface of every navigation source. Without I/O: frames or lines in, poses and problems out."""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable
from typing import ClassVar, Generic, NamedTuple, Protocol, TypeVar

from ods.base.clock import NS
from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.clocks.utc import Utc
from ods.nav_bridge.lever_arm import LeverArm
from ods.nav_bridge.settings import NavSettings

HELD_BACK = "the line or an adapter delays them; if that clock had stopped, restart nav"
NOTHING_COMES = "no data arrive on the line any more"
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
    utc: Utc


class Item(Protocol):
    """What comes off a line: a CAN frame, a line of text."""

    @property
    def t_ns(self) -> int:
        """Arrival, CLOCK_MONOTONIC."""


ItemT = TypeVar("ItemT", bound=Item)


class PoseSource(ABC, Generic[ItemT]):
    """One navigation system, by the data it sends."""

    kind: ClassVar[str]
    """What it speaks: CAN, NMEA."""

    def __init__(self, nav: NavSettings, now_ns: int) -> None:
        self._stale_ns = round(nav.stale_s * NS)
        self._oldest_ns = nav.limits.age_s * NS
        self._pose_ns = now_ns
        self._item_ns = now_ns
        """When anything came last."""
        self._worked = False
        """There was a pose."""
        self._lever_arm = LeverArm(nav.lever_arm_m)

    @abstractmethod
    def expects(self) -> dict[str, str]:
        """Return what must come for a pose, by the name that `name_of` gives it, with a word on what it carries."""

    def objections(self) -> list[str]:
        """Return what is unlikely of its files and settings, before anything came."""
        return []

    def unusable(self) -> dict[str, str]:
        """Return what comes of `expects`, but was never of use, and what is wrong with it."""
        return {}

    @abstractmethod
    def name_of(self, item: ItemT) -> str:
        """Return what people call the item: its CAN identifier, its sentence."""

    def take(self, item: ItemT) -> Pose | None:
        """Take one item; return the pose, of the body's origin, that it completes."""
        self._item_ns = item.t_ns
        pose = self._take(item)
        if pose is None:
            return None
        self._pose_ns, self._worked = item.t_ns, True
        return self._lever_arm.at_origin(pose)

    def problems(self, now_ns: int, overload: str = "") -> list[str]:
        """Return the problems of pose and source, a text each.

        overload: text that the computer is overloaded, which delays all data; or "".
        """
        stale_ns = self.stale_ns(now_ns)
        if stale_ns and self._fell_silent(now_ns):
            return [f"no pose for {stale_ns / NS:.1f} s: {NOTHING_COMES}"]  # all else follows
        stale = [f"no pose for {stale_ns / NS:.1f} s"] if stale_ns else []
        if stale and self.late_ns > self._oldest_ns:  # what is less late would be used
            stale.append(f"data arrive {self.late_ns / NS:.1f} s late by the INS's clock: {overload or HELD_BACK}")
        return stale + self._complaints(now_ns)

    def _fell_silent(self, now_ns: int) -> bool:
        """Return whether a source that worked has become silent: it is off, or its line is cut."""
        worked = self._worked and self._item_ns - self._pose_ns < self._stale_ns
        return worked and now_ns - self._item_ns > self._stale_ns

    def stale_ns(self, now_ns: int) -> int:
        """Return the time without a pose, ns, 0 while that is no problem."""
        silent_ns = now_ns - self._pose_ns
        return silent_ns if silent_ns > self._stale_ns else 0

    @property
    def late_ns(self) -> int:
        """Delay of the newest data by the INS's clock, ns; 0 without such a clock."""
        return 0

    def opened(self) -> None:
        """Take note that the line has been opened."""

    def tick(self, now_ns: int) -> None:
        """Send what is due; called often while the line is open."""

    def waits_for_start(self, now_ns: int) -> bool:
        """Return whether the source is there, as far as its messages show, but sends nothing until it is started."""
        return False

    def idle_ns(self, now_ns: int) -> int | None:
        """Return how long `tick` may wait; None: as long as everyone else's."""
        return None

    @abstractmethod
    def _take(self, item: ItemT) -> Pose | None: ...

    @abstractmethod
    def _complaints(self, now_ns: int) -> list[str]: ...
