"""The messages of one instant of a device that sends the same counter, or time stamp, in all of them."""

from collections import Counter
from collections.abc import Iterator

from ods.nav_bridge.clocks.ins_clock import InsClock
from ods.nav_bridge.dbc.epoch import DbcEpoch, Period
from ods.nav_bridge.dbc.signal_map import DbcMap, DbcMessage


class SharedNumberAssembler:
    """Puts epochs together from messages with the same number, in whatever order they come.

    A number comes again when its counter has gone round, so an epoch counts only when it is complete `window_ns` after
    its instant. Counts `epoch_torn`, `frame_stray` (repeated), `epoch_late`, and what `InsClock` does.
    """

    def __init__(self, dbc: DbcMap, window_ns: int, clock: InsClock | None, counters: Counter[str]) -> None:
        self.period = Period()
        self._labels = {message.can_id: message.label for message in dbc.epoch}
        self._window_ns = window_ns
        self._clock = clock
        self._counters = counters
        self._number: float | None = None
        self._missing = set(self._labels)
        self._lacked = ""
        self._values: dict[str, float] = {}
        self._first_ns = self._instant_ns = 0

    def take(self, message: DbcMessage, counts: dict[str, float], t_ns: int) -> DbcEpoch | None:
        """Take the raw counts of one message of the epoch; return the epoch that it completes."""
        assert message.sequence is not None  # `load_dbc_map` has seen to it
        number = counts[message.sequence]
        if number != self._number:
            self._begin(number, t_ns)
        if message.can_id not in self._missing:
            self._counters["frame_stray"] += 1
            return None
        self._missing.remove(message.can_id)
        message.add_to(self._values, counts)
        if message.clock is not None:
            assert self._clock is not None
            self._instant_ns = self._clock.instant(counts[message.clock.signal], self._first_ns)
        return None if self._missing else self._finish(t_ns)

    def objections(self) -> Iterator[str]:
        """Yield why epochs do not become poses though all their messages come."""
        if self._lacked:
            yield f"{self._lacked} has no number in common with the others (nav.dbc.sequence)"

    def _begin(self, number: float, t_ns: int) -> None:
        if self._number is not None and self._missing:
            self._counters["epoch_torn"] += 1
            self._lacked = ", ".join(sorted(self._labels[can_id] for can_id in self._missing))
        self._number, self._missing, self._values = number, set(self._labels), {}
        self._first_ns = self._instant_ns = t_ns

    def _finish(self, t_ns: int) -> DbcEpoch | None:
        self.period.add(self._instant_ns)
        self._lacked = ""
        if t_ns - min(self._first_ns, self._instant_ns) > self._window_ns:
            self._counters["epoch_late"] += 1
            return None
        return DbcEpoch(self._values, self._instant_ns)
