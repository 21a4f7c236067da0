"""Exponential back-off: how long to wait before something that failed is tried again."""

MOST_DOUBLINGS = 60
"""Further ones make no longest delay longer, and would overflow."""


class Backoff:
    """Waits twice as long after each failure, up to a longest delay, until something works."""

    def __init__(self, first_s: float, longest_s: float) -> None:
        self._first_s, self._longest_s = first_s, longest_s
        self._failures = 0

    def failed(self) -> float:
        """Count a failure; return how long to wait, s."""
        self._failures += 1
        return self.delay_s(self._failures)

    def worked(self) -> None:
        """Begin anew."""
        self._failures = 0

    def delay_s(self, failures: int) -> float:
        """Return how long to wait after so many failures in a row, 1 at least, s."""
        return min(self._longest_s, self._first_s * 2.0 ** min(failures - 1, MOST_DOUBLINGS))
