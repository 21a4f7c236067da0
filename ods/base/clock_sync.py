"""Clock synchronisation: a device's clock mapped onto CLOCK_MONOTONIC by a minimum filter over one-way delays.

The message with the least delay tells the offset best: F. Cristian, Probabilistic clock synchronization, Distributed
Computing 3 (1989), 146-158. That a clock was set shows in delays that change at once and stay so, and, as delays are
never negative, in messages that would have come before they were sent: V. Paxson, On calibrating measurements of packet
transit times, ACM SIGMETRICS 1998, 11-21.
"""

from collections import deque

DRIFT_DIVISOR = 10_000
"""A device's clock drifts by at most one part in this many: 100 ppm."""
CONFIRMATIONS = 4
"""Consecutive messages that must agree before a jump of a device's clock is believed."""
STEP_NS = 10_000_000
"""Messages no later than this are late by the jitter of a line, not by a step of the device's clock."""
STEP_CONFIRMATIONS = 8
"""Consecutive late messages that must agree before they are taken for a step back that shows in nothing else."""
WILD_CONFIRMATIONS = 2 * STEP_CONFIRMATIONS
"""Wild messages in a row, none the least late of its last STEP_CONFIRMATIONS, that are no backlog: a wild line."""
STEP_SHARE = 4
"""They agree within one part in so many of the least lateness: jitter does not."""
STEP_PACE = 16
"""And within one part in so many of the device's time between them: the delays of a backlog shrink as it is read."""


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

    A message's time is taken from the envelope, in STEPPED from its arrival. No delay explains one that is early and
    wild, or whose device time lies before the last one's, as messages keep their order on the way. A new envelope is
    confirmed by messages in a row, all off the old one:

        in STEPPED  CONFIRMATIONS that are wild and tell the same offset
        in both     STEP_CONFIRMATIONS that are late and tell the same offset, which a backlog does not: it shrinks
        in LATE     WILD_CONFIRMATIONS that are wild and become no less late, however much their delays differ

    But in LATE messages that a line holds back are no step, however long it does: their lateness began with longer
    waits for messages whose device time went on at its pace. They are neither learned nor confirm anything. A step
    back leaves the arrivals at their pace and shows in the device time, unless it comes in a silence as long as it.
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
        self._suspects: deque[tuple[int, int]] = deque(maxlen=STEP_CONFIRMATIONS)
        """(device time, arrival) of the messages that came last, one after another, and all off the envelope."""
        self._wild_run = 0
        self._settled_for = 0
        """Wild messages since one that was less late than those before it."""
        self._no_delay = False
        """Something among the suspects is not explained by delays."""
        self._envelope: deque[tuple[int, int]] = deque()  # (message number, key), both rising: a sliding minimum
        self._messages = 0
        self._newest_device_ns: int | None = None
        self._last: tuple[int, int] | None = None
        """(device time, arrival) of the message that came last."""
        self._device_gap_ns = 0
        """Between the device times of the two that came last."""
        self._waited_ns = 0
        """How much of the messages' lateness came with waits for them; all of one's on the envelope."""
        self._previous_key: int | None = None

    def map(self, device_ns: int, arrival_ns: int) -> int:
        """Return the monotonic time of `device_ns`, ns, never later than its message's arrival, and learn from it."""
        self._watch_waits(device_ns, arrival_ns)
        wild = self._suspect(device_ns, arrival_ns)
        self.held_back_ns = self._late_by_waits_ns(device_ns, arrival_ns)
        confirming = [] if self.held_back_ns else self._jumped() or self._stepped_back() or self._settled()
        if confirming:
            self._rebase(confirming)
        elif not wild and not self.held_back_ns:
            self._learn(device_ns, arrival_ns)
        if confirming or not wild:
            self._newest_device_ns = device_ns
        return arrival_ns if self._no_delay else self._mapped(device_ns, arrival_ns)

    def _watch_waits(self, device_ns: int, arrival_ns: int) -> None:
        """Add up by how much longer one waited for messages than the device, which went on at its pace."""
        if self._last is not None:
            pace_ns, self._device_gap_ns = self._device_gap_ns, device_ns - self._last[0]
            wait_ns = arrival_ns - self._last[1]
            at_pace = 0 < 2 * self._device_gap_ns <= 3 * pace_ns  # none in between is missing
            if at_pace and abs(self._device_gap_ns - pace_ns) < abs(wait_ns - pace_ns):
                self._waited_ns += wait_ns - self._device_gap_ns
        self._last = device_ns, arrival_ns

    def _late_by_waits_ns(self, device_ns: int, arrival_ns: int) -> int:
        """Return how late a message is, 0 where waits do not explain it."""
        late_ns = arrival_ns - device_ns - self._offset(device_ns, arrival_ns)
        explained = STEP_SHARE * (late_ns - self._waited_ns) <= late_ns
        return late_ns if self._suspects and not self._no_delay and explained else 0

    def _suspect(self, device_ns: int, arrival_ns: int) -> bool:
        """Keep a message that is off the envelope, forget those before one that is not; tell whether it is wild."""
        late_ns = arrival_ns - device_ns - self._offset(device_ns, arrival_ns)
        wild = abs(late_ns) > self._jump_ns
        if not wild and late_ns <= STEP_NS:
            self._trust()
            self._waited_ns = max(late_ns, 0)
            return False
        went_back = self._newest_device_ns is not None and device_ns < self._newest_device_ns
        self.wild += wild
        self._wild_run = self._wild_run + 1 if wild else 0
        self._suspects.append((device_ns, arrival_ns))
        shrinks = arrival_ns - device_ns == min(_differences(list(self._suspects))[0])
        self._settled_for = self._settled_for + 1 if wild and not shrinks else 0
        self._no_delay |= went_back or late_ns < 0
        return wild

    def _trust(self) -> None:
        self._suspects.clear()
        self._wild_run = self._settled_for = self._waited_ns = 0
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

    def _jumped(self) -> list[tuple[int, int]]:
        """Return the messages that confirm a jump that no delay explains, none when there was none."""
        suspects = list(self._suspects)[-CONFIRMATIONS:]
        if self._wild_run < CONFIRMATIONS or not self._no_delay:
            return []
        differences, device_span = _differences(suspects)
        agreed = max(differences) - min(differences) <= min(self._jump_ns, device_span // 2)
        return suspects if agreed else []

    def _stepped_back(self) -> list[tuple[int, int]]:
        """Return the late messages that confirm a step back, none when there was none."""
        suspects = list(self._suspects)
        if len(suspects) < STEP_CONFIRMATIONS:
            return []
        differences, device_span = _differences(suspects)
        least_ns = min(differences) - self._offset(*suspects[-1])
        agreed = max(differences) - min(differences) <= min(least_ns // STEP_SHARE, device_span // STEP_PACE)
        return suspects if agreed else []

    def _settled(self) -> list[tuple[int, int]]:
        """Return the newest wild messages when they agree on nothing, but become no less late either."""
        return list(self._suspects) if self._settled_for >= WILD_CONFIRMATIONS and not self._no_delay else []

    def _rebase(self, confirming: list[tuple[int, int]]) -> None:
        self.jumps += 1
        self._envelope.clear()
        self._previous_key = None
        for device_ns, arrival_ns in confirming:
            self._learn(device_ns, arrival_ns)
        self._trust()


def _differences(messages: list[tuple[int, int]]) -> tuple[list[int], int]:
    """Return arrival - device time of each message, and the device's time from the first to the last."""
    return [arrival - device for device, arrival in messages], abs(messages[-1][0] - messages[0][0])
