"""The order in which the messages of one instant are sent: configured, or found on the bus."""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from statistics import median
from typing import NamedTuple

from ods.nav_bridge.can.frame import CanId
from ods.nav_bridge.dbc.signal_map import DbcMessage

MS = 1e6
REST = 7
"""Number of checks skipped after one without a change."""
CYCLES = 8
"""Instants, each with all messages, that are looked at together."""
CLEARLY_LONGER = 3.0
"""Least ratio of the silence between two instants to the longest gap within one."""
LEAST_SILENCE_NS = 100_000
"""Gap shorter than a frame on the fastest bus, ns: such frames were read at once, and their gap means nothing."""
USUAL_SHARE = 0.6
"""Of the times that a message came, the one that mostly follows it followed it; frames are lost now and then."""


class Step(NamedTuple):
    """Two messages of the epoch, one directly after the other."""

    before: CanId
    after: CanId
    gap_ns: int


class MessageCycle(NamedTuple):
    """The messages of an instant come one after the other, then there is silence until the next: what steps show."""

    cycle: tuple[CanId, ...] = ()
    """All messages in the order in which they follow each other, from any of them on; () when there is none."""
    rare: tuple[CanId, ...] = ()
    """Messages that come clearly more rarely than the others; there is no cycle then."""
    gaps_ns: tuple[float, ...] = ()
    """Usual gap after each message of the cycle."""

    @property
    def order(self) -> tuple[CanId, ...]:
        """Return the messages of one instant in the order of sending, () when gaps do not show it."""
        if not self.cycle:
            return ()
        longest, second = sorted(self.gaps_ns, reverse=True)[:2]
        if longest < max(LEAST_SILENCE_NS, CLEARLY_LONGER * second):
            return ()
        first = (self.gaps_ns.index(longest) + 1) % len(self.cycle)
        return self.cycle[first:] + self.cycle[:first]


def find_burst(steps: Sequence[Step], members: Collection[CanId]) -> MessageCycle:
    """Return how `members` follow each other; medians, so that lost and delayed frames do not count."""
    came = Counter(step.after for step in steps)
    rare = tuple(member for member in members if came[member] < USUAL_SHARE * max(came.values()))
    if rare:
        return MessageCycle(rare=rare)
    followers: dict[CanId, Counter[CanId]] = {member: Counter() for member in members}
    for step in steps:
        followers[step.before][step.after] += 1
    usual = {before: after.most_common(1)[0] for before, after in followers.items()}
    if any(times < USUAL_SHARE * followers[before].total() for before, (_, times) in usual.items()):
        return MessageCycle()
    cycle = [next(iter(members))]
    while len(cycle) < len(members) and usual[cycle[-1]][0] not in cycle:
        cycle.append(usual[cycle[-1]][0])
    if len(cycle) < len(members):
        return MessageCycle()
    pairs = zip(cycle, [*cycle[1:], cycle[0]], strict=True)
    gaps = [median(step.gap_ns for step in steps if step[:2] == pair) for pair in pairs]
    return MessageCycle(tuple(cycle), (), tuple(gaps))


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
        """Record a message; return whether the order has changed."""
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

    def check_again(self) -> None:
        """Check again at once, because something has changed."""
        self._resting = 0

    def _judge(self, burst: MessageCycle) -> bool:
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

    def _uncertainty(self, burst: MessageCycle) -> str:
        if burst.rare:
            named = ", ".join(self._labels[can_id] for can_id in burst.rare)
            return f"{named}: more rarely than the others: set all to one rate at the INS, or list it in nav.dbc.held"
        if not burst.cycle:
            return (
                "the messages of an instant come in changing order: nav.dbc.sequence must name the counter or time "
                "stamp that those of one instant share"
            )
        gaps = sorted(zip(burst.gaps_ns, burst.cycle, strict=True), reverse=True)[:2]
        silences = ", ".join(f"{gap_ns / MS:.2f} ms after {self._labels[can_id]}" for gap_ns, can_id in gaps)
        return (
            "the first message of an instant cannot be found, because the longest silences on the bus are alike "
            f"({silences}): set nav.dbc.epoch to their order, or nav.dbc.sequence to a number that they share"
        )
