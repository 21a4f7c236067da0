"""Clock synchronisation: a device's clock mapped onto CLOCK_MONOTONIC by a minimum filter over one-way delays.

The message with the least delay gives the best offset: F. Cristian, Probabilistic clock synchronization, Distributed
Computing 3 (1989), 146-158. That a clock was set shows in delays that change at once and stay so, and, as delays are
never negative, in messages that would have come before they were sent: V. Paxson, On calibrating measurements of packet
transit times, ACM SIGMETRICS 1998, 11-21.
"""

from collections import deque
from typing import NamedTuple

DRIFT_DIVISOR = 10_000
"""A device's clock drifts by at most one part in this many: 100 ppm."""
CONFIRMATIONS = 4
"""Consecutive messages that must agree before a jump of a device's clock is believed."""
STEP_NS = 10_000_000
"""Messages no later than this are late by the jitter of a line, not by a step of the device's clock."""
STEP_CONFIRMATIONS = 8
"""Consecutive late messages that must agree before they are taken for a step back that shows in nothing else."""
STEP_SHARE = 4
"""One over the share of the least lateness within which they agree: jitter does not."""
STEP_PACE = 16
"""One over the share of the device's time between them: the delays of a backlog shrink as it is read."""
PACE_OF = 8
"""Number of messages from whose device times the device's pace is estimated."""
PACE_SLACK = 1.5
"""A gap of this many times the longest of the device's times between two messages means that messages were lost."""
MOST_LOST = 9
"""Largest number of messages that a stalling line loses."""
LOST_SHARE = 5
"""A stalling line loses at most the waiting time over this; with more, the device was silent."""


