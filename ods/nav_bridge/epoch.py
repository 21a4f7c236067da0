"""A set of PDOs taken as one epoch: all from the same instant, or none."""

from collections import Counter
from dataclasses import dataclass

from ods.nav_bridge.can_frame import Frame
from ods.nav_bridge.pdo_layout import PdoLayout, PdoSet

TIMEOUT_NS = 100_000_000
"""An epoch that is not complete after this time never will be; the sequence number may have wrapped since."""


@dataclass(frozen=True)
class Epoch:
    """All pose fields of one instant."""

    values: dict[str, float]
    """In the units of `pdo_layout.POSE_OBJECTS`."""
    t_ns: int
    """Arrival of its first PDO."""


class EpochAssembler:
    """Puts epochs together from single PDOs.

    PDOs that carry the sequence number are tied by it. One that does not is taken only directly after its
    predecessor in the set, so that it cannot slip in from another epoch.

    Counts `pdo_short`, `pdo_duplicate` (also those of a repeated epoch), `pdo_stray` (without sequence number and out
    of place), `epoch_torn` (given up incomplete), `epoch_missing` (numbers never seen), `sequence_reset` (went back).
    """

    def __init__(self, pdo_set: PdoSet, counters: Counter[str]) -> None:
        self._counters = counters
        self._all = frozenset(layout.cob_id for layout in pdo_set.layouts)
        self._modulus = pdo_set.sequence_modulus
        self._sequence: int | None = None
        self._finished = True
        self._values: dict[str, float] = {}
        self._missing: set[int] = set()
        self._place = -1
        self._t_ns = 0

    def take(self, layout: PdoLayout, frame: Frame) -> Epoch | None:
        """Take one PDO; return the epoch that it completes."""
        if len(frame.data) < layout.size:
            self._counters["pdo_short"] += 1
            return None
        values = layout.decode(frame.data)
        if not self._belongs(layout, values.get("sequence"), frame.t_ns):
            return None
        self._values |= values
        self._missing.discard(layout.cob_id)
        self._place = layout.place
        if self._missing:
            return None
        self._finished = True
        return Epoch(self._values, self._t_ns)

    def _belongs(self, layout: PdoLayout, sequence: float | None, t_ns: int) -> bool:
        """Tell whether a PDO fits the open epoch; one with a new sequence number opens the next epoch first."""
        is_open = not self._finished and t_ns - self._t_ns <= TIMEOUT_NS
        if sequence is None:
            if is_open and layout.place == self._place + 1:
                return True
            self._counters["pdo_stray"] += 1
            return False
        if sequence == self._sequence and (is_open or self._finished):
            if layout.cob_id in self._missing:
                return True
            self._counters["pdo_duplicate"] += 1
            return False
        self._open(int(sequence), t_ns)
        return True

    def _open(self, sequence: int, t_ns: int) -> None:
        if not self._finished:
            self._counters["epoch_torn"] += 1
        if self._sequence not in (None, sequence):
            ahead = (sequence - self._sequence - 1) % self._modulus
            if ahead < self._modulus // 2:
                self._counters["epoch_missing"] += ahead
            else:
                self._counters["sequence_reset"] += 1
        self._sequence, self._t_ns, self._finished = sequence, t_ns, False
        self._missing = set(self._all)
        self._values = {}
