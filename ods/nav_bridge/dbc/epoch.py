"""The messages of one instant of a device that sends no sequence number: all of them, or none.

Something sampled earlier than an epoch can only be in it as a late frame, which its own epoch then lacked: so an epoch
counts when its messages came in their order, each once, directly after an epoch whose messages came so too. Something
sampled later cannot be in it when it was complete before the next instant, by `window_ns`. One that was read later
waits for the next reading of the device's clock, which says whether instants were lost on the way. Where one instant
ends and the next begins is recognized by silence on the bus: an epoch with a silence in it does not count.
"""

from collections import Counter, deque
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import median

from ods.nav_bridge.clocks.ins_clock import InsClock
from ods.nav_bridge.dbc.epoch_order import CLEARLY_LONGER, LEAST_SILENCE_NS, EpochOrder
from ods.nav_bridge.dbc.signal_map import Clock, DbcMap, DbcMessage

SKIPPED = 1.5
"""Steps between instants: an epoch later than the one before by more than this has missed one."""
STEPS = 9
"""Steps that are remembered: a busy computer, or device, makes single ones shorter and longer."""


class Period:
    """How often a device sends: the median of the newest steps between complete epochs."""

    def __init__(self) -> None:
        self._last_ns: int | None = None
        self._steps_ns: deque[int] = deque(maxlen=STEPS)

    def add(self, instant_ns: int) -> int:
        """Take the instant of a complete epoch, CLOCK_MONOTONIC; return the step to it, ns, 0 for the first."""
        last_ns, self._last_ns = self._last_ns, instant_ns
        if last_ns is None:
            return 0
        self._steps_ns.append(instant_ns - last_ns)
        return instant_ns - last_ns

    @property
    def ns(self) -> int:
        """The period, ns, 0 while it is not known."""
        return round(median(self._steps_ns)) if self._steps_ns else 0


@dataclass(frozen=True)
class DbcEpoch:
    """All pose fields of one instant."""

    values: dict[str, float]
    t_ns: int
    """Its instant, CLOCK_MONOTONIC."""


class DbcEpochAssembler:
    """Puts epochs together from single messages.

    Counts `frame_unplaced` (while the order of messages is not known), `frame_stray` (out of order, repeated, without
    opener), `epoch_torn` (given up incomplete), `epoch_parted` (a silence in it, none before it), `epoch_unproven`
    (complete, but not the one before), `epoch_late` (complete after the window, and not proven by the next),
    and what `InsClock` does.
    """

    def __init__(self, dbc: DbcMap, window_ns: int, clock: InsClock | None, counters: Counter[str]) -> None:
        self.period = Period()
        self._labels = {message.can_id: message.label for message in dbc.epoch}
        self._order = EpochOrder(dbc.epoch, dbc.order_specified)
        self._window_ns = window_ns
        self._clock = clock
        self._counters = counters
        self._breaks_at = ""
        """Message that was expected when the newest epoch was given up."""
        self._next = 0
        self._sound = False
        self._values: dict[str, float] = {}
        self._instant_ns = 0
        self._frame_ns = self._silence_ns = self._longest_gap_ns = 0
        self._step_ns = 0
        """Between the instants of the two newest complete epochs."""
        self._held: DbcEpoch | None = None

    def take(self, message: DbcMessage, counts: dict[str, float], t_ns: int) -> DbcEpoch | None:
        """Take the raw counts of one message of the epoch; return the epoch that it completes or proves."""
        if not self._follows(message, t_ns):
            return None
        message.add_to(self._values, counts)
        proven = self._read_clock(message.clock, counts) if message.clock is not None else None
        self._next += 1
        complete = self._finish(t_ns) if self._next == len(self._labels) else None
        if proven and complete:  # one at a time: the newer one waits for the next reading
            self._held = complete
        return proven or complete

    def objections(self) -> Iterator[str]:
        """Yield why epochs do not become poses though all their messages come."""
        if self._order.objection:
            yield self._order.objection
        elif self._breaks_at:
            yield f"epochs break off before {self._breaks_at}: it is lost, or sent more rarely than the others"

    def _follows(self, message: DbcMessage, t_ns: int) -> bool:
        """Return whether the message is the next one of an epoch, and begin a new one where it is the first."""
        gap_ns, self._frame_ns = t_ns - self._frame_ns, t_ns
        if self._order.note(message.can_id, t_ns):
            self._give_up()
            self._breaks_at = ""
        place = self._order.places.get(message.can_id)
        if place is None:
            self._counters["frame_unplaced"] += 1
            return False
        if place != self._next:
            self._give_up()
        if place == 0:
            self._values, self._instant_ns = {}, t_ns
            self._silence_ns, self._longest_gap_ns = gap_ns, 0
        elif self._next:
            self._longest_gap_ns = max(self._longest_gap_ns, gap_ns)
        else:
            self._counters["frame_stray"] += 1
        return place == self._next

    def _read_clock(self, clock: Clock, counts: dict[str, float]) -> DbcEpoch | None:
        """Set the epoch's instant; return the epoch held back if no instant is missing between it and this one."""
        assert self._clock is not None
        self._instant_ns = self._clock.instant(counts[clock.signal], self._instant_ns)  # by the arrival of the first
        held, self._held = self._held, None
        if held is None or not self._skips(self._instant_ns - held.t_ns, self._step_ns):
            return held
        self._counters["epoch_late"] += 1
        return None

    def _give_up(self) -> None:
        self._order.check_again()
        if self._next:
            self._counters["epoch_torn"] += 1
            self._breaks_at = next(
                (self._labels[can_id] for can_id, place in self._order.places.items() if place == self._next), ""
            )
        if self._held is not None:
            self._counters["epoch_late"] += 1
            self._held = None
        self._next = 0
        self._sound = False

    def _finish(self, t_ns: int) -> DbcEpoch | None:
        before_ns, self._step_ns = self._step_ns, self.period.add(self._instant_ns)
        proven = self._sound and not self._skips(self._step_ns, before_ns)
        self._next, self._sound, self._breaks_at = 0, True, ""
        if not proven:
            self._counters["epoch_unproven"] += 1
            return None
        if self._is_parted():
            self._counters["epoch_parted"] += 1
            self._order.check_again()
            return None
        epoch = DbcEpoch(self._values, self._instant_ns)
        if t_ns - self._instant_ns <= self._window_ns:
            return epoch
        if self._clock is not None:
            self._held = epoch
        else:
            self._counters["epoch_late"] += 1
        return None

    def _is_parted(self) -> bool:
        """Return whether the bus was silent within the epoch as it is between two: one of both may be in it."""
        usual_ns = self._order.silence_ns
        unlike_before = self._longest_gap_ns > max(LEAST_SILENCE_NS, CLEARLY_LONGER * self._silence_ns)
        return unlike_before or 0.0 < usual_ns < 2.0 * self._longest_gap_ns

    def _skips(self, step_ns: int, before_ns: int) -> bool:
        """Return whether instants seem to be missing in a step, by the step before it."""
        return before_ns > 0 and not 0 < step_ns <= max(SKIPPED * before_ns, 2 * self._window_ns)
