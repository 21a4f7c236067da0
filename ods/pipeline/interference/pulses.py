"""Another sonar's pulses: they come in at a period of their own, whatever our pings do, and look like small bodies.

In time since a fixed instant they stand at even distances; from ping to ping their range then moves by a constant step
modulo the ping period. A body stands at one range, or moves along a line. So echoes that have no forerunner where a
body would have been are held against the pulses of one period, and where those explain several of them, and no body
does, all that arrive at the instants to come are pulses: they are left out, and their places are told as unseen.

What comes once a ping at nearly our own period (within 2 %, which is 15 m/s) is on a line, too, and stays an echo.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Ping, UnseenPart
from ods.pipeline.measure.echoes import EchoTable

GAP_S = 3.0
"""After a pause of so long all is forgotten."""
MARGIN_M = 0.1


class PulseMemory(NamedTuple):
    """What is remembered of the pings before, as pulses.c has it."""

    counts: Ints
    """Of pings, trains and places."""
    looks: Floats
    arrivals: Floats
    trains: Floats
    """(8, 4) the first column is the period, s."""
    places: Floats


class Pulses(NamedTuple):
    """What of a ping's echoes are another sonar's pulses."""

    of_echoes: Mask
    """(echoes,)."""
    of_faint: Mask
    """(faint echoes,)."""
    parts: list[UnseenPart]
    """Where they stand."""
    why: str
    """In plain words; empty: there are none."""


class PulseFinder:
    """Looks at the echoes of ping after ping."""

    def __init__(self) -> None:
        self._memory = PulseMemory(
            np.zeros(3, np.int64), np.zeros((12, 3)), np.zeros((12, 64, 3)), np.zeros((8, 4)), np.zeros((256, 3))
        )
        self._begun_ns, self._newest_ns = 0, 0

    def sort_out(self, ping: Ping, echoes: EchoTable, faint: EchoTable) -> Pulses:
        """Return which of a ping's echoes are pulses."""
        since_s, self._newest_ns = (ping.t_ns - self._newest_ns) / NS, ping.t_ns
        if not 0.0 < since_s < GAP_S or ping.sound_speed <= 0.0:
            self._memory.counts[:] = 0
            self._begun_ns, since_s = ping.t_ns, 0.0
        pulses = Pulses(np.zeros(len(echoes), np.bool_), np.zeros(len(faint), np.bool_), [], "")
        if ping.sound_speed <= 0.0:
            return pulses
        near_m, far_m = max(ping.range0_m, 0.0), ping.range0_m + ping.samples * ping.dr_m
        found = native.sort_out_pulses(
            echoes, faint, (ping.t_ns - self._begun_ns) / NS, 2.0 / ping.sound_speed, near_m, far_m, since_s,
            self._memory, pulses.of_echoes, pulses.of_faint,
        )  # fmt: skip
        if not found:
            return pulses
        parts = [_part(row, near_m) for table, marks in ((echoes, pulses.of_echoes), (faint, pulses.of_faint))
                 for row in table[marks]]  # fmt: skip
        periods = ", ".join(f"{1e3 * period_s:.1f} ms" for period_s in self._memory.trains[: self._memory.counts[1], 0])
        return pulses._replace(parts=parts, why=f"another sonar's pulses, each {periods}")


def _part(echo: EchoTable, least_m: float) -> UnseenPart:
    bearing_rad, half_rad = float(echo["bearing_rad"]), 0.5 * float(echo["bearing_extent_rad"])
    near_m, far_m = float(echo["near_m"]) - MARGIN_M, float(echo["near_m"] + echo["range_extent_m"]) + MARGIN_M
    return UnseenPart(bearing_rad - half_rad, bearing_rad + half_rad, max(near_m, least_m), far_m, "interference")
