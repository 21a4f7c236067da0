"""Finds where pings were lost: those explained by a busy computer, and those lost by ODS. Pure."""

import msgspec

from ods.bench.machine import MachineLoad
from ods.offline.run_record import RunRecord

LEFT_OUT = {
    "pipeline": ("skipped_pings", "dropped_ping"),
    "tracker": ("skipped_pings", "dropped_detections"),
}
"""Counters of what a process on the way left out as newer messages waited: it had too little of a processor."""


class PingLosses(msgspec.Struct, frozen=True):
    """Pings that were sent and have no list, each in one of these."""

    on_line: int = 0
    """Never came out of the sonar process: the line's buffers overflow while it does not read."""
    left_out: int = 0
    """Counted by pipeline and tracker as left out."""
    unread: int = 0
    """Lists that the bench itself was too slow to read."""
    last_moment: int = 0
    """After the last report of the process that had them."""
    unexplained: int = 0
    """All others: ODS lost them."""

    def __str__(self) -> str:
        return "; ".join(f"{getattr(self, name)} {words}" for name, words in WORDS.items() if getattr(self, name))


WORDS = {
    "on_line": "not published by the sonar process",
    "left_out": "skipped by pipeline or tracker because newer ones waited",
    "unread": "in lists that the bench was too slow to read",
    "last_moment": "at the end, without a report",
    "unexplained": "lost by ODS, uncounted",
}


def losses_of(record: RunRecord, answered: set[int]) -> PingLosses:
    """Return where the pings were lost that have no list; answered: the numbers of those that have one."""
    lost = record.truths.keys() - answered
    left = lost & record.received
    on_line = len(lost) - len(left)
    reported_ns = min((reports[-1].t_ns for name in LEFT_OUT if (reports := record.health.get(name))), default=None)
    last = {number for number in left if reported_ns is not None and record.truths[number].t_ns > reported_ns}
    rest = len(left) - len(last)
    left_out = min(_left_out(record), rest)
    unread = min(record.unread_lists, rest - left_out)
    return PingLosses(on_line, left_out, unread, len(last), rest - left_out - unread)


def explained_by_load(losses: PingLosses, limit: int, machine: MachineLoad) -> bool:
    """Return whether a busy computer explains all losses but as many as are allowed."""
    return machine.busy and losses.unexplained <= limit


def _left_out(record: RunRecord) -> int:
    """Return how many pings processes counted as left out, also those that were started again."""
    return sum(
        sum(newest.values())
        for name, keys in LEFT_OUT.items()
        for newest in [
            {(report.pid, key): report.counters.get(key, 0) for report in record.health.get(name) or () for key in keys}
        ]
    )
