"""Another sonar's pulses: they arrive with their own period, independent of this sonar's, and look like small objects.

In time since a fixed instant they stand at even distances; from ping to ping their range then moves by a constant step
modulo the ping period. A body stands at one range, or moves along a line. So echoes that have no forerunner where a
body would have been are held against the pulses of one period, and where those explain several of them, and no body
does, all that arrive at the instants to come are pulses: they are left out, and their positions are reported as not
observed.

What comes once a ping at nearly our own period (within 2 %, which is 15 m/s) is on a line, too, and stays an echo.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats, Ints, Mask
from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Ping, UnseenPart
from ods.pipeline.interference.buried_pulses import SHORTEST_S, BuriedPulses, PulseTrain
from ods.pipeline.measure.echoes import EchoTable

GAP_S = 2.0
"""Length of a pause, s, after which all is forgotten, and a train that was not received for so long."""
MARGIN_M = 0.1


class PulseMemory(NamedTuple):
    """Memory of former pings, as in pulses.c."""

    counts: Ints
    """Of pings, trains and places."""
    pings: Floats
    arrivals: Floats
    trains: Floats
    """Rows of `PulseTrain`."""
    places: Floats


class Pulses(NamedTuple):
    """Another sonar's pulses among a ping's echoes."""

    of_echoes: Mask
    """(echoes,)."""
    of_faint: Mask
    """(faint echoes,)."""
    parts: list[UnseenPart]
    """Where they stand."""
    why: str
    """In plain words; empty: there are none."""


class PulseFinder:
    """Examines the echoes of successive pings."""

    def __init__(self) -> None:
        self._memory = PulseMemory(
            np.zeros(3, np.int64), np.zeros((12, 3)), np.zeros((12, 64, 3)), np.zeros((8, 6)), np.zeros((256, 3))
        )
        self._buried = BuriedPulses()
        self._found = np.zeros((4, 6))
        self._begun_ns, self._newest_ns = 0, 0

    def classify(self, ping: Ping, frame: AnyArray, echoes: EchoTable, faint: EchoTable) -> Pulses:
        """Return which of a ping's echoes are pulses; frame: (beams, samples)."""
        since_s, self._newest_ns = (ping.t_ns - self._newest_ns) / NS, ping.t_ns
        if not 0.0 < since_s < GAP_S or ping.sound_speed <= 0.0:
            self._memory.counts[:] = 0
            self._begun_ns, since_s = ping.t_ns, 0.0
        pulses = Pulses(np.zeros(len(echoes), np.bool_), np.zeros(len(faint), np.bool_), [], "")
        if ping.sound_speed <= 0.0:
            return pulses
        near_m, far_m = max(ping.range0_m, 0.0), ping.range0_m + ping.samples * ping.dr_m
        sent = (ping.t_ns - self._begun_ns) / NS, 2.0 / ping.sound_speed
        self._buried.add(ping, frame, sent[0])
        found = native.find_pulses(echoes, sent, near_m, far_m, since_s, SHORTEST_S, GAP_S, self._memory, self._found)
        if found or self._memory.counts[1]:
            self._listen([PulseTrain(*row) for row in self._found[:found].tolist()], sent[0])
        if not self._memory.counts[1] or not native.mark_pulses(
            echoes, faint, sent, self._memory, pulses.of_echoes, pulses.of_faint
        ):
            return pulses
        parts = [_part(row, near_m) for table, own in ((echoes, pulses.of_echoes), (faint, pulses.of_faint))
                 for row in table[own]]  # fmt: skip
        periods = ", ".join(f"{1e3 * period_s:.1f} ms" for period_s, *_ in self._trains)
        return pulses._replace(parts=parts, why=f"another sonar's pulses, every {periods}")

    @property
    def _trains(self) -> list[PulseTrain]:
        return [PulseTrain(*row) for row in self._memory.trains[: self._memory.counts[1]].tolist()]

    def _listen(self, found: list[PulseTrain], now_s: float) -> None:
        """Listen for pulses that are buried, of known trains and of those that were found, and keep a train."""
        known = self._trains
        for place, train in enumerate(known):
            if train.buried > 1.0 and self._buried.is_received(train):
                self._memory.trains[place] = train._replace(received_s=now_s)
        for train in found:
            count = max(self._buried.a_period(train), train.buried)
            if count > 0.0 and len(known) < len(self._memory.trains):
                self._memory.trains[len(known)] = train._replace(period_s=train.period_s / count, buried=count)
                self._memory.counts[1] += 1
                return


def _part(echo: EchoTable, least_m: float) -> UnseenPart:
    bearing_rad, half_rad = float(echo["bearing_rad"]), 0.5 * float(echo["bearing_extent_rad"])
    near_m, far_m = float(echo["near_m"]) - MARGIN_M, float(echo["near_m"] + echo["range_extent_m"]) + MARGIN_M
    return UnseenPart(bearing_rad - half_rad, bearing_rad + half_rad, max(near_m, least_m), far_m, "interference")
