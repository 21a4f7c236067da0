"""Gaps of a recording, by the sequence numbers of its messages."""

from collections import Counter

from ods.recording.mcap.topics import process_of, stamp_of
from ods.runtime import bus


class Gaps:
    """Counts messages that were published and did not come, by topic; a publisher that restarts leaves no gap.

    Health has a sequence for each process. Requests and answers have none.
    """

    def __init__(self) -> None:
        self.missed: Counter[str] = Counter()
        self._last: dict[str, int] = {}

    def take(self, topic: str, data: bytes) -> None:
        """Take the next message."""
        stamp = stamp_of(data)
        if stamp is None or stamp.seq is None:
            return
        source = topic
        if topic == bus.HEALTH:
            source = process_of(data)[0]
            if not source:
                return
        last = self._last.get(source, stamp.seq)
        self._last[source] = stamp.seq
        if stamp.seq > last + 1:
            self.missed[topic] += stamp.seq - last - 1
