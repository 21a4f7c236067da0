"""The order in which the messages of one instant are sent: configured, or found on the bus."""

from collections.abc import Mapping, Sequence

from ods.nav_bridge.can.frame import CanId
from ods.nav_bridge.dbc.burst import CYCLES, Burst, Step, find_burst
from ods.nav_bridge.dbc.signal_map import DbcMessage

MS = 1e6
REST = 7
"""Number of checks skipped after one without a change."""


class EpochOrder:
    """Watches how messages follow each other; knows the order, or says why not.

    There is none before a few instants have been seen. A configured one holds unless the bus contradicts it: the
    silence between two instants is elsewhere.
    """

    def __init__(self, messages: Sequence[DbcMessage], configured: bool) -> None:
        self.places: Mapping[CanId, int] = {}
        """Position of each message in the epoch; empty while it is not known."""
        self.objection = ""
        """Why there is no order, as text; "" while there is one, or too few messages have come."""
        self.silence_ns = 0.0
        """Usual silence between two instants; 0 where it is not clearly longer than those within one."""
        self._labels = {message.can_id: message.label for message in messages}
        self._configured = tuple(self._labels) if configured else ()
        self._steps: list[Step] = []
        self._last: tuple[CanId, int] | None = None
        self._resting = 0
        if len(messages) == 1:
            self._adopt(tuple(self._labels))

    def note(self, can_id: CanId, t_ns: int) -> bool:
        """Take note of a message; return whether the order is another one now."""
        if self._resting:
            self._resting -= 1
            return False
        if len(self._labels) == 1:
            return False
        last, self._last = self._last, (can_id, t_ns)
        if last is None:
            return False
        self._steps.append(Step(last[0], can_id, t_ns - last[1]))
        if len(self._steps) < CYCLES * len(self._labels):
            return False
        burst, self._steps, self._last = find_burst(self._steps, self._labels), [], None
        changed = self._judge(burst)
        self._resting = 0 if changed or not self.places else REST * CYCLES * len(self._labels)
        return changed

    def look_again(self) -> None:
        """Rest no longer: something is not as it was."""
        self._resting = 0

    def _judge(self, burst: Burst) -> bool:
        order, self.objection = burst.order, ""
        self.silence_ns = max(burst.gaps_ns) if order else self.silence_ns
        if self._configured:
            if order and order != self._configured:
                self.objection = self._contradiction(order)
            return self._adopt(() if self.objection else self._configured)
        if not order and self.places and (not burst.cycle or self._goes_on(burst.cycle)):
            return False  # found before, and borne out by each epoch or not: a disturbed moment proves nothing
        if not order:
            self.objection = self._uncertainty(burst)
        return self._adopt(order)

    def _goes_on(self, cycle: tuple[CanId, ...]) -> bool:
        """Return whether messages follow each other as they did, wherever an epoch begins."""
        order = tuple(self.places)
        first = cycle.index(order[0])
        return cycle[first:] + cycle[:first] == order

    def _adopt(self, order: tuple[CanId, ...]) -> bool:
        if order == tuple(self.places):
            return False
        self.places = {can_id: place for place, can_id in enumerate(order)}
        return True

    def _contradiction(self, order: tuple[CanId, ...]) -> str:
        named = ", ".join(self._labels[can_id] for can_id in order)
        return (
            f"epochs are paired wrongly by nav.dbc.epoch: on the bus an instant's messages come as {named}, then there "
            "is silence: write it so, or leave it out"
        )

    def _uncertainty(self, burst: Burst) -> str:
        if burst.rare:
            named = ", ".join(self._labels[can_id] for can_id in burst.rare)
            return f"{named}: more rarely than the others: give one rate to all at the INS, or list it in nav.dbc.held"
        if not burst.cycle:
            return (
                "the messages of an instant come in changing order: nav.dbc.sequence must name the counter or time "
                "stamp that those of one instant share"
            )
        gaps = sorted(zip(burst.gaps_ns, burst.cycle, strict=True), reverse=True)[:2]
        silences = ", ".join(f"{gap_ns / MS:.2f} ms after {self._labels[can_id]}" for gap_ns, can_id in gaps)
        return (
            f"the bus does not show an instant's first message, as its longest silences are alike ({silences}): "
            "set nav.dbc.epoch to their order, or nav.dbc.sequence to a number that they share"
        )