class OffsetEstimator:
    """Maps the clock of one device.

    Delays only add, so the offset is the lower envelope of arrival - device time over the last `window` messages. An
    old minimum is allowed to have grown by 100 ppm of its age, so that a drifting clock is followed. A low value
    counts once two messages in a row stand for it: so small steps forward are followed.

    Messages are late or early by the envelope; those off it by more than `jump_ns` are wild, and leave it alone:

                   late by more than STEP_NS           no delay explains it
        TRUSTED -----------------------------> LATE -------------------------> STEPPED
         ^   ^                                 |  |                            |  |
         |   '------ on the envelope ----------'--|----------------------------'  |
         |                                        |                               |
         '------ confirmed: a new envelope -------'-------------------------------'

    A message's time is taken from the envelope, in STEPPED from its arrival less what the line holds it back. No delay
    explains one that is early and wild, or whose device time lies before the last one's, as messages keep their order
    on the way. A new envelope is confirmed by messages in a row, all off the old one:

        in STEPPED  CONFIRMATIONS that are wild and give the same offset
        in both     STEP_CONFIRMATIONS that are late and give the same offset

    The offsets that they give are those without the time waited longer for messages than the device, which continued at
    its pace, let pass between them: the line's delays, whether it sends bursts, reads a backlog or stalls. A step back
    leaves the arrivals at their pace and shows in the device time. Messages whose lateness such waits explain are held
    back by the line, however long, and no step: they are neither learned nor confirm anything. A step back in a silence
    that is about as long as the step cannot be distinguished from a line that stalls, and is taken for that.
    """

    def __init__(self, window: int = 64, jump_ns: int = 500_000_000) -> None:
        self.jumps = 0
        """Jumps of the device's clock, and steps back, that were believed."""
        self.wild = 0
        """Messages further than `jump_ns` from the envelope."""
        self.held_back_ns = 0
        """How late the newest message is by waits for it alone, 0 when it is not."""
        self._window = window
        self._jump_ns = jump_ns
        self._suspects: deque[_Message] = deque(maxlen=STEP_CONFIRMATIONS)
        """The messages that came last, one after another, and all off the envelope."""
        self._wild_run = 0
        self._no_delay = False
        """Something among the suspects is not explained by delays."""
        self._envelope: deque[tuple[int, int]] = deque()  # (message number, key), both rising: a sliding minimum
        self._messages = 0
        self._newest_device_ns: int | None = None
        self._last: tuple[int, int] | None = None
        """(device time, arrival) of the message that came last."""
        self._pace = _Pace()
        self._waited_ns = 0
        """How much of the messages' lateness came with waits for them; all of one's on the envelope."""
        self._previous_key: int | None = None

    def map(self, device_ns: int, arrival_ns: int) -> int:
        """Return the monotonic time of `device_ns`, ns, never later than its message's arrival, and learn from it."""
        self._watch_waits(device_ns, arrival_ns)
        wild = self._suspect(device_ns, arrival_ns)
        self.held_back_ns = self._late_by_waits_ns(device_ns, arrival_ns)
        confirming = [] if self.held_back_ns else self._jumped() or self._stepped_back()
        if confirming:
            self._rebase(confirming)
        elif not wild and not self.held_back_ns:
            self._learn(device_ns, arrival_ns)
        if confirming or not wild:
            self._newest_device_ns = device_ns
        return arrival_ns - _held_ns(self._waited_ns) if self._no_delay else self._mapped(device_ns, arrival_ns)

    def _watch_waits(self, device_ns: int, arrival_ns: int) -> None:
        """Add up by how much longer one waited for messages than the device, which went on at its pace."""
        if self._last is not None:
            gap_ns, wait_ns = device_ns - self._last[0], arrival_ns - self._last[1]
            if self._pace.explains(gap_ns, wait_ns):
                self._waited_ns += wait_ns - gap_ns
            self._pace.follow(gap_ns)
        self._last = device_ns, arrival_ns

    def _late_by_waits_ns(self, device_ns: int, arrival_ns: int) -> int:
        """Return how late a message is, 0 where waits do not explain it."""
        late_ns = arrival_ns - device_ns - self._offset(device_ns, arrival_ns)
        explained = STEP_SHARE * (late_ns - self._waited_ns) <= late_ns
        return late_ns if self._suspects and not self._no_delay and explained else 0

    def _suspect(self, device_ns: int, arrival_ns: int) -> bool:
        """Keep a message that is off the envelope, forget those before one that is not; return whether it is wild."""
        late_ns = arrival_ns - device_ns - self._offset(device_ns, arrival_ns)
        wild = abs(late_ns) > self._jump_ns
        if not wild and late_ns <= STEP_NS:
            self._trust()
            self._waited_ns = max(late_ns, 0)
            return False
        went_back = self._newest_device_ns is not None and device_ns < self._newest_device_ns
        self.wild += wild
        self._wild_run = self._wild_run + 1 if wild else 0
        self._suspects.append(_Message(device_ns, arrival_ns, self._waited_ns))
        self._no_delay |= went_back or late_ns < 0
        return wild

    def _trust(self) -> None:
        self._suspects.clear()
        self._wild_run = self._waited_ns = 0
        self._no_delay = False

    def _mapped(self, device_ns: int, arrival_ns: int) -> int:
        return min(device_ns + self._offset(device_ns, arrival_ns), arrival_ns)

    def _offset(self, device_ns: int, arrival_ns: int) -> int:
        if not self._envelope:
            return arrival_ns - device_ns
        return self._envelope[0][1] + arrival_ns // DRIFT_DIVISOR

    def _learn(self, device_ns: int, arrival_ns: int) -> None:
        key = arrival_ns - device_ns - arrival_ns // DRIFT_DIVISOR
        previous, self._previous_key = self._previous_key, key
        if previous is None:
            return
        agreed = max(key, previous)
        while self._envelope and self._envelope[-1][1] >= agreed:
            self._envelope.pop()
        self._messages += 1
        self._envelope.append((self._messages, agreed))
        if self._envelope[0][0] <= self._messages - self._window:
            self._envelope.popleft()

    def _jumped(self) -> "list[_Message]":
        """Return the messages that confirm a jump that no delay explains, none when there was none."""
        suspects = list(self._suspects)[-CONFIRMATIONS:]
        if self._wild_run < CONFIRMATIONS or not self._no_delay:
            return []
        differences, device_span = _differences(suspects)
        agreed = max(differences) - min(differences) <= min(self._jump_ns, device_span // 2)
        return suspects if agreed else []

    def _stepped_back(self) -> "list[_Message]":
        """Return the late messages that confirm a step back, none when there was none."""
        suspects = list(self._suspects)
        if len(suspects) < STEP_CONFIRMATIONS:
            return []
        differences, device_span = _differences(suspects)
        least_ns = min(differences) - self._offset(suspects[-1].device_ns, suspects[-1].arrival_ns)
        agreed = max(differences) - min(differences) <= min(least_ns // STEP_SHARE, device_span // STEP_PACE)
        return suspects if agreed and least_ns > STEP_NS else []

    def _rebase(self, confirming: "list[_Message]") -> None:
        """Learn the offset again; a line that is late stays so: the delay common to all is subtracted."""
        self.jumps += 1
        self._envelope.clear()
        self._previous_key = None
        waited_ns = self._waited_ns
        common_ns = _held_ns(min(message.waited_ns for message in confirming))
        for message in confirming:
            self._learn(message.device_ns, message.arrival_ns - common_ns)
        self._trust()
        self._waited_ns = waited_ns


def _held_ns(waited_ns: int) -> int:
    """Return the time for which the line held messages back, by the waiting time: jitter does not count."""
    return max(waited_ns - STEP_NS, 0)


class _Message(NamedTuple):
    device_ns: int
    arrival_ns: int
    waited_ns: int
    """How much of its lateness came with waits."""


def _differences(messages: list[_Message]) -> tuple[list[int], int]:
    """Return arrival without waits - device time of each message, and the device's time from the first to the last."""
    span_ns = abs(messages[-1].device_ns - messages[0].device_ns)
    return [m.arrival_ns - m.waited_ns - m.device_ns for m in messages], span_ns


class _Pace:
    """How long the device usually lets pass from message to message."""

    def __init__(self) -> None:
        self._gaps: deque[int] = deque(maxlen=PACE_OF)

    def follow(self, gap_ns: int) -> None:
        """Record the device's time between two messages."""
        self._gaps.append(gap_ns)

    def explains(self, gap_ns: int, wait_ns: int) -> bool:
        """Return whether the device went on at its pace, and more so than the messages came."""
        if abs(wait_ns - gap_ns) <= STEP_NS:
            return True
        if len(self._gaps) < PACE_OF // 2 or gap_ns < 0:
            return False
        longest_ns = sorted(self._gaps)[-2]  # one may be that of a message lost, or of a step
        missing = gap_ns > PACE_SLACK * longest_ns
        believed = not missing or (gap_ns <= (1 + MOST_LOST) * longest_ns and LOST_SHARE * gap_ns <= wait_ns)
        return believed and self._off(gap_ns) < self._off(wait_ns)

    def _off(self, gap_ns: int) -> int:
        return min(abs(gap_ns - usual_ns) for usual_ns in self._gaps)
