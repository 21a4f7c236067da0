"""Order of the messages of one instant on the bus: one after the other, then silence until the next instant."""

from collections import Counter
from collections.abc import Collection, Sequence
from statistics import median
from typing import NamedTuple

from ods.nav_bridge.can.frame import CanId

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


class Burst(NamedTuple):
    """Result of a number of steps."""

    cycle: tuple[CanId, ...] = ()
    """All messages in the order in which they follow each other, from any of them on; () when there is none."""
    rare: tuple[CanId, ...] = ()
    """Messages that come clearly more rarely than the others; there is no cycle then."""
    gaps_ns: tuple[float, ...] = ()
    """Usual gap after each message of the cycle."""

    @property
    def order(self) -> tuple[CanId, ...]:
        """Return the messages of one instant in the order of sending, () when gaps do not show it."""
        if len(self.cycle) < 2:
            return self.cycle
        longest, second = sorted(self.gaps_ns, reverse=True)[:2]
        if longest < max(LEAST_SILENCE_NS, CLEARLY_LONGER * second):
            return ()
        first = (self.gaps_ns.index(longest) + 1) % len(self.cycle)
        return self.cycle[first:] + self.cycle[:first]


def find_burst(steps: Sequence[Step], members: Collection[CanId]) -> Burst:
    """Return how `members` follow each other; medians, so that lost and delayed frames do not count."""
    if len(members) == 1:
        return Burst(tuple(members), (), (0.0,))
    came = Counter(step.after for step in steps)
    rare = tuple(member for member in members if came[member] < USUAL_SHARE * max(came.values()))
    if rare:
        return Burst(rare=rare)
    followers: dict[CanId, Counter[CanId]] = {member: Counter() for member in members}
    for step in steps:
        followers[step.before][step.after] += 1
    usual = {before: after.most_common(1)[0] for before, after in followers.items()}
    if any(times < USUAL_SHARE * followers[before].total() for before, (_, times) in usual.items()):
        return Burst()
    cycle = [next(iter(members))]
    while len(cycle) < len(members) and usual[cycle[-1]][0] not in cycle:
        cycle.append(usual[cycle[-1]][0])
    if len(cycle) < len(members):
        return Burst()
    pairs = zip(cycle, [*cycle[1:], cycle[0]], strict=True)
    gaps = [median(step.gap_ns for step in steps if step[:2] == pair) for pair in pairs]
    return Burst(tuple(cycle), (), tuple(gaps))
