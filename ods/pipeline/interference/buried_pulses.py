"""Pulses that are buried in reverberation: only one a ping is loud enough to be an echo, or none.

Where another sonar's period is near our own or near a fraction of it, the loudest pulse of each ping stands on a line
over time, as a body's echo does. A body is alone; pulses come again one period later, at places that move with the
line. Each of these places is brighter with the pulse than one ping before or after, when it was elsewhere. By how much
is averaged over pings and places, and held against the same of all other places of the same beams: their spread is that
of speckle, noise and texture, whatever unit the samples have.
"""

from collections import deque
from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray
from ods.compiled import native
from ods.messages import Ping
from ods.pipeline.prepared.plan import sample_scale_of

PINGS, BEAMS = 8, 3
"""So many of the last pings are compared, in so many beams next to the direction."""
SHORTEST_S = 0.02
"""The shortest period of pulses that is looked for, s."""


class PulseTrain(NamedTuple):
    """Pulses of one period; times since a fixed instant."""

    period_s: float
    at_s: float
    """Of a pulse."""
    bearing_rad: float
    received_s: float
    buried: float
    """Pulses in a period of what was found; 0: a line, if it is alone."""
    arrivals: float


class _Image(NamedTuple):
    """One ping."""

    ping: Ping
    frame: AnyArray
    sent_s: float

    @property
    def setting(self) -> tuple[object, ...]:
        """What pings must have in common to be compared."""
        ping = self.ping
        return (
            ping.bearing_rad, ping.samples, ping.dtype, ping.scale, ping.scale_factor, ping.range0_m, ping.dr_m,
            ping.sound_speed, ping.setting,
        )  # fmt: skip


class BuriedPulses:
    """Compares the images of the last pings at the places where pulses would be."""

    def __init__(self) -> None:
        self._images: deque[_Image] = deque(maxlen=PINGS)

    def add(self, ping: Ping, frame: AnyArray, sent_s: float) -> None:
        """Take in the next ping; frame (beams, samples); sent_s: since a fixed instant."""
        image = _Image(ping, frame, sent_s)
        if self._images and (sent_s <= self._images[-1].sent_s or self._images[-1].setting != image.setting):
            self._images.clear()
        self._images.append(image)

    def a_period(self, train: PulseTrain) -> int:
        """Return how many pulses come in the period of a train; 0: no others than its own."""
        return self._ask(train, is_known=False)

    def is_received(self, train: PulseTrain) -> bool:
        """Return whether a train's pulses are in the images."""
        return bool(self._ask(train, is_known=True))

    def _ask(self, train: PulseTrain, *, is_known: bool) -> int:
        ping = self._images[-1].ping
        rows = np.argsort(np.abs(np.array(ping.bearing_rad) - train.bearing_rad))[:BEAMS]
        frames = np.concatenate([image.frame[rows] for image in self._images])
        sent_s = np.array([image.sent_s for image in self._images])
        grid = 2.0 / ping.sound_speed, ping.range0_m, ping.dr_m
        found: int = native.pulses_a_period(
            frames, sample_scale_of(ping).table, sent_s, *grid,
            train.period_s, train.at_s, SHORTEST_S, is_known,
        )  # fmt: skip
        return found
