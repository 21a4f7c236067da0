"""Settings that change from ping to ping: no sonar does that by itself, and each change moves all echoes."""

from collections import deque
from itertools import pairwise

from ods.messages import Ping

PINGS, CHANGES = 10, 3
"""Number of changes among the last pings from which on they are reported. A new range setting is one change."""
SPACING_SHARE, SPEED_SHARE = 0.02, 0.005
"""What counts as a change, of the value before: a sound speed moves all ranges by as much."""


class Steadiness:
    """Examines successive pings."""

    def __init__(self) -> None:
        self._spacings_m: deque[float] = deque(maxlen=PINGS)
        self._speeds: deque[float] = deque(maxlen=PINGS)

    def judge(self, ping: Ping) -> str:
        """Return what changes, in plain words; "": nothing."""
        self._spacings_m.append(ping.dr_m)
        self._speeds.append(ping.sound_speed)
        speeds = _unsteady(self._speeds, SPEED_SHARE)
        spacings = "" if speeds else _unsteady(self._spacings_m, SPACING_SHARE)  # which follow the sound speed
        if speeds:
            return f"the sonar's sound speed changes from ping to ping ({speeds} m/s)"
        return f"the sonar's sample spacing changes from ping to ping ({spacings} m)" if spacings else ""


def _unsteady(values: "deque[float]", share: float) -> str:
    """Return the least and the largest value where they change too often."""
    changes = sum(abs(new - old) > share * abs(old) for old, new in pairwise(values))
    return f"{min(values):.4g} to {max(values):.4g}" if changes >= CHANGES else ""
