"""Assembly of PDOs into epochs: all PDOs of one instant, or none."""

from collections import Counter
from dataclasses import dataclass

from ods.nav_bridge.can.frame import Frame
from ods.nav_bridge.canopen.object_map import SEQUENCE_FIELD
from ods.nav_bridge.canopen.pdo_layout import PdoLayout, PdoSet
from ods.nav_bridge.canopen.recent import DuplicateNode

TIMEOUT_NS = 100_000_000
"""An epoch that is not complete after this time never will be; the sequence number may have wrapped since."""
LOST_SLACK = 3
LOST_SHARE = 0.02
"""Number of epochs, and share of them, by which number and time may disagree on how many were lost."""
PERIOD_GAIN = 0.1
"""Share of the newest period in the mean."""
EVIDENCE = 3
"""Pieces needed: one may come of a damaged number on a serial line."""


@dataclass(frozen=True)
class Epoch:
    """All fields of one instant."""

    values: dict[str, float]
    """By the names of `PdoSet.fields`."""
    t_ns: int
    """Arrival of its first PDO."""


class EpochAssembler:
    """Puts epochs together from single PDOs.

    PDOs that carry the sequence number are tied by it. One that does not is taken only directly after its
    predecessor in the set. That proves its epoch if a PDO with the number follows; those behind the last number are
    taken within `window_ns` of the epoch's first PDO only. In a set without sequence numbers the first PDO opens an
    epoch, and that holds for all others.

    Counts `pdo_short`, `pdo_duplicate` (also those of a repeated epoch), `pdo_stray` (without sequence number and out
    of place), `epoch_torn` (given up incomplete), `epoch_missing` (numbers never seen), `sequence_reset` (went back),
    `ins_twice` (a PDO that contradicts one of the same epoch, or numbers that take turns).
    """

    def __init__(self, pdo_set: PdoSet, window_ns: int, counters: Counter[str]) -> None:
        self.duplicate = DuplicateNode("ins_twice", counters, EVIDENCE)
        self._counters = counters
        self._all = frozenset(layout.cob_id for layout in pdo_set.layouts)
        self._modulus = pdo_set.sequence_modulus
        self._timeout_ns = window_ns if self._modulus is None else TIMEOUT_NS
        self._window_ns = window_ns
        self._last_numbered = max((n.place for n in pdo_set.layouts if SEQUENCE_FIELD in n.fields), default=-1)
        self._period_ns = 0.0
        self._numbers: tuple[int | None, int | None] = (None, None)  # of the newest two epochs
        self._finished = True
        self._values: dict[str, float] = {}
        self._taken: dict[int, bytes] = {}
        self._place = -1
        self._t_ns = 0

    def take(self, layout: PdoLayout, frame: Frame) -> Epoch | None:
        """Take one PDO; return the epoch that it completes."""
        data = frame.data[: layout.size]
        if len(data) < layout.size:
            self._counters["pdo_short"] += 1
            return None
        values = layout.decode(data)
        number = values.get("sequence")
        in_time = frame.t_ns - self._t_ns <= self._timeout_ns
        if self._opens(layout, number, in_time):
            self._open(None if number is None else int(number), frame.t_ns)
        elif not self._belongs(layout, data, number, frame.t_ns, in_time):
            return None
        self._values |= values
        self._taken[layout.cob_id] = data
        self._place = layout.place
        if len(self._taken) < len(self._all):
            return None
        self._finished = True
        return Epoch(self._values, self._t_ns)

    def _opens(self, layout: PdoLayout, number: float | None, in_time: bool) -> bool:
        if self._modulus is None:
            return layout.place == 0
        return number is not None and (number != self._numbers[1] or not in_time)

    def _belongs(self, layout: PdoLayout, data: bytes, number: float | None, t_ns: int, in_time: bool) -> bool:
        """Return whether a PDO fits the open epoch. One that contradicts what it has makes an end of it."""
        taken = self._taken.get(layout.cob_id) if in_time else None
        if taken is not None and taken != data:
            if number is not None:
                self.duplicate.seen(t_ns)
            self._give_up()
        if number is not None and (taken is not None or self._finished):
            self._taken.setdefault(layout.cob_id, data)  # for the next one to contradict
            self._counters["pdo_duplicate"] += 1
            return False
        if self._finished or not in_time or (number is None and not self._follows(layout, t_ns)):
            self._counters["pdo_stray"] += 1
            return False
        return True

    def _follows(self, layout: PdoLayout, t_ns: int) -> bool:
        """Return whether a PDO without number comes where and when one of the open epoch does."""
        in_window = layout.place < self._last_numbered or t_ns - self._t_ns <= self._window_ns
        return layout.place == self._place + 1 and in_window

    def _open(self, number: int | None, t_ns: int) -> None:
        self._give_up()
        if number is not None:
            self._follow(number, t_ns)
        self._t_ns, self._finished = t_ns, False
        self._values, self._taken = {}, {}

    def _give_up(self) -> None:
        if not self._finished:
            self._counters["epoch_torn"] += 1
        self._finished = True

    def _follow(self, number: int, t_ns: int) -> None:
        """Count what lies between the last sequence number and this one."""
        assert self._modulus is not None
        before, last = self._numbers
        self._numbers = last, number
        if last is None:
            return
        ahead = (number - last - 1) % self._modulus
        lost = self._lost(ahead, t_ns - self._t_ns)
        if number == last and lost is None:
            return
        if not ahead:
            self._period_ns += (PERIOD_GAIN if self._period_ns else 1.0) * (t_ns - self._t_ns - self._period_ns)
        if last not in (before, number) and before is not None and ahead and (number - before) % self._modulus <= 1:
            self.duplicate.seen(t_ns)
        elif lost is not None:
            self._counters["epoch_missing"] += lost
        else:
            self._counters["sequence_reset"] += 1

    def _lost(self, ahead: int, elapsed_ns: int) -> int | None:
        """Return how many epochs were lost, by number and time, None if the number was set back."""
        assert self._modulus is not None
        if self._period_ns > 0.0:
            by_time = elapsed_ns / self._period_ns - 1.0
            lost = ahead + self._modulus * round((by_time - ahead) / self._modulus)
            if lost >= 0 and abs(lost - by_time) <= LOST_SLACK + LOST_SHARE * by_time:
                return lost
        return ahead if ahead < self._modulus // 2 else None
