"""Lost pings, counted by the numbers that a sonar gives its pings."""

from collections import Counter

MAX_GAP = 1000
"""A number further ahead than this is a sonar that restarted, not pings lost."""
MODULUS = 2**32


class PingNumbers:
    """Follows one sonar. Counters: lost_pings (for whatever reason), ping_number_restarts."""

    def __init__(self, counters: "Counter[str]") -> None:
        self._counters = counters
        self.newest: int | None = None
        """The number that was followed last."""

    def follow(self, number: int) -> None:
        """Take the number of a ping that came whole."""
        ahead = 0 if self.newest is None else (number - self.newest) % MODULUS
        if ahead > MAX_GAP:
            self._counters["ping_number_restarts"] += 1
        elif ahead > 1:
            self._counters["lost_pings"] += ahead - 1
        self.newest = number
