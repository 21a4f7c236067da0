"""Recorded messages of one topic, up to those that a process had received at a time."""

from collections.abc import Iterator
from typing import Generic, TypeVar

import msgspec

from ods.base.clock import NS
from ods.messages import Detections, Health, ObstacleList, Pose, VetoOrder
from ods.recording.mcap.reader import Recorded, Recording

MessageT = TypeVar("MessageT", bound=msgspec.Struct)

SLACK_NS = NS
"""Longest time by which the recorder may receive a message later than its user."""


class Stream(Generic[MessageT]):
    """The messages of one topic in the order in which they came, with a look at the next one."""

    def __init__(self, messages: Iterator[tuple[int, MessageT]]) -> None:
        """Take (log time, message) pairs."""
        self._messages = messages
        self.upcoming = next(messages, None)

    def take(self) -> MessageT:
        """Return the upcoming message, and go on."""
        if self.upcoming is None:
            raise LookupError("no more messages")
        _, message = self.upcoming
        self.upcoming = next(self._messages, None)
        return message


def messages_of(recording: Recording, topic: str, kind: type[MessageT]) -> Iterator[tuple[int, MessageT]]:
    """Yield log time and message; what is malformed is counted among the recording's losses. Raises RecordingError."""
    for recorded in recording.messages([topic]):
        message = message_of(recording, recorded)
        if isinstance(message, kind):
            yield recorded.log_ns, message


def message_of(recording: Recording, recorded: Recorded) -> msgspec.Struct | None:
    """Return a recorded message; None, and counted, where it is malformed."""
    try:
        return recorded.message()
    except ValueError:
        recording.losses[f"bad_{recorded.topic}"] += 1
        return None


class PoseStream:
    """Poses as a process received them, by `poses_until` and `poses_heard` in its messages.

    `missing`: how often the newest pose that it knew was not recorded.
    """

    def __init__(self, recording: Recording) -> None:
        self._poses = Stream(messages_of(recording, "pose", Pose))
        self._last: int | None = None
        self._received = 0
        self.missing = 0

    def begin(self) -> None:
        """From now on another process receives them."""
        self._received = 0

    def until(self, message: Detections | ObstacleList, now_ns: int) -> list[Pose]:
        """Return the poses that the process received since the last call and before it made a message, at `now_ns`.

        Of those in between it received the newest: the others were sent before it was connected, or it was busy.
        """
        seq, found = message.poses_until, list[Pose]()
        while seq >= 0 and self._last != seq:
            upcoming = self._poses.upcoming
            lost = upcoming is not None and (self._last is None or self._last < seq) and seq < upcoming[1].seq
            later = upcoming is not None and upcoming[0] > now_ns + SLACK_NS
            if upcoming is None or lost or later:
                self.missing += 1
                break
            self._last = upcoming[1].seq
            found.append(self._poses.take())
        new = message.poses_heard - self._received
        self._received = message.poses_heard
        return found[max(0, len(found) - new) :] if message.poses_heard else found


class HealthStream:
    """Health reports up to an instant. When a process received one is not recorded, only when the recorder did."""

    def __init__(self, recording: Recording) -> None:
        self._reports = Stream(messages_of(recording, "health", Health))

    def until(self, now_ns: int) -> Iterator[Health]:
        """Yield the reports not yielded yet that had come by then."""
        while self._reports.upcoming is not None and self._reports.upcoming[0] <= now_ns:
            yield self._reports.take()


class OrderStream:
    """Operators' orders that a tracker carried out, up to an instant."""

    def __init__(self, recording: Recording) -> None:
        self._orders = Stream(messages_of(recording, "veto-orders", VetoOrder))

    def until(self, now_ns: int) -> Iterator[VetoOrder]:
        """Yield those not reported yet that had been carried out by then."""
        while self._orders.upcoming is not None and self._orders.upcoming[1].t_ns <= now_ns:
            order = self._orders.take()
            if not order.refused:
                yield order


class DetectionsStream:
    """Detections, found by the instant of their ping."""

    def __init__(self, detections: Iterator[tuple[int, Detections]]) -> None:
        self._found = Stream(detections)

    def of(self, t_ns: int) -> Detections | None:
        """Return the detections of the ping sent at `t_ns`, behind those asked for before; None: not recorded."""
        while self._found.upcoming is not None and self._found.upcoming[1].t_ns < t_ns:
            self._found.take()
        if self._found.upcoming is None or self._found.upcoming[1].t_ns != t_ns:
            return None
        return self._found.take()
